"""Flume tables, Cp curves and tables of a run as spreadsheets leave them: read, or refused by what they are."""

from pathlib import Path
from shutil import copytree

import pandas as pd
import pytest

from codend.io.files import write_table
from codend.plan.plan import load_plan
from codend.selectivity.escape.species import example_species_path
from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli


@pytest.fixture(scope="module")
def ran(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("run")
    (home / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    assert codend_cli("run", home / "plan.toml", "--out", home / "out").exit_code == 0
    return home / "out"


def european(text: str) -> str:
    """As a spreadsheet with decimal commas saves a table, with empty columns at the end."""
    return text.replace(",", ";").replace(".", ",").replace("\n", ";;\r\n") + ";;;;\r\n"


# --- flume tables

FLUME = "# INVENTED, for a test\nfilled_meshes,speed_m_s,drag_n\n5,1.0,55.25\n6,1.0,60.5\n"
CAPITALS = FLUME.replace("filled_meshes", "Filled meshes").replace("speed_m_s", "Speed (m/s)").replace("drag", "DRAG")


def compared(table: str | bytes, ran: Path, folder: Path, *words: object):
    copytree(ran, folder / "out")
    (folder / "flume.csv").write_bytes(table.encode() if isinstance(table, str) else table)
    return codend_cli("compare", folder / "out", folder / "flume.csv", *words)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (FLUME, ()),
        (european(FLUME), ()),
        (european(FLUME).replace(";", "\t"), ()),
        (european(FLUME).encode("utf-16"), ()),
        (CAPITALS, ()),
        (european(FLUME).replace("test", "Prüfung").encode("latin-1"), ("--encoding", "latin-1")),
        (
            FLUME.replace(",", ";").replace("55.25", "55.250").replace("60.5", "60.500").replace("1.0", "1"),
            ("--decimal", "."),
        ),
    ],
)
def test_a_flume_table_is_read_in_the_forms_people_have(table, words, ran, tmp_path):
    assert compared(table, ran, tmp_path, *words).exit_code == 0
    found = pd.read_csv(tmp_path / "out" / "comparison.csv").query("quantity == 'drag_n'")
    assert sorted(found["tabled"]) == [55.25, 60.5]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (european(FLUME).replace("test", "Prüfung").encode("latin-1"), ["Latin-1", "line 1", "ü", "--encoding"]),
        (
            european(FLUME).replace("55,25", "1,250").replace("60,5", "1,300").replace("1,0;", "1;"),
            ["1,250", "--decimal"],
        ),
        (FLUME.replace(",", " "), ["blanks between its columns"]),
        (
            european(FLUME).replace("55,25", "wide"),
            ['drag_n = "wide"', "semicolons between columns and commas in numbers"],
        ),
        (FLUME.replace("drag_n", "drag_kn"), ["drag_kn is no known column"]),
        (b"PK\x03\x04" + bytes(50), ["spreadsheet"]),
    ],
)
def test_a_flume_table_is_refused_by_what_it_is(table, words, ran, tmp_path):
    assert_refused(compared(table, ran, tmp_path), "flume.csv", *words)
    assert not (tmp_path / "out" / "comparison.csv").exists()


# --- Cp curves

CURVE = "# INVENTED, for a test\ntheta_deg,cp\n0,1.0\n40.5,-0.25\n90,-1.15\n180,0.4\n"


def drag_n(curve: str | bytes, folder: Path):
    (folder / "cp.csv").write_bytes(curve.encode() if isinstance(curve, str) else curve)
    (folder / "plan.toml").write_text(TINY_PLAN + 'sphere_cp_csv = "cp.csv"\n', encoding="utf-8")
    return codend_cli("run", folder / "plan.toml", "--out", folder / "out", "--set", "catch.filled_meshes=4")


def test_a_cp_curve_is_read_in_the_forms_people_have(tmp_path):
    found = []
    capitals = CURVE.replace("theta_deg,cp", "Theta (deg),Cp")
    for curve in (
        CURVE,
        european(CURVE),
        capitals,
        european(CURVE).encode("utf-16"),
        european(CURVE).replace(";", "\t"),
    ):
        assert drag_n(curve, tmp_path).exit_code == 0
        found.append(pd.read_csv(tmp_path / "out" / "results.csv")["drag_n"].item())
    assert len(set(found)) == 1


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        (CURVE.replace("INVENTED", "Kurve für").encode("latin-1"), ["Latin-1", "ü", "saved as UTF-8"]),
        (european(CURVE).replace("-0,25", "wide"), ['cp = "wide"', "semicolons between columns and commas in numbers"]),
        ("theta_deg;cp\n0;1,000\n180;1,125\n", ["1,000, whose comma", "no mark after thousands"]),
        (CURVE.replace("cp\n", "Cd\n"), ["cp is missing", "theta_deg, Cd"]),
        (CURVE.replace("180", "170"), ["theta_deg does not run over the whole sphere", "0 to 180"]),
        (CURVE.replace("40.5", "95"), ["theta_deg does not run over the whole sphere"]),
        ("theta_deg,cp\n", ["theta_deg does not run over the whole sphere"]),
        ("", ["it is empty"]),
        (CURVE + "#" * 21_000_000, ["too large", "20 MB"]),
    ],
)
def test_a_cp_curve_is_refused_by_what_it_is(curve, words, tmp_path):
    result = drag_n(curve, tmp_path)
    assert_refused(result, "cp.csv", *words)
    assert not (tmp_path / "out").exists()


