"""Invariants and closed forms of the equilibrium (shell theory of the netting, N large)."""

import numpy as np
import pytest

from codend.bag.bag import mesh_corners
from codend.bag.measures import measure_all, mesh_openings
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.solvers.outcome import Outcome
from codend.studies.study import solve
from tests.plans import UNIFORM, make_plan, uniform_plan
from validation.reference import residual

SECTOR = {"fidelity": "sector", "method": "dynamic-relaxation", "tolerance": 1e-7}


@pytest.fixture(scope="module")
def uniform():
    """100 meshes round, uniform pressure, no drag: T cos^2 phi and cos a / (r^2 cos phi) are constant."""
    return solve(uniform_plan(100, 60, 25.0, bar_mm=20.0, model=SECTOR)).cases[0]


def half_angles(result):
    """Half opening angle of the twines of each band: sin phi = half the spacing of the knots over the bar."""
    rows, net = result.rows, result.net
    middle = 0.5 * (rows.radius_m[1:] + rows.radius_m[:-1])
    return np.arcsin(np.clip(middle * np.pi / (net.order * net.bar_length[0]), 0, 1))


def test_the_constant_of_the_meridional_pull_holds_from_entry_to_codline(uniform):
    phi = half_angles(uniform)
    tension = uniform.bar_tension_n[np.argsort(uniform.bag.bar_band, kind="stable")][::2]
    constant = (tension * np.cos(phi) ** 2)[:-6]  # the last rows are too few bars wide for the smooth limit
    assert constant == pytest.approx(constant.mean(), rel=1e-3)


def test_the_slope_in_the_catch_follows_radius_and_opening(uniform):
    rows = uniform.rows
    phi = half_angles(uniform)
    cos_a = np.diff(rows.x_m) / np.hypot(np.diff(rows.x_m), np.diff(rows.radius_m))
    front = uniform.bag.bands - 50
    middle = 0.5 * (rows.radius_m[1:] + rows.radius_m[:-1])
    in_catch = (cos_a / (middle**2 * np.cos(phi)))[front + 1 : -8]
    assert in_catch == pytest.approx(in_catch.mean(), rel=2e-3)
    ahead = (cos_a / (rows.radius_m[front] ** 2 * np.cos(phi)))[: front - 1]
    assert ahead == pytest.approx(in_catch.mean(), rel=2e-3)


def test_entry_reaction_is_pressure_times_the_polygon_of_the_front_row(uniform):
    net = uniform.net
    radius = uniform.rows.radius_m[uniform.bag.bands - 50]
    polygon = 0.5 * net.order * radius**2 * np.sin(2 * np.pi / net.order)
    pressure = 1.4 * 500.0
    assert uniform.measures.catch_drag_n == pytest.approx(pressure * polygon, rel=1e-12)
    assert uniform.measures.entry_reaction_n == pytest.approx(pressure * polygon, rel=2e-7)


def test_opening_and_radius_stay_below_their_bounds_in_a_long_catch():
    result = solve(uniform_plan(100, 100, 85.0, bar_mm=20.0, model=SECTOR)).cases[0]
    limit = np.degrees(2 * np.arctan(np.sqrt(2)))
    bound = 0.8165 * 100 * 0.020 / np.pi
    assert 105.0 < np.nanmax(result.rows.opening_deg) < limit + 0.02
    assert 0.98 * bound < result.measures.max_radius_m < 1.0005 * bound


