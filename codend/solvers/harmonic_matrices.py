"""The tangents K_k that changes exp(i k theta) of a sector's net see, as bands; what they are is in ``harmonics``."""

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag
from numpy.typing import NDArray

from codend.mechanics.arrays import Structure
from codend.mechanics.harmonics import hermitian_parts
from codend.mechanics.newton_state import empty_state
from codend.mechanics.newton_step import empty_step
from codend.mechanics.tangent import Pattern, pattern_of
from codend.net.net import Floats, Ints
from codend.solvers.linear_systems import narrow_numbering

Complex = NDArray[np.complex128]


class Entries(NamedTuple):
    """Entries of a matrix: those of the blocks that are named, each times a weight, added up where they meet."""

    row: Ints
    column: Ints
    source: Ints
    weight: Complex


class Ring:
    """What depends on a sector's structure alone, and room to work in: kept from one equilibrium to the next.

    Unknowns are the free coordinates of the nodes off the axis, numbered for a narrow band; behind them come those that
    the nodes on it have in a harmonic.
    """

    def __init__(self, structure: Structure) -> None:
        self.order = int(structure.order)
        self.pattern = pattern_of(structure, by_image=True)
        self.state, self.step = empty_state(structure), empty_step(structure, self.pattern)
        self.fronted = False
        """Whether the catch's front follows the net."""
        self.on_axis = np.flatnonzero((structure.free == [1.0, 0.0, 0.0]).all(axis=1))
        self.unknown = _numbered(structure, self.pattern, self.on_axis)
        self.size = int(self.unknown.max()) + 1
        """Unknowns off the axis."""
        row = np.repeat(self.unknown[self.pattern.row][:, :, None], 3, axis=2).ravel()
        column = np.repeat(self.unknown[self.pattern.column][:, None, :], 3, axis=1).ravel()
        image = np.repeat(self.pattern.image, 9)
        self._off_axis = np.flatnonzero((row >= 0) & (column >= 0))
        self._row, self._column, self._image = (part[self._off_axis] for part in (row, column, image))
        self._at_axis = self._entries_at_axis(0), self._entries_at_axis(1)
        tails = max(len(self.axis_moves(k)) for k in (0, 1)) * len(self.on_axis)
        rows = np.concatenate([self._row, *(entries.row for entries in self._at_axis)])
        columns = np.concatenate([self._column, *(entries.column for entries in self._at_axis)])
        self.depth = np.zeros(self.size + tails, dtype=np.int32)
        """How many columns before its diagonal a row starts."""
        np.maximum.at(self.depth, np.maximum(rows, columns), np.abs(rows - columns))
        width, reach = int(self.depth.max()) + 1, int(np.abs(image).max())
        self.even, self.odd = np.zeros((2, reach + 1, self.size, width))
        """C and S of ``mechanics.harmonics``."""
        row, column, image = self._row, self._column, self._image
        off = np.abs(row - column)
        self._place = np.full(9 * len(self.pattern.row), -1)
        self._place[self._off_axis] = (np.abs(image) * self.size + np.maximum(row, column)) * width + off
        self._weight = np.zeros((len(self._place), 2))
        # an entry on the diagonal is both of a pair, which count half each
        self._weight[self._off_axis, 0] = np.where(off == 0, 1.0, 0.5)
        self._weight[self._off_axis, 1] = 0.5 * np.sign(image) * np.sign(row - column)

    def gather(self, fronted: bool) -> None:
        """Take over the tangent that was written into ``step``, and whether the catch's front follows the net."""
        self.fronted = fronted
        hermitian_parts(self.step.blocks, self._place, self._weight, self.even, self.odd)

    def axis_moves(self, harmonic: int) -> Complex:
        """Moves of a node on the axis in a harmonic, as a sector sees them and of the size it does, (moves, 3)."""
        moves = np.zeros((0, 3), dtype=complex)
        if harmonic == 0:
            moves = np.array([[1.0, 0.0, 0.0]], dtype=complex)
        elif harmonic == 1 and self.order == 2:
            moves = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], dtype=complex)
        elif harmonic == 1:
            moves = np.sqrt(0.5) * np.array([[0.0, 1.0, 1.0j]])
        return np.sqrt(self.order) * moves

    def _entries_at_axis(self, harmonic: int) -> Entries:
        """Entries of a harmonic in the rows and columns of the nodes on the axis."""
        moves, pattern = self.axis_moves(harmonic), self.pattern
        first = np.full(len(self.unknown), -1)
        first[self.on_axis] = self.size + len(moves) * np.arange(len(self.on_axis))

        def ways(node: int, moves: Complex) -> tuple[Ints, Complex]:
            """Unknowns of a node, and how each weighs its coordinates, (unknowns, 3)."""
            if first[node] < 0:
                return self.unknown[node], np.eye(3, dtype=complex)
            return first[node] + np.arange(len(moves), dtype=np.int32), moves

        found: list[tuple[int, int, int, complex]] = []
        for block in np.flatnonzero((first[pattern.row] >= 0) | (first[pattern.column] >= 0)):
            turn = np.exp(2j * np.pi * harmonic * pattern.image[block] / self.order)
            (rows, by_row), (columns, by_column) = ways(pattern.row[block], moves.conj()), ways(pattern.column[block], moves)
            for a, b, i, j in np.ndindex(len(rows), len(columns), 3, 3):
                weight = turn * by_row[a, i] * by_column[b, j]
                if weight != 0.0 and rows[a] >= 0 and columns[b] >= 0:
                    found.append((rows[a], columns[b], 9 * block + 3 * i + j, weight))
        row, column, source, weights = zip(*found, strict=True) if found else ((), (), (), ())
        whole = [np.array(part, dtype=np.int64) for part in (row, column, source)]
        return Entries(*whole, np.array(weights, dtype=complex))

    def _values_at_axis(self, harmonic: int) -> tuple[Ints, Ints, Complex]:
        row, column, source, weight = self._at_axis[harmonic]
        return row, column, weight * self.step.blocks.reshape(-1)[source]

    def turn_and_tail(self, harmonics: Ints) -> tuple[Floats, Floats]:
        """What ``negative_pivots_side_by_side`` asks for of some harmonics."""
        angle = np.arange(len(self.even))[:, None] * (2.0 * np.pi / self.order * harmonics)
        tail = np.zeros((len(self.depth) - self.size, self.even.shape[2], 2, len(harmonics)))
        tail[:, 0, 0] = 1.0
        for lane in np.flatnonzero(harmonics <= 1):
            row, column, value = self._values_at_axis(harmonics[lane])
            # of each pair the lower, of which the upper is the conjugate
            value = 0.5 * np.where(row >= column, value, value.conj())
            place = np.maximum(row, column) - self.size, np.abs(row - column)
            tail[np.unique(place[0]), 0, 0, lane] = 0.0
            np.add.at(tail[:, :, 0, lane], place, np.where(row == column, 2.0, 1.0) * value.real)
            np.add.at(tail[:, :, 1, lane], place, value.imag)
        return np.stack([np.cos(angle), np.sin(angle)]), tail

    def matrix(self, harmonic: int) -> "Matrix":
        """Tangent of a harmonic at the equilibrium that was gathered last."""
        row, column = self._row, self._column
        value = self.step.blocks.reshape(-1)[self._off_axis] * np.exp(2j * np.pi * harmonic / self.order * self._image)
        if harmonic <= 1:
            pairs = zip((row, column, value), self._values_at_axis(harmonic), strict=True)
            row, column, value = (np.concatenate(pair) for pair in pairs)
        half = self.even.shape[2] - 1
        count = len(self.axis_moves(harmonic)) * len(self.on_axis)
        band = np.zeros((2 * half + 1, self.size + count), dtype=complex)
        np.add.at(band, (half + row - column, column), value)
        if harmonic > 0 or not self.fronted:
            return Matrix(band)
        return Matrix(band, self._of_harmonic_0(self.step.right[1]), self._of_harmonic_0(self.step.gradient))

    def _of_harmonic_0(self, values: Floats) -> Floats:
        """Values at the nodes, (n, 3), as those at the unknowns of harmonic 0."""
        free = self.unknown >= 0
        off_axis = np.zeros(self.size)
        off_axis[self.unknown[free]] = values[free]
        return np.append(off_axis, values[self.on_axis] @ self.axis_moves(0)[0].real)

    def shape_of(self, vector: Complex, harmonic: int) -> Complex:
        """Moves of a sector's nodes by the unknowns of a harmonic, (n, 3), the largest component 1."""
        free = self.unknown >= 0
        shape = np.zeros(self.unknown.shape, dtype=complex)
        shape[free] = vector[self.unknown[free]]
        moves = self.axis_moves(harmonic)
        shape[self.on_axis] = vector[self.size :].reshape(len(self.on_axis), len(moves)) @ moves
        return shape / shape.reshape(-1)[np.abs(shape).argmax()]


