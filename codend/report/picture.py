"""A picture of the whole net in its current, every mesh coloured by its opening.

The net is projected along parallel rays and drawn as flat polygons from the farthest to the nearest, which for tens
of thousands of meshes is faster and cleaner than a general 3-D plot.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag, WholeBag, all_round
from codend.net.net import Floats
from codend.report.layer_lines import layer_lines
from codend.report.polygons import joined_on_axis, mesh_polygons
from codend.report.style import INK, new_figure, number_text
from codend.studies.case_result import CaseResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TURN_DEG = 24.0
"""Angle by which the onlooker stands upstream of abeam, so that the entry is seen into."""
RISE_DEG = 14.0
"""Angle by which the onlooker looks down."""
WIDTH_IN, BAR_IN = 12.0, 0.75
"""Width of the picture, and room below the net for the bar of colours and its numbers."""
STRAP_WIDTH = 3.2
"""Width of the line of a strap, which is a thick rope; other rings are thinner."""
LAYER_WIDTH = 0.6
"""Width of the bars of a second layer."""
NEAR_OPACITY, FAR_OPACITY = 0.72, 0.38
"""Of netting ahead of the catch, on the near and on the far side; netting on the catch hides what is behind."""


def net_picture(result: CaseResult) -> "Figure":
    """The net of a solved case in perspective-free view from upstream, abeam and a little above.

    Raises:
        ValueError: the case was not solved.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    if result.meshes is None:
        raise ValueError(f"case {result.case.number} was not solved: there is no shape to draw")
    sectors = all_round(result.bag, result.positions)
    whole = joined_on_axis(sectors)
    flat = whole.positions @ _screen_axes()
    span = np.ptp(flat[:, :2], axis=0)
    height_in = float(np.clip(WIDTH_IN * 0.9 * span[1] / span[0] + 0.9, 3.0, 9.0))
    # placed by hand: to find the same places by measuring all texts takes a fifth of the picture's time
    figure = new_figure(WIDTH_IN, height_in, layout=None)
    below = BAR_IN / height_in
    axes = figure.add_axes((0.005, below, 0.99, 0.995 - below))
    axes.set_aspect("equal")
    axes.set_axis_off()

    most = 10.0 * np.ceil(np.nanmax(result.meshes.opening_deg) / 10.0)
    colours = ScalarMappable(Normalize(0.0, most), colormaps["viridis"])
    opening = np.tile(result.meshes.opening_deg, result.net.sectors)
    in_catch = np.tile(result.meshes.pressure_pa > 0.0, result.net.sectors)
    front = result.solution.front_row
    entry_ring, front_ring, *straps = (
        _ring(result, sectors, row) @ _screen_axes() for row in (0, round(front), *_strap_rows(result.bag))
    )
    _draw_meshes(axes, whole, flat, colours.to_rgba(opening), in_catch, front_ring)
    _draw_layers(axes, layer_lines(result.bag, result.positions) @ _screen_axes())
    axes.plot(entry_ring[:, 0], entry_ring[:, 1], color=INK, linewidth=1.8)
    _draw_ring(axes, front_ring, 1.8)
    for ring in straps:
        _draw_ring(axes, ring, STRAP_WIDTH)
    _label(axes, flat, entry_ring, front_ring, result)
    if straps:
        _label_straps(axes, flat, straps)

    place = figure.add_axes((0.3, 0.6 * below, 0.4, 0.01 * WIDTH_IN / height_in))
    bar = figure.colorbar(colours, cax=place, orientation="horizontal")
    bar.set_label("mesh opening angle (degrees)")
    bar.outline.set_visible(False)
    return figure


def _screen_axes() -> Floats:
    """Columns: to the right on the screen, along which the net's axis is seen, upwards, and to the onlooker, (3, 3)."""
    turn, rise = np.radians(TURN_DEG), np.radians(RISE_DEG)
    towards = np.array([-np.sin(turn) * np.cos(rise), -np.cos(turn) * np.cos(rise), np.sin(rise)])
    right = np.array([1.0, 0.0, 0.0]) - towards[0] * towards
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), towards], axis=1)


