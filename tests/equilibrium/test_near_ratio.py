"""Joined sections whose counts share little: a sector of nearly their ratio stands for one too wide."""

import numpy as np
import pytest

from codend.bag.bag import Bag, all_round
from codend.bag.build import build_bag
from codend.bag.measures import Measures, measure_all
from codend.bag.near_ratio import NearRatio, narrower, near_enough, near_ratios
from codend.equilibrium import fidelity
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.accuracy import SAFETY, by_ratio
from codend.equilibrium.bag_model import model_of
from codend.mechanics.sheet import FEWEST, sheet_of
from codend.plan.plan import Plan
from codend.report.choice_words import reason_text
from codend.report.html import cautions
from codend.solvers import newton
from codend.solvers.harmonics import harmonics_of
from codend.solvers.outcome import Solution
from codend.solvers.refusal import refusal
from codend.studies.study import solve
from tests.plans import joined_plan
from validation.joined_counts import joined_pair


def joined(first: int, second: int, rows: int = 8, **model: object) -> Plan:
    sections = ("diamond", first, rows, 20.0, {}), ("diamond", second, rows, 24.0, {})
    return joined_plan(*sections, entry=0.3 * first * 0.02 / np.pi, model=model)


def solved(plan: Plan, near: NearRatio | None) -> tuple[Bag, Measures, Solution]:
    model = model_of(plan, 1, 1, near=near)
    problem, solution = equilibrium.solve(model, plan.cases()[0], (), None)
    assert solution.report.outcome.converged
    assert refusal(problem, solution.positions, solution.share) is None
    return model.bag, measure_all(model.bag, problem, solution)[2], solution


@pytest.mark.parametrize(("first", "second"), [(172, 54), (97, 89), (100, 60), (31, 7)])
def test_ever_wider_sectors_come_ever_nearer_and_end_in_the_exact_one(first, second):
    found = list(near_ratios(joined(first, second)))
    assert np.all(np.diff([near.largest for near in found]) < 0.0)
    common = np.gcd(first, second)
    assert found[-1].columns == (first // common, second // common)
    assert found[-1].order == pytest.approx(common)
    assert found[-1].largest < 1e-15
    for near in found:
        stands_for = near.order * np.array(near.columns)
        assert stands_for == pytest.approx([first, second] * (1.0 + np.array(near.mismatch)))


def test_the_exact_sector_written_as_a_ratio_is_the_exact_sector():
    plan = joined(20, 12)
    exact = list(near_ratios(plan))[-1]
    assert solved(plan, exact)[1].drag_n == pytest.approx(solved(plan, None)[1].drag_n, rel=1e-9)


@pytest.mark.parametrize(("first", "second"), [(29, 20), (31, 24), (25, 17)])
def test_what_a_near_ratio_is_off_by_is_covered_by_its_distance_to_a_nearer_one_still(first, second):
    plan = joined(first, second)
    exact = solved(plan, None)[1]
    for near in list(near_ratios(plan))[1:-1]:
        measures = solved(plan, near)[1]
        error = SAFETY * by_ratio(model_of(plan, 1, 1, near=near), plan.cases()[0], measures)
        off = [getattr(measures, name) - getattr(exact, name) for name in ("drag_n", "catch_volume_m3")]
        assert np.all(np.abs(off) <= error[:2])
        assert abs(off[0]) <= 2.0 * near.largest * exact.drag_n


def test_a_fraction_of_a_sector_has_harmonics_and_a_picture():
    plan = joined(29, 20)
    near = next(near for near in near_ratios(plan) if near.columns == (3, 2))
    assert near.order != round(near.order)
    bag, _, solution = solved(plan, near)
    model = model_of(plan, 1, 1, near=near)
    problem, _ = equilibrium.solve(model, plan.cases()[0], [(plan.cases()[0], solution)], None)
    assert not newton.tangent_at(problem, solution, model.prepared).singular
    assert harmonics_of(problem, solution, model.ring).growing == ()
    whole = all_round(bag, solution.positions)
    assert len(whole.bars) == round(near.order) * len(bag.net.bars)
    sides = whole.positions[whole.bars]
    length = np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
    assert length.max() <= 1.05 * bag.net.bar_length.max()


@pytest.mark.parametrize(("first", "second"), [(172, 54), (97, 89)])
def test_auto_takes_a_near_ratio_where_the_exact_sector_would_take_minutes(first, second):
    plan = joined(first, second, rows=60)
    choice = fidelity.choose(plan)
    assert choice.near == near_enough(plan)
    assert choice.knots < 6000
    assert choice.drag_error <= plan.model.accuracy
    said = reason_text(choice)
    assert "would be exact, but take minutes" in said
    assert "in drag where 1 % is allowed" in said
    assert narrower(plan, choice.near).largest > choice.near.largest
    assert near_enough(joined(first, second, rows=60, accuracy=1e-9)) is None


@pytest.mark.parametrize(("first", "second"), [(100, 60), (13, 12)])
def test_sectors_that_are_narrow_or_nets_that_are_small_stay_exact(first, second):
    assert fidelity.choose(joined(first, second)).near is None
    assert build_bag(joined(first, second), sectors=1).net.order == np.gcd(first, second)


def test_a_narrower_sector_stands_in_where_the_chosen_one_has_no_equilibrium():
    """Of 107 to 76 meshes all spare netting folds but in 3 to 2 and 31 to 22; the latter has 357.6345 N."""
    plan = joined_pair(7, 15)
    plan = plan.model_copy(update={"model": plan.model.model_copy(update={"contact": False})})
    result = solve(plan).cases[0]
    assert result.converged
    assert result.stands_in is not None
    assert result.stands_in.columns == (3, 2)
    assert abs(result.measures.drag_n - 357.6345) <= result.errors.drag_error_n < 0.1 * result.measures.drag_n
    assert any("meshes round that the plan has" in caution for caution in cautions(solve(plan)))


def test_spare_netting_behind_a_joint_lies_in_folds_with_the_drag_of_a_nearer_ratio():
    """A sector 31 and 22 meshes wide, in which 107 to 76 differ by 0.1 %, has 357.6345 N."""
    result = solve(joined_pair(7, 15)).cases[0]
    assert result.converged
    assert result.stability.stable == "yes"
    assert result.followed.contact_share > 0.0
    assert result.problem.surface.least_distance(result.positions) > 0.0
    assert result.net.order != round(result.net.order)
    assert abs(result.measures.drag_n - 357.6345) <= result.errors.drag_error_n < 0.01 * result.measures.drag_n


def test_contact_wants_sectors_enough_that_what_is_left_of_one_is_little():
    plan = joined(29, 20)
    near = next(near for near in near_ratios(plan) if near.order < FEWEST and near.order != round(near.order))
    with pytest.raises(ValueError, match="4 of them and a fraction"):
        sheet_of(build_bag(plan, near=near).net)
