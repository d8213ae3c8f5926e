"""Panels, cuts, selvedges and windows as plans say them: what follows from the counts, and what is refused."""

from fractions import Fraction
from itertools import pairwise

import pytest

from codend.errors import InputError
from codend.plan.copy import plan_toml
from codend.plan.cuts import cut_of, cut_that_loses
from codend.plan.plan import Plan, load_plan, plan_from_dict
from codend.plan.tables import Netting

SECTION = {"mesh": "diamond", "meshes_round": 100, "meshes_long": 40, "bar_mm": 50.0, "twine_mm": 4.0}
WINDOW = {
    "mesh": "square", "meshes_round": 20, "meshes_long": 30, "bar_mm": 50.0, "twine_mm": 4.0,
    "netting": "1", "panel": "upper", "meshes_from_codline": [10, 30], "meshes_across": 30,
}  # fmt: skip


def section(**keys: object) -> Netting:
    return Netting.model_validate({**SECTION, **keys})


def plan(windows: list[dict] | None = None, *more: dict, **keys: object) -> Plan:
    return plan_from_dict(
        {
            "title": "panels",
            "tow": {"speed_m_s": 1.2},
            "entry": {"radius_m": 0.4},
            "netting": [{**SECTION, **keys}, *more],
            "window": windows or [],
            "catch": {"filled_meshes": 10},
        }
    )


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("AN", 0),
        ("AB", 1),
        ("1N1B", 1 / 3),
        ("1N2B", 1 / 2),
        ("1N4B", 2 / 3),
        ("2N1B", 1 / 5),
        ("1T2B", 2),
        ("1T1B", 3),
    ],
)
def test_cuts_have_the_rates_of_the_cutters_table(text, rate):
    cut = cut_of(text)
    assert cut is not None
    assert cut.rate == pytest.approx(rate)
    assert cut.text() == text
    if 0 < rate < float("inf"):
        assert cut_that_loses(round(2 * 60 * rate), 60) == cut


def test_points_and_meshes_change_places_in_turned_netting():
    assert section(mesh="t90", cut="1T2B").aft_meshes_round == section(cut="1N2B").aft_meshes_round == 60
    assert section(mesh="t90", meshes_round_aft=60).edge_cut_text == "1T2B"
    assert section(mesh="t90").edge_cut_text == "AT"


@pytest.mark.parametrize(
    ("panels", "keys", "aft", "cut"),
    [
        (1, {"cut": "1N2B", "meshes_long": 20}, 80, "1N2B"),
        (2, {"cut": "1N2B", "meshes_long": 20}, 60, "1N2B"),
        (2, {"meshes_round_aft": 60, "meshes_long": 20}, 60, "1N2B"),
        (4, {"meshes_round_aft": 60, "cut": "7N2B"}, 60, "7N2B"),
        (2, {"meshes_round_aft": 120, "meshes_long": 10}, 120, "1N2B"),
        (2, {"selvedge_meshes": 3}, 100, "AN"),
    ],
)
def test_counts_and_cut_follow_from_each_other(panels, keys, aft, cut):
    found = section(panels=panels, **keys)
    assert found.aft_meshes_round == aft
    assert found.edge_cut_text == cut
    assert found.open_meshes == (100 - found.selvedged_meshes, aft - found.selvedged_meshes)


def test_meshes_taken_up_into_selvedges_are_not_open():
    found = section(panels=2, selvedge_meshes=3)
    assert found.selvedged_meshes == 12
    assert found.open_meshes == (88, 88)
    assert plan(panels=2, selvedge_meshes=3).ropes[0].twines == 12


@pytest.mark.parametrize(
    ("keys", "key", "words"),
    [
        ({"cut": "2N"}, "cut", '"1N2B"'),
        ({"mesh": "square", "cut": "1N2B"}, "cut", "left out"),
        ({"panels": 3}, "panels", "1, 2, 4"),
        ({"panels": 2, "meshes_round": 101}, "meshes_round", "a multiple of 2"),
        ({"panels": 2, "meshes_round_aft": 71}, "meshes_round_aft", "a multiple of 2"),
        ({"panels": 2, "meshes_round_aft": 60, "meshes_long": 20, "cut": "1N1B"}, "cut", '"1N2B"'),
        ({"panels": 2, "selvedge_meshes": 24}, "selvedge_meshes", "at most 23"),
        ({"cut": "1T1B"}, "cut", "leaves 3 meshes"),
        ({"meshes_round_aft": 2}, "meshes_round_aft", "at least 3"),
    ],
)
def test_contradictions_of_counts_and_cuts_are_told(keys, key, words):
    with pytest.raises(InputError) as told:
        plan(**keys)
    assert told.value.key == f"netting.0.{key}"
    assert words in str(told.value)


@pytest.mark.parametrize(
    ("keys", "key", "words"),
    [
        ({"netting": "belly"}, "netting", "a section: 1"),
        ({"panel": "port"}, "panel", "upper, lower"),
        ({"panel": "top"}, "panel", '"upper"'),
        ({"meshes_from_codline": [30, 10]}, "meshes_from_codline", "first"),
        ({"meshes_from_codline": [10, 50]}, "meshes_from_codline.1", "from 0 to 40"),
        ({"meshes_from_codline": [10.5, 30]}, "meshes_from_codline.0", "whole meshes"),
        ({"meshes_across": 51}, "meshes_across", "at most 50"),
        ({"selvedge_meshes": 2}, "selvedge_meshes", "one straight piece"),
        ({"name": "1"}, "name", "no other section"),
    ],
)
def test_windows_out_of_place_are_told(keys, key, words):
    with pytest.raises(InputError) as told:
        plan([{**WINDOW, **keys}], panels=2)
    assert told.value.key == f"window.0.{key}"
    assert words in str(told.value)


