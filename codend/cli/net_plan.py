"""``codend plan``: the net plan drawn to scale, and templates to write one's own from."""

from pathlib import Path

import click

from codend.cli.common import SeveralPairs, set_option

_HEAD = """\
# A plan for codend. Numbers are examples: put your own in.
title = "My codend"

[tow]
speed_m_s = 1.5                # a number or a list

[entry]
hanging_ratio = 0.3            # of the front row; or radius_m

[[netting]]                    # the foremost section first: an extension goes above the codend
name = "codend"
"""
_TWINE = """\
inside_mesh_mm = 100           # what the gauge measures; or mesh_mm, the full stretched mesh, or bar_mm
knot_mm = 12                   # length of a knot
twine_mm = 4.0
material = "PE"                # gives the density; rtex, runnage_m_kg or twine_number give the mass
twines = 2                     # double twine
"""
_CATCH = """
[catch]
mass_kg = [200, 500, 1000]     # or filled_meshes, volume_m3, front_from_codline_m
"""
_ROPES = """
[[rope]]                       # lastridge ropes, one along each of the two selvedges
number = 2
shortening = 0.15              # of the stretched netting
diameter_mm = 24.0
axial_stiffness_n = 5e5        # left out: inextensible

[model]
opening_accuracy_deg = 10.0    # the quick look: ropes smeared over all meshes; left out: each as it is
"""
_OPEN = "meshes_round = {round}             # all round\nmeshes_long = 50\n"
_PANELS = """\
panels = 2                     # sewn together: upper and lower
selvedge_meshes = 3            # of each edge of a panel, taken up: 100 - 2 x 2 x 3 = 88 stay open
# cut = "1N2B"                 # of the side edges, where a section tapers; or meshes_round_aft
"""
TEMPLATES = dict(
    t0=_HEAD + 'mesh = "diamond"\n' + _OPEN.format(round=100) + _TWINE + _CATCH,
    t90=_HEAD + 'mesh = "t90"\n' + _OPEN.format(round=50) + _TWINE + _CATCH,
    panels=_HEAD + 'mesh = "diamond"\n' + _OPEN.format(round=100) + _PANELS + _TWINE + _ROPES + _CATCH,
    ropes=_HEAD + 'mesh = "diamond"\n' + _OPEN.format(round=100) + _TWINE + _ROPES + _CATCH,
)


@click.group("plan")
def net_plan() -> None:
    """Draw the net plan of a plan file, or begin a new one."""


@net_plan.command(cls=SeveralPairs)
@click.argument("plan", metavar="PLAN.toml")
@click.option("--out", "path", required=True, type=click.Path(path_type=Path), help="SVG file to write.")
@click.option("--limits", metavar="FILE.toml", help="Limits to hold the plan to: [[limit]] tables, each with a source.")
@set_option
def show(plan: str, path: Path, limits: str | None, changes: tuple[str, ...]) -> int:
    """Draw the net plan to scale: panels, cuts, selvedges, windows, twine, ropes, straps, joins, and what they take."""
    from codend.io.files import write_text
    from codend.plan.limits import held_to
    from codend.plan.plan import load_plan
    from codend.report.net_plan import plan_svg
    from codend.report.size_words import size_sentences

    checked = load_plan(plan, changes)
    findings = [] if limits is None else held_to(checked, limits)
    write_text(plan_svg(checked, findings), path)
    for sentence in size_sentences(checked):
        click.echo(sentence)
    for finding in findings:
        click.echo(finding.words)
    click.echo(f"written: {path}")
    return 0


@net_plan.command()
@click.option("--kind", type=click.Choice(list(TEMPLATES)), default="t0", show_default=True, help="Which template.")
def new(kind: str) -> int:
    """Print a commented template: of diamond netting, of T90, of two panels with ropes, or of ropes on a tube."""
    click.echo(TEMPLATES[kind], nl=False)
    return 0
