"""Dynamic relaxation: damped motion under fictitious masses until it stops at the equilibrium.

Bars that cannot stretch, or hardly, are held by multipliers (augmented Lagrangian): the motion is relaxed under a
moderate penalty, the multipliers are set to the tensions found, and so on until the lengths are right.
"""

from dataclasses import dataclass

import numpy as np

from codend.mechanics import relaxation
from codend.mechanics.bars import augmented_law, bar_lengths, length_error
from codend.mechanics.loads import add_force
from codend.mechanics.problem import Problem
from codend.mechanics.relaxation import Workspace
from codend.net.net import Floats
from codend.solvers.clock import Clock
from codend.solvers.outcome import START, Outcome, Progress, Solution, SolverReport
from codend.solvers.refusal import Refusal, passage, refusal, told

METHOD = "dynamic-relaxation"
LENGTH_TOLERANCE = 1e-6
"""Largest length error of a bar, relative."""

ROUGH = 2.5e-3
"""Residual to which a start without tensions is relaxed before the multipliers are first set."""
TIGHTENING = 0.05
"""Residual asked for between two settings of the multipliers, over the length error at the last."""
CANCELLED = 1e-6
"""Resultant of the loads, over the sum of their sizes, that says nothing of the tensions any more."""
STEPS_AT_ONCE = 20_000
"""Steps between two looks at the progress."""
FIRST_WHILE = 20
"""Steps between two looks at what is near what, at first."""

_OUTCOMES = {
    relaxation.CONVERGED: Outcome.CONVERGED,
    relaxation.STEPS_SPENT: Outcome.STEPS_SPENT,
    relaxation.NOT_FINITE: Outcome.NOT_FINITE,
    relaxation.OVERSTRETCHED: Outcome.OVERSTRETCHED,
    relaxation.OVERFULL: Outcome.OVERFULL,
}


@dataclass(frozen=True)
class RelaxationSettings:
    """What may be tuned; the defaults hold for all plans the project knows."""

    viscous: bool = False
    """Viscous damping, critical for the lowest frequency, instead of kinetic damping."""
    penalty: float = 30.0
    """Axial stiffness EA that stands in for inextensible twine, in units of the reference tension."""
    mass_factor: float = 1.5
    """Fictitious masses over their bound for a stable unit time step."""
    steps_allowed: int = 200_000
    restarts: int = 4


def solve(
    problem: Problem,
    tolerance: float,
    start: Solution | None = None,
    settings: RelaxationSettings = RelaxationSettings(),
    progress: Progress | None = None,
) -> Solution:
    """Equilibrium of a net, from the positions it was built with or from a solution nearby; see ``Solver``.

    A net that balloons, loses its footing or passes through itself is restarted from the same shape with a penalty four
    times as stiff, one that makes no headway with masses twice as large; every attempt is in the report.
    """
    attempts: list[str] = []
    penalty, mass_factor = settings.penalty, settings.mass_factor
    steps = 0
    with Clock() as clock:
        for _ in range(settings.restarts + 1):
            work = relaxation.workspace(
                problem.structure, problem.bands, problem.net.positions if start is None else start.positions
            )
            run = _Relaxation(problem, work, settings, penalty, mass_factor, settings.steps_allowed - steps, progress)
            outcome = run.to_equilibrium(tolerance, start)
            if outcome.balanced:
                run.refused = refusal(problem, work.position, work.share)
                outcome = outcome if run.refused is None else run.refused.outcome
            steps += run.steps
            damping = "viscous" if settings.viscous else "kinetic"
            attempts.append(
                f"{METHOD}, {damping} damping, penalty {penalty:g}, masses x {mass_factor:g}: "
                f"{run.steps} steps, residual {run.residual:.1e}. {told(outcome, run.refused)}"
            )
            if outcome.balanced or steps >= settings.steps_allowed:
                break
            if outcome is not Outcome.STEPS_SPENT:
                penalty *= 4.0
            mass_factor *= 2.0
        spent_ms = clock.ms
    report = SolverReport(
        method=METHOD,
        outcome=outcome,
        iterations=steps,
        residual=run.residual,
        imbalance=run.imbalance,
        length_error=run.length_error,
        solve_ms=spent_ms,
        attempts=tuple(attempts),
    )
    return Solution.ended(report, work.state[:, :3], work.density * work.length, work.share)


