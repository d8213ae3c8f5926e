import base64
import re
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from codend.bag.measures import Measures
from codend.io.files import whole_file, write_table
from codend.plan.plan import plan_from_dict
from codend.report import drawn_beside, page
from codend.report.choice_words import reason_text
from codend.report.drag_plot import drag_plot
from codend.report.html import notes
from codend.report.own_look import own_look
from codend.report.page import PLOTS, files_of, write_report
from codend.report.page_tables import RESULT_HEADS
from codend.report.style import column_text, number_text, png, spread, worth
from codend.report.turning_net import TURNING, can_turn, turning_page
from codend.solvers.outcome import Outcome
from codend.studies.case_result import CaseResult
from codend.studies.study import Study, solve

PLAN: dict[str, Any] = {
    "title": "Small bag <script>alert('x')</script> & more",
    "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1000.0},
    "entry": {"radius_m": 0.1},
    "netting": [{"mesh": "diamond", "meshes_round": 24, "meshes_long": 20, "bar_mm": 40.0, "twine_mm": 2.0}],
    "catch": {"filled_meshes": [4, 7.5]},
}
PNG_START = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def study() -> Study:
    solved = solve(plan_from_dict(PLAN))
    assert solved.converged
    return solved


def as_failed(result: CaseResult) -> CaseResult:
    """The same case as a solver leaves it that gave up."""
    report = replace(
        result.report,
        outcome=Outcome.STEPS_SPENT,
        residual=float("inf"),
        length_error=float("nan"),
        attempts=("first <b>way</b>: gave up", "second way: gave up"),
    )
    solution = replace(
        result.solution,
        positions=np.full_like(result.positions, np.nan),
        bar_tension=np.full_like(result.bar_tension_n, np.nan),
        report=report,
    )
    return replace(result, solution=solution, measures=Measures.unknown(), rows=None, meshes=None)


@pytest.fixture(scope="module")
def half_failed(study: Study) -> Study:
    return Study(study.plan, study.choice, (study.cases[0], as_failed(study.cases[1])))


