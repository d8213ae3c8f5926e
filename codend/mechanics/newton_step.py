"""Newton's method on shape and force densities together: kernels.

Unknowns are the free coordinates x and the force density q of every bar, whose law is in ``newton_state``. The
densities are eliminated from the linear system bar by bar, which leaves the nodes' coordinates only. For that an
inextensible bar is given a compliance so small, that of ``STIFFEST`` times the reference tension, that it changes
nothing but the last digits of a step; the lengths themselves are held exactly, since each step corrects the gap that
is left.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics.bars import add_bar_tangent, bar_vector
from codend.mechanics.broyden import PastSteps, no_steps
from codend.mechanics.catch_front import front_band, load_by_share, share_gradient
from codend.mechanics.catch_weight import add_to_rings, force_by_height, height_gradient, rings_gradient
from codend.mechanics.images import add_turned_back
from codend.mechanics.loads import Loading, add_tangent
from codend.mechanics.newton_state import State, measure
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats

STIFFEST = 1e8
MOST_PRODUCTS = 5
"""By which what moves with the front adds to a tangent: its band's share, its height, three parts of a force."""


class Step(NamedTuple):
    """Linearisation at a state, and the step it asks for."""

    blocks: Floats
    """Tangent, (b, 3, 3)."""
    right: Floats
    """Right side, and the loads by what moves with the front, (1 + ``MOST_PRODUCTS``, n, 3): its band's share, its
    height, and the parts of what its rings bear."""
    gradient: Floats
    """Derivatives of these, (``MOST_PRODUCTS``, n, 3)."""
    solved: Floats
    """Solutions for the right sides, (1 + ``MOST_PRODUCTS``, n, 3)."""
    move: Floats
    """Change of the positions, (n, 3)."""
    simplified: Floats
    """The move that the old tangent asks for at a new state, (n, 3)."""
    change: Floats
    """Change of the force densities, (m,)."""
    hardening: Floats
    """(dq/dl) / l of the taut bars, N/m3, (m,)."""
    past: PastSteps


def empty_step(structure: Structure, pattern: Pattern) -> Step:
    """Arrays for a step of a net."""
    nodes, bars = len(structure.free), len(structure.first)
    return Step(
        np.zeros((len(pattern.row), 3, 3)),
        np.zeros((1 + MOST_PRODUCTS, nodes, 3)),
        np.zeros((MOST_PRODUCTS, nodes, 3)),
        np.zeros((1 + MOST_PRODUCTS, nodes, 3)),
        np.zeros((nodes, 3)),
        np.zeros((nodes, 3)),
        np.zeros(bars),
        np.zeros(bars),
        no_steps(nodes, bars),
    )


@njit(cache=True, error_model="numpy")
def right_side(structure: Structure, here: State, there: State, step: Step) -> None:
    """Write the first right side: what is out of balance in ``there``, by the linearisation in ``here``."""
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    right, hardening, gaps, lengths, position = step.right[0], step.hardening, there.gap, here.length, here.position
    left_over = there.force
    for node in range(len(right)):
        for i in range(3):
            right[node, i] = left_over[node, i]
    for bar in range(len(gaps)):
        if hardening[bar] == 0.0 or gaps[bar] == 0.0:
            continue
        q = gaps[bar] * hardening[bar] * lengths[bar] ** 3
        first, second, image = firsts[bar], seconds[bar], images[bar]
        dx, dy, dz = bar_vector(position, first, second, image, rotations)
        right[first, 0] += q * dx
        right[first, 1] += q * dy
        right[first, 2] += q * dz
        add_turned_back(right, second, -q * dx, -q * dy, -q * dz, image, rotations)


@njit(cache=True, error_model="numpy")
def right_sides(structure: Structure, loading: Loading, tension: float, state: State, step: Step) -> int:
    """Write the right sides at a state, and how the bars there harden: all of ``linearise`` but the tangent.

    Returns:
        the number of right sides: one more where the front's share follows the net, four where a catch has weight.
    """
    flexibilities, position = structure.flexibility, state.position
    density, gaps, lengths, hardening = state.density, state.gap, state.length, step.hardening
    for bar in range(len(density)):
        hardening[bar] = 0.0
        if density[bar] != 0.0 or gaps[bar] != 0.0 or structure.is_strut[bar]:
            compliance = max(flexibilities[bar], 1.0 / (STIFFEST * tension))
            hardening[bar] = 1.0 / (compliance * lengths[bar] ** 3)
    right_side(structure, state, state, step)
    catch, share, sides = loading.catch, state.share, 1
    band = front_band(catch, share)
    if band >= 0:
        share_gradient(position, structure, catch, share, band, step.gradient[0])
        load_by_share(position, structure, loading.water, catch, share, band, step.right[1])
        sides = 2
    if catch.weight_density != 0.0:
        height_gradient(catch, share, step.gradient[sides - 1])
        force_by_height(position, structure, catch, share, step.right[sides])
        rings_gradient(position, structure, catch, share, step.gradient[sides : sides + 3])
        step.right[sides + 1 : sides + 4] = 0.0
        add_to_rings(catch, share, (1.0, 0.0, 0.0), step.right[sides + 1])
        add_to_rings(catch, share, (0.0, 1.0, 0.0), step.right[sides + 2])
        add_to_rings(catch, share, (0.0, 0.0, 1.0), step.right[sides + 3])
        sides += 4
    return sides


