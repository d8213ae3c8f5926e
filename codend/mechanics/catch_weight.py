"""The catch's own weight in water, as it presses on the netting: force, tangent and bound, kernels.

A catch denser than the water by d presses with d g (z_f - z) beside what the water does, z_f the height of the middle
of its front. On a facet that is what it is at the middle, times the area vector, so that over closed netting the sum is
d g V downward. The height of the front follows the net: it adds one product to the tangent, -dF/dx = K - u v^T with
u = dF/dz_f and v = dz_f/dx at given shares.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.images import add_turned_back
from codend.mechanics.pressure import Catch, area_vector, corners_of_facet, side_across, take_from_facet_blocks
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats


@njit(cache=True)
def foremost(share: Floats) -> int:
    """First band that the catch reaches; the number of bands if it reaches none."""
    for band in range(len(share)):
        if share[band] > 0.0:
            return band
    return len(share)


@njit(cache=True)
def ring_height(position: Floats, catch: Catch, row: int) -> float:
    """Height of the middle of a row's ring of nodes, m."""
    height, rows = 0.0, catch.node_row
    for node in range(len(rows)):
        if rows[node] == row:
            height += position[node, 2]
    return height / catch.row_size[row]


@njit(cache=True)
def front_height(position: Floats, catch: Catch, share: Floats) -> float:
    """Height z_f of the middle of the front, m: between the middles of the two rings of its band, as its lid is."""
    band = foremost(share)
    if band == len(share):
        return 0.0
    fore, aft = ring_height(position, catch, band), ring_height(position, catch, band + 1)
    return aft + share[band] * (fore - aft)


@njit(cache=True)
def add_force(position: Floats, structure: Structure, catch: Catch, share: Floats, force: Floats) -> None:
    """Add what the catch's weight presses with on every facet to the nodal forces, a third to each corner."""
    if catch.weight_density != 0.0:
        add_force_below(position, structure, catch, share, front_height(position, catch, share), force)


@njit(cache=True)
def add_force_below(
    position: Floats, structure: Structure, catch: Catch, share: Floats, height: float, force: Floats
) -> None:
    """Add the same force with the middle of the front at a given height."""
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = catch.facet_band, structure.facet_weight
    for facet in range(len(bands)):
        filled = share[bands[facet]] * weights[facet] * catch.weight_density
        if filled == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        x, y, z = area_vector(corners)
        third = filled * (height - (corners[2] + corners[5] + corners[8]) / 3.0) / 3.0
        for corner in range(3):
            add_turned_back(
                force, facets[facet, corner], third * x, third * y, third * z, images[facet, corner], rotations
            )


@njit(cache=True)
def force_by_height(position: Floats, structure: Structure, catch: Catch, share: Floats, force: Floats) -> None:
    """Write the derivative of that force by the height of the front, N/m, (n, 3)."""
    force[:] = 0.0
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = catch.facet_band, structure.facet_weight
    for facet in range(len(bands)):
        third = share[bands[facet]] * weights[facet] * catch.weight_density / 3.0
        if third == 0.0:
            continue
        x, y, z = area_vector(corners_of_facet(position, facets, images, rotations, facet))
        for corner in range(3):
            add_turned_back(
                force, facets[facet, corner], third * x, third * y, third * z, images[facet, corner], rotations
            )


@njit(cache=True)
def height_gradient(catch: Catch, share: Floats, gradient: Floats) -> None:
    """Write the derivative of the front's height by the nodes at given shares, (n, 3)."""
    gradient[:] = 0.0
    band = foremost(share)
    rows, sizes = catch.node_row, catch.row_size
    for node in range(len(rows)):
        if rows[node] == band:
            gradient[node, 2] = share[band] / sizes[band]
        elif rows[node] == band + 1:
            gradient[node, 2] = (1.0 - share[band]) / sizes[band + 1]


@njit(cache=True, error_model="numpy")
def add_tangent(
    position: Floats, structure: Structure, catch: Catch, pattern: Pattern, share: Floats, blocks: Floats
) -> None:
    """Add minus the derivative of the force with the front at the height where it is.

    The load P = k (z_f - z) A changes by k (z_f - z) dA - k A dz, dA = da x (b - c) / 2 for a move of corner a and
    dz = da_z / 3.
    """
    if catch.weight_density == 0.0:
        return
    height = front_height(position, catch, share)
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights, slots = catch.facet_band, structure.facet_weight, pattern.facet_slot
    h = np.empty((3, 3))
    for facet in range(len(bands)):
        third = share[bands[facet]] * weights[facet] * catch.weight_density / 3.0
        if third == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        area = area_vector(corners)
        half = 0.5 * third * (height - (corners[2] + corners[5] + corners[8]) / 3.0)
        for moved in range(3):
            ex, ey, ez = side_across(corners, moved)
            h[0, 0], h[0, 1], h[0, 2] = 0.0, half * ez, -half * ey
            h[1, 0], h[1, 1], h[1, 2] = -half * ez, 0.0, half * ex
            h[2, 0], h[2, 1], h[2, 2] = half * ey, -half * ex, 0.0
            for i in range(3):
                h[i, 2] -= third * area[i] / 3.0
            take_from_facet_blocks(blocks, slots, facet, moved, h, images, rotations)


@njit(cache=True)
def add_bound(position: Floats, structure: Structure, catch: Catch, share: Floats, bound: Floats) -> None:
    """Add a bound on its part of each node's row of the stiffness, N/m: of a facet p perimeter / 6 + 2 k area / 3."""
    if catch.weight_density == 0.0:
        return
    height = front_height(position, catch, share)
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = catch.facet_band, structure.facet_weight
    for facet in range(len(bands)):
        filled = share[bands[facet]] * weights[facet] * abs(catch.weight_density)
        if filled == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        ax, ay, az, bx, by, bz, cx, cy, cz = corners
        x, y, z = area_vector(corners)
        perimeter = (
            np.sqrt((bx - ax) ** 2 + (by - ay) ** 2 + (bz - az) ** 2)
            + np.sqrt((cx - bx) ** 2 + (cy - by) ** 2 + (cz - bz) ** 2)
            + np.sqrt((ax - cx) ** 2 + (ay - cy) ** 2 + (az - cz) ** 2)
        )
        depth = abs(height - (az + bz + cz) / 3.0)
        least = filled * (depth * perimeter / 6.0 + 2.0 / 3.0 * np.sqrt(x * x + y * y + z * z))
        for corner in range(3):
            bound[facets[facet, corner]] += least
