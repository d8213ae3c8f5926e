"""One case of a plan solved as closely as numbers allow, and what is asked of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from catch_models.fish import Species
from codend.bag.loads import problem_of
from codend.bag.measures import measure_briefly
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.fidelity import Choice
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.plan.plan import Plan
from codend.selectivity.escape.haul import hauls_of, terms_of_catches
from codend.selectivity.escape.predict import rows_needed
from codend.selectivity.escape.retention import nodes_of
from codend.solvers.newton import NEARBY, solve_nearby, tangent_at
from codend.solvers.outcome import Solution
from codend.studies.catches_solved import catches_in, fish_columns
from codend.studies.study import Study, measured

FINEST: Final = (1e-13, 1e-12, 1e-11, 1e-10)
"""Tolerances that are tried in turn: derivatives are differences of what is solved, divided by little."""
CLOSELY: Final = replace(NEARBY, least_iterations=3)
"""Steps that are made in any case: the tolerance of bars' lengths is not that of forces."""
SMOOTH: Final = nodes_of(steps=60)
"""Quadrature over fish whose best rotations are found to round-off, so that L50 has no steps."""
OF_NETS: Final = ("drag_n", "catch_volume_m3", "opening_ahead_deg")


@dataclass(frozen=True)
class SolvedCase:
    """A plan of one case with its equilibrium."""

    plan: Plan
    choice: Choice
    model: BagModel
    problem: Problem
    solution: Solution


def modelled(plan: Plan, choice: Choice) -> BagModel:
    """The model of a plan by the choice for one much like it; of a meridian the sector that it stands for."""
    if choice.fidelity == "meridian":
        return model_of(plan, 1, 1)
    return model_of(plan, choice.globalisation, choice.sectors, choice.fidelity == "smeared", choice.near)


def solved_case(plan: Plan, choice: Choice, start: Solution | None = None) -> SolvedCase | None:
    """Solve a plan of one case; None where it was not solved.

    Args:
        plan: of one case.
        choice: its model.
        start: an equilibrium nearby, of a net of as many nodes and bars.
    """
    (case,) = plan.cases()
    plan = plan.model_copy(update={"model": plan.model.model_copy(update={"method": "auto"})})
    model = modelled(plan, choice)
    if start is None:
        problem, solution = equilibrium.solve(model, case, (), None)
        if not solution.report.outcome.converged:
            return None
    else:
        problem = problem_of(model.bag, plan, case)
        solution = replace(start, positions=on_the_hoop(problem, start.positions))
    tangent = tangent_at(problem, solution, model.prepared)
    for tolerance in FINEST:
        found = solve_nearby(problem, tolerance, solution, tangent, CLOSELY)
        if found.report.outcome.converged:
            return SolvedCase(plan, choice, model, problem, found)
    return None


def on_the_hoop(problem: Problem, positions: Floats) -> Floats:
    """Positions of a net's nodes with those that are held where the net has them, (n, 3)."""
    held = problem.net.fixed
    return np.where(held, problem.net.positions, positions)


def quantities(case: SolvedCase, species: Sequence[Species]) -> dict[str, float]:
    """Drag, catch volume, opening ahead, and L50 and SR of every species: by the names of their columns."""
    drag, volume, _, opening = measure_briefly(case.model.bag, case.problem, case.solution)
    found = dict(zip(OF_NETS, (drag, volume, opening), strict=True))
    if species:
        found |= _selectivity(case, species)
    return found


def quantity_names(species: Sequence[Species]) -> list[str]:
    """Names of what ``quantities`` tells."""
    return [*OF_NETS, *(name for one in species for name in fish_columns(species, one))]


def _selectivity(case: SolvedCase, species: Sequence[Species]) -> dict[str, float]:
    (asked,) = case.plan.cases()
    study = Study(case.plan, case.choice, (measured(case.model.bag, asked, case.problem, case.solution),))
    found: dict[str, float] = {}
    for one in species:
        (haul,) = hauls_of(catches_in(study, rows_needed(one)))
        (terms,) = terms_of_catches(haul, one, SMOOTH)
        found.update(zip(fish_columns(species, one), terms.l50_sr(), strict=True))
    return found
