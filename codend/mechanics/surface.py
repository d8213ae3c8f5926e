"""A net's surface under contact: what is near what, and how far a move may go before anything would cross."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.contact import Contact
from codend.mechanics.contact_search import free_share, least_distance, near_pairs, on_the_way, within_reach
from codend.mechanics.sheet import Sheet, sheet_of
from codend.net.net import Floats, Net

SEEN = 1.5
"""Reach within which parts are seen, over the distance at which contact begins: a step may bring them that near."""
SPARE = 1.0
"""How far nodes may go before what is near is sought anew, over the same."""


class ContactLaw(NamedTuple):
    """How parts of a net press on each other (``mechanics.contact``)."""

    distance_m: float
    """D, at which contact begins."""
    stiffness_n_m: float
    """k: parts at half of D press on each other with 1.2 k D."""


@dataclass(frozen=True)
class Surface:
    """The parts of a net that nothing may pass through, and how they press on each other."""

    sheet: Sheet
    law: ContactLaw

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
        reach = SEEN * self.law.distance_m
        pairs = self.pairs(position, np.zeros_like(position), reach)
        return _chosen(pairs, within_reach(position, pairs, reach))

    def least_distance(self, position: Floats) -> float:
        """Least distance of the parts near each other in a shape, m; inf where none are."""
        return float(least_distance(position, self.near(position)))

    def free_share(self, position: Floats, move: Floats) -> float:
        """Share of a move of the nodes, (n, 3), at most 1, after which all parts keep a tenth of their distance."""
        return float(free_share(position, move, self.pairs(position, move, 0.0)))

    def pairs(self, position: Floats, move: Floats, reach: float) -> Contact:
        """Parts whose ways along a move of the nodes, (n, 3), may come nearer to each other than ``reach``, in m."""
        law = self.law
        node, image, kind, weight, even = near_pairs(position, move, reach, self.sheet)
        return Contact(node, image, kind, weight, even, law.distance_m, law.stiffness_n_m, self.sheet.rotations, 1.0)


class Neighbours:
    """What is near what as a net moves: sought again only where nodes have gone farther than what was sought covers."""

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        self._spare = SPARE * surface.law.distance_m
        self._reach = SEEN * surface.law.distance_m
        self._pairs: Contact | None = None
        self._sought_at: Floats = np.zeros(0)
        self._near: NDArray[np.integer] = np.zeros(0, dtype=np.int64)
        self._contact: Contact | None = None

    def near(self, position: Floats) -> Contact:
        """What is near what in a shape, (n, 3); that of the last one, while nothing else has come near."""
        if self._pairs is None or _farthest(position - self._sought_at) > self._spare:
            self._sought(position, np.zeros_like(position))
            self._sought_at = position.copy()
        if self._contact is None or not np.isin(self._within(position, 1.0), self._near, assume_unique=True).all():
            assert self._pairs is not None
            self._near = self._within(position, SEEN)
            self._contact = _chosen(self._pairs, self._near)
        return self._contact

    def free_share(self, position: Floats, move: Floats) -> float:
        """As that of the surface."""
        fresh = self._pairs is None or _farthest(position + move - self._sought_at) > self._spare
        pairs = self._sought(position, move) if fresh else self._pairs
        assert pairs is not None
        share = float(free_share(position, move, _chosen(pairs, on_the_way(position, move, pairs))))
        if fresh:
            self._sought_at = position + share * move
        return share

    def _sought(self, position: Floats, move: Floats) -> Contact:
        self._pairs, self._contact = self.surface.pairs(position, move, self._reach + 2.0 * self._spare), None
        return self._pairs

    def _within(self, position: Floats, reach: float) -> NDArray[np.integer]:
        assert self._pairs is not None
        return within_reach(position, self._pairs, reach * self.surface.law.distance_m)


def _farthest(move: Floats) -> float:
    return float(np.sqrt(np.einsum("ij,ij->i", move, move).max(initial=0.0)))


def _chosen(contact: Contact, which: NDArray[np.integer]) -> Contact:
    return contact._replace(
        node=contact.node[which],
        image=contact.image[which],
        kind=contact.kind[which],
        weight=contact.weight[which],
        even=contact.even[which],
    )
