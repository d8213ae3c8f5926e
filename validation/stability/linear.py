"""Linear theory about an equilibrium: the dense tangent, and what follows from it for steps and for tolerances."""

import numpy as np

from catch_models.filling import enclosed_volume
from codend.mechanics import drag, pressure
from codend.mechanics.bars import add_bar_tangent, bar_lengths
from codend.mechanics.catch_front import band_geometry, row_positions
from codend.mechanics.problem import Problem
from codend.mechanics.tangent import pattern_of
from codend.net.net import Floats
from codend.solvers.outcome import Solution
from validation.reference import bar_vector, turned

RIGID = 1e7
"""Axial stiffness that stands in for inextensible twine, in units of the mean tension."""


def free_coordinates(problem: Problem) -> np.ndarray:
    """Places of the free coordinates among all 3 n."""
    return np.flatnonzero(~problem.net.fixed.ravel())


def dense_tangent(
    problem: Problem, positions: Floats, density: Floats, hardening: Floats, share: Floats | None
) -> Floats:
    """Stiffness -dF/dx of the free coordinates; loads stand still where ``share`` is None.

    Args:
        problem: a net without bending stiffness, its catch given in filled meshes.
        positions: (n, 3).
        density: force density q of the bars, N/m, (m,).
        hardening: (dq/dl) / l of the bars, N/m3, (m,).
        share: the catch's share of each band, (bands,).
    """
    structure, loading = problem.structure, problem.loading
    pattern = pattern_of(structure)
    blocks = np.zeros((len(pattern.row), 3, 3))
    add_bar_tangent(positions, structure, pattern, density, hardening, blocks)
    if share is not None:
        at_rest = np.zeros((0, 3)), 0.0
        drag.add_tangent(positions, *at_rest, structure, loading.water, loading.catch, pattern, share, blocks)
        pressure.add_tangent(positions, structure, loading.catch, pattern, share, blocks)
    size = 3 * len(positions)
    whole = np.zeros((size, size))
    rows = 3 * pattern.row[:, None, None] + np.arange(3)[None, :, None]
    columns = 3 * pattern.column[:, None, None] + np.arange(3)[None, None, :]
    np.add.at(whole, (rows, columns), blocks)
    free = free_coordinates(problem)
    return whole[np.ix_(free, free)]


def _rigidity(problem: Problem, solution: Solution) -> Floats:
    """Axial stiffness of the taut bars, N, 0 for slack ones, (m,)."""
    stiffest = RIGID * float(solution.bar_tension.mean())
    return np.where(solution.bar_tension > 0.0, 1.0 / np.maximum(problem.net.bar_flexibility, 1.0 / stiffest), 0.0)


def tangent_of(problem: Problem, solution: Solution) -> Floats:
    """``dense_tangent`` of an equilibrium by the law of the twine."""
    positions = np.ascontiguousarray(solution.positions)
    length = lengths_of(problem, positions)
    hardening = _rigidity(problem, solution) / length**3
    return dense_tangent(problem, positions, solution.bar_tension / length, hardening, solution.share)


def is_stable(problem: Problem, solution: Solution) -> bool:
    """Whether every small move of an equilibrium is pushed back: all eigenvalues of the tangent in the right half."""
    return bool(np.linalg.eigvals(tangent_of(problem, solution)).real.min() > 0.0)


def lengths_of(problem: Problem, positions: Floats) -> Floats:
    """Lengths of the bars, m, (m,)."""
    length = np.empty(len(problem.net.bars))
    bar_lengths(np.ascontiguousarray(positions), problem.structure, length)
    return length


def drag_and_volume(problem: Problem, positions: Floats, share: Floats) -> tuple[float, float]:
    """Axial load on the whole net, N, and volume behind the catch's front, m3."""
    structure, catch = problem.structure, problem.loading.catch
    load = np.zeros_like(positions)
    drag.add_force(positions, np.zeros((0, 3)), structure, problem.loading.water, catch, share, load)
    pressure.add_force(positions, structure, catch, share, load)
    area, moment, rows = np.empty(problem.bands), np.empty(problem.bands), np.empty(problem.bands + 1)
    band_geometry(positions, structure, catch, area, moment)
    row_positions(positions, catch, rows)
    return float(load[:, 0].sum() * problem.net.order), float(enclosed_volume(rows, area, moment, share))


def worst_responses(problem: Problem, solution: Solution) -> tuple[Floats, Floats]:
    """Largest changes of drag (N), volume (m3) and any coordinate (m), to first order, about an equilibrium.

    The first array is what out-of-balance forces of one newton in the worst direction at every free node may do, the
    second what departures of one in every taut bar's strain may do, each with its worst sign: the sums of the moduli of
    the answers to each.
    """
    positions, share = np.ascontiguousarray(solution.positions), solution.share
    rigidity = _rigidity(problem, solution)
    free = free_coordinates(problem)
    answers = np.linalg.inv(tangent_of(problem, solution))
    gradients = np.vstack([_gradients(problem, positions, share)[:, free] @ answers, answers])
    node_of = free // 3
    nodes = np.unique(node_of)
    forces = np.stack([np.linalg.norm(gradients[:, node_of == node], axis=1) for node in nodes], axis=1).sum(axis=1)
    strains = np.zeros(len(gradients))
    for bar in np.flatnonzero(rigidity):
        # a bar longer than its law by a strain e pushes its ends apart as a force EA e would
        push = _ends_apart(problem, positions, int(bar))[free]
        strains += np.abs(gradients @ push) * rigidity[bar]
    worst = [np.array([found[0], found[1], found[2:].max()]) for found in (forces, strains)]
    return worst[0], worst[1]


def _gradients(problem: Problem, positions: Floats, share: Floats) -> Floats:
    """Derivatives of drag and volume by all coordinates, central differences, (2, 3 n)."""
    step = 1e-5 * float(problem.net.bar_length.mean())
    found = np.zeros((2, positions.size))
    for place in range(positions.size):
        moved = [positions.copy(), positions.copy()]
        for shape, sign in zip(moved, (1.0, -1.0), strict=True):
            shape.reshape(-1)[place] += sign * step
        high, low = (np.array(drag_and_volume(problem, shape, share)) for shape in moved)
        found[:, place] = (high - low) / (2.0 * step)
    return found


def _ends_apart(problem: Problem, positions: Floats, bar: int) -> Floats:
    """Unit forces on the ends of a bar that push them apart, (3 n,)."""
    net = problem.net
    i, j = net.bars[bar]
    along = bar_vector(net, positions, bar)
    along /= np.linalg.norm(along)
    force = np.zeros_like(positions)
    force[i] -= along
    force[j] += turned(along, -net.bar_image[bar], net.order)
    return force.ravel()
