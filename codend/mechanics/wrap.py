"""Netting that lies over other netting, as a second layer does, and moves with it: kernels of a load.

It is laid over cells of the net below, each a base e along a ring of knots and a height h from there to the next ring,
both sums of its nodes' places with given weights. It is drawn out evenly over a cell, and its meshes there have the
half diagonals

    T = (c |e| - a) e / |e|,    Q = (|h| / n - l) h / |h|

c its half meshes to a metre of base, n its rows over the height, a and l what its knots take across and along it. Its
bars Q + T and Q - T, of length b, pull by EA beyond it; in square mesh 2 T and Q do, apart. Where they are shorter the
layer carries nothing.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.images import add_turned_back, turned
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern, add_turned_block
from codend.net.net import Floats

ROUND, ACROSS, ROWS, ALONG, BAR, STIFFNESS, COUNT, SQUARE = range(8)
"""Columns of ``Net.wrap_law``: c (1/m), a, n, l, b, EA, bars of either way, and 1 of square mesh."""


@njit(cache=True)
def write_spans(position: Floats, structure: Structure, cell: int, span: Floats) -> None:
    """Write base and height of a cell, (2, 3)."""
    span[:] = 0.0
    weight = structure.wrap_weight[cell]
    for i in range(weight.shape[1]):
        node = structure.wrap_node[cell, i]
        y, z = turned(position[node, 1], position[node, 2], structure.wrap_image[cell, i], structure.rotations)
        for k in range(2):
            span[k, 0] += weight[k, i] * position[node, 0]
            span[k, 1] += weight[k, i] * y
            span[k, 2] += weight[k, i] * z


@njit(cache=True, error_model="numpy")
def per_span(law: Floats, way: int) -> tuple[float, float]:
    """How much of a span is a half diagonal, and what knots take of that."""
    return (law[ROUND], law[ACROSS]) if way == 0 else (1.0 / law[ROWS], law[ALONG])


@njit(cache=True, error_model="numpy")
def write_diagonals(law: Floats, span: Floats, diagonal: Floats) -> None:
    """Write T and Q, (2, 3)."""
    for k in range(2):
        per, knot = per_span(law, k)
        length = np.sqrt(span[k, 0] ** 2 + span[k, 1] ** 2 + span[k, 2] ** 2)
        factor = max(per - knot / length, 0.0) if length > 0.0 else 0.0
        for i in range(3):
            diagonal[k, i] = factor * span[k, i]


@njit(cache=True)
def parts(law: Floats, bar: int) -> tuple[float, float]:
    """How much of T and of Q is in the first or the second bar of a mesh."""
    if law[SQUARE] > 0.0:
        return (2.0, 0.0) if bar == 0 else (0.0, 1.0)
    return (1.0, 1.0) if bar == 0 else (-1.0, 1.0)


@njit(cache=True, error_model="numpy")
def write_bar(law: Floats, bar: int, diagonal: Floats, vector: Floats) -> float:
    """Write the vector of the first or the second bar of a mesh, (3,); returns its length."""
    of_t, of_q = parts(law, bar)
    square = 0.0
    for i in range(3):
        vector[i] = of_t * diagonal[0, i] + of_q * diagonal[1, i]
        square += vector[i] ** 2
    return np.sqrt(square)


@njit(cache=True)
def is_point(diagonal: Floats) -> bool:
    """Whether knots take all of a span, (3,)."""
    return diagonal[0] == 0.0 and diagonal[1] == 0.0 and diagonal[2] == 0.0


@njit(cache=True)
def squared_and_along(span: Floats, slope: Floats) -> tuple[float, float]:
    """The square of a span's length, and its product with a derivative, (3,) both."""
    square, along = 0.0, 0.0
    for i in range(3):
        square += span[i] ** 2
        along += span[i] * slope[i]
    return square, along


