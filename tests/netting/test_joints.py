"""Sections of different mesh counts and kinds, laced together: the net as it is written, and its equilibria."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from codend.bag.bag import Bag, all_round
from codend.bag.build import build_bag
from codend.bag.measures import Measures, measure_all, opening_rows_ahead
from codend.equilibrium import fidelity
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.situation import Situation
from codend.equilibrium.solve import solve as solve_case
from codend.net.net import facet_corners
from codend.plan.plan import Plan
from codend.report.choice_words import reason_text
from codend.solvers import interior_point, newton
from codend.solvers.outcome import Outcome, Solution
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from tests.plans import NO_DRAG, UNIFORM, joined_plan
from validation.reference import residual

KNOT = {"knot_mm": 5.0}
STIFF = {"bending_stiffness_n_m2": 2e-6, "rest_opening_deg": 30.0}
ELASTIC = {"axial_stiffness_n": 1500.0}
Sections = tuple[tuple[str, int, int, float, dict[str, Any]], ...]
SMALL: dict[str, Sections] = {
    "5 to 3": (("diamond", 20, 6, 40.0, {}), ("diamond", 12, 8, 40.0, {})),
    "3 to 5, knotted": (("diamond", 12, 6, 40.0, KNOT), ("diamond", 20, 8, 40.0, KNOT)),
    "T0 to fewer T90": (("diamond", 20, 6, 40.0, {}), ("t90", 12, 8, 40.0, KNOT)),
    "T90 to fewer T0": (("t90", 20, 6, 40.0, KNOT), ("diamond", 12, 8, 40.0, KNOT)),
    "square between diamonds": (
        ("diamond", 20, 6, 40.0, {}),
        ("square", 20, 7, 40.0, {}),
        ("diamond", 16, 4, 40.0, {}),
    ),
    "T90 to as many squares": (("t90", 20, 6, 40.0, KNOT), ("square", 20, 7, 40.0, {})),
}
USUAL: dict[str, Sections] = {
    "100 to 60": (("diamond", 100, 10, 40.0, {}), ("diamond", 60, 10, 40.0, {})),
    "120 to 60, knotted": (("diamond", 120, 10, 40.0, KNOT), ("diamond", 60, 10, 60.0, KNOT)),
    "60 to 100, elastic": (("diamond", 60, 10, 40.0, ELASTIC), ("diamond", 100, 10, 40.0, ELASTIC)),
    "90 to 60 to 45": (("diamond", 90, 6, 40.0, {}), ("diamond", 60, 4, 40.0, KNOT), ("diamond", 45, 10, 40.0, {})),
    "100 T0 to 50 T90": (("diamond", 100, 10, 40.0, KNOT), ("t90", 50, 10, 40.0, KNOT)),
    "50 T90 to 100 T0": (("t90", 50, 10, 40.0, KNOT), ("diamond", 100, 10, 40.0, KNOT)),
    "50 T90 to 40, elastic": (("t90", 50, 10, 40.0, KNOT | ELASTIC), ("t90", 40, 10, 40.0, KNOT | ELASTIC)),
    "diamonds to as many squares": (("diamond", 60, 10, 40.0, KNOT), ("square", 60, 10, 40.0, {})),
    "squares to fewer diamonds": (("square", 60, 11, 40.0, {}), ("diamond", 40, 10, 40.0, {})),
    "100 to 60, stiff": (("diamond", 100, 10, 40.0, STIFF), ("diamond", 60, 10, 40.0, STIFF)),
}


def closure(bag: Bag) -> tuple[np.ndarray, float, float]:
    """Sum of the area vectors all round, area of the entry's polygon, least outward area."""
    net = bag.net
    corner = facet_corners(net, net.positions)
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
    outward = np.einsum("ij,ij->i", area[:, 1:], corner.mean(axis=1)[:, 1:])
    entry = all_round(bag, net.positions).positions[np.tile(net.fixed.all(axis=1), net.order)]
    azimuth = np.sort(np.arctan2(entry[:, 2], entry[:, 1]))
    gaps = np.diff(np.append(azimuth, azimuth[0] + 2 * np.pi))
    lid = 0.5 * np.hypot(entry[0, 1], entry[0, 2]) ** 2 * np.sin(gaps).sum()
    total = (area * net.facet_weight[:, None]).sum(axis=0) * [net.order, net.order == 1, net.order == 1]
    return total, lid, float(outward.min())


