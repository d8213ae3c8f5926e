"""Only the hoop at the entry holds a bag: a support that carries what nothing supplies is found."""

from dataclasses import replace

import numpy as np
import pytest

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import measure_all
from codend.equilibrium import fidelity
from codend.mechanics.problem import Problem
from codend.plan.plan import Plan, load_plan, plan_from_dict
from codend.solvers import interior_point
from codend.solvers.outcome import Solution
from codend.solvers.reactions import loads_and_supports
from codend.studies.study import solve
from tests import ROOT
from tests.plans import joined_plan, make_plan

HELD_BY_NOTHING = ROOT / "tests" / "codline_held_by_nothing.toml"
HEAVY = {"twine_density_kg_m3": 1400.0}
PLANS = {
    "T0": make_plan(12, 10, filled=3.0, netting=HEAVY, speed=0.5),
    "T0 weightless": make_plan(12, 10, filled=3.0),
    "T90": make_plan(12, 10, filled=3.0, mesh="t90", netting={**HEAVY, "knot_mm": 6.0}, speed=0.5),
    "square": make_plan(12, 10, filled=3.0, mesh="square", netting=HEAVY, speed=0.5),
    "stiff": make_plan(12, 10, filled=3.0, netting={**HEAVY, "bending_stiffness_n_m2": 1e-4}, speed=0.5),
    "joined": joined_plan(("diamond", 12, 6, 40.0, HEAVY), ("diamond", 13, 6, 40.0, HEAVY)),
}


def solved(plan: Plan, sectors: int | None, *, codline_held: bool = False) -> tuple[Bag, Problem, Solution]:
    bag = build_bag(plan, sectors=sectors)
    if codline_held:
        fixed = bag.net.fixed.copy()
        fixed[-1, 1:] = True
        bag = replace(bag, net=replace(bag.net, fixed=fixed))
    problem = problem_of(bag, plan, plan.cases()[0])
    solution = interior_point.solve(problem, 1e-10)
    assert solution.report.outcome.converged
    return bag, problem, solution


@pytest.mark.parametrize("plan", PLANS)
def test_the_entry_alone_carries_the_loads_of_a_full_net(plan):
    bag, problem, solution = solved(PLANS[plan], None)
    load, support = loads_and_supports(problem, solution)
    entry = bag.held_by_the_entry
    total = np.linalg.norm(load.sum(axis=0))
    assert 0 < entry.sum() < len(entry)
    assert np.abs(support[~entry]).max() <= 1e-9 * total
    assert support[entry].sum(axis=0) == pytest.approx(-load.sum(axis=0), abs=1e-8 * total)
    assert measure_all(bag, problem, solution)[2].sideways_imbalance <= 1e-8


@pytest.mark.parametrize("kind", ["T0", "T90"])
def test_a_sector_balances_sideways_and_about_its_axis(kind):
    bag, problem, solution = solved(PLANS[kind], 1)
    assert measure_all(bag, problem, solution)[2].sideways_imbalance <= 1e-8


def test_a_codline_held_sideways_shows_in_the_balance():
    bag, problem, solution = solved(PLANS["T0"], None, codline_held=True)
    measures = measure_all(bag, problem, solution)[2]
    carried = loads_and_supports(problem, solution)[1][-1, 2]
    assert measures.entry_reaction_n == pytest.approx(measures.drag_n, rel=1e-8)
    assert carried > 0.1 * abs(problem.loading.dead[:, 2].sum())
    assert measures.sideways_imbalance > 0.5 * carried / measures.drag_n


def test_a_bag_with_weight_sags_to_its_codline():
    """Two independent solves of the case gave 4.677 N, 31.15 degrees and a codline 0.45 m down."""
    study = solve(load_plan(HELD_BY_NOTHING))
    result = study.cases[0]
    assert study.choice.fidelity == "full"
    assert result.measures.drag_n == pytest.approx(4.677, abs=5e-4)
    assert result.measures.opening_ahead_deg == pytest.approx(31.15, abs=5e-3)
    assert result.positions[-1] == pytest.approx([result.measures.length_m, 0.0, -0.45], abs=2e-3)
    assert study.table["sideways_imbalance"].item() <= 1e-6


