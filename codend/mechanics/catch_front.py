"""How far the catch fills the net, and how its front follows the net: kernels.

Where the front is given by its distance from the codline or by the catch's volume, the share s of the band it stands
in depends on the positions. Loads are linear in the shares, so the tangent gains one product: -dF/dx = K - u v^T
with u = dF/ds and v = ds/dx.
"""

import numpy as np

from catch_models.filling import fill_by_meshes, fill_to_plane, fill_to_volume
from codend.compiled import njit
from codend.mechanics import catch_weight, drag, pressure
from codend.mechanics.images import add_turned_back
from codend.mechanics.pressure import FILLED_MESHES, FRONT_FROM_CODLINE, Catch, area_vector, corners_of_facet
from codend.mechanics.structure import Structure
from codend.mechanics.water import Water
from codend.net.net import Floats


@njit(cache=True)
def row_positions(position: Floats, catch: Catch, row_x: Floats) -> None:
    """Write the mean axial position of every row's ring of nodes, (rows + 1,)."""
    row_x[:] = 0.0
    rows, sizes = catch.node_row, catch.row_size
    for node in range(len(rows)):
        row = rows[node]
        if row >= 0:
            row_x[row] += position[node, 0] / sizes[row]


@njit(cache=True)
def band_geometry(position: Floats, structure: Structure, catch: Catch, band_area: Floats, band_moment: Floats) -> None:
    """Write area projected on the axis (m2) and its integral of x (m3) for every band, all round."""
    band_area[:] = 0.0
    band_moment[:] = 0.0
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = catch.facet_band, structure.facet_weight
    for facet in range(len(bands)):
        corners = corners_of_facet(position, facets, images, rotations, facet)
        area = area_vector(corners)[0] * weights[facet] * structure.order
        band = bands[facet]
        band_area[band] += area
        band_moment[band] += area * (corners[0] + corners[3] + corners[6]) / 3.0


@njit(cache=True)
def fill(position: Floats, structure: Structure, catch: Catch, share: Floats) -> bool:
    """Write the share of every band that lies in the catch; False if the catch does not fit into the net."""
    if catch.kind == FILLED_MESHES:
        return fill_by_meshes(catch.band_meshes, catch.size, share)
    row_x = np.empty(len(share) + 1)
    row_positions(position, catch, row_x)
    if catch.kind == FRONT_FROM_CODLINE:
        return fill_to_plane(row_x, catch.size, share)
    band_area, band_moment = np.empty(len(share)), np.empty(len(share))
    band_geometry(position, structure, catch, band_area, band_moment)
    return fill_to_volume(row_x, band_area, band_moment, catch.size, share)


@njit(cache=True, error_model="numpy")
def front_band(catch: Catch, share: Floats) -> int:
    """Band whose share moves with the net; -1 if none does."""
    if catch.kind == FILLED_MESHES:
        return -1
    for band in range(len(share)):
        if 0.0 < share[band] < 1.0:
            return band
    return -1


@njit(cache=True, error_model="numpy")
def share_gradient(
    position: Floats, structure: Structure, catch: Catch, share: Floats, band: int, gradient: Floats
) -> None:
    """Write the derivative of the front band's share with respect to the nodes of the sector, 1/m, (n, 3).

    With the lid at x_L = (1 - s) x_(b+1) + s x_b, in the front's band b, what is given is the distance x_codline - x_L
    or the volume s (M_b - x_b A_b) + sum_(k > b) (M_k - x_L A_k); A and M are the bands' projected areas and their
    moments (``fill_to_volume``).
    """
    gradient[:] = 0.0
    row_x = np.empty(len(share) + 1)
    row_positions(position, catch, row_x)
    s, depth = share[band], row_x[band + 1] - row_x[band]
    lid = row_x[band + 1] - s * depth
    # g(s, x) is given; dg/ds, and dg by the two rows of the front's band and by the codline
    if catch.kind == FRONT_FROM_CODLINE:
        by_share, by_fore, by_aft, by_codline = depth, -s, s - 1.0, 1.0
    else:
        area, area_of_band, volume_of_band = 0.0, 0.0, 0.0
        facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
        bands, weights = catch.facet_band, structure.facet_weight
        for facet in range(len(bands)):
            place = bands[facet]
            if share[place] == 0.0:
                continue
            corners = corners_of_facet(position, facets, images, rotations, facet)
            ax, ay, az, bx, by, bz, cx, cy, cz = corners
            weight = weights[facet] * structure.order
            projected = area_vector(corners)[0] * weight
            plane = row_x[band] if place == band else lid
            depth_behind = (ax + bx + cx) / 3.0 - plane
            if place == band:
                area_of_band += projected
                volume_of_band += projected * depth_behind
            else:
                area += projected
            weight *= 0.5 * share[place] * depth_behind
            third = share[place] * projected / 3.0
            for corner in range(3):
                if corner == 0:
                    ey, ez = by - cy, bz - cz
                elif corner == 1:
                    ey, ez = cy - ay, cz - az
                else:
                    ey, ez = ay - by, az - bz
                add_turned_back(
                    gradient,
                    facets[facet, corner],
                    third,
                    weight * ez,
                    -weight * ey,
                    images[facet, corner],
                    rotations,
                )
        by_share = volume_of_band + depth * area
        by_fore, by_aft, by_codline = -s * (area + area_of_band), (s - 1.0) * area, 0.0
    rows, sizes = catch.node_row, catch.row_size
    for node in range(len(rows)):
        row = rows[node]
        if row < 0:
            continue
        if row == band:
            gradient[node, 0] += by_fore / sizes[row]
        if row == band + 1:
            gradient[node, 0] += by_aft / sizes[row]
        if row == len(share):
            gradient[node, 0] += by_codline / sizes[row]
    scale = -1.0 / by_share
    for node in range(len(rows)):
        for i in range(3):
            gradient[node, i] *= scale


@njit(cache=True, error_model="numpy")
def load_by_share(
    position: Floats, structure: Structure, water: Water, catch: Catch, filled: Floats, band: int, load: Floats
) -> None:
    """Write the derivative of the nodal loads at given shares with respect to that of the front's band, N, (n, 3)."""
    load[:] = 0.0
    # the pressure is linear in the share and the drag in 1 - share, both band by band
    share = np.ones(len(catch.band_meshes))
    share[band] = 0.0
    drag.add_force(position, np.empty((0, 3)), structure, water, catch, share, load)
    for node in range(len(load)):
        for i in range(3):
            load[node, i] *= -1.0
    share[:] = 0.0
    share[band] = 1.0
    pressure.add_force(position, structure, catch, share, load)
    if catch.weight_density == 0.0:
        return
    height = catch_weight.front_height(position, catch, filled)
    catch_weight.add_force_below(position, structure, catch, share, height, load)
    # with its share the middle of the front moves from that of one ring to that of the next
    rise = catch_weight.ring_middle(position, catch, band, 2) - catch_weight.ring_middle(position, catch, band + 1, 2)
    by_height = np.empty_like(load)
    catch_weight.force_by_height(position, structure, catch, filled, by_height)
    for node in range(len(load)):
        for i in range(3):
            load[node, i] += rise * by_height[node, i]
    catch_weight.add_by_share(position, structure, catch, filled, band, height, load)
