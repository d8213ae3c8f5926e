"""The catch's own weight in water, as it presses on the netting: force, tangent and bound, kernels.

A catch denser than the water by d presses with d g (z_f - z) beside what the water does, z_f the height of the middle
of its front. On a facet that is what it is at the middle, times the area vector, so that over closed netting the sum is
d g V downward. Netting that is open at a front which is neither level nor a vertical plane lacks what would press on a
lid there; nothing but the net bears a catch, so the rings at the front bear that, c = -d g V e_z less the sum over the
netting, evenly: whatever its shape the catch weighs d g V and pushes to no side.

The height of the front and c follow the net: each adds a product to the tangent, -dF/dx = K - u v^T, with u = dF/dz_f
and v = dz_f/dx, and with u the share of a ring's node in a part of c and v its derivative, all at given shares.
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
def ring_middle(position: Floats, catch: Catch, row: int, i: int) -> float:
    """Coordinate i of the middle of a row's ring of nodes, m."""
    middle, rows = 0.0, catch.node_row
    for node in range(len(rows)):
        if rows[node] == row:
            middle += position[node, i]
    return middle / catch.row_size[row]


@njit(cache=True)
def front_height(position: Floats, catch: Catch, share: Floats) -> float:
    """Height z_f of the middle of the front, m: between the middles of the two rings of its band, as its lid is."""
    band = foremost(share)
    if band == len(share):
        return 0.0
    fore, aft = ring_middle(position, catch, band, 2), ring_middle(position, catch, band + 1, 2)
    return aft + share[band] * (fore - aft)


@njit(cache=True)
def add_force(position: Floats, structure: Structure, catch: Catch, share: Floats, force: Floats) -> None:
    """Add what the catch's weight presses with on every facet, a third to each corner, and what the rings bear."""
    if catch.weight_density == 0.0:
        return
    height = front_height(position, catch, share)
    add_force_below(position, structure, catch, share, height, force)
    add_to_rings(catch, share, left_to_rings(position, structure, catch, share, height), force)


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
def left_to_rings(
    position: Floats, structure: Structure, catch: Catch, share: Floats, height: float
) -> tuple[float, float, float]:
    """Force c that netting with the middle of the front at a given height lacks of the catch's weight, N."""
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = catch.facet_band, structure.facet_weight
    fore, lid = planes(position, catch, share)
    band, x, y, z, volume = foremost(share), 0.0, 0.0, 0.0, 0.0
    for facet in range(len(bands)):
        filled = share[bands[facet]] * weights[facet]
        if filled == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        ax, ay, az = area_vector(corners)
        depth = filled * (height - (corners[2] + corners[5] + corners[8]) / 3.0)
        x, y, z = x + depth * ax, y + depth * ay, z + depth * az
        plane = fore if bands[facet] == band else lid
        volume += filled * ax * ((corners[0] + corners[3] + corners[6]) / 3.0 - plane)
    k = catch.weight_density
    return -k * x, -k * y, -k * (z + volume)


@njit(cache=True)
def planes(position: Floats, catch: Catch, share: Floats) -> tuple[float, float]:
    """Axial position of the foremost ring of the front's band, and of the lid, m: see ``catch_front``."""
    band = foremost(share)
    if band == len(share):
        return 0.0, 0.0
    fore, aft = ring_middle(position, catch, band, 0), ring_middle(position, catch, band + 1, 0)
    return fore, aft + share[band] * (fore - aft)


@njit(cache=True)
def add_to_ring(catch: Catch, row: int, x: float, y: float, z: float, force: Floats) -> None:
    """Add a force to the nodes of a row's ring, evenly."""
    rows, size = catch.node_row, catch.row_size[row]
    for node in range(len(rows)):
        if rows[node] == row:
            force[node, 0] += x / size
            force[node, 1] += y / size
            force[node, 2] += z / size


@njit(cache=True)
def add_to_rings(catch: Catch, share: Floats, whole: tuple[float, float, float], force: Floats) -> None:
    """Add a force to the nodes of the two rings of the front's band, more to the one that the front is nearer to."""
    band = foremost(share)
    if band == len(share):
        return
    x, y, z = whole
    fore, aft = share[band], 1.0 - share[band]
    add_to_ring(catch, band, fore * x, fore * y, fore * z, force)
    add_to_ring(catch, band + 1, aft * x, aft * y, aft * z, force)


