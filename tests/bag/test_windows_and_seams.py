"""Seams, selvedges, sections that taper, and windows: nets are closed, balanced, and the tube where they should be."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from codend.bag.build import build_bag
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.start_shapes import set_round, windows_let_into
from codend.errors import InputError
from codend.io.run_tables import read_run_table
from codend.net.net import facet_corners
from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.catches import catches_of, run_of
from codend.studies.case_result import CaseResult
from codend.studies.study import Study, solve

SECTION = {"mesh": "diamond", "meshes_round": 24, "meshes_long": 12, "bar_mm": 40.0, "twine_mm": 2.0}
WINDOW = {
    "mesh": "diamond", "meshes_round": 6, "meshes_long": 4, "bar_mm": 40.0, "twine_mm": 2.0,
    "netting": "1", "panel": "upper", "meshes_from_codline": [5, 9], "meshes_across": 6,
}  # fmt: skip
KINDS = [{}, {"knot_mm": 6.0}, {"mesh": "t90", "knot_mm": 6.0}, {"mesh": "square", "meshes_round": 48}]
OTHER = {
    "square": {"mesh": "square", "meshes_long": 8},
    "square and few": {"mesh": "square", "meshes_round": 4, "meshes_long": 7},
    "turned": {"mesh": "t90", "knot_mm": 5.0},
    "turned and deeper": {"mesh": "t90", "knot_mm": 5.0, "bar_mm": 32.0, "meshes_long": 5},
    "larger": {"bar_mm": 53.3, "meshes_round": 5, "meshes_long": 3},
    "smaller": {"bar_mm": 32.0, "meshes_round": 8, "meshes_long": 5, "knot_mm": 3.0},
    "at the codline": {"mesh": "square", "meshes_long": 8, "meshes_from_codline": [0, 4]},
    "at the entry": {"mesh": "square", "meshes_long": 8, "meshes_from_codline": [8, 12]},
}


def plan(*sections: dict, windows: list[dict] | None = None, entry: float = 0.12, **tables: object) -> Plan:
    data = {
        "title": "seams",
        "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1000.0},
        "entry": {"radius_m": entry},
        "netting": [{**SECTION, **section} for section in sections],
        "window": [{**WINDOW, **window} for window in windows or []],
        "catch": {"filled_meshes": 3.5},
        "model": {"fidelity": "full", "tolerance": 1e-10, "wrinkles": False},
    }
    return plan_from_dict({**data, **tables})


def solved(*sections: dict, windows: list[dict] | None = None, **tables: object) -> CaseResult:
    (result,) = solve(plan(*sections, windows=windows, **tables)).cases
    assert result.converged, result.report.attempts
    return result


def numbers(result: CaseResult) -> list[float]:
    m = result.measures
    return [m.drag_n, m.catch_volume_m3, m.opening_ahead_deg, m.length_m, m.max_radius_m, m.entry_reaction_n]


TAPERED = {
    "a tube": [{"meshes_round_aft": 18}],
    "two panels": [{"panels": 2, "meshes_round_aft": 16}],
    "two panels, with knots": [{"panels": 2, "meshes_round_aft": 20, "knot_mm": 5.0}],
    "turned, with knots": [{"panels": 2, "mesh": "t90", "meshes_round_aft": 20, "knot_mm": 5.0}],
    "turned and stiff": [
        {"panels": 2, "mesh": "t90", "meshes_round_aft": 20, "knot_mm": 5.0, "bending_stiffness_n_m2": 1e-4}
    ],
    "four panels": [{"panels": 4, "meshes_round": 32, "meshes_round_aft": 24}],
    "wider": [{"panels": 2, "meshes_round": 20, "meshes_round_aft": 24}],
}
AFT = {"panels": 2, "meshes_round": 16}
STEEP = {
    "1T2B": [{"panels": 2, "meshes_round": 64, "meshes_long": 6, "cut": "1T2B"}, AFT],
    "1T1B, with knots": [
        {"panels": 2, "meshes_round": 64, "meshes_long": 4, "cut": "1T1B", "knot_mm": 5.0},
        AFT | {"knot_mm": 5.0},
    ],
    "odd": [{"panels": 2, "meshes_round": 50, "meshes_long": 4, "meshes_round_aft": 24}, AFT | {"meshes_round": 24}],
    "turned and stiff": [
        TAPERED["turned and stiff"][0] | {"meshes_round": 48, "meshes_long": 4, "meshes_round_aft": 24, "cut": "1N4B"},
        TAPERED["turned and stiff"][0] | {"meshes_round": 24, "meshes_round_aft": 24},
    ],
    "wider": [AFT, AFT | {"meshes_long": 4, "meshes_round_aft": 36}, AFT | {"meshes_round": 36}],
}
ASKED = {"tolerance": 1e-10, "wrinkles": False}


@pytest.mark.parametrize("sections", STEEP.values(), ids=STEEP.keys())
def test_cuts_steeper_than_bars_neither_add_nor_lose_twine_and_are_in_balance(sections):
    """A trapezoid has as many bars but for a step of the cut in every row of a seam."""
    made = plan(*sections)
    bag = build_bag(made)
    for number, section in enumerate(made.netting):
        own = bag.bar_is_twine & (np.array(made.sections_of_bands())[bag.bar_band] == number)
        steps = section.panels * section.rows_per_mesh * section.meshes_long * (2 + section.edge_cut.rate)
        assert abs(own.sum() - 4 * section.mean_meshes_round * section.meshes_long) <= steps
    assert (bag.mesh_bars >= 0).all()
    sector, full = (solved(*sections, model={**ASKED, "fidelity": asked}) for asked in ("sector", "full"))
    assert sector.net.order == 2
    assert numbers(sector) == pytest.approx(numbers(full), rel=1e-8)
    assert full.measures.entry_reaction_n == pytest.approx(full.measures.drag_n, rel=1e-8)
    assert abs(full.measures.turn_deg) < 1e-6


def test_an_entry_from_which_steeply_cut_netting_does_not_reach_its_seams_is_told():
    steep = {"panels": 2, "meshes_round": 64, "meshes_long": 6, "cut": "1T2B"}
    with pytest.raises(InputError, match="cut 1T2B, reaches its seams") as told:
        solve(plan(steep, AFT, entry=0.35))
    assert told.value.key == "entry.radius_m"
    build_bag(plan(steep | {"axial_stiffness_n": 1e3}, AFT, entry=0.35))


@pytest.mark.parametrize("sections", TAPERED.values(), ids=TAPERED.keys())
def test_a_sector_of_netting_that_tapers_is_the_full_net_and_not_turned(sections):
    sector, full = (solved(*sections, model={**ASKED, "fidelity": asked}) for asked in ("sector", "full"))
    assert sector.net.order == (sections[0].get("panels") or 6)
    assert numbers(sector) == pytest.approx(numbers(full), rel=1e-8)
    assert full.measures.entry_reaction_n == pytest.approx(full.measures.drag_n, rel=1e-8)
    assert abs(full.measures.turn_deg) < 1e-6


def test_knots_of_turned_netting_that_tapers_shrink_to_those_without_a_length():
    tapered = {"panels": 2, "mesh": "t90", "meshes_round_aft": 20, "axial_stiffness_n": 1e4}
    short, none = (solved(tapered | {"knot_mm": knot_mm}) for knot_mm in (0.05, 0.0))
    assert numbers(short) == pytest.approx(numbers(none), rel=5e-3)


@pytest.mark.parametrize("panels", [2, 4])
def test_panels_without_selvedges_are_the_tube(panels):
    for asked in ("sector", "full"):
        tables = {"model": {**ASKED, "fidelity": asked}}
        assert numbers(solved({"panels": panels}, **tables)) == pytest.approx(numbers(solved({}, **tables)), rel=1e-10)


def test_slack_selvedges_without_drag_leave_the_tube_of_the_open_meshes():
    bare = {"drag": {"normal": 0.0}, "model": {**ASKED, "fidelity": "sector"}}
    selvedged = solved({"panels": 2, "selvedge_meshes": 1}, **bare)
    assert selvedged.net.order == 2
    assert selvedged.measures.max_rope_tension_n == 0.0
    assert numbers(selvedged) == pytest.approx(numbers(solved({"meshes_round": 20}, **bare)), rel=1e-8)


def test_a_sector_with_selvedges_and_ropes_is_the_full_net():
    rope = [{"number": 2, "shortening": 0.1, "axial_stiffness_n": 5e3}]
    sector, full = (
        solved({"panels": 2, "selvedge_meshes": 1}, rope=rope, model={**ASKED, "fidelity": asked})
        for asked in ("sector", "full")
    )
    assert numbers(sector) == pytest.approx(numbers(full), rel=1e-8)
    assert sector.measures.opening_ahead_spread_deg > 1.0


def test_the_upper_panel_has_its_middle_on_top():
    meshes = solve(plan({"panels": 4, "meshes_round_aft": 20}, model={**ASKED, "fidelity": "sector"})).meshes
    assert set(meshes["panel"]) == {"upper", "port", "lower", "starboard"}
    middles = meshes.groupby("panel")[["y_m", "z_m"]].mean()
    assert middles.loc["upper", "z_m"] > abs(middles.loc["upper", "y_m"])
    assert middles.loc["port", "y_m"] < -abs(middles.loc["port", "z_m"])


@pytest.mark.parametrize("kind", KINDS, ids=["plain", "knots", "turned", "square"])
def test_a_window_of_the_same_netting_changes_nothing(kind):
    across = {"meshes_round": 12, "meshes_across": 12} if kind.get("mesh") == "square" else {}
    window = {key: value for key, value in kind.items() if key != "meshes_round"} | across
    assert numbers(solved(kind, windows=[window])) == pytest.approx(numbers(solved(kind)), rel=1e-9)


STIFF = {"bending_stiffness_n_m2": 2e-4, "rest_opening_deg": 30.0, "axial_stiffness_n": 1e4}


@pytest.mark.parametrize(
    "kind", [*KINDS[:3], {"mesh": "t90"}], ids=["plain", "knots", "turned", "turned without knots"]
)
def test_a_window_of_the_same_stiff_netting_changes_nothing(kind):
    whole = build_bag(plan(kind | STIFF)).net
    stiff = solved(kind | STIFF, windows=[kind | STIFF])
    assert len(stiff.net.corners) == len(whole.corners)
    assert numbers(stiff) == pytest.approx(numbers(solved(kind | STIFF)), rel=1e-9)


@pytest.mark.parametrize("name", ["square", "turned", "larger", "smaller"])
def test_stiff_netting_about_a_window_is_in_balance_and_tends_to_limp_netting(name):
    limp, hardly, stiff = (
        solved({"axial_stiffness_n": 1e4} | bending, windows=[OTHER[name]])
        for bending in ({}, {"bending_stiffness_n_m2": 1e-9}, STIFF)
    )
    assert numbers(hardly) == pytest.approx(numbers(limp), rel=1e-3)
    assert stiff.measures.entry_reaction_n == pytest.approx(stiff.measures.drag_n, rel=1e-8)
    assert abs(stiff.measures.opening_ahead_deg - limp.measures.opening_ahead_deg) > 0.05


@pytest.mark.parametrize("window", OTHER.values(), ids=OTHER.keys())
@pytest.mark.parametrize("kind", KINDS, ids=["plain", "knots", "turned", "square"])
def test_netting_with_a_window_is_closed(kind, window):
    """The area vectors of a closed net, and of one half of it, add up to those of the entry's polygon."""
    for windows in ([], [window]):
        net = build_bag(plan(kind, windows=windows)).net
        corners = facet_corners(net, net.positions)
        area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        total = (net.facet_weight[:, None] * area).sum(axis=0)
        if not windows:
            entry = total[0]
        assert total == pytest.approx([entry, 0.0, 0.0], abs=1e-12)
        assert len(np.unique(np.append(net.bars.ravel(), net.facets.ravel()))) == len(net.positions)


