"""Equilibrium of any net under loads, by whichever solver finds it."""

from collections.abc import Sequence
from dataclasses import replace

from codend.mechanics.problem import Problem
from codend.solvers import dynamic_relaxation, floating, gentle, in_turns, interior_point, newton
from codend.solvers.body_system import moored
from codend.solvers.outcome import Progress, Solution, Solver

IN_ORDER: Sequence[Solver] = (interior_point.solve, newton.solve, dynamic_relaxation.solve)
"""From the shape in which a net was built: the first needs no start nearby, the last one is slow and hard to upset."""
UNDER_CONTACT: Sequence[Solver] = (gentle.solve, dynamic_relaxation.solve)
"""The same for nets of which parts may touch: those that let nothing pass through anything on the way."""
POLISH = replace(newton.DIRECT, least_iterations=1)
"""One step more: in a net that is tight without loads, a length that is met to the tolerance leaves the tension off by
that over the strain."""


def find_equilibrium(
    problem: Problem, tolerance: float = 1e-9, start: Solution | None = None, progress: Progress | None = None
) -> Solution:
    """Equilibrium of a net under its loads, for nets that are no codend of a plan (``Net.from_bars``, ``Problem.of``).

    Args:
        problem: the net under its loads.
        tolerance: largest residual and axial imbalance (``mechanics.balance.out_of_balance``).
        start: positions and tensions to start from; the shape in which the net was built by default.
        progress: told the residual now and then.

    Returns:
        The solution of the first solver that finds one. Where none does, positions and tensions are nan, and the report
        tells what was tried.
    """
    if problem.body is not None:
        return _afloat(problem, tolerance, start, progress)
    attempts: list[str] = []
    spent_ms = 0.0
    for solve in IN_ORDER if problem.surface is None else UNDER_CONTACT:
        solution = solve(problem, tolerance, start, progress=progress)
        attempts += solution.report.attempts
        spent_ms += solution.report.solve_ms
        if solution.report.outcome.balanced:
            break
    solution = replace(solution, report=replace(solution.report, attempts=tuple(attempts), solve_ms=spent_ms))
    return polished(problem, tolerance, solution, progress) if solution.report.outcome.converged else solution


def polished(problem: Problem, tolerance: float, solution: Solution, progress: Progress | None = None) -> Solution:
    """An equilibrium one step of Newton's method nearer to the truth, if that finds one."""
    more = newton.solve(problem, tolerance, solution, POLISH, progress)
    attempts = (*solution.report.attempts, *more.report.attempts)
    spent_ms = solution.report.solve_ms + more.report.solve_ms
    better = more if more.report.outcome.converged else solution
    return replace(better, report=replace(better.report, attempts=attempts, solve_ms=spent_ms))


def _afloat(problem: Problem, tolerance: float, start: Solution | None, progress: Progress | None) -> Solution:
    """Equilibrium of a net with a floating body: at once, or in turns."""
    found = floating.solve(problem, tolerance, start, progress)
    if found.report.outcome.converged or not moored(problem):
        return found

    def held(net: Problem, from_there: Solution | None) -> tuple[Problem, Solution]:
        return net, find_equilibrium(net, tolerance, from_there, progress)

    _, turned = in_turns.solve(problem, tolerance, held, start)
    attempts = (*found.report.attempts, *turned.report.attempts)
    spent_ms = found.report.solve_ms + turned.report.solve_ms
    return replace(turned, report=replace(turned.report, attempts=attempts, solve_ms=spent_ms))
