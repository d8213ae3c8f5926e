"""Answers that are refused: nets that pass through themselves, as others judge it, and impossible catches."""

from dataclasses import replace

import ipctk
import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.mechanics.crossing import band_turns
from codend.mechanics.piercing import first_pierced
from codend.mechanics.problem import Problem
from codend.mechanics.rings import first_crossed_ring, rings_of
from codend.net.net import Net
from codend.plan.plan import plan_from_dict
from codend.solvers import dynamic_relaxation, newton
from codend.solvers.dynamic_relaxation import RelaxationSettings
from codend.solvers.newton import DIRECT
from codend.solvers.outcome import Outcome
from codend.solvers.refusal import layers_touch, passage, refusal
from codend.studies.study import solve
from tests.plans import make_plan
from validation.passing_through import (
    MODELS,
    crossed_rings,
    fault,
    pierced_however_divided,
    piercing_bars,
    set_all_round,
)
from validation.passing_through import solved as random_plan_solved

KINDS = [("diamond", {}), ("diamond", {"knot_mm": 8.0}), ("t90", {"knot_mm": 8.0}), ("square", {})]


def solved(mesh, netting, sectors, **options):
    plan = make_plan(12, 10, mesh=mesh, netting=netting, filled=3.0, **options)
    bag = build_bag(plan, sectors=sectors)
    problem = problem_of(bag, plan, plan.cases()[0])
    return bag, problem, newton.solve(problem, 1e-8)


def pierced(problem, positions, touching):
    s = problem.structure
    sheet = (s.first, s.second, s.image, s.facets, s.facet_image, s.facet_weight, s.order)
    return first_pierced(np.ascontiguousarray(positions), *sheet, touching)


def ipc_says_it_intersects(net, positions):
    """The judge: edges of one division of the netting against its triangles, without tolerance."""
    nodes, bars, facets = set_all_round(net, positions)
    whole = np.tile(net.facet_weight, net.order)
    # the first two of the four triangles that cover a quadrangle share its diagonal
    single = facets[whole == 1.0]
    mesh = ipctk.CollisionMesh(nodes, np.concatenate([bars, ipctk.edges(single)]), single)
    return ipctk.has_intersections(mesh, nodes)


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
@pytest.mark.parametrize("sectors", [1, 2, None])
def test_shaken_nets_are_pierced_where_an_independent_check_finds_that_they_are(mesh, netting, sectors):
    bag, problem, solution = solved(mesh, netting, sectors)
    touching = 1e-3 * float(bag.net.bar_length.min())
    assert refusal(problem, solution.positions, solution.share) is None
    verdicts = set()
    for size in (0.05, 0.3, 1.0, 2.0):
        rng = np.random.default_rng(int(100 * size))
        move = size * bag.net.bar_length.max() * rng.normal(size=solution.positions.shape)
        shaken = solution.positions + move * ~bag.net.fixed
        wanted = piercing_bars(bag.net, shaken, touching)
        found = pierced(problem, shaken, touching)[0]
        assert (found >= 0) == (len(wanted) > 0)
        if found >= 0:
            # bars of all sectors are numbered on
            assert found in wanted % len(bag.net.bars)
        rings = rings_of(bag.net.positions, bag.node_row, bag.net.order)
        row = first_crossed_ring(shaken, *rings, problem.structure.order, touching)[0]
        seen = crossed_rings(bag, shaken, touching)
        assert row == (seen[0] if seen else -1) or sectors is None  # a full net's rings are seen along their own axes
        verdicts.add(found >= 0)
    assert verdicts == {False, True}


@pytest.mark.parametrize("azimuth", [0.4, 3.1, -3.1, 1.6])
@pytest.mark.parametrize("sectors", [1, 3])
def test_sectors_are_pierced_alike_wherever_they_lie_about_the_axis(sectors, azimuth):
    bag, problem, solution = solved("t90", {"knot_mm": 8.0}, sectors)
    touching = 1e-3 * float(bag.net.bar_length.min())
    for seed in range(6):
        rng = np.random.default_rng(seed)
        shaken = solution.positions.copy()
        shaken += 0.1 * 2.0**seed * bag.net.bar_length.max() * rng.normal(size=shaken.shape) * ~bag.net.fixed
        c, s = np.cos(azimuth), np.sin(azimuth)
        turned = shaken @ np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
        assert pierced(problem, turned, touching)[0] == pierced(problem, shaken, touching)[0]


