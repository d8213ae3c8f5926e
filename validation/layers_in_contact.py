"""Second layers as nets of their own beside the model of them: ``python -m validation.layers_in_contact``.

The model lets a layer move with the netting below, drawn out evenly over it. Here the layer is a net of its own, laced
to the row where it begins and gathered by the same codline, on which the netting below presses by contact without
friction: it slides, and netting bulges through its meshes. No drag acts on the twine of either.

Then codends of 100 by 50 meshes of 110 mm with a series of catches under such layers, snug and tight, by default: the
processor time of a catch, of which the asking of layers in contact is nearly all, and what errors it leaves.
"""

from time import process_time

import click
import numpy as np

from codend.bag.bag import Bag
from codend.bag.measures import Measures, measure_all
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.layer_contact import NEAR, in_contact
from codend.mechanics.problem import Problem
from codend.plan.plan import Plan, plan_from_dict
from codend.solvers.outcome import Solution
from codend.studies.case_result import CaseResult
from codend.studies.study import solve

CASES = ((24, 0.95, 6), (24, 0.8, 7), (48, 0.95, 12), (48, 0.8, 15))
"""Meshes round of the codend, twice the layer's; bars of the layer over twice those below; meshes that it is long."""


SERIES = (("snug", 50, 150.0, 22), ("tight", 40, 220.0, 15), ("half as wide", 25, 220.0, 15))
"""Layers of the series: meshes round, mesh in mm, meshes long."""
CATCHES_KG = [100.0, 300.0, 700.0, 1200.0]
SECONDS = 5.0
"""Asked of a catch of a series."""


def codend_plan(meshes_round: int, bars: float, meshes_long: int) -> Plan:
    """A limp codend of 2.4 m of bars round under a layer over its last three fifths; all sizes assumed."""
    bar_mm, fine = 2400.0 / meshes_round, meshes_round // 24
    netting = {
        "mesh": "diamond", "meshes_round": meshes_round, "meshes_long": 20 * fine, "bar_mm": bar_mm, "twine_mm": 3.0,
        "axial_stiffness_n": 2000.0,
    }  # fmt: skip
    layer = {
        "mesh": "diamond", "meshes_round": meshes_round // 2, "meshes_long": meshes_long, "bar_mm": 2.0 * bars * bar_mm,
        "twine_mm": 5.0, "axial_stiffness_n": 5000.0, "meshes_from_codline": [0, 12 * fine],
    }  # fmt: skip
    return plan_from_dict(
        {
            "title": "a layer of its own",
            "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": 0.25},
            "netting": [netting],
            "layer": [layer],
            "catch": {"filled_meshes": 8.0 * fine},
            "drag": {"normal": 0.0},
            "model": {"wrinkles": False},
        }
    )


def slid(plan: Plan, modelled: CaseResult, starts: tuple[float, ...] = NEAR) -> tuple[Bag, Problem, Solution] | None:
    """The bag and its layer as two nets in contact, at rest or not; None where the starts are pierced."""
    return in_contact(model_of(plan, 1, 1), modelled.case, modelled.problem, modelled.solution, starts)


def measured_in_contact(plan: Plan, modelled: CaseResult, starts: tuple[float, ...] = NEAR) -> Measures | None:
    """What is measured of them; None where they come to no rest."""
    found = slid(plan, modelled, starts)
    return None if found is None or not found[2].report.outcome.converged else measure_all(*found)[2]


def compare(plan: Plan) -> dict[str, float]:
    """A layer that moves with the netting below beside one that slides on it."""
    modelled = solve(plan).cases[0]
    began = process_time()
    found = slid(plan, modelled)
    if found is None:
        raise click.ClickException("the start is pierced")
    bag, problem, solution = found
    seconds = process_time() - began
    free, held = measure_all(bag, problem, solution)[2], modelled.measures
    return {
        "drag_n": held.drag_n,
        "drag_changes": free.drag_n / held.drag_n - 1.0,
        "radius_changes": free.max_radius_m / held.max_radius_m - 1.0,
        "opening_deg": held.opening_ahead_deg,
        "opening_changes_deg": free.opening_ahead_deg - held.opening_ahead_deg,
        "residual": solution.report.residual,
        "steps": solution.report.iterations,
        "seconds": seconds,
    }


def series_plan(mesh: str, meshes_round: int, mesh_mm: float, meshes_long: int) -> Plan:
    """A codend of 100 by 50 meshes under a layer of a kind over its last 30, all sizes assumed, and its catches."""
    alike = {"mesh": mesh, "knot_mm": 12.0 if mesh == "diamond" else 0.0}
    over = {"meshes_round": meshes_round, "meshes_long": meshes_long, "mesh_mm": mesh_mm, "twine_mm": 6.0}
    return plan_from_dict(
        {
            "title": "a series under a layer",
            "tow": {"speed_m_s": 1.6, "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": 0.35},
            "netting": [alike | {"meshes_round": 100, "meshes_long": 50, "mesh_mm": 110.0, "twine_mm": 3.5}],
            "layer": [alike | over | {"axial_stiffness_n": 3000.0, "meshes_from_codline": [0, 30]}],
            "catch": {"mass_kg": CATCHES_KG},
        }
    )


def tell_series() -> None:
    """Print what the catches of the series take, and what is stated of the largest."""
    click.echo(
        f"series of {len(CATCHES_KG)} | layer | s a catch ({SECONDS:g} asked) | in contact | drag N | opening deg"
    )
    for mesh in ("diamond", "t90"):
        for name, *sizes in SERIES:
            plan = series_plan(mesh, *sizes)
            began = process_time()
            cases = solve(plan).cases
            seconds = (process_time() - began) / len(cases)
            last, free = cases[-1], sum(bool(np.isfinite(case.slid[0])) for case in cases)
            click.echo(
                f"{mesh} | {name} | {seconds:.1f} | {free} of {len(cases)} | {last.measures.drag_n:.0f} +- "
                f"{last.errors.drag_error_n:.0f} | {last.measures.opening_ahead_deg:.1f} +- "
                f"{last.errors.opening_ahead_error_deg:.1f}"
            )


@click.command(help=__doc__)
def main() -> None:
    """Print the tables."""
    click.echo("round | bars / 2 | long | drag N | slides: drag | radius | opening | residual | s")
    for case in CASES:
        found = compare(codend_plan(*case))
        click.echo(
            f"{case[0]} | {case[1]:g} | {case[2]} | {found['drag_n']:.1f} | {found['drag_changes']:+.1%} | "
            f"{found['radius_changes']:+.1%} | {found['opening_deg']:.1f} {found['opening_changes_deg']:+.1f} | "
            f"{found['residual']:.0e} | {found['seconds']:.1f}"
        )
    tell_series()


if __name__ == "__main__":
    main()