@pytest.mark.parametrize("name", ["square", "turned", "larger", "at the codline"])
def test_a_window_leaves_the_net_in_balance(name):
    result = solved({}, windows=[OTHER[name]])
    assert result.measures.entry_reaction_n == pytest.approx(result.measures.drag_n, rel=1e-8)
    assert result.measures.sideways_imbalance < 1e-8
    without = solved({}).measures
    assert result.measures.drag_n != pytest.approx(without.drag_n, rel=1e-3)
    assert result.measures.codline_aside_m == pytest.approx(np.hypot(*result.solution.positions[-1, 1:]), rel=1e-12)
    assert result.measures.codline_aside_m > 1e-3 > 1e6 * without.codline_aside_m


LINES = {
    "strap ahead": {"strap": [{"meshes_from_codline": 9, "length_m": 0.9}]},
    "strap behind": {"strap": [{"meshes_from_codline": 5, "length_m": 0.9}]},
    "ropes": {"rope": [{"number": 2, "shortening": 0.1, "axial_stiffness_n": 1e3}]},
    "ropes to its edge": {
        "rope": [{"number": 4, "shortening": 0.1, "axial_stiffness_n": 1e3, "meshes_from_codline": [0, 5]}]
    },
}


@pytest.mark.parametrize("lines", LINES.values(), ids=LINES.keys())
@pytest.mark.parametrize("kind", KINDS, ids=["plain", "knots", "turned", "square"])
@pytest.mark.parametrize("name", ["square", "turned and deeper", "smaller"])
def test_straps_and_ropes_beside_a_window_are_laced_to_knots_that_are_there(name, kind, lines):
    bare, laced = (len(build_bag(plan(kind, windows=[OTHER[name]], **more)).net.bars) for more in ({}, lines))
    bag = build_bag(plan(kind, windows=[OTHER[name]], **lines))
    own = bag.net.bars[bare:laced]
    assert len(own) == len(bag.straps) + len(bag.ropes) > 0
    assert (own >= 0).all()
    assert (own[:, 0] != own[:, 1]).all()


