"""Steps with an old tangent, corrected by what the steps before them have shown of it: kernels.

Broyden's method in the form that never builds a matrix (algorithm QNERR: Deuflhard, Newton Methods for Nonlinear
Problems, 2011, section 2.1.4). A step is made of the nodes' moves and the change of the bars' force densities, which
count in its norm as the moves that would turn the bars' forces by as much at the reference tension.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.net.net import Floats

MOST_STEPS = 16
"""With one tangent; each costs two more scalar products than the one before it."""
LARGEST_GROWTH = 10.0
"""Factor by which a step may be made longer; one that would be longer still says that the tangent is too old."""


class PastSteps(NamedTuple):
    """Steps made with the same tangent."""

    moves: Floats
    """Moves of the nodes, (MOST_STEPS, n, 3)."""
    changes: Floats
    """Changes of the force densities, (MOST_STEPS, m)."""
    squares: Floats
    """Squares of their norms, (MOST_STEPS,)."""


def no_steps(nodes: int, bars: int) -> PastSteps:
    """Room for the steps of a net."""
    return PastSteps(np.zeros((MOST_STEPS, nodes, 3)), np.zeros((MOST_STEPS, bars)), np.zeros(MOST_STEPS))


@njit(cache=True, error_model="numpy")
def keep(past: PastSteps, count: int, lengths: Floats, tension: float, move: Floats, change: Floats) -> None:
    """Keep a step as number ``count`` of the past ones; arguments as for ``correct``."""
    kept_move, kept_change = past.moves[count], past.changes[count]
    for node in range(len(move)):
        for i in range(3):
            kept_move[node, i] = move[node, i]
    for bar in range(len(change)):
        kept_change[bar] = change[bar]
    past.squares[count] = _product(move, change, move, change, lengths, tension)


@njit(cache=True, error_model="numpy")
def correct(past: PastSteps, count: int, lengths: Floats, tension: float, move: Floats, change: Floats) -> bool:
    """Turn the step that the old tangent asks for into Broyden's, and keep it as number ``count`` of the past ones.

    Args:
        past: steps 0 .. count - 1, the first of which was kept as it was.
        count: number of this step, 1 or more.
        lengths: of the bars where the tangent was set up, m, (m,).
        tension: reference tension, N.
        move: of the nodes, m, (n, 3); corrected in place.
        change: of the force densities, N/m, (m,); corrected in place.

    Returns:
        False if the past steps say that the tangent is of no more use; the step is not to be made then.
    """
    moves, changes, squares = past.moves, past.changes, past.squares
    for last in range(count):
        along = _product(moves[last], changes[last], move, change, lengths, tension) / squares[last]
        if last == count - 1:
            if not along < 1.0 - 1.0 / LARGEST_GROWTH:
                return False
            _add(along / (1.0 - along), move, change, move, change)
        else:
            _add(along, moves[last + 1], changes[last + 1], move, change)
    keep(past, count, lengths, tension, move, change)
    return True


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _product(
    move: Floats, change: Floats, other: Floats, other_change: Floats, lengths: Floats, tension: float
) -> float:
    total = 0.0
    for node in range(len(move)):
        for i in range(3):
            total += move[node, i] * other[node, i]
    for bar in range(len(change)):
        turn = lengths[bar] * lengths[bar] / tension
        total += turn * change[bar] * turn * other_change[bar]
    return total


@njit(cache=True, error_model="numpy")
def _add(factor: float, move: Floats, change: Floats, to_move: Floats, to_change: Floats) -> None:
    for node in range(len(move)):
        for i in range(3):
            to_move[node, i] += factor * move[node, i]
    for bar in range(len(change)):
        to_change[bar] += factor * change[bar]
