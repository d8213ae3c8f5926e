"""The tangent of each load alone, and of all together, against complex steps of the same forces in plain numpy."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catch_models.pressure import sphere_law
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.mechanics import bending, catch_weight, drag, loads, newton_state, newton_step, points, pressure, seabed
from codend.mechanics.bars import add_bar_forces, add_bar_tangent, bar_lengths, carried
from codend.mechanics.catch_front import fill, front_band, load_by_share, share_gradient
from codend.mechanics.inertia import Inertia
from codend.mechanics.problem import Problem
from codend.mechanics.structure import Structure, structure_of
from codend.mechanics.tangent import Pattern, pattern_of
from codend.mechanics.water import Water, uniform_flow
from codend.net.net import Floats, Net, bar_vectors
from tests import complex_loads
from tests.complex_loads import derivative
from tests.plans import UNIFORM, make_plan

MESHES = ["diamond", "knotted", "t90", "square"]
COLUMNS = [1, 2, None]
LAWS = ["le-bris-1999", "bessonneau-1997", "choo-casarella-1971"]
MESHES_FILLED, PLANE, VOLUME = {"filled_meshes": 2.3}, {"front_from_codline_m": 0.3}, {"volume_m3": 1.5e-3}
HEAVY = {"density_kg_m3": 1300.0}
ROUND_OFF = 1e-11
AT_REST = np.zeros((0, 3))
ROUND_OFF_OF_PRESSURE = 1e-13
"""Its angle is not told by a cosine, which loses digits where it is nearly 1, as that of bending is."""


def distorted(
    mesh: str, sectors: int | None, *, catch: dict | None = None, law: str = LAWS[0], shake: float = 0.01, seed: int = 7
) -> Problem:
    """A small elastic net away from its built shape, every other bar slack, stiff in bending where that has a place."""
    netting = {"twine_mm": 4.0, "axial_stiffness_n": 50.0, "knot_mm": 20.0 if mesh in {"knotted", "t90"} else 0.0}
    if mesh != "square":
        netting["bending_stiffness_n_m2"] = 1e-3
    plan = make_plan(
        6,
        4,
        0.4,
        mesh="diamond" if mesh == "knotted" else mesh,
        bar_mm=100.0,
        netting=netting,
        catch=catch or {"filled_meshes": 2.3},
        drag={"law": law, "tangential": 0.1},
        speed=1.3,
    )
    bag = build_bag(plan, sectors=sectors)
    net = bag.net
    rng = np.random.default_rng(seed)
    positions = net.positions + shake * rng.normal(size=net.positions.shape)
    bars = np.arange(len(net.bars))
    length = np.linalg.norm(bar_vectors(net, positions), axis=1)
    net = replace(
        net,
        positions=positions,
        bar_length=length * np.where(bars % 2, 1.1, 0.9) * rng.uniform(0.95, 1.05, len(bars)),
        bar_flexibility=rng.uniform(0.01, 0.1, len(bars)),
    )
    return problem_of(replace(bag, net=net), plan, plan.cases()[0])


def shares(problem: Problem) -> Floats:
    share = np.zeros(problem.bands)
    fill(problem.net.positions, problem.structure, problem.loading.catch, share)
    return share


def laid_out(structure: Structure) -> tuple[Pattern, Floats]:
    pattern = pattern_of(structure)
    return pattern, np.zeros((len(pattern.row), 3, 3))


def dense(pattern: Pattern, blocks: Floats, nodes: int) -> Floats:
    matrix = np.zeros((nodes, 3, nodes, 3))
    for row, column, block in zip(pattern.row, pattern.column, blocks, strict=True):
        matrix[row, :, column] += block
    return matrix.reshape(3 * nodes, 3 * nodes)


def assert_same(found: Floats, expected: Floats, round_off: float = ROUND_OFF) -> None:
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=round_off * np.abs(expected).max())


def check(problem: Problem, kernel, tangent, plain, round_off: float = ROUND_OFF) -> None:  # type: ignore[no-untyped-def]
    """The kernel's forces are the plain ones, and its tangent is minus their derivative."""
    position = problem.net.positions
    force = np.zeros_like(position)
    kernel(position, force)
    assert_same(force, plain(position).real, round_off)
    pattern, blocks = laid_out(problem.structure)
    tangent(position, pattern, blocks)
    assert_same(dense(pattern, blocks, len(position)), -derivative(plain, position), round_off)


