"""Whether errors cover layers that slide: ``python -m validation.sliding_layers [--nets 60] [--seed 6]``.

Random codends of diamond, T90 and square mesh under random layers, whose meshes divide those below, are solved with the
layer held to the netting below and as two nets in contact without friction (``equilibrium.layer_contact``), with
catches of filled meshes and, with ``--by-volume``, of the volume that those hold. The law in ``equilibrium.sliding``
was found on those of seeds 1 to 4, and of seed 5 by volume. With ``--by-nets`` errors are by the nets in contact
themselves, and the shape to which a third start leads is judged. Printed are what sliding changes and its share of all
that is stated. Where the layer carries nothing, nor is near it, nothing may change. Exits with 1 if any is above 1.
Nets whose layer comes to no rest in contact, a sixth of them, are counted.
"""

import sys

import click
import numpy as np
import pandas as pd

from codend.equilibrium.layer_contact import NEAR
from codend.errors import InputError
from codend.plan.plan import Plan, plan_from_dict
from codend.studies.study import solve
from validation.layers_in_contact import measured_in_contact
from validation.weight_left_out import QUANTITIES

ROWS_A_MESH = {"diamond": 2.0, "t90": 2.0, "square": 1.0}
"""Of bars along a mesh."""
NOISE = 1e-5
"""Relative change that the tolerance of the contact leaves."""
THIRD = 0.08, 0.15
"""Shares by which layers start outside of the netting below, by neither of which errors are told."""


def random_plan(seed: int, number: int) -> Plan:
    """A codend of random netting under a random layer, all sizes assumed."""
    rng = np.random.default_rng([seed, number])
    mesh, over = (str(rng.choice(["diamond", "t90", "square"], p=[0.5, 0.3, 0.2])) for _ in range(2))
    ratio, own = int(rng.integers(1, 4)), int(rng.integers(8, 25))
    count, width = ratio * own, float(rng.uniform(1.5, 4.0))
    bar = width / count / (1.0 if mesh == "square" else 2.0)
    bar_over = float(rng.uniform(0.45, 1.05)) * width / own / (1.0 if over == "square" else 2.0)
    long = max(int(rng.uniform(0.8, 1.6) * width / (ROWS_A_MESH[mesh] * bar)), 4)
    covered = max(int(rng.uniform(0.3, 1.0) * long), 2)
    longer = float(np.exp(rng.uniform(np.log(0.85), np.log(1.4))))
    long_over = max(round(longer * covered * ROWS_A_MESH[mesh] * bar / (ROWS_A_MESH[over] * bar_over)), 1)
    filled = float(rng.uniform(0.15, 0.7)) * long
    soft = {} if rng.random() < 0.3 else {"axial_stiffness_n": float(rng.uniform(1000.0, 10000.0))}
    soft_over = {} if rng.random() < 0.3 else {"axial_stiffness_n": float(rng.uniform(2000.0, 20000.0))}
    netting = {
        "mesh": mesh, "meshes_round": count, "meshes_long": long, "bar_mm": 1000.0 * bar, "twine_mm": 60.0 * bar,
    }  # fmt: skip
    layer = {
        "mesh": over, "meshes_round": own, "meshes_long": long_over, "bar_mm": 1000.0 * bar_over,
        "twine_mm": 60.0 * bar_over, "meshes_from_codline": [0, covered],
    }  # fmt: skip
    speed = float(rng.uniform(0.8, 2.0))
    return plan_from_dict(
        {
            "title": f"layer {number}",
            "tow": {"speed_m_s": speed, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": float(rng.uniform(0.3, 0.7)) * width / 2.0 / np.pi},
            "netting": [netting | soft],
            "layer": [layer | soft_over],
            "catch": {"filled_meshes": filled, "pressure": "sphere" if rng.random() < 0.7 else "uniform"},
            "drag": {} if rng.random() < 0.5 else {"normal": 0.0},
            "model": {"fidelity": "sector", "wrinkles": False, "contact": False},
        }
    )


def by_volume(plan: Plan) -> Plan:
    """The plan with a catch of the volume that its filled meshes hold."""
    tables = plan.to_dict()
    held = solve(plan).cases[0].measures.catch_volume_m3
    tables["catch"] = {"volume_m3": held, "pressure": plan.catch.pressure}
    return plan_from_dict(tables)


def by_nets(plan: Plan) -> Plan:
    """The plan with errors by its layer as a net of its own, in contact, where that comes to rest."""
    tables = plan.to_dict()
    return plan_from_dict(tables | {"model": tables["model"] | {"contact": True}})


def changes_of(plan: Plan, starts: tuple[float, ...] = NEAR) -> dict[str, float] | None:
    """What sliding changes, relative, and over what is stated; None where a net was not solved or came to no rest."""
    held = solve(plan).cases[0]
    free = measured_in_contact(plan, held, starts) if held.converged else None
    if free is None:
        return None
    found = {"carries": float(held.by_sliding[0] > 0.0)}
    for name, error in QUANTITIES.items():
        size = getattr(held.measures, name)
        off = abs(getattr(free, name) - size)
        found[name] = off / size
        found[f"{name} over stated"] = off / (getattr(held.errors, error) + NOISE * size)
    return found


def table_of(nets: int, seed: int, of_volume: bool = False, of_nets: bool = False) -> tuple[pd.DataFrame, int]:
    """A row a net that came to rest, and how many did not."""
    rows, restless = [], 0
    for number in range(nets):
        try:
            plan = random_plan(seed, number)
            plan = by_volume(plan) if of_volume else plan
            found = changes_of(by_nets(plan), THIRD) if of_nets else changes_of(plan)
        except InputError:  # entries wider than square meshes open
            continue
        restless += found is None
        if found is not None:
            rows.append({"net": number, **found})
    return pd.DataFrame(rows), restless


@click.command(help=__doc__)
@click.option("--nets", default=60, show_default=True)
@click.option("--seed", default=6, show_default=True)
@click.option("--by-volume", "of_volume", is_flag=True, help="Catches of a given volume.")
@click.option("--by-nets", "of_nets", is_flag=True, help="Errors by the nets in contact themselves.")
def main(nets: int, seed: int, of_volume: bool, of_nets: bool) -> None:
    """Print the changes, net by net and at most."""
    table, restless = table_of(nets, seed, of_volume, of_nets)
    click.echo(table.round(4).to_string(index=False))
    over = [f"{name} over stated" for name in QUANTITIES]
    worst = table[over].max()
    click.echo(f"{len(table)} nets, {table['carries'].sum():.0f} with layers that carry, {restless} came to no rest")
    click.echo(worst.round(3).to_string())
    sys.exit(int(worst.max() > 1.0))


if __name__ == "__main__":
    main()
