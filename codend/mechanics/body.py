"""A rigid body that nodes of a net are fastened to, afloat or not: its pose, its loads, their tangent and its mass.

It has six unknowns: where its origin is, and how it is turned, kept as a matrix and changed by a rotation vector, so
that no attitude is singular. Its floats are prisms (boxes, cylinders) that stand upright while the body does, cut by
the water's level surface at z = 0. A prism is told as columns at the points of a quadrature that is exact to the third
degree over its section: the water covers a height that is linear over the section, so volume, centre of buoyancy and
their derivatives are exact at any heel as long as the surface crosses the sides only and neither foot nor top.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import Floats, Ints

UP = np.array([0.0, 0.0, 1.0])
FULL = 0.9
"""Share of all its buoyancy to which a body is taken to be loaded at most, to start with."""
MARKER_M = 0.01
"""How far from the origin the two nodes are that tell how the body is turned."""


class Pose(NamedTuple):
    """Where a body is."""

    origin: Floats
    """(3,), m."""
    turn: Floats
    """Its own axes as columns, (3, 3)."""


@dataclass(frozen=True)
class Body:
    """A rigid body, in its own axes, which are those of the water while it is as it was placed."""

    nodes: Ints
    """Nodes of the net that go with it, (k,): its origin first, then one ahead and one beside by ``MARKER_M``."""
    arms: Floats
    """Places of these, from its origin, (k, 3), m."""
    mass_kg: float
    centre: Floats
    """Its centre of mass, from its origin, (3,), m."""
    inertia: Floats
    """About its centre of mass, (3, 3), kg m2."""
    added_mass: Floats
    """Of water that goes with it, along its own axes at the centre of mass, (3,), kg."""
    added_inertia: Floats
    """Likewise about these, (3,), kg m2."""
    column_foot: Floats
    """Lower ends of the columns of its floats, (c, 3), m."""
    column_height: Floats
    """(c,), m."""
    column_area: Floats
    """Waterplane of each, (c,), m2."""
    water_density: float

    @property
    def weight_n(self) -> float:
        """Its own, in air."""
        return self.mass_kg * GRAVITY_M_S2

    @property
    def carries_kg(self) -> float:
        """What its floats carry at most, under water."""
        return self.water_density * float(self.column_area @ self.column_height)

    @property
    def size_m(self) -> float:
        """How far its parts are from its origin: what turns are measured with."""
        reach = np.linalg.norm(np.concatenate([self.arms, self.column_foot]), axis=1).max()
        return float(max(reach, MARKER_M))


def cross(vectors: ArrayLike) -> Floats:
    """Matrices [v]x with [v]x w = v x w, (..., 3, 3), of vectors (..., 3)."""
    v = np.asarray(vectors, dtype=float)
    zero = np.zeros(v.shape[:-1])
    rows = [[zero, -v[..., 2], v[..., 1]], [v[..., 2], zero, -v[..., 0]], [-v[..., 1], v[..., 0], zero]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def turned_by(rotation: ArrayLike) -> Floats:
    """The matrix of a rotation vector, (3, 3)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(np.asarray(rotation, dtype=float)).as_matrix())


def moved(pose: Pose, twist: Floats) -> Pose:
    """The pose after a displacement of the origin and a rotation vector about it, (6,)."""
    return Pose(pose.origin + twist[:3], turned_by(twist[3:]) @ pose.turn)


def arms_now(body: Body, pose: Pose) -> Floats:
    """From the origin to the body's nodes as it is turned, (k, 3)."""
    return np.asarray(body.arms @ pose.turn.T)


def place(body: Body, pose: Pose, position: Floats) -> None:
    """Write where the body's nodes are into the positions of all nodes, (n, 3)."""
    position[body.nodes] = pose.origin + arms_now(body, pose)


def pose_of(body: Body, position: Floats) -> Pose:
    """The pose of a body whose nodes are at these places, (n, 3)."""
    origin, ahead, beside = position[body.nodes[:3]]
    x = (ahead - origin) / np.linalg.norm(ahead - origin)
    y = (beside - origin) - ((beside - origin) @ x) * x
    y = y / np.linalg.norm(y)
    return Pose(origin.copy(), np.stack([x, y, np.cross(x, y)], axis=1))


