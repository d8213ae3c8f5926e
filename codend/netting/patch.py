"""A straight piece of netting that is let into the lattice: its knots, and what joins them.

Places are counted in rows from its fore edge and in half meshes from its left one, 0 to 2 W, seen from outside with the
codline behind. Netting whose rows are turned by half a mesh has knots where row and half mesh are both even or both
odd, so that every other row begins on the side edges; square netting has them at every even half mesh. Nodes are asked
for by ports, as those of the lattice (``netting.knots``); on the edges they are those it is sewn to.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codend.netting.knots import LEFT, RIGHT
from codend.netting.lattice import Counts
from codend.plan.tables import Netting

FORE, AFT = range(2)
"""Ends of a knot: where twines from ahead end, and where those behind start."""

Line = tuple[Counts, ...]
"""Nodes side by side, one array a corner of what they belong to."""


@dataclass(frozen=True)
class Patch:
    """The piece, its nodes found."""

    netting: Netting
    wide: int
    """Meshes across."""
    rows: int
    """Bands between its rows."""
    nodes: NDArray[np.int64]
    """By end, side, row and half mesh; -1 where no knot is, (2, 2, rows + 1, 2 W + 1)."""
    own: NDArray[np.int64]
    """Row, half mesh, whether fore (1), and side (-1 left, 0 middle, 1 right) of every own node, (k, 4)."""
    knots: NDArray[np.int64]
    """Ends of its own knots that have a length, and their rows, (k, 3)."""

    @property
    def staggered(self) -> bool:
        """Whether every other row is turned by half a mesh."""
        return self.netting.kind.staggered

    def halves(self, row: int) -> Counts:
        """Half meshes at which a row has knots."""
        start = row % 2 if self.staggered else 0
        return np.arange(start, 2 * self.wide + 1, 2)

    def twines(self, side_edges: bool, end_edges: bool) -> Iterator[tuple[Line, int, int]]:
        """Ends of bars of twine, row by row, and the rows of either.

        Square netting has bars along its edges: where the netting it is let into has none there, they are asked for.
        """
        nodes, last = self.nodes, 2 * self.wide
        for row in range(self.rows):
            h = self.halves(row)
            if self.staggered:
                right, left = h[h < last], h[h > 0]
                yield (nodes[AFT, RIGHT, row, right], nodes[FORE, LEFT, row + 1, right + 1]), row, row + 1
                yield (nodes[AFT, LEFT, row, left], nodes[FORE, RIGHT, row + 1, left - 1]), row, row + 1
            else:
                h = h if side_edges else h[1:-1]
                yield (nodes[AFT, LEFT, row, h], nodes[FORE, LEFT, row + 1, h]), row, row + 1
        if not self.staggered:
            for row in range(0 if end_edges else 1, self.rows + (1 if end_edges else 0)):
                ring = nodes[AFT, LEFT, row, self.halves(row)]
                yield (ring[:-1], ring[1:]), row, row

    def quadrangles(self) -> Iterator[tuple[Line, int, int]]:
        """Corners of the netting between the twines, half meshes at the side edges left out, and rows of its ends."""
        nodes, last = self.nodes, 2 * self.wide
        for row in range(self.rows):
            h = self.halves(row)
            aft, fore = nodes[AFT], nodes[FORE]
            if self.staggered:
                m = h[(h > 0) & (h < last)]
                ends = fore[LEFT, row + 1, m + 1], fore[RIGHT, row + 1, m - 1]
                yield (aft[LEFT, row, m], aft[RIGHT, row, m], *ends), row, row + 1
                h = h[h < last - 1]
                ends = fore[RIGHT, row + 1, h + 1], fore[LEFT, row + 1, h + 1]
                yield (aft[RIGHT, row, h], aft[LEFT, row, h + 2], *ends), row, row + 1
            else:
                a, b, m = h[:-1], h[1:], h[1:-1]
                ends = fore[LEFT, row + 1, b], fore[RIGHT, row + 1, a]
                yield (aft[RIGHT, row, a], aft[LEFT, row, b], *ends), row, row + 1
                # the width of knots that it is sewn to
                ends = fore[RIGHT, row + 1, m], fore[LEFT, row + 1, m]
                yield (aft[LEFT, row, m], aft[RIGHT, row, m], *ends), row, row + 1
            # between knots that lie along the netting
            h = self.halves(row + 1)
            ends = aft[LEFT, row + 1, h[1:]], aft[RIGHT, row + 1, h[:-1]]
            yield (fore[RIGHT, row + 1, h[:-1]], fore[LEFT, row + 1, h[1:]], *ends), row + 1, row + 1
            m = h[(h > 0) & (h < last)]
            ends = aft[RIGHT, row + 1, m], aft[LEFT, row + 1, m]
            yield (fore[LEFT, row + 1, m], fore[RIGHT, row + 1, m], *ends), row + 1, row + 1

    def meshes(self) -> Iterator[tuple[list[tuple[Counts, Counts]], float]]:
        """Sides of whole meshes, each as its two nodes, and the row of their middle."""
        aft, fore = self.nodes[AFT], self.nodes[FORE]
        for row in range(0 if not self.staggered else 1, self.rows):
            h = self.halves(row)[:-1]
            if self.staggered:
                m, after = h + 1, h + 2
                yield (
                    [
                        (aft[RIGHT, row - 1, m], fore[LEFT, row, after]),
                        (aft[LEFT, row, after], fore[RIGHT, row + 1, m]),
                        (fore[LEFT, row + 1, m], aft[RIGHT, row, h]),
                        (fore[RIGHT, row, h], aft[LEFT, row - 1, m]),
                    ],
                    float(row),
                )
            else:
                a, b = aft[LEFT, row, h], aft[LEFT, row, h + 2]
                c, d = fore[LEFT, row + 1, h + 2], fore[LEFT, row + 1, h]
                yield [(a, b), (b, c), (c, d), (d, a)], row + 0.5

    @cached_property
    def deep(self) -> int:
        """Points that a side edge has, less one."""
        return self.rows // 2 if self.staggered else self.rows

    def side(self, right: bool) -> list[tuple[float, list[int]]]:
        """Nodes nearest to a side edge from the fore end: how far down, as a share, and the fore and the aft one."""
        last, chain = 2 * self.wide, []
        for row in range(self.rows + 1):
            h = row % 2 if self.staggered else 0
            # a knot on the edge is seen from its far side
            facing = (LEFT if right else RIGHT) if h == 0 else (RIGHT if right else LEFT)
            place = last - h if right else h
            chain.append((row / self.rows, [int(self.nodes[end, facing, row, place]) for end in (FORE, AFT)]))
        return chain


def patch_of(netting: Netting, wide: int, rows: int, first: int, sewn: Callable[..., int | None]) -> Patch:
    """Number the nodes of a piece.

    Args:
        netting: what it is made of.
        wide: meshes across.
        rows: bands between its rows.
        first: number of its first own node.
        sewn: node of the lattice at an end, side, row and half mesh of it; None where it has one of its own.
    """
    nodes = np.full((2, 2, rows + 1, 2 * wide + 1), -1, dtype=np.int64)
    own: list[tuple[int, int, int, int]] = []
    knots: list[tuple[int, int, int]] = []
    along, across = netting.knot_along_m > 0.0, netting.knot_across_m > 0.0
    for row in range(rows + 1):
        for half in range(row % 2 if netting.kind.staggered else 0, 2 * wide + 1, 2):
            numbered: dict[tuple[bool, int], int] = {}
            for end in (FORE, AFT):
                for side in (LEFT, RIGHT):
                    there = sewn(end, side, row, half)
                    if there is None:
                        key = (along and end == FORE, (2 * side - 1) * across)
                        if key not in numbered:
                            numbered[key] = first + len(own)
                            own.append((row, half, int(key[0]), key[1]))
                        there = numbered[key]
                    nodes[end, side, row, half] = there
            if along and numbered:
                knots.append((int(nodes[FORE, LEFT, row, half]), int(nodes[AFT, LEFT, row, half]), row))
            if across and numbered:
                knots.append((int(nodes[AFT, LEFT, row, half]), int(nodes[AFT, RIGHT, row, half]), row))
    return Patch(netting, wide, rows, nodes, np.array(own).reshape(-1, 4), np.array(knots).reshape(-1, 3))