def rough_shape(
    problem: Problem, rough_residual: float, penalty: float, steps_allowed: int = 20_000
) -> tuple[Solution, str]:
    """Shape and tensions of a net relaxed just enough for Newton's method to start from, and what was done.

    Inextensible bars are given a stiffness of ``penalty`` times the reference tension, four times as much if the net
    balloons. The solution's report tells the residual; it is no equilibrium.
    """
    structure = problem.structure
    steps = 0
    while True:
        work = relaxation.workspace(structure, problem.bands, problem.net.positions)
        augmented_law(structure, penalty * reference_tension(problem), work.relief, work.gain)
        code, spent, _, residual, imbalance = relaxation.relax(
            work, structure, problem.loading, rough_residual, 1.5, False, steps_allowed
        )
        steps += spent
        if code not in (relaxation.OVERSTRETCHED, relaxation.NOT_FINITE) or penalty > 1e4:
            break
        penalty *= 4.0
    note = f"rough relaxation, penalty {penalty:g}: {steps} steps, residual {residual:.1e}."
    report = SolverReport(
        "rough relaxation",
        Outcome.STEPS_SPENT,
        steps,
        residual,
        imbalance,
        np.inf,
        0.0,
        (note,),
    )
    positions = work.state[:, :3].copy()
    return Solution(positions, work.density * work.length, work.share.copy(), report), note


