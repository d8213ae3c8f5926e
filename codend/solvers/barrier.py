"""The way of the interior-point method: a barrier that keeps all twine taut, followed as it is made lower and lower.

Whatever is led along it, a net that is held or one that hangs on a body afloat, tells how it takes a step (``Led``).
A step is mended by the factors it was made with. The barrier is lowered when forces are as near to balance as it
allows, by more the nearer the end is, and raised to where the bars are when they hit slackness one after the other
(``interior_kernels``).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from codend.mechanics.newton_state import State
from codend.mechanics.structure import Structure
from codend.net.net import Floats
from codend.solvers import interior_kernels as kernels
from codend.solvers.newton import LARGEST_SHIFT
from codend.solvers.outcome import Midway, Outcome, Progress
from codend.solvers.watched import Watched, less_exact, more_exact

LOWERED, LOWERED_WARILY = 0.1, 0.5
"""Factor on the barrier after a step that was nearly whole, at most, and after one that was more than half of it."""
NEAREST = 0.9
"""Share of the way that a step may go to where the first slackness or force density is nothing; nearer in the end."""
BLOCKED = 0.3
"""Share of a step under which the barrier is raised to where the bars are."""
NEAR = 10.0
"""Largest force left over, in units of the tension and the barrier, at which the barrier is lowered: that of netting
all but slack is itself of the barrier's size, and lowered earlier it is lost."""
MIDWAY = 1e-3
"""Barrier, over the tension, down to which it is kept where it was lowered. From 5e-3 the next two catches of a net of
30 000 knots with a window took 11 steps each, from 4e-4 12 and 15, from the equilibrium itself 14 and 16 (one
correction a step)."""
LEAST_SLACKNESS = 1e-3
"""What bars are given to start with, over the square of their length."""
LARGEST_TURN = 0.5
"""Largest change of a bar's vector in one step, over its length."""
FARTHEST_TURN = 5.0
"""Change of a bar's vector, over its length, that a step may ask for: near a singular tangent steps ask for far more,
in a direction that leads nowhere, and the tangent is shifted."""
LEAST_SHIFT = 1e-3
"""In units of what the pull and the bending of the bars at a node resist, see ``kernels.shift_by_resistance``."""
BOLD, EASY = 0.3, 0.5
"""Share of a step that its turn leaves under which the shift rises, and over which it falls."""
EXACT = 1e-4
"""Residual up to which contact's tangent is its own, or what of it leaves pivots positive: elsewhere what is negative
definite of it is left out."""
KEPT_TAUT = 1.0
"""Any barrier to ``measure``: that it cuts no density. What it says of the lengths is overwritten."""


class Led(Protocol):
    """What is led along the barrier."""

    watched: Watched
    state: State
    """Where it is."""
    midway: Midway | None
    """Where it sets out from, on the way to a net nearby, whatever the first barrier, if that is known; then on its
    own."""

    def linearise(self, softened: Structure, shift: float, exact: float) -> tuple[float, float]:
        """Write the step at the state, with bars softened and the tangent shifted, so much of contact exact.

        Returns:
            its turn, the largest change of a bar's vector over its length or of what else moves over what that may,
            and that of the bars alone; infinite where it leads back, nan where the tangent cannot be factorised.
        """

    def correct(self, barrier: float, loosening: Floats, way: float) -> float:
        """Mend what the step would leave, by the same factors, as far as that is of use.

        Args:
            barrier: the one that is followed, N.
            loosening: change of the slackness in the step, (m,); mended in place.
            way: share of the step at which the first slackness or force density is nothing.

        Returns:
            that share of the step as it is then.
        """

    def go(self, loosening: Floats, share: float) -> float:
        """Go so much of the step, slackness changing by so much, (m,), as far as nothing passes through anything.

        Returns:
            the share of that way that was gone.
        """

    def left_over(self) -> float:
        """The largest force left over at the state, N."""


@dataclass(frozen=True)
class Course:
    """From where the barrier is lowered, to where, and what is enough there."""

    first: float
    """Slackness times force density of a bar, in units of its rest length and the tension."""
    last: float
    steps_allowed: int
    patience: int
    """Steps in a row that do not lower the barrier, after which none will."""
    enough: float
    """Residual at which the last barrier is left."""
    close: float
    """Residual at the last barrier with which it may end when its steps are spent."""


