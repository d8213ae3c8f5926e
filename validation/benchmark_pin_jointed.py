"""A square net of elastic bars, beside another program: ``python -m validation.benchmark_pin_jointed [--others]``.

N x N nodes joined by bars with pins, the edges held, the same load on every node square to the net; the load of a row
of nodes is 1 % of EA, which stretches the bars by 0.8 % in the mean. It has nothing of a codend, so programs for
frames and multibody systems solve it as well: with ``--others`` Exudyn, from the optional packages ``compare``. All
start from the same shallow bowl with the tensions of its stretch, or from nets of 1/4 and 1/2 as many nodes a side.

The residual of every answer is computed here from its displacements, in one way: the root of the sum of the squares of
what is out of balance over that of the loads. It is stricter than the largest force over the resultant, 1/N of which it
can be. Times are of the solve alone, the least of several; building the net and compiling are left out for all.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import click
import numpy as np
from scipy.interpolate import RegularGridInterpolator

from codend.equilibrium.start_shapes import START
from codend.mechanics.bars import add_bar_forces
from codend.mechanics.problem import Problem
from codend.net.net import Floats, bar_vectors
from codend.solvers import dynamic_relaxation, newton
from codend.solvers.newton import DIRECT
from codend.solvers.outcome import Solution
from validation.plain_nets import plain_net, plain_problem

LOAD = 0.01
"""Load of a row of nodes over EA."""
SAG = 0.07
"""Of the bowl to start from, over the side of the net."""
RESIDUAL = 1e-6
GOAL_S = 0.3
REPEATS = 3


@dataclass(frozen=True)
class Answer:
    """What a program found, and in what time."""

    name: str
    positions: Floats
    seconds: float
    iterations: str


def square_net(side: int, real_side: int) -> Problem:
    """A square net of 1 m with ``side`` nodes a side, for one with ``real_side``: fewer bars carry the same load."""
    merged = (real_side - 1) / (side - 1)
    node = np.arange(side * side).reshape(side, side)
    place = np.linspace(0.0, 1.0, side)
    x, y = np.meshgrid(place, place, indexing="ij")
    edge = np.ones((side, side), dtype=bool)
    edge[1:-1, 1:-1] = False
    bars = np.concatenate(
        [
            np.stack([node[:-1].ravel(), node[1:].ravel()], axis=1),
            np.stack([node[:, :-1].ravel(), node[:, 1:].ravel()], axis=1),
        ]
    )
    net = plain_net(
        np.stack([x.ravel(), y.ravel(), np.zeros(side * side)], axis=1),
        np.repeat(edge.reshape(-1, 1), 3, axis=1),
        bars,
        np.full(len(bars), 1.0 / (side - 1)),
        stiffness=merged,
    )
    problem = plain_problem(net, np.zeros(side * side))
    load = LOAD / (real_side - 1) * merged**2
    problem.loading.dead[:, 2] = np.where(net.fixed[:, 2], 0.0, load)
    return problem


def bowl(problem: Problem) -> Solution:
    """The start: a bowl of sines, and the tensions of the stretch in it."""
    positions = problem.net.positions.copy()
    sag = SAG * np.sin(np.pi * positions[:, 0]) * np.sin(np.pi * positions[:, 1])
    positions[:, 2] = np.where(problem.net.fixed[:, 2], 0.0, sag)
    return Solution(positions, _tensions(problem, positions), np.zeros(problem.bands), START)


def refined(coarse: Solution, problem: Problem) -> Solution:
    """A start from the solution of a coarser net: positions and tensions by cubic splines."""
    old, new = (int(np.sqrt(len(positions))) for positions in (coarse.positions, problem.net.positions))
    node_old, node_new = np.linspace(0.0, 1.0, old), np.linspace(0.0, 1.0, new)
    middle_old, middle_new = (0.5 * (nodes[1:] + nodes[:-1]) for nodes in (node_old, node_new))

    def between(values: Floats, axes: tuple[Floats, Floats], at: tuple[Floats, Floats]) -> Floats:
        spline = RegularGridInterpolator(axes, values, "cubic", bounds_error=False, fill_value=None)
        return np.asarray(spline(np.stack(np.meshgrid(*at, indexing="ij"), axis=-1)))

    positions = between(coarse.positions.reshape(old, old, 3), (node_old, node_old), (node_new, node_new))
    lengthwise, crosswise = np.split(coarse.bar_tension * (old - 1) / (new - 1), 2)
    along = between(lengthwise.reshape(old - 1, old), (middle_old, node_old), (middle_new, node_new))
    across = between(crosswise.reshape(old, old - 1), (node_old, middle_old), (node_new, middle_new))
    tension = np.concatenate([along.ravel(), across.ravel()])
    net = problem.net
    positions = np.where(net.fixed, net.positions, positions.reshape(-1, 3))
    return Solution(positions, tension, coarse.share, START)


def residual(problem: Problem, positions: Floats) -> float:
    """What is out of balance at given positions of elastic bars over the loads, both as root of the sum of squares."""
    force = problem.loading.dead.copy()
    length = np.linalg.norm(bar_vectors(problem.net, positions), axis=1)
    add_bar_forces(positions, problem.structure, _tensions(problem, positions) / length, force)
    return float(np.linalg.norm(force[~problem.net.fixed]) / np.linalg.norm(problem.loading.dead))


def _tensions(problem: Problem, positions: Floats) -> Floats:
    stretch = np.linalg.norm(bar_vectors(problem.net, positions), axis=1) / problem.net.bar_length - 1.0
    return np.asarray(np.maximum(stretch, 0.0) / problem.net.bar_flexibility)


def by_newton(problem: Problem, tolerance: float, start: Solution) -> Solution:
    """Newton's method."""
    return newton.solve(problem, _safe(problem, tolerance), start, DIRECT)


