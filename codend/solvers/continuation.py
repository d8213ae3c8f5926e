"""Equilibria of one net along a growing catch: each starts from where the last ones lead."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from codend.problem import Problem
from codend.solvers import newton
from codend.solvers.newton import NewtonSettings, Prepared
from codend.solvers.outcome import Progress, Solution

DEGREE = 2
"""Highest degree of the polynomial that is led through the last equilibria."""


def solve_along(
    problem: Problem,
    catch_values: Sequence[float],
    tolerance: float,
    start: Solution | None = None,
    settings: NewtonSettings | None = None,
    progress: Progress | None = None,
) -> list[Solution]:
    """Equilibria for each of ``catch_values``, in order, of a net under loads that are otherwise the same.

    Where the step from one catch to the next is too long for Newton's method, it is halved, up to five times; what is
    solved on the way is not returned. A catch that cannot be reached so is solved from scratch.

    Args:
        problem: the net under its loads; its own catch value does not matter.
        catch_values: filled meshes, distances of the front in m or volumes in m3, by the problem's kind of catch.
        tolerance: as in ``newton.solve``.
        start: equilibrium to start from, for a catch near the first one.
        settings: for Newton's method; only the first and the unreachable catches use its rough starts.
        progress: told the residual of every iteration.
    """
    settings = settings or NewtonSettings()
    prepared = newton.prepare(problem.structure)
    direct = replace(settings, rough_starts=())
    known: list[tuple[float, Solution]] = []
    solutions = []
    for value in catch_values:
        target = with_catch(problem, value)
        solution = None
        if known:
            solution = _reach(target, known, tolerance, direct, progress, prepared)
        if solution is None:
            solution = newton.solve(target, tolerance, start if not known else None, settings, progress, prepared)
        if solution.report.outcome.converged:
            known.append((value, solution))
        solutions.append(solution)
    return solutions


def with_catch(problem: Problem, value: float) -> Problem:
    """The same net with another size of the catch, in the unit of its kind of catch."""
    return replace(problem, loading=problem.loading._replace(catch_value=float(value)))


def predict(known: Sequence[tuple[float, Solution]], value: float) -> Solution:
    """Start for a catch from equilibria for others: positions and tensions on the polynomial through the last ones.

    Tensions that would be negative are set to 0. The report is that of the last equilibrium.
    """
    used = known[-(DEGREE + 1) :]
    at = np.array([catch for catch, _ in used])
    # Lagrange's weights at the new value
    weights = [np.prod((value - np.delete(at, i)) / (at[i] - np.delete(at, i))) for i in range(len(at))]
    positions = sum(w * s.positions for w, (_, s) in zip(weights, used, strict=True))
    tension = sum(w * s.bar_tension for w, (_, s) in zip(weights, used, strict=True))
    last = used[-1][1]
    return replace(last, positions=np.asarray(positions), bar_tension=np.maximum(tension, 0.0))


def _reach(
    target: Problem,
    known: list[tuple[float, Solution]],
    tolerance: float,
    settings: NewtonSettings,
    progress: Progress | None,
    prepared: Prepared,
) -> Solution | None:
    """Step from the last known equilibrium to the target's catch, in more than one step if need be."""
    path = list(known)
    goal = target.loading.catch_value
    step, halvings = goal - path[-1][0], 0
    if step == 0.0:
        return newton.solve(target, tolerance, path[-1][1], settings, progress, prepared)
    while True:
        value = goal if abs(goal - path[-1][0]) <= abs(step) * (1.0 + 1e-9) else path[-1][0] + step
        solution = newton.solve(
            with_catch(target, value), tolerance, predict(path, value), settings, progress, prepared
        )
        if solution.report.outcome.converged:
            if value == goal:
                return solution
            path.append((value, solution))
        elif halvings == 5:
            return None
        else:
            halvings += 1
            step *= 0.5
