"""Newton's method with the exact tangent, on shape and tensions together.

A step is shortened until the merit (out-of-balance forces and length errors) falls. Far from equilibrium the tangent is shifted
towards that of a damped motion, and always until its pivots are positive, so that the iteration ends at stable
equilibria. Twine that would be compressed goes slack on the way; what is returned has no bar in compression.
"""

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from codend.loads import Problem
from codend.mechanics import newton_step as kernels
from codend.mechanics.arrays import Structure
from codend.mechanics.newton_step import State, Step
from codend.mechanics.relaxation import add_loads, fill
from codend.mechanics.tangent import Pattern, pattern_of
from codend.net import Floats
from codend.solvers.dynamic_relaxation import LENGTH_TOLERANCE
from codend.solvers.linear_systems import LinearSystem, linear_system
from codend.solvers.outcome import Outcome, Progress, Solution, SolverReport

METHOD = "newton"


@dataclass(frozen=True)
class NewtonSettings:
    """What may be tuned; the defaults hold for all plans the project knows."""

    iterations_allowed: int = 80
    largest_turn: float = 1.0
    """Largest change of a taut bar's vector in one step, over its length."""
    shortest_step: float = 0.01
    first_shift: float = 1e-4
    """Shift of the tangent far from equilibrium, in units of the stiffness that tension gives the nodes."""
    largest_shift: float = 1e3


@dataclass(frozen=True)
class NewtonReport(SolverReport):
    """What Newton's method did."""

    history: tuple[float, ...] = ()
    """The larger of residual and axial imbalance before the first and after every iteration."""
    negative_pivots: int | None = None
    """Negative pivots of the last tangent, 0 at a stable equilibrium; None where the factorisation does not tell."""


@dataclass(frozen=True)
class Prepared:
    """What depends on the structure alone and is kept from one equilibrium to the next."""

    pattern: Pattern
    system: LinearSystem
    state: State
    trial: State
    move: Floats
    step: Step


def prepare(structure: Structure) -> Prepared:
    """Number the unknowns of a structure, once for all its equilibria."""
    pattern = pattern_of(structure)
    return Prepared(
        pattern,
        linear_system(structure, pattern),
        kernels.empty_state(structure),
        kernels.empty_state(structure),
        np.zeros((len(structure.free), 3)),
        kernels.empty_step(structure, pattern),
    )


def solve(
    problem: Problem,
    tolerance: float,
    start: Solution | None = None,
    settings: NewtonSettings = NewtonSettings(),
    progress: Progress | None = None,
    prepared: Prepared | None = None,
) -> Solution:
    """Equilibrium of a net by Newton's method.

    Args:
        problem: the net under its loads.
        tolerance: largest residual and axial imbalance over the resultant of the loads.
        start: positions and tensions to start from; the net's own positions with equal tensions by default.
        settings: see ``NewtonSettings``.
        progress: told the residual of every iteration.
        prepared: what ``prepare`` returned for this structure, to save that work.

    A solve that fails returns nan positions and tensions, and why.
    """
    started = perf_counter()
    prepared = prepare(problem.structure) if prepared is None else prepared
    run = _Run(problem, prepared, settings, progress)
    outcome = run.to_equilibrium(tolerance, start)
    state = run.state
    _, residual, imbalance, length_error, _ = state.marks
    report = NewtonReport(
        method=METHOD,
        outcome=outcome,
        iterations=run.iterations,
        residual=float(residual),
        imbalance=float(imbalance),
        length_error=float(length_error),
        solve_ms=1e3 * (perf_counter() - started),
        attempts=(f"{METHOD}: {run.iterations} iterations, residual {residual:.1e}. {outcome.value}",),
        history=tuple(run.history),
        negative_pivots=run.negative_pivots,
    )
    if not outcome.converged:
        return Solution(np.full_like(state.position, np.nan), np.full_like(state.density, np.nan), state.share, report)
    return Solution(state.position.copy(), state.density * state.length, state.share.copy(), report)