def test_a_strap_along_the_edge_of_a_window_bounds_its_sides_and_leaves_the_net_in_balance():
    result = solved({}, windows=[OTHER["square"]], strap=[{"meshes_from_codline": 5, "length_m": 0.9}])
    assert result.measures.max_strap_tension_n > 0.0
    bag = build_bag(plan({}, windows=[OTHER["square"]], strap=[{"meshes_from_codline": 5, "length_m": 0.9}]))
    ends = result.positions[bag.net.bars[bag.straps]]
    sides = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert sides.max() == pytest.approx(0.9 / 24, rel=1e-6)
    assert result.measures.entry_reaction_n == pytest.approx(result.measures.drag_n, rel=1e-8)


MERGED = {
    "square": {"meshes_long": 16},
    "square, wide": {"meshes_round": 12, "meshes_across": 12, "meshes_long": 16},
    "turned": {"mesh": "t90", "meshes_long": 8, "knot_mm": 5.0, "panel": "lower"},
}


@pytest.mark.parametrize("window", MERGED.values(), ids=MERGED.keys())
def test_what_is_stated_of_merged_windows_covers_the_distance_to_the_net_as_it_is(window):
    placed = {"mesh": "square", "meshes_round": 8, "meshes_across": 8, "meshes_from_codline": [8, 16], **window}

    def of(**model: object) -> CaseResult:
        tables = {"catch": {"filled_meshes": 6}, "model": {**ASKED, "tolerance": 1e-8, **model}}
        return solved({"meshes_long": 24}, windows=[placed], entry=0.15, **tables)

    real = of(fidelity="full").measures.estimated
    for globalisation in (2, 4):
        merged = of(fidelity="globalised", globalisation=globalisation)
        e = merged.errors
        stated = [e.drag_error_n, e.catch_volume_error_m3, e.max_radius_error_m, e.opening_ahead_error_deg]
        assert (np.abs(merged.measures.estimated - real) < stated).all()
        assert e.drag_error_n < 0.3 * merged.measures.drag_n


