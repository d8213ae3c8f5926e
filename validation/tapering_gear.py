"""Random tapering plans with ropes or windows by ``auto``: ``python -m validation.tapering_gear [PLANS] [--seed S]``.

A belly of two panels, or a tube, tapers into a codend; it has ropes along its seams, a window, or both. For every plan
the model that was chosen, its knots, how it ended, the processor time, the stability, and how far aside the codline
lies; what is not solved is told in the words of its last attempt. What takes longer than is allowed is none.
"""

from time import process_time

import click
import numpy as np

from codend.errors import InputError
from codend.plan.plan import Plan, plan_from_dict
from codend.studies.study import Study
from validation.smeared_ropes import TooLong, found_within

SEED = 71
GEAR = ("ropes", "window", "both")


def random_window(rng: np.random.Generator, mesh_mm: float, belly: int, codend: int, panel: int) -> dict:
    """A window of square, T90 or other meshes in the upper panel of the codend or the belly ahead of it."""
    deep = int(rng.integers(4, 11))
    behind, long, name = [(0, codend, "codend"), (codend, belly, "belly")][int(rng.integers(2))]
    near = behind + int(rng.integers(1, max(2, long - deep)))
    across = max(3, int(panel * rng.uniform(0.3, 0.7)))
    mesh = str(rng.choice(["square", "t90", "diamond"]))
    own = {
        "square": {"bar_mm": mesh_mm / 2, "meshes_round": max(2, int(across * rng.uniform(0.6, 1.0))),
                   "meshes_long": 2 * deep},
        "t90": {"mesh_mm": mesh_mm, "knot_mm": 0.1 * mesh_mm, "meshes_long": deep,
                "meshes_round": max(2, int(across * rng.uniform(0.5, 0.8)))},
        "diamond": {"mesh_mm": mesh_mm * deep / (deep + 1), "meshes_round": across, "meshes_long": deep + 1},
    }[mesh]  # fmt: skip
    return {
        **own, "mesh": mesh, "twine_mm": 3.0, "axial_stiffness_n": 1000.0, "netting": name, "panel": "upper",
        "meshes_from_codline": [near, near + deep], "meshes_across": across,
    }  # fmt: skip


def random_plan(rng: np.random.Generator, gear: str) -> Plan:
    """A tapering plan; netting of 28 to 160 meshes round at its fore end, ropes up to 12 % short."""
    while True:
        fore = 2 * int(np.exp(rng.uniform(np.log(14), np.log(80))))
        aft = 2 * int(fore * rng.uniform(0.5, 0.8) / 2)
        belly, codend = (int(rng.integers(low, high)) for low, high in ((fore - aft, 2 * (fore - aft) + 6), (15, 40)))
        mesh_mm = float(rng.uniform(60.0, 120.0))
        panels = int(rng.choice([1, 2, 2, 2])) if gear == "window" else 2
        netting = {
            "mesh": "diamond", "mesh_mm": mesh_mm, "knot_mm": float(rng.choice([0.0, 0.1])) * mesh_mm, "twine_mm": 3.0,
            "axial_stiffness_n": 1000.0, "panels": panels,
        }  # fmt: skip
        rope = {
            "number": 2, "shortening": float(rng.uniform(0.0, 0.12)),
            "axial_stiffness_n": float(10.0 ** rng.uniform(3.5, 5.5)),
        }  # fmt: skip
        plan = {
            "title": "random belly",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1025.0},
            "entry": {"hanging_ratio": float(rng.uniform(0.25, 0.45))},
            "netting": [
                netting | {"meshes_round": fore, "meshes_round_aft": aft, "meshes_long": belly, "name": "belly"},
                netting | {"meshes_round": aft, "meshes_long": codend, "name": "codend"},
            ],
            "rope": [rope] if gear != "window" else [],
            "window": [random_window(rng, mesh_mm, belly, codend, aft // 2)] if gear != "ropes" else [],
            "catch": {"filled_meshes": float(rng.uniform(0.25, 0.9)) * codend, "pressure": "uniform"},
        }
        try:
            return plan_from_dict(plan)
        except InputError:
            continue  # a window that has no place there


def told(plan: Plan, study: Study) -> str:
    """How the only case of a plan ended."""
    choice, case = study.choice, study.cases[0]
    model = f"{choice.fidelity} {choice.globalisation} {len(case.bag.net.positions):6d} knots"
    if not case.converged:
        return f"{model}  unsolved: {case.report.attempts[-1]}"
    row = study.table.iloc[0]
    stands = " (stands in)" if case.stands_in is not None else ""
    aside = float(np.hypot(*case.solution.positions[len(case.bag.net.positions) - 1 - case.bag.anchors, 1:]))
    return (
        f"{model}{stands}  {row['drag_n']:.1f} +- {row['drag_error_n']:.1g} N, {row['opening_ahead_deg']:.1f} +- "
        f"{row['opening_ahead_error_deg']:.1g} deg, stable {row['stable']}, codline {aside:.3f} m aside"
    )


@click.command()
@click.argument("plans", type=int, default=17)
@click.option("--seed", type=int, default=SEED)
@click.option("--only", type=int, default=None, help="Number of the one plan to solve.")
@click.option("--seconds", default=100.0, show_default=True, help="Processor time that a plan may take.")
def main(plans: int, seed: int, only: int | None, seconds: float) -> None:
    """Print a line a plan."""
    rng = np.random.default_rng(seed)
    for number in range(plans):
        gear = GEAR[number % len(GEAR)]
        plan = random_plan(rng, gear)
        if only not in (None, number):
            continue
        first, last = plan.netting
        said = f"{number:2d} {gear:6s} {first.meshes_round:3d} to {last.meshes_round:3d}, {first.meshes_long:3d}+"
        said += f"{last.meshes_long:2d}"
        if plan.window:
            window = plan.window[0]
            said += f", {window.mesh} in {window.netting} {window.meshes_across}"
        began = process_time()
        try:
            ended = told(plan, found_within(plan, {}, seconds))
        except TooLong:
            ended = "not ended"
        print(f"{said}: {process_time() - began:.1f} s  {ended}", flush=True)


if __name__ == "__main__":
    main()
