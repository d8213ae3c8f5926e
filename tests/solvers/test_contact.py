"""Nets that rest on something, or on themselves, against closed forms; each solver that knows contact."""

from dataclasses import replace

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.mechanics.contact import add_force
from codend.mechanics.drag_laws import drag
from codend.mechanics.problem import Problem
from codend.mechanics.surface import ContactLaw, Surface
from codend.mechanics.water import uniform_flow
from codend.net.net import Net
from codend.solvers import dynamic_relaxation, gentle, interior_point, newton, rigid_bars
from codend.solvers.dynamic_relaxation import RelaxationSettings
from codend.solvers.motion import Motion
from codend.solvers.solve import find_equilibrium
from tests.plans import make_plan
from validation.contact import chain_on_a_floor

SETTINGS = RelaxationSettings(steps_allowed=60_000, restarts=0)


def pushes(problem: Problem, positions: np.ndarray) -> np.ndarray:
    """What contact does to the nodes, N."""
    force = np.zeros_like(positions)
    add_force(positions, problem.touching_at(positions).loading.contact, force)
    return force


def suspended(z: float, pull: float = 30.0, weight: float = 20.0) -> float:
    return float(np.sqrt(z**2 + 2.0 * pull / weight * z))


def test_a_chain_hangs_to_a_floor_as_long_as_its_catenary_is():
    problem = chain_on_a_floor(200, 3.0, 2e-5)
    solution = find_equilibrium(problem, 1e-9)
    assert solution.report.outcome.converged
    x, p = solution.positions[:201], pushes(problem, solution.positions)
    carried = 20.0 * 10.0 - p[:201, 2].sum()
    assert carried / 20.0 == pytest.approx(suspended(3.0), rel=1e-4)
    assert 0.0 < x[:, 2].min() < 2e-5
    assert p[201:, 2].sum() == pytest.approx(-p[:201, 2].sum(), rel=1e-9)
    assert solution.bar_tension[-1] == pytest.approx(30.0, rel=1e-6)


def test_relaxation_lays_a_chain_on_a_floor_as_gentle_steps_do():
    problem = chain_on_a_floor(20, 1.0, 5e-3)
    expected = gentle.solve(problem, 1e-9)
    found = dynamic_relaxation.solve(problem, 1e-6, settings=SETTINGS)
    assert found.report.outcome.converged
    assert np.abs(found.positions - expected.positions).max() < 2e-3


def test_the_interior_point_lays_a_chain_on_a_floor_as_gentle_steps_do():
    problem = chain_on_a_floor(50, 2.0, 1e-3)
    expected, found = gentle.solve(problem, 1e-9), interior_point.solve(problem, 1e-9)
    assert found.report.outcome.converged
    assert found.report.iterations < expected.report.iterations
    assert np.abs(found.positions - expected.positions).max() < 1e-6


def test_newtons_method_goes_on_from_a_chain_on_a_floor_to_one_pulled_harder():
    problem = chain_on_a_floor(50, 2.0, 1e-3)
    start = gentle.solve(problem, 1e-9)
    pull = problem.loading.dead.copy()
    pull[50, 0] = 33.0
    harder = replace(problem, loading=problem.loading._replace(dead=pull))
    found = newton.solve(harder, 1e-9, start, newton.DIRECT)
    assert found.report.outcome.converged
    lifted = 20.0 * 10.0 - pushes(harder, found.positions)[:51, 2].sum()
    assert lifted / 20.0 == pytest.approx(suspended(2.0, 33.0), rel=3e-3)


def test_a_chain_in_motion_comes_to_rest_on_a_floor_and_never_falls_through():
    problem = chain_on_a_floor(10, 0.5, 0.02)
    motion = Motion(problem, problem.net.positions)
    for _ in range(400):
        motion.step(5e-3)
        assert motion.position[:11, 2].min() > 0.0
        motion.velocity *= 0.97  # still water would damp it as much
    rest = gentle.solve(problem, 1e-9)
    assert np.abs(motion.position - rest.positions).max() < 0.02