def lower(
    led: Led, structure: Structure, tension: float, course: Course, progress: Progress | None, method: str
) -> tuple[Outcome, int, float]:
    """Follow the barrier down: how that ended, after how many steps, and the error of lengths there.

    Args:
        led: what is led, at its start.
        structure: its net.
        tension: force that is the unit of the barrier, N.
        course: how far.
        progress: told the residual of every step.
        method: its name.
    """
    loosening, softness = np.zeros(len(structure.length)), np.zeros(len(structure.length))
    barrier, shift, steps, lowered = course.first, 0.0, 0, 0
    if led.midway is None:
        kernels.begin(structure, barrier * tension, LEAST_SLACKNESS, led.state)
    else:
        led.state.slack[:], barrier = led.midway.slackness, led.midway.barrier / tension
    while True:
        state = led.state
        error = kernels.strain(structure, barrier * tension, state, softness)
        if progress is not None:
            progress(method, state.residual)
        if not np.isfinite(state.residual):
            return Outcome.NOT_FINITE, steps, error
        if barrier <= course.last and state.residual <= course.enough:
            return Outcome.CONVERGED, steps, error
        if steps - lowered >= course.patience and barrier > course.last:
            return Outcome.NOT_IMPROVING, steps, error
        if steps >= course.steps_allowed:
            close = barrier <= course.last and state.residual <= course.close
            return Outcome.CONVERGED if close else Outcome.STEPS_SPENT, steps, error
        steps += 1
        turn, shift = _step(led, structure._replace(flexibility=softness), shift)
        if not np.isfinite(turn):
            return Outcome.SINGULAR if np.isnan(turn) else Outcome.NOT_IMPROVING, steps, error
        step = led.watched.prepared.step
        back = led.watched.goes_back(step.move)
        loosening[:] = 0.0
        kernels.loosen(structure, barrier * tension, state, state, step.change, loosening)
        way = kernels.way_to_nothing(structure, state, step.change, loosening)
        of_turn = min(1.0, LARGEST_TURN / turn) if turn > 0.0 else 1.0
        # what a shifted step leaves is what the shift took, and beyond a turn all is other than the step says
        if shift == 0.0 and of_turn == 1.0:
            way = led.correct(barrier * tension, loosening, way)
        share = min(of_turn, max(NEAREST, 1.0 - np.sqrt(barrier)) * way)
        blocked, share = share < BLOCKED, share * led.go(loosening, share)
        shift = _next_shift(shift, of_turn, back)
        if blocked:
            barrier = max(barrier, kernels.reached_barrier(structure, led.state) / tension)
            continue
        near = led.left_over() <= NEAR * tension * barrier or led.state.residual <= course.enough
        if share > 0.5 and near:
            lowered = steps
            if barrier >= MIDWAY:
                at = led.state
                kept = at.position.copy(), at.density.copy(), at.slack.copy()
                led.midway = Midway(*kept, barrier * tension)
            factor = min(LOWERED, np.sqrt(barrier)) if share > 0.9 else LOWERED_WARILY
            barrier = max(factor * barrier, course.last)


def _step(led: Led, softened: Structure, shift: float) -> tuple[float, float]:
    """Write the step at a state, with the tangent shifted until it can be factorised and leads not too far.

    Returns:
        its turn, infinite if no shift helps and nan if none lets the tangent be factorised, and the shift it took.
    """
    watched, near_contact = led.watched, led.state.residual <= EXACT and len(led.watched.loading.contact.kind) > 0
    exact = more_exact(watched.exact) if near_contact else 0.0
    while True:
        watched.exact = exact
        turn, of_bars = led.linearise(softened, shift, exact)
        stands = not (np.isnan(turn) or (near_contact and watched.prepared.system.negative_pivots()))
        if (of_bars <= FARTHEST_TURN and stands) or shift >= LARGEST_SHIFT:
            return turn, shift
        if exact > 0.0:
            exact = less_exact(exact)
            continue
        shift = max(4.0 * shift, LEAST_SHIFT)


def _next_shift(shift: float, of_turn: float, back: bool) -> float:
    """Shift of the next tangent, by the share of the last step that its turn left and whether it went back."""
    if of_turn < BOLD or back:
        return min(max(2.0 * shift, LEAST_SHIFT), LARGEST_SHIFT)
    if of_turn > EASY:
        return 0.25 * shift if shift > LEAST_SHIFT else 0.0
    return shift
