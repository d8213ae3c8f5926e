"""Newton's method with the exact tangent, on shape and tensions together.

A step is shortened until the move that the old tangent still asks for at its end is shorter than the step (natural
monotonicity: Deuflhard, Newton Methods for Nonlinear Problems, 2011, section 3.3). Where pivots are negative far from
an equilibrium, a banded tangent is shifted until they are positive, which leads away from unstable equilibria. It does
not keep off them: a start may be one, and of wide nets the pivots are not known on the way. The tangent there tells
afterwards (``harmonics``, ``whole_tangent``). Twine that would be compressed goes slack on the way; an answer with
twine in compression is refused.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from codend.mechanics import newton_step
from codend.mechanics.bars import carried
from codend.mechanics.loads import Loading
from codend.mechanics.newton_state import State, measure, take_over
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import LENGTH_TOLERANCE, reference_tension, rough_shape
from codend.solvers.kernels import FAILED, IN_FIRST, Iteration, Limits, advance, advance_banded
from codend.solvers.linear_systems import BandedSystem
from codend.solvers.outcome import Outcome, Progress, Solution, SolverReport
from codend.solvers.prepared import Prepared, prepare
from codend.solvers.refusal import Refusal, refusal, told
from codend.solvers.ring import NEUTRAL, SWITCH, Ring
from codend.solvers.watched import Watched

METHOD = "newton"
CLEAR_FALL = 0.1
"""Fall of the merit at which a step is taken without the test of monotonicity."""
ROUND_OFF = 1e-9
"""Compression of a bar, over the reference tension, up to which it carries nothing but round-off."""
LARGEST_TURN = 1.0
"""Largest change of a taut bar's vector in one step, over its length."""
SHORTEST_STEP = 0.01
"""Fraction of a step below which the tangent is shifted instead."""
FIRST_SHIFT, LARGEST_SHIFT = 1e-4, 1e3
"""In units of the stiffness that the reference tension gives the nodes; each next one is ten times as large."""
ROUGH_STEPS = 20_000
"""Steps of a relaxation to start from."""


@dataclass(frozen=True)
class NewtonSettings:
    """What may be tuned; the defaults hold for all plans the project knows."""

    switches: tuple[float, ...] = (SWITCH, 0.01, 1.0)
    """Weights of the test for taut bars (``newton_state.measure``), tried in order: where one makes bars go taut and
    slack in turns for ever, another does not."""
    iterations_allowed: int = 30
    """Iterations with each of them; from a start that was given only the first is tried before the net is relaxed."""
    least_iterations: int = 0
    """Made even from a start within the tolerance, which is one of single nodes: a small load on all hides below it."""
    refuses: bool = True
    """Whether an answer is held to what answers are refused for; needless a step from one that was."""
    rough_starts: tuple[tuple[float, float], ...] = ((2.5e-3, 30.0), (2.5e-4, 100.0), (2.5e-5, 1000.0))
    """Relaxations to start from, in order, where no start is given or it leads nowhere: the residual, and the axial
    stiffness that stands in for inextensible bars, in units of the reference tension."""


DIRECT = NewtonSettings(rough_starts=())
"""Newton's method from the start it is given and no other."""
NEARBY = replace(DIRECT, iterations_allowed=8, refuses=False)
"""Newton's method from an equilibrium nearby, for no longer than a step or two and some to spare."""


@dataclass(frozen=True)
class NewtonReport(SolverReport):
    """What Newton's method did."""

    history: tuple[float, ...] = ()
    """The larger of residual and axial imbalance before the first and after every iteration."""


