"""``python -m validation`` from end to end: what it writes, where, and how it tells what failed."""

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest
from click.testing import CliRunner, Result

from codend.report.style import new_figure
from tests import ROOT
from validation.__main__ import COMMITTED, SECTIONS, main
from validation.report import Part, markdown_table, report_text
from validation.section import Picture, Section, Verdict

GOOD, BAD = Verdict("Water is wet", True, "it was"), Verdict("Pigs fly", False, "none did")


def links(report: Path) -> list[str]:
    return re.findall(r"\]\(([^)]+)\)", report.read_text(encoding="utf-8"))


def picture(name: str) -> Picture:
    figure = new_figure(2.0, 1.0)
    figure.add_subplot()
    return Picture(name, figure, f"A caption of {name}.")


@pytest.fixture
def inject(monkeypatch):
    """Add a section to the list, given what its ``section`` returns or raises."""
    sections = dict(SECTIONS)
    monkeypatch.setattr("validation.__main__.SECTIONS", sections)

    def injected(name: str, found: Section | Exception) -> None:
        def section(quick: bool) -> Section:
            if isinstance(found, Exception):
                raise found
            return found

        sections[name] = f"validation.{name}"
        monkeypatch.setitem(sys.modules, f"validation.{name}", SimpleNamespace(section=section))

    injected.sections = sections
    return injected


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_the_flume_section_runs_as_a_command_and_everything_it_links_to_is_there(tmp_path):
    command = [sys.executable, "-m", "validation", "--quick", "--only", "flume", "--out", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    report = tmp_path / "REPORT.md"
    text = report.read_text(encoding="utf-8")
    assert "`python -m validation --quick --only flume`" in text
    assert "no measured flume table ships" in text
    linked = links(report)
    assert "figures/flume_drag.png" in linked
    for link in linked:
        assert (tmp_path / link).is_file(), link
    drag = pd.read_csv(tmp_path / "data" / "flume_drag.csv")
    assert drag["drag_with_assumed_hoop_n"].to_list() == pytest.approx(
        (drag["catch_drag_n"] + drag["twine_drag_n"] + drag["hoop_drag_assumed_rod_n"]).to_list()
    )
    assert not list(tmp_path.rglob(".*"))


def test_the_checks_section_passes_and_shows_every_theme(tmp_path):
    done = run("--quick", "--only", "checks", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    report = (tmp_path / "REPORT.md").read_text(encoding="utf-8")
    for title in ("Closed forms of a bare bag", "Chains and cables", "Panel of netting on a frame"):
        assert f"### {title}" in report
    assert {path.stem for path in (tmp_path / "figures").iterdir()} == {
        "closed_forms",
        "shells",
        "cables",
        "pressure",
        "panels",
    }


def test_a_failed_check_gives_status_1_and_is_named(tmp_path, inject):
    inject("farm", Section("A farm", "Text.", verdicts=(GOOD, BAD)))
    done = run("--only", "farm", "--out", tmp_path)
    assert done.exit_code == 1
    assert "FAILED farm: Pigs fly: none did" in done.stderr
    assert "Water is wet" not in done.stderr
    text = (tmp_path / "REPORT.md").read_text(encoding="utf-8")
    assert "1 of 2 checks passed" in text
    assert "**FAILED** farm: Pigs fly: none did" in text
    assert "| farm | Pigs fly | none did | **NO** |" in text


def test_a_section_that_raises_is_reported_and_the_others_still_run(tmp_path, inject):
    inject("first", ValueError("no such beast"))
    inject.sections["missing"] = "validation.not_there"
    inject("last", Section("The last", "Text.", verdicts=(GOOD,)))
    done = run("--only", "first", "--only", "missing", "--only", "last", "--out", tmp_path)
    assert done.exit_code == 1
    assert "FAILED first: It runs to its end: ValueError: no such beast" in done.stderr
    assert "FAILED missing: It runs to its end: ModuleNotFoundError" in done.stderr
    text = (tmp_path / "REPORT.md").read_text(encoding="utf-8")
    assert "| last | Water is wet | it was | yes |" in text
    assert "## The last" in text


def test_two_sections_cannot_overwrite_each_others_files(tmp_path, inject):
    inject("one", Section("One", "Text.", (picture("same"),), verdicts=(GOOD,)))
    inject("two", Section("Two", "Text.", (picture("same"),), {"other": pd.DataFrame({"a": [1]})}, (GOOD,)))
    done = run("--only", "one", "--only", "two", "--out", tmp_path)
    assert done.exit_code == 1
    assert "FAILED two" in done.stderr
    assert "another section has files named same.png" in done.stderr


def test_leftovers_of_the_last_report_are_removed_and_nothing_else(tmp_path, inject):
    table = pd.DataFrame({"a": [1.0]})
    inject("farm", Section("A farm", "Text.", (picture("pig"), picture("cow")), {"pig": table}, (GOOD,)))
    assert run("--only", "farm", "--out", tmp_path).exit_code == 0
    (tmp_path / "figures" / "mine.png").write_bytes(b"mine")
    inject("farm", Section("A farm", "Text.", (picture("cow"),), {"hen": table}, (GOOD,)))
    assert run("--only", "farm", "--out", tmp_path).exit_code == 0
    left = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file())
    assert left == ["REPORT.md", "data/hen.csv", "figures/cow.png", "figures/mine.png"]


@pytest.mark.parametrize("options", [("--quick",), ("--only", "farm"), ("--quick", "--only", "farm")])
def test_a_report_that_is_quick_or_in_part_never_overwrites_the_committed_one(tmp_path, inject, monkeypatch, options):
    inject.sections.clear()
    inject("farm", Section("A farm", "Text.", verdicts=(GOOD,)))
    inject("other", Section("Another", "Text.", verdicts=(GOOD,)))
    monkeypatch.chdir(tmp_path)
    before = {path: path.stat().st_mtime_ns for path in COMMITTED.glob("REPORT.md")}
    assert run(*options).exit_code == 0
    assert (tmp_path / "results" / "validation" / "REPORT.md").is_file()
    assert {path: path.stat().st_mtime_ns for path in COMMITTED.glob("REPORT.md")} == before


def test_an_unknown_section_or_a_folder_that_cannot_be_is_refused_before_the_work(tmp_path, inject):
    done = run("--only", "nonsense")
    assert done.exit_code == 2
    assert f"'nonsense' is none of {', '.join(SECTIONS)}" in done.stderr
    inject("farm", RuntimeError("must not run"))
    (tmp_path / "file").write_text("", encoding="utf-8")
    done = run("--only", "farm", "--out", tmp_path / "file")
    assert done.exit_code == 2
    assert "a folder that can be written" in done.stderr
    assert "must not run" not in done.stderr


def test_pictures_stand_where_the_text_names_them_and_the_others_after_it():
    section = Section("A farm", "Before.\n\n![pig]\n\nAfter.", (picture("cow"), picture("pig")), verdicts=(GOOD,))
    text = report_text([Part("farm", section)], "How.", [("cores", "2")])
    places = [text.index(part) for part in ("Before.", "(figures/pig.png)", "After.", "(figures/cow.png)")]
    assert places == sorted(places)
    assert "*A caption of pig.*" in text


def test_cells_cannot_break_a_table():
    assert markdown_table(("a", "b"), [("x | y", "two\nlines")]).splitlines()[2] == r"| x \| y | two lines |"


def test_the_committed_report_has_every_file_it_links_to_and_no_failed_check():
    report = COMMITTED / "REPORT.md"
    assert "FAILED" not in report.read_text(encoding="utf-8")
    linked = links(report)
    assert linked
    for link in linked:
        assert (COMMITTED / link).is_file(), link
