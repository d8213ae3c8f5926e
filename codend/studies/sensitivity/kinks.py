"""Kinks along a number of a plan: twine that goes slack or taut, a front of the catch that passes a row."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from codend.mechanics.bars import bar_lengths
from codend.net.net import Floats
from codend.solvers.derivative import Move
from codend.studies.sensitivity.solved_case import SolvedCase

FULL: Final = 1e-9
"""Share of a band up to which it counts as empty, and from 1 less which as full."""
STILL: Final = 1e-9
"""Change over the change of the number, both relative, under which a bar does not change."""


@dataclass(frozen=True)
class Kink:
    """The nearest kinks on either side, as far as the case changes in proportion."""

    below: float
    """Change of the number at which the first one is met, 0 or less; minus infinity where none is."""
    above: float
    """The same, 0 or more, or infinity."""
    reason: str
    """What happens at the nearer one."""

    @property
    def distance(self) -> float:
        """To the nearer one."""
        return min(-self.below, self.above)


def kinks_along(base: SolvedCase, ends: tuple[SolvedCase, SolvedCase], move: Move, spread: float, size: float) -> Kink:
    """The nearest kinks of a case.

    Args:
        base: the case.
        ends: the case moved to a smaller and to a larger number.
        move: how it moves with the number.
        spread: by how much the number is larger in the second.
        size: of the number, what changes are relative to.
    """
    found = [*_of_bars(base, ends, move, spread, size), *_of_front(base, ends, spread, size)]
    below = max(((at, why) for at, why in found if at <= 0.0), default=(-np.inf, ""))
    above = min(((at, why) for at, why in found if at >= 0.0), default=(np.inf, ""))
    return Kink(below[0], above[0], above[1] if above[0] <= -below[0] else below[1])


def _of_bars(
    base: SolvedCase, ends: tuple[SolvedCase, SolvedCase], move: Move, spread: float, size: float
) -> list[tuple[float, str]]:
    """Changes at which the first bars go slack and taut, on either side, and what they are."""
    bag, length = base.model.bag, base.problem.structure.length
    density = base.solution.bar_tension / _lengths(base)
    taut = density > 0.0
    room = 1.0 / length - 1.0 / _lengths(base)
    first, second = (1.0 / end.problem.structure.length - 1.0 / _lengths(end) for end in ends)
    rate = np.where(taut, move.density, (second - first) / spread)
    left = np.where(taut, density, room)
    scale = np.where(taut, density, 1.0 / length)
    moving = np.abs(rate) * size > STILL * scale
    at = np.full(len(left), np.inf)
    np.divide(-left, rate, out=at, where=moving)
    found = []
    for bars, what in (
        (bag.straps, "a strap"),
        (bag.ropes, "a rope"),
        (np.setdiff1d(np.arange(len(length)), np.concatenate([bag.straps, bag.ropes])), "twine"),
    ):
        for state, word in ((taut[bars], "goes slack"), (~taut[bars], "goes taut")):
            places = at[bars][state & np.isfinite(at[bars])]
            found += [
                (float(side.max() if side[0] < 0.0 else side.min()), f"{what} {word}")
                for side in (places[places < 0.0], places[places >= 0.0])
                if len(side)
            ]
    return found


def _lengths(case: SolvedCase) -> Floats:
    length = np.empty(len(case.solution.bar_tension))
    bar_lengths(np.ascontiguousarray(case.solution.positions), case.problem.structure, length)
    return length


def _of_front(
    base: SolvedCase, ends: tuple[SolvedCase, SolvedCase], spread: float, size: float
) -> list[tuple[float, str]]:
    """Changes at which the front comes to the next row of knots on either side."""
    first, own, second = ends[0].solution.share, base.solution.share, ends[1].solution.share
    change = float((second - first).sum()) / spread
    if abs(change) * size <= STILL:
        return []
    why = "the front of the catch passes a row of knots"
    partly = np.flatnonzero((own > FULL) & (own < 1.0 - FULL))
    if len(partly) == 0:
        return [(0.0, why)]
    share = float(own[partly[0]])
    return [(-share / change, why), ((1.0 - share) / change, why)]
