"""Pressure of the catch on the facets: force, tangent and bound, kernels.

How far the catch fills the net is in ``catch_front``.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics.images import add_turned_back, turned
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats, Ints

FILLED_MESHES, FRONT_FROM_CODLINE, VOLUME = range(3)


class Catch(NamedTuple):
    """How the catch fills the net from its last band on, and how it presses."""

    bar_band: Ints
    """Band a bar lies in, (m,)."""
    facet_band: Ints
    """Band a facet lies in, (f,)."""
    band_meshes: Floats
    """Meshes that a band is long, (bands,)."""
    node_row: Ints
    """Row whose ring polygon the node belongs to, -1 for none, (n,)."""
    row_size: Floats
    """Nodes in the ring polygon of each row, (bands + 1,)."""
    kind: int
    """What its size is given by."""
    size: float
    """Filled meshes, distance of the front from the codline in m, or volume in m3."""
    stagnation_pressure: float
    angles: Floats
    """Breaks of the pressure law in theta, rad, (k + 1,)."""
    coefficients: Floats
    """Piecewise cubic net pressure coefficient, (4, k)."""
    weight_density: float = 0.0
    """Weight of the catch in water, N/m3, 0 where none acts; see ``catch_weight``."""


@njit(cache=True)
def corners_of_facet(position: Floats, facets: Ints, images: Ints, rotations: Floats, facet: int) -> tuple[float, ...]:
    """x, y and z of a facet's first, second and third corner, each in its own sector."""
    a, b, c = facets[facet, 0], facets[facet, 1], facets[facet, 2]
    ay, az = turned(position[a, 1], position[a, 2], images[facet, 0], rotations)
    by, bz = turned(position[b, 1], position[b, 2], images[facet, 1], rotations)
    cy, cz = turned(position[c, 1], position[c, 2], images[facet, 2], rotations)
    return position[a, 0], ay, az, position[b, 0], by, bz, position[c, 0], cy, cz


@njit(cache=True)
def area_vector(corners: tuple[float, ...]) -> tuple[float, float, float]:
    """Half the cross product of two edges: points outward, as long as the facet's area."""
    ax, ay, az, bx, by, bz, cx, cy, cz = corners
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    return 0.5 * (uy * vz - uz * vy), 0.5 * (uz * vx - ux * vz), 0.5 * (ux * vy - uy * vx)


@njit(cache=True)
def law_and_slope(x: float, across: float, angles: Floats, coefficients: Floats) -> tuple[float, float]:
    """Net pressure over stagnation pressure, a piecewise cubic in theta, and its derivative, per radian.

    theta is the angle between the upstream direction and an area vector with the parts ``x`` along the flow and
    ``across`` it: from these to round-off, where near the axis a cosine would leave it uncertain by 1e-8.
    """
    theta = np.arctan2(across, -x)
    piece, left = 0, len(angles) - 1
    while left > 1:
        half = left // 2
        if theta >= angles[piece + half]:
            piece += half
        left -= half
    t = theta - angles[piece]
    c3, c2, c1, c0 = coefficients[0, piece], coefficients[1, piece], coefficients[2, piece], coefficients[3, piece]
    return ((c3 * t + c2) * t + c1) * t + c0, (3.0 * c3 * t + 2.0 * c2) * t + c1


@njit(cache=True)
def is_uniform(angles: Floats, coefficients: Floats) -> bool:
    """Whether a pressure law is one constant."""
    return len(angles) == 2 and coefficients[0, 0] == 0.0 and coefficients[1, 0] == 0.0 and coefficients[2, 0] == 0.0


@njit(cache=True)
def add_force(position: Floats, structure: Structure, catch: Catch, share: Floats, force: Floats) -> None:
    """Add the catch's pressure on every facet to the nodal forces, a third to each corner.

    Facet load = share of the facet within the catch x q (1 - Cp(theta)) x area vector, theta between the upstream
    direction and the outward normal (Le Bris et al. 1999, section 5). Nothing acts at the front, which is open.
    """
    angles, coefficients = catch.angles, catch.coefficients
    uniform = is_uniform(angles, coefficients)
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = catch.facet_band, structure.facet_weight
    third_of_stagnation = catch.stagnation_pressure / 3.0
    for facet in range(len(bands)):
        filled = share[bands[facet]]
        if filled == 0.0:
            continue
        x, y, z = area_vector(corners_of_facet(position, facets, images, rotations, facet))
        if uniform:
            coefficient = coefficients[3, 0]
        else:
            coefficient, _ = law_and_slope(x, np.sqrt(y * y + z * z), angles, coefficients)
        third = filled * weights[facet] * third_of_stagnation * coefficient
        x, y, z = third * x, third * y, third * z
        for corner in range(3):
            add_turned_back(force, facets[facet, corner], x, y, z, images[facet, corner], rotations)


@njit(cache=True)
def side_across(corners: tuple[float, ...], moved: int) -> tuple[float, float, float]:
    """Side e of a facet across from one of its corners, whose move dx changes the area vector by dx x e / 2."""
    ax, ay, az, bx, by, bz, cx, cy, cz = corners
    if moved == 0:
        return bx - cx, by - cy, bz - cz
    if moved == 1:
        return cx - ax, cy - ay, cz - az
    return ax - bx, ay - by, az - bz


