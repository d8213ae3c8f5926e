"""Parts of a page that is made of headings, texts, tables and figures: `sections.html`."""

import math
from dataclasses import dataclass

import pandas as pd

from codend.report.html import PageFigure


@dataclass(frozen=True)
class Section:
    """A part of the page."""

    heading: str
    texts: tuple[str, ...] = ()
    heads: tuple[str, ...] = ()
    words: tuple[bool, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    figures: tuple[PageFigure, ...] = ()


def table_section(heading: str, texts: tuple[str, ...], table: pd.DataFrame) -> Section:
    """Texts, and a table below, numbers to four digits."""
    words = tuple(not pd.api.types.is_numeric_dtype(table[column]) for column in table.columns)
    rows = tuple(tuple(map(_cell, row)) for row in table.itertuples(index=False))
    # keys of plans keep their names
    heads = tuple(name if "." in name else name.replace("_", " ") for name in map(str, table.columns))
    return Section(heading, texts, heads, words, rows)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if math.isfinite(value) else ""
    return str(value)
