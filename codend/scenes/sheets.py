"""Sheets of netting laid out between their corners, and which of their knots are one with which other nodes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats
from codend.netting.sheet import EDGES, Edge, EdgeName
from codend.scenes.netting_tables import SeamTable, SheetTable

Counts = NDArray[np.int64]
Pairs = list[tuple[int, int]]


@dataclass(frozen=True)
class Laced:
    """The stretch of an edge that hangs on one rope."""

    edge: Edge
    rope: str
    forward: bool
    """Whether the rope runs as the edge does."""
    first: int
    """Place of its knots in the edge: from this one."""
    last: int

    @property
    def bars(self) -> int:
        """Bars that the rope has for a node at every knot."""
        return self.last - self.first

    def pairs(self, knots: Counts, nodes: Counts) -> Pairs:
        """Knots, (e,) of the edge, and the nodes of the rope, (r,), that are one."""
        along = nodes if self.forward else nodes[::-1]
        place = self.edge.place[self.first : self.last + 1]
        share = (place - place[0]) / (place[-1] - place[0])
        return _paired(knots[self.first : self.last + 1], along[np.rint(share * (len(along) - 1)).astype(int)])


def laced(sheet: SheetTable, ends: Mapping[str, tuple[str, str]], lengths: Mapping[str, float]) -> list[Laced]:
    """What the edges of a sheet hang on, knots shared out among ropes end to end by the lengths of these."""
    found = []
    for name in EDGES:
        ropes, edge = sheet.ropes_of(name), sheet.sheet.edges[name]
        here = sheet.corner_names(name)[0]
        reached = np.concatenate([[0.0], np.cumsum([lengths[rope] for rope in ropes])])
        bounds = np.searchsorted(edge.place, reached / max(reached[-1], 1e-300) - 0.5 / max(len(edge.place) - 1, 1))
        for number, rope in enumerate(ropes):
            forward = ends[rope][0] == here
            here = ends[rope][1 if forward else 0]
            found.append(Laced(edge, rope, forward, int(bounds[number]), int(bounds[number + 1])))
    return found


def laid(sheet: SheetTable, places: Mapping[str, Floats], curves: Sequence[tuple[Laced, Floats]]) -> Floats:
    """Knots of a sheet between its corners and edges, (k, 3): a Coons patch over edges as the ropes on them lie.

    Args:
        sheet: the sheet.
        places: of points by name.
        curves: what its edges hang on, and the nodes of those ropes, (r, 3).
    """
    a, b, c, d = (np.array(places[on] if isinstance(on, str) else on, dtype=float) for on in sheet.corners)
    share = sheet.sheet.share
    u, v = share[:, :1], share[:, 1:]
    found: Floats = (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * d + u * c)
    ends: dict[EdgeName, tuple[Floats, Floats, int, Floats]]
    ends = {"fore": (a, b, 0, 1.0 - v), "aft": (d, c, 0, v), "left": (a, d, 1, 1.0 - u), "right": (b, c, 1, u)}
    for name, (first, last, along, weight) in ends.items():
        parts = [part for part, _ in curves if part.edge is sheet.sheet.edges[name]]
        nodes = [line for part, line in curves if part.edge is sheet.sheet.edges[name]]
        for part, line in zip(parts, nodes, strict=True):
            low, high = part.edge.place[part.first], part.edge.place[part.last]
            on = (share[:, along] >= low) & (share[:, along] <= high)
            at = (share[on, along] - low) / (high - low)
            way = line if part.forward else line[::-1]
            curve = np.stack([np.interp(at, np.linspace(0.0, 1.0, len(way)), way[:, i]) for i in range(3)], axis=1)
            straight = first + share[on, along][:, None] * (last - first)
            found[on] += weight[on] * (curve - straight)
    for edge in EDGES:
        if sheet.hold_of(edge) == "symmetry":
            found[sheet.sheet.edges[edge].knots, 1] = 0.0
    return found


def at_points(sheet: SheetTable, knots: Counts, node_of: Mapping[str, int]) -> Pairs:
    """Knots of a sheet, (k,), and nodes of points that are one: its corners, and edges that are gathered."""
    found: Pairs = []
    for name in EDGES:
        edge, (first, last) = sheet.sheet.edges[name], sheet.corner_names(name)
        if first is not None and first == last:
            found += [(int(knots[k]), node_of[first]) for k in edge.knots]
        for corner, k in ((first, edge.knots[0]), (last, edge.knots[-1])):
            if corner is not None:
                found.append((int(knots[k]), node_of[corner]))
    return found


def sewn(seam: SeamTable, sheets: Sequence[SheetTable], knots: Sequence[Counts], positions: Floats) -> Pairs:
    """Knots of edges that are one: those at the same place along them, in the ratio of counts where these differ.

    The first edge is sewn to the others end to end; edges run against each other where that brings their ends nearer at
    the start.
    """
    number = {sheet.name: index for index, sheet in enumerate(sheets)}

    def side(named: Sequence[tuple[str, str]]) -> tuple[Counts, Floats]:
        found, places, reached = [], [], 0.0
        for name, edge in named:
            which: EdgeName = next(e for e in EDGES if e == edge)
            sheet = sheets[number[name]]
            own, length = sheet.sheet.edges[which], sheet.reach_m(which)
            found.append(knots[number[name]][own.knots])
            places.append(reached + length * own.place)
            reached += length
        return np.concatenate(found), np.concatenate(places) / reached

    named = seam.named
    sides = side(named[:1]), side(named[1:])
    (one, place), (other, other_place) = sorted(sides, key=lambda part: -len(part[0]))
    straight = [np.linalg.norm(positions[one[i]] - positions[other[j]]) for i, j in ((0, 0), (-1, -1))]
    crossed = [np.linalg.norm(positions[one[i]] - positions[other[j]]) for i, j in ((0, -1), (-1, 0))]
    if sum(crossed) < sum(straight):
        other, other_place = other[::-1], 1.0 - other_place[::-1]
    apart = np.abs(place[:, None] - other_place[None, :])
    nearest = apart.argmin(axis=1)
    left = np.setdiff1d(np.arange(len(other)), nearest)
    return _paired(one, other[nearest]) + _paired(one[apart.argmin(axis=0)[left]], other[left])


def _paired(first: Counts, second: Counts) -> Pairs:
    return list(zip(first.tolist(), second.tolist(), strict=True))


def merged(count: int, pairs: Pairs, positions: Floats, firm: int) -> tuple[Counts, Floats]:
    """New numbers of nodes of which some are one, (count,), and where those are.

    Args:
        count: number of nodes.
        pairs: nodes that are one.
        positions: of the nodes, (count, 3).
        firm: nodes below this number stay where they are; others meet half way.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ends = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, group = connected_components(graph, directed=False)
    _, first, joined = np.unique(group, return_index=True, return_inverse=True)
    # numbered by the lowest of each, so that points and ropes keep their order
    rank = np.argsort(np.argsort(first))
    number: Counts = rank[joined].astype(np.int64)
    summed = np.stack([np.bincount(number, positions[:, i]) for i in range(3)], axis=1)
    places: Floats = summed / np.bincount(number)[:, None]
    lowest = np.sort(first)
    places[lowest < firm] = positions[lowest[lowest < firm]]
    return number, places
