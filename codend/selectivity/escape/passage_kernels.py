"""Kernels of the longest fish that passes a mesh; equations and symbols stand in ``penetration``."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit

Sides = tuple[float, float, float, float, float, float]
"""Angle of the normal and distance from the centre, of three pairs of sides in turn."""

RHOMBUS_KNOTS_ALONG, RHOMBUS_KNOTS_ACROSS, RECTANGLE = range(3)
"""Shapes of holes."""
GOLDEN: Final = 0.5 * (math.sqrt(5.0) - 1.0)
FINE: Final = 40
"""Steps of bisection and of golden-section search by which a single answer is refined."""
ROTATIONS, OPENINGS = 5, 30
"""Intervals in which the best rotation, between turning points, and the ideal openings are looked for."""
IDEALS: Final = 4
"""Most ideal openings of a netting that are kept; ellipses in a rhombus have two."""


class Fish(NamedTuple):
    """Half height and half width of the section of a fish of length 1, and the superellipse's exponent."""

    a: float
    b: float
    n: float


class Hole(NamedTuple):
    """One mesh but for its opening, as in ``Holes``."""

    shape: int
    bar: float
    knot: float
    across: float
    load: float
    bending: float
    rest: float
    held_across: float
    held_along: float


class Turns(NamedTuple):
    """Turns off a rotation, rad, and cosine and sine of twice each, (k,)."""

    angle: NDArray[np.float64]
    cosine: NDArray[np.float64]
    sine: NDArray[np.float64]


@njit(cache=True, nogil=True)
def longest_turned(hole: Hole, phi: float, fish: Fish, rotation: float) -> float:
    """Longest fish at a given rotation, m: min of d / h_1 over the sides."""
    return min(_by_side(sides_of(hole, phi), fish, rotation))


@njit(cache=True, nogil=True)
def longest_turned_by(
    hole: Hole, phi: float, fish: Fish, rotation: float, turns: Turns, lengths: NDArray[np.float64]
) -> None:
    """Write the longest fish at a rotation, and at that and each of some ``turns`` (k,), into ``lengths`` (k + 1,), m.

    Of ellipses h^2 = (S + D cos 2(nu - theta)) / 2 (see ``_support``) is linear in cos and sin of twice the turn, and
    of the three d^2 / h^2 the least is asked.
    """
    if fish.n != 2.0:
        lengths[0] = longest_turned(hole, phi, fish, rotation)
        for k in range(len(turns.angle)):
            lengths[k + 1] = longest_turned(hole, phi, fish, rotation + turns.angle[k])
        return
    nu1, d1, nu2, d2, nu3, d3 = sides_of(hole, phi)
    squares, difference = 0.5 * (fish.a * fish.a + fish.b * fish.b), 0.5 * (fish.a * fish.a - fish.b * fish.b)
    c1, s1 = difference * math.cos(2.0 * (nu1 - rotation)), difference * math.sin(2.0 * (nu1 - rotation))
    c2, s2 = difference * math.cos(2.0 * (nu2 - rotation)), difference * math.sin(2.0 * (nu2 - rotation))
    c3, s3 = difference * math.cos(2.0 * (nu3 - rotation)), difference * math.sin(2.0 * (nu3 - rotation))
    for k in range(len(lengths)):
        cosine = turns.cosine[k - 1] if k > 0 else 1.0
        sine = turns.sine[k - 1] if k > 0 else 0.0
        least = min(d1 * d1 / (squares + c1 * cosine + s1 * sine), d2 * d2 / (squares + c2 * cosine + s2 * sine))
        lengths[k] = math.sqrt(min(least, d3 * d3 / (squares + c3 * cosine + s3 * sine)))


@njit(cache=True, nogil=True)
def _by_side(sides: Sides, fish: Fish, rotation: float) -> tuple[float, float, float]:
    """Longest fish that each pair of sides would let through, m."""
    nu1, d1, nu2, d2, nu3, d3 = sides
    third = d3 / _support(fish, nu3 - rotation) if d3 < math.inf else math.inf
    return d1 / _support(fish, nu1 - rotation), d2 / _support(fish, nu2 - rotation), third


