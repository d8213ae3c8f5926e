"""A level seabed without friction that carries what lies on it: force, tangent and bound, kernels.

A node at the depth e below it is pushed up by k e, k its own stiffness, so large that what lies there sinks in by a
small share of the depth only; above it nothing pushes.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats


class Seabed(NamedTuple):
    """A level plane."""

    height: float
    """Its z, m."""
    stiffness: Floats
    """N/m of every node, (n,); empty where there is no seabed."""


def no_seabed() -> Seabed:
    """Water without a bottom."""
    return Seabed(0.0, np.zeros(0))


@njit(cache=True)
def add_force(position: Floats, seabed: Seabed, force: Floats) -> None:
    """Add the seabed's push to the nodal forces, N."""
    for node in range(len(seabed.stiffness)):
        sunk = seabed.height - position[node, 2]
        if sunk > 0.0:
            force[node, 2] += seabed.stiffness[node] * sunk


@njit(cache=True)
def add_tangent(position: Floats, seabed: Seabed, pattern: Pattern, blocks: Floats) -> None:
    """Add the seabed's part to the tangent."""
    for node in range(len(seabed.stiffness)):
        if position[node, 2] < seabed.height:
            blocks[pattern.diagonal[node], 2, 2] += seabed.stiffness[node]


@njit(cache=True)
def add_bound(position: Floats, seabed: Seabed, bound: Floats) -> None:
    """Add the seabed's part to the bound on each node's row of the stiffness, N/m, whether it touches or not."""
    for node in range(len(seabed.stiffness)):
        bound[node] += seabed.stiffness[node]
