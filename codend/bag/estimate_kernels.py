"""What error estimates stand beside, measured alone of a bag: kernels."""

import numpy as np

from codend.bag.bag_kernels import ROWS_AHEAD, BagStructure, largest_radius, mean_ahead
from codend.bag.measure_kernels import catch_volume, mean_by, rows_ahead, write_corners, write_openings
from codend.compiled import njit
from codend.mechanics.catch_front import fill
from codend.mechanics.catch_weight import add_force as add_weight
from codend.mechanics.drag import add_force as add_drag
from codend.mechanics.pressure import Catch
from codend.mechanics.pressure import add_force as add_pressure
from codend.mechanics.structure import Structure
from codend.mechanics.water import Water
from codend.net.net import Floats

Estimated = tuple[float, float, float, float]
"""Drag, N, catch volume, m3, largest radius, m, and opening ahead, degrees."""


@njit(cache=True, error_model="numpy")
def drag(structure: Structure, water: Water, catch: Catch, position: Floats, share: Floats) -> float:
    """Drag of the whole net, of its twine and of the catch, N."""
    on_twine, by_catch = np.zeros_like(position), np.zeros_like(position)
    add_drag(position, np.empty((0, 3)), structure, water, catch, share, on_twine)
    add_pressure(position, structure, catch, share, by_catch)
    add_weight(position, structure, catch, share, by_catch)
    return structure.order * np.sum(on_twine[:, 0]) + structure.order * np.sum(by_catch[:, 0])


@njit(cache=True, error_model="numpy")
def opening_ahead(bag: BagStructure, position: Floats, share: Floats) -> float:
    """Mean opening in the mesh rows just ahead of the front, degrees: that of no other row is measured."""
    ahead = rows_ahead(share, bag.band_meshes, bag.globalisation, ROWS_AHEAD)
    if len(ahead) == 0:
        return np.nan
    count = len(bag.mesh_place)
    has_mesh = np.zeros(count, dtype=np.bool_)
    for mesh in range(len(bag.mesh_row)):
        if bag.mesh_of_section[mesh]:
            has_mesh[bag.mesh_row[mesh]] = True
    # rows with meshes that are nearest to the first of these from before, and to the last from behind
    first, last = 0, count
    for row in range(count - 1, -1, -1):
        if has_mesh[row] and bag.mesh_place[row] >= ahead.max():
            last = row + 1
    for row in range(last):
        if has_mesh[row] and bag.mesh_place[row] <= ahead.min():
            first = row
    has_mesh[:first], has_mesh[last:] = False, False
    some, found = np.empty(len(bag.mesh_row), dtype=np.int64), 0
    for mesh in range(len(bag.mesh_row)):
        if has_mesh[bag.mesh_row[mesh]] and bag.mesh_of_section[mesh]:
            some[found] = mesh
            found += 1
    some = some[:found]
    corners, opening, normal = np.empty((found, 4, 2, 3)), np.empty(found), np.empty((found, 3))
    write_corners(position, bag.sides[some], bag.side_image[some], bag.order, corners)
    write_openings(corners, bag.mesh_is_staggered[some], bag.mesh_is_folded[some], opening, normal)
    return mean_ahead(bag, share, mean_by(bag.mesh_row[some], opening, count), has_mesh)


@njit(cache=True, error_model="numpy")
def estimated(
    bag: BagStructure, structure: Structure, water: Water, catch: Catch, position: Floats, share: Floats
) -> Estimated:
    """Drag, the catch's volume, largest radius and opening ahead."""
    volume = catch_volume(position, structure, catch, share)
    radius = largest_radius(bag, position)
    return drag(structure, water, catch, position, share), volume, radius, opening_ahead(bag, position, share)


@njit(cache=True, error_model="numpy")
def estimated_and_changed(
    bag: BagStructure,
    structure: Structure,
    water: Water,
    catch: Catch,
    position: Floats,
    share: Floats,
    changed: Catch,
    shape: Floats,
) -> tuple[Estimated, float]:
    """The same, and the drag with a catch that presses otherwise, in the shape that the net has then, N, (n, 3)."""
    found, of_shape = estimated(bag, structure, water, catch, position, share), share.copy()
    fill(shape, structure, changed, of_shape)
    return found, drag(structure, water, changed, shape, of_shape)
