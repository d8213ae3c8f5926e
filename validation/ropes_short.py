"""How far short ropes open the meshes ahead of the catch: ``python -m validation.ropes_short``.

The net of the project's issue on ropes: 50 x 50 meshes of 100 mm full mesh and EA 1 kN, entry 0.3 m, a uniform pressure
of 1.4 times the stagnation pressure at 0.8 m/s, two and four ropes of EA 5 kN. How much the net has caught and whether
the twine has drag are not said there, and both count: the openings are told for several catches, with drag and without.
"""

from collections.abc import Iterator
from time import process_time

from codend.bag.measures import Measures, measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.plan.plan import Plan, plan_from_dict

CATCHES = (8.0, 10.0, 12.0, 16.0, 20.0)
"""In meshes from the codline."""


def plan_with(number: int, shortening: float, filled: float, drag: bool = True) -> Plan:
    """The net with so many ropes, with none for 0."""
    section = {"mesh": "diamond", "meshes_round": 50, "meshes_long": 50, "mesh_mm": 100.0, "twine_mm": 3.0}
    rope = {"number": number, "shortening": shortening, "axial_stiffness_n": 5e3}
    return plan_from_dict(
        {
            "title": "short ropes",
            "tow": {"speed_m_s": 0.8},
            "entry": {"radius_m": 0.3},
            "netting": [{**section, "axial_stiffness_n": 1e3}],
            "rope": [rope] if number else [],
            "catch": {"filled_meshes": filled, "pressure": "uniform", "coefficient": 1.4},
            "drag": {} if drag else {"normal": 0.0, "tangential": 0.0},
        }
    )


def measured(plan: Plan) -> Measures | None:
    """What its sector measures, real ropes and all; None where it is not solved."""
    model = model_of(plan, 1, 1)
    problem, solution = equilibrium.solve(model, plan.cases()[0], (), None)
    return measure_all(model.bag, problem, solution)[2] if solution.report.outcome.converged else None


def rows() -> Iterator[str]:
    """A line a catch and number of ropes."""
    for drag in (True, False):
        for filled in CATCHES:
            tube = measured(plan_with(0, 0.0, filled, drag))
            assert tube is not None
            for number in (2, 4):
                said = f"{'with' if drag else 'without'} twine drag, {filled:2g} meshes caught, {number} ropes:"
                for shortening in (0.1, 0.2):
                    began = process_time()
                    found = measured(plan_with(number, shortening, filled, drag))
                    spent = process_time() - began
                    told = "not solved"
                    if found is not None:
                        opened = found.opening_ahead_deg - tube.opening_ahead_deg
                        told = f"{opened:+5.1f} degrees, drag {100.0 * (found.drag_n / tube.drag_n - 1.0):+5.1f} %"
                    said += f"  {shortening:.0%} short {told} ({spent:.1f} s)"
                yield said


def main() -> None:
    """Print the table."""
    for row in rows():
        print(row, flush=True)


if __name__ == "__main__":
    main()
