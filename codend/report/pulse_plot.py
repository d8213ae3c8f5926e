"""A pulsing codend in time: its speed, its openings and its drag."""

from typing import TYPE_CHECKING

from codend.report.style import dress, new_figure, ordered_colours

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

PANELS = (
    ("speed_m_s", "speed through the water (m/s)"),
    ("opening_ahead_deg", "opening ahead of the catch (deg)"),
    ("drag_n", "drag (N)"),
)


def pulse_plot(table: "pd.DataFrame") -> "Figure":
    """The last two periods of every case and period of heave, against time over the period."""
    figure = new_figure(9.0, 8.0)
    panels = figure.subplots(len(PANELS), 1, sharex=True)
    groups = list(table.groupby(["case", "period_s"], sort=False))
    for ((case, period), rows), colour in zip(groups, ordered_colours(len(groups)), strict=True):
        last = rows[rows["time_s"] >= rows["time_s"].max() - 2.0 * rows["period_s"].iloc[0] - 1e-9]
        share = (last["time_s"] - last["time_s"].iloc[0]) / rows["period_s"].iloc[0]
        words = f"{period:g} s" if table["case"].nunique() == 1 else f"case {case}, {period:g} s"
        for panel, (column, _) in zip(panels, PANELS, strict=True):
            panel.plot(share, last[column], color=colour, lw=1.4, label=words)
    for panel, (_, title) in zip(panels, PANELS, strict=True):
        panel.set_ylabel(title)
        dress(panel)
    panels[0].legend(frameon=False, fontsize=8, title="period of heave", title_fontsize=8)
    panels[-1].set_xlabel("time over the period")
    return figure
