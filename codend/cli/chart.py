"""The command ``codend chart``: speed against accuracy."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from codend.cli.common import NOT_CONVERGED, SeveralPairs, check_writable, out_option, set_option, written_into
from codend.cli.console import shown_progress, text_table

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = {
    "accuracy": "error in drag",
    "fastest": "fastest",
    "fastest_ms": "ms",
    "fastest_error": "its error",
    "chosen": "chosen automatically",
    "chosen_ms": "ms",
    "chosen_drag_error": "its error",
}
"""Columns of the choices that are printed, and their headings."""


@click.command(cls=SeveralPairs)
@click.argument("plan", metavar="PLAN.toml")
@out_option
@click.option("--case", "number", default=1, show_default=True, type=click.IntRange(1), help="Case of the plan.")
@click.option("--quick", is_flag=True, help="Fewer settings, timed twice at most.")
@set_option
def chart(plan: str, folder: Path, number: int, quick: bool, changes: tuple[str, ...]) -> int:
    """Chart speed against accuracy for one case of a plan.

    Solves it by every method and model, measures errors against an answer converged far beyond, and says which is
    fastest for which accuracy and what `codend run` would choose. What the plan says of fidelity and method does not
    matter here. Writes chart.csv, chart_choices.csv, chart_drag.png, chart_opening.png and chart_volume.png into DIR.
    """
    from codend.io.files import write_bytes, write_table
    from codend.report.own_look import own_look
    from codend.report.speed_plot import speed_figure
    from codend.report.style import png
    from codend.studies.speed_accuracy.choices import choices
    from codend.studies.speed_accuracy.contenders import scene_from
    from codend.studies.speed_accuracy.measuring import QUANTITIES, measure

    scene = scene_from(plan, changes, number)
    pictures = {short: f"chart_{short}.png" for short in QUANTITIES.values()}
    check_writable(folder, ("chart.csv", "chart_choices.csv", *pictures.values()))
    with shown_progress() as progress:
        try:
            measured = measure(scene, quick, progress)
        except RuntimeError as error:
            click.echo(f"codend: {error}", err=True)
            return NOT_CONVERGED
    chosen = choices(measured)
    with written_into(folder, ("chart.csv", "chart_choices.csv", *pictures.values())):
        write_table(measured.points, folder / "chart.csv")
        write_table(chosen, folder / "chart_choices.csv")
        for short, picture in pictures.items():
            with own_look():
                write_bytes(png(speed_figure((measured,), short)), folder / picture)
    click.echo(text_table(list(COLUMNS.values()), chosen[list(COLUMNS)].itertuples(index=False)))
    click.echo(_confirmed(measured.confirmations))
    click.echo(f"{len(measured.points)} answers in {folder / 'chart.csv'}; see {folder / 'chart_drag.png'}")
    return 0


def _confirmed(confirmations: "pd.DataFrame") -> str:
    """What stands behind the answer that errors are measured against."""
    if confirmations.empty:
        return "No second method confirms the answer that errors are measured against."
    found = (f"{row.model} by {row.method} within {row.drag:.1e}" for row in confirmations.itertuples())
    return f"Errors are measured against an answer that others confirm in drag: {'; '.join(found)}."
