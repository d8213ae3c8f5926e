"""A section of the validation report: what was computed, drawn and found, before anything is written.

Every part of the report is a module with ``section(quick) -> Section``; ``python -m validation`` runs them in order and
writes ``REPORT.md`` with their pictures and data. ``quick`` asks for a coarser version that finishes in seconds.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Picture:
    """A figure of the report and what a reader should see in it."""

    name: str
    """Stem of its file; the picture goes where the section's text has the line ``![name]``, else after the text."""
    figure: "Figure"
    caption: str


@dataclass(frozen=True)
class Verdict:
    """A claim that was checked."""

    claim: str
    """A sentence that is true if the check passed."""
    passed: bool
    found: str
    """The figures measured, in words."""


@dataclass(frozen=True)
class Section:
    """A section of the report."""

    title: str
    text: str
    """Markdown: paragraphs and tables, without the title."""
    pictures: tuple[Picture, ...] = ()
    data: Mapping[str, "pd.DataFrame"] = field(default_factory=dict)
    """What the pictures show, by stem of the CSV file."""
    verdicts: tuple[Verdict, ...] = ()
