"""What every number of a plan does to what a case tells, as bars on either side of its value."""

import math
from typing import TYPE_CHECKING, Final

import pandas as pd

from codend.report.style import BLUE, INK, ORANGE, dress, new_figure, number_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_BARS: Final = 10
"""Numbers that are drawn, those that do most."""
SHARE: Final = 0.1
LEAST: Final = 2e-3
"""Of the longest bar, below which none is drawn."""
NAMES: Final = {
    "drag_n": ("drag", "N"),
    "catch_volume_m3": ("catch volume", "m³"),
    "opening_ahead_deg": ("opening ahead", "°"),
    "l50_cm": ("L50", "cm"),
    "sr_cm": ("SR", "cm"),
}
"""Quantities in words, and their units."""
DRAWN: Final = ("drag_n", "opening_ahead_deg", "l50_cm")
"""Those that have panels; of several species each has one."""


def named(quantity: str) -> tuple[str, str]:
    """A quantity in words, with the species that it is of, and its unit."""
    column, _, species = quantity.partition(" ")
    words, unit = NAMES[column]
    return (f"{words}, {species}" if species else words), unit


def tornado_figure(table: pd.DataFrame) -> "Figure":
    """A panel a quantity of one case: what 10 % more and 10 % less of every number make, in proportion.

    Of counts below 10 one more and one fewer. Bars of numbers that do nothing are left out.

    Args:
        table: rows of one case of ``sensitivities.csv``.
    """
    panels = [name for name in dict.fromkeys(table["quantity"]) if name.partition(" ")[0] in DRAWN]
    bars = [_bars(table[table["quantity"] == name]) for name in panels]
    heights = [max(len(one), 1) for one in bars]
    figure = new_figure(8.6, 0.75 * len(panels) + 0.25 * sum(heights) + 0.6)
    axes = figure.subplots(len(panels), 1, squeeze=False, gridspec_kw={"height_ratios": [h + 1.5 for h in heights]})
    for axis, name, own in zip(axes[:, 0], panels, bars, strict=True):
        words, unit = named(name)
        dress(axis)
        axis.grid(visible=False, axis="y")
        for place, row in enumerate(reversed(own)):
            axis.barh(place + 0.19, row["more"], 0.36, color=BLUE, label="10 % more" if place == 0 else None)
            axis.barh(
                place - 0.19, row["less"], 0.36, color="white", edgecolor=ORANGE, hatch="////", linewidth=1.2,
                label="10 % less" if place == 0 else None,
            )  # fmt: skip
        axis.axvline(0.0, color=INK, linewidth=0.9)
        axis.set_yticks(range(len(own)), [row["label"] for row in reversed(own)], fontsize=8.5)
        axis.set_ylim(-0.7, max(len(own), 1) - 0.3)
        axis.set_xlabel(f"change of {words} ({unit})")
        axis.margins(x=0.06)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2, frameon=False)
    return figure


def _bars(table: pd.DataFrame) -> list[dict[str, object]]:
    """Bars of a quantity, that which does most first."""
    rows = []
    for row in table.to_dict("records"):
        few = math.isnan(row["by_10_percent"])
        change = 1.0 if few else SHARE * row["value"]
        sides = {"more": change * row["derivative_above"], "less": -change * row["derivative_below"]}
        if any(math.isfinite(side) and side != 0.0 for side in sides.values()):
            one = ", one more or fewer" if few else ""
            rows.append(sides | {"label": f"{row['key']} = {number_text(row['value'], 4)}{one}"})
    largest = max(map(_size, rows), default=0.0)
    shown = [row for row in rows if _size(row) >= LEAST * largest]
    return sorted(shown, key=_size, reverse=True)[:MOST_BARS]


def _size(bar: dict[str, object]) -> float:
    return max(abs(float(str(bar[side]))) for side in ("more", "less") if not math.isnan(float(str(bar[side]))))