def test_windows_over_one_another_are_told():
    plan([WINDOW, {**WINDOW, "panel": "lower"}], panels=2)
    with pytest.raises(InputError, match="no other window"):
        plan([WINDOW, {**WINDOW, "meshes_from_codline": [25, 35]}], panels=2)


STRAP = {"length_m": 3.0, "axial_stiffness_n": 1e5}
ROPE = {"shortening": 0.1, "axial_stiffness_n": 1e4}


def with_lines(window: dict, **lines: list[dict]) -> Plan:
    """A codend of two panels with a window, 10 to 30 meshes from the codline of 40 and 30 of 50 across, and lines."""
    tables = plan([{**WINDOW, "meshes_round": 30, **window}], panels=2).to_dict()
    return plan_from_dict({**tables, **lines})


@pytest.mark.parametrize(
    ("window", "strap", "words"),
    [
        ({}, {"meshes_from_codline": 20}, "at most 10 or at least 30: at 20 it would run through window 1"),
        ({"name": "w"}, {"meshes_from_codline": 10.5}, "at 10.5 it would run through w"),
        ({}, {"meshes_from_codline": 6, "spacing_meshes": 8}, "at 14 it would run through window 1"),
        ({"meshes_round": 29}, {"meshes_from_codline": 30}, "below 10 or above 30: at 30 knots of its row are taken"),
    ],
)
def test_straps_through_a_window_are_told(window, strap, words):
    with pytest.raises(InputError) as told:
        with_lines(window, strap=[{**STRAP, **strap}])
    assert told.value.key == "strap.0.meshes_from_codline"
    assert words in str(told.value)
    assert len(str(told.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("rope", "key", "words"),
    [
        ({"number": 4}, "number", "rope 2 of 4 would run through window 1"),
        ({"number": 4, "meshes_from_codline": [0, 20]}, "meshes_from_codline", "as far as 10 or from 30"),
        ({"number": 4, "meshes_from_codline": [12, 14]}, "meshes_from_codline", "rope 2 of 4"),
    ],
)
def test_ropes_through_a_window_are_told(rope, key, words):
    with pytest.raises(InputError) as told:
        with_lines({}, rope=[{**ROPE, **rope}])
    assert told.value.key == f"rope.0.{key}"
    assert words in str(told.value)
    assert len(str(told.value).splitlines()) == 1


def test_lines_beside_a_window_or_along_its_edges_are_allowed():
    straps = [{**STRAP, "meshes_from_codline": place} for place in (9.5, 10, 30, 31)]
    ropes = [{**ROPE, "number": 2}, {**ROPE, "number": 4, "meshes_from_codline": [0, 10]}]
    assert with_lines({}, strap=straps, rope=ropes).globalisations == (1,)


def test_meshes_are_not_merged_where_a_rope_would_come_to_lie_in_a_window():
    # of 13 ropes one lies along the edge of a window from the 73rd to the 77th mesh, which merged by 2 ends at the 78th
    window = {"meshes_round": 4, "meshes_across": 4, "panel": "lower"}
    assert with_lines(window, rope=[{**ROPE, "number": 1}]).globalisations == (1, 2)
    assert with_lines(window, rope=[{**ROPE, "number": 13}]).globalisations == (1,)


def test_windows_side_by_side_need_a_mesh_between():
    whole = {**WINDOW, "meshes_across": 50}
    plan([whole], panels=2)
    plan([whole, {**whole, "panel": "lower", "meshes_from_codline": [0, 10]}], panels=2)
    with pytest.raises(InputError, match="a mesh between") as told:
        plan([whole, {**whole, "panel": "lower"}], panels=2)
    assert told.value.key == "window.1.meshes_from_codline"


def test_the_middle_of_a_window_is_that_of_its_panel():
    assert plan([WINDOW], panels=2).holes[0].first == 10
    assert plan([WINDOW], panels=1).holes[0].first == 10
    side = {**WINDOW, "panel": "port", "meshes_across": 15}
    assert plan([side], panels=4).holes[0].first == 30


def test_a_plan_of_panels_and_windows_reads_back(tmp_path):
    made = plan([WINDOW], panels=2, selvedge_meshes=2)
    path = tmp_path / "plan.toml"
    path.write_text(plan_toml(made))
    assert load_plan(path).to_dict() == made.to_dict()


PAIR_TRAWL = [(312, 40, "1N2B", 272), (340, 200, "1N2B", 140), (186, 126, "1N2B", 60), (80, 100, "AN", 80)]
"""Meshes across, deep, cut and meshes across aft of the upper panels of a high opening pair trawl, square to codend:
BOBP/WP/10, appendix 6, page 20 of the PDF (16 of the document), as transcribed in trawlkit 1.1.0 (data CC BY 4.0)."""


@pytest.mark.parametrize(("around", "deep", "cut", "aft"), PAIR_TRAWL)
def test_counts_of_a_published_trawl_follow_from_its_cuts(around, deep, cut, aft):
    counts = {"meshes_round": around, "meshes_long": deep}
    assert section(**counts, cut=cut).aft_meshes_round == aft
    assert section(**counts, meshes_round_aft=aft).edge_cut_text == cut
    assert section(**counts, cut=cut, meshes_round_aft=aft).edge_loss == (around - aft) / 2


def test_joins_of_a_published_trawl_follow_from_its_counts():
    pieces = [section(meshes_round=around, meshes_long=deep, cut=cut) for around, deep, cut, _ in PAIR_TRAWL]
    joins = [Fraction(ahead.aft_meshes_round, aft.meshes_round) for ahead, aft in pairwise(pieces)]
    assert joins == [Fraction(4, 5), Fraction(70, 93), Fraction(3, 4)]
