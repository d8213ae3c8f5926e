"""Whether an equilibrium is stable, and how a run passes that on."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from click.testing import CliRunner

from codend.cli.main import main
from codend.equilibrium import solve as equilibrium
from codend.equilibrium import stability
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.followed import HANGS_ASIDE
from codend.equilibrium.stability import Stability, stability_of_whole
from codend.equilibrium.wrinkles import BY_SWINGING, changed_by_wrinkles, may_hang_aside
from codend.plan.plan import plan_from_dict
from codend.report.html import cautions, notes
from codend.report.page_tables import solving_table
from codend.solvers import newton, whole_tangent
from codend.solvers.harmonics import stiffness_under_tension
from codend.solvers.whole_tangent import WholeTangent
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from tests.plans import make_plan
from validation import pushed
from validation.shaken import QUANTITIES, wrinkling_plan
from validation.stability.linear import tangent_of
from validation.weight_left_out import weighed_plan

FOLDING = """
title = "Square netting whose slack rings would fold"
tow = { speed_m_s = 1.0, water_density_kg_m3 = 1000.0 }
entry = { radius_m = 0.1 }
netting = [{ mesh = "square", meshes_round = 36, meshes_long = 10, bar_mm = 40.0, twine_mm = 2.0 }]
catch = { filled_meshes = [1.2, 5.0] }
model = { fidelity = "full" }
"""


def test_a_bag_that_turns_for_nothing_behind_a_closed_neck_is_not_called_unstable_for_round_off():
    """The turn's eigenvalue is 0 within round-off; without the shift a third of these had a negative pivot."""
    for meshes_round in (40, 48, 56, 64):
        for entry in (0.2, 0.3, 0.4, 0.5, 0.6):
            plan = make_plan(meshes_round, 250, entry, 4.0, model={"fidelity": "sector"})
            (result,) = solve(plan).cases
            assert result.converged
            assert result.stability.stable == "yes", (meshes_round, entry)


SQUARE = [("square", 36, entry, filled, 0.0) for entry, filled in ((0.4, 5.0), (0.7, 1.2), (0.4, 1.2))]
T90 = [("t90", 16, entry, filled, knot_mm) for entry, knot_mm in ((0.3, 20.0), (0.6, 10.0)) for filled in (1.5, 4.0)]


@pytest.mark.parametrize("dense", [0, 10_000])
@pytest.mark.parametrize(("mesh", "meshes_round", "entry", "filled", "knot_mm"), [*SQUARE, *T90])
def test_a_full_net_is_stable_where_the_dense_tangent_has_no_eigenvalue_in_the_left_half(
    mesh, meshes_round, entry, filled, knot_mm, dense, monkeypatch
):
    """Symmetric shapes, one of which is unstable in six directions: an even number, which no determinant shows."""
    monkeypatch.setattr(whole_tangent, "DENSE", dense)
    netting = {"knot_mm": knot_mm}
    plan = make_plan(meshes_round, 10, entry, filled, mesh=mesh, netting=netting, model={"fidelity": "full"})
    model = model_of(plan, 1, None)
    problem, solution = equilibrium.solve(model, plan.cases()[0], (), None)
    assert solution.report.outcome.converged
    running_away = np.count_nonzero(np.linalg.eigvals(tangent_of(problem, solution)).real < 0.0)
    tangent = newton.tangent_at(problem, solution, model.prepared)
    assert stability_of_whole(tangent) == ("no" if running_away else "yes")


@pytest.mark.parametrize("catch", [{"front_from_codline_m": 0.15}, {"volume_m3": 0.01}])
@pytest.mark.parametrize(
    ("mesh", "meshes_round", "knot_mm"), [("diamond", 24, 0.0), ("square", 24, 0.0), ("t90", 16, 10.0)]
)
def test_so_it_is_where_the_front_follows_the_net(catch, mesh, meshes_round, knot_mm, monkeypatch):
    """Its tangent is held to finite differences elsewhere; here the search for eigenvalues to all of them."""
    netting = {"knot_mm": knot_mm}
    plan = make_plan(meshes_round, 10, 0.6, mesh=mesh, netting=netting, catch=catch, model={"fidelity": "full"})
    model = model_of(plan, 1, None)
    problem, solution = equilibrium.solve(model, plan.cases()[0], (), None)
    assert solution.report.outcome.converged
    tangent = newton.tangent_at(problem, solution, model.prepared)
    assert tangent.products == 1
    whole = WholeTangent.at(tangent)
    monkeypatch.setattr(whole_tangent, "DENSE", 0)
    growing = whole.growing(stiffness_under_tension(problem, solution))
    assert (len(growing.eigenvalues) > 0) == (np.linalg.eigvals(whole.dense()).real.min() < 0.0)
    symmetric = 0.5 * (whole.dense() + whole.dense().T)
    factors = whole._factors(0.0)
    counted = whole._negative_eigenvalues(factors, whole_tangent._negative_pivots(factors), None)
    assert counted == np.count_nonzero(np.linalg.eigvalsh(symmetric) < 0.0)


@cache
def whole_and_sector() -> tuple[CaseResult, CaseResult]:
    """A net that swings on its hoop beside wrinkles that grow half a million times as strongly."""
    tables = wrinkling_plan(2023).to_dict()
    plans = [plan_from_dict(tables | {"model": {"fidelity": name, "wrinkles": False}}) for name in ("full", "sector")]
    whole, sector = (solve(plan).cases[0] for plan in plans)
    return whole, sector


