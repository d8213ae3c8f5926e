"""Equilibrium by the motion of rigid bars in time (Bessonneau and Marichal 1997, section 5; Le Bris et al. 1999, 3.2).

The empty net is let go in the current, the catch comes by and by, and the motion goes on until the net is at rest. What
is returned as converged meets the same criteria as the other methods' answers: residual, axial imbalance and lengths,
with no twine in compression. Rigid bars can carry it; an equilibrium that needs it of twine is refused.

Nothing but the drag of the moving bars damps the motion, and in the catch, where the water goes with the net, that drag
falls with the square of the speed: left alone a net may swing on for long with ever smaller speeds, and without twine
drag it does for ever. So once the catch is all there the net is stopped whenever its kinetic energy has passed a peak
(``stop_at_peaks``), which is not in the papers and does not change where it ends.
"""

from dataclasses import dataclass

import numpy as np

from codend.mechanics.balance import out_of_balance
from codend.mechanics.bars import add_bar_forces, bar_lengths, carried, length_error
from codend.mechanics.problem import Problem
from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import Floats
from codend.solvers.clock import Clock
from codend.solvers.dynamic_relaxation import LENGTH_TOLERANCE
from codend.solvers.outcome import Outcome, Progress, Solution, SolverReport
from codend.solvers.refusal import Refusal, refusal, told
from codend.solvers.rigid_motion import RigidMotion

METHOD = "rigid-bars"
LOOK = 25
"""Steps between two looks at the state of the motion."""
LOST = 0.5
"""Drift of a bar, relative, beyond which the motion has lost its footing."""
SAFETY = 0.5
"""Time step over the largest stable one, halved at every restart."""
REST_SPEED = 1e-3
"""Root mean square of the nodes' speeds over the towing speed at which the net counts as at rest (LB99 5)."""


@dataclass(frozen=True)
class RigidBarsSettings:
    """What may be tuned; the defaults hold for all plans the project knows."""

    time_step_s: float | None = None
    """None: ``SAFETY`` times the largest stable step, found anew for every step."""
    ramp_s: float = 0.5
    """Time in which the catch's pressure comes up, from the empty net."""
    stop_at_peaks: bool = True
    """Stop the net at peaks of its kinetic energy, once the catch is all there."""
    slack: bool = False
    """Drop twine that would carry compression for a step, instead of refusing an equilibrium that has it."""
    steps_allowed: int = 60_000
    restarts: int = 2
    """Restarts with half the time step when the motion loses its footing; none with a ``time_step_s``."""


@dataclass(frozen=True)
class RigidBarsReport(SolverReport):
    """What the motion was like."""

    motion_s: float = 0.0
    """Time that passed for the net."""
    time_step_s: float = 0.0
    """Mean time step."""
    largest_drift: float = 0.0
    """Largest departure of a bar from its length in the whole motion, relative."""
    rms_speed_m_s: float = 0.0
    """Largest in the last look."""
    stops: int = 0


def solve(
    problem: Problem,
    tolerance: float,
    start: Solution | None = None,
    settings: RigidBarsSettings = RigidBarsSettings(),
    progress: Progress | None = None,
) -> Solution:
    """Equilibrium of a net, from the positions it was built with or those of a start; see ``Solver``.

    Args:
        problem: the net under its loads; its bars must be inextensible and have mass, their own or the water's.
        tolerance: largest residual and axial imbalance.
        start: where the motion starts from rest.
        settings: see ``RigidBarsSettings``.
        progress: told the residual now and then (infinite until the net has come to rest for the first time).
    """
    if problem.surface is not None:
        raise ValueError("this method knows no contact: use find_equilibrium")
    attempts: list[str] = []
    steps, safety = 0, SAFETY
    with Clock() as clock:
        for _ in range(1 if settings.time_step_s is not None else settings.restarts + 1):
            run = _MotionToRest(problem, start, settings, safety, progress)
            outcome = run.to_rest(tolerance)
            steps += run.steps
            mean_step = run.time_s / run.steps if run.steps else 0.0
            attempts.append(
                f"{METHOD}, time step {mean_step:.1e} s: {run.steps} steps, {run.time_s:.3g} s of motion, "
                f"{run.stops} stops, drift up to {run.largest_drift:.1e}, residual {run.residual:.1e}. "
                f"{told(outcome, run.refused)}"
            )
            if outcome is not Outcome.NOT_FINITE or run.steps == 0:
                break
            safety *= 0.5
        spent_ms = clock.ms
    report = RigidBarsReport(
        method=METHOD,
        outcome=outcome,
        iterations=steps,
        residual=run.residual,
        imbalance=run.imbalance,
        length_error=run.length_error,
        solve_ms=spent_ms,
        attempts=tuple(attempts),
        motion_s=run.time_s,
        time_step_s=mean_step,
        largest_drift=run.largest_drift,
        rms_speed_m_s=run.speed,
        stops=run.stops,
    )
    return Solution.ended(report, run.motion.position, run.tension, run.motion.share)


