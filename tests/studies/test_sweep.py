"""Sweeps: every combination, the numbers of a run by itself, nothing solved twice, mistakes found before the work."""

import re
import signal

import pandas as pd
import pytest

import codend.studies.run_record
import codend.studies.sweep
import codend.studies.workers
from codend.errors import InputError
from codend.plan.copy import plan_toml
from codend.plan.plan import load_plan
from codend.report.page import PLOTS
from codend.studies.run_record import PLOT_NAMES
from codend.studies.study import solve
from codend.studies.sweep import runs_of, solve_runs, why_again
from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli

VARY = ["netting.0.bar_mm=[40.0, 50.0]", "catch.filled_meshes=[[4], [4, 8]]"]


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(TINY_PLAN, encoding="utf-8")
    return path


def test_every_combination_is_run_and_has_the_numbers_of_a_run_by_itself(plan, tmp_path):
    table = solve_runs(runs_of(plan, VARY), tmp_path / "sweep")
    assert table["run"].tolist() == [1, 2, 2, 3, 4, 4]
    assert table["netting.0.bar_mm"].tolist() == [40.0, 40.0, 40.0, 50.0, 50.0, 50.0]
    assert table["catch.filled_meshes"].tolist() == ["[4]", "[4, 8]", "[4, 8]", "[4]", "[4, 8]", "[4, 8]"]
    alone = solve(load_plan(plan, ["netting.0.bar_mm=50.0"])).table
    last = table[table["run"] == 4]
    for quantity in ("drag_n", "catch_volume_m3", "opening_ahead_deg"):
        assert last[quantity].to_numpy() == pytest.approx(alone[quantity].to_numpy(), rel=1e-6)


def test_two_processes_find_what_one_does(plan, tmp_path, monkeypatch):
    monkeypatch.setattr(codend.studies.workers, "WAITED_FOR_S", 600)
    runs = runs_of(plan, VARY[:1])
    one, two = (solve_runs(runs, tmp_path / str(count), count) for count in (1, 2))
    pd.testing.assert_frame_equal(one.drop(columns="solve_ms"), two.drop(columns="solve_ms"))


def test_a_sweep_goes_on_where_it_stopped(plan, tmp_path, monkeypatch):
    runs = runs_of(plan, VARY[:1])
    solved = []

    def watched(plan):
        if len(solved) == 1:
            raise KeyboardInterrupt
        solved.append(plan)
        return solve(plan)

    monkeypatch.setattr(codend.studies.sweep, "solve", watched)
    with pytest.raises(KeyboardInterrupt):
        solve_runs(runs, tmp_path)
    monkeypatch.setattr(codend.studies.sweep, "solve", solve)
    first = tmp_path / "runs" / "001" / "results.csv"
    before = first.stat().st_mtime_ns
    table = solve_runs(runs, tmp_path)
    assert table["run"].tolist() == [1, 1, 2, 2]
    assert first.stat().st_mtime_ns == before
    # a run of another plan is done again
    solve_runs(runs_of(plan, VARY[:1], ["tow.speed_m_s=2.0"]), tmp_path)
    assert first.stat().st_mtime_ns != before


def test_a_shorter_sweep_removes_the_runs_of_a_longer_one_and_nothing_else(plan, tmp_path):
    long, short = (runs_of(plan, [f"netting.0.bar_mm={values}"]) for values in ("[40.0,50.0,60.0,70.0]", "[45.0]"))
    solve_runs(long, tmp_path)
    runs = tmp_path / "runs"
    stays = [runs / "003" / "notes.txt", runs / "mine" / "results.csv", runs / "010" / "results.csv"]
    stays += [
        runs / "011" / name for name in ("plan.toml", "results.csv", "profile.csv", "report.html")
    ]  # codend run's
    goes = [runs / "001" / "comparison.png", runs / "002" / "plots" / "selectivity_meshes.png"]
    for path in (*stays, *goes):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("not of this sweep", encoding="utf-8")
    solve_runs(short, tmp_path)
    own = {runs / "001" / name for name in ("plan.toml", "results.csv", "profile.csv", "run.json")}
    assert {path for path in runs.rglob("*") if path.is_file()} == {*stays, *own}
    assert {path.name for path in runs.iterdir()} == {"001", "003", "010", "011", "mine"}


