"""Nets that are their own mirror image in the plane y = 0 and stay so: only one half of the unknowns is factorised.

Where net and loads have a mirror plane, moves that have it too are all that a mirrored right side asks for. They have
half the unknowns: those of the nodes on one side, and of the nodes on the plane those along it. The plane's own rows
hold for both halves at once, so nothing is approximated. Of a full net SuperLU takes a third of the time.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats, Ints, Net
from codend.solvers.sparse_system import SparseSystem

ACROSS = np.array([1.0, -1.0, 1.0])
"""What a reflection in y = 0 does to the coordinates."""
NEAR = 1e-9
"""Distance of a node from another's image, over the length of a bar, that is round-off."""


def mirrored_nodes(net: Net) -> Ints | None:
    """The node that each node of a net is the image of in y = 0, (n,); None unless bars and supports are images too."""
    from scipy.spatial import cKDTree

    near = NEAR * float(net.bar_length.min())
    apart, found = cKDTree(net.positions).query(net.positions * ACROSS)
    image = np.asarray(found, dtype=np.int32)
    if np.max(apart) > near or not np.array_equal(image[image], np.arange(len(image))):
        return None
    same = [net.bar_length, net.bar_flexibility, net.bar_drag_diameter, net.bar_is_strut.astype(float)]
    own, theirs = (_in_order(ends, len(image), same) for ends in (net.bars, image[net.bars]))
    mirrored = np.array_equal(own, theirs) and np.array_equal(net.fixed[image], net.fixed)
    return image if mirrored else None


def _in_order(ends: NDArray[np.integer], nodes: int, values: list[Floats]) -> Floats:
    """A row a bar, its ends and what it is, whichever way and in whichever order bars are written."""
    low, high = ends.min(axis=1).astype(np.float64), ends.max(axis=1)
    rows = np.stack([low * nodes + high, *values])
    return rows[:, np.lexsort(rows[::-1])]


def made_mirrored(positions: Floats, image: Ints) -> Floats:
    """Positions (n, 3) that are images to the last digit: stiff bars make forces of what is left."""
    exact = positions.copy()
    first = np.flatnonzero(np.arange(len(image)) < image)
    exact[image[first]] = positions[first] * ACROSS
    exact[image == np.arange(len(image)), 1] = 0.0
    return exact


class MirroredSystem(SparseSystem):
    """SuperLU for the half of a mirrored net; solutions are mirrored, whatever the right sides are."""

    name = "SuperLU of one half"

    def __init__(self, structure: Structure, pattern: Pattern, image: Ints) -> None:
        nodes = np.arange(len(image))
        self._half = nodes <= image
        free = structure.free > 0.0
        own = free & self._half[:, None]
        own[nodes == image, 1] = False
        unknown = np.full(own.shape, -1, dtype=np.int32)
        unknown[own] = np.arange(np.count_nonzero(own))
        self.size = int(np.count_nonzero(own))
        self._unknown = unknown[np.minimum(nodes, image)]
        self._sign = np.where(self._half[:, None], 1.0, ACROSS)
        row = np.repeat(self._unknown[pattern.row][:, :, None], 3, axis=2).ravel()
        column = np.repeat(self._unknown[pattern.column][:, None, :], 3, axis=1).ravel()
        used = np.flatnonzero((row >= 0) & (column >= 0) & np.repeat(self._half[pattern.row], 9))
        place, self._place = np.unique(column[used].astype(np.int64) * self.size + row[used], return_inverse=True)
        self._indices = (place % self.size).astype(np.int32)
        self._starts = np.searchsorted(place, self.size * np.arange(self.size + 1)).astype(np.int32)
        self._gather = used
        self._weight = np.repeat(self._sign[pattern.column], 3, axis=0).ravel()[used]
        self._factors: Any = None

    def _entries(self, blocks: Floats) -> Floats:
        """See ``SparseSystem``: entries of both halves' nodes are added up where they meet."""
        weighted = self._weight * blocks.reshape(-1)[self._gather]
        return np.bincount(self._place, weights=weighted, minlength=len(self._indices)).astype(np.float64)

    def solve(self, right: Floats) -> Floats:
        """See ``LinearSystem``; what a right side has that is not mirrored is left out."""
        own = (self._unknown >= 0) & self._half[:, None]
        sides = np.empty((self.size, len(right)))
        sides[self._unknown[own]] = right[:, own].T
        solved = self._factors.solve(sides)
        solution = np.zeros_like(right)
        known = self._unknown >= 0
        solution[:, known] = solved[self._unknown[known]].T * self._sign[known]
        return solution
