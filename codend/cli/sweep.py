"""The command ``codend sweep``: studies over many plans."""

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codend.cli.common import (
    NOT_CONVERGED,
    SeveralPairs,
    check_writable,
    out_option,
    set_option,
    spreadsheet_options,
    written_into,
)
from codend.cli.console import shown_progress, text_table
from codend.errors import OPTIONS, InputError
from codend.io.columns import error_of

if TYPE_CHECKING:
    import pandas as pd

SUMMARY = {
    "cases": ("converged", "size"),
    "solved": ("converged", "sum"),
    "least drag N": ("drag_n", "min"),
    "most drag N": ("drag_n", "max"),
    "largest error N": ("drag_error_n", "max"),
    "least opening deg": ("opening_ahead_deg", "min"),
    "most opening deg": ("opening_ahead_deg", "max"),
    "largest error deg": ("opening_ahead_error_deg", "max"),
}
"""What is printed of every run: heading, column of ``results.csv``, and what of it."""
OF_A_CASE = {
    "drag_n": ("drag N", "+- N"),
    "opening_ahead_deg": ("opening deg", "+- deg"),
    "l50_cm": ("L50 cm", "+- cm"),
}
"""What is printed of runs of one case, and its error."""
MOST_PRINTED = 30
"""Runs of a study that are printed each; of more, all in one."""
MOST_TOLD = 10
"""Cases not solved that are told each."""
FILES = ("sweep.csv", "sweep.png")
OF_UNCERTAIN = ("sensitivities.csv", "intervals.csv")
"""What a study with a table [uncertain] writes besides."""


@click.command(cls=SeveralPairs)
@click.argument("study", metavar="STUDY.toml|PLAN.toml")
@out_option
@click.option(
    "--vary",
    multiple=True,
    metavar="KEY=[VALUE,...]",
    help="Values a key of a PLAN is to take, such as --vary netting.0.bar_mm=[20,25,30]. May be repeated: all "
    "combinations.",
)
@set_option
@click.option(
    "--workers",
    "--processes",
    "workers",
    default=None,
    type=click.IntRange(1, 1024),
    help="Processes that solve. Left out: one for every core.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Of a Dask cluster that solves a STUDY instead.")
@spreadsheet_options
def sweep(
    study: str,
    folder: Path,
    vary: tuple[str, ...],
    changes: tuple[str, ...],
    workers: int | None,
    scheduler: str | None,
) -> int:
    """Solve many designs: those of a study, or a plan with every combination of some values.

    A STUDY.toml names a plan or several designs, what varies (lists, ranges, linked keys, samples) and species, whose
    L50 and SR become columns. Writes sweep.csv, a row a case, sweep.png, and study.html with responses, maps over two
    numbers and drag against L50 into DIR, plans of the best designs into DIR/best, and DIR/parts, the same table in
    Parquet, part by part as it is solved.

    A table [uncertain] in the study, relative standard deviations of numbers, has intervals of drag, opening and L50 of
    every design written, and which number to measure better: intervals.csv, from sensitivities.csv.

    With --vary, writes sweep.csv and sweep.png into DIR, and every run's plan and tables into DIR/runs/NUMBER, where
    `codend selectivity` and `codend compare` take them; runs that a longer sweep left there are removed.

    A sweep that was interrupted goes on where it stopped: what DIR holds already is not solved again, unless the
    program, the study, a file that it names or what was written has changed.
    """
    from codend.studies.workers import cores, one_thread_each

    many = workers or cores()
    with one_thread_each() if many > 1 else nullcontext():
        return _sweep(study, folder, vary, changes, many, scheduler)


def _sweep(
    study: str, folder: Path, vary: Sequence[str], changes: Sequence[str], many: int, scheduler: str | None
) -> int:
    if vary:
        if scheduler is not None:
            raise InputError(OPTIONS, "--scheduler", scheduler, "with a STUDY.toml, without --vary")
        return _sweep_of_plan(study, folder, vary, changes, many)
    if changes:
        allowed = "together with --vary; the designs of a study have tables set"
        raise InputError(OPTIONS, "--set", list(changes), allowed)
    return _sweep_of_study(study, folder, many, scheduler)


