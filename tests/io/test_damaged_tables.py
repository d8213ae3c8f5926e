"""Tables of a run that were cut short or edited: refused with what is wrong where, never computed with."""

from collections.abc import Callable
from pathlib import Path
from shutil import copytree

import numpy as np
import pandas as pd
import pytest

import codend
from codend.io.columns import RESULT_COLUMNS
from codend.io.files import write_table
from codend.io.run_tables import read_run_table
from codend.plan.copy import plan_toml
from codend.plan.plan import Plan
from codend.selectivity.escape.catches import catches_of, read_run
from codend.selectivity.escape.species import example_species_path
from tests.cli.test_cli import assert_refused, codend_cli
from tests.plans import joined_plan, make_plan

Change = Callable[[list[str]], list[str]]
WHOLE_NET = {"fidelity": "globalised", "globalisation": 2}


def cell(line: int, column: str, value: str) -> Change:
    """Another value in a line, counted from 1."""

    def changed(lines: list[str]) -> list[str]:
        cells = lines[line - 1].split(",")
        cells[lines[0].split(",").index(column)] = value
        return [*lines[: line - 1], ",".join(cells), *lines[line:]]

    return changed


def without(line: int) -> Change:
    return lambda lines: lines[: line - 1] + lines[line:]


def written(model: dict, folder: Path) -> Path:
    """What ``codend run`` leaves that other commands read; two cases in 21 rows, or 11 where meshes are merged."""
    return left_by_run(make_plan(12, 10, filled=[3.0, 5.0], model=model), folder)


def left_by_run(plan: Plan, folder: Path) -> Path:
    study = codend.solve(plan)
    assert study.converged
    for name, table in (("results", study.table), ("profile", study.profile), ("meshes", study.meshes)):
        if not table.empty:
            write_table(table, folder / f"{name}.csv")
    (folder / "plan.toml").write_text(plan_toml(study.plan), encoding="utf-8")
    return folder


SQUARES_BETWEEN = tuple((mesh, 24, 8, 40.0, {}) for mesh in ("diamond", "square", "diamond"))
HALVED = ("diamond", 24, 8, 40.0, {}), ("diamond", 12, 8, 40.0, {})
COPRIME = ("diamond", 24, 8, 40.0, {}), ("diamond", 13, 8, 40.0, {})


@pytest.mark.parametrize(
    ("sections", "model"),
    [
        (SQUARES_BETWEEN, {}),
        (SQUARES_BETWEEN, {"fidelity": "full"}),
        (HALVED, {}),
        (HALVED, {"fidelity": "full"}),
        (HALVED, {"fidelity": "globalised", "globalisation": 2}),
        (COPRIME, {}),
    ],
)
def test_runs_of_joined_sections_are_read_back_whole(sections, model, tmp_path):
    """Joints count no mesh where square mesh ends, and elsewhere those of the fewer meshes round."""
    plan = joined_plan(*sections, catch={"filled_meshes": [3.0, 5.0]}, model=model)
    for catch in catches_of(read_run(left_by_run(plan, tmp_path)), 4.0):
        assert np.bincount((catch.rows_ahead + 1e-9).astype(int), weights=catch.share)[1:4] == pytest.approx(1.0)


@pytest.fixture(scope="module")
def sector(tmp_path_factory):
    return written({}, tmp_path_factory.mktemp("sector"))


@pytest.fixture(scope="module")
def whole_net(tmp_path_factory):
    return written(WHOLE_NET, tmp_path_factory.mktemp("whole_net"))


def damaged(folder: Path, to: Path, name: str, change: Change) -> Path:
    copytree(folder, to)
    lines = (to / name).read_text(encoding="utf-8").splitlines()
    (to / name).write_text("\n".join(change(lines)) + "\n", encoding="utf-8")
    return to


def selectivity(folder: Path):
    return codend_cli("selectivity", folder, "--species", example_species_path(), "--bootstrap", 0, "--samples", 0)


def compare(folder: Path):
    (folder / "flume.csv").write_text("# INVENTED\nfilled_meshes,drag_n\n4,100\n", encoding="utf-8")
    return codend_cli("compare", folder, folder / "flume.csv")


