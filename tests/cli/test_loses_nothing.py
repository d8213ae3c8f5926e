"""Runs that are killed, crash or meet each other: what was solved is kept, and a page is of the tables beside it.

``CODEND_KILLS`` sets how many kills at random moments there are, ``CODEND_MEETINGS`` how many pairs of runs.
"""

import json
import os
import random
import shutil
import signal
from pathlib import Path
from time import monotonic, sleep

import pandas as pd
import pytest

import codend.studies.study
from tests.cli.processes import WITH_WORKERS, assert_page_is_of_its_tables, numbers, run, start
from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli

KILLS = int(os.environ.get("CODEND_KILLS", "4"))
STUDY_KILLS = int(os.environ.get("CODEND_KILLS", "1"))
MEETINGS = int(os.environ.get("CODEND_MEETINGS", "3"))
TITLES = ("first", "second")


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two plans, and the runs of each that nothing disturbed."""
    folder = tmp_path_factory.mktemp("lost")
    for title, sizes in zip(TITLES, ("[4, 8]", "[3, 5, 6]"), strict=True):
        text = TINY_PLAN.replace("A small bag", title).replace("[4, 8]", sizes)
        (folder / f"{title}.toml").write_text(text, encoding="utf-8")
        done = run("run", folder / f"{title}.toml", "--out", folder / title)
        assert done.returncode == 0, done.stderr
    return folder


def assert_belongs_together(folder: Path, home: Path) -> None:
    """A page is of its tables, and these are of the plan beside them: all its cases, or as many as were solved."""
    assert_page_is_of_its_tables(folder)
    copy = folder / "plan.toml"
    if not copy.exists():
        assert not (folder / "report.html").exists()
        assert not (folder / "results.csv").exists()
        return
    (title,) = (title for title in TITLES if f'title = "{title}"' in copy.read_text(encoding="utf-8"))
    for name in ("results.csv", "profile.csv"):
        if (folder / name).exists():
            whole = numbers(home / title / name)
            found = numbers(folder / name)
            expected = whole[whole["case"].isin(found["case"])].reset_index(drop=True)
            pd.testing.assert_frame_equal(found, expected, rtol=1e-9)
            if (folder / "report.html").exists():
                assert len(found) == len(whole)
    if (folder / "report.html").exists():
        assert f"<h1>{title}</h1>" in (folder / "report.html").read_text(encoding="utf-8")


def kill_at_some_moment(process, seconds: float) -> None:
    """Kill a process; its output ends only when all that were started by it have ended too."""
    sleep(seconds)
    process.kill()
    process.communicate()


def test_runs_killed_at_random_moments_leave_no_page_of_other_tables(home: Path, tmp_path: Path):
    out, dice = tmp_path / "out", random.Random(11)
    begun = monotonic()
    assert run("run", home / "first.toml", "--out", out).returncode == 0
    takes_s = monotonic() - begun
    for kill in range(KILLS):
        title = TITLES[(kill + 1) % 2]
        kill_at_some_moment(start("run", home / f"{title}.toml", "--out", out), dice.uniform(0.3, 1.0) * takes_s)
        assert_belongs_together(out, home)
    for title in TITLES:
        assert run("run", home / f"{title}.toml", "--out", out).returncode == 0
        assert_belongs_together(out, home)
        names = [{str(path.relative_to(folder)) for path in folder.rglob("*")} for folder in (out, home / title)]
        assert names[0] == names[1], "what the killed runs left is gone"


@pytest.mark.parametrize("processes", [1, 2])
def test_sweeps_killed_at_random_moments_end_as_an_undisturbed_one(processes: int, home: Path, tmp_path: Path):
    out, whole, dice = tmp_path / "out", tmp_path / "whole", random.Random(12)
    vary = ["--vary", "netting.0.bar_mm=[38,40,42,44,46]", "--processes", processes]
    words = ["sweep", home / "first.toml", *vary, "--out"]
    begun = monotonic()
    assert run(*words, whole, command=WITH_WORKERS).returncode == 0
    takes_s = monotonic() - begun
    for kill in range(KILLS):
        if kill % 3 == 0:
            shutil.rmtree(out, ignore_errors=True)
        kill_at_some_moment(start(*words, out, command=WITH_WORKERS), dice.uniform(0.3, 1.0) * takes_s)
        for record in out.glob("runs/*/run.json"):
            for name in ("results.csv", "profile.csv"):
                same = whole / record.parent.relative_to(out) / name
                pd.testing.assert_frame_equal(numbers(record.with_name(name)), numbers(same), rtol=1e-9)
    assert run(*words, out).returncode == 0
    pd.testing.assert_frame_equal(numbers(out / "sweep.csv"), numbers(whole / "sweep.csv"), rtol=1e-9)
    names = [{str(path.relative_to(folder)) for path in folder.rglob("*")} for folder in (out, whole)]
    assert names[0] == names[1], "what the killed sweeps left is gone"


@pytest.mark.parametrize("workers", [1, 2])
def test_studies_killed_at_random_moments_end_as_an_undisturbed_one(workers: int, home: Path, tmp_path: Path):
    study, out, whole, dice = tmp_path / "study.toml", tmp_path / "out", tmp_path / "whole", random.Random(14)
    text = f'plan = "{home}/first.toml"\n[vary]\n"netting.0.bar_mm" = {{ from = 38, to = 46, steps = 24 }}\n'
    study.write_text(text, encoding="utf-8")
    words = ["sweep", study, "--workers", workers, "--out"]
    begun = monotonic()
    assert run(*words, whole, command=WITH_WORKERS).returncode == 0
    takes_s = monotonic() - begun
    for kill in range(STUDY_KILLS):
        if kill % 3 == 0:
            shutil.rmtree(out, ignore_errors=True)
        kill_at_some_moment(start(*words, out, command=WITH_WORKERS), dice.uniform(0.3, 1.0) * takes_s)
        for part in out.glob("parts/*.parquet"):
            pd.testing.assert_frame_equal(rows_of(part), rows_of(whole / "parts" / part.name))
    kept = {part: part.stat().st_mtime_ns for part in out.glob("parts/*.parquet")}
    assert run(*words, out).returncode == 0
    assert all(part.stat().st_mtime_ns == time for part, time in kept.items()), "what was whole is not solved again"
    pd.testing.assert_frame_equal(numbers(out / "sweep.csv"), numbers(whole / "sweep.csv"))
    names = [{str(path.relative_to(folder)) for path in folder.rglob("*")} for folder in (out, whole)]
    assert names[0] == names[1], "what the killed studies left is gone"


def rows_of(part: Path) -> pd.DataFrame:
    return pd.read_parquet(part).drop(columns="solve_ms")


def test_two_runs_in_one_folder_do_not_mix(home: Path, tmp_path: Path):
    dice = random.Random(13)
    for _ in range(MEETINGS):
        out = tmp_path / "out"
        first = start("run", home / "first.toml", "--out", out)
        sleep(dice.uniform(0.0, 1.0))
        second = start("run", home / "second.toml", "--out", out)
        said = [process.communicate()[1].decode() for process in (first, second)]
        statuses = [first.returncode, second.returncode]
        assert 0 in statuses
        for status, line in zip(statuses, said, strict=True):
            if status != 0:
                assert (status, line.count("\n")) == (2, 1)
                assert f"{out}: is in use by another run of codend" in line
        assert (out / "report.html").exists()
        assert_belongs_together(out, home)


def test_the_lock_of_a_killed_run_is_no_hindrance(home: Path, tmp_path: Path):
    process = start("run", home / "first.toml", "--out", tmp_path)
    while not (tmp_path / ".codend.lock").exists():
        sleep(0.01)
    process.kill()
    process.communicate()
    (tmp_path / ".results.csv.99.part").touch()
    assert run("run", home / "second.toml", "--out", tmp_path).returncode == 0
    assert not [path.name for path in tmp_path.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize(
    ("stop", "status", "word"),
    [
        (lambda: signal.raise_signal(signal.SIGINT), 130, "interrupted; 2 of 3 cases were solved and are in "),
        (lambda: signal.raise_signal(signal.SIGTERM), 143, "terminated; 2 of 3 cases were solved and are in "),
        (lambda: bytearray(2**62), 1, "too little memory; 2 of 3 cases were solved and are in "),
    ],
)
def test_cases_solved_before_the_end_are_kept_and_told(stop, status, word, home: Path, tmp_path: Path, monkeypatch):
    stop_at_the_third(stop, monkeypatch)
    out = tmp_path / "out"
    result = codend_cli("run", home / "second.toml", "--out", out)
    assert_refused(result, word + str(out / "results.csv"), status=status, printed=result.stdout)
    assert {path.name for path in out.iterdir()} == {"plan.toml", "results.csv", "profile.csv"}
    assert len(pd.read_csv(out / "results.csv")) == 2
    assert_belongs_together(out, home)


def stop_at_the_third(stop, monkeypatch: pytest.MonkeyPatch) -> None:
    solve, calls = codend.studies.study.equilibrium.solve, []

    def watched(*arguments: object) -> object:
        calls.append(arguments)
        if len(calls) == 3:
            stop()
        return solve(*arguments)

    monkeypatch.setattr(codend.studies.study.equilibrium, "solve", watched)


def test_an_error_of_the_program_leaves_the_cases_and_a_line_beside_its_traceback(home, tmp_path, monkeypatch):
    stop_at_the_third(lambda: 1 // 0, monkeypatch)
    result = codend_cli("run", home / "second.toml", "--out", tmp_path)
    assert isinstance(result.exception, ZeroDivisionError)
    assert "2 of 3 cases were solved" in result.stderr
    assert_belongs_together(tmp_path, home)
    again = run("run", home / "first.toml", "--out", tmp_path)
    assert again.stderr == f"{tmp_path} held 2 cases of a run that did not end; this one takes its place\n"
    assert_belongs_together(tmp_path, home)


def test_the_page_names_the_run_of_its_tables_and_another_run_has_another_name(home: Path):
    names = [json.loads((home / title / "run.json").read_bytes())["run"] for title in TITLES]
    assert names[0] != names[1]
    for title, name in zip(TITLES, names, strict=True):
        assert f"run {name}," in (home / title / "report.html").read_text(encoding="utf-8")


def test_an_interrupted_selectivity_leaves_no_section_of_other_tables(home: Path, tmp_path: Path, monkeypatch):
    folder = shutil.copytree(home / "first", tmp_path / "run")
    species = tmp_path / "fish.toml"
    species.write_text(codend_cli("species").stdout, encoding="utf-8")
    words = ["selectivity", folder, "--species", species, "--bootstrap", 0, "--samples", 0]
    assert codend_cli(*words).exit_code == 0
    page = folder / "report.html"
    assert "Selectivity</h2>" in page.read_text(encoding="utf-8")
    monkeypatch.setattr("codend.report.selectivity_page.png", lambda _: signal.raise_signal(signal.SIGINT))
    assert codend_cli(*words).exit_code == 130
    assert "<h2>Selectivity</h2>" not in page.read_text(encoding="utf-8")
    assert_page_is_of_its_tables(folder)


def test_a_worker_that_is_killed_ends_the_sweep_in_one_line(home: Path, tmp_path: Path, monkeypatch):
    from concurrent.futures.process import BrokenProcessPool

    def broken(*_: object) -> None:
        raise BrokenProcessPool

    monkeypatch.setattr("codend.studies.sweep.solve_runs", broken)
    words = ["sweep", home / "first.toml", "--vary", "netting.0.bar_mm=[38,40]", "--out", tmp_path / "out"]
    assert_refused(codend_cli(*words), "a process that solved was killed", status=1)
