"""Gentle motion from a shape that does not last to one that does, with nothing passing through anything.

Implicit steps (K + s T / l) dx = F, F what is out of balance, K its tangent, T / l the tension over the length of the
bars at a node, so that a step is one of an overdamped motion. None is longer than ``LONGEST`` of a bar. The shift s
falls as the motion calms, but not to nothing, and not under what makes the shifted tangent's pivots positive: the
motion then runs away from unstable equilibria, where Newton's method would stay. With contact between its parts
(``Problem.of(contact=...)``) every step ends before any would pass through another, and layers press on each other;
without, netting that would pass through netting stops the motion.
"""

from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from codend.mechanics import newton_step
from codend.mechanics.bars import bar_lengths, carried
from codend.mechanics.loads import Loading
from codend.mechanics.newton_state import State, measure
from codend.mechanics.problem import Problem
from codend.mechanics.surface import Surface
from codend.net.net import Floats
from codend.solvers import newton
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import as_built
from codend.solvers.newton import DIRECT, NewtonSettings
from codend.solvers.outcome import Outcome, Progress, Solution
from codend.solvers.prepared import Prepared, prepare
from codend.solvers.refusal import passage
from codend.solvers.watched import REVERSED, Watched, less_exact, more_exact

METHOD = "gentle steps"
LONGEST = 0.15
"""Longest move of a node in a step, and longest change of a taut bar's vector, over the length of a bar."""
FIRST_SHIFT, LEAST_SHIFT, MOST_SHIFT = 0.1, 1e-5, 1e4
FALL, RISE = 0.6, 3.0
"""Factors on the shift after a step that was not cut, and where pivots are negative or a step passes through."""
CALM, CALMER = 1e-6, (1e-6, 1e-6, 1e-7, 1e-9)
"""Residual at which Newton's method takes over, and where it led nowhere, for layers that touch are seldom smooth to
it, those at which it does again."""
POLISH = replace(DIRECT, switches=DIRECT.switches[:1], iterations_allowed=25)
"""How it is tried at the first of these under contact."""
BRIEFLY = replace(POLISH, iterations_allowed=10)
"""The same without contact, at all but the last: where a net drifts off an equilibrium it leads nowhere, however
long."""
FINEST = 1e-11
"""Residual to which it goes where a net leaves a shape, as long as it is about as near to that as it began, and
without contact at all levels but the last: along what hardly grows a larger one tells nothing."""
BETWEEN = 6
"""Steps before it is tried again."""
KINKED, SEEN = 1.0, 1e-4
"""Length error, over the largest move over a bar, and by itself, that a step leaves which carried bars past where they
go taut or slack: from there the next one goes back, on and on, unless the shift rises. From a tenth of the move on
layers that come to rest in contact took one and a half to four times as many steps."""
HALVINGS = 5
"""Most halvings of a step that would carry netting through netting, or to where it is pushed back."""
SHORT, BOLDER = 0.7, 2.0
"""Share of a step under contact under which it was too bold, and the factor on the shift then."""
PUSHED_BACK = 0.5
"""Of the work that a step's force does along it, what may be left at its end against it: more is an overshoot."""
SETTLING_RESIDUAL, SETTLING_MOVE = 1e-3, 0.02
"""Residual, and move over a bar, under which contact's own tangent is tried, or what of it leaves pivots positive."""


class End(Enum):
    """How a gentle motion ended."""

    SETTLED = auto()
    """In balance."""
    TOUCHING = auto()
    """Netting meets netting."""
    STEPS_SPENT = auto()


@dataclass(frozen=True)
class Motion:
    """Where a gentle motion led."""

    end: End
    solution: Solution
    """The equilibrium; where none was reached, the last shape, its report that of the start."""
    steps: int


