"""Compiled code of the solvers: a band LU, and a step of Newton's method on any net.

The step is written once: plain Python for sparse systems, compiled for banded ones. A sector's step takes about as long
as a call from Python into compiled code, so for banded systems all of it is one kernel. ``advance`` is that kernel's
source and runs as it stands where the system is factorised by a library.
"""

from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from codend.compiled import njit
from codend.mechanics.broyden import MOST_STEPS, correct, keep
from codend.mechanics.loads import Loading
from codend.mechanics.newton_state import State
from codend.mechanics.newton_step import Step, finish_step, linearise, right_sides, simplified_move, take
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats, Ints

FAILED, IN_FIRST, IN_SECOND = range(3)
"""Where the new state is: nowhere, or in the first or second of the spare states."""


NEARBY = 2.5e-5
"""Residual up to which a step with negative pivots is made if it is a good one: where a bag turns about its axis for
nothing a pivot is 0 but for round-off, of either sign, and in steps that are shifted it crawls."""


class Band(NamedTuple):
    """A banded matrix as kernels see it."""

    rows: Floats
    """Entry (i, j) in ``rows[i, half_band + j - i]``, or the factors, (size, 2 half_band + 1)."""
    place: Ints
    """Where each entry of the matrix goes in the flattened rows, -1 for held coordinates."""
    unknown: Ints
    """Number of the unknown of every coordinate, -1 for held ones, (n, coordinates)."""


@njit(cache=True, fastmath={"contract", "reassoc", "nsz"}, error_model="numpy")
def factorise_band(entries: Floats, place: Ints, band: Floats) -> int:
    """Gather a matrix into its band and factorise it in place; number of negative pivots, -1 if it is singular.

    ``band[i, half + j - i]`` holds entry (i, j), later the multipliers of L below the diagonal and U.
    """
    size, width = band.shape
    half = width // 2
    band[:] = 0.0
    flat = band.reshape(-1)
    for entry in range(len(place)):
        if place[entry] >= 0:
            flat[place[entry]] += entries[entry]
    negative = 0
    for k in range(size):
        pivot = band[k, half]
        if pivot == 0.0 or not np.isfinite(pivot):
            return -1
        if pivot < 0.0:
            negative += 1
        inverse = 1.0 / pivot
        reach = min(half, size - 1 - k)
        upper = band[k, half + 1 : half + 1 + reach]
        for below in range(1, reach + 1):
            row, start = k + below, half - below
            factor = band[row, start] * inverse
            band[row, start] = factor
            lower = band[row, start + 1 : start + 1 + reach]
            for i in range(reach):
                lower[i] -= factor * upper[i]
    return negative


@njit(cache=True, error_model="numpy")
def solve_band(band: Floats, unknown: Ints, right: Floats, solution: Floats) -> None:
    """Solve with the factors of ``factorise_band``; right sides and solutions are (k, n, coordinates)."""
    size, width = band.shape
    half = width // 2
    nodes, coordinates = unknown.shape
    x = np.zeros(size)
    for side in range(len(right)):
        for node in range(nodes):
            for i in range(coordinates):
                if unknown[node, i] >= 0:
                    x[unknown[node, i]] = right[side, node, i]
        for i in range(size):
            value = x[i]
            for j in range(max(0, i - half), i):
                value -= band[i, half + j - i] * x[j]
            x[i] = value
        for i in range(size - 1, -1, -1):
            value = x[i]
            for j in range(i + 1, min(size, i + half + 1)):
                value -= band[i, half + j - i] * x[j]
            x[i] = value / band[i, half]
        for node in range(nodes):
            for i in range(coordinates):
                if unknown[node, i] >= 0:
                    solution[side, node, i] = x[unknown[node, i]]


class Limits(NamedTuple):
    """Bounds of a step, and when it is good enough."""

    largest_turn: float
    shortest_step: float
    clear_fall: float
    """Fall of the merit at which a step is taken without the test of monotonicity."""
    worthwhile_fall: float
    """Fall of the merit at which one more step with the same factors costs less than it saves."""
    tolerance: float
    length_tolerance: float


def factorise(system: Any, blocks: Floats) -> int:
    """Factorise the tangent; number of negative pivots (0 where the factorisation does not tell), -1 if singular.

    ``system`` is a ``linear_systems.LinearSystem``, or in compiled code a ``Band``.
    """
    return int(system.factorise(blocks))


