"""Codends of published net plans, as cases."""

from pathlib import Path

import pytest

from codend.equilibrium.fidelity import choose
from codend.plan.amounts import amounts_of
from codend.plan.plan import load_plan
from codend.studies.study import solve

CASES = Path("validation/cases")
PUBLISHED = {
    "bobp_wp20_high_opening": (266, 250, 720.0),
    "bobp_wp13_pair_trawl": (200, 250, 720.0),
    "bobp_wp10_pair_trawl": (320, 200, 720.0),
    "fao_workbook_bottom_trawl": (172, 150, 910.0),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_codends_are_solved_and_weigh_their_twine_times_the_runnage(name):
    meshes_round, meshes_long, rtex = PUBLISHED[name]
    plan = load_plan(CASES / f"{name}.toml", ["model.fidelity=sector", "catch.mass_kg=300"])
    (section,) = plan.netting
    assert (section.meshes_round, section.meshes_long, section.rtex) == (meshes_round, meshes_long, rtex)
    amounts = amounts_of(section)
    assert amounts.twine_m == pytest.approx(4 * meshes_round * meshes_long * section.bar_m)
    assert amounts.mass_kg == pytest.approx(amounts.twine_m * rtex / 1e6)
    assert solve(plan).converged


def test_the_case_with_ropes_is_solved_by_the_quick_look_that_its_accuracy_allows():
    plan = load_plan(CASES / "assumed_two_panels_with_ropes.toml")
    study = solve(plan, choice=choose(plan))
    assert study.choice.fidelity == "smeared"
    assert study.converged
    assert (study.table["max_rope_tension_n"] > 0.0).all()
