"""Steps through the interior: mended by the factors they were made with, and taken up midway by the next catch."""

from dataclasses import replace

import numpy as np
import pytest

from codend.equilibrium import situation
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import BagModel, model_of
from codend.mechanics.newton_state import empty_state, measure
from codend.net.net import Floats
from codend.plan.plan import plan_from_dict
from codend.solvers import barrier, interior_point
from codend.solvers.barrier import KEPT_TAUT
from codend.solvers.interior_point import InteriorPointSettings
from codend.solvers.outcome import Midway, Solution

WINDOW = {
    "mesh": "square", "meshes_round": 8, "meshes_long": 16, "bar_mm": 50.0, "twine_mm": 4.0, "axial_stiffness_n": 1e3,
    "netting": "1", "panel": "upper", "meshes_from_codline": [8, 16], "meshes_across": 8,
}  # fmt: skip


def windowed(speeds: list[float], catches: list[float], netting: dict, **tables: object) -> BagModel:
    """A full net of 40 x 24 meshes with a window of square mesh on top."""
    section = {"mesh": "diamond", "meshes_round": 40, "meshes_long": 24, "bar_mm": 50.0, "twine_mm": 4.0, "panels": 2}
    plan = {
        "title": "window",
        "tow": {"speed_m_s": speeds},
        "entry": {"radius_m": 0.3},
        "netting": [section | netting],
        "window": [WINDOW],
        "catch": {"filled_meshes": catches, "pressure": "uniform", "coefficient": 1.4},
    }
    return model_of(plan_from_dict(plan | tables), 1, None)


def stretching(catches: list[float]) -> BagModel:
    """One of twine that stretches."""
    return windowed([1.0], catches, {"axial_stiffness_n": 1e3})


def steps_of(solution: Solution) -> int:
    """Steps through the interior, of the way that led there."""
    assert solution.report.outcome.converged
    through = [line for line in solution.report.attempts if ": interior point with" in line]
    return int(through[-1].split(" steps")[0].split()[-1])


def left_by_the_step(led: interior_point._Led, pressed: float, loosening: Floats) -> Floats:
    """What a whole step leaves: of forces, of s q = b, and of a bar's length, each the root of its mean square."""
    structure, state, step = led.watched.problem.structure, led.state, led.watched.prepared.step
    there = empty_state(structure, led.watched.problem.bands)
    there.position[:] = state.position + step.move
    there.density[:] = state.density + step.change
    measure(structure, led.watched.loading, led.tension, 1.0, KEPT_TAUT, there)
    slack = state.slack + loosening
    products = slack * there.density - pressed * structure.length
    own = structure.length / (1.0 - structure.flexibility * structure.length * there.density)
    lengths = slack - 0.5 * (own**2 - there.length**2)
    return np.array([np.sqrt(np.mean(left**2)) for left in (there.force * structure.free, products, lengths)])


def test_mended_steps_leave_less_of_every_equation(monkeypatch):
    model, mended = stretching([8.0]), []
    once = interior_point._Led.correct

    def correct(self: interior_point._Led, pressed: float, loosening: Floats, way: float) -> float:
        before, move = left_by_the_step(self, pressed, loosening), self.watched.prepared.step.move.copy()
        of_way = once(self, pressed, loosening, way)
        if not np.array_equal(move, self.watched.prepared.step.move):
            mended.append(left_by_the_step(self, pressed, loosening) / before)
        return of_way

    monkeypatch.setattr(interior_point._Led, "correct", correct)
    _, solution = equilibrium.solve(model, model.plan.cases()[0], (), None)
    assert solution.report.outcome.converged
    assert len(mended) > 5
    assert np.median(mended, axis=0).max() < 0.4
    assert np.max(mended[-5:]) < 1.0


def test_a_net_with_a_window_takes_fewer_steps_when_they_are_mended(monkeypatch):
    model = stretching([8.0])
    case = model.plan.cases()[0]
    _, with_three = equilibrium.solve(model, case, (), None)
    monkeypatch.setattr(situation, "AT_GEAR", InteriorPointSettings())
    _, without = equilibrium.solve(model, case, (), None)
    assert steps_of(with_three) <= 0.75 * steps_of(without)
    np.testing.assert_allclose(with_three.positions, without.positions, atol=1e-8)


def test_the_next_catch_is_led_from_midway_in_fewer_steps_to_the_same_equilibrium():
    model = stretching([8.0, 8.5])
    first, second = model.plan.cases()
    _, known = equilibrium.solve(model, first, (), None)
    assert known.midway.barrier >= barrier.MIDWAY
    _, led = equilibrium.solve(model, second, [(first, known)], None)
    _, from_the_end = equilibrium.solve(model, second, [(first, replace(known, midway=None))], None)
    _, alone = equilibrium.solve(model, second, (), None)
    assert led.report.attempts[0].startswith("from where the last equilibria lead: interior point")
    assert steps_of(led) < min(steps_of(from_the_end), steps_of(alone))
    np.testing.assert_allclose(led.positions, alone.positions, atol=1e-8)
    np.testing.assert_allclose(led.bar_tension, alone.bar_tension, atol=1e-6 * alone.mean_tension)


@pytest.mark.parametrize("netting", [{}, {"axial_stiffness_n": 1e3}])
def test_at_another_speed_it_is_led_from_midway_too(netting):
    """Without weight and stretch all forces grow with the square of the speed, and so does what is midway."""
    model = windowed([1.0, 2.0], [8.0], netting)
    slow, fast = model.plan.cases()
    _, known = equilibrium.solve(model, slow, (), None)
    _, alone = equilibrium.solve(model, fast, (), None)
    faster = known.midway.at_speed(2.0)
    forces = []
    for case, midway in ((slow, known.midway), (fast, faster)):
        problem = model.problem(case)
        state = empty_state(problem.structure, problem.bands)
        state.position[:], state.density[:] = midway.positions, midway.density
        measure(problem.structure, problem.loading, 1.0, 1.0, KEPT_TAUT, state)
        forces.append(state.force * problem.structure.free)
    np.testing.assert_allclose(forces[1], 4.0 * forces[0], atol=1e-9 * np.abs(alone.bar_tension).max())
    assert faster.barrier == 4.0 * known.midway.barrier
    _, led = equilibrium.solve(model, fast, [(slow, known)], None)
    assert led.report.outcome.converged
    np.testing.assert_allclose(led.positions, alone.positions, atol=1e-7)


def test_an_equilibrium_of_the_case_itself_is_not_taken_back_to_midway():
    model = stretching([8.0])
    case = model.plan.cases()[0]
    _, known = equilibrium.solve(model, case, (), None)
    astray = replace(known, midway=Midway(*(np.full_like(known.bar_tension, np.nan),) * 3, np.nan))
    _, again = equilibrium.solve(model, case, [(case, astray)], None)
    assert again.report.outcome.converged
    assert len(again.report.attempts) == 2
    np.testing.assert_allclose(again.positions, known.positions, atol=1e-8)


def test_what_is_midway_of_a_mirrored_net_is_mirrored():
    model = stretching([8.0])
    mirror, _ = model.half
    _, known = equilibrium.solve(model, model.plan.cases()[0], (), None)
    made = mirror.made_mirrored(known).midway
    assert mirror.off(made.positions) == 0.0
    for before, after in ((known.midway.density, made.density), (known.midway.slackness, made.slackness)):
        np.testing.assert_array_equal(after, after[mirror.bar])
        np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-12)
