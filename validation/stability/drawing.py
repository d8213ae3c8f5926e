"""Stability maps as pictures: a coloured cell for every solve, and the borders that theory knows."""

from typing import TYPE_CHECKING

import numpy as np

from codend.report.style import INK, new_figure
from validation.section import Picture
from validation.stability.judge import Finding
from validation.stability.maps import Axis, Panel, StabilityMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = {
    Finding.RIGHT: "#0072b2",
    Finding.RESCUED: "#8cc5e3",
    Finding.ANOTHER: "#f0c94c",
    Finding.UNSTABLE: "#b59ad6",
    Finding.FAILED: "#ece7d8",
    Finding.WRONG: "#d55e00",
}
"""Dark to light for readers who see no hues; a wrong answer is marked with a cross as well."""
NAMES = {
    Finding.RIGHT: "right at once",
    Finding.RESCUED: "right after a fall-back",
    Finding.ANOTHER: "another equilibrium",
    Finding.UNSTABLE: "told unstable",
    Finding.FAILED: "honest failure",
    Finding.WRONG: "WRONG ANSWER",
}
DASHES = ("-", (0, (4, 2)), (0, (1, 1.2)))


def picture_of(stability_map: StabilityMap) -> Picture:
    """The panels of a map side by side, with the count of each outcome in the caption."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    panels = stability_map.panels
    rows = 1 if len(panels) <= 3 else 2
    columns = -(-len(panels) // rows)
    figure = new_figure(max(7.5, 1.0 + 3.7 * columns), 1.4 + 3.2 * rows)
    grid = figure.subplots(rows, columns, squeeze=False)
    figure.suptitle(stability_map.title, x=0.012, ha="left", color=INK, fontsize=13)
    for number, panel in enumerate(panels):
        axes = grid[number // columns, number % columns]
        _draw(axes, panel)
        if number % columns == 0 or panel.y.label != panels[number - 1].y.label:
            axes.set_ylabel(panel.y.label, color=INK)
    for spare in range(len(panels), rows * columns):
        grid[spare // columns, spare % columns].set_axis_off()
    handles: list = [
        Patch(facecolor=colour, edgecolor=INK, linewidth=0.5, label=_named(stability_map, finding))
        for finding, colour in COLOURS.items()
    ]
    lines = {line.name: dash for panel in panels for line, dash in zip(panel.lines, DASHES, strict=False)}
    handles += [
        Line2D([], [], color="black", linestyle=dash, linewidth=1.8, label=name) for name, dash in lines.items()
    ]
    figure.legend(handles=handles, loc="outside lower left", ncols=4 if columns > 2 else 3, frameon=False, fontsize=9)
    return Picture(stability_map.name, figure, f"{stability_map.question} {counts_text(stability_map)}")


def counts_text(stability_map: StabilityMap) -> str:
    """The number of cells of each kind in words."""
    counts = ", ".join(f"{stability_map.count(finding)} {NAMES[finding]}" for finding in Finding)
    return f"{len(stability_map.cells)} cells: {counts}."


def _named(stability_map: StabilityMap, finding: Finding) -> str:
    return NAMES[finding] if stability_map.count(finding) else f"{NAMES[finding]} (none)"


def _draw(axes: "Axes", panel: Panel) -> None:
    from matplotlib.colors import ListedColormap

    order = list(COLOURS)
    kinds = np.array([[order.index(cell.judgement.finding) for cell in row] for row in panel.cells])
    colours = ListedColormap(list(COLOURS.values()))
    axes.pcolormesh(kinds, cmap=colours, vmin=-0.5, vmax=len(order) - 0.5, edgecolors="white", linewidth=0.8)
    for y, x in np.argwhere(kinds == order.index(Finding.WRONG)):
        axes.plot(x + 0.5, y + 0.5, "x", color="black", markersize=6, markeredgewidth=2)
    for line, dash in zip(panel.lines, DASHES, strict=False):
        x, y = _placed(panel.x, line.x), _placed(panel.y, line.y)
        for colour, width in (("white", 4.0), ("black", 1.8)):
            axes.plot(x, y, color=colour, linewidth=width, linestyle=dash if colour == "black" else "-")
    axes.set_xlim(0, len(panel.x.values))
    axes.set_ylim(0, len(panel.y.values))
    for axis, values, most in ((axes.xaxis, panel.x, 8), (axes.yaxis, panel.y, 14)):
        count = len(values.values)
        shown = range(0, count, -(-count // most))
        axis.set_ticks([place + 0.5 for place in shown], [values.name(place) for place in shown])
    axes.tick_params(colors=INK, length=2, labelsize=8.5)
    axes.spines[:].set_visible(False)
    axes.set_title(panel.title, loc="left", fontsize=10, color=INK)
    axes.set_xlabel(panel.x.label, color=INK)


def _placed(axis: Axis, values: np.ndarray) -> np.ndarray:
    """Where values lie on an axis whose cells are all one wide: in the logarithm between the centres of two cells."""
    known, at = np.log(np.array(axis.values)), np.arange(len(axis.values)) + 0.5
    wanted = np.log(values)
    inside = np.interp(wanted, known, at)
    first, last = (known[1] - known[0]), (known[-1] - known[-2])
    inside = np.where(wanted < known[0], at[0] + (wanted - known[0]) / first, inside)
    return np.where(wanted > known[-1], at[-1] + (wanted - known[-1]) / last, inside)
