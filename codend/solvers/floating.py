"""Equilibrium of a net and of the rigid body that floats and carries it, all unknowns at once.

Newton's method on the places of the nodes, the force densities of the bars and the six unknowns of the body
(``mechanics.body``, ``body_system``), with the ``barrier`` made lower and lower and none at the end. After a step the
body is turned by the whole rotation, not by its first order. What no mooring holds is left where it is: a body without
one is free in x, y and yaw, of which nothing is asked but that loads there cancel. With contact between parts of a net
(``Problem.of(contact=...)``) no step goes past where any would pass through another.
"""

import numpy as np

from codend.mechanics import body as rigid
from codend.mechanics import newton_step
from codend.mechanics.bars import carried
from codend.mechanics.body import Pose
from codend.mechanics.newton_state import State, measure
from codend.mechanics.problem import Problem
from codend.mechanics.structure import Structure
from codend.net.net import Floats
from codend.solvers import interior_kernels as kernels
from codend.solvers.barrier import KEPT_TAUT, LARGEST_TURN, Course, lower
from codend.solvers.body_system import BodySystem, out_of_balance, residual_of
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import LENGTH_TOLERANCE, reference_tension
from codend.solvers.interior_point import InteriorPointSettings
from codend.solvers.outcome import START, Midway, Outcome, Progress, Solution, SolverReport
from codend.solvers.prepared import Prepared, prepare
from codend.solvers.refusal import refusal, told
from codend.solvers.watched import Watched

METHOD = "newton with a floating body"
SETTINGS = InteriorPointSettings()
LEAST_TENSION_N = 1e-9
"""Where nothing pulls at any bar."""
BALANCED = 1e-9
"""Residual to which the last barrier is followed."""
CLOSE = 1e-6
"""Residual at the last barrier from which the finish is tried though its steps be spent."""
LARGEST_TILT = 0.1
"""Largest rotation of the body in one step, rad."""
FARTHEST = 1.0
"""Largest move of the body in one step, over its size: out of the water, or all under it, nothing resists its heave."""
LAST_STEPS = 40
PUSHES = (0.3, 1.0, -1.0, 2.0)
"""Rotations in rad, or moves over the body's size, by which it leaves an equilibrium that it would not keep."""
SWITCHES = (1.0, 0.1, 0.01)
"""Weights of the test for taut bars at the end, tried in order."""


def solve(
    problem: Problem, tolerance: float, start: Solution | None = None, progress: Progress | None = None
) -> Solution:
    """Equilibrium of a net that hangs on a body afloat; positions of the body's nodes tell its pose.

    Args:
        problem: the net under its loads, with a body.
        tolerance: largest residual of a node, over loads and tensions, and of the body, its own weight among them.
        start: positions and tensions to start from; without one those in which the net was built.
        progress: told the residual of every step.
    """
    return solution_and_shape(problem, tolerance, start, progress)[0]


def solution_and_shape(
    problem: Problem, tolerance: float, start: Solution | None = None, progress: Progress | None = None
) -> tuple[Solution, Floats | None]:
    """What ``solve`` does, and how body and net float if the net may pass through itself, (n, 3).

    The body is then near to where it floats if not. None where they do not float so either.
    """
    with Clock() as clock:
        run = _Run(problem, progress)
        run.set_start(start)
        outcome, note = run.to_equilibrium(tolerance)
        floats = outcome in (Outcome.CONVERGED, Outcome.PASSED_THROUGH)
        shape = run.state.position.copy() if floats else None
        for push in PUSHES:
            if outcome is not Outcome.TURNS_OVER:
                break
            run.push(push)
            outcome, note = run.to_equilibrium(tolerance)
        spent_ms = clock.ms
    state = run.state
    report = SolverReport(
        method=METHOD,
        outcome=outcome,
        iterations=run.steps,
        residual=state.residual,
        imbalance=state.imbalance,
        length_error=state.length_error,
        solve_ms=spent_ms,
        attempts=(f"{METHOD}: {run.steps} steps, residual {state.residual:.1e}. {note}",),
    )
    return Solution.ended(report, state.position, state.density * state.length, state.share), shape


