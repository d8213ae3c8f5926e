"""Meshes that yield: against the energy of a rhombus, their limits, and a net in which a mesh is pulled open."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from catch_models.fish import FishSection
from codend.bag.measures import opening_force
from codend.selectivity.escape.neighbour_kernels import neighbours_hold
from codend.selectivity.escape.penetration import Holes, hole_of, longest_fish
from codend.selectivity.escape.yielding import held_by_neighbours, load_along
from codend.selectivity.escape.yielding_kernels import force_to
from validation.yielding_meshes import pulls

SECTION = FishSection(0.1, 0.07)
BAR_M, TENSION_N, OPENING_DEG = 0.05, 8.0, 24.0
HALF = np.radians(OPENING_DEG) / 2.0
INFINITE_N = 1e12


def holes(bending_n: float = 0.0, rest_deg: float = 10.0, **changes: float) -> Holes:
    load = load_along(TENSION_N, HALF, bending_n, np.radians(rest_deg) / 2.0)
    return Holes.of("diamond", BAR_M, OPENING_DEG, load_n=load, bending_n=bending_n, rest_deg=rest_deg, **changes)


@pytest.mark.parametrize("rest_deg", [0.0, 24.0, 70.0])
@pytest.mark.parametrize("bending_n", [0.0, 3.0, 30.0])
def test_a_push_brings_a_mesh_to_the_least_of_its_energy(bending_n, rest_deg):
    """The energy of four clamped bars under the loads that hold them at the computed opening, and the push."""
    mesh = hole_of(holes(bending_n, rest_deg), 0)
    rest = np.radians(rest_deg) / 2.0
    shear = 0.5 * bending_n * (HALF - rest)
    along = 2.0 * (TENSION_N * np.cos(HALF) - shear * np.sin(HALF))
    across = 2.0 * (TENSION_N * np.sin(HALF) + shear * np.cos(HALF))

    def least(push_across: float, push_along: float) -> float:
        def energy(half: float) -> float:
            work = (along + push_along) * np.cos(half) + (across + push_across) * np.sin(half)
            return 0.5 * bending_n * (half - rest) ** 2 - work

        return minimize_scalar(energy, bounds=(0.0, 1.57), method="bounded", options={"xatol": 1e-10}).x

    np.testing.assert_allclose(least(0.0, 0.0), HALF, atol=1e-6)
    for wanted in np.radians([14.0, 25.0, 40.0]):
        np.testing.assert_allclose(least(force_to(mesh, HALF, wanted), 0.0), wanted, atol=1e-6)
    for wanted in np.radians([3.0, 9.0]):
        np.testing.assert_allclose(least(0.0, force_to(mesh, HALF, wanted)), wanted, atol=1e-6)


@pytest.mark.parametrize("bending_n", [0.0, 3.0, 30.0])
def test_the_force_of_a_push_is_the_opening_force_of_the_mechanics(bending_n):
    rest = np.radians(10.0) / 2.0
    expected = opening_force(np.array(TENSION_N), np.array(OPENING_DEG), 60.0, bending_n, rest)
    np.testing.assert_allclose(force_to(hole_of(holes(bending_n), 0), HALF, np.radians(30.0)), expected, rtol=1e-12)


def test_without_a_push_a_mesh_is_rigid_however_limp_and_without_stiffness_bending_changes_nothing():
    rigid = longest_fish(Holes.of("diamond", BAR_M, OPENING_DEG), SECTION)
    assert longest_fish(holes(30.0), SECTION) == rigid
    nearly = longest_fish(holes(1e-9), SECTION, push_force_n=2.0)
    np.testing.assert_allclose(longest_fish(holes(0.0), SECTION, push_force_n=2.0), nearly, rtol=1e-8)
    np.testing.assert_allclose(longest_fish(holes(30.0), SECTION, push_force_n=1e-9), rigid, rtol=1e-8)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_an_infinite_push_lets_the_largest_section_through_that_any_opening_does(exponent):
    found = longest_fish(holes(30.0, held_across=7.0), SECTION, push_force_n=INFINITE_N, push_exponent=exponent)
    np.testing.assert_allclose(found, 2.0 * BAR_M / (2.0 * 0.1 + 2.0 * 0.07), rtol=1e-6)


def test_stiffer_twine_tension_and_neighbours_make_a_fish_that_pushes_shorter_and_a_push_longer():
    def length(push_force_n: float = 2.0, **changes: float) -> float:
        return longest_fish(holes(**changes), SECTION, push_force_n=push_force_n, push_exponent=2.0).item()

    assert length() > length(bending_n=3.0) > length(bending_n=30.0)
    assert length() > length(held_across=3.0)
    assert length(8.0) > length(4.0) > length(2.0) > length(0.0)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("push_n", [0.05, 0.5, 5.0, 50.0])
def test_the_longest_fish_is_the_longest_of_all_openings_to_which_its_own_push_reaches(exponent, push_n):
    given = holes(3.0)
    mesh = hole_of(given, 0)
    half = np.radians(np.linspace(0.5, 179.0, 7141)) / 2.0
    rigid = longest_fish(Holes.of("diamond", BAR_M, np.degrees(2.0 * half)), SECTION)
    needed = np.array([force_to(mesh, HALF, one) for one in half])
    brute = rigid[needed <= push_n * (rigid / 0.3) ** exponent].max()
    found = longest_fish(given, SECTION, push_force_n=push_n, push_exponent=exponent).item()
    assert brute * (1.0 - 1e-9) <= found < brute * 1.003


def test_of_openings_that_a_push_reaches_with_a_gap_between_them_the_best_is_found():
    """A mesh nearly shut lets tiny fish through, which push next to nothing; much longer ones open it as they need."""
    half = np.radians(np.linspace(0.5, 179.0, 3570)) / 2.0
    tension = 0.0913
    given = Holes.of("diamond", BAR_M, 6.3, load_n=load_along(tension, np.radians(3.15), 0.0, 0.0))
    rigid = longest_fish(Holes.of("diamond", BAR_M, np.degrees(2.0 * half)), SECTION)
    needed = np.array([force_to(hole_of(given, 0), np.radians(3.15), one) for one in half])
    gaps = {}
    for push in np.geomspace(0.05, 20.0, 25):
        reached = needed <= push * (rigid / 0.3) ** 2.0
        gaps[push] = np.count_nonzero(np.diff(reached.astype(int)) == 1)
        found = longest_fish(given, SECTION, push_force_n=push, push_exponent=2.0).item()
        assert rigid[reached].max() * (1.0 - 1e-9) <= found < rigid[reached].max() * 1.01, push
    assert 2 in gaps.values(), "some reach two ranges of openings"


def test_a_mesh_in_netting_of_stiff_twine_is_held_as_the_root_of_ea_over_tension_says():
    """Where bars hardly stretch the netting gives way along its bars only: a sum whose size is known."""
    tension = np.array([10.0, 10.0])
    half, none = np.radians([20.0, 20.0]), np.zeros(2)
    netting = (none, none, none, np.zeros(2, dtype=bool))
    held, _ = held_by_neighbours(tension, half, np.array([1e5, 1e6]), *netting)
    np.testing.assert_allclose(held[1] / held[0], np.sqrt(10.0), rtol=0.01)
    held, closed = held_by_neighbours(tension, half, np.array([np.inf, 1e3]), *netting)
    assert held[0] == closed[0] == 1.0 < held[1]


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("stiffness", [0.0, 1e-4])
def test_knots_without_length_hold_a_mesh_as_no_knots_do(turned, stiffness):
    with_knots, without = np.empty(2), np.empty(2)
    neighbours_hold(0.35, 1e-2, stiffness, 0.3, 1e-7, turned, with_knots)
    neighbours_hold(0.35, 1e-2, stiffness, 0.3, 0.0, False, without)
    np.testing.assert_allclose(with_knots, without, rtol=2e-3)


def test_many_knots_pushed_apart_in_a_piece_of_netting_move_as_the_sum_over_waves_says():
    """A torus of 24 x 24 knots, its stiffness written bar by bar: what two knots move apart under a unit force."""
    half, strain, size = 0.4, 0.05, 24
    e = np.array([[np.cos(half), np.sin(half)], [np.cos(half), -np.sin(half)]])
    n = np.stack([-e[:, 1], e[:, 0]], axis=1)
    number = np.arange(size * size).reshape(size, size)
    stiffness = np.zeros((2 * size * size,) * 2)
    for bar, ahead in enumerate((np.roll(number, -1, axis=0), np.roll(number, -1, axis=1))):
        block = np.outer(e[bar], e[bar]) + strain * np.outer(n[bar], n[bar])
        for one, other in zip(number.ravel(), ahead.ravel(), strict=True):
            i, j = slice(2 * one, 2 * one + 2), slice(2 * other, 2 * other + 2)
            stiffness[i, i] += block
            stiffness[j, j] += block
            stiffness[i, j] -= block
            stiffness[j, i] -= block
    pull = np.zeros(2 * size * size)
    pull[2 * number[1, 0] + 1], pull[2 * number[0, 1] + 1] = 1.0, -1.0
    apart = pull @ np.linalg.lstsq(stiffness, pull, rcond=None)[0]
    alone = 2.0 * np.cos(half) ** 2 / (2.0 * strain)
    held = np.empty(2)
    neighbours_hold(half, strain, 0.0, 0.0, 0.0, False, held)
    np.testing.assert_allclose(held[0], alone / apart, rtol=0.01)


@pytest.mark.parametrize("name", ["EI 1e-3 N m2, EA 1000 N", "T90, knots of 10 mm, EA 1000 N"])
def test_a_mesh_really_pulled_open_in_a_solved_net_takes_the_force_that_the_selectivity_takes(name):
    (one,) = pulls(name, (5.0,))
    assert one.alone_n * 1.5 < one.in_net_n, "neighbours tell"
    np.testing.assert_allclose(one.ratio, 1.0, atol=0.06)


def test_a_force_is_nothing_at_the_computed_opening_and_grows_away_from_it():
    for bending in (0.0, 30.0):
        mesh = hole_of(holes(bending), 0)
        assert force_to(mesh, HALF, HALF) == pytest.approx(0.0, abs=1e-12)
        for way in (np.linspace(HALF, 1.5, 60), np.linspace(HALF, 0.02, 60)):
            assert (np.diff([force_to(mesh, HALF, half) for half in way]) > 0.0).all()
