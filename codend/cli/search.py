"""The command ``codend search``: the least change of a plan that reaches a target."""

from pathlib import Path

import click

from codend.cli.common import NOT_CONVERGED, check_writable, out_option, spreadsheet_options, written_into
from codend.cli.console import shown_progress, text_table


@click.command()
@click.argument("study", metavar="STUDY.toml")
@out_option
@spreadsheet_options
def search(study: str, folder: Path) -> int:
    """Look for the least change of a plan that reaches a target.

    A STUDY.toml names a plan, species where L50 is asked, and in its table [search] the numbers that may change, the
    target (an opening, L50, a drag, at given catches) and limits. Counts stay whole. Writes the plan found, with the
    target's catches, as plan.toml, search.csv, every design that was looked at, and search.html, a page with its figure
    search.png, into DIR. Status 3 where no design within the limits reaches the target.
    """
    from codend.report.search_page import FILES, write_search
    from codend.studies.search.asked import asked_of
    from codend.studies.search.search import search as look
    from codend.studies.search.table import ended
    from codend.studies.study_file import load_study

    asked = asked_of(load_study(study))
    check_writable(folder, FILES)
    with shown_progress() as progress:
        found = look(asked, progress)
    with written_into(folder, FILES):
        write_search(asked.plan.title, found, folder)
    shown = [("as it is", found.start), ("found", found.best), ("nearest", None if found.best else found.nearest)]
    rows = [
        (name, case, *design.values.values(), *told.values())
        for name, design in shown
        if design is not None
        for case, told in enumerate(design.told, start=1)
    ]
    click.echo(text_table(["design", "case", *found.start.values, *found.start.told[0]], rows))
    for sentence in ended(found):
        click.echo(sentence, err=found.best is None)
    page = folder / "search.html"
    if found.best is None:
        click.echo(f"see {page}")
        return NOT_CONVERGED
    click.echo(f"{folder / 'plan.toml'} is the plan, {folder / 'search.csv'} what was looked at; see {page}")
    return 0