WHOLE = {"square": ("square", 12), "turned": ("turned", 12), "larger": ("larger", 10), "smaller": ("smaller", 16)}


@pytest.mark.parametrize(("name", "across"), WHOLE.values(), ids=WHOLE.keys())
def test_a_window_as_wide_as_its_panel_leaves_the_net_in_balance(name, across):
    """Two panels of unequal depth: all of the upper one's netting is another's over a part of its length."""
    whole = {**OTHER[name], "meshes_across": 12, "meshes_round": across}
    upper, lower = (solved({"panels": 2}, windows=[{**whole, "panel": side}]) for side in ("upper", "lower"))
    assert upper.measures.entry_reaction_n == pytest.approx(upper.measures.drag_n, rel=1e-8)
    assert upper.measures.sideways_imbalance < 1e-8
    assert numbers(upper) == pytest.approx(numbers(lower), rel=1e-8)


BEHIND = {"panels": 2, "meshes_round": 24, "meshes_long": 8}
TURNED = {"panels": 2, "mesh": "t90", "knot_mm": 5.0}
HOSTS = {
    "1N2B": [{"panels": 2, "meshes_round": 40, "meshes_long": 8, "cut": "1N2B"}, BEHIND],
    "1T2B": [{"panels": 2, "meshes_round": 88, "meshes_long": 8, "cut": "1T2B"}, BEHIND],
    "turned": [TURNED | {"meshes_round": 40, "meshes_long": 8, "cut": "1T2B"}, BEHIND | TURNED],
    "four panels": [
        BEHIND | {"panels": 4, "meshes_round": 80, "cut": "1N2B"},
        BEHIND | {"panels": 4, "meshes_round": 48},
    ],
}
LET_IN = {"meshes_from_codline": [9, 13]}


