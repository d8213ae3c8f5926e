"""Gentle motion to an equilibrium of netting that is slack, and of which parts touch: gentle steps under a barrier.

Implicit steps (K + s T / l) dx = F as in ``gentle``, of twine that a barrier keeps taut as in ``interior_point``, and
with contact between parts of the net (``Problem.of(contact=...)``), past which no step goes. Slack netting has next to
no stiffness: without a barrier its bars go taut and slack in turns for ever, and with one that is lowered before the
net has come to rest they hit slackness one after the other. So the barrier b is lowered as the motion calms, where the
residual is below ``CALM`` b; the shift s rises where a step was cut short or the residual grew much, and falls where
the residual fell.

Where layers touch, more than one shape may be in balance: what is found is where the motion from the start leads.
"""

from dataclasses import dataclass, replace

import numpy as np

from codend.mechanics import newton_step
from codend.mechanics.newton_state import State, measure
from codend.mechanics.problem import Problem
from codend.solvers import newton
from codend.solvers.barrier import share_to_slack, softened
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import as_built
from codend.solvers.gentle import BOLDER, FIRST_SHIFT, LONGEST, MOST_SHIFT, RISE, SHORT
from codend.solvers.interior_point import FINISH, LEAST_TENSION
from codend.solvers.outcome import Outcome, Progress, Solution
from codend.solvers.prepared import prepare
from codend.solvers.watched import Watched

METHOD = "gentle steps under a barrier"
FALL, LEAST_SHIFT = 0.6, 1e-4
"""Factor on the shift after a good step, and what it falls to."""
NEAREST_TO_SLACK = 0.99
"""Share of the way to the first bar's slackness that a step may go."""
FIRST_BARRIER, LAST_BARRIER, LOWERED = 1e-3, 1e-10, 0.2
"""Barrier in units of the reference tension over the square of the mean length of bars, and factor on it."""
CALM = 3.0
"""Residual, over the barrier in those units, below which that is lowered."""
EXACT = 1e-4
"""Residual up to which contact's tangent is its own: far from balance, what is negative definite of it would ask for
shifts that leave no step to speak of."""
WORSE = 1.5
"""Growth of the residual beyond which a step was too bold."""
NEARLY = 1e-6
"""Residual under the last barrier at which Newton's method takes over."""


@dataclass(frozen=True)
class SlackSettings:
    """What may be tuned."""

    steps_allowed: int = 600


def solve(
    problem: Problem,
    tolerance: float,
    start: Solution | None = None,
    settings: SlackSettings = SlackSettings(),
    progress: Progress | None = None,
) -> Solution:
    """Equilibrium of a net by gentle steps, from a shape in which nothing passes through anything; see ``Solver``."""
    with Clock() as clock:
        start = as_built(problem) if start is None else start
        run = _Run(problem, start, progress)
        outcome = run.to_rest(settings)
        if outcome is Outcome.CONVERGED:
            polished = newton.solve(problem, tolerance, run.reached(), FINISH, progress, run.prepared)
            outcome = polished.report.outcome
            if outcome.converged and np.abs(polished.positions - run.here.position).max() > LONGEST * run.bar:
                outcome = Outcome.NOT_IMPROVING
        spent_ms = clock.ms
    note = f"{METHOD}: {run.steps} steps, residual {run.residual:.1e}. {outcome.value}"
    if not outcome.converged:
        report = replace(start.report, method=METHOD, outcome=outcome, iterations=run.steps, residual=run.residual)
        report = replace(report, solve_ms=spent_ms, attempts=(note,))
        return Solution.ended(report, run.here.position, start.bar_tension, run.here.share)
    report = replace(polished.report, method=METHOD, iterations=run.steps, solve_ms=spent_ms)
    return replace(polished, report=replace(report, attempts=(note, *polished.report.attempts)))


class _Run:
    """Steps from a start."""

    def __init__(self, problem: Problem, start: Solution, progress: Progress | None) -> None:
        self.problem, self.start, self.progress = problem, start, progress
        structure = problem.structure
        self.prepared = prepare(structure, problem.bands)
        self.watched = Watched(problem, self.prepared)
        self.here, self.there, _ = self.prepared.states
        self.tension, self.bar = start.mean_tension, float(np.median(structure.length))
        self.unit = self.tension / float(structure.length.mean()) ** 2
        self.barrier, self.shift, self.residual, self.steps = FIRST_BARRIER * self.unit, FIRST_SHIFT, np.inf, 0
        self.here.position[:] = start.positions
        self.here.density[:] = np.maximum(start.bar_tension, LEAST_TENSION * self.tension) / structure.length
        self.watched.look(self.here.position)

    def reached(self) -> Solution:
        """Where it has come to."""
        tension = self.here.density * self.here.length
        return replace(self.start, positions=self.here.position.copy(), bar_tension=tension)

    def to_rest(self, settings: SlackSettings) -> Outcome:
        """Step until the net is at rest under the last barrier."""
        self._measure(self.here)
        while self.steps < settings.steps_allowed:
            self.steps += 1
            size, whole = self._step()
            if not np.isfinite(self.here.residual):
                return Outcome.NOT_FINITE
            calm = float(max(self.here.residual, self.here.imbalance)) < CALM * self.barrier / self.unit
            if size > 0.5 and calm:
                self.barrier = max(LOWERED * self.barrier, LAST_BARRIER * self.unit)
            self._measure(self.here)
            last, self.residual = self.residual, float(max(self.here.residual, self.here.imbalance))
            if self.progress is not None:
                self.progress(METHOD, self.residual)
            if size < SHORT * whole or self.residual > WORSE * last:
                self.shift = min(self.shift * BOLDER, MOST_SHIFT)
            elif self.residual < last:
                self.shift = max(FALL * self.shift, LEAST_SHIFT)
            if self.residual <= NEARLY and self.barrier <= LAST_BARRIER * self.unit:
                return Outcome.CONVERGED
        return Outcome.STEPS_SPENT

    def _step(self) -> tuple[float, float]:
        """Take a step; its size, and the size that twine near slackness would have left it."""
        structure, here, there = self.problem.structure, self.here, self.there
        loading, prepared = self.watched.loading, self.watched.prepared
        step, system = prepared.step, prepared.system
        calmer = loading._replace(contact=loading.contact._replace(exact=float(self.residual <= EXACT)))
        softer = softened(structure, here.density, self.barrier)
        while True:
            sides = newton_step.linearise(softer, calmer, prepared.pattern, self.tension, self.shift, here, step)
            if (system.factorise(step.blocks) == 0 and system.negative_pivots() == 0) or self.shift > MOST_SHIFT:
                break
            self.shift *= RISE
        newton_step.finish_step(structure, here, here, system.solve(step.right[:sides]), step)
        farthest = float(np.sqrt(np.einsum("ij,ij->i", step.move, step.move).max()))
        whole = min(1.0, NEAREST_TO_SLACK * share_to_slack(structure, here.density, step.change))
        size = min(whole, LONGEST * self.bar / farthest) if farthest > 0.0 else whole
        surface, pairs = self.problem.surface, None
        if surface is not None:
            pairs = surface.on_the_way(here.position, size * step.move)
            size *= surface.free_part(here.position, size * step.move, pairs)
        newton_step.take(structure, loading, self.tension, 1.0, self.barrier, size, here, here, step, there)
        self.here, self.there = there, here
        if surface is not None and pairs is not None:
            self.watched.see(surface.nearest_of(pairs, self.here.position))
        return size, whole

    def _measure(self, state: State) -> None:
        measure(self.problem.structure, self.watched.loading, self.tension, 1.0, self.barrier, state)
