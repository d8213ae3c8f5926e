"""Newton's method with a barrier that keeps all twine taut, made lower and lower: for nets whose bars go slack by many.

Which bars end slack is not tried out but emerges: every bar has a force density q and a slackness s, unknowns both,
that stay above 0 and whose product, the barrier, falls to nothing (``interior_kernels``; a primal-dual interior-point
method: Nocedal and Wright, Numerical Optimization, 2006, sections 16.6 and 19.3; steps are corrected more than once by
the same factors: Gondzio, Computational Optimization and Applications 6, 1996). Shape, pull and slackness go the
same share of a step, and the barrier is lowered as ``barrier`` tells. One form serves limp and stiff twine,
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
from codend.mechanics.structure import Structure
from codend.net.net import Floats
from codend.solvers import interior_kernels as kernels
from codend.solvers import newton
from codend.solvers.barrier import KEPT_TAUT, Course, lower
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import reference_tension
from codend.solvers.newton import DIRECT, Prepared
from codend.solvers.outcome import Midway, Outcome, Progress, Solution, SolverReport
from codend.solvers.watched import Watched

METHOD = "interior point"
LEAST_TENSION = 0.01
"""Tension that bars are given at least to start with, over the mean."""
MOST_MENDED, LEAST_OF_WAY = 0.5, 0.9
"""Length of a correction over that of its step, and share of the step's way that it must leave, to be of use."""
LEAST_MENDED = 0.03
"""The former under which nothing is left that another would mend."""
STALLED = 80
"""Steps in a row that do not lower the barrier, after which none will."""
FINEST = 1e-10
"""Residual to which the last barrier is followed: from there Newton's method goes on though bars be nearly slack."""
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
    corrections: int = 0
    """Most corrections of a step: each costs a back-substitution, of a wide net a twentieth of the factorisation before
    it. Not for all: nets of which a mesh is pulled, in sectors that may turn, were led through themselves by them."""
    resumes: bool = False
    """Whether it sets out from where the start's own way through the interior was, if it came by one (``Midway``): of
    an equilibrium under nearly the same loads."""


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
        led, outcome, steps, length_error = _lower_the_barrier(problem, tolerance, start, settings, progress, prepared)
        spent_ms = clock.ms
    state = led.state
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
    return replace(solution, report=finished, midway=led.midway)


def _lower_the_barrier(
    problem: Problem,
    tolerance: float,
    start: Solution | None,
    settings: InteriorPointSettings,
    progress: Progress | None,
    prepared: Prepared,
) -> tuple["_Led", Outcome, int, float]:
    """Follow the barrier down; where that ended, how, after how many steps, and the error of lengths there."""
    structure, watched = problem.structure, Watched(problem, prepared)
    state, new, _ = prepared.states
    state.position[:] = problem.net.positions if start is None else start.positions
    mean = reference_tension(problem) if start is None else start.mean_tension
    crude = start is None or problem.surface is not None
    tension = max(mean, _largest_load(problem, mean, state)) if crude else mean
    tensions = tension if start is None else np.maximum(start.bar_tension, LEAST_TENSION * tension)
    state.density[:] = tensions / structure.length
    midway = start.midway if start is not None and settings.resumes else None
    if midway is not None:
        state.position[:], state.density[:] = midway.positions, midway.density
    watched.look(state.position)
    measure(structure, watched.loading, tension, 1.0, KEPT_TAUT, state)
    corrections = settings.corrections if problem.surface is None else 0
    led = _Led(watched, tension, state, new, midway, corrections)
    course = Course(
        first=settings.first_barrier,
        last=settings.last_barrier * mean / tension,
        steps_allowed=settings.steps_allowed,
        patience=STALLED,
        enough=min(tolerance, FINEST),
        close=tolerance,
    )
    outcome, steps, error = lower(led, structure, tension, course, progress, METHOD)
    return led, outcome, steps, error


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


class _Led:
    """A net that hangs on what is held, see ``barrier.Led``."""

    def __init__(
        self,
        watched: Watched,
        tension: float,
        state: State,
        new: State,
        midway: Midway | None,
        corrections: int,
    ) -> None:
        self.watched, self.tension, self.state, self._new = watched, tension, state, new
        self.midway, self._corrections = midway, corrections
        self._solved = np.zeros(0)

    def linearise(self, softened: Structure, shift: float, exact: float) -> tuple[float, float]:
        """See ``barrier.Led``."""
        structure, loading, prepared = self.watched.problem.structure, self.watched.loading, self.watched.prepared
        step, state = prepared.step, self.state
        acting = loading._replace(contact=loading.contact._replace(exact=exact))
        sides = newton_step.linearise(softened, acting, prepared.pattern, self.tension, 0.0, state, step)
        if shift > 0.0:
            kernels.shift_by_resistance(structure, prepared.pattern, state, shift, step.blocks)
        if prepared.system.factorise(step.blocks) != 0:
            return np.nan, np.nan
        self._solved = solved = prepared.system.solve(step.right[:sides])
        _, _, determinant = newton_step.finish_step(structure, state, state, solved, step)
        turn = kernels.largest_turn(structure, state, step) if determinant > 0.0 else np.inf
        return turn, turn

    def correct(self, barrier: float, loosening: Floats, way: float) -> float:
        """See ``barrier.Led``; nothing is mended under contact, whose pairs are those near the state."""
        step = self.watched.prepared.step
        for _ in range(self._corrections):
            move, change, loosened = step.move.copy(), step.change.copy(), loosening.copy()
            mended, length = self._mend(barrier, loosening), newton_step.norm(move)
            corrected = kernels.way_to_nothing(self.watched.problem.structure, self.state, step.change, loosening)
            if not (mended <= MOST_MENDED * length and min(corrected, 1.0) >= LEAST_OF_WAY * min(way, 1.0)):
                step.move[:], step.change[:], loosening[:] = move, change, loosened
                break
            way = corrected
            if mended <= LEAST_MENDED * length:
                break
        return way

    def _mend(self, barrier: float, loosening: Floats) -> float:
        """Add to the step and its loosening what mends what they leave; the length of the moves added, m."""
        structure, prepared, state, there = self.watched.problem.structure, self.watched.prepared, self.state, self._new
        step = prepared.step
        kernels.go(state, step, loosening, 1.0, there)
        measure(structure, self.watched.loading, self.tension, 1.0, KEPT_TAUT, there)
        kernels.left_of_bars(structure, barrier, state, there)
        newton_step.right_side(structure, state, there, step)
        move, change = step.move.copy(), step.change.copy()
        self._solved[:1] = prepared.system.solve(step.right[:1])
        length, _, _ = newton_step.finish_step(structure, state, there, self._solved, step)
        kernels.loosen(structure, barrier, state, there, step.change, loosening)
        step.move[:] += move
        step.change[:] += change
        return length

    def go(self, loosening: Floats, share: float) -> float:
        """See ``barrier.Led``."""
        structure, step, new = self.watched.problem.structure, self.watched.prepared.step, self._new
        free = self.watched.go_along(self.state.position, share * step.move)
        kernels.go(self.state, step, loosening, free * share, new)
        measure(structure, self.watched.loading, self.tension, 1.0, KEPT_TAUT, new)
        self.state, self._new = new, self.state
        return free

    def left_over(self) -> float:
        """See ``barrier.Led``."""
        return kernels.largest_force(self.watched.problem.structure, self.state.force)
