"""A rigid body in a net's motion in time: its momentum, and how the bars at its nodes accelerate each other through it.

The body's six velocities w (of its origin, and its rotation) change over a step, with the masses and drag of what is
fastened to it on its left side (``mechanics.motion``), by

    A w' = P + (A - M) w + kick (F + J^T f)

M its mass matrix with the bare masses of its nodes, A the same with what drag takes at the step's end, F its own loads,
f the forces on its nodes and P its momentum. P and not M w is what goes from one step to the next, so the moment of
momentum of a body that spins freely is kept whole however long the steps; its own part of M is that of the attitude
half a step on. Weight and buoyancy are taken at the step's start: a step may be no longer than a part of its heave.
"""

import numpy as np

from codend.mechanics import body as rigid
from codend.mechanics.body import Body, Pose
from codend.mechanics.rigid import RigidPattern
from codend.mechanics.structure import Structure
from codend.net.net import Floats, Ints


class BodyMotion:
    """Where the body of a net is and how it moves."""

    def __init__(self, body: Body, structure: Structure, pattern: RigidPattern, position: Floats) -> None:
        """Set it out at rest where its nodes are, (n, 3)."""
        self.body = body
        self.pose = rigid.pose_of(body, position)
        self.twist = np.zeros(6)
        """Velocity of its origin and of its rotation, half a step before."""
        self.momentum = np.zeros(6)
        """Its own and that of its nodes' bare masses, the moment about its origin, likewise."""
        place = np.full(len(position), -1)
        place[body.nodes] = np.arange(len(body.nodes))
        ends = np.stack([structure.first, structure.second], axis=1)
        on_body = place[ends]
        self.bars = np.flatnonzero((on_body >= 0).any(axis=1))
        self._on = on_body[self.bars]
        pairs = self.bars[:, None] * len(ends) + self.bars[None, :]
        keys = pattern.row.astype(np.int64) * len(ends) + pattern.column
        self._slots = np.searchsorted(keys, pairs)
        # bars of which nothing but the body moves, whose own entries stand in for nothing
        other = ends[self.bars, np.where(self._on[:, 0] >= 0, 1, 0)]
        alone = ~(self._on >= 0).all(axis=1) & ~structure.free[other].any(axis=1)
        self._alone = pattern.diagonal[self.bars[alone]]

    @property
    def energy_j(self) -> float:
        """Of its own motion, without what is fastened to it."""
        return 0.5 * float(self.twist @ rigid.mass_matrix(self.body, self.pose.turn) @ self.twist)

    def state(self) -> dict[str, Floats]:
        """A copy of all that ``set_state`` needs."""
        return {"body": np.concatenate([self.pose.origin, self.pose.turn.ravel(), self.twist, self.momentum])}

    def set_state(self, values: Floats | Ints) -> None:
        """Go back to a state."""
        now = np.array(values, dtype=float)
        self.pose = Pose(now[:3], now[3:12].reshape(3, 3))
        self.twist, self.momentum = now[12:18], now[18:]

    def start_step(self, bare: Floats, blocks: Floats, gradient: Floats, dt: float) -> None:
        """Take the masses of the nodes before and after drag is added, (n, 3, 3), and bars' gradients, (2 m, 3)."""
        body, nodes = self.body, self.body.nodes
        self._arms = rigid.arms_now(body, self.pose)
        self._jacobian = rigid.jacobian(self._arms)
        own = rigid.mass_matrix(body, rigid.turned_by(0.5 * dt * self.twist[3:]) @ self.pose.turn)
        self._bare = own + np.einsum("kia,kij,kjb->ab", self._jacobian, bare[nodes], self._jacobian)
        self._mass = own + np.einsum("kia,kij,kjb->ab", self._jacobian, blocks[nodes], self._jacobian)
        self._inverse = np.linalg.inv(self._mass)
        ends = gradient.reshape(-1, 2, 3)[self.bars]
        self._gradient = np.zeros((len(self.bars), 6))
        for side in range(2):
            on = self._on[:, side] >= 0
            self._gradient[on] += np.einsum("ki,kia->ka", ends[on, side], self._jacobian[self._on[on, side]])

    def couple(self, entries: Floats) -> None:
        """Add to the system for the tensions what bars feel of each other through the body."""
        entries[self._alone] = 0.0
        entries[self._slots] += self._gradient @ self._inverse @ self._gradient.T

    def gathered(self, force: Floats) -> Floats:
        """Forces on the body's nodes, of those on all, (n, 3), as force and moment, (6,)."""
        return np.asarray(np.einsum("kia,ki->a", self._jacobian, force[self.body.nodes]))

    def set_free(self, force: Floats, kick: float) -> None:
        """Take the velocity to which loads alone bring the body, forces on nodes (n, 3) among them."""
        push = kick * (rigid.load(self.body, self.pose) + self.gathered(force))
        self._free = self._inverse @ (self.momentum + (self._mass - self._bare) @ self.twist + push)

    def pulled(self, pulls: Floats, kick: float) -> Floats:
        """Velocity with the pulls of bars, (n, 3), besides, (6,)."""
        return np.asarray(self._free + kick * (self._inverse @ self.gathered(pulls)))

    def velocities(self, twist: Floats, velocity: Floats) -> None:
        """Write the velocities of the body's nodes into those of all, (n, 3)."""
        velocity[self.body.nodes] = self._jacobian @ twist

    def moves(self, twist: Floats, dt: float, move: Floats) -> None:
        """Write how far the body's nodes go in a step into the moves of all, (n, 3)."""
        turned = rigid.turned_by(dt * twist[3:])
        move[self.body.nodes] = dt * twist[:3] + self._arms @ turned.T - self._arms

    def advance(self, twist: Floats, dt: float, position: Floats) -> None:
        """Go on by a step with this velocity; writes where the body's nodes are."""
        self.momentum = self._bare @ twist
        # about where the origin then is
        self.momentum[3:] -= np.cross(dt * twist[:3], self.momentum[:3])
        self.twist, self.pose = twist, rigid.moved(self.pose, dt * twist)
        rigid.place(self.body, self.pose, position)
