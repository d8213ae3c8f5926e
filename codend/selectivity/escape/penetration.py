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

How far a mesh yields to a fish that pushes stands in ``codend.selectivity.escape.yielding``. Square mesh is taken as
rigid, and so is every mesh for a push of 0.
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
    Fish,
    Hole,
    ideal_openings,
    longest_at,
    sides_of,
)
from codend.selectivity.escape.yielding_kernels import Effort, Passing, best_opening

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
    bending_n: Floats
    """24 EI / b^2 of its bars."""
    rest_rad: Floats
    """Half the opening at which bending is at rest."""
    held_across: Floats
    held_along: Floats
    """By how many times the netting around it makes a mesh harder to open, and to close; 1 for a mesh alone."""

    @classmethod
    def of(
        cls,
        mesh: MeshName,
        bar_m: ArrayLike,
        opening_deg: ArrayLike,
        *,
        knot_m: ArrayLike = 0.0,
        load_n: ArrayLike = 0.0,
        bending_n: ArrayLike = 0.0,
        rest_deg: ArrayLike = 0.0,
        held_across: ArrayLike = 1.0,
        held_along: ArrayLike = 1.0,
    ) -> Holes:
        """Meshes of one kind, the other arguments broadcast; square ones are as wide as their bars are long."""
        given = (bar_m, opening_deg, knot_m, load_n, bending_n, rest_deg, held_across, held_along)
        bar, opening, knot, load, bending, rest, *held = (
            a.astype(float) for a in np.broadcast_arrays(*map(np.atleast_1d, given))
        )
        shape = np.full(bar.shape, SHAPES[KINDS[mesh].hole])
        half, rest = np.radians(opening) / 2.0, np.radians(rest) / 2.0
        return cls(shape, bar, knot, half, bar, load, bending, rest, *held)


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
    holes: Holes,
    section: FishSection,
    *,
    rotation_deg: float | None = None,
    push_force_n: float = 0.0,
    push_exponent: float = 0.0,
    push_length_m: float = 0.3,
) -> Floats:
    """Longest fish that passes each mesh, m, (k,).

    Args:
        holes: the meshes.
        section: of a fish of length 1.
        rotation_deg: angle between the fish's height and the netting's axis; None: the best there is.
        push_force_n: largest force with which a fish of ``push_length_m`` deforms the mesh.
        push_exponent: with which that force grows with the fish's length; 0: all push alike.
        push_length_m: see ``push_force_n``.
    """
    fish = Fish(float(section.half_height), float(section.half_width), float(section.exponent))
    rotation = math.nan if rotation_deg is None else math.radians(rotation_deg)
    effort = Effort(float(push_force_n), float(push_exponent), float(push_length_m), FINE)
    passing = Passing(fish, rotation, np.zeros((0, 0)))
    longest, ideals = np.empty(len(holes.shape)), np.full(IDEALS, np.nan)
    for i in range(len(longest)):
        hole, phi = hole_of(holes, i), float(holes.half_angle_rad[i])
        if push_force_n > 0.0:
            ideal_openings(hole, fish, rotation, FINE, ideals)
        phi = best_opening(hole, phi, passing, effort, ideals)
        longest[i] = longest_at(hole, phi, fish, rotation, FINE)
    return longest


def hole_sides(holes: Holes, i: int) -> tuple[Floats, Floats]:
    """Normal angles (3,) and distances (3,) from the centre of the pairs of sides of mesh i; no side: at infinity."""
    sides = sides_of(hole_of(holes, i), holes.half_angle_rad[i])
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


def hole_of(holes: Holes, i: int) -> Hole:
    """Mesh i as the kernels read it."""
    of_mesh = (holes.bar_m[i], holes.knot_m[i], holes.across_m[i], holes.load_n[i])
    yielding = (holes.bending_n[i], holes.rest_rad[i], holes.held_across[i], holes.held_along[i])
    return Hole(int(holes.shape[i]), *map(float, (*of_mesh, *yielding)))
