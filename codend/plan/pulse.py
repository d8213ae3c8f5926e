"""What makes a codend pulse: a vessel that heaves, and how long it is followed."""

import math
from typing import Annotated

from annotated_types import Ge, Gt, Le

from codend.plan.tables import Number, Several, Table, Whole


class Heave(Table):
    """A vessel that heaves, and what of that reaches the codend."""

    heave_m: Annotated[Number, Gt(0), Le(20)]
    """Amplitude of the vessel's heave."""
    period_s: Annotated[tuple[Annotated[Number, Ge(1), Le(1000)], ...], *Several]
    """Of the heave; a number or a list, each followed by itself."""
    transmitted: Annotated[Number, Gt(0), Le(1)] = 1.0
    """Share of the heave by which the codend's entry moves to and fro along the tow; 1, all of it, is assumed."""

    @property
    def fastest_m_s(self) -> float:
        """Largest speed to and fro of the codend's entry, of the shortest period."""
        return 2.0 * math.pi * self.heave_m * self.transmitted / min(self.period_s)


class Following(Table):
    """How long a pulsing codend is followed, and in what steps."""

    periods: Annotated[Whole, Ge(3), Le(200)] = 6
    """Periods of heave, of which the first sets it going; ranges are of the last one."""
    outputs_a_period: Annotated[Whole, Ge(8), Le(1000)] = 40
    """Rows a period."""
    step_s: Annotated[Number, Gt(0), Le(0.1)] = 0.1
    """Longest time step; it is halved until the ranges of openings and drag change by little with it."""
