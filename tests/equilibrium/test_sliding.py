"""Errors cover what it may change that second layers slide on the netting below."""

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.layer_contact import can_slide, in_contact
from codend.plan.plan import Plan, plan_from_dict
from codend.report.choice_words import reason_text
from codend.report.layer_words import held_layers
from codend.studies.study import solve
from tests.bag.test_layers import ROPE, SEAMS, SNUG, plan_with, small_plan
from validation.layers_in_contact import codend_plan, measured_in_contact
from validation.sliding_layers import by_nets, changes_of, random_plan
from validation.weight_left_out import QUANTITIES


def with_contact(plan: Plan, contact: bool | str) -> Plan:
    tables = plan.to_dict()
    return plan_from_dict(tables | {"model": tables["model"] | {"contact": contact}})


def test_errors_cover_a_tight_layer_in_contact_by_the_law_and_more_closely_by_the_net_itself():
    plan = codend_plan(24, 0.8, 7)
    by_law, by_net = (solve(with_contact(plan, contact)).cases[0] for contact in (False, "auto"))
    free = measured_in_contact(plan, by_net)
    assert free is not None
    off = np.abs(free.estimated - by_net.measures.estimated)
    assert off[0] > 0.2 * by_net.measures.drag_n
    for held in (by_law, by_net):
        stated = np.array([getattr(held.errors, error) for error in QUANTITIES.values()])
        assert np.all(off < stated)
        assert np.all(held.by_sliding <= stated)
    assert np.all(by_net.by_sliding < by_law.by_sliding)
    assert np.array_equal(by_law.positions, by_net.positions)


@pytest.mark.parametrize(("seed", "number"), [(6, 0), (6, 7), (6, 39), (4, 32), (5, 64)])
def test_the_law_covers_random_layers(seed, number):
    found = changes_of(random_plan(seed, number))
    assert found is None or max(found[f"{name} over stated"] for name in QUANTITIES) < 1.0


def test_layers_that_carry_nothing_may_slide_as_they_like():
    held = solve(small_plan("loose")).cases[0]
    assert not held.by_sliding.any()


@pytest.mark.parametrize("number", [5, 13])
def test_netting_may_touch_a_layer_that_all_but_carries(number):
    """Round as the model has it the netting is clear of it, by 4e-4 of its bars; in pillows it is not."""
    study, found = solve(random_plan(77, number)), changes_of(random_plan(77, number))
    (held,) = study.cases
    assert held.measures.drag_n * 0.005 < held.by_sliding[0] < held.measures.drag_n * 0.02
    (word,) = held_layers(study, lambda cases, study: "it")
    assert "lie so close over it" in word
    assert "it; errors count up to 1 % of the drag and " in word
    assert found is not None
    assert max(found[f"{name} over stated"] for name in QUANTITIES) < 1.0


def test_of_a_catch_of_a_given_volume_that_is_not_changed():
    plan = with_contact(small_plan("tight", catch={"volume_m3": 0.04}), False)
    held = solve(plan).cases[0]
    assert held.by_sliding[1] == 0.0
    assert held.by_sliding[0] > 0.3 * held.measures.drag_n


def test_what_cannot_be_two_nets_in_a_sector_is_left_to_the_law():
    assert can_slide(model_of(small_plan("tight"), 1, 1))
    assert not can_slide(model_of(small_plan("tight"), 1, None))
    assert not can_slide(model_of(with_contact(small_plan("tight"), False), 1, 1))
    assert can_slide(model_of(small_plan("t90"), 1, 1))
    # 24 meshes round and 10 repeat after 12 and 5, two ropes after 12
    assert can_slide(model_of(small_plan("snug"), 1, 1))
    assert can_slide(model_of(small_plan("snug", rope=[ROPE]), 1, 1))
    # four ropes after 6, of which layers of 10 meshes round make no equal parts
    assert not can_slide(model_of(small_plan("snug", rope=[ROPE | {"number": 4}]), 1, 1))
    # 100 meshes round and 36 repeat after 25 and 9: 2525 knots
    assert not can_slide(model_of(plan_with(SNUG), 1, 1))
    assert can_slide(model_of(with_contact(plan_with(SNUG), True), 1, 1))


def two_layers() -> Plan:
    tables = small_plan("tight").to_dict()
    inner = tables["layer"][0] | {"meshes_from_codline": [0, 6], "meshes_long": 8, "meshes_round": 24}
    return plan_from_dict(tables | {"layer": [*tables["layer"], inner]})


