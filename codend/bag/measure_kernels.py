"""What is measured of meshes, rows and bands, one thing at a time: kernels. ``bag_kernels`` measures all of a bag."""

import numpy as np
from numpy.typing import NDArray

from catch_models.filling import enclosed_volume
from codend.compiled import njit
from codend.mechanics.catch_front import band_geometry, row_positions
from codend.mechanics.pressure import Catch, law_and_slope
from codend.mechanics.structure import Structure
from codend.net.net import Floats, Ints

Flags = NDArray[np.bool_]
WANTED_OPENING_DEG = 30.0
"""Opening to which the opening force brings a mesh (Le Bris et al. 1999, figure 11)."""


@njit(cache=True, error_model="numpy")
def write_corners(position: Floats, sides: Ints, images: Ints, order: float, corners: Floats) -> None:
    """Write the end positions of the four sides of every mesh, (k, 4, 2, 3)."""
    if len(sides) == 0:
        return
    reach = int(np.abs(images).max())
    angle = 2.0 * np.pi / order * np.arange(-reach, reach + 1)
    cosine, sine = np.cos(angle), np.sin(angle)
    for mesh in range(len(sides)):
        for side in range(4):
            for end in range(2):
                node, turn = sides[mesh, side, end], images[mesh, side, end] + reach
                y, z = position[node, 1], position[node, 2]
                corners[mesh, side, end, 0] = position[node, 0]
                corners[mesh, side, end, 1] = cosine[turn] * y - sine[turn] * z
                corners[mesh, side, end, 2] = sine[turn] * y + cosine[turn] * z


@njit(cache=True, error_model="numpy")
def write_openings(corners: Floats, staggered: Flags, folded: Flags, opening: Floats, normal: Floats) -> None:
    """Write openings in degrees (k,) and outward normals (k, 3) of meshes; see ``measures.mesh_openings``."""
    sides = np.empty((4, 3))
    longitudinal, transverse, fore = np.empty(3), np.empty(3), np.empty(3)
    for mesh in range(len(corners)):
        flat_fore, flat_aft = 0.0, 0.0
        for side in range(4):
            for i in range(3):
                sides[side, i] = corners[mesh, side, 1, i] - corners[mesh, side, 0, i]
        for i in range(3):
            fore[i], aft = 0.5 * (sides[0, i] - sides[3, i]), 0.5 * (sides[1, i] - sides[2, i])
            flat_fore, flat_aft = flat_fore + fore[i] ** 2, flat_aft + aft**2
            if staggered[mesh]:
                longitudinal[i] = fore[i] + aft
                transverse[i] = 0.5 * (sides[0, i] - sides[1, i] - sides[2, i] + sides[3, i])
            else:
                longitudinal[i] = 0.5 * (sides[1, i] - sides[3, i])
                transverse[i] = 0.5 * (sides[0, i] - sides[2, i])
        nx = transverse[1] * longitudinal[2] - transverse[2] * longitudinal[1]
        ny = transverse[2] * longitudinal[0] - transverse[0] * longitudinal[2]
        nz = transverse[0] * longitudinal[1] - transverse[1] * longitudinal[0]
        size = np.sqrt(nx * nx + ny * ny + nz * nz)
        normal[mesh, 0], normal[mesh, 1], normal[mesh, 2] = nx / size, ny / size, nz / size
        along = np.sqrt(flat_fore) + np.sqrt(flat_aft) if folded[mesh] else _norm(longitudinal)
        opening[mesh] = np.degrees(2.0 * np.arctan2(_norm(transverse), along))


@njit(cache=True)
def _norm(vector: Floats) -> float:
    return np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)


@njit(cache=True, error_model="numpy")
def opening_force(
    bar_tension_n: Floats,
    opening_deg: Floats,
    wanted_deg: float = WANTED_OPENING_DEG,
    bending_n: Floats | float = 0.0,
    rest_rad: Floats | float = 0.0,
) -> Floats:
    """Extra pull across the short diagonal that brings isolated meshes to the wanted opening, N, of one or (k,).

    F = P (tan phi' - tan phi) + B ((phi' - phi0) / cos phi' - (phi - phi0) / cos phi), P = 2 T cos phi - B (phi - phi0)
    sin phi the load along the netting that a mesh carries, phi half its opening, phi' half the wanted one, phi0 half
    that at rest and B = 24 EI / b^2: derived from the equilibrium of a rhombus of four clamped bars. Zero or less once
    the mesh is open that far.
    """
    half, wanted = np.radians(opening_deg) / 2.0, np.radians(wanted_deg) / 2.0
    along = 2.0 * bar_tension_n * np.cos(half) - bending_n * (half - rest_rad) * np.sin(half)
    bent = (wanted - rest_rad) / np.cos(wanted) - (half - rest_rad) / np.cos(half)
    return along * (np.tan(wanted) - np.tan(half)) + bending_n * bent


