"""The cases of a run kept in its folder as they are solved: whatever ends it, those that were solved are there."""

from contextlib import suppress
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Final, Self

from codend.equilibrium.fidelity import Choice
from codend.io.files import table_text, write_text
from codend.plan.copy import plan_toml
from codend.plan.plan import Plan
from codend.studies.case_result import CaseResult
from codend.studies.run_record import TABLES, remove_run
from codend.studies.study import Study

_PAUSE_S: Final = 0.3
_SHARE: Final = 0.1
"""Tables are written once so long after they were written last, and longer where that took more than this share of the
time: what is killed loses no more than a blink of solving."""


class KeptCases:
    """Writes the tables of the cases solved so far; as a context manager, those not yet written when it ends early.

    The earlier run in the folder goes as the first case comes.
    """

    def __init__(self, plan: Plan, choice: Choice, folder: Path) -> None:
        self.count = 0
        self._plan, self._choice, self._folder = plan, choice, folder
        self._waiting: list[CaseResult] = []
        self._texts: dict[str, dict[int, str]] = {name: {} for name in TABLES}
        self._begun = self._last = 0.0
        self._spent_s = 0.0

    def add(self, result: CaseResult) -> None:
        """Keep one more case.

        Raises:
            OSError: it cannot be written; those before it are kept.
        """
        self.count += 1
        self._waiting.append(result)
        now = monotonic()
        if self.count == 1:
            remove_run(self._folder)
            # kernels that were read or compiled are none of what would be lost
            self._begun = self._last = now - 1e-3 * result.report.solve_ms
        if now - self._last > _PAUSE_S and self._spent_s < _SHARE * (now - self._begun):
            self._write()

    def _write(self) -> None:
        before = monotonic()
        for result in self._waiting:
            for name, table in Study(self._plan, self._choice, (result,)).tables.items():
                self._texts[name][result.case.number] = table_text(table)
        self._waiting.clear()
        whole = {"plan.toml": plan_toml(self._plan)}
        for name, texts in self._texts.items():
            if texts:
                ordered = [texts[number] for number in sorted(texts)]
                whole[name] = ordered[0] + "".join(text.partition("\n")[2] for text in ordered[1:])
        for name, text in whole.items():
            path = self._folder / name
            # the report may have written it already
            if not path.is_file() or path.read_bytes() != text.encode(errors="replace"):
                write_text(text, path)
        self._last = monotonic()
        self._spent_s += self._last - before

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None and self._waiting:
            with suppress(OSError):  # the disk may be what ended the run
                self._write()
