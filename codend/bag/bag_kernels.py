"""All that is measured of a bag in equilibrium, in one call: kernels."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.bag.measure_kernels import (
    WANTED_OPENING_DEG,
    Flags,
    catch_volume,
    mean_by,
    mean_over,
    net_pressure,
    opening_force,
    rows_ahead,
    sideways_imbalance,
    write_corners,
    write_openings,
)
from codend.compiled import njit
from codend.mechanics.catch_weight import front_height
from codend.mechanics.crossing import whole_turn
from codend.mechanics.loads import Loading, add_in_parts, supports
from codend.mechanics.possible import inward_share
from codend.mechanics.pressure import Catch
from codend.mechanics.rings import Rings
from codend.mechanics.structure import Structure
from codend.net.net import Floats, Ints

ROWS_AHEAD = 5
"""Mesh rows ahead of the catch over which ``opening_ahead_deg`` is the mean."""
SUMS = (
    "filled_meshes",
    "catch_volume_m3",
    "front_radius_m",
    "front_from_codline_m",
    "max_radius_m",
    "length_m",
    "drag_n",
    "catch_drag_n",
    "twine_drag_n",
    "entry_reaction_n",
    "opening_ahead_deg",
    "opening_force_ahead_n",
    "opening_ahead_spread_deg",
    "opening_ahead_least_deg",
    "opening_ahead_most_deg",
    "max_bar_tension_n",
    "max_strap_tension_n",
    "max_rope_tension_n",
    "folded_share",
    "turn_deg",
    "sideways_imbalance",
    "codline_aside_m",
)
"""Numbers of a bag as a whole, in the order of ``measures.Measures``."""
_RECORD = np.dtype([(name, np.float64) for name in SUMS])


class BagStructure(NamedTuple):
    """A bag as kernels see it; see ``bag.Bag``."""

    order: float
    globalisation: float
    sides: Ints
    side_image: Ints
    mesh_bars: Ints
    mesh_row: Ints
    mesh_is_staggered: Flags
    mesh_is_folded: Flags
    mesh_ahead: Ints
    """Band that a mesh reaches ahead into, (k,)."""
    mesh_behind: Ints
    """Band that it reaches behind into, (k,)."""
    mesh_opens: Flags
    mesh_bending_n: Floats
    mesh_rest_rad: Floats
    mesh_of_section: Flags
    mesh_place: Floats
    node_row: Ints
    held_by_the_entry: Flags
    twine_band: Ints
    """Band that a bar of twine lies in, -1 for other bars, (m,)."""
    band_meshes: Floats
    netting: Flags
    """Whether a bar is neither strap nor rope, (m,)."""
    straps: Ints
    ropes: Ints
    smeared: bool


@njit(cache=True, error_model="numpy")
def openings_of(bag: BagStructure, position: Floats) -> tuple[Floats, Floats, Floats]:
    """Corners, openings in degrees and outward normals of all meshes, see ``measures.mesh_openings``."""
    count = len(bag.mesh_row)
    corners, opening, normal = np.empty((count, 4, 2, 3)), np.empty(count), np.empty((count, 3))
    write_corners(position, bag.sides, bag.side_image, bag.order, corners)
    write_openings(corners, bag.mesh_is_staggered, bag.mesh_is_folded, opening, normal)
    return corners, opening, normal


@njit(cache=True, error_model="numpy")
def meshes_of(
    bag: BagStructure, position: Floats, tension: Floats, share: Floats, catch: Catch
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """The arrays of ``measures.Meshes``, from positions and tensions of the model."""
    corners, opening, normal = openings_of(bag, position)
    pull = mean_over(tension, bag.mesh_bars)
    centre, force, pressure = np.zeros((len(pull), 3)), np.empty(len(pull)), np.empty(len(pull))
    front = front_height(position, catch, share)
    for mesh in range(len(pull)):
        pull[mesh] /= bag.globalisation
        for i in range(3):
            for side in range(4):
                centre[mesh, i] += corners[mesh, side, 0, i] + corners[mesh, side, 1, i]
            centre[mesh, i] /= 8.0
        bending, rest = bag.mesh_bending_n[mesh], bag.mesh_rest_rad[mesh]
        force[mesh] = opening_force(pull[mesh], opening[mesh], WANTED_OPENING_DEG, bending, rest)
        if not bag.mesh_opens[mesh]:
            force[mesh] = np.nan
        filled = 0.5 * (share[bag.mesh_ahead[mesh]] + share[bag.mesh_behind[mesh]])
        pressure[mesh] = 0.0
        if filled > 0.0:
            by_water = net_pressure(normal[mesh, 0], np.hypot(normal[mesh, 1], normal[mesh, 2]), catch)
            pressure[mesh] = filled * (by_water + catch.weight_density * (front - centre[mesh, 2]))
    return centre, opening, pull, force, pressure


@njit(cache=True, error_model="numpy")
def ring_middles(bag: BagStructure, position: Floats) -> Floats:
    """Sideways positions of the middles of the rings of knots, (rows + 1, 2), m.

    The rings of a sector have their middles on the axis; those of a full net, which may sag, where their knots have.
    """
    middles = np.zeros((len(bag.band_meshes) + 1, 2))
    if bag.order == 1.0:
        for i in range(2):
            middles[:, i] = mean_by(bag.node_row, position[:, 1 + i], len(middles))
    return middles


@njit(cache=True, error_model="numpy")
def ring_radii(bag: BagStructure, position: Floats, middles: Floats) -> Floats:
    """Distances of the nodes from the middle of their ring, m, (n,); 0 of those that belong to none."""
    radius = np.zeros(len(position))
    for node in range(len(position)):
        row = bag.node_row[node]
        if row >= 0:
            radius[node] = np.hypot(position[node, 1] - middles[row, 0], position[node, 2] - middles[row, 1])
    return radius


@njit(cache=True, error_model="numpy")
def ring_means(bag: BagStructure, position: Floats) -> tuple[Floats, Floats]:
    """Mean place along the axis and mean radius of every ring of knots, each (rows + 1,), m."""
    rows, radius = len(bag.band_meshes) + 1, ring_radii(bag, position, ring_middles(bag, position))
    return mean_by(bag.node_row, position[:, 0], rows), mean_by(bag.node_row, radius, rows)


@njit(cache=True, error_model="numpy")
def rows_of(
    bag: BagStructure,
    position: Floats,
    real_tension: Floats,
    share: Floats,
    catch: Catch,
    opening: Floats,
    force: Floats,
) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
    """The arrays of ``measures.Rows``, from positions, real tensions and what was measured of the meshes.

    Tensions and shares are means of the bands on either side; slopes are those between the rows on either side.
    """
    bands = len(bag.band_meshes)
    x, radius = ring_means(bag, position)
    middles = ring_middles(bag, position)
    front = front_height(position, catch, share)
    by_band = mean_by(bag.twine_band, real_tension, bands)
    tension, pressure = np.empty(bands + 1), np.empty(bands + 1)
    for row in range(bands + 1):
        fore, aft = max(row - 1, 0), min(row, bands - 1)
        tension[row] = 0.5 * (by_band[fore] + by_band[aft])
        filled = 0.5 * ((share[fore] if row > 0 else 0.0) + share[aft])
        before, after = max(row - 1, 0), min(row + 1, bands)
        slope, run = (radius[after] - radius[before]) / (after - before), (x[after] - x[before]) / (after - before)
        by_weight = catch.weight_density * (front - middles[row, 1])
        pressure[row] = filled * (net_pressure(-slope, abs(run), catch) + by_weight)
    # meshes of windows are left out
    row_of_mesh = np.where(bag.mesh_of_section, bag.mesh_row, -1)
    opens, pulls = mean_by(row_of_mesh, opening, bands + 1), mean_by(row_of_mesh, force, bands + 1)
    return x, radius, opens, tension, pulls, pressure


@njit(cache=True, error_model="numpy")
def mean_ahead(bag: BagStructure, share: Floats, of_rows: Floats, has_mesh: Flags) -> float:
    """Mean of values of rows, (rows + 1,), over the mesh rows just ahead of the front; nan where there are none."""
    ahead = rows_ahead(share, bag.band_meshes, bag.globalisation, ROWS_AHEAD)
    if len(ahead) == 0:
        return np.nan
    return np.mean(np.interp(ahead, bag.mesh_place[has_mesh], of_rows[has_mesh]))


@njit(cache=True, error_model="numpy")
def spread_ahead(bag: BagStructure, share: Floats, opening: Floats) -> tuple[float, float, float]:
    """How openings differ round the ring in the rows just ahead of the front: spread, least and most, degrees.

    The spread is their standard deviation about the means of their rows; nan where ropes are smeared.
    """
    ahead = rows_ahead(share, bag.band_meshes, bag.globalisation, ROWS_AHEAD)
    if len(ahead) == 0 or bag.smeared:
        return np.nan, np.nan, np.nan
    first, last = ahead.min() - 0.5 + 1e-9, ahead.max() + 0.5 - 1e-9
    row_of_mesh = np.full(len(opening), -1)
    least, most, count = np.inf, -np.inf, 0
    for mesh in range(len(opening)):
        place = bag.mesh_place[bag.mesh_row[mesh]]
        if bag.mesh_of_section[mesh] and np.isfinite(opening[mesh]) and first < place < last:
            row_of_mesh[mesh] = bag.mesh_row[mesh]
            least, most, count = min(least, opening[mesh]), max(most, opening[mesh]), count + 1
    if count == 0:
        return np.nan, np.nan, np.nan
    means, squares = mean_by(row_of_mesh, opening, len(bag.mesh_place)), 0.0
    for mesh in range(len(opening)):
        if row_of_mesh[mesh] >= 0:
            squares += (opening[mesh] - means[row_of_mesh[mesh]]) ** 2
    return np.sqrt(squares / count), least, most


@njit(cache=True, error_model="numpy")
def between_rows(place: float, of_rows: Floats) -> float:
    """Value between two rows, in proportion."""
    row = min(int(place), len(of_rows) - 2)
    return of_rows[row] + (place - row) * (of_rows[row + 1] - of_rows[row])


@njit(cache=True, error_model="numpy")
def largest_radius(bag: BagStructure, position: Floats) -> float:
    """Of all knots, m."""
    return np.max(ring_radii(bag, position, ring_middles(bag, position)))


@njit(cache=True, error_model="numpy")
def write_sums(
    bag: BagStructure,
    structure: Structure,
    loading: Loading,
    rings: Rings,
    position: Floats,
    tension: Floats,
    real_tension: Floats,
    share: Floats,
    opening: Floats,
    rows: tuple[Floats, Floats, Floats, Floats, Floats, Floats],
    sums: NDArray[np.void],
) -> None:
    """Write the numbers of ``SUMS``."""
    x, radius, opens, _, pulls, _ = rows
    found, catch, bands = sums[0], loading.catch, len(share)
    front = bands - np.sum(share)
    found.filled_meshes = np.sum(share * bag.band_meshes)
    found.catch_volume_m3 = catch_volume(position, structure, catch, share)
    found.front_radius_m = between_rows(front, radius)
    found.front_from_codline_m = x[-1] - between_rows(front, x)
    found.max_radius_m = largest_radius(bag, position)
    found.length_m = x[-1] - x[0]
    on_twine, by_catch, load = np.zeros_like(position), np.zeros_like(position), np.zeros_like(position)
    add_in_parts(position, np.empty((0, 3)), structure, loading, share, on_twine, by_catch, load)
    found.twine_drag_n = structure.order * np.sum(on_twine[:, 0])
    found.catch_drag_n = structure.order * np.sum(by_catch[:, 0])
    found.drag_n = found.twine_drag_n + found.catch_drag_n
    load += on_twine + by_catch
    support = supports(structure, position, tension, load)
    reaction = 0.0
    for node in range(len(support)):
        if bag.held_by_the_entry[node]:
            reaction -= support[node, 0]
    found.entry_reaction_n = structure.order * reaction
    has_mesh = np.isfinite(opens)
    found.opening_ahead_deg = mean_ahead(bag, share, opens, has_mesh)
    found.opening_force_ahead_n = mean_ahead(bag, share, pulls, has_mesh)
    spread, least, most = spread_ahead(bag, share, opening)
    found.opening_ahead_spread_deg, found.opening_ahead_least_deg, found.opening_ahead_most_deg = spread, least, most
    found.max_bar_tension_n = np.max(real_tension[bag.netting])
    found.max_strap_tension_n = np.max(real_tension[bag.straps]) if len(bag.straps) else np.nan
    found.max_rope_tension_n = np.max(real_tension[bag.ropes]) if len(bag.ropes) else np.nan
    found.folded_share = inward_share(position, structure, catch, share)
    found.turn_deg = np.degrees(whole_turn(position, structure, catch, rings)[0])
    found.sideways_imbalance = sideways_imbalance(position, load, support, bag.held_by_the_entry, bag.order)
    codline = ring_middles(bag, position)[-1]
    found.codline_aside_m = np.hypot(codline[0], codline[1])


@njit(cache=True, error_model="numpy")
def measure_bag(
    bag: BagStructure,
    structure: Structure,
    loading: Loading,
    rings: Rings,
    position: Floats,
    tension: Floats,
    real_tension: Floats,
    share: Floats,
    sums: NDArray[np.void],
) -> tuple[tuple[Floats, Floats, Floats, Floats, Floats], tuple[Floats, Floats, Floats, Floats, Floats, Floats]]:
    """Measure meshes, rows and sums.

    Args:
        bag: what is measured.
        structure: its net.
        loading: what acts on it.
        rings: its rings as built.
        position: nodes, (n, 3), m.
        tension: of the bars of the model, (m,), N.
        real_tension: of the real bars that they stand for, (m,), N.
        share: of each band that lies in the catch, (bands,).
        sums: the numbers of ``SUMS`` are written, (1,).
    """
    meshes = meshes_of(bag, position, tension, share, loading.catch)
    rows = rows_of(bag, position, real_tension, share, loading.catch, meshes[1], meshes[3])
    write_sums(bag, structure, loading, rings, position, tension, real_tension, share, meshes[1], rows, sums)
    return meshes, rows


def empty_sums() -> NDArray[np.void]:
    """Room for ``SUMS``, (1,)."""
    return np.zeros(1, dtype=_RECORD)