def _sweep_of_study(path: str, folder: Path, workers: int, scheduler: str | None) -> int:
    from codend.io.files import write_bytes, write_table
    from codend.io.toml import read_toml
    from codend.report.own_look import own_look
    from codend.report.study_page import BEST, FIGURES, PAGE, remove_study, write_study
    from codend.report.style import png
    from codend.report.sweep_plot import MOST_DRAWN, sweep_figure
    from codend.studies.many import solve_parts
    from codend.studies.parts import FOLDER, read_parts, write_csv
    from codend.studies.sensitivity.of_designs import check_count, of_designs
    from codend.studies.study_file import looks_like_a_plan, study_from_dict

    data = read_toml(path, "study file in TOML")
    if looks_like_a_plan(data):
        raise InputError(path, "", None, "a study file, or --vary KEY=[VALUE,...] with a plan", "is a plan")
    study = study_from_dict(data, path)
    study.designs.check_any()
    if study.uncertain:
        check_count(study)
    check_writable(
        folder, (*FILES, *OF_UNCERTAIN, *FIGURES, PAGE, f"{BEST}/run_1.toml", f"{FOLDER}/part-000000.parquet")
    )
    with shown_progress() as progress, written_into(folder, (*FILES, *OF_UNCERTAIN)):
        remove_study(folder)
        parts = solve_parts(study, folder, workers, scheduler, progress)
        write_csv(parts, folder / "sweep.csv")
        table = read_parts(parts)
        runs = study.designs.some(MOST_DRAWN)
        with own_look():
            write_bytes(png(sweep_figure(table, {run.number: run.label for run in runs})), folder / "sweep.png")
        intervals = None
        if study.uncertain:
            found = of_designs(study, study.species, list(study.uncertain), workers, progress)
            write_table(found.sensitivities, folder / OF_UNCERTAIN[0])
            write_table(found.intervals, folder / OF_UNCERTAIN[1])
            intervals = found.intervals
        title = str(data.get("title", Path(path).stem))
        written = write_study(title, table, lambda number: study.designs.run(number).plan(), folder, intervals)
    keys = [name for name in table.columns[: list(table.columns).index("case")] if name != "run"]
    if len(study.designs) <= MOST_PRINTED:
        _print_runs(table, keys)
    else:
        click.echo(text_table(list(SUMMARY), [[table[of].agg(how) for of, how in SUMMARY.values()]]))
    see = folder / (PAGE if PAGE in written else "sweep.png")
    click.echo(f"{len(study.designs)} runs, {len(table)} cases in {folder / 'sweep.csv'}; see {see}")
    failed = table[~table["converged"].astype(bool)]
    for row in failed.head(MOST_TOLD).to_dict("records"):
        case = "" if row["case"] != row["case"] else f", case {row['case']:g}"
        click.echo(f"run {row['run']}{case} was not solved: {row['reason']}", err=True)
    if len(failed) > MOST_TOLD:
        click.echo(f"and {len(failed) - MOST_TOLD} more, each with its reason in sweep.csv", err=True)
    return NOT_CONVERGED if len(failed) else 0


def _sweep_of_plan(plan: str, folder: Path, vary: Sequence[str], changes: Sequence[str], workers: int) -> int:
    from codend.io.files import write_bytes, write_table
    from codend.report.own_look import own_look
    from codend.report.style import png
    from codend.report.sweep_plot import sweep_figure
    from codend.studies.sweep import files_of, runs_of, solve_runs, why_again

    runs = runs_of(plan, vary, changes)
    check_writable(folder, (*FILES, *files_of(runs)))
    for reason, numbers in why_again(runs, folder).items():
        which = f"run {numbers[0]} is" if len(numbers) == 1 else f"runs {', '.join(map(str, numbers))} are"
        click.echo(f"{which} solved again: {reason}", err=True)
    with shown_progress() as progress, written_into(folder, FILES):
        table = solve_runs(runs, folder, workers, progress)
        write_table(table, folder / "sweep.csv")
        with own_look():
            write_bytes(png(sweep_figure(table, {run.number: run.label for run in runs})), folder / "sweep.png")
    _print_runs(table, list(runs[0].values))
    click.echo(f"{len(runs)} runs, {len(table)} cases in {folder / 'sweep.csv'}; see {folder / 'sweep.png'}")
    for case in table[~table["converged"]].itertuples():
        click.echo(f"run {case.run}, case {case.case} was not solved: codend run its plan.toml says why", err=True)
    return 0 if table["converged"].all() else NOT_CONVERGED


def _print_runs(table: "pd.DataFrame", keys: list[str]) -> None:
    if len(table) > table["run"].nunique():
        summary = table.groupby(["run", *keys], sort=False, dropna=False).agg(**SUMMARY).reset_index()
        click.echo(text_table(["run", *keys, *SUMMARY], summary.itertuples(index=False)))
        return
    told = [name for name in table.columns if name.partition(" ")[0] in OF_A_CASE]
    names = [column for name in told for column in (name, error_of(name))]
    heads = [f"{head} {name.partition(' ')[2]}".strip() for name in told for head in OF_A_CASE[name.partition(" ")[0]]]
    shown = table[["run", *keys, *names]]
    click.echo(text_table(["run", *keys, *heads], shown.itertuples(index=False)))
