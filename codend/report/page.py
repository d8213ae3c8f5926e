"""Everything a study leaves in its folder."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from codend.io.files import write_bytes, write_table, write_text
from codend.plan.copy import plan_toml
from codend.plan.kinds import kinds_in_words
from codend.plan.plan import Plan
from codend.report.drag_plot import drag_plot
from codend.report.drawn_beside import drawn_beside
from codend.report.html import PageFigure, page_html
from codend.report.own_look import own_look
from codend.report.picture import net_picture
from codend.report.plots import (
    catch_text,
    layers_plot,
    opening_force_plot,
    opening_plot,
    profiles_plot,
    solved,
    tension_plot,
)
from codend.report.style import number_text, png
from codend.report.turning_net import TURNING, can_turn, turning_page
from codend.report.vtk import write_series, write_vtu
from codend.studies.case_result import CaseResult
from codend.studies.run_record import RECORD, SERIES, TABLES, inputs_of, remove_run, write_record
from codend.studies.study import Study, StudyProgress

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Plot:
    """A plot of a study: ``plots/<name>.png`` and its place on the page."""

    name: str
    draw: Callable[[Study], "Figure"]
    caption: Callable[[Study], str]
    fits: Callable[[Study], bool] = lambda _: True
    """Whether there is anything to draw."""


def shown_case(study: Study) -> CaseResult:
    """The case the picture of the net shows: the middle one of those solved at the first speed."""
    cases = [result for result in solved(study) if result.case.speed_m_s == solved(study)[0].case.speed_m_s]
    return cases[(len(cases) - 1) // 2]


def _net_caption(study: Study) -> str:
    shown = shown_case(study)
    catch = catch_text(shown.measures.catch_volume_m3, study.plan.catch_density_kg_m3)
    g = f"{shown.bag.globalisation:.3g}"
    merged = f" One mesh drawn stands for {g} x {g} real ones." if shown.bag.globalisation > 1 else ""
    layers = " Dark lines are the bars of second layers." if shown.bag.layer_bands else ""
    return (
        f"The net with {catch} of catch at {number_text(shown.case.speed_m_s)} m/s (case {shown.case.number}), "
        f"every mesh coloured by its opening angle.{merged}{layers}"
    )


PLOTS = (
    Plot("net", lambda study: net_picture(shown_case(study)), _net_caption),
    Plot("profiles", profiles_plot, lambda _: "Profiles of the codend, to scale."),
    Plot(
        "opening",
        opening_plot,
        lambda _: "Opening angle of the meshes along the codend: 0° is a closed mesh, 90° one as wide as it is long.",
    ),
    Plot(
        "opening_force",
        opening_force_plot,
        lambda _: (
            "Opening force of the meshes ahead of the catch, each taken as isolated: the extra pull across its "
            "short diagonal that opens it to 30°. Below zero it is wider open already. "
            f"{kinds_in_words(lambda kind: not kind.opens).capitalize()} mesh has none."
        ),
        lambda study: any(section.kind.opens for section in study.plan.netting),
    ),
    Plot(
        "tension",
        tension_plot,
        lambda _: "Tension of the bars along the codend, mean of each row; single bars at a joint may carry more.",
    ),
    Plot(
        "layers",
        layers_plot,
        lambda _: (
            "Second layers: opening angle of their own meshes, and the share of the hoop load that they carry beside "
            "the netting below; both along that netting."
        ),
        lambda study: bool(study.plan.layer),
    ),
    Plot("drag", drag_plot, lambda _: "Drag of the codend, and the parts that the catch and the twine have in it."),
)


def files_of(plan: Plan) -> list[str]:
    """Every file that ``write_report`` may write of a plan, relative to its folder."""
    nets = [f"net_{case.number}.vtu" for case in plan.cases()]
    plots = [f"plots/{plot.name}.png" for plot in PLOTS]
    left_out = {"ropes.csv": not plan.ropes, "layers.csv": not plan.layer, "plots/layers.png": not plan.layer}
    some = [name for name in (*TABLES, RECORD, *plots) if not left_out.get(name, False)]
    return ["plan.toml", *some, *nets, SERIES, *([TURNING] if can_turn() else []), "report.html"]


def write_report(study: Study, folder: Path, progress: StudyProgress | None = None, copied: bool = False) -> list[Path]:
    """Write tables, VTK files, plots and the page of a study into a folder, which is made when it is not there.

    ``plan.toml``, the plan as it was solved; ``results.csv`` and ``profile.csv``; ``meshes.csv`` for models more than
    one mesh wide; ``net_<case>.vtu`` for every solved case, strung together by ``net.pvd``;
    ``plots/*.png`` when a case was solved; ``net.html``, which turns under the mouse, where Plotly is installed;
    ``report.html``.
    Each file appears whole or not at all. What an earlier study left goes first, its page before
    all else, and so does what ``codend selectivity`` and ``codend compare`` made of it; ``run.json``, with digests of
    the tables, comes after these, and the page comes last and bears its name: whatever ends the writing, a page is of
    the tables beside it.

    Args:
        study: what to write; its cases that were not solved are listed as such, without numbers.
        folder: where to write.
        progress: told how many files are done, of how many, and which is being written.
        copied: let a copy of this process draw, where it can be copied: a program whose threads hold no locks.

    Returns:
        The files written.

    Raises:
        OSError: a file cannot be written.
    """
    drawn = [plot for plot in PLOTS if solved(study) and plot.fits(study)]
    beside = ThreadPoolExecutor(1)
    try:
        with drawn_beside([partial(plot.draw, study) for plot in drawn] if copied else []) as next_picture:
            return _write_files(study, folder, drawn, next_picture, beside, progress)
    finally:
        beside.shutdown(cancel_futures=True)  # of files not yet begun when one cannot be written


def _write_files(
    study: Study,
    folder: Path,
    drawn: Sequence[Plot],
    next_picture: Callable[[], bytes | None],
    beside: Executor,
    progress: StudyProgress | None,
) -> list[Path]:
    figures: dict[str, PageFigure] = {}
    begun: dict[int, Future[None]] = {}
    run = ""

    def write_plot(plot: Plot, path: Path) -> None:
        picture = next_picture()
        if picture is None:
            with own_look():
                picture = png(plot.draw(study))
        figures[plot.name] = PageFigure(picture, plot.caption(study))
        write_bytes(picture, path)

    def write_page(path: Path) -> None:
        turning = TURNING if folder / TURNING in writers else ""
        write_text(page_html(study, list(figures.values()), run, turning), path)

    def write_run(_: Path) -> None:
        nonlocal run
        run = write_record(folder, inputs_of(study.plan))
        # VTK files take compression for the most part, which lets this thread make plots; then it helps
        for result in solved(study):
            begun[result.case.number] = beside.submit(write_vtu, result, net_path(result))

    def write_net(result: CaseResult, path: Path) -> None:
        """Wait for the file when another thread has begun it, or write it here."""
        if begun[result.case.number].cancel():
            write_vtu(result, path)
        else:
            begun[result.case.number].result()

    def net_path(result: CaseResult) -> Path:
        return folder / f"net_{result.case.number}.vtu"

    folder.mkdir(parents=True, exist_ok=True)
    copy = plan_toml(study.plan)
    remove_run(folder, but_tables_of=copy)
    tables = study.tables
    writers: dict[Path, Callable[[Path], None]] = {folder / "plan.toml": partial(write_text, copy)}
    for name in TABLES:
        if name in tables:
            writers[folder / name] = partial(write_table, tables[name])
        else:
            (folder / name).unlink(missing_ok=True)
    writers[folder / RECORD] = write_run
    writers |= {folder / "plots" / f"{plot.name}.png": partial(write_plot, plot) for plot in drawn}
    # the other thread comes from the first
    writers |= {net_path(result): partial(write_net, result) for result in reversed(solved(study))}
    if shown := solved(study):
        numbers = [result.case.number for result in shown]
        nets = [f"net_{number}.vtu" for number in numbers]
        writers[folder / SERIES] = partial(write_series, nets, numbers)
        if can_turn():
            case = shown_case(study)
            title = f"{study.plan.title}, case {case.case.number}"
            writers[folder / TURNING] = lambda path: write_text(turning_page(case, title), path)
    writers[folder / "report.html"] = write_page
    for done, (path, write) in enumerate(writers.items()):
        if progress is not None:
            progress(done, len(writers), f"writing {path.name}")
        path.parent.mkdir(exist_ok=True)
        write(path)
    return list(writers)
