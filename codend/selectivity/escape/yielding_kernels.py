"""Kernels of meshes that yield to a fish's push; equations and symbols stand in ``yielding``."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.selectivity.escape.passage_kernels import RECTANGLE, Fish, Hole, longest_at

NARROWED: Final = 1e-10
ROUGHLY: Final = 1e-4
"""Interval of half opening angles, rad, within which the edge of a push's reach is found, exactly and by a table."""
MOST_STEPS: Final = 200


class Effort(NamedTuple):
    """A fish's push, and steps of refinement in the search for the best rotation.

    A fish of length L pushes with ``push`` (L / ``at``) ^ ``exponent``, N; ``at`` in metres.
    """

    push: float
    exponent: float
    at: float
    steps: int


@njit(cache=True, nogil=True)
def force_to(hole: Hole, computed: float, phi: float) -> float:
    """Push that brings a mesh from the computed half opening angle to another one, N: across, or along to close it."""
    sine, cosine = math.sin(phi), math.cos(phi)
    across = hole.load * math.tan(computed) + hole.bending * (computed - hole.rest) / math.cos(computed)
    missing = hole.load * sine + hole.bending * (phi - hole.rest) - across * cosine
    if phi >= computed:
        return max(hole.held_across * missing / cosine, 0.0)
    return max(-hole.held_along * missing / sine, 0.0)


@njit(cache=True, nogil=True)
def best_opening(
    hole: Hole, phi: float, fish: Fish, rotation: float, effort: Effort, ideals: NDArray[np.float64]
) -> float:
    """Half opening angle that the longest fish which passes gives the mesh, at a rotation or the best for nan.

    It is one of the netting's ``ideal_openings``, or the edge of what the fish's push reaches on the way to one.
    """
    if effort.push <= 0.0 or hole.shape == RECTANGLE:
        return phi
    best, value = phi, longest_at(hole, phi, fish, rotation, effort.steps)
    for side in (1.0, -1.0):
        reached = phi
        for k in range(len(ideals)):
            ideal = ideals[k] if side > 0.0 else ideals[len(ideals) - 1 - k]
            if not side * (ideal - phi) > 0.0:  # behind, or nan
                continue
            if _within_reach(hole, phi, ideal, fish, rotation, effort):
                tried = reached = ideal
            else:
                tried = _edge_of_reach(hole, phi, reached, ideal, fish, rotation, effort)
            length = longest_at(hole, tried, fish, rotation, effort.steps)
            if length > value:
                best, value = tried, length
    return best


@njit(cache=True, nogil=True)
def _within_reach(hole: Hole, computed: float, phi: float, fish: Fish, rotation: float, effort: Effort) -> bool:
    """Whether the longest fish that passes at an opening pushes hard enough to bring the mesh there."""
    needed = force_to(hole, computed, phi)
    if effort.exponent == 0.0:
        return needed <= effort.push
    length = longest_at(hole, phi, fish, rotation, effort.steps)
    return needed <= effort.push * (length / effort.at) ** effort.exponent


@njit(cache=True, nogil=True)
def _edge_of_reach(
    hole: Hole, computed: float, within: float, beyond: float, fish: Fish, rotation: float, effort: Effort
) -> float:
    """The last opening within reach between one that is and one that is not: by bisection, and regula falsi between."""
    spare, lacking = math.nan, math.nan
    for step in range(MOST_STEPS):
        if abs(beyond - within) <= NARROWED:
            break
        middle = _tried_between(within, spare, beyond, lacking, step)
        push = effort.push
        if effort.exponent != 0.0:
            length = longest_at(hole, middle, fish, rotation, effort.steps)
            push *= (length / effort.at) ** effort.exponent
        left = push - force_to(hole, computed, middle)
        if left >= 0.0:
            within, spare = middle, left
        else:
            beyond, lacking = middle, left
    return within


@njit(cache=True, nogil=True)
def _tried_between(within: float, spare: float, beyond: float, lacking: float, step: int) -> float:
    """Where to look next for the opening at which a push is spent: by regula falsi, at every third step in the middle.

    Args:
        within: an opening that is reached.
        spare: push left there; nan where that is not known.
        beyond: one that is not.
        lacking: push left there, below 0; nan where that is not known.
        step: how often was looked before.
    """
    if step % 3 and spare - lacking > 0.0:
        return within + min(max(spare / (spare - lacking), 0.01), 0.99) * (beyond - within)
    return 0.5 * (within + beyond)


@njit(cache=True, nogil=True)
def table_opening(hole: Hole, phi: float, table: NDArray[np.float64], effort: Effort) -> float:
    """``best_opening`` from a table of the longest fish at even half opening angles from 0 to 90 degrees, (n + 1, ...).

    The first column is that at the best rotation, linear between its rows.
    """
    if effort.push <= 0.0:
        return phi
    last = len(table) - 1
    width = 0.5 * math.pi / last
    best, value = phi, _tabled(table, phi / width)
    for side in (1, -1):
        reached = phi
        at = int(phi / width) + (1 if side > 0 else 0)
        if at * width == phi:
            at += side
        while 0 < at < last:
            here = table[at, 0]
            peak = here >= table[at - 1, 0] and here >= table[at + 1, 0]
            if peak:
                push = effort.push * (here / effort.at) ** effort.exponent
                if force_to(hole, phi, at * width) <= push:
                    tried = reached = at * width
                else:
                    tried = _table_edge(hole, phi, reached, at * width, table, effort)
                length = _tabled(table, tried / width)
                if length > value:
                    best, value = tried, length
            at += side
    return best


@njit(cache=True, nogil=True)
def _table_edge(
    hole: Hole, computed: float, within: float, beyond: float, table: NDArray[np.float64], effort: Effort
) -> float:
    width = 0.5 * math.pi / (len(table) - 1)
    spare, lacking = math.nan, math.nan
    for step in range(MOST_STEPS):
        if abs(beyond - within) <= ROUGHLY:
            break
        middle = _tried_between(within, spare, beyond, lacking, step)
        push = effort.push * (_tabled(table, middle / width) / effort.at) ** effort.exponent
        left = push - force_to(hole, computed, middle)
        if left >= 0.0:
            within, spare = middle, left
        else:
            beyond, lacking = middle, left
    return within


@njit(cache=True, nogil=True)
def _tabled(table: NDArray[np.float64], at: float) -> float:
    left = min(int(at), len(table) - 2)
    return table[left, 0] + (at - left) * (table[left + 1, 0] - table[left, 0])