def check_bars(problem: Problem) -> None:
    net, structure = problem.net, problem.structure
    length = np.zeros(len(net.bars))
    bar_lengths(net.positions, structure, length)
    taut = (length > net.bar_length) | net.bar_is_strut
    density = np.where(taut, (1.0 / net.bar_length - 1.0 / length) / net.bar_flexibility, 0.0)
    hardening = np.where(taut, 1.0 / (net.bar_flexibility * length**3), 0.0)
    check(
        problem,
        lambda at, force: add_bar_forces(at, structure, density, force),
        lambda at, pattern, blocks: add_bar_tangent(at, structure, pattern, density, hardening, blocks),
        lambda at: complex_loads.elastic_pull(net, at),
    )


def check_drag(problem: Problem) -> None:
    structure, loading, share = problem.structure, problem.loading, shares(problem)
    check(
        problem,
        lambda at, force: drag.add_force(at, AT_REST, structure, loading.water, loading.catch, share, force),
        lambda at, pattern, blocks: drag.add_tangent(
            at, AT_REST, 0.0, structure, loading.water, loading.catch, pattern, share, blocks
        ),
        lambda at: complex_loads.twine_drag(problem, at, share),
    )


def check_pressure(problem: Problem) -> None:
    structure, loading, share = problem.structure, problem.loading, shares(problem)
    check(
        problem,
        lambda at, force: pressure.add_force(at, structure, loading.catch, share, force),
        lambda at, pattern, blocks: pressure.add_tangent(at, structure, loading.catch, pattern, share, blocks),
        lambda at: complex_loads.catch_pressure(problem, at, share),
        ROUND_OFF_OF_PRESSURE,
    )


def check_catch_weight(problem: Problem) -> None:
    """With the front where it is; its height and the parts of what its rings bear add a product each."""
    structure, catch, share = problem.structure, problem.loading.catch, shares(problem)
    position = problem.net.positions
    pattern = pattern_of(structure)
    force, blocks = np.zeros_like(position), np.zeros((len(pattern.row), 3, 3))
    catch_weight.add_force(position, structure, catch, share, force)
    assert_same(force, complex_loads.catch_weight(problem, position, share).real)
    catch_weight.add_tangent(position, structure, catch, pattern, share, blocks)
    by_height, gradient = np.zeros_like(position), np.zeros_like(position)
    catch_weight.force_by_height(position, structure, catch, share, by_height)
    catch_weight.height_gradient(catch, share, gradient)
    found = dense(pattern, blocks, len(position)) - np.outer(by_height.ravel(), gradient.ravel())
    gradients, borne = np.zeros((3, *position.shape)), np.zeros((3, *position.shape))
    catch_weight.rings_gradient(position, structure, catch, share, gradients)
    for i, way in enumerate(np.eye(3)):
        catch_weight.add_to_rings(catch, share, tuple(way), borne[i])
        found -= np.outer(borne[i].ravel(), gradients[i].ravel())
    assert_same(found, -derivative(lambda at: complex_loads.catch_weight(problem, at, share), position))


def check_bending(problem: Problem) -> None:
    net, structure = problem.net, problem.structure
    check(
        problem,
        lambda at, force: bending.add_force(at, structure, force),
        lambda at, pattern, blocks: bending.add_tangent(at, structure, pattern, blocks),
        lambda at: complex_loads.bending_resistance(net, at),
    )


@pytest.mark.parametrize("sectors", COLUMNS)
@pytest.mark.parametrize("mesh", MESHES)
def test_tangent_of_taut_and_slack_elastic_bars_is_the_derivative_of_their_pull(mesh, sectors):
    check_bars(distorted(mesh, sectors))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("sectors", COLUMNS)
@pytest.mark.parametrize("mesh", ["diamond", "t90"])
def test_tangent_of_the_drag_is_its_derivative_at_given_shares(mesh, sectors, law):
    check_drag(distorted(mesh, sectors, law=law))


@pytest.mark.parametrize("law", LAWS)
def test_tangent_of_the_drag_of_taut_and_slack_ropes_is_its_derivative(law):
    problem = distorted("diamond", 2, law=law)
    net = replace(problem.net, bar_is_rope=np.arange(len(problem.net.bars)) % 3 == 0)
    check_drag(replace(problem, net=net, structure=structure_of(net)))