def jacobian(arms: Floats) -> Floats:
    """How points at these arms move with the body's six unknowns, (k, 3, 6)."""
    return np.concatenate([np.broadcast_to(np.eye(3), (len(arms), 3, 3)), -cross(arms)], axis=2)


class Immersed(NamedTuple):
    """What the water covers of the columns of a body."""

    length: Floats
    """(c,), m."""
    middle: Floats
    """Of what is covered, from the body's origin, (c, 3), m."""
    surface: Floats
    """Where the surface cuts each, likewise; of columns all in or all out of the water of no use."""
    cut: NDArray[np.bool_]
    """Whether the surface cuts it, (c,)."""
    upright: float
    """Cosine of the angle between the columns and the vertical, without its sign."""


def immersed(body: Body, pose: Pose) -> Immersed:
    """What the water covers of the columns."""
    axis, foot = pose.turn[:, 2], body.column_foot @ pose.turn.T
    height, low = body.column_height, pose.origin[2] + foot[:, 2]
    rise = height * axis[2]
    lowest, span = np.minimum(low, low + rise), np.maximum(np.abs(rise), 1e-300)
    share = np.clip(-lowest / span, 0.0, 1.0)
    length = share * height
    # a float on its head is covered from its other end on
    start, way = (0.0, 1.0) if axis[2] >= 0.0 else (1.0, -1.0)
    first = foot + (start * height)[:, None] * axis
    along = way * axis
    middle, surface = first + 0.5 * length[:, None] * along, first + length[:, None] * along
    return Immersed(length, middle, surface, (share > 0.0) & (share < 1.0), abs(float(axis[2])))


def buoyancies(body: Body, water: Immersed) -> Floats:
    """Lift of every column, (c,), N."""
    return body.water_density * GRAVITY_M_S2 * body.column_area * water.length


def load(body: Body, pose: Pose) -> Floats:
    """Force of weight and buoyancy, and their moment about the origin, (6,), N and N m."""
    water = immersed(body, pose)
    lift, centre = buoyancies(body, water), pose.turn @ body.centre
    force = (lift.sum() - body.weight_n) * UP
    moment = np.cross((lift[:, None] * water.middle).sum(axis=0) - body.weight_n * centre, UP)
    return np.concatenate([force, moment])


def load_tangent(body: Body, pose: Pose) -> Floats:
    """Minus the derivative of ``load`` by the six unknowns, (6, 6)."""
    water = immersed(body, pose)
    lift, centre = buoyancies(body, water), pose.turn @ body.centre
    found = np.zeros((6, 6))
    # forces that keep their direction turn about the origin with their arms
    middle = (lift[:, None] * water.middle).sum(axis=0) - body.weight_n * centre
    found[3:, 3:] = -cross(UP) @ cross(middle)
    if water.cut.any():
        at = water.surface[water.cut]
        up = np.concatenate([np.broadcast_to(UP, at.shape), np.cross(at, UP)], axis=1)
        spring = body.water_density * GRAVITY_M_S2 * body.column_area[water.cut] / max(water.upright, 1e-9)
        found += np.einsum("c,ci,cj->ij", spring, up, up)
    return found


def force_tangent(arms: Floats, force: Floats) -> Floats:
    """What forces on points at these arms, (k, 3) both, add to ``load_tangent``, (6, 6)."""
    found = np.zeros((6, 6))
    found[3:, 3:] = -np.einsum("kij,kjl->il", cross(force), cross(arms))
    return found


def mass_matrix(body: Body, turn: Floats) -> Floats:
    """Of the body alone and the water that goes with it, about its origin, in the axes of the water, (6, 6)."""
    centre = cross(turn @ body.centre)
    mass = turn @ np.diag(body.mass_kg + body.added_mass) @ turn.T
    about = turn @ (body.inertia + np.diag(body.added_inertia)) @ turn.T
    found = np.zeros((6, 6))
    found[:3, :3], found[:3, 3:], found[3:, :3] = mass, -mass @ centre, centre @ mass
    found[3:, 3:] = about - centre @ mass @ centre
    return found


