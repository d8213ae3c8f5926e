"""The longest fish that passes a mesh: closed form for an ellipse in a rhombus, a convex test for everything else.

A mesh is a hole with straight sides, the same on both sides of its centre: strips |n . x| <= d, one for each pair of
opposite sides. A fish's section is convex and as symmetric, so if it passes at all it passes with its centre in the
hole's: moved aside by t and by -t it fits as well, and so does half-way between. It passes when its support h (the
distance from its centre to its tangent) is at most d on every side, and as h grows with the fish's length L, h = L h_1,

    L_max = min over the sides of d / h_1(angle between the side's normal and the fish).

Sides, x along the netting and y across it, phi half the opening angle, b the clear bar and l the knot (derived):

    diamond, knots along (T0)   normals (sin phi, +-cos phi), d = (b cos phi + l/2) sin phi;  (0, 1), d = b sin phi
    T90, knots across           normals (sin phi, +-cos phi), d = (b sin phi + l/2) cos phi;  (1, 0), d = b cos phi
    square                      (1, 0), d = b / 2;  (0, 1), d = half the clear distance between the meridional bars

What a mesh leaves open. Where a plan gives a knot, its bar is the twine between two knots and is clear over its whole
length, so that the stretched inside opening, as a gauge measures it, is the full mesh less one knot, m_i = 2 b + l.
Where it gives none, bars run from crossing to crossing and lose half a twine's width at each end: clear bar
b - w, m_i = 2 (b - w), with w the width of all the bar's twines side by side. Exact for a square of crossing twines.

A mesh that yields. A mesh carries the load P along the netting and Q = P tan(phi) across it. A fish that pushes with
the force F across or along changes tan(phi) = Q / P to (Q + F) / P or Q / (P + F) (derived from the equilibrium of a
rhombus of four bars; the first is ``codend.bag.measures.opening_force``), and it takes the opening in between that
suits it best. Square mesh is taken as rigid, and so is every mesh for F = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_models.fish import FishSection
from codend.plan.kinds import KINDS, HoleShape, MeshName
from codend.selectivity.escape.passage_kernels import (
    FINE,
    IDEALS,
    RECTANGLE,
    RHOMBUS_KNOTS_ACROSS,
    RHOMBUS_KNOTS_ALONG,
    Effort,
    Fish,
    Hole,
    best_opening,
    ideal_openings,
    longest_at,
    sides_of,
)

Floats = NDArray[np.float64]

SHAPES: Final[dict[HoleShape, int]] = {
    "rhombus, knots along": RHOMBUS_KNOTS_ALONG,
    "rhombus, knots across": RHOMBUS_KNOTS_ACROSS,
    "rectangle": RECTANGLE,
}
"""Numbers of the shapes that holes can have."""


@dataclass(frozen=True)
class Holes:
    """Meshes as holes, arrays (k,)."""

    shape: NDArray[np.int64]
    """One of ``SHAPES``."""
    bar_m: Floats
    """Clear length of a bar."""
    knot_m: Floats
    """Length of the knot; 0 for rectangles."""
    half_angle_rad: Floats
    """Half the opening angle; without meaning for rectangles."""
    across_m: Floats
    """Clear distance between the meridional bars of rectangles; without meaning for others."""
    load_n: Floats
    """Load P along the netting that a mesh carries."""

    @classmethod
    def of(
        cls,
        mesh: MeshName,
        bar_m: ArrayLike,
        opening_deg: ArrayLike,
        *,
        knot_m: ArrayLike = 0.0,
        load_n: ArrayLike = 0.0,
    ) -> Holes:
        """Meshes of one kind, the other arguments broadcast; square ones are as wide as their bars are long."""
        bar, opening, knot, load = np.broadcast_arrays(*map(np.atleast_1d, (bar_m, opening_deg, knot_m, load_n)))
        half = np.radians(opening.astype(float)) / 2.0
        shape = np.full(bar.shape, SHAPES[KINDS[mesh].hole])
        return cls(shape, *(a.astype(float) for a in (bar, knot, half, bar, load)))


def longest_through_rhombus(
    inside_mesh_m: ArrayLike, opening_deg: ArrayLike, height_per_length: ArrayLike, width_per_length: ArrayLike
) -> Floats:
    """Longest fish of elliptical section through a rhombus, in the better of its two orientations, m.

    L_max = m_i / sqrt((k_h / cos phi)^2 + (k_w / sin phi)^2), or the same with height and width exchanged; no other
    orientation is better: with the fish turned by theta its support on the two pairs of sides is largest as
    cos(2 |theta| - 2 beta), whose least value in [0, 90] degrees lies at an end. Largest at tan^2(phi) = k_w / k_h.
    Arguments are broadcast.
    """
    half = np.radians(opening_deg) / 2.0
    height, width = np.asarray(height_per_length, dtype=float), np.asarray(width_per_length, dtype=float)
    with np.errstate(divide="ignore"):
        upright = np.hypot(height / np.cos(half), width / np.sin(half))
        lying = np.hypot(width / np.cos(half), height / np.sin(half))
        return np.asarray(np.asarray(inside_mesh_m) / np.minimum(upright, lying))


def longest_fish(
    holes: Holes, section: FishSection, *, rotation_deg: float | None = None, push_force_n: float = 0.0
) -> Floats:
    """Longest fish that passes each mesh, m, (k,).

    Args:
        holes: the meshes.
        section: of a fish of length 1.
        rotation_deg: angle between the fish's height and the netting's axis; None: the best there is.
        push_force_n: largest force with which the fish deforms the mesh.
    """
    fish = Fish(float(section.half_height), float(section.half_width), float(section.exponent))
    rotation = math.nan if rotation_deg is None else math.radians(rotation_deg)
    longest, ideals = np.empty(len(holes.shape)), np.full(IDEALS, np.nan)
    for i in range(len(longest)):
        hole, phi = _hole(holes, i), float(holes.half_angle_rad[i])
        if push_force_n > 0.0:
            ideal_openings(hole, fish, rotation, FINE, ideals)
        phi = best_opening(hole, phi, fish, rotation, Effort(push_force_n, FINE), ideals)
        longest[i] = longest_at(hole, phi, fish, rotation, FINE)
    return longest


def hole_sides(holes: Holes, i: int) -> tuple[Floats, Floats]:
    """Normal angles (3,) and distances (3,) from the centre of the pairs of sides of mesh i; no side: at infinity."""
    sides = sides_of(_hole(holes, i), holes.half_angle_rad[i])
    return np.array(sides[0::2]), np.array(sides[1::2])


def hole_corners(holes: Holes, i: int) -> Floats:
    """Corners of mesh i in metres, x along the netting, anticlockwise, (4 or 6, 2)."""
    b, knot = holes.bar_m[i], holes.knot_m[i]
    along, across = b * math.cos(holes.half_angle_rad[i]), b * math.sin(holes.half_angle_rad[i])
    if holes.shape[i] == RECTANGLE:
        x, y = 0.5 * b, 0.5 * holes.across_m[i]
        quarter = [(x, -y), (x, y)]
    elif knot == 0.0:
        quarter = [(along, 0.0), (0.0, across)]
    elif holes.shape[i] == RHOMBUS_KNOTS_ACROSS:
        quarter = [(along, -0.5 * knot), (along, 0.5 * knot), (0.0, across + 0.5 * knot)]
    else:
        quarter = [(along + 0.5 * knot, 0.0), (0.5 * knot, across), (-0.5 * knot, across)]
    corners = np.array(quarter)
    return np.concatenate([corners, -corners])


def _hole(holes: Holes, i: int) -> Hole:
    of_mesh = (holes.bar_m[i], holes.knot_m[i], holes.across_m[i], holes.load_n[i])
    return Hole(int(holes.shape[i]), *map(float, of_mesh))
