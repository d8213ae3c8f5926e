"""Motion of a net of rigid bars in time, by the scheme of Bessonneau and Marichal (1997) and Le Bris et al. (1999).

Masses are real: the twine's (the water's density where none is given), half of a bar to each end, and the added mass
rho pi d^2 / 4 l Cm across the bar, Cm = 1, likewise half to each end. The papers put the added mass among the forces,
with the last step's acceleration (equations 4 and 12 of the former), which is on the edge of instability for twine as
light as water; here it is part of the node's 3 x 3 mass. The only damping is the drag of bars that move through the
water.
"""

from dataclasses import dataclass

import numpy as np

from codend.mechanics import rigid
from codend.mechanics.bars import bar_lengths
from codend.mechanics.catch_front import fill
from codend.mechanics.loads import add_bound, add_moving_force
from codend.mechanics.problem import Problem
from codend.net.net import Floats, Ints
from codend.solvers.linear_systems import symmetric_system

ADDED_MASS = 1.0
"""Cm of a cylinder in potential flow (BM97 2.1.2, LB99 4.1)."""
PROJECTIONS = 12
LONGEST_MOVE = 0.3
"""Largest move of a node in one projection, over the mean bar length."""
LENGTHS_MET = 1e-12
FARTHEST_OFF = 1e-6
"""Drift that a projection may leave before it counts as failed."""
SLACK_PASSES = 8
REFINEMENTS = 2