@pytest.mark.parametrize("catch", [{}, UNIFORM], ids=["sphere", "uniform"])
@pytest.mark.parametrize("sectors", COLUMNS)
@pytest.mark.parametrize("mesh", MESHES)
def test_tangent_of_the_pressure_is_its_derivative_at_given_shares(mesh, sectors, catch):
    check_pressure(distorted(mesh, sectors, catch={"filled_meshes": 2.3, **catch}))


@pytest.mark.parametrize("filled", [2.3, 4.0])
@pytest.mark.parametrize("mesh", MESHES)
def test_tangent_of_the_catchs_weight_is_its_derivative_at_given_shares(mesh, filled):
    check_catch_weight(distorted(mesh, None, catch={"filled_meshes": filled, "density_kg_m3": 1300.0}))


@pytest.mark.parametrize("sectors", COLUMNS)
@pytest.mark.parametrize("mesh", ["diamond", "knotted", "t90"])
def test_tangent_of_stiff_twine_is_the_derivative_of_its_resistance(mesh, sectors):
    check_bending(distorted(mesh, sectors))


@settings(max_examples=12)
@given(
    st.sampled_from(MESHES),
    st.sampled_from(COLUMNS[:2]),
    st.sampled_from(LAWS),
    st.floats(0.3, 4.0),
    st.floats(0.002, 0.03),
    st.integers(0, 2**32 - 1),
)
def test_tangents_are_the_derivatives_on_random_nets(mesh, sectors, law, filled, shake, seed):
    problem = distorted(mesh, sectors, catch={"filled_meshes": filled}, law=law, shake=shake, seed=seed)
    check_bars(problem)
    check_drag(problem)
    check_pressure(problem)
    if mesh != "square":
        check_bending(problem)


@pytest.mark.parametrize("sectors", COLUMNS)
@pytest.mark.parametrize("mesh", ["diamond", "knotted", "t90"])
@pytest.mark.parametrize("catch", [PLANE, VOLUME], ids=["plane", "volume"])
def test_the_share_of_the_fronts_band_follows_the_net_by_its_gradient(mesh, sectors, catch):
    problem = distorted(mesh, sectors, catch=catch, shake=0.003)
    net, share = problem.net, shares(problem)
    band = front_band(problem.loading.catch, share)
    assert 0 < band < problem.bands - 1
    np.testing.assert_allclose(share, complex_loads.shares(problem, net.positions).real, rtol=0.0, atol=1e-12)
    gradient = np.zeros_like(net.positions)
    share_gradient(net.positions, problem.structure, problem.loading.catch, share, band, gradient)
    by_node = derivative(lambda at: complex_loads.shares(problem, at)[band], net.positions)
    assert_same(gradient.ravel(), by_node[0])


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(
    ("catch", "sectors", "sides"),
    [
        pytest.param(catch | weight, sectors, sides, id=f"{name} {sectors or 'full'}{' heavy' if weight else ''}")
        for name, catch, moving in (("meshes", MESHES_FILLED, 0), ("plane", PLANE, 1), ("volume", VOLUME, 1))
        for sectors, weight in [*((sectors, {}) for sectors in COLUMNS), (1, HEAVY), (None, HEAVY)]
        for sides in [1 + moving + 4 * int(bool(weight) and sectors is None)]
    ],
)
def test_newtons_linearisation_is_the_derivative_of_all_that_is_out_of_balance(mesh, sectors, catch, sides):
    """Of elastic nets, their force densities eliminated; what moves with the front adds products of two vectors."""
    check_linearisation(distorted(mesh, sectors, catch=catch, shake=0.003), sides)


@pytest.mark.parametrize("sectors", COLUMNS)
@pytest.mark.parametrize("mesh", ["knotted", "t90"])
def test_newtons_linearisation_is_that_of_struts_that_are_pushed(mesh, sectors):
    problem = distorted(mesh, sectors, shake=0.003)
    struts = np.arange(len(problem.net.bars)) % 4 < 2  # half of them shorter than without load
    net = replace(problem.net, bar_is_strut=struts)
    check_bars(replace(problem, net=net, structure=structure_of(net)))
    check_linearisation(replace(problem, net=net, structure=structure_of(net)), 1)


