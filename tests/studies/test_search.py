"""The least change that reaches a target: what brute force finds, whole counts, and said where no design does."""

from itertools import product

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import brentq

import codend.studies.search.search
from codend.errors import InputError
from codend.plan.copy import plan_toml
from codend.plan.numbers import changed
from codend.plan.plan import load_plan
from codend.selectivity.escape.species import example_species_path
from codend.studies.search.asked import asked_of
from codend.studies.search.search import search
from codend.studies.search.table import ended
from codend.studies.sensitivity.derivatives import derivatives_at
from codend.studies.study import solve
from codend.studies.study_file import study_from_dict
from tests.cli.test_cli import assert_refused, codend_cli
from tests.plans import make_plan

PLAN = make_plan(filled=5.3)
ROUND, BAR = "netting.0.meshes_round", "netting.0.bar_mm"
GRID = {ROUND: {"least": 20, "most": 28}, BAR: {"least": 36.0, "most": 44.0, "step": 1.0}}


def found_of(plan=PLAN, **table):
    study = study_from_dict({"plan": plan.to_dict(), "species": [str(example_species_path())], "search": table})
    return search(asked_of(study))


@pytest.mark.parametrize(
    ("target", "limits"),
    [({"drag_n": 60.0}, {}), ({"opening_ahead_deg": {"least": 37.0}}, {"catch_volume_m3": {"least": 0.03}})],
)
def test_a_search_finds_what_brute_force_over_the_same_grid_finds(target, limits):
    found = found_of(change=[ROUND, BAR], target=target, limits={**GRID, **limits})
    best = (np.inf, None)
    for count, bar in product(range(20, 29), np.arange(36.0, 44.5)):
        row = solve(changed(changed(PLAN, ROUND, count), BAR, float(bar))).table.iloc[0]
        change = np.hypot(count / 24 - 1.0, bar / 40.0 - 1.0)
        if all(one.margin(row[one.quantity]) >= -1e-4 for one in found.conditions) and change < best[0]:
            best = (change, (count, bar))
    assert found.best is not None
    assert tuple(found.best.values.values()) == best[1]
    assert len(found.looked_at) < 81


def test_a_real_number_is_changed_no_more_than_it_takes():
    found = found_of(change=[BAR, "netting.0.twine_mm"], target={"l50_cm": 13.5}, within=0.4)
    assert found.best is not None
    told = found.best.told[0]
    assert told["l50_cm"] == pytest.approx(13.5, rel=1e-4)
    assert "l50_cm 13.5 +- " in ended(found)[1]
    # at the least change, changes are in the ratio of what they do: the gradients point the same way
    assert found.plan is not None
    share = [found.best.values[key] / found.start.values[key] - 1.0 for key in (BAR, "netting.0.twine_mm")]
    slope = []
    for key in (BAR, "netting.0.twine_mm"):
        (one,) = [each for each in _derivatives(found.plan) if each.number.key == key]
        slope.append(one.slope["l50_cm"] * found.start.values[key])
    assert share[0] / share[1] == pytest.approx(slope[0] / slope[1], rel=2e-2)


def _derivatives(plan):
    from codend.selectivity.escape.species import load_species
    from codend.studies.sensitivity.derivatives import sensitivity_of

    found = sensitivity_of(plan, plan.cases()[0], [load_species(example_species_path())], [BAR, "netting.0.twine_mm"])
    assert found is not None
    return found.numbers


def test_a_count_and_a_real_number_do_as_well_as_a_fine_grid():
    limits = {ROUND: {"least": 23, "most": 24}}
    fine = {**limits, BAR: {"least": 30.0, "most": 50.0, "step": 0.5}}
    free = found_of(change=[ROUND, BAR], target={"drag_n": 67.0}, limits=limits)
    grid = found_of(change=[ROUND, BAR], target={"drag_n": 67.0}, limits=fine)
    assert free.best is not None
    assert grid.best is not None
    assert isinstance(free.best.values[ROUND], int)
    assert free.best.values[ROUND] == grid.best.values[ROUND]
    assert grid.best.change - 0.5 / 40.0 <= free.best.change <= grid.best.change + 1e-6


def test_a_count_and_a_real_number_are_those_of_the_least_root_over_all_counts(monkeypatch):
    asked = []

    def counted(case, *words):
        asked.append(case.plan)
        return derivatives_at(case, *words)

    monkeypatch.setattr(codend.studies.search.search, "derivatives_at", counted)
    found = found_of(change=[ROUND, BAR], target={"drag_n": 60.0})
    changes = {}
    for count in range(18, 31):
        plan = changed(PLAN, ROUND, count)

        def missed(bar, plan=plan):
            return solve(changed(plan, BAR, bar)).table["drag_n"][0] - 60.0

        if missed(30.0) < 0.0 < missed(50.0):
            changes[count] = np.hypot(count / 24 - 1.0, brentq(missed, 30.0, 50.0, xtol=1e-4) / 40.0 - 1.0)
    assert len(changes) > 5
    assert found.best is not None
    assert found.best.values[ROUND] == min(changes, key=changes.__getitem__)
    assert found.best.change == pytest.approx(min(changes.values()), rel=2e-3)
    assert found.best.change <= min(changes.values()) * (1.0 + 1e-4) + 1e-5
    assert len(asked) <= len(found.looked_at), "slopes of a design are found once"


