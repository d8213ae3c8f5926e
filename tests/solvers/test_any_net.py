"""Nets that are no codend: tight without loads, under loads that cancel, and found by every solver alike."""

import numpy as np
import pytest

from codend.mechanics.problem import Problem
from codend.net.net import Net
from codend.solvers import dynamic_relaxation, interior_point, newton, rigid_bars
from codend.solvers.outcome import Outcome
from codend.solvers.solve import find_equilibrium

TOLERANCE = 1e-9
SOLVERS = {
    "newton": newton.solve,
    "interior point": interior_point.solve,
    "dynamic relaxation": dynamic_relaxation.solve,
    "any": find_equilibrium,
}
STIFFNESS_N, STRAIN = 2e4, 5e-3


def tight_cross(pull_n: float = 0.0) -> Problem:
    """Four bars from held corners to a knot that starts off its place, tight by 100 N, and pulled up or not."""
    nodes = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0.1, -0.05, 0.2]])
    bars = [[0, 4], [1, 4], [2, 4], [3, 4]]
    held = [True, True, True, True, False]
    net = Net.from_bars(nodes, bars, held, length_m=1.0 / (1.0 + STRAIN), stiffness_n=STIFFNESS_N)
    force = np.zeros((5, 3))
    force[4, 2] = pull_n
    return Problem.of(net, nodal_force_n=force)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_net_that_is_tight_without_loads_keeps_its_tension(name):
    found = SOLVERS[name](tight_cross(), TOLERANCE)
    assert found.report.outcome is Outcome.CONVERGED, found.report.attempts
    assert found.positions[4] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert found.bar_tension == pytest.approx(STIFFNESS_N * STRAIN, rel=1e-3)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("pull_n", [1e-3, 40.0])
def test_a_tight_net_gives_way_by_its_tension_and_stretch(name, pull_n):
    found = SOLVERS[name](tight_cross(pull_n), TOLERANCE)
    assert found.report.outcome is Outcome.CONVERGED, found.report.attempts
    up = found.positions[4, 2]
    length = np.hypot(1.0, up)
    tension = STIFFNESS_N * (length * (1.0 + STRAIN) - 1.0)
    assert found.bar_tension == pytest.approx(tension, rel=1e-3)
    assert 4.0 * tension * up / length == pytest.approx(pull_n, rel=1e-3)


def pulled_apart(stiffness_n: float = np.inf) -> Problem:
    """A chain of three bars hung from a held node, its other nodes pulled by loads whose sum is nothing."""
    nodes = np.array([[0.0, 0, 0], [0.9, 0.3, 0], [1.7, -0.1, 0.2], [2.5, 0.2, 0.1]])
    net = Net.from_bars(
        nodes, [[0, 1], [1, 2], [2, 3]], [True, False, False, False], length_m=1.0, stiffness_n=stiffness_n,
        diameter_m=0.01,
    )  # fmt: skip
    return Problem.of(net, nodal_force_n=np.array([[-30.0, 0, 0], [10, 0, 0], [0, 0, 0], [20, 0, 0]]))


@pytest.mark.parametrize("stiffness_n", [np.inf, 1e4])
@pytest.mark.parametrize("name", [*SOLVERS, "rigid bars"])
def test_loads_that_cancel_are_carried_from_bar_to_bar(name, stiffness_n):
    if name == "rigid bars" and np.isfinite(stiffness_n):
        pytest.skip("rigid bars do not stretch")
    solver = {**SOLVERS, "rigid bars": rigid_bars.solve}[name]
    found = solver(pulled_apart(stiffness_n), 1e-6 if name == "rigid bars" else TOLERANCE)
    assert found.report.outcome is Outcome.CONVERGED, found.report.attempts
    assert found.bar_tension == pytest.approx([30.0, 20.0, 20.0], rel=1e-5)
    assert np.abs(found.positions[:, 1:]).max() < 1e-3