def afloat(body: Body, pose: Pose, weight_n: float) -> Pose:
    """The pose raised or lowered to where its floats carry it and ``weight_n`` besides, if some are not in the surface.

    Out of the water or under it, nothing tells how it would float.
    """
    if immersed(body, pose).cut.all():
        return pose
    carried = min(body.weight_n + max(weight_n, 0.0), FULL * buoyancies(body, immersed(body, _at(pose, -1e6))).sum())
    reach = body.size_m + float(body.column_height.max())
    low, high = -reach, reach
    for _ in range(60):
        middle = 0.5 * (low + high)
        if buoyancies(body, immersed(body, _at(pose, middle))).sum() > carried:
            low = middle
        else:
            high = middle
    return _at(pose, 0.5 * (low + high))


def _at(pose: Pose, height: float) -> Pose:
    return Pose(np.array([*pose.origin[:2], height]), pose.turn)


def shortest_period(body: Body) -> float:
    """Of its swings in height, heel and trim by itself, upright and with all its floats in the surface, s."""
    up = np.concatenate([np.broadcast_to(UP, body.column_foot.shape), np.cross(body.column_foot, UP)], axis=1)
    spring = body.water_density * GRAVITY_M_S2 * body.column_area
    stiffness = np.einsum("c,ci,cj->ij", spring, up, up)
    fastest = np.abs(np.linalg.eigvals(np.linalg.pinv(mass_matrix(body, np.eye(3))) @ stiffness)).max()
    return float(2.0 * np.pi / np.sqrt(fastest)) if fastest > 0.0 else np.inf


def attitude_deg(turn: Floats) -> tuple[float, float, float]:
    """Heel about x, trim about y and yaw about z, in this order about the body's own axes from the last, degrees.

    Heel is above 0 where the side y > 0 comes up, trim where the side x > 0 goes down, yaw from x towards y. All are
    nan of a body whose place is not known.
    """
    if not np.isfinite(turn).all():
        return np.nan, np.nan, np.nan
    from scipy.spatial.transform import Rotation

    yaw, trim, heel = Rotation.from_matrix(turn).as_euler("ZYX", degrees=True)
    return float(heel), float(trim), float(yaw)


@dataclass(frozen=True)
class Prism:
    """An upright float: a box or a cylinder."""

    foot: Floats
    """Middle of its foot, from the body's origin, (3,), m."""
    height_m: float
    sides_m: tuple[float, float] | None = None
    """Of a box, along x and y."""
    diameter_m: float | None = None
    """Of a cylinder."""

    @property
    def area_m2(self) -> float:
        """Of its section."""
        return self.sides_m[0] * self.sides_m[1] if self.sides_m else 0.25 * np.pi * (self.diameter_m or 0.0) ** 2

    def columns(self) -> tuple[Floats, Floats, Floats]:
        """Feet (4, 3), heights (4,) and areas (4,) of its columns: quadratures of the third degree."""
        if self.sides_m:
            x, y = (0.5 / np.sqrt(3.0) * side for side in self.sides_m)
            offsets = np.array([[x, y], [-x, y], [-x, -y], [x, -y]])
        else:
            r = 0.5 * (self.diameter_m or 0.0) / np.sqrt(2.0)
            offsets = np.array([[r, 0.0], [0.0, r], [-r, 0.0], [0.0, -r]])
        feet = self.foot + np.column_stack([offsets, np.zeros(4)])
        return feet, np.full(4, self.height_m), np.full(4, 0.25 * self.area_m2)

    def inertia(self, mass_kg: float) -> Floats:
        """About its own middle, its mass evenly spread, (3, 3), kg m2."""
        h = self.height_m**2
        if self.sides_m:
            a, b = self.sides_m[0] ** 2, self.sides_m[1] ** 2
            return np.diag([b + h, a + h, a + b]) * mass_kg / 12.0
        r = 0.25 * (self.diameter_m or 0.0) ** 2
        return np.diag([3.0 * r + h, 3.0 * r + h, 6.0 * r]) * mass_kg / 12.0
