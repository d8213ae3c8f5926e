"""PARDISO, where it is installed: the same solutions, pivots and equilibria as with SuperLU."""

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.mechanics.tangent import pattern_of
from codend.solvers import newton, pardiso_system
from codend.solvers.linear_systems import _band_numbering, _scalar_places, linear_system
from codend.solvers.outcome import Outcome
from codend.solvers.pardiso_system import PardisoSystem
from codend.solvers.sparse_system import SparseSystem
from tests.plans import make_plan

needs_pardiso = pytest.mark.skipif(not pardiso_system.installed(), reason="py-mkl-pardiso is not installed")


@pytest.fixture(scope="module")
def problem():
    plan = make_plan(60, 10, filled=4.0, netting={"knot_mm": 5.0})
    return problem_of(build_bag(plan), plan, plan.cases()[0])


def without_pardiso(monkeypatch):
    monkeypatch.setattr(pardiso_system, "installed", lambda: False)


def test_wide_nets_fall_back_on_superlu(problem, monkeypatch):
    without_pardiso(monkeypatch)
    assert type(linear_system(problem.structure, pattern_of(problem.structure))) is SparseSystem


@needs_pardiso
def test_it_solves_what_superlu_solves_for_one_pattern_and_many_values(problem):
    structure, pattern = problem.structure, pattern_of(problem.structure)
    unknown = _band_numbering(structure, pattern)
    row, column = _scalar_places(pattern, unknown)
    ours, theirs = PardisoSystem(unknown, row, column), SparseSystem(unknown, row, column)
    rng = np.random.default_rng(4)
    right = rng.normal(size=(2, len(unknown), 3))
    for shift in (90.0, 6.0, 90.0):
        blocks = rng.normal(size=(len(pattern.row), 3, 3))
        blocks[pattern.diagonal] += shift * np.eye(3)
        assert ours.factorise(blocks) == theirs.factorise(blocks) == 0
        expected = theirs.solve(right)
        np.testing.assert_allclose(ours.solve(right), expected, atol=1e-9 * np.abs(expected).max())
    blocks[:] = 0.0
    assert ours.factorise(blocks) == -1


@needs_pardiso
def test_equilibria_are_the_same_with_either_library_and_the_report_names_it(problem, monkeypatch):
    fast = newton.solve(problem, 1e-10)
    without_pardiso(monkeypatch)
    plain = newton.solve(problem, 1e-10)
    for solution, library in ((fast, "PARDISO"), (plain, "SuperLU")):
        assert solution.report.outcome is Outcome.CONVERGED
        assert f"with {library}" in solution.report.attempts[-1]
    np.testing.assert_allclose(fast.positions, plain.positions, atol=1e-8)
    np.testing.assert_allclose(fast.bar_tension, plain.bar_tension, atol=1e-6 * plain.bar_tension.max())