@njit(cache=True, error_model="numpy")
def take_from_facet_blocks(
    blocks: Floats, slots: Ints, facet: int, moved: int, h: tuple[float, ...], images: Ints, rotations: Floats
) -> None:
    """Take off the blocks of a facet's three corners whose loads all change by h with the move of one of them.

    ``h`` has its nine entries row by row.
    """
    middle = (rotations.shape[0] - 1) // 2
    xx, xy, xz, yx, yy, yz, zx, zy, zz = h
    image = images[facet, moved]
    if image != 0:
        c, s = rotations[middle + image, 0], rotations[middle + image, 1]
        xy, xz = c * xy + s * xz, c * xz - s * xy
        yy, yz = c * yy + s * yz, c * yz - s * yy
        zy, zz = c * zy + s * zz, c * zz - s * zy
    for corner in range(3):
        block, image = blocks[slots[facet, corner, moved]], images[facet, corner]
        # the turn of a sector on itself is left out
        c, s = (1.0, 0.0) if image == 0 else (rotations[middle + image, 0], rotations[middle + image, 1])
        block[0, 0] -= xx
        block[0, 1] -= xy
        block[0, 2] -= xz
        block[1, 0] -= c * yx + s * zx
        block[1, 1] -= c * yy + s * zy
        block[1, 2] -= c * yz + s * zz
        block[2, 0] -= c * zx - s * yx
        block[2, 1] -= c * zy - s * yy
        block[2, 2] -= c * zz - s * yz


@njit(cache=True, error_model="numpy")
def add_tangent(
    position: Floats, structure: Structure, catch: Catch, pattern: Pattern, share: Floats, blocks: Floats
) -> None:
    """Add the catch's pressure's part; it follows the facets' areas, senses and angles to the flow.

    The load P = k C(theta) A of a facet with area vector A = (a x b + b x c + c x a) / 2 changes by
    dP = k (C I + C' A (dtheta/dA)^T) dA, with dtheta/dA = (e_x - n_x n) / (|A| sin theta), a unit vector over |A|, and
    dA = da x (b - c) / 2 for a move of corner a. On the axis of the flow, where that unit vector has no direction, the
    law's slope counts as 0.
    """
    angles, coefficients = catch.angles, catch.coefficients
    uniform = is_uniform(angles, coefficients)
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights, slots = catch.facet_band, structure.facet_weight, pattern.facet_slot
    stagnation = catch.stagnation_pressure
    for facet in range(len(bands)):
        filled = share[bands[facet]]
        if filled == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        x, y, z = area_vector(corners)
        third = filled * weights[facet] * stagnation / 3.0
        coefficient, sx, sy, sz = coefficients[3, 0], 0.0, 0.0, 0.0
        if not uniform:
            area, across = np.sqrt(x * x + y * y + z * z), np.sqrt(y * y + z * z)
            if area == 0.0:
                continue
            coefficient, slope = law_and_slope(x, across, angles, coefficients)
            if across > 0.0:
                # (e_x - n_x n) / sin theta = (sin theta, -n_x n_y / sin theta, -n_x n_z / sin theta)
                slope *= third / (area * area)
                sx, sy, sz = slope * across, -slope * x * y / across, -slope * x * z / across
        k = third * coefficient
        for moved in range(3):
            ex, ey, ez = side_across(corners, moved)
            ex, ey, ez = 0.5 * ex, 0.5 * ey, 0.5 * ez
            # k I + (x, y, z) (sx, sy, sz)^T times the matrix that turns a move dx into dx x e
            tx, ty, tz = sz * ey - sy * ez, sx * ez - sz * ex, sy * ex - sx * ey
            of_x = x * tx, x * ty + k * ez, x * tz - k * ey
            of_y = y * tx - k * ez, y * ty, y * tz + k * ex
            of_z = z * tx + k * ey, z * ty - k * ex, z * tz
            take_from_facet_blocks(blocks, slots, facet, moved, of_x + of_y + of_z, images, rotations)


@njit(cache=True)
def add_bound(position: Floats, structure: Structure, catch: Catch, share: Floats, bound: Floats) -> None:
    """Add a bound on the pressure's part of each node's row of the stiffness, N/m: p times perimeter / 6 a facet."""
    pressure = catch.stagnation_pressure * np.max(np.abs(catch.coefficients[3]))
    facets, bands, weights, order = structure.facets, catch.facet_band, structure.facet_weight, structure.order
    for facet in range(len(bands)):
        filled = share[bands[facet]]
        if filled == 0.0:
            continue
        perimeter = 0.0
        for corner in range(3):
            a, b = facets[facet, corner], facets[facet, (corner + 1) % 3]
            # images turn both ends alike or by one sector; the axial and radial parts bound the edge well enough
            ra = np.sqrt(position[a, 1] ** 2 + position[a, 2] ** 2)
            rb = np.sqrt(position[b, 1] ** 2 + position[b, 2] ** 2)
            if order > 1.0:
                chord = 2.0 * np.sin(np.pi / order) * max(ra, rb)
            else:
                chord = abs(position[a, 1] - position[b, 1]) + abs(position[a, 2] - position[b, 2])
            perimeter += abs(position[a, 0] - position[b, 0]) + abs(ra - rb) + chord
        least = filled * weights[facet] * pressure * perimeter / 6.0
        for corner in range(3):
            bound[facets[facet, corner]] += least
