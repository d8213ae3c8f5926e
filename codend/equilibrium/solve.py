"""Net under loads to equilibrium, from the starts of the plan's method in turn."""

from collections.abc import Sequence
from dataclasses import replace

from codend.equilibrium.bag_model import BagModel
from codend.equilibrium.situation import Situation
from codend.equilibrium.starts import BRIEFLY, STARTS, Start
from codend.mechanics.problem import Problem
from codend.plan.plan import Case
from codend.solvers.outcome import Progress, Solution


def solve(
    model: BagModel,
    case: Case,
    known: Sequence[tuple[Case, Solution]],
    progress: Progress | None,
    starts: Sequence[Start] | None = None,
) -> tuple[Problem, Solution]:
    """Equilibrium of one case, helped by the equilibria known of others of the same model.

    The starts that apply, of ``STARTS`` unless others are named, are tried until one ends in balance. The report of
    what is returned tells every attempt; its time is that of all of them, of finding where to start too.
    """
    problem = model.problem(case)
    situation = Situation(model, problem, case, known, progress, _beside)
    attempts: list[str] = []
    spent_ms = 0.0
    solution: Solution | None = None
    in_contact = False
    for start in STARTS[model.plan.model.method] if starts is None else starts:
        tried = start.solve(situation) if start.applies(situation) else None
        if tried is None:
            continue
        # a net found in balance and refused tells more than a later start that led nowhere
        if solution is None or not solution.report.outcome.refused or tried.report.outcome.balanced:
            solution, in_contact = tried, start.in_contact
        attempts += [f"from {start.name}: {line}" for line in tried.report.attempts]
        spent_ms += tried.report.solve_ms
        if solution.report.outcome.balanced:
            break
    assert solution is not None  # every method has a start that is always there
    if in_contact and solution.report.outcome.balanced:
        touching = situation.touching.touching_at(solution.positions)
        problem = touching if len(touching.loading.contact.kind) else problem
    return problem, replace(solution, report=replace(solution.report, attempts=tuple(attempts), solve_ms=spent_ms))


def _beside(other: BagModel, case: Case) -> Solution:
    """A case of another model; a quick look at netting that tapers is not tried for long, for others are left."""
    return solve(other, case, (), None, BRIEFLY if other.near is not None and other.plan.tapers else None)[1]
