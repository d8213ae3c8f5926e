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
    hole: Hole, phi: float, fish: Fish, steps: int, turns: Turns, lengths: NDArray[np.float64]
) -> None:
    """Write the longest fish at the best rotation, and at each of some ``turns`` (k,) off it, m, into ``lengths``.

    (k + 1,); one search for the best rotation serves all.
    """
    if fish.n != 2.0:
        rotation = best_rotation(hole, phi, fish, steps)
        lengths[0] = longest_turned(hole, phi, fish, rotation)
        for k in range(len(turns.angle)):
            lengths[k + 1] = longest_turned(hole, phi, fish, rotation + turns.angle[k])
        return
    best = _best_of_ellipse(hole, phi, fish)
    lengths[0] = math.sqrt(_squared(hole, phi, fish, best))
    for k in range(len(turns.angle)):
        cosine, sine = turns.cosine[k], turns.sine[k]
        turned = best[0] * cosine - best[1] * sine, best[1] * cosine + best[0] * sine
        lengths[k + 1] = math.sqrt(_squared(hole, phi, fish, turned))


@njit(cache=True, nogil=True, inline="always")
def _squared(hole: Hole, phi: float, fish: Fish, turned: tuple[float, float]) -> float:
    """Square of the longest ellipse, m2, by cosine and sine of twice its rotation: least of d^2 / h^2 over the sides.

    h^2 = (S + D cos 2(nu - theta)) / 2 with S = a^2 + b^2, D = a^2 - b^2 is linear in them.
    """
    squares, difference = 0.5 * (fish.a * fish.a + fish.b * fish.b), 0.5 * (fish.a * fish.a - fish.b * fish.b)
    cosine, sine = difference * turned[0], difference * turned[1]
    if hole.shape == RECTANGLE:
        return min(
            0.25 * hole.bar * hole.bar / (squares + cosine), 0.25 * hole.across * hole.across / (squares - cosine)
        )
    c, s = math.cos(phi), math.sin(phi)
    across, along = 2.0 * s * s - 1.0, 2.0 * s * c  # cosine and sine of twice the first normal's angle
    turned_knots = hole.shape == RHOMBUS_KNOTS_ACROSS
    d = (hole.bar * s + 0.5 * hole.knot) * c if turned_knots else (hole.bar * c + 0.5 * hole.knot) * s
    least = d * d / (squares + max(across * cosine + along * sine, across * cosine - along * sine))
    if hole.knot > 0.0:
        third = hole.bar * (c if turned_knots else s)
        least = min(least, third * third / (squares + (cosine if turned_knots else -cosine)))
    return least


@njit(cache=True, nogil=True)
def _best_of_ellipse(hole: Hole, phi: float, fish: Fish) -> tuple[float, float]:
    """Cosine and sine of twice the best rotation of an ellipse: as ``best_rotation`` has it."""
    best = 1.0, 0.0
    value = _squared(hole, phi, fish, best)
    tried = -1.0, 0.0
    length = _squared(hole, phi, fish, tried)
    if length > value:
        best, value = tried, length
    if hole.shape != RECTANGLE and hole.knot == 0.0:  # in a rhombus it lies along a diagonal
        return best
    nu1, d1, nu2, d2, nu3, d3 = sides_of(hole, phi)
    normal = math.cos(2.0 * nu1), math.sin(2.0 * nu1)
    for sign in (1.0, -1.0):
        tried = sign * normal[0], sign * normal[1]
        length = _squared(hole, phi, fish, tried)
        if length > value:
            best, value = tried, length
    # where the first pair of sides and another let the same ellipse through: a linear equation in cosine and sine. The
    # first two pairs of a rhombus cross at 0 and 90 degrees only, and the second and third mirror the first and third
    nu, d = (nu2, d2) if hole.shape == RECTANGLE else (nu3, d3)
    squares, difference = fish.a * fish.a + fish.b * fish.b, fish.a * fish.a - fish.b * fish.b
    first, other = d1**-2, d**-2
    cosine = difference * (first * normal[0] - other * math.cos(2.0 * nu))
    sine = difference * (first * normal[1] - other * math.sin(2.0 * nu))
    wanted, reach = squares * (other - first), cosine * cosine + sine * sine
    if reach == 0.0 or wanted * wanted > reach:
        return best
    root = math.sqrt(reach - wanted * wanted)
    for sign in (1.0, -1.0):
        tried = (cosine * wanted - sign * sine * root) / reach, (sine * wanted + sign * cosine * root) / reach
        length = _squared(hole, phi, fish, tried)
        if length > value:
            best, value = tried, length
    return best


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
    if fish.n == 2.0:
        turned = _best_of_ellipse(hole, phi, fish)
        return 0.5 * math.atan2(turned[1], turned[0])
    best, value = 0.0, min(_by_side(sides, fish, 0.0))
    at_end = min(_by_side(sides, fish, quarter))
    if at_end > value:
        best, value = quarter, at_end
    q = fish.n / (fish.n - 1.0)
    between = math.atan((fish.a / fish.b) ** (q / (q - 2.0))) if q > 2.0 else 0.0
    turns = 0.0, quarter, between, -between
    for side in (0, 2):
        for k in range(4 if between > 0.0 else 2):
            tried = sides[2 * side] - turns[k]
            length = min(_by_side(sides, fish, tried))
            if length > value:
                best, value = tried, length
    for one, two in ((0, 1), (0, 2), (1, 2)):
        if sides[2 * two + 1] == math.inf:
            continue
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
def _crossing(sides: Sides, fish: Fish, one: int, two: int, left: float, right: float, steps: int) -> float:
    """Rotation at which two pairs of sides let the same section through: by bisection in an interval.

    nan where it holds no crossing or two.
    """
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
