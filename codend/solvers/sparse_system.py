"""Wide nets factorised by SuperLU in its symmetric mode, which always works."""

from typing import Any

import numpy as np

from codend.net.net import Floats, Ints
from codend.solvers.sparse_kernels import columns_in_order

LEAVES, PANEL = 1, 8
"""Columns at the leaves of the elimination tree that SuperLU takes as one, and columns that it updates together: nets
fill in so little that its defaults take twice as long for 3000 unknowns, and half as long again for 50 000."""


class SparseSystem:
    """SuperLU in its symmetric mode."""

    name = "SuperLU"
    worthwhile_fall = 0.7

    def __init__(self, unknown: Ints, row: Ints, column: Ints) -> None:
        self.size = int(unknown.max(initial=-1)) + 1
        self.unknown = unknown
        """Number of the unknown of every coordinate, -1 for held ones, (n, coordinates)."""
        self._free = unknown >= 0
        self._number = unknown[self._free]
        self._gather, self._indices, self._starts = columns_in_order(row.reshape(-1), column.reshape(-1), self.size)
        self._factors: Any = None

    @property
    def ready(self) -> bool:
        """See ``LinearSystem``."""
        return self._factors is not None

    def factorise(self, blocks: Floats) -> int:
        """See ``LinearSystem``."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        matrix = csc_array((self._entries(blocks), self._indices, self._starts), shape=(self.size, self.size))
        self._factors = None
        try:
            self._factors = splu(
                matrix,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                relax=LEAVES,
                panel_size=PANEL,
                options={"SymmetricMode": True},
            )
        except RuntimeError:
            return -1
        return 0

    def _entries(self, blocks: Floats) -> Floats:
        """Entries by column: gathered, not added up by scipy, which would drop zeros and with them the pattern."""
        return blocks.reshape(-1)[self._gather]

    def solve(self, right: Floats) -> Floats:
        """See ``LinearSystem``."""
        sides = np.empty((self.size, len(right)))
        sides[self._number] = right[:, self._free].T
        solved = self._factors.solve(sides)
        solution = np.zeros_like(right)
        solution[:, self._free] = solved[self._number].T
        return solution

    def negative_pivots(self) -> int:
        """See ``LinearSystem``; the factor must be copied out of SuperLU, which takes about half a factorisation."""
        return int(np.count_nonzero(self._factors.U.diagonal() < 0.0))
