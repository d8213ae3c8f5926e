"""A rigid body afloat: exact hydrostatics, its tangent, its mass."""

import numpy as np
import pytest

from codend.mechanics.body import (
    Body,
    Pose,
    Prism,
    attitude_deg,
    immersed,
    load,
    load_tangent,
    mass_matrix,
    moved,
    place,
    pose_of,
    turned_by,
)
from codend.mechanics.weight import GRAVITY_M_S2

WATER = 1025.0
PRISMS = {
    "box": Prism(np.array([0.4, -0.3, -0.6]), 1.1, sides_m=(0.5, 0.8)),
    "cylinder": Prism(np.array([-0.2, 0.5, -0.5]), 1.3, diameter_m=0.7),
}
TILTS = ([0.0, 0.0, 0.0], [0.3, -0.2, 0.9], [0.05, 0.4, -2.0])


def afloat(*prisms, mass=100.0):
    parts = [prism.columns() for prism in prisms]
    arms = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [1.0, 2.0, 0.3]])
    zero = np.zeros(3)
    return Body(
        np.arange(4), arms, mass, np.array([0.1, 0.0, -0.2]), np.diag([3.0, 4.0, 5.0]), zero, zero,
        *(np.concatenate([part[i] for part in parts]) for i in range(3)), WATER,
    )  # fmt: skip


def by_quadrature(prism, pose):
    """Immersed volume and its moment about the origin by a fine quadrature over the section."""
    points, weights = np.polynomial.legendre.leggauss(40)
    if prism.sides_m:
        x, y = np.meshgrid(*(0.5 * side * points for side in prism.sides_m))
        area = 0.25 * prism.area_m2 * np.outer(weights, weights)
    else:
        r, angle = 0.25 * prism.diameter_m * (points + 1.0), 2.0 * np.pi * np.arange(64) / 64
        x, y = np.outer(np.cos(angle), r), np.outer(np.sin(angle), r)
        area = np.broadcast_to(2.0 * np.pi / 64 * 0.25 * prism.diameter_m * weights * r, x.shape)
    foot = (prism.foot + np.stack([x, y, 0.0 * x], axis=-1)) @ pose.turn.T
    length = -(pose.origin[2] + foot[..., 2]) / pose.turn[2, 2]
    assert length.min() > 0.0
    assert length.max() < prism.height_m
    middle = foot + 0.5 * length[..., None] * pose.turn[:, 2]
    return (area * length).sum(), ((area * length)[..., None] * middle).sum(axis=(0, 1))


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("kind", PRISMS)
def test_volume_and_centre_of_a_tilted_float_are_exact(kind, tilt):
    prism, pose = PRISMS[kind], Pose(np.array([0.3, 0.1, 0.02]), turned_by(tilt))
    volume, moment = by_quadrature(prism, pose)
    water = immersed(afloat(prism), pose)
    share = water.length * 0.25 * prism.area_m2
    assert share.sum() == pytest.approx(volume, rel=1e-12)
    assert (share[:, None] * water.middle).sum(axis=0) == pytest.approx(moment, rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("turn", [np.eye(3), np.diag([1.0, -1.0, -1.0])], ids=["upright", "on its head"])
@pytest.mark.parametrize("tilt", TILTS)
def test_the_tangent_of_weight_and_buoyancy_is_that_of_differences(tilt, turn):
    body = afloat(*PRISMS.values())
    pose = Pose(np.array([0.3, 0.1, 0.02]), turned_by(tilt) @ turn)
    size = 1e-5
    columns = [(load(body, moved(pose, -size * e)) - load(body, moved(pose, size * e))) / (2 * size) for e in np.eye(6)]
    assert load_tangent(body, pose) == pytest.approx(np.array(columns).T, abs=1e-5)


def test_an_upright_body_is_righted_by_its_metacentre():
    # rho g V GM, GM = I / V + KB - KG, of a box whose weight it carries
    prism = Prism(np.array([0.0, 0.0, -0.3]), 1.0, sides_m=(1.0, 2.0))
    mass = WATER * 2.0 * 0.3
    body = Body(
        np.arange(3), np.zeros((3, 3)), mass, np.array([0.0, 0.0, 0.1]), np.eye(3), np.zeros(3), np.zeros(3),
        *prism.columns(), WATER,
    )  # fmt: skip
    found = load_tangent(body, Pose(np.zeros(3), np.eye(3)))
    for axis, second in ((3, 1.0 * 2.0**3 / 12.0), (4, 2.0 * 1.0**3 / 12.0)):
        gm = second / 0.6 - 0.15 - 0.1
        assert found[axis, axis] == pytest.approx(mass * GRAVITY_M_S2 * gm, rel=1e-12)
    assert found[2, 2] == pytest.approx(WATER * GRAVITY_M_S2 * 2.0, rel=1e-12)


def test_the_nodes_of_a_body_tell_its_pose():
    body, position = afloat(*PRISMS.values()), np.zeros((4, 3))
    pose = Pose(np.array([5.0, -3.0, 0.2]), turned_by([0.3, -0.2, 2.5]))
    place(body, pose, position)
    found = pose_of(body, position)
    assert found.origin == pytest.approx(pose.origin)
    assert found.turn == pytest.approx(pose.turn, abs=1e-11)


def test_heel_trim_and_yaw_have_the_signs_that_are_told():
    assert attitude_deg(turned_by([0.1, 0.0, 0.0])) == pytest.approx((np.degrees(0.1), 0.0, 0.0))
    assert attitude_deg(turned_by([0.0, 0.1, 0.0])) == pytest.approx((0.0, np.degrees(0.1), 0.0))
    assert attitude_deg(turned_by([0.0, 0.0, 0.1])) == pytest.approx((0.0, 0.0, np.degrees(0.1)))


def test_the_energy_of_a_turning_body_is_that_of_its_parts():
    body, turn, rng = afloat(*PRISMS.values()), turned_by([0.4, 0.1, -1.0]), np.random.default_rng(2)
    velocity, spin = rng.normal(size=3), rng.normal(size=3)
    at_centre = velocity + np.cross(spin, turn @ body.centre)
    right = body.mass_kg * at_centre @ at_centre + spin @ (turn @ body.inertia @ turn.T) @ spin
    twist = np.concatenate([velocity, spin])
    assert twist @ mass_matrix(body, turn) @ twist == pytest.approx(right, rel=1e-12)
