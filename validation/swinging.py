"""Whether errors cover bags that swing on their hoop: ``python -m validation.swinging [--plans 60] [--few]``.

A small hoop lets a bag swing: its symmetric shape is left by a move that grows weakly, and goes far. Plans without
weight, of ``validation.weight_left_out``, of which the codline's sideways move grows are followed in the whole net.
Printed is how far that lies from the symmetric shape, and over the errors stated there. Exits with 1 if one is exceeded
or a plan leads to no shape that lasts.

The law in ``wrinkles.BY_SWINGING`` was found on the plans of seeds 40 to 45; ``--few`` makes them 6 to 10 meshes round,
behind smaller hoops, which ``wrinkles.SWINGING_OF_FEW`` and ``ASIDE_OF_FEW`` are of (seed 50).
"""

import sys
from collections.abc import Iterator

import click
import numpy as np
import pandas as pd

from codend.plan.plan import Plan, plan_from_dict
from codend.studies.study import solve
from validation.weight_left_out import QUANTITIES, weighed_plan


def swinging_plans(plans: int, seed: int, few: bool = False) -> Iterator[tuple[int, Plan]]:
    """Plans of whose symmetric shape harmonic 1 grows, by their numbers."""
    for number in range(plans):
        plan, _ = weighed_plan(seed, number)
        plan = of_few_meshes(plan, seed, number) if few else plan
        result = solve(with_wrinkles(plan, False)).cases[0]
        if result.converged and result.stability is not None and 1 in result.stability.growing:
            yield number, plan


def of_few_meshes(plan: Plan, seed: int, number: int) -> Plan:
    """A plan of 6 to 10 meshes round, behind a hoop of 0.4 to 0.8 times the share of its width."""
    rng = np.random.default_rng([seed, number, 1])
    tables, few = plan.to_dict(), int(rng.integers(6, 11))
    first = tables["netting"][0]
    tables["entry"]["radius_m"] *= few / first["meshes_round"] * float(rng.uniform(0.4, 0.8))
    tables["netting"] = [first | {"meshes_round": few}]
    tables["catch"]["filled_meshes"] = min(*tables["catch"]["filled_meshes"], 0.8 * first["meshes_long"])
    return plan_from_dict(tables)


def with_wrinkles(plan: Plan, followed: bool) -> Plan:
    """The plan, what grows followed or not."""
    tables = plan.to_dict()
    tables["model"]["wrinkles"] = followed
    return plan_from_dict(tables)


def row_of(plan: Plan) -> dict[str, object]:
    """How far the shape that is followed lies from the symmetric one, relative, and over the errors stated there."""
    symmetric, followed = (solve(with_wrinkles(plan, asked)).cases[0] for asked in (False, True))
    row: dict[str, object] = {
        "mesh": plan.netting[0].mesh,
        "harmonics": ", ".join(map(str, symmetric.stability.growing)) if symmetric.stability else "",
        "followed is stable": followed.stability.stable if followed.stability else "unknown",
    }
    for name, error in QUANTITIES.items():
        there, here = getattr(symmetric.measures, name), getattr(followed.measures, name)
        row[name] = abs(here - there) / there
        row[f"{name} over its error"] = abs(here - there) / getattr(symmetric.errors, error)
    return row


@click.command()
@click.option("--plans", default=60, show_default=True, help="Plans tried; about one in twenty swings.")
@click.option("--seed", default=40, show_default=True)
@click.option("--few", is_flag=True, help="Of 6 to 10 meshes round.")
def main(plans: int, seed: int, few: bool) -> None:
    """Print the changes and the largest over its error."""
    table = pd.DataFrame([{"plan": number} | row_of(plan) for number, plan in swinging_plans(plans, seed, few)])
    print(table.round(4).to_string(index=False))
    worst = float(np.nanmax(table.filter(like="over its error").to_numpy(dtype=float)))
    lost = int((table["followed is stable"] != "yes").sum())
    print(f"{len(table)} swing, largest change over its stated error {worst:.3f}; {lost} led to no shape that lasts")
    sys.exit(int(worst > 1.0 or lost > 0))


if __name__ == "__main__":
    main()
