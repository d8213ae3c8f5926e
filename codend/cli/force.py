"""The command ``codend opening-force``: what it takes to open one mesh."""

from pathlib import Path

import click

from codend.cli.common import NOT_CONVERGED, SeveralPairs, check_writable, out_option, set_option, written_into
from codend.cli.console import shown_progress, text_table

COLUMNS = {
    "case": "case",
    "meshes_from_entry": "meshes from entry",
    "opening_deg": "opening deg",
    "wanted_opening_deg": "wanted deg",
    "opening_force_alone_n": "alone N",
    "opening_force_in_net_n": "in the net N",
    "opening_force_in_net_error_n": "error N",
    "converged": "converged",
}
"""Columns of ``opening_force.csv`` that are printed, and their headings."""


@click.command("opening-force", cls=SeveralPairs)
@click.argument("plan", metavar="PLAN.toml")
@out_option
@click.option(
    "--at",
    "places",
    multiple=True,
    type=float,
    metavar="MESHES",
    help="Mesh to open, in meshes from the entry; may be repeated. By default the one ahead of the catch that needs "
    "most when alone.",
)
@click.option(
    "--opening",
    "wanted_deg",
    default=30.0,
    show_default=True,
    type=float,
    metavar="DEGREES",
    help="Opening to bring it to.",
)
@set_option
def force(plan: str, folder: Path, places: tuple[float, ...], wanted_deg: float, changes: tuple[str, ...]) -> int:
    """Force that opens a mesh: alone, and in the net with its neighbours and all.

    For every case of a plan: alone by the equilibrium of a rhombus under the load it carries; in the net by pulling its
    two knots apart in the solved model, which is made of sectors side by side, whatever model.fidelity says, and knows
    no wet weight. Writes opening_force.csv into DIR. Takes seconds a mesh, of a net of 40 000 knots 15.
    """
    from codend.io.files import write_table
    from codend.plan.plan import load_plan
    from codend.studies.opening_force import check_place, pull_mesh
    from codend.studies.tables import opening_force_table

    checked = load_plan(plan, changes)
    asked: tuple[float | None, ...] = places or (None,)
    for place in asked:
        check_place(checked, place)
    check_writable(folder, ["opening_force.csv"])
    wanted = [(case, place) for case in checked.cases() for place in asked]
    pulls = []
    with shown_progress() as progress:
        for done, (case, place) in enumerate(wanted):

            def report(doing: str, residual: float, number: int = case.number, done: int = done) -> None:
                progress(done, len(wanted), f"case {number}: {doing}, residual {residual:.1e}")

            pulls.append(pull_mesh(checked, case, place, wanted_deg, report))
    table = opening_force_table(pulls)
    with written_into(folder):
        write_table(table, folder / "opening_force.csv")
    click.echo(text_table(list(COLUMNS.values()), table[list(COLUMNS)].itertuples(index=False)))
    if any(section.density_kg_m3 is not None for section in checked.netting):
        click.echo("Wet weight is left out.")
    if any(section.axial_stiffness_n is None for section in checked.netting):
        click.echo("Twine without axial_stiffness_n does not stretch: in the net it opens far harder than real twine.")
    for pull in pulls:
        if not pull.converged:
            where = f"case {pull.case.number}, {pull.meshes_from_entry:g} meshes from the entry"
            click.echo(f"{where}: not solved", err=True)
            for attempt in pull.attempts:
                click.echo(f"  tried {attempt}", err=True)
    return 0 if all(pull.converged for pull in pulls) else NOT_CONVERGED
