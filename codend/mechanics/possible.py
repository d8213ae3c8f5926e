"""What no catch and no netting on it can be: without volume, inside out, its front behind the codline. Kernels."""

import numpy as np

from catch_models.filling import enclosed_volume
from codend.compiled import njit
from codend.mechanics.catch_front import band_geometry, row_positions
from codend.mechanics.pressure import Catch, area_vector, corners_of_facet
from codend.mechanics.structure import Structure
from codend.net.net import Floats

POSSIBLE, NO_VOLUME, FRONT_BEHIND, INSIDE_OUT = range(4)
NOTHING = 1e-12
"""Volume over the cube of a bar, and length over a bar, that is round-off."""
MOST_INWARD = 0.5
"""Share of the netting on a catch that may face inward: of netting in folds it is a third, and less than half."""


@njit(cache=True)
def inward_share(position: Floats, structure: Structure, catch: Catch, share: Floats, row_x: Floats) -> float:
    """Share of the area of the facets on the catch that face inward, seen from the mean meridian of their band."""
    rows, count = catch.node_row, len(row_x)
    middle, radius = np.zeros((count, 2)), np.zeros(count)
    if structure.order == 1.0:
        for node in range(len(rows)):
            if rows[node] >= 0:
                for i in range(2):
                    middle[rows[node], i] += position[node, 1 + i] / catch.row_size[rows[node]]
    for node in range(len(rows)):
        row = rows[node]
        if row >= 0:
            y, z = position[node, 1] - middle[row, 0], position[node, 2] - middle[row, 1]
            radius[row] += np.sqrt(y * y + z * z) / catch.row_size[row]
    inward, whole = 0.0, 0.0
    for facet in range(len(catch.facet_band)):
        band = catch.facet_band[facet]
        if share[band] == 0.0:
            continue
        corners = corners_of_facet(position, structure.facets, structure.facet_image, structure.rotations, facet)
        x, y, z = area_vector(corners)
        out_y = (corners[1] + corners[4] + corners[7]) / 3.0 - 0.5 * (middle[band, 0] + middle[band + 1, 0])
        out_z = (corners[2] + corners[5] + corners[8]) / 3.0 - 0.5 * (middle[band, 1] + middle[band + 1, 1])
        along, across = row_x[band + 1] - row_x[band], radius[band + 1] - radius[band]
        size = share[band] * structure.facet_weight[facet] * np.sqrt(x * x + y * y + z * z)
        whole += size
        if along * (out_y * y + out_z * z) < across * np.sqrt(out_y * out_y + out_z * out_z) * x:
            inward += size
    return inward / whole if whole > 0.0 else 0.0


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
    front = row_x[-1] - (row_x[row] + (place - row) * (row_x[row + 1] - row_x[row]))
    if front < -NOTHING * bar:
        return FRONT_BEHIND, front
    inward = inward_share(position, structure, catch, share, row_x)
    if inward > MOST_INWARD:
        return INSIDE_OUT, inward
    return POSSIBLE, 0.0
