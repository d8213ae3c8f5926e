"""Time of asking every harmonic of an equilibrium: ``python -m validation.benchmark_harmonics``.

Prints milliseconds a catch, the tangent's assembly and the codline included, for the flume net, all of whose 76
harmonics are stable, and for commercial codends (100 meshes round, full mesh 120 mm, EA 2 kN) of which many grow: there
the growing eigenvalues are found as well. Least and median of several.
"""

from time import perf_counter

import numpy as np

from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.plan.plan import Plan, load_plan, plan_from_dict
from codend.solvers.harmonics import harmonics_of
from validation.benchmark_equilibria import FLUME

REPEATS = 25


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


def report(name: str, plan: Plan, goal: str) -> None:
    """Print a row for the first case of a plan."""
    scene = model_of(plan, 1, 1)
    problem, solution = equilibrium.solve(scene, plan.cases()[0], (), None)
    harmonics = harmonics_of(problem, solution, scene.ring)
    times = []
    for _ in range(REPEATS):
        started = perf_counter()
        harmonics_of(problem, solution, scene.ring)
        times.append(1e3 * (perf_counter() - started))
    growing = [growth.harmonic for growth in harmonics.growing]
    said = f"{growing[0]} to {growing[-1]}, {harmonics.directions} directions" if growing else "none"
    print(
        f"{name:32}{scene.ring.order // 2 + 1:10}{scene.ring.size:10}{min(times):9.2f}{np.median(times):9.2f}"
        f"{goal:>8}   {said}"
    )


def main() -> None:
    """Print the table."""
    print(f"{'':32}{'harmonics':>10}{'unknowns':>10}{'least ms':>9}{'median':>9}{'goal':>8}   growing")
    report("flume, 40 meshes filled", load_plan(FLUME, ["catch.filled_meshes=40"]), "5")
    report("limp T0, 300 kg", commercial("diamond", 0.0, 300.0), "")
    report("T0 of EI 2e-3 N m2, 300 kg", commercial("diamond", 2e-3, 300.0), "")
    report("T90, 300 kg", commercial("t90", 0.0, 300.0), "")


if __name__ == "__main__":
    main()