# --- tables of a run, saved anew from a spreadsheet


def test_tables_of_a_run_are_read_as_a_spreadsheet_saves_them_anew(ran, tmp_path):
    saved = copytree(ran, tmp_path / "saved")
    for name in ("results.csv", "profile.csv"):
        (saved / name).write_text(european((saved / name).read_text(encoding="utf-8")), encoding="utf-16")
    found = []
    for folder in (ran, saved):
        words = ("selectivity", folder, "--species", example_species_path(), "--bootstrap", 0, "--samples", 0)
        assert codend_cli(*words).exit_code == 0
        found.append(pd.read_csv(folder / "selectivity.csv"))
    pd.testing.assert_frame_equal(*found)


HAULS = "haul,length_cm,codend,cover\n" + "".join(
    f"{haul},{length + 0.5},{kept},{20 - kept}\n"
    for haul in (1, 2, 3)
    for length, kept in ((4, haul), (5, 4 + haul), (6, 10), (7, 16 - haul), (8, 20 - haul))
)


def test_hauls_beside_a_prediction_are_read_as_codend_fit_reads_them(ran, tmp_path):
    found = []
    millimetres = HAULS.replace(".5,", "5,").replace("length_cm", "length_mm")
    for number, text in enumerate((HAULS, european(HAULS), millimetres)):
        folder = copytree(ran, tmp_path / f"out{number}")
        (tmp_path / "hauls.csv").write_text(text, encoding="utf-8")
        words = ["--species", example_species_path(), "--bootstrap", 0, "--samples", 0]
        result = codend_cli("selectivity", folder, *words, "--field", tmp_path / "hauls.csv", "--design", "covered")
        assert (result.exit_code, result.stderr) == (0, "")
        found.append(pd.read_csv(folder / "together.csv"))
    for other in found[1:]:
        pd.testing.assert_frame_equal(found[0], other)
    assert "length_mm is in mm" in result.stdout


# --- formulas


@pytest.mark.parametrize("name", ["=1+1", "+1", "-1", "@SUM(A1)", " =1+1", "\t=1+1"])
def test_no_table_holds_a_text_that_a_spreadsheet_takes_for_a_formula(name, tmp_path):
    table = pd.DataFrame({"name": [name, "a-b"], name: [-1.5, 2.0], "mixed": [-1, name]})
    write_table(table, tmp_path / "table.csv")
    cells = pd.read_csv(tmp_path / "table.csv", dtype=str)
    assert list(cells.columns) == ["name", f"'{name}", "mixed"]
    assert cells["name"].tolist() == [f"'{name}", "a-b"]
    assert cells["mixed"].tolist() == ["-1", f"'{name}"]
    assert cells[f"'{name}"].tolist() == ["-1.5", "2"]


def test_a_species_named_by_a_formula_reaches_no_spreadsheet_as_one(ran, tmp_path):
    text = example_species_path().read_text(encoding="utf-8").replace('name = "', 'name = "=cmd|', 1)
    (tmp_path / "species.toml").write_text(text, encoding="utf-8")
    folder = copytree(ran, tmp_path / "out")
    words = ("--species", tmp_path / "species.toml", "--bootstrap", 0, "--samples", 0)
    assert codend_cli("selectivity", folder, *words).exit_code == 0
    for name in ("selectivity.csv", "retention.csv"):
        assert pd.read_csv(folder / name)["species"].str.startswith("'=cmd|").all()
    assert load_plan(folder / "plan.toml").title == "A small bag"


def test_a_section_named_by_a_formula_is_found_again_in_the_tables(tmp_path):
    (tmp_path / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    folder, change = tmp_path / "out", 'netting.0.name="=1+1"'
    assert codend_cli("run", tmp_path / "plan.toml", "--set", change, "--out", folder).exit_code == 0
    assert set(pd.read_csv(folder / "profile.csv")["section"].dropna()) == {"'=1+1"}
    words = ("--species", example_species_path(), "--bootstrap", 0, "--samples", 0)
    assert codend_cli("selectivity", folder, *words).exit_code == 0
