"""Wide nets factorised by PARDISO, where the optional package ``py-mkl-pardiso`` is installed (the extra ``fast``).

The tangent is not symmetric: follower pressure and drag put in up to 7 % of the bars' geometric stiffness on the flume
net, 80 % once 10 x 10 of its meshes are merged into one. So a library for symmetric matrices would factorise another
matrix (its answer left a sixth of the right side), and the ones for general matrices are to be compared. Numerical
factorisation of the tangent of the flume net, 40 meshes filled, one thread of a shared two-core machine, least of
several, in ms of processor time; all answers agree within the 1e-7 that the tangent's condition allows:

    unknowns (meshes merged)    1 216 (10)   4 951 (5)   31 276 (2)   125 551 (1)
    SuperLU, symmetric mode        3.4         22.9         277          1835
    py-mkl-pardiso                 1.6         10.2         108           677
    pypardiso                      1.6         10.3         105           660
    qdldl, symmetric part only     1.6         13.8         357          4090

PARDISO finds its ordering once (0.5 s on the largest) where SuperLU finds it every time. py-mkl-pardiso was chosen for
one wheel of 18 MB without other packages, against 0.7 GB, and for refactorising by a public call. Its wrapper is under
the MIT licence, the MKL in it under Intel's Simplified Software License; wheels exist for Linux and Windows on x86-64.
Others did not install clean or not run: scikit-sparse (CHOLMOD), scikit-umfpack and pydiso have no wheels for
Python 3.11, the wheel of python-mumps found there asks for numpy 1, cvxopt and kvxopt are under the GPL.
"""

from importlib.util import find_spec
from typing import Any

from codend.net.net import Floats, Ints
from codend.solvers.sparse_system import SparseSystem

_ORDERING, _PERTURBATION, _SCALING, _MATCHING, _PERTURBED = 1, 9, 10, 12, 13
"""Places of PARDISO's parameters, counted from 0."""
_NESTED_DISSECTION = 2


def installed() -> bool:
    """Whether PARDISO is there to be used."""
    return find_spec("pymklpardiso") is not None


class PardisoSystem(SparseSystem):
    """PARDISO for matrices of symmetric pattern, its order found once: no scaling or exchange by the first values."""

    name = "PARDISO"

    def __init__(self, unknown: Ints, row: Ints, column: Ints) -> None:
        super().__init__(unknown, column, row)  # it wants the rows in order, which are the transpose's columns
        self._solver: Any = None

    def factorise(self, blocks: Floats) -> int:
        """See ``LinearSystem``; a pivot that had to be moved off 0 counts as singular."""
        from pymklpardiso import MTYPE_REAL_STRUCT_SYM, PardisoSolver
        from scipy.sparse import csr_array

        self._blocks = blocks.copy()
        values = blocks.reshape(-1)[self._gather]
        if self._solver is None:
            matrix = csr_array((values, self._indices, self._starts), shape=(self.size, self.size))
            parameters = {_ORDERING: _NESTED_DISSECTION, _PERTURBATION: 13, _SCALING: 0, _MATCHING: 0}
            self._solver = PardisoSolver(matrix, MTYPE_REAL_STRUCT_SYM, parameters)
        else:
            self._solver.refactor(values)
        self._factors = self._solver
        return -1 if self._solver.get_iparm_value(_PERTURBED) > 0 else 0

    def negative_pivots(self) -> int:
        """See ``LinearSystem``; PARDISO does not show its pivots, so SuperLU factorises the same tangent once more."""
        if super().factorise(self._blocks) < 0:
            return -1
        negative = super().negative_pivots()
        self._factors = self._solver
        return negative
