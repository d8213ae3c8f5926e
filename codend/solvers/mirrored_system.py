"""Nets that are their own mirror image and stay so: only one half of the unknowns is factorised.

Where net and loads have a mirror plane, moves that have it too are all that a mirrored right side asks for. They have
half the unknowns: those of the nodes on one side, and of the nodes on the plane those along it. The plane's own rows
hold for both halves at once, so nothing is approximated. A half is half as wide: SuperLU takes a third of the time of a
full net for it, and of a sector it is often narrow enough for a band LU.
"""

import numpy as np

from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats, Ints
from codend.solvers.linear_systems import WIDEST_BAND, fitting_system, narrow_numbering
from codend.solvers.mirror import Mirror


class MirroredSystem:
    """A system for the half of a mirrored net; solutions are mirrored, whatever the right sides are."""

    def __init__(self, structure: Structure, pattern: Pattern, mirror: Mirror) -> None:
        from scipy.sparse import csr_array

        own, weight, size = _unknowns(structure, mirror)
        of_half = np.flatnonzero(np.arange(len(mirror.node)) <= mirror.node)
        coordinate = 3 * len(mirror.node)
        there = own >= 0
        place = np.nonzero(there)
        self._expand = csr_array((weight[there], (3 * place[0] + place[1], own[there])), shape=(coordinate, size))
        half = np.zeros(len(mirror.node), dtype=bool)
        half[of_half] = True
        rows = np.repeat(half, 3)[3 * place[0] + place[1]]
        self._reduce = csr_array(
            (weight[there][rows], (own[there][rows], (3 * place[0] + place[1])[rows])), shape=(size, coordinate)
        )
        # entry (i, j) of a block goes to every unknown that coordinate i is part of, and every one that moves j
        block = np.flatnonzero(half[pattern.row])
        shape = (len(block), 3, 3, own.shape[2], own.shape[2])
        row = np.broadcast_to(own[pattern.row[block]][:, :, None, :, None], shape)
        column = np.broadcast_to(own[pattern.column[block]][:, None, :, None, :], shape)
        used = (row >= 0) & (column >= 0)
        of_row, of_column = weight[pattern.row[block]], weight[pattern.column[block]]
        self._weight = (of_row[:, :, None, :, None] * of_column[:, None, :, None, :])[used]
        entry = 9 * block[:, None, None] + np.arange(9).reshape(3, 3)
        self._gather = np.broadcast_to(entry[..., None, None], shape)[used]
        key, self._place = np.unique(row[used].astype(np.int64) * size + column[used], return_inverse=True)
        rows_of, columns_of = (key // size).astype(np.int32), (key % size).astype(np.int32)
        number = narrow_numbering(rows_of, columns_of, size)
        self._half = fitting_system(number[:, None], number[rows_of], number[columns_of], WIDEST_BAND)
        self._entries, self._nodes = len(key), len(mirror.node)
        self.name, self.worthwhile_fall = f"{self._half.name} of one half", self._half.worthwhile_fall

    @property
    def ready(self) -> bool:
        """See ``LinearSystem``."""
        return self._half.ready

    def factorise(self, blocks: Floats) -> int:
        """See ``LinearSystem``: entries of both halves' nodes are added up where they meet."""
        weighted = self._weight * blocks.reshape(-1)[self._gather]
        entries: Floats = np.bincount(self._place, weights=weighted, minlength=self._entries).astype(np.float64)
        return self._half.factorise(entries)

    def solve(self, right: Floats) -> Floats:
        """See ``LinearSystem``; what a right side has that is not mirrored is left out."""
        sides = (self._reduce @ right.reshape(len(right), -1).T).T
        solved = self._half.solve(np.ascontiguousarray(sides)[:, :, None])
        whole: Floats = np.ascontiguousarray((self._expand @ solved[:, :, 0].T).T)
        return whole.reshape(right.shape)

    def negative_pivots(self) -> int:
        """See ``LinearSystem``: of mirrored moves alone."""
        return self._half.negative_pivots()


def _unknowns(structure: Structure, mirror: Mirror) -> tuple[Ints, Floats, int]:
    """Unknowns that every coordinate moves with, at most two, -1 for none, their weights (n, 3, 2), and their number.

    A node beside the plane has one for every free coordinate, and its image the same; one on the plane has one along
    the axis and one away from it.
    """
    nodes = np.arange(len(mirror.node))
    free = structure.free > 0.0
    beside, on_plane = nodes < mirror.node, nodes == mirror.node
    asked = free & beside[:, None]
    asked[on_plane] = np.stack([free[on_plane, 0], free[on_plane, 1:].all(axis=1), np.zeros(on_plane.sum(), bool)], 1)
    number = np.where(asked, np.cumsum(asked.ravel()).reshape(asked.shape) - 1, -1).astype(np.int32)
    own = np.full((*free.shape, 2), -1, dtype=np.int32)
    weight = np.zeros(own.shape)
    own[beside, :, 0], weight[beside, :, 0] = number[beside], 1.0
    away = 0.5 * np.arctan2(mirror.turn[:, 1, 2], mirror.turn[:, 1, 1])[on_plane]
    own[on_plane, 0, 0], weight[on_plane, 0, 0] = number[on_plane, 0], 1.0
    for i, component in ((1, np.cos(away)), (2, np.sin(away))):
        part = np.where(np.abs(component) < 1e-12, 0.0, component)
        own[on_plane, i, 0] = np.where(part != 0.0, number[on_plane, 1], -1)
        weight[on_plane, i, 0] = part
    image = nodes > mirror.node
    turn, of = mirror.turn[image], number[mirror.node[image]]
    for i in range(3):
        filled = np.zeros(len(turn), dtype=np.int64)
        for j in range(3):
            there = turn[:, i, j] != 0.0
            which = np.flatnonzero(image)[there]
            own[which, i, filled[there]] = of[there, j]
            weight[which, i, filled[there]] = turn[there, i, j]
            filled += there
    return own, weight, int(asked.sum())
