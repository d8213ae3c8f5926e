"""Newton's method with a barrier that keeps all twine taut, made lower and lower: for nets whose bars go slack by many.

Which bars end slack is not tried out but emerges: every bar has a force density q and a slackness s, unknowns both,
that stay above 0 and whose product, the barrier, falls to nothing (``interior_kernels``; a primal-dual interior-point
method: Nocedal and Wright, Numerical Optimization, 2006, sections 16.6 and 19.3). Shape, pull and slackness go the
same share of a step. The barrier is lowered when forces are as near to balance as it allows, by more the nearer the end
is, and raised to where the bars are when they hit slackness one after the other. One form serves limp and stiff twine,
ropes, layers, weight and sheets at rest (``python -m validation.interior_steps`` counts the steps): ten to thirty
factorisations, up to a hundred for T90 of stiff twine with a small catch, where Newton's method alone needs one or two
near its equilibrium, and the last digits are left to it; but it needs no start nearby. With contact between parts of a
net (``Problem.of(contact=...)``) no step goes past where any would pass through another.
"""

from dataclasses import dataclass, replace

import numpy as np

from codend.mechanics import newton_step
from codend.mechanics.newton_state import State, measure
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers import interior_kernels as kernels
from codend.solvers import newton
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import reference_tension
from codend.solvers.newton import DIRECT, LARGEST_SHIFT, Prepared
from codend.solvers.outcome import Outcome, Progress, Solution, SolverReport
from codend.solvers.watched import Watched, less_exact, more_exact

METHOD = "interior point"
LOWERED, LOWERED_WARILY = 0.1, 0.5
"""Factor on the barrier after a step that was nearly whole, at most, and after one that was more than half of it."""
NEAREST = 0.9
"""Share of the way that a step may go to where the first slackness or force density is nothing; nearer in the end."""
BLOCKED = 0.3
"""Share of a step under which the barrier is raised to where the bars are."""
NEAR = 10.0
"""Largest force left over, in units of the tension and the barrier, at which the barrier is lowered: that of netting
all but slack is itself of the barrier's size, and lowered earlier it is lost."""
LEAST_SLACKNESS = 1e-3
"""What bars are given to start with, over the square of their length."""
LARGEST_TURN = 0.5
"""Largest change of a bar's vector in one step, over its length."""
LEAST_TENSION = 0.01
"""Tension that bars are given at least to start with, over the mean."""
FARTHEST_TURN = 5.0
"""Change of a bar's vector, over its length, that a step may ask for: near a singular tangent steps ask for far more,
in a direction that leads nowhere, and the tangent is shifted."""
FINEST = 1e-10
"""Residual to which the last barrier is followed: from there Newton's method goes on though bars be nearly slack."""
LEAST_SHIFT = 1e-3
"""In units of what the pull and the bending of the bars at a node resist, see ``kernels.shift_by_resistance``."""
BOLD, EASY = 0.3, 0.5
"""Share of a step that its turn leaves under which the shift rises, and over which it falls."""
EXACT = 1e-4
"""Residual up to which contact's tangent is its own, or what of it leaves pivots positive: elsewhere what is negative
definite of it is left out."""
STALLED = 80
"""Steps in a row that do not lower the barrier, after which none will."""
KEPT_TAUT = 1.0
"""Any barrier to ``measure``: that it cuts no density. What it says of the lengths is overwritten."""
FINISH = replace(DIRECT, switches=(1.0, 0.1, 0.01))
"""Newton's method at the end: the first of these weights parts taut and slack bars as the barrier did."""
LAST_DIGITS = replace(FINISH, iterations_allowed=4, least_iterations=1)
"""The same for what the barrier has left of forces and lengths."""