@njit(cache=True, nogil=True)
def sides_of(hole: Hole, phi: float) -> Sides:
    """Normal angle to the netting's axis and distance from the centre of three pairs of sides; see the heading."""
    if hole.shape == RECTANGLE:
        return 0.0, 0.5 * hole.bar, 0.5 * math.pi, 0.5 * hole.across, 0.0, math.inf
    sine, cosine = math.sin(phi), math.cos(phi)
    normal = 0.5 * math.pi - phi
    if hole.shape == RHOMBUS_KNOTS_ACROSS:
        d = (hole.bar * sine + 0.5 * hole.knot) * cosine
        return normal, d, -normal, d, 0.0, hole.bar * cosine if hole.knot > 0.0 else math.inf
    d = (hole.bar * cosine + 0.5 * hole.knot) * sine
    return normal, d, -normal, d, 0.5 * math.pi, hole.bar * sine if hole.knot > 0.0 else math.inf


@njit(cache=True, nogil=True)
def _support(fish: Fish, angle: float) -> float:
    if fish.n == 2.0:
        squares, difference = fish.a * fish.a + fish.b * fish.b, fish.a * fish.a - fish.b * fish.b
        return math.sqrt(0.5 * (squares + difference * math.cos(2.0 * angle)))
    x, y = fish.a * math.cos(angle), fish.b * math.sin(angle)
    q = fish.n / (fish.n - 1.0)
    return (abs(x) ** q + abs(y) ** q) ** (1.0 / q)