@njit(cache=True)
def rings_gradient(position: Floats, structure: Structure, catch: Catch, share: Floats, gradients: Floats) -> None:
    """Write the derivatives of the parts of c by the nodes, at a given height of the front and given shares, (3, n, 3).

    A facet's part k (z_f - z) A of what the netting bears changes by k (z_f - z) dA - k A dz, and the volume, of x' A_x
    from the plane of the front's foremost ring or of its lid, x', by x' dA_x + A_x dx'.
    """
    gradients[:] = 0.0
    facets, bands, weights = structure.facets, catch.facet_band, structure.facet_weight
    images, rotations = structure.facet_image, structure.rotations
    height, (fore, lid) = front_height(position, catch, share), planes(position, catch, share)
    band, area, area_of_band = foremost(share), 0.0, 0.0
    for facet in range(len(bands)):
        filled = share[bands[facet]] * weights[facet] * catch.weight_density
        if filled == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        x, y, z = area_vector(corners)
        plane = fore if bands[facet] == band else lid
        half = 0.5 * filled * (height - (corners[2] + corners[5] + corners[8]) / 3.0)
        behind = 0.5 * filled * ((corners[0] + corners[3] + corners[6]) / 3.0 - plane)
        third = filled / 3.0
        if bands[facet] == band:
            area_of_band += filled * x
        else:
            area += filled * x
        for moved in range(3):
            node = facets[facet, moved]
            ex, ey, ez = side_across(corners, moved)
            gradients[0, node, 1] -= half * ez
            gradients[0, node, 2] += half * ey + third * x
            gradients[1, node, 0] += half * ez
            gradients[1, node, 2] += third * y - half * ex
            gradients[2, node, 0] -= half * ey + third * x
            gradients[2, node, 1] += half * ex - behind * ez
            gradients[2, node, 2] += third * z + behind * ey
    if band < len(share):
        add_to_ring(catch, band, area_of_band, 0.0, 0.0, gradients[2])
        add_to_rings(catch, share, (area, 0.0, 0.0), gradients[2])


@njit(cache=True)
def add_by_share(
    position: Floats, structure: Structure, catch: Catch, share: Floats, band: int, height: float, force: Floats
) -> None:
    """Add the derivative of c and of how the rings share it by the share of the front's band, N, (n, 3)."""
    k, (fore, lid) = catch.weight_density, planes(position, catch, share)
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = catch.facet_band, structure.facet_weight
    x, y, z, volume, area = 0.0, 0.0, 0.0, 0.0, 0.0
    for facet in range(len(bands)):
        if bands[facet] < band:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        ax, ay, az = area_vector(corners)
        if bands[facet] > band:
            area += weights[facet] * ax
            continue
        depth = weights[facet] * (height - (corners[2] + corners[5] + corners[8]) / 3.0)
        x, y, z = x + depth * ax, y + depth * ay, z + depth * az
        volume += weights[facet] * ax * ((corners[0] + corners[3] + corners[6]) / 3.0 - fore)
    # the lid moves from one ring to the other
    volume += area * (lid - fore) / (1.0 - share[band])
    add_to_rings(catch, share, (-k * x, -k * y, -k * (z + volume)), force)
    x, y, z = left_to_rings(position, structure, catch, share, height)
    add_to_ring(catch, band, x, y, z, force)
    add_to_ring(catch, band + 1, -x, -y, -z, force)


@njit(cache=True)
def force_by_height(position: Floats, structure: Structure, catch: Catch, share: Floats, force: Floats) -> None:
    """Write the derivative of that force by the height of the front, N/m, (n, 3)."""
    force[:] = 0.0
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = catch.facet_band, structure.facet_weight
    whole_x, whole_y, whole_z = 0.0, 0.0, 0.0
    for facet in range(len(bands)):
        third = share[bands[facet]] * weights[facet] * catch.weight_density / 3.0
        if third == 0.0:
            continue
        x, y, z = area_vector(corners_of_facet(position, facets, images, rotations, facet))
        whole_x, whole_y, whole_z = whole_x - 3.0 * third * x, whole_y - 3.0 * third * y, whole_z - 3.0 * third * z
        for corner in range(3):
            add_turned_back(
                force, facets[facet, corner], third * x, third * y, third * z, images[facet, corner], rotations
            )
    add_to_rings(catch, share, (whole_x, whole_y, whole_z), force)


@njit(cache=True)
def height_gradient(catch: Catch, share: Floats, gradient: Floats) -> None:
    """Write the derivative of the front's height by the nodes at given shares, (n, 3)."""
    gradient[:] = 0.0
    add_to_rings(catch, share, (0.0, 0.0, 1.0), gradient)


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
    for facet in range(len(bands)):
        third = share[bands[facet]] * weights[facet] * catch.weight_density / 3.0
        if third == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        x, y, z = area_vector(corners)
        x, y, z = third * x / 3.0, third * y / 3.0, third * z / 3.0
        half = 0.5 * third * (height - (corners[2] + corners[5] + corners[8]) / 3.0)
        for moved in range(3):
            ex, ey, ez = side_across(corners, moved)
            ex, ey, ez = half * ex, half * ey, half * ez
            h = (0.0, ez, -ey - x, -ez, 0.0, ex - y, ey, -ex, -z)
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