def solve(
    problem: Problem,
    tolerance: float,
    start: Solution | None = None,
    settings: NewtonSettings = NewtonSettings(),
    progress: Progress | None = None,
    prepared: Prepared | None = None,
) -> Solution:
    """Equilibrium of a net by Newton's method; see ``Solver``.

    Args:
        problem: the net under its loads.
        tolerance: largest residual and axial imbalance.
        start: positions and tensions to start from; without one the net's own shape is relaxed a little first.
        settings: see ``NewtonSettings``.
        progress: told the residual of every iteration.
        prepared: what ``prepare`` returned for this structure, to save that work.
    """
    prepared = prepare(problem.structure, problem.bands) if prepared is None else prepared
    return _solve(_Iterations(problem, prepared, settings, progress), tolerance, start)


def _solve(run: "_Iterations", tolerance: float, start: Solution | None) -> Solution:
    """What ``solve`` does once there is room to iterate in."""
    settings = run.settings
    attempts: list[str] = []
    switches = settings.switches[:1] if start is not None and settings.rough_starts else settings.switches
    waiting = list(settings.rough_starts)
    with Clock() as clock:
        while True:
            if start is None:
                start, note = rough_shape(run.problem, *waiting.pop(0), ROUGH_STEPS)
                attempts.append(note)
            outcome = run.from_start(start, tolerance, switches, attempts)
            if outcome.balanced or not waiting:
                break
            start, switches = None, settings.switches
        spent_ms = clock.ms
    state = run.state
    report = NewtonReport(
        method=METHOD,
        outcome=outcome,
        iterations=run.iterations,
        residual=state.residual,
        imbalance=state.imbalance,
        length_error=state.length_error,
        solve_ms=spent_ms,
        attempts=tuple(attempts),
        history=tuple(run.history),
    )
    return Solution.ended(report, state.position, state.density * state.length, state.share)


@dataclass(frozen=True)
class TangentAtEquilibrium:
    """The tangent at an equilibrium, factorised: it tells of stability, and solves nearby can do with its factors."""

    problem: Problem
    solution: Solution
    """The equilibrium."""
    prepared: Prepared
    """With the factors, until something else is solved with it."""
    products: int
    """By how many products of two vectors a front that follows the net adds to the tangent."""
    singular: bool
    state: State
    """Where it was taken, measured; ``polished`` sets out from there, and leaves something else in it."""
    ring: Ring | None = None
    """A sector's ring with the tangent for all harmonics, until something else is linearised in it."""


def tangent_at(
    problem: Problem, solution: Solution, prepared: Prepared, ring: Ring | None = None
) -> TangentAtEquilibrium:
    """The tangent at an equilibrium, shifted by ``NEUTRAL`` and factorised in ``prepared``.

    Of a sector it is written by way of its ``ring``, which has it for all harmonics then; not where parts touch, whose
    pairs a ring of the joints alone has no room for.
    """
    touches = problem.surface is not None or len(problem.loading.contact.kind) > 0
    if ring is not None and not touches and solution.mean_tension > 0.0:
        sides = ring.linearise(problem, solution)
        ring.write_whole(prepared.step)
        singular = prepared.system.factorise(prepared.step.blocks) == -1
        return TangentAtEquilibrium(problem, solution, prepared, sides - 1, singular, ring.state, ring)
    run = _Iterations(problem, prepared, DIRECT, None)
    run._set_start(solution, DIRECT.switches[0])
    prepared = run.prepared
    step, system = prepared.step, prepared.system
    sides = newton_step.linearise(
        problem.structure, run.loading, prepared.pattern, run.tension, NEUTRAL, run.state, step
    )
    singular = system.factorise(step.blocks) == -1
    touching = replace(problem, loading=run.loading)
    return TangentAtEquilibrium(touching, solution, prepared, sides - 1, singular, run.state)


def moved_by(tangent: TangentAtEquilibrium, force: Floats) -> Floats:
    """Moves of the nodes by small forces on them, (n, 3) both, m and N: one back-substitution.

    The tangent's factors, or those of a tangent nearby that took their place, stand for its own.
    """
    step, system = tangent.prepared.step, tangent.prepared.system
    step.right[0] = force
    newton_step.combine(system.solve(step.right[: 1 + tangent.products]), step, step.move)
    return step.move.copy()