@pytest.mark.parametrize(
    "plan",
    [
        make_plan(24, 20, model=SECTOR),
        make_plan(24, 20, netting={"knot_mm": 6.0, "axial_stiffness_n": 2000.0}, model=SECTOR),
        make_plan(24, 20, mesh="t90", netting={"knot_mm": 6.0}, drag={"law": "bessonneau-1997"}, model=SECTOR),
        make_plan(24, 20, mesh="square", model=SECTOR, entry=0.8),
        make_plan(12, 10, filled=4.0, netting={"twine_density_kg_m3": 1400.0}, model={"fidelity": "full"}),
        make_plan(24, 20, catch={"volume_m3": 0.02}, model={"fidelity": "globalised", "globalisation": 2}),
        make_plan(24, 20, model={"bars_per_side": 2, "fidelity": "sector"}),
    ],
    ids=["diamond", "knotted elastic", "t90", "square", "full and heavy", "globalised", "hinged"],
)
def test_residual_in_the_table_is_that_of_the_arrays(plan):
    study = solve(plan)
    result = study.cases[0]
    assert result.converged
    recomputed = residual(result.problem, result.positions, result.solution.bar_tension, result.solution.share)
    assert study.table.residual[0] == pytest.approx(recomputed, rel=1e-6, abs=1e-13)
    assert recomputed <= plan.model.tolerance
    balance = result.measures.entry_reaction_n / result.measures.drag_n - 1
    assert abs(balance) <= 1.01 * plan.model.tolerance
    assert np.all(result.bar_tension_n >= 0.0)
    assert result.report.length_error <= 1e-6


def test_elastic_twine_tends_to_inextensible_as_its_stiffness_grows():
    stiff = solve(make_plan(24, 20, model=SECTOR)).cases[0].positions
    gaps = []
    for stiffness in (1e4, 1e5, 1e6):
        soft = solve(make_plan(24, 20, netting={"axial_stiffness_n": stiffness}, model=SECTOR)).cases[0].positions
        gaps.append(np.abs(soft - stiff).max())
    rates = np.diff(np.log10(gaps))
    assert rates == pytest.approx([-1.0, -1.0], abs=0.05)


def test_twine_carries_no_compression_and_slack_twine_is_not_longer_than_itself():
    """Knots lying across near the codline of a T90 bag have no room: they must come out slack."""
    result = solve(make_plan(24, 20, mesh="t90", netting={"knot_mm": 12.0}, model=SECTOR)).cases[0]
    assert result.converged
    slack = result.bar_tension_n == 0.0
    knots = result.net.bar_drag_diameter == 0.0
    assert np.any(slack & knots)
    assert not np.any(slack & ~knots)


def test_drag_scales_with_the_square_of_the_speed_and_the_shape_does_not_change():
    slow, fast = (solve(make_plan(24, 20, speed=v, model=SECTOR)).cases[0] for v in (0.5, 2.0))
    assert fast.measures.drag_n == pytest.approx(16 * slow.measures.drag_n, rel=1e-4)
    assert fast.positions == pytest.approx(slow.positions, abs=1e-4)


def test_viscous_and_kinetic_damping_end_at_the_same_equilibrium():
    kinetic, viscous = (
        solve(make_plan(24, 20, model={**SECTOR, "damping": damping})).cases[0].positions
        for damping in ("kinetic", "viscous")
    )
    assert viscous == pytest.approx(kinetic, abs=1e-5)


def test_openings_of_a_flat_panel_are_those_it_was_laid_with(uniform):
    opening, normal = mesh_openings(uniform.bag, mesh_corners(uniform.bag, uniform.positions))
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)
    phi = np.radians(opening) / 2
    spacing = np.pi * uniform.rows.radius_m[uniform.bag.mesh_row] / uniform.net.order
    assert 2 * uniform.net.bar_length[0] * np.sin(phi[:-2]) == pytest.approx(2 * spacing[:-2], rel=2e-3)


def test_a_catch_within_the_last_band_has_its_share_of_the_volume_and_is_found_by_it():
    filled = [0.05, 0.2, 0.4, 0.5]
    by_meshes = solve(make_plan(24, 20, filled=filled, model=SECTOR)).table
    volume = by_meshes["catch_volume_m3"].to_numpy()
    assert np.all(np.diff(volume) > 0.0)
    assert volume[0] > 0.0
    by_volume = solve(make_plan(24, 20, catch={"volume_m3": volume.tolist()}, model=SECTOR)).table
    assert by_volume["converged"].all()
    assert by_volume["filled_meshes"].to_numpy() == pytest.approx(filled, rel=1e-4)
    assert by_volume["drag_n"].to_numpy() == pytest.approx(by_meshes["drag_n"].to_numpy(), rel=1e-4)


