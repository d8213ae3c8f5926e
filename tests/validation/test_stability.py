"""Stability maps: what counts as right, stable steps by theory, and the borders at which methods fail and say so."""

from dataclasses import replace

import numpy as np
import pytest

from codend.solvers import dynamic_relaxation, newton, rigid_bars
from codend.solvers.dynamic_relaxation import RelaxationSettings
from codend.solvers.newton import NewtonSettings
from codend.solvers.outcome import Outcome
from codend.solvers.refusal import passage
from codend.solvers.rigid_bars import RigidBarsSettings
from codend.solvers.rigid_motion import simulate
from validation.reference import departure, facing_rings
from validation.stability.automatic_maps import checked
from validation.stability.judge import Finding, confirmed_reference, judge, passes_through
from validation.stability.linear import drag_and_volume, is_stable, worst_responses
from validation.stability.relaxation_map import largest_stable_step
from validation.stability.rigid_bars_map import LinearMotion
from validation.stability.scenes import bag_and_problem, disturbed, plan_of

HONEST = (Finding.RIGHT, Finding.RESCUED, Finding.FAILED)
ANSWERED = (Finding.RIGHT, Finding.RESCUED)


@pytest.fixture(scope="module")
def reference():
    return confirmed_reference(*bag_and_problem(plan_of()))


@pytest.fixture(scope="module")
def crossed():
    """Square netting, its equilibrium, and a start whose aft part lies on the other side of the axis.

    From there hinged bars find an equilibrium, unstable.
    """
    bag, problem = bag_and_problem(plan_of(8.0, 0.5, netting={"mesh": "square"}, normal_drag=0.0))
    answer = newton.solve(problem, 1e-10)
    aft = (bag.node_row >= 6)[:, None]
    return (
        problem,
        answer,
        replace(answer, positions=np.where(aft, answer.positions * [1.0, -1.0, -1.0], answer.positions)),
    )


def finding_of(reference, solution, tolerance):
    judgement = judge(reference, solution, tolerance)
    if judgement.finding is Finding.FAILED:
        assert not solution.report.outcome.converged
        assert np.isnan(solution.positions).all()
        assert np.isnan(solution.bar_tension).all()
    return judgement.finding


def test_a_state_off_by_more_than_its_residual_explains_is_found_out(reference):
    answer, problem = reference.solution, reference.problem
    assert judge(reference, answer, 1e-9).finding is Finding.RIGHT
    moved = replace(answer, positions=answer.positions + 1e-6 * ~problem.net.fixed)
    assert judge(reference, moved, 1e-9).finding is Finding.WRONG
    pushed = replace(answer, bar_tension=-answer.bar_tension)
    assert "compression" in judge(reference, pushed, 1.0).why
    emptied = replace(answer, share=0.5 * answer.share)
    assert "not the catch" in judge(reference, emptied, 1.0).why


def test_the_judge_sees_a_net_that_has_passed_through_itself(crossed):
    bag, _ = bag_and_problem(plan_of(8.0, 0.5, netting={"mesh": "square"}, normal_drag=0.0))
    _, answer, through = crossed
    assert [passes_through(bag, shape) for shape in (answer, through)] == [False, True]


def test_a_full_nets_reference_comes_back_when_shaken():
    bag, problem = bag_and_problem(plan_of(), 4, None)
    assert judge(confirmed_reference(bag, problem), newton.solve(problem, 1e-8), 1e-8).finding in ANSWERED


def test_numbers_that_come_with_a_failure_are_wrong(reference):
    answer = reference.solution
    failed = replace(answer, report=replace(answer.report, outcome=Outcome.STEPS_SPENT))
    assert judge(reference, failed, 1e-9).finding is Finding.WRONG


def test_what_out_of_balance_forces_explain_bounds_what_they_do(reference):
    """A dead load of known size on every node moves drag, volume and shape by less than the bound, if not by much."""
    problem, answer = reference.problem, reference.solution
    by_forces, by_strains = worst_responses(problem, answer)
    size = 1e-6 * drag_and_volume(problem, answer.positions, answer.share)[0]
    free = ~problem.net.fixed
    most = np.zeros(3)
    for seed in range(6):
        push = np.random.default_rng(seed).normal(size=free.shape)
        push *= size / np.linalg.norm(push, axis=1, keepdims=True)
        loaded = replace(problem, loading=problem.loading._replace(dead=push * free))
        moved = newton.solve(loaded, 1e-11, answer)
        was, now = (drag_and_volume(problem, s.positions, s.share) for s in (answer, moved))
        change = [abs(now[0] - was[0]), abs(now[1] - was[1]), np.abs(moved.positions - answer.positions).max()]
        most = np.maximum(most, np.array(change) / (by_forces * size))
    assert np.all(most < 1.0)
    assert np.all(most > 0.01)
    longer = replace(problem, structure=problem.structure._replace(length=problem.structure.length * (1.0 + 1e-6)))
    moved = newton.solve(longer, 1e-11, answer)
    assert np.abs(moved.positions - answer.positions).max() < 1e-6 * by_strains[2]


