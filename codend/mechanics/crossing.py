"""How a net is turned about its axis from band to band, and whether one has gone through itself there: a kernel.

A net of hinged bars can pass through itself where it is narrow, and balance on the other side of its axis; twine
cannot. A band has passed through when the ends of its bars lie on opposite sides of their rings' middles, on the mean
of the band: when the rings of knots at its ends are turned against each other by more than a right angle. Turned by
less in every band but by as much over several, a net is wrung: it has crossed its axis little by little. Where a ring
is drawn together to a point no azimuth tells its turn: there the rings on either side are held to each other.
"""

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.images import turned
from codend.mechanics.pressure import Catch
from codend.mechanics.rings import Rings, turn_as_built
from codend.mechanics.structure import Structure
from codend.net.net import Floats

THROUGH = 1e-6
"""Scalar product of two knots from the middles of their rings, over a bar squared, that is no round-off any more."""


@njit(cache=True)
def band_turns(position: Floats, structure: Structure, catch: Catch, rings: Rings) -> tuple[Floats, int]:
    """Turn of every band about the axis, rad, (bands,), and the first band that has passed through itself, -1 for none.

    That of bands between a ring drawn together and the next is told by the rings beyond, and stands at the first. Bars
    that lie in a ring do not count. The rings of a sector have their middles on the axis, those of a full net
    where their knots have theirs. Twine that ends in nodes between two rings and what leads on from there are told
    apart: their turns add up.
    """
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    bands, rows, lengths = catch.bar_band, catch.node_row, structure.length
    count = len(catch.band_meshes)
    # of each band what leaves its fore ring, what lies between two nodes that are in no ring, and what ends in its aft
    middles, along, across, bars = (
        np.zeros((count, 3, 4)),
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        np.zeros((count, 3)),
    )
    shortest, whole = np.inf, structure.order == 1.0
    for middling in (True, False):
        if middling and not whole:
            continue
        for bar in range(len(bands)):
            first, second, band = firsts[bar], seconds[bar], bands[bar]
            if rows[first] == rows[second] and rows[first] >= 0:
                continue
            y, z = turned(position[second, 1], position[second, 2], images[bar], rotations)
            fore_y, fore_z, aft_y, aft_z = position[first, 1], position[first, 2], y, z
            part = 0 if band in (rows[first], rows[second]) else (1 if rows[first] == rows[second] else 2)
            # the node between two rings with the higher number is a hinge, ahead of a knot's
            forward = rows[first] == band if part == 0 else (rows[second] >= 0 if part == 2 else False)
            if not forward:
                fore_y, fore_z, aft_y, aft_z = aft_y, aft_z, fore_y, fore_z
            if middling == whole:
                bars[band, part] += 1.0
                shortest = min(shortest, lengths[bar])
            if middling:
                middles[band, part, 0] += fore_y
                middles[band, part, 1] += fore_z
                middles[band, part, 2] += aft_y
                middles[band, part, 3] += aft_z
            else:
                middle = middles[band, part]
                fore_y, fore_z, aft_y, aft_z = (
                    fore_y - middle[0],
                    fore_z - middle[1],
                    aft_y - middle[2],
                    aft_z - middle[3],
                )
                along[band, part] += fore_y * aft_y + fore_z * aft_z
                across[band, part] += fore_y * aft_z - fore_z * aft_y
        if middling:
            for band in range(count):
                for part in range(3):
                    for i in range(4):
                        middles[band, part, i] /= max(bars[band, part], 1.0)
    turns, drawn_together = np.zeros(count), np.zeros(count, dtype=np.bool_)
    through = -1
    for band in range(count - 1, -1, -1):
        for part in range(3):
            least = THROUGH * shortest * shortest * bars[band, part]
            if along[band, part] < -least:
                through = band
            if abs(along[band, part]) + abs(across[band, part]) > least:
                turns[band] += np.arctan2(across[band, part], along[band, part])
            elif bars[band, part] > 0.0:
                drawn_together[band] = True
    if drawn_together[:-1].any():
        _across_necks(position, drawn_together, rings, structure.order, np.sqrt(THROUGH) * shortest, turns)
    return turns, through


@njit(cache=True)
def whole_turn(position: Floats, structure: Structure, catch: Catch, rings: Rings) -> tuple[float, int]:
    """Turn of a net about its axis, rad, summed over its bands, and the first that has passed through itself or -1."""
    turns, through = band_turns(position, structure, catch, rings)
    return turns.sum(), through


@njit(cache=True)
def _across_necks(
    position: Floats, drawn_together: NDArray[np.bool_], rings: Rings, order: float, narrow: float, turns: Floats
) -> None:
    """Write the turns of bands drawn together, by the nearest rings on either side that are wider than ``narrow``."""
    ahead, turn_ahead = -1, 0.0
    for row in range(len(turns) + 1):
        radius, turn = turn_as_built(position, rings, row, order)
        if radius <= narrow:
            continue
        if ahead >= 0 and drawn_together[ahead:row].any():
            turns[ahead:row] = 0.0
            turns[ahead] = np.arctan2(np.sin(turn - turn_ahead), np.cos(turn - turn_ahead))
        ahead, turn_ahead = row, turn
