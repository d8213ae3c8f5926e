"""Force densities of bars that never push: one-sided linear systems, A q = right where q > 0 and A q > right elsewhere.

Which bars are taut is guessed and mended: those that push go slack, those that would come out too long are taut (a
primal-dual active set: Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13(3), 865, for matrices near M-matrices).
That settles all but a few steps; where it goes round, sweeps of one-sided relaxation tell where the guess is wrong.
"""

import numpy as np

from codend.mechanics import rigid
from codend.mechanics.bars import carried
from codend.mechanics.rigid import RigidPattern
from codend.net.net import Floats, Ints
from codend.solvers.linear_systems import symmetric_system

PASSES = 8
"""Guesses that are mended bar by bar, before bars are asked together."""
SWEPT_PASSES, SWEEPS, MOST_SWEEPS = 12, 30, 1000
"""Guesses after these, sweeps after the first of them, twice as many after each further one."""
NO_PUSH = 1e-10
"""Push, over the largest force density, that is round-off."""


class OneSided:
    """The system for the tensions of a step, factorised for the bars that are taut."""

    def __init__(self, pattern: RigidPattern, is_strut: np.ndarray, no_push: Floats | float = NO_PUSH) -> None:
        """Set it out for bars of which struts, (m,), may push; ``no_push`` is what counts as none, of all or (m,)."""
        bars = len(is_strut)
        self._no_push = no_push
        self.pattern, self.is_strut = pattern, is_strut
        self.entries = np.zeros(len(pattern.row))
        """A, in the order of ``pattern``; ``renewed`` must be called when they have changed."""
        self.taut = np.ones(bars, dtype=np.int32)
        self.unsettled = 0
        """Systems of which it was not found which bars are slack."""
        self._system = symmetric_system(pattern.row, pattern.column, bars)
        self._masked, self._product = np.zeros(len(pattern.row)), np.zeros(bars)
        self._starts = np.searchsorted(pattern.row, np.arange(bars + 1)).astype(np.int32)
        self._factored: Ints | None = None

    def renewed(self) -> None:
        """Forget the factors of entries that were."""
        self._factored = None

    def times(self, density: Floats) -> Floats:
        """A q, (m,)."""
        rigid.multiply(self._starts, self.pattern.column, self.entries, density, self._product)
        return self._product.copy()

    def solve(self, right: Floats) -> Floats | None:
        """Force densities q, (m,), for a right side, (m,); struts have A q = right; None where A is singular."""
        strut = self.is_strut
        for number in range(PASSES + SWEPT_PASSES):
            if not self._factorised():
                return None
            density = self._system.solve(np.where(self.taut, right, 0.0)[None, :, None]).reshape(-1) * self.taut
            pushes = ~strut & (density < -self._no_push * float(np.abs(density).max(initial=0.0)))
            # asked with the pushes still in it, which is what settles
            missing = right - self.times(density) > self._no_push * float(np.abs(right).max(initial=0.0))
            density = np.asarray(carried(strut, density))
            if not np.any(np.where(self.taut, pushes, missing)):
                return density
            if number < PASSES:
                self.taut[:] = strut | np.where(self.taut, ~pushes, missing)
            else:
                self._sweep(right, density, min(SWEEPS * 2 ** (number - PASSES), MOST_SWEEPS))
        self.unsettled += 1
        return density

    def _factorised(self) -> bool:
        if self._factored is not None and np.array_equal(self.taut, self._factored):
            return True
        rigid.only_taut(self._starts, self.pattern.column, self.taut, self.entries, self._masked)
        self._factored = self.taut.copy()
        return self._system.factorise(self._masked) != -1

    def _sweep(self, right: Floats, density: Floats, sweeps: int) -> None:
        pattern = self.pattern
        rigid.relax_one_sided(
            self._starts, pattern.column, pattern.diagonal, self.entries, right, self.is_strut, density, sweeps
        )
        self.taut[:] = self.is_strut | (density > 0.0)
