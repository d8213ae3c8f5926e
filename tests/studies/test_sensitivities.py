"""Derivatives by the tangent are those of full solves and of dimensions; kinks are told; intervals follow from them."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm, qmc

from codend.equilibrium.fidelity import choose
from codend.errors import InputError
from codend.plan.numbers import alone, changed, numbers_of
from codend.plan.plan import plan_from_dict
from codend.selectivity.escape.species import example_species_path, load_species
from codend.studies.many import sweep
from codend.studies.sensitivity.derivatives import sensitivity_of
from codend.studies.sensitivity.solved_case import quantities, solved_case
from codend.studies.sensitivity.table import case_sensitivities, sensitivities
from codend.studies.sensitivity.uncertain import interval_table
from codend.studies.study import solve
from codend.studies.study_file import study_from_dict
from tests.cli.test_cli import codend_cli
from tests.plans import joined_plan, make_plan
from validation.derivatives import KINDS, compared, random_plan

STIFF = {"knot_mm": 6.0, "bending_stiffness_n_m2": 5e-5}
PLANS = {
    "T0 of elastic twine, a volume": make_plan(netting={"axial_stiffness_n": 2000.0}, catch={"volume_m3": 0.02}),
    "T90 of stiff twine, its front": make_plan(mesh="t90", netting=STIFF, catch={"front_from_codline_m": 0.4}),
    "square, a mass": make_plan(mesh="square", catch={"mass_kg": 10.0, "density_kg_m3": 1050.0}),
    "joined, with a strap": joined_plan(
        ("diamond", 24, 12, 40.0, {}),
        ("t90", 12, 10, 50.0, {"knot_mm": 5.0}),
        catch={"filled_meshes": 5.3},
        strap=[{"meshes_from_codline": 4, "length_m": 0.8, "diameter_mm": 10.0}],
    ),
}


def of_one_case(plan, species=(), keys=None):
    found = sensitivity_of(plan, plan.cases()[0], species, keys)
    assert found is not None
    return found


@pytest.mark.parametrize("name", PLANS)
def test_derivatives_are_differences_of_full_solves(name):
    plan, species = PLANS[name], [load_species(example_species_path())]
    choice, base = choose(plan), solved_case(alone(plan, plan.cases()[0]), choose(plan))
    keys = [one.key for one in numbers_of(plan, plan.cases()[0]) if not one.counted and one.value != 0.0]
    for one in of_one_case(plan, species, keys).numbers:
        number, told = one.number, []
        step = 1e-5 * number.value
        for steps in (-2, -1, 1, 2):
            case = solved_case(changed(base.plan, number.key, number.value + steps * step), choice, base.solution)
            told.append(quantities(case, species))
        for quantity, value in quantities(base, species).items():
            first, second, third, last = (each[quantity] for each in told)
            difference = (first - last + 8.0 * (third - second)) / (12.0 * step)
            allowed = 1e-5 * max(abs(difference), 1e-2 * value / number.value)
            assert one.slope[quantity] == pytest.approx(difference, abs=allowed), (number.key, quantity)


@pytest.mark.parametrize("kind", ["ropes", "windows", "layers"])
def test_derivatives_of_nets_with_more_than_their_netting_are_differences_of_full_solves(kind):
    plan = random_plan(
        kind, np.random.default_rng([0, KINDS.index(kind), {"ropes": 5, "windows": 0, "layers": 3}[kind]])
    )
    rows = [row for row in compared(kind, plan, load_species(example_species_path())) if not row.kink]
    assert {row.key.split(".")[0] for row in rows} >= {"netting", kind[:-1], "tow", "catch"}
    assert max(row.error for row in rows if row.quantity != "sr_cm") < 1e-5


def test_tensions_that_change_alone_have_a_derivative():
    # limp twine that does not stretch: the speed moves no knot
    plan = random_plan("windows", np.random.default_rng([0, KINDS.index("windows"), 3]))
    found = of_one_case(plan, keys=["tow.speed_m_s"])
    assert found.numbers[0].slope["drag_n"] == pytest.approx(
        2.0 * found.told["drag_n"] / plan.tow.speed_m_s[0], rel=1e-8
    )


@pytest.mark.parametrize("mesh", ["diamond", "t90", "square"])
def test_derivatives_by_all_lengths_add_to_what_dimensions_say(mesh):
    """With inextensible twine, drag goes as water V^2 length^2, volume as length^3, and openings do not change."""
    found = of_one_case(make_plan(mesh=mesh, filled=5.3, netting={} if mesh == "square" else {"knot_mm": 5.0}))
    for quantity, power in (("drag_n", 2.0), ("catch_volume_m3", 3.0), ("opening_ahead_deg", 0.0)):
        share = {one.number.key: one.slope[quantity] * one.number.value / found.told[quantity] for one in found.numbers}
        by_lengths = sum(part for key, part in share.items() if key.endswith(("_mm", "_m")))
        assert by_lengths == pytest.approx(power, abs=1e-6)
        assert share["tow.speed_m_s"] == pytest.approx(2.0 if quantity == "drag_n" else 0.0, abs=1e-6)
        assert share["tow.water_density_kg_m3"] == pytest.approx(1.0 if quantity == "drag_n" else 0.0, abs=1e-6)


def test_a_front_on_a_row_of_knots_is_told_and_either_side_solved():
    plan = make_plan(filled=6.0)
    (one,) = of_one_case(plan, keys=["catch.filled_meshes"]).numbers
    assert one.one_sided
    assert one.note == "here the front of the catch passes a row of knots"
    for side, sign in ((one.below, -1), (one.above, 1)):
        (beside,) = of_one_case(make_plan(filled=6.0 + sign * 1e-3), keys=["catch.filled_meshes"]).numbers
        assert not beside.one_sided
        assert side["drag_n"] == pytest.approx(beside.slope["drag_n"], rel=1e-3)
    assert abs(one.above["drag_n"] / one.below["drag_n"] - 1.0) > 1e-2


def test_the_nearest_kink_is_told_in_proportion():
    plan = make_plan(filled=6.01)
    (one,) = of_one_case(plan, keys=["catch.filled_meshes"]).numbers
    assert one.kink_below == pytest.approx(6.0, abs=1e-6)
    assert one.kink_above == pytest.approx(6.5, abs=1e-6)
    assert one.note == "at 0.17 % less the front of the catch passes a row of knots"


def test_counts_are_differences_of_one():
    plan = make_plan()
    (one,) = of_one_case(plan, keys=["netting.0.meshes_round"]).numbers
    drag = [solve(changed(plan, one.number.key, count)).table["drag_n"][0] for count in (23, 24, 25)]
    assert one.one_sided
    assert one.above["drag_n"] == pytest.approx(drag[2] - drag[1], rel=1e-5)
    assert one.below["drag_n"] == pytest.approx(drag[1] - drag[0], rel=1e-5)


def test_counts_of_nets_with_ropes_step_to_the_next_that_leaves_the_ropes_alike():
    tables = make_plan(meshes_long=10, netting={"axial_stiffness_n": 2000.0}, filled=3.3).to_dict()
    rope = {"kind": "lastridge", "number": 4, "shortening": 0.05, "axial_stiffness_n": 5000.0}
    (found,) = of_one_case(plan_from_dict(tables | {"rope": [rope]}), keys=["netting.0.meshes_round"]).numbers
    assert found.note == "over 4 fewer, the next of a narrow sector; over 4 more, the next of a narrow sector"
    assert found.below["drag_n"] == pytest.approx(found.above["drag_n"], rel=0.3)


def test_a_number_at_its_end_is_asked_towards_the_other_side():
    plan = make_plan(netting={"bending_stiffness_n_m2": 0.0, "rest_opening_deg": 40.0})
    (one,) = of_one_case(plan, keys=["netting.0.bending_stiffness_n_m2"]).numbers
    assert (one.one_sided, one.note) == (True, "the plan allows no smaller value")
    stiffer = solve(changed(plan, one.number.key, 1e-7)).table["opening_ahead_deg"][0]
    assert one.slope["opening_ahead_deg"] * 1e-7 == pytest.approx(
        stiffer - solve(plan).table["opening_ahead_deg"][0], rel=1e-2
    )


def test_numbers_are_those_that_a_plan_names_but_not_of_its_model():
    plan = make_plan(catch={"volume_m3": [0.01, 0.02]}, netting={"knot_mm": 0.0})
    assert [number.key for number in numbers_of(plan, plan.cases()[1])] == [
        "tow.speed_m_s",
        "catch.volume_m3",
        "tow.water_density_kg_m3",
        "entry.radius_m",
        "netting.0.meshes_round",
        "netting.0.meshes_long",
        "netting.0.bar_mm",
        "netting.0.twine_mm",
        "drag.normal",
        "drag.tangential",
    ]


def test_a_full_net_and_its_sector_have_the_same_derivatives():
    keys = ["netting.0.bar_mm", "drag.normal"]
    plans = [make_plan(8, 8, filled=3.3, model={"fidelity": fidelity}) for fidelity in ("sector", "full")]
    sector, full = (of_one_case(plan, keys=keys).numbers for plan in plans)
    for one, other in zip(sector, full, strict=True):
        assert one.slope["drag_n"] == pytest.approx(other.slope["drag_n"], rel=1e-6)


def test_an_interval_is_that_of_the_numbers_and_names_the_one_to_measure():
    plan = make_plan(filled=5.3)
    uncertain = {"tow.speed_m_s": 0.1, "netting.0.twine_mm": 0.01}
    table = interval_table(case_sensitivities(plan, keys=list(uncertain)), uncertain).set_index("quantity")
    drag = table.loc["drag_n"]
    assert drag["measure_better"] == "tow.speed_m_s"
    # drag goes as the square of the speed
    assert drag["standard_deviation"] * drag["share"] ** 0.5 == pytest.approx(0.2 * drag["value"], rel=1e-6)
    assert drag["upper_95"] - drag["value"] == pytest.approx(1.959964 * drag["standard_deviation"])
    assert table.loc["opening_ahead_deg", "measure_better"] == "netting.0.twine_mm"


def test_an_interval_is_that_of_plans_drawn_at_random():
    plan = make_plan(filled=5.3)
    uncertain = {"tow.speed_m_s": 0.02, "netting.0.twine_mm": 0.05, "netting.0.bar_mm": 0.01}
    table = interval_table(case_sensitivities(plan, keys=list(uncertain)), uncertain).set_index("quantity")
    own = {number.key: number.value for number in numbers_of(plan, plan.cases()[0])}
    plans = []
    for shares in qmc.Sobol(len(uncertain), seed=1).random(64):
        found = plan
        for (key, relative), share in zip(uncertain.items(), shares, strict=True):
            found = changed(found, key, own[key] * (1.0 + relative * norm.ppf(share)))
        plans.append(found)
    found = sweep(plans)
    for name in ("drag_n", "catch_volume_m3", "opening_ahead_deg"):
        assert found[name].std() == pytest.approx(table.loc[name, "standard_deviation"], rel=0.1), name


def test_an_unknown_number_is_refused_with_those_there_are():
    with pytest.raises(InputError, match=r"netting.0.twine_cm is no number that the plan gives"):
        sensitivities(make_plan(), keys=["netting.0.twine_cm"])
    plan = make_plan().to_dict()
    with pytest.raises(InputError, match=r"uncertain.netting.0.twine is no number .* \(did you mean netting.0.twines"):
        study_from_dict({"plan": plan, "uncertain": {"netting.0.twine": 0.1}})
    with pytest.raises(InputError, match=r"uncertain.netting.0.twine_mm = 3 is not allowed"):
        study_from_dict({"plan": plan, "uncertain": {"netting.0.twine_mm": 3}})


def test_the_command_writes_tables_figure_and_page(tmp_path):
    plan = make_plan(filled=[3.3, 5.3])
    study = tmp_path / "study.toml"
    (tmp_path / "plan.toml").write_text(_toml(plan), encoding="utf-8")
    study.write_text('plan = "plan.toml"\n[uncertain]\n"netting.0.twine_mm" = 0.05\n', encoding="utf-8")
    result = codend_cli("sensitivities", study, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "measure netting.0.twine_mm better, which makes 100 % of the variance" in result.output
    table = pd.read_csv(tmp_path / "out" / "sensitivities.csv")
    assert list(table.columns[:6]) == ["case", "quantity", "key", "value", "derivative", "one_sided"]
    assert len(table) == 2 * 3 * table["key"].nunique()
    assert {"intervals.csv", "tornado.png", "sensitivities.html"} <= {p.name for p in (tmp_path / "out").iterdir()}


def _toml(plan):
    from codend.plan.copy import plan_toml

    return plan_toml(plan_from_dict(plan.to_dict()))


def test_a_sweep_of_uncertain_plans_has_intervals_of_every_design(tmp_path):
    (tmp_path / "plan.toml").write_text(_toml(make_plan(filled=5.3)), encoding="utf-8")
    tables = '[vary]\n"netting.0.bar_mm" = [40.0, 44.0]\n[uncertain]\n"netting.0.twine_mm" = 0.05\n'
    (tmp_path / "study.toml").write_text(f'plan = "plan.toml"\n{tables}', encoding="utf-8")
    result = codend_cli("sweep", tmp_path / "study.toml", "--workers", "1", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    intervals = pd.read_csv(tmp_path / "out" / "intervals.csv")
    sweep = pd.read_csv(tmp_path / "out" / "sweep.csv")
    drag = intervals[intervals["quantity"] == "drag_n"]
    assert drag["run"].tolist() == [1, 2]
    assert drag["value"].tolist() == pytest.approx(sweep["drag_n"].tolist(), rel=1e-5)
    assert ((drag["lower_95"] < drag["value"]) & (drag["value"] < drag["upper_95"])).all()
