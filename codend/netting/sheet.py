"""Flat sheets of netting, cut from an endless lattice: knots, bars, facets and edges, all told by counts.

A knot of diamond netting lies at (u, v): u half meshes across from the left end of the fore edge, v half meshes aft of
it, u + v even; bars lead aslant to (u +- 1, v + 1). In square netting u and v count bars and every place has a knot.
The fore and the aft edge run across. A side edge of diamond netting is cut as netmakers cut it, by steps: N, two rows
aft at the same u; B, along a bar; T, two half meshes across. Steps are spread evenly along an edge.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats, Ints

Counts = NDArray[np.int64]
EdgeName = Literal["fore", "aft", "left", "right"]
EDGES: Final[tuple[EdgeName, ...]] = ("fore", "aft", "left", "right")
Taper = Literal["both", "left", "right"]


@dataclass(frozen=True)
class Edge:
    """Knots along an edge: the fore and aft ones from left to right, the sides from fore to aft."""

    knots: Counts
    """(e,)."""
    place: Floats
    """Of each from 0 to 1, by steps of the cut, (e,)."""


@dataclass(frozen=True)
class Sheet:
    """A sheet by its lattice."""

    share: Floats
    """Place of every knot between the left and the right edge, and between the fore and the aft one, (k, 2)."""
    bars: Ints
    """(m, 2)."""
    outermost: NDArray[np.bool_]
    """Bars that lie along an edge as its last line; only square netting has any, (m,)."""
    facets: Ints
    """(f, 3); a mesh is covered by both of its divisions into triangles."""
    facet_weight: Floats
    """1, or 1/2 of those of whole meshes, (f,)."""
    meshes: Ints
    """Corners of whole meshes, walking round: fore, right, aft, left of a diamond one, (q, 4)."""
    edges: dict[EdgeName, Edge]


def diamond_sheet(across: int, aft: int, long: int, taper: Taper = "both") -> Sheet:
    """A sheet of diamond netting of so many meshes across its fore and its aft edge, and so many long.

    Args:
        across: meshes across the fore edge, from 0 on.
        aft: meshes across the aft edge, from 0 on; not 0 both.
        long: meshes from the fore to the aft edge.
        taper: which side edges take up the difference; of an odd one between both the left takes the half more that
            leaves its knots on the lattice.
    """
    rows, change = 2 * long, 2 * (across - aft)
    inward = {"left": change, "right": 0, "both": 2 * (change // 4)}[taper]
    left = _cut(0, inward, rows)
    right = _cut(2 * across, inward + 2 * aft, rows)
    edge_low, edge_high = _outline(left, rows, min), _outline(right, rows, max)
    # in the middle of an N step the last knot lies one further in
    low, high = edge_low + (edge_low + np.arange(rows + 1)) % 2, edge_high - (edge_high + np.arange(rows + 1)) % 2
    knots = np.array([(u, v) for v in range(rows + 1) for u in range(low[v], high[v] + 1, 2)])
    number = {(int(u), int(v)): k for k, (u, v) in enumerate(knots)}
    bars = [
        (k, number[u + step, v + 1]) for (u, v), k in number.items() for step in (-1, 1) if (u + step, v + 1) in number
    ]
    meshes, facets, weights = [], [], []
    for around in _middles(number):
        corners = [number.get(place, -1) for place in around]
        found = [k for k in corners if k >= 0]
        if len(found) == 4:
            meshes.append(found)
        elif len(found) == 3:
            facets.append(found)
            weights.append(1.0)
    edges = {
        "fore": [(u, 0) for u in range(0, 2 * across + 1, 2)],
        "aft": [(u, rows) for u in range(inward, inward + 2 * aft + 1, 2)],
        "left": left,
        "right": right,
    }
    wide = np.maximum(edge_high - edge_low, 1)
    share = np.stack([(knots[:, 0] - edge_low[knots[:, 1]]) / wide[knots[:, 1]], knots[:, 1] / rows], axis=1)
    along = {name: _edge([number[place] for place in path], path) for name, path in edges.items()}
    return _sheet(share, bars, np.zeros(len(bars), dtype=bool), meshes, facets, weights, along)


def square_sheet(across: int, long: int) -> Sheet:
    """A sheet of square netting of so many meshes across and long."""
    number = np.arange((across + 1) * (long + 1)).reshape(long + 1, across + 1)
    u, v = np.meshgrid(np.arange(across + 1), np.arange(long + 1))
    cross = np.stack([number[:, :-1], number[:, 1:]], axis=-1)
    down = np.stack([number[:-1], number[1:]], axis=-1)
    last_cross, last_down = np.zeros(cross.shape[:2], dtype=bool), np.zeros(down.shape[:2], dtype=bool)
    last_cross[[0, -1]] = last_down[:, [0, -1]] = True
    meshes = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    places = {
        "fore": [(x, 0) for x in range(across + 1)],
        "aft": [(x, long) for x in range(across + 1)],
        "left": [(0, y) for y in range(long + 1)],
        "right": [(across, y) for y in range(long + 1)],
    }
    along = {name: _edge([int(number[y, x]) for x, y in path], path) for name, path in places.items()}
    share = np.stack([u.ravel() / across, v.ravel() / long], axis=1)
    bars = np.concatenate([cross.reshape(-1, 2), down.reshape(-1, 2)])
    return _sheet(share, bars, np.concatenate([last_cross.ravel(), last_down.ravel()]), meshes, [], [], along)


def _sheet(share, bars, outermost, meshes, facets, weights, edges) -> Sheet:  # type: ignore[no-untyped-def]
    whole = np.array(meshes, dtype=np.int32).reshape(-1, 4)
    # no diagonal is special
    halves = [whole[:, order] for order in ([0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3])]
    return Sheet(
        share,
        np.array(bars, dtype=np.int32).reshape(-1, 2),
        outermost,
        np.concatenate([*halves, np.array(facets, dtype=np.int32).reshape(-1, 3)]),
        np.append(np.full(4 * len(whole), 0.5), weights),
        whole,
        edges,
    )


def _cut(start: int, end: int, rows: int) -> list[tuple[int, int]]:
    """Knots of a side edge from (start, 0) to (end, rows), by N, B and T steps that are spread evenly."""
    across = abs(end - start)
    side = 1 if end > start else -1
    if rows >= across:
        steps, other = [*_spread(across, (rows - across) // 2)], (0, 2)
    else:  # a knot with T steps on either side would hang on nothing at the ends
        steps, other = [True, *_spread(rows - 2, (across - rows) // 2), True], (2 * side, 0)
    u, v = start, 0
    path = [(u, v)]
    for is_bar in steps:
        du, dv = (side, 1) if is_bar else other
        u, v = u + du, v + dv
        path.append((u, v))
    return path


def _spread(some: int, others: int) -> Iterator[bool]:
    """True ``some`` times and False ``others`` times, as evenly as may be, and the same read backwards or nearly so."""
    total, done = some + others, 0
    for step in range(total):
        due = (2 * (step + 1) * some + total) // (2 * total)
        yield due > done
        done = due


def _outline(path: list[tuple[int, int]], rows: int, outermost) -> Counts:  # type: ignore[no-untyped-def]
    """Where an edge lies in every row, (rows + 1,); of several steps in a row the last towards the edge."""
    found: dict[int, int] = {}
    for u, v in path:
        found[v] = outermost(found.get(v, u), u)
    return np.array([found.get(v, found.get(v - 1)) for v in range(rows + 1)], dtype=np.int64)


def _middles(number: dict[tuple[int, int], int]) -> Iterator[tuple[tuple[int, int], ...]]:
    """Places of the four corners about every place that may be the middle of a mesh, walking round from the fore."""
    middles = sorted({(u + du, v + dv) for u, v in number for du, dv in ((0, 1), (0, -1), (1, 0), (-1, 0))})
    for u, v in middles:
        yield (u, v - 1), (u + 1, v), (u, v + 1), (u - 1, v)


def _edge(knots: list[int], path: list[tuple[int, int]]) -> Edge:
    steps = np.abs(np.diff(np.array(path), axis=0)).max(axis=1) if len(path) > 1 else np.zeros(0)
    reached = np.concatenate([[0.0], np.cumsum(steps)])
    return Edge(np.array(knots, dtype=np.int64), reached / max(reached[-1], 1.0))