@pytest.mark.parametrize("sectors", [1, 3, None])
def test_ipctk_agrees_on_nets_of_triangles(sectors):
    bag, problem, solution = solved("diamond", {}, sectors)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        size = 0.05 * 1.4**seed * bag.net.bar_length.max()
        shaken = solution.positions + size * rng.normal(size=solution.positions.shape) * ~bag.net.fixed
        assert (pierced(problem, shaken, 1e-9)[0] >= 0) == ipc_says_it_intersects(bag.net, shaken), seed


def sheets(gap):
    """Two triangles side by side and a bar that stands on them, its foot ``gap`` above."""
    corners = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.6, 0.3, gap], [0.6, 0.3, gap + 1.0]], dtype=float
    )
    facets = [[0, 1, 2], [0, 2, 3]]
    return Problem.of(Net.from_bars(corners, [[4, 5], [0, 1]], np.ones(6, dtype=bool), facets=facets), weight=False)


@pytest.mark.parametrize(
    ("gap", "refused"), [(0.1, False), (0.0, False), (-1e-4, False), (-0.1, True), (-0.9999, False)]
)
def test_a_bar_that_merely_touches_does_not_pierce(gap, refused):
    problem = sheets(gap)
    assert (passage(problem, problem.net.positions) is not None) == refused


@pytest.mark.parametrize(("y", "z"), [(0.3, 0.6), (0.5, 0.5), (0.0, 0.5)])
def test_a_bar_that_meets_an_edge_or_a_corner_of_facets_pierces(y, z):
    problem = sheets(-0.5)
    moved = problem.net.positions.copy()
    moved[4:, :2] = y, z
    assert passage(problem, moved).outcome is Outcome.PASSED_THROUGH


def test_a_ring_that_runs_twice_round_its_middle_is_told():
    bag, problem, solution = solved("diamond", {}, None)
    row = np.flatnonzero(bag.node_row == 12)
    through = solution.positions.copy()
    order = np.argsort(np.arctan2(bag.net.positions[row, 2], bag.net.positions[row, 1]))
    radius = 0.05 + 0.01 * np.arange(12)
    through[row[order], 1] = radius * np.cos(4.0 * np.pi * np.arange(12) / 12)
    through[row[order], 2] = radius * np.sin(4.0 * np.pi * np.arange(12) / 12)
    assert passage(problem, through).where == "ring 12 of 20 runs 2 times round and crosses itself"


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
@pytest.mark.parametrize("sectors", [1, None])
def test_the_turns_of_the_bands_add_up_to_that_of_the_net(mesh, netting, sectors):
    _, problem, solution = solved(mesh, netting, sectors)
    turn, share = 2.5, np.clip(solution.positions[:, 0] / solution.positions[:, 0].max() / 0.9, 0.0, 1.0)
    across = (solution.positions[:, 1] + 1j * solution.positions[:, 2]) * np.exp(1j * turn * share)
    wrung = np.stack([solution.positions[:, 0], across.real, across.imag], axis=1)
    turns, through = band_turns(wrung, problem.structure, problem.loading.catch, problem.rings)
    assert through == -1
    assert turns.sum() == pytest.approx(turn, rel=0.05)
    assert passage(problem, wrung).outcome is Outcome.WRUNG
    turns, _ = band_turns(solution.positions, problem.structure, problem.loading.catch, problem.rings)
    assert abs(turns.sum()) < 1e-6


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
@pytest.mark.parametrize("sectors", [1, 2, None])
@pytest.mark.parametrize("turn", [0.0, 40.0, 180.0])
def test_beyond_a_ring_drawn_together_to_a_point_a_net_is_as_it_was_or_has_gone_through_its_axis(
    mesh, netting, sectors, turn
):
    """A full net was once called sound whose knots had met in one point and gone on beyond."""
    bag, problem, solution = solved(mesh, netting, sectors)
    rows = bag.node_row
    across = solution.positions[:, 1] + 1j * solution.positions[:, 2]
    across[rows == 4] *= 1e-10 * np.exp(2j * np.pi * np.random.default_rng(1).random(np.count_nonzero(rows == 4)))
    across[solution.positions[:, 0] > solution.positions[rows == 4, 0].mean() + 1e-3] *= np.exp(1j * np.radians(turn))
    drawn = np.stack([solution.positions[:, 0], across.real, across.imag], axis=1)
    turns, through = band_turns(drawn, problem.structure, problem.loading.catch, problem.rings)
    assert through == -1
    assert np.degrees(abs(turns.sum())) == pytest.approx(turn, abs=0.01)
    refused = passage(problem, drawn)
    assert (refused is not None and refused.outcome is Outcome.WRUNG) == (turn == 180.0)


