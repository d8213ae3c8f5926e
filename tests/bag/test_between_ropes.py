"""Fewer, larger meshes between ropes, by numbers that need not divide the plan's counts."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.equilibrium import standing_in
from codend.equilibrium.accuracy import between_ropes_errors
from codend.equilibrium.fidelity import Reason, choose
from codend.equilibrium.situation import Situation
from codend.equilibrium.starts import Start
from codend.net.net import bar_vectors
from codend.plan.merging import LEAST_ROUND, between_ropes
from codend.plan.plan import Plan, plan_from_dict
from codend.report.choice_words import reason_text
from codend.report.html import cautions
from codend.selectivity.escape.catches import catches_of, run_of
from codend.solvers.outcome import Outcome, Solution
from codend.studies.catches_solved import catches_in
from codend.studies.study import Study, solve
from validation.reference import nodal_loads
from validation.smeared_ropes import QUICK, SEED, compare, random_plan

T90 = {"mesh": "t90", "bar_mm": 40.0, "knot_mm": 8.0, "twine_mm": 3.0, "axial_stiffness_n": 1000.0}
SQUARE = T90 | {"mesh": "square", "knot_mm": 0.0}


def plan_of(netting: list[dict], *ropes: dict, accuracy_deg: float | None = 90.0, **other: object) -> Plan:
    model = {"tolerance": 1e-9} | ({} if accuracy_deg is None else {"opening_accuracy_deg": accuracy_deg})
    return plan_from_dict(
        {
            "title": "between ropes",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": 0.3 * netting[0]["meshes_round"] * 0.08 / (2.0 * np.pi)},
            "netting": netting,
            "rope": [{"shortening": 0.1, "axial_stiffness_n": 1e4} | rope for rope in ropes],
            "catch": {"filled_meshes": 8.0, "pressure": "uniform"},
            "model": model,
        }
        | other
    )


def tube(kind: dict = T90, around: int = 58, long: int = 31, **more: object) -> dict:
    return kind | {"meshes_round": around, "meshes_long": long} | more


def quick(plan: Plan) -> Study:
    study = solve(plan)
    assert study.converged, study.cases[0].report.attempts
    assert study.table["fidelity"].tolist() == ["globalised"]
    return study


@pytest.mark.parametrize("kind", [T90, SQUARE])
@pytest.mark.parametrize(("around", "long", "number"), [(58, 31, 2), (50, 41, 4), (33, 29, 3), (54, 39, 6)])
def test_merged_netting_is_as_long_as_wide_and_as_much_as_the_real(kind, around, long, number):
    plan = plan_of([tube(kind, around, long)], {"number": number})
    g = between_ropes(plan)
    assert g is not None
    merged, real = (build_bag(plan, globalisation=by, sectors=1) for by in (g, 1))
    # places that lay half a mesh beside a knot may come to lie on one
    assert merged.net.order % real.net.order == 0
    assert merged.row_place[-1] == pytest.approx(long, rel=1e-12)
    for bag in (merged, real):
        of_one = bag.net.bar_length[bag.ropes].sum() / (number / bag.net.order)
        assert of_one == pytest.approx(0.9 * plan.netting[0].stretched_length_m, rel=1e-12)
    areas = [
        bag.net.order * (bag.net.bar_length * bag.net.bar_drag_diameter)[bag.bar_is_twine].sum()
        for bag in (merged, real)
    ]
    # but for the last rings of square mesh
    assert areas[0] == pytest.approx(areas[1], rel=1e-12 if kind is T90 else 0.05)


def test_so_many_meshes_are_merged_that_enough_are_left_round():
    for number, around in ((2, 58), (3, 57), (4, 60), (5, 40), (6, 54)):
        g = between_ropes(plan_of([tube(around=around)], {"number": number}))
        assert g is not None
        assert LEAST_ROUND <= around / g < LEAST_ROUND + number
        assert (around / g / number) % 1.0 == pytest.approx(0.0, abs=1e-12)
    assert between_ropes(plan_of([tube(around=24)], {"number": 2})) == 1


@pytest.mark.parametrize(
    ("netting", "rope", "other", "merged"),
    [
        # joints, straps and ends of ropes keep their rows: divisors of all counts alone
        ([tube(around=60, long=24), tube(around=60, long=12)], {}, {}, 2),
        ([tube(around=60, long=25), tube(around=60, long=12)], {}, {}, None),
        ([tube(around=60, long=30)], {"meshes_from_codline": [0, 20]}, {}, 2),
        ([tube(around=60, long=30)], {"meshes_from_codline": [0, 20.5]}, {}, None),
        ([tube(around=60, long=30, panels=2, selvedge_meshes=2)], {}, {}, None),
        ([tube(around=60, long=30)], {}, {"rope": []}, None),
    ],
)
def test_rows_that_have_a_place_of_their_own_keep_it(netting, rope, other, merged):
    assert between_ropes(plan_of(netting, {"number": 2} | rope, **other)) == merged


def test_a_whole_number_merges_as_it_does_in_a_full_net():
    plan = plan_of([tube(around=60, long=30)], {"number": 4})
    by_ropes, by_divisor = (build_bag(plan, globalisation=g, sectors=1) for g in (between_ropes(plan), 2))
    assert between_ropes(plan) == 2.5
    assert by_divisor.net.bar_length[by_divisor.bar_is_twine] == pytest.approx(2 * 0.04)
    assert by_ropes.net.bar_length[by_ropes.bar_is_twine] == pytest.approx(2.5 * 0.04)


@pytest.mark.parametrize("kind", [T90, SQUARE])
def test_it_is_chosen_for_netting_that_smeared_ropes_do_not_fit(kind):
    rope = {"number": 4}
    netting = [tube(kind, 60, 30)]
    needed = between_ropes_errors(plan_of(netting, rope))[3]
    near, far = (choose(plan_of(netting, rope, accuracy_deg=needed * by)) for by in (1.01, 0.99))
    assert (near.reason, near.fidelity, near.globalisation, near.sectors) == (
        Reason.BETWEEN_ROPES,
        "globalised",
        2.5,
        1,
    )
    assert "2.5 x 2.5 meshes merged into one" in reason_text(near)
    assert (far.reason, far.fidelity) == (Reason.ROPES, "sector")
    assert choose(plan_of([tube(kind | {"mesh": "diamond"}, 60, 30)], rope)).reason is Reason.SMEARED


@pytest.mark.parametrize(("kind", "which"), [("square", 6), ("t90", 6)])
def test_it_is_near_real_ropes_and_its_errors_cover_the_difference(kind, which):
    """With smeared ropes these are 1.5 and 6.7 % too short."""
    rng = np.random.default_rng(SEED)
    *_, plan = (random_plan(rng, kind) for _ in range(which + 1))
    found = compare(plan)
    assert found is not None
    assert found["worst"] <= 1.0
    assert abs(found["drag"]) < 0.012
    assert abs(found["length"]) < 0.004
    assert abs(found["opening"]) < 2.0


@pytest.mark.parametrize(("kind", "which"), [("t90", 6), ("square", 22)])
def test_the_load_across_any_cut_of_it_is_the_drag_behind_it(kind, which):
    """Of netting that does not lie on itself, which hands on load as well."""
    rng = np.random.default_rng(SEED)
    *_, plan = (random_plan(rng, kind) for _ in range(which + 1))
    result = quick(plan.model_copy(update={"model": plan.model.model_copy(update=QUICK)})).cases[0]
    assert len(result.problem.loading.contact.kind) == 0
    net, positions = result.net, result.positions
    load = nodal_loads(result.problem, positions, result.solution.share)[:, 0]
    ends = positions[net.bars, 0]
    along = np.abs(np.diff(ends, axis=1)[:, 0]) / np.linalg.norm(bar_vectors(net, positions), axis=1)
    for cut in np.linspace(0.05, 0.9, 7) * result.measures.length_m:
        crossing = (ends.min(axis=1) < cut) & (ends.max(axis=1) > cut)
        behind = load[positions[:, 0] > cut].sum()
        assert (result.solution.bar_tension * along)[crossing].sum() == pytest.approx(behind, rel=1e-5)
    assert result.measures.entry_reaction_n == pytest.approx(result.measures.drag_n, rel=1e-6)


def test_fish_meet_its_rows_as_far_apart_as_real_ones():
    """A merged row stands for rows about it that need not be a whole number of them."""
    rope = {"number": 6, "shortening": 0.05}
    study = quick(plan_of([tube(around=60)], rope))
    (catch,), (in_memory,) = catches_of(run_of(study), 20.0), catches_in(study, 20.0)
    assert in_memory.rows_ahead == pytest.approx(catch.rows_ahead)
    assert between_ropes(study.plan) == 2.5
    rows = np.unique(np.round(catch.rows_ahead, 9))
    assert np.ptp(np.diff(rows)) < 1.0
    assert len(rows) == pytest.approx(np.ptp(rows) + 1.0, rel=0.25)


def test_it_stands_in_where_nothing_is_found_with_every_mesh_between_ropes(monkeypatch):
    nowhere = Start("nowhere", lambda s: not s.model.between_ropes, _fails)
    merged = [replace(one, applies=partial(_of_merged, one)) for one in standing_in.BETWEEN_ROPES]
    monkeypatch.setattr(standing_in, "BETWEEN_ROPES", (nowhere, *merged))
    monkeypatch.setattr(standing_in, "MOST_RELAXED", 0)
    rng = np.random.default_rng(SEED)
    _, plan = (random_plan(rng, "t90") for _ in range(2))
    study = solve(plan)
    assert study.choice.fidelity == "sector"
    assert study.table["fidelity"].tolist() == ["globalised"]
    assert study.table["drag_error_n"][0] > 0.01 * study.table["drag_n"][0]
    assert any("1.75 x 1.75 merged into one" in sentence for sentence in cautions(study))


def _of_merged(start: Start, situation: Situation) -> bool:
    return situation.model.between_ropes and start.applies(situation)


def _fails(situation: Situation) -> Solution:
    found = situation.sector_all_round
    return replace(found, report=replace(found.report, outcome=Outcome.NOT_IMPROVING))
