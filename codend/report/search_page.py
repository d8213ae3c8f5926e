"""A search on a page: how it ended, the designs looked at beside what is asked, and the one that was found."""

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

import pandas as pd

from codend.io.files import write_bytes, write_table, write_text
from codend.plan.copy import plan_toml
from codend.report.html import PageFigure, rendered
from codend.report.own_look import own_look
from codend.report.page_sections import Section, table_section
from codend.report.style import dress, new_figure, png
from codend.report.tornado_plot import named
from codend.studies.search.search import Condition, Design, Found
from codend.studies.search.table import ended, search_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES: Final = ("plan.toml", "search.csv", "search.png", "search.html")
"""The first only where a design was found."""
MISSED, REACHED, BOUND = "#999999", "#0072b2", "#d55e00"


def write_search(title: str, found: Found, folder: Path) -> None:
    """Write the plan found, the table of the designs looked at, the figure and the page."""
    plan, table, picture, page = (folder / name for name in FILES)
    with own_look():
        drawn = png(search_figure(found))
    write_table(search_table(found), table)
    if found.plan is not None:
        write_text(plan_toml(found.plan), plan)
    write_bytes(drawn, picture)
    write_text(_html(title, found, PageFigure(drawn, "Every design that was looked at, in its worst case.")), page)


def search_figure(found: Found) -> "Figure":
    """A panel a bound: what every design has in its worst case over its change, and the bound."""
    across = min(len(found.conditions), 2)
    down = -(-len(found.conditions) // across)
    figure = new_figure(4.6 * across, 3.1 * down + 0.5)
    axes = figure.subplots(down, across, squeeze=False).ravel()
    for axis, bound in zip(axes, found.conditions, strict=False):
        dress(axis)
        for reaches, colour, marker, words in (
            (False, MISSED, "x", "does not reach all bounds"),
            (True, REACHED, "o", "reaches all bounds"),
        ):
            shown = [one for one in found.looked_at if one.told and one.reaches is reaches]
            places = [100.0 * one.change for one in shown], [_worst(one, bound) for one in shown]
            axis.plot(*places, marker, color=colour, label=words, markersize=5)
        for design, words, marker in ((found.start, "the plan as it is", "D"), (found.best, "found", "*")):
            if design is not None:
                place = [100.0 * design.change], [_worst(design, bound)]
                axis.plot(*place, marker, color="black", mfc="none", markersize=11, label=words)
        axis.axhline(bound.bound, color=BOUND, linestyle="--", label="bound")
        words, unit = named(bound.quantity)
        axis.set_xlabel("change of the plan, %")
        axis.set_ylabel(f"{words}, {unit}, {'at least' if bound.sign > 0.0 else 'at most'} {bound.bound:g}")
    for axis in axes[len(found.conditions) :]:
        axis.set_visible(False)
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", frameon=False, ncols=2, fontsize=8.5
    )
    return figure


def _worst(design: Design, bound: Condition) -> float:
    return min((told[bound.quantity] for told in design.told), key=bound.margin, default=float("nan"))


def _html(title: str, found: Found, figure: PageFigure) -> str:
    """The page, with everything from plans escaped."""
    designs = [("as it is", found.start), ("found", found.best), ("nearest", None if found.best else found.nearest)]
    there = [(name, design) for name, design in designs if design is not None]
    told = [
        {"design": name, "case": case, **one} for name, design in there for case, one in enumerate(design.told, start=1)
    ]
    values = pd.DataFrame([{"design": name, **design.values, "change": design.change} for name, design in there])
    sentences = tuple(ended(found))
    change = "The change is the root of the sum of the squares of the relative changes of the numbers that may change."
    return rendered(
        "sections.html",
        title=title,
        summary=f"Search. Written {datetime.now().astimezone():%d %B %Y, %H:%M %Z}.",
        lead=sentences if found.best else (),
        warnings=() if found.best else sentences,
        notes=(),
        sections=[
            Section("", figures=(figure,)),
            table_section("The plan's numbers", (change,), values),
            table_section("What they come to", (), pd.DataFrame(told)),
        ],
    )