def test_an_interrupted_shorter_sweep_removes_nothing_yet(plan, tmp_path, monkeypatch):
    solve_runs(runs_of(plan, VARY[:1]), tmp_path)
    monkeypatch.setattr(codend.studies.sweep, "solve", lambda _: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        solve_runs(runs_of(plan, ["netting.0.bar_mm=[45.0]"]), tmp_path)
    assert (tmp_path / "runs" / "002" / "results.csv").is_file()


def cut(path):
    path.write_bytes(path.read_bytes()[:-20])


def lose_a_case(path):
    path.write_text("".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:-1]), encoding="utf-8")


@pytest.mark.parametrize(
    ("file", "damage", "word"),
    [
        ("results.csv", cut, "results.csv is not as it was written"),
        ("results.csv", lose_a_case, "results.csv is not as it was written"),
        ("profile.csv", lambda path: path.unlink(), "profile.csv is missing"),
        ("plan.toml", lambda path: path.unlink(), "plan.toml is missing"),
        ("run.json", lambda path: path.unlink(), "it did not end"),
        ("run.json", cut, "run.json cannot be read"),
        ("run.json", lambda path: path.write_text("[]"), "run.json cannot be read"),
        ("cp.csv", lambda path: path.write_text("theta_deg,cp\n0,1\n90,-1\n180,0.2\n"), "cp.csv has changed"),
    ],
)
def test_a_run_that_is_not_whole_and_of_these_inputs_is_solved_again_with_a_word(file, damage, word, plan, tmp_path):
    (tmp_path / "cp.csv").write_text("theta_deg,cp\n0,1\n90,-0.5\n180,0.4\n", encoding="utf-8")
    runs = runs_of(plan, VARY[:1], ['catch.sphere_cp_csv="cp.csv"'])
    before = solve_runs(runs, tmp_path)
    assert why_again(runs, tmp_path) == {}
    second = tmp_path / "runs" / "002"
    damage(tmp_path / file if file == "cp.csv" else second / file)
    assert why_again(runs, tmp_path) == {word: [1, 2] if file == "cp.csv" else [2]}
    after = solve_runs(runs, tmp_path)
    assert why_again(runs, tmp_path) == {}
    same = after.drop(columns="solve_ms").equals(before.drop(columns="solve_ms"))
    assert same == (file != "cp.csv")


def test_a_run_of_another_program_is_solved_again(plan, tmp_path, monkeypatch):
    runs = runs_of(plan, VARY[:1])
    solve_runs(runs, tmp_path)
    monkeypatch.setattr(codend.studies.run_record, "program", lambda: "codend 0.0.9, 123456789abc")
    assert why_again(runs, tmp_path) == {"the program has changed": [1, 2]}


def test_the_plan_beside_a_run_is_the_one_that_was_solved(plan, tmp_path):
    runs = runs_of(plan, VARY[:1])
    solve_runs(runs, tmp_path)
    for run in runs:
        copy = tmp_path / "runs" / f"{run.number:03d}" / "plan.toml"
        assert copy.read_text(encoding="utf-8") == plan_toml(run.plan)