NETTING = {"mesh": "diamond", "meshes_round": 12, "meshes_long": 12, "bar_mm": 40.0, "twine_mm": 2.0, **HEAVY}
ROPE = {"number": 2, "shortening": 0.05, "diameter_mm": 8.0, "density_kg_m3": 2000.0}
STRAP = {"meshes_from_codline": 4.0, "length_m": 0.5, "diameter_mm": 8.0, "density_kg_m3": 2000.0}
WINDOW = {**NETTING, "meshes_round": 4, "meshes_long": 3, "netting": "1", "panel": "upper"}
WINDOW |= {"meshes_from_codline": [5, 8], "meshes_across": 4}
OF_EVERY_KIND = {
    "ropes and a strap": {"rope": [ROPE], "strap": [STRAP]},
    "a heavy catch and ropes": {"rope": [ROPE], "catch": {"filled_meshes": 4.0, "density_kg_m3": 1200.0}},
    "a heavy catch given by its mass": {"catch": {"mass_kg": 8.0, "density_kg_m3": 1200.0}},
    "a window and a heavy catch": {"window": [WINDOW], "catch": {"filled_meshes": 4.0, "density_kg_m3": 1100.0}},
    "panels": {"netting": [{**NETTING, "panels": 2, "selvedge_meshes": 1}]},
    "netting that tapers": {"netting": [{**NETTING, "meshes_round_aft": 8}]},
    "knots that stretch": {
        "netting": [{**NETTING, "knot_mm": 6.0, "axial_stiffness_n": 500.0, "knot_axial_stiffness_n": 500.0}]
    },
    "merged meshes": {"model": {"fidelity": "globalised", "globalisation": 2}},
    "a sector": {"model": {"fidelity": "sector"}},
    "a sector between ropes": {"rope": [ROPE], "model": {"fidelity": "sector"}},
    "ropes smeared": {"rope": [ROPE], "model": {"fidelity": "smeared"}},
}


def tables(**changed: object) -> dict:
    data = {
        "title": "held",
        "tow": {"speed_m_s": 0.6, "water_density_kg_m3": 1000.0},
        "entry": {"radius_m": 0.08},
        "netting": [NETTING],
        "catch": {"filled_meshes": 4.0},
    }
    return {**data, **changed, "model": {"tolerance": 1e-9, "wrinkles": False, **changed.get("model", {})}}  # type: ignore[dict-item]


@pytest.mark.parametrize("kind", OF_EVERY_KIND)
def test_of_models_of_every_kind_no_free_node_carries_anything_and_the_entry_all(kind):
    result = solve(plan_from_dict(tables(**OF_EVERY_KIND[kind]))).cases[0]
    assert result.converged
    load, support = loads_and_supports(result.problem, result.solution)
    entry, size = result.bag.held_by_the_entry, np.abs(load).sum()
    if result.net.order > 1:
        support[len(support) - 1 - result.bag.anchors, 1:] = 0.0  # the images of a sector take that off
    assert np.abs(support[~entry]).max() <= 1e-8 * size
    assert result.measures.sideways_imbalance <= 1e-7


def test_straps_and_ropes_weigh_what_they_are_long_and_thick():
    plan = plan_from_dict(tables(netting=[{**NETTING, "twine_density_kg_m3": None}], rope=[ROPE], strap=[STRAP]))
    long_m = 0.5 + 2 * 0.95 * 24 * 0.04
    expected = 9.80665 * 1000.0 * np.pi / 4.0 * 0.008**2 * long_m
    choice = fidelity.choose(plan)
    problem = problem_of(build_bag(plan), plan, plan.cases()[0])
    assert -problem.loading.dead.sum() == pytest.approx(expected, rel=1e-9)
    assert choice.weight_n == pytest.approx(expected, rel=1e-9)
    assert choice.fidelity == "full"
