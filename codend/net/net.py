"""A net: nodes joined by straight bars, covered by facets, held by supports.

A net may stand for one rotational sector of a structure that is the same all round: the end of a bar or the corner of a
facet then names a node and the *image* it sits in, the number of sectors by which that node is turned about the x axis.
A full net is the same thing with one sector and image 0 everywhere.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Net:
    """Arrays of nodes, bars, facets and corners, and what holds them; SI units, x along the flow, z up."""

    positions: Floats
    """Shape in which the solver starts, (n, 3)."""
    order: int
    """Number of equal sectors all round, 1 for a full net."""
    fixed: NDArray[np.bool_]
    """Coordinates that are held, (n, 3)."""

    bars: Ints
    """First and second node of a bar, (m, 2)."""
    bar_image: Ints
    """Image of the second node seen from the first, (m,)."""
    bar_length: Floats
    """Length without load, (m,)."""
    bar_flexibility: Floats
    """Strain per newton 1 / EA, 0 for inextensible bars, (m,)."""
    bar_drag_diameter: Floats
    """Width that meets the flow, 0 for bars that carry no drag, (m,)."""
    bar_solid_diameter: Floats
    """Diameter of the round section of the same volume, (m,)."""
    bar_density: Floats
    """Density of the bar's material in kg/m3, nan where it is as dense as the water, (m,)."""
    bar_is_rope: NDArray[np.bool_]
    """Whether a bar is a rope, which meets the flow with its own length however slack it hangs, (m,)."""

    facets: Ints
    """Corners of the triangles that cover the net, seen anticlockwise from outside, (f, 3)."""
    facet_image: Ints
    """Images of the corners, (f, 3)."""
    facet_weight: Floats
    """1, or 1/2 where a quadrangle is covered by both of its divisions into two triangles, (f,)."""

    corners: Ints
    """Middle, first and second node of the corners between two twines at a knot that resist opening, (c, 3)."""
    corner_image: Ints
    """Images of those nodes, (c, 3)."""
    corner_stiffness: Floats
    """Moment per radian of each of the two twines of a corner, N m, (c,)."""
    corner_rest: Floats
    """Angle between the two twines at rest, rad, (c,)."""


def rotate(points: Floats, image: NDArray[np.integer] | int, order: int) -> Floats:
    """Turn points (..., 3) about the x axis by ``image`` sectors of a net with ``order`` sectors all round."""
    angle = 2.0 * np.pi * np.asarray(image) / order
    cosine, sine = np.cos(angle), np.sin(angle)
    y, z = points[..., 1], points[..., 2]
    return np.stack([points[..., 0] + 0.0 * angle, cosine * y - sine * z, sine * y + cosine * z], axis=-1)


def bar_vectors(net: Net, positions: Floats) -> Floats:
    """Vectors from the first to the second end of every bar, (m, 3), in metres."""
    second = rotate(positions[net.bars[:, 1]], net.bar_image, net.order)
    return second - positions[net.bars[:, 0]]


def facet_corners(net: Net, positions: Floats) -> Floats:
    """Corner positions of every facet, (f, 3, 3): facet, corner, coordinate."""
    return rotate(positions[net.facets], net.facet_image, net.order)


def with_bars(
    net: Net,
    bars: Ints,
    image: NDArray[np.integer] | int,
    *,
    length: float,
    flexibility: float,
    drag_diameter: float,
    solid_diameter: float,
    density: float,
    is_rope: bool,
) -> Net:
    """The net with more bars after its own, all alike: their ends (b, 2) and images, and the rest as in ``Net``."""

    def extended(values: np.ndarray, value: float | NDArray[np.integer]) -> np.ndarray:
        return np.append(values, np.broadcast_to(np.asarray(value, dtype=values.dtype), len(bars)))

    return replace(
        net,
        bars=np.concatenate([net.bars, bars.astype(np.int32)]),
        bar_image=extended(net.bar_image, image),
        bar_length=extended(net.bar_length, length),
        bar_flexibility=extended(net.bar_flexibility, flexibility),
        bar_drag_diameter=extended(net.bar_drag_diameter, drag_diameter),
        bar_solid_diameter=extended(net.bar_solid_diameter, solid_diameter),
        bar_density=extended(net.bar_density, density),
        bar_is_rope=extended(net.bar_is_rope, is_rope),
    )


def split_bars(net: Net, which: NDArray[np.bool_]) -> Net:
    """The same net with a hinge in the middle of the bars marked in ``which`` (Le Bris et al. 1999, figure 1).

    The hinges come after the other nodes; the halves keep the bar's direction, the first half in the bar's old place.
    """
    chosen = np.flatnonzero(which)
    hinge = np.arange(len(net.positions), len(net.positions) + len(chosen), dtype=np.int32)
    middle = net.positions[net.bars[chosen, 0]] + 0.5 * bar_vectors(net, net.positions)[chosen]
    first_half = net.bars.copy()
    first_half[chosen, 1] = hinge
    first_image = net.bar_image.copy()
    first_image[chosen] = 0
    second_half = np.stack([hinge, net.bars[chosen, 1]], axis=1)
    length = net.bar_length.copy()
    length[chosen] *= 0.5

    def extended(values: NDArray) -> NDArray:
        return np.concatenate([values, values[chosen]])

    return replace(
        net,
        positions=np.concatenate([net.positions, middle]),
        fixed=np.concatenate([net.fixed, np.zeros((len(chosen), 3), dtype=bool)]),
        bars=np.concatenate([first_half, second_half]),
        bar_image=np.concatenate([first_image, net.bar_image[chosen]]),
        bar_length=extended(length),
        bar_flexibility=extended(net.bar_flexibility),
        bar_drag_diameter=extended(net.bar_drag_diameter),
        bar_solid_diameter=extended(net.bar_solid_diameter),
        bar_density=extended(net.bar_density),
        bar_is_rope=extended(net.bar_is_rope),
    )


def numbered_all_round(net: Net, node: Ints, image: Ints) -> Ints:
    """Nodes of all sectors set side by side, sector by sector, (order * k, ...), from those of one and their images."""
    sector = np.arange(net.order).reshape((-1,) + (1,) * node.ndim)
    turned = (image[None] + sector) % net.order
    return (turned * len(net.positions) + node[None]).reshape(-1, *node.shape[1:]).astype(np.int32)