def follow(
    problem: Problem,
    tolerance: float,
    start: Solution,
    prepared: Prepared,
    progress: Progress | None = None,
    steps_allowed: int = 400,
    left: Floats | None = None,
) -> Motion:
    """Move a net gently from a start to an equilibrium, polished by Newton's method.

    Args:
        problem: the net under its loads.
        tolerance: largest residual and axial imbalance of the equilibrium.
        start: positions and tensions to start from, with nothing passing through anything.
        prepared: what ``newton.prepare`` returned for this structure.
        progress: told the residual of every step.
        steps_allowed: before it is given up.
        left: an equilibrium that the net is to leave, (n, 3): Newton's method may lead back to it from a start where
            little is out of balance yet, or nothing to the tolerance.
    """
    steps, calm, waits = _Steps(problem, start, prepared, FIRST_SHIFT), [CALM, *CALMER], 0
    departed = 0.0 if left is None else 2.0 * _apart(start, left)
    for number in range(1, steps_allowed + 1):
        steps.turn()
        size = steps.take()
        if size == 0.0:
            return Motion(End.TOUCHING, _as_is(problem, start, steps.here), number)
        if progress is not None:
            progress(METHOD, steps.residual)
        if not np.isfinite(steps.residual):
            break
        if steps.residual <= calm[0] and size >= 0.5 and number >= waits:
            reached = _as_is(problem, start, steps.here)
            how, finer = _polish(problem.surface is not None, calm), tolerance
            if left is not None and _apart(reached, left) <= departed:
                how, finer = replace(how, least_iterations=1), min(tolerance, FINEST)
            elif left is not None and problem.surface is None and len(calm) > 1:
                finer = min(tolerance, FINEST)
            polished = newton.solve(problem, finer, reached, how, progress, prepared)
            if polished.report.outcome is Outcome.PASSED_THROUGH:
                return Motion(End.TOUCHING, reached, number)
            near = np.abs(polished.positions - reached.positions).max() <= LONGEST * steps.bar
            back = left is not None and _apart(polished, left) < 0.5 * _apart(reached, left)
            if polished.report.outcome.converged and near and not back:
                return Motion(End.SETTLED, polished, number)
            if not back:
                calm = calm[1:]
            if not calm:
                break
            # Newton's method works in the same room
            shift = FIRST_SHIFT if problem.surface is not None else steps.shift
            steps, waits = _Steps(problem, reached, prepared, shift), number + BETWEEN
    return Motion(End.STEPS_SPENT, _as_is(problem, start, steps.here), number)


def _polish(touching: bool, calm: list[float]) -> NewtonSettings:
    """How Newton's method is tried, by the residuals at which it is yet to be."""
    if touching:
        return DIRECT if calm[0] < CALM else POLISH
    return DIRECT if len(calm) == 1 else BRIEFLY


def _apart(one: Solution, left: Floats) -> float:
    """Farthest that a knot lies from where it was, m."""
    return float(np.abs(one.positions - left).max())


