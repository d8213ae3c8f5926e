"""Exact tangent of the stiff twine's resistance to opening: kernels."""

import numpy as np

from codend.compiled import njit
from codend.mechanics.arrays import Structure
from codend.mechanics.bending import corner_slopes, corner_vectors, dot
from codend.mechanics.tangent import Pattern, add_turned_block
from codend.net.net import Floats


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
def add_bending_tangent(position: Floats, structure: Structure, pattern: Pattern, blocks: Floats) -> None:
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
