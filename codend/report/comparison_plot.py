"""Computed codends and a flume table in one figure, a panel a quantity."""

import textwrap
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np
import pandas as pd

from codend.report.style import dress, new_figure, ordered_colours
from codend.studies.comparison.compare import Comparison, curve
from codend.studies.comparison.flume_table import CATCH_COLUMNS, SPEED_COLUMN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "catch_mass_kg": "catch, kg",
        "catch_volume_m3": "catch volume, m³",
        "filled_meshes": "filled meshes",
        "speed_m_s": "speed, m/s",
        "drag_n": "drag, N",
        "front_from_codline_m": "front from codline, m",
        "max_diameter_m": "largest diameter, m",
        "length_m": "length, m",
    }
)
Colour = tuple[float, float, float, float]

_PER_ROW = 3
_DENSE = 100
_HANDLE_IN, _LETTER_IN = 0.7, 0.095
"""Room that an entry of the legend takes, beside its text and for each letter."""


def comparison_figure(comparison: Comparison) -> "Figure":
    """Lines through the computed cases, a colour a speed, and the table's points; the table's origin is in the title.

    Where the hoop's drag is known, it is drawn as a term of its own, and computed drag with it beside without.
    """
    quantities = list(dict.fromkeys(comparison.points["quantity"]))
    columns = min(_PER_ROW, len(quantities))
    rows = -(-len(quantities) // columns)
    figure = new_figure(1.0 + 3.6 * max(columns, 2), 1.6 + 3.2 * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axis, quantity in zip(axes, quantities, strict=False):
        _panel(axis, comparison, quantity)
    for axis in axes[len(quantities) :]:
        axis.remove()
    handles = {
        label: handle
        for axis in axes[: len(quantities)]
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)
    }
    longest = _HANDLE_IN + _LETTER_IN * max(map(len, handles))
    abreast = min(3, max(1, int(figure.get_figwidth() / longest)))
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=abreast, frameon=False)
    width = int(16.0 * figure.get_figwidth())
    title = textwrap.fill(f"Computed codend beside {comparison.table.path.name}", width)
    figure.suptitle(f"{title}\n{textwrap.fill(comparison.table.origin, width)}", fontsize="medium")
    return figure


def _panel(axis: "Axes", comparison: Comparison, quantity: str) -> None:
    across = comparison.matched_on or SPEED_COLUMN
    points = comparison.points[comparison.points["quantity"] == quantity].sort_values(across)
    known = np.unique(comparison.computed[SPEED_COLUMN])
    speeds = known if comparison.matched_on else [None]
    for speed, colour in zip(speeds, ordered_colours(len(speeds)), strict=True):
        cases, here, at_speed = comparison.computed, points, ""
        if speed is not None:
            cases = cases[cases[SPEED_COLUMN] == speed]
            here = points[np.isclose(points[SPEED_COLUMN], speed)]
            at_speed = f" at {speed:g} m/s"
        _computed(axis, cases.sort_values(across), across, quantity, colour=colour, label=f"computed codend{at_speed}")
        axis.plot(here[across], here["tabled"], "o", color=colour, mfc="none", ms=7, label=f"table{at_speed}")
        if here["hoop_drag_n"].notna().any():
            label = f"computed codend + hoop{at_speed}"
            axis.plot(here[across], here["computed"], "+", color=colour, ms=9, label=label)
            label = f"hoop, {comparison.table.hoop_origin}{at_speed}"
            axis.plot(here[across], here["hoop_drag_n"], "^", color=colour, ms=4, label=label)
    if comparison.matched_on:
        elsewhere = points[~np.isclose(points[SPEED_COLUMN].to_numpy()[:, None], known).any(axis=1)]
        if not elsewhere.empty:
            axis.plot(elsewhere[across], elsewhere["tabled"], "x", color="0.5", label="table, speeds not computed")
    axis.set(xlabel=LABELS[across], ylabel=LABELS[quantity])
    axis.set_ylim(bottom=0.0)
    dress(axis)


def _computed(axis: "Axes", cases: pd.DataFrame, across: str, quantity: str, *, colour: Colour, label: str) -> None:
    """Computed cases as dots, joined by the curve that rows of the table are compared with."""
    line = cases
    if across in CATCH_COLUMNS and cases[across].nunique() > 1:
        line = curve(cases, across, np.linspace(cases[across].min(), cases[across].max(), _DENSE))
    axis.plot(line[across], line[quantity], "-", color=colour, lw=1.5, label=label)
    axis.plot(cases[across], cases[quantity], ".", color=colour, ms=5)
