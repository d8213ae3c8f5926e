"""A net: nodes joined by straight bars, covered by facets, held by supports.

A net may stand for one rotational sector of a structure that is the same all round: the end of a bar or the corner of a
facet then names a node and the *image* it sits in, the number of sectors by which that node is turned about the x axis.
A full net is the same thing with one sector and image 0 everywhere.
"""

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Net:
    """Arrays of nodes, bars, facets and corners, and what holds them; SI units, x along the flow, z up."""

    positions: Floats
    """Shape in which the solver starts, (n, 3)."""
    order: float
    """Number of equal sectors all round, 1 for a full net; not whole where one stands for sectors nearly its like."""
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
    bar_diameter: Floats
    """Real diameter of the twine or rope, on which a drag law may depend, (m,)."""
    bar_drag_law: Ints
    """Law of its drag, a place in ``drag_laws.DRAG_LAWS``, (m,)."""
    bar_normal_drag: Floats
    """First coefficient of that law, (m,)."""
    bar_tangential_drag: Floats
    """Second coefficient, (m,)."""
    bar_is_rope: NDArray[np.bool_]
    """Whether a bar is a rope, which meets the flow with its own length however slack it hangs, (m,)."""
    bar_is_strut: NDArray[np.bool_]
    """Whether a bar resists being shortened as it does being stretched; else it goes slack, (m,)."""

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

    point_node: Ints
    """Node of a point: a weight, a float, a door, (p,)."""
    point_mass: Floats
    """kg, (p,)."""
    point_wet_weight: Floats
    """Weight in water, downward, N, (p,)."""
    point_drag_area: Floats
    """Drag area Cd A, m2, (p,)."""
    point_lift_area: Floats
    """Lift area Cl A, m2, (p,)."""
    point_lift_towards: Floats
    """Direction of its lift, of which the part across the flow counts, (p, 3)."""

    wrap_node: Ints = field(default_factory=lambda: np.zeros((0, 1), dtype=np.int32))
    """Nodes of the cells over which other netting lies, see ``mechanics.wrap``, (w, k)."""
    wrap_image: Ints = field(default_factory=lambda: np.zeros((0, 1), dtype=np.int32))
    """Images of those nodes, (w, k)."""
    wrap_weight: Floats = field(default_factory=lambda: np.zeros((0, 2, 1)))
    """What each counts in the base and in the height of its cell, (w, 2, k)."""
    wrap_law: Floats = field(default_factory=lambda: np.zeros((0, 8)))
    """What that netting is made of, (w, 8)."""

    @property
    def sectors(self) -> int:
        """Equal sectors that are set side by side to show it all round."""
        return round(self.order)

    @classmethod
    def from_bars(
        cls,
        positions: ArrayLike,
        bars: ArrayLike,
        held: ArrayLike,
        *,
        length_m: ArrayLike | None = None,
        stiffness_n: ArrayLike = np.inf,
        diameter_m: ArrayLike = 0.0,
        density_kg_m3: ArrayLike = np.nan,
        drag: tuple[int, float, float] = (0, 0.0, 0.0),
        is_rope: bool = False,
        is_strut: ArrayLike = False,
        facets: ArrayLike | None = None,
    ) -> "Net":
        """A net from its nodes and bars; numbers that hold for all bars may be given once.

        Args:
            positions: nodes in the shape in which a solver starts, (n, 3), m.
            bars: first and second node of every bar, (m, 2).
            held: nodes that are held, (n,), or coordinates of them, (n, 3).
            length_m: lengths without load, (m,); as in ``positions`` by default.
            stiffness_n: EA; inextensible by default.
            diameter_m: of the round bars, for drag, mass and weight; none of these by default.
            density_kg_m3: of their material; that of the water by default.
            drag: law and coefficients, as ``drag_laws.drag`` gives them; no drag by default.
            is_rope: see ``bar_is_rope``.
            is_strut: see ``bar_is_strut``; none by default.
            facets: corners of triangles, seen anticlockwise from outside, (f, 3); none by default.

        Raises:
            ValueError: a node that is named is none, or a number is out of range.
        """
        nodes = np.array(positions, dtype=float).reshape(-1, 3)
        ends = np.array(bars, dtype=np.int32).reshape(-1, 2)
        corners = np.zeros((0, 3), dtype=np.int32) if facets is None else np.array(facets, dtype=np.int32)
        named = np.concatenate([ends.ravel(), corners.ravel()])
        if len(named) and not 0 <= named.min() <= named.max() < len(nodes):
            raise ValueError(f"bars and facets join nodes 0 to {len(nodes) - 1}, not {named.min()} to {named.max()}")
        fixed = np.array(held, dtype=bool)
        if fixed.shape not in ((len(nodes),), (len(nodes), 3)):
            raise ValueError(f"held must be given for {len(nodes)} nodes, or their three coordinates")

        def of_bars(value: ArrayLike, kind: type = float) -> NDArray:
            return np.array(np.broadcast_to(np.asarray(value, dtype=kind), (len(ends),)))

        apart = np.linalg.norm(nodes[ends[:, 1]] - nodes[ends[:, 0]], axis=1)
        length = of_bars(apart if length_m is None else length_m)
        stiffness, diameter = of_bars(stiffness_n), of_bars(diameter_m)
        if not (np.all(length > 0.0) and np.all(stiffness > 0.0) and np.all(diameter >= 0.0)):
            raise ValueError("lengths and stiffnesses must be above 0, diameters not below")
        law, normal, tangential = drag
        return cls(
            positions=nodes,
            order=1,
            fixed=np.array(np.broadcast_to(fixed.reshape(len(nodes), -1), (len(nodes), 3))),
            bars=ends,
            bar_image=of_bars(0, np.int32),
            bar_length=length,
            bar_flexibility=1.0 / stiffness,
            bar_drag_diameter=diameter,
            bar_solid_diameter=diameter,
            bar_density=of_bars(density_kg_m3),
            bar_diameter=diameter,
            bar_drag_law=of_bars(law, np.int32),
            bar_normal_drag=of_bars(normal),
            bar_tangential_drag=of_bars(tangential),
            bar_is_rope=of_bars(is_rope, bool),
            bar_is_strut=of_bars(is_strut, bool),
            facets=corners,
            facet_image=np.zeros_like(corners),
            facet_weight=np.ones(len(corners)),
            **NO_CORNERS,
            **NO_POINTS,
        )


