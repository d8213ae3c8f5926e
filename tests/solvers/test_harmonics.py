"""Which harmonics grow, against the dense tangent of whole nets, theory, and shapes that are known to be stable."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catch_models.pressure import uniform_law
from codend.bag.loads import problem_of
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.start_shapes import all_round_start
from codend.mechanics import bending, pressure
from codend.mechanics.bars import add_bar_tangent
from codend.mechanics.loads import add_tangent
from codend.mechanics.problem import Problem
from codend.mechanics.tangent import Pattern, pattern_of
from codend.plan.plan import Plan, plan_from_dict
from codend.solvers.harmonic_tangent import HarmonicTangent
from codend.solvers.harmonics import Harmonics, growing_harmonics, harmonics_of, negative_pivots
from codend.solvers.outcome import Solution
from codend.solvers.ring import NEUTRAL, Ring
from tests import complex_loads
from tests.plans import joined_plan, make_plan

KNOTTED = {"knot_mm": 6.0, "twine_mm": 3.0}
STIFF = {"axial_stiffness_n": 2000.0, "bending_stiffness_n_m2": 2e-3, "knot_mm": 5.0}


def solved(plan: Plan) -> tuple[Problem, Solution]:
    """Equilibrium of the narrowest sector."""
    finely = plan.model_copy(update={"model": plan.model.model_copy(update={"tolerance": 1e-9})})
    scene = model_of(finely, 1, 1)
    problem, solution = equilibrium.solve(scene, plan.cases()[0], (), None)
    assert solution.report.outcome.converged
    return problem, solution


def asked(plan: Plan, abreast: int = 1) -> Harmonics:
    """The harmonics of that equilibrium, of so many such sectors as one."""
    problem, solution = solved(plan)
    if abreast > 1:
        narrow = model_of(plan, 1, 1).bag
        solution = all_round_start(narrow, solution.positions, solution.bar_tension, abreast)
        problem = problem_of(model_of(plan, 1, abreast).bag, plan, plan.cases()[0])
    harmonics = harmonics_of(problem, solution, Ring(problem.structure, problem.bands))
    assert harmonics.undecided == ()
    return harmonics


def growing(plan: Plan) -> list[int]:
    return [growth.harmonic for growth in asked(plan).growing]


def directions_of_whole_net(plan: Plan) -> int:
    """Growing eigenvalues of the whole net, its codline free, by complex steps on loads written for the tests.

    Taut inextensible bars keep their force densities and hold their lengths: the tangent counts on the moves that do.
    """
    _, solution = solved(plan)
    bag = model_of(plan, 1, None).bag
    net = bag.net
    narrow = model_of(plan, 1, 1).bag
    start = all_round_start(narrow, solution.positions, solution.bar_tension, narrow.net.order)
    problem = problem_of(bag, plan, plan.cases()[0])
    flexibility = np.where(net.bar_flexibility > 0.0, net.bar_flexibility, 1.0)
    own_length = complex_loads.norm(complex_loads.vectors(net, start.positions))
    held = start.bar_tension / own_length

    def forces(position: np.ndarray) -> np.ndarray:
        vector = complex_loads.vectors(net, position)
        length = complex_loads.norm(vector)
        elastic = (length / net.bar_length - 1.0) / flexibility / length
        density = np.where(held == 0.0, 0.0, np.where(net.bar_flexibility > 0.0, elastic, held))
        force = complex_loads.on_both_ends(net, density[:, None] * vector, -density[:, None] * vector)
        share = complex_loads.shares(problem, position)
        force += complex_loads.twine_drag(problem, position, share)
        force += complex_loads.catch_pressure(problem, position, share)
        return force + complex_loads.bending_resistance(net, position) if len(net.corners) else force

    def strains(position: np.ndarray) -> np.ndarray:
        length = complex_loads.norm(complex_loads.vectors(net, position))
        return length[(net.bar_flexibility == 0.0) & (held > 0.0)]

    fixed = net.fixed.copy()
    fixed[-1] = False
    free = np.flatnonzero(~fixed.ravel())
    assert np.abs(forces(start.positions)[~fixed]).max() < 1e-6 * start.bar_tension.max()
    tangent = -complex_loads.derivative(forces, start.positions)[np.ix_(free, free)]
    if len(strains(start.positions)):
        _, sizes, rows = np.linalg.svd(complex_loads.derivative(strains, start.positions)[:, free])
        keeps = rows[np.count_nonzero(sizes > 1e-9 * sizes[0]) :].T
        tangent = keeps.T @ tangent @ keeps
    eigenvalues = np.linalg.eigvals(tangent).real
    neutral = NEUTRAL * start.bar_tension.mean() / net.bar_length.min()
    return int(np.count_nonzero(eigenvalues < -neutral))


@pytest.mark.parametrize(
    ("plan", "abreast"),
    [
        (make_plan(10, 6, 0.35, 3.0), 1),
        (make_plan(8, 6, 0.3, 2.0, netting=STIFF), 1),
        (make_plan(9, 6, 0.2, 2.5, netting=STIFF | {"bending_stiffness_n_m2": 1e-2}), 1),
        (make_plan(8, 5, 0.25, 1.5, mesh="t90", netting=KNOTTED), 1),
        (make_plan(12, 6, 0.6, 0.6, mesh="t90", netting={"knot_mm": 15.0, "twine_mm": 3.0}), 1),
        (make_plan(10, 6, 0.35, catch={"volume_m3": 0.001}, netting=STIFF | {"bending_stiffness_n_m2": 1e-3}), 1),
        (make_plan(9, 5, 0.25, mesh="t90", netting=KNOTTED, catch={"front_from_codline_m": 0.12}), 1),
        (make_plan(12, 6, 0.7, 1.2, mesh="square"), 1),
        (make_plan(8, 6, 0.3, 2.0, netting=STIFF), 4),
        (joined_plan(("diamond", 12, 3, 40.0, {}), ("diamond", 8, 4, 40.0, {}), catch={"filled_meshes": 2.0}), 1),
    ],
)
def test_growing_eigenvalues_of_all_harmonics_are_those_of_the_whole_net(plan, abreast):
    assert asked(plan, abreast).directions == directions_of_whole_net(plan)


def small(mesh: str, bar_mm: float, meshes_round: int, radius: float, filled: float, **netting: float) -> Plan:
    section = {"mesh": mesh, "meshes_round": meshes_round, "meshes_long": 20, "bar_mm": bar_mm, **netting}
    return plan_from_dict(
        {
            "title": "small",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1000.0 if mesh == "diamond" else 1025.0},
            "entry": {"radius_m": radius},
            "netting": [section],
            "catch": {"filled_meshes": filled},
        }
    )


def test_the_two_small_plans_whose_dense_tangents_are_known():
    """Growing eigenvalues of the full nets of 5691 and 5619 unknowns: 21 and 7."""
    stiff = {"knot_mm": 5.0, "axial_stiffness_n": 5000.0, "bending_stiffness_n_m2": 1e-3, "twine_mm": 1.0, "twines": 2}
    harmonics = asked(small("diamond", 25.0, 24, 0.07, 6.0, **stiff))
    assert harmonics.directions == 21
    assert [growth.harmonic for growth in harmonics.growing] == list(range(2, 13))
    harmonics = asked(small("t90", 40.0, 24, 0.12, 1.5, twine_mm=3.0, knot_mm=8.0))
    assert harmonics.directions == 7
    assert [growth.harmonic for growth in harmonics.growing] == [9, 10, 11, 12]


def commercial(mesh: str, meshes_round: int, bending: float, catch_kg: float) -> Plan:
    """120 mm full mesh with knots of 15 mm, double 4 mm twine of EA 2 kN."""
    section = {"mesh": mesh, "meshes_round": meshes_round, "meshes_long": 50, "bar_mm": 45.0, "knot_mm": 15.0}
    section |= {"twine_mm": 4.0, "twines": 2, "axial_stiffness_n": 2000.0, "bending_stiffness_n_m2": bending}
    return plan_from_dict(
        {
            "title": "commercial",
            "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": 0.4},
            "netting": [section],
            "catch": {"mass_kg": catch_kg},
        }
    )


@pytest.mark.parametrize(
    ("plan", "first"),
    [
        (commercial("diamond", 100, 2e-3, 300.0), 16),
        (commercial("diamond", 100, 2e-3, 1500.0), 27),
        (commercial("diamond", 100, 5e-4, 50.0), 21),
        (commercial("t90", 100, 0.0, 50.0), 3),
        (commercial("t90", 50, 0.0, 50.0), 6),
    ],
)
def test_commercial_codends_of_stiff_or_turned_netting_grow_from_a_harmonic_on(plan, first):
    (section,) = plan.netting
    assert growing(plan) == list(range(first, section.meshes_round // 2 + 1))


def test_harmonics_of_stiff_turned_netting_beside_a_cluster_at_0_ask_no_dense_matrix(monkeypatch):
    problem, solution = solved(commercial("t90", 100, 5e-4, 50.0))
    ring = Ring(problem.structure, problem.bands)
    with monkeypatch.context() as without:
        without.setattr(HarmonicTangent, "dense", lambda tangent: pytest.fail("a dense matrix was asked for"))
        harmonics = harmonics_of(problem, solution, ring)
    assert harmonics.undecided == ()
    found = {growth.harmonic: growth.eigenvalues for growth in harmonics.growing}
    for k in (2, 3, 12, 41):
        dense = np.sort(np.linalg.eigvals(ring.tangent(k).dense()).real)
        # inextensible bars of 1e10 N/m leave 1e-6 of that by round-off
        np.testing.assert_allclose(np.sort(found.get(k, np.zeros(0)).real), dense[dense < 0.0], 1e-5, 1e-5)


@pytest.mark.parametrize("filled", [0.3, 1.0, 3.0, 8.0, 14.0, 20.0])
def test_limp_diamond_netting_is_stable_at_any_catch(filled):
    assert growing(make_plan(24, 20, 0.35, filled)) == []
    assert growing(make_plan(25, 20, 0.35, filled, netting={"knot_mm": 5.0})) == []


def ring_of_beam(inside_pa: float, order: int = 48) -> Ring:
    """Tangent of a ring of radius 1 m, width 1 m and EI 1 N m2, under pressure from inside: two hoops and a skin.

    Each hoop is a polygon of one node a sector that is at rest as it stands, stiff in length, held along the axis and
    tied to the other.
    """
    turn = 2.0 * np.pi / order
    side, spare = 2.0 * np.sin(0.5 * turn), spare_problem()
    facets = np.array([[0, 0, 1], [0, 1, 1], [0, 0, 1], [0, 1, 1]])
    images = np.array([[0, 1, 1], [0, 1, 0], [0, 1, 0], [1, 1, 0]])
    structure = spare.structure._replace(
        first=np.array([0, 1], dtype=np.int32),
        second=np.array([0, 1], dtype=np.int32),
        image=np.ones(2, dtype=np.int32),
        rotations=np.array([[np.cos(k * turn), np.sin(k * turn)] for k in (-1, 0, 1)]),
        length=np.full(2, side),
        facets=facets.astype(np.int32),
        facet_image=images.astype(np.int32),
        facet_weight=np.full(4, 0.5),
        corners=np.array([[0, 0, 0], [1, 1, 1]], dtype=np.int32),
        corner_image=np.array([[0, -1, 1], [0, -1, 1]], dtype=np.int32),
        # k / 4 (psi - psi0)^2 / 2 is EI / side times the same, EI half the beam's
        corner_stiffness=np.full(2, 4.0 * 0.5 / side),
        corner_rest=np.full(2, np.pi - turn),
        free=np.array([[0.0, 1.0, 1.0], [0.0, 1.0, 1.0]]),
        order=float(order),
    )
    ring = Ring(structure, 1)
    position = np.array([[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    tension = 0.5 * inside_pa * side * np.cos(0.5 * turn) / (2.0 * np.sin(0.5 * turn))
    law = uniform_law(1.0)
    catch = spare.loading.catch._replace(
        facet_band=np.zeros(4, dtype=np.int32),
        stagnation_pressure=inside_pa,
        angles=law.angles_rad,
        coefficients=np.ascontiguousarray(law.coefficients),
    )
    blocks = ring.step.blocks
    blocks[:] = 0.0
    add_bar_tangent(position, structure, ring.pattern, np.full(2, tension / side), np.full(2, 1e6 / side**3), blocks)
    bending.add_tangent(position, structure, ring.pattern, blocks)
    pressure.add_tangent(position, structure, catch, ring.pattern, np.ones(1), blocks)
    # the hoops move alike, and what moves for nothing, as the whole ring does, is to be stable
    alike = ring.pattern.image == 0
    unlike = np.where(ring.pattern.row == ring.pattern.column, 1.0, -1.0)
    blocks[alike] += 1e6 * unlike[alike, None, None] * np.eye(3)
    blocks[ring.pattern.diagonal] += 1e-6 * np.eye(3)
    ring.gather(False)
    return ring


def spare_problem() -> Problem:
    plan = make_plan(8, 5, filled=2.0)
    return problem_of(model_of(plan, 1, 1).bag, plan, plan.cases()[0])


def test_a_ring_under_suction_buckles_into_an_oval_at_the_pressure_of_theory():
    """p = 3 EI / r^3 under pressure that stays normal to the ring, k = 2 (Timoshenko and Gere 1961, 7.3)."""
    assert growing_harmonics(ring_of_beam(-2.98), 1.0).growing == ()
    oval = growing_harmonics(ring_of_beam(-3.02), 1.0).growing
    assert [growth.harmonic for growth in oval] == [2]
    # y outward, z along the ring: an inextensible oval moves half as far along as outward
    shape = oval[0].shape
    np.testing.assert_allclose(np.abs(shape[:, 2] / shape[:, 1]), 0.5, atol=5e-3)


@st.composite
def disturbed_rings(draw):
    """A sector of a small plan, its knots moved and its bars pulled at random: the ring, unloaded and loaded."""
    mesh = draw(st.sampled_from(["diamond", "t90", "square"]))
    netting = {"knot_mm": draw(st.sampled_from([0.0, 6.0])), "axial_stiffness_n": 300.0} if mesh != "square" else {}
    if mesh != "square":
        netting["bending_stiffness_n_m2"] = draw(st.sampled_from([0.0, 1e-3]))
    plan = make_plan(draw(st.integers(2, 4)) * 3, draw(st.integers(4, 6)), mesh=mesh, filled=2.5, netting=netting)
    bag = model_of(plan, 1, draw(st.sampled_from([1, 3]))).bag
    net, problem = bag.net, problem_of(bag, plan, plan.cases()[0])
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    position = net.positions + rng.normal(0.0, 0.004, net.positions.shape) * ~net.fixed
    pulls = rng.uniform(0.0, 10.0, len(net.bars)), rng.uniform(0.0, 1e4, len(net.bars))
    share = rng.uniform(0.0, 1.0, bag.bands)

    def ring(loaded: bool) -> Ring:
        ring = Ring(problem.structure, problem.bands)
        arguments = (position, problem.structure, ring.pattern)
        ring.step.blocks[:] = 0.0
        add_bar_tangent(*arguments, *pulls, ring.step.blocks)
        if not loaded:
            bending.add_tangent(*arguments, ring.step.blocks)
        else:
            structure, loading = problem.structure, problem.loading
            add_tangent(position, structure, loading, ring.pattern, share, ring.step.blocks)
        ring.gather(False)
        return ring

    return ring


@given(disturbed_rings())
@settings(max_examples=25, deadline=None)
def test_twine_alone_has_hermitian_tangents_and_harmonics_k_and_n_less_k_conjugate_ones(ring):
    ring = ring(loaded=False)
    for k in range(ring.order // 2 + 1):
        whole = ring.tangent(k).dense()
        np.testing.assert_allclose(whole, whole.conj().T, atol=1e-9 * np.abs(whole).max())
        if 1 < k < ring.order - 1:
            np.testing.assert_allclose(
                ring.tangent(ring.order - k).dense(), whole.conj(), atol=1e-12 * np.abs(whole).max()
            )


@given(disturbed_rings())
@settings(max_examples=25, deadline=None)
def test_negative_pivots_are_as_many_as_negative_eigenvalues_of_the_hermitian_part(ring):
    ring = ring(loaded=True)
    asked = np.arange(ring.order // 2 + 1)
    wholes = [ring.tangent(k).dense() for k in asked]
    eigenvalues = [np.linalg.eigvalsh(0.5 * (whole + whole.conj().T)) for whole in wholes]
    for shift in (0.0, 40.0):
        expected = [np.count_nonzero(values < -shift) for values in eigenvalues]
        assert negative_pivots(ring, asked, np.full(len(asked), shift)).tolist() == expected


@pytest.mark.parametrize("sectors", [1, 2])
@pytest.mark.parametrize("mesh", ["diamond", "t90"])
def test_harmonic_0_is_the_tangent_of_newtons_method(mesh, sectors):
    """But for the codline, which in the whole net is one node where each sector has its own."""
    plan = make_plan(12, 6, 0.4, 2.5, mesh=mesh, netting=KNOTTED)
    scene = model_of(plan, 1, sectors)
    problem = problem_of(scene.bag, plan, plan.cases()[0])
    position, structure = problem.net.positions, problem.structure
    ring, share = Ring(structure, problem.bands), np.full(problem.bands, 0.4)

    def added_up(pattern: Pattern) -> np.ndarray:
        blocks = np.zeros((len(pattern.row), 3, 3))
        ones = np.ones(len(problem.net.bars))
        add_bar_tangent(position, structure, pattern, ones, 1e3 * ones, blocks)
        add_tangent(position, structure, problem.loading, pattern, share, blocks)
        return blocks

    pattern, size = pattern_of(structure), 3 * len(position)
    newtons = np.zeros((size // 3, 3, size // 3, 3))
    np.add.at(newtons, (pattern.row, slice(None), pattern.column), added_up(pattern))
    ring.step.blocks[:] = added_up(ring.pattern)
    ring.gather(False)
    places = np.append(np.where(structure.free > 0.0, ring.unknown, -1)[:-1].ravel(), [ring.size, -1, -1])
    free = np.flatnonzero(places >= 0)
    weight = np.where(free == size - 3, np.sqrt(ring.order), 1.0)
    expected = newtons.reshape(size, size)[np.ix_(free, free)] * np.outer(weight, weight)
    order = places[free]
    np.testing.assert_allclose(ring.tangent(0).dense()[np.ix_(order, order)], expected, atol=1e-9 * expected.max())
