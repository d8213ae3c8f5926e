"""A net's surface under contact: what is near what, and how far a move may go before anything would cross."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from codend.mechanics.cells import Numbers
from codend.mechanics.contact import Contact, no_contact
from codend.mechanics.contact_search import Candidates, may_meet, near_pairs, strayed, within_reach
from codend.mechanics.contact_ways import free_share, least_distance
from codend.mechanics.sheet import Sheet, sheet_of
from codend.net.net import Floats, Net

SEEN = 1.5
"""Reach within which parts are seen, over the distance at which contact begins: a step may bring them that near."""
MARGIN = 1.5
"""About the way of every node, over that distance: pairs once found serve as long as no node leaves it."""


class ContactLaw(NamedTuple):
    """How parts of a net press on each other (``mechanics.contact``)."""

    distance_m: float
    """D, at which contact begins."""
    stiffness_n_m: float
    """k: parts at half of D press on each other with 1.2 k D."""

    @classmethod
    def pressing(cls, distance_m: float, push_n: float) -> "ContactLaw":
        """The law by which parts at half of the distance press on each other with a force, N."""
        return cls(distance_m, push_n / (1.2 * distance_m))


@dataclass(frozen=True)
class Surface:
    """The parts of a net that nothing may pass through, and how they press on each other."""

    sheet: Sheet
    law: ContactLaw
    _found: list[Candidates] = field(default_factory=list, repr=False, compare=False)
    """What the last search found; answers do not depend on it."""

    @classmethod
    def of(cls, net: Net, law: ContactLaw) -> "Surface":
        """The surface of a net: its facets, their sides, and its bars.

        Raises:
            ValueError: distance or stiffness are not above 0, or the net is a sector that does not close round.
        """
        if not (law.distance_m > 0.0 and law.stiffness_n_m > 0.0):
            raise ValueError("contact needs a distance at which it begins and a stiffness, both above 0")
        return cls(sheet_of(net), law)

    def near(self, position: Floats) -> Contact:
        """What is near what in a shape, (n, 3)."""
        return self.nearest_of(self.on_the_way(position, np.zeros_like(position)), position)

    def on_the_way(self, position: Floats, move: Floats) -> Contact:
        """What a move of the nodes, (n, 3), brings near each other at its start, its end or on the way, and more."""
        reach, margin = SEEN * self.law.distance_m, MARGIN * self.law.distance_m
        stray = strayed(position, move, self._found[0].start, self._found[0].way) if self._found else None
        if stray is None or not stray.max(initial=0.0) <= margin:
            pairs, apart = near_pairs(position, move, reach + 2.0 * margin, self._nothing(), self.sheet)
            self._found[:] = [Candidates(position.copy(), move.copy(), pairs, apart)]
            stray = np.zeros(len(position))
        return _only(self._found[0].pairs, may_meet(self._found[0], stray, reach))

    def within(self, position: Floats, reach: float) -> Contact:
        """What is within a reach of what in a shape, (n, 3)."""
        return near_pairs(position, np.zeros_like(position), reach, self._nothing(), self.sheet)[0]

    def _nothing(self) -> Contact:
        """Nothing near anything, by this law."""
        distance, stiffness = self.law
        return no_contact()._replace(distance=distance, stiffness=stiffness, rotations=self.sheet.rotations)

    def nearest_of(self, pairs: Contact, position: Floats) -> Contact:
        """Those of some pairs that are near each other in a shape, (n, 3)."""
        return _only(pairs, within_reach(position, pairs, SEEN * self.law.distance_m))

    def free_part(self, position: Floats, move: Floats, pairs: Contact) -> float:
        """Share of a move, at most 1, after which the pairs that it brings near keep a tenth of their distance."""
        return float(free_share(position, move, pairs))

    def least_distance(self, position: Floats) -> float:
        """Least distance of the parts near each other in a shape, m; inf where none are."""
        return float(least_distance(position, self.near(position)))

    def free_share(self, position: Floats, move: Floats) -> float:
        """Share of a move of the nodes, (n, 3), at most 1, after which all parts keep a tenth of their distance."""
        return self.free_part(position, move, self.on_the_way(position, move))


def _only(pairs: Contact, which: Numbers) -> Contact:
    """Some of the pairs, by their numbers."""
    return pairs._replace(
        node=pairs.node[which],
        image=pairs.image[which],
        kind=pairs.kind[which],
        weight=pairs.weight[which],
        even=pairs.even[which],
    )
