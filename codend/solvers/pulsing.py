"""A bag in motion: its catch presses by the speed at which the water then passes, and the water in it goes with it."""

from dataclasses import dataclass, replace

import numpy as np

from codend.mechanics import rigid
from codend.mechanics.inertia import Inertia, at_rest
from codend.mechanics.loads import Loading, loads_and_supports
from codend.mechanics.problem import Problem
from codend.net.net import Floats, facet_corners
from codend.solvers.motion import Path
from codend.solvers.moving_masses import MovingMasses
from codend.solvers.newton import NewtonSettings, solve
from codend.solvers.outcome import Solution
from codend.solvers.prepared import prepare

SPHERE = 0.5
"""Added mass of a sphere over that of the water it displaces."""
TOLERANCE = 1e-10
"""Largest residual and axial imbalance at the end of a step."""
STEP = NewtonSettings(rough_starts=(), refuses=False)
"""Newton's method from where the bag would be without any change of its velocities."""
SPEED_MET = 1e-3
"""What the speed by which the catch presses, foreseen to the second order in the step, may be off from that at its
end, over that of the tow."""
PASSES = 8
"""Solves of a step, after which the speed must be met."""
MOST_GROWTH = 2.0
"""From a step to the next up to which it is of the second order: the method is stable for one by 1 + sqrt(2)."""
MOST_HALVINGS = 8


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


@dataclass(frozen=True)
class Moment:
    """A bag at a time."""

    solution: Solution
    """Places, tensions and shares of the catch."""
    velocity: Floats
    """Of the nodes, m/s, (n, 3)."""
    speed_m_s: float
    """At which the water passes the bag."""


class PulsingBag:
    """A bag whose supports move through the water.

    Backward differences of the second order (Hairer, Norsett and Wanner 1993, Solving Ordinary Differential Equations
    I, section III.5) for places and velocities, all loads and tensions at a step's end: the bag is in equilibrium there
    with what its masses resist with (``mechanics.inertia``), which Newton's method finds. What is too stiff to swing as
    slowly as the steps go is at rest in them, so accuracy and not stability sets the step.
    """

    def __init__(
        self, problem: Problem, solution: Solution, tow_m_s: float, bag: BagWater, path: Path, added_mass: float = 1.0
    ) -> None:
        """Set a bag out from its equilibrium at a steady speed.

        Args:
            problem: the net under its loads at that speed.
            solution: its equilibrium.
            tow_m_s: the speed.
            bag: the water that goes with it.
            path: how its supports move besides.
            added_mass: Cm of the twine.
        """
        net = problem.net
        self.problem, self.tow_m_s, self.path = problem, tow_m_s, path
        self.towed = np.asarray(net.fixed.all(axis=1))
        """Nodes that go with the entry, (n,)."""
        self.now = Moment(solution, np.zeros_like(solution.positions), tow_m_s)
        self.loading = problem.loading
        """Without what masses resist with."""
        self.time = 0.0
        self._last, self._last_step = self.now, 0.0
        self._start = solution.positions[self.towed]
        self._share = bag.mass / bag.mass.sum()
        self._masses = MovingMasses(net, problem.loading.water.density, added_mass)
        self._masses.of_points += bag.mass
        self._pattern = rigid.rigid_pattern(problem.structure, None)
        self._prepared = prepare(problem.structure, problem.bands)
        self._inertia = at_rest()

    def step(self, dt: float, halvings: int = 0) -> None:
        """Advance by ``dt`` seconds; where Newton's method does not get there at once, in shorter steps.

        Raises:
            ArithmeticError: shorter steps do not mend it.
        """
        if self._tried(dt):
            return
        if halvings == MOST_HALVINGS:
            raise ArithmeticError(f"no balance was found after {self.time:.5g} s, {1e3 * dt:.2g} ms on neither")
        self.step(0.5 * dt, halvings + 1)
        self.step(0.5 * dt, halvings + 1)

    def _tried(self, dt: float) -> bool:
        now, last = self.now, self._last
        growth = dt / self._last_step if self._last_step > 0.0 else np.inf
        w = growth if growth <= MOST_GROWTH else 0.0
        one, two = (1.0 + w) ** 2 / (1.0 + 2.0 * w), w**2 / (1.0 + 2.0 * w)
        rate = (1.0 + 2.0 * w) / (1.0 + w) / dt
        origin = one * now.solution.positions - two * last.solution.positions
        velocity = one * now.velocity - two * last.velocity
        start = origin + velocity / rate
        start[self.towed] = self._start + self.path(self.time + dt)
        inertia = Inertia(rate, self._masses_at(start), origin, velocity)
        speed = now.speed_m_s + w * (now.speed_m_s - last.speed_m_s)
        found = replace(now.solution, positions=start)
        for _ in range(PASSES):
            self.loading = self._at_speed(speed)
            problem = replace(self.problem, loading=self.loading._replace(inertia=inertia))
            found = solve(problem, TOLERANCE, found, STEP, prepared=self._prepared)
            if not found.report.outcome.converged:
                return False
            velocity = rate * (found.positions - origin)
            taken, speed = speed, self.tow_m_s - float(self._share @ velocity[:, 0])
            if abs(speed - taken) <= SPEED_MET * self.tow_m_s:
                break
        else:
            return False
        self._last, self._last_step, self.time = now, dt, self.time + dt
        self.now = Moment(found, velocity, speed)
        self._inertia = inertia
        return True

    def _masses_at(self, position: Floats) -> Floats:
        """Of the nodes, kg, (n, 3, 3)."""
        bars = len(self.problem.net.bars)
        gradient, square = np.zeros((2 * bars, 3)), np.zeros(bars)
        rigid.length_gradients(position, self.problem.structure, gradient, square)
        return self._masses.set_bare(self._pattern, gradient, square).copy()

    def _at_speed(self, speed_m_s: float) -> Loading:
        """Loads where the water passes the bag at a speed."""
        catch = self.problem.loading.catch
        change = speed_m_s * abs(speed_m_s) / self.tow_m_s**2
        return self.problem.loading._replace(
            catch=catch._replace(stagnation_pressure=change * catch.stagnation_pressure)
        )

    @property
    def support(self) -> Floats:
        """What holds the nodes, N, (n, 3): of free nodes what is left out of balance."""
        now, loading = self.now.solution, self.loading._replace(inertia=self._inertia)
        structure = self.problem.structure
        return loads_and_supports(structure, loading, now.positions, now.bar_tension, now.share)[1]
