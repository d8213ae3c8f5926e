"""The command ``codend sensitivities``: what every number of a plan does to what is told of it."""

from collections.abc import Sequence
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
from codend.cli.console import shown_progress
from codend.errors import OPTIONS, InputError

if TYPE_CHECKING:
    from codend.studies.study_file import StudyPlan


MOST_TOLD = 20
"""Intervals that are printed, those of the last cases."""


@click.command(cls=SeveralPairs)
@click.argument("path", metavar="PLAN.toml|STUDY.toml")
@out_option
@click.option("--species", "files", multiple=True, metavar="FILE.toml", help="L50 and SR of it too. May be repeated.")
@set_option
@click.option(
    "--workers", default=None, type=click.IntRange(1, 1024), help="Processes that solve a study. Left out: every core."
)
@spreadsheet_options
def sensitivities(
    path: str, folder: Path, files: tuple[str, ...], changes: tuple[str, ...], workers: int | None
) -> int:
    """Tell what every number of a plan does to drag, catch volume, opening and, with species, L50 and SR.

    Writes sensitivities.csv, a row a case, quantity and number, tornado.png and sensitivities.html into DIR.
    Derivatives are exact, by the tangent of every equilibrium; of counts they are differences of one. Of a STUDY.toml
    every design is asked, and where it has a table [uncertain], relative standard deviations of numbers, intervals.csv
    says how well drag, opening and L50 are known, and which number to measure better.
    """
    from codend.report.sensitivity_page import FILES, better, case_name, told, write_sensitivities
    from codend.selectivity.escape.species import load_species
    from codend.studies.sensitivity.of_designs import check_count, of_designs
    from codend.studies.workers import cores

    species = [load_species(file) for file in files]
    title, study = _study_of(path, changes)
    check_count(study)
    check_writable(folder, FILES)
    with shown_progress() as progress:
        progress(0, len(study.designs), "solving")
        found = of_designs(study, species or study.species, None, workers or cores(), progress)
    table, intervals = found.sensitivities, found.intervals if study.uncertain else None
    if table.empty:
        click.echo("no case was solved", err=True)
        return NOT_CONVERGED
    with written_into(folder, FILES):
        written = write_sensitivities(title, table, intervals, folder)
    cases = list(table.groupby([name for name in ("run", "case") if name in table], sort=False))
    _, last = cases[-1]
    if len(cases) > 1:
        click.echo(f"In {case_name(last)}:")
    for sentence in (*told(last), *(better(intervals)[-MOST_TOLD:] if intervals is not None else ())):
        click.echo(sentence)
    click.echo(f"{len(written)} files written into {folder}; see {folder / 'sensitivities.html'}")
    if found.missing:
        click.echo(f"{found.missing} cases were not solved, and are not in the table", err=True)
    return NOT_CONVERGED if found.missing else 0


def _study_of(path: str, changes: Sequence[str]) -> "tuple[str, StudyPlan]":
    """The title and the designs of a study, or of a plan as the only one."""
    from codend.io.toml import read_toml
    from codend.plan.overrides import apply_overrides
    from codend.plan.plan import plan_from_dict
    from codend.studies.designs import Base, Designs
    from codend.studies.study_file import StudyPlan, looks_like_a_plan, study_from_dict

    data = read_toml(path, "plan or study file in TOML")
    if looks_like_a_plan(data):
        changed = apply_overrides(data, changes, path)
        plan = plan_from_dict(changed, path)
        return plan.title, StudyPlan(path, Designs((Base("", changed, path),)), ())
    if changes:
        allowed = "with a PLAN.toml; the designs of a study have tables set"
        raise InputError(OPTIONS, "--set", list(changes), allowed)
    return str(data.get("title", Path(path).stem)), study_from_dict(data, path)
