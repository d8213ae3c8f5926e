"""A bag in motion: its catch presses by the speed at which the water then passes, and the water in it goes with it."""

from dataclasses import dataclass

import numpy as np

from codend.mechanics.catch_front import fill
from codend.mechanics.problem import Problem
from codend.net.net import Floats, facet_corners
from codend.solvers.motion import Motion, Path

SPHERE = 0.5
"""Added mass of a sphere over that of the water it displaces."""


@dataclass(frozen=True)
class BagWater:
    """What goes with the netting on the catch."""

    mass: Floats
    """Of every node, kg, (n,)."""

    @classmethod
    def of(cls, problem: Problem, positions: Floats, share: Floats, volume_m3: float, density: float) -> "BagWater":
        """The catch, of its own density, and the added mass of a sphere of its volume, assumed.

        Shared out among the nodes by the area of netting about them that is on the catch, and felt by them in all
        directions alike; it stays as it is in the equilibrium.
        """
        net = problem.net
        corners = facet_corners(net, positions)
        area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        wetted = np.zeros(len(positions))
        part = area * net.facet_weight * share[problem.loading.catch.facet_band]
        np.add.at(wetted, net.facets.ravel(), np.repeat(part, 3))
        total = (density + SPHERE * problem.loading.water.density) * volume_m3 / net.order
        return cls(total * wetted / wetted.sum())


class PulsingBag(Motion):
    """A bag whose supports move through the water."""

    def __init__(
        self, problem: Problem, positions: Floats, speed_m_s: float, bag: BagWater, path: Path, added_mass: float = 1.0
    ) -> None:
        """Set a bag out from its equilibrium at a steady speed.

        Args:
            problem: the net under its loads at that speed.
            positions: of its equilibrium, (n, 3).
            speed_m_s: of the tow.
            bag: the water that goes with it.
            path: how its supports move besides.
            added_mass: Cm of the twine.
        """
        held = np.asarray(problem.net.fixed.all(axis=1))
        super().__init__(problem, positions, towed=held, path=path, added_mass=added_mass)
        self.tow_m_s, self.bag = speed_m_s, bag
        self.masses.of_points += bag.mass
        self.speed_m_s = speed_m_s
        """At which the water passes the bag."""

    def _set_loads(self, kick: float, dt: float) -> None:
        mass, catch = self.bag.mass, self.problem.loading.catch
        self.speed_m_s = self.tow_m_s - float(mass @ self.velocity[:, 0] / mass.sum())
        change = self.speed_m_s * abs(self.speed_m_s) / self.tow_m_s**2
        catch = catch._replace(stagnation_pressure=change * catch.stagnation_pressure)
        fill(self.position, self.structure, catch, self._share)
        self.loading = self.loading._replace(catch=catch)
        super()._set_loads(kick, dt)

    @property
    def share(self) -> Floats:
        """Share of each band that lies in the catch."""
        return self._share
