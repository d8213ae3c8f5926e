"""The interior-point method where Newton's method finds nothing: long joined nets, much of whose twine is slack."""

import numpy as np
import pytest

from codend.bag.bag import Bag
from codend.bag.loads import problem_of
from codend.bag.measures import measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.mechanics.problem import Problem
from codend.plan.plan import Plan, plan_from_dict
from codend.scenes.build import build
from codend.scenes.equilibrium import find
from codend.scenes.scene import scene_from_dict
from codend.solvers import barrier, interior_point
from codend.solvers.outcome import Outcome, Solution
from tests.plans import UNIFORM, joined_plan, make_plan
from validation.cage.gear import box

JOINED = {
    "T90, T90 and diamond": joined_plan(
        ("t90", 60, 49, 41.4, {"knot_mm": 7.16, "twine_mm": 2.31, "axial_stiffness_n": 507.0}),
        ("t90", 40, 36, 44.7, {"twine_mm": 2.61, "axial_stiffness_n": 17100.0}),
        ("diamond", 40, 39, 44.7, {"knot_mm": 7.09, "twine_mm": 3.02}),
        entry=0.43,
        catch={"filled_meshes": 10.6},
    ),
    "T90 and diamond, nearly empty": joined_plan(
        ("t90", 60, 51, 33.3, {"knot_mm": 3.41, "twine_mm": 1.61}),
        ("diamond", 45, 43, 33.8, {"twine_mm": 1.15}),
        entry=0.395,
        catch={"filled_meshes": 2.13, **UNIFORM},
    ),
    "three kinds of twine": joined_plan(
        ("t90", 180, 36, 76.7, {"knot_mm": 13.0, "twine_mm": 7.6}),
        ("diamond", 120, 48, 69.5, {"knot_mm": 13.5, "twine_mm": 5.0, "axial_stiffness_n": 3030.0}),
        ("diamond", 60, 52, 85.1, {"twine_mm": 5.04}),
        entry=1.09,
        catch={"filled_meshes": 4.6},
    ),
}


def solved(plan: Plan) -> tuple[Bag, Problem, Solution]:
    model = model_of(plan, 1, 1)
    problem = problem_of(model.bag, plan, plan.cases()[0])
    return model.bag, problem, interior_point.solve(problem, 1e-8, prepared=model.prepared)


@pytest.mark.parametrize("name", JOINED)
def test_much_slack_twine_is_found_from_a_crude_bag(name):
    bag, problem, solution = solved(JOINED[name])
    assert solution.report.outcome is Outcome.CONVERGED
    assert np.all(solution.bar_tension >= 0.0)
    assert np.count_nonzero(solution.bar_tension == 0.0) > 0.03 * len(solution.bar_tension)
    measures = measure_all(bag, problem, solution)[2]
    assert measures.entry_reaction_n == pytest.approx(measures.drag_n, rel=1e-7)
    assert measures.folded_share == 0.0


def roped(meshes_long: int, filled: float, number: int, knot_mm: float) -> Plan:
    """Double twine with ropes 15 % short: much netting between them hangs all but slack in the current."""
    return plan_from_dict(
        {
            "title": "ropes",
            "tow": {"speed_m_s": 1.5},
            "entry": {"hanging_ratio": 0.3},
            "netting": [
                {
                    "mesh": "diamond",
                    "meshes_round": 60,
                    "meshes_long": meshes_long,
                    "inside_mesh_mm": 100.0,
                    "knot_mm": knot_mm,
                    "twine_mm": 4.0,
                    "twines": 2,
                }
            ],
            "rope": [{"number": number, "shortening": 0.15, "diameter_mm": 24.0, "axial_stiffness_n": 5e5}],
            "catch": {"filled_meshes": filled},
        }
    )


def between_ropes(plan: Plan) -> tuple[Bag, Problem, Solution]:
    """Solved through the interior alone, from where the same net's ropes are smeared."""
    model = model_of(plan, 1, 1)
    problem, solution = equilibrium.solve(model, plan.cases()[0], (), None)
    assert len(solution.report.attempts) == 2
    return model.bag, problem, solution


@pytest.mark.parametrize(("number", "knot_mm", "filled"), [(4, 12.0, 16.0), (4, 0.0, 8.0), (6, 0.0, 12.0)])
def test_ropes_far_shorter_than_netting_with_and_without_knots_are_found_in_a_few_dozen_steps(number, knot_mm, filled):
    bag, problem, solution = between_ropes(roped(30, filled, number, knot_mm))
    assert solution.report.outcome is Outcome.CONVERGED
    assert solution.report.iterations < 60
    measures = measure_all(bag, problem, solution)[2]
    assert measures.entry_reaction_n == pytest.approx(measures.drag_n, rel=1e-6)


def test_steps_that_a_nearly_singular_tangent_asks_for_lead_astray_however_shortened(monkeypatch):
    plan = roped(30, 16.0, 4, 12.0)
    shifted = between_ropes(plan)[2].report.iterations
    monkeypatch.setattr(barrier, "FARTHEST_TURN", np.inf)
    assert between_ropes(plan)[2].report.iterations > 1.1 * shifted


@pytest.mark.parametrize(("mesh", "most"), [("diamond", 20), ("t90", 60)])
def test_stiff_twine_is_found_from_a_crude_bag(mesh, most):
    netting = {"knot_mm": 12.0, "bending_stiffness_n_m2": 2e-3, "axial_stiffness_n": 2000.0}
    plan = make_plan(100, 50, 0.27, 20.0, mesh=mesh, bar_mm=48.0, netting=netting, speed=1.5)
    report = solved(plan)[2].report
    assert report.outcome is Outcome.CONVERGED
    assert report.iterations < most


@pytest.mark.parametrize("like", [{}, {"ballast_kg": 6.0}, {"along_foot": True}, {"twine_density_kg_m3": 1140.0}])
def test_slack_cages_at_rest_are_found_in_a_few_dozen_steps(like):
    """A convex problem, in which lead at the corners pulls a hundred times the mean."""
    problem = build(scene_from_dict(box(merged=8, **like))).problem
    report = interior_point.solve(problem, 1e-9).report
    assert report.outcome is Outcome.CONVERGED
    assert report.iterations < 40


def test_a_slack_cage_that_the_first_test_for_taut_bars_does_not_settle_is_not_kept_waiting_for_it():
    """Its bars go taut and slack in turns by that test: 33 of 83 factorisations were spent on it."""
    problem = build(scene_from_dict(box(0.05, merged=8, ballast_kg=24.0))).problem
    touching, found = find(problem, 1e-8, True)
    through = next(attempt for attempt in found.report.attempts if attempt.startswith("interior point"))
    in_the_interior = int(through.split(":")[1].split()[0])
    assert found.report.outcome is Outcome.CONVERGED
    assert len(touching.loading.contact.kind) > 0
    assert found.report.iterations - in_the_interior < 12
