"""Time of asking every harmonic of an equilibrium: ``python -m validation.benchmark_harmonics``.

Prints milliseconds of processor time a catch, the tangent's assembly and the codline included, for the flume net, all
of whose 76 harmonics are stable, and for commercial codends (100 meshes round, full mesh 120 mm, EA 2 kN) of which many
grow: there the growing eigenvalues are found as well. Least and median of several. Beside them what is left in a study,
which needs the tangent for its errors: the median over a series of ten catches.
"""

from time import process_time

import numpy as np

from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.stability import stability_of, tangent_of
from codend.plan.plan import Case, Plan, load_plan, plan_from_dict
from codend.solvers.harmonics import harmonics_of
from codend.solvers.outcome import Solution
from validation.benchmark_equilibria import FLUME

CATCHES = [40.0 + 4.0 * number for number in range(10)]
REPEATS = 25
GOAL_IN_A_SERIES = 0.7


def commercial(mesh: str, bending_n_m2: float, catch_kg: float) -> Plan:
    """A codend of 100 x 50 meshes with knots of 15 mm."""
    netting = {"mesh": mesh, "meshes_round": 100, "meshes_long": 50, "bar_mm": 45.0, "knot_mm": 15.0, "twine_mm": 4.0}
    netting |= {"twines": 2, "axial_stiffness_n": 2000.0, "bending_stiffness_n_m2": bending_n_m2}
    return plan_from_dict(
        {
            "title": "commercial",
            "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": 0.4},
            "netting": [netting],
            "catch": {"mass_kg": catch_kg},
        }
    )


def in_a_series(plan: Plan) -> float:
    """Median milliseconds that a catch's harmonics take in a study, where its tangent is there."""
    scene = model_of(plan, 1, 1)
    known: list[tuple[Case, Solution]] = []
    times = []
    for case in plan.cases():
        problem, solution = equilibrium.solve(scene, case, known, None)
        known.append((case, solution))
        tangent = tangent_of(scene, problem, solution)
        least = np.inf
        for _ in range(5):
            started = process_time()
            stability_of(scene, tangent)
            least = min(least, 1e3 * (process_time() - started))
        times.append(least)
    return float(np.median(times))


def report(name: str, plan: Plan, goal: str) -> None:
    """Print a row for the first case of a plan; in a series, for all of them."""
    scene = model_of(plan, 1, 1)
    problem, solution = equilibrium.solve(scene, plan.cases()[0], (), None)
    harmonics = harmonics_of(problem, solution, scene.ring)
    times = []
    for _ in range(REPEATS):
        started = process_time()
        harmonics_of(problem, solution, scene.ring)
        times.append(1e3 * (process_time() - started))
    growing = [growth.harmonic for growth in harmonics.growing]
    said = f"{growing[0]} to {growing[-1]}, {harmonics.directions} directions" if growing else "none"
    print(
        f"{name:32}{scene.ring.order // 2 + 1:10}{scene.ring.size:10}{min(times):9.2f}{np.median(times):9.2f}"
        f"{goal:>8}{in_a_series(plan):11.2f}{'' if growing else GOAL_IN_A_SERIES:>8}   {said}"
    )


def main() -> None:
    """Print the table."""
    head = f"{'least ms':>9}{'median':>9}{'goal':>8}{'in series':>11}{'goal':>8}"
    print(f"{'':32}{'harmonics':>10}{'unknowns':>10}{head}   growing")
    report("flume, from 40 meshes filled", load_plan(FLUME, [f"catch.filled_meshes={CATCHES}"]), "5")
    report("limp T0, 300 kg", commercial("diamond", 0.0, 300.0), "")
    report("T0 of EI 2e-3 N m2, 300 kg", commercial("diamond", 2e-3, 300.0), "")
    report("T90, 300 kg", commercial("t90", 0.0, 300.0), "")


if __name__ == "__main__":
    main()