def by_relaxation(problem: Problem, tolerance: float, start: Solution) -> Solution:
    """Dynamic relaxation with kinetic damping."""
    return dynamic_relaxation.solve(problem, _safe(problem, tolerance), start)


def _safe(problem: Problem, tolerance: float) -> float:
    """Largest force over the loads and the tension, with room for the bars' law, to which solvers hold them apart."""
    return 0.02 * tolerance / len(problem.net.positions)


def ours(
    name: str,
    method: Callable[[Problem, float, Solution], Solution],
    sides: Sequence[int],
    tolerance: float = RESIDUAL,
    repeats: int = REPEATS,
) -> Answer:
    """Solve nets with ``sides`` nodes a side one after the other, each from the last one's solution."""
    problems = [square_net(side, sides[-1]) for side in sides]
    best = np.inf
    for _ in range(repeats):
        began = perf_counter()
        solution = method(problems[0], tolerance, bowl(problems[0]))
        steps = [solution.report.iterations]
        for problem in problems[1:]:
            solution = method(problem, tolerance, refined(solution, problem))
            steps.append(solution.report.iterations)
        best = min(best, perf_counter() - began)
    return Answer(name, solution.positions, best, " + ".join(map(str, steps)))


def exudyn(problem: Problem, repeats: int = REPEATS) -> Answer:
    """Exudyn's static solver: a mass point a node, a spring a bar, sparse Newton with the default tolerances."""
    import exudyn as exu
    from exudyn.itemInterface import (
        LoadForceVector,
        MarkerNodePosition,
        NodePoint,
        NodePointGround,
        ObjectConnectorSpringDamper,
        ObjectMassPoint,
    )

    net, start = problem.net, bowl(problem).positions
    best = np.inf
    for _ in range(repeats):
        system = exu.SystemContainer().AddSystem()
        markers, numbers = [], {}
        for node, (built, begun, held) in enumerate(zip(net.positions, start, net.fixed, strict=True)):
            if held.all():
                number = system.AddNode(NodePointGround(referenceCoordinates=list(built)))
            else:
                number = system.AddNode(
                    NodePoint(referenceCoordinates=list(built), initialCoordinates=list(begun - built))
                )
                system.AddObject(ObjectMassPoint(mass=1.0, nodeNumber=number))
                numbers[node] = number
            markers.append(system.AddMarker(MarkerNodePosition(nodeNumber=number)))
            if node in numbers:
                system.AddLoad(LoadForceVector(markerNumber=markers[-1], loadVector=list(problem.loading.dead[node])))
        for (first, second), length, flexibility in zip(net.bars, net.bar_length, net.bar_flexibility, strict=True):
            system.AddObject(
                ObjectConnectorSpringDamper(
                    markerNumbers=[markers[first], markers[second]],
                    referenceLength=length,
                    stiffness=1.0 / (flexibility * length),
                )
            )
        system.Assemble()
        settings = exu.SimulationSettings()
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        settings.staticSolver.verboseMode = 0
        settings.solution.file.write = False
        began = perf_counter()
        system.SolveStatic(settings)
        best = min(best, perf_counter() - began)
    positions = net.positions.copy()
    for node, number in numbers.items():
        positions[node] = system.GetNodeOutput(number, exu.OutputVariableType.Position)
    return Answer(f"Exudyn {exu.config.Version()}", positions, best, "")


def report(problem: Problem, answers: Sequence[Answer], exact: Floats) -> None:
    """Print a row an answer; displacements are compared with ``exact`` over its largest."""
    largest = np.abs(exact - problem.net.positions).max()
    for answer in answers:
        error = np.abs(answer.positions - exact).max() / largest
        print(
            f"{answer.name:44}{answer.seconds:9.3f}{residual(problem, answer.positions):10.0e}{error:12.0e}"
            f"{answer.positions[:, 2].max():16.10f}   {answer.iterations}"
        )


@click.command()
@click.option("--size", default=100, show_default=True, help="Nodes a side.")
@click.option("--others", is_flag=True, help="Solve it with Exudyn too (pip install -e '.[compare]').")
def main(size: int, others: bool) -> None:
    """Print the table."""
    problem = square_net(size, size)
    through = (size // 4, size // 2, size)
    exact = ours("", by_newton, [size], tolerance=1e-10, repeats=1)
    library = newton.prepare(problem.structure, problem.bands).system.name
    print(f"{size} x {size} nodes, {len(problem.net.bars)} bars, residual {RESIDUAL:g}; goal at 100: {GOAL_S:g} s")
    print(f"mean strain of the bars {np.mean(_tensions(problem, exact.positions)):.2e}")
    print(f"{'':44}{'s':>9}{'residual':>10}{'difference':>12}{'largest sag':>16}   iterations")
    answers = [
        ours(f"Newton ({library})", by_newton, [size]),
        ours(f"Newton ({library}) through coarser nets", by_newton, through),
        ours("dynamic relaxation", by_relaxation, [size]),
        ours("dynamic relaxation through coarser nets", by_relaxation, through),
    ]
    if others:
        answers.append(exudyn(problem))
    report(problem, answers, exact.positions)


if __name__ == "__main__":
    main()
