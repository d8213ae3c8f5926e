"""How far the numbers of a result may be off: the solver's tolerance, merged meshes, and the pressure curve.

The number of meshes of the real net is real, not an error: a sector of the unglobalised net is exact in that respect.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from codend import equilibrium
from codend.equilibrium import Scene
from codend.measures import Measures, measure_all
from codend.plan import Case, Plan
from codend.problem import Problem
from codend.solvers import newton
from codend.solvers.newton import DIRECT
from codend.solvers.outcome import Solution

POLISHED = 1e-3
"""Tolerance of the answer that a result is compared with, over the result's own residual."""
FINEST = 1e-11
SAFETY = 1.5
MORE_SUCTION = 0.1
"""Change of the suction outside the catch, relative, that the sensitivity to the pressure curve is told for."""
NOISE = 1e-8
"""Relative error that is claimed in any case: what a residual of ``FINEST`` may leave."""
NEARBY = replace(DIRECT, iterations_allowed=8)
"""From a result it is a step or two; if it is not, there is no estimate."""


@dataclass(frozen=True)
class Errors:
    """Estimates beside the quantities of ``Measures``; nan where none could be made."""

    drag_error_n: float
    catch_volume_error_m3: float
    max_radius_error_m: float
    opening_ahead_error_deg: float
    drag_change_with_suction: float
    """Relative change of the drag for 10 % more suction outside the catch: what the pressure curve is worth."""

    @classmethod
    def unknown(cls) -> "Errors":
        """No estimate of anything."""
        return cls(*(float("nan") for _ in fields(cls)))


_QUANTITIES = ("drag_n", "catch_volume_m3", "max_radius_m", "opening_ahead_deg")


def estimate(scene: Scene, case: Case, problem: Problem, solution: Solution, measures: Measures) -> Errors:
    """Error estimates of one solved case.

    The solver's part is the distance to an answer that Newton's method finds from the result at a far smaller residual.
    The part of a globalised net is the distance between a sector of it and one of the real net, under the loads that
    are the same all round.
    """
    prepared = scene.prepared
    finest = max(POLISHED * max(solution.report.residual, solution.report.imbalance), FINEST)
    polished = newton.solve(problem, finest, solution, NEARBY, prepared=prepared)
    if not polished.report.outcome.converged:
        return Errors.unknown()
    solver = _distance(measures, measure_all(problem, polished)[2])
    merged = discretisation(scene.plan, case, scene.globalisation).distance
    errors = SAFETY * (solver + merged) + NOISE * np.abs([getattr(measures, name) for name in _QUANTITIES])
    drag, volume, radius, opening = map(float, errors)
    return Errors(drag, volume, radius, opening, _change_with_suction(problem, polished, prepared, measures.drag_n))


@dataclass(frozen=True)
class Discretisation:
    """What merging meshes changes, between sectors under the loads that are the same all round."""

    distance: np.ndarray
    """In drag, volume, largest radius and opening ahead of the catch; nan where a sector was not solved."""
    relative_drag: float


def discretisation(plan: Plan, case: Case, globalisation: int) -> Discretisation:
    """Distance between a sector of the globalised net and one of the real net."""
    if globalisation == 1:
        return Discretisation(np.zeros(len(_QUANTITIES)), 0.0)
    found = []
    quickly = plan.model_copy(update={"model": plan.model.model_copy(update={"method": "auto"})})
    for g in (1, globalisation):
        problem, solution = equilibrium.solve(equilibrium.scene_of(quickly, g, 1), case, (), None)
        if not solution.report.outcome.converged:
            return Discretisation(np.full(len(_QUANTITIES), np.nan), float("nan"))
        found.append(measure_all(problem, solution)[2])
    return Discretisation(_distance(*found), abs(found[1].drag_n / found[0].drag_n - 1.0))


def _distance(first: Measures, second: Measures) -> np.ndarray:
    return np.array([abs(getattr(first, name) - getattr(second, name)) for name in _QUANTITIES])


def _change_with_suction(problem: Problem, solution: Solution, prepared: newton.Prepared, drag_n: float) -> float:
    """1 - Cp becomes 1 - 1.1 Cp; inside the catch the water stays at stagnation pressure."""
    coefficients = (1.0 + MORE_SUCTION) * problem.loading.coefficients
    coefficients[3] -= MORE_SUCTION
    changed = replace(problem, loading=problem.loading._replace(coefficients=coefficients))
    moved = newton.solve(changed, 1e-8, solution, NEARBY, prepared=prepared)
    if not moved.report.outcome.converged:
        return float("nan")
    return measure_all(changed, moved)[2].drag_n / drag_n - 1.0