@pytest.mark.parametrize("name", SOLVERS)
def test_a_net_that_nothing_pulls_at_is_slack_and_says_so(name):
    nodes = np.array([[0.0, 0, 0], [0.4, 0.0, 0.1], [1.0, 0, 0]])
    net = Net.from_bars(nodes, [[0, 1], [1, 2]], [True, False, True], length_m=0.8)
    found = SOLVERS[name](Problem.of(net), TOLERANCE)
    if found.report.outcome.converged:
        assert np.all(found.bar_tension == 0.0)
        assert np.linalg.norm(np.diff(found.positions, axis=0), axis=1) == pytest.approx([0.8, 0.8], abs=0.8)
    else:
        assert np.isnan(found.bar_tension).all()


SPREAD, PULL_N = 0.8, 50.0


def spread_by_a_strut(*, is_strut: bool, stiffness_n: float = np.inf) -> Problem:
    """Two strings of two bars of 1 m from a held node to one that is pulled, kept apart in a plane by a bar between."""
    nodes = np.array([[0.0, 0, 0], [0.8, 0.5, 0], [1.0, -0.3, 0], [1.7, 0.2, 0]])
    held = np.zeros((4, 3), dtype=bool)
    held[0], held[:, 2] = True, True
    net = Net.from_bars(
        nodes,
        [[0, 1], [0, 2], [1, 3], [2, 3], [1, 2]],
        held,
        length_m=[1.0, 1.0, 1.0, 1.0, SPREAD],
        stiffness_n=[np.inf, np.inf, np.inf, np.inf, stiffness_n],
        diameter_m=0.01,
        is_strut=[False, False, False, False, is_strut],
    )
    force = np.zeros((4, 3))
    force[3, 0] = PULL_N
    return Problem.of(net, nodal_force_n=force)


@pytest.mark.parametrize("stiffness_n", [np.inf, 400.0])
@pytest.mark.parametrize("name", [*SOLVERS, "rigid bars"])
def test_a_strut_keeps_two_strings_apart(name, stiffness_n):
    """Its push is P tan(phi), its length 2 sin(phi) = s (1 - push / EA)."""
    if name == "rigid bars" and np.isfinite(stiffness_n):
        pytest.skip("rigid bars do not stretch")
    problem = spread_by_a_strut(is_strut=True, stiffness_n=stiffness_n)
    found = {**SOLVERS, "rigid bars": rigid_bars.solve}[name](problem, 1e-6 if name == "rigid bars" else TOLERANCE)
    assert found.report.outcome is Outcome.CONVERGED, found.report.attempts
    apart = float(np.linalg.norm(found.positions[1] - found.positions[2]))
    push = PULL_N * np.tan(np.arcsin(0.5 * apart))
    assert apart == pytest.approx(SPREAD * (1.0 - push / stiffness_n), rel=2e-6)
    assert found.bar_tension[:4] == pytest.approx(PULL_N / 2.0 / np.cos(np.arcsin(0.5 * apart)), rel=1e-4)
    assert found.bar_tension[4] == pytest.approx(-push, rel=1e-4)


@pytest.mark.parametrize("name", [*SOLVERS, "rigid bars"])
def test_twine_never_keeps_strings_apart(name):
    found = {**SOLVERS, "rigid bars": rigid_bars.solve}[name](spread_by_a_strut(is_strut=False), 1e-6)
    if found.report.outcome.converged:
        assert found.bar_tension[4] == 0.0
        assert np.linalg.norm(found.positions[1] - found.positions[2]) < 0.1 * SPREAD
    else:
        assert np.isnan(found.bar_tension).all()


def test_a_bar_to_a_node_that_is_none_is_refused():
    with pytest.raises(ValueError, match="nodes 0 to 1, not 0 to 2"):
        Net.from_bars([[0, 0, 0], [1, 0, 0]], [[0, 2]], [True, False])