def test_errors_of_a_full_net_know_of_all_that_grows_as_those_of_its_sector_do():
    whole, sector = whole_and_sector()
    assert whole.stability.growing == sector.stability.growing == (1, 2, 3, 4, 5, 6)
    for error in QUANTITIES.values():
        assert getattr(whole.errors, error) == pytest.approx(getattr(sector.errors, error), rel=1e-3)
    assert sector.errors.opening_ahead_error_deg > 3.9


def test_where_no_sector_stands_for_a_full_net_all_of_its_growing_moves_are_found():
    whole, sector = whole_and_sector()
    tangent = newton.tangent_at(whole.problem, whole.solution, model_of(wrinkling_plan(2023), 1, None).prepared)
    scale = stiffness_under_tension(whole.problem, whole.solution)
    found = WholeTangent.at(tangent).growing(scale, thorough=True)
    assert found.complete
    # 1 to 5 twice, of 12 round the 6th once
    assert len(found.eigenvalues) == 11
    of_harmonics = [growth.eigenvalues[0].real for growth in sector.stability.growths]
    assert found.eigenvalues.real.max() == pytest.approx(max(of_harmonics), rel=1e-2)
    assert found.eigenvalues.real.min() == pytest.approx(min(of_harmonics), rel=1e-6)
    first = WholeTangent.at(tangent).growing(scale)
    assert not first.complete
    assert len(first.eigenvalues) < 11


def test_what_was_not_found_may_swing_the_bag_and_reach_any_row():
    whole, _ = whole_and_sector()
    first = whole.stability.growths[-1:]
    changed = [
        changed_by_wrinkles(
            whole.bag, whole.case, whole.solution, replace(whole.stability, growths=first, complete=known),
            whole.measures, touching=False,
        )
        for known in (True, False)
    ]  # fmt: skip
    assert (changed[1] > changed[0] + 0.9 * BY_SWINGING * whole.measures.estimated).all()


def test_errors_of_square_mesh_that_sways_easily_cover_the_stable_shape_beside_its_stable_one():
    """A small part of ``python -m validation.pushed``."""
    row = pushed.row_of(weighed_plan(46, 13)[0])
    assert row["sway"] == pytest.approx(0.036, abs=1e-3)
    assert (row["ends"], row["stable"]) == ("settled", "yes")
    assert row["hangs aside"] > 0.4
    assert row["drag_n"] > 0.07
    assert max(row[f"{name} over its error"] for name in QUANTITIES) <= 0.6


def test_a_whole_net_sways_as_its_sector_does_and_says_that_it_may_hang_aside():
    for tables in (weighed_plan(46, 13)[0].to_dict(), weighed_plan(46, 9)[0].to_dict()):
        whole, sector = (
            solve(plan_from_dict(tables | {"model": {"fidelity": name, "wrinkles": False}})).cases[0]
            for name in ("full", "sector")
        )
        tangent = newton.tangent_at(whole.problem, whole.solution, model_of(whole_plan(tables), 1, None).prepared)
        assert stability._sway_of_whole(whole.bag, tangent) == pytest.approx(sector.stability.sway_n_m, rel=1e-4)
        aside = may_hang_aside(sector.stability, sector.measures)
        assert (HANGS_ASIDE in (whole.followed.reason, sector.followed.reason)) == aside
        assert whole.errors.drag_error_n == pytest.approx(sector.errors.drag_error_n, rel=0.01, abs=1e-5)


def whole_plan(tables):
    return plan_from_dict(tables | {"model": {"fidelity": "full"}})


def test_a_run_says_on_its_page_and_in_the_end_which_net_in_balance_is_not_stable(tmp_path):
    (tmp_path / "plan.toml").write_text(FOLDING)
    result = CliRunner().invoke(main, ["run", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    said = "In balance, but not stable by the eigenvalues of the tangent: 1 case of 2 (2)."
    # a machine at work on other things is told of progress first
    told = [line for line in result.stderr.splitlines() if " of 2 done, " not in line]
    assert told[0].startswith(said)
    assert said in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_only_what_grows_makes_a_net_unstable():
    study = solve(make_plan(24, 20, filled=[4.0, 6.0, 8.0]))
    assert cautions(study) == []
    answers = Stability("unknown"), Stability("yes"), Stability("no", (2, 9, 10, 11))
    known = zip(study.cases, answers, strict=True)
    study = replace(study, cases=tuple(replace(case, stability=answer) for case, answer in known))
    (said,) = cautions(study)
    assert said in notes(study)
    assert "1 case of 3 (3)" in said
    assert "2, 9 to 11 times round" in said
    assert study.table["stable"].tolist() == ["unknown", "yes", "no"]
    assert study.table["growing_harmonics"].fillna("").tolist() == ["", "", "2, 9 to 11"]
    assert set(study.table["sector_order"]) == {24}
    assert set(study.table["sector_meshes"]) == {1}
    stable = [head.name for head in solving_table(study).heads].index("Stable")
    assert [row.cells[stable] for row in solving_table(study).rows] == ["not sure", "yes", "no (2, 9 to 11)"]
