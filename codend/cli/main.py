"""The command line: parse, call, print. Heavy libraries are imported where a command uses them: help is quick."""

import atexit
import gc
import sys
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from codend.cli.bow_wave import bow_wave
from codend.cli.chart import chart
from codend.cli.common import (
    BAD_INPUT,
    INTERRUPTED,
    NO_MEANS,
    NOT_CONVERGED,
    SeveralPairs,
    Stopped,
    check_writable,
    explain_failures,
    out_option,
    set_option,
    spreadsheet_options,
    written_into,
)
from codend.cli.compare import compare
from codend.cli.console import shown_progress, text_table
from codend.cli.fit import fit
from codend.cli.force import force
from codend.cli.guide import guide
from codend.cli.net_plan import net_plan
from codend.cli.scene import scene
from codend.cli.search import search
from codend.cli.selectivity import selectivity, species
from codend.cli.sensitivities import sensitivities
from codend.cli.streams import Terminated, end_on_signals, give_up_output, say, take_any_text
from codend.cli.sweep import sweep
from codend.cli.tables import tables
from codend.errors import InputError, TooLittleMemory

if TYPE_CHECKING:
    from codend.studies.kept_cases import KeptCases

TABLE_COLUMNS = {
    "case": "case",
    "speed_m_s": "speed m/s",
    "filled_meshes": "filled meshes",
    "catch_volume_m3": "volume m3",
    "max_radius_m": "radius m",
    "drag_n": "drag N",
    "opening_ahead_deg": "opening deg",
    "opening_ahead_error_deg": "+- deg",
    "residual": "residual",
    "converged": "solved",
}
"""Columns of ``results.csv`` that ``codend run`` prints, and their headings."""


class _OneLineErrors(click.Group):
    """A group whose commands return an exit status, and which reports what a user can mend, a line each."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except Terminated as request:
            _end("terminated", 128 + request.args[0])
        except KeyboardInterrupt:
            _end("interrupted", INTERRUPTED)
        except EOFError as error:  # click takes it for Ctrl-C; nothing here reads from a terminal
            raise RuntimeError("a file ended too early") from error

    def main(self, *args: Any, **kwargs: Any) -> NoReturn:
        _make_haste()
        take_any_text()
        end_on_signals()
        try:
            status = super().main(*args, **{**kwargs, "standalone_mode": False})
        except Stopped as error:
            _end(error.format_message(), error.status)
        except click.ClickException as error:
            _end(" ".join(error.format_message().split()), BAD_INPUT)
        except InputError as error:
            _end("\n".join(error.lines), BAD_INPUT)
        except TooLittleMemory as error:
            _end(f"too little memory: {error}", NO_MEANS)
        except MemoryError:
            _end("too little memory", NO_MEANS)
        except BrokenExecutor:
            _end("a process that solved was killed, most likely for want of memory; what is solved is kept", NO_MEANS)
        except click.Abort:
            _end("interrupted", INTERRUPTED)
        except OSError as error:
            give_up_output()
            what = "standard output" if error.filename is None else str(error.filename)
            _end(f"{what}: {error.strerror or error}", NO_MEANS)
        raise SystemExit(status or 0)


def _make_haste() -> None:
    """Settings of the interpreter that suit a short command.

    Hardly look for cycles to free while it runs, nor at its end: most of what there is was made by libraries as they
    were imported, and stays; that took a fifth of a run. Let threads that compress files take their turn at once.
    """
    gc.set_threshold(500_000)
    atexit.register(gc.freeze)
    sys.setswitchinterval(1e-4)


def _end(message: str, status: int) -> NoReturn:
    for line in message.splitlines():
        say(f"codend: {' '.join(line.split())}")
    raise SystemExit(status)


def _print_version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted:
        from codend.cli.doctor import version_of

        click.echo(f"codend {version_of('codend') or 'not installed, run from its source'}")
        ctx.exit()


@click.group(cls=_OneLineErrors, invoke_without_command=True)
@click.option("--version", is_flag=True, is_eager=True, expose_value=False, callback=_print_version, help="Show it.")
@click.pass_context
def main(ctx: click.Context) -> None:
    """Shape, drag, mesh opening and selectivity of towed trawl codends.

    Exit status: 0 when all went well, 1 for want of memory or of an output that can be written, 2 for bad input (one
    line says what), 3 when something did not converge, 130 when interrupted.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


