"""How a solve ended, and what is reported of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from codend.mechanics.problem import Problem
from codend.net.net import Floats

Progress = Callable[[str, float], None]
"""Told what is being done and the residual reached, now and then during a long solve."""


class Outcome(Enum):
    """How a solve ended; every value is a sentence with advice."""

    CONVERGED = "Residual, axial balance and twine law are within the tolerance."
    STEPS_SPENT = "The allowed steps were spent: a looser tolerance helps where the residual is near it, nowhere else."
    NOT_FINITE = "The motion lost its footing (numbers overflowed): the start was too far from equilibrium."
    OVERSTRETCHED = "The net ballooned, bars stretched to three times their length: too soft, the twine or its penalty."
    OVERFULL = "The catch does not fit into the net: give a smaller one."
    SINGULAR = "The tangent could not be factorised: the net is a mechanism at this shape."
    NOT_IMPROVING = "No step lowered the residual further: start nearer to the equilibrium."
    PASSED_THROUGH = "The net has passed through itself, which twine cannot: it was refused; start from another shape."
    WRUNG = "The net is turned about its axis by more than a right angle, wrung as no tow does: it was refused."
    NO_VOLUME = "The catch found has no volume, or less than none: it was refused; start from another shape."
    FRONT_BEHIND = "The front of the catch found lies behind the codline: it was refused; start from another shape."
    INSIDE_OUT = "Most of the netting on the catch found faces inward: it was refused; start from another shape."
    TURNS_OVER = "The equilibrium of the frame found is one it would heel or turn from: refused; follow it in time."
    COMPRESSED = "The only solution found has bars in compression, which twine cannot carry: it was refused."
    NO_MERIDIAN = "Newton's method found no meridian from any start: model a sector, or start from a larger catch."
    SLOPE_REVERSED = "The meridian found runs back upstream, which is no equilibrium of a towed bag: it was refused."
    RADIUS_NEGATIVE = "The meridian found crosses the axis ahead of the codline: it was refused."
    TOO_SMALL = "The catch fills less than a quarter of a mesh, too little for a membrane: model a sector."

    @property
    def converged(self) -> bool:
        """Whether the result may be used."""
        return self is Outcome.CONVERGED

    @property
    def refused(self) -> bool:
        """Whether a net in balance was found, but one that no towed net is."""
        return self in _REFUSED

    @property
    def balanced(self) -> bool:
        """Whether the net is in equilibrium: with its catch, or full, and the catch is larger."""
        return self in (Outcome.CONVERGED, Outcome.OVERFULL)


_REFUSED = (
    Outcome.PASSED_THROUGH,
    Outcome.WRUNG,
    Outcome.NO_VOLUME,
    Outcome.FRONT_BEHIND,
    Outcome.INSIDE_OUT,
    Outcome.COMPRESSED,
    Outcome.TURNS_OVER,
)


@dataclass(frozen=True)
class SolverReport:
    """What a solver did and how far it came."""

    method: str
    outcome: Outcome
    iterations: int
    residual: float
    """Largest out-of-balance force of a free node over the sizes of loads and tensions (``balance.out_of_balance``)."""
    imbalance: float
    """Axial sum of the out-of-balance forces of all free nodes over the same."""
    length_error: float
    """Largest departure of a bar from the law of its twine, relative to its length."""
    solve_ms: float
    attempts: tuple[str, ...] = ()
    """Everything that was tried, in order, a line each."""


START = SolverReport("start", Outcome.NOT_IMPROVING, 0, float("inf"), float("inf"), float("inf"), 0.0)
"""Of positions and tensions that no solver arrived at, but from which one sets out."""


class Solver(Protocol):
    """What every solver is: from a problem, and a start if there is one, to a solution that says how it ended."""

    def __call__(
        self,
        problem: Problem,
        tolerance: float,
        start: "Solution | None" = None,
        settings: Any = ...,
        progress: Progress | None = None,
    ) -> "Solution":
        """Equilibrium of a net.

        Args:
            problem: the net under its loads.
            tolerance: largest residual and axial imbalance (``balance.out_of_balance``).
            start: positions and tensions to start from; without one the shape in which the net was built.
            settings: the solver's own.
            progress: told the residual now and then.

        Returns:
            A solution; of a solve that failed, positions and tensions that are nan, and what it tried.
        """


@dataclass(frozen=True)
class Midway:
    """A net on its way through the interior, all twine taut still, where its barrier was lowered (``barrier``)."""

    positions: Floats
    """(n, 3), m."""
    density: Floats
    """Force densities of the bars, N/m, (m,)."""
    slackness: Floats
    """What bars are taken to be short of their lengths, m2, (m,)."""
    barrier: float
    """N."""

    def at_speed(self, ratio: float) -> "Midway":
        """The same of a net towed so many times as fast."""
        return replace(self, density=ratio**2 * self.density, barrier=ratio**2 * self.barrier)


@dataclass(frozen=True)
class Solution:
    """Shape and tensions a solver arrived at."""

    positions: Floats
    """(n, 3), m."""
    bar_tension: Floats
    """(m,), N, of the bars of the model; below 0 in struts that are pushed."""
    share: Floats
    """Share of each band that lies in the catch, (bands,)."""
    report: SolverReport
    midway: Midway | None = None
    """Where the way through the interior to it may be taken up again by a net under nearly the same loads."""

    @classmethod
    def ended(cls, report: SolverReport, positions: Floats, bar_tension: Floats, share: Floats) -> "Solution":
        """What a solver returns: copies of these; of a solve that failed, positions and tensions that are nan."""
        if not report.outcome.converged:
            positions, bar_tension = np.full_like(positions, np.nan), np.full_like(bar_tension, np.nan)
        return cls(positions.copy(), bar_tension.copy(), share.copy(), report)

    @cached_property
    def mean_tension(self) -> float:
        """Mean pull or push of the bars, N."""
        return float(np.abs(self.bar_tension).sum()) / len(self.bar_tension)

    @property
    def front_row(self) -> float:
        """Row at which the catch begins, between two rows when the last one is partly filled."""
        return float(np.sum(1.0 - self.share))