def solve_nearby(
    problem: Problem,
    tolerance: float,
    start: Solution,
    tangent: TangentAtEquilibrium,
    settings: NewtonSettings = NEARBY,
) -> Solution:
    """Equilibrium a step or two from a start near the one whose tangent is known; not converged if it is farther.

    The first iteration takes the tangent's factors; where they are of no use it makes its own.
    """
    return _solve(_Iterations(problem, tangent.prepared, settings, None, takes_factors=True), tolerance, start)


def polished(tangent: TangentAtEquilibrium, tolerance: float) -> Solution | None:
    """The equilibrium of a tangent to a smaller tolerance, by its own factors and from the state it was taken in.

    None where a few iterations do not get there. The report is that of the equilibrium.
    """
    run = _Iterations(tangent.problem, tangent.prepared, NEARBY, None, takes_factors=True)
    run.measured = tangent.state
    ended = run.to_equilibrium(tolerance, tangent.solution, NEARBY.switches[0])
    return run.ended_from(tangent.solution) if ended.converged else None


def drifted(tangent: TangentAtEquilibrium, tolerance: float) -> Solution | None:
    """Where the iterations of ``NEARBY`` lead from an equilibrium that they do not bring to a tolerance.

    Netting all but slack moves on and on for next to no force. None where they fail, or do reach it.
    """
    problem, start = tangent.problem, tangent.solution
    run = _Iterations(problem, tangent.prepared, NEARBY, None)
    ended = run.to_equilibrium(tolerance, start, NEARBY.switches[0])
    return run.ended_from(start) if ended is Outcome.STEPS_SPENT else None


