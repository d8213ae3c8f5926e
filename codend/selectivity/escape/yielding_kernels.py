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


class Passing(NamedTuple):
    """How long a fish passes a mesh at an opening: by its section and rotation (nan: the best), or by a table.

    The table is of even half opening angles from 0 to 90 degrees, (n + 1, ...), its first column the longest fish at
    the best rotation; without rows every length is exact.
    """

    fish: Fish
    rotation: float
    table: NDArray[np.float64]


@njit(cache=True, nogil=True)
def force_to(hole: Hole, computed: float, phi: float) -> float:
    """Push that brings a mesh from the computed half opening angle to another one, N: across, or along to close it."""
    return _force_against(hole, computed, _resting(hole, computed), phi)


@njit(cache=True, nogil=True)
def _resting(hole: Hole, computed: float) -> float:
    """Load and moment that balance at the computed half opening angle, as a load across, N."""
    return hole.load * math.tan(computed) + hole.bending * (computed - hole.rest) / math.cos(computed)


@njit(cache=True, nogil=True)
def _force_against(hole: Hole, computed: float, across: float, phi: float) -> float:
    """``force_to`` with ``across`` as ``_resting`` has it."""
    sine, cosine = math.sin(phi), math.cos(phi)
    missing = hole.load * sine + hole.bending * (phi - hole.rest) - across * cosine
    if phi >= computed:
        return max(hole.held_across * missing / cosine, 0.0)
    return max(-hole.held_along * missing / sine, 0.0)


@njit(cache=True, nogil=True)
def longest_by(hole: Hole, phi: float, passing: Passing, steps: int) -> float:
    """Longest fish through a mesh at a half opening angle, m: by its table where there is one, else exactly."""
    last = len(passing.table) - 1
    if last < 0:
        return longest_at(hole, phi, passing.fish, passing.rotation, steps)
    at = phi / (0.5 * math.pi) * last
    left = min(int(at), last - 1)
    return passing.table[left, 0] + (at - left) * (passing.table[left + 1, 0] - passing.table[left, 0])


@njit(cache=True, nogil=True)
def best_opening(hole: Hole, phi: float, passing: Passing, effort: Effort, ideals: NDArray[np.float64]) -> float:
    """Half opening angle that the longest fish which passes gives the mesh.

    It is one of the netting's ideal openings, or the edge of what the fish's push reaches on the way to one.
    """
    if effort.push <= 0.0 or hole.shape == RECTANGLE:
        return phi
    best, value = phi, longest_by(hole, phi, passing, effort.steps)
    across = _resting(hole, phi)
    at_rest = _push_of(value, effort)
    for side in (1.0, -1.0):
        reached, spare, too_much = phi, at_rest, 0.0
        for k in range(len(ideals)):
            ideal = ideals[k] if side > 0.0 else ideals[len(ideals) - 1 - k]
            if not side * (ideal - phi) > 0.0:  # behind, or nan
                continue
            length = longest_by(hole, ideal, passing, effort.steps)
            push = _push_of(length, effort)
            if push < too_much:  # the force only rises: nothing from the ideal that was out of reach to this one is not
                continue
            force = _force_against(hole, phi, across, ideal)
            if push >= force:
                tried, reached, spare = ideal, ideal, push - force
            else:
                too_much = force
                if length <= value * (1.0 + NARROWED):  # nor is a longer one on the way, without an ideal there
                    continue
                tried = _edge_of_reach(hole, phi, across, reached, ideal, spare, push - force, passing, effort)
                length = longest_by(hole, tried, passing, effort.steps)
            if length > value:
                best, value = tried, length
    return best


@njit(cache=True, nogil=True)
def _push_of(length: float, effort: Effort) -> float:
    """Push of a fish of a length, N."""
    if effort.exponent == 0.0:
        return effort.push
    longer = length / effort.at
    return effort.push * (longer * longer if effort.exponent == 2.0 else longer**effort.exponent)


@njit(cache=True, nogil=True)
def _edge_of_reach(
    hole: Hole,
    computed: float,
    across: float,
    within: float,
    beyond: float,
    spare: float,
    lacking: float,
    passing: Passing,
    effort: Effort,
) -> float:
    """The last opening within reach between one that is, with ``spare`` push, N, and one that is not.

    Half-way first, as openings that a small fish reaches may be followed by a gap, and then by those that a larger one
    does, which pushes harder; then by regula falsi, each time a little aside of the root so that it is enclosed from
    both sides, and by bisection where that is slow.
    """
    narrowed = ROUGHLY if len(passing.table) else NARROWED
    aside = math.copysign(0.4 * narrowed, beyond - within)
    for step in range(MOST_STEPS):
        wide = beyond - within
        if abs(wide) <= narrowed:
            break
        middle = within + 0.5 * wide
        if step % 4 > 0 and spare > lacking:
            root = within + spare / (spare - lacking) * wide + aside
            if (root - within) * (beyond - root) > 0.0:
                middle = root
        length = longest_by(hole, middle, passing, effort.steps)
        left = _push_of(length, effort) - _force_against(hole, computed, across, middle)
        if left >= 0.0:
            within, spare = middle, left
            aside = abs(aside) if wide > 0.0 else -abs(aside)
        else:
            beyond, lacking = middle, left
            aside = -abs(aside) if wide > 0.0 else abs(aside)
    return within
