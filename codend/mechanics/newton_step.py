"""Newton's method on shape and force densities together: kernels.

Unknowns are the free coordinates x and the force density q of every bar. A bar is taut where q + w (gap - q / EA) > 0, gap =
1/l0 - 1/l, for any w > 0 (in newtons); then gap = q / EA must hold, else q = 0: together that is the law of twine
that carries no compression (a semismooth complementarity problem). The densities are eliminated from the linear system bar by bar,
which leaves the nodes' coordinates only. For that an inextensible bar is given a compliance so small, that of ``STIFFEST``
times the reference tension, that it changes nothing but the last digits of a step; the lengths themselves are held exactly,
since each step corrects the gap that is left.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from codend.mechanics.arrays import Loading, Structure
from codend.mechanics.bars import add_bar_forces, bar_vector
from codend.mechanics.images import add_turned_back, turned
from codend.mechanics.pressure import fill
from codend.mechanics.relaxation import add_loads, out_of_balance
from codend.mechanics.tangent import Pattern, add_bar_tangent
from codend.mechanics.tangent_front import front_band, load_by_share, share_gradient
from codend.mechanics.tangent_loads import add_drag_tangent, add_pressure_tangent
from codend.net import Floats

STIFFEST = 1e8
SWITCH = 0.1
LENGTH_WEIGHT = 10.0
"""Force, in units of the reference tension, that a bar's strain of 1 counts as in the merit."""


class State(NamedTuple):
    """A shape with its tensions, and what is left of them out of balance."""

    position: Floats
    density: Floats
    """Force densities q, N/m, (m,); exactly 0 in slack bars."""
    gap: Floats
    """1/l0 - 1/l - q / EA of the bars that count as taut, 0 for the others, 1/m, (m,)."""
    length: Floats
    share: Floats
    force: Floats
    """Out-of-balance force of the nodes, N, (n, 3)."""
    load: Floats
    marks: Floats
    """Merit, residual, axial imbalance, length error, 1 if the catch fits."""


class Step(NamedTuple):
    """Linearisation at a state, and the step it asks for."""

    blocks: Floats
    """Tangent, (b, 3, 3)."""
    right: Floats
    """Right side, and the loads by the share of the front's band, (2, n, 3)."""
    gradient: Floats
    """Derivative of that share, (n, 3)."""
    move: Floats
    """Change of the positions, (n, 3)."""
    change: Floats
    """Change of the force densities, (m,)."""
    hardening: Floats
    """(dq/dl) / l of the taut bars, N/m3, (m,)."""


def empty_state(structure: Structure) -> State:
    """Arrays for a state of a net."""
    nodes, bars = len(structure.free), len(structure.first)
    at_nodes, at_bars = (nodes, 3), (bars,)
    return State(
        np.zeros(at_nodes),
        np.zeros(at_bars),
        np.zeros(at_bars),
        np.zeros(at_bars),
        np.zeros(len(structure.band_meshes)),
        np.zeros(at_nodes),
        np.zeros(at_nodes),
        np.zeros(5),
    )


def empty_step(structure: Structure, pattern: Pattern) -> Step:
    """Arrays for a step of a net."""
    nodes, bars = len(structure.free), len(structure.first)
    return Step(
        np.zeros((len(pattern.row), 3, 3)),
        np.zeros((2, nodes, 3)),
        np.zeros((nodes, 3)),
        np.zeros((nodes, 3)),
        np.zeros(bars),
        np.zeros(bars),
    )


@njit(cache=True, error_model="numpy")
def measure(structure: Structure, loading: Loading, tension: float, state: State) -> None:
    """Cut the density of bars that are slack, and write all that follows from positions and densities.

    The merit is the root of the sum of the squares of the free out-of-balance forces and of the bars' strain errors
    times ``LENGTH_WEIGHT`` x ``tension`` (or the bar's own stiffness if less).
    """
    position, density = state.position, state.density
    merit, worst = 0.0, 0.0
    for bar in range(len(density)):
        dx, dy, dz = bar_vector(position, structure.first[bar], structure.second[bar], structure.image[bar], structure.rotations)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        rest, flexibility = structure.length[bar], structure.flexibility[bar]
        weight = 1.0 / max(flexibility, 1.0 / (LENGTH_WEIGHT * tension))
        gap = 1.0 / rest - 1.0 / max(length, 1e-6 * rest) - flexibility * density[bar]
        if density[bar] + min(weight, SWITCH * tension) * gap <= 0.0:
            density[bar] = gap = 0.0
        state.length[bar], state.gap[bar] = length, gap
        error = abs(gap) * length
        worst = max(worst, error)
        merit += (weight * error) ** 2
    fits = fill(position, structure, loading, state.share)
    load, force = state.load, state.force
    load[:] = 0.0
    add_loads(position, structure, loading, state.share, load)
    force[:] = load
    add_bar_forces(position, structure, density, force)
    for node in range(len(force)):
        for i in range(3):
            merit += structure.free[node, i] * force[node, i] ** 2
    residual, imbalance = out_of_balance(structure, force, load)
    marks = state.marks
    marks[0], marks[1], marks[2], marks[3], marks[4] = np.sqrt(merit), residual, imbalance, worst, 1.0 if fits else 0.0