def test_a_target_at_several_catches_holds_at_each():
    plan = make_plan(filled=[4.3, 5.3])
    found = found_of(plan, change=[BAR], target={"drag_n": {"most": 45.0}})
    assert found.best is not None
    assert max(told["drag_n"] for told in found.best.told) == pytest.approx(45.0, rel=1e-4)
    assert [told["drag_n"] for told in found.best.told] == pytest.approx(
        solve(found.plan).table["drag_n"].tolist(), rel=1e-5
    )


def test_a_plan_that_meets_the_target_stays_as_it_is():
    found = found_of(change=[BAR], target={"drag_n": {"most": 1e4}})
    assert found.best is not None
    assert found.best.change == 0.0
    first, second = ended(found)
    assert first == "The plan as it is has drag_n at most 10000."
    assert second.startswith("As codend run tells it: drag_n 71.95 +- ")


def test_what_was_reached_stands_with_its_error_and_says_where_the_net_wrinkles():
    stiff = {"bending_stiffness_n_m2": 1e-3, "knot_mm": 5.0, "twine_mm": 1.0}
    plan = make_plan(bar_mm=25.0, entry=0.37, filled=6.0, netting=stiff, model={"wrinkles": False})
    found = found_of(plan, change=["netting.0.twine_mm"], target={"drag_n": {"most": 1e3}})
    (case,) = found.cases
    assert case.unstable
    _, known, wrinkles = ended(found)
    assert f"+- {case.errors.drag_error_n:.2g}" in known
    assert wrinkles == "The shape is not stable (case 1): the errors cover what wrinkles change."


def test_a_target_that_no_design_meets_is_said(tmp_path):
    (tmp_path / "plan.toml").write_text(plan_toml(PLAN), encoding="utf-8")
    search_toml = f'plan = "plan.toml"\n[search]\nchange = ["{BAR}"]\ntarget = {{ drag_n = {{ most = 1.0 }} }}\n'
    (tmp_path / "study.toml").write_text(search_toml, encoding="utf-8")
    result = codend_cli("search", tmp_path / "study.toml", "--out", tmp_path / "out")
    assert result.exit_code == 3
    assert "No design within the limits reaches drag_n at most 1" in result.stderr
    assert "The nearest has drag_n" in result.stderr
    assert "netting.0.bar_mm 40 to 30" in result.stderr
    assert not (tmp_path / "out" / "plan.toml").exists()


def test_the_command_writes_the_plan_found_with_the_catch_of_the_target(tmp_path):
    (tmp_path / "plan.toml").write_text(plan_toml(PLAN), encoding="utf-8")
    target = "target = { opening_ahead_deg = 43.0, volume_m3 = 0.02 }"
    (tmp_path / "study.toml").write_text(
        f'plan = "plan.toml"\n[search]\nchange = ["{BAR}"]\n{target}\n', encoding="utf-8"
    )
    result = codend_cli("search", tmp_path / "study.toml", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    plan = load_plan(tmp_path / "out" / "plan.toml")
    assert plan.catch.volume_m3 == (0.02,)
    assert solve(plan).table["opening_ahead_deg"][0] == pytest.approx(43.0, rel=2e-4)
    looked_at = pd.read_csv(tmp_path / "out" / "search.csv")
    assert looked_at["reaches"].any()
    page = (tmp_path / "out" / "search.html").read_text(encoding="utf-8")
    assert "Reached: opening_ahead_deg at" in page
    assert (tmp_path / "out" / "search.png").stat().st_size > 0


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"target": {"drag_n": 1.0}}, r"search.change is missing"),
        ({"change": ["netting.0.bar"], "target": {"drag_n": 1.0}}, r"search.change.0 = \"netting.0.bar\" is no number"),
        (
            {"change": [BAR], "target": {"drag": 1.0}},
            r"search.target.drag = 1.0 is not a known key \(did you mean drag_n",
        ),
        ({"change": [BAR], "target": {}}, r"search.target names nothing to reach"),
        ({"change": [BAR], "target": {"l50_cm": 3.0, "species": "whale"}}, r"search.target.species = \"whale\" is not"),
        (
            {"change": [BAR], "target": {"drag_n": 1.0}, "limits": {BAR: {"least": 50}}},
            r"bounds with the plan's own 40 between them",
        ),
        ({"change": [ROUND], "target": {"drag_n": 1.0}, "limits": {ROUND: {"least": 20.5}}}, r"whole numbers"),
    ],
)
def test_mistakes_are_one_line_each(table, said):
    with pytest.raises(InputError, match=said):
        found_of(**table)


@pytest.mark.parametrize("name", ["Example round fish (assumed)", "species_example"])
def test_a_species_is_named_as_it_or_its_file_is_called(name):
    table = {"change": [BAR], "target": {"l50_cm": 10.0, "species": name}}
    study = study_from_dict({"plan": PLAN.to_dict(), "species": [str(example_species_path())], "search": table})
    assert asked_of(study).species == study.species


def test_a_study_without_a_search_is_refused(tmp_path):
    (tmp_path / "plan.toml").write_text(plan_toml(PLAN), encoding="utf-8")
    (tmp_path / "study.toml").write_text('plan = "plan.toml"\n', encoding="utf-8")
    assert_refused(codend_cli("search", tmp_path / "study.toml", "--out", tmp_path), "search is missing")
