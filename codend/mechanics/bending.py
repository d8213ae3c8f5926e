"""Resistance of stiff twine to the opening of the meshes: force, tangent and bound, kernels.

A twine of bending stiffness EI and length b that is clamped in its knots turns by phi - phi0 from its angle at rest
under the moment k (phi - phi0), k = 12 EI / b for small deflections (derived: each end sways under 6 EI / b^2 times the
deflection). Half of that belongs to each end. At a corner of a mesh two twines meet at the angle psi = 2 phi, or
pi - 2 phi beside a knot that lies across, so a corner holds half the energy of two twines:

    U = k (psi - psi0)^2 / 8,   dU/dpsi = k (psi - psi0) / 4
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.images import add_turned_back, turned
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern, add_turned_block
from codend.net.net import Floats


@njit(cache=True)
def corner_vectors(position: Floats, structure: Structure, corner: int, u: Floats, v: Floats) -> None:
    """Write the two twines of a corner, from its middle outward, each (3,)."""
    corners, images, rotations = structure.corners, structure.corner_image, structure.rotations
    middle, first, second = corners[corner, 0], corners[corner, 1], corners[corner, 2]
    my, mz = turned(position[middle, 1], position[middle, 2], images[corner, 0], rotations)
    ay, az = turned(position[first, 1], position[first, 2], images[corner, 1], rotations)
    by, bz = turned(position[second, 1], position[second, 2], images[corner, 2], rotations)
    u[0], u[1], u[2] = position[first, 0] - position[middle, 0], ay - my, az - mz
    v[0], v[1], v[2] = position[second, 0] - position[middle, 0], by - my, bz - mz


@njit(cache=True)
def dot(u: Floats, v: Floats) -> float:
    """Scalar product of two vectors in space."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@njit(cache=True)
def corner_slopes(u: Floats, v: Floats, along_u: Floats, along_v: Floats) -> float:
    """Angle psi between two vectors, and its gradients with respect to them; gradients 0 where they are parallel."""
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    cross = np.sqrt(max(uu * vv - uv * uv, 0.0))
    along_u[:] = 0.0
    along_v[:] = 0.0
    if cross > 1e-12 * uu + 1e-12 * vv:
        for i in range(3):
            along_u[i] = (uv / uu * u[i] - v[i]) / cross
            along_v[i] = (uv / vv * v[i] - u[i]) / cross
    return np.arctan2(cross, uv)


@njit(cache=True)
def add_force(position: Floats, structure: Structure, force: Floats) -> None:
    """Add to the nodal forces what the stiff twines resist with, N."""
    corners, images, rotations = structure.corners, structure.corner_image, structure.rotations
    stiffness, rest = structure.corner_stiffness, structure.corner_rest
    u, v, along_u, along_v = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for corner in range(len(stiffness)):
        corner_vectors(position, structure, corner, u, v)
        psi = corner_slopes(u, v, along_u, along_v)
        moment = -0.25 * stiffness[corner] * (psi - rest[corner])
        ax, ay, az = moment * along_u[0], moment * along_u[1], moment * along_u[2]
        bx, by, bz = moment * along_v[0], moment * along_v[1], moment * along_v[2]
        add_turned_back(force, corners[corner, 1], ax, ay, az, images[corner, 1], rotations)
        add_turned_back(force, corners[corner, 2], bx, by, bz, images[corner, 2], rotations)
        add_turned_back(force, corners[corner, 0], -ax - bx, -ay - by, -az - bz, images[corner, 0], rotations)