class RigidMotion:
    """A net on its way: positions, velocities and force densities after every step."""

    def __init__(
        self, problem: Problem, positions: Floats, velocities: Floats, *, project: bool = False, slack: bool = False
    ) -> None:
        structure, net, water = problem.structure, problem.net, problem.loading.water.density
        self.problem, self.structure, self.loading = problem, structure, problem.loading
        self.project, self.slack = project, slack
        bars, nodes = len(structure.first), len(structure.free)
        volume = 0.25 * np.pi * net.bar_solid_diameter**2 * net.bar_length
        self.mass = np.where(np.isnan(net.bar_density), water, net.bar_density) * volume
        self.added = ADDED_MASS * water * volume
        if not np.all(self.mass > 0.0):
            raise ValueError("rigid bars need a mass: give the density of the bars or of the water")
        if np.any(structure.flexibility > 0.0):
            raise ValueError("rigid bars do not stretch: the net must be inextensible")
        self.pattern = rigid.rigid_pattern(structure)
        row, column = self.pattern.row, self.pattern.column
        self.system = symmetric_system(row, column, bars)
        self.position = np.array(positions, dtype=np.float64, order="C")
        self.velocity = np.array(velocities, dtype=np.float64, order="C")
        self.density = np.zeros(bars)
        """Force density of the bars in the last step, N/m, (m,)."""
        self.share = np.zeros(problem.bands)
        self.fits = True
        self.force = np.zeros((nodes, 3))
        self.taut = np.ones(bars, dtype=np.int32)
        self._gradient, self._square = np.zeros((2 * bars, 3)), np.zeros(bars)
        self._measure()
        if slack:
            self.taut[:] = structure.is_strut | (self._square >= structure.length**2)
        self._inverse = np.zeros((nodes, 3, 3))
        self._acceleration, self._bound = np.zeros((nodes, 3)), np.zeros(nodes)
        self._entries, self._rate = np.zeros(len(self.pattern.row)), np.zeros(bars)

    def lengths(self) -> Floats:
        """Lengths of the bars, m, (m,)."""
        self._measure()
        return np.sqrt(self._square)

    @property
    def drift(self) -> float:
        """Largest departure of a taut bar from its length, relative."""
        return float(np.max(np.abs(self.lengths() / self.structure.length - 1.0) * self.taut, initial=0.0))

    @property
    def rms_speed_m_s(self) -> float:
        """Root mean square of the speeds of all nodes that can move."""
        moving = np.any(self.structure.free > 0.0, axis=1)
        return float(np.sqrt(np.mean(np.sum(self.velocity[moving] ** 2, axis=1)))) if moving.any() else 0.0

    @property
    def kinetic_energy_j(self) -> float:
        """Kinetic energy of the bars and of the water that goes with them, of one sector."""
        self._measure()
        arrays = self._gradient, self._square, self.mass, self.added, self.velocity
        return float(rigid.kinetic_energy(self.structure, *arrays))

    def state(self) -> tuple[Floats | Ints, ...]:
        """A copy of what ``set_state`` needs to go on from here."""
        return tuple(part.copy() for part in self._parts())

    def set_state(self, state: tuple[Floats | Ints, ...]) -> None:
        """Go back to a state."""
        for part, kept in zip(self._parts(), state, strict=True):
            part[:] = kept

    def _parts(self) -> tuple[Floats | Ints, ...]:
        return self.position, self.velocity, self.density, self.taut, self.share

    def set_loads(self, filling: float = 1.0) -> None:
        """Set forces (but for the tensions) and the share of each band in a catch of which ``filling`` is there."""
        self.fits = fill(self.position, self.structure, self.loading.catch, self.share)
        self.share *= filling
        self.force[:] = 0.0
        add_moving_force(self.position, self.velocity, self.structure, self.loading, self.share, self.force)

    def stable_time_step(self) -> float:
        """Largest time step in which the motion is stable under the last step's loads and tensions, s."""
        self._bound[:] = 0.0
        add_bound(self.position, self.structure, self.loading, self.share, self._bound)
        room = np.zeros((len(self._bound), 2))
        return float(
            rigid.stable_time_step(
                self.structure, self.loading, self.velocity, self.density, self._bound, self.mass, self.added, room
            )
        )

    def step(self, dt: float, filling: float = 1.0) -> bool:
        """Advance by ``dt`` seconds; False if the system for the tensions is singular or numbers overflow."""
        self._measure()
        self.set_loads(filling)
        if not self._solve_for_tensions(dt):
            return False
        before = self.position.copy() if self.project else self.position
        with np.errstate(over="ignore", invalid="ignore"):
            self.velocity += dt * self._acceleration
            self.position += dt * self.velocity
        if not np.isfinite(self.position).all():
            return False
        if self.project:
            if not self._keep_lengths(dt):
                return False
            self.velocity[:] = (self.position - before) / dt
        return True

    def tensions_at_rest(self) -> bool:
        """Stop, and set the force densities that rigid bars have at the moment they are let go; False if singular."""
        structure = self.structure
        self.velocity[:] = 0.0
        self._measure()
        self.set_loads()
        if not self._solve_for_tensions(np.inf):
            return False
        for _ in range(REFINEMENTS):
            # what the slight give on the diagonal took
            rigid.lengthening(structure, self._gradient, self._acceleration, self._rate)
            self.density += self._densities(self._rate)
            self._accelerate()
        return True

    def bring_to_lengths(self) -> float:
        """Move the nodes, the heavy ones less, until all taut bars have their lengths (Newton); the drift left over."""
        longest = LONGEST_MOVE * float(np.mean(self.structure.length))
        for _ in range(4 * PROJECTIONS):
            if not self.drift > LENGTHS_MET:
                break
            self._factorise()
            move = self._correction(0.5 * (self._square - self.structure.length**2))[1]
            largest = float(np.abs(move).max())
            if not np.isfinite(largest):
                return np.inf
            self.position += min(1.0, longest / max(largest, longest)) * move
        return self.drift

    def _measure(self) -> None:
        rigid.length_gradients(self.position, self.structure, self._gradient, self._square)

    def _factorise(self) -> bool:
        rigid.inverse_masses(
            self.pattern, self.structure.free, self._gradient, self._square, self.mass, self.added, self._inverse
        )
        return self._factorise_again()

    def _factorise_again(self) -> bool:
        rigid.tension_system(self.pattern, self._gradient, self._inverse, self.taut, self._entries)
        return self.system.factorise(self._entries) != -1

    def _densities(self, right: Floats) -> Floats:
        """Force densities, (m,), 0 in slack bars, for a right side of the system for the tensions, (m,)."""
        return self.system.solve(np.where(self.taut, right, 0.0)[None, :, None]).reshape(-1)

    def _solve_for_tensions(self, dt: float) -> bool:
        """Set force densities and accelerations of the step; infinite ``dt`` leaves velocities and lengths alone."""
        structure = self.structure
        if not self._factorise():
            return False
        rigid.accelerations(self._inverse, self.force, self._acceleration)
        rigid.lengthening(structure, self._gradient, self._acceleration + self.velocity / dt, self._rate)
        right = self._rate + 0.5 * (self._square - structure.length**2) / dt**2
        for _ in range(SLACK_PASSES):
            self.density[:] = self._densities(right)
            self._accelerate()
            if not (self.slack and np.isfinite(dt)) or not self._go_slack(dt):
                break
            if not self._factorise_again():
                return False
        return True

    def _accelerate(self) -> None:
        pulls = self.force.copy()
        rigid.add_pulls(self.structure, self._gradient, self.density, pulls)
        rigid.accelerations(self._inverse, pulls, self._acceleration)

    def _go_slack(self, dt: float) -> bool:
        """Drop twine that pushes, take back those that would come out longer than they are; False if there are none."""
        structure = self.structure
        rigid.lengthening(structure, self._gradient, self._acceleration + self.velocity / dt, self._rate)
        too_long = self._rate + 0.5 * (self._square - structure.length**2) / dt**2 > 0.0
        taut = structure.is_strut | np.where(self.taut, self.density >= 0.0, too_long)
        changed = not np.array_equal(taut, self.taut)
        self.taut[:] = taut
        return changed

    def _keep_lengths(self, dt: float) -> bool:
        """Add to the tensions what the dropped term in dt^2 needs (Newton, same matrix); False if it fails."""
        structure = self.structure
        length, drift = np.empty_like(self.density), np.inf
        for _ in range(PROJECTIONS):
            bar_lengths(self.position, structure, length)
            last, drift = drift, float(np.max(np.abs(length / structure.length - 1.0) * self.taut, initial=0.0))
            if drift <= LENGTHS_MET or drift > 0.5 * last:
                break
            extra, move = self._correction(0.5 * (length**2 - structure.length**2))
            self.position += move
            self.density += extra / dt**2
        return drift < FARTHEST_OFF

    def _correction(self, error: Floats) -> tuple[Floats, Floats]:
        """Force densities times dt^2, (m,), and moves, (n, 3), that undo ``error`` in half the squared lengths."""
        extra = self._densities(error)
        pull, move = np.zeros_like(self.force), np.empty_like(self.force)
        rigid.add_pulls(self.structure, self._gradient, extra, pull)
        rigid.accelerations(self._inverse, pull, move)
        return extra, move


