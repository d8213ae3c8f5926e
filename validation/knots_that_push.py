"""What it changes that knots resist compression: ``python -m validation.knots_that_push [--random 40] [--seed 1000]``.

Commercial codends of T90 netting, and random small ones, with knots that give way to compression as twine does and with
knots that keep their length (``netting.knot_compression``), symmetric: drag and opening ahead of the catch, what grows,
and the largest push of a knot. It is another model, so no error stated covers the difference where the net is stable.
Exits with 1 if twine carries compression, or a codend is solved one way only.
"""

import sys

import click
import numpy as np
import pandas as pd

from codend.plan.plan import Plan, plan_from_dict
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from validation.shaken import wrinkling_plan
from validation.wrinkles.matrix import BENDING_N_M2, CATCH_KG, MESHES_ROUND, commercial


def with_knots(plan: Plan, push: bool) -> CaseResult:
    """A plan solved with all its knots resisting compression, or none."""
    tables = plan.to_dict()
    for section in tables["netting"]:
        section["knot_compression"] = push
    return solve(plan_from_dict(tables)).cases[0]


def row_of(plan: Plan) -> dict[str, object]:
    """A plan solved both ways."""
    give, push = (with_knots(plan, push) for push in (False, True))
    row: dict[str, object] = {
        "plan": plan.title,
        "solved": f"{'yes' if give.converged else 'no'} / {'yes' if push.converged else 'no'}",
    }
    if not (give.converged and push.converged):
        return row
    row |= {
        "drag_n": give.measures.drag_n,
        "drag_change": push.measures.drag_n / give.measures.drag_n - 1.0,
        "opening_deg": give.measures.opening_ahead_deg,
        "opening_change_deg": push.measures.opening_ahead_deg - give.measures.opening_ahead_deg,
        "push_over_tension": max(-push.bar_tension_n.min(), 0.0) / push.measures.max_bar_tension_n,
        "growing": " / ".join(str(len(r.stability.growing)) if r.stability else "unknown" for r in (give, push)),
    }
    row["twine_pushes"] = bool(np.any(push.bar_tension_n[push.bag.bar_is_twine] < 0.0))
    return row


def commercial_table(meshes_round: tuple[int, ...] = MESHES_ROUND) -> pd.DataFrame:
    """A row a commercial codend."""
    return pd.DataFrame(
        [
            row_of(commercial("t90", around, bending, catch, wrinkles=False))
            for around in meshes_round
            for bending in BENDING_N_M2
            for catch in CATCH_KG
        ]
    )


def random_table(plans: int, seed: int) -> pd.DataFrame:
    """A row a random small codend of T90 netting."""
    drawn = (wrinkling_plan(number) for number in range(seed, seed + plans))
    return pd.DataFrame([row_of(plan) for plan in drawn if plan.netting[0].knot_across_m > 0.0])


@click.command()
@click.option("--random", "plans", default=40, show_default=True, help="Seeds tried; about half are T90 netting.")
@click.option("--seed", default=1000, show_default=True, help="The first.")
def main(plans: int, seed: int) -> None:
    """Print both tables and the largest changes."""
    wrong = False
    for name, table in (("commercial", commercial_table()), ("random", random_table(plans, seed))):
        print(table.round(5).to_string(index=False))
        both = table[table["solved"] == "yes / yes"]
        print(
            f"{name}: {len(both)} of {len(table)} solved both ways; drag changes by {both['drag_change'].min():.2%} to "
            f"{both['drag_change'].max():.2%}, median {both['drag_change'].median():.2%}; opening by "
            f"{both['opening_change_deg'].min():.2f} to {both['opening_change_deg'].max():.2f} degrees",
            flush=True,
        )
        wrong |= bool((table["solved"] == "yes / no").any() or both["twine_pushes"].any())
    sys.exit(wrong)


if __name__ == "__main__":
    main()