@pytest.mark.parametrize("sections", HOSTS.values(), ids=HOSTS.keys())
def test_a_window_of_the_same_netting_in_a_section_that_tapers_changes_nothing(sections):
    kind = {key: sections[0][key] for key in ("mesh", "knot_mm") if key in sections[0]}
    assert numbers(solved(*sections, windows=[LET_IN | kind])) == pytest.approx(numbers(solved(*sections)), rel=1e-9)


@pytest.mark.parametrize(("host", "across"), [("1N2B", 3), ("1T2B", 3)])
def test_a_window_in_a_section_that_tapers_leaves_the_net_in_balance_and_mirrored(host, across):
    square = LET_IN | {"mesh": "square", "meshes_round": across, "meshes_long": 8, "axial_stiffness_n": 1e4}
    one, other = (solved(*HOSTS[host], windows=[square | {"panel": side}]) for side in ("upper", "lower"))
    assert one.measures.entry_reaction_n == pytest.approx(one.measures.drag_n, rel=1e-8)
    assert one.measures.sideways_imbalance < 1e-8
    assert numbers(one) == pytest.approx(numbers(other), rel=1e-8)


@pytest.mark.parametrize("knot_mm", [0.0, 5.0, 9.6])
@pytest.mark.parametrize("aft", [26, 30])
def test_a_window_without_knots_in_netting_that_tapers_with_knots_leaves_it_closed(aft, knot_mm):
    """Knots beside a seam lie off their columns, and once left triangles between knots that were cut out."""
    belly = {"panels": 2, "meshes_round": 36, "meshes_long": 15, "bar_mm": 48.0, "knot_mm": knot_mm}
    sections = [belly | {"meshes_round_aft": aft}, belly | {"meshes_round": aft, "meshes_long": 17}]

    def enclosed(windows: list[dict]) -> np.ndarray:
        net = build_bag(plan(*sections, windows=windows)).net
        corners = facet_corners(net, net.positions)
        assert len(np.unique(np.append(net.bars.ravel(), net.facets.ravel()))) == len(net.positions)
        area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return (net.facet_weight[:, None] * area).sum(axis=0)

    for across, near, deep in ((7, 20, 9), (7, 18, 8), (5, 18, 3), (3, 22, 5)):
        window = {"meshes_round": across, "meshes_across": across, "meshes_from_codline": [near, near + deep]}
        let_in = window | {"bar_mm": 48.0 * deep / (deep + 1), "meshes_long": deep + 1}
        assert enclosed([let_in]) == pytest.approx(enclosed([]), abs=1e-12)


def test_a_tube_that_tapers_loses_its_meshes_beside_a_window():
    sections = [{"meshes_round": 40, "meshes_long": 8, "meshes_round_aft": 24}, {"meshes_long": 8}]
    assert plan(*sections).places_round() == 8
    for side, lines in (("upper", 2), ("port", 1), ("starboard", 2)):
        square = LET_IN | {"mesh": "square", "meshes_round": 3, "meshes_long": 8, "panel": side}
        made = plan(*sections, windows=[square])
        assert (made.places_round(), made.seam_deg) == (lines, -90.0 if side == "starboard" else 0.0)
    result = solved(*sections, windows=[square])
    assert result.measures.entry_reaction_n == pytest.approx(result.measures.drag_n, rel=1e-8)


