"""The meridian method against closed forms, invariants, direct integration and a discrete net written here."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from catch_models.pressure import sphere_law, uniform_law
from codend.bag.meridian import MeridianProblem, MeridianShape, solve, solve_meridian, uniform_pressure_shape
from codend.bag.meridian.collocation import NewtonResult
from codend.bag.meridian.shell import rates
from codend.mechanics.drag_laws import DRAG_LAWS
from codend.solvers.outcome import Outcome
from codend.studies.study import solve as solve_plan
from tests.plans import make_plan

BARE = MeridianProblem(100, 120, 0.03, 0.28, 71.4, 500.0, uniform_law(1.4))
FLUME = MeridianProblem(150, 280, 0.020, 0.30, 200.0, 500.0, sphere_law(), drag_width_m=0.52e-3)
SHORT = MeridianProblem(100, 90, 0.03, 0.35, 52.3, 500.0, sphere_law(), drag_width_m=1.5e-3)
CASES = {
    "diamond": SHORT,
    "no drag, uniform": replace(SHORT, pressure_law=uniform_law(1.3), drag_width_m=0.0),
    "knots along": replace(SHORT, knot_m=0.005),
    "t90": replace(SHORT, mesh="t90", knot_m=0.005),
    "t90, entry narrower than its knots": replace(SHORT, mesh="t90", knot_m=0.006, entry_radius_m=0.15),
    "bessonneau": replace(SHORT, drag_law="bessonneau-1997", normal_drag=1.2, tangential_drag=0.1),
    "elastic": replace(SHORT, axial_stiffness_n=400.0),
    "knots along that stretch": replace(SHORT, knot_m=0.005, axial_stiffness_n=400.0, knot_axial_stiffness_n=200.0),
    "t90, knots that stretch": replace(SHORT, mesh="t90", knot_m=0.005, knot_axial_stiffness_n=200.0),
}


def meridional_force(problem: MeridianProblem, shape: MeridianShape) -> np.ndarray:
    return 2.0 * problem.meshes_round * shape.bar_tension_n * np.cos(shape.half_angle_rad)


def random_problem(random: np.random.Generator, **fixed: object) -> MeridianProblem:
    """Any bag of the working range: 40..200 meshes round, 30..150 long, filled from one mesh to nine tenths."""
    round_, long = int(random.integers(40, 201)), int(random.integers(30, 151))
    bar = random.uniform(0.015, 0.08)
    problem = MeridianProblem(
        meshes_round=round_,
        half_mesh_rows=2 * long,
        bar_m=bar,
        knot_m=bar * random.uniform(0.0, 0.2),
        entry_radius_m=random.uniform(0.15, 0.6) * round_ * bar / np.pi,
        front_row=2.0 * long - 2.0 * random.uniform(1.0, 0.9 * long),
        stagnation_pressure_pa=random.uniform(100.0, 2000.0),
        pressure_law=sphere_law(),
        drag_width_m=bar * 10.0 ** random.uniform(-2.0, -0.7),
    )
    return replace(problem, **fixed)


# --- closed forms and invariants -------------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", [uniform_pressure_shape, solve_meridian])
def test_first_integrals_hold_along_the_meridian(solver):
    shape = solver(BARE)
    phi, a, r = shape.half_angle_rad, shape.slope_rad, shape.radius_m
    twine = shape.bar_tension_n * np.cos(phi) ** 2
    assert np.ptp(twine) < 1e-6 * twine.mean()
    in_catch = np.arange(121) > BARE.front_row
    constant = np.cos(shape.slope_rad[72]) / (r[72] ** 2 * np.cos(phi[72]))
    effective = np.where(in_catch, r, shape.front_radius_m)
    np.testing.assert_allclose(np.cos(a), constant * effective**2 * np.cos(phi), atol=1e-6)


@pytest.mark.parametrize("solver", [uniform_pressure_shape, solve_meridian])
def test_meridional_force_times_row_length_is_constant_with_knots_along(solver):
    problem = replace(BARE, knot_m=0.006)
    shape = solver(problem)
    row_length = problem.bar_m * np.cos(shape.half_angle_rad) + problem.knot_m
    product = meridional_force(problem, shape) * row_length
    assert np.ptp(product) < 1e-6 * product.mean()


@pytest.mark.parametrize("mesh", ["diamond", "t90"])
def test_drag_is_pressure_on_the_front_and_not_on_the_largest_section(mesh):
    shape = uniform_pressure_shape(replace(BARE, mesh=mesh, knot_m=0.004))
    expected = 1.4 * 500.0 * np.pi * shape.front_radius_m**2
    assert shape.drag_n == pytest.approx(expected, rel=1e-6)
    assert shape.entry_reaction_n == pytest.approx(expected, rel=1e-9)
    assert shape.largest_radius_m > 1.05 * shape.front_radius_m


def test_long_catch_tends_to_the_tube_of_tan_squared_two_and_never_passes_it():
    widest = [uniform_pressure_shape(replace(FLUME, front_row=row)) for row in (260.0, 200.0, 100.0, 30.0)]
    opening = [np.degrees(2.0 * shape.half_angle_rad.max()) for shape in widest]
    radius = [shape.largest_radius_m / FLUME.spread_radius_m for shape in widest]
    limit = 2.0 * np.degrees(np.arctan(np.sqrt(2.0)))
    assert np.all(np.diff(opening) > 0.0)
    assert np.all(np.diff(radius) > 0.0)
    assert limit - 0.5 < opening[-1] <= limit
    assert np.sqrt(2.0 / 3.0) - 2e-3 < radius[-1] <= np.sqrt(2.0 / 3.0) * (1.0 + 1e-12)


def test_volume_is_that_of_the_rows_frusta():
    shape = uniform_pressure_shape(replace(BARE, front_row=70.0))
    r, x = shape.radius_m[70:], shape.x_m[70:]
    frusta = np.pi / 3.0 * np.sum(np.diff(x) * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2))
    assert shape.catch_volume_m3 == pytest.approx(frusta, rel=2e-3)
    assert shape.front_x_m == pytest.approx(x[0])
    assert shape.length_m == pytest.approx(x[-1])


def test_shape_scales_with_length_and_pressure():
    small = solve_meridian(SHORT)
    big = solve_meridian(
        replace(SHORT, bar_m=0.06, entry_radius_m=0.70, drag_width_m=3e-3, stagnation_pressure_pa=1500.0)
    )
    np.testing.assert_allclose(big.x_m, 2.0 * small.x_m, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(big.bar_tension_n, 12.0 * small.bar_tension_n, rtol=1e-9)
    assert big.catch_volume_m3 == pytest.approx(8.0 * small.catch_volume_m3)
    assert big.twine_drag_n == pytest.approx(12.0 * small.twine_drag_n)


# --- independent methods ---------------------------------------------------------------------------------------------


def direct_rates(problem: MeridianProblem, j: float, state: np.ndarray) -> list[float]:
    """Meridian equations in metres and newtons, drag by its axial and radial components, bar by bar elastic."""
    _, r, a, log_force = state
    n, b, knot, q = problem.meshes_round, problem.bar_m, problem.knot_m, problem.stagnation_pressure_pa
    force = np.exp(log_force)
    across = knot if problem.mesh == "t90" else 0.0
    softness = 0.0 if problem.knot_axial_stiffness_n is None else 1.0 / problem.knot_axial_stiffness_n
    half_side = max(np.pi * r / n - across, 0.0)

    def bar_at(phi: float) -> float:
        flexibility = 0.0 if problem.axial_stiffness_n is None else 1.0 / problem.axial_stiffness_n
        return b * (1.0 + flexibility * force / (2.0 * n * np.cos(phi)))

    def too_wide(phi: float) -> float:
        return bar_at(phi) * np.sin(phi) + across * softness * force / n * np.tan(phi) - half_side

    phi = brentq(too_wide, -1e-9, 1.57, xtol=1e-14) if half_side else 0.0
    bar = bar_at(phi)
    step = bar * np.cos(phi) + (knot * (1.0 + softness * force / n) if problem.mesh == "diamond" else 0.0)
    normal = along = pressure = 0.0
    if j > problem.front_row:
        pressure = q * float(problem.pressure_law(np.arccos(np.sin(a))))
    else:
        c = np.cos(phi) * np.cos(a)
        s = np.sqrt(1.0 - c * c)
        scale, cd, f = 2.0 * q * n * problem.drag_width_m * bar, problem.normal_drag, problem.tangential_drag
        if problem.drag_law == "le-bris-1999":
            axial = scale * cd * (s**3 + f * c**3)
            radial = scale * cd * (-s * c + f * c * c) * np.cos(phi) * np.sin(a)
        else:
            axial = scale * (cd * s**2 + f * c**2)
            radial = scale * (-cd * c + f * c) * np.cos(phi) * np.sin(a)
        normal = -np.sin(a) * axial + np.cos(a) * radial
        along = np.cos(a) * axial + np.sin(a) * radial
    hoop = np.pi / n * np.tan(phi)
    return [
        step * np.cos(a),
        step * np.sin(a),
        hoop * np.cos(a) - (2.0 * np.pi * r * pressure * step + normal) / force,
        hoop * np.sin(a) - along / force,
    ]


@pytest.mark.parametrize("name", CASES)
def test_agrees_with_direct_integration_from_the_entry(name):
    problem = CASES[name]
    shape = solve_meridian(problem, refinement=4)
    assert shape.converged, shape.outcome.value
    force = meridional_force(problem, shape)
    state = np.array([0.0, shape.radius_m[0], shape.slope_rad[0], np.log(force[0])])
    rows = np.arange(problem.half_mesh_rows + 1.0)
    x, r, a = (np.empty(len(rows)) for _ in range(3))
    for start, end in ((0.0, problem.front_row), (problem.front_row, rows[-1])):
        mine = (rows >= start) & (rows <= end)
        run = solve_ivp(
            lambda j, y, low=start, high=end: direct_rates(problem, low + 1e-9 if j <= low else min(j, high), y),
            (start, end),
            state,
            method="DOP853",
            rtol=1e-9,
            atol=1e-11,
            t_eval=np.unique(np.append(rows[mine], end)),
            max_step=3.0,
        )
        x[mine], r[mine], a[mine] = run.y[:3, : mine.sum()]
        state = run.y[:, -1]
    # what is left is the solver's error at the entry times the growth from there to the codline
    np.testing.assert_allclose(r, shape.radius_m, atol=3e-5 * problem.spread_radius_m)
    np.testing.assert_allclose(x, shape.x_m, atol=3e-5 * problem.spread_radius_m)
    np.testing.assert_allclose(a, shape.slope_rad, atol=3e-4)


@pytest.mark.parametrize("mesh", ["diamond", "t90"])
@pytest.mark.parametrize("front_row", [4.0, 60.0, 71.4, 110.0, 117.0])
def test_quadrature_and_collocation_agree(mesh, front_row):
    problem = replace(BARE, mesh=mesh, knot_m=0.001, front_row=front_row)
    closed, solved = uniform_pressure_shape(problem), solve_meridian(problem, refinement=3)
    assert closed.method == "quadrature"
    for name in ("x_m", "radius_m"):
        np.testing.assert_allclose(getattr(solved, name), getattr(closed, name), atol=1e-6 * problem.spread_radius_m)
    np.testing.assert_allclose(solved.bar_tension_n, closed.bar_tension_n, rtol=3e-6)
    np.testing.assert_allclose(solved.slope_rad, closed.slope_rad, atol=1e-5)


def test_collocation_converges_with_the_fourth_power_of_the_step():
    exact = uniform_pressure_shape(BARE)
    steps = np.array([1, 2, 4])
    errors = [np.abs(solve_meridian(BARE, int(k)).radius_m - exact.radius_m).max() for k in steps]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(4.0, abs=0.2)


def discrete_net_error(meshes_round: int) -> float:
    """Largest distance of the rows of a net of rigid bars from the shell, over N b / pi (see ``discrete_defects``)."""
    rows = meshes_round // 3
    problem = MeridianProblem(
        meshes_round, rows, 1.2 / meshes_round, 0.3 * 1.2 / np.pi, rows / 2, 500.0, uniform_law(1.4)
    )
    shape = uniform_pressure_shape(problem)
    start = np.concatenate(
        [shape.x_m[1:], shape.radius_m[1:-1], 0.5 * (shape.bar_tension_n[1:] + shape.bar_tension_n[:-1])]
    )
    found = root(discrete_defects, start, args=(problem,), method="hybr", tol=1e-12)
    assert found.success
    assert np.all(found.x[2 * rows - 1 :] > 0.0)
    difference = (found.x - start)[: 2 * rows - 1]
    return float(np.abs(difference).max() / problem.spread_radius_m)


def discrete_defects(unknowns: np.ndarray, problem: MeridianProblem) -> np.ndarray:
    """Equilibrium of the knots of one sector and lengths of its bars: rows of N knots, each turned pi/N on the last.

    Pressure acts along the area vectors of the triangles between two rows, a third at each corner.
    """
    n, rows, b = problem.meshes_round, problem.half_mesh_rows, problem.bar_m
    x = np.concatenate([[0.0], unknowns[:rows]])
    r = np.concatenate([[problem.entry_radius_m], unknowns[rows : 2 * rows - 1], [0.0]])
    tension = unknowns[2 * rows - 1 :]
    turn = np.pi / n
    dx = np.diff(x)
    lengths = np.sqrt(dx**2 + r[1:] ** 2 + r[:-1] ** 2 - 2.0 * r[1:] * r[:-1] * np.cos(turn))
    axial, radial = np.zeros(rows + 1), np.zeros(rows + 1)
    pull = 2.0 * tension / lengths
    np.add.at(axial, np.arange(rows), pull * dx)
    np.add.at(axial, np.arange(rows) + 1, -pull * dx)
    np.add.at(radial, np.arange(rows), pull * (r[1:] * np.cos(turn) - r[:-1]))
    np.add.at(radial, np.arange(rows) + 1, pull * (r[:-1] * np.cos(turn) - r[1:]))

    def knot(row: int, azimuth: float) -> np.ndarray:
        return np.array([x[row], r[row] * np.cos(azimuth), r[row] * np.sin(azimuth)])

    pressure = 1.4 * problem.stagnation_pressure_pa
    for row in range(int(problem.front_row), rows):
        fore = [(row, 0.0), (row, 2.0 * turn), (row + 1, turn)]
        aft = [(row + 1, turn), (row, 2.0 * turn), (row + 1, 3.0 * turn)]
        for corners in (fore, aft):
            p0, p1, p2 = (knot(*corner) for corner in corners)
            area = 0.5 * np.cross(p1 - p0, p2 - p0)
            for at, azimuth in corners:
                axial[at] += pressure * area[0] / 3.0
                radial[at] += pressure * (area[1] * np.cos(azimuth) + area[2] * np.sin(azimuth)) / 3.0
    scale = 1.0 / (pressure * np.pi * problem.entry_radius_m**2 / n)
    return np.concatenate([scale * axial[1:], scale * radial[1:-1], lengths / b - 1.0])


def test_discrete_net_tends_to_the_shell_with_the_square_of_the_mesh():
    coarse, fine = discrete_net_error(30), discrete_net_error(60)
    assert fine < 1e-3
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.3)


# --- pressure of a sphere, twine drag, elastic bars ------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_entry_reaction_balances_catch_load_and_twine_drag(name):
    shape = solve_meridian(CASES[name])
    assert shape.converged
    assert shape.axial_imbalance < 1e-6
    assert shape.drag_n == pytest.approx(shape.catch_drag_n + shape.twine_drag_n)
    assert shape.residual < 1e-10


@pytest.mark.parametrize("law", DRAG_LAWS)
def test_row_drag_is_that_of_its_bars_in_space(law):
    problem = replace(SHORT, drag_law=law, pressure_law=uniform_law(0.0), speed_m_s=0.9, reynolds_per_speed=1e3)
    shell = problem.shell()
    r, a, log_force = 0.6, -0.4, 0.3
    loaded, _ = rates(shell, np.array([[r], [a], [log_force]]), np.zeros(1))
    bare, _ = rates(replace(shell, drag_width=0.0), np.array([[r], [a], [log_force]]), np.zeros(1))
    phi = np.arcsin(r)
    load = np.zeros(3)  # axial, radial, tangential, of one bar each way, over rho d b V^2 / 2
    for side in (1.0, -1.0):
        bar = np.array([np.cos(phi) * np.cos(a), np.cos(phi) * np.sin(a), side * np.sin(phi)])
        flow_along = bar[0] * bar
        flow_across = np.array([1.0, 0.0, 0.0]) - flow_along
        cd, f = shell.normal, shell.tangential
        if law == "choo-casarella-1971":
            number = 0.9e3 * np.linalg.norm(flow_across)
            load += cd * (1.1 + 4.0 * number**-0.5) * np.linalg.norm(flow_across) * flow_across
            load += f * 2.0 * np.pi / 0.9e3 * (0.55 * number**0.5 + 0.084 * number ** (2.0 / 3.0)) * flow_along
        elif law == "le-bris-1999":
            load += cd * np.linalg.norm(flow_across) * flow_across + f * cd * np.linalg.norm(flow_along) * flow_along
        else:
            load += cd * flow_across + f * flow_along
    normal = -np.sin(a) * load[0] + np.cos(a) * load[1]
    along = np.cos(a) * load[0] + np.sin(a) * load[1]
    # N bars each way over Q, and t = pi j / N: N / pi * N rho d b V^2 / 2 / (pi R^2 q) = d / b
    scale = 0.5 * shell.drag_width * np.exp(-log_force)
    np.testing.assert_allclose((loaded - bare)[1:, 0], [-scale * normal, -scale * along], rtol=1e-12)


@pytest.mark.parametrize("law", DRAG_LAWS)
@pytest.mark.parametrize("mesh", ["diamond", "t90"])
@pytest.mark.parametrize(("stiffness", "of_knots"), [(None, None), (50.0, None), (None, 20.0), (50.0, 20.0)])
def test_jacobian_is_the_derivative_of_the_rates(law, mesh, stiffness, of_knots):
    section = {"mesh": mesh, "knot_m": 0.004, "axial_stiffness_n": stiffness, "knot_axial_stiffness_n": of_knots}
    shell = replace(SHORT, drag_law=law, speed_m_s=0.9, reynolds_per_speed=1e3, **section).shell()
    random = np.random.default_rng(2)
    state = np.stack([random.uniform(0.2, 0.8, 40), random.uniform(-1.5, 1.4, 40), random.uniform(-2.0, 1.0, 40)])
    in_catch = (random.random(40) < 0.5).astype(float)
    _, jacobian = rates(shell, state, in_catch)
    for k, nudge in enumerate(1e-6 * np.eye(3)[:, :, None]):
        forward, back = (rates(shell, state + sign * nudge, in_catch)[0] for sign in (1.0, -1.0))
        np.testing.assert_allclose((forward - back) / 2e-6, jacobian[:, k], rtol=1e-6, atol=2e-8)


def test_twine_drag_of_a_nearly_straight_tube_is_that_of_its_oblique_bars():
    """Bars of a long tube lie at phi to the flow: axial drag k_n sin^2 phi + k_t cos^2 phi of each."""
    shape = solve_meridian(FLUME)
    rows = int(FLUME.front_row)
    cosine = np.cos(shape.half_angle_rad[: rows + 1]) * np.cos(shape.slope_rad[: rows + 1])
    sine = np.sqrt(1.0 - cosine**2)
    bars = 2.0 * 150 * 500.0 * 0.52e-3 * 0.020 * 1.36 * (sine**3 + 0.07 * cosine**3)
    assert shape.twine_drag_n == pytest.approx(np.trapezoid(bars), rel=1e-4)


def test_no_twine_drag_without_coefficients_and_more_with_thicker_twine():
    drags = [solve_meridian(replace(FLUME, drag_width_m=width)).twine_drag_n for width in (0.0, 1e-4, 2e-4)]
    assert drags[0] == 0.0
    assert drags[2] == pytest.approx(2.0 * drags[1], rel=0.02)
    assert solve_meridian(replace(FLUME, normal_drag=0.0)).twine_drag_n == 0.0


def test_stiff_twine_tends_to_inextensible_and_soft_twine_gives_a_wider_bag():
    rigid = solve_meridian(SHORT)
    error = [abs(solve_meridian(replace(SHORT, axial_stiffness_n=ea)).length_m - rigid.length_m) for ea in (1e5, 1e6)]
    assert error[0] / error[1] == pytest.approx(10.0, rel=0.02)
    soft = solve_meridian(replace(SHORT, axial_stiffness_n=200.0))
    assert soft.largest_radius_m > rigid.largest_radius_m
    stretched = SHORT.bar_m * (1.0 + soft.bar_tension_n / 200.0)
    np.testing.assert_allclose(
        SHORT.meshes_round / np.pi * stretched * np.sin(soft.half_angle_rad), soft.radius_m, atol=1e-9
    )


def test_t90_without_knot_length_is_diamond_netting():
    diamond, turned = solve_meridian(SHORT), solve_meridian(replace(SHORT, mesh="t90"))
    np.testing.assert_allclose(turned.radius_m, diamond.radius_m, atol=1e-12)
    assert turned.drag_n == pytest.approx(diamond.drag_n, rel=1e-12)


def test_slack_t90_knots_leave_bars_in_meridian_planes():
    problem = CASES["t90, entry narrower than its knots"]
    shape = solve_meridian(problem)
    slack = shape.radius_m < problem.meshes_round * problem.knot_m / np.pi
    assert slack[0]
    assert slack[-1]
    assert np.all(shape.half_angle_rad[slack] == 0.0)
    assert np.all(shape.half_angle_rad[~slack] > 0.0)
    tail = np.flatnonzero(slack)[np.flatnonzero(slack) > problem.front_row]
    assert np.ptp(shape.bar_tension_n[tail]) < 1e-6 * shape.bar_tension_n[-1]


def test_drag_and_volume_do_not_jump_as_the_front_passes_a_row():
    rows = 200.0 + np.array([-2e-6, -1e-6, 0.0, 1e-6, 2e-6])
    shapes = [solve_meridian(replace(FLUME, front_row=row)) for row in rows]
    for name in ("drag_n", "catch_volume_m3", "front_x_m", "largest_radius_m"):
        values = np.array([getattr(shape, name) for shape in shapes])
        assert np.ptp(values) < 1e-6 * values[0], name


# --- robustness and refusals -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "fixed",
    [
        {},
        {"mesh": "t90"},
        {"drag_law": "bessonneau-1997", "normal_drag": 1.2, "tangential_drag": 0.1},
        {"pressure_law": uniform_law(1.4), "drag_width_m": 0.0},
    ],
    ids=["diamond", "t90", "bessonneau", "uniform"],
)
def test_solves_the_whole_working_range(fixed):
    random = np.random.default_rng(20)
    for _ in range(40):
        problem = random_problem(random, **fixed)
        shape = solve_meridian(problem)
        assert shape.converged, (problem, shape.outcome.value)
        assert shape.axial_imbalance < 1e-6
        assert np.all(shape.bar_tension_n > 0.0)
        assert np.all(np.cos(shape.slope_rad) > -1e-9)
        assert np.all(np.diff(shape.x_m) > 0.0)
        assert shape.radius_m[0] == pytest.approx(problem.entry_radius_m)
        assert abs(shape.radius_m[-1]) < 1e-9


def test_quadrature_gives_a_start_for_every_diamond_bag_of_the_working_range():
    random = np.random.default_rng(21)
    for _ in range(100):
        shape = uniform_pressure_shape(random_problem(random))
        assert shape.converged
        assert shape.method == "quadrature"
        assert shape.residual < 1e-9


def test_front_at_the_entry_and_an_entry_wider_than_the_catch_are_solved():
    for problem in (replace(FLUME, front_row=0.0), replace(FLUME, entry_radius_m=0.93 * FLUME.spread_radius_m)):
        for shape in (solve_meridian(problem), uniform_pressure_shape(problem)):
            assert shape.converged
            assert shape.axial_imbalance < 1e-6


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"bar_m": 0.0}, "bar_m = 0.0 must be above 0"),
        ({"knot_m": -0.001}, "knot_m"),
        ({"stagnation_pressure_pa": np.nan}, "stagnation_pressure_pa"),
        ({"front_row": 280.0}, "front_row = 280.0 must lie in"),
        ({"mesh": "square"}, "unknown mesh 'square'"),
        ({"drag_law": "morison"}, "'morison'"),
        ({"axial_stiffness_n": 0.0}, "axial_stiffness_n"),
        ({"entry_radius_m": 0.96}, "cannot reach"),
        ({"half_mesh_rows": 14, "front_row": 7.0}, "cannot reach"),
    ],
)
def test_impossible_problems_are_refused_with_the_reason(change, words):
    with pytest.raises(ValueError, match=words):
        replace(FLUME, **change)


def test_a_catch_without_pressure_is_refused():
    with pytest.raises(ValueError, match="coefficient"):
        uniform_pressure_shape(FLUME, coefficient=0.0)
    assert not solve_meridian(replace(BARE, pressure_law=uniform_law(0.0))).converged


def test_rows_that_only_just_reach_the_axis_are_nearly_a_flat_disc():
    needed = FLUME.rows_to_axis()
    flat = replace(FLUME, half_mesh_rows=int(np.ceil(needed)), front_row=2.0, entry_radius_m=0.30)
    shape = solve_meridian(flat)
    assert shape.converged
    assert shape.length_m < 0.3 * flat.entry_radius_m
    assert shape.slope_rad[0] < np.radians(-50.0)


@pytest.mark.parametrize(
    ("spoil", "outcome"),
    [
        (lambda result: replace(result, converged=False), Outcome.NO_MERIDIAN),
        (lambda result: replace(result, state=result.state * [[1.0], [1.6], [1.0]]), Outcome.SLOPE_REVERSED),
        (lambda result: replace(result, state=result.state - [[0.1], [0.0], [0.0]]), Outcome.RADIUS_NEGATIVE),
    ],
)
def test_a_state_that_is_no_equilibrium_is_never_passed_as_solved(monkeypatch, spoil, outcome):
    genuine = solve.solve_newton

    def spoiled(*arguments: object) -> NewtonResult:
        return spoil(genuine(*arguments))

    monkeypatch.setattr(solve, "solve_newton", spoiled)
    shape = solve_meridian(SHORT)
    assert not shape.converged
    assert shape.outcome is outcome


@pytest.mark.parametrize(
    ("quantity", "small", "fits", "large"), [("volume_m3", 1e-9, 0.05, 0.45), ("front_from_codline_m", 1e-5, 0.4, 1.59)]
)
def test_a_catch_the_membrane_cannot_hold_fails_alone_and_says_why(quantity, small, fits, large):
    study = solve_plan(make_plan(24, 20, catch={quantity: [small, fits, large]}, model={"fidelity": "meridian"}))
    outcomes = [result.report.outcome for result in study.cases]
    assert outcomes == [Outcome.TOO_SMALL, Outcome.CONVERGED, Outcome.OVERFULL]
    assert study.table["drag_n"].notna().tolist() == [False, True, False]


def test_a_search_for_the_front_that_meets_an_unsolved_shape_ends_in_a_failed_case(monkeypatch):
    genuine = solve.solve_newton
    monkeypatch.setattr(solve, "solve_newton", lambda *arguments: replace(genuine(*arguments), converged=False))
    (result,) = solve_plan(make_plan(24, 20, catch={"volume_m3": 0.05}, model={"fidelity": "meridian"})).cases
    assert result.report.outcome is Outcome.NO_MERIDIAN
    assert np.isnan(result.measures.drag_n)


def test_a_catch_of_a_billionth_of_a_mesh_asks_for_no_more_grid_than_there_is_room_for():
    found = solve_plan(make_plan(24, 10, filled=1e-9))
    assert found.converged
    assert 0.0 < found.table["catch_volume_m3"].item() < 1e-12


@pytest.mark.parametrize("filled", [0.1, 0.3, 4.25])
def test_the_meshes_filled_are_told_as_they_were_asked_for(filled):
    told = solve_plan(make_plan(24, 20, filled=filled, model={"fidelity": "meridian"})).table
    assert told["filled_meshes"].item() == pytest.approx(filled, rel=1e-12)
