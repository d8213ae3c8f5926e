"""Random plans through the automatic method: ``python -m validation.random_plans [--plans 500] [--seed 0]``.

Every plan must converge to 1e-8 with no bar in compression and its axial balance within 1e-8; the table prints the
share solved by each step of the fall-back list. A plan that fails is followed from a slow tow to its own speed: where
its equilibria end before, with soft twine that balloons, there was none to be found, and it counts apart. Exits with 1
if any other plan failed.
"""

import sys
from collections import Counter

import click
import numpy as np

from codend.plan.plan import Plan, plan_from_dict
from codend.studies.case_result import CaseResult
from codend.studies.study import solve

TOLERANCE = 1e-8
FOLLOWED = np.linspace(0.3, 1.0, 36)
"""Speeds at which a plan that fails is followed, over its own."""


def random_plan(rng: np.random.Generator) -> Plan:
    """A plan of the working range: mesh counts, twine, speed and catch of flume models and commercial codends."""
    mesh = str(rng.choice(["diamond", "t90"]))
    meshes_round, meshes_long = int(rng.integers(40, 201)), int(rng.integers(30, 151))
    bar_mm = float(rng.uniform(15.0, 80.0))
    knot_mm = float(rng.choice([0.0, rng.uniform(0.0, 0.2)])) * bar_mm
    across = bar_mm + (knot_mm if mesh == "t90" else 0.0)
    netting: dict[str, object] = {
        "mesh": mesh,
        "meshes_round": meshes_round,
        "meshes_long": meshes_long,
        "bar_mm": bar_mm,
        "knot_mm": knot_mm,
        "twine_mm": float(rng.uniform(0.02, 0.1)) * bar_mm,
    }
    if rng.random() < 0.5:
        netting["axial_stiffness_n"] = float(np.exp(rng.uniform(np.log(500.0), np.log(1e5))))
    filled = float(np.exp(rng.uniform(0.0, np.log(0.9 * meshes_long)))) if rng.random() < 0.9 else float(meshes_long)
    return plan_from_dict(
        {
            "title": "random",
            "tow": {"speed_m_s": float(rng.uniform(0.3, 2.5)), "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": float(rng.uniform(0.15, 0.6)) * meshes_round * across / 1000.0 / np.pi},
            "netting": [netting],
            "catch": {"filled_meshes": filled, "pressure": str(rng.choice(["sphere", "uniform"]))},
            "model": {"fidelity": "sector", "tolerance": TOLERANCE},
        }
    )


def fault(result: CaseResult) -> str:
    """What is wrong with a result, empty if nothing is."""
    if not result.converged:
        return f"not converged: {result.report.attempts[-1]}"
    if np.any(result.bar_tension_n < 0.0):
        return "bars in compression"
    balance = abs(result.measures.entry_reaction_n / result.measures.drag_n - 1.0)
    if balance > 1.5 * TOLERANCE:
        return f"axial balance {balance:.1e}"
    if max(result.report.residual, result.report.imbalance) > TOLERANCE or result.report.length_error > 1e-6:
        return f"residual {result.report.residual:.1e}, length error {result.report.length_error:.1e}"
    return ""


def last_speed_m_s(plan: Plan) -> float:
    """Fastest tow, up to the plan's own, to which its equilibria can be followed in small steps; 0 if there is none."""
    tables = plan.to_dict()
    (asked,) = plan.tow.speed_m_s
    tables["tow"]["speed_m_s"] = (asked * FOLLOWED).tolist()
    solved = [result.case.speed_m_s for result in solve(plan_from_dict(tables)).cases if result.converged]
    return max(solved, default=0.0)


@click.command()
@click.option("--plans", default=500, show_default=True)
@click.option("--seed", default=0, show_default=True)
def main(plans: int, seed: int) -> None:
    """Solve random plans and tell which step of the fall-back list solved them."""
    by_start: Counter[str] = Counter()
    times: list[float] = []
    faults, ended = [], []
    for number in range(plans):
        plan = random_plan(np.random.default_rng([seed, number]))
        result = solve(plan).cases[0]
        times.append(result.report.solve_ms)
        if reason := fault(result):
            told = f"plan {number}: {reason}\n  {plan.netting[0]} {plan.catch.filled_meshes}"
            (asked,) = plan.tow.speed_m_s
            if not result.converged and 0.0 < (last := last_speed_m_s(plan)) < FOLLOWED[-2] * asked:
                by_start["no equilibrium at that speed"] += 1
                ended.append(f"{told}\n  {asked:.3f} m/s asked for, its equilibria end at about {last:.3f} m/s")
            else:
                by_start["failed"] += 1
                faults.append(told)
        else:
            by_start[result.report.attempts[-1].split(":")[0]] += 1
    for start, count in by_start.most_common():
        print(f"{start:40} {count:5}  {100.0 * count / plans:6.2f} %")
    median, late = np.quantile(times, [0.5, 0.9])
    print(f"solve time: median {median:.1f} ms, 90 % {late:.1f} ms, most {max(times):.0f} ms")
    for line in ended + faults:
        print(line)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