@dataclass(frozen=True)
class History:
    """A motion step by step, its start included."""

    time_s: Floats
    """(steps + 1,)."""
    positions: Floats
    """(steps + 1, n, 3), m."""
    velocities: Floats
    """(steps + 1, n, 3), m/s."""
    bar_tension: Floats
    """Tension during each step, N, (steps, m)."""
    drift: Floats
    """Largest departure of a bar from its length, relative, (steps + 1,)."""


def simulate(
    problem: Problem,
    positions: Floats,
    velocities: Floats,
    dt: float,
    steps: int,
    *,
    project: bool = False,
    slack: bool = False,
) -> History:
    """Motion of a net from given positions and velocities, (n, 3) each, under its full loads, in steps of ``dt``.

    Args:
        problem: the net under its loads; its bars must be inextensible and have mass.
        positions: where the nodes start; lengths that are not met are met by the end of the first step.
        velocities: of the nodes at the start; held coordinates keep theirs.
        dt: time step, s.
        steps: their number.
        project: bring the bars to their lengths after every step, and take the velocities from the moves (SHAKE).
        slack: let twine go slack instead of carrying compression.

    Raises:
        ArithmeticError: the motion overflowed; the message tells the step.
    """
    motion = RigidMotion(problem, positions, velocities, project=project, slack=slack)
    tensions = np.zeros((steps, len(motion.density)))
    found_x, found_v = [motion.position.copy()], [motion.velocity.copy()]
    drift = [motion.drift]
    for number in range(steps):
        length = motion.lengths()
        if not motion.step(dt):
            raise ArithmeticError(f"the motion overflowed in step {number + 1}: take a smaller dt than {dt:g} s")
        tensions[number] = motion.density * length
        found_x.append(motion.position.copy())
        found_v.append(motion.velocity.copy())
        drift.append(motion.drift)
    time = np.linspace(0.0, dt * steps, steps + 1)
    return History(time, np.array(found_x), np.array(found_v), tensions, np.array(drift))