NO_CORNERS: dict[str, Any] = {
    "corners": np.zeros((0, 3), dtype=np.int32),
    "corner_image": np.zeros((0, 3), dtype=np.int32),
    "corner_stiffness": np.zeros(0),
    "corner_rest": np.zeros(0),
}
NO_POINTS: dict[str, Any] = {
    "point_node": np.zeros(0, dtype=np.int32),
    "point_mass": np.zeros(0),
    "point_wet_weight": np.zeros(0),
    "point_drag_area": np.zeros(0),
    "point_lift_area": np.zeros(0),
    "point_lift_towards": np.zeros((0, 3)),
}
BAR_ARRAYS = [own.name for own in fields(Net) if own.name.startswith("bar")]
"""Fields of a net that have a row a bar."""


def rotate(points: Floats, image: ArrayLike, order: float) -> Floats:
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


def with_bars(net: Net, bars: Ints, image: NDArray[np.integer] | int, **values: ArrayLike) -> Net:
    """The net with more bars after its own: their ends (b, 2), images, and other fields of bars, 0 where left out."""
    given = {"bar_image": image, **values}

    def extended(name: str) -> NDArray:
        own = getattr(net, name)
        return np.append(own, np.broadcast_to(np.asarray(given.get(name, 0), dtype=own.dtype), len(bars)))

    others: dict[str, Any] = {name: extended(name) for name in BAR_ARRAYS if name != "bars"}
    return replace(net, bars=np.concatenate([net.bars, bars.astype(np.int32)]), **others)


def with_held_node(net: Net, position: Floats) -> Net:
    """The net with one more node, held at a position (3,), behind all others."""
    return replace(
        net,
        positions=np.concatenate([net.positions, position[None]]),
        fixed=np.concatenate([net.fixed, np.ones((1, 3), dtype=bool)]),
    )


def with_point(
    net: Net,
    node: int,
    *,
    mass_kg: float = 0.0,
    wet_weight_n: float = 0.0,
    drag_area_m2: float = 0.0,
    lift_area_m2: float = 0.0,
    lift_towards: ArrayLike = (0.0, 0.0, 1.0),
) -> Net:
    """The net with a weight, a float or a door at a node; a float has a wet weight below 0."""
    return replace(
        net,
        point_node=np.append(net.point_node, np.int32(node)),
        point_mass=np.append(net.point_mass, mass_kg),
        point_wet_weight=np.append(net.point_wet_weight, wet_weight_n),
        point_drag_area=np.append(net.point_drag_area, drag_area_m2),
        point_lift_area=np.append(net.point_lift_area, lift_area_m2),
        point_lift_towards=np.concatenate([net.point_lift_towards, np.array([lift_towards], dtype=float)]),
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

    parted: dict[str, Any] = {}
    for name in BAR_ARRAYS:
        values = getattr(net, name)
        parted[name] = np.concatenate([values, values[chosen]])
    parted |= {
        "bars": np.concatenate([first_half, second_half]),
        "bar_image": np.concatenate([first_image, net.bar_image[chosen]]),
        "bar_length": np.concatenate([length, length[chosen]]),
    }
    return replace(
        net,
        positions=np.concatenate([net.positions, middle]),
        fixed=np.concatenate([net.fixed, np.zeros((len(chosen), 3), dtype=bool)]),
        **parted,
    )


def numbered_all_round(net: Net, node: Ints, image: Ints) -> Ints:
    """Nodes of all sectors side by side, sector by sector, (sectors * k, ...), from those of one and their images."""
    sector = np.arange(net.sectors).reshape((-1,) + (1,) * node.ndim)
    turned = (image[None] + sector) % net.sectors
    return (turned * len(net.positions) + node[None]).reshape(-1, *node.shape[1:]).astype(np.int32)
