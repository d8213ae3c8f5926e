"""The command ``codend sweep``: studies over many plans."""

from pathlib import Path

import click

from codend.cli.common import NOT_CONVERGED, SeveralPairs, check_writable, out_option, set_option, written_into
from codend.cli.console import shown_progress, text_table

SUMMARY = {
    "cases": ("converged", "size"),
    "solved": ("converged", "sum"),
    "least drag N": ("drag_n", "min"),
    "most drag N": ("drag_n", "max"),
    "least opening deg": ("opening_ahead_deg", "min"),
    "most opening deg": ("opening_ahead_deg", "max"),
}
"""What is printed of every run: heading, column of ``results.csv``, and what of it."""


@click.command(cls=SeveralPairs)
@click.argument("plan", metavar="PLAN.toml")
@out_option
@click.option(
    "--vary",
    multiple=True,
    required=True,
    metavar="KEY=[VALUE,...]",
    help="Values a key is to take, such as --vary netting.0.bar_mm=[20,25,30]. May be repeated: all combinations.",
)
@set_option
@click.option("--processes", default=1, show_default=True, type=click.IntRange(1, 64), help="Runs solved at once.")
def sweep(plan: str, folder: Path, vary: tuple[str, ...], changes: tuple[str, ...], processes: int) -> int:
    """Solve a plan with every combination of some values.

    Writes sweep.csv (results.csv of all runs with columns for what varies) and sweep.png into DIR, and every run's
    plan and tables into DIR/runs/NUMBER, where `codend selectivity` and `codend compare` take them. A sweep that was
    interrupted goes on where it stopped: runs that DIR holds already are not solved again, unless the program, a file
    that the plan names or the run's tables have changed. Runs that a longer sweep left in DIR/runs are removed.
    """
    from codend.io.files import whole_file, write_table
    from codend.report.own_look import own_look
    from codend.report.style import png
    from codend.report.sweep_plot import sweep_figure
    from codend.studies.sweep import files_of, runs_of, solve_runs, why_again

    runs = runs_of(plan, vary, changes)
    check_writable(folder, ("sweep.csv", "sweep.png", *files_of(runs)))
    for reason, numbers in why_again(runs, folder).items():
        which = f"run {numbers[0]} is" if len(numbers) == 1 else f"runs {', '.join(map(str, numbers))} are"
        click.echo(f"{which} solved again: {reason}", err=True)
    with shown_progress() as progress, written_into(folder, ("sweep.csv", "sweep.png")):
        table = solve_runs(runs, folder, processes, progress)
        write_table(table, folder / "sweep.csv")
        with whole_file(folder / "sweep.png") as temporary, own_look():
            temporary.write_bytes(png(sweep_figure(table, {run.number: run.label for run in runs})))
    keys = list(runs[0].values)
    summary = table.groupby(["run", *keys], sort=False).agg(**SUMMARY).reset_index()
    click.echo(text_table(["run", *keys, *SUMMARY], summary.itertuples(index=False)))
    click.echo(f"{len(runs)} runs, {len(table)} cases in {folder / 'sweep.csv'}; see {folder / 'sweep.png'}")
    for case in table[~table["converged"]].itertuples():
        click.echo(f"run {case.run}, case {case.case} was not solved: codend run its plan.toml says why", err=True)
    return 0 if table["converged"].all() else NOT_CONVERGED
