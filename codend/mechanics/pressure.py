"""Pressure of the catch on the facets, and how far the catch fills the net: kernels."""

import numpy as np

from catch_models.filling import fill_by_meshes, fill_to_plane, fill_to_volume
from codend.compiled import njit
from codend.mechanics.arrays import FILLED_MESHES, FRONT_FROM_CODLINE, Catch, Loading, Structure
from codend.mechanics.images import add_turned_back, turned
from codend.net.net import Floats, Ints


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
def add_pressure(position: Floats, structure: Structure, loading: Loading, share: Floats, force: Floats) -> None:
    """Add the catch's pressure on every facet to the nodal forces, a third to each corner.

    Facet load = share of the facet within the catch x q (1 - Cp(theta)) x area vector, theta between the upstream
    direction and the outward normal (Le Bris et al. 1999, section 5). Nothing acts at the front, which is open.
    """
    angles, coefficients = loading.catch.angles, loading.catch.coefficients
    uniform = is_uniform(angles, coefficients)
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = loading.catch.facet_band, structure.facet_weight
    third_of_stagnation = loading.catch.stagnation_pressure / 3.0
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
def row_positions(position: Floats, catch: Catch, row_x: Floats) -> None:
    """Write the mean axial position of every row's ring of nodes, (rows + 1,)."""
    row_x[:] = 0.0
    rows, sizes = catch.node_row, catch.row_size
    for node in range(len(rows)):
        row = rows[node]
        if row >= 0:
            row_x[row] += position[node, 0] / sizes[row]


@njit(cache=True)
def band_geometry(
    position: Floats, structure: Structure, catch: Catch, band_area: Floats, band_moment: Floats
) -> None:
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
def fill(position: Floats, structure: Structure, loading: Loading, share: Floats) -> bool:
    """Write the share of every band that lies in the catch; False if the catch does not fit into the net."""
    catch = loading.catch
    if catch.kind == FILLED_MESHES:
        return fill_by_meshes(catch.band_meshes, catch.size, share)
    row_x = np.empty(len(share) + 1)
    row_positions(position, catch, row_x)
    if catch.kind == FRONT_FROM_CODLINE:
        return fill_to_plane(row_x, catch.size, share)
    band_area, band_moment = np.empty(len(share)), np.empty(len(share))
    band_geometry(position, structure, catch, band_area, band_moment)
    return fill_to_volume(row_x, band_area, band_moment, catch.size, share)
