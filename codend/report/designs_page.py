"""Designs beside each other on one page: a figure, what differs in the plans, and the differences."""

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

import pandas as pd

from codend.io.files import whole_file, write_bytes, write_table
from codend.report.html import PageFigure, rendered
from codend.report.own_look import own_look
from codend.report.page_sections import Section
from codend.report.style import dress, new_figure, number_text, png
from codend.studies.comparison.designs import BesideEachOther

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES: Final = ("plan_differences.csv", "designs.csv", "design_differences.csv", "designs.png", "designs.html")
LABELS: Final = {
    "opening_ahead_deg": "opening ahead of the catch, °",
    "drag_n": "drag, N",
    "l50_cm": "L50, cm",
    "sr_cm": "SR, cm",
}
COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
"""Of the palette for the colour-blind by Okabe and Ito."""
DASHES: Final = ("-", "--", "-.", ":")
"""A design's: colour and dash together tell more designs apart than there are colours, and in print."""


def designs_figure(found: BesideEachOther) -> "Figure":
    """A panel a quantity and species over the catch, a line a design and speed, its interval behind it."""
    kinds = found.values[["quantity", "species"]].drop_duplicates()
    panels = [(str(quantity), str(species)) for quantity, species in kinds.itertuples(index=False)]
    across = min(len(panels), 2)
    figure = new_figure(4.6 * across, 3.3 * -(-len(panels) // across) + 0.25 * len(found.names))
    axes = figure.subplots(-(-len(panels) // across), across, squeeze=False).ravel()
    for axis, (quantity, species) in zip(axes, panels, strict=False):
        dress(axis)
        shown = found.values[(found.values["quantity"] == quantity) & (found.values["species"] == species)]
        for number, name in enumerate(found.names):
            colour, dash = COLOURS[number % len(COLOURS)], DASHES[number % len(DASHES)]
            label: str | None = name
            rising = shown[shown["design"] == name].sort_values("catch_mass_kg")
            for _, curve in rising.groupby("speed_m_s"):
                mass, value, half = (curve[column] for column in ("catch_mass_kg", "value", "half_width"))
                axis.plot(mass, value, dash, marker=".", color=colour, label=label)
                axis.fill_between(mass, value - half, value + half, color=colour, alpha=0.15, linewidth=0)
                label = None
        axis.set_xlabel("catch, kg")
        axis.set_ylabel(LABELS[quantity] + (f", {species}" if species else ""))
        axis.set_xlim(left=0.0)
    for axis in axes[len(panels) :]:
        axis.set_visible(False)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", frameon=False, ncols=min(len(labels), 3))
    return figure


def write_designs(found: BesideEachOther, folder: Path) -> None:
    """Write the tables, the figure and the page that are in ``FILES``."""
    plans, values, differences, picture, page = (folder / name for name in FILES)
    write_table(found.plans, plans)
    write_table(found.values[["design", *found.values.columns.drop("design")]], values)
    write_table(found.differences, differences)
    with own_look():
        drawn = png(designs_figure(found))
    write_bytes(drawn, picture)
    with whole_file(page) as temporary:
        temporary.write_text(designs_html(found, PageFigure(drawn, "Against the catch")), encoding="utf-8")


def designs_html(found: BesideEachOther, figure: PageFigure) -> str:
    """The page, with everything from plans and folders escaped."""
    remark = (
        f"Each less {found.names[0]}, at its catches and speeds; between a design's own catches in proportion, never "
        "beyond them. Intervals of opening and drag are as wide as both error estimates together, which cover no "
        "uncertainty of the plans; those of L50 and SR are as wide as the 95 % of both logit fits, for a finite "
        "number of fish and the error of the openings, taken as independent."
    )
    return rendered(
        "sections.html",
        title="Designs beside each other",
        summary=f"{', '.join(found.names)}. Written {datetime.now().astimezone():%d %B %Y, %H:%M %Z}.",
        lead=(),
        warnings=found.left_out,
        notes=(),
        sections=[
            Section("", figures=(figure,)),
            _section("What differs in the plans", "" if len(found.plans) else "Nothing.", found.plans),
            _section("Differences", remark, found.differences.drop(columns="interpolated")),
        ],
    )


def _section(heading: str, text: str, table: pd.DataFrame) -> Section:
    words = tuple(table[column].dtype.kind not in "fiu" for column in table.columns)
    rows = tuple(tuple(map(_cell, row)) for row in table.itertuples(index=False))
    return Section(heading, (text,) if text else (), tuple(map(str, table.columns)) if rows else (), words, rows)


def _cell(value: object) -> str:
    return number_text(value, 4) if isinstance(value, float) else str(value)