@njit(cache=True)
def add_bound(position: Floats, structure: Structure, bound: Floats) -> None:
    """Add a bound on the bending's part of each node's row of the stiffness matrix, N/m, (n,)."""
    corners, stiffness, rest = structure.corners, structure.corner_stiffness, structure.corner_rest
    u, v = np.empty(3), np.empty(3)
    for corner in range(len(stiffness)):
        corner_vectors(position, structure, corner, u, v)
        uu, vv = dot(u, u), dot(v, v)
        shorter = min(uu, vv)
        # 2/l for the angle's gradient at the middle; its own derivative weighs with the moment that is there
        angle = np.arccos(min(max(dot(u, v) / np.sqrt(uu * vv), -1.0), 1.0))
        turning = 0.25 * stiffness[corner] * (4.0 + 4.0 * abs(angle - rest[corner]) / max(np.sin(angle), 0.05))
        for end in range(3):
            bound[corners[corner, end]] += turning / shorter


@njit(cache=True)
def angle_curvatures(u: Floats, v: Floats, along_u: Floats, along_v: Floats, curvature: Floats) -> None:
    """Write the second derivatives of the angle psi between u and v by (u, v), (6, 6).

    With c = |u x v| and the gradient along u, g = ((u.v / u.u) u - v) / c, from ``corner_slopes``:

        dg = (d(u.v / u.u) u + (u.v / u.u) du - dv - g dc) / c,   c dc = v.v u.du + u.u v.dv - u.v (v.du + u.dv)
    """
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    square = uu * vv - uv * uv
    cross = np.sqrt(square)
    for i in range(3):
        for j in range(3):
            same = 1.0 if i == j else 0.0
            by_u, by_v = vv * u[j] - uv * v[j], uu * v[j] - uv * u[j]
            own = u[i] * (v[j] / uu - 2.0 * uv / uu**2 * u[j]) + uv / uu * same
            curvature[i, j] = own / cross - along_u[i] * by_u / square
            curvature[i, 3 + j] = (u[i] * u[j] / uu - same) / cross - along_u[i] * by_v / square
            own = v[i] * (u[j] / vv - 2.0 * uv / vv**2 * v[j]) + uv / vv * same
            curvature[3 + i, 3 + j] = own / cross - along_v[i] * by_v / square
            curvature[3 + j, i] = curvature[i, 3 + j]


@njit(cache=True)
def add_tangent(position: Floats, structure: Structure, pattern: Pattern, blocks: Floats) -> None:
    """Add the second derivative of k (psi - psi0)^2 / 8: k / 4 (grad psi grad psi^T + (psi - psi0) grad grad psi)."""
    images, rotations = structure.corner_image, structure.rotations
    stiffness, rest, slots = structure.corner_stiffness, structure.corner_rest, pattern.corner_slot
    u, v, along_u, along_v = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    curvature, whole, h = np.empty((6, 6)), np.zeros((9, 9)), np.empty((3, 3))
    for corner in range(len(stiffness)):
        corner_vectors(position, structure, corner, u, v)
        psi = corner_slopes(u, v, along_u, along_v)
        if along_u[0] == 0.0 and along_u[1] == 0.0 and along_u[2] == 0.0:
            continue
        angle_curvatures(u, v, along_u, along_v, curvature)
        quarter = 0.25 * stiffness[corner]
        for i in range(6):
            first = along_u[i] if i < 3 else along_v[i - 3]
            for j in range(6):
                second = along_u[j] if j < 3 else along_v[j - 3]
                whole[3 + i, 3 + j] = quarter * (first * second + (psi - rest[corner]) * curvature[i, j])
        # the middle moves both vectors the other way
        for i in range(3):
            for j in range(6):
                whole[i, 3 + j] = -whole[3 + i, 3 + j] - whole[6 + i, 3 + j]
                whole[3 + j, i] = whole[i, 3 + j]
            for j in range(3):
                whole[i, j] = 0.0
        for i in range(3):
            for j in range(3):
                whole[i, j] = -whole[i, 3 + j] - whole[i, 6 + j]
        for a in range(3):
            for b in range(3):
                for i in range(3):
                    for j in range(3):
                        h[i, j] = whole[3 * a + i, 3 * b + j]
                slot = slots[corner, a, b]
                add_turned_block(blocks, slot, 1.0, h, images[corner, a], images[corner, b], rotations)
