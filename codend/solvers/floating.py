"""Equilibrium of a net and of the rigid body that floats and carries it, all unknowns at once.

Newton's method on the places of the nodes, the force densities of the bars and the six unknowns of the body
(``mechanics.body``, ``body_system``), with the barrier of ``interior_point`` made lower and lower and no barrier at the
end. After a step the body is turned by the whole rotation, not by its first order. What no mooring holds is left where
it is: a body without one is free in x, y and yaw, of which nothing is asked but that loads there cancel.
"""

import numpy as np

from codend.mechanics import body as rigid
from codend.mechanics import newton_step
from codend.mechanics.bars import carried
from codend.mechanics.body import Pose
from codend.mechanics.newton_state import State, measure
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.barrier import share_to_slack, softened
from codend.solvers.body_system import BodySystem, out_of_balance, residual_of
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import LENGTH_TOLERANCE, reference_tension
from codend.solvers.outcome import START, Outcome, Progress, Solution, SolverReport
from codend.solvers.prepared import prepare
from codend.solvers.refusal import refusal, told

METHOD = "newton with a floating body"
FIRST_BARRIER, LAST_BARRIER = 1e-3, 1e-12
"""In units of the reference tension over the square of the mean length of bars."""
FIRST_SHIFT, LARGEST_SHIFT = 1e-4, 1e3
NEAREST_TO_SLACK, LARGEST_TURN, FARTHEST_TURN = 0.99, 0.5, 5.0
LARGEST_TILT = 0.1
"""Largest rotation of the body in one step, rad."""
STEPS_ALLOWED, LAST_STEPS = 300, 40
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
        self.prepared = prepare(problem.structure, problem.bands)
        self.system = BodySystem(problem, self.prepared)
        self.state, self.spare, _ = self.prepared.states
        self.pose = rigid.pose_of(self.body, problem.net.positions)
        self.steps = 0
        self.grows: Floats | None = None
        """How the body would leave the equilibrium found, (6,)."""

    def set_start(self, start: Solution | None) -> None:
        """Set out from a solution, or from the net as it was built."""
        problem, state = self.problem, self.state
        self.tension = max(reference_tension(problem), 1e-9) if start is None else start.mean_tension
        unit = self.tension / float(problem.structure.length.mean()) ** 2
        self.barrier, self.last = FIRST_BARRIER * unit, LAST_BARRIER * unit
        state.position[:] = problem.net.positions if start is None else start.positions
        self.pose = rigid.pose_of(self.body, state.position)
        if start is None:
            self.pose = rigid.afloat(self.body, self.pose, -float(problem.loading.dead[:, 2].sum()))
            rigid.place(self.body, self.pose, state.position)
        tensions = self.tension if start is None else np.maximum(start.bar_tension, 0.01 * self.tension)
        state.density[:] = tensions / problem.structure.length
        self._measure(state, self.pose, 1.0)

    def to_equilibrium(self, tolerance: float) -> tuple[Outcome, str]:
        """Lower the barrier, then go on without it; how that ended, in short and in words."""
        outcome = self._lower()
        if outcome is not Outcome.CONVERGED:
            return outcome, outcome.value
        reached = self.state.position.copy(), self.state.density.copy(), self.pose
        self.barrier, self.system.steering = 0.0, False
        for switch in SWITCHES:
            self.state.position[:], self.state.density[:], self.pose = reached
            self._measure(self.state, self.pose, switch)
            outcome = self._finish(tolerance, switch)
            if outcome is Outcome.CONVERGED:
                break
        refused = refusal(self.problem, self.state.position, self.state.share) if outcome.converged else None
        outcome = outcome if refused is None else refused.outcome
        if outcome is Outcome.CONVERGED:
            self._linearise(0.0)
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
        shift = 0.0
        for _ in range(STEPS_ALLOWED):
            if self.progress is not None:
                self.progress(METHOD, self.state.residual)
            if not np.isfinite(self.state.residual):
                return Outcome.NOT_FINITE
            if self.barrier <= self.last and self.state.residual <= 1e-9:
                return Outcome.CONVERGED
            self.steps += 1
            turn, shift = self._linearise(shift)
            if not np.isfinite(turn):
                return Outcome.SINGULAR
            step = self.prepared.step
            to_slack = share_to_slack(self.problem.structure, self.state.density, step.change)
            size = min(1.0, NEAREST_TO_SLACK * to_slack, LARGEST_TURN / turn if turn > 0.0 else 1.0)
            if size > 0.5 and shift == 0.0:
                self.barrier = max((0.1 if size > 0.9 else 0.5) * self.barrier, self.last)
            shift = 0.1 * shift if shift > FIRST_SHIFT else 0.0
            self._take(size, 1.0)
        return Outcome.CONVERGED if self.state.residual <= 1e-6 else Outcome.STEPS_SPENT

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
            turn, _ = self._linearise(0.0)
            if not np.isfinite(turn):
                return Outcome.SINGULAR
            self._take(min(1.0, LARGEST_TURN / turn) if turn > 0.0 else 1.0, switch)
        return Outcome.NOT_IMPROVING

    def _linearise(self, shift: float) -> tuple[float, float]:
        """Write the step at the state, with the net's tangent shifted until it leads not too far; its turn, the shift.

        The turn is the largest change of a bar's vector over its length, or of the body's attitude over what it may.
        """
        problem, prepared, state = self.problem, self.prepared, self.state
        step = prepared.step
        structure = problem.structure
        softer = softened(structure, state.density, self.barrier)
        while True:
            turn = asked = np.inf
            newton_step.linearise(softer, problem.loading, prepared.pattern, self.tension, shift, state, step)
            if self.system.factorise(step.blocks, self.pose, state.force) == 0:
                solved = self.system.solve(step.right[:1], self.pose)
                _, asked, _ = newton_step.finish_step(problem.structure, state, state, solved, step)
                tilt = float(np.linalg.norm(self.system.twist[3:]))
                turn = max(float(asked), LARGEST_TURN / LARGEST_TILT * tilt)
            if asked <= FARTHEST_TURN or shift >= LARGEST_SHIFT or self.barrier == 0.0:
                return turn, shift
            shift = max(10.0 * shift, FIRST_SHIFT)

    def _take(self, size: float, switch: float) -> None:
        step, new = self.prepared.step, self.spare
        new.position[:] = self.state.position + size * step.move
        new.density[:] = self.state.density + size * step.change
        self.pose = rigid.moved(self.pose, size * self.system.twist)
        rigid.place(self.body, self.pose, new.position)
        self._measure(new, self.pose, switch)
        self.state, self.spare = new, self.state

    def _measure(self, state: State, pose: Pose, switch: float) -> None:
        """Write what is out of balance, in the residual the body as well."""
        structure, loading = self.problem.structure, self.problem.loading
        measure(structure, loading, self.tension, switch, self.barrier, state)
        left = out_of_balance(self.body, pose, state.force)
        error = residual_of(self.body, left, float(np.linalg.norm(state.load, axis=1).sum()) + self.tension)
        state.marks["residual"] = max(float(state.marks["residual"][0]), error)
