"""Any net of bars in a figure: three views, bars coloured by their tension."""

from typing import TYPE_CHECKING

import numpy as np

from codend.mechanics.problem import Problem
from codend.net.net import rotate
from codend.report.style import INK, dress, new_figure
from codend.solvers.outcome import Solution

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VIEWS = (((0, 2), "from the side"), ((0, 1), "from above"), ((1, 2), "from ahead"))
NAMES = ("x (m)", "y (m)", "z (m)")


def draw(problem: Problem, solution: Solution) -> "Figure":
    """A net in equilibrium from the side, from above and from ahead; of a sector what is modelled.

    Raises:
        ValueError: the net was not solved.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize

    if not solution.report.outcome.converged:
        raise ValueError(f"there is no shape to draw: {solution.report.outcome.value}")
    net, positions = problem.net, solution.positions
    ends = np.stack([positions[net.bars[:, 0]], rotate(positions[net.bars[:, 1]], net.bar_image, net.order)], axis=1)
    held = positions[np.asarray(net.fixed).any(axis=1)]
    figure = new_figure(11.0, 3.8)
    colours = ScalarMappable(Normalize(0.0, max(float(solution.bar_tension.max()), 1e-300)), "viridis")
    for axes, ((across, up), words) in zip(figure.subplots(1, 3), VIEWS, strict=True):
        bars = LineCollection(list(ends[:, :, [across, up]]), colors=colours.to_rgba(solution.bar_tension))
        axes.add_collection(bars)
        axes.plot(held[:, across], held[:, up], "s", color=INK, markersize=3.0)
        axes.autoscale()
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_title(words, loc="left", fontsize="medium")
        axes.set_xlabel(NAMES[across])
        axes.set_ylabel(NAMES[up])
        dress(axes)
    figure.colorbar(colours, ax=figure.axes, label="tension (N)", shrink=0.8)
    return figure
