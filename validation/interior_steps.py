"""Steps of the interior-point method over all it is asked for: ``python -m validation.interior_steps [--each]``.

Codends limp and stiff, joined, between short ropes and under layers, full nets with weight, and cages at rest, each
from where the project begins: a crude bag, the sector set all round, the scene as laid. Settings of
``codend.solvers.interior_point`` that help one class cost another, and none may lose one; found without contact, cages
at rest may pass through themselves and are counted lost then.
"""

from collections.abc import Iterator
from time import process_time
from typing import Any

import click
import numpy as np

from codend.bag.loads import problem_of
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.situation import Situation
from codend.mechanics.problem import Problem
from codend.plan.plan import Plan, plan_from_dict
from codend.scenes.build import build
from codend.scenes.scene import scene_from_dict
from codend.solvers import interior_point
from codend.solvers.outcome import Solution
from validation.cage.gear import box, cylinder
from validation.layers import MESHES_ROUND, codend_plan, with_layer
from validation.ropes_short import plan_with
from validation.which_starts import MOST_KNOTS, random_plan

Begun = tuple[Problem, Solution | None]
KINDS = ("diamond", "t90", "square")


def crude(plan: Plan, case: int = 0) -> Begun:
    """A crude bag of one sector."""
    model = model_of(plan, 1, 1)
    return problem_of(model.bag, plan, plan.cases()[case]), None


def all_round(plan: Plan, sectors: int | None, merged: int = 1) -> Begun:
    """The equilibrium of a sector set round a wider model."""
    model, case = model_of(plan, merged, sectors), plan.cases()[0]
    problem = problem_of(model.bag, plan, case)
    begun = Situation(model, problem, case, (), None, lambda other, case: equilibrium.solve(other, case, (), None)[1])
    return problem, begun.sector_all_round


def codend(kind: str, meshes_round: int, filled: float, **more: float) -> Plan:
    """A codend of 120 mm, its sizes assumed."""
    netting = {"mesh": kind, "meshes_round": meshes_round, "meshes_long": 50, "mesh_mm": 120.0, "twine_mm": 4.0}
    knot = {} if kind == "square" else {"knot_mm": 12.0}
    return plan_from_dict(
        {
            "title": kind,
            "tow": {"speed_m_s": 1.5},
            "entry": {"radius_m": 0.4 * meshes_round / 100},
            "netting": [netting | knot | {"axial_stiffness_n": 2000.0} | more],
            "catch": {"filled_meshes": filled},
        }
    )


def full(kind: str, speed_m_s: float) -> Plan:
    """A whole net of heavy twine."""
    netting = {"mesh": kind, "meshes_round": 48, "meshes_long": 40, "mesh_mm": 110.0, "twine_mm": 4.0}
    return plan_from_dict(
        {
            "title": kind,
            "tow": {"speed_m_s": speed_m_s},
            "entry": {"radius_m": 0.35},
            "netting": [netting | {"twine_density_kg_m3": 1140.0}],
            "catch": {"filled_meshes": 8.0},
            "model": {"fidelity": "full"},
        }
    )


def laid(tables: dict[str, Any]) -> Begun:
    """A scene as it is laid."""
    return build(scene_from_dict(tables)).problem, None


def classes() -> Iterator[tuple[str, Iterator[Begun]]]:
    """What is solved, by its class."""
    catches = (3.0, 8.0, 20.0)
    yield "limp", (crude(codend(kind, 100, filled)) for kind in KINDS for filled in catches)
    for kind in KINDS[:2]:
        yield (
            f"stiff {kind}",
            (
                crude(codend(kind, meshes_round, filled, bending_stiffness_n_m2=stiffness))
                for meshes_round in (100, 75)
                for stiffness in (5e-4, 2e-3)
                for filled in catches
            ),
        )
    yield "full, with weight", (all_round(full(kind, speed), None, 2) for kind in KINDS for speed in (0.4, 1.2))
    shortenings, filled = (0.1, 0.2), (10.0, 20.0)
    yield "short ropes", (all_round(plan_with(n, s, f), 1) for n in (2, 4) for s in shortenings for f in filled)
    yield "layers", (crude(with_layer(codend_plan(), n), case=case) for n in MESHES_ROUND for case in (0, 3))
    joined = (crude(random_plan("joined", number)) for number in range(60))
    yield "joined, random", (begun for begun in joined if len(begun[0].net.positions) <= MOST_KNOTS)
    yield "cages at rest", (laid(tables) for tables in cages())


def cages() -> Iterator[dict[str, Any]]:
    """Boxes and a cylinder in still water."""
    for merged in (10, 8, 5):
        for ballast_kg in (6.0, 12.0, 24.0):
            yield box(merged=merged, ballast_kg=ballast_kg)
    yield box(merged=8, seam_ropes=True)
    yield box(merged=8, along_foot=True)
    yield box(merged=8, twine_density_kg_m3=1140.0)
    yield cylinder()


@click.command(help=__doc__)
@click.option("--each", is_flag=True, help="Tell every net.")
def main(each: bool) -> None:
    """Print a line a class."""
    for name, nets in classes():
        steps, lost, spent = [], 0, 0.0
        for number, (problem, start) in enumerate(nets):
            began = process_time()
            report = interior_point.solve(problem, 1e-8, start).report
            spent += process_time() - began
            if each:
                click.echo(f"  {name} {number}: {report.iterations} steps. {report.outcome.value}")
            if report.outcome.converged:
                steps.append(report.iterations)
            else:
                lost += 1
        told = f"median {np.median(steps):3.0f}, most {max(steps):3d} steps" if steps else "none found"
        click.echo(f"{name:24s} {len(steps) + lost:3d} nets: {told}, {lost} lost, {spent:.1f} s of processor time")


if __name__ == "__main__":
    main()
