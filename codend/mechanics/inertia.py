"""What resists a net's being moved, at the end of a step of its motion: force and tangent, kernels.

With v = r (x - x') the velocities at its end, x' where the nodes set out from, each is held back by M (v - v') r. The
net at the step's end is then in equilibrium under its loads and this.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats


class Inertia(NamedTuple):
    """A step of a net's motion; arrays of no nodes for a net at rest."""

    rate: float
    """r, one over the step, 1/s."""
    mass: Floats
    """M, kg, (n, 3, 3)."""
    origin: Floats
    """x', m, (n, 3)."""
    velocity: Floats
    """v', m/s, (n, 3)."""


def at_rest() -> Inertia:
    """No motion."""
    return Inertia(0.0, np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros((0, 3)))


@njit(cache=True)
def velocities(position: Floats, inertia: Inertia) -> Floats:
    """Of the nodes at the end of the step, m/s, (n, 3); (0, 3) at rest."""
    found = np.empty_like(inertia.origin)
    for node in range(len(found)):
        for i in range(3):
            found[node, i] = inertia.rate * (position[node, i] - inertia.origin[node, i])
    return found


@njit(cache=True)
def add_force(velocity: Floats, inertia: Inertia, force: Floats) -> None:
    """Add what the masses resist with to the nodal forces, N; ``velocity`` is what ``velocities`` says."""
    for node in range(len(velocity)):
        for i in range(3):
            for j in range(3):
                change = velocity[node, j] - inertia.velocity[node, j]
                force[node, i] -= inertia.rate * inertia.mass[node, i, j] * change


@njit(cache=True)
def add_tangent(inertia: Inertia, pattern: Pattern, blocks: Floats) -> None:
    """Add the masses' part to the tangent."""
    for node in range(len(inertia.mass)):
        for i in range(3):
            for j in range(3):
                blocks[pattern.diagonal[node], i, j] += inertia.rate**2 * inertia.mass[node, i, j]