@pytest.mark.parametrize("sections", SMALL.values(), ids=SMALL)
def test_facets_close_the_bag_across_a_joint_and_face_outward(sections):
    plan = joined_plan(*sections)
    for sectors in (1, 2, None):
        total, lid, outward = closure(build_bag(plan, sectors=sectors))
        assert total == pytest.approx([lid, 0.0, 0.0], abs=1e-12)
        assert outward > -1e-12


@pytest.mark.parametrize("sections", SMALL.values(), ids=SMALL)
def test_a_sector_of_joined_sections_repeated_all_round_is_the_full_net(sections):
    plan = joined_plan(*sections)
    full, sector = build_bag(plan), build_bag(plan, sectors=1)
    whole = all_round(sector, sector.net.positions)

    def segments(positions, bars):
        return sorted(tuple(sorted(map(tuple, pair))) for pair in (positions[bars].round(9) + 0.0).tolist())

    assert sector.net.order == np.gcd.reduce([section[1] for section in sections])
    assert segments(whole.positions, whole.bars) == segments(full.net.positions, full.net.bars)
    assert len(full.net.facets) == sector.net.order * len(sector.net.facets)
    assert len(full.mesh_sides) == sector.net.order * len(sector.mesh_sides)


def test_of_5_meshes_laced_to_3_two_pairs_are_taken_up_two_by_two():
    plan = joined_plan(*USUAL["100 to 60"])
    bag = build_bag(plan)
    net = bag.net
    joint = np.flatnonzero(bag.node_row == 20)
    assert len(joint) == 60
    ahead, behind = (
        np.bincount(net.bars[bag.bar_band == band].ravel(), minlength=len(net.positions))[joint] for band in (19, 20)
    )
    assert sorted(ahead.tolist()) == [2] * 20 + [4] * 40
    assert behind.tolist() == [2] * 60
    assert np.count_nonzero(bag.mesh_row == 20) == 60
    assert np.all(bag.mesh_bars >= 0)


@pytest.mark.parametrize("g", [1, 2, 5, 10])
def test_a_joint_neither_adds_nor_loses_twine(g):
    dense = {"twine_density_kg_m3": 1140.0}
    plan = joined_plan(("diamond", 100, 20, 40.0, KNOT | dense), ("diamond", 60, 30, 50.0, KNOT | dense))
    net = build_bag(plan, globalisation=g).net
    twine_m = sum(4 * s.meshes_round * s.meshes_long * s.bar_m for s in plan.netting)
    assert (net.bar_drag_diameter * net.bar_length).sum() == pytest.approx(0.002 * twine_m, rel=1e-12)
    knots_m = sum(2 * s.meshes_round * s.meshes_long * s.knot_m for s in plan.netting)
    solid_m3 = (np.pi / 4 * net.bar_solid_diameter**2 * net.bar_length).sum()
    assert solid_m3 == pytest.approx(np.pi / 4 * 0.002**2 * (twine_m + knots_m), rel=1e-12)


def test_a_square_section_has_its_ring_at_a_joint_unless_its_meshes_are_taken_up_there():
    def rings(*sections):
        bag = build_bag(joined_plan(*sections))
        return np.count_nonzero(np.all(bag.node_row[bag.net.bars] == 2 * 6, axis=1))

    diamond = ("diamond", 20, 6, 40.0, {})
    assert rings(diamond, ("square", 20, 7, 40.0, {})) == 20
    assert rings(diamond, ("square", 16, 7, 40.0, {})) == 16
    assert rings(diamond, ("square", 30, 7, 40.0, {})) == 0


def check(result: CaseResult, tolerance: float) -> None:
    assert result.converged, result.report.attempts
    found = residual(result.problem, result.positions, result.solution.bar_tension, result.solution.share)
    if len(result.net.corners) == 0:
        assert found <= 1.01 * tolerance
    assert abs(result.measures.entry_reaction_n / result.measures.drag_n - 1) <= 1.01 * tolerance
    assert result.bar_tension_n.min() >= 0.0
    assert result.report.length_error <= 1e-6


