"""The tangent that one harmonic of a sector's net sees: a band, less a product where the front follows the net."""

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.harmonics import Complex, arnoldi, factorise_complex_band, solve_complex_band
from codend.net.net import Floats

NEAREST = 1e-8
"""Relative residual of an eigenvalue of the inverse."""
FIRST_STEPS, MORE_STEPS, MOST_STEPS = 26, 13, 150
"""Of Arnoldi's method, before it is first looked what it found, until it is looked again, and in all."""


class HarmonicTangent:
    """The tangent K of one harmonic: a band B, less u v^T where the catch's front follows the net."""

    def __init__(self, band: Complex, front: tuple[Floats, Floats] | None = None) -> None:
        self.band = band
        """Entry (i, j) in ``band[half + i - j, j]``, (2 half + 1, unknowns)."""
        self.front = front
        """u and v, (unknowns,)."""

    @property
    def size(self) -> int:
        """Unknowns."""
        return self.band.shape[1]

    @property
    def half(self) -> int:
        """Half-bandwidth."""
        return len(self.band) // 2

    def dense(self) -> Complex:
        """All entries, (unknowns, unknowns)."""
        return self @ np.eye(self.size, dtype=complex)

    def __matmul__(self, vectors: Complex) -> Complex:
        """Products with vectors, (unknowns, k)."""
        from scipy.sparse import dia_array

        below = np.arange(len(self.band)) - self.half
        product: Complex = np.asarray(dia_array((self.band, -below), shape=(self.size, self.size)) @ vectors)
        return product if self.front is None else product - np.outer(self.front[0], self.front[1] @ vectors)

    def _adjoint(self) -> Complex:
        """The band of B^H."""
        adjoint = np.zeros_like(self.band)
        for row in range(len(self.band)):
            below, values = row - self.half, self.band[row].conj()
            inside = slice(max(-below, 0), self.size - max(below, 0))
            adjoint[2 * self.half - row, inside.start + below : inside.stop + below] = values[inside]
        return adjoint

    def _factors(self, centre: float) -> Complex:
        """Factors of B less ``centre`` on its diagonal, row by row."""
        rows = np.zeros((self.size, len(self.band)), dtype=complex)
        for row in range(len(self.band)):
            below = row - self.half
            inside = slice(max(-below, 0), self.size - max(below, 0))
            rows[inside.start + below : inside.stop + below, len(self.band) - 1 - row] = self.band[row, inside]
        rows[:, self.half] -= centre
        factorise_complex_band(rows)
        return rows

    def nearest(self, centre: float, wanted: int) -> tuple[Complex, Complex] | None:
        """The eigenvalues nearest to a real number and their vectors, by Arnoldi's method on the inverse; None if late.

        The residual of an eigenvalue of the projection is the last entry of its vector times the next row's length.
        """
        band, most = self._factors(centre), min(MOST_STEPS, self.size - 1)
        by_load, gradient = np.zeros((2, self.size), dtype=complex)
        if self.front is not None:
            by_load[:], gradient[:] = self.front
            solve_complex_band(band, by_load)
            by_load /= 1.0 - np.sum(gradient * by_load)
        basis = np.zeros((most + 1, self.size), dtype=complex)
        projection = np.zeros((most + 1, most), dtype=complex)
        start = np.random.default_rng(0).standard_normal(self.size)
        basis[0] = start / np.sqrt(np.sum(start**2))
        steps = 0
        while steps < most:
            last = min(steps + MORE_STEPS if steps else max(FIRST_STEPS, 3 * wanted), most)
            arnoldi(band, by_load, gradient, steps, last, basis, projection)
            steps = last
            if not np.isfinite(projection[:, :steps]).all():
                return None
            inverse, parts = np.linalg.eig(projection[:steps, :steps])
            chosen = np.argsort(-np.abs(inverse))[:wanted]
            residual = np.abs(projection[steps, steps - 1] * parts[-1, chosen])
            if np.all(residual <= NEAREST * np.abs(inverse[chosen])):
                found = np.asarray(centre + 1.0 / inverse[chosen], dtype=np.complex128)
                return found, np.einsum("mi,mk->ik", basis[:steps], parts[:, chosen])
        return None

    def negative_eigenvalues(self, negative: int, basis: Complex | None = None) -> int:
        """Number of negative eigenvalues of the Hermitian part of K J, J = I - 2 Y Y^H with an orthonormal basis Y.

        With a basis of the moves that grow there are none, and that proves them to be all: K and J then have equally
        many eigenvalues with negative real parts (Ostrowski and Schneider 1962, J. Math. Anal. Appl. 4, 72-84). Without
        a basis J is I.

        The part is H - U D U^H, H that of B and U = (Y, K Y, u, v). Its inertia and that of D^-1 add up to those of H
        and of D^-1 - U^H H^-1 U (Haynsworth 1968, Linear Algebra Appl. 1, 73-81).

        Args:
            negative: negative eigenvalues of H.
            basis: Y, (unknowns, moves).
        """
        from scipy.linalg import block_diag

        pairs: list[tuple[float, NDArray, NDArray]] = []
        if basis is not None:
            pairs.append((1.0, basis, self @ basis))
        if self.front is not None:
            pairs.append((2.0, self.front[0][:, None], self.front[1][:, None]))
        sides = np.concatenate([side for _, *both in pairs for side in both], axis=1).astype(complex)
        inverse = block_diag(*(size * np.kron([[0, 1], [1, 0]], np.eye(first.shape[1])) for size, first, _ in pairs))
        hermitian = HarmonicTangent(0.5 * (self.band + self._adjoint()))
        factors, solved = hermitian._factors(0.0), np.ascontiguousarray(sides.T)
        for side in solved:
            solve_complex_band(factors, side)
        schur = inverse - np.einsum("ij,ki->jk", sides.conj(), solved)
        below_0 = np.count_nonzero(np.linalg.eigvalsh(0.5 * (schur + schur.conj().T)) < 0.0)
        return negative + int(below_0) - len(inverse) // 2

    def bounds(self, lowest: float) -> tuple[float, float]:
        """Bounds on the Hermitian part from below and on the size of the skew one, N/m; ``lowest`` is one on that of B.

        No row of absolute values adds up to less than the largest eigenvalue.
        """
        aside = float(0.5 * np.abs(self.band - self._adjoint()).sum(axis=0).max())
        if self.front is None:
            return lowest, aside
        u, v = self.front
        size = float(np.linalg.norm(u) * np.linalg.norm(v))
        return lowest - 0.5 * (size + float(u @ v)), aside + 0.5 * size
