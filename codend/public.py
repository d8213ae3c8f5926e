"""What ``codend`` offers from Python: plans however they are given, and studies that plot and write themselves."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codend.errors import OPTIONS, InputError
from codend.plan.overrides import Overrides
from codend.plan.plan import Plan, load_plan, plan_from_dict
from codend.studies import study as studies

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = ["case", "speed_m_s", "catch_volume_m3", "drag_n", "opening_ahead_deg", "stable", "converged"]
"""Columns of ``results.csv`` that a notebook shows of a study."""


@dataclass(frozen=True, repr=False)
class Study(studies.Study):
    """All cases of a plan, solved."""

    def plot(self, what: str = "opening") -> "Figure":
        """One of the plots of its page: net, profiles, opening, opening_force, tension or drag.

        Raises:
            InputError: there is no such plot, or nothing to draw: no case was solved.
        """
        from codend.report.page import PLOTS
        from codend.report.plots import solved

        drawn = {plot.name: plot.draw for plot in PLOTS if plot.fits(self)} if solved(self) else {}
        if what not in drawn:
            raise InputError(OPTIONS, "plot", what, ", ".join(drawn) or "nothing, for no case was solved")
        return drawn[what](self)

    def write(self, folder: str | Path) -> list[Path]:
        """Write all that ``codend run`` writes into a folder; the files.

        Raises:
            OSError: a file cannot be written.
        """
        from codend.report.page import write_report

        return write_report(self, Path(folder))

    def __repr__(self) -> str:
        solved = sum(result.converged for result in self.cases)
        return f"<Study {self.plan.title!r}: {solved} of {len(self.cases)} cases solved, {self.choice.fidelity}>"

    def _repr_html_(self) -> str:
        shown: str = self.table[SHOWN].to_html(index=False, border=0, float_format=lambda value: f"{value:.4g}")
        return f"<p>{escape(repr(self))}</p>{shown}"


def solve(
    plan: Plan | Mapping[str, Any] | str | Path,
    overrides: Overrides = (),
    *,
    progress: Callable[[int, int, str], None] | None = None,
) -> Study:
    """Solve every case of a plan.

    Args:
        plan: a plan, its tables, or the path of its file.
        overrides: changes, as ``{"netting.0.bar_mm": 25}`` or ``["netting.0.bar_mm=25"]``.
        progress: told how many cases are done, of how many, and what is being done.

    Returns:
        A study; a case that failed is in it, not converged, its numbers nan.

    Raises:
        InputError: the plan cannot be used.
        TooLittleMemory: the model does not fit into memory; which merged net would is told.
    """
    if isinstance(plan, Plan):
        checked = plan_from_dict(plan.said(), plan.source, overrides) if overrides else plan
    elif isinstance(plan, Mapping):
        checked = plan_from_dict(plan, overrides=overrides)
    else:
        checked = load_plan(plan, overrides)
    found = studies.solve(checked, progress)
    return Study(found.plan, found.choice, found.cases)
