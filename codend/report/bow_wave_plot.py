"""A bow wave in one figure: its profile with its sheet, and where a wave of such an entrance is steady."""

from typing import TYPE_CHECKING

import numpy as np

from codend.report.style import BLUE, INK, ORANGE, PALE, dress, new_figure
from codend.scenes.bow_wave import BowWave, steady_limit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LONGEST = 2.5
"""Length of the profile shown, over the distance of the crest."""
WIDEST_DEG = 60.0


def bow_wave_figure(wave: BowWave) -> "Figure":
    """Profile and paths of the sheet, of a steady wave; the limit of steady waves with this one marked."""
    figure = new_figure(9.5 if wave.steady else 5.5, 3.9)
    axes = figure.subplots(1, 2 if wave.steady else 1, squeeze=False)[0]
    limit = axes[-1]
    angle = np.linspace(1.0, WIDEST_DEG, 200)
    froude = np.array([steady_limit(float(a)) for a in angle])
    top = 1.3 * max(wave.froude, steady_limit(wave.entrance_angle_deg), 1.0)
    limit.fill_between(angle, froude, top, where=froude <= top, color=PALE, lw=0.0)
    limit.plot(angle, froude, color=INK, lw=1.4)
    limit.plot([wave.entrance_angle_deg], [wave.froude], "o", color=ORANGE, ms=7)
    limit.annotate(
        "this wave", (wave.entrance_angle_deg, wave.froude), (8, 8), textcoords="offset points", color=ORANGE
    )
    limit.text(3.0, 0.93 * top, "steady", color=INK)
    limit.text(WIDEST_DEG - 2.0, 0.03 * top, "not steady", color=INK, ha="right")
    limit.set(xlim=(0.0, WIDEST_DEG), ylim=(0.0, top))
    limit.set_xlabel("half entrance angle (°)")
    limit.set_ylabel("speed / √(g × draught)")
    dress(limit)
    if not wave.steady:
        return figure
    profile, unit = axes[0], wave.length_unit_m
    t = np.linspace(0.0, LONGEST * wave.crest, 300)
    starts = np.linspace(0.05, 0.95, 10) * wave.crest
    along, _, up = wave.sheet(starts, np.linspace(0.0, 1.2 * wave.crest, 80))
    up[up < 0.0] = np.nan
    profile.plot(unit * along.T, unit * up.T, color=BLUE, lw=0.7, alpha=0.7)
    profile.plot(unit * t, unit * wave.profile(t), color=INK, lw=2.0, label="contact line on the hull")
    profile.plot([], [], color=BLUE, lw=0.7, label="water that has left it, in free flight")
    profile.axhline(0.0, color=PALE, lw=1.0, zorder=0)
    profile.set_xlabel("distance from the stem along the hull (m)")
    profile.set_ylabel("height above still water (m)")
    profile.set_xlim(left=0.0)
    dress(profile)
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure
