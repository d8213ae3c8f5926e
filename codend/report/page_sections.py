"""Parts of a page: texts with figures, and tables."""

import math

import pandas as pd

from codend.report.fit_page import Section
from codend.report.html import PageFigure


def text_section(heading: str, texts: tuple[str, ...], figures: tuple[PageFigure, ...]) -> Section:
    """Texts, and figures below."""
    return Section(heading, texts, figures=figures)


def table_section(heading: str, texts: tuple[str, ...], table: pd.DataFrame) -> Section:
    """Texts, and a table below, numbers to four digits."""
    words = tuple(not pd.api.types.is_numeric_dtype(table[column]) for column in table.columns)
    rows = tuple(tuple(map(_cell, row)) for row in table.itertuples(index=False))
    return Section(heading, texts, tuple(str(name).replace("_", " ") for name in table.columns), words, rows)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if math.isfinite(value) else ""
    return str(value)