@njit(cache=True, error_model="numpy")
def right_side(structure: Structure, here: State, there: State, step: Step) -> None:
    """Write the first right side: what is out of balance in ``there``, by the linearisation in ``here``."""
    right = step.right[0]
    right[:] = there.force
    for bar in range(len(there.gap)):
        if step.hardening[bar] == 0.0 or there.gap[bar] == 0.0:
            continue
        q = there.gap[bar] * step.hardening[bar] * here.length[bar] ** 3
        dx, dy, dz = bar_vector(here.position, structure.first[bar], structure.second[bar], structure.image[bar], structure.rotations)
        first, second, image = structure.first[bar], structure.second[bar], structure.image[bar]
        right[first, 0] += q * dx
        right[first, 1] += q * dy
        right[first, 2] += q * dz
        add_turned_back(right, second, -q * dx, -q * dy, -q * dz, image, structure.rotations)


@njit(cache=True, error_model="numpy")
def linearise(
    structure: Structure, loading: Loading, pattern: Pattern, tension: float, shift: float, state: State, step: Step
) -> int:
    """Write tangent and right sides at a state, shifted by ``shift`` times a bound on the taut net's own stiffness.

    Returns:
        the number of right sides: 2 if the front's share follows the net.
    """
    position, density, gap = state.position, state.density, state.gap
    blocks, hardening = step.blocks, step.hardening
    blocks[:] = 0.0
    for bar in range(len(density)):
        hardening[bar] = 0.0
        if density[bar] != 0.0 or gap[bar] != 0.0:
            compliance = max(structure.flexibility[bar], 1.0 / (STIFFEST * tension))
            hardening[bar] = 1.0 / (compliance * state.length[bar] ** 3)
    right_side(structure, state, state, step)
    add_bar_tangent(position, structure, pattern, density, hardening, blocks)
    add_drag_tangent(position, structure, loading, pattern, state.share, blocks)
    add_pressure_tangent(position, structure, loading, pattern, state.share, blocks)
    if shift > 0.0:
        for bar in range(len(density)):
            stiffness = shift * tension / structure.length[bar]
            for i in range(3):
                blocks[pattern.diagonal[structure.first[bar]], i, i] += stiffness
                blocks[pattern.diagonal[structure.second[bar]], i, i] += stiffness
    band = front_band(loading, state.share)
    if band < 0:
        return 1
    share_gradient(position, structure, loading, state.share, band, step.gradient)
    load_by_share(position, structure, loading, band, step.right[1])
    return 2


@njit(cache=True, error_model="numpy")
def combine(solved: Floats, step: Step, move: Floats) -> float:
    """Write the move of the nodes from the solutions of the linear system (Sherman and Morrison).

    Returns:
        the factor 1 - v . K^-1 u by which the moving front changes the tangent's determinant.
    """
    move[:] = solved[0]
    if len(solved) == 1:
        return 1.0
    along, determinant = 0.0, 1.0
    for node in range(len(move)):
        for i in range(3):
            along += step.gradient[node, i] * solved[0, node, i]
            determinant -= step.gradient[node, i] * solved[1, node, i]
    move += (along / determinant) * solved[1]
    return determinant


@njit(cache=True, error_model="numpy")
def finish_step(structure: Structure, state: State, solved: Floats, step: Step) -> tuple[float, float, float]:
    """Write the step from the solutions of the linear system.

    Returns:
        norm of the move, largest change of a taut bar's vector over its length, and the factor of ``combine``.
    """
    move, change = step.move, step.change
    determinant = combine(solved, step, move)
    largest = 0.0
    for bar in range(len(change)):
        change[bar] = 0.0
        if step.hardening[bar] == 0.0:
            continue
        first, second, image = structure.first[bar], structure.second[bar], structure.image[bar]
        dx, dy, dz = bar_vector(state.position, structure.first[bar], structure.second[bar], structure.image[bar], structure.rotations)
        vy, vz = turned(move[second, 1], move[second, 2], image, structure.rotations)
        vx, vy, vz = move[second, 0] - move[first, 0], vy - move[first, 1], vz - move[first, 2]
        length = state.length[bar]
        change[bar] = step.hardening[bar] * (state.gap[bar] * length**3 + dx * vx + dy * vy + dz * vz)
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
def simplified_move(solved: Floats, size: float, step: Step, move: Floats) -> tuple[float, float]:
    """Write the move that the old tangent asks for at the new state.

    Returns:
        its norm, and the norm of its difference from the (1 - size) of the step that is left.
    """
    combine(solved, step, move)
    squares, differences = 0.0, 0.0
    for node in range(len(move)):
        for i in range(3):
            squares += move[node, i] ** 2
            differences += (move[node, i] - (1.0 - size) * step.move[node, i]) ** 2
    return np.sqrt(squares), np.sqrt(differences)


@njit(cache=True, error_model="numpy")
def take(
    structure: Structure, loading: Loading, tension: float, size: float, state: State, step: Step, new: State
) -> None:
    """Write the state that a fraction ``size`` of the step leads to."""
    new.position[:] = state.position + size * step.move
    new.density[:] = state.density + size * step.change
    measure(structure, loading, tension, new)
