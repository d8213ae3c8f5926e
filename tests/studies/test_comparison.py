from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import codend
from codend.errors import InputError
from codend.io.run_tables import read_run_table
from codend.report.comparison_plot import comparison_figure
from codend.studies.comparison import Hoop, compare, read_flume_table
from validation.make_flume_table import TABLE, table_text

# Everything linear in the catch, so that interpolated values are known exactly. Made up for the tests.
CASES = [(1.0, 10.0), (1.0, 20.0), (1.0, 30.0), (1.5, 10.0), (1.5, 30.0)]
RESULTS = pd.DataFrame(
    {
        "case": number,
        "speed_m_s": speed,
        "filled_meshes": filled,
        "catch_volume_m3": 0.01 * filled,
        "catch_mass_kg": 10.0 * filled,
        "drag_n": 100.0 * speed**2 + 2.0 * filled,
        "front_from_codline_m": 0.05 * filled,
        "max_radius_m": 0.1 + 0.01 * filled,
        "length_m": 6.0 - 0.1 * filled,
        "converged": True,
    }
    for number, (speed, filled) in enumerate(CASES, start=1)
)


@pytest.fixture
def write(tmp_path):
    def written(text: str) -> Path:
        path = tmp_path / "flume.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return written


def value(comparison, quantity: str, line: int, column: str):
    points = comparison.points
    return points[(points["quantity"] == quantity) & (points["table_line"] == line)][column].item()


# --- reading ---------------------------------------------------------------------------------------------------------

GOOD = "# a source\nfilled_meshes,speed_m_s,drag_n\n10,1.0,120\n"


def test_comments_columns_and_empty_cells_are_read(write):
    table = read_flume_table(
        write("#\n# Tank X, 1999: page 3\n# fresh water\nspeed_m_s, drag_n,length_m\n1,,5\n\n1.5,80,\n")
    )
    assert table.origin == "Tank X, 1999: page 3"
    assert table.comments == ("", "Tank X, 1999: page 3", "fresh water")
    np.testing.assert_array_equal(table.columns["drag_n"], [np.nan, 80.0])
    np.testing.assert_array_equal(table.columns["length_m"], [5.0, np.nan])
    assert table.lines.tolist() == [5, 7]


def test_tables_as_spreadsheets_save_them_are_read(write):
    table = read_flume_table(write('\ufeff"# Tank X, 1999"\r\n"filled_meshes","drag_n"\r\n"10","120"\r\n'))
    assert table.origin == "Tank X, 1999"
    assert table.columns["drag_n"].tolist() == [120.0]


def test_semicolons_between_columns_are_read(write):
    table, plain = read_flume_table(write(GOOD.replace(",", ";"))), read_flume_table(write(GOOD))
    assert table.columns == plain.columns


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("drag_n", "drag_kn", ["drag_kn", "no known column", "front_from_codline_m"]),
        ("speed_m_s,", "", ["line 3", "3 cells", "2 cells"]),
        ("speed_m_s", "drag_n", ["drag_n", "line 2", "twice"]),
        ("speed_m_s", "", ["(empty)", "no known column"]),
        ("120", "12O", ["drag_n", '"12O"', "line 3", "number"]),
        ("120", "-1", ["drag_n", '"-1"', "line 3", "0 or more"]),
        ("120", "nan", ["drag_n", '"nan"', "line 3"]),
        ("120", "inf", ["drag_n", '"inf"', "line 3"]),
        ("120", "1_2", ["drag_n", '"1_2"', "line 3"]),
        ("120", "1,2", ["line 3", "3 cells", "4 cells"]),
        ("10,1.0,120\n", "10,1.0,120\n10,1,120.0\n", ["line 4", "repeats line 3"]),
        ("10,1.0,120\n", "", ["no rows"]),
        ("10,1.0,120", ",,120", ["match", "catch_mass_kg"]),
        ("10,1.0,120", "10,1.0,", ["no column to compare", "drag_n"]),
        ("drag_n", "hoop_drag_n", ["no column to compare"]),
        ("drag_n\n10,1.0,120", "length_m,hoop_drag_n\n10,1.0,5,20", ["hoop_drag_n", "drag_n beside it"]),
        (GOOD, "", ["header"]),
        (GOOD, "# only a comment\n", ["header"]),
    ],
)
def test_a_table_that_cannot_be_used_is_refused_on_one_line_that_says_where(write, old, new, words):
    assert old in GOOD
    path = write(GOOD.replace(old, new))
    with pytest.raises(InputError) as caught:
        read_flume_table(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert len(message.splitlines()) == 1
    for word in words:
        assert word in message


@pytest.mark.parametrize("make", [lambda path: None, Path.mkdir, lambda path: path.write_bytes(b"\xff\xfe")])
def test_what_is_no_text_file_is_refused(tmp_path, make):
    make(tmp_path / "table.csv")
    with pytest.raises(InputError, match="cannot be read"):
        read_flume_table(tmp_path / "table.csv")


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda r: r.drop(columns="drag_n"), "drag_n"),
        (lambda r: r.drop(columns="converged"), "converged"),
        (lambda r: r.assign(converged=False), "converged"),
        (lambda r: r.assign(converged="maybe"), "converged"),
    ],
)
def test_results_that_cannot_be_used_are_refused(write, change, word):
    with pytest.raises(InputError) as caught:
        compare(change(RESULTS), read_flume_table(write(GOOD)), "here/results.csv")
    assert caught.value.key == word
    assert str(caught.value).startswith("here/results.csv: ")


