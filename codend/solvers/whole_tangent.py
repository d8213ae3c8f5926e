"""The tangent of a net as a whole, and whether anything grows by it.

Loads that follow the net make a tangent unsymmetric: its pivots then tell whether its determinant is negative, and no
more. A change grows where an eigenvalue of it has a negative real part; where its symmetric part is positive definite,
whose pivots do tell, none has.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from codend.net.net import Floats
from codend.solvers.harmonic_tangent import Complex, negative_beside
from codend.solvers.newton import TangentAtEquilibrium

FIRST_BOUND = 1e-2
"""Least bound on the lowest eigenvalue of a symmetric part, over a bar's stiffness under tension."""
WIDER = 4.0
"""Factor from one bound tried to the next."""
FIRST_EIGENVALUES = 6
"""Found first: where much grows, one that does is soon met."""
MOST_EIGENVALUES = 60
"""Found at a time, before the answer is that it is not known."""
EXACTLY, ROUGHLY = 1e-8, 1e-3
"""Relative tolerance of the distances of eigenvalues to a bound below them all, and where they are looked at first. Of
22 000 knots between two ropes six took 70 s to 1e-8, and a fifteenth of that to 1e-2."""
DENSE = 600
"""Unknowns up to which all eigenvalues are found at once."""


@dataclass(frozen=True)
class Growing:
    """What grows by a tangent."""

    eigenvalues: Complex
    """With negative real parts, the most negative first, N/m, (k,)."""
    vectors: Complex
    """Theirs, (unknowns, k)."""
    complete: bool
    """Whether no others have any."""
    at_most: float = 0.0
    """How much what was not found grows at most, but for what the front adds, N/m."""


