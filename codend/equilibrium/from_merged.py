"""A start for a net out of the equilibrium of the same net with meshes merged, which is found in a moment.

Both are seen as sheets: how far along the netting a node lies, in rows of the real net, and how far round, as the nets
are built. Rings of the merged net tell where its sheet is, and bars of either lean what it pulls with.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.equilibrium.start_shapes import START
from codend.net.net import Floats
from codend.solvers.outcome import Solution


def from_merged(merged: Bag, found: Solution, bag: Bag) -> Solution:
    """Shape and tensions for a net, or a sector of it, from those of the same with more meshes merged."""
    finer = bag.globalisation / merged.globalisation
    positions = bag.net.positions.copy()
    along, around = _places(bag)
    rings = _rings(merged, found.positions)
    rows = np.arange(merged.bands + 1) / finer
    # axial place, radius and how far round from where it was built, of every ring at every node's azimuth
    ahead = np.clip(np.searchsorted(rows, along, side="right") - 1, 0, merged.bands - 1)
    share = (along - rows[ahead]) / (rows[ahead + 1] - rows[ahead])
    moved = np.zeros((len(positions), 3))
    for row in np.unique(ahead):
        here = np.flatnonzero(ahead == row)
        fore, aft = (_at(rings[r], around[here], merged.net.order) for r in (row, row + 1))
        # the codline has no azimuth
        aft[:, 2] = fore[:, 2] if row + 1 == merged.bands else aft[:, 2]
        moved[here] = (1.0 - share[here, None]) * fore + share[here, None] * aft
    turn = around + moved[:, 2]
    sheet = np.stack([moved[:, 0], moved[:, 1] * np.cos(turn), moved[:, 1] * np.sin(turn)], axis=1)
    free = ~bag.net.fixed
    positions[free] = sheet[free]
    return Solution(positions, _pulls(merged, found, bag, finer), np.zeros(bag.bands), replace(START))


def _places(bag: Bag) -> tuple[Floats, Floats]:
    """How far along the netting, in rows, and how far round, rad, every node of a net is built, each (n,)."""
    start, ringed = bag.net.positions, bag.node_row >= 0
    x = np.array([start[ringed & (bag.node_row == row), 0].mean() for row in range(bag.bands + 1)])
    along = np.where(ringed, bag.node_row, np.interp(start[:, 0], np.maximum.accumulate(x), np.arange(bag.bands + 1)))
    return along, np.arctan2(start[:, 2], start[:, 1])


def _rings(bag: Bag, positions: Floats) -> list[Floats]:
    """Of every ring its knots by azimuth as built: that, axial place, radius and turn since, (rows + 1, k, 4)."""
    rings = []
    built = np.arctan2(bag.net.positions[:, 2], bag.net.positions[:, 1])
    radius = np.hypot(positions[:, 1], positions[:, 2])
    turn = np.arctan2(positions[:, 2], positions[:, 1]) - built
    turn = np.where(radius > 0.0, (turn + np.pi) % (2.0 * np.pi) - np.pi, 0.0)
    known = np.stack([built, positions[:, 0], radius, turn], axis=1)
    of_netting = np.arange(len(positions)) < len(positions) - bag.anchors
    for row in range(bag.bands + 1):
        rings.append(known[of_netting & (bag.node_row == row)])
    return rings


def _at(ring: Floats, around: Floats, order: float) -> Floats:
    """What a ring tells at azimuths, (k, columns - 1), straight between its knots and their images."""
    period = 2.0 * np.pi / order
    return np.stack([np.interp(around, ring[:, 0], ring[:, i], period=period) for i in range(1, ring.shape[1])], axis=1)


def _leans(bag: Bag) -> tuple[NDArray[np.int64], Floats]:
    """Of every bar which way it leans as built, -1, 0 or 1, ropes 2, straps 3, and its middle's azimuth, (m,)."""
    net, (along, around) = bag.net, _places(bag)
    first, second = net.bars.T
    turned = around[second] + 2.0 * np.pi / net.order * net.bar_image - around[first]
    turned = (turned + np.pi) % (2.0 * np.pi) - np.pi
    sense = np.sign(along[second] - along[first])
    lean = np.where(np.abs(turned) > 1e-6, np.sign(turned) * sense, 0).astype(np.int64)
    lean[bag.ropes], lean[bag.straps] = 2, 3
    return lean, around[first] + 0.5 * turned


def _pulls(merged: Bag, found: Solution, bag: Bag, finer: float) -> Floats:
    """Tensions: of netting the merged ones shared out, of ropes and straps, which are not merged, as they are."""
    (lean, around), (own_lean, own_around) = _leans(merged), _leans(bag)
    band = np.minimum((bag.bar_band * finer).astype(int), merged.bands - 1)
    pulls = np.zeros(len(own_lean))
    for which in np.unique(own_lean):
        for row in np.unique(band):
            own = np.flatnonzero((own_lean == which) & (band == row))
            theirs = (merged.bar_band == row) & (lean == which)
            if len(own) == 0 or not theirs.any():
                continue
            known = np.stack([around[theirs], found.bar_tension[theirs]], axis=1)
            share = 1.0 if which >= 2 else finer
            pulls[own] = share * _at(known, own_around[own], merged.net.order)[:, 0]
    return pulls
