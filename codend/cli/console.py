"""What commands show in a terminal: plain tables, and the progress of long work."""

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from time import monotonic

from codend.cli.streams import say

ShownProgress = Callable[[int, int, str], None]
"""Told how many parts are done, of how many, and what is being done."""

SECONDS_BETWEEN_LINES = 10.0


def text_table(headers: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Columns of text, numbers to four digits and to the right; what is not known is a dash."""
    values = [list(row) for row in rows]
    numeric = [
        all(isinstance(row[c], int | float) and not isinstance(row[c], bool) for row in values)
        for c in range(len(headers))
    ]
    lines = [list(headers), *([_shown(value) for value in row] for row in values)]
    widths = [max(len(line[c]) for line in lines) for c in range(len(headers))]
    return "\n".join(
        "  ".join(
            cell.rjust(width) if right else cell.ljust(width)
            for cell, width, right in zip(line, widths, numeric, strict=True)
        ).rstrip()
        for line in lines
    )


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "NO"
    if isinstance(value, float):
        return "-" if math.isnan(value) else f"{value:.4g}"
    return str(value)


@contextmanager
def shown_progress() -> Iterator[ShownProgress]:
    """A bar on standard error where that is a terminal, otherwise a line there every ten seconds."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield _progress_lines()
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False))
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=None)
        yield lambda done, total, doing: bar.update(task, completed=done, total=total, description=doing)


def _progress_lines() -> ShownProgress:
    last = monotonic()

    def report(done: int, total: int, doing: str) -> None:
        nonlocal last
        now = monotonic()
        if now - last > SECONDS_BETWEEN_LINES:
            last = now
            say(f"{done} of {total} done, {doing}")

    return report
