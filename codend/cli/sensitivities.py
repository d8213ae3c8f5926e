"""The command ``codend sensitivities``: what every number of a plan does to what is told of it."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    import pandas as pd

    from catch_models.fish import Species
    from codend.plan.plan import Plan

MOST_DESIGNS = 1000
"""Of a study: a second each."""


@click.command(cls=SeveralPairs)
@click.argument("path", metavar="PLAN.toml|STUDY.toml")
@out_option
@click.option("--species", "files", multiple=True, metavar="FILE.toml", help="L50 and SR of it too. May be repeated.")
@set_option
@spreadsheet_options
def sensitivities(path: str, folder: Path, files: tuple[str, ...], changes: tuple[str, ...]) -> int:
    """Tell what every number of a plan does to drag, catch volume, opening and, with species, L50 and SR.

    Writes sensitivities.csv, a row a case, quantity and number, tornado.png and sensitivities.html into DIR.
    Derivatives are exact, by the tangent of every equilibrium; of counts they are differences of one. Of a STUDY.toml
    every design is asked, and where it has a table [uncertain], relative standard deviations of numbers, intervals.csv
    says how well drag, opening and L50 are known, and which number to measure better.
    """
    from codend.io.toml import read_toml
    from codend.report.sensitivity_page import FILES, better, told, write_sensitivities
    from codend.selectivity.escape.species import load_species
    from codend.studies.study_file import looks_like_a_plan

    data = read_toml(path, "plan or study file in TOML")
    species = [load_species(file) for file in files]
    uncertain: dict[str, float] = {}
    if looks_like_a_plan(data):
        designs = _of_plan(path, changes)
    else:
        if changes:
            raise InputError(
                OPTIONS, "--set", list(changes), "with a PLAN.toml; the designs of a study have tables set"
            )
        designs, uncertain, own = _of_study(data, path)
        species = species or own
    check_writable(folder, FILES)
    with shown_progress() as progress:
        found = [_asked(plan, told_ahead, species, uncertain, progress) for told_ahead, plan in designs]
    import pandas as pd

    table = pd.concat([one[0] for one in found], ignore_index=True)
    intervals = pd.concat([one[1] for one in found], ignore_index=True) if uncertain else None
    if table.empty:
        click.echo("codend: no case was solved", err=True)
        return NOT_CONVERGED
    with written_into(folder, FILES):
        title = str(data.get("title") or designs[0][1].title)
        written = write_sensitivities(title, table, intervals, folder)
    _, last = list(table.groupby([name for name in ("run", "case") if name in table], sort=False))[-1]
    for sentence in told(last):
        click.echo(sentence)
    for sentence in better(intervals) if intervals is not None else ():
        click.echo(sentence)
    click.echo(f"{len(written)} files written into {folder}; see {folder / 'sensitivities.html'}")
    missing = sum(len(plan.cases()) for _, plan in designs) - sum(one[2] for one in found)
    if missing:
        click.echo(f"{missing} cases were not solved, and are not in the table", err=True)
    return NOT_CONVERGED if missing else 0


def _of_plan(path: str, changes: Sequence[str]) -> "list[tuple[dict[str, Any], Plan]]":
    from codend.plan.plan import load_plan

    return [({}, load_plan(path, changes))]


def _of_study(
    data: dict[str, Any], path: str
) -> "tuple[list[tuple[dict[str, Any], Plan]], dict[str, float], list[Species]]":
    from codend.studies.study_file import study_from_dict

    study = study_from_dict(data, path)
    if len(study.designs) > MOST_DESIGNS:
        raise InputError(path, "vary", None, f"at most {MOST_DESIGNS} designs", f"makes {len(study.designs)} designs")
    found = []
    for number in range(1, len(study.designs) + 1):
        run = study.designs.run(number)
        ahead: dict[str, Any] = {"run": number} if len(study.designs) > 1 else {}
        if run.base.name:
            ahead["design"] = run.base.name
        found.append((ahead, run.plan()))
    return found, dict(study.uncertain), list(study.species)


def _asked(
    plan: "Plan", ahead: dict[str, Any], species: "Sequence[Species]", uncertain: dict[str, float], progress: Any
) -> "tuple[pd.DataFrame, pd.DataFrame, int]":
    """Sensitivities and intervals of a design, with columns that say which it is, and how many cases were solved."""
    from codend.studies.sensitivity.table import case_sensitivities, sensitivity_table
    from codend.studies.sensitivity.uncertain import interval_table

    cases = case_sensitivities(plan, species, None, progress)
    tables = sensitivity_table(cases), interval_table(cases, uncertain)
    for table in tables:
        for place, (name, value) in enumerate(ahead.items()):
            table.insert(place, name, value)
    return *tables, len(cases)