@pytest.fixture(scope="module")
def written(study: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole") / "made" / "on the way"
    told: list[tuple[int, int, str]] = []
    files = write_report(study, folder, lambda *said: told.append(said))
    assert sorted(files) == sorted(path for path in folder.rglob("*") if path.is_file())
    assert told == [(done, len(files), f"writing {path.name}") for done, path in enumerate(files)]
    return folder


@pytest.fixture(scope="module")
def written_half_failed(half_failed: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("half")
    write_report(half_failed, folder)
    return folder


def text_of(folder: Path) -> str:
    """The page as its reader sees it: without pictures and tags."""
    html = (folder / "report.html").read_text(encoding="utf-8")
    return unescape(re.sub(r"<[^>]*>", " ", re.sub(r"<style>.*?</style>", "", html, flags=re.S)))


def cells_of(folder: Path) -> Iterator[str]:
    html = (folder / "report.html").read_text(encoding="utf-8")
    return (match[1] for match in re.finditer(r"<td[^>]*>(.*?)</td>", html, re.S))


def test_a_study_leaves_every_file_that_is_promised_and_tells_of_each(study: Study, written: Path):
    names = {str(path.relative_to(written)) for path in written.rglob("*") if path.is_file()}
    plots = {f"plots/{plot.name}.png" for plot in PLOTS if plot.fits(study)}
    tables = {"plan.toml", "results.csv", "profile.csv", "run.json"}
    turning = {TURNING} if can_turn() else set()
    assert names == {*tables, "net_1.vtu", "net_2.vtu", "net.pvd", "report.html"} | plots | turning
    assert names == set(files_of(study.plan)) - {"meshes.csv"}


def test_tables_read_back_as_the_study_has_them(study: Study, written: Path):
    for name, table in (("results", study.table), ("profile", study.profile)):
        read = pd.read_csv(written / f"{name}.csv", dtype={"section": str})
        pd.testing.assert_frame_equal(read, table, check_dtype=False, rtol=1e-11, atol=0.0)


def test_meshes_of_a_full_net_are_written_too(tmp_path: Path):
    small = {**PLAN, "catch": {"filled_meshes": 4}, "model": {"fidelity": "globalised", "globalisation": 4}}
    full = solve(plan_from_dict(small))
    written = write_report(full, tmp_path)
    read = pd.read_csv(tmp_path / "meshes.csv")
    assert tmp_path / "meshes.csv" in written
    assert len(read) == len(full.cases[0].bag.mesh_row)


def test_plots_are_pictures_with_something_drawn_in_them(study: Study, written: Path):
    from matplotlib.image import imread

    for plot in (plot for plot in PLOTS if plot.fits(study)):
        path = written / "plots" / f"{plot.name}.png"
        assert path.read_bytes().startswith(PNG_START)
        picture = imread(path)
        assert min(picture.shape[:2]) > 200
        assert len(np.unique(picture[..., :3].sum(axis=2))) > 50


def test_the_page_carries_its_pictures_and_asks_for_nothing_from_elsewhere(study: Study, written: Path):
    html = (written / "report.html").read_text(encoding="utf-8")
    sources = re.findall(r'(?:src|srcset|action)\s*=\s*"([^"]*)"', html)
    drawings = [source for source in sources if source.startswith("data:image/svg+xml")]
    for drawing in drawings:
        assert base64.b64decode(drawing.removeprefix("data:image/svg+xml;base64,"), validate=True).startswith(b"<svg ")
    pictures = [source for source in sources if source not in drawings]
    assert len(pictures) == sum(plot.fits(study) for plot in PLOTS)
    places = set(re.findall(r'id="([^"]*)"', html))
    for link in re.findall(r'href="([^"]*)"', html):
        assert link[1:] in places if link.startswith("#") else (written / link).is_file()
    for source in pictures:
        assert source.startswith("data:image/png;base64,")
        assert base64.b64decode(source.partition(",")[2], validate=True).startswith(PNG_START)
    assert not re.search(r"https?:|//[a-z]|@import|url\(|<script|<link|<iframe", re.sub(r'"data:[^"]*"', "", html))


def test_text_of_the_plan_is_escaped(written: Path):
    html = (written / "report.html").read_text(encoding="utf-8")
    assert "<script" not in html
    assert "&lt;script&gt;" in html
    assert str(PLAN["title"]) in text_of(written)


def test_the_page_says_all_that_the_plan_asks_for_defaults_included(study: Study, written: Path):
    text = text_of(written)
    for name, table in study.plan.to_dict().items():
        for part in table if isinstance(table, list) else [table]:
            for key in part if isinstance(part, dict) else []:
                assert key in text, f"{name}.{key}"
    assert "bessonneau" not in text
    assert "le-bris-1999" in text


def test_the_page_says_which_model_was_used_and_what_stands_behind_the_pressure(study: Study, written: Path):
    assert reason_text(study.choice) in text_of(written)
    assert "reconstructed" in text_of(written)


def test_a_uniform_pressure_law_is_no_reconstruction(study: Study):
    uniform = plan_from_dict({**PLAN, "catch": {"filled_meshes": 4, "pressure": "uniform", "coefficient": 1.3}})
    said = " ".join(notes(replace(study, plan=uniform)))
    assert "reconstructed" not in said
    assert "1.3 times the stagnation pressure" in said


def test_a_case_that_failed_is_listed_with_what_was_tried_and_without_numbers(
    half_failed: Study, written_half_failed: Path
):
    text = text_of(written_half_failed)
    assert "2 (not solved)" in text
    assert "Not solved, and without numbers: 1 case of 2 (2)" in text
    assert Outcome.STEPS_SPENT.value in text
    assert "first <b>way</b>: gave up" in text
    assert not (written_half_failed / "net_2.vtu").exists()
    read = pd.read_csv(written_half_failed / "results.csv")
    assert read["drag_n"].notna().tolist() == [True, False]
    assert read["filled_meshes"].tolist() == [pytest.approx(4.0), 7.5]


@pytest.mark.parametrize("name", ["results.csv", "report.html"])
def test_a_number_nobody_computed_is_never_printed(written_half_failed: Path, name: str):
    if name.endswith("csv"):
        cells = (written_half_failed / name).read_text().replace("\n", ",").split(",")
    else:
        cells = list(cells_of(written_half_failed))
    assert not {cell.strip().lower() for cell in cells} & {"nan", "inf", "-inf", "none", "<na>"}


def test_a_study_of_which_nothing_was_solved_still_has_tables_and_a_page(study: Study, tmp_path: Path):
    nothing = Study(study.plan, study.choice, tuple(map(as_failed, study.cases)))
    written = write_report(nothing, tmp_path)
    assert {path.name for path in written} == {"plan.toml", "results.csv", "profile.csv", "run.json", "report.html"}
    assert pd.read_csv(tmp_path / "profile.csv").empty
    assert "data:image/png" not in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_files_of_an_earlier_study_do_not_stay_beside_those_of_this_one(half_failed: Study, tmp_path: Path):
    (tmp_path / "plots").mkdir()
    for name in ("net_2.vtu", "net_17.vtu", "meshes.csv", "net_mine.vtu", "notes.txt", "plots/mine.png"):
        (tmp_path / name).write_text("earlier")
    write_report(half_failed, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        *("plan.toml", "results.csv", "profile.csv", "run.json"),
        *("net_1.vtu", "net.pvd", "plots", "report.html", "net_mine.vtu", "notes.txt"),
        *([TURNING] if can_turn() else []),
    }
    assert (tmp_path / "plots" / "mine.png").exists()


def test_a_writer_that_fails_midway_leaves_no_half_file_and_the_old_one_untouched(tmp_path: Path):
    path = tmp_path / "table.csv"
    path.write_text("old")
    writing = whole_file(path)
    with pytest.raises(RuntimeError), writing as temporary:
        raise RuntimeError(temporary.write_text("ha"))
    assert [(found.name, found.read_text()) for found in tmp_path.iterdir()] == [("table.csv", "old")]


@pytest.mark.parametrize("broken", ["to_csv", "page_html", "net_mesh", "save"])
def test_a_report_that_breaks_off_leaves_only_whole_files(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, broken: str
):
    def half_then_fail(*args: object, **_: object) -> None:
        for target in args:
            if isinstance(target, Path):
                target.write_text("half")
        raise OSError(28, "No space left on device")

    owner = {
        "to_csv": "pandas.DataFrame.to_csv",
        "page_html": "codend.report.page.page_html",
        "net_mesh": "meshio.Mesh.write",
        "save": "PIL.Image.Image.save",
    }[broken]
    monkeypatch.setattr(owner, half_then_fail)
    with pytest.raises(OSError, match="No space"):
        write_report(study, tmp_path)
    for path in tmp_path.rglob("*"):
        assert path.is_dir() or path.read_bytes() != b"half"
        assert not path.name.endswith(".part")
    assert not (tmp_path / "report.html").exists()


def test_infinite_and_missing_numbers_are_empty_cells(tmp_path: Path):
    write_table(pd.DataFrame({"a": [1.0, np.nan], "b": [np.inf, 2.5]}), tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "a,b\n1,\n,2.5\n"


def test_the_picture_shows_the_middle_catch_at_the_first_speed(study: Study):
    first = study.cases[0]
    cases = tuple(
        replace(first, case=replace(first.case, number=number, speed_m_s=speed))
        for number, speed in enumerate([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0], start=1)
    )
    assert page.shown_case(replace(study, cases=cases)).case.number == 2
    assert page.shown_case(replace(study, cases=(as_failed(first), *cases[1:]))).case.number == 2
    assert page.shown_case(replace(study, cases=(*map(as_failed, cases[:3]), *cases[3:]))).case.number == 5


@pytest.mark.parametrize(
    ("speeds", "catches"), [([1.0], [4]), ([1.0, 1.3], [4]), ([1.0, 1.3], [4, 6])], ids=["one", "speeds", "both"]
)
def test_drag_is_drawn_for_any_mix_of_speeds_and_catches(speeds: list[float], catches: list[float]):
    from codend.report.drag_plot import drag_plot

    tow = {"speed_m_s": speeds, "water_density_kg_m3": 1000.0}
    study = solve(plan_from_dict({**PLAN, "tow": tow, "catch": {"filled_meshes": catches}}))
    axes = drag_plot(study).axes[0]
    if len(speeds) == len(catches) == 1:
        drawn = [bar.get_width() for bar in axes.patches]
    else:
        drawn = np.concatenate([np.asarray(line.get_ydata()) for line in axes.get_lines()]).tolist()
    expected = study.table[["drag_n", "catch_drag_n", "twine_drag_n"]].to_numpy().ravel()
    np.testing.assert_allclose(sorted(drawn), sorted(expected))


def test_curves_ahead_of_and_on_the_catch_meet_at_a_front_between_two_rows(study: Study):
    from codend.report.plots import curves_by_speed

    small, large = curves_by_speed(study)[1.0]
    for curve, filled in ((small, 4.0), (large, 7.5)):
        place = curve.meshes_from_entry
        assert curve.ahead(place)[-1] == curve.behind(place)[0] == pytest.approx(20.0 - filled)
        assert np.all(np.diff(np.concatenate([curve.ahead(place), curve.behind(place)[1:]])) > 0.0)


def test_figures_drawn_by_a_copy_of_the_process_are_those_drawn_here(study: Study, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(drawn_beside, "can_draw_beside", lambda: True)
    draw = partial(drag_plot, study)
    with drawn_beside.drawn_beside([draw, draw, lambda: 1 / 0, draw]) as next_picture:
        found = [next_picture() for _ in range(5)]
    with own_look():
        assert found == [png(draw()), png(draw()), None, None, None], (
            "all after a failure are drawn here, where it tells"
        )


def test_numbers_are_rounded_for_readers():
    assert [number_text(v) for v in (1813.37, 0.0352021, 1.0, 10.0, 0.0, -2.345)] == [
        *("1813", "0.0352", "1", "10", "0", "-2.35")
    ]
    assert column_text(np.array([3.585431, 0.0352, np.nan, -np.inf])) == ["3.585", "0.035", "", ""]
    assert column_text(np.array([np.nan])) == [""]
    assert column_text(np.array([0.0, 12345.6])) == ["0", "12346"]


def test_long_legends_name_both_ends():
    assert spread(3, 10) == [0, 1, 2]
    assert spread(31, 10)[0] == 0
    assert spread(31, 10)[-1] == 30
    assert len(set(spread(31, 10))) == 10


def test_the_answer_stands_first_with_the_digits_its_error_leaves_it(study: Study, written: Path):
    html = (written / "report.html").read_text(encoding="utf-8")
    first = study.cases[0].measures
    assert html.index('id="answer"') < html.index("<img") < html.index('id="results"')
    for value in (first.opening_ahead_deg, first.drag_n):
        assert f"<strong>{worth(value, 0.0)[0]}" in html


@pytest.mark.parametrize(
    ("value", "error", "told"),
    [
        (29.7813, 0.21, ("29.8", "0.2")),
        (827.84, 1e-7, ("827.8", "")),
        (7.413, 2.1, ("7", "2")),
        (57.64, 13.87, ("58", "14")),
        (9858.4, 312.0, ("9900", "300")),
        (0.0, 0.0, ("0.000", "")),
        (float("nan"), 1.0, ("", "")),
        (5.0, float("nan"), ("5.000", "")),
    ],
)
def test_numbers_are_rounded_to_what_they_are_worth(value, error, told):
    assert worth(value, error) == told


def test_the_page_printed_on_paper_loses_no_column(written: Path, tmp_path: Path):
    chromium, pypdf = shutil.which("chromium"), pytest.importorskip("pypdf")
    if chromium is None:
        pytest.skip("needs Chromium")
    words = [chromium, "--headless", "--no-sandbox", f"--user-data-dir={tmp_path}"]
    words += [f"--print-to-pdf={tmp_path / 'p.pdf'}", (written / "report.html").as_uri()]
    subprocess.run(words, check=True, capture_output=True)
    text = " ".join(" ".join(page.extract_text() for page in pypdf.PdfReader(tmp_path / "p.pdf").pages).split())
    table = pd.read_csv(written / "results.csv")
    for name, head in RESULT_HEADS.items():
        assert name not in table or table[name].isna().all() or head.name in text, name


def test_the_net_turns_on_a_page_that_needs_nothing_from_elsewhere(study: Study):
    pytest.importorskip("plotly")
    page = turning_page(study.cases[0], "a net")
    assert not re.search(r'<(?:script|link|img)[^>]+(?:src|href)="https?:', page)
    assert len(page) > 1_000_000