@njit(cache=True, error_model="numpy")
def linearise(
    structure: Structure,
    loading: Loading,
    pattern: Pattern,
    tension: float,
    shift: float,
    state: State,
    step: Step,
) -> int:
    """Write tangent and right sides at a state, shifted by ``shift`` times a bound on the taut net's own stiffness.

    Returns:
        the number of right sides, as ``right_sides`` has it.
    """
    firsts, seconds, rests = structure.first, structure.second, structure.length
    position, density, blocks, diagonal = state.position, state.density, step.blocks, pattern.diagonal
    sides = right_sides(structure, loading, tension, state, step)
    blocks[:] = 0.0
    add_bar_tangent(position, structure, pattern, density, step.hardening, blocks)
    add_tangent(position, structure, loading, pattern, state.share, blocks)
    if shift > 0.0:
        for bar in range(len(density)):
            stiffness = shift * tension / rests[bar]
            for i in range(3):
                blocks[diagonal[firsts[bar]], i, i] += stiffness
                blocks[diagonal[seconds[bar]], i, i] += stiffness
    return sides


@njit(cache=True, error_model="numpy")
def combine(solved: Floats, step: Step, move: Floats) -> float:
    """Write the move of the nodes from the solutions of the linear system (Sherman, Morrison and Woodbury).

    Returns:
        the factor det(I - V^T K^-1 U) by which the moving front changes the tangent's determinant.
    """
    for node in range(len(move)):
        for i in range(3):
            move[node, i] = solved[0, node, i]
    count = len(solved) - 1
    if count == 0:
        return 1.0
    by, corner = np.empty(count), np.empty((count, count))
    for row in range(count):
        by[row] = _along(step.gradient[row], solved[0])
        for column in range(count):
            corner[row, column] = (1.0 if row == column else 0.0) - _along(step.gradient[row], solved[1 + column])
    determinant = _solve_in_place(corner, by)
    for number in range(count):
        for node in range(len(move)):
            for i in range(3):
                move[node, i] += by[number] * solved[1 + number, node, i]
    return determinant


@njit(cache=True, error_model="numpy")
def _solve_in_place(matrix: Floats, right: Floats) -> float:
    """Solve a small system in the place of its right side by elimination; returns the determinant."""
    count, determinant = len(right), 1.0
    for step in range(count):
        pivot = step
        for row in range(step + 1, count):
            if abs(matrix[row, step]) > abs(matrix[pivot, step]):
                pivot = row
        if pivot != step:
            for column in range(count):
                matrix[step, column], matrix[pivot, column] = matrix[pivot, column], matrix[step, column]
            right[step], right[pivot] = right[pivot], right[step]
            determinant = -determinant
        determinant *= matrix[step, step]
        for row in range(count):
            if row == step:
                continue
            factor = matrix[row, step] / matrix[step, step]
            for column in range(step, count):
                matrix[row, column] -= factor * matrix[step, column]
            right[row] -= factor * right[step]
    for row in range(count):
        right[row] /= matrix[row, row]
    return determinant


@njit(cache=True, error_model="numpy")
def _along(gradient: Floats, move: Floats) -> float:
    """Change of what has this gradient under a move of the nodes."""
    change = 0.0
    for node in range(len(move)):
        for i in range(3):
            change += gradient[node, i] * move[node, i]
    return change


@njit(cache=True, error_model="numpy")
def finish_step(
    structure: Structure, here: State, there: State, solved: Floats, step: Step
) -> tuple[float, float, float]:
    """Write the step from ``there`` out of the solutions of the linear system that was set up ``here``.

    Returns:
        norm of the move, largest change of a taut bar's vector over its length, and the factor of ``combine``.
    """
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    position, lengths, gaps, hardening = here.position, here.length, there.gap, step.hardening
    move, change = step.move, step.change
    determinant = combine(solved, step, move)
    largest = 0.0
    for bar in range(len(change)):
        change[bar] = 0.0
        if hardening[bar] == 0.0:
            continue
        first, second, image, length = firsts[bar], seconds[bar], images[bar], lengths[bar]
        dx, dy, dz = bar_vector(position, first, second, image, rotations)
        vx, vy, vz = bar_vector(move, first, second, image, rotations)
        change[bar] = hardening[bar] * (gaps[bar] * length**3 + dx * vx + dy * vy + dz * vz)
        largest = max(largest, np.sqrt(vx * vx + vy * vy + vz * vz) / length)
    return norm(move), largest, determinant


@njit(cache=True, error_model="numpy")
def norm(values: Floats) -> float:
    """Euclidean norm of an (n, 3) array."""
    squares = 0.0
    for node in range(len(values)):
        for i in range(3):
            squares += values[node, i] ** 2
    return np.sqrt(squares)


@njit(cache=True, error_model="numpy")
def simplified_move(solved: Floats, size: float, step: Step) -> tuple[float, float]:
    """Write the move that the old tangent asks for at the new state.

    Returns:
        its norm, and the norm of its difference from the (1 - size) of the step that is left.
    """
    move, whole = step.simplified, step.move
    combine(solved, step, move)
    squares, differences = 0.0, 0.0
    for node in range(len(move)):
        for i in range(3):
            squares += move[node, i] ** 2
            differences += (move[node, i] - (1.0 - size) * whole[node, i]) ** 2
    return np.sqrt(squares), np.sqrt(differences)


@njit(cache=True, error_model="numpy")
def take(
    structure: Structure,
    loading: Loading,
    tension: float,
    switch: float,
    barrier: float,
    size: float,
    here: State,
    there: State,
    step: Step,
    new: State,
) -> None:
    """Write the state a fraction ``size`` of the step away from ``there``, and its right side by ``here``'s tangent."""
    position, density = new.position, new.density
    last_position, last_density, move, change = there.position, there.density, step.move, step.change
    for node in range(len(position)):
        for i in range(3):
            position[node, i] = last_position[node, i] + size * move[node, i]
    for bar in range(len(density)):
        density[bar] = last_density[bar] + size * change[bar]
    measure(structure, loading, tension, switch, barrier, new)
    right_side(structure, here, new, step)
