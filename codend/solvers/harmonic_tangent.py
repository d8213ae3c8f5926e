"""The tangent that one harmonic of a sector's net sees: a band, less a product where the front follows the net."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from codend.mechanics.harmonics import (
    Complex,
    Numbers,
    arnoldi,
    band_times,
    factorise_band_of_numbers,
    solve_band_of_numbers,
    write_rows,
)
from codend.net.net import Floats

NEAREST = 1e-8
"""Relative residual of an eigenvalue of the inverse."""
HELD = 1e-3
"""What a solution by the factors, which are made without pivoting, may leave of its load: of an eigenvalue likewise."""
FIRST_STEPS, MORE_STEPS, MOST_STEPS = 26, 13, 150
"""Of Arnoldi's method, before it is first looked what it found, until it is looked again, and in all."""


BESIDE = 1e-4
"""Share of that in a start which leads to some eigenvectors."""


@lru_cache(maxsize=8)
def _start(size: int) -> Floats:
    """A direction that no eigenvector is at right angles to, (size,)."""
    start = np.random.default_rng(0).standard_normal(size)
    return np.asarray(start / np.sqrt(np.sum(start**2)))


def _led_start(size: int, led: Numbers | None, kind: np.dtype) -> Numbers:
    """The same, but mostly along a vector that the eigenvectors sought are near to, where there is one, (size,)."""
    start = _start(size)
    if led is not None and kind.kind != "c" and not led.imag.any():
        led = led.real
    if led is None or len(led) != size or (np.iscomplexobj(led) and kind.kind != "c"):
        return start
    mostly = BESIDE * start + led / np.linalg.norm(led)
    return np.asarray(mostly / np.linalg.norm(mostly))


class HarmonicTangent:
    """The tangent K of one harmonic: a band B, less u v^T where the catch's front follows the net."""

    def __init__(self, band: Numbers, front: tuple[Floats, Floats] | None = None) -> None:
        self.band = band
        """Entry (i, j) in ``band[half + i - j, j]``, (2 half + 1, unknowns); real where the harmonic's turns are."""
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

    def dense(self) -> Numbers:
        """All entries, (unknowns, unknowns)."""
        return np.asarray(self @ np.eye(self.size, dtype=self.band.dtype))

    def __matmul__(self, vectors: Numbers) -> Numbers:
        """Products with vectors, (unknowns, k)."""
        product = band_times(self.band, np.asarray(vectors, dtype=np.result_type(self.band, vectors)))
        return product if self.front is None else product - np.outer(self.front[0], self.front[1] @ vectors)

    def factors(self, centre: float, hermitian: bool = False) -> Numbers:
        """Factors of B, or of its Hermitian part, less ``centre`` on its diagonal, row by row."""
        rows = np.zeros((self.size, len(self.band)), dtype=self.band.dtype)
        write_rows(self.band, centre, hermitian, rows)
        factorise_band_of_numbers(rows)
        return rows

    def nearest(self, centre: float, most_steps: int = MOST_STEPS, led: Numbers | None = None) -> "Nearest":
        """Its eigenvalues nearest to a real number, as many as will be asked for.

        ``led`` is a vector that theirs are near to, as those of a neighbouring harmonic are, (unknowns,).
        """
        return Nearest(self, centre, most_steps, led)

    def negative_eigenvalues(self, negative: int, basis: Numbers | None = None) -> int:
        """Number of negative eigenvalues of the Hermitian part of K, on moves at right angles to a basis if any.

        Of a basis of eigenvectors that tells of all other eigenvalues of K: they are those of K on what is left, and
        where its Hermitian part is positive definite there none has a negative real part.

        With H the Hermitian part of B, U = (Y, u, v) of the orthonormal basis Y and the front, and C zero but for 2
        between u and v, (H, U; U^H, C) has as many negative eigenvalues as are sought, and one more a column of Y and
        for the front. They are those of H and of C - U^H H^-1 U (Haynsworth 1968, Linear Algebra Appl. 1, 73-81).

        Args:
            negative: negative eigenvalues of H.
            basis: Y, (unknowns, moves).
        """
        factors = self.factors(0.0, hermitian=True)
        if basis is not None and not np.iscomplexobj(factors):
            if basis.imag.any():
                factors = factors.astype(np.complex128)
            else:
                basis = np.asarray(basis.real)

        def solve(sides: Complex) -> Complex:
            solved = sides.copy()
            for side in solved:
                solve_band_of_numbers(factors, side)
            return solved

        return negative_beside(negative, solve, basis, () if self.front is None else (self.front,))