@pytest.mark.parametrize("command", [selectivity, compare])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (cell(3, "converged", "maybe"), ['converged = "maybe" in line 3', "allowed: True, False"]),
        (cell(3, "converged", ""), ['converged = "(empty)" in line 3']),
        (cell(3, "fidelity", "good"), ['fidelity = "good" in line 3', "allowed: meridian, smeared, sector"]),
        (cell(3, "filled_meshes", ""), ['filled_meshes = "(empty)" in line 3', "allowed: a number"]),
        (cell(3, "drag_n", "1_0"), ['drag_n = "1_0" in line 3', "allowed: a number"]),
        (cell(1, "speed_m_s", "speed"), ["speed_m_s is missing"]),
        (cell(1, "drag_n", "length_m"), ["length_m in line 1 is given twice"]),
        (
            lambda lines: [*lines[:2], ",".join(lines[2].split(",")[:5])],
            ["line 3 has 5 cells", f"allowed: {len(RESULT_COLUMNS)} cells"],
        ),
        (
            lambda lines: [*lines[:2], f"3,{lines[2]}1"],  # the last cell may be empty
            [f"line 3 has {len(RESULT_COLUMNS) + 1} cells", f"allowed: {len(RESULT_COLUMNS)} cells"],
        ),
        (lambda lines: lines[:1], ["converged is nowhere true"]),
        (lambda lines: [], ["it is empty"]),
    ],
)
def test_damaged_results_are_refused_by_every_command_that_reads_them(command, change, words, sector, tmp_path):
    folder = damaged(sector, tmp_path / "out", "results.csv", change)
    assert_refused(command(folder), "results.csv: ", *words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda lines: lines[:22], ["case = 2 has 0 rows", "allowed: rows 0 to 20"]),
        (lambda lines: lines[:33], ["case = 2 has 11 rows", "allowed: rows 0 to 20"]),
        (without(5), ["case = 1 has 20 rows"]),
        (cell(5, "row", "-1"), ["case = 1 has 21 rows, not those of the plan"]),
        (cell(5, "radius_m", "wide"), ['radius_m = "wide" in line 5', "allowed: a number"]),
        (cell(5, "radius_m", ""), ['radius_m = "(empty)" in line 5']),
        (cell(5, "opening_deg", ""), ['opening_deg = "(empty)" in line 5']),
        (cell(1, "opening_deg", "opening"), ["opening_deg is missing"]),
        (cell(5, "section", "2"), ['section = "2" in line 5', "allowed: a section of the plan that lies there"]),
        (cell(5, "section", ""), ['section = "(empty)" in line 5']),
        (cell(5, "meshes_from_entry", "2.5"), ['meshes_from_entry = "2.5" in line 5', "the place of the plan's row"]),
        (cell(1, "section", "part"), ["section is missing", "run the plan again"]),
        (cell(1, "meshes_from_entry", "place"), ["meshes_from_entry is missing", "run the plan again"]),
    ],
)
def test_a_damaged_profile_is_refused(change, words, sector, tmp_path):
    folder = damaged(sector, tmp_path / "out", "profile.csv", change)
    assert_refused(selectivity(folder), "profile.csv: ", *words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda lines: lines[:55], ["case = 2 has 0 meshes", "allowed: the 54 of the plan in rows 1 to 9"]),
        (lambda lines: lines[:1], ["case = 1 has 0 meshes"]),
        (lambda lines: lines[:-1], ["case = 2 has 53 meshes"]),
        (without(9), ["case = 1 has 53 meshes"]),
        (cell(9, "row", "2.5"), ["case = 1 has 54 meshes, not those of the plan"]),
        (cell(9, "bar_tension_n", "strong"), ['bar_tension_n = "strong" in line 9']),
        (cell(9, "opening_deg", ""), ['opening_deg = "(empty)" in line 9']),
        (cell(9, "section", "2"), ['section = "2" in line 9', "allowed: that of its row in profile.csv"]),
        (cell(1, "section", "part"), ["section is missing", "run the plan again"]),
    ],
)
def test_damaged_meshes_are_refused(change, words, whole_net, tmp_path):
    folder = damaged(whole_net, tmp_path / "out", "meshes.csv", change)
    assert_refused(selectivity(folder), "meshes.csv: ", *words)


def test_a_net_without_symmetry_needs_its_meshes(whole_net, tmp_path):
    folder = copytree(whole_net, tmp_path / "out")
    (folder / "meshes.csv").unlink()
    assert_refused(selectivity(folder), "meshes.csv: case = 1 has 0 meshes")


def test_a_case_stands_in_the_results_once(sector, tmp_path):
    folder = damaged(sector, tmp_path / "out", "results.csv", cell(3, "case", "1"))
    assert_refused(selectivity(folder), 'results.csv: case = "1" in line 3', "allowed: each case once")


def test_a_case_that_did_not_converge_is_left_out_whatever_the_others_say(sector, tmp_path):
    folder = damaged(sector, tmp_path / "out", "results.csv", cell(3, "converged", "FALSE"))
    assert [catch.case for catch in catches_of(read_run(folder), 5.0)] == [1]
    assert compare(folder).exit_code == 2  # 4 filled meshes lie beyond the one case that is left


@pytest.mark.parametrize("model", [{}, WHOLE_NET, {"fidelity": "meridian"}])
def test_tables_are_read_back_as_they_were_written(model, tmp_path):
    study = codend.solve(make_plan(12, 10, filled=[3.0, 5.0], model=model))
    for table in (study.table, study.profile, study.meshes):
        if table.empty:
            continue
        write_table(table, tmp_path / "table.csv")
        again = read_run_table(tmp_path / "table.csv").reset_index(drop=True)
        finite = table.replace([np.inf, -np.inf], np.nan)
        pd.testing.assert_frame_equal(again, finite, rtol=1e-11, check_dtype=False)
        assert again["case"].dtype == np.int64


def test_a_column_of_words_that_a_user_added_is_nobodys_business(sector, tmp_path):
    folder = copytree(sector, tmp_path / "noted")
    lines = (folder / "results.csv").read_text().splitlines()
    (folder / "results.csv").write_text("\n".join([f"{lines[0]},remark", *(f"{line},fine" for line in lines[1:])]))
    assert len(catches_of(read_run(folder), 4.0)) == 2
