"""Rigid bars in time: pendulums and chains in closed form, drift, falling bars, and equilibria of other methods."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipk, jn_zeros

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import measure_all
from codend.errors import InputError
from codend.mechanics import drag
from codend.mechanics.water import uniform_flow
from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import rotate
from codend.solvers import dynamic_relaxation, linear_systems, rigid_bars
from codend.solvers.linear_systems import BandedSystem
from codend.solvers.outcome import Outcome
from codend.solvers.rigid_bars import RigidBarsSettings
from codend.solvers.rigid_motion import RigidMotion, simulate
from codend.studies import study
from tests.chains import hanging, pendulum, small_swings
from tests.plans import make_plan, uniform_plan
from validation.chains import DENSITY_KG_M3, DIAMETER_M, MASS_PER_METRE, chain
from validation.reference import residual

LARGE = 2.0


def motion(problem, dt, seconds, velocities=None, **options):
    start = problem.net.positions
    still = np.zeros_like(start)
    return simulate(problem, start, still if velocities is None else velocities, dt, round(seconds / dt), **options)


def slope(sizes, errors):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


def swing_period(history):
    """Mean time between every second passage of the lowest point, interpolated."""
    x, t = history.positions[:, -1, 0], history.time_s
    down = np.flatnonzero((x[:-1] > 0) & (x[1:] <= 0))
    passed = t[down] + (t[down + 1] - t[down]) * x[down] / (x[down] - x[down + 1])
    return np.diff(passed).mean()


def energy(history):
    """Energy of a pendulum over that of its height, both for the half of the bar's mass at its free end."""
    speed = np.sum(history.velocities[:, -1] ** 2, axis=1)
    return 0.5 * speed + GRAVITY_M_S2 * history.positions[:, -1, 2]


def test_a_large_swing_takes_the_time_of_the_elliptic_integral():
    period = 4 * np.sqrt(1 / GRAVITY_M_S2) * ellipk(np.sin(LARGE / 2) ** 2)
    found = swing_period(motion(pendulum(LARGE), 1e-3, 6.0))
    assert found == pytest.approx(period, rel=2e-5)
    projected = swing_period(motion(pendulum(LARGE), 2e-3, 8.5, project=True))
    assert projected == pytest.approx(period, rel=2e-5)


def test_positions_converge_with_the_first_order_of_the_time_step():
    steps = np.array([4e-3, 2e-3, 1e-3, 5e-4])
    from scipy.integrate import solve_ivp

    exact = solve_ivp(
        lambda _, y: [y[1], -GRAVITY_M_S2 * np.sin(y[0])], (0, 1.2), [LARGE, 0.0], rtol=1e-11, atol=1e-12
    ).y[0, -1]
    errors = []
    for dt in steps:
        end = motion(pendulum(LARGE), dt, 1.2).positions[-1, -1]
        errors.append(np.hypot(end[0] - np.sin(exact), end[2] + np.cos(exact)))
    assert slope(steps, errors) == pytest.approx(1.0, abs=0.1)


def test_the_energy_error_is_of_first_order_in_the_time_step_and_does_not_pile_up_under_projection():
    steps = np.array([4e-3, 2e-3, 1e-3])
    error = [np.ptp(energy(motion(pendulum(LARGE), dt, 3.0))) for dt in steps]
    assert slope(steps, error) == pytest.approx(1.0, abs=0.15)
    history = motion(pendulum(LARGE), 2e-3, 12.0, project=True)
    error = np.abs(energy(history) - energy(history)[0])
    assert error[-1500:].max() < 1.02 * error[:1500].max()


def test_drift_falls_with_the_square_of_the_time_step_and_projection_removes_it():
    """The dropped term is dt^2 V^2: what a step adds to the lengths, the next one takes back."""
    steps = np.array([8e-3, 4e-3, 2e-3, 1e-3])
    drift = [motion(pendulum(LARGE), dt, 1.5).drift.max() for dt in steps]
    assert slope(steps, drift) == pytest.approx(2.0, abs=0.05)
    fastest = 2 * GRAVITY_M_S2 * (1 - np.cos(LARGE))
    assert drift[-1] == pytest.approx(steps[-1] ** 2 * fastest / 2, rel=0.05)
    assert motion(pendulum(LARGE), 8e-3, 1.5, project=True).drift.max() < 1e-12


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_a_hanging_chain_swings_with_the_frequencies_of_its_masses(mode):
    frequencies, shapes = small_swings(8)
    problem = chain(hanging(8, displacement=1e-4 * shapes[:, mode]))
    period = 2 * np.pi / frequencies[mode]
    history = motion(problem, period / 400, 6 * period)
    assert swing_period(history) == pytest.approx(period, rel=1e-4)
    # the other modes stay asleep
    end = history.positions[-1, :, 0] / history.positions[-1, -1, 0]
    assert end == pytest.approx(shapes[:, mode], abs=0.02)


