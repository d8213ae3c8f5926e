"""Bags that hang from their hoop: ``python -m validation.hanging [--bags 40] [--seed 0]``.

Bags of diamond, T90 and square mesh, of heavy twine and with a catch lighter or denser than the water, towed so slowly
that next to nothing but weight counts. Printed is, for every bag, what its hoop carries beside the wet weight of its
netting, (rho_c - rho) g V of its catch and the little that the water does, over the sum of the weights: upward, and to
the sides. Exits with 1 if one that is solved misses 1e-8, or one of twenty is not solved.
"""

import sys
from dataclasses import replace
from time import process_time

import click
import numpy as np
import pandas as pd

from codend.bag.loads import catch_weight_density
from codend.plan.plan import Plan, plan_from_dict
from codend.solvers.reactions import loads_and_supports
from codend.studies.case_result import CaseResult
from codend.studies.study import solve

WATER = 1025.0
CATCHES = (900.0, 1025.0, 1100.0, 1500.0, 2050.0)
"""kg/m3."""


def hanging_plan(
    mesh: str, meshes_round: int, meshes_long: int, filled: float, catch: float, twine: float, entry: float = 0.25
) -> Plan:
    """A bag towed at next to no speed; ``entry`` is its hoop's radius over that of its meshes pulled fully open."""
    knot_mm = 6.0 if mesh == "t90" else 0.0
    across_mm = {"diamond": 40.0, "t90": 46.0, "square": 20.0}[mesh]
    netting = {
        "mesh": mesh,
        "meshes_round": meshes_round,
        "meshes_long": meshes_long,
        "bar_mm": 40.0,
        "knot_mm": knot_mm,
        "twine_mm": 3.0,
        "twine_density_kg_m3": twine,
    }
    return plan_from_dict(
        {
            "title": f"hanging, {mesh}, {meshes_round} round, catch of {catch:g} kg/m3",
            "tow": {"speed_m_s": 1e-4, "water_density_kg_m3": WATER},
            "entry": {"radius_m": entry * meshes_round * across_mm / 1000.0 / np.pi},
            "netting": [netting],
            "catch": {"filled_meshes": filled, "density_kg_m3": catch},
            "model": {"tolerance": 1e-9},
        }
    )


def random_bag(seed: int, number: int) -> Plan:
    """A small bag of any mesh."""
    rng = np.random.default_rng([seed, number])
    long = int(rng.integers(8, 17))
    return hanging_plan(
        str(rng.choice(["diamond", "t90", "square"])),
        int(rng.integers(6, 17)),
        long,
        float(rng.uniform(0.3, 0.7)) * long,
        float(rng.choice(CATCHES)),
        float(rng.uniform(1300.0, 4000.0)),
        float(rng.uniform(0.15, 0.6)),
    )


def missed(plan: Plan, result: CaseResult) -> tuple[float, float]:
    """What the hoop carries upward and to the sides beside wet weights and what the water does, over the weights."""
    problem, loading = result.problem, result.problem.loading
    support = loads_and_supports(problem, result.solution)[1]
    weightless = loading._replace(dead=np.zeros_like(loading.dead), catch=loading.catch._replace(weight_density=0.0))
    by_water = loads_and_supports(replace(problem, loading=weightless), result.solution)[0].sum(axis=0)
    carried = support[result.bag.held_by_the_entry].sum(axis=0) + by_water
    netting_n = -float(loading.dead[:, 2].sum())
    catch_n = catch_weight_density(plan) * result.measures.catch_volume_m3
    size = abs(netting_n) + abs(catch_n)
    return float(carried[2] - netting_n - catch_n) / size, float(np.hypot(*carried[:2])) / size


@click.command()
@click.option("--bags", default=40, show_default=True)
@click.option("--seed", default=0, show_default=True)
def main(bags: int, seed: int) -> None:
    """Print what every hoop carries."""
    rows = []
    for number in range(bags):
        plan, began = random_bag(seed, number), process_time()
        result = solve(plan).cases[0]
        upward, sideways = missed(plan, result) if result.converged else (np.nan, np.nan)
        rows.append(
            {
                "bag": plan.title,
                "solved": result.converged,
                "contact": result.problem.surface is not None,
                "upward": upward,
                "sideways": sideways,
                "stable": result.stability.stable if result.stability else "",
                "s": process_time() - began,
            }
        )
        print(pd.DataFrame(rows[-1:]).to_string(index=False, header=number == 0), flush=True)
    table = pd.DataFrame(rows)
    most = np.nanmax(np.abs(table[["upward", "sideways"]].to_numpy()))
    print(f"{table.solved.sum()} of {bags} solved, {table.contact.sum()} under contact, missed by at most {most:.1e}")
    sys.exit(int(most > 1e-8 or table.solved.mean() < 0.95))


if __name__ == "__main__":
    main()
