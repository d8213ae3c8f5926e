"""How long catches of panels with ropes and of nets with windows take: ``python -m validation.panel_speed [--small]``.

Processor time of one thread where ``OMP_NUM_THREADS=1`` is set, without compilation: the first case of every model is
solved twice. A catch in a series is one that follows others. Two ropes alone draw a bag that is nearly empty into two
lobes that pass through each other, which is refused: the catches here are a fifth of the net.
"""

import sys
from collections.abc import Iterator
from time import process_time

from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.plan.plan import Case, Plan, plan_from_dict
from codend.solvers.outcome import Solution

ROPE = {"number": 2, "shortening": 0.1, "axial_stiffness_n": 5e3, "diameter_mm": 20.0}
WINDOW = {
    "mesh": "square", "meshes_round": 20, "meshes_long": 40, "bar_mm": 50.0, "twine_mm": 4.0, "axial_stiffness_n": 1e3,
    "netting": "2", "panel": "upper", "meshes_from_codline": [30, 50], "meshes_across": 20,
}  # fmt: skip


def panels(long: tuple[int, int], windows: list[dict]) -> Plan:
    """Two panels of 50 open meshes with two ropes, or without ropes and with windows; twine of EA 1 kN, assumed."""
    section = {
        "mesh": "diamond", "meshes_round": 100, "bar_mm": 50.0, "twine_mm": 4.0, "panels": 2, "axial_stiffness_n": 1e3
    }  # fmt: skip
    return plan_from_dict(
        {
            "title": "two panels",
            "tow": {"speed_m_s": 1.0},
            "entry": {"radius_m": 0.6},
            "netting": [{**section, "meshes_long": meshes} for meshes in long],
            "rope": [] if windows else [ROPE],
            "window": windows,
            "catch": {"filled_meshes": [30, 32, 34], "pressure": "uniform", "coefficient": 1.4},
        }
    )


def seconds(plan: Plan, globalisation: int, sectors: int | None) -> Iterator[tuple[float, float, str]]:
    """Catch, processor time and outcome of every case of a plan, in series."""
    model = model_of(plan, globalisation, sectors)
    known: list[tuple[Case, Solution]] = []
    cases = plan.cases()
    equilibrium.solve(model, cases[0], (), None)
    for case in cases:
        began = process_time()
        _, solution = equilibrium.solve(model, case, known, None)
        yield case.catch_value, process_time() - began, solution.report.outcome.name
        if solution.report.outcome.converged:
            known.append((case, solution))


def main() -> None:
    """Print a line a catch."""
    small = "--small" in sys.argv[1:]
    long = (40, 60) if small else (50, 100)
    models = [
        ("two ropes, order 2, merged 10 x 10", panels(long, []), 10, 1),
        ("two ropes, order 2, merged 5 x 5", panels(long, []), 5, 1),
        ("window, full net, merged 10 x 10", panels(long, [WINDOW]), 10, None),
        ("window, full net, merged 5 x 5", panels(long, [WINDOW]), 5, None),
    ]
    if not small:
        models += [
            ("two ropes, order 2", panels(long, []), 1, 1),
            ("window, full net", panels(long, [WINDOW]), 1, None),
        ]
    for name, plan, globalisation, sectors in models:
        for catch, spent, outcome in seconds(plan, globalisation, sectors):
            print(f"{name:36s} {catch:5g} meshes {spent:8.3f} s  {outcome}", flush=True)


if __name__ == "__main__":
    main()
