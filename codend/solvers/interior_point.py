"""Newton's method with a barrier that keeps all twine taut, made lower and lower: for nets whose bars go slack by many.

Which bars end slack is not tried out but emerges: with the barrier b every bar obeys (q / EA - gap) q = b (see
``newton_state``), so that its force density q and what it is short of its length stay above 0 and their product falls
to nothing (a primal-dual interior-point method: Nocedal and Wright, Numerical Optimization, 2006, sections 16.6 and
19.3). It needs ten to thirty factorisations where Newton's method alone, near its equilibrium, needs one or two, and
leaves the last digits to it; but it needs no start nearby.
"""

from dataclasses import dataclass, replace

import numpy as np

from codend.mechanics import newton_step
from codend.mechanics.newton_state import State, measure
from codend.mechanics.problem import Problem
from codend.solvers import interior_kernels as kernels
from codend.solvers import newton
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import reference_tension
from codend.solvers.newton import DIRECT, LARGEST_SHIFT, Prepared
from codend.solvers.outcome import Outcome, Progress, Solution, SolverReport

METHOD = "interior point"
LOWERED, LOWERED_WARILY = 0.1, 0.3
"""Factor on the barrier after a step that was nearly whole, and after one that was more than half of it."""
NEAREST = 0.9
"""Share of the way that a step may go to where the first slackness or force density is nothing."""
MOST_PULL = 3.0
"""Share of the change of tensions, over that of the shape, that a step may go: alone they run away."""
NEAR = 10.0
"""Largest force left over, in units of the reference tension and the barrier, at which the barrier is lowered: that of
netting all but slack is itself of the barrier's size, and lowered earlier it is lost."""
LEAST_SLACKNESS = 1e-3
"""What bars are given to start with, over the mean length."""
LARGEST_TURN = 0.5
"""Largest change of a bar's vector in one step, over its length."""
LEAST_TENSION = 0.01
"""Tension that bars are given at least to start with, over the mean."""
FARTHEST_TURN = 5.0
"""Change of a bar's vector, over its length, that a step may ask for: near a singular tangent steps ask for far more,
in a direction that leads nowhere, and the tangent is shifted."""
FINEST = 1e-10
"""Residual to which the last barrier is followed: from there Newton's method goes on though bars be nearly slack."""
FIRST_SHIFT, LEAST_SHIFT = 1e-2, 1e-3
"""In units of what the pull of the bars at a node resists, see ``kernels.shift_by_pull``."""
STALLED = 80
"""Steps in a row that do not lower the barrier, after which none will."""
FINISH = replace(DIRECT, switches=(1.0, 0.1, 0.01))
"""Newton's method at the end: the first of these weights parts taut and slack bars as the barrier did."""
LAST_DIGITS = replace(FINISH, switches=(1.0,), iterations_allowed=3, least_iterations=1)
"""The same for what the barrier has left of the lengths of bars, though forces balance."""
FINE = 1e-10
"""Relative error of lengths that is not worth a step."""


@dataclass(frozen=True)
class InteriorPointSettings:
    """What may be tuned; the default holds for all plans the project knows."""

    steps_allowed: int = 300
    first_barrier: float = 1e-2
    """In units of the reference tension over the square of the mean length of bars. From a start that the loads have
    since left by much, a higher one takes fewer steps: lowered too early, bars hit slackness one after the other."""
    last_barrier: float = 1e-12
    """Likewise; a higher one leaves more to Newton's method."""


def solve(
    problem: Problem,
    tolerance: float,
    start: Solution | None = None,
    settings: InteriorPointSettings = InteriorPointSettings(),
    progress: Progress | None = None,
    prepared: Prepared | None = None,
) -> Solution:
    """Equilibrium of a net from a start that need not be near; see ``Solver``.

    Bars may go slack on the way, and slack ones taut.

    Args:
        problem: the net under its loads.
        tolerance: largest residual and axial imbalance.
        start: positions and tensions to start from; without one the net's own shape with even tension.
        settings: see ``InteriorPointSettings``.
        progress: told the residual of every step.
        prepared: what ``newton.prepare`` returned for this structure.
    """
    if problem.surface is not None:
        raise ValueError("this method knows no contact: use find_equilibrium")
    prepared = newton.prepare(problem.structure, problem.bands) if prepared is None else prepared
    with Clock() as clock:
        state, outcome, steps = _lower_the_barrier(problem, tolerance, start, settings, progress, prepared)
        spent_ms = clock.ms
    attempt = f"{METHOD} with {prepared.system.name}: {steps} steps, residual {state.residual:.1e}. {outcome.value}"
    report = SolverReport(
        method=METHOD,
        outcome=outcome,
        iterations=steps,
        residual=state.residual,
        imbalance=state.imbalance,
        length_error=state.length_error,
        solve_ms=spent_ms,
        attempts=(attempt,),
    )
    reached = Solution.ended(report, state.position, state.density * state.length, state.share)
    if not outcome.converged:
        return reached
    fine = report.length_error <= FINE
    solution = newton.solve(problem, tolerance, reached, FINISH if fine else LAST_DIGITS, progress, prepared)
    if not fine and not solution.report.outcome.converged:
        solution = newton.solve(problem, tolerance, reached, FINISH, progress, prepared)
    finished = replace(
        solution.report,
        iterations=steps + solution.report.iterations,
        solve_ms=spent_ms + solution.report.solve_ms,
        attempts=(attempt, *solution.report.attempts),
    )
    return replace(solution, report=finished)


