"""The symmetric system for the tensions of rigid bars: ordered once for a net, factorised at every step."""

from typing import Literal

import numpy as np

from codend.mechanics.rigid import RigidPattern
from codend.net import Floats, Ints
from codend.solvers.linear_systems import BandedSystem
from codend.solvers.sparse_system import columns_in_order

WIDEST_BAND = 80
"""Half-bandwidth beyond which SuperLU is the faster (measured)."""


class TensionSystem:
    """Band LU where the bars can be numbered so that the band is narrow, else SuperLU in its symmetric mode."""

    def __init__(self, pattern: RigidPattern) -> None:
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import reverse_cuthill_mckee

        bars = len(pattern.diagonal)
        graph = csr_array((np.ones(len(pattern.row)), (pattern.row, pattern.column)), shape=(bars, bars))
        place = np.empty(bars, dtype=np.int32)
        place[reverse_cuthill_mckee(graph, symmetric_mode=True)] = np.arange(bars)
        row, column = place[pattern.row], place[pattern.column]
        half_band = int(np.abs(row - column).max(initial=0))
        self._bars = bars
        # the band solver takes its unknowns in threes
        self._padded = np.zeros((1, -(-bars // 3), 3))
        self._banded: BandedSystem | None = None
        if half_band <= WIDEST_BAND:
            unknown = np.full(self._padded[0].size, -1, dtype=np.int32)
            unknown[:bars] = place
            self._banded = BandedSystem(unknown.reshape(-1, 3), row, column, half_band)
        else:
            self._order = np.arange(bars, dtype=np.int32)
            self._lay_out(pattern.row, pattern.column, self._order)
            self._row, self._column = pattern.row, pattern.column
            self._ordering: Literal["MMD_AT_PLUS_A", "NATURAL"] = "MMD_AT_PLUS_A"

    def _lay_out(self, row: Ints, column: Ints, place: Ints) -> None:
        order = columns_in_order(place[row], place[column], self._bars)
        self._gather, self._indices, self._starts = order

    def factorise(self, entries: Floats) -> bool:
        """Factorise the system with these entries, (entries,); False if it is singular."""
        if self._banded is not None:
            return self._banded.factorise(entries) != -1
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        shape = (self._bars, self._bars)
        matrix = csc_array((entries[self._gather], self._indices, self._starts), shape=shape)
        try:
            self._factors = splu(
                matrix, permc_spec=self._ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError:
            return False
        if self._ordering != "NATURAL":
            # the order that SuperLU found stays good: the pattern does not change
            self._order = np.asarray(self._factors.perm_c, dtype=np.int32)
            self._lay_out(self._row, self._column, self._order)
            self._ordering = "NATURAL"
            return self.factorise(entries)
        return True

    def solve(self, right: Floats) -> Floats:
        """Force densities for one right side, (m,)."""
        if self._banded is not None:
            self._padded.reshape(-1)[: self._bars] = right
            return self._banded.solve(self._padded).reshape(-1)[: self._bars]
        sides = np.empty(self._bars)
        sides[self._order] = right
        return self._factors.solve(sides)[self._order]
