"""Kernels of what the netting around a mesh adds to the force that opens it; see ``yielding``.

Netting without end, flat and even: a knot and its two twines aft, bar 1 along e1 = (cos phi, sin phi) and bar 2 along
e2 = (cos phi, -sin phi), repeat with the phases exp(i theta1), exp(i theta2) in a wave. A knot moves by u and, where it
has a length, turns: its ends move by -w/2 and w/2 across it, along t. The ends of a bar move apart by

    delta = (exp(i theta) - 1) u -+ (exp(i theta) + 1) t w / 2

(+ for bar 2 of T90, whose bars go from the left end of a knot to the right one of the next). It is stretched by EA / b,
turned against its tension by T / b and, as part of two bent corners, by their moment; a corner opens by what its twines
turn, each n . delta / b; a knot turns against the load that it carries. The sum over waves of the inverse stiffness on
the two knots of a mesh is what they move apart by under a unit force. Lengths are in bars, forces in EA.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit

Floats = NDArray[np.float64]

WAVES: Final = 16
"""Waves, each way, that are summed over; twice as many change the force by less than 0.1 %."""
LEAST_STRAIN: Final = 1e-7
"""Of a bar, below which it counts as this: netting without tension is held by nothing else."""


@njit(cache=True, nogil=True)
def all_neighbours_hold(
    half_angle: Floats, strain: Floats, stiffness: Floats, rest: Floats, knot: Floats, turned: NDArray[np.bool_]
) -> Floats:
    """``neighbours_hold`` of many meshes, arguments (k,), the result (k, 2)."""
    held = np.empty((len(half_angle), 2))
    for i in range(len(half_angle)):
        neighbours_hold(half_angle[i], strain[i], stiffness[i], rest[i], knot[i], turned[i], held[i])
    return held


@njit(cache=True, nogil=True)
def neighbours_hold(
    half_angle: float, strain: float, stiffness: float, rest: float, knot: float, turned: bool, held: Floats
) -> None:
    """Write by how many times the force that opens a mesh (0) and that closes it (1) is larger in its netting.

    Args:
        half_angle: half the opening, rad.
        strain: tension of a bar over its EA.
        stiffness: of bending, 12 EI / (EA b^2).
        rest: half the opening at rest, rad.
        knot: its length over that of a bar.
        turned: whether knots lie across, as in T90.
        held: (2,).
    """
    c, s = math.cos(half_angle), math.sin(half_angle)
    g = max(strain, LEAST_STRAIN)
    bent = stiffness * (half_angle - rest)
    load_along, load_across = 2.0 * (g * c - bent * s), 2.0 * (g * s + bent * c)
    knot_turns = 0.0
    if knot > 0.0:
        knot_turns = max(load_across if turned else load_along, 0.0) / knot
    # bars 1 and 2: stretched by 1, turned against g, and bent; off the diagonal they differ in sign
    xx, yy = c * c + g * s * s + 2.0 * bent * s * c, s * s + g * c * c - 2.0 * bent * s * c
    xy = (1.0 - g) * s * c - bent * (c * c - s * s)
    across, along = 0.0, 0.0
    for i in range(WAVES):
        theta1, weight1 = _wave(i)
        for j in range(2 * WAVES):
            theta2, weight2 = _wave(j)
            dxx, dyy, dxy = _stiffness(theta1, theta2, c, s, xx, yy, xy, stiffness, knot_turns, knot > 0.0, turned)
            determinant = dxx * dyy - dxy.real**2 - dxy.imag**2
            if determinant > 0.0:
                weight = 2.0 * weight1 * weight2 / determinant
                across += weight * 2.0 * (1.0 - math.cos(theta1 - theta2)) * dxx
                along += weight * 2.0 * (1.0 - math.cos(theta1 + theta2)) * dyy
    # a mesh alone: what its diagonals 2 sin(phi) and 2 cos(phi) change by under a unit force
    turning = load_along / c + 2.0 * stiffness * (1.0 + (half_angle - rest) * s / c)
    held[0] = max(2.0 * c * c / turning / across, 1.0) if across > 0.0 else 1.0
    held[1] = max(2.0 * s * s / turning / along, 1.0) if along > 0.0 else 1.0


@njit(cache=True, nogil=True)
def _stiffness(
    theta1: float,
    theta2: float,
    c: float,
    s: float,
    xx: float,
    yy: float,
    xy: float,
    bending: float,
    knot_turns: float,
    has_knots: bool,
    turned: bool,
) -> tuple[float, float, complex]:
    """Stiffness of the netting against a wave of u, with the turning of knots w left to itself."""
    wave1, wave2 = complex(math.cos(theta1), math.sin(theta1)), complex(math.cos(theta2), math.sin(theta2))
    u1, u2 = wave1 - 1.0, wave2 - 1.0
    c1, c2 = 2.0 * (1.0 - wave1.real), 2.0 * (1.0 - wave2.real)
    dxx, dyy, dxy = (c1 + c2) * xx, (c1 + c2) * yy, complex((c1 - c2) * xy, 0.0)
    dxw, dyw, dww = 0j, 0j, knot_turns
    w1, w2 = 0j, 0j
    if has_knots:
        w1, w2 = -0.5 * (wave1 + 1.0), (0.5 if turned else -0.5) * (wave2 + 1.0)
        m1, m2 = u1.conjugate() * w1, u2.conjugate() * w2
        if turned:
            dxw, dyw = (m1 + m2) * xx, (m1 - m2) * xy
        else:
            dxw, dyw = (m1 - m2) * xy, (m1 + m2) * yy
        dww += 0.5 * (2.0 + wave1.real + wave2.real) * (xx if turned else yy)
    if bending > 0.0:
        for corner in range(2):
            if turned:  # beside the knot: bar 1 and the bar 2 ahead of it, bar 2 and the bar 1 ahead of it
                f1, f2 = (1.0 + 0j, wave2.conjugate()) if corner == 0 else (wave1.conjugate(), 1.0 + 0j)
            else:  # aft and fore of the knot
                f1, f2 = (1.0 + 0j, 1.0 + 0j) if corner == 0 else (wave1.conjugate(), wave2.conjugate())
            # n1 = (-s, c), n2 = (s, c)
            qx, qy = -s * (f1 * u1 + f2 * u2), c * (f1 * u1 - f2 * u2)
            qw = -s * f1 * w1 - s * f2 * w2 if turned else c * f1 * w1 - c * f2 * w2
            dxx += 0.25 * bending * (qx.real**2 + qx.imag**2)
            dyy += 0.25 * bending * (qy.real**2 + qy.imag**2)
            dxy += 0.25 * bending * qx.conjugate() * qy
            dxw += 0.25 * bending * qx.conjugate() * qw
            dyw += 0.25 * bending * qy.conjugate() * qw
            dww += 0.25 * bending * (qw.real**2 + qw.imag**2)
    if has_knots and dww > 0.0:
        dxx -= (dxw.real**2 + dxw.imag**2) / dww
        dyy -= (dyw.real**2 + dyw.imag**2) / dww
        dxy -= dxw * dyw.conjugate() / dww
    return dxx, dyy, dxy


@njit(cache=True, nogil=True)
def _wave(i: int) -> tuple[float, float]:
    """Phase from bar to bar, in (0, 2 pi), and its weight: dense near 0, where netting gives way most."""
    x = (i + 0.5) * math.pi / WAVES
    return x - math.sin(x), (1.0 - math.cos(x)) / (2.0 * WAVES)