@pytest.mark.parametrize(
    ("vary", "named"),
    [
        ("netting.0.bar_mm=25", "netting.0.bar_mm"),
        ("netting.0.bar_mm=[]", "netting.0.bar_mm"),
        ("netting.0.bar_mm=[25, -1]", "netting.0.bar_mm"),
        ("netting.0.bar=[25]", "netting.0.bar"),
        ("bar_mm", "bar_mm"),
        ("netting.0.bar_mm=[18, 25, 18.0]", "options: --vary netting.0.bar_mm = [18, 25, 18.0] has a value twice"),
        ("catch.filled_meshes=[[4], [4]]", "options: --vary catch.filled_meshes = [[4], [4]] has a value twice"),
    ],
)
def test_what_cannot_vary_is_refused_before_anything_is_solved(vary, named, plan, tmp_path):
    with pytest.raises(InputError, match=re.escape(named)):
        runs_of(plan, [vary])
    assert_refused(codend_cli("sweep", plan, "--vary", vary, "--out", tmp_path / "sweep"), named)
    assert not (tmp_path / "sweep").exists()


def test_a_key_that_varies_is_not_set_as_well(plan, tmp_path):
    words = ["--vary", "netting.0.bar_mm=[25,30]", "--set", "netting.0.bar_mm=20", "--out", tmp_path / "sweep"]
    assert_refused(codend_cli("sweep", plan, *words), "--vary netting.0.bar_mm = [25, 30] is set to one value as well")


def test_a_key_varies_once(plan):
    with pytest.raises(InputError, match="twice"):
        runs_of(plan, ["entry.radius_m=[0.1]", "entry.radius_m=[0.2]"])


def test_the_command_writes_table_and_picture_and_feeds_selectivity(plan, tmp_path):
    folder = tmp_path / "sweep"
    result = codend_cli("sweep", plan, "--vary", VARY[0], "entry.radius_m=[0.1,0.12]", "--out", folder)
    assert result.exit_code == 0, result.stderr
    assert "4 runs, 8 cases" in result.stdout
    assert len(pd.read_csv(folder / "sweep.csv")) == 8
    assert (folder / "sweep.png").stat().st_size > 10_000
    species = tmp_path / "fish.toml"
    species.write_text(codend_cli("species").stdout, encoding="utf-8")
    chosen = codend_cli("selectivity", folder / "runs" / "002", "--species", species)
    assert chosen.exit_code == 0, chosen.stderr


def test_a_case_that_is_not_solved_gives_status_3(plan, tmp_path):
    # more than the bag holds, though not more than a cylinder of the netting stretched both ways would
    too_much = ["catch.volume_m3=[[0.05], [0.2]]"]
    result = codend_cli("sweep", plan, "--vary", *too_much, "--out", tmp_path / "sweep")
    assert result.exit_code == 3, result.output
    assert "was not solved" in result.stderr
    table = pd.read_csv(tmp_path / "sweep" / "sweep.csv")
    assert table["converged"].tolist() == [True, False]
    assert table["drag_n"].isna().tolist() == [False, True]


def test_the_command_says_which_runs_are_solved_again_and_why(plan, tmp_path):
    words = ["sweep", plan, "--vary", VARY[0], "--out", tmp_path / "sweep"]
    assert codend_cli(*words).stderr == ""
    assert codend_cli(*words).stderr == ""
    cut(tmp_path / "sweep" / "runs" / "002" / "results.csv")
    assert codend_cli(*words).stderr == "run 2 is solved again: results.csv is not as it was written\n"
    told = codend_cli(*words, "--set", "tow.speed_m_s=2").stderr
    assert told == "runs 1, 2 are solved again: plan.toml has changed\n"


def test_a_sweep_takes_the_place_of_a_whole_run_in_one_of_its_folders(plan, tmp_path):
    own = tmp_path / "sweep" / "runs" / "001"
    assert codend_cli("run", plan, "--out", own).exit_code == 0
    solve_runs(runs_of(plan, ["netting.0.bar_mm=[41.0]"]), tmp_path / "sweep")
    assert {path.name for path in own.iterdir()} == {"plan.toml", "results.csv", "profile.csv", "run.json"}


def test_all_plots_of_a_run_are_among_those_that_go_with_it():
    assert {plot.name for plot in PLOTS} == set(PLOT_NAMES)