@dataclass(frozen=True)
class InteriorPointSettings:
    """What may be tuned; the default holds for all plans the project knows."""

    steps_allowed: int = 300
    first_barrier: float = 0.05
    """Slackness times force density of a bar, in units of its rest length and the tension: the mean, or the largest
    load if that is more."""
    last_barrier: float = 1e-12
    """Likewise, in units of the mean tension; a higher one leaves more to Newton's method."""


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
    prepared = newton.prepare(problem.structure, problem.bands) if prepared is None else prepared
    with Clock() as clock:
        state, outcome, steps, length_error = _lower_the_barrier(
            problem, tolerance, start, settings, progress, prepared
        )
        spent_ms = clock.ms
    attempt = f"{METHOD} with {prepared.system.name}: {steps} steps, residual {state.residual:.1e}. {outcome.value}"
    report = SolverReport(
        method=METHOD,
        outcome=outcome,
        iterations=steps,
        residual=state.residual,
        imbalance=state.imbalance,
        length_error=length_error,
        solve_ms=spent_ms,
        attempts=(attempt,),
    )
    reached = Solution.ended(report, state.position, state.density * state.length, state.share)
    if not outcome.converged:
        return reached
    solution = newton.solve(problem, tolerance, reached, LAST_DIGITS, progress, prepared)
    if not solution.report.outcome.converged:
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
) -> tuple[State, Outcome, int, float]:
    """Follow the barrier down; where that ended, how, after how many steps, and the error of lengths there."""
    structure, watched = problem.structure, Watched(problem, prepared)
    state, new, _ = prepared.states
    state.position[:] = problem.net.positions if start is None else start.positions
    mean = reference_tension(problem) if start is None else start.mean_tension
    crude = start is None or problem.surface is not None
    tension = max(mean, _largest_load(problem, mean, state)) if crude else mean
    last_barrier = settings.last_barrier * mean / tension
    tensions = tension if start is None else np.maximum(start.bar_tension, LEAST_TENSION * tension)
    state.density[:] = tensions / structure.length
    watched.look(state.position)
    measure(structure, watched.loading, tension, 1.0, KEPT_TAUT, state)
    barrier = settings.first_barrier
    kernels.begin(structure, barrier * tension, LEAST_SLACKNESS, state)
    loosening, softness = np.zeros(len(structure.length)), np.zeros(len(structure.length))
    steps, lowered, shift = 0, 0, 0.0
    while True:
        error = kernels.strain(structure, barrier * tension, state, softness)
        if progress is not None:
            progress(METHOD, state.residual)
        if not np.isfinite(state.residual):
            return state, Outcome.NOT_FINITE, steps, error
        if barrier <= last_barrier and state.residual <= min(tolerance, FINEST):
            return state, Outcome.CONVERGED, steps, error
        if steps - lowered >= STALLED and barrier > last_barrier:
            return state, Outcome.NOT_IMPROVING, steps, error
        if steps >= settings.steps_allowed:
            close = barrier <= last_barrier and state.residual <= tolerance
            return state, Outcome.CONVERGED if close else Outcome.STEPS_SPENT, steps, error
        steps += 1
        turn, shift = _step(watched, tension, shift, softness, state)
        if not np.isfinite(turn):
            return state, Outcome.SINGULAR if np.isnan(turn) else Outcome.NOT_IMPROVING, steps, error
        step = watched.prepared.step
        way = kernels.way_to_nothing(structure, barrier * tension, state, step, loosening)
        of_turn = min(1.0, LARGEST_TURN / turn) if turn > 0.0 else 1.0
        share = min(of_turn, nearest_to_nothing(barrier) * way)
        free = watched.go_along(state.position, share * step.move)
        kernels.go(state, step, loosening, free * share, new)
        measure(structure, watched.loading, tension, 1.0, KEPT_TAUT, new)
        state, new = new, state
        shift = next_shift(shift, of_turn, watched.goes_back(step.move))
        blocked, share = share < BLOCKED, free * share
        if blocked:
            barrier = max(barrier, kernels.reached_barrier(structure, state) / tension)
            continue
        near = kernels.largest_force(structure, state.force) <= NEAR * tension * barrier or state.residual <= FINEST
        if share > 0.5 and near:
            lowered = steps
            lower = min(LOWERED, np.sqrt(barrier)) if share > 0.9 else LOWERED_WARILY
            barrier = max(lower * barrier, last_barrier)


def nearest_to_nothing(barrier: float) -> float:
    """Share of the way to where the first slackness or force density is nothing that a step may go."""
    return float(max(NEAREST, 1.0 - np.sqrt(barrier)))


def next_shift(shift: float, of_turn: float, back: bool) -> float:
    """Shift of the next tangent, by the share of the last step that its turn left and whether it went back."""
    if of_turn < BOLD or back:
        return min(max(2.0 * shift, LEAST_SHIFT), LARGEST_SHIFT)
    if of_turn > EASY:
        return 0.25 * shift if shift > LEAST_SHIFT else 0.0
    return shift


def _largest_load(problem: Problem, tension: float, state: State) -> float:
    """Largest load on a free node in a shape, N: what the bars beside it have to pull with.

    Where little but a few weights loads a net, that is a hundred times the mean. What layers resist with is left out:
    in a crude shape that may be any size.
    """
    structure = problem.structure
    bare = structure._replace(wrap_law=structure.wrap_law[:0])
    state.density[:] = tension / structure.length
    measure(bare, problem.loading, tension, 1.0, KEPT_TAUT, state)
    return kernels.largest_force(structure, state.load)


def _step(watched: Watched, tension: float, shift: float, softness: Floats, state: State) -> tuple[float, float]:
    """Write the step at a state, with the tangent shifted until it can be factorised and leads not too far.

    Returns:
        the largest change of a bar's vector over its length, infinite if no shift helps and nan if none lets the
        tangent be factorised, and the shift it took.
    """
    structure, loading, prepared = watched.problem.structure, watched.loading, watched.prepared
    step, system = prepared.step, prepared.system
    near_contact = state.residual <= EXACT and len(loading.contact.kind) > 0
    exact = more_exact(watched.exact) if near_contact else 0.0
    softened = structure._replace(flexibility=softness)
    while True:
        turn, watched.exact = np.nan, exact
        acting = loading._replace(contact=loading.contact._replace(exact=exact))
        sides = newton_step.linearise(softened, acting, prepared.pattern, tension, 0.0, state, step)
        if shift > 0.0:
            kernels.shift_by_resistance(structure, prepared.pattern, state, shift, step.blocks)
        factorised = system.factorise(step.blocks) == 0
        if factorised:
            solved = system.solve(step.right[:sides])
            _, _, determinant = newton_step.finish_step(structure, state, state, solved, step)
            turn = kernels.largest_turn(structure, state, step) if determinant > 0.0 else np.inf
        stands = factorised and not (near_contact and system.negative_pivots())
        if (turn <= FARTHEST_TURN and stands) or shift >= LARGEST_SHIFT:
            return turn, shift
        if exact > 0.0:
            exact = less_exact(exact)
            continue
        shift = max(4.0 * shift, LEAST_SHIFT)