class _Run:
    """One solve, from the start to wherever it gets."""

    def __init__(
        self, problem: Problem, prepared: Prepared, settings: NewtonSettings, progress: Progress | None
    ) -> None:
        self.structure, self.loading, self.net = problem.structure, problem.loading, problem.net
        self.prepared, self.settings, self.progress = prepared, settings, progress
        self.state, self.trial, self.step = prepared.state, prepared.trial, prepared.step
        self.iterations = 0
        self.trace = []
        self.negative_pivots: int | None = None
        self.history: list[float] = []

    def to_equilibrium(self, tolerance: float, start: Solution | None) -> Outcome:
        self._start(start)
        settings = self.settings
        shift = 0.0
        while True:
            marks = self.state.marks
            error = max(marks[1], marks[2])
            self.history.append(float(error))
            if self.progress is not None:
                self.progress(METHOD, float(error))
            if not np.isfinite(marks[0]):
                return Outcome.NOT_FINITE
            if error <= tolerance and marks[3] <= LENGTH_TOLERANCE:
                if marks[4] == 0.0:
                    return Outcome.OVERFULL
                return Outcome.COMPRESSED if self.state.density.min(initial=0.0) < 0.0 else Outcome.CONVERGED
            if self.iterations >= settings.iterations_allowed:
                return Outcome.STEPS_SPENT
            self.iterations += 1
            while not self._advance(shift):
                shift = max(10.0 * shift, settings.first_shift)
                if shift > settings.largest_shift:
                    return Outcome.SINGULAR if self.negative_pivots == -1 else Outcome.NOT_IMPROVING
            shift = 0.1 * shift if shift > settings.first_shift else 0.0

    def _start(self, start: Solution | None) -> None:
        state, structure = self.state, self.structure
        if start is None:
            state.position[:] = self.net.positions
            state.density[:] = 0.0
        else:
            state.position[:] = start.positions
            state.density[:] = start.bar_tension
            kernels.measure(structure, self.loading, 1.0, state)
            state.density[:] = start.bar_tension / state.length
        tension = float(start.bar_tension.mean()) if start is not None else 0.0
        if tension == 0.0:
            tension = _reference_tension(structure, self.loading, state)
            state.density[:] = tension / structure.length
        self.tension = tension
        kernels.measure(structure, self.loading, tension, state)

    def _advance(self, shift: float) -> bool:
        """Take one step with the tangent shifted; False if no good one was found."""
        structure, loading, step, settings = self.structure, self.loading, self.step, self.settings
        system, state, trial, tension = self.prepared.system, self.state, self.trial, self.tension
        sides = kernels.linearise(structure, loading, self.prepared.pattern, tension, shift, state, step)
        negative = system.factorise(step.blocks)
        self.negative_pivots = negative
        if negative != 0:
            return False
        solved = system.solve(step.right[:sides])
        length, turn, determinant = kernels.finish_step(structure, state, solved, step)
        if not determinant > 0.0 or not np.isfinite(turn):
            self.negative_pivots = 1
            return False
        size = min(1.0, settings.largest_turn / max(turn, 1e-300))
        # Deuflhard's natural monotonicity: the move still asked for, by the old tangent, must get shorter
        while True:
            kernels.take(structure, loading, tension, size, state, step, trial)
            kernels.right_side(structure, state, trial, step)
            solved[0] = system.solve(step.right[:1])[0]
            left, bend = kernels.simplified_move(solved, size, step, self.prepared.move)
            self.trace.append((shift, size, length, left, turn))
            if left <= (1.0 - 0.25 * size) * length or (shift > 0.0 and left <= 2.0*length):
                break
            size = min(0.5 * size, 0.5 * size * size * length / max(bend, 1e-300))
            if size < settings.shortest_step:
                return False
        self.ratio = left / length
        self.state, self.trial = trial, state
        return True


def _reference_tension(structure: Structure, loading, state: State) -> float:
    """Mean tension that the loads on the start shape ask for, N: their resultant over the bars of a band."""
    fill(state.position, structure, loading, state.share)
    load: Floats = np.zeros_like(state.position)
    add_loads(state.position, structure, loading, state.share, load)
    bars_abreast = max(len(structure.first) / len(structure.band_meshes), 1.0)
    return float(np.linalg.norm(load.sum(axis=0) * [1.0, structure.order == 1.0, structure.order == 1.0])) / bars_abreast
