"""Smeared against real ropes on random plans: ``python -m validation.smeared_ropes [PLANS] [--kind KIND] [--seed S]``.

For every plan the relative difference in drag and length, that in mean opening ahead, and the largest of the true
errors of drag, volume, radius and opening over those that the smeared model states. Netting other than diamond without
knots may pass through itself here: between real ropes that of T90 and square mesh hangs in folds, which no net without
contact between its layers has.
"""

from contextlib import nullcontext
from unittest.mock import patch

import click
import numpy as np

from codend.plan.plan import Plan, plan_from_dict
from codend.studies.study import solve

SEED = 15
KNOT = 0.1
"""Of a mesh."""
KINDS = {"diamond": (1.0, {}), "knotted": (1.0, {"knot": 1}), "t90": (1.0, {"mesh": "t90", "knot": 1}),
         "square": (0.9, {"mesh": "square"})}  # fmt: skip
"""Entry over that of diamond netting, and what a section has else."""


def random_plan(rng: np.random.Generator, kind: str = "diamond") -> Plan:
    """A plan with 2 to 6 ropes, soft or stiff, 5 to 20 % short."""
    entry, own = KINDS[kind]
    number = int(rng.integers(2, 7))
    meshes_round = number * int(rng.integers(max(3, 30 // number), 60 // number + 1))
    meshes_long = int(rng.integers(25, 45))
    mesh_mm = float(rng.uniform(60.0, 120.0))
    stretched_m = meshes_round * mesh_mm / 2000.0 / np.pi
    return plan_from_dict(
        {
            "title": "random ropes",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": entry * float(rng.uniform(0.3, 0.45)) * stretched_m},
            "netting": [
                {
                    "mesh": "diamond",
                    "meshes_round": meshes_round,
                    "meshes_long": meshes_long,
                    "mesh_mm": mesh_mm,
                    "twine_mm": 3.0,
                    "axial_stiffness_n": 1000.0,
                    "knot_mm": KNOT * mesh_mm if "knot" in own else 0.0,
                    **({"mesh": own["mesh"]} if "mesh" in own else {}),
                }
            ],
            "rope": [
                {
                    "number": number,
                    "shortening": float(rng.uniform(0.05, 0.2)),
                    "axial_stiffness_n": float(10.0 ** rng.uniform(3.5, 5.5)),
                }
            ],
            "catch": {"filled_meshes": float(rng.uniform(0.25, 0.6)) * meshes_long, "pressure": "uniform"},
        }
    )


def compare(plan: Plan, through_itself: bool = False) -> dict[str, float] | None:
    """Differences smeared less real of one plan; None where either was not solved."""
    found = []
    for fidelity in ("smeared", "sector"):
        asked = plan.model_copy(update={"model": plan.model.model_copy(update={"fidelity": fidelity})})
        with patch("codend.solvers.newton.refusal", return_value=None) if through_itself else nullcontext():
            study = solve(asked)
        if not study.converged:
            return None
        found.append(study.table.iloc[0])
    smeared, real = found
    drag, length = (smeared[name] / real[name] - 1.0 for name in ("drag_n", "length_m"))
    opening = smeared["opening_ahead_deg"] - real["opening_ahead_deg"]
    stated = {
        name: next(column for column in smeared.index if column.startswith(f"{name.rsplit('_', 1)[0]}_error"))
        for name in ("drag_n", "catch_volume_m3", "max_radius_m", "opening_ahead_deg")
    }
    worst = max(abs(smeared[name] - real[name]) / smeared[error] for name, error in stated.items())
    return {"drag": drag, "length": length, "opening": opening, "worst": float(worst)}


@click.command()
@click.argument("plans", type=int, default=40)
@click.option("--kind", type=click.Choice(list(KINDS)), default="diamond")
@click.option("--seed", type=int, default=SEED)
def main(plans: int, kind: str, seed: int) -> None:
    """Print the table and the medians."""
    rng = np.random.default_rng(seed)
    rows = []
    print("ropes short   EA N     round  drag %  length %  opening deg  true / stated")
    for _ in range(plans):
        plan = random_plan(rng, kind)
        rope, found = plan.rope[0], compare(plan, through_itself=kind != "diamond")
        said = (
            f"{rope.number:5d} {rope.shortening:5.3f} {rope.axial_stiffness_n:9.0f} {plan.netting[0].meshes_round:7d}"
        )
        if found is None:
            print(f"{said}  not solved")
            continue
        rows.append(found)
        drag, length = 100.0 * found["drag"], 100.0 * found["length"]
        print(f"{said} {drag:7.2f} {length:9.2f} {found['opening']:12.2f} {found['worst']:14.2f}", flush=True)
    medians = [np.median(np.abs([row[name] for row in rows])) for name in ("drag", "length", "opening")]
    print(
        f"{len(rows)} of {plans} solved; medians: drag {100 * medians[0]:.2f} %, length {100 * medians[1]:.2f} %, "
        f"opening {medians[2]:.2f} deg; covered {sum(row['worst'] <= 1.0 for row in rows)}"
    )


if __name__ == "__main__":
    main()
