"""Round straps: rope rings that bound the radius of a row of knots."""

from typing import Any

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.measures import Measures, measure_all
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.solve import solve as solve_case
from codend.errors import InputError
from codend.io.columns import RESULT_COLUMNS
from codend.mechanics import drag
from codend.net.net import bar_vectors
from codend.plan.reach import least_radius_m
from codend.report.html import cautions
from codend.report.page_tables import results_tables
from codend.report.picture import RISE_DEG, STRAP_WIDTH, net_picture
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from tests.plans import joined_plan
from validation.reference import bar_pulls, nodal_loads, residual

ROUND, LONG = 60, 40
KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "T0": ("diamond", {}),
    "T0 with knots": ("diamond", {"knot_mm": 5.0}),
    "T90": ("t90", {"knot_mm": 5.0}),
    "square": ("square", {}),
}


def strapped(
    kind: str = "T0",
    filled: float = 24.0,
    at: float = 12.0,
    tolerance: float = 1e-9,
    fidelity: str = "sector",
    entry: float = 0.25,
    **strap,
):
    mesh, further = KINDS[kind]
    section = (mesh, ROUND, LONG, 40.0, further)
    straps = [{"meshes_from_codline": at, **strap}] if strap else []
    # what tests hold it against knows no contact
    model = {"tolerance": tolerance, "fidelity": fidelity, "contact": False}
    return joined_plan(section, entry=entry, catch={"filled_meshes": filled}, strap=straps, model=model)


def solved(*args: Any, **options: Any) -> CaseResult:
    result = solve(strapped(*args, **options)).cases[0]
    assert result.converged, result.report.attempts
    return result


def strap_row(result: CaseResult, at: float = 12.0) -> int:
    per_mesh = 1 if result.bag.band_meshes[-1] == 1.0 else 2
    return result.bag.bands - int(per_mesh * at)


