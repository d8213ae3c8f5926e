"""A net: nodes joined by straight bars, covered by facets, held by supports. Knows nothing about codends.

A net may stand for one rotational sector of a structure that is the same all round: the end of a bar, the corner of a
facet or of a mesh then names a node and the *image* it sits in, the number of sectors by which that node is turned
about the x axis. A full net is the same thing with one sector and image 0 everywhere.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Net:
    """Arrays of nodes, bars, facets and meshes, and what holds them; SI units throughout.

    x points aft along the flow, y sideways, z up. Rows count rings of nodes from the entry, row 0, to the codline; band
    j is the netting between rows j and j + 1.
    """

    positions: Floats
    """Shape in which the solver starts, (n, 3)."""
    order: int
    """Number of equal sectors all round, 1 for a full net."""
    fixed: NDArray[np.bool_]
    """Coordinates that are held, (n, 3)."""
    node_row: Ints
    """Row whose ring polygon the node belongs to, -1 for a node between two rings, (n,)."""

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
    bar_band: Ints
    """Band a bar lies in, (m,)."""

    facets: Ints
    """Corners of the triangles that cover the net, seen anticlockwise from outside, (f, 3)."""
    facet_image: Ints
    """Images of the corners, (f, 3)."""
    facet_weight: Floats
    """1, or 1/2 where a quadrangle is covered by both of its divisions into two triangles, (f,)."""
    facet_band: Ints
    """Band a facet lies in, (f,)."""

    mesh_sides: Ints
    """First and second node of the four twine sides of a mesh, walking round it: fore to right, right to aft, aft to
    left, left to fore, (k, 4, 2)."""
    mesh_side_image: Ints
    """Images of those nodes, (k, 4, 2)."""
    mesh_bars: Ints
    """Bars of those sides, -1 where a side is held and no bar, (k, 4)."""
    mesh_row: Ints
    """Row that counts a mesh, at its widest part or, of a square mesh, ahead of it, (k,)."""
    band_meshes: Floats
    """Meshes that a band is long, (bands,)."""

    corners: Ints
    """Middle, first and second node of the corners between two twines at a knot that resist opening, (c, 3)."""
    corner_image: Ints
    """Images of those nodes, (c, 3)."""
    corner_stiffness: Floats
    """Moment per radian of each of the two twines of a corner, N m, (c,)."""
    corner_rest: Floats
    """Angle between the two twines at rest, rad, (c,)."""

    globalisation: int = 1
    """Real meshes merged into one, each way."""
    straps: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    """Bars that are ropes round the netting, (s,)."""
    strap_share: Floats = field(default_factory=lambda: np.zeros(0))
    """Tension of the real rope over that of its bar, (s,)."""

    @property
    def bands(self) -> int:
        """Number of bands of netting from the entry to the codline."""
        return len(self.band_meshes)

    @property
    def row_place(self) -> Floats:
        """Place of every row of knots, in meshes from the entry, (bands + 1,)."""
        return np.concatenate([[0.0], np.cumsum(self.band_meshes)])

    @property
    def square_mesh(self) -> NDArray[np.bool_]:
        """Whether a band is of square mesh, which is a whole mesh long: its meshes lie in it, (bands,)."""
        return self.band_meshes == self.globalisation

    @property
    def of_square_mesh(self) -> NDArray[np.bool_]:
        """Whether a mesh is square, (k,)."""
        return np.append(self.square_mesh, False)[self.mesh_row]

    @property
    def mesh_place(self) -> Floats:
        """Middle of the meshes that a row counts, in meshes from the entry, (bands + 1,)."""
        behind = np.append(0.5 * self.band_meshes * self.square_mesh, 0.0)
        return self.row_place + behind


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


def mesh_corners(net: Net, positions: Floats) -> Floats:
    """End positions of the four sides of every mesh, (k, 4, 2, 3): mesh, side, end, coordinate."""
    return rotate(positions[net.mesh_sides], net.mesh_side_image, net.order)


def twine_bars(net: Net) -> NDArray[np.bool_]:
    """Whether a bar is twine of the netting: no knot and no strap, (m,)."""
    twine = net.bar_drag_diameter > 0.0
    twine[net.straps] = False
    return twine


def real_tensions(net: Net, bar_tension: Floats) -> Floats:
    """Tension of the real bars and ropes that the bars of a net stand for, N, (m,)."""
    real = bar_tension / net.globalisation
    real[net.straps] = net.strap_share * bar_tension[net.straps]
    return real


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
    band: int,
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
        bar_band=extended(net.bar_band, band),
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
        node_row=np.concatenate([net.node_row, np.full(len(chosen), -1, dtype=np.int32)]),
        bars=np.concatenate([first_half, second_half]),
        bar_image=np.concatenate([first_image, net.bar_image[chosen]]),
        bar_length=extended(length),
        bar_flexibility=extended(net.bar_flexibility),
        bar_drag_diameter=extended(net.bar_drag_diameter),
        bar_solid_diameter=extended(net.bar_solid_diameter),
        bar_density=extended(net.bar_density),
        bar_band=extended(net.bar_band),
    )


@dataclass(frozen=True)
class WholeNet:
    """The sectors of a net set side by side all round: for pictures, files and sums over the whole net."""

    positions: Floats
    """All nodes, (order * n, 3); nodes on the axis occur once a sector."""
    bars: Ints
    """(order * m, 2); bar i of sector s is number s * m + i."""
    meshes: Ints
    """Ends of the four sides of a mesh, (order * k, 8), walking round it; corners may repeat."""


def all_round(net: Net, positions: Floats) -> WholeNet:
    """Repeat one sector all round; per-bar and per-mesh values are repeated with ``numpy.tile(values, net.order)``."""
    sector = np.arange(net.order)
    nodes = len(positions)
    whole = rotate(np.broadcast_to(positions, (net.order, nodes, 3)), sector[:, None], net.order)

    def numbered(node: Ints, image: Ints) -> Ints:
        turned = (image[None] + sector.reshape((-1,) + (1,) * node.ndim)) % net.order
        return (turned * nodes + node[None]).reshape(-1, *node.shape[1:]).astype(np.int32)

    bar_images = np.stack([np.zeros_like(net.bar_image), net.bar_image], axis=1)
    return WholeNet(
        positions=whole.reshape(-1, 3),
        bars=numbered(net.bars, bar_images),
        meshes=numbered(net.mesh_sides, net.mesh_side_image).reshape(-1, 8),
    )
