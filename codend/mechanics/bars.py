"""Tension in the bars: law, force and tangent, kernels.

A taut bar obeys the law  1/l0 - 1/l = q / EA,  with l0 its length without load, l its length and q = T / l its force
density: T = EA (l - l0) / l0, and l = l0 where the bar is inextensible. A slack bar carries nothing. Both come out of
one augmented law, in which c (in newtons) is a penalty and m a multiplier:

    q = max(0, (m + c (1/l0 - 1/l)) / (1 + c / EA))

A strut obeys the law of a taut bar however short it is, without the max: 1/l0 - 1/l falls without bound as l goes to 0.

The law holds exactly where q = m, so the multipliers are set to q again and again. Bars softer than the penalty need no
multiplier: c is then taken as infinite, which gives the elastic law itself.
"""

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.images import add_turned_back, turned
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern, add_bar_blocks
from codend.net.net import Floats


@njit(cache=True)
def augmented_law(structure: Structure, penalty: float, relief: Floats, gain: Floats) -> None:
    """Write q's derivatives with respect to multiplier (``relief``) and to 1/l0 - 1/l (``gain``, N), each (m,)."""
    flexibilities = structure.flexibility
    for bar in range(len(flexibilities)):
        flexibility = flexibilities[bar]
        if flexibility * penalty >= 1.0:
            relief[bar] = 0.0
            gain[bar] = 1.0 / flexibility
        else:
            relief[bar] = 1.0 / (1.0 + penalty * flexibility)
            gain[bar] = penalty * relief[bar]


@njit(cache=True)
def bar_vector(position: Floats, first: int, second: int, image: int, rotations: Floats) -> tuple[float, float, float]:
    """Vector from the first to the second end."""
    y, z = turned(position[second, 1], position[second, 2], image, rotations)
    return position[second, 0] - position[first, 0], y - position[first, 1], z - position[first, 2]


@njit(cache=True)
def add_bar_forces(position: Floats, structure: Structure, density: Floats, force: Floats) -> None:
    """Add to the nodal forces the pull of bars with force densities ``density`` (N/m), (m,)."""
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    for bar in range(len(firsts)):
        q = density[bar]
        if q == 0.0:
            continue
        first, second, image = firsts[bar], seconds[bar], images[bar]
        dx, dy, dz = bar_vector(position, first, second, image, rotations)
        force[first, 0] += q * dx
        force[first, 1] += q * dy
        force[first, 2] += q * dz
        add_turned_back(force, second, -q * dx, -q * dy, -q * dz, image, rotations)


@njit(cache=True)
def bar_lengths(position: Floats, structure: Structure, length: Floats) -> None:
    """Write the length of every bar, m, (m,)."""
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    for bar in range(len(firsts)):
        dx, dy, dz = bar_vector(position, firsts[bar], seconds[bar], images[bar], rotations)
        length[bar] = np.sqrt(dx * dx + dy * dy + dz * dz)


@njit(cache=True)
def bar_products(position: Floats, move: Floats, structure: Structure, product: Floats) -> None:
    """Write the scalar product of every bar with the move of its second end against its first, m2, (m,)."""
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    for bar in range(len(firsts)):
        dx, dy, dz = bar_vector(position, firsts[bar], seconds[bar], images[bar], rotations)
        vx, vy, vz = bar_vector(move, firsts[bar], seconds[bar], images[bar], rotations)
        product[bar] = dx * vx + dy * vy + dz * vz


@njit(cache=True)
def length_error(structure: Structure, length: Floats, density: Floats) -> float:
    """Largest departure from the law of the twine, relative to the bar's length.

    A taut bar, or a strut, should be as long as its tension makes it, a slack one no longer than without load.
    """
    worst = 0.0
    rests, flexibilities = structure.length, structure.flexibility
    for bar in range(len(rests)):
        rest = rests[bar]
        if density[bar] > 0.0 or structure.is_strut[bar]:
            tension = density[bar] * length[bar]
            error = abs(length[bar] / rest - 1.0 - tension * flexibilities[bar])
        else:
            error = length[bar] / rest - 1.0
        worst = max(worst, error)
    return worst


def carried(is_strut: NDArray[np.bool_], pulls: Floats) -> Floats:
    """Pulls or force densities of bars, (m,), without the compression that twine, which is no strut, cannot carry."""
    return np.where(is_strut, pulls, np.maximum(pulls, 0.0))


@njit(cache=True, error_model="numpy")
def add_bar_tangent(
    position: Floats, structure: Structure, pattern: Pattern, density: Floats, hardening: Floats, blocks: Floats
) -> None:
    """Add the bars' part: the derivative of their pull q d is q I + k d d^T, with k = (dq/dl) / l.

    ``density`` holds q, N/m, and ``hardening`` k, N/m3, each (m,); k is 0 for bars that are slack or whose q is held.
    """
    h = np.empty((3, 3))
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    slots = pattern.bar_slot
    for bar in range(len(firsts)):
        q, k = density[bar], hardening[bar]
        if q == 0.0 and k == 0.0:
            continue
        image = images[bar]
        dx, dy, dz = bar_vector(position, firsts[bar], seconds[bar], image, rotations)
        h[0, 0], h[0, 1], h[0, 2] = q + k * dx * dx, k * dx * dy, k * dx * dz
        h[1, 0], h[1, 1], h[1, 2] = h[0, 1], q + k * dy * dy, k * dy * dz
        h[2, 0], h[2, 1], h[2, 2] = h[0, 2], h[1, 2], q + k * dz * dz
        add_bar_blocks(blocks, slots, bar, h, -1.0, image, rotations)
