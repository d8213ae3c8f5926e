"""A scene as one page to read."""

from collections.abc import Sequence
from datetime import datetime
from importlib.resources import files
from typing import Any

import pandas as pd

from codend.report.html import PageFigure, made_with, page_style
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
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    template = environment.from_string((files("codend.report") / "scene.html").read_text(encoding="utf-8"))
    return template.render(
        style=page_style(),
        title=scene.title,
        summary=f"A scene; written {datetime.now().astimezone():%d %B %Y, %H:%M %Z}.",
        notes=notes,
        tables=[{"title": title, "heads": list(table.columns), "rows": _cells(table)} for title, table in tables],
        figures=figures,
        inputs=_inputs(scene),
        versions=made_with(),
    )


def _cells(table: pd.DataFrame) -> list[list[str]]:
    columns = []
    for name in table.columns:
        values = table[name]
        words = values.dtype == bool or not pd.api.types.is_numeric_dtype(values)
        columns.append([str(v) for v in values] if words else column_text(values.to_numpy(dtype=float)))
    return [list(row) for row in zip(*columns, strict=True)]


def _inputs(scene: Scene) -> list[dict[str, Any]]:
    sections = []
    for name, table in scene.model_dump(mode="json", exclude_none=True).items():
        several = table if isinstance(table, list) else [table]
        for number, one in enumerate(several, start=1):
            if isinstance(one, dict):
                title = name if len(several) == 1 else f"{name} {number} of {len(several)}"
                sections.append({"name": title, "entries": [(key, _words(value)) for key, value in one.items()]})
    return sections


def _words(value: Any) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)