class _Iterations:
    """Iterations from a start to wherever they get."""

    def __init__(
        self,
        problem: Problem,
        prepared: Prepared,
        settings: NewtonSettings,
        progress: Progress | None,
        takes_factors: bool = False,
    ) -> None:
        self.problem, self.structure = problem, problem.structure
        self.watched = Watched(problem, prepared)
        self.settings, self.progress = settings, progress
        self.takes_factors = takes_factors
        self.measured: State | None = None
        """That of the start, with the first of the weights, where it is there already."""
        self.state, self.first, self.second = prepared.states
        self.iterations = 0
        self.singular = False
        self.refused: Refusal | None = None
        self.history: list[float] = []

    @property
    def loading(self) -> Loading:
        """What acts on the net, contact where it is now."""
        return self.watched.loading

    @property
    def prepared(self) -> Prepared:
        """The unknowns numbered, for what touches now."""
        return self.watched.prepared

    def from_start(
        self, start: Solution, tolerance: float, switches: tuple[float, ...], attempts: list[str]
    ) -> Outcome:
        """Try the weights of the test for taut bars in order, and note each attempt."""
        for switch in switches:
            before = self.iterations
            outcome = self.to_equilibrium(tolerance, start, switch)
            attempts.append(
                f"{METHOD} with {self.prepared.system.name}, switch {switch:g}: {self.iterations - before} iterations, "
                f"residual {self.state.residual:.1e}. {told(outcome, self.refused)}"
            )
            if outcome.balanced or outcome is Outcome.NOT_FINITE:
                break
        return outcome

    def to_equilibrium(self, tolerance: float, start: Solution | None, switch: float) -> Outcome:
        """Iterate until residual, axial imbalance and length error are within their tolerances."""
        unseen = None if self.measured is not None else start
        if unseen is not None and not math.isfinite(unseen.positions.sum() + unseen.bar_tension.sum()):
            # a relaxation that lost its footing is no start
            self.state.marks[:] = (np.inf, np.inf, np.inf, np.inf, 0.0, 0.0)
            return Outcome.NOT_FINITE
        self._set_start(start, switch)
        settings, shift = self.settings, 0.0
        kept = self.takes_factors and self.prepared.system.ready
        first, last = (self.iterations + n for n in (settings.least_iterations, settings.iterations_allowed))
        while True:
            merit, residual, imbalance, length_error, fits, lowest = self.state.marks[0].item()
            error = max(residual, imbalance)
            if not math.isfinite(merit) or not math.isfinite(error):
                return Outcome.NOT_FINITE
            self.history.append(error)
            if self.progress is not None:
                self.progress(METHOD, error)
            if error <= tolerance and length_error <= LENGTH_TOLERANCE and self.iterations >= first:
                if lowest < -ROUND_OFF * self.tension:
                    return Outcome.COMPRESSED
                if lowest < 0.0:
                    self.state.density[:] = carried(self.structure.is_strut, self.state.density)
                    self._measure()
                    continue
                if self.settings.refuses:
                    self.refused = refusal(self.problem, self.state.position, self.state.share)
                    if self.refused is not None:
                        return self.refused.outcome
                return Outcome.CONVERGED if fits else Outcome.OVERFULL
            if self.iterations >= last:
                return Outcome.STEPS_SPENT
            self.iterations += 1
            if kept:
                kept = False
                if self._advance(0.0, tolerance, fresh=False):
                    continue
            while not self._advance(shift, tolerance):
                shift = max(10.0 * shift, FIRST_SHIFT)
                if shift > LARGEST_SHIFT:
                    return Outcome.SINGULAR if self.singular else Outcome.NOT_IMPROVING
            shift = 0.1 * shift if shift > FIRST_SHIFT else 0.0

    def ended_from(self, start: Solution) -> Solution:
        """Where the iterations have led to, with the report of where they began."""
        state = self.state
        tension = carried(self.structure.is_strut, state.density * state.length)
        return replace(start, positions=state.position.copy(), bar_tension=tension, share=state.share.copy())

    def _set_start(self, start: Solution | None, switch: float) -> None:
        state, structure = self.state, self.structure
        self.switch = switch
        if self.measured is not None and start is not None:
            self.state, self.measured, self.tension = self.measured, None, start.mean_tension
            return
        if start is None:
            state.position[:] = self.problem.net.positions
        else:
            take_over(structure, np.ascontiguousarray(start.positions), start.bar_tension, state)
        self.tension = start.mean_tension if start is not None else 0.0
        if self.tension == 0.0:
            self.tension = reference_tension(self.problem)
            state.density[:] = self.tension / structure.length
        self._measure()

    def _measure(self) -> None:
        self.watched.look(self.state.position)
        measure(self.structure, self.loading, self.tension, self.switch, 0.0, self.state)

    def _advance(self, shift: float, tolerance: float, fresh: bool = True) -> bool:
        """Take one step with the tangent shifted; False if no good one was found."""
        system = self.prepared.system
        iteration = Iteration(
            structure=self.structure,
            loading=self.loading,
            pattern=self.prepared.pattern,
            tension=self.tension,
            switch=self.switch,
            limits=Limits(
                LARGEST_TURN,
                SHORTEST_STEP,
                CLEAR_FALL,
                system.worthwhile_fall,
                tolerance,
                LENGTH_TOLERANCE,
            ),
            state=self.state,
            first=self.first,
            second=self.second,
            step=self.prepared.step,
        )
        if isinstance(system, BandedSystem):
            where, negative = advance_banded(system.arrays, iteration, shift, fresh)
        else:
            where, negative = advance(system, iteration, shift, fresh)
        self.singular = negative == -1
        if where == FAILED:
            return False
        last = self.state
        if where == IN_FIRST:
            self.state, self.first = self.first, self.state
        else:
            self.state, self.second = self.second, self.state
        if self.problem.surface is not None:
            self._stop_short(last)
        return True

    def _stop_short(self, last: State) -> None:
        """Go back on the way from the last state to where nothing has passed through anything, and look again."""
        state = self.state
        move = state.position - last.position
        share = self.watched.free_share(last.position, move)
        if share < 1.0:
            state.position[:] = last.position + share * move
            state.density[:] = last.density + share * (state.density - last.density)
        self._measure()
