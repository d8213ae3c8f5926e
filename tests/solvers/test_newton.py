"""Newton's method: stable equilibria, no compression, agreement with relaxation, honest failures."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.equilibrium.stability import stability_of_whole
from codend.equilibrium.start_shapes import START
from codend.mechanics.bars import add_bar_tangent
from codend.mechanics.tangent import pattern_of
from codend.net.net import bar_vectors, rotate
from codend.plan.plan import plan_from_dict
from codend.solvers import continuation, dynamic_relaxation, newton
from codend.solvers.linear_systems import BandedSystem, _band_numbering, _scalar_places
from codend.solvers.newton import NewtonSettings
from codend.solvers.outcome import Outcome, Solution
from codend.solvers.refusal import Refusal
from codend.solvers.ring import Ring
from codend.solvers.sparse_system import SparseSystem
from validation.plain_nets import plain_net, plain_problem


def _problem(sectors=1, catch=None, drag=1.36, **section):
    netting = {
        "mesh": "diamond",
        "meshes_round": 60,
        "meshes_long": 30,
        "bar_mm": 40.0,
        "knot_mm": 0.0,
        "twine_mm": 3.0,
    } | section
    plan = plan_from_dict(
        {
            "title": "newton",
            "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": 0.33e-3 * netting["meshes_round"] * netting["bar_mm"] / np.pi},
            "netting": [netting],
            "catch": {"pressure": "sphere"} | (catch or {"filled_meshes": 12.0}),
            "drag": {"normal": drag, "tangential": 0.07 if drag else 0.0},
        }
    )
    return problem_of(build_bag(plan, sectors=sectors), plan, plan.cases()[0])


PLANS = {
    "inextensible T0": {},
    "knotted elastic T0": {"knot_mm": 5.0, "axial_stiffness_n": 1000.0},
    "knotted inextensible T0": {"knot_mm": 5.0},
    "elastic T90": {"mesh": "t90", "knot_mm": 5.0, "axial_stiffness_n": 1000.0},
    "inextensible T90": {"mesh": "t90", "knot_mm": 8.0},
    "T90 without knot length": {"mesh": "t90"},
    "square": {"mesh": "square"},
    "one mesh filled": {"catch": {"filled_meshes": 1.0}},
    "nearly empty stiff codend": {"catch": {"filled_meshes": 1.0}, "knot_mm": 5.0, "axial_stiffness_n": 3e5},
    "filled to nine tenths": {"catch": {"filled_meshes": 27.0}, "knot_mm": 5.0},
    "whole bag filled": {"catch": {"filled_meshes": 30.0}},
    "volume": {"catch": {"volume_m3": 0.08}},
    "plane front": {"catch": {"front_from_codline_m": 0.6}, "knot_mm": 5.0},
    "without twine drag": {"drag": 0.0},
}


@pytest.mark.parametrize("name", PLANS)
def test_a_rough_start_leads_to_an_equilibrium_without_compression(name):
    problem = _problem(**PLANS[name])
    solution = newton.solve(problem, 1e-8)
    report = solution.report
    assert report.outcome is Outcome.CONVERGED, report.attempts
    assert max(report.residual, report.imbalance) <= 1e-8
    assert report.length_error <= 1e-6
    prepared = newton.prepare(problem.structure, problem.bands)
    assert stability_of_whole(newton.tangent_at(problem, solution, prepared)) == "yes"
    assert solution.bar_tension.min() >= 0.0
    length = np.linalg.norm(bar_vectors(problem.net, solution.positions), axis=1)
    law = problem.net.bar_length * (1.0 + solution.bar_tension * problem.net.bar_flexibility)
    taut = solution.bar_tension > 0.0
    np.testing.assert_allclose(length[taut], law[taut], rtol=1e-6)
    assert np.all(length[~taut] <= law[~taut] * (1.0 + 1e-6))


@pytest.mark.parametrize("name", ["inextensible T0", "elastic T90", "volume", "plane front"])
def test_newton_agrees_with_dynamic_relaxation(name):
    problem = _problem(**PLANS[name])
    relaxed = dynamic_relaxation.solve(problem, 1e-7)
    solution = newton.solve(problem, 1e-9)
    size = np.ptp(solution.positions[:, 0])
    np.testing.assert_allclose(solution.positions, relaxed.positions, atol=1e-4 * size)
    np.testing.assert_allclose(solution.bar_tension, relaxed.bar_tension, atol=1e-4 * solution.bar_tension.max())
    np.testing.assert_allclose(solution.share, relaxed.share, atol=1e-3)


def test_random_plans_are_solved_to_round_off():
    rng = np.random.default_rng(20)
    for _ in range(8):
        problem = _problem(
            mesh=str(rng.choice(["diamond", "t90"])),
            meshes_round=int(rng.integers(40, 100)),
            meshes_long=int(rng.integers(20, 60)),
            bar_mm=float(rng.uniform(30.0, 60.0)),
            knot_mm=float(rng.choice([0.0, rng.uniform(2.0, 12.0)])),
            catch={"filled_meshes": float(rng.uniform(1.0, 18.0))},
            **({} if rng.random() < 0.5 else {"axial_stiffness_n": float(10.0 ** rng.uniform(3.0, 5.0))}),
        )
        report = newton.solve(problem, 1e-8).report
        assert report.outcome is Outcome.CONVERGED, report.attempts


def test_knots_that_lie_across_are_slack_where_the_ring_is_too_small_for_them():
    problem = _problem(**PLANS["inextensible T90"])
    solution = newton.solve(problem, 1e-8)
    net = problem.net
    knots = np.flatnonzero(net.bar_drag_diameter == 0.0)
    radius = np.hypot(solution.positions[:, 1], solution.positions[:, 2])[net.bars[knots, 0]]
    too_small = radius < 0.9 * net.order * net.bar_length[knots] / (2.0 * np.pi)
    assert np.any(too_small)
    assert np.all(solution.bar_tension[knots[too_small]] == 0.0)


def test_convergence_is_quadratic_near_the_solution():
    problem = _problem(knot_mm=5.0, axial_stiffness_n=1000.0)
    exact = newton.solve(problem, 1e-10)
    rng = np.random.default_rng(3)
    errors = []
    for size in (1e-2, 1e-3):
        move = size * problem.net.bar_length.min() * rng.normal(size=exact.positions.shape) * ~problem.net.fixed
        start = replace(exact, positions=exact.positions + move)
        run = newton._Iterations(problem, newton.prepare(problem.structure, problem.bands), NewtonSettings(), None)
        run._set_start(start, 0.1)
        before = np.linalg.norm(run.state.position - exact.positions)
        run.prepared.system.worthwhile_fall = 0.0
        assert run._advance(0.0, 0.0)
        errors.append((before, np.linalg.norm(run.state.position - exact.positions)))
    (wide, wide_left), (near, near_left) = errors
    order = np.log(wide_left / near_left) / np.log(wide / near)
    assert order > 1.8


@pytest.mark.parametrize("sectors", [2, None])
def test_sector_and_wider_models_have_the_same_equilibrium(sectors):
    narrow, wide = (_problem(c, meshes_round=12, meshes_long=10, catch={"filled_meshes": 4.0}) for c in (1, sectors))
    small, large = newton.solve(narrow, 1e-10), newton.solve(wide, 1e-10)

    def sorted_points(problem, solution):
        order = problem.net.order
        points = rotate(solution.positions, np.arange(order)[:, None], order).reshape(-1, 3).round(7) + 0.0
        return np.unique(points, axis=0)

    a, b = sorted_points(narrow, small), sorted_points(wide, large)
    assert a.shape == b.shape
    distance = np.linalg.norm(a[:, None] - b[None], axis=2).min(axis=1)
    assert distance.max() < 1e-6
    assert large.bar_tension.sum() * wide.net.order == pytest.approx(
        small.bar_tension.sum() * narrow.net.order, rel=1e-7
    )


def test_a_start_that_is_no_number_falls_back_on_relaxation_and_says_so():
    problem = _problem()
    nowhere = newton.solve(problem, 1e-8)
    nowhere = replace(nowhere, positions=np.full_like(nowhere.positions, np.nan))
    report = newton.solve(problem, 1e-8, nowhere).report
    assert report.outcome is Outcome.CONVERGED
    assert Outcome.NOT_FINITE.value in report.attempts[0]
    assert any("rough relaxation" in line for line in report.attempts)


def test_failure_returns_nan_and_the_reason():
    settings = NewtonSettings(iterations_allowed=1, switches=(0.1,), rough_starts=((1e-1, 30.0),))
    solution = newton.solve(_problem(), 1e-8, settings=settings)
    assert solution.report.outcome is Outcome.STEPS_SPENT
    assert np.all(np.isnan(solution.positions))
    assert np.all(np.isnan(solution.bar_tension))


@pytest.mark.parametrize("method", [newton, dynamic_relaxation], ids=["newton", "relaxation"])
def test_a_net_that_has_passed_through_itself_tells_nothing_of_what_fits_into_it(method, monkeypatch):
    problem = _problem(catch={"volume_m3": 4.0})
    assert method.solve(problem, 1e-6).report.outcome is Outcome.OVERFULL
    monkeypatch.setattr(method, "refusal", lambda *_: Refusal(Outcome.PASSED_THROUGH, "somewhere"))
    assert method.solve(problem, 1e-6).report.outcome is Outcome.PASSED_THROUGH


def _one_bar_in_tension_and_one_with(compression, excess):
    """A node pulled away from two fixed ones in line with it, and a start in which one bar carries (almost) all.

    The other one is too long by a share ``excess``, so that it counts as taut.
    """
    positions = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    fixed = np.array([[1, 1, 1], [0, 1, 1], [1, 1, 1]], dtype=bool)
    bars, lengths = np.array([[0, 1], [2, 1]]), np.array([1.0, 0.5 / (1.0 + excess)])
    problem = plain_problem(plain_net(positions, fixed, bars, lengths), np.array([0, 1, 0]))
    problem.loading.dead[1, 0] = 7.0
    start = Solution(positions, np.array([7.0 + compression, -compression]), np.zeros(problem.bands), START)
    return newton.solve(problem, 1e-8, start, replace(newton.DIRECT, switches=(0.1,)))


def test_compression_that_is_round_off_is_none_at_all_and_the_result_carries_none():
    solution = _one_bar_in_tension_and_one_with(7e-13, 1e-11)
    assert solution.report.outcome is Outcome.CONVERGED, solution.report.attempts
    assert solution.bar_tension[1] == 0.0
    assert solution.bar_tension[0] == pytest.approx(7.0, rel=1e-12)
    assert 0.0 < solution.report.residual < 1e-12, "measured again without the compression"


def test_compression_beyond_round_off_is_refused():
    assert _one_bar_in_tension_and_one_with(3e-8, 1e-7).report.outcome is Outcome.COMPRESSED


def test_progress_hears_of_every_iteration():
    heard = []
    report = newton.solve(_problem(), 1e-8, progress=lambda _, residual: heard.append(residual)).report
    assert heard == list(report.history)


def _tangent(problem, shift):
    structure, pattern = problem.structure, pattern_of(problem.structure)
    blocks = np.zeros((len(pattern.row), 3, 3))
    rng = np.random.default_rng(5)
    bars = len(structure.first)
    position = problem.net.positions + 1e-3 * rng.normal(size=problem.net.positions.shape)
    add_bar_tangent(position, structure, pattern, rng.uniform(1.0, 9.0, bars), rng.uniform(0.0, 1e4, bars), blocks)
    blocks[pattern.diagonal] += shift * np.eye(3)
    unknown = _band_numbering(structure, pattern)
    row, column = _scalar_places(pattern, unknown)
    used = (row >= 0) & (column >= 0)
    size = unknown.max() + 1
    matrix = csc_array((blocks[used], (row[used], column[used])), shape=(size, size)).toarray()
    return blocks, unknown, row, column, matrix


@pytest.mark.parametrize("sectors", [1, None])
@pytest.mark.parametrize("shift", [0.0, -150.0])
def test_band_and_sparse_factors_solve_the_dense_system_and_pivots_count_eigenvalues(sectors, shift):
    problem = _problem(sectors, meshes_round=12, meshes_long=8, knot_mm=5.0, catch={"filled_meshes": 3.0})
    blocks, unknown, row, column, matrix = _tangent(problem, shift)
    half_band = int(np.abs(row - column)[(row >= 0) & (column >= 0)].max())
    banded, sparse = BandedSystem(unknown, row, column, half_band), SparseSystem(unknown, row, column)
    right = np.random.default_rng(6).normal(size=(2, len(unknown), 3))
    negative = banded.factorise(blocks)
    assert negative == np.count_nonzero(np.linalg.eigvalsh(matrix) < 0.0)
    sparse.factorise(blocks)
    free = unknown >= 0
    expected = np.zeros_like(right)
    for side in range(2):
        vector = np.empty(len(matrix))
        vector[unknown[free]] = right[side][free]
        expected[side][free] = np.linalg.solve(matrix, vector)[unknown[free]]
    scale = np.abs(expected).max()
    np.testing.assert_allclose(banded.solve(right), expected, atol=1e-7 * scale)
    np.testing.assert_allclose(sparse.solve(right), expected, atol=1e-7 * scale)


def test_a_path_in_steps_ends_where_a_solve_from_scratch_does():
    problem = _problem(knot_mm=5.0)
    first = newton.solve(continuation.with_catch(problem, 2.0), 1e-9)
    wanted = continuation.with_catch(problem, 20.0)
    prepared = newton.prepare(problem.structure, problem.bands)
    tried = []

    def short_of_breath(step, start):
        tried.append(step.loading.catch.size)
        settings = NewtonSettings(rough_starts=(), switches=(0.1,), iterations_allowed=5)
        return newton.solve(step, 1e-9, start, settings, prepared=prepared)

    solution = continuation.in_steps(wanted, (2.0, first), short_of_breath)
    assert solution.report.outcome is Outcome.CONVERGED
    assert len(tried) > 2
    assert tried[-1] == 20.0
    np.testing.assert_allclose(solution.positions, newton.solve(wanted, 1e-9).positions, atol=1e-6)


def test_a_path_that_leads_nowhere_is_given_up_honestly():
    problem = _problem(knot_mm=5.0)
    first = newton.solve(continuation.with_catch(problem, 2.0), 1e-9)
    beyond = continuation.with_catch(problem, 31.0)
    direct = NewtonSettings(rough_starts=(), switches=(0.1,))
    solution = continuation.in_steps(beyond, (2.0, first), lambda step, at: newton.solve(step, 1e-9, at, direct))
    assert not solution.report.outcome.converged
    assert np.all(np.isnan(solution.positions))


def test_prediction_is_exact_for_quadratics():
    solution = newton.solve(_problem(), 1e-6)
    direction = np.random.default_rng(8).normal(size=solution.positions.shape)

    def at(value):
        return replace(solution, positions=solution.positions + (3.0 * value - 0.2 * value**2) * direction)

    predicted = continuation.predict([(v, at(v)) for v in (1.0, 2.0, 4.0)], 5.0)
    np.testing.assert_allclose(predicted.positions, at(5.0).positions, atol=1e-9)


def test_a_solve_nearby_that_keeps_the_factors_makes_no_new_ones_and_ends_at_the_same_equilibrium(monkeypatch):
    problem = _problem(None, meshes_round=60, meshes_long=10, knot_mm=5.0, catch={"filled_meshes": 4.0})
    prepared = newton.prepare(problem.structure, problem.bands)
    assert isinstance(prepared.system, SparseSystem)
    assert not prepared.system.ready
    known = newton.solve(problem, 1e-9, prepared=prepared)
    nearby = continuation.with_catch(problem, 4.1)
    expected = newton.solve(nearby, 1e-10, known, newton.DIRECT)
    made = []
    factorise = SparseSystem.factorise
    monkeypatch.setattr(SparseSystem, "factorise", lambda self, blocks: made.append(1) or factorise(self, blocks))
    tangent = newton.tangent_at(problem, known, prepared)
    assert not tangent.singular
    solution = newton.solve_nearby(nearby, 1e-10, known, tangent)
    assert solution.report.outcome is Outcome.CONVERGED
    np.testing.assert_allclose(solution.positions, expected.positions, atol=1e-9)
    assert len(made) == 1
    # without any to keep, Newton's method makes its own
    newton.solve(nearby, 1e-10, known, newton.DIRECT)
    assert len(made) > 1


def test_an_answer_is_polished_from_the_state_of_its_tangent_as_from_its_own():
    problem = _problem(catch={"filled_meshes": 4.3})
    prepared, ring = newton.prepare(problem.structure, problem.bands), Ring(problem.structure, problem.bands)
    known = newton.solve(problem, 1e-4, prepared=prepared)
    expected = newton.solve_nearby(problem, 1e-11, known, newton.tangent_at(problem, known, prepared, ring))
    polished = newton.polished(newton.tangent_at(problem, known, prepared, ring), 1e-11)
    assert polished is not None
    assert len(expected.report.history) > 1
    np.testing.assert_array_equal(polished.positions, expected.positions)
    np.testing.assert_array_equal(polished.bar_tension, expected.bar_tension)