class _MotionToRest:
    """One motion, from the start to wherever it gets."""

    def __init__(
        self,
        problem: Problem,
        start: Solution | None,
        settings: RigidBarsSettings,
        safety: float,
        progress: Progress | None,
    ) -> None:
        self.problem, self.settings, self.safety, self.progress = problem, settings, safety, progress
        still = np.zeros_like(problem.net.positions)
        positions = problem.net.positions if start is None else start.positions
        self.motion = RigidMotion(problem, positions, still, slack=settings.slack)
        # in still water, the speed of a free fall by a bar's length
        fall_m_s = np.sqrt(GRAVITY_M_S2 * problem.structure.length.mean())
        self.flow_m_s = problem.loading.water.fastest or float(fall_m_s)
        self.steps, self.stops = 0, 0
        self.time_s = self.speed = self.largest_drift = 0.0
        self.residual = self.imbalance = self.length_error = np.inf
        self.tension: Floats = np.full(len(problem.net.bars), np.nan)
        self.refused: Refusal | None = None

    def to_rest(self, tolerance: float) -> Outcome:
        """Step until the net is at rest."""
        motion, settings = self.motion, self.settings
        if not motion.bring_to_lengths() < LENGTH_TOLERANCE:
            self.largest_drift = motion.drift
            return Outcome.NOT_FINITE
        last_energy, peak_speed = 0.0, 0.0
        while self.steps < settings.steps_allowed:
            filling = min(1.0, self.time_s / settings.ramp_s) if settings.ramp_s > 0.0 else 1.0
            dt = settings.time_step_s
            if dt is None:
                # before there are tensions, the drag alone would allow far too long a step
                longest = settings.ramp_s / 100.0 if settings.ramp_s > 0.0 else np.inf
                dt = min(self.safety * motion.stable_time_step(), longest)
            if not motion.step(dt, filling):
                return Outcome.NOT_FINITE
            self.steps += 1
            self.time_s += dt
            self.largest_drift = max(self.largest_drift, motion.drift)
            if not self.largest_drift < LOST:
                return Outcome.NOT_FINITE
            peak_speed = max(peak_speed, motion.rms_speed_m_s)
            if filling == 1.0 and settings.stop_at_peaks:
                energy = motion.kinetic_energy_j
                if energy < last_energy:
                    motion.velocity[:] = 0.0
                    energy = 0.0
                    self.stops += 1
                last_energy = energy
            last = self.steps == settings.steps_allowed
            if last or self.steps % LOOK == 0:
                self.speed, peak_speed = peak_speed, 0.0
                at_rest = filling == 1.0 and self.speed <= REST_SPEED * self.flow_m_s
                outcome = self._look(tolerance) if at_rest or last else None
                if self.progress is not None:
                    self.progress(METHOD, float(max(self.residual, self.imbalance)))
                if outcome is not None and at_rest:
                    return outcome
        return Outcome.STEPS_SPENT

    def _look(self, tolerance: float) -> Outcome | None:
        """How it ends if the net is an equilibrium as it lies; else None, and the motion goes on as if nothing was."""
        motion, structure = self.motion, self.problem.structure
        moving = motion.state()
        motion.bring_to_lengths()
        if not motion.tensions_at_rest():
            motion.set_state(moving)
            return None
        self.residual, self.imbalance = self._out_of_balance(motion.density)
        outcome = None
        if max(self.residual, self.imbalance) <= tolerance:
            density = carried(structure.is_strut, motion.density)
            self.residual, self.imbalance = self._out_of_balance(density)
            length = np.empty_like(density)
            bar_lengths(motion.position, structure, length)
            self.length_error = length_error(structure, length, density)
            self.tension = density * length
            if max(self.residual, self.imbalance) > tolerance:
                outcome = Outcome.COMPRESSED
            elif self.length_error <= LENGTH_TOLERANCE:
                self.refused = refusal(self.problem, motion.position, motion.share)
                fits = Outcome.CONVERGED if motion.fits else Outcome.OVERFULL
                outcome = fits if self.refused is None else self.refused.outcome
        if outcome is None:
            motion.set_state(moving)
        return outcome

    def _out_of_balance(self, density: Floats) -> tuple[float, float]:
        load = self.motion.force
        force = load.copy()
        add_bar_forces(self.motion.position, self.problem.structure, density, force)
        tension = float(np.mean(np.abs(density) * self.motion.lengths()))
        residual, imbalance = out_of_balance(self.problem.structure, force, load, tension)
        return float(residual), float(imbalance)
