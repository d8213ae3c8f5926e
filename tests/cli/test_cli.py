import io
import itertools
import os
import signal
import subprocess
import sys
import threading
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

import codend.studies.study
from codend.cli import console, doctor
from codend.cli.main import main
from codend.equilibrium import fidelity
from codend.io import files
from codend.io.columns import RESULT_COLUMNS
from codend.plan.plan import load_plan
from codend.report import page
from codend.report.choice_words import reason_text
from tests import ROOT
from tests.bad_plans import BAD_PLANS, VALID_PLAN, BadPlan

HADDOCK = ROOT / "validation" / "tables" / "millar_haddock_paired.csv"

TINY_PLAN = """
title = "A small bag"
[tow]
speed_m_s = 1.0
water_density_kg_m3 = 1000.0
[entry]
radius_m = 0.1
[[netting]]
mesh = "diamond"
meshes_round = 24
meshes_long = 20
bar_mm = 40.0
twine_mm = 2.0
[catch]
filled_meshes = [4, 8]
"""


def codend_cli(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words], prog_name="codend")


def assert_refused(result: Result, *words: str, status: int = 2, printed: str = "") -> None:
    """One line on standard error that holds the words, nothing else printed but ``printed``, no traceback."""
    assert result.exit_code == status
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == printed
    assert result.stderr.startswith("codend: ")
    assert result.stderr.count("\n") == 1
    assert result.stderr.endswith("\n")
    for word in words:
        assert word in result.stderr


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(TINY_PLAN, encoding="utf-8")
    return path


