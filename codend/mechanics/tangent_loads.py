"""Exact tangent of the loads at given shares of the catch: twine drag and follower pressure, kernels.

Both add -dF/dx to the blocks laid out in ``tangent``. How the shares follow the positions is in ``tangent_front``.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.arrays import LE_BRIS_1999, Loading, Structure
from codend.mechanics.bars import bar_vector
from codend.mechanics.pressure import area_vector, corners_of_facet, is_uniform, law_and_slope
from codend.mechanics.tangent import Pattern, add_bar_blocks
from codend.net.net import Floats, Ints


@njit(cache=True, error_model="numpy")
def add_drag_tangent(
    position: Floats, structure: Structure, loading: Loading, pattern: Pattern, share: Floats, blocks: Floats
) -> None:
    """Add the twine drag's part; the law is that of ``drag.add_drag``.

    With d = (a, y, z) the bar's vector, r = |(y, z)|, l = |d| and S half the bar's q d, the load on each end is
    (F, W y, W z):

        LB99  F = S (Cd r^3 + f Cd |a|^3) / l^2,  W = S (f Cd |a| - Cd r) a / l^2
        BM97  F = S (Cd r^2 + Cf a^2) / l,        W = S (Cf - Cd) a / l

    Those of a strap, whose own length is L, are L / l times as large, which falls by (a, y, z) / l^2 of itself.
    """
    if loading.normal == 0.0 and loading.tangential == 0.0:
        return
    pressure = 0.5 * loading.density * loading.speed * loading.speed
    le_bris = loading.drag_law == LE_BRIS_1999
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    diameters, bands, slots = structure.drag_diameter, loading.catch.bar_band, pattern.bar_slot
    h = np.empty((3, 3))
    for bar in range(len(firsts)):
        exposed = 1.0 - share[bands[bar]]
        if diameters[bar] == 0.0 or exposed == 0.0:
            continue
        image = images[bar]
        a, y, z = bar_vector(position, firsts[bar], seconds[bar], image, rotations)
        squared = a * a + y * y + z * z
        if squared == 0.0:
            continue
        r, length = np.sqrt(y * y + z * z), np.sqrt(squared)
        scale = 0.5 * exposed * pressure * diameters[bar]
        normal, tangential = scale * loading.normal, scale * loading.tangential
        if le_bris:
            tangential *= loading.normal
            force = (normal * r**3 + tangential * abs(a) ** 3) / squared
            force_a = (3.0 * tangential * a * abs(a) - 2.0 * a * force) / squared
            force_r = (3.0 * normal * r * r - 2.0 * r * force) / squared
            across = (tangential * abs(a) - normal * r) * a / squared
            across_a = (2.0 * tangential * abs(a) - normal * r - 2.0 * a * across) / squared
            across_r = (-normal * a - 2.0 * r * across) / squared
        else:
            force = (normal * r * r + tangential * a * a) / length
            force_a = (2.0 * tangential * a - a * force / length) / length
            force_r = (2.0 * normal * r - r * force / length) / length
            across = (tangential - normal) * a / length
            across_a = (tangential - normal) * r * r / (length * squared)
            across_r = -across * r / squared
        if structure.is_rope[bar]:
            ratio = structure.length[bar] / length
            force_a, force_r = ratio * (force_a - a * force / squared), ratio * (force_r - r * force / squared)
            across_a, across_r = ratio * (across_a - a * across / squared), ratio * (across_r - r * across / squared)
            across *= ratio
        sideways, upward = (y / r, z / r) if r > 0.0 else (0.0, 0.0)
        h[0, 0], h[0, 1], h[0, 2] = force_a, force_r * sideways, force_r * upward
        h[1, 0], h[1, 1], h[1, 2] = across_a * y, across + across_r * y * sideways, across_r * y * upward
        h[2, 0], h[2, 1], h[2, 2] = across_a * z, across_r * z * sideways, across + across_r * z * upward
        add_bar_blocks(blocks, slots, bar, h, 1.0, image, rotations)


@njit(cache=True, error_model="numpy")
def take_from_facet_blocks(
    blocks: Floats, slots: Ints, facet: int, moved: int, h: Floats, images: Ints, rotations: Floats
) -> None:
    """Take off the blocks of a facet's three corners whose loads all change by h with the move of one of them."""
    middle = (rotations.shape[0] - 1) // 2
    e, t = rotations[middle + images[facet, moved], 0], rotations[middle + images[facet, moved], 1]
    for i in range(3):
        y, z = h[i, 1], h[i, 2]
        h[i, 1], h[i, 2] = e * y + t * z, e * z - t * y
    for corner in range(3):
        slot, image = slots[facet, corner, moved], images[facet, corner]
        c, s = rotations[middle + image, 0], rotations[middle + image, 1]
        for j in range(3):
            blocks[slot, 0, j] -= h[0, j]
            blocks[slot, 1, j] -= c * h[1, j] + s * h[2, j]
            blocks[slot, 2, j] -= c * h[2, j] - s * h[1, j]


