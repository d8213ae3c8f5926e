"""Haul tables as people keep them: read as they are, or refused in one line that says what the file is."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import Result

from tests.cli.test_cli import assert_refused, codend_cli

GIVEN = Path(__file__).parent / "hauls"
LENGTHS = np.arange(20.0, 42.0, 2.0)


def hauls(number: int = 4, **more: object) -> pd.DataFrame:
    """Made-up hauls of 100 fish a length class 2 cm wide, split by logistic curves of SR 4 cm about 30 cm."""
    frames = []
    for haul in range(1, number + 1):
        l50 = 29.0 + 2.0 * (haul - 1) / max(number - 1, 1)
        kept = np.round(100.0 / (1.0 + np.exp(-0.5 * np.log(3.0) * (LENGTHS - l50)))).astype(int)
        frames.append(
            pd.DataFrame({"haul": f"H{haul}", "length_cm": LENGTHS, "codend": kept, "cover": 100 - kept, **more})
        )
    return pd.concat(frames, ignore_index=True)


def fit(text: str | bytes | pd.DataFrame, folder: Path, *words: object) -> Result:
    path = folder / "hauls.csv"
    text = text.to_csv(index=False) if isinstance(text, pd.DataFrame) else text
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return codend_cli("fit", path, "--design", "covered", "--out", folder / "out", *words)


def l50_cm(folder: Path, group: str = "pooled") -> float:
    table = pd.read_csv(folder / "out" / "fit.csv").query(f"group == '{group}'").set_index("parameter")
    return float(table.loc["l50_cm", "estimate"])


def european(table: pd.DataFrame, separator: str = ";") -> str:
    return table.to_csv(index=False, sep=separator, decimal=",")


# --- forms of the file


@pytest.mark.parametrize(
    ("name", "l50", "said"),
    [
        ("semi", 25.05, "has semicolons between columns\n"),
        ("semidec", 25.55, "has semicolons between columns and commas in numbers\n"),
        ("tab", 25.05, "has tabs between columns\n"),
        ("caps", 25.05, ""),
        ("trail", 25.05, ""),
    ],
)
def test_the_forms_that_were_met_are_read(name, l50, said, tmp_path):
    result = codend_cli("fit", GIVEN / f"hauls_{name}.csv", "--design", "covered", "--out", tmp_path / "out")
    assert (result.exit_code, result.stderr) == (0, "")
    assert said in result.stdout
    assert l50_cm(tmp_path) == pytest.approx(l50, abs=0.01)


def test_letters_that_are_not_utf8_are_asked_for_and_read_as_the_option_says(tmp_path):
    words = ("fit", GIVEN / "hauls_lat1.csv", "--design", "covered", "--out", tmp_path / "out")
    assert_refused(codend_cli(*words), "Latin-1", "line 2", "å", "--encoding latin-1")
    assert not (tmp_path / "out").exists()
    assert codend_cli(*words, "--encoding", "latin-1").exit_code == 0
    assert "haul Hål 1" in set(pd.read_csv(tmp_path / "out" / "fit.csv")["group"])
    assert_refused(codend_cli(*words, "--encoding", "klingon"), "encoding", "klingon", "latin-1")


HALVES = hauls().assign(length_cm=lambda f: f["length_cm"] + 0.5)
NAMED = hauls().rename(columns={"haul": "HAUL", "length_cm": "Length (cm)", "codend": " Codend", "cover": "COVER"})


@pytest.mark.parametrize(
    ("text", "l50"),
    [
        (european(HALVES), 30.5),
        (european(HALVES, "\t"), 30.5),
        (european(HALVES, "|"), 30.5),
        (HALVES.to_csv(index=False, decimal=","), 30.5),  # commas in quotes
        ("sep=;\r\n" + european(HALVES).replace("\n", "\r\n"), 30.5),
        (european(HALVES).encode("utf-16"), 30.5),
        (b"\xff\xfe" + european(HALVES, "\t").encode("utf-16-le"), 30.5),
        (b"\xef\xbb\xbf" + HALVES.to_csv(index=False).encode(), 30.5),
        (HALVES.to_csv(index=False).encode("utf-32"), 30.5),
        (european(HALVES).replace("\n", ";;\n") + ";;;;;\n;;;;;\n", 30.5),
        ("# a cruise;;;\n" + european(HALVES), 30.5),
        (NAMED, 30.0),
        (hauls().rename(columns={"length_cm": "length_mm"}).assign(length_mm=lambda f: 10 * f["length_mm"]), 30.0),
    ],
)
def test_a_form_that_can_be_told_is_read(text, l50, tmp_path):
    result = fit(text, tmp_path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert l50_cm(tmp_path) == pytest.approx(l50, abs=0.01)


PLAIN = hauls().to_csv(index=False)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (PLAIN.replace(",", ";", 1), ["commas and semicolons in its header", "--separator"]),
        (PLAIN.replace(",", " "), ["blanks between its columns", "commas, semicolons or tabs"]),
        (PLAIN.replace("\n", ",5\n").replace("cover,5", "cover"), ["line 2 has 5 cells", "semicolons or tabs"]),
        (PLAIN.encode("utf-16-le"), ["UTF-16 without a byte order mark", "--encoding"]),
        (b"PK\x03\x04" + bytes(100), ["spreadsheet (.xlsx", "plain text"]),
        (b"\xd0\xcf\x11\xe0\xa1\xb1" + bytes(100), ["old Office (.xls"]),
        (b"%PDF-1.7\n", ["PDF"]),
        (b"<html><table></table></html>", ["web page"]),
        (PLAIN.replace("length_cm", "Length_cm").replace("cover", "LENGTH_CM"), ["length_cm", "given twice"]),
        (european(HALVES).replace("20,5", "wide"), ["semicolons between columns and commas in numbers", '"wide"']),
    ],
)
def test_a_form_that_cannot_be_read_is_refused_by_what_it_is(text, words, tmp_path):
    assert_refused(fit(text, tmp_path), "hauls.csv", *words)
    assert not (tmp_path / "out").exists()


RAISED = hauls().assign(codend_raising=1.25, cover_raising=1.0)
GROUPED = RAISED.to_csv(index=False, sep=";").replace("1.25;", "1.250;").replace(";1.0\n", ";1\n").replace(".0;", ";")


@pytest.mark.parametrize(
    ("text", "mark", "shown"),
    [
        (GROUPED, ".", "1.250, whose point"),
        (GROUPED.replace("1.250", "1,250"), ",", "1,250, whose comma"),
        (GROUPED.replace(";", ",").replace("1.250", '"1,250"'), ",", "1,250, whose comma"),
    ],
)
def test_a_mark_that_may_stand_after_thousands_is_asked_for(text, mark, shown, tmp_path):
    assert_refused(fit(text, tmp_path), shown, "may stand before a fraction or after thousands", "--decimal")
    assert fit(text, tmp_path, "--decimal", mark).exit_code == 0
    raised = l50_cm(tmp_path)
    assert fit(RAISED, tmp_path).exit_code == 0
    assert l50_cm(tmp_path) == pytest.approx(raised, rel=1e-12)
    other = {".": ",", ",": "."}[mark]
    assert_refused(fit(text, tmp_path, "--decimal", other), "codend_raising", "is not allowed")


def test_points_and_commas_in_one_file_are_not_guessed_at(tmp_path):
    text = european(RAISED).replace("1,25;", "1.25;").replace("24,0;", "24,5;")
    assert_refused(fit(text, tmp_path), "points and commas in numbers", "--decimal")
    assert_refused(fit(text, tmp_path, "--decimal", ","), 'codend_raising = "1.25"', "commas in numbers")


def test_a_separator_that_is_named_is_taken(tmp_path):
    text = PLAIN.replace(",", ";").replace("cover", "cover;depth, m").replace("\n", ";5\n").replace("m;5", "m")
    assert_refused(fit(text, tmp_path), "commas and semicolons in its header", "--separator")
    assert fit(text, tmp_path, "--separator", ";").exit_code == 0
    assert fit(text.replace(";", "\t"), tmp_path, "--separator", "tab").exit_code == 0
    assert_refused(fit(text, tmp_path, "--separator", "/"), "--separator", '"/"', "tab")
    assert_refused(fit(text, tmp_path, "--decimal", "x"), "--decimal", '"x"')


def test_a_table_is_refused_unread_from_a_size_on(tmp_path):
    assert_refused(fit(PLAIN + "#" * 20_000_000, tmp_path), "too large", "at most 20 MB")


# --- lengths


def intervals(width: float, between: str = "-") -> pd.DataFrame:
    return hauls().assign(
        length_cm=lambda f: [f"{length:g}{between}{length + width:g}" for length in f["length_cm"] - 1.0]
    )


@pytest.mark.parametrize("between", ["-", " - ", "\u2013", " to "])
def test_intervals_that_share_their_bounds_are_taken_at_their_middle(between, tmp_path):
    result = fit(intervals(2.0, between), tmp_path)
    assert result.exit_code == 0
    assert f"intervals such as {19:g}-{21:g}" in result.stdout
    assert l50_cm(tmp_path) == pytest.approx(30.0, abs=0.01)


def test_intervals_with_decimal_commas_are_read(tmp_path):
    text = european(intervals(1.9)).replace(".", ",")
    assert_refused(fit(text, tmp_path), "19-20.9", "--length-is")
    assert fit(text, tmp_path, "--length-is", "lower").exit_code == 0
    assert l50_cm(tmp_path) == pytest.approx(30.0, abs=0.01)


@pytest.mark.parametrize(("length_is", "l50"), [("midpoint", 29.5), ("lower", 30.0)])
def test_intervals_that_do_not_meet_are_asked_about(length_is, l50, tmp_path):
    assert_refused(fit(intervals(1.0), tmp_path), "19-20", "--length-is midpoint", "19.5", "--length-is lower")
    assert fit(intervals(1.0), tmp_path, "--length-is", length_is).exit_code == 0
    assert l50_cm(tmp_path) == pytest.approx(l50, abs=0.01)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (intervals(2.0).replace("19-21", "20"), ['length_cm = "20"', "line 2", "intervals in every row, or in none"]),
        (intervals(3.0), ["overlap", "19-22 and 21-24"]),
        (intervals(2.0).replace("19-21", "21-19"), ['length_cm = "21-19"']),
        (hauls().replace({"length_cm": {40.0: "40+"}}), ['length_cm = "40+"', "line 12"]),
    ],
)
def test_lengths_that_are_neither_numbers_nor_classes_are_refused(text, words, tmp_path):
    assert_refused(fit(text, tmp_path), *words)


def test_lower_ends_of_classes_are_moved_to_their_middle_with_a_word(tmp_path):
    result = fit(hauls(), tmp_path, "--length-is", "lower")
    assert "length_cm is the lower end of classes 2 wide" in result.stdout
    assert l50_cm(tmp_path) == pytest.approx(31.0, abs=0.01)
    uneven = hauls().replace({"length_cm": {20.0: 20.5}})
    assert_refused(fit(uneven, tmp_path, "--length-is", "lower"), "does not tell how wide its classes are")
    assert_refused(fit(hauls(), tmp_path, "--length-is", "upper"), "--length-is", "midpoint or lower")


@pytest.mark.parametrize(("factor", "shown"), [(10.0, "400.0"), (0.01, "0.4"), (3.0, "60.0")])
def test_lengths_that_are_hardly_cm_are_asked_about(factor, shown, tmp_path):
    table = hauls().assign(length_cm=lambda f: factor * f["length_cm"])
    assert_refused(fit(table, tmp_path), f"length_cm = {shown}", "can hardly be in cm", "--length-unit mm")
    assert fit(table, tmp_path, "--length-unit", "cm").exit_code == 0
    assert l50_cm(tmp_path) == pytest.approx(30.0 * factor, rel=1e-3)
    assert fit(table, tmp_path, "--length-unit", "mm").exit_code == 0
    assert l50_cm(tmp_path) == pytest.approx(3.0 * factor, rel=1e-3)
    assert_refused(fit(table, tmp_path, "--length-unit", "inch"), "--length-unit", "mm or cm")


# --- what is no single haul of one gear and species


@pytest.mark.parametrize("name", ["Total", "TOTAL", "All hauls", "Summe", "sub-total", "Sum of hauls"])
def test_a_total_by_name_is_refused(name, tmp_path):
    total = hauls().groupby("length_cm", as_index=False)[["codend", "cover"]].sum().assign(haul=name)
    assert_refused(fit(pd.concat([hauls(), total]), tmp_path), f'haul = "{name}" in line 46', "no totals")


def test_a_total_row_at_the_end_of_a_haul_is_refused(tmp_path):
    rows = hauls(1)
    total = pd.DataFrame({"haul": ["H1"], "length_cm": ["Total"], "codend": rows["codend"].sum(), "cover": 550})
    assert_refused(fit(pd.concat([rows, total]), tmp_path), 'length_cm = "Total" in line 13', "no totals")
    unnamed = total.assign(length_cm=99, cover=rows["cover"].sum())
    assert_refused(fit(pd.concat([rows, unnamed]), tmp_path), "length_cm", "line 13", "the fish of this row")


def test_a_haul_that_is_the_sum_of_the_others_is_refused_whatever_its_name(tmp_path):
    total = hauls().groupby("length_cm", as_index=False)[["codend", "cover"]].sum().assign(haul="H5")
    assert_refused(fit(pd.concat([hauls(), total]), tmp_path), 'haul = "H5" in line 46', "all others together")


def test_hauls_that_a_user_pooled_are_one_haul(tmp_path):
    assert fit(hauls(1).assign(haul="all hauls"), tmp_path).exit_code == 0


@pytest.mark.parametrize(
    ("column", "one", "two"),
    [("species", "cod", "haddock"), ("Gear", "T90", "T0"), ("trawl name", "Anna", "Berta"), ("mesh_mm", 100, 120)],
)
def test_two_gears_or_species_in_one_file_are_refused_and_one_is_read_alone(column, one, two, tmp_path):
    both = pd.concat(
        [hauls().assign(**{column: one}), hauls(3).assign(haul=lambda f: "B" + f["haul"], **{column: two})]
    )
    assert_refused(fit(both, tmp_path), column, "has 2 values", f"--only {column}={one}")
    assert fit(both, tmp_path, "--only", f"{column}={two}").exit_code == 0
    assert l50_cm(tmp_path) == pytest.approx(30.0, abs=0.01)
    assert_refused(fit(both, tmp_path, "--only", f"{column}=other"), "is in no row", str(one), str(two))
    assert_refused(fit(both, tmp_path, "--only", column), "--only", "COLUMN=VALUE")


def test_gears_that_a_covariate_tells_apart_are_one_fit(tmp_path):
    hauls_of = [hauls().assign(haul=lambda f, mesh=mesh: f"{mesh}" + f["haul"], mesh=mesh) for mesh in (90, 110)]
    both = pd.concat(hauls_of).assign(gear=lambda f: f["mesh"].map({90: "narrow", 110: "wide"}))
    assert_refused(fit(both, tmp_path), "mesh", "--covariate mesh")
    assert fit(both, tmp_path, "--covariate", "mesh").exit_code == 0


def test_a_column_that_was_not_asked_for_is_named(tmp_path):
    assert "not used: depth_m\n" in fit(hauls().assign(depth_m=lambda f: f["haul"].str[1:]), tmp_path).stdout


# --- covariates


def test_the_collinear_covariates_that_were_met_are_refused(tmp_path):
    words = ("--design", "covered", "--covariate", "mesh", "--covariate", "twine", "--out", tmp_path / "out")
    result = codend_cli("fit", GIVEN / "hauls_collinear_covariates.csv", *words)
    assert_refused(result, "twine says the same as mesh", "over these 6 hauls")


def test_covariates_that_say_what_others_say_together_are_refused(tmp_path):
    number = hauls(6)["haul"].str[1:].astype(int)
    table = hauls(6).assign(depth=number, speed=(number % 3) * 0.1, both=lambda f: 3 * f["depth"] - 7 * f["speed"])
    names = ("--covariate", "depth", "--covariate", "speed")
    assert fit(table, tmp_path, *names).exit_code == 0
    assert_refused(fit(table, tmp_path, *names, "--covariate", "both"), "both says the same as depth and speed")


# --- data that tell nothing

ALL_KEPT = hauls().assign(codend=10, cover=0)
ONE_LENGTH = hauls().query("length_cm == 30.0")
FALLING = hauls().assign(codend=lambda f: f["cover"], cover=lambda f: 100 - f["codend"])


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (ALL_KEPT, ["the counts do not determine the parameters", "nor were 4 of 4 hauls"]),
        (ONE_LENGTH, ["too few lengths with fish", "nor were 4 of 4 hauls"]),
        (FALLING, ["falls with length", "check which column"]),
    ],
)
def test_hauls_that_tell_nothing_end_in_one_line_that_says_so(table, words, tmp_path):
    result = fit(table, tmp_path, "--bootstrap", 5)
    assert result.exit_code == 3
    assert result.stderr.startswith("pooled was not fitted: ")
    assert result.stderr.count("\n") == 1
    assert all(word in result.stderr for word in words)
    assert pd.read_csv(tmp_path / "out" / "fit.csv")["estimate"].isna().all()


def test_fish_that_were_never_caught_fit_nothing(tmp_path):
    assert_refused(fit(hauls().assign(codend=0, cover=0), tmp_path), "at least one fish")


# --- what a spreadsheet would take for a formula


@pytest.mark.parametrize("name", ["=1+1", "+1", "-1", "@SUM(A1)", '=HYPERLINK("http://example.org")'])
def test_names_reach_no_spreadsheet_as_formulas(name, tmp_path):
    result = fit(hauls().replace("H1", name).assign(**{name: lambda f: f["haul"].map(len)}), tmp_path)
    assert result.exit_code == 0
    for file in ("fit.csv", "diagnostics.csv"):
        cells = pd.read_csv(tmp_path / "out" / file, dtype=str)
        texts = cells.select_dtypes(include=["object", "string"])[["group", "curve"]]
        assert not texts.stack().str.startswith(("=", "+", "-", "@")).any()
