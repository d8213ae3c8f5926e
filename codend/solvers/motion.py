"""Motion of a net in time: rigid bars, bars that stretch, and ropes that go slack, in steps of any length.

The scheme of Bessonneau and Marichal (1997, equations 10 to 16): every step solves one symmetric system for the
tensions that bring the bars to their lengths at its end. Beyond the papers (see ``mechanics.motion``) the added mass is
part of the nodes' masses, drag is linearised, and the tensions are corrected with the same matrix until the lengths are
met, not only to the first order. Velocities stand half a step behind the places, so a step is of the second order.
A bar that stretches has at the end of a step the length that its tension gives it over the step (``Stretching``).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codend.mechanics import motion, rigid
from codend.mechanics.bars import bar_lengths
from codend.mechanics.contact_rows import add_pushes
from codend.mechanics.loads import add_moving_force
from codend.mechanics.problem import Problem
from codend.net.net import Floats, Ints
from codend.solvers.body_motion import BodyMotion
from codend.solvers.meeting import COMPLIANCE, NO_TOUCH, Meeting, Rows
from codend.solvers.moving_masses import MovingMasses
from codend.solvers.one_sided import NO_PUSH, OneSided
from codend.solvers.stretching import Stretching

LENGTHS_MET = 1e-11
LOOSE, ENOUGH = 1e-3, 0.2
"""From which allowed departure on, and below which part of it, lengths are corrected twice only."""
CORRECTIONS = 15
MORE_ROWS = 8
"""Times that parts which a step would carry through each other are taken into its system, before it is too long."""
NEARLY_TAUT = 1e-6
"""What a bar may be shorter than its length at the start, relative, to be looked upon as taut first."""
MOST_HALVINGS = 8

Path = Callable[[float], Floats]
"""Where the vessel has gone from where it was at first, at a time in s, (3,), m."""


class Motion:
    """A net, or a sector of one, on its way: places and, half a step behind, velocities."""

    def __init__(
        self,
        problem: Problem,
        positions: Floats,
        velocities: Floats | None = None,
        *,
        added_mass: Floats | float = 1.0,
        towed: NDArray[np.bool_] | None = None,
        path: Path | None = None,
        length_error: float = 1e-7,
    ) -> None:
        """Set a net out.

        Args:
            problem: the net under its loads; all its bars must have mass.
            positions: of the nodes, (n, 3).
            velocities: of the nodes, (n, 3); none by default.
            added_mass: Cm of the bars, (m,) or of all.
            towed: nodes that are held by the vessel and go with it, (n,).
            path: how the vessel goes.
            length_error: departure of a bar from its length, relative, that a step may leave to the next one to mend;
                from ``LOOSE`` on they are met no better than need be, which large nets that flap are followed by.
        """
        net = problem.net
        self.problem, self.loading = problem, problem.loading
        self.structure = problem.structure._replace(free=problem.structure.free.copy())
        self.masses = MovingMasses(net, problem.loading.water.density, added_mass)
        bars, nodes = len(net.bars), len(net.positions)
        self.pattern = rigid.rigid_pattern(self.structure, None if problem.body is None else problem.body.nodes)
        self.tensions = OneSided(self.pattern, self.structure.is_strut)
        surface = problem.surface
        self.meeting = None if surface is None else Meeting(surface, float(net.bar_length.min()))
        self._met = np.zeros((0, 4), dtype=np.int32)
        self.time, self.last_step = 0.0, 0.0
        self.position = np.array(positions, dtype=np.float64, order="C")
        self.body: BodyMotion | None = None
        if problem.body is not None:
            self.body = BodyMotion(problem.body, self.structure, self.pattern, self.position)
        self.velocity = np.zeros((nodes, 3)) if velocities is None else np.array(velocities, dtype=np.float64)
        self.towed = np.zeros(nodes, dtype=bool) if towed is None else towed
        self.path, self._start = path, self.position[self.towed].copy()
        self.length_error, self._corrections = length_error, 2 if length_error >= LOOSE else CORRECTIONS
        self.worst_length = 0.0
        """Largest departure of a bar from its length that a step has left, relative."""
        self.density = np.zeros(bars)
        """Force densities of the last step, N/m, (m,)."""
        self.tension = np.zeros(bars)
        """At the start of the last step, N, (m,)."""
        self.support = np.zeros((nodes, 3))
        """What held the nodes then, N, (n, 3): of free nodes what is left out of balance, round-off."""
        self._move = np.zeros((nodes, 3))
        self._share = np.zeros(problem.bands)
        self._gradient, self._square = np.zeros((2 * bars, 3)), np.zeros(bars)
        self._inverse = np.zeros((nodes, 3, 3))
        self._force, self._acceleration = np.zeros((nodes, 3)), np.zeros((nodes, 3))
        self._rate, self._length = np.zeros(bars), np.zeros(bars)
        bar_lengths(self.position, self.structure, self._length)
        self.stretching = Stretching(self.structure, self._length)
        # a crumpled bar that was asked to be as long as it is would tear its neighbours along
        self.tensions.taut[:] = self.structure.is_strut | (self._length >= (1.0 - NEARLY_TAUT) * self.structure.length)

    def state(self) -> dict[str, Floats | Ints]:
        """A copy of all that ``set_state`` needs to go on from here."""
        clock = np.array([self.time, self.last_step, float(self.unsettled), self.worst_length])
        return {
            "position": self.position.copy(),
            "velocity": self.velocity.copy(),
            "taut": self.tensions.taut.copy(),
            "strain": self.stretching.strain.copy(),
            "density": self.density.copy(),
            "free": self.structure.free.copy(),
            "clock": clock,
            **({} if self.body is None else self.body.state()),
            **({} if self.meeting is None else self.meeting.state()),
        }

    def set_state(self, state: dict[str, Floats | Ints]) -> None:
        """Go back to a state."""
        self.position[:], self.velocity[:] = state["position"], state["velocity"]
        if self.meeting is not None:
            self.meeting.set_state(state)
            self._set_rows(self.meeting.nodes)
        self.tensions.taut[:], self.stretching.strain[:] = state["taut"], state["strain"]
        self.structure.free[:], self.density = state["free"], np.array(state["density"])
        self.time, self.last_step, unsettled, self.worst_length = map(float, state["clock"])
        self.tensions.unsettled = int(unsettled)
        if self.body is not None:
            self.body.set_state(state["body"])

    def hold(self, node: int, ground: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Hold a node fast from now on to the ground, whose velocity as seen here is ``ground``, (3,), m/s."""
        self.structure.free[node] = 0.0
        self.velocity[node] = ground

    @property
    def taut(self) -> Ints:
        """Bars that were taut in the last step, (m,)."""
        return self.tensions.taut[: len(self.density)]

    @property
    def unsettled(self) -> int:
        """Steps in which it was not found which bars are slack."""
        return self.tensions.unsettled

    @property
    def kinetic_energy_j(self) -> float:
        """Of bars, points and the water that goes with them, half a step before the places."""
        blocks = self.bare_masses()
        own = 0.0 if self.body is None else self.body.energy_j
        return own + 0.5 * float(np.einsum("ni,nij,nj", self.velocity, blocks, self.velocity))

    def step(self, dt: float) -> None:
        """Advance by ``dt`` seconds; where one step does not meet the lengths, in shorter ones.

        Raises:
            ArithmeticError: shorter steps do not mend it.
        """
        self._advance(dt, 0)

    def _advance(self, dt: float, halvings: int) -> None:
        before = self.state()
        if self._tried(dt):
            return
        if halvings == MOST_HALVINGS:
            raise ArithmeticError(f"the motion cannot be followed at {self.time:g} s, in steps of {dt:g} s neither")
        self.set_state(before)
        self._advance(0.5 * dt, halvings + 1)
        at_start = self.tension.copy(), self.support.copy()
        self._advance(0.5 * dt, halvings + 1)
        self.tension, self.support = at_start

    def _tried(self, dt: float) -> bool:
        kick = 0.5 * (self.last_step + dt)
        self._measure()
        self._set_loads(kick, dt)
        last_velocity = self.velocity.copy()
        self._move_supports(dt)
        # what their masses feel of being moved is in the balance of the supports below
        found = self._solve_for_tensions(kick, dt)
        if found is None:
            return False
        density, pulls = found
        pulls += self._force
        rigid.accelerations(self._inverse, pulls, self._acceleration)
        self.velocity += kick * self._acceleration
        self.position += dt * self.velocity
        if self.body is not None:
            twist = self.body.pulled(pulls - self._force, kick)
            self.body.velocities(twist, self.velocity)
            self.body.advance(twist, dt, self.position)
        if not np.isfinite(self.position).all():
            return False
        felt = np.einsum("nij,nj->ni", self.masses.blocks, self.velocity - last_velocity) / kick
        self.support = felt - pulls
        self.tension, self.density = density * np.sqrt(self._square), density
        bar_lengths(self.position, self.structure, self._length)
        self.stretching.note(self.structure, self._length)
        self.time, self.last_step = self.time + dt, dt
        return True

    def _measure(self) -> None:
        rigid.length_gradients(self.position, self.structure, self._gradient, self._square)

    def bare_masses(self) -> Floats:
        """Masses of the nodes where they are, kg, (n, 3, 3), until the next step."""
        self._measure()
        return self.masses.set_bare(self.pattern, self._gradient, self._square)

    def _set_loads(self, kick: float, dt: float) -> None:
        structure, loading, water, masses = self.structure, self.loading, self.loading.water, self.masses
        self._force[:] = 0.0
        add_moving_force(self.position, self.velocity, structure, loading, self._share, self._force)
        blocks = masses.set_bare(self.pattern, self._gradient, self._square)
        bare = blocks.copy() if self.body is not None else blocks
        of_points = blocks[loading.points.node, 0, 0].copy()
        here = self.position, self.velocity
        own = masses.of_bars, masses.of_water, masses.of_points_a_bar
        motion.add_bar_drag(*here, structure, water, *own, self.density, kick, dt, blocks)
        motion.add_point_drag(*here, loading.points, water, of_points, kick, blocks)
        motion.add_seabed(*here, loading.seabed, kick, dt, self._force, blocks)
        motion.invert(blocks, structure.free, self._inverse)
        if self.body is not None:
            self.body.start_step(bare, blocks, self._gradient, dt)
            self.body.set_free(self._force, kick)

    def _move_supports(self, dt: float) -> None:
        if self.path is not None:
            there = self._start + self.path(self.time + dt)
            self.velocity[self.towed] = (there - self.position[self.towed]) / dt

    def _solve_for_tensions(self, kick: float, dt: float) -> tuple[Floats, Floats] | None:
        """Force densities of the step, N/m, (m,), of twine none below 0, and the pulls of bars and pushes, N, (n, 3).

        None where the lengths are not met, or parts pass through each other.
        """
        if self.meeting is None:
            return self._with_rows(kick, dt, None)
        expected = dt * self.velocity
        self.meeting.look(self.position, expected)
        rows: Rows | None = self.meeting.rows(self.position, expected)
        for _ in range(MORE_ROWS):
            if rows is None:
                return None
            self._set_rows(rows.node)
            found = self._with_rows(kick, dt, rows)
            if found is None or self.meeting.passes(self.position, self._move):
                return found
            rows = self.meeting.more_rows(self.position, self._move)
        return None

    def _set_rows(self, met: Ints) -> None:
        """Give pairs of parts, whose nodes are (c, 4), rows after those of the bars."""
        if np.array_equal(met, self._met):
            return
        before, bars = self.tensions, len(self.density)
        strut = np.concatenate([self.structure.is_strut, np.zeros(len(met), dtype=bool)])
        no_push = np.concatenate([np.full(bars, NO_PUSH), np.full(len(met), NO_TOUCH)])
        self.tensions = OneSided(rigid.rigid_pattern(self.structure, None, met), strut, no_push)
        # a pair that had a row presses as it did; one that had none, not before it is asked
        pressed = {tuple(pair): push for pair, push in zip(self._met.tolist(), before.taut[bars:], strict=True)}
        self.tensions.taut[:bars] = before.taut[:bars]
        self.tensions.taut[bars:] = [pressed.get(tuple(pair), 0) for pair in met.tolist()]
        self.tensions.unsettled, self._met = before.unsettled, met

    def _with_rows(self, kick: float, dt: float, rows: Rows | None) -> tuple[Floats, Floats] | None:
        """The same with the rows of some parts that meet.

        Newton's method on the lengths at the end of the step, all its systems with the matrix of the start; in each
        one bars are taut that then pull, and all others no longer than they may be.
        """
        structure, stretching, squared = self.structure, self.stretching, kick * dt
        bars, system = len(structure.length), self.tensions
        stretching.begin(structure, self._square)
        rigid.accelerations(self._inverse, self._force, self._acceleration)
        free_move = dt * (self.velocity + kick * self._acceleration)
        self._moved(free_move, kick, dt, None)
        every = np.ones(len(system.taut), dtype=np.int32)
        gradient = self._gradient if rows is None else np.concatenate([self._gradient, rows.gradient.reshape(-1, 3)])
        rigid.tension_system(system.pattern, gradient, self._inverse, every, system.entries)
        if self.body is not None:
            self.body.couple(system.entries)
        diagonal = system.pattern.diagonal
        system.entries[diagonal[:bars]] += structure.length**2 * stretching.give / squared
        system.entries[diagonal[bars:]] *= 1.0 + COMPLIANCE
        system.renewed()
        # the first time without the term in dt^2, which is what the papers solve
        rigid.lengthening(structure, self._gradient, free_move, self._rate)
        aim = stretching.aims(0.0)
        right = np.zeros(len(system.taut))
        right[:bars] = (self._rate + 0.5 * (self._square - aim**2)) / squared
        if rows is not None:
            right[bars:] = (rows.aim - rows.gap + rows.closed(free_move)) / squared
        worst, density = np.inf, None
        for number in range(CORRECTIONS):
            found = system.solve(right)
            if found is None:
                return None
            density, pulls = found[:bars], np.zeros_like(free_move)
            rigid.add_pulls(structure, self._gradient, density, pulls)
            if rows is not None:
                add_pushes(rows.node, rows.gradient, found[bars:], pulls)
            rigid.accelerations(self._inverse, pulls, self._acceleration)
            self._move = move = free_move + squared * self._acceleration
            self._moved(move, kick, dt, pulls)
            bar_lengths(self.position + move, structure, self._length)
            aim = stretching.aims(density)
            error = self._length / aim - 1.0
            last, worst = worst, float(np.max(np.where(self.taut, np.abs(error), error), initial=0.0))
            if worst <= LENGTHS_MET or not worst < 0.7 * last:
                break
            if number + 1 >= self._corrections and worst <= ENOUGH * self.length_error:
                break
            right = system.times(found)
            right[:bars] += 0.5 * (self._length**2 - aim**2) / squared
            if rows is not None:
                right[bars:] += (rows.aim - rows.gap + rows.closed(move)) / squared
        if not worst <= self.length_error or density is None or not np.isfinite(density).all():
            return None
        self.worst_length = max(self.worst_length, worst)
        return density, pulls

    def _moved(self, move: Floats, kick: float, dt: float, pulls: Floats | None) -> None:
        """Write those of a body's nodes into the moves of a step, (n, 3): under its loads, and pulls (n, 3) besides."""
        if self.body is not None:
            self.body.moves(self.body.pulled(np.zeros_like(move) if pulls is None else pulls, kick), dt, move)