class _Steps:
    """Implicit steps from a start to wherever they lead."""

    def __init__(self, problem: Problem, start: Solution, prepared: Prepared, shift: float) -> None:
        self.problem, self.structure, self.watched = problem, problem.structure, Watched(problem, prepared)
        self.here, self.there, _ = prepared.states
        self.tension = start.mean_tension
        self.bar = float(np.median(self.structure.length))
        self.shift, self.exact = shift, 0.0
        self.moved, self.before = np.inf, np.zeros_like(start.positions)
        self.here.position[:] = start.positions
        bar_lengths(start.positions, self.structure, self.here.length)
        np.divide(start.bar_tension, self.here.length, out=self.here.density, where=self.here.length > 0.0)
        self.watched.look(self.here.position)
        self._measure(self.here)

    @property
    def residual(self) -> float:
        """Of the state that was reached."""
        return float(max(self.here.residual, self.here.imbalance))

    def turn(self) -> None:
        """Find the direction of the next step: write it into ``prepared.step``."""
        touching = self.problem.surface is not None
        settling = self.residual <= SETTLING_RESIDUAL and self.moved <= SETTLING_MOVE
        self.exact = more_exact(self.exact) if settling or not touching else 0.0
        while True:
            step, system = self.watched.prepared.step, self.watched.prepared.system
            loading = self.watched.loading
            loading = loading._replace(contact=loading.contact._replace(exact=self.exact))
            pattern = self.watched.prepared.pattern
            sides = newton_step.linearise(self.structure, loading, pattern, self.tension, self.shift, self.here, step)
            negative = system.factorise(step.blocks)
            if (negative == 0 and system.negative_pivots() == 0) or self.shift > MOST_SHIFT:
                break
            if touching and self.exact > 0.0:
                self.exact = less_exact(self.exact)
            else:
                self.shift *= RISE
        solved = system.solve(step.right[:sides])
        _, self.turned, _ = newton_step.finish_step(self.structure, self.here, self.here, solved, step)

    def take(self) -> float:
        """Take so much of the step as is gentle, 0 where none is; tell how much, and set the shift of the next."""
        step = self.watched.prepared.step
        farthest = float(np.sqrt(np.einsum("ij,ij->i", step.move, step.move).max()))
        size = min(1.0, LONGEST * self.bar / farthest) if farthest > 0.0 else 1.0
        size = min(size, LONGEST / self.turned) if self.turned > 0.0 else size
        self.moved = farthest / self.bar
        if self.problem.surface is None:
            size = self._without_passing(size)
            if size == 1.0:
                self.shift = max(FALL * self.shift, LEAST_SHIFT)
        else:
            size = self._under_contact(size, self.problem.surface)
        self.here, self.there = self.there, self.here
        return size

    def _without_passing(self, size: float) -> float:
        for _ in range(HALVINGS):
            self._try(size, self.watched.loading)
            if passage(self.problem, self.there.position, gathered=False) is None:
                return size
            size *= 0.5
        return 0.0

    def _under_contact(self, size: float, surface: Surface) -> float:
        """The share of a step after which nothing has passed through, nor is pushed back much."""
        step = self.watched.prepared.step
        move, before = step.move, self.before
        along = float(np.vdot(move, before)) / float(np.linalg.norm(move) * np.linalg.norm(before) + 1e-300)
        back = size == 1.0 and along < REVERSED  # half of it is taken then
        size = 0.5 if back else size
        pairs = surface.on_the_way(self.here.position, size * move)
        size *= surface.free_part(self.here.position, size * move, pairs)
        work = abs(float(np.vdot(step.right[0] * self.structure.free, move)))
        for _ in range(HALVINGS + 1):
            near = surface.nearest_of(pairs, self.here.position + size * move)
            self._try(size, self.watched.loading._replace(contact=near))
            if float(np.vdot(self.there.force * self.structure.free, move)) >= -PUSHED_BACK * work:
                break
            size *= 0.5
        self.watched.see(near)
        self.before = move.copy()
        if (size < SHORT and not back) or (size == 1.0 and self.there.length_error > max(KINKED * self.moved, SEEN)):
            self.shift *= BOLDER
        elif size == 1.0:
            self.shift = max(FALL * self.shift, LEAST_SHIFT)
        return size

    def _try(self, size: float, loading: Loading) -> None:
        step = self.watched.prepared.step
        switch = DIRECT.switches[0]
        here, there = self.here, self.there
        newton_step.take(self.structure, loading, self.tension, switch, 0.0, size, here, here, step, there)

    def _measure(self, state: State) -> None:
        measure(self.structure, self.watched.loading, self.tension, DIRECT.switches[0], 0.0, state)


@dataclass(frozen=True)
class GentleSettings:
    """What may be tuned."""

    steps_allowed: int = 1000


def solve(
    problem: Problem,
    tolerance: float,
    start: Solution | None = None,
    settings: GentleSettings = GentleSettings(),
    progress: Progress | None = None,
) -> Solution:
    """Equilibrium of a net by gentle steps, from a shape in which nothing passes through anything; see ``Solver``."""
    with Clock() as clock:
        start = as_built(problem) if start is None else start
        prepared = prepare(problem.structure, problem.bands)
        motion = follow(problem, tolerance, start, prepared, progress, settings.steps_allowed)
        spent_ms = clock.ms
    found = motion.solution.report
    outcome = {End.SETTLED: found.outcome, End.TOUCHING: Outcome.PASSED_THROUGH}.get(motion.end, Outcome.STEPS_SPENT)
    note = f"{METHOD}: {motion.steps} steps. {outcome.value}"
    attempts = (note, *found.attempts) if motion.end is End.SETTLED else (note,)
    report = replace(found, method=METHOD, outcome=outcome, iterations=motion.steps, solve_ms=spent_ms)
    report = replace(report, attempts=attempts)
    return Solution.ended(report, motion.solution.positions, motion.solution.bar_tension, motion.solution.share)


def _as_is(problem: Problem, start: Solution, state: State) -> Solution:
    tension = carried(problem.structure.is_strut, state.density * state.length)
    return Solution(state.position.copy(), tension, state.share.copy(), start.report)