@pytest.mark.parametrize("kind", KINDS)
def test_a_loose_strap_changes_nothing_and_carries_nothing(kind):
    plain, loose = solved(kind), solved(kind, length_m=6.0)
    assert loose.measures.max_strap_tension_n == 0.0
    assert np.isnan(plain.measures.max_strap_tension_n)
    assert loose.positions == pytest.approx(plain.positions, abs=1e-7)
    assert loose.measures.drag_n == pytest.approx(plain.measures.drag_n, rel=1e-9)
    assert loose.measures.max_bar_tension_n == pytest.approx(plain.measures.max_bar_tension_n, rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("length_m", [2.0, 1.2])
def test_a_tight_strap_is_as_long_as_it_is_all_round_and_balances_the_hoop(kind, length_m):
    """Pulled out of the row by twine and pressure, and held by the two sides of the polygon that meet in a knot."""
    result = solved(kind, length_m=length_m)
    bag, net = result.bag, result.net
    around = np.linalg.norm(bar_vectors(net, result.positions), axis=1)
    knots = np.all(bag.node_row[net.bars] == strap_row(result), axis=1) & (net.bar_drag_diameter == 0.0)
    if kind == "square":
        knots = np.isin(np.arange(len(net.bars)), bag.straps)
    assert net.order * around[knots].sum() == pytest.approx(length_m, rel=1e-6)

    found = residual(result.problem, result.positions, result.solution.bar_tension, result.solution.share)
    assert found <= 1.01e-9
    without = result.solution.bar_tension.copy()
    without[bag.straps] = 0.0
    if kind == "T90":
        return  # a knot there has two nodes, between which its own twine pulls as well
    force = nodal_loads(result.problem, result.positions, result.solution.share)
    force += bar_pulls(net, result.positions, without)
    (node,) = np.flatnonzero(bag.node_row == strap_row(result))
    outward = result.positions[node] * [0.0, 1.0, 1.0]
    pull = force[node] @ outward / np.linalg.norm(outward)
    tension = result.measures.max_strap_tension_n
    assert tension > 1.0
    assert 2.0 * tension * np.sin(np.pi / ROUND) == pytest.approx(pull, rel=1e-6)


@pytest.mark.parametrize("kind", ["T0", "T90"])
def test_a_mesh_folded_over_a_tight_strap_is_as_open_as_its_twines_make_it(kind):
    """Between the rows ahead and behind, which are more open; of bars b spread by w, 2 asin(w / 2 b)."""
    result = solved(kind, length_m=1.2)
    row = strap_row(result)
    # a T90 mesh has half a knot at either side, and between its twines a whole one fore and aft
    spread = 1.2 / ROUND - (2.0 * 0.005 if kind == "T90" else 0.0)
    opening = result.rows.opening_deg
    assert opening[row] == pytest.approx(2.0 * np.degrees(np.arcsin(spread / 0.080)), rel=1e-3)
    assert opening[row] < min(opening[row - 1], opening[row + 1])


def test_a_strap_of_elastic_rope_is_longer_by_its_tension_over_its_stiffness():
    result = solved(length_m=1.5, axial_stiffness_n=800.0)
    strain = result.measures.max_strap_tension_n / 800.0
    side = np.linalg.norm(bar_vectors(result.net, result.positions)[result.bag.straps], axis=1)
    assert ROUND * side == pytest.approx([1.5 * (1.0 + strain)], rel=1e-7)
    assert strain > 0.01


def merged(kind: str, g: int, **strap: Any) -> tuple[Measures, float]:
    """Measures of a sector of merged meshes, and the radius of the strap's row."""
    mesh, further = KINDS[kind]
    plan = joined_plan(
        (mesh, 120, 60, 20.0, further),
        entry=0.25,
        catch={"filled_meshes": 30.0},
        model={"tolerance": 1e-9},
        strap=[{"meshes_from_codline": 15.0, **strap}],
    )
    model = model_of(plan, g, 1)
    problem, solution = solve_case(model, plan.cases()[0], (), None)
    assert solution.report.outcome.converged
    _, rows, measures = measure_all(model.bag, problem, solution)
    return measures, float(rows.radius_m[model.bag.bands - 30 // g])


@pytest.mark.parametrize("kind", ["T0", "T90"])
def test_merged_knots_lie_on_the_circle_of_the_real_ones(kind):
    real, *others = (merged(kind, g, length_m=1.5)[1] for g in (1, 3, 10))
    assert others == pytest.approx([real] * 2, rel=1e-6)


@pytest.mark.parametrize("kind", ["T0", "T90"])
def test_strap_tension_converges_with_the_square_of_the_globalisation(kind):
    """Of the real rope, not of the bar that stands for more of it."""
    rope = {"length_m": 1.5, "axial_stiffness_n": 800.0}
    factors = [2, 3, 5]
    real, *others = (merged(kind, g, **rope)[0].max_strap_tension_n for g in (1, *factors))
    errors = np.abs(np.array(others) / real - 1.0)
    assert errors[0] < 2e-3
    assert 1.7 < np.polyfit(np.log(factors), np.log(errors), 1)[0] < 2.7


@pytest.mark.parametrize("kind", KINDS)
def test_merging_meshes_keeps_the_ropes_drag_area_and_volume(kind):
    plan = strapped(kind, at=20.0, length_m=3.0, diameter_mm=20.0)
    for g in (1, 2, 4, 20):
        bag = build_bag(plan, globalisation=g)
        net = bag.net
        length, width, solid = (v[bag.straps] for v in (net.bar_length, net.bar_drag_diameter, net.bar_solid_diameter))
        assert (length * width).sum() == pytest.approx(3.0 * 0.020, rel=1e-12)
        assert (length * solid**2).sum() == pytest.approx(3.0 * 0.020**2, rel=1e-12)


@pytest.mark.parametrize("length_m", [0.9, 6.0], ids=["tight", "slack"])
def test_a_strap_ahead_of_the_catch_meets_the_flow_at_right_angles_with_all_its_length(length_m):
    result = solved(filled=8.0, length_m=length_m, diameter_mm=20.0)
    assert (result.measures.max_strap_tension_n > 0.0) == (length_m < 1.0)
    problem, net = result.problem, result.net
    bare = problem.structure._replace(
        drag_diameter=np.where(np.isin(np.arange(len(net.bars)), result.bag.straps), 0.0, net.bar_drag_diameter)
    )
    force = np.zeros_like(net.positions)
    water, catch = problem.loading.water, problem.loading.catch
    drag.add_force(result.positions, np.zeros((0, 3)), bare, water, catch, result.solution.share, force)
    own = result.measures.twine_drag_n - net.order * force[:, 0].sum()
    assert own == pytest.approx(0.5 * 1000.0 * 1.36 * 0.020 * length_m, rel=1e-6)


def test_a_strap_within_the_catch_has_no_drag():
    within, thin = (solved(filled=24.0, length_m=0.9, **rope) for rope in ({"diameter_mm": 20.0}, {}))
    assert within.measures.twine_drag_n == pytest.approx(thin.measures.twine_drag_n, rel=1e-9)


def test_the_drag_of_a_slack_strap_does_not_hang_on_the_method():
    plan = strapped(filled=8.0, length_m=6.0, diameter_mm=20.0, tolerance=1e-7)
    drags = [
        solve(plan.model_copy(update={"model": plan.model.model_copy(update={"method": method})}))
        .cases[0]
        .measures.drag_n
        for method in ("newton", "dynamic-relaxation", "rigid-bars")
    ]
    assert drags[1:] == pytest.approx([drags[0]] * 2, rel=1e-5)


def test_straps_lie_on_joints_and_beside_each_other():
    sections = (("diamond", 60, 20, 40.0, {}), ("diamond", 40, 20, 40.0, {}))
    straps = [{"meshes_from_codline": at, "length_m": 1.6} for at in (20.0, 12.0, 6.0)]
    result = solve(joined_plan(*sections, entry=0.2, catch={"filled_meshes": 24.0}, strap=straps)).cases[0]
    assert result.converged
    assert result.measures.entry_reaction_n == pytest.approx(result.measures.drag_n, rel=1e-6)
    assert len(result.bag.straps) == 3 * 2
    polygon = 0.8 / np.pi / np.sinc(1 / 40)
    assert result.rows.radius_m[[56, 68]] == pytest.approx(polygon, rel=1e-6)
    # the knots of the joint hold unequal numbers of twines, and its ring is not quite flat
    assert result.rows.radius_m[40] == pytest.approx(polygon, rel=2e-3)
    side = np.linalg.norm(bar_vectors(result.net, result.positions)[result.bag.straps], axis=1)
    assert side == pytest.approx(1.6 / 40, rel=1e-6)


def test_a_full_net_has_the_strap_of_its_sector():
    sector, full = (solved(length_m=1.5, fidelity=fidelity).measures for fidelity in ("sector", "full"))
    assert full.max_strap_tension_n == pytest.approx(sector.max_strap_tension_n, rel=1e-6)
    assert full.drag_n == pytest.approx(sector.drag_n, rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("strap", [{"length_m": 2.0}, {"length_m": 0.5, "axial_stiffness_n": 1.0}])
def test_relaxation_and_newton_find_the_same_strap(kind, strap):
    """A rope so soft that it is pulled to several times its length is no sign of a net that balloons."""
    plan = strapped(kind, tolerance=1e-7, **strap)
    relaxing = plan.model_copy(update={"model": plan.model.model_copy(update={"method": "dynamic-relaxation"})})
    newton, relaxed = (solve(p).cases[0].measures for p in (plan, relaxing))
    assert relaxed.max_strap_tension_n == pytest.approx(newton.max_strap_tension_n, rel=1e-4)


def test_a_hinge_in_mid_bar_is_not_put_into_a_strap():
    plan = strapped(length_m=2.0)
    hinged = plan.model_copy(update={"model": plan.model.model_copy(update={"bars_per_side": 2})})
    bag = build_bag(hinged, sectors=1)
    assert np.all(bag.node_row[bag.net.bars[bag.straps]] == bag.bands - 24)


def test_results_tell_the_strap_tension_only_of_plans_that_have_straps():
    tight, none = (solve(strapped(**strap)).table for strap in ({"length_m": 1.5}, {}))
    assert list(none.columns) == RESULT_COLUMNS
    assert list(tight.columns) == [*RESULT_COLUMNS, "max_strap_tension_n"]
    assert tight["max_strap_tension_n"][0] > 1.0


def test_the_picture_shows_the_near_half_of_every_strap_where_its_knots_are():
    straps = [{"meshes_from_codline": at, "length_m": 1.6} for at in (12.0, 6.0)]
    plan = joined_plan(("diamond", ROUND, LONG, 40.0, {}), entry=0.25, catch={"filled_meshes": 20.0}, strap=straps)
    study = solve(plan)
    (axes, _) = net_picture(study.cases[0]).axes
    ropes = [line.get_xydata() for line in axes.lines if line.get_linewidth() == STRAP_WIDTH]
    assert "straps" in [text.get_text() for text in axes.texts]
    assert len(ropes) == 2
    for points, row in zip(ropes, (56, 68), strict=True):
        drawn = points[np.isfinite(points[:, 1])]
        assert 0.4 * ROUND < len(drawn) < 0.6 * ROUND + 2
        # seen from a little above, a ring of radius r is r cos(rise) high
        height = study.cases[0].rows.radius_m[row] * np.cos(np.radians(RISE_DEG))
        assert np.ptp(drawn[:, 1]) == pytest.approx(2.0 * height, rel=0.05)
    assert "weigh nothing in water" in " ".join(results_tables(study)[-1].remarks)
    assert not any("Straps" in remark for remark in results_tables(solve(strapped()))[-1].remarks)


def test_a_strap_shorter_than_the_knots_it_runs_through_is_refused():
    with pytest.raises(InputError, match=r"strap\.0\.length_m = 0\.29 .*above 0\.3 m, the knots"):
        build_bag(strapped("T90", length_m=0.29))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("at", [38.0, 39.0])
def test_a_row_is_drawn_in_from_the_entry_as_far_as_flat_meshes_reach_and_no_farther(kind, at):
    """A stiff rope that stretches is not refused: under a thousand newtons it draws its row as far as the bound."""
    entry = 0.3
    with pytest.raises(InputError, match="as far as the netting from the entry reaches inwards") as refused:
        build_bag(strapped(kind, at=at, entry=entry, length_m=0.35))
    least_m = float(refused.value.allowed.split()[1])
    result = solved(kind, at=at, entry=entry, filled=8.0, length_m=0.9 * least_m, axial_stiffness_n=1e4)
    # in T90 netting knots of 5 mm lie between the pieces of rope
    knots_m = 0.005 * ROUND if kind == "T90" else 0.0
    length_m = knots_m + (0.9 * least_m - knots_m) * (1.0 + result.measures.max_strap_tension_n / 1e4)
    assert 0.9995 < length_m / least_m < 1.01
    build_bag(strapped(kind, at=at, entry=entry, length_m=1.001 * least_m))


def test_a_strap_on_a_joined_net_is_refused_only_where_no_chain_of_bars_reaches_it():
    sections = (("diamond", 60, 2, 40.0, {}), ("diamond", 40, 38, 40.0, {}))
    for length_m, fits in ((0.7, False), (1.6, True)):
        strap = [{"meshes_from_codline": 37.0, "length_m": length_m}]
        plan = joined_plan(*sections, entry=0.4, catch={"filled_meshes": 8.0}, strap=strap)
        assert (least_radius_m(plan.netting, plan.entry.radius_m, 74) < length_m / 2.0 / np.pi) == fits
        if fits:
            assert solve(plan).converged
        else:
            with pytest.raises(InputError, match=r"strap\.0\.length_m = 0\.7 .* netting from the entry reaches"):
                build_bag(plan)


def test_twine_that_stretches_lets_a_strap_be_as_short_as_the_bundle_of_its_twines():
    soft = {"meshes_from_codline": 39.0, "length_m": 0.5}
    section = ("diamond", ROUND, LONG, 40.0, {"axial_stiffness_n": 500.0})
    build_bag(joined_plan(section, entry=0.25, strap=[soft]))
    # 120 twines of 2 mm have the section of one of 21.9 mm
    with pytest.raises(InputError, match=r"strap\.0\.length_m = 0\.0001 .*above 0\.06883 m, round the twines"):
        build_bag(joined_plan(section, entry=0.25, strap=[soft | {"length_m": 1e-4}]))
    assert solved(length_m=0.07).measures.max_strap_tension_n > 1.0


def test_the_meridian_method_refuses_straps():
    with pytest.raises(InputError, match="knows no straps"):
        solve(strapped(length_m=2.0, fidelity="meridian"))


def test_globalisation_keeps_the_rows_of_straps():
    plan = strapped(at=7.0, length_m=2.0)
    assert plan.globalisations == (1, 2)


def test_a_strap_is_repeated_by_its_spacing_and_as_long_as_its_share_of_the_meshes_round():
    """60 meshes of 80 mm stretched are 4.8 m round; each of the straps bounds its ring."""
    plan = strapped(at=4.0, length_m=2.0)
    straps = [{"meshes_from_codline": 4, "spacing_meshes": 8, "circumference_share": 0.4}]
    repeated = joined_plan(
        ("diamond", ROUND, LONG, 40.0, {}),
        entry=0.25,
        catch={"filled_meshes": 30.0},
        strap=straps,
        model={"tolerance": 1e-10},
    )
    assert [strap.meshes_from_codline for strap in repeated.straps] == [4, 12, 20, 28, 36]
    assert [strap.around_m for strap in repeated.straps] == pytest.approx([0.4 * 4.8] * 5)
    assert len(plan.straps) == 1
    result = solve(repeated).cases[0]
    assert result.converged
    side = np.linalg.norm(bar_vectors(result.net, result.positions)[result.bag.straps], axis=1)
    tight = result.bar_tension_n[result.bag.straps] > 0.0
    assert tight.sum() >= 3
    assert ROUND * side[tight] == pytest.approx(0.4 * 4.8, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"circumference_share": 0.4}, "strap.0.circumference_share"),
        ({"length_m": None}, "strap.0.length_m"),
        ({"length_m": None, "circumference_share": 1.2}, "strap.0.circumference_share"),
        ({"spacing_meshes": 0.7}, "strap.0.meshes_from_codline"),
        ({"spacing_meshes": 0}, "strap.0.spacing_meshes"),
    ],
)
def test_straps_that_contradict_themselves_are_one_line(change, key):
    strap = {"meshes_from_codline": 4, "length_m": 2.0} | change
    with pytest.raises(InputError) as caught:
        joined_plan(
            ("diamond", ROUND, LONG, 40.0, {}),
            entry=0.25,
            strap=[{name: value for name, value in strap.items() if value is not None}],
        )
    assert caught.value.key == key


@pytest.mark.parametrize(("share", "said"), [(0.95, 1), (0.7, 0)])
def test_a_strap_that_is_slack_on_the_catch_is_told_with_how_wide_the_netting_is(share, said):
    tube = solved()
    around = 2.0 * np.pi * tube.rows.radius_m[strap_row(tube)]
    longer = {"length_m": 1.05 * around} if said else {"length_m": share * around}
    told = [word for word in cautions(solve(strapped(**longer))) if "slack" in word]
    assert len(told) == said
    assert all("12 meshes from the codline" in word and f"{around:.2g}" in word for word in told)