def check_linearisation(problem: Problem, sides: int) -> None:
    net, structure, loading, position = problem.net, problem.structure, problem.loading, problem.net.positions
    pattern = pattern_of(structure)
    state, step = newton_state.empty_state(structure, problem.bands), newton_step.empty_step(structure, pattern)
    state.position[:] = position
    bar_lengths(position, structure, state.length)
    stretch = 1.0 / net.bar_length - 1.0 / state.length
    state.density[:] = carried(structure.is_strut, stretch) / net.bar_flexibility
    newton_state.measure(structure, loading, 1.0, 1.0, 0.0, state)
    assert sides == newton_step.linearise(structure, loading, pattern, 1.0, 0.0, state, step)

    def out_of_balance(at):
        share = complex_loads.shares(problem, at)
        outside = complex_loads.twine_drag(problem, at, share) + complex_loads.catch_pressure(problem, at, share)
        outside += complex_loads.catch_weight(problem, at, share)
        return outside + complex_loads.elastic_pull(net, at) + complex_loads.bending_resistance(net, at)

    assert_same(state.force, out_of_balance(position).real)
    found = dense(pattern, step.blocks, len(position))
    band = front_band(loading.catch, state.share)
    if band >= 0:
        load = np.zeros_like(position)
        load_by_share(position, structure, loading.water, loading.catch, state.share, band, load)
        assert_same(step.right[1], load)
    for load, gradient in zip(step.right[1:sides], step.gradient[: sides - 1], strict=True):
        found -= np.outer(load.ravel(), gradient.ravel())
    assert_same(found, -derivative(out_of_balance, position))


def test_filled_meshes_leave_the_shares_where_they_are():
    problem = distorted("diamond", 1)
    assert front_band(problem.loading.catch, shares(problem)) == -1


@pytest.mark.parametrize("turn", [0.0, np.pi])
def test_pressure_tangent_is_finite_on_facets_square_to_the_flow(turn):
    problem = distorted("diamond", None, shake=0.0)
    structure = structure_of(problem.net)
    flat = problem.net.positions.copy()
    flat[:, 0] = 0.0
    flat[:, 1] *= np.cos(turn)
    whole = np.ones(problem.bands)
    pattern, blocks = laid_out(structure)
    pressure.add_tangent(flat, structure, problem.loading.catch, pattern, whole, blocks)
    assert np.all(np.isfinite(blocks))
    # just off the axis of the flow the derivative is as large, and differs by the order of the law's slope there
    near = np.zeros_like(blocks)
    shaken = flat + 1e-9 * np.random.default_rng(1).normal(size=flat.shape)
    pressure.add_tangent(shaken, structure, problem.loading.catch, pattern, whole, near)
    slope = np.abs(sphere_law().derivative([0.0, np.pi])).max()
    assert np.abs(near - blocks).max() <= 5.0 * slope * np.abs(blocks).max()


@pytest.mark.parametrize("turn", [0.0, np.pi])
@pytest.mark.parametrize("shake", [1e-5, 1e-6, 1e-7])
def test_pressure_and_its_tangent_hold_to_round_off_next_to_the_axis_of_the_flow(turn, shake):
    """Under a law with a slope there, which an angle told by its cosine would get wrong by 1e-16 / angle."""
    problem = distorted("diamond", None, catch={"filled_meshes": 4.0}, shake=0.0)
    positions = problem.net.positions.copy()
    positions[:, 0] = 0.0
    positions[:, 1] *= np.cos(turn)
    positions += shake * np.random.default_rng(1).normal(size=positions.shape)
    net = replace(problem.net, positions=positions)
    sloping = problem.loading.catch._replace(
        angles=np.array([0.0, np.pi]), coefficients=np.array([[0.0], [0.0], [1.0], [1.0]])
    )
    loading = problem.loading._replace(catch=sloping)
    check_pressure(replace(problem, net=net, structure=structure_of(net), loading=loading))