def test_a_chain_of_many_bars_swings_as_a_heavy_rope():
    rope = 0.5 * jn_zeros(0, 1)[0] * np.sqrt(GRAVITY_M_S2)
    bars = np.array([8, 16, 32])
    gaps = [abs(small_swings(n)[0][0] / rope - 1) for n in bars]
    assert slope(1 / bars, gaps) == pytest.approx(2.0, abs=0.1)
    shape = small_swings(32)[1][:, 0]
    history = motion(chain(hanging(32, displacement=1e-4 * shape)), 2 * np.pi / rope / 200, 3 * 2 * np.pi / rope)
    assert swing_period(history) == pytest.approx(2 * np.pi / rope, rel=1e-3)


def test_tension_at_the_lowest_point_is_weight_and_centripetal_force():
    history = motion(pendulum(1.0), 5e-4, 1.0, project=True)
    lowest = np.argmin(history.positions[:, -1, 2])
    expected = 0.5 * MASS_PER_METRE * GRAVITY_M_S2 * (3 - 2 * np.cos(1.0))
    assert history.bar_tension[lowest, 0] == pytest.approx(expected, rel=1e-3)


def test_a_bar_let_go_in_water_starts_with_its_added_mass_across_and_without_it_along():
    water = 1000.0
    weight = (1 - water / DENSITY_KG_M3) * GRAVITY_M_S2
    for axis, expected in ((0, weight / (1 + water / DENSITY_KG_M3)), (2, weight)):
        positions = np.zeros((2, 3))
        positions[1, axis] = -1.0
        history = simulate(chain(positions, held=(), water=water), positions, np.zeros((2, 3)), 1e-4, 1)
        assert history.velocities[1, :, 2] == pytest.approx(-1e-4 * expected, rel=1e-12)


def test_a_level_bar_sinks_at_the_speed_at_which_drag_is_its_weight():
    problem = chain(np.array([[0.0, 0, 0], [1.0, 0, 0]]), held=(), water=1000.0, normal=1.36)
    weight = MASS_PER_METRE * (1 - 1000.0 / DENSITY_KG_M3) * GRAVITY_M_S2
    history = motion(problem, 1e-3, 2.0)
    assert history.velocities[-1, :, 2] == pytest.approx(-np.sqrt(weight / (500.0 * DIAMETER_M * 1.36)), rel=1e-6)


@pytest.mark.parametrize("law", ["le-bris-1999", "bessonneau-1997"])
def test_drag_knows_only_the_velocity_relative_to_the_water(law):
    plan = make_plan(6, 4, filled=1.0, drag={"law": law}, speed=1.5)
    problem = problem_of(build_bag(plan), plan, plan.cases()[0])
    net, structure, loading = problem.net, problem.structure, problem.loading
    dry = np.zeros(problem.bands)

    def moving(velocity, speed, share=dry):
        force = np.zeros_like(net.positions)
        wind = np.broadcast_to(np.asarray(velocity, dtype=float), force.shape).copy()
        water = uniform_flow(loading.water.density, np.array([speed, 0.0, 0.0]))
        drag.add_force(net.positions, wind, structure, water, loading.catch, share, force)
        return force

    resting = np.zeros_like(net.positions)
    drag.add_force(net.positions, np.zeros((0, 3)), structure, loading.water, loading.catch, dry, resting)
    assert moving([0, 0, 0], 1.5) == pytest.approx(resting, rel=1e-12, abs=1e-15)
    assert moving([1.5, 0, 0], 1.5) == pytest.approx(np.zeros_like(resting), abs=1e-15)
    assert moving([-1.5, 0, 0], 0.0) == pytest.approx(resting, rel=1e-12, abs=1e-15)
    # within the catch the water stands still with the net, and only the bars' own motion is resisted
    assert moving([-1.5, 0, 0], 3.0, np.ones(problem.bands)) == pytest.approx(resting, rel=1e-12, abs=1e-15)
    power = np.sum(moving([0.3, 0.2, -0.4], 0.0) * [0.3, 0.2, -0.4])
    assert power < 0.0


