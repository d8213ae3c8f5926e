"""A narrow sector in place of a wide one in which no equilibrium is found.

Where much netting is spare at a joint it lies in folds, or hangs all but without load, and a wide sector then ends
unsolved after minutes. One of nearly the ratio of the counts mostly is solved in milliseconds; how far its counts are
off is in its errors. Between short ropes netting may hang so slack that it flutters, or lie in folds to which no start
leads: there fewer, larger meshes stand between T90's and square mesh's ropes, and others' are smeared. What that costs
is in the errors; that of the weight too where it is left out.
"""

from collections.abc import Sequence
from dataclasses import replace

from codend.bag.near_ratio import quick_looks, smeared_sectors, stand_ins
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.accuracy import between_ropes_errors
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.fidelity import Choice
from codend.equilibrium.situation import MOST_RELAXED
from codend.equilibrium.starts import BETWEEN_ROPES, BRIEFLY, STARTS, Start
from codend.mechanics.problem import Problem
from codend.plan.merging import between_ropes
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
    automatic = plan.model.fidelity == plan.model.method == "auto"
    by_ratio = stand_ins(plan) if automatic and choice.fidelity == "sector" else []
    others = [model_of(plan, 1, 1, near=near) for near in by_ratio]
    starts: tuple[Start, ...] = BRIEFLY
    if automatic and plan.rope and not (model.smeared or plan.window):
        others = [*_between_ropes(model)]
        others += [model_of(plan, 1, 1, smeared=True, near=near) for near in smeared_sectors(plan)]
        large = len(model.bag.net.positions) > MOST_RELAXED
        starts = BETWEEN_ROPES if large or model.between_ropes else STARTS["auto"]
    if choice.fidelity == "smeared" and choice.near is not None:
        # not every catch is solved on the one that the first is
        others = [model_of(plan, 1, 1, smeared=True, near=near) for near in quick_looks(plan) if near != choice.near]
    problem, solution = equilibrium.solve(model, case, known, progress, starts if others else None)
    if solution.report.outcome.balanced or not others:
        return model, problem, solution
    attempts, spent_ms = solution.report.attempts, solution.report.solve_ms
    for other in others:
        brief = BETWEEN_ROPES if other.between_ropes else BRIEFLY
        its_problem, found = equilibrium.solve(other, case, (), progress, brief)
        spent_ms += found.report.solve_ms
        if found.report.outcome.converged:
            report = replace(found.report, attempts=(*attempts, *found.report.attempts), solve_ms=spent_ms)
            return other, its_problem, replace(found, report=report)
    problem, solution = equilibrium.solve(model, case, known, progress)
    report = replace(solution.report, solve_ms=spent_ms + solution.report.solve_ms)
    return model, problem, replace(solution, report=report)


def _between_ropes(model: BagModel) -> list[BagModel]:
    """The sector of merged meshes between ropes as they are, where those of its netting are not better smeared."""
    merged = between_ropes(model.plan)
    if merged is None or merged == 1 or model.globalisation > 1 or between_ropes_errors(model.plan) is None:
        return []
    return [model_of(model.plan, merged, 1)]
