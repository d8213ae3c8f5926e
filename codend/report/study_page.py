"""A study on a page: responses, maps, drag against L50, and the best designs with their plans."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Final

import pandas as pd

from codend.io.files import write_bytes, write_text
from codend.plan.copy import plan_toml
from codend.plan.plan import Plan
from codend.report.fit_page import Section
from codend.report.html import PageFigure, rendered
from codend.report.own_look import own_look
from codend.report.page_sections import table_section
from codend.report.study_plots import Swept, front_of, map_figure, pareto_figure, response_figure, swept
from codend.report.style import png, spread
from codend.report.tornado_plot import named

PAGE: Final = "study.html"
FIGURES: Final = ("response.png", "map.png", "pareto.png")
BEST: Final = "best"
"""Folder of the plans of the best designs."""
MOST_BEST: Final = 10
TOLD: Final = ("drag_n", "opening_ahead_deg", "catch_mass_kg")


def write_study(title: str, table: pd.DataFrame, plan_of: Callable[[int], Plan], folder: Path) -> list[str]:
    """Write the figures that the study has, its page, and plans of its best designs; their names.

    Args:
        title: of the study.
        table: ``sweep.csv``.
        plan_of: the plan of a run, by its number.
        folder: where; figures and plans of an earlier study there are removed.
    """
    found = swept(table)
    if found is None:
        return []
    more = next((name for name in table.columns if name.startswith("l50_cm") and found.table[name].notna().any()), None)
    front = front_of(found.table, more or "opening_ahead_deg")
    best = front.iloc[spread(len(front), MOST_BEST)]
    with own_look():
        drawn = _drawn(found, more or "opening_ahead_deg")
    page = _html(title, found, drawn, best, more or "opening_ahead_deg")
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
        caption = f"Drag against {words}; {found.case}. No design has both less drag and more than those on the line."
        drawn["pareto.png"] = (png(pareto_figure(found, more)), caption)
    return drawn


def _html(title: str, found: Swept, drawn: dict[str, tuple[bytes, str]], best: pd.DataFrame, more: str) -> str:
    figures = tuple(PageFigure(picture, caption) for picture, caption in drawn.values())
    keys = list(found.table.columns[: list(found.table.columns).index("case")])
    told = [name for name in dict.fromkeys((*keys, more, *TOLD)) if name in best]
    remark = f"Of designs than which none has both less drag and more of {named(more)[0]}; their plans are in {BEST}."
    written = f"{datetime.now().astimezone():%d %B %Y, %H:%M %Z}"
    return rendered(
        "fit.html",
        title=title,
        summary=f"{len(found.table)} designs at {found.case}. Written {written}.",
        lead=(),
        warnings=(),
        notes=(),
        sections=[
            Section("What it shows", (), figures=figures),
            table_section("Best designs", (remark,), best[told]),
        ],
    )