@njit(cache=True, error_model="numpy")
def mean_by(group: Ints, values: Floats, groups: int) -> Floats:
    """Mean of the values of every group, (groups,): nan where it has none; those of group -1 belong to none."""
    mean, count = np.zeros(groups), np.zeros(groups)
    for i in range(len(group)):
        if group[i] >= 0:
            mean[group[i]] += values[i]
            count[group[i]] += 1.0
    for i in range(groups):
        mean[i] /= count[i]
    return mean


@njit(cache=True, error_model="numpy")
def mean_over(values: Floats, index: Ints) -> Floats:
    """Mean of the values at each row of indices (k, places), -1 left out, (k,)."""
    mean = np.empty(len(index))
    for row in range(len(index)):
        total, count = 0.0, 0.0
        for i in index[row]:
            if i >= 0:
                total += values[i]
                count += 1.0
        mean[row] = total / count
    return mean


@njit(cache=True)
def net_pressure(x: float, across: float, catch: Catch) -> float:
    """Net pressure of the water in the catch, Pa, at a normal with ``x`` along the flow and ``across`` it."""
    return catch.stagnation_pressure * law_and_slope(x, across, catch.angles, catch.coefficients)[0]


@njit(cache=True, error_model="numpy")
def sideways_imbalance(position: Floats, load: Floats, support: Floats, entry: Flags, order: float) -> float:
    """What the loads of a bag and the reactions of its entry leave over across the axis and as a moment, relative.

    The larger of the force across the axis over the resultant load, and of the moment about the middle of the entry
    over that times the bag's reach from there. Over the images of a sector all cancel but the moment about the axis. A
    support elsewhere that carries something, which no gear supplies, shows in it.
    """
    middle, held = np.zeros(3), 0
    for node in range(len(entry)):
        if entry[node]:
            middle += position[node]
            held += 1
    middle /= held
    if order > 1.0:
        middle[1:] = 0.0
    force, moment, resultant = np.zeros(3), np.zeros(3), np.zeros(3)
    arm, outer, reach = np.empty(3), np.empty(3), 0.0
    for node in range(len(entry)):
        for i in range(3):
            arm[i] = position[node, i] - middle[i]
            outer[i] = load[node, i] + (support[node, i] if entry[node] else 0.0)
            force[i] += outer[i]
            resultant[i] += load[node, i]
        moment[0] += arm[1] * outer[2] - arm[2] * outer[1]
        moment[1] += arm[2] * outer[0] - arm[0] * outer[2]
        moment[2] += arm[0] * outer[1] - arm[1] * outer[0]
        reach = max(reach, _norm(arm))
    if order > 1.0:
        force[1:], moment[1:], resultant[1:] = 0.0, 0.0, 0.0
    force[0] = 0.0
    return max(_norm(force), _norm(moment) / reach) / _norm(resultant)


@njit(cache=True)
def rows_ahead(share: Floats, band_meshes: Floats, globalisation: float, most: int) -> Floats:
    """Middles of the real mesh rows just ahead of the front, in meshes from the entry, ``most`` of them at most."""
    place = np.zeros(len(share) + 1)
    end, found = 0.0, 0
    for band in range(len(share)):
        place[band + 1] = place[band] + band_meshes[band]
        end += (1.0 - share[band]) * band_meshes[band]
    middles = np.empty(most)
    while found < most and end >= 1.0 - 1e-9:
        middles[found] = end - 0.5
        found += 1
        end -= band_meshes[max(int(np.searchsorted(place, end - 1e-9)) - 1, 0)] / globalisation
    return middles[:found]


@njit(cache=True)
def catch_volume(position: Floats, structure: Structure, catch: Catch, share: Floats) -> float:
    """Volume of the catch, m3."""
    row_x, area, moment = np.empty(len(share) + 1), np.empty(len(share)), np.empty(len(share))
    row_positions(position, catch, row_x)
    band_geometry(position, structure, catch, area, moment)
    return enclosed_volume(row_x, area, moment, share)


@njit(cache=True)
def knots_all_but_slack(
    first: Ints, second: Ints, tension: Floats, least: float, free: Floats, codline: int
) -> NDArray[np.int64]:
    """Numbers of the free knots of three bars and more of which at most one pulls; not the codline, (k,).

    Args:
        first: first end of the bars, (m,).
        second: second end, (m,).
        tension: of the bars, N, (m,).
        least: N, up to which a bar does not pull.
        free: 1 for coordinates that move, (n, 3).
        codline: the node that is none of them.
    """
    bars, pulling = np.zeros(len(free), dtype=np.int64), np.zeros(len(free), dtype=np.int64)
    for bar in range(len(first)):
        for end in (first[bar], second[bar]):
            bars[end] += 1
            pulling[end] += tension[bar] > least
    found, count = np.empty(len(free), dtype=np.int64), 0
    for node in range(len(free)):
        moves = free[node, 0] > 0.0 and free[node, 1] > 0.0 and free[node, 2] > 0.0
        if moves and bars[node] >= 3 and pulling[node] <= 1 and node != codline:
            found[count] = node
            count += 1
    return found[:count]
