"""Linear systems of a net, of its tangent first of all: numbered once a structure, then factorised again and again.

A sector, or any net that is narrow against its length, gives a narrow band: it is factorised by a compiled band LU.
Wide nets go to SuperLU in its symmetric mode, whole. Neither pivots: stiff and inextensible bars enter as stiffness
and not as zeros on the diagonal, so near a stable equilibrium the matrix is close to symmetric and positive definite,
and elsewhere the solver adds a shift until it is, as far as it knows: a band LU tells the signs of its pivots at once,
of the others they are asked for at the equilibrium only. They tell whether it is stable.
"""

from copy import copy
from typing import Protocol

import numpy as np

from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats, Ints
from codend.solvers import pardiso_system
from codend.solvers.kernels import Band, factorise_band, solve_band
from codend.solvers.pardiso_system import PardisoSystem
from codend.solvers.sparse_system import SparseSystem
from codend.solvers.symmetric_system import SymmetricSystem

WIDEST_BAND = 100
"""Half-bandwidth of a tangent beyond which SuperLU is the faster (measured)."""
WIDEST_SYMMETRIC_BAND = 50
"""The same beyond which L D L^T is the faster (measured on strips of netting)."""


class LinearSystem(Protocol):
    """A factorised tangent; fixed coordinates are left out of it and come back as 0.

    In other matrices the shapes below may have any number of coordinates in place of the 3 of a node.
    """

    name: str
    """What factorises it, for reports."""
    worthwhile_fall: float
    """Fall of the merit at which one more step with the same factors costs less than it saves."""

    @property
    def ready(self) -> bool:
        """Whether it holds factors to solve with."""

    def factorise(self, blocks: Floats) -> int:
        """Factorise the tangent ``blocks`` (b, 3, 3).

        Returns:
            the number of negative pivots where that costs nothing, else 0; -1 if the tangent is singular.
        """

    def solve(self, right: Floats) -> Floats:
        """Solutions for right sides (k, n, 3), of the same shape."""

    def negative_pivots(self) -> int:
        """Number of negative pivots of the last factorisation: of a symmetric tangent, of its negative eigenvalues."""


def linear_system(structure: Structure, pattern: Pattern, fewer: LinearSystem | None = None) -> LinearSystem:
    """The system that suits a net's tangent.

    ``fewer`` is that of the same net with fewer blocks: one that orders its unknowns for itself need not be numbered
    for a narrow band again.
    """
    if isinstance(fewer, SparseSystem):
        return type(fewer)(fewer.unknown, *_scalar_places(pattern, fewer.unknown))
    unknown = _band_numbering(structure, pattern)
    return fitting_system(unknown, *_scalar_places(pattern, unknown), WIDEST_BAND)


def fitting_system(unknown: Ints, row: Ints, column: Ints, widest_band: int) -> LinearSystem:
    """Banded up to a half-bandwidth, else sparse: factorised by PARDISO where it is installed, else by SuperLU.

    Args:
        unknown: number of the unknown of every coordinate, -1 for held ones, (n, coordinates).
        row: of every entry of the matrix, -1 for held ones, in the shape in which ``factorise`` will get the entries.
        column: of every entry, likewise.
        widest_band: that half-bandwidth.
    """
    used = (row >= 0) & (column >= 0)
    half_band = int(np.abs(row - column)[used].max(initial=0))
    if half_band <= widest_band:
        return BandedSystem(unknown, row, column, half_band)
    wide = PardisoSystem if pardiso_system.installed() else SparseSystem
    return wide(unknown, row, column)


def symmetric_system(row: Ints, column: Ints, size: int) -> LinearSystem:
    """The system for a positive definite matrix of one coordinate an unknown: banded, or its own L D L^T."""
    place = narrow_numbering(row, column, size)
    half_band = int(np.abs(place[row] - place[column]).max(initial=0))
    if half_band <= WIDEST_SYMMETRIC_BAND:
        return BandedSystem(place[:, None], place[row], place[column], half_band)
    return SymmetricSystem(row, column, size)


def narrow_numbering(row: Ints, column: Ints, size: int) -> Ints:
    """Places in which a symmetric pattern has a narrow band, by reverse Cuthill-McKee, (size,).

    Those they have, where no band is narrower: a row with k entries beside its diagonal reaches k / 2 to either side.
    """
    entries = np.unique(row.astype(np.int64) * size + column)
    beside = int(np.bincount(entries // size, minlength=1).max()) - 1
    if int(np.abs(row - column).max(initial=0)) <= (beside + 1) // 2:
        return np.arange(size, dtype=np.int32)
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    place = np.empty(size, dtype=np.int32)
    graph = csr_array((np.ones(len(row)), (row, column)), shape=(size, size))
    place[reverse_cuthill_mckee(graph, symmetric_mode=True)] = np.arange(size)
    return place


def _band_numbering(structure: Structure, pattern: Pattern) -> Ints:
    """Number of the unknown of every free coordinate, -1 for held ones, (n, 3)."""
    nodes = len(structure.free)
    place = narrow_numbering(pattern.row, pattern.column, nodes)
    free = structure.free > 0.0
    key = np.where(free, 3 * place[:, None] + np.arange(3), -1)
    unknown = np.full(3 * nodes, -1, dtype=np.int32)
    unknown[np.sort(key[free])] = np.arange(np.count_nonzero(free))
    return np.where(free, unknown[key], -1).astype(np.int32)


def _scalar_places(pattern: Pattern, unknown: Ints) -> tuple[Ints, Ints]:
    """Row and column of every entry of every block, -1 for held coordinates, each (b, 3, 3)."""
    row = np.repeat(unknown[pattern.row][:, :, None], 3, axis=2)
    column = np.repeat(unknown[pattern.column][:, None, :], 3, axis=1)
    return row, column


class BandedSystem:
    """Band LU without pivoting."""

    name = "a band LU"
    worthwhile_fall = 0.2

    def __init__(self, unknown: Ints, row: Ints, column: Ints, half_band: int) -> None:
        size = int(unknown.max(initial=-1)) + 1
        width = 2 * half_band + 1
        used = (row >= 0) & (column >= 0)
        place = np.where(used, row.astype(np.int64) * width + column - row + half_band, -1).ravel()
        self.arrays = Band(np.zeros((size, width)), place, unknown)

    def beside(self) -> "BandedSystem":
        """Another system of the same numbering, with room of its own."""
        other = copy(self)
        other.arrays = self.arrays._replace(rows=np.zeros(self.arrays.rows.shape))
        return other

    @property
    def ready(self) -> bool:
        """See ``LinearSystem``."""
        rows = self.arrays.rows
        return bool(rows[:, rows.shape[1] // 2].all())

    def factorise(self, blocks: Floats) -> int:
        """See ``LinearSystem``."""
        return int(factorise_band(blocks.reshape(-1), self.arrays.place, self.arrays.rows))

    def solve(self, right: Floats) -> Floats:
        """See ``LinearSystem``."""
        solution = np.zeros_like(right)
        solve_band(self.arrays.rows, self.arrays.unknown, right, solution)
        return solution

    def negative_pivots(self) -> int:
        """See ``LinearSystem``."""
        rows = self.arrays.rows
        return int(np.count_nonzero(rows[:, rows.shape[1] // 2] < 0.0))