@pytest.mark.parametrize(
    "make", [lambda path: None, Path.mkdir, Path.touch, lambda path: path.write_bytes(b"\xff\xfe")]
)
def test_results_that_cannot_be_read_are_refused(tmp_path, make):
    make(tmp_path / "results.csv")
    with pytest.raises(InputError, match="cannot be read"):
        read_run_table(tmp_path / "results.csv")


def test_cases_that_did_not_converge_are_never_compared_with(tmp_path, write):
    drag = RESULTS["drag_n"].where(RESULTS["case"] != 2, 1e6)
    RESULTS.assign(drag_n=drag, converged=RESULTS["case"] != 2).to_csv(tmp_path / "results.csv", index=False)
    table = read_flume_table(write("speed_m_s,filled_meshes,drag_n\n1.0,20,140\n"))
    comparison = compare(read_run_table(tmp_path / "results.csv"), table)
    assert comparison.points["computed"].item() == pytest.approx(140.0)


# --- matching --------------------------------------------------------------------------------------------------------


def test_statistics_are_those_of_the_differences_computed_minus_tabled(write):
    table = read_flume_table(write("speed_m_s,filled_meshes,drag_n\n1.0,10,119\n1.0,20,143\n1.0,30,161\n1.5,10,250\n"))
    summary = compare(RESULTS, table).summary.iloc[0]
    error, tabled = np.array([1.0, -3.0, -1.0, -5.0]), np.array([119.0, 143.0, 161.0, 250.0])
    assert summary["points"] == 4
    assert summary["bias"] == pytest.approx(-2.0)
    assert summary["rms"] == pytest.approx(3.0)
    assert summary["largest"] == pytest.approx(-5.0)
    assert summary["relative_bias"] == pytest.approx(np.mean(error / tabled))
    assert summary["relative_rms"] == pytest.approx(np.sqrt(np.mean((error / tabled) ** 2)))
    assert summary["relative_largest"] == pytest.approx(-3.0 / 143.0)


def test_a_tabled_zero_has_no_relative_difference(write):
    table = read_flume_table(write("speed_m_s,filled_meshes,drag_n\n1.0,10,0\n1.0,20,140\n"))
    comparison = compare(RESULTS, table)
    assert np.isnan(value(comparison, "drag_n", 2, "relative_difference"))
    assert comparison.summary["largest"].item() == pytest.approx(120.0)
    assert comparison.summary["relative_largest"].item() == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("column", "size"), [("filled_meshes", 17.0), ("catch_volume_m3", 0.17), ("catch_mass_kg", 170.0)]
)
def test_cases_are_interpolated_along_whatever_catch_column_the_table_has(write, column, size):
    header = f"{column},speed_m_s,drag_n,front_from_codline_m,max_diameter_m,length_m"
    comparison = compare(RESULTS, read_flume_table(write(f"{header}\n{size},1.0,1,1,1,1\n")))
    expected = {"drag_n": 134.0, "front_from_codline_m": 0.85, "max_diameter_m": 0.54, "length_m": 4.3}
    assert comparison.matched_on == column
    for quantity, number in expected.items():
        assert value(comparison, quantity, 2, "computed") == pytest.approx(number)
        assert value(comparison, quantity, 2, "interpolated")


