"""The command `codend fit`: the page and tables of trials, gears and catch comparisons."""

import re

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from codend.cli.main import main
from tests import ROOT
from tests.cli.test_cli import HADDOCK, assert_refused, codend_cli
from tests.selectivity.fits.trials import haul_table


@pytest.fixture
def trial(tmp_path):
    path = tmp_path / "trial.csv"
    haul_table(8, fish=150.0, seed=1).to_csv(path, index=False)
    return path


@pytest.fixture
def gears(tmp_path):
    path = tmp_path / "gears.csv"
    haul_table(8, fish=150.0, seed=1, gears=True).to_csv(path, index=False)
    return path


@pytest.fixture
def pairs(tmp_path):
    path = tmp_path / "pairs.csv"
    haul_table(8, "paired", fish=150.0, seed=1).to_csv(path, index=False)
    return path


def written(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


def test_a_trial_gives_a_page_with_its_answer_and_picture_first(trial, tmp_path):
    out = tmp_path / "out"
    result = codend_cli("fit", trial, "--design", "covered", "--reference-length", "30", "--out", out)
    assert result.exit_code == 0
    first = result.stdout.splitlines()[0]
    assert re.fullmatch(r"L50 [\d.]+ cm \([\d.]+ to [\d.]+\), SR [\d.]+ cm \([\d.]+ to [\d.]+\)", first)
    tables = {f"{name}.csv" for name in ("fit", "diagnostics", "predictions", "curves", "usability")}
    pictures = {f"fit_{name}.png" for name in ("curve", "hauls", "residuals")}
    assert written(out) == tables | pictures | {"fit.html"}
    page = (out / "fit.html").read_text(encoding="utf-8")
    assert page.index(first) < page.index("data:image/png") < page.index("<table")
    for heading in ("Estimates", "Usability", "Hauls", "Residuals", "Curves by AIC", "How each fit went"):
        assert f"<h2>{heading}</h2>" in page
    assert "dispersion factor" in page
    assert "<script" not in page


def test_gears_are_set_beside_each_other(gears, tmp_path):
    words = ("--group", "gear", "--covariate", "catch_kg", "--at", "catch_kg=300", "--at", "catch_kg=900")
    result = codend_cli("fit", gears, "--design", "covered", *words, "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert [line.partition(":")[0] for line in result.stdout.splitlines()[:2]] == ["A", "B"]
    table = pd.read_csv(tmp_path / "out" / "fit.csv")
    assert list(table["group"].unique()) == ["A", "B", "B minus A"]
    predictions = pd.read_csv(tmp_path / "out" / "predictions.csv")
    assert list(predictions["at"].unique()) == ["mean of hauls", "catch_kg=300", "catch_kg=900"]
    delta = pd.read_csv(tmp_path / "out" / "delta.csv")
    assert (delta["lower_all_95"] <= delta["lower_95"]).all()
    assert {"coefficients.csv", "fit_delta.png"} <= written(tmp_path / "out")
    assert "likelihood ratio p = " in (tmp_path / "out" / "fit.html").read_text(encoding="utf-8")


def test_catches_are_compared_without_a_curve(pairs, tmp_path):
    words = ("--design", "paired", "--compare", "--bootstrap", "50")
    result = codend_cli("fit", pairs, *words, "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert "test gear catches less than the control at 2" in result.stdout
    assert written(tmp_path / "out") == {"compare.csv", "fit_compare.png", "fit.html"}
    assert_refused(codend_cli("fit", pairs, "--design", "covered", "--compare", "--out", tmp_path / "no"), "--design")


def test_what_an_earlier_fit_left_is_removed(pairs, tmp_path):
    out = ("--out", tmp_path / "out")
    codend_cli("fit", pairs, "--design", "paired", "--compare", "--bootstrap", "20", *out)
    codend_cli("fit", pairs, "--design", "paired", "--split", "0.5", *out)
    assert not {"compare.csv", "fit_compare.png"} & written(tmp_path / "out")


@pytest.mark.parametrize("random", ["none", "haul:l50,sr,split", "trip:l50"])
def test_what_differs_at_random_can_be_said(random, pairs, tmp_path):
    table = pd.read_csv(pairs)
    table.assign(trip=table["haul"].map(lambda haul: int(haul[1:]) % 4)).to_csv(pairs, index=False)
    words = ("--design", "paired", "--split", "estimated", "--random", random)
    assert codend_cli("fit", pairs, *words, "--out", tmp_path / "out").exit_code in (0, 3)
    table = pd.read_csv(tmp_path / "out" / "fit.csv")
    sds = table["parameter"].str.startswith("between_sd").sum()
    assert sds == {"none": 0, "haul:l50,sr,split": 3, "trip:l50": 1}[random]


def test_dispersion_can_be_turned_off_and_is_said(tmp_path):
    errors = {}
    for kind, said in (("pearson", "dispersion factor of 2.07 (Pearson)"), ("none", "no dispersion factor, as asked")):
        result = codend_cli("fit", HADDOCK, "--design", "paired", "--overdispersion", kind, "--out", tmp_path)
        assert said in result.stdout
        errors[kind] = pd.read_csv(tmp_path / "fit.csv").set_index("parameter").loc["a", "standard_error"]
    assert errors["pearson"] > 1.3 * errors["none"]


def test_hauls_left_out_are_a_warning_with_their_number(trial, tmp_path):
    table = pd.read_csv(trial)
    table.loc[table["haul"] == "H2", "cover"] = 0
    table.to_csv(trial, index=False)
    result = codend_cli("fit", trial, "--design", "covered", "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert "between-hauls warning: 1 of 8 hauls left out" in result.stderr
    assert "1 of 8 hauls have no L50 of their own (H2)" in result.stderr


def test_names_from_a_table_are_escaped_on_the_page(gears, tmp_path):
    table = pd.read_csv(gears)
    table["gear"] = table["gear"].map({"A": "<b>100</b>", "B": "120 & more"})
    table.to_csv(gears, index=False)
    codend_cli("fit", gears, "--design", "covered", "--group", "gear", "--out", tmp_path / "out")
    page = (tmp_path / "out" / "fit.html").read_text(encoding="utf-8")
    assert "<b>100" not in page
    assert "&lt;b&gt;100" in page


def test_a_curve_that_others_leave_far_behind_is_named(tmp_path):
    data = ROOT / "validation" / "tables" / "simulated_covered_hauls.csv"
    result = codend_cli("fit", data, "--design", "covered", "--out", tmp_path / "out")
    assert "the logit curve has hardly any support beside the " in result.stderr
    assert "consider --curve" in (tmp_path / "out" / "fit.html").read_text(encoding="utf-8")


def test_flat_data_end_with_status_3_and_no_number(tmp_path):
    path = tmp_path / "flat.csv"
    table = haul_table(4, "paired", seed=2)
    table["test"] = table["control"] = 20 + table.index.to_numpy() % 3
    table.to_csv(path, index=False)
    result = codend_cli("fit", path, "--design", "paired", "--split", "estimated", "--out", tmp_path / "out")
    assert result.exit_code == 3
    assert result.stdout.startswith("no L50")
    assert "pooled was not fitted: " in result.stderr
    assert pd.read_csv(tmp_path / "out" / "fit.csv").query("group == 'pooled'")["estimate"].isna().all()


def test_gears_that_nobody_tells_apart_are_refused_with_what_would(gears, tmp_path):
    result = codend_cli("fit", gears, "--design", "covered", "--out", tmp_path / "out")
    assert_refused(result, "gear has 2 values", "--group gear for a curve each")
    result = codend_cli("fit", gears, "--design", "covered", "--random", "gear", "--out", tmp_path / "out")
    assert_refused(result, "random", "3 or more units")


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--group", "vessel"], "vessel"),
        (["--l50", "catch_kg", "--bootstrap", "10"], "--bootstrap"),
        (["--l50", "catch_kg +"], "l50"),
        (["--at", "catch_kg=3"], "--at"),
        (["--reference-length", "-3"], "--reference-length"),
        (["--random", "haul:l95"], "random"),
        (["--overdispersion", "some"], "overdispersion"),
    ],
)
def test_choices_that_cannot_be_are_refused_before_anything_is_written(words, named, trial, tmp_path):
    assert_refused(codend_cli("fit", trial, "--design", "covered", *words, "--out", tmp_path / "out"), named)
    assert not (tmp_path / "out").exists()


LENGTHS_CM = np.arange(20.0, 46.0, 2.0)


def hostile(share, hauls: int = 6) -> pd.DataFrame:
    """Hauls of 40 fish at every length, of which the share at that length is retained, by chance."""
    rng, frames = np.random.default_rng(0), []
    for haul in range(hauls):
        kept = rng.binomial(40, share(LENGTHS_CM))
        frames.append(pd.DataFrame({"haul": haul, "length_cm": LENGTHS_CM, "codend": kept, "cover": 40 - kept}))
    return pd.concat(frames, ignore_index=True)


@pytest.mark.parametrize(
    "share",
    [
        lambda length: np.full_like(length, 0.5),
        lambda length: 1.0 / (1.0 + np.exp(0.5 * (length - 32.0))),
        np.ones_like,
        lambda length: np.exp(-0.5 * ((length - 32.0) / 4.0) ** 2),
    ],
    ids=["flat", "reversed", "all retained", "a hump"],
)
def test_hauls_that_tell_of_no_selection_get_no_number_and_a_word(share, tmp_path):
    hostile(share).to_csv(tmp_path / "hauls.csv", index=False)
    asked = ["fit", str(tmp_path / "hauls.csv"), "--design", "covered", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(main, asked)
    assert result.exit_code == 3
    assert "no L50" in result.output
    assert "pooled was not fitted: " in result.output
    table = pd.read_csv(tmp_path / "out" / "fit.csv")
    gear = table[~table["group"].str.startswith("haul ")]
    assert gear[["estimate", "standard_error", "lower_95", "upper_95"]].isna().all(axis=None)


def test_a_selection_range_wider_than_the_lengths_is_said(tmp_path):
    hostile(lambda length: 1.0 / (1.0 + np.exp(-0.02 * (length - 32.0)))).to_csv(tmp_path / "hauls.csv", index=False)
    asked = ["fit", str(tmp_path / "hauls.csv"), "--design", "covered", "--out", str(tmp_path / "out")]
    assert "wider than all lengths measured" in CliRunner().invoke(main, asked).output


def fitted(table, folder, *options):
    table.to_csv(folder / "hauls.csv", index=False)
    asked = ["fit", str(folder / "hauls.csv"), "--design", "covered", *options, "--out", str(folder / "out")]
    return CliRunner().invoke(main, asked)


def test_two_hauls_are_answered_by_the_pooled_fit_with_a_word_on_its_limits(tmp_path):
    result = fitted(haul_table(2, fish=300.0, seed=1), tmp_path)
    assert re.match(r"L50 3\d\.\d\d cm", result.output), result.output
    assert "2 hauls tell nothing of how hauls differ" in result.output
    assert pd.read_csv(tmp_path / "out" / "fit.csv")["group"][0] == "pooled"


def test_a_gear_that_retained_nothing_is_named(tmp_path):
    table = haul_table(6, fish=150.0, seed=1, gears=True)
    table.loc[table["gear"] == "B", "codend"] = 0
    result = fitted(table, tmp_path, "--group", "gear")
    assert result.exit_code == 3
    assert "not fitted: B has no fish in codend" in result.output


def test_where_an_answer_that_depends_on_columns_is_asked_for_is_said(tmp_path):
    table = haul_table(6, fish=150.0, seed=1, gears=True)
    result = fitted(table, tmp_path, "--l50", "gear + catch_kg")
    mean = table.groupby("haul")["catch_kg"].first().mean()
    assert f"at the mean of the 6 hauls (gear: A in 3, B in 3; catch_kg = {mean:.4g})" in result.output


def test_counts_of_a_hundred_millions_get_no_number_between_hauls_and_the_reason(tmp_path):
    table = haul_table(4, fish=150.0, seed=1)
    table[["codend", "cover"]] *= 1_000_000
    result = fitted(table, tmp_path)
    assert result.exit_code == 3
    assert "one-stage was not fitted: more than 1e+08 fish are counted" in result.output