@njit(cache=True, error_model="numpy")
def add_pressure_tangent(
    position: Floats, structure: Structure, loading: Loading, pattern: Pattern, share: Floats, blocks: Floats
) -> None:
    """Add the catch's pressure's part; it follows the facets' areas, senses and angles to the flow.

    The load P = k C(theta) A of a facet with area vector A = (a x b + b x c + c x a) / 2 changes by
    dP = k (C I + C' A (dtheta/dA)^T) dA, with dtheta/dA = (e_x - n_x n) / (|A| sin theta), a unit vector over |A|, and
    dA = da x (b - c) / 2 for a move of corner a. On the axis of the flow, where that unit vector has no direction, the
    law's slope counts as 0.
    """
    angles, coefficients = loading.catch.angles, loading.catch.coefficients
    uniform = is_uniform(angles, coefficients)
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights, slots = loading.catch.facet_band, structure.facet_weight, pattern.facet_slot
    stagnation = loading.catch.stagnation_pressure
    h, b = np.empty((3, 3)), np.empty((3, 3))
    for facet in range(len(bands)):
        filled = share[bands[facet]]
        if filled == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        ax, ay, az, bx, by, bz, cx, cy, cz = corners
        x, y, z = area_vector(corners)
        third = filled * weights[facet] * stagnation / 3.0
        b[:] = 0.0
        coefficient = coefficients[3, 0]
        if not uniform:
            area, across = np.sqrt(x * x + y * y + z * z), np.sqrt(y * y + z * z)
            if area == 0.0:
                continue
            coefficient, slope = law_and_slope(x, across, angles, coefficients)
            if across > 0.0:
                # (e_x - n_x n) / sin theta = (sin theta, -n_x n_y / sin theta, -n_x n_z / sin theta)
                slope *= third / (area * area)
                sx, sy, sz = slope * across, -slope * x * y / across, -slope * x * z / across
                b[0, 0], b[0, 1], b[0, 2] = x * sx, x * sy, x * sz
                b[1, 0], b[1, 1], b[1, 2] = y * sx, y * sy, y * sz
                b[2, 0], b[2, 1], b[2, 2] = z * sx, z * sy, z * sz
        for i in range(3):
            b[i, i] += third * coefficient
        for moved in range(3):
            if moved == 0:
                ex, ey, ez = bx - cx, by - cy, bz - cz
            elif moved == 1:
                ex, ey, ez = cx - ax, cy - ay, cz - az
            else:
                ex, ey, ez = ax - bx, ay - by, az - bz
            ex, ey, ez = 0.5 * ex, 0.5 * ey, 0.5 * ez
            # b times the matrix that turns a move dx into dx x e
            for i in range(3):
                h[i, 0] = b[i, 2] * ey - b[i, 1] * ez
                h[i, 1] = b[i, 0] * ez - b[i, 2] * ex
                h[i, 2] = b[i, 1] * ex - b[i, 0] * ey
            take_from_facet_blocks(blocks, slots, facet, moved, h, images, rotations)