@pytest.mark.parametrize("sections", USUAL.values(), ids=USUAL)
def test_catches_before_at_and_beyond_a_joint_are_solved_from_nothing(sections):
    tolerance = 1e-8
    for filled in (5.0, 10.0, 13.25):
        plan = joined_plan(*sections, catch={"filled_meshes": filled}, model={"tolerance": tolerance, "contact": False})
        check(solve(plan).cases[0], tolerance)


@pytest.mark.parametrize("filled", [6.0, 8.0, 11.0])
def test_entry_reaction_is_pressure_times_the_polygon_of_the_front_row_at_joints_too(filled):
    plan = joined_plan(*SMALL["5 to 3"], catch={"filled_meshes": filled, **UNIFORM}, drag=NO_DRAG)
    result = solve(plan).cases[0]
    front = all_round(result.bag, result.positions).positions
    ring = front[np.tile(result.bag.node_row, result.net.order) == result.bag.bands - 2 * filled]
    ring = ring[np.argsort(np.arctan2(ring[:, 2], ring[:, 1]))]
    polygon = 0.5 * np.cross(ring, np.roll(ring, -1, axis=0))[:, 0].sum()
    assert result.measures.catch_drag_n == pytest.approx(1.4 * 500.0 * polygon, rel=1e-12)
    assert result.measures.entry_reaction_n == pytest.approx(1.4 * 500.0 * polygon, rel=2e-6)


def measured(plan: Plan, sectors: int) -> Measures:
    model = model_of(plan, 1, sectors)
    problem, solution = solve_case(model, plan.cases()[0], (), None)
    assert solution.report.outcome.converged, solution.report.attempts
    return measure_all(model.bag, problem, solution)[2]


@pytest.mark.parametrize("sections", SMALL.values(), ids=SMALL)
def test_models_of_one_and_two_sectors_have_the_same_equilibrium(sections):
    """Each finds it from a crude start of its own."""
    plan = joined_plan(*sections, model={"tolerance": 1e-9})
    narrow, wide = (measured(plan, sectors) for sectors in (1, 2))
    for name in ("drag_n", "catch_volume_m3", "length_m", "max_radius_m", "opening_ahead_deg"):
        assert getattr(wide, name) == pytest.approx(getattr(narrow, name), rel=1e-6)


def test_relaxation_agrees_with_newton_across_a_joint():
    newton, relaxed = (
        solve(joined_plan(*SMALL["3 to 5, knotted"], model={"method": method})).cases[0].measures
        for method in ("newton", "dynamic-relaxation")
    )
    assert relaxed.drag_n == pytest.approx(newton.drag_n, rel=1e-5)
    assert relaxed.catch_volume_m3 == pytest.approx(newton.catch_volume_m3, rel=1e-5)


def test_a_full_net_of_joined_sections_starts_from_a_sector_and_is_there_at_once():
    result = solve(joined_plan(*USUAL["100 to 60"], model={"fidelity": "full"})).cases[0]
    check(result, 1e-6)
    (attempt,) = result.report.attempts
    assert attempt.startswith("from the equilibrium of a sector: newton")
    assert ": 0 iterations" in attempt


def halved_aft(meshes_round: int) -> tuple[CaseResult, CaseResult]:
    """A bag, and the same with twice as many meshes of half the bar in its aft half."""
    bar, long = 2400.0 / meshes_round, meshes_round // 3
    fore = ("diamond", meshes_round, long, bar, {})
    aft = ("diamond", 2 * meshes_round, 2 * long, bar / 2, {})

    def bag(*sections, filled):
        catch = {"filled_meshes": filled, **UNIFORM}
        return solve(joined_plan(*sections, entry=0.2, catch=catch, drag=NO_DRAG)).cases[0]

    plain = bag(("diamond", meshes_round, 2 * long, bar, {}), filled=0.6 * long)
    return plain, bag(fore, aft, filled=1.2 * long)