def test_a_string_goes_slack_where_a_rigid_bar_pushes_and_its_weight_flies():
    """From just off the top: the weight falls freely until it is a length away from the pivot again."""
    speed, dt = 1.0, 1e-4
    problem = pendulum(np.pi)
    velocities = np.array([[0.0, 0, 0], [speed, 0, 0]])
    pushed = motion(problem, dt, 0.3, velocities)
    assert pushed.bar_tension.min() < 0.0
    flown = motion(problem, dt, 0.5, velocities, slack=True)
    assert flown.bar_tension.min() == 0.0
    t = flown.time_s
    height = 1.0 - GRAVITY_M_S2 * t**2 / 2
    free = np.hypot(speed * t, height) < 0.999
    free[0] = True
    upto = np.argmin(free[1:])
    assert flown.positions[:upto, -1, 0] == pytest.approx(speed * t[:upto], abs=2e-3)
    assert flown.positions[:upto, -1, 2] == pytest.approx(height[:upto], abs=2e-3)
    distance = np.linalg.norm(flown.positions[:, -1], axis=1)
    assert distance.max() < 1.0 + 1e-5


def test_a_sector_moves_as_the_full_net_does():
    plan = make_plan(8, 6, filled=3.0)
    whole, part = (problem_of(bag, plan, plan.cases()[0]) for bag in (build_bag(plan), build_bag(plan, sectors=1)))
    full, sector = (motion(problem, 5e-4, 0.05) for problem in (whole, part))
    turned = rotate(sector.positions[-1, :-1, None], np.arange(8)[None], 8).reshape(-1, 3)
    assert full.positions[-1, :-1] == pytest.approx(turned, abs=1e-9)
    assert full.positions[-1, -1] == pytest.approx(sector.positions[-1, -1], abs=1e-9)
    assert np.abs(full.positions[-1] - full.positions[0]).max() > 0.01


def test_band_and_sparse_factors_give_the_same_tensions(monkeypatch):
    plan = make_plan(8, 6)
    problem = problem_of(build_bag(plan), plan, plan.cases()[0])
    start, still = problem.net.positions, np.zeros_like(problem.net.positions)
    banded = RigidMotion(problem, start, still)
    monkeypatch.setattr(linear_systems, "WIDEST_SYMMETRIC_BAND", 0)
    sparse = RigidMotion(problem, start, still)
    assert isinstance(banded.system, BandedSystem)
    assert not isinstance(sparse.system, BandedSystem)
    pattern = banded.pattern
    rng = np.random.default_rng(1)
    entries = rng.uniform(-1.0, 0.0, len(pattern.row))
    turned_over = np.lexsort((pattern.row, pattern.column))
    entries = 0.5 * (entries + entries[turned_over])
    entries[pattern.diagonal] = 40.0
    right = rng.normal(size=(1, len(pattern.diagonal), 1))
    for factor in (1.0, 2.0):
        assert banded.system.factorise(factor * entries) == 0
        assert sparse.system.factorise(factor * entries) == 0
        tensions = banded.system.solve(right)
        assert sparse.system.solve(right) == pytest.approx(tensions, rel=1e-10, abs=1e-14)
        dense = np.zeros((right.size, right.size))
        dense[pattern.row, pattern.column] = factor * entries
        assert dense @ tensions[0, :, 0] == pytest.approx(right[0, :, 0], abs=1e-12)


def case_of(plan, **options):
    return problem_of(build_bag(plan, **options), plan, plan.cases()[0])


