"""Gentle motion comes back where a net is stable, runs away where it is not, and stops where netting meets netting."""

from dataclasses import replace

import numpy as np
import pytest

from codend.bag.loads import problem_of
from codend.bag.measures import measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.start_shapes import all_round_start
from codend.plan.plan import Plan, plan_from_dict
from codend.solvers import gentle, newton
from codend.solvers.gentle import End
from codend.solvers.refusal import passage, refusal
from tests.plans import make_plan


def shaken_whole_net(plan: Plan, share: float, seed: int):
    """The whole net of a sector's equilibrium, its free knots moved at random by a share of a bar."""
    sector, whole = model_of(plan, 1, 1), model_of(plan, 1, None)
    (case,) = plan.cases()
    _, found = equilibrium.solve(sector, case, (), None)
    problem = problem_of(whole.bag, plan, case)
    start = all_round_start(sector.bag, found.positions, found.bar_tension, sector.bag.net.order)
    moves = np.random.default_rng(seed).standard_normal(start.positions.shape) * ~problem.net.fixed
    moved = share * float(np.median(problem.structure.length)) * moves
    return whole, problem, replace(start, positions=start.positions + moved)


def test_the_square_net_that_went_through_itself_comes_back_when_shaken():
    """square_full_net_through_itself: 22.03 N and 25.85 degrees."""
    plan = plan_from_dict(
        {
            "title": "square",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": 0.05729577951308232},
            "netting": [{"mesh": "square", "meshes_round": 48, "meshes_long": 24, "bar_mm": 25.0, "twine_mm": 3.0}],
            "catch": {"filled_meshes": 2.0},
        }
    )
    for seed in range(3):
        whole, problem, start = shaken_whole_net(plan, 0.01, seed)
        motion = gentle.follow(problem, 1e-8, start, whole.prepared)
        assert motion.end is End.SETTLED
        measures = measure_all(whole.bag, problem, motion.solution)[2]
        assert measures.drag_n == pytest.approx(22.027, abs=1e-3)
        assert measures.opening_ahead_deg == pytest.approx(25.85, abs=0.01)


def test_no_step_is_longer_than_a_share_of_a_bar_and_none_carries_netting_through_netting(monkeypatch):
    whole, problem, start = shaken_whole_net(make_plan(16, 8, 0.2, 1.5, mesh="t90", netting={"knot_mm": 8.0}), 0.02, 1)
    places, take = [start.positions], gentle.newton_step.take

    def noted(*arguments):
        take(*arguments)
        there, new = arguments[7], arguments[9]
        if np.abs(there.position - places[-1]).max() > 0.0:
            places.append(there.position.copy())
        assert np.linalg.norm(new.position - there.position, axis=1).max() <= 1.001 * gentle.LONGEST * bar

    bar = float(np.median(problem.structure.length))
    monkeypatch.setattr(gentle.newton_step, "take", noted)
    motion = gentle.follow(problem, 1e-8, start, whole.prepared)
    assert len(places) > 2
    assert all(passage(problem, place, gathered=False) is None for place in places)
    if motion.end is End.SETTLED:
        assert refusal(problem, motion.solution.positions, motion.solution.share) is None


def test_a_start_in_balance_stays():
    plan = make_plan(12, 8, filled=3.0)
    whole, problem, start = shaken_whole_net(plan, 0.0, 0)
    exact = newton.solve(problem, 1e-10, start, newton.DIRECT, None, whole.prepared)
    motion = gentle.follow(problem, 1e-10, exact, whole.prepared)
    assert motion.end is End.SETTLED
    np.testing.assert_allclose(motion.solution.positions, exact.positions, atol=1e-8)
