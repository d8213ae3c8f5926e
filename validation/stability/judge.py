"""Whether what a solver returns is right: held to the equations in plain numpy, and to an answer found twice.

A state that is near an equilibrium is off by no more than its own out-of-balance forces and length errors explain, to
first order (``linear.worst_responses``); a state that says it converged and is off by more is a wrong answer, and so is
one that breaks the equations or passes through itself, by checks that share nothing with the project's own
(``validation.passing_through``), and so are numbers that come with a failure. Where a plan has more than one
equilibrium, a state that is exact, stable and has not passed through itself counts as another one.
"""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from codend.bag.bag import Bag
from codend.bag.measures import measure_all
from codend.equilibrium.stability import stability_of_whole
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers import dynamic_relaxation, gentle, newton
from codend.solvers.dynamic_relaxation import LENGTH_TOLERANCE
from codend.solvers.outcome import Outcome, Solution
from validation.passing_through import DEEPEST, TOUCHING, crossed_rings, piercing_bars
from validation.reference import Departure, departure, facing_rings
from validation.stability.linear import is_stable, worst_responses
from validation.stability.scenes import disturbed

SAFETY = 2.0
"""On what out-of-balance forces explain: for the terms of second order."""
SHAKEN = 0.01
"""Random move, over a bar, from which a full net's reference must come back."""
ROUND_OFF = 1e-9
"""Relative error of drag and volume, and of the shape over the bag's length, that is explained in any case."""


class Finding(Enum):
    """What a cell of a map found; every value is a sentence."""

    RIGHT = "Right at once: the equations hold, and drag, volume and shape are those of the reference."
    RESCUED = "Right after a fall-back: an attempt failed and said so, a later one found the answer."
    ANOTHER = "Another equilibrium: exact, stable and sound, but not that of the reference; the plan has two."
    UNSTABLE = "Unstable, and told so: exact and sound, but no net stays there, and its row says `stable = no`."
    FAILED = "Honest failure: it says that it did not converge, why, and gives no numbers."
    WRONG = "WRONG ANSWER: it says converged, but the equations or the reference contradict it."


@dataclass(frozen=True)
class Reference:
    """The answer of a problem, and how far out-of-balance forces and length errors move it."""

    bag: Bag
    problem: Problem
    solution: Solution
    state: Departure
    drag_volume_size: Floats
    """Drag, N, volume, m3 (nan if not known), and length of the bag, m."""
    by_residual: Floats
    """Largest relative change of drag, volume and shape for a residual of 1, (3,)."""
    by_length_error: Floats
    """The same for a length error of 1, (3,)."""


@dataclass(frozen=True)
class Judgement:
    """Finding on one solve."""

    finding: Finding
    error: float
    """Largest of the relative errors in drag and volume and of the largest move over the bag's length; nan if none."""
    explained: float
    """That error over what the state's own residual and length error explain, for the worst of the three; nan if
    there is no answer."""
    residual: float
    """As plain numpy finds it; what the solver says where there is no answer."""
    why: str
    """What contradicts a wrong answer, else empty."""


def reference_of(bag: Bag, problem: Problem, solution: Solution) -> Reference:
    """Make a solution the reference for its problem.

    Raises:
        ArithmeticError: it does not satisfy the equations, or passes through itself.
    """
    state = departure(problem, solution.positions, solution.bar_tension, solution.share)
    if not (max(state.residual, state.imbalance) < 1e-7 and state.length_error < 1e-6 and state.compression == 0.0):
        raise ArithmeticError(f"no reference: {state}")
    if passes_through(bag, solution):
        raise ArithmeticError("no reference: it passes through itself")
    forces, strains = worst_responses(problem, solution)
    volume = measure_all(bag, problem, solution)[2].catch_volume_m3
    scale = np.array([state.drag, volume, np.ptp(solution.positions[:, 0])])
    return Reference(bag, problem, solution, state, scale, forces * abs(state.drag) / scale, strains / scale)


def confirmed_reference(bag: Bag, problem: Problem) -> Reference:
    """The answer of Newton's method converged as far as it goes, confirmed by dynamic relaxation from a crude bag.

    That of a full net is confirmed as well by coming back when it is shaken and followed gently.

    Raises:
        ArithmeticError: either fails, or they disagree.
    """
    reference = reference_of(bag, problem, newton.solve(problem, 1e-11))
    second = judge(reference, dynamic_relaxation.solve(problem, 1e-8), 1e-8)
    if second.finding not in (Finding.RIGHT, Finding.RESCUED):
        raise ArithmeticError(f"the reference is not confirmed: {second}")
    if problem.net.order == 1:
        shaken = disturbed(problem, reference.solution.positions, SHAKEN, (1,))
        start = replace(reference.solution, positions=shaken)
        motion = gentle.follow(problem, 1e-8, start, newton.prepare(problem.structure, problem.bands))
        third = judge(reference, motion.solution, 1e-8) if motion.end is gentle.End.SETTLED else None
        if third is None or third.finding is not Finding.RIGHT:
            raise ArithmeticError(f"the reference does not come back when shaken: {motion.end.name}, {third}")
    return reference