def joined() -> Plan:
    tables = small_plan("tight").to_dict()
    (section,) = tables["netting"]
    sections = [section | {"meshes_round": 36, "meshes_long": 8}, section | {"meshes_long": 12}]
    return plan_from_dict(tables | {"netting": sections})


@pytest.mark.parametrize(
    "plan",
    [
        small_plan("t90"),
        small_plan("tight", rope=[ROPE]),
        small_plan("tight", SEAMS | {"meshes_round": 28}),
        two_layers(),
        joined(),
    ],
    ids=["knots across", "ropes", "seams", "two layers", "joined sections"],
)
def test_layers_over_and_beside_anything_start_with_nothing_through_anything(plan, monkeypatch):
    monkeypatch.setattr("codend.equilibrium.layer_contact.STEPS", 1)
    held = solve(with_contact(plan, False)).cases[0]
    found = in_contact(model_of(with_contact(plan, True), 1, 1), held.case, held.problem, held.solution)
    assert found is not None
    bag, problem, _ = found
    below = build_bag(plan.model_copy(update={"layer": ()}), sectors=1)
    layers = bag.net.bars[len(below.net.bars) * below.net.sectors // bag.net.sectors :]
    # every layer ends in the codline and goes all round
    twine = sum(layer.meshes_round for layer in plan.layer) // bag.net.sectors
    assert np.count_nonzero(layers == np.flatnonzero(bag.node_row == bag.bands)[0]) >= twine
    assert problem.net.order == bag.net.order


def test_the_net_in_contact_stands_beside_the_answer_in_the_row():
    plan = codend_plan(24, 0.8, 7)
    by_net, by_law = solve(plan), solve(with_contact(plan, False))
    (row,), (without,) = (study.table.to_dict("records") for study in (by_net, by_law))
    free = measured_in_contact(plan, by_net.cases[0])
    assert free is not None
    assert row["drag_layers_free_n"] == pytest.approx(free.drag_n, rel=1e-12)
    assert row["opening_ahead_layers_free_deg"] == pytest.approx(free.opening_ahead_deg, rel=1e-12)
    assert row["drag_n"] == without["drag_n"]
    assert np.isnan(without["drag_layers_free_n"])
    (word,) = held_layers(by_net, lambda cases, study: "it")
    assert "in 1 of 1 cases" in word
    assert f"{free.drag_n:.4g} N" in word
    assert "is exact" not in reason_text(by_net.choice)
    assert "is as good as the whole net" in reason_text(by_net.choice)


def test_a_third_start_ends_within_the_errors():
    """One that leads to 56.3 N for 58.6 N by those that errors are told by, of a net held at 59.4 N."""
    held = solve(by_nets(random_plan(6, 28))).cases[0]
    free = measured_in_contact(by_nets(random_plan(6, 28)), held, (0.15,))
    assert free is not None
    assert abs(free.drag_n - held.slid[0]) > 0.02 * held.measures.drag_n
    assert abs(free.drag_n - held.measures.drag_n) < held.errors.drag_error_n


@pytest.mark.parametrize("below_mesh", ["diamond", "t90", "square"])
@pytest.mark.parametrize("layer", ["tight", "snug", "square"])
def test_a_layer_in_contact_starts_beside_the_netting_below_laced_to_a_row_of_it(below_mesh, layer, monkeypatch):
    monkeypatch.setattr("codend.equilibrium.layer_contact.STEPS", 1)
    knots = {"mesh": below_mesh, "knot_mm": 0.0}
    plan = with_contact(small_plan(layer, knots), True)
    held, model = solve(with_contact(plan, False)).cases[0], model_of(plan, 1, 1)
    assert held.converged
    found = in_contact(model, held.case, held.problem, held.solution)
    assert found is not None  # nothing passes through anything
    bag, own = found[0], plan.layer[0].meshes_round
    assert round(bag.net.order) == np.gcd(24, own)
    columns = 24 // round(bag.net.order)
    below = build_bag(plan.model_copy(update={"layer": ()}), sectors=columns)
    shared = np.unique(bag.net.bars[len(below.net.bars) :])
    shared = shared[shared < len(below.net.positions)]
    rows, counts = np.unique(bag.node_row[shared], return_counts=True)
    assert rows.tolist() == [bag.bands - 12 * (1 if below_mesh == "square" else 2), bag.bands]
    assert counts.tolist() == [own * columns // 24, 1]
