"""Tables as workbooks and with decimal commas hold what the CSV holds, and no formula."""

import math

import numpy as np
import pandas as pd
import pytest
from openpyxl import load_workbook

from codend.errors import InputError
from codend.io import spreadsheet
from codend.io.files import write_table
from codend.io.spreadsheet import semicolon_text, write_spreadsheets
from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli

TABLE = pd.DataFrame({"name": ["=1+1", "Kabeljau, groß"], "drag_n": [1234.5678, np.nan], "converged": [True, False]})


@pytest.fixture
def folder(tmp_path):
    write_table(TABLE, tmp_path / "results.csv")
    write_table(TABLE[["name"]], tmp_path / "other.csv")
    return tmp_path


def test_a_workbook_has_a_sheet_a_table_numbers_as_numbers_and_no_formula(folder):
    (path,) = write_spreadsheets(folder, xlsx=True, semicolons=False)
    book = load_workbook(path)
    assert book.sheetnames == ["other", "results"]
    cells = list(book["results"].iter_rows(values_only=True))
    assert cells == [("name", "drag_n", "converged"), ("=1+1", 1234.5678, True), ("Kabeljau, groß", None, False)]
    assert book["results"]["A2"].data_type == "s"


def test_semicolons_and_decimal_commas_are_read_back_the_same(folder):
    (path,) = write_spreadsheets(folder, xlsx=False, semicolons=True)
    written = (path / "results.csv").read_bytes()
    assert written.startswith(b"\xef\xbb\xbfname;drag_n;converged\n'=1+1;1234,5678;True\n")
    again = pd.read_csv(path / "results.csv", sep=";", decimal=",", encoding="utf-8-sig")
    assert again["drag_n"][0] == 1234.5678
    assert math.isnan(again["drag_n"][1])


def test_small_numbers_keep_their_digits_with_commas():
    assert semicolon_text(pd.DataFrame({"residual": [1.25e-9]})) == "residual\n1,25e-09\n"


def test_a_run_writes_both_for_those_who_ask_and_a_later_run_removes_them(tmp_path):
    (tmp_path / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    out = tmp_path / "out"
    result = codend_cli("run", tmp_path / "plan.toml", "--out", out, "--xlsx", "--semicolons")
    assert result.exit_code == 0, result.output
    drag = pd.read_csv(out / "results.csv")["drag_n"]
    assert pd.read_excel(out / "tables.xlsx", "results")["drag_n"].tolist() == drag.tolist()
    assert pd.read_csv(out / "semicolons" / "profile.csv", sep=";", decimal=",", encoding="utf-8-sig").shape[1] > 5
    assert codend_cli("run", tmp_path / "plan.toml", "--out", out).exit_code == 0
    assert not (out / "tables.xlsx").exists()
    assert not list((out / "semicolons").glob("*.csv"))


def test_tables_of_any_folder_are_written_again(folder):
    assert codend_cli("tables", folder, "--xlsx").exit_code == 0
    assert (folder / "tables.xlsx").exists()
    assert_refused(codend_cli("tables", folder), "--xlsx or --semicolons")
    assert_refused(codend_cli("tables", folder / "none", "--xlsx"), "does not exist")


def test_a_table_too_long_for_a_sheet_is_refused(folder, monkeypatch):
    monkeypatch.setattr(spreadsheet, "MOST_ROWS", 2)
    with pytest.raises(InputError, match=r"cannot hold other.csv; allowed: tables of fewer than 2 rows"):
        write_spreadsheets(folder, xlsx=True, semicolons=False)
    assert not (folder / "tables.xlsx").exists()


def test_without_openpyxl_the_extra_is_named(folder, monkeypatch):
    monkeypatch.setattr(spreadsheet, "find_spec", lambda name: None)
    assert_refused(codend_cli("tables", folder, "--xlsx"), "pip install 'codend[xlsx]'")
