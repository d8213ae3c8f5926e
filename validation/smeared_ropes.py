"""Quick looks at ropes against real ones: ``python -m validation.smeared_ropes [PLANS] [--kind KIND] [--seed S]``.

The quick look is what ``auto`` takes where any error in opening is allowed: ropes smeared over a sector one mesh wide,
of T90 and square mesh fewer, larger meshes between ropes as they are; with ``--always`` smeared ropes of these too. For
every plan the relative difference in drag and length, that in mean opening ahead, and the true errors of drag,
volume, radius and opening over those that the quick look states: the largest of each half of the plans, so that
widths found on one half are checked on the other. Between real ropes netting may hang in folds, found with contact
between its layers; nets that pass through themselves are no answers, and what takes longer than is allowed is none.
"""

from time import process_time

import click
import numpy as np

from codend.plan.plan import Plan, plan_from_dict
from codend.studies.study import Study, solve

SEED = 15
KNOT = 0.1
"""Of a mesh."""
KINDS = {"diamond": (1.0, {}), "knotted": (1.0, {"knot": 1}), "t90": (1.0, {"mesh": "t90", "knot": 1}),
         "square": (0.9, {"mesh": "square"})}  # fmt: skip
"""Entry over that of diamond netting, and what a section has else."""
RELATIVE = (("drag", "n"), ("length", "m"))
ESTIMATED = {
    "drag": "drag_n",
    "volume": "catch_volume_m3",
    "radius": "max_radius_m",
    "opening": "opening_ahead_deg",
}
"""What errors are stated of."""


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


class TooLong(Exception):
    """A plan that is not solved in the time allowed."""


QUICK: dict[str, object] = {"opening_accuracy_deg": 90.0}
SMEARED: dict[str, object] = {"fidelity": "smeared"}
REAL: dict[str, object] = {"fidelity": "sector"}


def found_within(plan: Plan, model: dict[str, object], seconds: float) -> Study:
    """The plan solved by a model in so much processor time."""
    asked = plan.model_copy(update={"model": plan.model.model_copy(update=model)})
    end = process_time() + seconds

    def watch(done: int, cases: int, doing: str) -> None:
        if process_time() > end:
            raise TooLong

    return solve(asked, watch)


def compare(plan: Plan, seconds: float = 60.0, look: dict[str, object] = QUICK) -> dict[str, float] | None:
    """Differences of a look less real ropes, and the true errors over the stated; None if either is not found."""
    try:
        studies = [found_within(plan, model, seconds) for model in (look, REAL)]
    except TooLong:
        return None
    if not all(study.converged for study in studies):
        return None
    quick, real = (study.table.iloc[0] for study in studies)
    found = {name: float(quick[f"{name}_{unit}"] / real[f"{name}_{unit}"] - 1.0) for name, unit in RELATIVE}
    found["opening"] = float(quick["opening_ahead_deg"] - real["opening_ahead_deg"])
    for name, size in ESTIMATED.items():
        error = next(column for column in quick.index if column.startswith(f"{size.rsplit('_', 1)[0]}_error"))
        found[f"{name} over"] = float(abs(quick[size] - real[size]) / quick[error])
    found["worst"] = max(found[f"{name} over"] for name in ESTIMATED)
    return found


@click.command()
@click.argument("plans", type=int, default=40)
@click.option("--kind", type=click.Choice(list(KINDS)), default="diamond")
@click.option("--seed", type=int, default=SEED)
@click.option("--seconds", default=60.0, show_default=True, help="Processor time that a model of a plan may take.")
@click.option("--always", is_flag=True, help="Smear ropes of every kind of netting.")
def main(plans: int, kind: str, seed: int, seconds: float, always: bool) -> None:
    """Print the table and the medians."""
    rng = np.random.default_rng(seed)
    rows: list[dict[str, float]] = []
    print(f"ropes short   EA N     round  drag %  length %  opening deg  true / stated: {', '.join(ESTIMATED)}; s")
    for number in range(plans):
        plan, began = random_plan(rng, kind), process_time()
        rope, found = plan.rope[0], compare(plan, seconds, SMEARED if always else QUICK)
        said = (
            f"{rope.number:5d} {rope.shortening:5.3f} {rope.axial_stiffness_n:9.0f} {plan.netting[0].meshes_round:7d}"
        )
        spent = process_time() - began
        if found is None:
            print(f"{said}  not solved; {spent:.0f}", flush=True)
            continue
        rows.append({**found, "half": number % 2})
        drag, length = 100.0 * found["drag"], 100.0 * found["length"]
        over = " ".join(f"{found[f'{name} over']:5.2f}" for name in ESTIMATED)
        print(f"{said} {drag:7.2f} {length:9.2f} {found['opening']:12.2f}    {over}; {spent:.0f}", flush=True)
    medians = [np.median(np.abs([row[name] for row in rows])) for name in ("drag", "length", "opening")]
    print(
        f"{len(rows)} of {plans} solved; medians: drag {100 * medians[0]:.2f} %, length {100 * medians[1]:.2f} %, "
        f"opening {medians[2]:.2f} deg"
    )
    for half, name in enumerate(("first, third ... plan", "second, fourth ... plan")):
        most = [max((row[f"{size} over"] for row in rows if row["half"] == half), default=np.nan) for size in ESTIMATED]
        print(f"{name}: true over stated at most " + ", ".join(f"{one:.2f}" for one in most))


if __name__ == "__main__":
    main()