def test_a_sheet_pushed_on_a_smooth_wall_is_free_as_far_as_its_closed_form_says():
    height, ballast, per_m, distance, bars = 4.0, 10.0, 8.0, 0.6, 200
    gap = 1e-4
    width = 2.0 * per_m / (1000.0 * 1.36)
    z = -np.arange(bars + 1) * height / bars
    # from a sheet that nearly reaches the wall
    strip = np.stack([np.minimum(0.55, -0.2 * z), 0 * z, z], axis=1)
    wall = np.array([[distance, -9.0, 5.0], [distance, 9.0, 5.0], [distance, 0.0, -30.0]])
    nodes = np.concatenate([strip, wall])
    held = np.zeros((len(nodes), 3), dtype=bool)
    held[0] = held[-3:] = held[:, 1] = True
    ends = np.stack([np.arange(bars), np.arange(1, bars + 1)], axis=1)
    net = Net.from_bars(
        nodes, ends, held, length_m=height / bars, diameter_m=width, drag=drag("le-bris-1999", 1.36, 0.0),
        facets=[[bars + 1, bars + 2, bars + 3]],
    )  # fmt: skip
    force = np.zeros_like(nodes)
    force[bars, 2] = -ballast
    water = uniform_flow(1000.0, np.array([1.0, 0.0, 0.0]))
    law = ContactLaw(gap, 3.0 * per_m * height / bars / gap)
    problem = Problem.of(net, nodal_force_n=force, water=water, weight=False, contact=law)
    solution = find_equilibrium(problem, 1e-9)
    assert solution.report.outcome.converged
    free = ballast / per_m * (np.sqrt((1.0 + per_m * distance / ballast) ** 2 - 1.0))
    reaction = -pushes(problem, solution.positions)[: bars + 1, 0].sum()
    assert reaction == pytest.approx(per_m * (height - free), rel=1e-3)
    assert solution.bar_tension[-1] == pytest.approx(ballast, rel=1e-4)


def rings(outer_length: float, inner_length: float, outer_ea: float, push: float) -> Problem:
    """Two rings of 24 bars, one in the other, each a node of a sector; the inner is pressed outwards."""
    order, angle = 24, 2.0 * np.pi / 24
    nodes = np.array([[0.0, 0.97, 0.0], [0.0, 1.0, 0.0]])
    held = np.array([[True, False, False]] * 2)
    side = np.array([inner_length, outer_length]) * 2.0 * np.sin(0.5 * angle)
    net = Net.from_bars(nodes, [[0, 0], [1, 1]], held, length_m=side, stiffness_n=[2000.0, outer_ea])
    net = replace(net, order=order, bar_image=np.ones(2, dtype=np.int32))
    force = np.array([[0.0, push, 0.0], [0.0, 0.0, 0.0]])
    return Problem.of(net, nodal_force_n=force, weight=False, contact=ContactLaw(2e-4, 1e4 * push))


def test_two_elastic_rings_share_the_pressure_by_their_stiffness():
    problem = rings(1.0, 0.98, 3000.0, 60.0)
    solution = find_equilibrium(problem, 1e-10)
    assert solution.report.outcome.converged
    inner, outer = np.linalg.norm(solution.positions, axis=1)
    assert 0.0 < outer - inner < 2e-4
    angle = 2.0 * np.pi / 24
    # the load on a node is carried by both: 2 sin(angle / 2) (T_i + T_o), with the radii all but the same
    strain = (60.0 / (2.0 * np.sin(0.5 * angle)) + 2000.0 + 3000.0) / (2000.0 / 0.98 + 3000.0)
    assert inner == pytest.approx(strain, rel=2e-4)
    pulls = np.array([2000.0 * (inner / 0.98 - 1.0), 3000.0 * (outer - 1.0)])
    assert solution.bar_tension == pytest.approx(pulls, rel=1e-6)
    assert pushes(problem, solution.positions)[1, 1] == pytest.approx(2.0 * np.sin(0.5 * angle) * pulls[1], rel=1e-8)


def test_a_ring_with_length_to_spare_lies_slack_in_a_rigid_hoop_that_carries_all():
    problem = rings(1.0, 1.1, 1e9, 60.0)
    solution = find_equilibrium(problem, 1e-10)
    assert solution.report.outcome.converged
    assert solution.bar_tension[0] == 0.0
    angle = 2.0 * np.pi / 24
    assert solution.bar_tension[1] == pytest.approx(60.0 / (2.0 * np.sin(0.5 * angle)), rel=1e-6)


@pytest.mark.parametrize("mesh", ["diamond", "square"])
@pytest.mark.parametrize("sectors", [1, None])
def test_contact_changes_nothing_where_nothing_touches(mesh, sectors):
    plan = make_plan(12, 10, mesh=mesh, bar_mm=40.0, filled=4.0)
    bag = build_bag(plan, sectors=sectors)
    free = problem_of(bag, plan, plan.cases()[0])
    touching = replace(free, surface=Surface.of(bag.net, ContactLaw(1e-5, 1.0)))
    start = interior_point.solve(free, 1e-9)
    without, beside = (newton.solve(p, 1e-12, start, newton.DIRECT) for p in (free, touching))
    assert without.report.outcome.converged
    assert beside.report.outcome.converged
    assert np.abs(without.positions - beside.positions).max() <= 1e-12
    assert np.abs(without.bar_tension - beside.bar_tension).max() <= 1e-12 * without.bar_tension.max()


def test_methods_that_know_no_contact_say_so():
    problem = chain_on_a_floor(10, 1.0, 1e-3)
    with pytest.raises(ValueError, match="knows no contact"):
        rigid_bars.solve(problem, 1e-6)
