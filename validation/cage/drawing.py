"""Pictures of the cage: figure 18, and the shapes of figures 14 and 15 of Le Bris et al. (1999)."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from codend.net.net import Floats
from codend.report.style import BLUE, INK, ORANGE, dress, new_figure, ordered_colours
from codend.scenes.build import BuiltScene
from codend.scenes.measures import SceneResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ASLANT = (0.45, 0.22)
"""Where a length across the current goes in the picture, over that length."""


def volume_figure(tables: Mapping[float, pd.DataFrame], fine: pd.DataFrame) -> "Figure":
    """Volume over that at rest against the current, a line a ballast."""
    figure = new_figure(7.0, 4.2)
    axes = figure.subplots()
    for colour, (ballast, table) in zip(ordered_colours(len(tables)), tables.items(), strict=True):
        share = 100.0 * table["volume_share"]
        axes.plot(table["speed_m_s"], share, color=colour, marker="o", ms=3)
        axes.annotate(f"{ballast:g} kg", (table["speed_m_s"].iloc[-1], share.iloc[-1]), (5, -3),
                      textcoords="offset points", color=colour)  # fmt: skip
    axes.plot(fine["speed_m_s"], 100.0 * fine["volume_share"], "x", color=INK, ms=5, label="12 kg in finer netting")
    axes.set_xlabel("current (m/s)")
    axes.set_ylabel("volume (% of that at rest)")
    axes.set_xlim(0.0, 1.1)
    axes.set_ylim(bottom=0.0)
    axes.legend(frameon=False)
    dress(axes)
    return figure


def shapes_figure(results: Sequence[SceneResult]) -> "Figure":
    """Cages seen aslant from the side, the current from the left; seams are thick, the bottom is blue."""
    figure = new_figure(3.6 * len(results), 4.2)
    panels = figure.subplots(1, len(results), sharex=True, sharey=True)
    for axes, result in zip(np.atleast_1d(panels), results, strict=True):
        _draw(axes, result.built, result.solution.positions)
        axes.set_title(f"{np.linalg.norm(result.built.scene.water.flow_m_s):.1f} m/s", color=INK)
        axes.set_aspect("equal")
        axes.set_axis_off()
    return figure


def _draw(axes, built: BuiltScene, positions: Floats) -> None:  # type: ignore[no-untyped-def]
    from matplotlib.collections import LineCollection

    flat = positions[:, [0, 2]] + positions[:, 1:2] * np.array(ASLANT)
    net = built.problem.net
    for number in np.argsort([-positions[nodes, 1].mean() for nodes in built.sheet_nodes]):
        bottom = built.scene.netting[number].name == "bottom"
        bars = net.bars[built.bar_sheet == number]
        axes.add_collection(LineCollection(list(flat[bars]), colors=BLUE if bottom else ORANGE, lw=0.5))
    for sheet, nodes in zip(built.scene.netting, built.sheet_nodes, strict=True):
        for edge in sheet.sheet.edges.values():
            axes.plot(*flat[nodes[edge.knots]].T, color=INK, lw=1.2)
    axes.autoscale_view()
