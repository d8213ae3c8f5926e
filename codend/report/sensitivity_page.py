"""Sensitivities on a page: the tornado, what does most in words, intervals and what to measure better."""

import math
from datetime import datetime
from pathlib import Path
from typing import Final

import pandas as pd

from codend.io.files import write_bytes, write_table, write_text
from codend.report.html import PageFigure, rendered
from codend.report.own_look import own_look
from codend.report.page_sections import Section, table_section
from codend.report.style import number_text, png, spread
from codend.report.tornado_plot import named, tornado_figure

FILES: Final = ("sensitivities.csv", "intervals.csv", "tornado.png", "sensitivities.html")
MOST_FIGURES: Final = 3
"""Cases that are drawn, evenly spread, the last among them."""
MOST_TOLD: Final = 4
"""Numbers that are told of in words, those that do most."""
LEAST_TOLD: Final = 5e-4
"""Change over the quantity from which a number is told of."""
MOST_SENTENCES: Final = 20
"""Intervals that are told in words, those of the last cases."""
WHAT: Final = ["run", "case"]


def write_sensitivities(title: str, table: pd.DataFrame, intervals: pd.DataFrame | None, folder: Path) -> list[str]:
    """Write the tables, the figure of the last case and the page; the files' names.

    Args:
        title: of the plan or study.
        table: ``sensitivities.csv``, of several designs with a column ``run`` ahead.
        intervals: ``intervals.csv``; None where nothing is said to be uncertain.
        folder: where.
    """
    cases = list(table.groupby([name for name in WHAT if name in table], sort=False))
    shown = [cases[i] for i in spread(len(cases), MOST_FIGURES)]
    with own_look():
        pictures = [png(tornado_figure(own)) for _, own in shown]
    figures = [
        PageFigure(
            picture, f"{case_name(own)}: 10 % more and less of every number, in proportion; of small counts one."
        )
        for picture, (_, own) in zip(pictures, shown, strict=True)
    ]
    page = _html(title, table, intervals, figures)
    write_table(table, folder / FILES[0])
    if intervals is not None:
        write_table(intervals, folder / FILES[1])
    write_bytes(pictures[-1], folder / FILES[2])
    write_text(page, folder / FILES[3])
    return [name for name in FILES if name != FILES[1] or intervals is not None]


def told(table: pd.DataFrame) -> list[str]:
    """Of one case what 10 % more of the numbers that do most does, a sentence a quantity."""
    sentences = []
    for quantity in dict.fromkeys(table["quantity"]):
        words, unit = named(quantity)
        own = table[(table["quantity"] == quantity) & table["by_10_percent"].notna()]
        own = own.assign(size=own["by_10_percent"].abs()).sort_values("size", ascending=False)
        largest = own[own["size"] > LEAST_TOLD * own["size"].max()].head(MOST_TOLD)
        parts = [f"{row.key} {_signed(row.by_10_percent)} {unit}" for row in largest.itertuples()]
        if parts:
            sentences.append(f"10 % more changes {words}: {', '.join(parts)}.")
    return sentences


def better(intervals: pd.DataFrame) -> list[str]:
    """The intervals in words, a sentence a row, and which number to measure better."""
    sentences = []
    for row in intervals.to_dict("records"):
        words, unit = named(str(row["quantity"]))
        if math.isnan(row["lower_95"]):
            sentences.append(f"{_name_of(row)}: {words} has no interval, for a derivative is not known.")
        elif row["measure_better"]:
            digits = max(2, 2 + math.floor(math.log10(abs(row["value"]) / max(row["standard_deviation"], 1e-300))))
            low, high, value = (number_text(row[name], digits) for name in ("lower_95", "upper_95", "value"))
            sentences.append(
                f"{_name_of(row)}: {words} {value} {unit}, 95 % from {low} to {high}; "
                f"measure {row['measure_better']} better, which makes {100.0 * row['share']:.0f} % of the variance."
            )
    return sentences


def _html(title: str, table: pd.DataFrame, intervals: pd.DataFrame | None, figures: list[PageFigure]) -> str:
    last = list(table.groupby([name for name in WHAT if name in table], sort=False))[-1][1]
    heading = "What does most" + (f" in {case_name(last)}" if len(figures) > 1 else "")
    sections = [Section(heading, tuple(told(last)), figures=tuple(figures))]
    if intervals is not None:
        remark = (
            "In proportion, numbers as independent: the interval holds what the plan's numbers leave open, and no "
            "error of the model."
        )
        sections.append(table_section("Intervals", (remark, *better(intervals)[-MOST_SENTENCES:]), intervals))
    known = last[["quantity", "key", "value", "derivative", "by_10_percent", "note"]]
    remark = (
        f"Of {case_name(last)}, per unit of the number, of counts per one more; sensitivities.csv has those of all "
        "cases, towards smaller and larger values each, and between which values nothing goes slack or taut and the "
        "front passes no row."
    )
    sections.append(table_section("Derivatives", (remark,), known))
    return rendered(
        "sections.html",
        title=title,
        summary=f"Sensitivities. Written {datetime.now().astimezone():%d %B %Y, %H:%M %Z}.",
        lead=(),
        warnings=(),
        notes=(),
        sections=sections,
    )


def case_name(own: pd.DataFrame) -> str:
    """What a case is called, of which there are rows."""
    return _name_of(own.iloc[0].to_dict())


def _name_of(row: dict) -> str:
    design = row.get("design")
    run = f"run {row['run']}, " if "run" in row else ""
    return f"{run}{f'{design}, ' if isinstance(design, str) else ''}case {row['case']}"


def _signed(value: float) -> str:
    return ("+" if value > 0.0 else "−") + (number_text(abs(value), 2) or "0")