@pytest.mark.parametrize(
    ("plan", "options", "slack"),
    [
        (make_plan(24, 20), {"globalisation": 2}, False),
        (make_plan(24, 20, catch={"volume_m3": 0.02}), {"sectors": 1}, False),
        (make_plan(24, 20, mesh="t90", netting={"knot_mm": 12.0}), {"sectors": 1}, True),
        (make_plan(24, 20, mesh="square", entry=0.8), {"sectors": 1}, True),
        (make_plan(12, 10, filled=4.0, netting={"twine_density_kg_m3": 1400.0}), {}, False),
    ],
    ids=["globalised", "volume", "t90 with slack knots", "square with slack rings", "heavy"],
)
def test_the_motion_ends_at_the_equilibrium_of_dynamic_relaxation(plan, options, slack):
    bag = build_bag(plan, **options)
    problem = problem_of(bag, plan, plan.cases()[0])
    found = rigid_bars.solve(problem, 1e-5, settings=RigidBarsSettings(slack=slack))
    expected = dynamic_relaxation.solve(problem, 1e-5)
    report = found.report
    assert report.outcome is Outcome.CONVERGED
    assert residual(problem, found.positions, found.bar_tension, found.share) <= 1e-5
    assert report.length_error < 1e-9
    assert found.bar_tension.min() >= 0.0
    drags = [measure_all(bag, problem, solution)[2].drag_n for solution in (found, expected)]
    assert drags[0] == pytest.approx(drags[1], rel=1e-4)
    assert found.positions == pytest.approx(expected.positions, abs=2e-4)
    assert 0.0 < report.largest_drift < 0.01


def test_a_solve_makes_the_steps_it_reports_and_no_others(monkeypatch):
    made = []
    step = RigidMotion.step
    monkeypatch.setattr(RigidMotion, "step", lambda *arguments: made.append(1) or step(*arguments))
    report = rigid_bars.solve(case_of(make_plan(8, 6, filled=3.0), sectors=1), 1e-5).report
    assert len(made) == report.iterations


def test_an_equilibrium_with_bars_in_compression_is_refused():
    problem = case_of(make_plan(24, 20, mesh="t90", netting={"knot_mm": 12.0}), sectors=1)
    found = rigid_bars.solve(problem, 1e-5)
    assert found.report.outcome is Outcome.COMPRESSED
    assert np.isnan(found.positions).all()
    assert np.isnan(found.bar_tension).all()


def test_too_long_a_time_step_is_reported_and_gives_no_numbers():
    found = rigid_bars.solve(case_of(make_plan(24, 20), sectors=1), 1e-5, settings=RigidBarsSettings(time_step_s=0.05))
    assert found.report.outcome is Outcome.NOT_FINITE
    assert np.isnan(found.positions).all()
    with pytest.raises(ArithmeticError, match="smaller dt"):
        motion(case_of(make_plan(24, 20), sectors=1), 0.5, 50.0)


def test_lengths_that_rigid_bars_cannot_have_are_refused():
    """Rings of square mesh fix the radius of a rigid bag, which cannot then narrow to the codline."""
    found = rigid_bars.solve(case_of(make_plan(24, 20, mesh="square", entry=0.8), sectors=1), 1e-5)
    assert found.report.outcome is Outcome.NOT_FINITE
    assert found.report.iterations == 0
    assert found.report.largest_drift > 1e-3


def test_without_drag_nothing_comes_to_rest_unless_it_is_stopped():
    problem = case_of(uniform_plan(24, 20, 6.0), sectors=1)
    left_alone = RigidBarsSettings(stop_at_peaks=False, steps_allowed=2000)
    found = rigid_bars.solve(problem, 1e-5, settings=left_alone).report
    assert found.outcome is Outcome.STEPS_SPENT
    assert found.rms_speed_m_s > 1e-3
    assert found.residual > 1e-5
    assert rigid_bars.solve(problem, 1e-5).report.outcome is Outcome.CONVERGED


def test_what_rigid_bars_cannot_model_is_an_error():
    stretching = case_of(make_plan(8, 6, filled=3.0, netting={"axial_stiffness_n": 1e3}), sectors=1)
    with pytest.raises(ValueError, match="inextensible"):
        rigid_bars.solve(stretching, 1e-5)
    problem = pendulum(1.0)
    massless = replace(problem, net=replace(problem.net, bar_density=np.array([np.nan])))
    with pytest.raises(ValueError, match="mass"):
        motion(massless, 1e-3, 0.1)


def test_a_plan_may_ask_for_rigid_bars_and_is_told_what_was_tried():
    model = {"fidelity": "sector", "method": "rigid-bars", "tolerance": 1e-4}
    plain = study.solve(make_plan(24, 20, model=model)).cases[0].report
    assert plain.method == "rigid-bars"
    assert len(plain.attempts) == 1
    rings = study.solve(make_plan(24, 20, mesh="square", entry=0.8, model=model)).cases[0].report
    assert rings.outcome is Outcome.CONVERGED
    assert "going slack" in rings.attempts[1]
    with pytest.raises(InputError, match="axial_stiffness_n"):
        study.solve(make_plan(24, 20, netting={"axial_stiffness_n": 1e3}, model=model))
