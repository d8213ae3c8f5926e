"""Contact in a step of motion: gaps that may not close below an aim, beside the bars that may not grow: kernels.

A pair of parts of a net with the nearest points r = sum of w_i x_i apart has the gap d = |r|, whose gradient by node i
is w_i r / d. Like a bar, whose length has an upper bound, it has the row S = -dd/dx in the system for the tensions
(``mechanics.rigid``), and its push N >= 0 on its four nodes is -S^T N, without net force or moment.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.contact import Contact, room, write_corners
from codend.mechanics.nearest import nearest
from codend.net.net import Floats, Ints


@njit(cache=True, error_model="numpy")
def write_gaps(position: Floats, contact: Contact, gap: Floats, gradient: Floats) -> None:
    """Write the gap of every pair, m, (k,), and S at its four nodes, (k, 4, 3)."""
    found = room()
    for pair in range(len(contact.kind)):
        write_corners(position, contact.node, contact.image, contact.rotations, pair, found.corner)
        _, square = nearest(contact.kind[pair], found)
        gap[pair] = np.sqrt(square)
        for i in range(4):
            for a in range(3):
                gradient[pair, i, a] = -found.weight[i] * found.apart[a] / gap[pair] if square > 0.0 else 0.0


@njit(cache=True)
def closing(node: Ints, gradient: Floats, move: Floats, closed: Floats) -> None:
    """Write by how much a move of the nodes, (n, 3), closes every gap to first order, m, (k,)."""
    for pair in range(len(closed)):
        total = 0.0
        for i in range(4):
            for a in range(3):
                total += gradient[pair, i, a] * move[node[pair, i], a]
        closed[pair] = total


@njit(cache=True)
def add_pushes(node: Ints, gradient: Floats, push: Floats, force: Floats) -> None:
    """Add -S^T N to nodal forces, (n, 3)."""
    for pair in range(len(push)):
        for i in range(4):
            for a in range(3):
                force[node[pair, i], a] -= push[pair] * gradient[pair, i, a]