@pytest.mark.parametrize("filled", [9.99, 30.01, 0.0])
def test_cases_are_never_extrapolated(write, filled):
    table = read_flume_table(write(f"filled_meshes,speed_m_s,drag_n\n{filled},1,100\n20,1,140\n"))
    comparison = compare(RESULTS, table)
    assert np.isnan(value(comparison, "drag_n", 2, "computed"))
    assert "outside the computed 10 to 30" in value(comparison, "drag_n", 2, "note")
    assert comparison.summary["points"].item() == 1


def test_the_ends_of_the_computed_range_are_in_it_and_not_interpolated(write):
    table = read_flume_table(write("filled_meshes,speed_m_s,drag_n\n10,1,120\n30.00000001,1,160\n"))
    points = compare(RESULTS, table).points
    np.testing.assert_allclose(points["computed"], [120.0, 160.0])
    assert not points["interpolated"].any()


def test_speeds_are_matched_and_never_interpolated(write):
    table = read_flume_table(write("filled_meshes,speed_m_s,drag_n\n20,1.5,265\n20,1.25,200\n20,,200\n"))
    comparison = compare(RESULTS, table)
    assert value(comparison, "drag_n", 2, "computed") == pytest.approx(265.0)
    assert "no case at 1.25 m/s" in value(comparison, "drag_n", 3, "note")
    assert value(comparison, "drag_n", 4, "note") == "no speed_m_s"
    assert comparison.summary["points"].item() == 1


def test_a_table_without_speed_is_matched_with_the_one_speed_computed(write):
    table = read_flume_table(write("filled_meshes,drag_n\n20,140\n"))
    assert compare(RESULTS[RESULTS["speed_m_s"] == 1.0], table).points["difference"].item() == pytest.approx(0.0)
    with pytest.raises(InputError) as caught:
        compare(RESULTS, table)
    assert caught.value.key == "speed_m_s"


def test_a_table_without_catch_is_matched_with_the_one_catch_computed(write):
    table = read_flume_table(write("speed_m_s,drag_n\n1.0,120\n1.5,245\n"))
    comparison = compare(RESULTS[RESULTS["filled_meshes"] == 10.0], table)
    np.testing.assert_allclose(comparison.points["computed"], [120.0, 245.0])
    assert comparison.matched_on is None
    with pytest.raises(InputError, match="several catches computed at 1 m/s"):
        compare(RESULTS, table)


def test_the_catch_column_that_needs_least_interpolation_is_matched_on_and_the_others_are_compared(write):
    table = read_flume_table(
        write("catch_mass_kg,filled_meshes,speed_m_s,drag_n\n101,10,1,120\n199,20,1,140\n305,30,1,160\n")
    )
    comparison = compare(RESULTS, table)
    assert comparison.matched_on == "filled_meshes"
    assert set(comparison.points["quantity"]) == {"drag_n", "catch_mass_kg"}
    assert value(comparison, "catch_mass_kg", 2, "difference") == pytest.approx(-1.0)


def test_a_table_with_nothing_to_compare_is_refused_with_the_reasons(write):
    table = read_flume_table(write("filled_meshes,speed_m_s,drag_n\n40,1,100\n20,2,100\n"))
    with pytest.raises(InputError, match=r"outside the computed 10 to 30; no case at 2 m/s \(computed: 1, 1.5\)"):
        compare(RESULTS, table)


def test_the_hoops_drag_is_a_term_of_its_own_added_to_the_computed_drag(write):
    header = "filled_meshes,speed_m_s,drag_n,hoop_drag_n,length_m"
    comparison = compare(RESULTS, read_flume_table(write(f"{header}\n10,1,150,25,5\n20,1,170,,4\n")))
    assert value(comparison, "drag_n", 2, "computed") == pytest.approx(120.0 + 25.0)
    assert value(comparison, "drag_n", 2, "hoop_drag_n") == 25.0
    assert value(comparison, "drag_n", 2, "difference") == pytest.approx(-5.0)
    assert value(comparison, "drag_n", 3, "note") == "no hoop_drag_n"
    assert np.isnan(value(comparison, "drag_n", 3, "computed"))
    assert value(comparison, "length_m", 3, "computed") == pytest.approx(4.0)
    labels = comparison_figure(comparison).axes[0].get_legend_handles_labels()[1]
    assert "computed codend + hoop at 1 m/s" in labels
    assert "hoop, of the table at 1 m/s" in labels