def _draw_meshes(
    axes: "Axes", whole: WholeBag, flat: Floats, colour: Floats, in_catch: NDArray[np.bool_], front_ring: Floats
) -> None:
    """Add the meshes to the axes, the farthest first, shaded by how they face a light above the onlooker's shoulder.

    Netting on the catch hides what is behind, so its far side is drawn only where one looks in through the front.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.path import Path

    light = np.array([-0.35, 0.65, 0.67])
    outlines, middles, facing, lit, numbers = [], [], [], [], []
    polygons = mesh_polygons(whole)
    most = max(corners.shape[1] for _, corners in polygons)
    for which, corners in polygons:
        points = flat[corners]
        # Newell: twice the polygon's area vector, outward as meshes are walked anticlockwise seen from outside
        area = np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)
        with np.errstate(invalid="ignore"):
            normal = np.nan_to_num(area / np.linalg.norm(area, axis=1, keepdims=True))
        # as many corners each, the last repeated: one array is drawn many times as fast as a list of polygons
        outlines.append(np.pad(points[:, :, :2], ((0, 0), (0, most - corners.shape[1]), (0, 0)), mode="edge"))
        middles.append(points.mean(axis=1))
        facing.append(normal[:, 2])
        lit.append(np.abs(normal @ light))
        numbers.append(which)
    number, middle = np.concatenate(numbers), np.concatenate(middles)
    near = np.concatenate(facing) > 0.0
    shade = 0.62 + 0.38 * np.concatenate(lit)
    face = colour[number].copy()
    face[:, :3] *= np.where(near, shade, 0.8 * shade)[:, None]
    face[:, 3] = np.where(in_catch[number], 1.0, np.where(near, NEAR_OPACITY, FAR_OPACITY))
    edge = face.copy()
    edge[:, :3] *= 0.45
    order = np.argsort(middle[:, 2], kind="stable")
    thin = float(np.clip(40.0 / np.sqrt(len(order)), 0.12, 0.6))
    wider_front = front_ring[:, :2] + 0.1 * (front_ring[:, :2] - front_ring[:-1, :2].mean(axis=0))
    seen = near | ~in_catch[number] | Path(wider_front).contains_points(middle[:, :2])
    order = order[seen[order]]
    drawn = PolyCollection(
        np.concatenate(outlines)[order],
        facecolors=face[order],
        edgecolors=edge[order],
        linewidths=thin,
        zorder=2,
    )
    axes.add_collection(drawn, autolim=False)


def _draw_layers(axes: "Axes", bars: Floats) -> None:
    """Second layers over the meshes: the bars on the near side, (k, 2, 3)."""
    from matplotlib.collections import LineCollection

    axis = (np.eye(3) @ _screen_axes())[0]
    # nearer than the axis at the same distance along it
    near = bars.mean(axis=1) @ (np.array([0.0, 0.0, 1.0]) - axis[2] * axis) > 0.0
    axes.add_collection(LineCollection(list(bars[near, :, :2]), colors=INK, linewidths=LAYER_WIDTH, zorder=2.5))


def _ring(result: CaseResult, sectors: WholeBag, row: int) -> Floats:
    """Nodes of a row of knots in order round the axis, the first one again at the end, (k + 1, 3)."""
    ring = sectors.positions[np.tile(result.bag.node_row, result.net.sectors) == row]
    y, z = ring[:, 1] - ring[:, 1].mean(), ring[:, 2] - ring[:, 2].mean()
    return ring[np.append(order := np.argsort(np.arctan2(z, y)), order[0])]


def _strap_rows(bag: Bag) -> list[int]:
    """Rows of knots that have a strap, from the entry."""
    return sorted(set(bag.node_row[bag.net.bars[bag.straps, 0]].tolist()))


def _draw_ring(axes: "Axes", ring: Floats, width: float) -> None:
    """The near half of a ring on the netting as a line of that width, the half behind the netting in dashes."""
    near = ring[:, 2] >= ring[:-1, 2].mean()
    for which, style in ((near, "-"), (~near, (0, (4, 3)))):
        x, y = (np.where(which, ring[:, i], np.nan) for i in (0, 1))
        axes.plot(x, y, color=INK, linestyle=style, linewidth=width if style == "-" else 1.0)


def _label(axes: "Axes", flat: Floats, entry_ring: Floats, front_ring: Floats, result: CaseResult) -> None:
    """Name entry, front and codline, and show the flow."""
    low, high = flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)
    size = high - low
    for ring, name in ((entry_ring, "entry"), (front_ring, "front of the catch")):
        x, y = ring[np.argmax(ring[:, 1]), :2]
        rise = 0.10 if ring is entry_ring else 0.16
        axes.annotate(
            name,
            (x, y),
            (x - 0.01 * size[0], y + rise * size[1]),
            ha="center" if ring is entry_ring else "right",
            va="bottom",
            arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.8, "shrinkB": 1},
        )
    axes.text(high[0] + 0.012 * size[0], flat[np.argmax(flat[:, 0]), 1], "codline", ha="left", va="center")
    start = low[0] - 0.15 * size[0], entry_ring[:-1, 1].mean()
    axes.annotate(
        "",
        (start[0] + 0.12 * size[0], start[1]),
        start,
        arrowprops={"arrowstyle": "-|>,head_width=0.5,head_length=0.9", "color": INK, "linewidth": 2.2},
    )
    speed = f"{number_text(result.case.speed_m_s)} m/s"
    axes.text(start[0] + 0.05 * size[0], start[1] + 0.05 * size[1], speed, ha="center", va="bottom")
    axes.text(start[0] + 0.05 * size[0], start[1] - 0.05 * size[1], "flow", ha="center", va="top")
    axes.set_xlim(start[0], high[0] + 0.09 * size[0])
    top = max(high[1] + 0.03 * size[1], front_ring[:, 1].max() + 0.27 * size[1], entry_ring[:, 1].max() + 0.2 * size[1])
    axes.set_ylim(low[1] - 0.03 * size[1], top)


def _label_straps(axes: "Axes", flat: Floats, straps: list[Floats]) -> None:
    """Name the straps at the first of them, below the net, and make room for that."""
    height = np.ptp(flat[:, 1])
    x, y = straps[0][np.argmin(straps[0][:, 1]), :2]
    below = flat[:, 1].min() - 0.05 * height
    axes.annotate(
        "strap" if len(straps) == 1 else "straps",
        (x, y),
        (x, below),
        ha="center",
        va="top",
        arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.8, "shrinkB": 1},
    )
    axes.set_ylim(bottom=below - 0.11 * height)
