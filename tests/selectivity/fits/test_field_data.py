"""Reading of counted fish: what is accepted, and what is refused with which column."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from codend.errors import InputError
from codend.selectivity.fits.analysis import fit_field_data
from codend.selectivity.fits.fielddata import read_field_data

GOOD = pd.DataFrame({"haul": ["A", "A", "B"], "length_cm": [20, 21, 20], "codend": [3, 4, 0], "cover": [5, 0, 2]})


def test_comment_lines_order_of_columns_and_missing_raising_are_accepted(tmp_path: Path) -> None:
    table = tmp_path / "trial.csv"
    table.write_text("# vessel, date\ncover,codend,length_cm,haul,codend_raising\n5,3,20,7,2.5\n# pause\n0,4,21,7,1\n")
    data = read_field_data(table, "covered")
    assert data.haul_names == ("7",)
    assert data.test_count == pytest.approx([3, 4])
    assert data.other_count == pytest.approx([5, 0])
    assert data.other_raising == pytest.approx([1, 1])
    # the counted share of the codend is 1/2.5, that of the cover 1
    assert data.log_offset == pytest.approx([-np.log(2.5), 0.0])


def test_hauls_keep_their_order_of_appearance_and_their_covariates() -> None:
    data = read_field_data(GOOD.iloc[::-1].assign(catch_kg=[300.0, 100.0, 100.0]), "covered", ["catch_kg"])
    assert data.haul_names == ("B", "A")
    assert data.covariates == pytest.approx(np.array([[300.0], [100.0]]))


@pytest.mark.parametrize(
    ("change", "design", "covariates", "key"),
    [
        ({"cover": [1, 2, -3]}, "covered", [], "cover"),
        ({"cover": [1, 2.5, 3]}, "covered", [], "cover"),
        ({"codend": [1, None, 3]}, "covered", [], "codend"),
        ({"codend": ["1", "many", "3"]}, "covered", [], "codend"),
        ({"codend": [1, np.inf, 3]}, "covered", [], "codend"),
        ({"codend": [0, 0, 0], "cover": [0, 0, 0]}, "covered", [], "codend"),
        ({"length_cm": [20, 20, 20]}, "covered", [], "length_cm"),
        ({"length_cm": [20, 0, 20]}, "covered", [], "length_cm"),
        ({"cover_raising": [1, 0.5, 1]}, "covered", [], "cover_raising"),
        ({"haul": ["A", None, "B"]}, "covered", [], "haul"),
        ({}, "paired", [], "test"),
        ({}, "trouser", [], "design"),
        ({}, "covered", ["catch_kg"], "catch_kg"),
        ({"catch_kg": [1, 2, 3]}, "covered", ["catch_kg"], "catch_kg"),
        ({"catch_kg": [2, 2, 2]}, "covered", ["catch_kg"], "catch_kg"),
    ],
)
def test_a_bad_table_is_refused_with_the_name_of_the_column(
    change: dict, design: str, covariates: list[str], key: str
) -> None:
    with pytest.raises(InputError) as error:
        read_field_data(GOOD.assign(**change), design, covariates)
    assert error.value.key == key
    assert "allowed" in str(error.value)


def test_files_that_are_missing_empty_or_no_table_are_refused(tmp_path: Path) -> None:
    empty, header_only = tmp_path / "empty.csv", tmp_path / "header.csv"
    empty.write_text("")
    header_only.write_text("haul,length_cm,codend,cover\n")
    for path in (tmp_path / "absent.csv", empty, header_only, tmp_path):
        with pytest.raises(InputError, match=path.name):
            read_field_data(path, "covered")


@pytest.mark.parametrize(
    ("header", "rows", "words"),
    [
        ("haul,length_cm,codend,codend,cover", "1,20,3,4,5", "codend in line 2 is given twice"),
        ("haul,length_cm,codend,cover", "1,20,3,4,5\n1,21,3,4,5", "line 3 has 5 cells; allowed: 4 cells"),
        ("haul,length_cm,codend,cover", "1,20,3,4\n\n1,21,3,4,5,6", "line 5 has 6 cells; allowed: 4 cells"),
        ("haul,length_cm,codend,cover", "1,20,3,4\n1,21,3", "line 4 has 3 cells; allowed: 4 cells"),
        ("haul,length_cm,codend,cover", "1,20,3,4\n1,21,,4", 'codend = "(empty)" in line 4'),
        ("haul,length_cm,codend,cover", "1,20,3,4\n,21,3,4", 'haul = "(empty)" in line 4'),
        ("haul,length_cm,codend,cover", '1,"20,3,4\n1,21,3,4', "line 3 has 2 cells"),
        ("haul,length_cm,codend,cover", f"1,20,3,{'4' * 200_000}", "line 3 cannot be read"),
    ],
)
def test_columns_that_are_doubled_shifted_or_cut_are_refused_with_the_line(
    header: str, rows: str, words: str, tmp_path: Path
) -> None:
    path = tmp_path / "trial.csv"
    path.write_text(f"# a trial\n{header}\n{rows}\n", encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(words)) as error:
        read_field_data(path, "covered")
    assert str(error.value).startswith(f"{path}: ")


def test_names_of_hauls_are_taken_as_they_stand(tmp_path: Path) -> None:
    path = tmp_path / "trial.csv"
    path.write_text('haul,length_cm,codend,cover\n"Sole, 1#2" ,20,3,4\nNA,20,3,4\n007,20,3,4\n', encoding="utf-8")
    assert read_field_data(path, "covered").haul_names == ("Sole, 1#2", "NA", "007")


@pytest.mark.parametrize(
    ("choice", "key"),
    [
        ({"curve": "spline"}, "curve"),
        ({"split": "free"}, "split"),
        ({"split": "estimated"}, "split"),
        ({"overdispersion": "yes"}, "overdispersion"),
        ({"n_bootstrap": -1}, "n_bootstrap"),
    ],
)
def test_choices_that_do_not_exist_are_refused(choice: dict, key: str) -> None:
    with pytest.raises(InputError) as error:
        fit_field_data(GOOD, "covered", **choice)
    assert error.value.key == key