def test_a_net_with_windows_between_ropes_starts_where_the_net_without_them_is_in_balance():
    rope = [{"number": 2, "shortening": 0.1, "axial_stiffness_n": 5e3}]
    strap = [{"meshes_from_codline": 3, "length_m": 0.9}]
    both = [{"panel": side, "axial_stiffness_n": 1e3} for side in ("upper", "lower")]
    elastic = {"panels": 2, "axial_stiffness_n": 1e3}
    made = plan(elastic, windows=both, rope=rope, strap=strap)
    model, sector = model_of(made, 1, None), model_of(made, 1, 1)
    _, found = equilibrium.solve(sector, made.cases()[0], (), None)
    start = windows_let_into(model, sector.bag, found)
    whole = set_round(sector.bag, build_bag(made, sectors=sector.bag.net.sectors), found)
    away, _ = cKDTree(whole.positions).query(start.positions)
    assert away.max() < 0.05 * model.bag.net.bar_length.min()
    with_windows = solved(elastic, windows=both, rope=rope, strap=strap)
    assert with_windows.report.attempts[0].startswith("from the equilibrium of a sector, through the interior")
    # the opening ahead is that of the section's own meshes, which are not alike between ropes
    wanted = np.delete(numbers(solved(elastic, rope=rope, strap=strap)), 2)
    assert np.delete(numbers(with_windows), 2) == pytest.approx(wanted, rel=1e-8)


def test_a_window_of_the_same_netting_as_wide_as_its_panel_changes_nothing():
    whole = {"meshes_across": 12, "meshes_round": 12}
    assert numbers(solved({"panels": 2}, windows=[whole])) == pytest.approx(numbers(solved({})), rel=1e-9)


def test_a_window_mirrored_mirrors_the_answer():
    sides = [solved({}, windows=[{**OTHER["square"], "panel": side}]) for side in ("port", "starboard")]
    assert numbers(sides[0]) == pytest.approx(numbers(sides[1]), rel=1e-8)
    port, starboard = (side.positions[np.lexsort(np.round(side.positions, 6).T)] for side in (sides[0], sides[1]))
    assert port[:, [0, 2]].sum(axis=0) == pytest.approx(starboard[:, [0, 2]].sum(axis=0), abs=1e-6)
    assert port[:, 1].sum() == pytest.approx(-starboard[:, 1].sum(), abs=1e-6)
    assert abs(port[:, 1].sum()) > 0.1


def test_meshes_of_a_window_are_told_by_its_name_and_panel_and_fish_meet_them(tmp_path):
    windows = [{**OTHER["square"], "name": "window", "panel": "lower"}]
    study: Study = solve(plan({"panels": 2}, windows=windows, model={"wrinkles": False}))
    assert study.choice.fidelity == "full"
    own = study.meshes[study.meshes["section"] == "window"]
    assert len(own) == 6 * 8
    assert set(own["panel"]) == {"lower"}
    assert own["inside_mesh_mm"].unique() == pytest.approx([76.0])
    study.meshes.to_csv(tmp_path / "meshes.csv", index=False)
    assert read_run_table(tmp_path / "meshes.csv")["panel"].tolist() == study.meshes["panel"].tolist()
    (catch,) = catches_of(run_of(study), 5.0)
    assert {("1", "upper"), ("1", "lower"), ("window", "lower")} == set(catch.parts)


@pytest.mark.parametrize("asked", ["sector", "meridian", "smeared"])
def test_a_sector_has_no_place_for_a_window(asked):
    with pytest.raises(InputError, match="window") as told:
        solve(plan({}, windows=[{}], model={"fidelity": asked}))
    assert told.value.key == "model.fidelity"


@pytest.mark.parametrize(
    ("sections", "windows", "key"),
    [
        ([{"meshes_round_aft": 18}], [{"panel": "lower"}, {"panel": "starboard"}], "window.0.panel"),
        ([{"panels": 2, "meshes_round_aft": 16}], [{"meshes_across": 7}], "window.0.meshes_across"),
        ([{}], [{"mesh": "square", "bending_stiffness_n_m2": 1e-4}], "window.0.bending_stiffness_n_m2"),
    ],
)
def test_what_is_not_modelled_is_refused(sections, windows, key):
    with pytest.raises(InputError) as told:
        build_bag(plan(*sections, windows=windows, entry=0.1))
    assert told.value.key == key


def test_later_catches_of_a_sector_between_ropes_start_from_the_last():
    rope = [{"number": 2, "shortening": 0.1, "axial_stiffness_n": 5e3}]
    asked = {**ASKED, "fidelity": "sector"}
    series = solve(plan({"panels": 2}, rope=rope, catch={"filled_meshes": [3, 3.5]}, model=asked))
    assert [case.converged for case in series.cases] == [True, True]
    assert series.cases[1].report.attempts[0].startswith("from where the last equilibria lead")
    alone = solved({"panels": 2}, rope=rope, model=asked)
    assert numbers(series.cases[1]) == pytest.approx(numbers(alone), rel=1e-8)
