"""Harmonics in real numbers against the same in complex ones: mirrored shapes, disturbed or not, and others."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codend.bag.loads import problem_of
from codend.bag.near_ratio import near_ratios
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import BagModel, model_of
from codend.mechanics.bars import add_bar_tangent
from codend.mechanics.loads import add_tangent
from codend.mechanics.problem import Problem
from codend.net.net import rotate
from codend.solvers import ring as rings
from codend.solvers.harmonics import growing_harmonics, harmonics_of, negative_pivots, stiffness_under_tension
from codend.solvers.outcome import Solution
from codend.solvers.ring import Ring
from codend.solvers.ring_images import Images, images_of
from tests.plans import joined_plan, make_plan

KNOTTED = {"knot_mm": 6.0, "twine_mm": 3.0}
STIFF = {"axial_stiffness_n": 2000.0, "bending_stiffness_n_m2": 1e-3, "knot_mm": 5.0}


def fraction_of_a_sector() -> BagModel:
    plan = joined_plan(("diamond", 29, 8, 20.0, {}), ("diamond", 20, 8, 24.0, {}), entry=0.055)
    near = next(near for near in near_ratios(plan) if near.columns == (3, 2))
    assert near.order != round(near.order)
    return model_of(plan, 1, 1, near=near)


JOINED = joined_plan(("diamond", 12, 3, 40.0, {}), ("diamond", 8, 4, 40.0, {}), catch={"filled_meshes": 2.0})
MODELS: dict[str, Callable[[], BagModel]] = {
    "diamond": lambda: model_of(make_plan(8, 5, 0.3, 2.0), 1, 1),
    "an odd number round": lambda: model_of(make_plan(9, 5, 0.3, 2.0, netting=KNOTTED), 1, 1),
    "square": lambda: model_of(make_plan(9, 6, 0.7, 1.2, mesh="square"), 1, 1),
    "t90": lambda: model_of(make_plan(8, 5, 0.25, 1.5, mesh="t90", netting=KNOTTED), 1, 1),
    "t90, three abreast": lambda: model_of(make_plan(9, 5, 0.25, 1.5, mesh="t90", netting=KNOTTED), 1, 3),
    "with a front": lambda: model_of(make_plan(10, 6, 0.35, catch={"volume_m3": 0.001}, netting=STIFF), 1, 1),
    "joined": lambda: model_of(JOINED, 1, 1),
    "merged meshes": lambda: model_of(make_plan(24, 12, 0.3, 4.0), 2, 1),
    "a fraction of a sector": fraction_of_a_sector,
}


def built(name: str) -> tuple[Problem, Images]:
    """The net as it is built, and which of its nodes are images of each other."""
    model = MODELS[name]()
    problem = problem_of(model.bag, model.plan, model.plan.cases()[0])
    on_axis = np.flatnonzero((problem.structure.free == [1.0, 0.0, 0.0]).all(axis=1)).astype(np.int32)
    images = images_of(problem.structure, on_axis)
    assert images is not None
    return problem, images


def solved(name: str) -> tuple[Problem, Solution]:
    model = MODELS[name]()
    return equilibrium.solve(model, model.plan.cases()[0], (), None)


@pytest.mark.parametrize("name", MODELS)
def test_images_are_those_of_the_net_as_it_is_built(name):
    problem, images = built(name)
    net = problem.net
    # the plane that the first node off the axis and its image tell
    azimuth = np.arctan2(net.positions[:, 2], net.positions[:, 1]) * net.order / (2.0 * np.pi)
    plane = 0.5 * (azimuth[0] + azimuth[images.node[0]] - images.middle[0])
    turned = rotate(net.positions, -(plane + 0.5 * images.middle), net.order)
    np.testing.assert_allclose(turned[images.node] * [1.0, 1.0, -1.0], turned, atol=1e-12)


def in_complex(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> Ring:
    with monkeypatch.context() as without:
        without.setattr(rings, "images_of", lambda *_: None)
        return Ring(problem.structure, problem.bands)


@pytest.mark.parametrize("name", MODELS)
def test_eigenvalues_of_every_harmonic_are_those_in_complex_numbers(name, monkeypatch):
    problem, solution = solved(name)
    ring, other = Ring(problem.structure, problem.bands), in_complex(problem, monkeypatch)
    for each in (ring, other):
        each.linearise(problem, solution)
    assert ring.mirrored is not None
    assert other.mirrored is None
    asked = np.arange(int(ring.order // 2) + 1)
    for k in asked:
        real, whole = ring.tangent(k).dense(), other.tangent(k).dense()
        assert not np.iscomplexobj(real)
        for one, two in (
            (real + real.T, whole + whole.conj().T),
            (1j * (real - real.T), 1j * (whole - whole.conj().T)),
        ):
            values = np.linalg.eigvalsh(two)
            np.testing.assert_allclose(np.linalg.eigvalsh(one), values, atol=1e-13 * np.abs(whole).max())
    size = np.abs(np.linalg.eigvalsh(real + real.T))
    for shift in (0.0, np.median(size), -0.1 * np.median(size), -np.median(size)):
        shifts = np.full(len(asked), shift)
        np.testing.assert_array_equal(negative_pivots(ring, asked, shifts), negative_pivots(other, asked, shifts))


@pytest.mark.parametrize("name", ["with a front", "t90", "t90, three abreast"])
def test_moves_of_an_eigenvector_solve_the_same_in_complex_numbers(name, monkeypatch):
    problem, solution = solved(name)
    ring, other = Ring(problem.structure, problem.bands), in_complex(problem, monkeypatch)
    for each in (ring, other):
        each.linearise(problem, solution)
    for k in range(int(ring.order // 2) + 1):
        values, vectors = np.linalg.eig(ring.tangent(k).dense())
        lowest = values.real.argmin()
        shape, free = ring.shape_of(vectors[:, lowest].astype(complex), k), other.unknown >= 0
        whole = other.tangent(k)
        vector = np.zeros(whole.size, dtype=complex)
        vector[other.unknown[free]] = shape[free]
        moves = other.axis_moves(k)
        if len(moves):
            vector[other.size :] = (shape[other.on_axis] @ moves.conj().T).ravel() / np.sum(np.abs(moves) ** 2)
        left = whole @ vector[:, None] - values[lowest] * vector[:, None]
        assert np.abs(left).max() < 1e-12 * np.abs(whole.dense()).max() * np.linalg.norm(vector)


@st.composite
def disturbed(draw):
    """A ring with its nodes moved, mirrored or not, at random and bars pulled at random: the tangent and who is."""
    name, mirrored = draw(st.sampled_from(sorted(MODELS))), draw(st.booleans())
    problem, images = built(name)
    net, rng = problem.net, np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    off_axis = ~net.fixed.any(axis=1)
    azimuth = np.arctan2(net.positions[:, 2], net.positions[:, 1]) * net.order / (2.0 * np.pi)
    plane = 0.5 * (azimuth[0] + azimuth[images.node[0]] - images.middle[0]) + 0.5 * images.middle
    move = rng.normal(0.0, 0.004, net.positions.shape) * off_axis[:, None]
    if mirrored:
        move += (move * [1.0, 1.0, -1.0])[images.node]
    position = net.positions + rotate(move, plane, net.order)
    ring, pull = Ring(problem.structure, problem.bands), rng.uniform(0.0, 10.0)
    ring.state.position[:] = position
    ring.step.blocks[:] = 0.0
    along, across = np.full((2, len(net.bars)), [[pull], [1e4 * pull]])
    if not mirrored:
        along *= rng.uniform(0.5, 1.5, len(along))
    add_bar_tangent(position, problem.structure, ring.pattern, along, across, ring.step.blocks)
    share = rng.uniform(0.0, 1.0, problem.bands)
    add_tangent(position, problem.structure, problem.loading, ring.pattern, share, ring.step.blocks)
    ring.gather(False)
    return ring, mirrored


@given(disturbed())
@settings(max_examples=30, deadline=None)
def test_a_tangent_is_taken_as_mirrored_where_it_is_and_its_pivots_are_those_of_its_eigenvalues(made):
    ring, mirrored = made
    assert (ring.mirrored is not None) == mirrored
    asked = np.arange(int(ring.order // 2) + 1)
    wholes = [ring.tangent(k).dense() for k in asked]
    eigenvalues = [np.linalg.eigvalsh(0.5 * (whole + whole.conj().T)) for whole in wholes]
    for shift in (0.0, 40.0):
        expected = [np.count_nonzero(values < -shift) for values in eigenvalues]
        assert negative_pivots(ring, asked, np.full(len(asked), shift)).tolist() == expected


@pytest.mark.parametrize(("aside", "mirrored"), [(0.0, True), (1e-13, True), (1e-6, False)])
def test_a_shape_that_is_off_its_image_by_more_than_round_off_is_asked_in_complex_numbers(aside, mirrored):
    problem, solution = solved("diamond")
    ring = Ring(problem.structure, problem.bands)
    positions = solution.positions.copy()
    positions[8] += [0.0, 0.0, aside * problem.structure.length[0]]
    ring.linearise(problem, replace(solution, positions=positions))
    assert (ring.mirrored is not None) == mirrored


@pytest.mark.parametrize(("share", "mirrored"), [(1e-10, True), (1e-5, False), (0.1, False)])
@pytest.mark.parametrize("name", ["diamond", "t90", "joined"])
def test_pull_that_is_off_its_image_in_a_mirrored_shape_is_asked_in_complex_numbers(name, share, mirrored):
    """Beside the own stiffness of bars that do not stretch it changes next to nothing of the tangent."""
    problem, solution = solved(name)
    _, images = built(name)
    ring, tension = Ring(problem.structure, problem.bands), solution.bar_tension.copy()
    one = np.flatnonzero((images.joint[images.bar] != images.bar) & (tension > 0.1 * tension.mean()))[0]
    tension[one] += share * tension.mean()
    ring.linearise(problem, replace(solution, bar_tension=tension))
    assert (ring.mirrored is not None) == mirrored


def test_a_ring_of_two_sectors_stays_complex():
    model = model_of(make_plan(8, 5, 0.3, 2.0), 1, 4)
    problem, solution = equilibrium.solve(model, model.plan.cases()[0], (), None)
    assert problem.structure.order == 2.0
    harmonics_of(problem, solution, model.ring)
    assert model.ring.mirrored is None


def test_a_tangent_that_is_no_number_is_told():
    problem, _ = built("diamond")
    ring = Ring(problem.structure, problem.bands)
    ring.step.blocks[:] = 1.0
    ring.step.blocks[3, 1, 1] = np.nan
    ring.gather(False)
    assert ring.mirrored is None
    harmonics = growing_harmonics(ring, 1.0)
    assert harmonics.undecided == tuple(range(5))


def test_what_grows_is_the_same_in_complex_numbers(monkeypatch):
    plan = make_plan(9, 6, 0.2, 2.5, netting=STIFF | {"bending_stiffness_n_m2": 1e-2})
    problem, solution = equilibrium.solve(model_of(plan, 1, 1), plan.cases()[0], (), None)
    scale = stiffness_under_tension(problem, solution)
    real, other = (
        harmonics_of(problem, solution, ring)
        for ring in (Ring(problem.structure, problem.bands), in_complex(problem, monkeypatch))
    )
    assert [growth.harmonic for growth in real.growing] == [growth.harmonic for growth in other.growing] != []
    for one, two in zip(real.growing, other.growing, strict=True):
        np.testing.assert_allclose(one.eigenvalues, two.eigenvalues, atol=1e-7 * scale)
