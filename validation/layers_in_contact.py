"""Second layers as nets of their own beside the model of them: ``python -m validation.layers_in_contact``.

The model lets a layer move with the netting below, drawn out evenly over it. Here the layer is a net of its own, laced
to the row where it begins and gathered by the same codline, on which the netting below presses by contact without
friction: it slides, and netting bulges through its meshes. No drag acts on the twine of either.
"""

from dataclasses import replace
from time import process_time

import click
import numpy as np

from codend.bag.bag import Bag, around
from codend.bag.build import build_bag
from codend.bag.layer_measures import measure_layers
from codend.bag.loads import catch_of
from codend.bag.measures import measure_all
from codend.equilibrium.start_shapes import all_round_start
from codend.mechanics.problem import Problem
from codend.mechanics.surface import ContactLaw
from codend.mechanics.water import uniform_flow
from codend.net.net import Floats, with_bars
from codend.plan.plan import Plan, plan_from_dict
from codend.solvers import gentle
from codend.solvers.gentle import GentleSettings
from codend.solvers.outcome import Solution
from codend.solvers.refusal import passage
from codend.studies.case_result import CaseResult
from codend.studies.study import solve

BEGINS_M = 1e-3
"""Distance at which contact begins."""
OUTSIDE = 0.15
"""Share by which the layer starts outside of the netting below."""
STEPS = 1500


CASES = ((24, 0.95, 6), (24, 0.8, 7), (48, 0.95, 12), (48, 0.8, 15))
"""Meshes round of the codend, twice the layer's; bars of the layer over twice those below; meshes that it is long."""


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


def in_contact(plan: Plan, modelled: CaseResult) -> tuple[Bag, Problem, Solution]:
    """The bag of a plan and its layer as two nets in a sector of one mesh of the layer, and their equilibrium."""
    layer, one = plan.layer[0], modelled.bag
    sectors = plan.netting[0].meshes_round // layer.meshes_round
    bare = plan.model_copy(update={"layer": ()})
    below = build_bag(bare, sectors=sectors)
    start = all_round_start(one, modelled.positions, modelled.solution.bar_tension, sectors)
    own, tension = _layer_net(plan, modelled)
    # its entry is a row of the netting below, its codline that one's
    nodes, mine = len(below.net.positions), len(own.net.positions)
    row = below.bands - 2 * int(layer.meshes_from_codline[1])
    laced = np.flatnonzero(below.node_row == row)
    azimuth = np.arctan2(*below.net.positions[laced, :0:-1].T)
    number = np.full(mine, -1)
    number[own.node_row == 0] = laced[np.abs(azimuth).argmin()]
    number[own.node_row == own.bands] = np.flatnonzero(below.node_row == below.bands)
    new = number < 0
    number[new] = nodes + np.arange(np.count_nonzero(new))
    net = replace(
        below.net,
        positions=np.concatenate([below.net.positions, own.net.positions[new]]),
        fixed=np.concatenate([below.net.fixed, own.net.fixed[new]]),
    )
    net = with_bars(
        net,
        number[own.net.bars],
        own.net.bar_image,
        bar_length=own.net.bar_length,
        bar_flexibility=own.net.bar_flexibility,
        bar_density=np.nan,
    )
    both = around(below, net, 0)
    case = plan.cases()[0]
    problem = Problem.of(
        both.net,
        water=uniform_flow(plan.tow.water_density_kg_m3, np.array([case.speed_m_s, 0.0, 0.0])),
        catch=catch_of(both, plan, case),
        contact=ContactLaw.pressing(BEGINS_M, 0.5 * modelled.solution.mean_tension),
    )
    led = replace(
        start,
        positions=np.concatenate([start.positions, own.net.positions[new]]),
        bar_tension=np.concatenate([start.bar_tension, tension]),
        report=modelled.solution.report,
    )
    if (crossed := passage(problem, led.positions)) is not None:
        raise click.ClickException(f"the start is pierced: {crossed}")
    return both, problem, gentle.solve(problem, plan.model.tolerance, led, GentleSettings(STEPS))


def _layer_net(plan: Plan, modelled: CaseResult) -> tuple[Bag, Floats]:
    """The layer as a sector one mesh wide, a little outside of the netting below, and the tension it starts with, N."""
    layer = plan.layer[0]
    bag, positions = modelled.bag, modelled.positions
    first = bag.bands - 2 * int(layer.meshes_from_codline[1])
    ring = [np.flatnonzero(bag.node_row == row)[0] for row in range(first, bag.bands + 1)]
    rows = np.linspace(0.0, 1.0, 2 * layer.meshes_long + 1)
    share = np.linspace(0.0, 1.0, len(ring))
    x = np.interp(rows, share, positions[ring, 0])
    radius = np.interp(rows, share, np.hypot(*positions[ring, 1:].T))
    # it starts behind the netting below as well, all but the codline
    x[:-1] = x[0] + (1.0 + OUTSIDE) * (x[:-1] - x[0])
    below_x, below_radius = positions[ring, 0], np.hypot(*positions[ring, 1:].T)
    for row in range(1, len(x) - 1):
        beside = (below_x >= min(x[row - 1], below_x[-3])) & (below_x <= max(x[row - 1], x[row + 1]))
        radius[row] = (1.0 + OUTSIDE) * max(radius[row], below_radius[beside].max())
    tables = plan.to_dict()
    outer = {key: value for key, value in tables["layer"][0].items() if key != "meshes_from_codline"}
    tables |= {"netting": [outer], "entry": {"radius_m": float(radius[0])}, "catch": {"filled_meshes": 1.0}}
    own = build_bag(plan_from_dict({key: tables[key] for key in tables if key != "layer"}), sectors=1, rows=(x, radius))
    (told,) = measure_layers(bag, modelled.problem, modelled.solution)
    return own, np.full(len(own.net.bars), max(float(told.bar_tension_n.mean()), 1.0))


def compare(plan: Plan) -> dict[str, float]:
    """A layer that moves with the netting below beside one that slides on it."""
    modelled = solve(plan).cases[0]
    began = process_time()
    bag, problem, solution = in_contact(plan, modelled)
    seconds = process_time() - began
    slid, held = measure_all(bag, problem, solution)[2], modelled.measures
    return {
        "drag_n": held.drag_n,
        "drag_changes": slid.drag_n / held.drag_n - 1.0,
        "radius_changes": slid.max_radius_m / held.max_radius_m - 1.0,
        "opening_deg": held.opening_ahead_deg,
        "opening_changes_deg": slid.opening_ahead_deg - held.opening_ahead_deg,
        "residual": solution.report.residual,
        "steps": solution.report.iterations,
        "seconds": seconds,
    }


@click.command(help=__doc__)
def main() -> None:
    """Print the table."""
    click.echo("round | bars / 2 | long | drag N | slides: drag | radius | opening | residual | s")
    for case in CASES:
        found = compare(codend_plan(*case))
        click.echo(
            f"{case[0]} | {case[1]:g} | {case[2]} | {found['drag_n']:.1f} | {found['drag_changes']:+.1%} | "
            f"{found['radius_changes']:+.1%} | {found['opening_deg']:.1f} {found['opening_changes_deg']:+.1f} | "
            f"{found['residual']:.0e} | {found['seconds']:.1f}"
        )


if __name__ == "__main__":
    main()