@main.command(cls=SeveralPairs)
@click.argument("plan", metavar="PLAN.toml")
@out_option
@set_option
@spreadsheet_options
def run(plan: str, folder: Path, changes: tuple[str, ...]) -> int:
    """Solve every case of a plan; write tables, plots, VTK files and a report into DIR.

    Cases are kept in the tables as they are solved, and the report comes last: it is there only where all that it
    tells of is. From a DIR that exists an earlier run is removed as the first case comes; all else is left alone.
    """
    from codend.plan.plan import load_plan

    checked = load_plan(plan, changes)
    from codend.bag.loads import pressure_law_of
    from codend.equilibrium.fidelity import choose
    from codend.report.choice_words import reason_text
    from codend.report.drawn_beside import can_draw_beside
    from codend.report.html import cautions, sea_water
    from codend.report.own_look import load_quickly
    from codend.report.page import files_of, write_report
    from codend.report.size_words import derived_sizes
    from codend.studies.kept_cases import KeptCases
    from codend.studies.run_record import unfinished
    from codend.studies.study import solve

    pressure_law_of(checked)  # a Cp curve that cannot be used is refused before anything is said
    check_writable(folder, files_of(checked))

    with shown_progress() as progress:
        progress(0, len(checked.cases()), "choosing the model")
        choice = choose(checked)
    click.echo(reason_text(choice))
    if checked.water_is_assumed:
        click.echo(sea_water(checked))
    for sentence in derived_sizes(checked):
        click.echo(sentence)
    if (before := unfinished(folder)) is not None:
        click.echo(f"{folder} held {before} of a run that did not end; this one takes its place", err=True)
    with shown_progress() as progress, written_into(folder), KeptCases(checked, choice, folder) as kept:
        with _told_what_is_kept(kept, len(checked.cases()), folder / "results.csv"):
            study = solve(checked, progress, choice, kept.add)
        if not can_draw_beside():
            load_quickly()
        written = write_report(study, folder, progress, copied=True)
    click.echo(text_table(list(TABLE_COLUMNS.values()), study.table[list(TABLE_COLUMNS)].itertuples(index=False)))
    click.echo(f"{len(written)} files written into {folder}; see {folder / 'report.html'}")
    for caution in cautions(study):
        click.echo(caution, err=True)
    explain_failures(study)
    return 0 if study.converged else NOT_CONVERGED


@contextmanager
def _told_what_is_kept(kept: "KeptCases", cases: int, table: Path) -> Iterator[None]:
    """Say on one line, where solving ends early, which cases are kept all the same."""
    try:
        yield
    except (KeyboardInterrupt, MemoryError, Exception) as error:
        told = f"{kept.count} of {cases} cases were solved and are in {table}" if kept.count else "no case was solved"
        match error:
            case Terminated():
                raise Stopped(f"terminated; {told}", 128 + error.args[0]) from None
            case KeyboardInterrupt():
                raise Stopped(f"interrupted; {told}", INTERRUPTED) from None
            case MemoryError():
                why = f": {error}" if isinstance(error, TooLittleMemory) else ""
                raise Stopped(f"too little memory{why}; {told}", NO_MEANS) from None
            case InputError() | OSError():
                raise
        say(f"codend: an error of the program; {told}")
        raise


@main.command()
@click.option("--warm-up", is_flag=True, help="Compile all kernels now, by solving a tiny net.")
def doctor(warm_up: bool) -> int:
    """Show what is installed and what this machine offers, and remove damaged files of the compiled kernels.

    Status 1 when a needed package is missing or does not work.
    """
    from codend.cli import doctor as examination

    failed = False
    if warm_up:
        try:
            click.echo(examination.warm_up())
        except Exception as error:  # what follows may say why
            say(f"codend: kernels cannot be compiled: {type(error).__name__}: {' '.join(str(error).split())}")
            failed = True
    findings = examination.examine()
    click.echo(text_table(["what", "found"], [(finding.topic, finding.found) for finding in findings]))
    return 1 if failed or any(finding.missing for finding in findings) else 0


for _command in (
    bow_wave,
    net_plan,
    scene,
    sweep,
    search,
    sensitivities,
    tables,
    compare,
    chart,
    force,
    selectivity,
    species,
    fit,
    guide,
):
    main.add_command(_command)


if __name__ == "__main__":
    main()
