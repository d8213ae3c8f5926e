"""A sweep in one figure: what matters most of every run against the catch."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from codend.report.style import dress, new_figure, ordered_colours, spread

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS = {
    "opening_ahead_deg": "opening ahead of the catch (°)",
    "drag_n": "drag (N)",
    "max_radius_m": "largest radius (m)",
}
"""Columns of the panels and what stands beside their axes."""
MOST_NAMED = 12
"""Most runs that are named; of more, the names are evenly spread."""
MOST_DRAWN = 200
"""Most runs of a study that are drawn, evenly spread."""


def sweep_figure(table: pd.DataFrame, labels: dict[int, str]) -> "Figure":
    """A panel a quantity, a line a run and speed; a dot where a run has one catch.

    Args:
        table: ``sweep.csv``; cases that were not solved leave gaps.
        labels: what each run is, by its number.
    """
    figure = new_figure(10.5, 3.9 + 0.19 * min(len(labels), MOST_NAMED))
    axes = figure.subplots(1, len(PANELS))
    named = {list(labels)[i] for i in spread(len(labels), MOST_NAMED)}
    for colour, (number, label) in zip(ordered_colours(len(labels)), labels.items(), strict=True):
        for at_first, (_, cases) in enumerate(table[table["run"] == number].groupby("speed_m_s", sort=True)):
            curve = cases.sort_values("catch_volume_m3")
            for axis, column in zip(axes, PANELS, strict=True):
                shown = label if number in named and at_first == 0 and axis is axes[0] else None
                axis.plot(curve["catch_volume_m3"], curve[column], ".-", color=colour, lw=1.4, ms=5, label=shown)
    for axis, text in zip(axes, PANELS.values(), strict=True):
        dress(axis)
        axis.set_xlabel("catch volume (m³)")
        axis.set_ylabel(text)
        axis.set_xlim(left=0.0)
        if np.isfinite(axis.get_ylim()).all():
            axis.set_ylim(bottom=0.0)
    figure.legend(loc="outside lower center", ncols=1 if len(max(labels.values(), key=len)) > 45 else 2, frameon=False)
    return figure
