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