def _lower_the_barrier(
    problem: Problem,
    tolerance: float,
    start: Solution | None,
    settings: InteriorPointSettings,
    progress: Progress | None,
    prepared: Prepared,
) -> tuple[State, Outcome, int]:
    """Follow the barrier down; where that ended, how, and after how many steps."""
    structure, loading, step = problem.structure, problem.loading, prepared.step
    state, new, _ = prepared.states
    tension = reference_tension(problem) if start is None else start.mean_tension
    length = float(structure.length.mean())
    unit = tension / length**2
    barrier, last_barrier = settings.first_barrier * unit, settings.last_barrier * unit
    state.position[:] = problem.net.positions if start is None else start.positions
    tensions = tension if start is None else np.maximum(start.bar_tension, LEAST_TENSION * tension)
    state.density[:] = tensions / structure.length
    measure(structure, loading, tension, 1.0, barrier, state)
    kernels.begin(structure, barrier, LEAST_SLACKNESS / length, state)
    loosening = np.zeros(len(structure.length))
    steps, lowered, shift = 0, 0, 0.0
    # what a tight layer takes from a bag is far more than steps ask for elsewhere, and to shift holds it back for ever
    layered = len(structure.wrap_ring) > 0
    farthest = np.inf if layered else FARTHEST_TURN
    while steps < settings.steps_allowed:
        if progress is not None:
            progress(METHOD, state.residual)
        if not np.isfinite(state.residual):
            return state, Outcome.NOT_FINITE, steps
        if barrier <= last_barrier and state.residual <= min(tolerance, FINEST):
            return state, Outcome.CONVERGED, steps
        if steps - lowered >= STALLED and barrier > last_barrier:
            return state, Outcome.NOT_IMPROVING, steps
        steps += 1
        turn, shift = _step(problem, tension, shift, farthest, state, prepared)
        if not np.isfinite(turn):
            return state, Outcome.SINGULAR if np.isnan(turn) else Outcome.NOT_IMPROVING, steps
        to_tight, to_slack = kernels.ways_to_nothing(structure, barrier, state, step, loosening)
        of_turn = min(1.0, LARGEST_TURN / turn) if turn > 0.0 else 1.0
        of_shape = min(of_turn, NEAREST * to_tight)
        of_pull = min(of_turn, NEAREST * to_slack, MOST_PULL * of_shape)
        kernels.go(state, step, loosening, of_shape, of_pull, new)
        measure(structure, loading, tension, 1.0, barrier, new)
        state, new = new, state
        least = min(of_shape, of_pull)
        if least > 0.9:
            shift = 0.25 * shift if shift > LEAST_SHIFT else 0.0
        elif least < 0.3 and not layered:
            shift = max(2.0 * shift, LEAST_SHIFT)
        if least > 0.5 and kernels.largest_force(structure, state) <= NEAR * tension * barrier / unit:
            lowered = steps
            lower = min(LOWERED, np.sqrt(barrier / unit)) if least > 0.9 else LOWERED_WARILY
            barrier = max(lower * barrier, last_barrier)
            measure(structure, loading, tension, 1.0, barrier, state)
    close = barrier <= last_barrier and state.residual <= tolerance
    return state, Outcome.CONVERGED if close else Outcome.STEPS_SPENT, steps


def _step(
    problem: Problem, tension: float, shift: float, farthest: float, state: State, prepared: Prepared
) -> tuple[float, float]:
    """Write the step at a state, with the tangent shifted until it can be factorised and leads not farther than that.

    To a step every bar is softer by its slackness over its force density.

    Returns:
        the largest change of a bar's vector over its length, infinite if no shift helps and nan if none lets the
        tangent be factorised, and the shift it took.
    """
    structure, loading, step, system = problem.structure, problem.loading, prepared.step, prepared.system
    yielding = np.where(structure.is_strut, 0.0, state.slack / state.density)
    softened = structure._replace(flexibility=structure.flexibility + yielding)
    while True:
        turn = np.nan
        sides = newton_step.linearise(softened, loading, prepared.pattern, tension, 0.0, state, step)
        if shift > 0.0:
            kernels.shift_by_pull(structure, prepared.pattern, state.density, shift, step.blocks)
        if system.factorise(step.blocks) == 0:
            solved = system.solve(step.right[:sides])
            _, asked, determinant = newton_step.finish_step(structure, state, state, solved, step)
            turn = float(asked) if determinant > 0.0 else np.inf
        if turn <= farthest or shift >= LARGEST_SHIFT:
            return turn, shift
        shift = max(4.0 * shift, FIRST_SHIFT)
