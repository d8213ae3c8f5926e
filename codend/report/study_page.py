"""A study on a page: responses, maps, drag against L50, and the best designs with their plans."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Final

import pandas as pd

from codend.io.columns import error_of
from codend.io.files import write_bytes, write_text
from codend.plan.copy import plan_toml
from codend.plan.plan import Plan
from codend.report.html import PageFigure, rendered
from codend.report.own_look import own_look
from codend.report.page_sections import Section, table_section
from codend.report.study_plots import Swept, fronts_of, map_figure, pareto_figure, response_figure, swept
from codend.report.style import png, spread
from codend.report.tornado_plot import named

PAGE: Final = "study.html"
FIGURES: Final = ("response.png", "map.png", "pareto.png")
BEST: Final = "best"
"""Folder of the plans of the best designs."""
MOST_BEST: Final = 10
MOST_LOST: Final = 5
"""Designs not solved that are told each."""
TOLD: Final = ("drag_n", "opening_ahead_deg", "catch_mass_kg", "stable")


def write_study(
    title: str,
    table: pd.DataFrame,
    plan_of: Callable[[int], Plan],
    folder: Path,
    intervals: pd.DataFrame | None = None,
) -> list[str]:
    """Write the figures that the study has, its page, and plans of its best designs; their names.

    Args:
        title: of the study.
        table: ``sweep.csv``.
        plan_of: the plan of a run, by its number.
        folder: where; figures and plans of an earlier study there are removed.
        intervals: ``intervals.csv`` of a study that says how well its numbers are known.
    """
    found = swept(table)
    if found is None:
        return []
    more = next((name for name in table.columns if name.startswith("l50_cm") and found.table[name].notna().any()), None)
    more = more or "opening_ahead_deg"
    front = pd.concat(fronts_of(found, more))
    best = front.iloc[spread(len(front), MOST_BEST)]
    with own_look():
        drawn = _drawn(found, more)
    page = _html(title, found, drawn, best, more, _warnings(table, found), intervals)
    plans = {f"run_{run}.toml": plan_toml(plan_of(int(run))) for run in best["run"]}
    for name, (picture, _) in drawn.items():
        write_bytes(picture, folder / name)
    (folder / BEST).mkdir(exist_ok=True)
    for name, text in plans.items():
        write_text(text, folder / BEST / name)
    write_text(page, folder / PAGE)
    return [*drawn, *(f"{BEST}/{name}" for name in plans), PAGE]


def remove_study(folder: Path) -> None:
    """Remove what ``write_study`` made of an earlier study."""
    for name in (*FIGURES, PAGE):
        (folder / name).unlink(missing_ok=True)
    for path in (folder / BEST).glob("run_*.toml"):
        path.unlink()


def _drawn(found: Swept, more: str) -> dict[str, tuple[bytes, str]]:
    """Pictures by their files' names, with what they show."""
    drawn = {}
    if found.numbers:
        drawn["response.png"] = (png(response_figure(found)), f"Against {found.numbers[0]}; {found.case}.")
    chart = map_figure(found)
    if chart is not None:
        rest = (*found.numbers[2:], *found.kinds)
        where = "; ".join(f"{key} = {found.table[key].iloc[0]}" for key in rest)
        drawn["map.png"] = (
            png(chart),
            f"Over {found.numbers[0]} and {found.numbers[1]}{f', at {where}' if where else ''}; {found.case}.",
        )
    if len(found.table) > 1:
        words = named(more)[0]
        caption = f"Drag against {words}; {found.case}. {_betters(found, words)}"
        drawn["pareto.png"] = (png(pareto_figure(found, more)), caption)
    return drawn


def _betters(found: Swept, words: str) -> str:
    """What the fronts are of."""
    if not found.conditions:
        return f"No design has both less drag and more {words} than those on the line."
    which = " and ".join(found.conditions)
    if len(found.alike) > 1:
        return f"A line for every {which}: no other design there has both less drag and more {words}."
    return f"No design has both less drag and more {words} than those on the line; they differ in {which} too."


def _warnings(table: pd.DataFrame, found: Swept) -> list[str]:
    """Designs that are not drawn, and shapes that do not last."""
    solved = set(found.table["run"])
    reasons = {int(run): str(reason) for run, reason in zip(table["run"], table["reason"], strict=True)}
    lost = [run for run in reasons if run not in solved]
    lines = []
    if lost:
        some = "; ".join(f"run {run}: {reasons[run].rstrip('.')}" for run in lost[:MOST_LOST])
        more = f"; and {len(lost) - MOST_LOST} more, see sweep.csv" if len(lost) > MOST_LOST else ""
        lines.append(f"Not solved, and in no figure: {some}{more}.")
    unstable = int((found.table["stable"] == "no").sum()) if "stable" in found.table else 0
    if unstable:
        lines.append(
            f"{unstable} of {len(found.table)} shapes are not stable (column stable): their errors cover what becomes "
            "of them."
        )
    return lines


def _html(
    title: str,
    found: Swept,
    drawn: dict[str, tuple[bytes, str]],
    best: pd.DataFrame,
    more: str,
    warnings: list[str],
    intervals: pd.DataFrame | None,
) -> str:
    figures = tuple(PageFigure(picture, caption) for picture, caption in drawn.values())
    keys = list(found.table.columns[: list(found.table.columns).index("case")])
    told = dict.fromkeys((*keys, more, error_of(more), "drag_n", error_of("drag_n"), *TOLD))
    like = f"of like {' and '.join(found.conditions)} " if len(found.alike) > 1 else ""
    words = named(more)[0]
    remark = f"Of designs {like}than which none has both less drag and more {words}; their plans are in {BEST}."
    shaded = any(error_of(quantity) in found.table for quantity in found.quantities)
    about = ("Shades behind lines are what the computed values may be off.",) if shaded and not found.by_points else ()
    sections = [
        Section("What it shows", about, figures=figures),
        table_section("Best designs", (remark,), best[[name for name in told if name in best]]),
    ]
    if intervals is not None:
        sections.append(_known(intervals, best, more))
    written = f"{datetime.now().astimezone():%d %B %Y, %H:%M %Z}"
    return rendered(
        "sections.html",
        title=title,
        summary=f"{len(found.table)} designs at {found.case}. Written {written}.",
        lead=(),
        warnings=warnings,
        notes=(),
        sections=sections,
    )


def _known(intervals: pd.DataFrame, best: pd.DataFrame, more: str) -> Section:
    """How well drag, opening and L50 of the best designs are known."""
    asked = intervals["quantity"].isin(["drag_n", "opening_ahead_deg", more])
    there = intervals["run"].isin(best["run"]) & (intervals["case"] == best["case"].iloc[0])
    own = intervals[asked & there]
    shown = own[["run", "value", "lower_95", "upper_95", "measure_better", "share"]].copy()
    shown.insert(1, "quantity", [", ".join(named(name)) for name in own["quantity"]])
    remark = (
        "By what the study says of its numbers in [uncertain], and nothing else; share is how much of the variance the "
        "number to measure better makes. All designs are in intervals.csv."
    )
    return table_section("How well these are known", (remark,), shown)
