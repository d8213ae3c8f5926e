"""Loads on random small nets: energies, rotations, translations, limits of the laws."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PPoly

from catch_models.filling import enclosed_volume, fill_by_meshes, fill_to_plane, fill_to_volume
from catch_models.pressure import PressureLaw, sphere_law, sphere_law_through, uniform_law
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import measure_meshes, measure_rows
from codend.io.input_table import read_table
from codend.mechanics import bars, catch_front, pressure
from codend.mechanics.loads import add_force
from codend.mechanics.structure import structure_of
from codend.net.net import bar_vectors, rotate
from codend.solvers.outcome import Outcome, Solution, SolverReport
from tests.plans import NO_DRAG, UNIFORM, make_plan
from validation.plain_nets import plain_net, plain_problem
from validation.reference import nodal_loads

KINDS = st.sampled_from([("diamond", 0.0), ("diamond", 6.0), ("t90", 6.0), ("square", 0.0)])


@st.composite
def random_bags(draw, sectors=None):
    mesh, knot = draw(KINDS)
    meshes = draw(st.integers(4, 9))
    plan = make_plan(
        meshes,
        draw(st.integers(2, 4)),
        draw(st.floats(0.1, 0.8)),
        1.0,
        mesh=mesh,
        netting={"knot_mm": knot, "axial_stiffness_n": draw(st.floats(10.0, 1e4))},
        catch={"filled_meshes": draw(st.floats(0.3, 2.0)), **draw(st.sampled_from([UNIFORM, {}]))},
        drag={"law": draw(st.sampled_from(["le-bris-1999", "bessonneau-1997"]))},
    )
    bag = build_bag(plan, sectors=sectors)
    net = bag.net
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shaken = net.positions + 0.005 * rng.normal(size=net.positions.shape) * ~net.fixed
    return plan, replace(bag, net=replace(net, positions=shaken))


def loads_on(problem, positions, share):
    force = np.zeros_like(positions)
    add_force(np.ascontiguousarray(positions), problem.structure, problem.loading, share, force)
    return force


def filled_share(problem, positions):
    share = np.zeros(problem.bands)
    catch_front.fill(np.ascontiguousarray(positions), problem.structure, problem.loading.catch, share)
    return share


@settings(max_examples=25, deadline=None)
@given(random_bags())
def test_loads_are_those_of_the_equations_written_in_vectors(case):
    plan, bag = case
    net, problem = bag.net, problem_of(bag, plan, plan.cases()[0])
    share = filled_share(problem, net.positions)
    expected = nodal_loads(problem, net.positions, share)
    assert loads_on(problem, net.positions, share) == pytest.approx(expected, rel=1e-10, abs=1e-12)


@settings(max_examples=25, deadline=None)
@given(random_bags(), st.floats(0, 6.3), st.floats(-1, 1))
def test_loads_turn_and_travel_with_the_net(case, angle, shift):
    plan, bag = case
    net, problem = bag.net, problem_of(bag, plan, plan.cases()[0])
    share = filled_share(problem, net.positions)
    turned = rotate(net.positions, 1, 2 * np.pi / angle) if angle else net.positions
    moved = turned + np.array([shift, 0.0, 0.0])
    expected = loads_on(problem, net.positions, share)
    expected = rotate(expected, 1, 2 * np.pi / angle) if angle else expected
    assert loads_on(problem, moved, share) == pytest.approx(expected, abs=1e-10)


@settings(max_examples=25, deadline=None)
@given(random_bags(sectors=1))
def test_a_sector_carries_the_loads_of_its_part_of_the_full_net(case):
    """Whichever image of a node is taken for its representative."""
    plan, bag = case
    net, problem = bag.net, problem_of(bag, plan, plan.cases()[0])
    share = filled_share(problem, net.positions)
    expected = nodal_loads(problem, net.positions, share)
    assert loads_on(problem, net.positions, share) == pytest.approx(expected, rel=1e-10, abs=1e-12)

    shift = np.arange(len(net.positions)) % 3 - 1
    shift[-1] = 0
    recut = replace(
        net,
        positions=rotate(net.positions, shift, net.order),
        bar_image=(net.bar_image + shift[net.bars[:, 0]] - shift[net.bars[:, 1]]).astype(np.int32),
        facet_image=(net.facet_image - shift[net.facets]).astype(np.int32),
    )
    again = problem_of(replace(bag, net=recut), plan, plan.cases()[0])
    assert loads_on(again, recut.positions, share) == pytest.approx(rotate(expected, shift, net.order), abs=1e-11)


@settings(max_examples=15, deadline=None)
@given(random_bags(), st.integers(0, 2**32 - 1))
def test_bar_forces_are_minus_the_gradient_of_their_energy(case, seed):
    built = case[1].net
    # no bar just as long as without load, where its energy has no one derivative
    apart = np.maximum(np.linalg.norm(bar_vectors(built, built.positions), axis=1), 1e-3)
    length = apart * np.where(np.arange(len(built.bars)) % 2, 0.95, 1.05)
    net = replace(built, bar_length=length, bar_flexibility=np.maximum(built.bar_flexibility, 1e-4))
    structure = structure_of(net)
    stiffness = 1.0 / net.bar_flexibility

    def energy(positions):
        length = np.empty(len(net.bars))
        bars.bar_lengths(positions, structure, length)
        stretch = np.maximum(length - net.bar_length, 0.0)
        return 0.5 * (stiffness / net.bar_length * stretch**2).sum()

    length, force = np.empty(len(net.bars)), np.zeros_like(net.positions)
    bars.bar_lengths(net.positions, structure, length)
    tension = stiffness * np.maximum(length / net.bar_length - 1.0, 0.0)
    bars.add_bar_forces(net.positions, structure, tension / length, force)
    direction = np.random.default_rng(seed).normal(size=net.positions.shape)
    step = 1e-7
    slope = (energy(net.positions + step * direction) - energy(net.positions - step * direction)) / (2 * step)
    assert -(force * direction).sum() == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.abs(force).max())


@settings(max_examples=15, deadline=None)
@given(random_bags(), st.integers(0, 2**32 - 1))
def test_uniform_pressure_does_the_work_of_the_volume_it_sweeps(case, seed):
    """With the front ring held there is no lid to forget: force . motion = pressure x change of volume."""
    plan, bag = case
    net = bag.net
    uniform = plan.model_copy(update={"drag": plan.drag.model_copy(update={"normal": 0.0})})
    problem = problem_of(bag, uniform, plan.cases()[0])
    catch = problem.loading.catch._replace(
        angles=np.array([0.0, np.pi]), coefficients=np.array([[0.0], [0.0], [0.0], [1.4]])
    )
    problem = replace(problem, loading=problem.loading._replace(catch=catch))
    share = np.ones(bag.bands)

    def volume(positions):
        area, moment = np.empty(bag.bands), np.empty(bag.bands)
        catch_front.band_geometry(np.ascontiguousarray(positions), problem.structure, catch, area, moment)
        return moment.sum()

    direction = np.random.default_rng(seed).normal(size=net.positions.shape) * ~net.fixed.all(axis=1, keepdims=True)
    step = 1e-5
    swept = (volume(net.positions + step * direction) - volume(net.positions - step * direction)) / (2 * step)
    work = (loads_on(problem, net.positions, share) * direction).sum()
    assert work == pytest.approx(1.4 * catch.stagnation_pressure * swept, rel=1e-6, abs=1e-6)


def test_the_catch_pushes_no_lid_at_its_open_front():
    """Uniform pressure: the axial load on the netting is pressure times the polygon of the front row, not zero."""
    plan = make_plan(12, 8, catch={"filled_meshes": 4.0, **UNIFORM}, drag=NO_DRAG)
    bag = build_bag(plan)
    net, problem = bag.net, problem_of(bag, plan, plan.cases()[0])
    share = filled_share(problem, net.positions)
    ring = net.positions[bag.node_row == 8]
    radius = np.hypot(ring[0, 1], ring[0, 2])
    polygon = 6 * radius**2 * np.sin(2 * np.pi / 12)
    assert loads_on(problem, net.positions, share).sum(axis=0) == pytest.approx([700.0 * polygon, 0, 0], abs=1e-10)


def test_the_front_moves_continuously_through_the_rows():
    plan = make_plan(12, 8, filled=4.0)
    bag = build_bag(plan, sectors=1)
    net = bag.net
    loads = []
    for filled in np.linspace(3.9, 4.6, 281):
        problem = problem_of(bag, plan, replace(plan.cases()[0], catch_value=filled))
        loads.append(loads_on(problem, net.positions, filled_share(problem, net.positions))[:, 0].sum())
    steps = np.abs(np.diff(loads))
    assert steps.max() < 3 * np.median(steps)


@given(st.lists(st.floats(0.05, 1.0), min_size=3, max_size=8), st.floats(0.01, 0.99))
def test_filling_to_a_volume_encloses_that_volume(radii, part):
    """A stack of cones, its volume known in closed form."""
    radius = np.array([*radii, 0.0])
    row_x = np.arange(len(radius), dtype=float)
    inner, outer = radius[1:], radius[:-1]
    cones = np.pi / 3 * (inner**2 + inner * outer + outer**2)
    band_area = np.pi * (outer**2 - inner**2)
    # positive where the band faces aft; the flux of (x, 0, 0) out of a closed cone is its volume
    band_moment = cones - (row_x[1:] * np.pi * inner**2 - row_x[:-1] * np.pi * outer**2)
    share = np.zeros(len(cones))
    assert fill_to_volume(row_x, band_area, band_moment, part * cones.sum(), share)
    assert share @ cones == pytest.approx(part * cones.sum(), rel=1e-9)
    assert enclosed_volume(row_x, band_area, band_moment, share) == pytest.approx(part * cones.sum(), rel=1e-9)
    assert np.all(share[int(np.ceil((1 - share).sum())) :] == 1.0)
    assert not fill_to_volume(row_x, band_area, band_moment, 1.01 * cones.sum(), share)


def test_filling_by_meshes_and_to_a_plane_agree_where_they_mean_the_same():
    row_x, meshes = np.linspace(0, 4, 9), np.full(8, 0.5)
    by_meshes, by_plane = np.zeros(8), np.zeros(8)
    assert fill_by_meshes(meshes, 1.3, by_meshes)
    assert fill_to_plane(row_x, 1.3, by_plane)
    assert by_plane == pytest.approx(by_meshes)
    assert not fill_by_meshes(meshes, 4.3, by_meshes)
    assert not fill_to_plane(row_x, 4.3, by_plane)


def test_bars_in_the_catch_and_knots_carry_no_drag():
    plan = make_plan(12, 8, netting={"knot_mm": 5.0}, catch={"filled_meshes": 8.0})
    bag = build_bag(plan)
    net, problem = bag.net, problem_of(bag, plan, plan.cases()[0])
    unpressed = problem.loading.catch._replace(stagnation_pressure=0.0)
    dry = replace(problem, loading=problem.loading._replace(catch=unpressed))
    assert np.all(loads_on(dry, net.positions, np.ones(bag.bands)) == 0.0)
    knots = net.bar_drag_diameter == 0.0
    assert np.count_nonzero(knots) == 12 * 16


def test_the_pieces_that_ship_are_those_of_the_curve_that_ships():
    """Else: ``python -m validation.make_sphere_pieces``."""
    table = read_table(str(files("catch_models") / "data" / "sphere_cp_subcritical.csv"))
    pieces, curve = sphere_law(), sphere_law_through(table.numbers("theta_deg"), table.numbers("cp"))
    np.testing.assert_array_equal(pieces.angles_rad, curve.angles_rad)
    np.testing.assert_array_equal(pieces.coefficients, curve.coefficients)


def test_a_pressure_law_and_its_slope_are_those_of_scipys_piecewise_cubic():
    law = sphere_law()
    theta = np.concatenate([law.angles_rad, np.linspace(0.0, np.pi, 1001)])
    expected = PPoly(law.coefficients, law.angles_rad)
    np.testing.assert_allclose(law(theta), expected(theta), rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(law.derivative(theta), expected.derivative()(theta), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("law", [sphere_law(), uniform_law()], ids=["sphere", "uniform"])
def test_kernels_take_pressures_and_slopes_from_a_law_as_tables_and_plots_do(law):
    middles = 0.5 * (law.angles_rad[1:] + law.angles_rad[:-1])
    for theta in (*law.angles_rad, *middles, *np.linspace(0.0, np.pi, 101)):
        for area in (1e-6, 1.0, 1e3):
            x, across = -area * np.cos(theta), area * np.sin(theta)
            value, slope = pressure.law_and_slope(x, across, law.angles_rad, law.coefficients)
            assert value == pytest.approx(law(theta), rel=1e-13, abs=1e-14)
            assert slope == pytest.approx(law.derivative(theta), rel=1e-13, abs=1e-13)


SLOPING = PressureLaw("1 + theta", np.array([0.0, np.pi]), np.array([[0.0], [0.0], [1.0], [1.0]]))
"""Under it an angle told by its cosine, wrong by 1e-16 / angle near the axis of the flow, shows."""
OFF_AXIS = pytest.mark.parametrize("off_axis", [1e-6, 1e-7, 1e-8])
FACING = pytest.mark.parametrize("upstream", [True, False], ids=["upstream", "downstream"])


@OFF_AXIS
@FACING
def test_the_pressure_on_a_facet_nearly_square_to_the_flow_is_exact(off_axis, upstream):
    theta = off_axis if upstream else np.pi - off_axis
    normal = np.array([-np.cos(theta), np.sin(theta), 0.0])
    corners = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [np.sin(theta), np.cos(theta), 0.0]])
    facets = np.array([[0, 1, 2]])
    net = plain_net(corners, np.zeros((3, 3)), np.zeros((0, 2)), np.zeros(0), facets=facets)
    problem = plain_problem(net, np.arange(3), pressure_law=SLOPING, stagnation_pressure=2.0, filled=2.0)
    assert loads_on(problem, corners, np.ones(2)).sum(axis=0) == pytest.approx((1.0 + theta) * normal, abs=1e-12)


@OFF_AXIS
@FACING
def test_the_pressure_told_of_meshes_and_rows_nearly_square_to_the_flow_is_exact(off_axis, upstream):
    """On a cone that is nearly a disc; its last rows, which close it, are none of it."""
    plan = make_plan(8, 6, filled=6.0)
    bag = build_bag(plan)
    net, problem = bag.net, problem_of(bag, plan, plan.cases()[0])
    catch = problem.loading.catch._replace(angles=SLOPING.angles_rad, coefficients=SLOPING.coefficients)
    problem = replace(problem, loading=problem.loading._replace(catch=catch))
    radius = np.where(bag.node_row >= 0, 1.0 + 0.05 * bag.node_row * (1 if upstream else -1), 0.0)
    x = off_axis * np.where(upstream, radius, -radius)
    azimuth = np.arctan2(net.positions[:, 2], net.positions[:, 1])
    positions = np.stack([x, radius * np.cos(azimuth), radius * np.sin(azimuth)], axis=1)
    report = SolverReport("none", Outcome.CONVERGED, 0, 0.0, 0.0, 0.0, 0.0, ())
    solution = Solution(positions, np.ones(len(net.bars)), np.ones(bag.bands), report)
    meshes = measure_meshes(bag, problem, solution)
    rows = measure_rows(bag, problem, solution, meshes)
    theta = off_axis if upstream else np.pi - off_axis
    found = np.concatenate([meshes.pressure_pa[bag.mesh_row < bag.bands - 1], rows.pressure_pa[1:-2]])
    assert found / catch.stagnation_pressure == pytest.approx(1.0 + theta, abs=1e-12)
