"""One half of a mirrored net: what it carries, and that its equilibrium is one of the whole."""

import numpy as np
import pytest

from codend.mechanics.newton_state import empty_state, measure
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.scenes.build import build
from codend.scenes.measures import solve_scene
from codend.scenes.scene import scene_from_dict
from codend.solvers.half import half_of
from codend.solvers.outcome import START, Solution
from validation.cage.gear import box, cylinder


def problem_of(data) -> Problem:
    return build(scene_from_dict(data)).problem


def loads_in(problem: Problem, positions: Floats, density: Floats) -> tuple[Floats, Floats]:
    """Loads on the nodes, and what is out of balance at the free ones, with these force densities, (n, 3) each."""
    state = empty_state(problem.structure, problem.bands)
    state.position[:], state.density[:] = positions, density
    measure(problem.structure, problem.loading, 1.0, 1.0, 0.0, state)
    return state.load.copy(), state.force * problem.structure.free


@pytest.mark.parametrize("data", [box(0.4, merged=10), box(0.4, merged=10, seam_ropes=True), cylinder(0.4, sides=12)])
def test_the_forces_on_a_half_are_those_on_the_whole(data):
    whole = problem_of(data)
    half = half_of(whole)
    assert half is not None
    net = half.problem.net
    rng = np.random.default_rng(1)
    own = net.positions + 0.2 * net.bar_length.min() * rng.standard_normal(net.positions.shape) * ~net.fixed
    tension = rng.uniform(0.1, 1.0, len(net.bars))
    both = half.whole(Solution(own, tension, np.ones(1), START))
    assert half.unlike_m(both.positions) < 1e-15

    length = np.linalg.norm(np.diff(own[net.bars], axis=1)[:, 0], axis=1)
    length_of_whole = np.linalg.norm(np.diff(both.positions[whole.net.bars], axis=1)[:, 0], axis=1)
    load, force = loads_in(half.problem, own, tension / length)
    of_whole, force_of_whole = loads_in(whole, both.positions, both.bar_tension / length_of_whole)
    # the plane holds its nodes across, and each half has a half of what pulls at them along
    first = np.array([np.flatnonzero((half.place == node) & ~half.is_image)[0] for node in range(len(own))])
    share = np.where(np.isin(np.arange(len(own)), half.place[half.is_image]), 1.0, 0.5)[:, None]
    assert share.min() == 0.5
    largest = np.abs(force_of_whole).max()
    assert force == pytest.approx(force_of_whole[first] * share * half.problem.structure.free, abs=1e-13 * largest)
    along = [0, 2]
    assert 2.0 * load.sum(axis=0)[along] == pytest.approx(of_whole.sum(axis=0)[along], rel=1e-12)
    assert of_whole.sum(axis=0)[1] == pytest.approx(0.0, abs=1e-12 * np.abs(of_whole).sum())


def on_one_side(data):
    data["ballast"] = {**data["ballast"], "points": data["ballast"]["points"][:1]}
    return data


def across(data):
    data["water"]["flow_m_s"] = [0.3, 0.1, 0.0]
    return data


@pytest.mark.parametrize("change", [on_one_side, across])
def test_a_net_that_is_not_its_own_mirror_image_has_no_half(change):
    assert half_of(problem_of(box(0.3, merged=10))) is not None
    assert half_of(problem_of(change(box(0.3, merged=10)))) is None


def test_a_half_has_no_half():
    half = half_of(problem_of(box(0.3, merged=10)))
    assert half is not None
    assert half_of(half.problem) is None


def test_how_unlike_two_sides_are_is_by_how_much_a_node_is_moved():
    problem = problem_of(box(0.3, merged=10))
    half = half_of(problem)
    assert half is not None
    moved = problem.net.positions.copy()
    node = int(np.flatnonzero(half.is_image)[-1])
    moved[node] += [0.0, 0.003, 0.004]
    assert half.unlike_m(moved) == pytest.approx(0.005, rel=1e-12)


def test_a_cage_is_found_mirrored_and_the_whole_is_in_balance_there():
    result = solve_scene(build(scene_from_dict(box(0.3, merged=10))))
    assert result.converged
    assert result.solution.report.attempts[0].startswith("one half of the net")
    half = half_of(result.built.problem)
    assert half is not None
    assert half.unlike_m(result.solution.positions) < 1e-9
    free = ~result.built.problem.net.fixed
    assert np.abs(result.support[free]).max() < 1e-8 * np.abs(result.load).max()