@njit(cache=True, error_model="numpy")
def write_slopes(law: Floats, diagonal: Floats, slope: Floats) -> float:
    """Write the derivatives of the energy by T and Q, N, (2, 3); returns the largest tension of a bar, N."""
    slope[:] = 0.0
    most, vector = 0.0, np.empty(3)
    rate = law[COUNT] * law[STIFFNESS] / law[BAR]
    for bar in range(2):
        length = write_bar(law, bar, diagonal, vector)
        if length <= law[BAR]:
            continue
        pull = rate * (length - law[BAR]) / length
        most = max(most, law[STIFFNESS] * (length / law[BAR] - 1.0))
        for k in range(2):
            of = parts(law, bar)[k]
            for i in range(3):
                slope[k, i] += of * pull * vector[i]
    return most


@njit(cache=True, error_model="numpy")
def turn_to_spans(law: Floats, span: Floats, diagonal: Floats, slope: Floats) -> None:
    """Make derivatives by T and Q those by base and height, in place, (2, 3).

    By a span s of a half diagonal  per s - knot s / |s|  derivatives p by that are  per p - knot (p - s (p s) / s^2) /
    |s|  by s.
    """
    for k in range(2):
        if is_point(diagonal[k]):
            slope[k] = 0.0
            continue
        per, knot = per_span(law, k)
        square, along = squared_and_along(span[k], slope[k])
        shortened = knot / np.sqrt(square)
        for i in range(3):
            slope[k, i] = per * slope[k, i] - shortened * (slope[k, i] - span[k, i] * along / square)


@njit(cache=True, error_model="numpy")
def of_cells(position: Floats, structure: Structure) -> tuple[Floats, Floats, Floats, Floats]:
    """Base and height of every cell, T and Q, the pull along base and height, N, (w, 2, 3) each, and how far bars go.

    The last is the largest length of a bar over its own, (w,): from 1 on it pulls.
    """
    cells = len(structure.wrap_law)
    span, diagonal, pull = np.zeros((cells, 2, 3)), np.zeros((cells, 2, 3)), np.zeros((cells, 2, 3))
    drawn, vector = np.zeros(cells), np.empty(3)
    for cell in range(cells):
        law = structure.wrap_law[cell]
        write_spans(position, structure, cell, span[cell])
        write_diagonals(law, span[cell], diagonal[cell])
        write_slopes(law, diagonal[cell], pull[cell])
        turn_to_spans(law, span[cell], diagonal[cell], pull[cell])
        for bar in range(2):
            drawn[cell] = max(drawn[cell], write_bar(law, bar, diagonal[cell], vector) / law[BAR])
    return span, diagonal, pull, drawn


@njit(cache=True, error_model="numpy")
def add_force(position: Floats, structure: Structure, force: Floats) -> None:
    """Add the pull of layers to the nodal forces, N."""
    span, diagonal, slope = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3))
    for cell in range(len(structure.wrap_law)):
        law, weight = structure.wrap_law[cell], structure.wrap_weight[cell]
        write_spans(position, structure, cell, span)
        write_diagonals(law, span, diagonal)
        if write_slopes(law, diagonal, slope) == 0.0:
            continue
        turn_to_spans(law, span, diagonal, slope)
        for i in range(weight.shape[1]):
            base, height = -weight[0, i], -weight[1, i]
            add_turned_back(
                force,
                structure.wrap_node[cell, i],
                base * slope[0, 0] + height * slope[1, 0],
                base * slope[0, 1] + height * slope[1, 1],
                base * slope[0, 2] + height * slope[1, 2],
                structure.wrap_image[cell, i],
                structure.rotations,
            )


