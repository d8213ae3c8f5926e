"""Designs beside each other: what differs, differences at the same catch, and never beyond the catches computed."""

import numpy as np
import pandas as pd
import pytest

from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """Three designs of which one has species, the second other catches."""
    home = tmp_path_factory.mktemp("designs")
    (home / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    (home / "fish.toml").write_text(codend_cli("species").stdout, encoding="utf-8")
    for name, changes in {"first": (), "other": ("netting.0.twine_mm=2.5", "catch.filled_meshes=[3,5,7]")}.items():
        words = ["--set", *changes] if changes else []
        assert codend_cli("run", home / "plan.toml", "--out", home / name, *words).exit_code == 0
        words = ["--species", home / "fish.toml", "--bootstrap", 0, "--samples", 0]
        assert codend_cli("selectivity", home / name, *words).exit_code == 0
    return home


@pytest.fixture(scope="module")
def compared(home):
    result = codend_cli("compare", home / "first", home / "other", "--out", home / "out")
    assert result.exit_code == 0, result.output
    return home / "out"


def test_what_differs_in_the_plans_is_told_and_nothing_else(compared):
    plans = pd.read_csv(compared / "plan_differences.csv", dtype=str)
    assert plans["key"].tolist() == ["netting.0.twine_mm", "catch.filled_meshes"]
    assert plans["other"].tolist() == ["2.5", "[3.0, 5.0, 7.0]"]


def test_differences_are_taken_at_the_catches_of_the_first_and_not_beyond_those_of_the_other(compared, home):
    found = pd.read_csv(compared / "design_differences.csv")
    first, other = (pd.read_csv(home / name / "results.csv") for name in ("first", "other"))
    assert found["catch_mass_kg"].to_numpy() == pytest.approx(first["catch_mass_kg"].iloc[0])
    drag = found[found["quantity"] == "drag_n"].iloc[0]
    there = np.interp(first["catch_mass_kg"].iloc[0], other["catch_mass_kg"], other["drag_n"])
    assert drag["difference"] == pytest.approx(there - first["drag_n"].iloc[0], rel=1e-6)
    assert drag["lower"] < drag["difference"] < drag["upper"]
    assert set(found["quantity"]) == {"opening_ahead_deg", "drag_n", "l50_cm", "sr_cm"}


def test_l50s_beside_each_other_are_of_the_fits_whose_intervals_they_have(compared, home):
    shown = pd.read_csv(compared / "designs.csv").query("quantity == 'l50_cm' and design == 'first'")
    table = pd.read_csv(home / "first" / "selectivity.csv").query("case != 'haul'")
    assert shown["value"].to_numpy() == pytest.approx(table["l50_logit_cm"].to_numpy(), rel=1e-6)
    between = 0.5 * (table["l50_upper_95_cm"] - table["l50_lower_95_cm"])
    assert shown["half_width"].to_numpy() == pytest.approx(between.to_numpy(), rel=1e-6)


def test_a_design_beside_itself_differs_in_nothing(compared, home):
    result = codend_cli("compare", home / "first", home / "first", "--out", home / "none")
    assert_refused(result, "is named twice")


def test_the_page_holds_figure_and_names(compared):
    page = (compared / "designs.html").read_text(encoding="utf-8")
    assert "netting.0.twine_mm" in page
    assert "data:image/png" in page
    assert (compared / "designs.png").stat().st_size > 10_000


def test_folders_without_a_place_to_write_to_or_without_a_run_are_refused(home, tmp_path):
    assert_refused(codend_cli("compare", home / "first", home / "other"), "--out is missing")
    assert_refused(codend_cli("compare", home / "first", tmp_path, "--out", tmp_path / "out"), "plan.toml")
    assert not (tmp_path / "out").exists()


def test_catches_of_the_first_that_cannot_be_compared_are_told_and_none_at_all_is_refused(home, tmp_path):
    words = ["run", home / "plan.toml", "--out", tmp_path / "faster", "--set", "tow.speed_m_s=1.9"]
    assert codend_cli(*words).exit_code == 0
    refused = codend_cli("compare", home / "first", tmp_path / "faster", "--out", tmp_path / "out")
    assert_refused(refused, "faster", "has no catch to compare", "a speed of first")
    told = codend_cli("compare", home / "first", home / "other", "--out", tmp_path / "out")
    assert "catches of first are left out" in told.stderr
    assert "are left out" in (tmp_path / "out" / "designs.html").read_text(encoding="utf-8")
