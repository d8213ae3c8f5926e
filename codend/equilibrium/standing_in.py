"""A sector of nearly the ratio of the counts in place of a wide one in which no equilibrium is found.

Where much netting is spare at a joint it lies in folds, or hangs all but without load, and a wide sector then ends
unsolved after minutes. A narrow one mostly is solved in milliseconds; how far its counts are off is in its errors.
"""

from collections.abc import Sequence
from dataclasses import replace

from codend.bag.near_ratio import stand_ins
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.fidelity import Choice
from codend.equilibrium.starts import BRIEFLY
from codend.mechanics.problem import Problem
from codend.plan.plan import Case
from codend.solvers.outcome import Progress, Solution


def solve(
    model: BagModel,
    choice: Choice,
    case: Case,
    known: Sequence[tuple[Case, Solution]],
    progress: Progress | None,
) -> tuple[BagModel, Problem, Solution]:
    """Equilibrium of a case, and the model it was found on: the one that was chosen, or where it has none another.

    Where others may stand in for a wide sector it is tried ``BRIEFLY``; where they have no equilibrium either, by all
    there is.
    """
    plan = model.plan
    automatic = plan.model.fidelity == plan.model.method == "auto" and choice.fidelity == "sector"
    others = stand_ins(plan) if automatic else []
    problem, solution = equilibrium.solve(model, case, known, progress, BRIEFLY if others else None)
    if solution.report.outcome.balanced or not others:
        return model, problem, solution
    attempts, spent_ms = solution.report.attempts, solution.report.solve_ms
    for near in others:
        other = model_of(plan, 1, 1, near=near)
        its_problem, found = equilibrium.solve(other, case, (), progress, BRIEFLY)
        spent_ms += found.report.solve_ms
        if found.report.outcome.converged:
            report = replace(found.report, attempts=(*attempts, *found.report.attempts), solve_ms=spent_ms)
            return other, its_problem, replace(found, report=report)
    problem, solution = equilibrium.solve(model, case, known, progress)
    report = replace(solution.report, solve_ms=spent_ms + solution.report.solve_ms)
    return model, problem, replace(solution, report=report)
