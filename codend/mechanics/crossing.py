"""Whether a net has passed through itself at its axis, or lies in folds on the catch: kernels.

A net of hinged bars can pass through itself where it is narrow, and balance on the other side of its axis; twine
cannot. A band has passed through when the ends of its bars lie on opposite sides of their rings' middles, on the mean
of the band: when the rings of knots at its ends are turned against each other by more than a right angle.

Netting to spare round the catch can also balance in folds, where facets face inward; the catch fills no folds, and its
pressure would push such facets the wrong way.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.arrays import Structure
from codend.mechanics.images import turned
from codend.mechanics.pressure import area_vector, corners_of_facet
from codend.net import Floats

THROUGH = 1e-6
"""Scalar product of two knots from the middles of their rings, over a bar squared, that is no round-off any more."""
FOLDED = 1e-3
"""Share of the area on the catch that may face inward."""


@njit(cache=True)
def passed_through_itself(position: Floats, structure: Structure) -> bool:
    """Whether any band of a net has passed through itself; bars that lie in a ring do not count.

    The rings of a sector have their middles on the axis, those of a full net where their knots have theirs.
    """
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    bands, rows, lengths = structure.bar_band, structure.node_row, structure.length
    count = len(structure.band_meshes)
    middles, meeting, bars = np.zeros((count, 4)), np.zeros(count), np.zeros(count)
    shortest = np.inf
    for middling in (True, False):
        for bar in range(len(bands)):
            first, second, band = firsts[bar], seconds[bar], bands[bar]
            if rows[first] == rows[second]:
                continue
            y, z = turned(position[second, 1], position[second, 2], images[bar], rotations)
            if middling:
                bars[band] += 1.0
                shortest = min(shortest, lengths[bar])
                if structure.order == 1.0:
                    middles[band, 0] += position[first, 1]
                    middles[band, 1] += position[first, 2]
                    middles[band, 2] += y
                    middles[band, 3] += z
            else:
                fore_y, fore_z = position[first, 1] - middles[band, 0], position[first, 2] - middles[band, 1]
                meeting[band] += fore_y * (y - middles[band, 2]) + fore_z * (z - middles[band, 3])
        if middling:
            for band in range(count):
                for i in range(4):
                    middles[band, i] /= max(bars[band], 1.0)
    through = False
    for band in range(count):
        through = through or meeting[band] < -THROUGH * shortest * shortest * bars[band]
    return through


@njit(cache=True)
def folded_on_catch(position: Floats, structure: Structure, share: Floats) -> bool:
    """Whether netting on the catch faces inward: against the meridian of its rings of knots, turned outward."""
    rows, sizes = structure.node_row, structure.row_size
    # axial and sideways position of every ring's middle, and its radius
    rings = np.zeros((len(sizes), 4))
    for radii in (False, True):
        for node in range(len(rows)):
            row = rows[node]
            if row < 0:
                continue
            x, y, z = position[node, 0], position[node, 1], position[node, 2]
            if radii:
                rings[row, 3] += np.hypot(y - rings[row, 1], z - rings[row, 2]) / sizes[row]
            else:
                rings[row, 0] += x / sizes[row]
                if structure.order == 1.0:
                    rings[row, 1] += y / sizes[row]
                    rings[row, 2] += z / sizes[row]
    facets, images, rotations = structure.facets, structure.facet_image, structure.rotations
    bands, weights = structure.facet_band, structure.facet_weight
    inward, whole = 0.0, 0.0
    for facet in range(len(bands)):
        band = bands[facet]
        if share[band] == 0.0:
            continue
        corners = corners_of_facet(position, facets, images, rotations, facet)
        area = area_vector(corners)
        y = (corners[1] + corners[4] + corners[7]) / 3.0 - 0.5 * (rings[band, 1] + rings[band + 1, 1])
        z = (corners[2] + corners[5] + corners[8]) / 3.0 - 0.5 * (rings[band, 2] + rings[band + 1, 2])
        along, across = rings[band + 1, 0] - rings[band, 0], rings[band + 1, 3] - rings[band, 3]
        outward = along * (y * area[1] + z * area[2]) - across * np.hypot(y, z) * area[0]
        size = share[band] * weights[facet] * np.sqrt(area[0] ** 2 + area[1] ** 2 + area[2] ** 2)
        whole += size
        if outward < 0.0:
            inward += size
    return inward > FOLDED * whole
