"""Independent checks: every claim with its source, its tolerance and the error found, a file a theme.

``THEMES`` is the one table of them, for the report and for the tests.
"""

from typing import TYPE_CHECKING

from validation.independent_checks import balance, cables, closed_forms, panels, pressure, shells
from validation.independent_checks.check import Check, Theme
from validation.report import markdown_table
from validation.section import Picture, Section, Verdict

if TYPE_CHECKING:
    import pandas as pd

THEMES = (closed_forms.THEME, shells.THEME, balance.THEME, cables.THEME, pressure.THEME, panels.THEME)


def section(quick: bool) -> Section:
    """All themes, one after the other."""
    blocks: list[str] = []
    pictures: list[Picture] = []
    data: dict[str, pd.DataFrame] = {}
    verdicts: list[Verdict] = []
    for theme in THEMES:
        found = [verdict(check, quick) for check in theme.checks]
        drawn = theme.pictures()
        rows = [
            (check.claim, check.source, one.found, "yes" if one.passed else "**NO**")
            for check, one in zip(theme.checks, found, strict=True)
        ]
        blocks += [f"### {theme.title}", theme.text, *(f"![{picture.name}]" for picture in drawn)]
        blocks.append(markdown_table(("claim", "source", "found", "passed"), rows))
        pictures += drawn
        data |= theme.data()
        verdicts += found
    return Section("Independent checks", "\n\n".join(blocks), tuple(pictures), data, tuple(verdicts))


def verdict(check: Check, quick: bool) -> Verdict:
    """What a check found; one that raises has failed."""
    try:
        error = check.error(quick)
    except Exception as reason:  # the other checks are still wanted
        return Verdict(check.claim, False, f"{type(reason).__name__}: {reason}")
    return Verdict(check.claim, error <= check.tolerance, check.words.format(error=error, tolerance=check.tolerance))


__all__ = ["THEMES", "Check", "Theme", "section", "verdict"]