def _numbered(structure: Structure, pattern: Pattern, on_axis: Ints) -> Ints:
    """Number of the unknown of every free coordinate off the axis, -1 for the others, (n, 3); near the axis is last."""
    nodes = len(structure.free)
    place = narrow_numbering(pattern.row, pattern.column, nodes)
    if place[on_axis].mean() < 0.5 * nodes if len(on_axis) else False:
        place = nodes - 1 - place
    free = structure.free > 0.0
    free[on_axis] = False
    unknown = np.full(free.shape, -1, dtype=np.int32)
    order = np.argsort(place)
    rows, ways = np.nonzero(free[order])
    unknown[order[rows], ways] = np.arange(len(rows))
    return unknown


class Matrix:
    """The tangent K_k of one harmonic, less a product u v^T where the catch's front follows the net."""

    def __init__(self, band: Complex, load: Floats | None = None, gradient: Floats | None = None) -> None:
        self.band = band
        """Entry (i, j) in ``band[half + i - j, j]``, (2 half + 1, unknowns)."""
        self.front = None if load is None or gradient is None else (load, gradient)

    def __len__(self) -> int:
        return self.band.shape[1]

    def dense(self) -> Complex:
        """All entries, (unknowns, unknowns)."""
        half, size = len(self.band) // 2, len(self)
        whole = sum(np.diagflat(self._diagonal(off), -off) for off in range(-min(half, size - 1), min(half, size - 1) + 1))
        return whole if self.front is None else whole - np.outer(*self.front)

    def _diagonal(self, off: int) -> Complex:
        """Entries ``off`` rows below the diagonal."""
        row = self.band[len(self.band) // 2 + off]
        return row[: len(self) - off] if off >= 0 else row[-off:]

    def negative_eigenvalues(self, negative: int, basis: Complex | None = None) -> int:
        """Number of negative eigenvalues of the Hermitian part of K J, with J = I - 2 Y Y^H of an orthonormal basis Y.

        With a basis of the growing moves there should be none. That proves them to be all: the eigenvalues of K and of
        J then have as many negative real parts (Ostrowski and Schneider 1962, J. Math. Anal. Appl. 4, 72-84). Without a
        basis J is I.

        The part is H - U D U^H, with U = (Y, K Y, u, v) and H that of K without the front. Its inertia and that of D^-1
        add up to those of H and of D^-1 - U^H H^-1 U (Haynsworth 1968, Linear Algebra Appl. 1, 73-81).

        Args:
            negative: negative eigenvalues of H.
            basis: Y, (unknowns, moves).
        """
        y = np.zeros((len(self), 0)) if basis is None else basis
        hermitian = Matrix(self.band + self._adjoint())
        hermitian.band *= 0.5
        pairs = [(y, self @ y, 1.0)]
        if self.front is not None:
            pairs.append((self.front[0][:, None], self.front[1][:, None], 2.0))
        sides = np.concatenate([part for first, second, _ in pairs for part in (first, second)], axis=1)
        inverse = block_diag(*(size * np.kron([[0, 1], [1, 0]], np.eye(first.shape[1])) for first, _, size in pairs))
        schur = inverse - sides.conj().T @ hermitian.solver(0.0)(sides.astype(complex))
        below = np.count_nonzero(np.linalg.eigvalsh(0.5 * (schur + schur.conj().T)) < 0.0)
        return negative + int(below) - len(inverse) // 2

    def _adjoint(self) -> Complex:
        """The band of the adjoint of the matrix without the front."""
        adjoint, half = np.zeros_like(self.band), len(self.band) // 2
        for off in range(-min(half, len(self) - 1), min(half, len(self) - 1) + 1):
            values = self._diagonal(-off).conj()
            if off >= 0:
                adjoint[half + off, : len(self) - off] = values
            else:
                adjoint[half + off, -off:] = values
        return adjoint

    def __matmul__(self, vectors: Complex) -> Complex:
        """Products with vectors, (unknowns, k)."""
        product, half = np.zeros(vectors.shape, dtype=complex), len(self.band) // 2
        for off in range(-min(half, len(self) - 1), min(half, len(self) - 1) + 1):
            values, rest = self._diagonal(off)[:, None], len(self) - abs(off)
            if off >= 0:
                product[off:] += values * vectors[:rest]
            else:
                product[:rest] += values * vectors[-off:]
        if self.front is not None:
            product -= np.outer(self.front[0], self.front[1] @ vectors)
        return product

    def nearest(self, centre: float, wanted: int) -> tuple[Complex, Complex]:
        """The eigenvalues nearest to a number on the axis and their vectors, by Arnoldi's method on the inverse.

        Raises:
            scipy.sparse.linalg.ArpackError: not found.
        """
        from scipy.sparse.linalg import LinearOperator, eigs

        shape = (len(self), len(self))
        inverse = LinearOperator(shape, matvec=self.solver(centre), dtype=complex)
        start = np.random.default_rng(0).standard_normal(len(self)) + 0.0j
        return eigs(inverse, wanted, sigma=centre, OPinv=inverse, v0=start)

    def bounds(self, lowest: float) -> tuple[float, float]:
        """Bounds on the Hermitian part, from below, and on the size of the skew one, N/m.

        ``lowest`` is one on the former without the front.
        """
        rows = np.zeros(len(self))
        for off in range(len(self.band) // 2 + 1):
            skew = 0.5 * np.abs(self._diagonal(off) - self._diagonal(-off).conj())
            rows[off:] += skew
            if off:
                rows[:-off] += skew
        if self.front is None:
            return lowest, float(rows.max())
        size = 0.5 * np.linalg.norm(self.front[0]) * np.linalg.norm(self.front[1])
        return float(lowest - size - 0.5 * self.front[0] @ self.front[1]), float(rows.max() + size)

    def solver(self, shift: float) -> Callable[[Complex], Complex]:
        """Solves with the matrix less ``shift`` on its diagonal."""
        from scipy.linalg.lapack import zgbtrf, zgbtrs

        half = len(self.band) // 2
        room = np.zeros((3 * half + 1, len(self)), dtype=complex)
        room[half:] = self.band
        room[2 * half] -= shift
        factors, pivots, _ = zgbtrf(room, half, half)

        def solved(right: Complex) -> Complex:
            return zgbtrs(factors, half, half, right, pivots)[0]

        if self.front is None:
            return solved
        load, gradient = self.front
        by_load = solved(load.astype(complex))
        determinant = 1.0 - gradient @ by_load

        def solved_with_front(right: Complex) -> Complex:
            without = solved(right)
            return without + np.multiply.outer(by_load, gradient @ without / determinant)

        return solved_with_front
