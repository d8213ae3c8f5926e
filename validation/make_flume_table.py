"""Flume-style table of the flume codend from the meridian method: independent of nets, and computed, not measured.

Run as `python -m validation.make_flume_table`; it writes `validation/tables/flume_150x140_meridian.csv`.
"""

from pathlib import Path

import click

from codend.bag.loads import pressure_law_of
from codend.bag.meridian import MeridianProblem, MeridianShape, solve_meridian
from codend.plan.plan import Plan, load_plan

HERE = Path(__file__).parent
CASE = HERE / "cases" / "flume_150x140.toml"
TABLE = HERE / "tables" / "flume_150x140_meridian.csv"

HEADER = """\
# COMPUTED, not measured: meridian (membrane shell) equations solved by collocation, no net of bars involved.
# Case: validation/cases/flume_150x140.toml, whose conditions are in part assumed, as marked there. {conditions}
# Drag is that of codend and catch alone: there is no hoop in it. A catch's front is a plane at whole meshes.
# Shared with the net models: the pressure law of the catch and the law of twine drag, so the table tests neither law.
# Made by validation/make_flume_table.py.
"""
COLUMNS = "filled_meshes,catch_volume_m3,speed_m_s,drag_n,front_from_codline_m,max_diameter_m,length_m"


def meridian_problem(plan: Plan, filled_meshes: float, speed_m_s: float) -> MeridianProblem:
    """The meridian of a plan with one section of diamond mesh, inextensible and without weight or bending."""
    (netting,) = plan.netting
    normal, tangential = plan.drag.coefficients
    return MeridianProblem(
        meshes_round=netting.meshes_round,
        half_mesh_rows=2 * netting.meshes_long,
        bar_m=netting.bar_m,
        entry_radius_m=plan.entry_radius_m,
        front_row=2.0 * (netting.meshes_long - filled_meshes),
        stagnation_pressure_pa=0.5 * plan.tow.water_density_kg_m3 * speed_m_s**2,
        pressure_law=pressure_law_of(plan),
        knot_m=netting.knot_m,
        drag_width_m=netting.drag_width_m,
        drag_law=plan.drag.law,
        normal_drag=normal,
        tangential_drag=tangential,
    )


def table_text() -> str:
    """The table, a row a catch, six digits a number: refining the grid changes an answer by less than 1e-6."""
    plan = load_plan(CASE)
    (speed,) = plan.tow.speed_m_s
    rows = [f"{case.catch_value:g},{_row(plan, case.catch_value, speed)}" for case in plan.cases()]
    conditions = f"{speed:g} m/s, water of {plan.tow.water_density_kg_m3:g} kg/m3."
    return "\n".join([HEADER.format(conditions=conditions) + COLUMNS, *rows, ""])


def _row(plan: Plan, filled_meshes: float, speed_m_s: float) -> str:
    problem = meridian_problem(plan, filled_meshes, speed_m_s)
    values, refined = (_measures(solve_meridian(problem, refinement)) for refinement in (2, 4))
    worst = max(abs(value / fine - 1.0) for value, fine in zip(values, refined, strict=True))
    if worst > 1e-6:
        raise click.ClickException(f"{filled_meshes:g} filled meshes: refinement changes the answer by {worst:.1e}")
    volume, *others = (f"{value:.6g}" for value in refined)
    return ",".join([volume, f"{speed_m_s:g}", *others])


def _measures(shape: MeridianShape) -> tuple[float, ...]:
    if not shape.converged:
        raise click.ClickException(shape.outcome.value)
    front_from_codline = shape.length_m - shape.front_x_m
    return shape.catch_volume_m3, shape.drag_n, front_from_codline, 2.0 * shape.largest_radius_m, shape.length_m


@click.command(help=__doc__)
def main() -> None:
    """Write the table."""
    TABLE.write_text(table_text(), encoding="utf-8")
    click.echo(f"written: {TABLE}")


if __name__ == "__main__":
    main()