@pytest.mark.parametrize("penalty", [20.0, 300.0])
@pytest.mark.parametrize("viscous", [False, True])
def test_relaxation_is_right_below_the_stable_step_of_theory_and_fails_honestly_above(reference, penalty, viscous):
    problem = reference.problem
    stable = largest_stable_step(problem, reference.solution, penalty)
    assert stable >= 1.0  # the bound on the rows of the stiffness is one
    for step, expected in ((0.78, ANSWERED), (0.9, HONEST), (1.0, HONEST), (1.12, (Finding.FAILED,))):
        settings = RelaxationSettings(
            viscous=viscous, penalty=penalty, mass_factor=(step * stable) ** -2, restarts=0, steps_allowed=20_000
        )
        solution = dynamic_relaxation.solve(problem, 1e-6, settings=settings)
        assert finding_of(reference, solution, 1e-6) in expected, step


def test_relaxation_beyond_the_stable_step_recovers_by_restarts(reference):
    solution = dynamic_relaxation.solve(reference.problem, 1e-6, settings=RelaxationSettings(mass_factor=0.5))
    assert finding_of(reference, solution, 1e-6) is Finding.RESCUED


@pytest.fixture(scope="module")
def merged():
    return confirmed_reference(*bag_and_problem(plan_of(), 4))


def test_a_disturbed_net_of_rigid_bars_swings_below_the_stable_step_of_theory_and_flies_apart_above(merged):
    problem, answer = merged.problem, merged.solution
    stable = LinearMotion(problem, answer).largest_stable_step()
    start = disturbed(problem, answer.positions, 1e-4, (1,))
    still = np.zeros_like(start)

    def reach(factor):
        history = simulate(problem, start, still, factor * stable, 400)
        return np.abs(history.positions[-50:] - answer.positions).max()

    assert reach(0.95) < 0.01 * problem.net.bar_length[0]
    with pytest.raises(ArithmeticError):
        reach(1.1)


def test_rigid_bars_with_a_fixed_step_are_right_or_fail_honestly_on_both_sides_of_the_border(merged):
    problem, linear = merged.problem, LinearMotion(merged.problem, merged.solution)
    stable, bound = linear.largest_stable_step(), linear.motion.stable_time_step()
    assert bound < stable
    steps = ((0.5 * bound, ANSWERED), (0.4 * stable, HONEST), (0.6 * stable, HONEST), (1.2 * stable, (Finding.FAILED,)))
    for step, expected in steps:
        solution = rigid_bars.solve(problem, 1e-5, settings=RigidBarsSettings(time_step_s=step, steps_allowed=2_000))
        assert finding_of(merged, solution, 1e-5) in expected, step


@pytest.mark.parametrize("settings", [NewtonSettings(rough_starts=()), NewtonSettings()], ids=["alone", "rough starts"])
def test_newton_is_right_from_near_and_right_or_honest_from_afar(reference, settings):
    problem = reference.problem
    for distance in (0.01, 0.1, 0.3, 0.6, 1.0, 3.0):
        for seed in range(3):
            shaken = disturbed(problem, reference.solution.positions, distance, (seed, 7))
            solution = newton.solve(problem, 1e-9, replace(reference.solution, positions=shaken), settings)
            expected = ANSWERED if distance < 0.05 or settings.rough_starts else HONEST
            assert finding_of(reference, solution, 1e-9) in expected, distance


@pytest.mark.parametrize("filled", [0.01, 0.49, 1.0, 20.0])
@pytest.mark.parametrize("entry", [0.01, 0.999])
def test_every_catch_in_every_entry_is_right_or_fails_honestly(filled, entry):
    judgement = checked(plan_of(filled, entry, tolerance=1e-8))[1]
    # all but empty, the tube behind a narrow entry is in balance both closed and blown open by its own drag
    expected = (*HONEST, Finding.ANOTHER) if filled < 0.05 and entry < 0.5 else ANSWERED
    assert judgement.finding in expected, judgement


@pytest.mark.parametrize("stiffness", [3.0, 30.0, 300.0, 3e7])
def test_twine_soft_enough_to_balloon_is_an_honest_failure_and_stiffer_twine_is_right(stiffness):
    solution, judgement = checked(plan_of(12.0, netting={"axial_stiffness_n": stiffness}, tolerance=1e-8))
    assert judgement.finding in (HONEST if stiffness < 100.0 else ANSWERED)
    if stiffness == 3.0:
        assert solution.report.outcome is Outcome.OVERSTRETCHED