def solve(system: Any, right: Floats, solution: Floats) -> None:
    """Write the solutions for right sides (k, n, 3), with the factors of such a system."""
    solution[:] = system.solve(right)


@overload(factorise)
def _factorise_compiled(system, blocks):  # type: ignore[no-untyped-def]
    return lambda system, blocks: factorise_band(blocks.reshape(-1), system.place, system.rows)


@overload(solve)
def _solve_compiled(system, right, solution):  # type: ignore[no-untyped-def]
    return lambda system, right, solution: solve_band(system.rows, system.unknown, right, solution)


class Iteration(NamedTuple):
    """What a step reads, and where it writes."""

    structure: Structure
    loading: Loading
    pattern: Pattern
    tension: float
    """Reference tension, N."""
    switch: float
    """Weight of the test for taut bars (``newton_state.measure``)."""
    limits: Limits
    state: State
    """Where the step starts."""
    first: State
    second: State
    """Spare states: one of them will be where it ends."""
    step: Step


@njit(cache=True, error_model="numpy")
def within(state: State, limits: Limits) -> bool:
    """Whether a state is an equilibrium to the tolerances."""
    marks = state.marks[0]
    return max(marks.residual, marks.imbalance) <= limits.tolerance and marks.length_error <= limits.length_tolerance


def advance(system: Any, iteration: Iteration, shift: float, fresh: bool) -> tuple[int, int]:
    """Take a step from a state with the tangent shifted, shortened as far as need be.

    Unless ``fresh``, the factors that the system holds stand for those of the tangent, which is near to theirs.

    While a whole step with the unshifted tangent does well, more follow with the same factors (Broyden's method).

    Returns:
        where the new state is, and the number of negative pivots, -1 if the tangent was singular.
    """
    structure, loading, pattern, limits = iteration.structure, iteration.loading, iteration.pattern, iteration.limits
    tension, switch, step = iteration.tension, iteration.switch, iteration.step
    state, first, second = iteration.state, iteration.first, iteration.second
    if fresh:
        sides = linearise(structure, loading, pattern, tension, shift, state, step)
    else:
        sides = right_sides(structure, loading, tension, state, step)
    right, solved = step.right, step.solved[:sides]
    negative = factorise(system, step.blocks) if fresh else 0
    if negative < 0 or (negative > 0 and state.marks[0]["residual"] > NEARBY):
        return FAILED, negative
    solve(system, right[:sides], solved)
    length, turn, determinant = finish_step(structure, state, state, solved, step)
    if not determinant > 0.0 or not np.isfinite(turn):
        return FAILED, 1
    size = min(1.0, limits.largest_turn / turn) if turn > 0.0 else 1.0
    solved_there = False
    while True:
        take(structure, loading, tension, switch, 0.0, size, state, state, step, first)
        fall = first.marks[0]["merit"] / state.marks[0]["merit"]
        if fall <= limits.clear_fall:
            break
        if negative > 0:
            return FAILED, negative
        solve(system, right[:1], solved[:1])
        solved_there = True
        left, bend = simplified_move(solved, size, step)
        # a shifted step leaves what the shift took, so there only growth is refused
        if left <= ((1.0 - 0.25 * size) if shift == 0.0 else 2.0) * length:
            # what is left to go may fall where the forces, of which stiff bars make much, do not
            fall = min(fall, left / length)
            break
        size = min(0.5 * size, 0.5 * size * size * length / bend)
        if size < limits.shortest_step:
            return FAILED, 0
    if shift > 0.0 or size < 1.0:
        return IN_FIRST, 0
    past = step.past
    keep(past, 0, state.length, tension, step.move, step.change)
    there, new, where, last_fall = first, second, IN_FIRST, fall
    for count in range(1, MOST_STEPS):
        # over two steps, since the first of a bend may seem to lead away
        if not fall * last_fall <= limits.worthwhile_fall**2 or within(there, limits):
            break
        if count > 1 or not solved_there:
            solve(system, right[:1], solved[:1])
        finish_step(structure, state, there, solved, step)
        if not correct(past, count, state.length, tension, step.move, step.change):
            break
        take(structure, loading, tension, switch, 0.0, 1.0, state, there, step, new)
        last_fall, fall = fall, new.marks[0]["merit"] / there.marks[0]["merit"]
        if fall < 1.0 or fall * last_fall <= limits.worthwhile_fall**2:
            there, new, where = new, there, IN_FIRST + IN_SECOND - where
    return where, 0


advance_banded = njit(cache=True, error_model="numpy")(advance)
