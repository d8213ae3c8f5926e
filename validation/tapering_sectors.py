"""Narrow sectors of netting that tapers beside exact ones: ``python -m validation.tapering_sectors [PLANS] [--ropes]``.

For random plans of two panels that taper into a codend, with or without ropes along their seams, the relative
differences in drag, volume and largest radius and that in the opening ahead of the quick looks that are solved
(``codend.bag.near_ratio.quick_looks``), and the true errors over those that they state.
"""

from dataclasses import replace
from time import process_time

import click
import numpy as np

from codend.bag.near_ratio import NearRatio, quick_looks
from codend.equilibrium.fidelity import choose
from codend.plan.plan import Plan, plan_from_dict
from codend.studies.study import Study, solve
from validation.smeared_ropes import ESTIMATED, REAL, TooLong, found_within

SEED = 33


def random_plan(rng: np.random.Generator, ropes: bool) -> Plan:
    """A belly of two panels that tapers into a codend, with two ropes up to 12 % short along its seams, or none."""
    fore = 2 * int(rng.integers(14, 25))
    aft = 2 * int(fore * rng.uniform(0.5, 0.8) / 2)
    belly, codend = (int(rng.integers(low, high)) for low, high in ((fore - aft, 2 * (fore - aft) + 6), (15, 28)))
    mesh_mm = float(rng.uniform(60.0, 120.0))
    netting = {
        "mesh": "diamond",
        "mesh_mm": mesh_mm,
        "knot_mm": float(rng.choice([0.0, 0.1])) * mesh_mm,
        "twine_mm": 3.0,
        "axial_stiffness_n": 1000.0,
        "panels": 2,
    }
    rope = {
        "number": 2,
        "shortening": float(rng.uniform(0.0, 0.12)),
        "axial_stiffness_n": float(10.0 ** rng.uniform(3.5, 5.5)),
    }
    return plan_from_dict(
        {
            "title": "random belly",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1025.0},
            "entry": {"hanging_ratio": float(rng.uniform(0.25, 0.45))},
            "netting": [
                netting | {"meshes_round": fore, "meshes_round_aft": aft, "meshes_long": belly},
                netting | {"meshes_round": aft, "meshes_long": codend},
            ],
            "rope": [rope] if ropes else [],
            "catch": {"filled_meshes": float(rng.uniform(0.25, 0.9)) * codend, "pressure": "uniform"},
        }
    )


def solved_on(plan: Plan, near: NearRatio) -> Study:
    """The plan solved on a narrow sector."""
    exact = plan.model_copy(update={"model": plan.model.model_copy(update={"fidelity": "sector"})})
    return solve(plan, choice=replace(choose(exact), fidelity="smeared", near=near))


@click.command()
@click.argument("plans", type=int, default=10)
@click.option("--ropes", is_flag=True, help="Two ropes along the seams.")
@click.option("--seed", type=int, default=SEED)
@click.option("--seconds", default=60.0, show_default=True, help="Processor time that a model of a plan may take.")
def main(plans: int, ropes: bool, seed: int, seconds: float) -> None:
    """Print the table."""
    rng = np.random.default_rng(seed)
    print(
        "round     long  short   wide  step  s exact  s narrow  drag %  volume %  radius %  opening deg  true / stated"
    )
    for _ in range(plans):
        plan = random_plan(rng, ropes)
        first, last = plan.netting
        said = f"{first.meshes_round:3d} to {last.meshes_round:2d} {first.meshes_long:3d}+{last.meshes_long:2d}"
        said += f" {plan.rope[0].shortening if plan.rope else 0.0:6.3f}"
        began = process_time()
        try:
            exact = found_within(plan, REAL, seconds)
        except TooLong:
            print(f"{said}  exact one not found in {seconds:g} s", flush=True)
            continue
        spent = process_time() - began
        if not exact.converged:
            print(f"{said}  exact one not solved", flush=True)
            continue
        truth = exact.table.iloc[0]
        for near in quick_looks(plan):
            began = process_time()
            study = solved_on(plan, near)
            own_s, found = process_time() - began, study.table.iloc[0]
            if not study.converged:
                print(f"{said} {near.columns[0]:3d}/{min(near.columns):<2d}  not solved, {own_s:.1f} s", flush=True)
                continue
            off = [found[name] / truth[name] - 1.0 for name in list(ESTIMATED.values())[:3]]
            opening = found["opening_ahead_deg"] - truth["opening_ahead_deg"]
            over = []
            for size in ESTIMATED.values():
                error = next(column for column in found.index if column.startswith(f"{size.rsplit('_', 1)[0]}_error"))
                over.append(abs(found[size] - truth[size]) / found[error])
            print(
                f"{said} {near.columns[0]:3d}/{min(near.columns):<2d} {near.step:.3f} {spent:7.1f} {own_s:8.1f} "
                + " ".join(f"{100 * one:8.2f}" for one in off)
                + f" {opening:8.2f}  "
                + " ".join(f"{one:5.2f}" for one in over),
                flush=True,
            )


if __name__ == "__main__":
    main()
