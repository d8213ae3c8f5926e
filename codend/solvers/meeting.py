"""Parts of a net that meet in motion: rows of pushes beside those of tensions, one system for both.

No part may come nearer to another in a step than an aim, half of the distance at which contact begins in an equilibrium
(or what is left of it), as long as the nearest points of a pair stay where they are; what a step then still carries
through is seen by the whole way of its parts. Pushes are without friction and end at the end of the step.
"""

from typing import NamedTuple

import numpy as np

from codend.mechanics.contact import Contact
from codend.mechanics.contact_rows import closing, write_gaps
from codend.mechanics.surface import Surface
from codend.net.net import Floats, Ints

AIM = 0.5
"""Gap that is kept, over the distance at which contact begins."""
REGAINED = 0.1
"""Share of what is wanting in a gap that a step gives back."""
SEEN = 3.0
"""Reach of the list of pairs, over that distance, beyond what parts go until it is made anew."""
FAR, MOVES = 0.1, 20.0
"""What parts may go meanwhile: over the shortest bar, or so many moves of a step if that is less."""
NEAR, PARTED, MOST_PARTED = 1.2, 2.0, 0.2
"""Gap, over its aim, within which a step is expected to bring a pair that is given a row, beyond which it loses it, and
the share of rows that may have parted: the order of elimination is sought again when rows change."""
COMPLIANCE = 1e-3
"""Of a push, over what it takes to stop its parts: pushes that share a load settle which bears what."""

NO_TOUCH = 1e-3
"""Push, over the largest, that is none."""


class Rows(NamedTuple):
    """Pairs that have a row in the system of a step."""

    node: Ints
    """(c, 4)."""
    gap: Floats
    """m, (c,)."""
    aim: Floats
    """What it may not close below, m, (c,)."""
    gradient: Floats
    """S, (c, 4, 3)."""

    def closed(self, move: Floats) -> Floats:
        """By how much a move closes the gaps, m, (c,)."""
        found = np.empty(len(self.gap))
        closing(self.node, self.gradient, move, found)
        return found


class Meeting:
    """What is near what in a net on its way, and which of that has rows."""

    def __init__(self, surface: Surface, shortest_m: float) -> None:
        self.surface, self._far = surface, FAR * shortest_m
        self.distance = surface.law.distance_m
        self._pairs: Contact | None = None
        self._at = np.zeros((0, 3))
        """Where the nodes were when the list was made."""
        self._reach = 0.0
        self._chosen = np.zeros(0, dtype=bool)

    def state(self) -> dict[str, Floats | Ints]:
        """A copy of all that ``set_state`` needs."""
        reach = np.array([self._reach])
        return {"met_at": self._at.copy(), "met_reach": reach, "met": np.flatnonzero(self._chosen)}

    def set_state(self, state: dict[str, Floats | Ints]) -> None:
        """Go back to a state."""
        at, reach = np.array(state["met_at"], dtype=float), float(state["met_reach"][0])
        if len(at) == 0:
            self._pairs, self._at, self._reach, self._chosen = None, at, reach, np.zeros(0, dtype=bool)
            return
        if not np.array_equal(at, self._at) or reach != self._reach:
            self._list(at, reach)
        self._chosen[:] = False
        self._chosen[np.asarray(state["met"], dtype=np.int64)] = True

    @property
    def nodes(self) -> Ints:
        """Of the pairs that were chosen, (c, 4)."""
        return np.zeros((0, 4), dtype=np.int32) if self._pairs is None else self._pairs.node[self._chosen]

    def look(self, position: Floats, move: Floats) -> bool:
        """Make the list of pairs anew where parts have gone far; whether it was.

        Args:
            position: of the nodes, (n, 3).
            move: about what the step will be, (n, 3).
        """
        moved = _farthest(position - self._at) if len(self._at) else np.inf
        if moved + _farthest(move) < 0.5 * (self._reach - SEEN * self.distance):
            return False
        self._list(position.copy(), SEEN * self.distance + min(self._far, MOVES * _farthest(move)))
        return True

    def rows(self, position: Floats, move: Floats) -> Rows:
        """Those of pairs that have one and have not parted, and of all that such a move brings to their aim."""
        pairs, gap, gradient = self._measured(position)
        closed = np.empty(len(gap))
        closing(pairs.node, gradient, move, closed)
        wanted = gap - np.maximum(2.0 * closed, 0.0) < NEAR * AIM * self.distance
        parted = self._chosen & (gap > PARTED * AIM * self.distance)
        if np.any(wanted & ~self._chosen) or parted.sum() > MOST_PARTED * self._chosen.sum():
            self._chosen = wanted | (self._chosen & ~parted)
        return self._rows(pairs, gap, gradient)

    def more_rows(self, position: Floats, move: Floats) -> Rows | None:
        """The same after a move that brought others below theirs; None if there are none."""
        pairs, gap, gradient = self._measured(position)
        closed = np.empty(len(gap))
        closing(pairs.node, gradient, move, closed)
        missed = (gap - closed < self._aim(gap)) & ~self._chosen
        if not missed.any():
            return None
        self._chosen |= missed
        return self._rows(pairs, gap, gradient)

    def passes(self, position: Floats, move: Floats) -> bool:
        """Whether a move carries no part through another, nor nearly does."""
        assert self._pairs is not None
        return self.surface.free_part(position, move, self._pairs) >= 1.0

    def _list(self, at: Floats, reach: float) -> None:
        self._at, self._reach = at, reach
        self._pairs = self.surface.within(at, reach)
        self._chosen = np.zeros(len(self._pairs.kind), dtype=bool)

    def _measured(self, position: Floats) -> tuple[Contact, Floats, Floats]:
        assert self._pairs is not None
        pairs = self._pairs
        gap, gradient = np.empty(len(pairs.kind)), np.empty((len(pairs.kind), 4, 3))
        write_gaps(position, pairs, gap, gradient)
        return pairs, gap, gradient

    def _rows(self, pairs: Contact, gap: Floats, gradient: Floats) -> Rows:
        number = np.flatnonzero(self._chosen)
        return Rows(pairs.node[number], gap[number], self._aim(gap[number]), gradient[number])

    def _aim(self, gap: Floats) -> Floats:
        whole = AIM * self.distance
        return np.where(gap < whole, gap + REGAINED * (whole - gap), whole)


def _farthest(move: Floats) -> float:
    """Largest departure of a node's move from the mean one, m."""
    apart = move - move.mean(axis=0)
    return float(np.sqrt(np.einsum("ij,ij->i", apart, apart).max()))
