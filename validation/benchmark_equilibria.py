"""Time of equilibria by the automatic method: ``python -m validation.benchmark_equilibria [--full]``.

Prints milliseconds a catch (solve alone, compiled, first guess included), started from the last catch and from nothing,
beside the goals and what the public axisymmetric program for knotted elastic codends takes; then how time grows with
the size of the net. With ``--full`` the 42 000 knots of the whole flume net are solved too.
"""

from pathlib import Path
from time import perf_counter

import click
import numpy as np

from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.plan.plan import Plan, load_plan, plan_from_dict
from codend.studies.study import solve

FLUME = Path(__file__).parent / "cases" / "flume_150x140.toml"
MESHES_LONG = (25, 50, 100, 200, 400, 700, 1000)
FACTORS = (10, 5, 2)


def knotted_t90(filled: list[float]) -> Plan:
    """T90, 100 x 100 meshes, knotted and elastic."""
    netting = {"mesh": "t90", "meshes_round": 100, "meshes_long": 100, "bar_mm": 45.0, "knot_mm": 5.0}
    return plan_from_dict(
        {
            "title": "T90 100 x 100",
            "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": 0.4},
            "netting": [netting | {"twine_mm": 4.0, "axial_stiffness_n": 1000.0}],
            "catch": {"filled_meshes": filled},
        }
    )


def report(name: str, plan: Plan, warm_goal: float, cold_goal: float, others: str) -> None:
    """Print a row: median of the warm catches and least of three first catches, with their goals in ms."""
    table = solve(plan).table
    order = np.argsort(table["filled_meshes"].to_numpy())
    warm = table["solve_ms"].to_numpy()[order][1:]
    first = min(float(solve(plan).table["solve_ms"].to_numpy()[order[0]]) for _ in range(3))
    state = "" if table["converged"].all() else "  NOT ALL CONVERGED"
    print(
        f"{name:34}{len(table):4}{np.median(warm):10.2f} (goal {warm_goal:g}){first:10.1f} (goal {cold_goal:g})"
        f"   {others}{state}"
    )


def exponent(sizes: list[float], times: list[float]) -> float:
    """Slope of log time over log size."""
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])


def growth_with_rows() -> float:
    """Exponent of the sector's warm solve time over the number of rows; prints the points.

    Catches are two meshes apart, as in the flume study; those that start from two others or more count.
    """
    times = []
    for meshes in MESHES_LONG:
        filled = [0.3 * meshes + 2.0 * step for step in range(9)]
        plan = load_plan(FLUME, [f"netting.0.meshes_long={meshes}", f"catch.filled_meshes={filled}"])
        times.append(float(np.median(solve(plan).table["solve_ms"][3:])))
        print(f"  sector of {2 * meshes:5} half-mesh rows: {times[-1]:8.2f} ms")
    return exponent(list(MESHES_LONG), times)


def growth_with_nodes(factors: tuple[int, ...]) -> float:
    """Exponent of the full net's solve time over its nodes, from the equilibrium of a sector; prints the points.

    The twine is given weight: without it the sector's equilibrium is that of the full net, with nothing left to solve.
    """
    nodes, times = [], []
    for g in factors:
        model = ["model.fidelity=globalised", f"model.globalisation={g}"] if g > 1 else ["model.fidelity=full"]
        plan = load_plan(FLUME, ["catch.filled_meshes=40", "netting.0.twine_density_kg_m3=1140", *model])
        started = perf_counter()
        model = model_of(plan, g, None)
        built = perf_counter() - started
        _, solution = equilibrium.solve(model, plan.cases()[0], (), None)
        nodes.append(len(model.bag.net.positions))
        times.append(solution.report.solve_ms)
        residual, outcome = solution.report.residual, solution.report.outcome.name
        print(
            f"  full net of {nodes[-1]:6} nodes: {times[-1]:9.1f} ms, residual {residual:.0e}, {outcome.lower()}, "
            f"{1e3 * built:.0f} ms to build and number"
        )
    return exponent(nodes, times)


@click.command()
@click.option("--full", is_flag=True, help="solve the whole flume net too")
def main(full: bool) -> None:
    """Print the tables."""
    forty = [10.0 + 2.0 * i for i in range(40)]
    print(f"{'':34}{'n':>4}{'from the last, ms':>20}{'from nothing, ms':>21}   others")
    report(
        "flume sector, sphere law and drag",
        load_plan(FLUME, [f"catch.filled_meshes={forty}"]),
        0.8,
        10.0,
        "public program, knotted elastic: 8.5 to 10, 30 to 900",
    )
    report(
        "T90 100 x 100 knotted elastic", knotted_t90(forty), 3.0, 25.0, "public program: from nothing 11 000 to 66 000"
    )
    tens = [10.0 * i for i in range(1, 11)]
    globalised = ["model.fidelity=globalised", "model.globalisation=10", f"catch.filled_meshes={tens}"]
    report("flume, full net globalised by 10", load_plan(FLUME, globalised), 20.0, 20.0, "")
    print(f"sector time grows with rows to the power {growth_with_rows():.2f} (goal: 1 or less)")
    factors = (*FACTORS, 1) if full else FACTORS
    print(f"full-net time grows with nodes to the power {growth_with_nodes(factors):.2f} (goal: 1.6 or less)")


if __name__ == "__main__":
    main()
