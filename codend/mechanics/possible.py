"""What no catch and no netting on it can be: without volume, inside out, its front behind the codline. Kernels."""

import numpy as np

from catch_models.filling import enclosed_volume
from codend.compiled import njit
from codend.mechanics.catch_front import band_geometry, row_positions
from codend.mechanics.crossing import whole_turn
from codend.mechanics.pressure import Catch, area_vector, corners_of_facet
from codend.mechanics.rings import Rings
from codend.mechanics.structure import Structure
from codend.mechanics.tube import maps_to_a_cone
from codend.net.net import Floats, Ints

POSSIBLE, NO_VOLUME, FRONT_BEHIND, INSIDE_OUT = range(4)
NOTHING = 1e-12
"""Volume over the cube of a bar, and length over a bar, that is round-off."""
MOST_INWARD = 0.5
"""Share of the netting on a catch that may face inward: of netting in folds it is a third, and less than half."""


@njit(cache=True)
def middles(position: Floats, structure: Structure, catch: Catch) -> tuple[Floats, Floats]:
    """Middles of the rows, (rows + 1, 3), and the direction of the bag, (3,).

    That of a full net, from the middle of its entry to its codline, is where it is towed or hangs; a sector's is x.
    """
    middle, axis = np.zeros((len(catch.row_size), 3)), np.array([1.0, 0.0, 0.0])
    last = 3 if structure.order == 1.0 else 1
    for node in range(len(catch.node_row)):
        row = catch.node_row[node]
        if row >= 0:
            for i in range(last):
                middle[row, i] += position[node, i] / catch.row_size[row]
    long = 0.0
    for i in range(last):
        long += (middle[-1, i] - middle[0, i]) ** 2
    if last == 3 and long > 0.0:
        for i in range(3):
            axis[i] = (middle[-1, i] - middle[0, i]) / np.sqrt(long)
    return middle, axis


@njit(cache=True)
def inward_share(position: Floats, structure: Structure, catch: Catch, share: Floats) -> float:
    """Share of the area of the facets on the catch that face inward, seen from the mean meridian of their band."""
    middle, axis = middles(position, structure, catch)
    rows, count = catch.node_row, len(middle)
    radius, out = np.zeros(count), np.empty(3)
    for node in range(len(rows)):
        row = rows[node]
        if row >= 0:
            for i in range(3):
                out[i] = position[node, i] - middle[row, i]
            radius[row] += _across(out, axis) / catch.row_size[row]
    inward, whole = 0.0, 0.0
    for facet in range(len(catch.facet_band)):
        band = catch.facet_band[facet]
        if share[band] == 0.0:
            continue
        corners = corners_of_facet(position, structure.facets, structure.facet_image, structure.rotations, facet)
        x, y, z = area_vector(corners)
        along = 0.0
        for i in range(3):
            out[i] = (corners[i] + corners[3 + i] + corners[6 + i]) / 3.0 - 0.5 * (
                middle[band, i] + middle[band + 1, i]
            )
            along += axis[i] * (middle[band + 1, i] - middle[band, i])
        far, across = _across(out, axis), radius[band + 1] - radius[band]
        aft = axis[0] * x + axis[1] * y + axis[2] * z
        size = share[band] * structure.facet_weight[facet] * np.sqrt(x * x + y * y + z * z)
        whole += size
        if along * (out[0] * x + out[1] * y + out[2] * z) < across * far * aft:
            inward += size
    return inward / whole if whole > 0.0 else 0.0


@njit(cache=True)
def _across(out: Floats, axis: Floats) -> float:
    """Leave of a vector what is across an axis, (3,), and tell its length."""
    along = out[0] * axis[0] + out[1] * axis[1] + out[2] * axis[2]
    squares = 0.0
    for i in range(3):
        out[i] -= along * axis[i]
        squares += out[i] ** 2
    return np.sqrt(squares)


@njit(cache=True)
def impossible(position: Floats, structure: Structure, catch: Catch, share: Floats) -> tuple[int, float]:
    """What is impossible about a catch in its net, and the number that tells it: volume (m3), distance (m) or share.

    A net without a catch has nothing to tell.
    """
    filled = 0.0
    for band in range(len(share)):
        filled += share[band]
    if filled == 0.0:
        return POSSIBLE, 0.0
    row_x, area, moment = np.empty(len(share) + 1), np.empty(len(share)), np.empty(len(share))
    row_positions(position, catch, row_x)
    band_geometry(position, structure, catch, area, moment)
    bar = structure.length.min()
    volume = enclosed_volume(row_x, area, moment, share)
    if volume <= NOTHING * bar**3:
        return NO_VOLUME, volume
    place = len(share) - filled
    row = min(int(place), len(share) - 1)
    middle, axis = middles(position, structure, catch)
    front = 0.0
    for i in range(3):
        front += axis[i] * (middle[-1, i] - middle[row, i] - (place - row) * (middle[row + 1, i] - middle[row, i]))
    # the catch fills it from its codline to a plane across the flow, whichever way a bag hangs
    along = row_x[-1] - row_x[row] - (place - row) * (row_x[row + 1] - row_x[row])
    if min(front, along) < -NOTHING * bar:
        return FRONT_BEHIND, min(front, along)
    inward = inward_share(position, structure, catch, share)
    if inward > MOST_INWARD:
        return INSIDE_OUT, inward
    return POSSIBLE, 0.0


@njit(cache=True)
def glance(
    position: Floats,
    structure: Structure,
    catch: Catch,
    rings: Rings,
    share: Floats,
    apex: int,
    rim: Ints,
    image: Ints,
) -> tuple[float, int, bool, int, float]:
    """All that is cheap to see of a shape: ``whole_turn``, whether nothing passes through anything, ``impossible``.

    Args:
        position: nodes, (n, 3).
        structure: the net.
        catch: what fills it.
        rings: its rings as built; of a net without there is no turn.
        share: of each band in the catch, (bands,); of none where that is not asked.
        apex: see ``Tube``, as the next two; -1 for a net that is none.
        rim: sides where it ends, (k, 2).
        image: of their second ends, (k,).
    """
    turn, through, is_one_to_one = 0.0, -1, False
    if len(rings.node) > 0:
        turn, through = whole_turn(position, structure, catch, rings)
    if apex >= 0:
        facets = structure.facets, structure.facet_image, structure.rotations
        is_one_to_one = maps_to_a_cone(position, *facets, structure.order, apex, rim, image)
    code, number = impossible(position, structure, catch, share)
    return turn, through, is_one_to_one, code, number