def judge(reference: Reference, solution: Solution, tolerance: float) -> Judgement:
    """Hold a solution of the reference's problem to the equations and to the reference.

    Args:
        reference: of the same problem, or of one with the same loads and bars.
        solution: what the solver returned.
        tolerance: residual and axial imbalance it was asked for.
    """
    report = solution.report
    if not report.outcome.converged:
        return judge_alone(solution, "numbers come with a failure")
    problem = reference.problem
    state = departure(problem, solution.positions, solution.bar_tension, solution.share)
    said = measure_all(reference.bag, problem, solution)[2]
    drag, volume, length = reference.drag_volume_size
    off = np.array(
        [
            said.drag_n / drag - 1.0,
            said.catch_volume_m3 / volume - 1.0,
            np.abs(solution.positions - reference.solution.positions).max() / length,
        ]
    )
    states = (state, reference.state)
    residual = sum(max(s.residual, s.imbalance) for s in states)
    explained = (
        SAFETY * (reference.by_residual * residual + reference.by_length_error * sum(s.length_error for s in states))
        + ROUND_OFF
    )
    ratio = np.abs(off) / explained
    away = not ratio.max() <= 1.0
    facing = facing_rings(problem, solution.positions)
    faults = [
        fault
        for fault, there in (
            (f"residual {state.residual:.1e}", not state.residual <= 1.01 * tolerance),
            (f"axial imbalance {state.imbalance:.1e}", not state.imbalance <= 1.01 * tolerance),
            (f"length error {state.length_error:.1e}", not state.length_error <= 1.01 * LENGTH_TOLERANCE),
            (f"compression {state.compression:.1e}", not state.compression <= 0.0),
            ("not the catch that was asked for", not _same_catch(problem, solution.share)),
            ("passed through itself", not facing >= 0.0 or (away and passes_through(reference.bag, solution))),
        )
        if there
    ]
    stays = not away or is_stable(problem, solution)
    if away and not faults and not is_stable(problem, reference.solution):
        faults.append("off the reference, which is unstable")
    if not stays and not faults and not _told_unstable(problem, solution):
        faults.append("off the reference, unstable, and not told so")
    failed = [o.value for o in Outcome if not o.converged]
    rescued = any(sentence in line for line in report.attempts[:-1] for sentence in failed)
    if faults:
        finding = Finding.WRONG
    elif not stays:
        finding = Finding.UNSTABLE
    elif away:
        finding = Finding.ANOTHER
    else:
        finding = Finding.RESCUED if rescued else Finding.RIGHT
    return Judgement(finding, float(np.abs(off).max()), float(ratio.max()), state.residual, ", ".join(faults))


def passes_through(bag: Bag, solution: Solution) -> bool:
    """Whether a bar pierces the netting or a ring of knots crosses itself, deeper than netting that touches."""
    net = bag.net
    shortest, thick = float(net.bar_length.min()), float(np.median(net.bar_diameter))
    touching = max(TOUCHING * shortest, min(thick, DEEPEST * shortest))
    at = solution.positions
    return len(piercing_bars(net, at, touching)) > 0 or len(crossed_rings(bag, at, touching)) > 0


def judge_alone(solution: Solution, why: str) -> Judgement:
    """Judge a solution for which there is no reference: an honest failure, or else wrong for the reason given."""
    numbers = np.isfinite(solution.positions).any() or np.isfinite(solution.bar_tension).any()
    finding = Finding.WRONG if numbers else Finding.FAILED
    return Judgement(finding, np.nan, np.nan, float(solution.report.residual), why if numbers else "")


def _told_unstable(problem: Problem, solution: Solution) -> bool:
    """Whether the product says of a net in balance that it is not stable."""
    tangent = newton.tangent_at(problem, solution, newton.prepare(problem.structure, problem.bands))
    return stability_of_whole(tangent) == "no"


def _same_catch(problem: Problem, share: Floats) -> bool:
    """Whether whole bands are filled from the codline up to the meshes asked for, one of them in part."""
    catch = problem.loading.catch
    to_codline = np.cumsum(catch.band_meshes[::-1])[::-1]
    expected = np.clip((catch.size - to_codline + catch.band_meshes) / catch.band_meshes, 0.0, 1.0)
    return bool(np.allclose(share, expected, atol=1e-12))
