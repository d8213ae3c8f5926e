"""A problem whose contact is looked for again as its net moves: loads, pattern and linear system of where it is now."""

import numpy as np

from codend.mechanics.contact import Contact
from codend.mechanics.loads import Loading
from codend.mechanics.newton_step import empty_step
from codend.mechanics.problem import Problem
from codend.mechanics.tangent import with_contact
from codend.net.net import Floats
from codend.solvers.linear_systems import linear_system
from codend.solvers.prepared import Prepared
from codend.solvers.sparse_system import SparseSystem

REVERSED = -0.5
"""Cosine between two moves under which the second goes back on the first: where parts are nearest has leapt."""

FIRST_EXACT = 0.125
"""Share of what is negative definite of contact that tangents near balance begin with; it is doubled step by step."""


def more_exact(share: float) -> float:
    """The share that the next tangent near balance tries."""
    return min(2.0 * max(share, FIRST_EXACT), 1.0)


def less_exact(share: float) -> float:
    """The share to try where pivots of the last tangent were negative."""
    return 0.25 * share if share > FIRST_EXACT else 0.0


class Watched:
    """Loads and room of a net in motion: those it was given, unless parts of it may touch."""

    def __init__(self, problem: Problem, prepared: Prepared) -> None:
        self.problem, self.prepared = problem, prepared
        self.loading: Loading = problem.loading
        self._without = prepared
        self._before: Floats | None = None
        self.exact = 0.0
        """Share of what is negative definite of contact that the last tangent had (``Contact.exact``)."""
        near = problem.loading.contact
        if len(near.kind) and len(prepared.pattern.contact_slot) != len(near.kind):
            self.prepared = self._made()

    def look(self, position: Floats) -> bool:
        """Look for contact in a shape; whether the pairs near each other are others than before."""
        surface = self.problem.surface
        if surface is None:
            return False
        return self.see(surface.near(position))

    def see(self, now: Contact) -> bool:
        """Take it that this is near now; whether those are other pairs than before."""
        last = self.loading.contact
        if np.array_equal(last.node, now.node) and np.array_equal(last.image, now.image):
            return False
        self.loading = self.loading._replace(contact=now)
        self.prepared = self._without if len(now.kind) == 0 else self._made()
        return True

    def go_along(self, position: Floats, move: Floats) -> float:
        """Take it that the net goes along a move, as far as nothing passes through anything; the share it goes."""
        surface = self.problem.surface
        if surface is None:
            return 1.0
        pairs = surface.on_the_way(position, move)
        share = surface.free_part(position, move, pairs)
        self.see(surface.nearest_of(pairs, position + share * move))
        return share

    def goes_back(self, move: Floats) -> bool:
        """Whether a move under contact goes back on the one before."""
        if self.problem.surface is None:
            return False
        before, self._before = self._before, move.copy()
        if before is None:
            return False
        along = float(np.vdot(move, before))
        return along < REVERSED * float(np.linalg.norm(move) * np.linalg.norm(before))

    def _made(self) -> Prepared:
        structure, near = self.problem.structure, self.loading.contact
        pattern = with_contact(self._without.pattern, near.node)
        # a net that contact has made wide is not numbered for a narrow band again at every step
        last = self.prepared.system
        system = linear_system(structure, pattern, last if isinstance(last, SparseSystem) else self._without.system)
        return Prepared(pattern, system, self._without.states, empty_step(structure, pattern))

    def free_share(self, position: Floats, move: Floats) -> float:
        """Share of a move after which nothing has passed through anything, 1 without contact."""
        surface = self.problem.surface
        return 1.0 if surface is None else surface.free_share(position, move)