class _Relaxation:
    """One relaxation with one penalty, from the start to wherever it gets."""

    def __init__(
        self,
        problem: Problem,
        work: Workspace,
        settings: RelaxationSettings,
        penalty: float,
        mass_factor: float,
        steps_allowed: int,
        progress: Progress | None,
    ) -> None:
        self.problem, self.work, self.settings = problem, work, settings
        self.penalty, self.mass_factor, self.steps_allowed = penalty, mass_factor, steps_allowed
        self.progress = progress
        self.steps = 0
        self.while_steps = FIRST_WHILE
        self.residual = self.imbalance = self.length_error = np.inf
        self.tension = 0.0
        self.refused: Refusal | None = None

    def to_equilibrium(self, tolerance: float, start: Solution | None) -> Outcome:
        work, structure = self.work, self.problem.structure
        if start is None:
            self._set_law(reference_tension(self.problem))
            inner = ROUGH
        else:
            self._set_law(start.mean_tension)
            bar_lengths(start.positions, structure, work.length)
            work.multiplier[:] = start.bar_tension / work.length
            inner = max(tolerance, 0.1 * ROUGH)
        best, last_headway = np.inf, 0
        while True:
            code = self._relax(inner)
            if self.progress is not None:
                self.progress(METHOD, max(self.residual, self.imbalance))
            outcome = _OUTCOMES[code]
            if outcome in (Outcome.NOT_FINITE, Outcome.OVERSTRETCHED):
                return outcome
            if structure.order == 1.0 and self.problem.surface is None:
                # a full net that has passed through itself does not come back
                self.refused = passage(self.problem, np.ascontiguousarray(work.state[:, :3]))
                if self.refused is not None:
                    return self.refused.outcome
            if max(self.residual, self.imbalance) < 0.5 * best:
                best, last_headway = max(self.residual, self.imbalance), self.steps
            if outcome is Outcome.STEPS_SPENT:
                if self.steps >= self.steps_allowed or self.steps - last_headway > 2 * STEPS_AT_ONCE:
                    return Outcome.STEPS_SPENT
                continue
            last_error, self.length_error = self.length_error, length_error(structure, work.length, work.density)
            reached = max(self.residual, self.imbalance) <= tolerance and self.length_error <= LENGTH_TOLERANCE
            # a catch that does not fit into a crude shape may fit into that of the equilibrium
            if reached:
                return outcome
            # the tensions found are a better measure of the penalty than the guess before them
            tension = float(np.mean(np.abs(work.density) * work.length))
            if not 0.5 < tension / self.tension < 2.0:
                self._set_law(tension)
            work.multiplier[:] = work.density
            inner = min(inner, TIGHTENING * self.length_error)
            if self.length_error < 0.5 * last_error:
                inner = max(inner, tolerance)
            elif inner > 0.01 * TIGHTENING * self.length_error:
                # multipliers taken from a shape that has not settled do not bring the lengths nearer: settle it further
                inner *= 0.3
            else:
                # the shape has settled: nearly dependent bars want a stiffer penalty
                self.penalty *= 3.0
                self._set_law(self.tension)
            best, last_headway = np.inf, self.steps

    def _relax(self, inner: float) -> int:
        """Relax for a while; what ``relaxation.relax`` returns.

        Under contact a while is short, and what is near what is looked for anew after it. Where parts would have
        passed through each other since, the net goes back on the way and on from rest, for a shorter while.
        """
        surface, work = self.problem.surface, self.work
        spend = min(STEPS_AT_ONCE, self.steps_allowed - self.steps)
        left = spend
        while True:
            before = np.ascontiguousarray(work.state[:, :3])
            loading = self.problem.touching_at(before).loading
            code, steps, _, self.residual, self.imbalance = relaxation.relax(
                work,
                self.problem.structure,
                loading,
                inner,
                self.mass_factor,
                self.settings.viscous,
                left if surface is None else min(left, self.while_steps),
            )
            self.steps += steps
            left -= steps
            if surface is None:
                return code
            move = work.state[:, :3] - before
            share = surface.free_share(before, move) if np.isfinite(move).all() else 0.0
            self.while_steps = max(self.while_steps // 4, 5) if share < 1.0 else 2 * self.while_steps
            if share < 1.0:
                work.state[:, :3] = before + share * move
            elif code != relaxation.STEPS_SPENT:
                return code
            if left <= 0:
                return relaxation.STEPS_SPENT

    def _set_law(self, tension: float) -> None:
        self.tension = tension
        augmented_law(self.problem.structure, self.penalty * tension, self.work.relief, self.work.gain)


def as_built(problem: Problem) -> Solution:
    """The shape in which a net was built, to start from, every bar with the tension that the loads ask for."""
    tension = np.full(len(problem.net.bars), reference_tension(problem))
    return Solution(problem.net.positions, tension, np.zeros(problem.bands), START)


def reference_tension(problem: Problem) -> float:
    """Mean tension that the loads on the start shape ask for, N: their resultant over the bars of a band.

    Where the loads cancel their sizes stand for the resultant, and where there are none the tension that elastic bars
    have in the start shape: only the scale of the tensions is wanted.
    """
    structure, loading = problem.structure, problem.loading
    position = problem.net.positions
    force: Floats = np.zeros_like(position)
    share = np.zeros(problem.bands)
    relaxation.fill(position, structure, loading.catch, share)
    add_force(position, structure, loading, share, force)
    resultant = float(np.linalg.norm(force.sum(axis=0) * [1.0, structure.order == 1.0, structure.order == 1.0]))
    size = float(np.linalg.norm(force, axis=1).sum())
    bars_abreast = max(len(structure.first) / problem.bands, 1.0)
    if size > 0.0:
        return (resultant if resultant > CANCELLED * size else size) / bars_abreast
    length = np.empty(len(structure.first))
    bar_lengths(position, structure, length)
    elastic = structure.flexibility > 0.0
    strain = np.maximum(length[elastic] / structure.length[elastic] - 1.0, 0.0)
    return float(np.mean(strain / structure.flexibility[elastic])) if strain.any() else 1.0