def full_net_in(height: list[float], flow: list[list[float]], law: str) -> Problem:
    """A full net, half of its bars ropes, in water that flows in any direction, and differently at other heights."""
    problem = distorted("diamond", None, law=law)
    ropes = np.arange(len(problem.net.bars)) % 2 == 0
    points = {
        "point_node": np.array([3, 8], dtype=np.int32),
        "point_mass": np.zeros(2),
        "point_wet_weight": np.array([5.0, -2.0]),
        "point_drag_area": np.array([0.3, 0.1]),
        "point_lift_area": np.array([0.2, 0.0]),
        "point_lift_towards": np.array([[0.1, 1.0, 0.4], [0.0, 0.0, 1.0]]),
    }
    net = replace(problem.net, bar_is_rope=ropes, **points)
    water = Water(1000.0, 1e-6, np.array(height), np.array(flow))
    return Problem.of(net, water=water, catch=problem.loading.catch)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(
    ("height", "flow"),
    [([0.0], [[0.4, -0.9, 0.6]]), ([-0.05, 0.02, 0.1], [[1.0, 0.2, 0.0], [0.6, -0.3, 0.1], [1.4, 0.1, -0.4]])],
    ids=["any direction", "a profile"],
)
def test_drag_and_its_tangent_in_any_flow(law, height, flow):
    check_drag(full_net_in(height, flow, law))


@pytest.mark.parametrize("law", LAWS)
def test_the_tangent_of_all_loads_in_a_profile_is_their_derivative_by_central_differences(law):
    """Drag and lift of points among them."""
    check_by_differences(full_net_in([-0.05, 0.1], [[1.0, 0.2, 0.0], [0.6, -0.3, 0.1]], law))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("sectors", COLUMNS)
def test_the_tangent_of_all_loads_on_a_net_in_motion_is_their_derivative_by_central_differences(sectors, law):
    """Within the catch, where the water goes with the net, and ahead of it."""
    problem, rng = distorted("t90", sectors, law=law), np.random.default_rng(3)
    nodes = problem.net.positions.shape
    root = rng.normal(size=(len(problem.net.positions), 3, 3))
    origin = problem.net.positions - 0.05 * rng.normal(size=nodes)
    moving = Inertia(12.0, np.einsum("nij,nkj->nik", root, root), origin, rng.normal(size=nodes))
    check_by_differences(replace(problem, loading=problem.loading._replace(inertia=moving)))


def check_by_differences(problem: Problem) -> None:
    structure, loading, share, position = problem.structure, problem.loading, shares(problem), problem.net.positions
    pattern, blocks = laid_out(structure)
    loads.add_tangent(position, structure, loading, pattern, share, blocks)
    differences = np.empty((position.size, position.size))
    step = 1e-6
    for place in range(position.size):
        forces = []
        for sign in (1.0, -1.0):
            moved, force = position.copy(), np.zeros_like(position)
            moved.reshape(-1)[place] += sign * step
            loads.add_force(moved, structure, loading, share, force)
            forces.append(force.ravel())
        differences[:, place] = (forces[1] - forces[0]) / (2.0 * step)
    assert_same(dense(pattern, blocks, len(position)), differences, 1e-7)


def test_a_point_is_dragged_along_the_flow_and_lifted_across_it():
    net = full_net_in([0.0], [[0.0, 2.0, 0.0]], LAWS[0]).net
    force = np.zeros_like(net.positions)
    water = uniform_flow(1000.0, np.array([0.0, 2.0, 0.0]))
    points.add_force(net.positions, AT_REST, points.points_of(net), water, force)
    assert force[8] == pytest.approx([0.0, 200.0, 0.0])
    assert force[3] == pytest.approx([400.0 * 0.1 / np.hypot(0.1, 0.4), 600.0, 400.0 * 0.4 / np.hypot(0.1, 0.4)])
    dead = Problem.of(net, water=water).loading.dead
    without = Problem.of(replace(net, point_wet_weight=np.zeros(2)), water=water).loading.dead
    assert (dead - without)[[3, 8], 2] == pytest.approx([-5.0, 2.0])


def test_a_seabed_pushes_what_lies_below_it_by_its_tangent():
    nodes = np.array([[0.0, 0, 0.5], [1.0, 0, -0.2], [2.0, 0, -0.4]])
    net = Net.from_bars(nodes, [[0, 1], [1, 2]], [True, False, False])
    bed = seabed.Seabed(-0.1, np.array([5.0, 7.0, 11.0]))
    force, (pattern, blocks) = np.zeros((3, 3)), laid_out(Problem.of(net).structure)
    seabed.add_force(nodes, bed, force)
    seabed.add_tangent(nodes, bed, pattern, blocks)
    assert force[:, 2] == pytest.approx([0.0, 0.7, 3.3])
    assert blocks[pattern.diagonal, 2, 2] == pytest.approx([0.0, 7.0, 11.0])
