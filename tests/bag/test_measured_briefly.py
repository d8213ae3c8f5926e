"""What is measured briefly of a bag, and of a bag that is pressed otherwise, is what measuring all of it finds."""

from dataclasses import fields, replace

import numpy as np
import pytest

from codend.bag.bag_kernels import SUMS
from codend.bag.build import build_bag
from codend.bag.loads import in_case, problem_of
from codend.bag.measure_kernels import knots_all_but_slack
from codend.bag.measures import Measures, measure_all, measure_briefly, measure_with_changed
from codend.mechanics.catch_front import fill
from codend.solvers import newton
from codend.studies.study import solve
from tests.bag.test_windows_and_seams import OTHER, plan
from tests.plans import joined_plan, make_plan

KINDS = [("diamond", {}), ("diamond", {"knot_mm": 8.0}), ("t90", {"knot_mm": 8.0}), ("square", {})]


def at_rest(bag, wanted):
    problem = problem_of(bag, wanted, wanted.cases()[0])
    return problem, newton.solve(problem, 1e-8)


def assert_same(bag, problem, solution):
    brief, whole = measure_briefly(bag, problem, solution), measure_all(bag, problem, solution)[2].estimated
    # to the last digit: estimates are differences of these
    assert np.array_equal(brief, whole, equal_nan=True)


def test_sums_are_written_in_the_order_of_measures():
    assert tuple(field.name for field in fields(Measures)) == SUMS


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
def test_estimates_stand_beside_what_is_measured_wherever_the_front_is(mesh, netting):
    wanted = make_plan(12, 10, mesh=mesh, netting=netting, filled=4.0)
    bag = build_bag(wanted, sectors=1)
    problem, solution = at_rest(bag, wanted)
    catch = wanted.cases()[0]
    # from a front in the last mesh to one ahead of which there is no whole mesh
    for filled in (0.01, 0.5, 1.0, 3.25, 5.0, 6.5, 8.0, 8.99, 9.0, 9.5, 9.999):
        case = replace(catch, catch_value=filled)
        there = in_case(problem, bag, wanted, case)
        share = solution.share.copy()
        assert fill(solution.positions, there.structure, there.loading.catch, share)
        assert_same(bag, there, replace(solution, share=share))


@pytest.mark.parametrize(
    "wanted",
    [
        joined_plan(("diamond", 12, 6, 40.0, {}), ("t90", 6, 5, 40.0, {"knot_mm": 8.0}), catch={"volume_m3": 0.004}),
        joined_plan(("square", 12, 6, 40.0, {}), ("diamond", 12, 5, 40.0, {}), entry=0.06),
        make_plan(24, 20, model={"fidelity": "globalised", "globalisation": 2}),
        plan({}, windows=[next(iter(OTHER.values()))]),
    ],
    ids=["fewer", "square ahead", "merged", "window"],
)
def test_estimates_stand_beside_what_is_measured_of_joined_merged_and_windowed_netting(wanted):
    (result,) = solve(wanted).cases
    assert result.converged
    assert_same(result.bag, result.problem, result.solution)


@pytest.mark.parametrize("catch", [{"filled_meshes": 3.0}, {"volume_m3": 0.002}, {"front_from_codline_m": 0.15}])
def test_drag_under_another_pressure_law_is_that_of_a_bag_under_it(catch):
    wanted = make_plan(12, 10, catch=catch)
    bag = build_bag(wanted, sectors=1)
    problem, solution = at_rest(bag, wanted)
    law = problem.loading.catch
    coefficients = 1.3 * law.coefficients
    moved = solution.positions * [1.01, 0.98, 0.98]
    brief, drag_n = measure_with_changed(bag, problem, solution, coefficients, moved)
    assert brief == measure_briefly(bag, problem, solution)
    loading = problem.loading._replace(catch=law._replace(coefficients=coefficients))
    share = solution.share.copy()
    assert fill(moved, problem.structure, loading.catch, share)
    there = replace(solution, positions=moved, share=share)
    assert drag_n == measure_briefly(bag, replace(problem, loading=loading), there)[0]
    assert abs(drag_n / brief[0] - 1.0) > 0.05


def test_knots_all_but_slack_are_those_of_three_bars_and_more_of_which_at_most_one_pulls():
    rng = np.random.default_rng(5)
    nodes, bars = 60, 130
    first, second = rng.integers(nodes, size=(2, bars)).astype(np.int32)
    tension, free = rng.normal(size=bars), (rng.random((nodes, 3)) < 0.95).astype(float)
    wanted = []
    for node in range(nodes - 1):
        ends = np.concatenate([tension[first == node], tension[second == node]])
        if len(ends) >= 3 and (ends > 0.7).sum() <= 1 and free[node].all():
            wanted.append(node)
    assert len(wanted) > 10
    assert knots_all_but_slack(first, second, tension, 0.7, free, nodes - 1).tolist() == wanted