@pytest.mark.parametrize("speed", [1e-4, 3.0])
def test_slack_twine_is_solved_at_any_speed(speed):
    t90 = plan_of(1.0, 0.2, speed, netting={"mesh": "t90", "knot_mm": 8.0}, normal_drag=0.0, tolerance=1e-8)
    square = plan_of(1.0, 0.5, speed, netting={"mesh": "square"}, normal_drag=0.0, tolerance=1e-8)
    for plan in (t90, square):
        solution, judgement = checked(plan)
        assert judgement.finding in ANSWERED
        assert np.any(solution.bar_tension == 0.0)


def test_a_net_that_has_passed_through_itself_is_seen_on_sectors_and_full_nets():
    for mesh in ({}, {"mesh": "square"}, {"mesh": "t90", "knot_mm": 8.0}, {"knot_mm": 8.0}):
        for globalisation, sectors in ((1, 1), (2, 2), (4, None)):
            _, problem = bag_and_problem(plan_of(netting=mesh), globalisation, sectors)
            sound = newton.solve(problem, 1e-8).positions
            aft = sound[:, 0] > 0.5 * sound[:, 0].max()
            through = np.where(aft[:, None], sound * [1.0, -1.0, -1.0], sound)
            assert passage(problem, sound) is None
            assert passage(problem, through).outcome is Outcome.PASSED_THROUGH
            if sectors is None:
                assert passage(problem, sound + np.array([0.0, 3.0, 1.0])) is None


def test_relaxation_from_a_crude_bag_does_not_pass_through_itself(crossed):
    """Without a bound on its moves this one did, to less drag."""
    problem, answer, _ = crossed
    found = dynamic_relaxation.solve(problem, 1e-8)
    assert found.report.outcome is Outcome.CONVERGED
    assert len(found.report.attempts) == 1
    assert found.positions == pytest.approx(answer.positions, abs=1e-6)


def test_relaxation_started_beyond_the_axis_says_that_it_has_passed_through_itself(crossed):
    problem, _, start = crossed
    stuck = dynamic_relaxation.solve(problem, 1e-8, start, RelaxationSettings(restarts=0))
    assert stuck.report.outcome is Outcome.PASSED_THROUGH
    assert "of 20 at the axis" in stuck.report.attempts[0]
    assert np.isnan(stuck.positions).all()


def test_what_the_twine_passed_through_is_an_unstable_equilibrium_of_less_drag(crossed, monkeypatch):
    problem, answer, start = crossed
    monkeypatch.setattr(dynamic_relaxation, "refusal", lambda *_: None)
    through = dynamic_relaxation.solve(problem, 1e-8, start)
    states = [departure(problem, s.positions, s.bar_tension, s.share) for s in (answer, through)]
    assert max(state.residual for state in states) < 1e-8
    assert states[1].drag < 0.95 * states[0].drag
    assert is_stable(problem, answer)
    assert not is_stable(problem, through)
    assert facing_rings(problem, answer.positions) > 0.9
    assert facing_rings(problem, through.positions) < 0.0


@pytest.fixture(scope="module")
def narrow():
    """A bag with a narrow entry, and the same with all but its first rows on the other side of the axis."""
    reference = confirmed_reference(*bag_and_problem(plan_of(4.0, 0.05)))
    positions = reference.solution.positions
    aft = (reference.bag.node_row >= 10)[:, None]
    return reference, np.where(aft, positions * [1.0, -1.0, -1.0], positions)


def test_rigid_bars_refuse_a_net_that_has_passed_through_itself(narrow):
    reference, through = narrow
    problem = replace(reference.problem, net=replace(reference.problem.net, positions=through))
    solution = rigid_bars.solve(problem, 1e-5, settings=RigidBarsSettings(ramp_s=0.0))
    assert solution.report.outcome is Outcome.PASSED_THROUGH
    assert finding_of(reference, solution, 1e-5) is Finding.FAILED


def test_newton_refuses_a_net_that_has_passed_through_itself(narrow):
    """Hinged bars are in stable balance on the wrong side of the axis too."""
    reference, through = narrow
    start = replace(reference.solution, positions=through)
    alone = newton.solve(reference.problem, 1e-9, start, NewtonSettings(rough_starts=()))
    assert finding_of(reference, alone, 1e-9) is Finding.FAILED
    assert finding_of(reference, newton.solve(reference.problem, 1e-9, start), 1e-9) is Finding.RESCUED