class Nearest:
    """Eigenvalues nearest to a real number, by Arnoldi's method on the inverse: carried on as more of them are wanted.

    The residual of an eigenvalue of the projection is the last entry of its vector times the next row's length.
    """

    def __init__(self, tangent: HarmonicTangent, centre: float, most_steps: int, led: Numbers | None = None) -> None:
        self.tangent, self.centre = tangent, centre
        self._factors = tangent.factors(centre)
        kind = self._factors.dtype
        self._by_load, self._gradient = np.zeros((2, tangent.size), dtype=kind)
        if tangent.front is not None:
            self._by_load[:], self._gradient[:] = tangent.front
            solve_band_of_numbers(self._factors, self._by_load)
            self._by_load /= 1.0 - np.sum(self._gradient * self._by_load)
        most = min(most_steps, tangent.size - 1)
        self._basis = np.empty((most + 1, tangent.size), dtype=kind)
        self._projection = np.zeros((most + 1, most), dtype=kind)
        self._basis[0] = _led_start(tangent.size, led, kind)
        self._steps = 0
        self._inverse = np.zeros(0, dtype=complex)
        self._parts = np.zeros((0, 0), dtype=complex)
        self._settled = 0

    def eigenvalues(self, wanted: int, first_steps: int = FIRST_STEPS) -> tuple[Complex, Complex] | None:
        """As many as are wanted or more, nearest first, and their vectors, (unknowns, k).

        Fewer where the rest is late; None where all are, and where the factors are of no use.
        """
        most = self._projection.shape[1]
        while self._settled < wanted:
            if self._steps == most:
                if self._settled == 0:
                    return None
                break
            some = max(first_steps, min(3 * wanted, 2 * wanted + FIRST_STEPS))
            last = min(max(self._steps + MORE_STEPS, some) if self._steps else some, most)
            arnoldi(self._factors, self._by_load, self._gradient, self._steps, last, self._basis, self._projection)
            self._steps = last
            if not np.isfinite(self._projection[:, :last]).all() or not self._factors_hold():
                return None
            self._look()
        inverse, parts = self._inverse[: self._settled], self._parts[:, : self._settled]
        found = np.asarray(self.centre + 1.0 / inverse, dtype=np.complex128)
        vectors: Complex = (self._basis[: self._steps].T @ parts).astype(np.complex128, copy=False)
        return found, vectors

    def _look(self) -> None:
        """Eigenvalues of the projection, nearest first, and how many of the first ones have settled."""
        steps = self._steps
        inverse, parts = np.linalg.eig(self._projection[:steps, :steps])
        nearest_first = np.argsort(-np.abs(inverse))
        self._inverse, self._parts = inverse[nearest_first], parts[:, nearest_first]
        residual = np.abs(self._projection[steps, steps - 1] * self._parts[-1])
        late = residual > NEAREST * np.abs(self._inverse)
        self._settled = int(np.argmax(late)) if late.any() else steps

    def _factors_hold(self) -> bool:
        """Whether the first solution by the factors, the start's, is one."""
        solution = self._basis[:2].T @ self._projection[:2, :1]
        left = self.tangent @ solution - self.centre * solution - self._basis[:1].T
        return bool(np.linalg.norm(left) <= HELD)


def negative_beside(
    negative: int,
    solve: Callable[[Complex], Complex],
    basis: Numbers | None,
    products: Sequence[tuple[Floats, Floats]],
) -> int:
    """Number of negative eigenvalues of the Hermitian part of a tangent, by those of its part without some products.

    With H the Hermitian part of B, U = (Y, u, v, ...) of the orthonormal basis Y and the products, and C zero but for 2
    between each u and v, (H, U; U^H, C) has as many negative eigenvalues as are sought, and one more a column of Y and
    a product. They are those of H and of C - U^H H^-1 U (Haynsworth 1968, Linear Algebra Appl. 1, 73-81).

    Args:
        negative: negative eigenvalues of H.
        solve: H^-1 times the rows of a matrix, (sides, unknowns).
        basis: Y, (unknowns, moves); only moves at right angles to it are asked.
        products: u and v of each u v^T that the tangent is less than B, (unknowns,).
    """
    sides = [] if basis is None else [*basis.T]
    held = len(sides)
    if not sides and not products:
        return negative
    corner = np.zeros((held + 2 * len(products),) * 2)
    for number, pair in enumerate(products):
        u = held + 2 * number
        corner[u, u + 1] = corner[u + 1, u] = 2.0
        sides += pair
    whole = np.array(sides)
    schur = corner - np.einsum("ji,ki->jk", whole.conj(), solve(whole))
    below_0 = np.count_nonzero(np.linalg.eigvalsh(0.5 * (schur + schur.conj().T)) < 0.0)
    return negative + int(below_0) - held - len(products)
