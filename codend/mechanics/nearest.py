"""The nearest points of two parts of a net's surface, a node and a triangle or two edges: a kernel.

Of a pair of four nodes x0 .. x3 the nearest points differ by r = sum of w_i x_i, the weights w linear in up to two
places along the parts that are free: none where a node is nearest to a node, both inside a triangle or two edges.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.net.net import Floats

NODE_TRIANGLE, EDGE_EDGE = 0, 1
FLAT = 1e-10
"""Square of the sine of the angle between two sides, up to which a triangle has no inside and edges are parallel."""


class Nearest(NamedTuple):
    """Room for what is found of a pair."""

    corner: Floats
    """Its four nodes, (4, 3)."""
    weight: Floats
    """w, (4,)."""
    slope: Floats
    """Derivatives of the weights by the places that are free, (2, 4)."""
    apart: Floats
    """r, (3,), m."""


@njit(cache=True, error_model="numpy")
def _along(corner: Floats, a: int, b: int, c: int, d: int) -> float:
    """Scalar product of the vectors from node a to b and from c to d."""
    total = 0.0
    for i in range(3):
        total += (corner[b, i] - corner[a, i]) * (corner[d, i] - corner[c, i])
    return total


@njit(cache=True, error_model="numpy")
def _set_edge(found: Nearest, node: int, a: int, b: int, place: float, free: bool) -> None:
    """Write that a node is nearest to a place along an edge."""
    found.weight[:] = 0.0
    found.weight[node], found.weight[a], found.weight[b] = 1.0, place - 1.0, -place
    if free:
        found.slope[0, a], found.slope[0, b] = 1.0, -1.0


@njit(cache=True, error_model="numpy")
def _to_edge(found: Nearest, node: int, a: int, b: int) -> tuple[float, bool]:
    """Place along an edge nearest to a node, and whether it lies between its ends."""
    square = _along(found.corner, a, b, a, b)
    if square == 0.0:
        return 0.0, False
    place = _along(found.corner, a, node, a, b) / square
    return min(max(place, 0.0), 1.0), 0.0 < place < 1.0


@njit(cache=True, error_model="numpy")
def _square(found: Nearest) -> float:
    """Write r by the weights; its square."""
    total = 0.0
    for i in range(3):
        value = 0.0
        for node in range(4):
            value += found.weight[node] * found.corner[node, i]
        found.apart[i] = value
        total += value * value
    return total


@njit(cache=True, error_model="numpy")
def nearest(kind: int, found: Nearest) -> tuple[int, float]:
    """Write weights, slopes and r of the pair in ``found.corner``.

    Returns:
        how many places are free, and the square of the distance.
    """
    found.slope[:] = 0.0
    return _node_triangle(found) if kind == NODE_TRIANGLE else _edge_edge(found)


@njit(cache=True, error_model="numpy")
def _node_triangle(found: Nearest) -> tuple[int, float]:
    corner, weight, slope = found.corner, found.weight, found.slope
    uu, uv, vv = _along(corner, 1, 2, 1, 2), _along(corner, 1, 2, 1, 3), _along(corner, 1, 3, 1, 3)
    pu, pv = _along(corner, 1, 0, 1, 2), _along(corner, 1, 0, 1, 3)
    area = uu * vv - uv * uv
    if area > FLAT * uu * vv:
        s, t = (vv * pu - uv * pv) / area, (uu * pv - uv * pu) / area
        if s > 0.0 and t > 0.0 and s + t < 1.0:
            weight[0], weight[1], weight[2], weight[3] = 1.0, s + t - 1.0, -s, -t
            slope[0, 1], slope[0, 2], slope[1, 1], slope[1, 3] = 1.0, -1.0, 1.0, -1.0
            return 2, _square(found)
    best, a, b, place, free = np.inf, 1, 2, 0.0, False
    for side in range(3):
        first, second = 1 + side, 1 + (side + 1) % 3
        along, inside = _to_edge(found, 0, first, second)
        _set_edge(found, 0, first, second, along, False)
        square = _square(found)
        if square < best:
            best, a, b, place, free = square, first, second, along, inside
    _set_edge(found, 0, a, b, place, free)
    return (1 if free else 0), _square(found)


@njit(cache=True, error_model="numpy")
def _edge_edge(found: Nearest) -> tuple[int, float]:
    corner, weight, slope = found.corner, found.weight, found.slope
    uu, uv, vv = _along(corner, 0, 1, 0, 1), _along(corner, 0, 1, 2, 3), _along(corner, 2, 3, 2, 3)
    ru, rv = _along(corner, 2, 0, 0, 1), _along(corner, 2, 0, 2, 3)
    area = uu * vv - uv * uv
    if area > FLAT * uu * vv:
        s, t = (uv * rv - vv * ru) / area, (uu * rv - uv * ru) / area
        if 0.0 < s < 1.0 and 0.0 < t < 1.0:
            weight[0], weight[1], weight[2], weight[3] = 1.0 - s, s, t - 1.0, -t
            slope[0, 0], slope[0, 1], slope[1, 2], slope[1, 3] = -1.0, 1.0, 1.0, -1.0
            return 2, _square(found)
    best, node, place, free = np.inf, 0, 0.0, False
    for end in range(4):
        a = 2 if end < 2 else 0
        along, inside = _to_edge(found, end, a, a + 1)
        _set_edge(found, end, a, a + 1, along, False)
        square = _square(found)
        if square < best:
            best, node, place, free = square, end, along, inside
    a = 2 if node < 2 else 0
    _set_edge(found, node, a, a + 1, place, free)
    return (1 if free else 0), _square(found)


@njit(cache=True, error_model="numpy")
def closing(kind: int, way: Floats) -> float:
    """Most by which the parts of a pair may near each other, after their mean move is taken off, which is done."""
    own = 1 if kind == NODE_TRIANGLE else 2
    for j in range(3):
        mean = 0.25 * (way[0, j] + way[1, j] + way[2, j] + way[3, j])
        for i in range(4):
            way[i, j] -= mean
    mine, theirs = 0.0, 0.0
    for i in range(4):
        size = way[i, 0] ** 2 + way[i, 1] ** 2 + way[i, 2] ** 2
        if i < own:
            mine = max(mine, size)
        else:
            theirs = max(theirs, size)
    return np.sqrt(mine) + np.sqrt(theirs)
