"""Whether a net has passed through itself at its axis: a kernel.

A net of hinged bars can pass through itself where it is narrow, and balance on the other side of its axis; twine
cannot. A band has passed through when the ends of its bars lie on opposite sides of their rings' middles, on the mean
of the band: when the rings of knots at its ends are turned against each other by more than a right angle.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.images import turned
from codend.mechanics.pressure import Catch
from codend.mechanics.structure import Structure
from codend.net.net import Floats

THROUGH = 1e-6
"""Scalar product of two knots from the middles of their rings, over a bar squared, that is no round-off any more."""


@njit(cache=True)
def passed_through_itself(position: Floats, structure: Structure, catch: Catch) -> bool:
    """Whether any band of a net has passed through itself; bars that lie in a ring do not count.

    The rings of a sector have their middles on the axis, those of a full net where their knots have theirs.
    """
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    bands, rows, lengths = catch.bar_band, catch.node_row, structure.length
    count = len(catch.band_meshes)
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