def test_a_case_known_already_is_no_start_for_a_path_to_itself():
    plan = make_plan(
        24, 20, 0.35, 0.01, netting={"knot_mm": 8.0, "axial_stiffness_n": 45.0}, model={"fidelity": "meridian"}
    )
    assert solve(plan).cases[0].converged


def test_two_sectors_side_by_side_have_the_equilibrium_of_one():
    plan = make_plan(24, 20)
    drags = []
    for sectors in (1, 2):
        model = model_of(plan, 1, sectors)
        problem, solution = equilibrium.solve(model, plan.cases()[0], (), None)
        assert solution.report.outcome.converged
        drags.append(measure_all(model.bag, problem, solution)[2].drag_n)
    assert drags[1] == pytest.approx(drags[0], rel=1e-6)


@pytest.mark.parametrize("speeds", [[0.5], [0.25, 0.5]])
def test_weight_is_borne_however_near_the_start_seems(speeds):
    """From a sector, which knows none, and from the same catch at another speed, where it is another share of drag."""
    netting = {"twine_density_kg_m3": 1140.0}
    options = {"netting": netting, "filled": 6.0}
    whole = {"fidelity": "globalised", "globalisation": 2}
    loose = solve(make_plan(24, 20, **options, speed=speeds, model=whole | {"tolerance": 1e-3})).cases[-1]
    exact = solve(make_plan(24, 20, **options, speed=speeds[-1], model=whole | {"tolerance": 1e-10})).cases[0]
    sag = [case.positions[:, 2].mean() for case in (loose, exact)]
    assert sag[1] < 0.0
    assert sag[0] == pytest.approx(sag[1], rel=0.01)


FULL_OR_NOT = {
    "diamond": (24, 20, 0.35, {}),
    "narrow entry, ballooning on the way": (40, 30, 0.2, {}),
    "square": (24, 20, 0.35, {"mesh": "square"}),
    "elastic T90": (40, 30, 0.2, {"mesh": "t90", "netting": {"knot_mm": 5.0, "axial_stiffness_n": 2000.0}}),
}
SHARES = (0.5, 0.7, 0.88, 0.95, 0.9999, 1.0001, 1.05)


@pytest.mark.parametrize("name", FULL_OR_NOT)
@pytest.mark.parametrize("pressure", [{}, UNIFORM], ids=["sphere", "uniform"])
def test_a_catch_is_called_too_large_by_every_method_above_the_volume_of_the_full_net_and_by_none_below(name, pressure):
    meshes_round, meshes_long, entry, options = FULL_OR_NOT[name]

    def solved(method, catch):
        model = {"fidelity": "sector", "method": method, "tolerance": 2.5e-7}
        plan = make_plan(meshes_round, meshes_long, entry, catch=catch | pressure, model=model, **options)
        model = model_of(plan, 1, 1)
        return model.bag, *equilibrium.solve(model, plan.cases()[0], (), None)

    full_volume = measure_all(*solved("auto", {"filled_meshes": float(meshes_long)}))[2].catch_volume_m3
    methods = ["newton", "auto", "dynamic-relaxation"]
    if "axial_stiffness_n" not in options.get("netting", {}):
        methods.append("rigid-bars")
    for share in SHARES:
        solutions = [solved(method, {"volume_m3": share * full_volume})[2] for method in methods]
        expected = Outcome.CONVERGED if share < 1.0 else Outcome.OVERFULL
        for method, solution in zip(methods, solutions, strict=True):
            report = solution.report
            assert report.outcome is expected, (method, share, report.attempts)
            assert max(report.residual, report.imbalance, report.length_error) <= 1e-6, (method, share)
            np.testing.assert_allclose(solution.share, solutions[0].share, atol=1e-3)
            np.testing.assert_allclose(solution.positions, solutions[0].positions, atol=1e-4)