def test_drag_with_a_hoop_of_unknown_drag_is_not_compared(write):
    table = read_flume_table(write("filled_meshes,speed_m_s,drag_n,hoop_drag_n,length_m\n10,1,150,,5\n"))
    assert compare(RESULTS, table).summary["quantity"].tolist() == ["length_m"]


HOOP = Hoop(radius_m=0.30, rod_m=0.010, water_density_kg_m3=1000.0)


def test_the_hoops_drag_is_that_of_a_straight_rod_of_its_length():
    assert HOOP.drag_n(np.array([0.0, 1.0, 2.0])) == pytest.approx(
        0.5 * 1000.0 * 1.2 * 0.01 * 0.6 * np.pi * np.array([0, 1, 4])
    )


def test_a_computed_hoop_fills_an_empty_column_and_is_called_assumed_wherever_it_shows(write):
    table = read_flume_table(write("filled_meshes,speed_m_s,drag_n,hoop_drag_n\n10,1,150,\n10,1.5,290,\n"))
    comparison = compare(RESULTS, table, hoop=HOOP)
    for line, speed in ((2, 1.0), (3, 1.5)):
        hoop = value(comparison, "drag_n", line, "hoop_drag_n")
        assert hoop == pytest.approx(HOOP.drag_n(np.array(speed)))
        bare = float(RESULTS[(RESULTS["speed_m_s"] == speed) & (RESULTS["filled_meshes"] == 10.0)]["drag_n"].iloc[0])
        assert value(comparison, "drag_n", line, "computed") == pytest.approx(bare + hoop)
        assert value(comparison, "drag_n", line, "hoop_origin") == "computed, rod of 10 mm ASSUMED"
    labels = comparison_figure(comparison).axes[0].get_legend_handles_labels()[1]
    assert "hoop, computed, rod of 10 mm ASSUMED at 1 m/s" in labels


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("filled_meshes,speed_m_s,drag_n\n10,1,150\n", "hoop_drag_n is missing, so drag_n includes no hoop's"),
        ("filled_meshes,speed_m_s,drag_n,hoop_drag_n\n10,1,150,20\n20,1,170,\n", "hoop_drag_n has numbers of its own"),
    ],
)
def test_no_hoop_is_computed_for_drag_without_one_or_with_a_known_one(write, table, said):
    with pytest.raises(InputError, match=said):
        compare(RESULTS, read_flume_table(write(table)), hoop=HOOP)


def test_the_tables_own_word_on_its_source_goes_wherever_its_numbers_go(write):
    said = "COMPUTED, not measured: by hand"
    comparison = compare(RESULTS, read_flume_table(write(f"# {said}\nfilled_meshes,speed_m_s,drag_n\n10,1,1\n")))
    assert (comparison.points["source"] == said).all()
    assert (comparison.summary["source"] == said).all()
    assert said in comparison_figure(comparison).get_suptitle()


# --- the shipped table -----------------------------------------------------------------------------------------------


def test_the_shipped_table_says_that_it_is_computed_and_is_what_its_script_makes():
    shipped = read_flume_table(TABLE)
    assert shipped.origin.startswith("COMPUTED, not measured")
    made = np.loadtxt(table_text().splitlines(), delimiter=",", skiprows=len(shipped.comments) + 1)
    np.testing.assert_allclose(np.array(list(shipped.columns.values())).T, made, rtol=1e-5)


def test_the_sector_net_agrees_with_the_meridian_table():
    plan = codend.load_plan(TABLE.parents[1] / "cases" / "flume_150x140.toml", ["catch.filled_meshes=[10, 40, 100]"])
    points = compare(codend.solve(plan).table, read_flume_table(TABLE)).points
    at_cases = points[~points["interpolated"]]
    assert at_cases["table_line"].nunique() == 3
    largest = at_cases["relative_difference"].abs().groupby(at_cases["quantity"]).max()
    # 150 bars round against a smooth skin: of order 1 / 150^2, more where the catch is but ten meshes long
    assert largest["drag_n"] < 5e-4
    assert largest["length_m"] < 1e-4
    assert largest["max_diameter_m"] < 5e-4
    assert largest["front_from_codline_m"] < 1e-3
    assert largest["catch_volume_m3"] < 2e-3
