"""How far a mesh yields to a fish that pushes, from its tension, the stiffness of its twine and the netting around it.

A mesh alone is a rhombus of four clamped bars of length b under the load P along the netting and Q across it. At the
half opening angle phi its energy is -2 b (P cos phi + Q sin phi) + 24 EI (phi - phi0)^2 / b, so that (derived; 24 EI /
b^2 = B)

    Q = P tan phi + B (phi - phi0) / cos phi,   P = 2 T cos phi - B (phi - phi0) sin phi,

T the computed tension of its bars. A fish that pushes its two knots across the netting apart to phi' > phi, or those
along it to phi' < phi, needs the force

    across   H_a [P (tan phi' - tan phi) + B ((phi' - phi0) / cos phi' - (phi - phi0) / cos phi)]
    along    H_l [Q cos phi' - P sin phi' - B (phi' - phi0)] / sin phi'.

The first is that of ``codend.bag.measures.opening_force`` for H_a = 1, a mesh alone. In the net its neighbours must
give way too, and can only where twine stretches: H is the force that moves the two knots of one mesh in an endless
plane netting apart over that of a mesh alone, both for a small pull (derived: the sum over waves of the netting's
inverse stiffness, bars stretching with EA, turning against T and bending with EI). It grows as sqrt(EA / T); taken as
the same for large pulls it is within a quarter of a solved net in which the mesh is really pulled open
(``python -m validation.yielding_meshes``). Twine without EA has H = 1: such meshes yield as if they were alone.

A fish of length L pushes with at most F1 (L / L1)^n, and with no more than it needs. Its section, less what its shares
of compression give way, takes the opening within its reach that suits it best. The longest fish that passes is

    max over phi' of L(phi'),   L the longest through the rigid mesh,   where the force to phi' <= F1 (L(phi') / L1)^n;

shorter ones of its shape are taken to pass as well. Bars stay straight: with no limit to its push a fish passes up to
the largest section that any opening lets through, an ellipse up to m_i / (k_h + k_w).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codend.selectivity.escape.neighbour_kernels import all_neighbours_hold

Floats = NDArray[np.float64]


def load_along(tension_n: ArrayLike, half_angle_rad: ArrayLike, bending_n: ArrayLike, rest_rad: ArrayLike) -> Floats:
    """Load P along the netting that a mesh carries, N; arguments are broadcast. See the heading, ``bending_n`` is B."""
    half, tension = np.asarray(half_angle_rad, dtype=float), np.asarray(tension_n, dtype=float)
    turned = half - np.asarray(rest_rad, dtype=float)
    return np.asarray(2.0 * tension * np.cos(half) - np.asarray(bending_n) * turned * np.sin(half))


def held_by_neighbours(
    tension_n: Floats,
    half_angle_rad: Floats,
    axial_stiffness_n: Floats,
    bending_n: Floats,
    rest_rad: Floats,
    knot_over_bar: Floats,
    knots_across: NDArray[np.bool_],
) -> tuple[Floats, Floats]:
    """H_a and H_l of meshes, (k,) each; 1 where ``axial_stiffness_n`` is infinite. Arguments (k,).

    The netting is taken as flat and even around each mesh, its knots as lumps.
    """
    held = np.ones((len(tension_n), 2))
    one = np.isfinite(axial_stiffness_n)
    if one.any():
        ea = axial_stiffness_n[one]
        bending = 0.5 * bending_n[one] / ea
        netting = (bending, rest_rad[one], knot_over_bar[one], knots_across[one])
        held[one] = all_neighbours_hold(half_angle_rad[one], tension_n[one] / ea, *netting)
    return held[:, 0], held[:, 1]