def full_net(mesh, **entries):
    """The full nets that relaxation once carried through themselves."""
    plan = plan_from_dict(
        {
            "title": "through itself",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": entries.pop("entry")},
            "netting": [{"mesh": mesh, "twine_mm": 3.0, **entries}],
            "catch": {"filled_meshes": 1.5 if mesh == "t90" else 2.0},
            "model": {"fidelity": "full", "method": "dynamic-relaxation"},
        }
    )
    return plan


T90 = ("t90", {"entry": 0.12, "meshes_round": 24, "meshes_long": 20, "bar_mm": 40.0, "knot_mm": 8.0})
SQUARE = ("square", {"entry": 0.18 / np.pi, "meshes_round": 48, "meshes_long": 24, "bar_mm": 25.0})


@pytest.mark.parametrize(("case", "drag", "opening"), [(T90, 28.115, 7.16), (SQUARE, 22.03, 25.85)])
def test_full_nets_relaxed_alone_are_right(case, drag, opening):
    measures = solve(full_net(case[0], **case[1])).cases[0].measures
    assert measures.drag_n == pytest.approx(drag, rel=2e-3)
    assert measures.opening_ahead_deg == pytest.approx(opening, rel=2e-3)


@pytest.mark.parametrize("case", [T90, SQUARE])
def test_full_nets_relaxed_from_a_crude_bag_are_refused_where_they_pass_through_themselves(case):
    plan = full_net(case[0], **case[1])
    bag = build_bag(plan)
    problem = problem_of(bag, plan, plan.cases()[0])
    solution = dynamic_relaxation.solve(problem, 1e-6, settings=RelaxationSettings(restarts=0))
    assert solution.report.outcome is Outcome.PASSED_THROUGH
    assert np.isnan(solution.positions).all()


def test_newton_refuses_a_net_wrung_by_half_a_turn_or_it_unwinds():
    bag, problem, solution = solved("diamond", {"knot_mm": 5.0}, 1, entry=0.2)
    share = np.clip(bag.node_row / 8.0, 0.0, 1.0)
    across = (solution.positions[:, 1] + 1j * solution.positions[:, 2]) * np.exp(1j * np.pi * share)
    wrung = np.stack([solution.positions[:, 0], across.real, across.imag], axis=1)
    assert passage(problem, wrung) is not None
    found = newton.solve(problem, 1e-8, replace(solution, positions=wrung), DIRECT)
    if found.report.outcome.converged:
        assert found.positions == pytest.approx(solution.positions, abs=1e-6)


def test_a_catch_inside_out_without_volume_or_ahead_of_its_front_is_refused():
    bag, problem, solution = solved("diamond", {}, None)
    x, rest = solution.positions[:, :1], solution.positions[:, 1:]
    dented = np.where(bag.node_row[:, None] >= 16, 2.0 * x[bag.node_row == 16].mean() - x, x)
    flat = np.concatenate([x, rest * [1.0, 0.0]], axis=1)
    for positions, outcome in (
        (np.concatenate([dented, rest], axis=1), (Outcome.FRONT_BEHIND, Outcome.NO_VOLUME, Outcome.PASSED_THROUGH)),
        (flat, (Outcome.NO_VOLUME,)),
        (solution.positions * [1.0, -1.0, 1.0], (Outcome.NO_VOLUME, Outcome.INSIDE_OUT, Outcome.WRUNG)),
    ):
        assert refusal(problem, np.ascontiguousarray(positions), solution.share).outcome in outcome


