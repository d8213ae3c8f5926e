"""A problem whose contact is looked for again as its net moves: loads, pattern and linear system of where it is now."""

import numpy as np

from codend.mechanics.contact import Contact
from codend.mechanics.loads import Loading
from codend.mechanics.newton_step import empty_step
from codend.mechanics.problem import Problem
from codend.mechanics.tangent import pattern_of
from codend.net.net import Floats
from codend.solvers.linear_systems import linear_system
from codend.solvers.prepared import Prepared


class Watched:
    """Loads and room of a net in motion: those it was given, unless parts of it may touch."""

    def __init__(self, problem: Problem, prepared: Prepared) -> None:
        self.problem, self.prepared = problem, prepared
        self.loading: Loading = problem.loading
        self._without = prepared
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

    def _made(self) -> Prepared:
        structure, near = self.problem.structure, self.loading.contact
        pattern = pattern_of(structure, near=(near.node, near.image))
        return Prepared(
            pattern, linear_system(structure, pattern), self._without.states, empty_step(structure, pattern)
        )

    def free_share(self, position: Floats, move: Floats) -> float:
        """Share of a move after which nothing has passed through anything, 1 without contact."""
        surface = self.problem.surface
        return 1.0 if surface is None else surface.free_share(position, move)
