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
from codend.mechanics.newton_state import State, measure
from codend.mechanics.problem import Problem
from codend.solvers import newton
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import reference_tension
from codend.solvers.newton import DIRECT
from codend.solvers.outcome import Outcome, Progress, Solution, SolverReport
from codend.solvers.prepared import Prepared, prepare
from codend.solvers.refusal import passage
from codend.solvers.watched import Watched

METHOD = "gentle steps"
LONGEST = 0.15
"""Longest move of a node in a step, and longest change of a taut bar's vector, over the length of a bar."""
FIRST_SHIFT, LEAST_SHIFT, MOST_SHIFT = 0.1, 1e-3, 1e4
FALL, RISE = 0.6, 3.0
"""Factors on the shift after a step that was not cut, and where pivots are negative or a step passes through."""
CALM = 1e-6
"""Residual at which Newton's method takes over."""
EXACT = 1e-5
"""Residual up to which the turning of contact's pushes is in the tangent: far from balance it would ask for shifts that
leave no step to speak of."""
WORSE, SHORT = 1.5, 0.7
"""Growth of the residual, and share of a step, beyond which a step under contact was too bold."""
BOLDER = 2.0
"""Factor on the shift then."""
HALVINGS = 5
"""Most halvings of a step that would carry netting through netting."""


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
) -> Motion:
    """Move a net gently from a start to an equilibrium, polished by Newton's method.

    Args:
        problem: the net under its loads.
        tolerance: largest residual and axial imbalance of the equilibrium.
        start: positions and tensions to start from, with nothing passing through anything.
        prepared: what ``newton.prepare`` returned for this structure.
        progress: told the residual of every step.
        steps_allowed: before it is given up.
    """
    structure, watched = problem.structure, Watched(problem, prepared)
    here, there, _ = prepared.states
    tension = start.mean_tension
    bar = float(np.median(structure.length))
    here.position[:] = start.positions
    bar_lengths(start.positions, structure, here.length)
    np.divide(start.bar_tension, here.length, out=here.density, where=here.length > 0.0)
    watched.look(here.position)
    measure(structure, watched.loading, tension, DIRECT.switches[0], 0.0, here)
    shift, residual = FIRST_SHIFT, np.inf
    for number in range(1, steps_allowed + 1):
        loading, step, system = watched.loading, watched.prepared.step, watched.prepared.system
        calmer = loading._replace(contact=loading.contact._replace(turning=1.0 if residual <= EXACT else 0.0))
        while True:
            sides = newton_step.linearise(structure, calmer, watched.prepared.pattern, tension, shift, here, step)
            negative = system.factorise(step.blocks)
            if (negative == 0 and system.negative_pivots() == 0) or shift > MOST_SHIFT:
                break
            shift *= RISE
        _, turned, _ = newton_step.finish_step(structure, here, here, system.solve(step.right[:sides]), step)
        farthest = float(np.sqrt(np.einsum("ij,ij->i", step.move, step.move).max()))
        size = min(1.0, LONGEST * bar / farthest) if farthest > 0.0 else 1.0
        size = min(size, LONGEST / turned) if turned > 0.0 else size
        size *= watched.free_share(here.position, size * step.move)
        for _ in range(HALVINGS):
            newton_step.take(structure, loading, tension, DIRECT.switches[0], 0.0, size, here, here, step, there)
            if problem.surface is not None or passage(problem, there.position, gathered=False) is None:
                break
            size *= 0.5
        else:
            return Motion(End.TOUCHING, _as_is(problem, start, here), number)
        here, there = there, here
        if watched.look(here.position):
            measure(structure, watched.loading, tension, DIRECT.switches[0], 0.0, here)
        last, residual = residual, float(max(here.residual, here.imbalance))
        if progress is not None:
            progress(METHOD, residual)
        if not np.isfinite(residual):
            break
        if problem.surface is not None and (size < SHORT or residual > WORSE * last):
            shift *= BOLDER
        elif size == 1.0:
            shift = max(FALL * shift, LEAST_SHIFT)
        if residual <= CALM and size == 1.0:
            reached = _as_is(problem, start, here)
            polished = newton.solve(problem, tolerance, reached, DIRECT, progress, prepared)
            if polished.report.outcome is Outcome.PASSED_THROUGH:
                return Motion(End.TOUCHING, reached, number)
            near = np.abs(polished.positions - reached.positions).max() <= LONGEST * bar
            if polished.report.outcome.converged and near:
                return Motion(End.SETTLED, polished, number)
            break
    return Motion(End.STEPS_SPENT, _as_is(problem, start, here), number)


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
        if start is None:
            tension = np.full(len(problem.net.bars), reference_tension(problem))
            report = SolverReport(METHOD, Outcome.STEPS_SPENT, 0, np.inf, np.inf, np.inf, 0.0)
            start = Solution(problem.net.positions, tension, np.zeros(problem.bands), report)
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