class _Run:
    """Steps from a start to wherever they get."""

    def __init__(self, problem: Problem, progress: Progress | None) -> None:
        assert problem.body is not None
        self.problem, self.body, self.progress = problem, problem.body, progress
        self.watched = Watched(problem, prepare(problem.structure, problem.bands))
        self.system = BodySystem(problem, self.prepared)
        self.state, self.spare, _ = self.prepared.states
        self.pose = rigid.pose_of(self.body, problem.net.positions)
        self.steps = 0
        self.grows: Floats | None = None
        """How the body would leave the equilibrium found, (6,)."""

    @property
    def prepared(self) -> Prepared:
        """The unknowns numbered, for what touches now."""
        return self.watched.prepared

    def set_start(self, start: Solution | None) -> None:
        """Set out from a solution, or from the net as it was built."""
        problem, state = self.problem, self.state
        mean = 0.0 if start is None else start.mean_tension
        self.tension = mean or max(reference_tension(problem), LEAST_TENSION_N)
        self.taut = KEPT_TAUT
        self.midway: Midway | None = None
        state.position[:] = problem.net.positions if start is None else start.positions
        self.pose = rigid.pose_of(self.body, state.position)
        if start is None:
            self.pose = rigid.afloat(self.body, self.pose, -float(problem.loading.dead[:, 2].sum()))
            rigid.place(self.body, self.pose, state.position)
        tensions = self.tension if start is None else np.maximum(start.bar_tension, 0.01 * self.tension)
        state.density[:] = tensions / problem.structure.length
        self.watched.look(state.position)
        self._measure(state, self.pose, 1.0)

    def to_equilibrium(self, tolerance: float) -> tuple[Outcome, str]:
        """Lower the barrier, then go on without it; how that ended, in short and in words."""
        outcome = self._lower()
        if outcome is not Outcome.CONVERGED:
            return outcome, outcome.value
        reached = self.state.position.copy(), self.state.density.copy(), self.pose
        self.taut, self.system.steering = 0.0, False
        for switch in SWITCHES:
            self.state.position[:], self.state.density[:], self.pose = reached
            self._measure(self.state, self.pose, switch)
            outcome = self._finish(tolerance, switch)
            if outcome is Outcome.CONVERGED:
                break
        refused = refusal(self.problem, self.state.position, self.state.share) if outcome.converged else None
        outcome = outcome if refused is None else refused.outcome
        if outcome is Outcome.CONVERGED:
            self.linearise(self.problem.structure, 0.0, 1.0)
            self.grows = self.system.growing()
            outcome = outcome if self.grows is None else Outcome.TURNS_OVER
        return outcome, told(outcome, refused)

    def push(self, far: float) -> None:
        """Set out again a way off in the direction in which the body would not stay."""
        assert self.grows is not None
        pose = rigid.moved(self.pose, far * self.body.size_m * self.grows)
        rigid.place(self.body, pose, self.state.position)
        start = Solution(self.state.position.copy(), self.state.density * self.state.length, self.state.share, START)
        self.set_start(start)
        self.system.steering = True

    def _lower(self) -> Outcome:
        structure = self.problem.structure
        tension = max(self.tension, kernels.largest_force(structure, self.state.load))
        course = Course(
            first=SETTINGS.first_barrier,
            last=SETTINGS.last_barrier * self.tension / tension,
            steps_allowed=SETTINGS.steps_allowed,
            # frames that sink until they hang on their moorings take more than 80 in a row
            patience=SETTINGS.steps_allowed,
            enough=BALANCED,
            close=CLOSE,
        )
        outcome, steps, _ = lower(self, structure, tension, course, self.progress, METHOD)
        self.steps += steps
        return outcome

    def left_over(self) -> float:
        """See ``barrier.Led``: on the net, and on the body."""
        return max(kernels.largest_force(self.problem.structure, self.state.force), self.left)

    def _finish(self, tolerance: float, switch: float) -> Outcome:
        for _ in range(LAST_STEPS):
            state = self.state
            if max(state.residual, state.imbalance) <= tolerance and state.length_error <= LENGTH_TOLERANCE:
                if float((state.density * state.length).min(initial=0.0)) < -1e-9 * self.tension:
                    return Outcome.COMPRESSED
                state.density[:] = carried(self.problem.structure.is_strut, state.density)
                return Outcome.CONVERGED
            if not np.isfinite(state.residual):
                return Outcome.NOT_FINITE
            self.steps += 1
            turn, _ = self.linearise(self.problem.structure, 0.0, 1.0)
            if not np.isfinite(turn):
                return Outcome.SINGULAR
            self._take(min(1.0, LARGEST_TURN / turn) if turn > 0.0 else 1.0, switch)
        return Outcome.NOT_IMPROVING

    def linearise(self, softened: Structure, shift: float, exact: float) -> tuple[float, float]:
        """See ``barrier.Led``; the body's turn is that of its pose over what it may."""
        state, prepared, loading = self.state, self.prepared, self.watched.loading
        structure, step = self.problem.structure, prepared.step
        if self.system.prepared is not prepared:
            steering, self.system = self.system.steering, BodySystem(self.problem, prepared)
            self.system.steering = steering
        acting = loading._replace(contact=loading.contact._replace(exact=exact))
        newton_step.linearise(softened, acting, prepared.pattern, self.tension, 0.0, state, step)
        if shift > 0.0:
            kernels.shift_by_resistance(structure, prepared.pattern, state, shift, step.blocks)
        if self.system.factorise(step.blocks, self.pose, state.force) != 0:
            return np.nan, np.nan
        solved = self.system.solve(step.right[:1], self.pose)
        newton_step.finish_step(structure, state, state, solved, step)
        of_bars = kernels.largest_turn(structure, state, step)
        moved, tilt = (float(np.linalg.norm(part)) for part in np.split(self.system.twist, 2))
        of_body = max(moved / (FARTHEST * self.body.size_m), tilt / LARGEST_TILT)
        return max(of_bars, LARGEST_TURN * of_body), of_bars

    def correct(self, barrier: float, loosening: Floats, way: float) -> float:
        """See ``barrier.Led``: nothing is mended, as what the body's turn leaves is not in the right side."""
        return way

    def go(self, loosening: Floats, share: float) -> float:
        """See ``barrier.Led``."""
        kernels.go(self.state, self.prepared.step, loosening, share, self.spare)
        return self._carry_body(share, 1.0)

    def _take(self, size: float, switch: float) -> None:
        step, new = self.prepared.step, self.spare
        new.position[:] = self.state.position + size * step.move
        new.density[:] = self.state.density + size * step.change
        self._carry_body(size, switch)

    def _carry_body(self, share: float, switch: float) -> float:
        """Take the body a share of its step to where the net is in the spare state, and go on from there.

        Returns:
            the share of that way that is gone: as far as nothing passes through anything.
        """
        state, new, pose = self.state, self.spare, self.pose
        self.pose = rigid.moved(pose, share * self.system.twist)
        rigid.place(self.body, self.pose, new.position)
        way = new.position - state.position
        free = self.watched.go_along(state.position, way)
        if free < 1.0:
            new.position[:] = state.position + free * way
            new.density[:] = state.density + free * (new.density - state.density)
            new.slack[:] = state.slack + free * (new.slack - state.slack)
            self.pose = rigid.moved(pose, free * share * self.system.twist)
            rigid.place(self.body, self.pose, new.position)
        self._measure(new, self.pose, switch)
        self.state, self.spare = new, self.state
        return free

    def _measure(self, state: State, pose: Pose, switch: float) -> None:
        """Write what is out of balance, in the residual the body as well."""
        structure, loading = self.problem.structure, self.watched.loading
        measure(structure, loading, self.tension, switch, self.taut, state)
        left = out_of_balance(self.body, pose, state.force)
        self.left = float(max(np.linalg.norm(left[:3]), np.linalg.norm(left[3:]) / self.body.size_m))
        error = residual_of(self.body, left, float(np.linalg.norm(state.load, axis=1).sum()) + self.tension)
        state.marks["residual"] = max(float(state.marks["residual"][0]), error)
