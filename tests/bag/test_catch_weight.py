"""A catch that is not as dense as the water weighs (rho_c - rho) g V, and a full net bears it."""

import numpy as np
import pytest

from catch_models.filling import enclosed_volume
from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.equilibrium import fidelity
from codend.mechanics import catch_weight
from codend.mechanics.catch_front import band_geometry, fill, row_positions
from codend.mechanics.problem import Problem
from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import Floats
from codend.report.choice_words import reason_text
from codend.studies.study import solve
from tests.plans import make_plan
from validation.hanging import hanging_plan, missed

WATER, HEAVY = 1000.0, 1300.0
MESHES = {"T0": {}, "T0 with knots": {"netting": {"knot_mm": 8.0}}, "T90": {"mesh": "t90", "netting": {"knot_mm": 8.0}}}
MESHES |= {"square": {"mesh": "square"}}


def weighing(kind: str, filled: float, shake_m: float) -> tuple[Bag, Problem, Floats, Floats]:
    """A crude bag, every free node moved at random, with the load of its catch's weight and the catch's shares."""
    plan = make_plan(9, 6, catch={"filled_meshes": filled, "density_kg_m3": HEAVY}, **MESHES[kind])
    bag = build_bag(plan)
    problem = problem_of(bag, plan, plan.cases()[0])
    at = bag.net.positions + shake_m * ~bag.net.fixed * np.random.default_rng(3).normal(size=bag.net.positions.shape)
    share, load = np.zeros(bag.bands), np.zeros_like(at)
    fill(at, problem.structure, problem.loading.catch, share)
    catch_weight.add_force(at, problem.structure, problem.loading.catch, share, load)
    return bag, problem, at, load


def volume_below(corners: Floats, weight: Floats) -> float:
    """Volume of the pyramids from facets, (f, 3, 3), to the origin, m3."""
    return float(weight @ np.linalg.det(corners)) / 6.0


@pytest.mark.parametrize("kind", MESHES)
def test_a_full_random_net_is_pulled_down_by_the_weight_of_its_catch_and_no_other_way(kind):
    bag, _, at, load = weighing(kind, 6.0, 0.01)
    volume = volume_below(at[bag.net.facets] - at[bag.held_by_the_entry].mean(axis=0), bag.net.facet_weight)
    expected = -(HEAVY - WATER) * GRAVITY_M_S2 * volume
    assert load.sum(axis=0) == pytest.approx([0.0, 0.0, expected], abs=1e-10 * abs(expected))


@pytest.mark.parametrize("kind", MESHES)
@pytest.mark.parametrize("shake_m", [0.0, 0.01])
@pytest.mark.parametrize("filled", [2.3, 4.0])
def test_behind_a_front_of_any_shape_the_netting_bears_the_volume_that_is_told_and_is_pushed_to_no_side(
    kind, filled, shake_m
):
    """Nothing else bears a catch: what a lid would on a front that is neither level nor upright, its rings do."""
    bag, problem, at, load = weighing(kind, filled, shake_m)
    catch, area, moment = problem.loading.catch, np.zeros(bag.bands), np.zeros(bag.bands)
    row_x, share = np.zeros(bag.bands + 1), np.zeros(bag.bands)
    row_positions(at, catch, row_x)
    band_geometry(at, problem.structure, catch, area, moment)
    fill(at, problem.structure, catch, share)
    expected = -(HEAVY - WATER) * GRAVITY_M_S2 * enclosed_volume(row_x, area, moment, share)
    assert load.sum(axis=0) == pytest.approx([0.0, 0.0, expected], abs=1e-10 * abs(expected))


@pytest.mark.parametrize(
    ("mesh", "meshes_round", "catch", "in_contact"),
    [
        ("diamond", 6, 2050.0, False),
        ("diamond", 7, 900.0, False),
        ("square", 9, 2050.0, False),
        ("t90", 8, 900.0, True),
    ],
)
def test_a_heavy_bag_towed_as_slowly_as_may_be_hangs_from_its_hoop(mesh, meshes_round, catch, in_contact):
    """One whose catch floats lies on itself at the hoop: contact bears what passes over it."""
    study = solve(plan := hanging_plan(mesh, meshes_round, 12, 6.0, catch, 4000.0, 0.4))
    result = study.cases[0]
    assert study.choice.fidelity == "full"
    assert result.converged
    assert (result.problem.surface is not None) == in_contact == (result.followed.contact_share > 0.0)
    assert np.abs(missed(plan, result)).max() <= 1e-8
    assert result.positions[-1, 2] * (catch - WATER) < 0.0, "a catch that floats rises"
    assert result.measures.sideways_imbalance <= 1e-6
    assert result.measures.folded_share <= 0.1


def test_a_catch_as_dense_as_the_water_is_one_whose_density_is_left_out():
    told, left_out = (
        solve(make_plan(12, 10, catch={"filled_meshes": 3.0, **density}, netting={"twine_density_kg_m3": 1400.0}))
        for density in ({"density_kg_m3": WATER}, {})
    )
    assert np.array_equal(told.cases[0].positions, left_out.cases[0].positions)
    assert told.cases[0].measures.drag_n == left_out.cases[0].measures.drag_n


@pytest.mark.parametrize(("density", "fidelity_chosen"), [(1001.0, "sector"), (1100.0, "full"), (900.0, "full")])
def test_auto_weighs_the_catch_as_it_weighs_twine(density, fidelity_chosen):
    choice = fidelity.choose(make_plan(13, 10, catch={"filled_meshes": [2.0, 5.0], "density_kg_m3": density}))
    assert choice.fidelity == fidelity_chosen
    assert "wet weight of the catch" in reason_text(choice)
    assert choice.weight_over_drag == pytest.approx(choice.catch_weight_n / choice.least_drag_n)
    sector = fidelity.choose(
        make_plan(13, 10, catch={"filled_meshes": 5.0, "density_kg_m3": density}, model={"fidelity": "sector"})
    )
    assert ("which here matters" in reason_text(sector)) == (fidelity_chosen == "full")
