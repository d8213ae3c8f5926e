"""Narrow sectors of netting that tapers: what they tell in a second, and what they leave a choice of models."""

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.near_ratio import quick_looks
from codend.equilibrium import accuracy
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.fidelity import Reason, choose
from codend.plan.plan import Plan, plan_from_dict
from codend.report.choice_words import reason_text
from codend.studies.study import solve
from validation.smeared_ropes import ESTIMATED
from validation.tapering_sectors import solved_on

NETTING = {
    "mesh": "diamond",
    "mesh_mm": 100.0,
    "knot_mm": 0.0,
    "twine_mm": 3.0,
    "axial_stiffness_n": 1000.0,
    "panels": 2,
}
ROPE = {"number": 2, "shortening": 0.03, "axial_stiffness_n": 1e4}
WINDOW = {
    "netting": "codend",
    "mesh": "square",
    "meshes_round": 8,
    "meshes_long": 8,
    "bar_mm": 60.0,
    "knot_mm": 0.0,
    "twine_mm": 3.0,
    "meshes_across": 8,
    "meshes_from_codline": [6, 14],
}


def belly(fore: int, aft: int, long: tuple[int, int] = (24, 16), **other: object) -> Plan:
    return plan_from_dict(
        {
            "title": "belly",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1025.0},
            "entry": {"hanging_ratio": 0.35},
            "netting": [
                NETTING | {"name": "belly", "meshes_round": fore, "meshes_round_aft": aft, "meshes_long": long[0]},
                NETTING | {"name": "codend", "meshes_round": aft, "meshes_long": long[1]},
            ],
            "catch": {"filled_meshes": [8.0], "pressure": "uniform"},
        }
        | other
    )


@pytest.mark.parametrize("ropes", [[], [ROPE]])
def test_narrow_sectors_state_errors_that_cover_the_exact_one(ropes):
    plan = belly(42, 30, rope=ropes)
    exact = solve(plan.model_copy(update={"model": plan.model.model_copy(update={"fidelity": "sector"})}))
    truth, looks = exact.table.iloc[0], quick_looks(plan)
    assert [near.off for near in looks] == sorted(near.off for near in looks)
    for near in (looks[0], looks[-1]):
        found = solved_on(plan, near).table.iloc[0]
        for size in ESTIMATED.values():
            error = next(name for name in found.index if name.startswith(f"{size.rsplit('_', 1)[0]}_error"))
            assert abs(found[size] - truth[size]) <= found[error]


def test_a_narrow_sector_with_the_counts_met_has_the_drag_of_the_exact_one():
    plan = belly(42, 30)
    near = quick_looks(plan)[0]
    assert near.off < 1e-12
    drag_n = [solve(plan).cases[0].measures.drag_n, solved_on(plan, near).cases[0].measures.drag_n]
    assert drag_n[1] == pytest.approx(drag_n[0], rel=0.01)


def test_smeared_over_tapers_there_is_as_much_rope_in_every_row_as_of_all_of_them():
    plan = belly(42, 30, rope=[ROPE])
    for near in quick_looks(plan):
        bag = build_bag(plan, sectors=1, smeared=True, near=near)
        stiffness = near.order / bag.rope_share
        of_rows = np.bincount(bag.bar_band[bag.ropes], weights=stiffness)
        assert of_rows[of_rows > 0.0] == pytest.approx(2.0)
        rest = np.bincount(bag.bar_band[bag.ropes], weights=bag.net.bar_length[bag.ropes] * stiffness)
        assert rest.sum() == pytest.approx(2 * 0.97 * 0.1 * 40)


def test_a_model_of_a_belly_with_ropes_and_a_window_is_chosen_by_narrow_sectors_each_solved_once(monkeypatch):
    asked = []
    real = equilibrium.solve

    def noted(model, case, *rest):
        asked.append((model.near, model.globalisation, case.catch_value, len(model.bag.net.positions)))
        return real(model, case, *rest)

    monkeypatch.setattr(accuracy.equilibrium, "solve", noted)
    plan = belly(80, 48, (32, 20), rope=[ROPE], window=[WINDOW], catch={"filled_meshes": [6.0, 10.0]})
    choice = choose(plan)
    assert choice.reason is Reason.WINDOW
    assert max(knots for *_, knots in asked) < 2000
    assert len(asked) == len(set(asked))
    again = len(asked)
    accuracy.sector_measures(plan, plan.cases()[0], 1)
    assert len(asked) == again


def test_ropes_smeared_over_tapers_are_told_with_the_sector_that_stands_for_the_net():
    plan = belly(42, 30, rope=[ROPE], model={"fidelity": "smeared"})
    study = solve(plan)
    assert study.converged
    assert study.table["fidelity"].tolist() == ["smeared"]
    assert "7 and 5 meshes wide, as of 42.0 and 30.0 meshes round" in reason_text(study.choice)


def test_counts_of_a_simple_ratio_have_quick_looks_too():
    """400 meshes to 200 are 2 to 1: the only sector looked at lost half its meshes at once."""
    looks = quick_looks(belly(80, 40))
    assert looks
    assert all(near.off < 1e-12 and near.step < 0.2 for near in looks)


def test_small_netting_that_tapers_has_no_quick_look():
    assert quick_looks(belly(16, 10, (6, 6))) == []


def test_slow_models_with_real_ropes_tell_of_the_quick_look():
    panels = [NETTING | {"meshes_round": 80, "meshes_long": 50}]
    plan = belly(42, 30, rope=[ROPE], netting=panels)
    assert "model.opening_accuracy_deg lets ropes be smeared" in reason_text(choose(plan))
    assert "opening_accuracy_deg" not in reason_text(choose(belly(80, 40, (40, 40))))


def test_selvedges_smeared_all_round_leave_sectors_one_mesh_wide():
    """Two panels with selvedges had sectors half a net wide, those in which ropes are smeared too."""
    panels = [NETTING | {"meshes_round": 52, "meshes_long": long, "selvedge_meshes": 3} for long in (20, 30)]
    plan = belly(42, 30, rope=[ROPE], netting=panels)
    assert build_bag(plan, sectors=1).net.order == 2
    assert build_bag(plan, sectors=1, smeared=True).net.order == 52 - 12
    assert choose(plan.model_copy(update={"model": plan.model.model_copy(update={"fidelity": "smeared"})})).near is None