@pytest.fixture
def no_solving(monkeypatch):
    def solve(*_: object) -> None:
        raise AssertionError("solved what should have been refused")

    monkeypatch.setattr(codend.studies.study, "solve", solve)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """One run of the tiny plan: the folder it filled and what it said."""
    home = tmp_path_factory.mktemp("run")
    (home / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    return home / "new" / "out", codend_cli("run", home / "plan.toml", "--out", home / "new" / "out")


def reason(plan: Path) -> str:
    """What ``codend run`` prints before it solves anything: the model, and why."""
    return f"{reason_text(fidelity.choose(load_plan(plan)))}\n"


# --- the program as a whole ------------------------------------------------------------------------------------------


def test_help_and_version_import_nothing_heavy():
    code = """
import sys
import codend, codend.cli.main
for words in ([], ["--help"], ["run", "--help"], ["--version"]):
    try:
        codend.cli.main.main(words, prog_name="codend")
    except SystemExit as end:
        assert end.code == 0
heavy = {"numba", "pandas", "matplotlib", "scipy", "numpy", "pydantic", "jinja2", "meshio", "rich", "llvmlite"}
print(sorted(heavy & set(sys.modules)), file=sys.stderr)
"""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert result.stderr == "[]\n"
    assert "Usage: codend" in result.stdout


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["run", "plan.toml"], "--out"),
        (["run", "plan.toml", "--out"], "--out"),
        (["run", "--out", "x"], "PLAN.toml"),
        (["run", "plan.toml", "second.toml", "--out", "x"], "second.toml"),
        (["run", "no_such_plan.toml", "--out", "x"], "no_such_plan.toml"),
        (["--wrong"], "--wrong"),
        (["wrong"], "wrong"),
        (["fit", "data.csv", "--design", "paired", "--out", "x", "--bootstrap", "many"], "--bootstrap"),
        (["fit", "no_such_data.csv", "--design", "paired", "--out", "x"], "no_such_data.csv"),
        (["compare", "no_such_folder", "table.csv"], "results.csv"),
    ],
)
def test_wrong_use_ends_in_one_line_and_status_2(words, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_refused(codend_cli(*words), named)
    assert not list(tmp_path.iterdir())


def test_a_bug_is_not_passed_off_as_bad_input(plan, monkeypatch):
    monkeypatch.setattr(codend.studies.study, "solve", lambda *_: 1 // 0)
    assert isinstance(codend_cli("run", plan, "--out", plan.parent / "out").exception, ZeroDivisionError)


# --- run -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", BAD_PLANS, ids=lambda bad: bad.id)
def test_every_broken_plan_ends_in_one_line_with_its_key_and_writes_nothing(bad: BadPlan, tmp_path, no_solving):
    path = tmp_path / "plan.toml"
    path.write_text(bad.text, encoding="utf-8")
    result = codend_cli("run", path, "--out", tmp_path / "out")
    assert_refused(result, f"codend: {path}: {bad.key}", "; allowed: ")
    assert list(tmp_path.iterdir()) == [path]


def test_a_bad_change_is_refused_like_a_bad_plan(tmp_path, no_solving):
    path = tmp_path / "plan.toml"
    path.write_text(VALID_PLAN, encoding="utf-8")
    for changes in (["--set", "tow.speed_m_s=1", "entry.radius_m=-1"], ["--set=entry.radius_m=-1"]):
        assert_refused(codend_cli("run", path, *changes, "--out", tmp_path / "out"), "entry.radius_m = -1")
    assert_refused(codend_cli("run", path, "--set", "entry", "--out", tmp_path / "out"), "KEY=VALUE")
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "words",
    [
        "PLAN --out OUT --set tow.speed_m_s=2 netting.0.bar_mm=25 catch.filled_meshes=3",
        "PLAN --set tow.speed_m_s=2 --set netting.0.bar_mm=25 --set catch.filled_meshes=3 --out OUT",
        "--set tow.speed_m_s=2 netting.0.bar_mm=25 --set=catch.filled_meshes=3 PLAN --out OUT",
        "--set=tow.speed_m_s=2 netting.0.bar_mm=25 --out OUT --set catch.filled_meshes=3 PLAN",
    ],
)
def test_set_takes_several_changes_and_may_be_repeated(words, plan, monkeypatch):
    seen = []
    monkeypatch.setattr(codend.studies.study, "solve", lambda plan, *_: seen.append(plan) or 1 // 0)
    names = {"PLAN": str(plan), "OUT": str(plan.parent / "out")}
    codend_cli("run", *(names.get(word, word) for word in words.split()))
    (changed,) = seen
    assert changed.tow.speed_m_s == (2.0,)
    assert changed.netting[0].bar_mm == 25.0
    assert changed.catch.filled_meshes == (3.0,)


def test_run_writes_the_tables_and_prints_a_short_one(ran):
    folder, result = ran
    assert result.exit_code == 0
    results = pd.read_csv(folder / "results.csv")
    assert list(results.columns) == RESULT_COLUMNS
    assert results["converged"].all()
    assert {path.name for path in folder.iterdir()} >= {"profile.csv", "net_1.vtu", "net_2.vtu", "report.html"}
    assert not list(folder.rglob("*.part"))
    over, header, first, second = result.stdout.splitlines()[1:5]
    assert over.split()[0] == "speed"
    assert header.split()[:3] == ["case", "m/s", "meshes"]
    assert max(map(len, result.stdout.splitlines()[1:5])) <= 80
    assert f"{results['drag_n'][0]:.4g}" in first.split()
    assert second.split()[0] == "2"
    assert second.split()[-1] == "yes"


def test_the_model_and_what_it_costs_are_told_before_anything_is_solved(plan, monkeypatch):
    """Mesh counts without a common divisor make a full net of many knots, which takes long where it must be exact."""
    laced = (
        "netting=[{mesh='diamond', meshes_round=97, meshes_long=10, bar_mm=40, twine_mm=2},"
        "{mesh='diamond', meshes_round=89, meshes_long=10, bar_mm=40, twine_mm=2}]"
    )
    monkeypatch.setattr(codend.studies.study, "solve", lambda *_: signal.raise_signal(signal.SIGINT))
    result = codend_cli("run", plan, "--out", plan.parent / "out", "--set", laced)
    assert "the full net (its mesh counts 97 and 89 have no common divisor) would be exact, but" in result.stdout
    assert "in its place stands one 12 and 11 meshes wide, as of 97.0 and 89.0 meshes round" in result.stdout
    exactly = ("--set", laced, "--set", "model.accuracy=1e-4")
    result = codend_cli("run", plan, "--out", plan.parent / "out", *exactly)
    assert "the full net (its mesh counts 97 and 89 have no common divisor) is exact." in result.stdout
    assert "Its 3721 knots take seconds to minutes a case; meshes round with a larger common" in result.stdout


def test_a_case_that_does_not_converge_gives_status_3_and_the_others_are_written(plan):
    out = plan.parent / "out"
    result = codend_cli("run", plan, "--out", out, "--set", "catch.volume_m3=[0.02, 0.16]")
    assert result.exit_code == 3
    assert pd.read_csv(out / "results.csv")["converged"].tolist() == [True, False]
    assert (out / "net_1.vtu").exists()
    assert not (out / "net_2.vtu").exists()
    first, *tried = result.stderr.splitlines()
    assert first.startswith("case 2 (volume_m3 = 0.16 at 1 m/s) was not solved: The catch does not fit")
    assert tried
    assert all(line.startswith("  tried ") for line in tried)
    assert result.stdout.splitlines()[4].endswith("NO")


def test_a_second_run_leaves_nothing_of_the_first_but_what_is_not_its_own(plan):
    out = plan.parent / "out"
    out.mkdir()
    for name in ("net_1.vtu", "net_7.vtu", "meshes.csv", "notes.txt"):
        (out / name).write_text("of an earlier run", encoding="utf-8")
    assert codend_cli("run", plan, "--out", out, "--set", "catch.filled_meshes=5").exit_code == 0
    assert not (out / "net_7.vtu").exists()
    assert not (out / "meshes.csv").exists()
    assert (out / "net_1.vtu").read_text(encoding="utf-8") != "of an earlier run"
    assert (out / "notes.txt").read_text(encoding="utf-8") == "of an earlier run"


@pytest.mark.parametrize("inside", ["plan.toml", "plan.toml/out"])
def test_a_folder_that_cannot_be_made_is_refused_before_anything_is_solved(plan, inside, no_solving):
    assert_refused(codend_cli("run", plan, "--out", plan.parent / inside), "cannot be written", "is no folder")


def as_folder(path: Path) -> Path:
    path.mkdir(parents=True)
    return path


def as_file(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    return path


@pytest.mark.parametrize(
    ("command", "make", "name"),
    [
        ("run", as_file, "plots"),
        ("run", as_folder, "plots/net.png"),
        ("run", as_folder, "net_2.vtu"),
        ("sweep", as_file, "runs/002"),
        ("sweep", as_folder, "runs/001/results.csv"),
        ("chart", as_folder, "chart_drag.png"),
    ],
)
def test_a_file_that_cannot_be_written_is_named_before_anything_is_solved(command, make, name, plan, monkeypatch):
    for solver in ("sweep.solve", "speed_accuracy.measuring.measure", "study.solve"):
        monkeypatch.setattr(f"codend.studies.{solver}", lambda *_: pytest.fail("solved what should have been refused"))
    there = make(plan.parent / "out" / name)
    more = ["--vary", "netting.0.bar_mm=[40,50]"] if command == "sweep" else []
    result = codend_cli(command, plan, "--out", plan.parent / "out", *more)
    assert_refused(result, f"{there}:", "cannot be written", "no folder" if make is as_file else "is a folder")
    assert list((plan.parent / "out").rglob("*.csv")) == [path for path in (there,) if path.suffix == ".csv"]


@pytest.mark.parametrize(("make", "name"), [(as_file, "plots"), (as_folder, "retention.csv")])
def test_selectivity_and_fit_name_what_they_cannot_write(make, name, ran, tmp_path):
    folder, species = tmp_path / "out", tmp_path / "fish.toml"
    folder.mkdir()
    for table in ("plan.toml", "results.csv", "profile.csv"):
        (folder / table).write_bytes((ran[0] / table).read_bytes())
    species.write_text(codend_cli("species").stdout, encoding="utf-8")
    there = make(folder / name)
    assert_refused(codend_cli("selectivity", folder, "--species", species), f"{there}:", "cannot be written")
    assert not (folder / "selectivity.csv").exists()
    there = as_folder(folder / "fit.csv")
    assert_refused(codend_cli("fit", HADDOCK, "--design", "paired", "--out", folder), f"{there}:", "cannot be written")


def test_what_cannot_be_written_in_the_end_is_named_itself(ran, plan, monkeypatch):
    monkeypatch.setattr(codend.studies.study, "solve", lambda *_: None)
    monkeypatch.setattr(page, "write_report", lambda _, folder, *__, **___: (folder / "new" / "plots").mkdir())
    out = plan.parent / "out"
    told = f"{out / 'new' / 'plots'}: cannot be written: No such file"
    assert_refused(codend_cli("run", plan, "--out", out), told, printed=reason(plan))


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="nothing is forbidden to root")
def test_a_folder_without_permission_is_refused_before_anything_is_solved(plan, no_solving):
    closed = plan.parent / "closed"
    closed.mkdir(mode=0o500)
    assert_refused(codend_cli("run", plan, "--out", closed / "out"), "permission denied")


def test_a_full_disk_ends_in_one_line(ran, plan, monkeypatch):
    def write_report(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(codend.studies.study, "solve", lambda *_: None)
    monkeypatch.setattr(page, "write_report", write_report)
    result = codend_cli("run", plan, "--out", plan.parent / "out")
    assert_refused(result, "No space left on device", printed=reason(plan))


def test_interrupted_while_solving_it_writes_nothing(plan, monkeypatch):
    monkeypatch.setattr(codend.studies.study, "solve", lambda *_: signal.raise_signal(signal.SIGINT))
    result = codend_cli("run", plan, "--out", plan.parent / "out")
    assert_refused(result, "codend: interrupted", status=130, printed=reason(plan))
    assert list(plan.parent.iterdir()) == [plan]


@pytest.mark.parametrize("stop", [3, 5, 8])
def test_interrupted_while_writing_it_leaves_no_half_files(stop, plan, ran, monkeypatch):
    whole, _ = ran
    solve = codend.studies.study.solve
    renamed, calls = [], itertools.count()  # threads rename at once: only one of them may find itself the fourth

    def replace(source: Path, target: Path) -> None:
        if next(calls) == stop:
            signal.raise_signal(signal.SIGINT)
        renamed.append(target)
        os.rename(source, target)

    def solve_then_watch(*arguments: object) -> object:
        study = solve(*arguments)
        monkeypatch.setattr(files.os, "replace", replace)
        return study

    monkeypatch.setattr(codend.studies.study, "solve", solve_then_watch)
    out = plan.parent / "out"
    assert_refused(codend_cli("run", plan, "--out", out), "codend: interrupted", status=130, printed=reason(plan))
    left = sorted(path for path in out.rglob("*") if path.is_file())
    assert left == sorted(renamed)
    for path in left:
        (same,) = whole.rglob(path.name)
        assert len(path.read_bytes().splitlines()) == len(same.read_bytes().splitlines())


# --- compare ---------------------------------------------------------------------------------------------------------

FLUME = """\
# INVENTED for a test: no measurement
filled_meshes,speed_m_s,drag_n,hoop_drag_n,max_diameter_m
4,1.0,70,10,0.40
6,1.0,80,10,
12,1.0,90,10,0.50
"""


def test_compare_prints_differences_and_the_tables_source_and_writes_both_and_a_plot(ran, tmp_path):
    folder, _ = ran
    (tmp_path / "flume.csv").write_text(FLUME, encoding="utf-8")
    result = codend_cli("compare", folder, tmp_path / "flume.csv")
    assert result.exit_code == 0
    assert result.stderr == ""
    assert "INVENTED for a test: no measurement" in result.stdout.splitlines()[0]
    assert "2 of 3 rows compared, matched on filled_meshes and speed" in result.stdout
    assert "not compared, line 5: drag_n, max_diameter_m: filled_meshes = 12 is outside" in result.stdout
    points = pd.read_csv(folder / "comparison.csv").set_index(["quantity", "table_line"])
    drag = pd.read_csv(folder / "results.csv")["drag_n"]
    assert points.loc[("drag_n", 3), "computed"] == pytest.approx(drag[0] + 10.0)
    assert points.loc[("drag_n", 3), "difference"] == pytest.approx(drag[0] + 10.0 - 70.0)
    assert drag[0] < points.loc[("drag_n", 4), "computed"] - 10.0 < drag[1]
    summary = pd.read_csv(folder / "comparison_summary.csv").set_index("quantity")
    assert summary["points"].to_dict() == {"drag_n": 2, "max_diameter_m": 1}
    assert f"{summary.loc['drag_n', 'bias']:.4g}" in result.stdout
    assert (folder / "comparison.png").read_bytes().startswith(b"\x89PNG")


def test_compare_computes_the_hoops_drag_for_an_assumed_rod(ran, tmp_path):
    (tmp_path / "flume.csv").write_text(FLUME.replace(",10,", ",,"), encoding="utf-8")
    result = codend_cli("compare", ran[0], tmp_path / "flume.csv", "--hoop-rod-mm", "8")
    assert result.exit_code == 0
    assert "drag_n: computed drag plus the hoop's (computed, rod of 8 mm ASSUMED)" in result.stdout
    points = pd.read_csv(ran[0] / "comparison.csv").set_index(["quantity", "table_line"])
    plan = codend.load_plan(ran[0] / "plan.toml")
    expected = 0.5 * plan.tow.water_density_kg_m3 * 1.2 * 0.008 * 2 * np.pi * plan.entry.radius_m
    assert points.loc[("drag_n", 3), "hoop_drag_n"] == pytest.approx(expected)
    assert points.loc[("drag_n", 3), "hoop_origin"] == "computed, rod of 8 mm ASSUMED"


@pytest.mark.parametrize("thickness", ["thick", "0", "-5", "1e4", "nan"])
def test_a_rod_that_cannot_be_is_refused_with_what_is_allowed(thickness, tmp_path):
    result = codend_cli("compare", tmp_path, tmp_path / "flume.csv", "--hoop-rod-mm", thickness)
    assert_refused(result, "options: --hoop-rod-mm = ", "allowed: a number above 0, at most 1000, in mm")


def test_compare_with_a_bad_table_writes_nothing(ran, tmp_path):
    folder = tmp_path / "results"
    folder.mkdir()
    (folder / "results.csv").write_bytes((ran[0] / "results.csv").read_bytes())
    (tmp_path / "flume.csv").write_text(FLUME.replace("80", "eighty"), encoding="utf-8")
    assert_refused(codend_cli("compare", folder, tmp_path / "flume.csv"), "drag_n", '"eighty"', "line 4")
    assert [path.name for path in folder.iterdir()] == ["results.csv"]


# --- fit -------------------------------------------------------------------------------------------------------------


def test_fit_finds_millars_haddock_and_writes_both_tables(tmp_path):
    result = codend_cli("fit", HADDOCK, "--design", "paired", "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert result.stderr == ""
    table = pd.read_csv(tmp_path / "out" / "fit.csv").set_index("parameter")
    assert list(table.columns) == ["group", "curve", "estimate", "standard_error", "lower_95", "upper_95", "interval"]
    assert table.loc["a", "estimate"] == pytest.approx(-36.3144, abs=1e-4)
    assert table.loc["b", "estimate"] == pytest.approx(1.2340, abs=1e-4)
    assert pd.read_csv(tmp_path / "out" / "diagnostics.csv")["converged"].all()
    assert [line.split()[:3] for line in result.stdout.splitlines() if " l50_cm " in line] == [
        ["pooled", "l50_cm", "29.43"]
    ]


def covered_hauls(path: Path, l50s: list[float]) -> Path:
    """Made-up hauls of 100 fish a length, split by a logistic curve of SR 4 cm to the nearest fish."""
    length = np.arange(20.0, 41.0, 2.0)
    frames = []
    for number, l50 in enumerate(l50s, start=1):
        kept = np.round(100.0 / (1.0 + np.exp(-2.0 * np.log(3.0) / 4.0 * (length - l50))))
        frames.append(pd.DataFrame({"haul": number, "length_cm": length, "codend": kept, "cover": 100.0 - kept}))
    pd.concat(frames).assign(depth_m=lambda f: 10.0 * f["haul"]).to_csv(path, index=False)
    return path


def test_fit_of_several_hauls_shows_one_stage_first_then_two_then_bootstrap_then_pooled(tmp_path):
    data = covered_hauls(tmp_path / "data.csv", [28.0, 29.0, 30.0, 31.0, 32.0])
    words = ["--design", "covered", "--curve", "probit", "--bootstrap", "20", "--seed", "1"]
    result = codend_cli("fit", data, *words, "--out", tmp_path)
    assert result.exit_code == 0
    shown = [line.split()[0] for line in result.stdout.splitlines() if " l50_cm " in line]
    assert shown == ["one-stage", "between-hauls", "bootstrap", "pooled"]
    table = pd.read_csv(tmp_path / "fit.csv")
    assert set(table["curve"]) == {"probit"}
    hauls = {f"haul {n}" for n in range(1, 6)}
    assert set(table["group"]) == {"one-stage", "between-hauls", "bootstrap", "pooled"} | hauls


@pytest.mark.parametrize(("split", "named"), [("equal", "split, fixed"), ("estimated", "split")])
def test_only_an_estimated_split_has_a_standard_error(split, named, tmp_path):
    out = ("--bootstrap", "20", "--out", tmp_path)
    result = codend_cli("fit", HADDOCK, "--design", "paired", "--split", split, *out)
    table = pd.read_csv(tmp_path / "fit.csv").query("parameter == 'split'")
    errors = table[["standard_error", "lower_95", "upper_95"]]
    assert len(table) == 2
    assert (errors.isna() if split == "equal" else errors.gt(0.0)).to_numpy().all()
    assert any(line.startswith(f"pooled     {named}  ") for line in result.stdout.splitlines())


def test_fit_takes_covariates(tmp_path):
    data = covered_hauls(tmp_path / "data.csv", [28.0, 29.0, 30.0, 31.0, 32.0])
    assert codend_cli("fit", data, "--design", "covered", "--covariate", "depth_m", "--out", tmp_path).exit_code == 0
    table = pd.read_csv(tmp_path / "fit.csv").query("group == 'pooled'").set_index("parameter")
    assert table.loc["l50_cm:depth_m", "estimate"] == pytest.approx(0.1, rel=0.02)


def test_a_fit_that_finds_no_maximum_gives_status_3_and_says_why(tmp_path):
    data = tmp_path / "data.csv"
    data.write_text("haul,length_cm,codend,cover\n1,20,10,0\n1,25,10,0\n1,30,10,0\n", encoding="utf-8")
    result = codend_cli("fit", data, "--design", "covered", "--out", tmp_path / "out")
    assert result.exit_code == 3
    assert result.stderr.startswith("pooled was not fitted: ")
    assert pd.read_csv(tmp_path / "out" / "fit.csv")["estimate"].isna().all()


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--design", "coverd"], "options: design"),
        (["--design", "covered"], f"{HADDOCK}: codend"),
        (["--design", "paired", "--curve", "spline"], "options: curve"),
        (["--design", "paired", "--split", "1.4"], "options: split"),
        (["--design", "paired", "--covariate", "depth_m"], f"{HADDOCK}: depth_m"),
        (["--design", "paired", "--bootstrap", "-1"], "options: n_bootstrap"),
    ],
)
def test_a_fit_that_cannot_be_made_writes_nothing(words, named, tmp_path):
    assert_refused(codend_cli("fit", HADDOCK, *words, "--out", tmp_path / "out"), f"codend: {named} ")
    assert not (tmp_path / "out").exists()


# --- doctor, version and progress ------------------------------------------------------------------------------------


def test_doctor_looks_at_every_package_the_project_declares():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

    def names(requirements: list[str]) -> list[str]:
        return [requirement.split(">")[0].strip() for requirement in requirements]

    assert list(doctor.REQUIRED) == names(project["dependencies"])
    assert list(doctor.FOR_TESTS) == names(project["optional-dependencies"]["test"])
    assert list(doctor.FAST) == names(project["optional-dependencies"]["fast"])


def test_doctor_warms_up_and_names_versions_and_caches():
    result = codend_cli("doctor", "--warm-up")
    assert result.exit_code == 0
    warm_up, *findings = result.stdout.splitlines()
    assert "kernels compiled" in warm_up
    found = {line.split()[0]: line for line in findings}
    assert np.__version__ in found["numpy"]
    assert "usable" in found["cores"]
    assert any(" compiled: " in line for line in findings if line.startswith("kernel cache"))


def test_doctor_reports_a_missing_package(monkeypatch):
    monkeypatch.setattr(doctor, "version_of", lambda name: None if name == "meshio" else "1.0")
    result = codend_cli("doctor")
    assert result.exit_code == 1
    assert [line.split() for line in result.stdout.splitlines() if "MISSING" in line] == [["meshio", "MISSING"]]


def test_version_is_that_of_the_installed_package(monkeypatch):
    monkeypatch.setattr(doctor, "version_of", lambda _: "1.2.3")
    result = codend_cli("--version")
    assert (result.exit_code, result.stdout) == (0, "codend 1.2.3\n")


def test_progress_without_a_terminal_is_a_plain_line_every_ten_seconds(monkeypatch, capsys):
    clock = iter([0.0, 1.0, 9.0, 10.5, 20.0, 20.9])
    monkeypatch.setattr(console, "monotonic", lambda: next(clock))
    with console.shown_progress() as progress:
        for done in range(5):
            progress(done, 5, "solving [1/2]")
    told = ["2 of 5 done (40%, 16 s left), solving [1/2]", "4 of 5 done (80%, 5 s left), solving [1/2]"]
    assert capsys.readouterr().err.splitlines() == told


def test_time_left_is_that_of_the_work_at_hand(monkeypatch, capsys):
    clock = iter([0.0, 1.0, 50.0, 65.0])
    monkeypatch.setattr(console, "monotonic", lambda: next(clock))
    with console.shown_progress() as progress:
        progress(0, 3, "fitting")
        progress(0, 100, "bootstrap")
        progress(50, 100, "bootstrap")
    assert capsys.readouterr().err.splitlines()[-1] == "50 of 100 done (50%, 15 s left), bootstrap"


def test_progress_in_a_terminal_is_a_bar_that_is_gone_in_the_end(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", terminal)
    threads = threading.active_count()
    with console.shown_progress() as progress:
        # workers are copied from no process with other threads
        assert threading.active_count() == threads
        progress(1, 2, "case 2: solving [1/2]")
    assert "1/2" in terminal.getvalue()
    assert "solving [1/2]" in terminal.getvalue()
    assert terminal.getvalue().endswith("\x1b[2K")


def test_tables_align_numbers_to_the_right_and_show_the_unknown_as_a_dash():
    table = console.text_table(["name", "drag N", "ok"], [("first", 12.3456, True), ("2nd", float("nan"), False)])
    assert table == "        drag\nname       N  ok\nfirst  12.35  yes\n2nd        -  NO"


def test_a_table_wider_than_a_terminal_goes_on_below():
    names = [f"quantity {c}" for c in range(14)]
    table = console.text_table(["case", *names], [[i, *(1000.5 + c for c in range(14))] for i in range(2)])
    assert max(map(len, table.splitlines())) <= 80
    assert len(table.split("\n\n")) == 2
    assert all(text in table.split() for text in ("1000", "1014"))


def test_a_folder_name_too_long_for_the_system_is_refused_in_one_line(plan, tmp_path, no_solving):
    assert_refused(codend_cli("run", plan, "--out", tmp_path / ("a" * 300)), "cannot be written")
