"""Equilibria of one net along a growing catch: where the last ones lead, and a path in steps where that is too far.

Newton's method from the last equilibrium begins with the tangent's own prediction: its first step is taken along the
linearisation there. From two known equilibria on, the polynomial through the last of them is nearer.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from codend.mechanics.problem import Problem
from codend.solvers.outcome import Outcome, Solution

DEGREE = 2
"""Highest degree of the polynomial that is led through the last equilibria."""
HALVINGS = 6
"""Most halvings of the step along a path before it is given up."""


def predict(known: Sequence[tuple[float, Solution]], value: float) -> Solution:
    """Start for a catch from equilibria for others, all of different catches: the polynomial through the last ones.

    Tensions fall no lower than 0, or than a strut's last one. The report is that of the last equilibrium.
    """
    used = known[-(DEGREE + 1) :]
    if len(used) == 1:
        return used[0][1]
    catches = [catch for catch, _ in used]
    # Lagrange's weights at the new value
    weights = [math.prod((value - b) / (a - b) for b in catches if b != a) for a in catches]
    positions, tension = weights[0] * used[0][1].positions, weights[0] * used[0][1].bar_tension
    for weight, (_, solution) in zip(weights[1:], used[1:], strict=True):
        positions += weight * solution.positions
        tension += weight * solution.bar_tension
    last = used[-1][1]
    return replace(last, positions=positions, bar_tension=np.maximum(tension, np.minimum(last.bar_tension, 0.0)))


def with_catch(problem: Problem, value: float) -> Problem:
    """The same net with another size of the catch, in the unit of its kind of catch."""
    return replace(problem, loading=problem.loading._replace(catch=problem.loading.catch._replace(size=float(value))))


def in_steps(
    problem: Problem, known: tuple[float, Solution], solve: Callable[[Problem, Solution], Solution]
) -> Solution:
    """Equilibrium for the problem's catch, on a path of equilibria from one that is known for another catch.

    The step is the whole way at first; it is halved where ``solve`` fails and doubled where it succeeds. The report
    counts all iterations and all time of the path.

    Args:
        problem: the net under its loads.
        known: another catch, in the unit of the problem's kind, and the equilibrium for it.
        solve: finds the equilibrium of a problem from a start nearby.

    Raises:
        ValueError: the catch that is known is the problem's own: there is no path to it.
    """
    goal = problem.loading.catch.size
    if goal == known[0]:
        raise ValueError(f"the equilibrium known is for the same catch, {goal}")
    path = [known]
    step, shortest = goal - known[0], abs(goal - known[0]) / 2.0**HALVINGS
    iterations, spent = 0, 0.0
    while True:
        here = path[-1][0]
        value = goal if abs(goal - here) <= 1.001 * abs(step) else here + step
        solution = solve(with_catch(problem, value), predict(path, value))
        iterations, spent = iterations + solution.report.iterations, spent + solution.report.solve_ms
        solved = solution.report.outcome is Outcome.CONVERGED
        if solved and value != goal:
            path.append((value, solution))
            step *= 2.0
        elif solved or 0.5 * abs(step) < shortest:
            return replace(solution, report=replace(solution.report, iterations=iterations, solve_ms=spent))
        else:
            step *= 0.5
