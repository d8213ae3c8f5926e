"""A scene as one page to read."""

from collections.abc import Sequence
from datetime import datetime

import pandas as pd

from codend.report.html import PageFigure, input_sections, rendered
from codend.report.style import column_text
from codend.scenes.scene import Scene


def scene_page(
    scene: Scene, tables: Sequence[tuple[str, pd.DataFrame]], figures: Sequence[PageFigure], notes: Sequence[str]
) -> str:
    """The page as HTML, everything from the scene escaped.

    Args:
        scene: what the user said.
        tables: their headings and rows.
        figures: its pictures.
        notes: what a reader must know before using the numbers.
    """
    return rendered(
        "scene.html",
        title=scene.title,
        summary=f"A scene; written {datetime.now().astimezone():%d %B %Y, %H:%M %Z}.",
        notes=notes,
        tables=[{"title": title, "heads": list(table.columns), "rows": _cells(table)} for title, table in tables],
        figures=figures,
        inputs=input_sections(scene.model_dump(mode="json", exclude_none=True)),
    )


def _cells(table: pd.DataFrame) -> list[list[str]]:
    columns = []
    for name in table.columns:
        values = table[name]
        words = values.dtype == bool or not pd.api.types.is_numeric_dtype(values)
        columns.append([str(v) for v in values] if words else column_text(values.to_numpy(dtype=float)))
    return [list(row) for row in zip(*columns, strict=True)]