def test_netting_of_half_the_bar_and_twice_the_meshes_makes_the_same_bag_as_meshes_grow_many():
    """As long as the joint lies ahead of the wide part: the gap is of the order of one row of meshes."""
    gaps = []
    for meshes_round in (30, 60):
        plain, halved = halved_aft(meshes_round)
        gaps.append(abs(halved.measures.drag_n / plain.measures.drag_n - 1.0))
    assert gaps[1] < 0.02
    assert gaps[1] < 0.6 * gaps[0]


def test_a_joint_is_no_wider_than_the_fewer_meshes_of_the_shorter_bar_pulled_open():
    fore, aft = ("diamond", 30, 10, 80.0, {}), ("diamond", 60, 20, 40.0, {})
    wide = solve(joined_plan(fore, aft, entry=0.2, catch={"filled_meshes": 24.0})).cases[0]
    bound = 30 * 0.040 / np.pi
    joint = wide.rows.radius_m[20]
    assert 0.98 * bound < joint < bound / np.sinc(1 / 60)
    assert wide.measures.max_radius_m > 1.2 * bound


def test_rows_ahead_of_the_front_are_counted_through_a_change_of_mesh_kind():
    plan = joined_plan(("diamond", 20, 6, 40.0, {}), ("square", 20, 7, 40.0, {}))
    bag = build_bag(plan, sectors=1)
    share = np.ones(bag.bands)
    share[: 12 + 2] = 0.0
    assert opening_rows_ahead(bag, share) == pytest.approx([7.5, 6.5, 5.5, 5.0, 4.5])


def test_the_reason_tells_how_many_meshes_make_a_sector():
    why = reason_text(fidelity.choose(joined_plan(*USUAL["100 to 60"])))
    assert "one of 20 equal sectors, 5 and 3 meshes wide, of the real net is exact" in why
    assert "meshes wide" not in reason_text(fidelity.choose(joined_plan(USUAL["100 to 60"][0])))


def test_counts_without_a_common_divisor_make_one_sector_of_the_whole_net():
    plan = joined_plan(("diamond", 9, 4, 40.0, {}), ("diamond", 7, 6, 40.0, {}), catch={"filled_meshes": 4.0})
    assert build_bag(plan, sectors=1).net.order == 1
    check(solve(plan).cases[0], 1e-6)


def test_counts_that_share_little_start_from_a_narrow_sector_of_nearly_their_ratio(monkeypatch):
    plan = joined_plan(("t90", 31, 10, 30.0, {"knot_mm": 3.0}), ("diamond", 19, 6, 40.0, {}))
    found = solve(plan).cases[0]
    check(found, 1e-6)
    assert found.report.attempts[0].startswith("from the rows of a sector of nearly the ratio")
    monkeypatch.setattr(Situation, "wide", False)
    crude = solve(plan).cases[0]
    assert crude.report.attempts[0].startswith("from a crude bag")
    assert found.measures.drag_n == pytest.approx(crude.measures.drag_n, rel=1e-6)


def test_a_path_from_half_a_bag_leads_to_the_small_catch_that_no_crude_bag_led_to(monkeypatch):
    plan = joined_plan(*USUAL["100 to 60"], catch={"filled_meshes": 2.0}, model={"fidelity": "sector"})
    expected = solve(plan).cases[0]
    of_any_catch, from_any_start = interior_point.solve, newton.solve

    def of_larger_catches(problem, *given, **further):
        solution = of_any_catch(problem, *given, **further)
        return failed(solution) if problem.loading.catch.size == 2.0 else solution

    def from_a_shape(problem, tolerance, start=None, *given, **further):
        solution = from_any_start(problem, tolerance, start, *given, **further)
        return failed(solution) if start is None else solution

    monkeypatch.setattr(interior_point, "solve", of_larger_catches)
    monkeypatch.setattr(newton, "solve", from_a_shape)
    found = solve(plan).cases[0]
    assert found.report.attempts[-1].startswith("from half a bag, in steps: ")
    assert found.positions == pytest.approx(expected.positions, abs=1e-5)


def failed(solution: Solution) -> Solution:
    return replace(solution, report=replace(solution.report, outcome=Outcome.NOT_IMPROVING))