@njit(cache=True, nogil=True)
def best_rotation(hole: Hole, phi: float, fish: Fish, steps: int) -> float:
    """Rotation of the longest fish, in [0, 90] degrees: hole and section are symmetric to both their axes.

    The least of several functions is largest where one of them is, or where two of them cross. The first is known, at
    the least supports: along an axis of the section, or for n < 2 at tan t = (a / b)^(q / (q - 2)) between them. So is
    the second for ellipses; for other sections it is looked for in intervals between the curves' turning points and
    found by bisection. The second pair of sides mirrors the first, or lies on an axis, and has no maximum of its own.
    """
    quarter = 0.5 * math.pi
    sides = sides_of(hole, phi)
    if sides[1] <= 0.0 or sides[3] <= 0.0:  # closed
        return 0.0
    best, value = 0.0, min(_by_side(sides, fish, 0.0))
    at_end = min(_by_side(sides, fish, quarter))
    if at_end > value:
        best, value = quarter, at_end
    if fish.n == 2.0 and hole.knot == 0.0 and hole.shape != RECTANGLE:  # an ellipse in a rhombus lies along a diagonal
        return best
    q = fish.n / (fish.n - 1.0)
    between = math.atan((fish.a / fish.b) ** (q / (q - 2.0))) if q > 2.0 else 0.0
    turned = 0.0, quarter, between, -between
    for side in (0, 2):
        for k in range(4 if between > 0.0 else 2):
            tried = sides[2 * side] - turned[k]
            length = min(_by_side(sides, fish, tried))
            if length > value:
                best, value = tried, length
    for one, two in ((0, 1), (0, 2), (1, 2)):
        # ellipses: the two roots for the first and third pair mirror those for the second and third, and the mirrored
        # sides of knotted netting cross at 0 and at 90 degrees only
        known = fish.n == 2.0 and (one == 1 or (two == 1 and hole.shape != RECTANGLE))
        if known or sides[2 * two + 1] == math.inf:
            continue
        if fish.n != 2.0:
            ends = _turning_points(sides, fish, one, two, between)
            for k in range(ROTATIONS * (len(ends) - 1)):
                left, right = ends[k // ROTATIONS], ends[k // ROTATIONS + 1]
                width = (right - left) / ROTATIONS
                left += width * (k % ROTATIONS)
                tried = _crossing(sides, fish, one, two, left, left + width, steps) if width > 0.0 else math.nan
                if not math.isnan(tried):
                    length = min(_by_side(sides, fish, tried))
                    if length > value:
                        best, value = tried, length
            continue
        for k in range(2):
            tried = _crossing_of_ellipse(sides, fish, one, two, k)
            if not math.isnan(tried):
                length = min(_by_side(sides, fish, tried))
                if length > value:
                    best, value = tried, length
    return best


@njit(cache=True, nogil=True)
def _turning_points(sides: Sides, fish: Fish, one: int, two: int, between: float) -> NDArray[np.float64]:
    """Rotations from 0 to 90 degrees between which what either pair of sides lets through only rises or only falls.

    Two curves can cross twice close to a turning point of one of them, where even intervals would see no crossing.
    """
    found, count = np.empty(18), 2
    found[0], found[1] = 0.0, 0.5 * math.pi
    for side in (one, two):
        for turned in (0.0, 0.5 * math.pi, between, -between):
            angle = (sides[2 * side] - turned) % math.pi
            if 0.0 < angle < 0.5 * math.pi:
                found[count] = angle
                count += 1
    return np.sort(found[:count])


@njit(cache=True, nogil=True)
def _crossing_of_ellipse(sides: Sides, fish: Fish, one: int, two: int, root: int) -> float:
    """Rotation at which two pairs of sides let the same ellipse through, one of two; nan where they never do.

    With S = a^2 + b^2, D = a^2 - b^2 and h^2 = (S + D cos 2(nu - theta)) / 2, equal h / d on both is a linear
    equation in cos(2 theta) and sin(2 theta).
    """
    squares, difference = fish.a * fish.a + fish.b * fish.b, fish.a * fish.a - fish.b * fish.b
    first, second = sides[2 * one + 1] ** -2, -(sides[2 * two + 1] ** -2)
    cosine = difference * (first * math.cos(2.0 * sides[2 * one]) + second * math.cos(2.0 * sides[2 * two]))
    sine = difference * (first * math.sin(2.0 * sides[2 * one]) + second * math.sin(2.0 * sides[2 * two]))
    reach, wanted = math.hypot(cosine, sine), -squares * (first + second)
    if abs(wanted) > reach or reach == 0.0:
        return math.nan
    turn = math.acos(wanted / reach)
    return 0.5 * (math.atan2(sine, cosine) + (turn if root == 0 else -turn))


@njit(cache=True, nogil=True)
def _crossing(sides: Sides, fish: Fish, one: int, two: int, left: float, right: float, steps: int) -> float:
    """The same for any section, by bisection in an interval; nan where it holds no crossing or two."""
    at_left, at_right = _by_side(sides, fish, left), _by_side(sides, fish, right)
    rising = at_left[one] < at_left[two]
    if (at_right[one] < at_right[two]) == rising:
        return math.nan
    for _ in range(steps):
        middle = 0.5 * (left + right)
        at_middle = _by_side(sides, fish, middle)
        if (at_middle[one] < at_middle[two]) == rising:
            left = middle
        else:
            right = middle
    return 0.5 * (left + right)


@njit(cache=True, nogil=True)
def longest_at(hole: Hole, phi: float, fish: Fish, rotation: float, steps: int) -> float:
    """Longest fish at the given rotation, or at the best one for nan."""
    if math.isnan(rotation):
        rotation = best_rotation(hole, phi, fish, steps)
    return longest_turned(hole, phi, fish, rotation)


@njit(cache=True, nogil=True)
def ideal_openings(hole: Hole, fish: Fish, rotation: float, steps: int, ideals: NDArray[np.float64]) -> None:
    """Write the half opening angles at which a longer fish passes than at any near them into ``ideals``, then nan.

    At a rotation, or the best one for nan. They depend on the netting and the fish's shape and not on the load, so that
    one search serves all meshes of a netting, however far each can be pushed.
    """
    ideals[:] = np.nan
    count, width = 0, 0.5 * math.pi / OPENINGS
    before, at = 0.0, longest_at(hole, 0.0, fish, rotation, steps)
    for k in range(OPENINGS):
        after = longest_at(hole, (k + 1) * width, fish, rotation, steps)
        if before <= at > after and k > 0 and count < len(ideals):
            ideals[count] = _highest(hole, fish, rotation, steps, (k - 1) * width)
            count += 1
        before, at = at, after


@njit(cache=True, nogil=True)
def _highest(hole: Hole, fish: Fish, rotation: float, steps: int, left: float) -> float:
    """Half opening angle of the longest fish in two intervals from ``left`` on, by golden-section search."""
    right = left + math.pi / OPENINGS
    one, two = right - GOLDEN * (right - left), left + GOLDEN * (right - left)
    at_one = longest_at(hole, one, fish, rotation, steps)
    at_two = longest_at(hole, two, fish, rotation, steps)
    for _ in range(steps):
        if at_one > at_two:
            right, two, at_two = two, one, at_one
            one = right - GOLDEN * (right - left)
            at_one = longest_at(hole, one, fish, rotation, steps)
        else:
            left, one, at_one = one, two, at_two
            two = left + GOLDEN * (right - left)
            at_two = longest_at(hole, two, fish, rotation, steps)
    return one if at_one > at_two else two