class WholeTangent:
    """The tangent K of all free coordinates: a sparse matrix B, less U^T V where the catch's front follows the net."""

    def __init__(self, matrix: Any, load: Floats, gradient: Floats) -> None:
        self.matrix = matrix
        """B, a sparse array, (unknowns, unknowns)."""
        self.load = load
        """U, the loads by what of the front follows the net, (products, unknowns)."""
        self.gradient = gradient
        """V, how that follows the net, (products, unknowns)."""
        self._symmetric = 0.5 * (matrix + matrix.T)

    @classmethod
    def at(cls, tangent: TangentAtEquilibrium) -> "WholeTangent":
        """That of an equilibrium, as it was written into ``tangent.prepared`` last."""
        from scipy.sparse import csc_array

        step, pattern = tangent.prepared.step, tangent.prepared.pattern
        free = tangent.problem.structure.free > 0.0
        number = np.full(free.shape, -1)
        number[free] = np.arange(np.count_nonzero(free))
        row = np.broadcast_to(number[pattern.row][:, :, None], step.blocks.shape)
        column = np.broadcast_to(number[pattern.column][:, None, :], step.blocks.shape)
        used = (row >= 0) & (column >= 0)
        size = np.count_nonzero(free)
        matrix = csc_array((step.blocks[used], (row[used], column[used])), shape=(size, size))
        gradient = step.gradient.reshape(-1, *free.shape)
        return cls(matrix, step.right[1 : 1 + tangent.products, free], gradient[: tangent.products, free])

    @property
    def size(self) -> int:
        """Unknowns."""
        return int(self.matrix.shape[0])

    def dense(self) -> Floats:
        """All entries, (unknowns, unknowns)."""
        whole: Floats = self.matrix.toarray() - self.load.T @ self.gradient
        return whole

    def growing(self, scale: float, most: int = MOST_EIGENVALUES, thorough: bool = False) -> Growing | None:
        """Eigenvalues of K with negative real parts, and their vectors; None if nothing is known of them.

        Those nearest to a lower bound of the symmetric part's are found, more and more until one of them grows, or all
        that do if it is to be ``thorough``: until what they leave is positive definite (as in ``harmonics``).

        Args:
            scale: a stiffness of the net's order of size, N/m.
            most: eigenvalues found at a time before the answer is not complete.
            thorough: whether all that grow are wanted.
        """
        stable = Growing(np.zeros(0, dtype=complex), np.zeros((self.size, 0), dtype=complex), True)
        if not np.isfinite(self.matrix.data).all():
            return None
        factors = self._factors(0.0)
        if factors is None:
            return None
        negative = _negative_pivots(factors)
        expected = self._negative_eigenvalues(factors, negative, None)
        if expected == 0:
            return stable
        if self.size <= DENSE:
            return _with_negative_real_parts(*np.linalg.eig(self.dense()), complete=True)
        centre, wanted = self._lower_bound(scale), min(expected, FIRST_EIGENVALUES)
        growing = None
        # without any eigenvalue the number expected falls by two at most, for its vector's real and imaginary part
        if centre is not None and expected > 2 * most and not self._may_grow(centre, wanted):
            return replace(stable, complete=False, at_most=-centre)
        while centre is not None and wanted <= most:
            found = self._nearest(centre, wanted)
            if found is None:
                break
            grows = found[0].real.min() < 0.0
            if grows and not thorough:
                return _with_negative_real_parts(*found, complete=False)
            proved = self._negative_eigenvalues(factors, negative, np.linalg.qr(found[1])[0]) == 0
            if grows:
                growing = _with_negative_real_parts(*found, complete=proved)
            if proved:
                return growing or stable
            wanted = most if wanted < most < 2 * wanted + 2 else max(expected, 2 * wanted + 2)
        if centre is None:
            return None
        return replace(growing or stable, complete=False, at_most=-centre)

    def _factors(self, shift: float) -> Any:
        """LU of the symmetric part and ``shift`` on its diagonal, without pivoting; None where that has no pivots."""
        return _unpivoted(self._symmetric, shift)

    def _lower_bound(self, scale: float) -> float | None:
        """A bound below all eigenvalues of B's symmetric part, N/m."""
        bound = FIRST_BOUND * scale
        while np.isfinite(bound):
            factors = self._factors(bound)
            if factors is None:
                return None
            if _negative_pivots(factors) == 0:
                return -bound
            bound *= WIDER
        return None

    def _negative_eigenvalues(self, factors: Any, negative: int, basis: Complex | None) -> int:
        """See ``HarmonicTangent.negative_eigenvalues``."""

        def solve(sides: Complex) -> Complex:
            solved: Complex = factors.solve(sides.real.T.copy()).T + 1j * factors.solve(sides.imag.T.copy()).T
            return solved

        return negative_beside(negative, solve, basis, tuple(zip(self.load, self.gradient, strict=True)))

    def _may_grow(self, centre: float, wanted: int) -> bool:
        """Whether a rough look at the eigenvalues nearest to a bound below them all leaves one that may grow."""
        found = self._nearest(centre, wanted, ROUGHLY)
        return found is not None and float(found[0].real.min()) < -2.0 * ROUGHLY * centre

    def _nearest(self, centre: float, wanted: int, tolerance: float = EXACTLY) -> tuple[Complex, Complex] | None:
        """The eigenvalues nearest to a real number, and their vectors; None if they are not found."""
        from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

        factors = _unpivoted(self.matrix, -centre)
        if factors is None:
            return None
        by_load = factors.solve(self.load.T)
        by_load = by_load @ np.linalg.inv(np.eye(len(self.load)) - self.gradient @ by_load)

        def solve(side: Floats) -> Floats:
            solved: Floats = factors.solve(side)
            return solved + by_load @ (self.gradient @ solved)

        inverse = LinearOperator(self.matrix.shape, matvec=lambda side: solve(side.ravel()), dtype=float)
        start = np.random.default_rng(0).standard_normal(self.size)
        try:
            found, vectors = eigs(inverse, k=wanted, v0=start, tol=tolerance)
        except ArpackNoConvergence:
            return None
        return centre + 1.0 / found, vectors


def _with_negative_real_parts(eigenvalues: Complex, vectors: Complex, complete: bool) -> Growing:
    order = np.argsort(eigenvalues.real)
    order = order[eigenvalues.real[order] < 0.0]
    return Growing(eigenvalues[order], vectors[:, order], complete)


def _unpivoted(matrix: Any, shift: float) -> Any:
    """SuperLU's factors of a matrix and ``shift`` on its diagonal, none exchanged; None if it would be."""
    from scipy.sparse import csc_array, eye_array
    from scipy.sparse.linalg import splu

    try:
        factors = splu(
            csc_array(matrix + shift * eye_array(matrix.shape[0])),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:
        return None
    return factors if np.array_equal(factors.perm_r, factors.perm_c) else None


def _negative_pivots(factors: Any) -> int:
    return int(np.count_nonzero(factors.U.diagonal() < 0.0))