@njit(cache=True, error_model="numpy")
def _write_curvature(law: Floats, span: Floats, diagonal: Floats, slope: Floats, curvature: Floats) -> None:
    """Write the second derivatives of the energy by base and height, (2, 2, 3, 3); ``slope`` is by T and Q.

    With U by T and Q, and J = per I - knot (I - s s^T / s^2) / |s|, those by the spans are J U'' J, and of one span
    knot (p_ s^T / |s| + s p_^T / |s| + (p s) / |s| (I - s s^T / s^2)) / s^2 besides, p_ what of p is across s.
    """
    curvature[:] = 0.0
    rate = law[COUNT] * law[STIFFNESS] / law[BAR]
    vector, turning, half = np.empty(3), np.zeros((2, 3, 3)), np.empty((3, 3))
    for k in range(2):
        if is_point(diagonal[k]):
            continue
        per, knot = per_span(law, k)
        square, along = squared_and_along(span[k], slope[k])
        length = np.sqrt(square)
        for i in range(3):
            for j in range(3):
                one = 1.0 if i == j else 0.0
                across = one - span[k, i] * span[k, j] / square
                turning[k, i, j] = per * one - knot / length * across
                over_i, over_j = slope[k, i] - span[k, i] * along / square, slope[k, j] - span[k, j] * along / square
                bent = over_i * span[k, j] + span[k, i] * over_j + along * across
                curvature[k, k, i, j] = knot * bent / (square * length)
    for bar in range(2):
        length = write_bar(law, bar, diagonal, vector)
        if length <= law[BAR]:
            continue
        q = rate * (length - law[BAR]) / length
        k2 = (rate - q) / (length * length)
        for a in range(2):
            of_a = parts(law, bar)[a]
            for i in range(3):
                for j in range(3):
                    half[i, j] = 0.0
                    for m in range(3):
                        stiff = k2 * vector[m] * vector[j] + (q if m == j else 0.0)
                        half[i, j] += of_a * turning[a, i, m] * stiff
            for b in range(2):
                of_b = parts(law, bar)[b]
                for i in range(3):
                    for j in range(3):
                        for m in range(3):
                            curvature[a, b, i, j] += of_b * half[i, m] * turning[b, m, j]


@njit(cache=True, error_model="numpy")
def add_tangent(position: Floats, structure: Structure, pattern: Pattern, blocks: Floats) -> None:
    """Add the layers' part to the tangent."""
    span, diagonal, slope = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3))
    curvature, h = np.empty((2, 2, 3, 3)), np.empty((3, 3))
    image, rotations = structure.wrap_image, structure.rotations
    for cell in range(len(structure.wrap_law)):
        law, weight = structure.wrap_law[cell], structure.wrap_weight[cell]
        write_spans(position, structure, cell, span)
        write_diagonals(law, span, diagonal)
        if write_slopes(law, diagonal, slope) == 0.0:
            continue
        _write_curvature(law, span, diagonal, slope, curvature)
        for i in range(weight.shape[1]):
            for j in range(weight.shape[1]):
                for m in range(3):
                    for n in range(3):
                        h[m, n] = (
                            weight[0, i] * weight[0, j] * curvature[0, 0, m, n]
                            + weight[0, i] * weight[1, j] * curvature[0, 1, m, n]
                            + weight[1, i] * weight[0, j] * curvature[1, 0, m, n]
                            + weight[1, i] * weight[1, j] * curvature[1, 1, m, n]
                        )
                slot = pattern.wrap_slot[cell, i, j]
                add_turned_block(blocks, slot, 1.0, h, image[cell, i], image[cell, j], rotations)


@njit(cache=True, error_model="numpy")
def add_bound(position: Floats, structure: Structure, bound: Floats) -> None:
    """Add the layers' part to the bound on each node's row of the stiffness, N/m."""
    for cell in range(len(structure.wrap_law)):
        law, weight = structure.wrap_law[cell], structure.wrap_weight[cell]
        rate = law[COUNT] * law[STIFFNESS] / law[BAR]
        base, height = 2.0 * law[ROUND], 2.0 / law[ROWS]
        whole = 0.0
        for i in range(weight.shape[1]):
            whole += base * abs(weight[0, i]) + height * abs(weight[1, i])
        for i in range(weight.shape[1]):
            own = base * abs(weight[0, i]) + height * abs(weight[1, i])
            bound[structure.wrap_node[cell, i]] += rate * own * whole