@pytest.mark.parametrize(("degrees", "refused"), [(0.0, False), (60.0, False), (100.0, True), (180.0, True)])
def test_the_front_of_a_bag_that_hangs_aside_is_refused_where_it_lies_behind_the_codline_along_the_flow(
    degrees, refused
):
    """Turned as a whole, so that nothing has passed through anything, and along the bag the front lies as it did."""
    _, problem, solution = solved("diamond", {}, None)
    turn, (x, y, z) = np.radians(degrees), solution.positions.T
    aside = np.stack([np.cos(turn) * x + np.sin(turn) * z, y, np.cos(turn) * z - np.sin(turn) * x], axis=1)
    found = refusal(problem, aside, solution.share)
    assert refused == (found is not None)
    assert found is None or found.outcome in (Outcome.FRONT_BEHIND, Outcome.NO_VOLUME)


@pytest.mark.parametrize("method", ["auto", "newton", "dynamic-relaxation"])
def test_a_catch_is_never_of_negative_volume(method):
    plan = plan_from_dict(
        {
            "title": "a narrow net that sags at hardly any speed",
            "tow": {"speed_m_s": 0.07198695443261962, "water_density_kg_m3": 1123.5900761838782},
            "entry": {"radius_m": 0.04325813229656051},
            "catch": {"filled_meshes": 0.9757701137151187},
            "drag": {"law": "le-bris-1999", "normal": 2.7784784519789634, "tangential": 0.30276672774110536},
            "model": {"fidelity": "full", "method": method},
            "netting": [
                {
                    "mesh": "diamond",
                    "meshes_round": 18,
                    "meshes_long": 5,
                    "bar_mm": 40.526,
                    "twine_mm": 3.981,
                    "twine_density_kg_m3": 1015.6912052609072,
                }
            ],
        }
    )
    result = solve(plan).cases[0]
    assert result.report.outcome.refused or result.measures.catch_volume_m3 > 0.0


@pytest.mark.parametrize("model", [model for model in MODELS if model != ("full", "rigid-bars")])
def test_random_plans_give_no_net_that_passes_through_itself(model):
    for number in range(4):
        result = random_plan_solved(number, *model)
        assert result is None or not result.converged or fault(result) == ""


def test_layers_that_lie_on_each_other_are_told_where_following_ends_at_no_shape():
    result = random_plan_solved(245, "sector", "dynamic-relaxation")
    assert layers_touch(result.problem, result.positions)
    assert result.converged
    assert result.followed.shape is None
    assert result.followed.folds
    assert fault(result) == ""


@pytest.mark.parametrize("away", [-1e4, -3.0, 3.0, 1e4])
@pytest.mark.parametrize("axis", range(3))
def test_bars_far_from_all_netting_pierce_none(axis, away):
    """A warp lies above its trawl: no list of the facets near it may be read beyond its ends."""
    triangle = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    offset = away * np.eye(3)[axis]
    positions = np.concatenate([triangle, triangle[:2] + offset + 0.2, [[0.2, 0.2, -1.0], [0.2, 0.2, 1.0]]])
    first, second = np.array([3], dtype=np.int32), np.array([4], dtype=np.int32)
    none, facets = np.zeros(1, dtype=np.int32), np.array([[0, 1, 2]], dtype=np.int32)
    sheet = facets, np.zeros((1, 3), dtype=np.int32), np.ones(1), 1.0
    assert first_pierced(positions, first, second, none, *sheet, 1e-3) == (-1, -1)
    assert first_pierced(positions, first + 2, second + 2, none, *sheet, 1e-3) == (0, 0)


@pytest.mark.parametrize(
    ("start", "end", "by_sum", "through"),
    [
        ([0.9, 0.1, 0.5], [0.1, 0.9, 0.5], 1, False),
        ([0.5, 0.4, -1.0], [0.5, 0.4, 2.0], 1, True),
        ([0.5, 0.4, -1.0], [0.5, 0.4, 0.4], 0, False),
    ],
    ids=["in and out by one covering", "by both", "ends between them"],
)
def test_folds_are_passed_through_where_both_coverings_of_a_quadrangle_are(start, end, by_sum, through):
    corners = [[0, 0, 0], [1, 0, 1], [1, 1, 0], [0, 1, 1]]
    facets = [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]]
    net = Net.from_bars([*corners, start, end], [[4, 5]], np.zeros(6, dtype=bool), facets=facets)
    net = replace(net, facet_weight=np.full(4, 0.5))
    assert len(piercing_bars(net, net.positions, 0.01)) == by_sum
    assert (len(pierced_however_divided(net, net.positions, 0.01)) > 0) == through
