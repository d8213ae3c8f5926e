"""Windows: a hole cut into the netting of a section of a full net, and a piece of other netting sewn into it.

The hole's fore and aft edges run along a row of knots, its sides along a column of them, so that no bar is cut in two.
Along its fore and aft edge the netting that has fewer knots gives those of the seam; the other's are taken up, two by
two, in the ratio of the counts. Along the sides, where taking up would make one netting shorter, edges of as many knots
are sewn knot to knot. Else the window's knots are sewn to the lattice's edge bars where they lie when both edges are
stretched; but square netting with more knots, held by a bar along its side, leaves those free that are not nearest
to one of the other's. The netting along the sides, half a mesh of either piece, is covered from knot to knot.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats
from codend.netting.knots import LEFT, RIGHT, Knots
from codend.netting.lattice import Counts
from codend.netting.parts import Parts, RowShape
from codend.netting.patch import AFT, FORE, Patch, patch_of
from codend.plan.tables import Netting

Chain = list[tuple[float, list[int]]]
"""Nodes along one side of a seam: how far down, as a share, and the fore and the aft one."""
NEAR_A_KNOT = 0.15
"""Of a bar: how near to a knot of the lattice one of the window is sewn to the knot itself."""
OFF_ROWS = -2
"""Row of a node that lies in no ring of knots because it is a window's."""


@dataclass(frozen=True)
class Opening:
    """A hole in the lattice of a full net."""

    fore: int
    """Row of its fore edge."""
    aft: int
    ahead: Counts
    """Column of its left edge in every row, counted in the columns of the band ahead of it, (bands + 1,)."""
    behind: Counts
    """The same counted in those of the band behind it: where netting tapers the seam has moved, (bands + 1,)."""
    across: int
    """Columns."""
    side_rad: float
    """Azimuth of what keeps its place in all rows: the hole's own middle, or in netting that tapers its panel's."""
    beside: float
    """Columns from there to the hole's middle."""

    def column(self, row: int, ahead: bool) -> int:
        """Column of its left edge in a row, in the columns of the band ahead of it or behind."""
        return int((self.ahead if ahead else self.behind)[row])


@dataclass
class LetIn:
    """A window as it is written: its own parts, and what becomes of the lattice's nodes."""

    netting: Netting
    opening: Opening
    patch: Patch
    bars: list[NDArray] = field(default_factory=list)
    facets: list[NDArray] = field(default_factory=list)
    weights: list[Floats] = field(default_factory=list)
    meshes: list[NDArray] = field(default_factory=list)
    splits: list[tuple[int, int, float, int]] = field(default_factory=list)
    """Both ends of a bar of the lattice, and a node of the window's that is sewn to it, how far along as a share."""
    alias: dict[int, int] = field(default_factory=dict)
    """Nodes of the lattice that are taken up, and those they are taken up by."""

    def row(self, of_patch: float) -> float:
        """Place among the lattice's rows of a row of the window."""
        return self.opening.fore + (self.opening.aft - self.opening.fore) * of_patch / self.patch.rows

    def band(self, fore: float, aft: float) -> int:
        """Band that what lies between two places is counted to; of a row, the one ahead."""
        middle = 0.5 * (fore + aft)
        band = int(np.floor(middle + 1e-9)) if aft > fore else int(np.ceil(middle - 1e-9)) - 1
        return min(max(band, self.opening.fore), self.opening.aft - 1)

    def add_bars(self, first: Counts, second: Counts, band: int, is_knot: bool) -> None:
        """Add bars that have two ends."""
        ends = np.stack([first, second], axis=1)
        ends = ends[first != second]
        rest = np.tile([0, band, int(is_knot)], (len(ends), 1))
        self.bars.append(np.concatenate([ends, rest], axis=1))

    def add_facets(self, corners: Sequence[Counts], weight: float, fore: float, aft: float) -> None:
        """Add triangles, each shared out among the bands that it reaches over."""
        nodes = np.stack([np.atleast_1d(corner) for corner in corners], axis=1)
        nodes = nodes[(nodes[:, 0] != nodes[:, 1]) & (nodes[:, 1] != nodes[:, 2]) & (nodes[:, 2] != nodes[:, 0])]
        for band, share in self._shares(fore, aft):
            rest = np.tile([0, 0, 0, band], (len(nodes), 1))
            self.facets.append(np.concatenate([nodes, rest], axis=1))
            self.weights.append(np.full(len(nodes), weight * share))

    def add_quadrangles(self, corners: Sequence[Counts], fore: float, aft: float) -> None:
        """Cover quadrangles by both divisions into triangles, each at half weight."""
        a, b, c, d = corners
        for triangle in ((a, b, c), (a, c, d), (a, b, d), (b, c, d)):
            self.add_facets(triangle, 0.5, fore, aft)

    def _shares(self, fore: float, aft: float) -> Iterator[tuple[int, float]]:
        if aft - fore < 1e-9:
            yield self.band(fore, fore), 1.0
            return
        for band in range(int(np.floor(fore + 1e-9)), int(np.ceil(aft - 1e-9))):
            yield band, (min(aft, band + 1.0) - max(fore, float(band))) / (aft - fore)


def shared_knots(one: int, other: int) -> list[tuple[int, int]]:
    """Pairs of knots of two edges, of so many meshes each, that are sewn to each other; ends to ends.

    Every knot of the edge with more is paired with one of the other. What lies evenly between two goes to the one
    nearer to an end, so that the pairs are the same from either end.
    """
    if one < other:
        return [(i, j) for j, i in shared_knots(other, one)]

    def nearest(knot: int) -> int:
        place = knot * other
        up, down = (2 * place + one) // (2 * one), -((one - 2 * place) // (2 * one))
        return up if 2 * knot > one else down

    return [(knot, nearest(knot)) for knot in range(one + 1)]


def nearest_only(pairs: list[tuple[int, int]], one: int, other: int) -> list[tuple[int, int]]:
    """Of the pairs that share a knot of the edge with fewer, the one that lies nearest to it."""
    best: dict[int, tuple[int, int]] = {}
    few = 1 if one >= other else 0
    for pair in pairs:
        off = abs(pair[0] * other - pair[1] * one)
        held = best.get(pair[few])
        if held is None or off < abs(held[0] * other - held[1] * one):
            best[pair[few]] = pair
    return sorted(best.values())


def let_in(knots: Knots, opening: Opening, netting: Netting, wide: int, deep: int, first: int) -> LetIn:
    """Sew a piece of so many meshes across and along into an opening; its own nodes are numbered from ``first``."""
    lattice = knots.lattice
    host = lattice.section(opening.fore)
    rows = netting.rows_per_mesh * deep
    host_deep = (opening.aft - opening.fore) // host.rows_per_mesh
    ends = {"fore": shared_knots(opening.across, wide)}
    sides = _sewn_sides(host, host_deep, netting, deep)
    of_end = {c: h for h, c in nearest_only(ends["fore"], opening.across, wide)} | {
        c: h for h, c in ends["fore"] if wide > opening.across
    }
    of_side = {i: j for j, i in sides}
    stepped = netting.rows_per_mesh

    def lattice_node(end: int, side: int, row: int, column: int) -> int:
        # those of the band ahead are counted where the netting behind has others
        ahead = end == FORE or row == opening.aft
        at, counted = np.array([row]), np.array([opening.column(row, ahead) + column])
        if end == FORE:
            found = knots.fore(side, at, counted)
        else:
            found = knots.ring(side, at, counted, lattice.columns[at - 1] if ahead else lattice.columns[at])
        return int(found.node[0])

    def sewn(end: int, side: int, row: int, half: int) -> int | None:
        at_side = half in (0, 2 * wide)
        left = half == 0
        if row in (0, rows):
            if row == rows and end == FORE and not at_side and netting.knot_along_m > 0.0:
                return None
            column = of_end[half // 2]
            where = opening.fore if row == 0 else opening.aft
            return lattice_node(FORE if at_side and end == FORE and row == rows else AFT, side, where, column)
        if not at_side or row // stepped not in of_side:
            return None  # its own, or sewn to a bar
        place = of_side[row // stepped]
        where = opening.fore + place * host.rows_per_mesh
        column = 0 if left else opening.across
        if where in (opening.fore, opening.aft):
            end = AFT if where == opening.fore else FORE
        return lattice_node(end, side, where, column)

    patch = patch_of(netting, wide, rows, first, sewn)
    window = LetIn(netting, opening, patch)
    edges = host.kind.staggered or deep != host_deep, host.kind.staggered
    for (one, other), fore, aft in patch.twines(*edges):
        window.add_bars(one, other, window.band(window.row(fore), window.row(aft)), False)
    for one, other, row in patch.knots:
        window.add_bars(np.array([one]), np.array([other]), window.band(window.row(row), window.row(row)), True)
    for corners, fore, aft in patch.quadrangles():
        window.add_quadrangles(corners, window.row(fore), window.row(aft))
    for sides_of, middle in patch.meshes():
        nodes = [corner for side in sides_of for corner in side]
        place = window.row(middle)
        row = round(place) if host.kind.staggered else int(place)
        row = min(max(row, 1), lattice.bands - 1)
        rest = np.tile([0] * 8 + [row], (len(nodes[0]), 1))
        window.meshes.append(np.concatenate([np.stack(nodes, axis=1), rest], axis=1))
    _take_up(window, lattice_node, ends["fore"], of_end)
    for right in (False, True):
        chain = _side_of_lattice(knots, opening, right, host)
        pairs = [(host.rows_per_mesh * j, stepped * i) for j, i in sides]
        if len(sides) < 1 + min(host_deep, deep):
            chain, pairs = _sewn_to_bars(window, chain, deep, right)
        _cover(window, chain, patch.side(right), pairs, right)
    return window


def _sewn_sides(host: Netting, host_deep: int, netting: Netting, deep: int) -> list[tuple[int, int]]:
    """Pairs of knots of both side edges that are one; the corners alone where the window is sewn to bars."""
    if host_deep == deep:
        return [(i, i) for i in range(deep + 1)]
    barred = netting if deep > host_deep else host
    if not barred.kind.staggered:
        return nearest_only(shared_knots(host_deep, deep), host_deep, deep)
    return [(0, 0), (host_deep, deep)]


def _sewn_to_bars(window: LetIn, lattice: Chain, deep: int, right: bool) -> tuple[Chain, list[tuple[int, int]]]:
    """The lattice's side with the window's knots on its bars, and pairs of what is one in both chains."""
    bars, steps, patch = len(lattice) - 1, window.netting.rows_per_mesh, window.patch
    facing, edge = (RIGHT, 2 * patch.wide) if right else (LEFT, 0)
    chain, pairs = list(lattice), []
    for knot in range(1, deep):
        place = knot * bars / deep
        bar, share = int(place), place - int(place)
        t, (fore, aft) = knot / deep, (int(patch.nodes[end, facing, steps * knot, edge]) for end in (FORE, AFT))
        if min(share, 1.0 - share) < NEAR_A_KNOT:
            there = lattice[round(place)][1]
            window.alias.update({fore: there[FORE], aft: there[AFT]} if fore != aft else {fore: there[AFT]})
            pairs.append((lattice[round(place)][0], steps * knot))
            continue
        window.splits.append((lattice[bar][1][AFT], lattice[bar + 1][1][FORE], share, aft))
        chain.append((t, [fore, aft]))
        pairs.append((t, steps * knot))
    chain.sort(key=lambda node: node[0])
    down = [node[0] for node in chain]
    inner = [(down.index(t), i) for t, i in pairs]
    # the lattice's own netting ends at its bars as they were: what a knot draws aside is covered as well
    _cover(window, lattice, chain, [(i, down.index(t)) for i, (t, _) in enumerate(lattice)], right)
    return chain, [(0, 0), *inner, (len(chain) - 1, patch.rows)]


def _take_up(
    window: LetIn, node: Callable[[int, int, int, int], int], ends: list[tuple[int, int]], of_end: dict[int, int]
) -> None:
    """Knots of the lattice's fore and aft edge that share one of the window, and the one that stands for them."""
    opening = window.opening
    for h, c in ends:
        for row in (opening.fore, opening.aft):
            for side in (LEFT, RIGHT):
                one, other = (node(AFT, side, row, place) for place in (h, of_end[c]))
                if one != other:
                    window.alias[one] = other


def _side_of_lattice(knots: Knots, opening: Opening, right: bool, host: Netting) -> Chain:
    """Nodes of the lattice nearest to a side edge of the hole, from the fore end."""
    chain: Chain = []
    edge = opening.across if right else 0
    facing = RIGHT if right else LEFT
    rows = opening.aft - opening.fore
    for row in range(opening.fore, opening.aft + 1):
        at, beside = np.array([row]), (row - opening.fore) % host.rows_per_mesh == 1
        from_edge, side = edge, facing
        if beside:
            from_edge += int(knots.lattice.shift[row - 1]) - (0 if right else 1)
            side = LEFT if right else RIGHT
        ahead, behind = (np.array([opening.column(row, ahead) + from_edge]) for ahead in (True, False))
        if row == opening.fore:
            node = int(knots.aft(side, at, behind).node[0])
            both = [node, node]
        elif row == opening.aft:
            node = int(knots.fore(side, at, ahead).node[0])
            both = [node, node]
        else:
            both = [int(knots.fore(side, at, ahead).node[0]), int(knots.aft(side, at, behind).node[0])]
        chain.append(((row - opening.fore) / rows, both))
    return chain


def _cover(window: LetIn, lattice: Chain, patch: Chain, pairs: list[tuple[int, int]], right: bool) -> None:
    """Cover the netting between the two chains of a side, from one shared knot to the next."""
    opening = window.opening
    patch = [(t, [nodes[AFT]] * 2 if t == 0.0 else [nodes[FORE]] * 2 if t == 1.0 else nodes) for t, nodes in patch]
    for (j, i), (j_next, i_next) in pairwise(pairs):
        one, other = _between(lattice, j, j_next), _between(patch, i, i_next)
        a = b = 0
        while a < len(one) - 1 or b < len(other) - 1:
            following = [chain[k + 1][0] if k < len(chain) - 1 else np.inf for chain, k in ((one, a), (other, b))]
            step_one, step_other = following[0] <= following[1] + 1e-9, following[1] <= following[0] + 1e-9
            to = a + step_one, b + step_other
            h, p, h_next, p_next = one[a], other[b], one[to[0]], other[to[1]]
            left, right_, right_next, left_next = (p, h, h_next, p_next) if right else (h, p, p_next, h_next)
            places = [opening.fore + (opening.aft - opening.fore) * node[1] for node in (h, p, h_next, p_next)]
            corners = [np.array([node[2]]) for node in (left, right_, right_next, left_next)]
            window.add_quadrangles(corners, min(places), max(places))
            a, b = to


def _between(chain: Chain, start: int, end: int) -> list[tuple[float, float, int]]:
    """Nodes from one shared knot to the next: how far along, as a share, how far down the whole side, and their number.

    A knot of two nodes takes no part of the way: its nodes are told apart by a hair.
    """
    found: list[tuple[float, float, int]] = []
    for number in range(start, end + 1):
        t, (fore, aft) = chain[number]
        share = (number - start) / max(end - start, 1)
        if number > start:
            found.append((share, t, fore))
        if number < end or start == end:
            found.append((share + 1e-3, t, aft))
    return found


def cut_out(parts: Parts, knots: Knots, opening: Opening, azimuth: Floats, node_row: NDArray) -> None:
    """Take out of the parts of a full net what lies within an opening.

    Args:
        parts: of the whole net.
        knots: of the whole net.
        opening: the hole.
        azimuth: of the lattice's nodes as they were written, without the turn of the whole net, rad, (n,).
        node_row: see ``Bag.node_row``.
    """
    lattice = knots.lattice
    away = (azimuth - opening.side_rad + np.pi) % (2.0 * np.pi) - np.pi
    step = _steps(knots, opening)

    def off(nodes: NDArray) -> Floats:
        """How far the middles of things lie from the middle of the hole, columns, (k,)."""
        on_axis = nodes == knots.codline
        first = away[np.where(on_axis, nodes[:, ::-1], nodes)[:, :1]]
        turned = (away[nodes] - first + np.pi) % (2.0 * np.pi) - np.pi + first
        columns = turned / step[nodes] - opening.beside
        return np.abs((columns * ~on_axis).sum(axis=1) / (~on_axis).sum(axis=1))

    half = 0.5 * opening.across
    for index, bars in enumerate(parts.bars):
        rows = node_row[bars[:, :2]]
        of_the_edge = (rows == opening.aft).all(axis=1)
        within = (bars[:, 3] >= opening.fore) & (bars[:, 3] < opening.aft) & ~of_the_edge
        parts.bars[index] = bars[~(within & (off(bars[:, :2]) < half - 1e-3))]
    for index, facets in enumerate(parts.facets):
        within = (facets[:, 6] >= opening.fore) & (facets[:, 6] < opening.aft)
        # those on a seam are written anew
        edge = half + (0.25 if lattice.section(opening.fore).kind.staggered else -0.25)
        parts.facets[index] = facets[~(within & (off(facets[:, :3]) < edge))]
    for index, meshes in enumerate(parts.meshes):
        nodes, row = meshes[:, [0, 1, 2, 3, 4, 5, 6, 7]], meshes[:, 16]
        staggered = lattice.section(opening.fore).kind.staggered
        ahead = row >= opening.fore
        within = ahead & (row <= opening.aft if staggered else row < opening.aft)
        edge = half + (0.25 if staggered else -0.25)
        parts.meshes[index] = meshes[~(within & (off(nodes) < edge))]


def _steps(knots: Knots, opening: Opening) -> Floats:
    """Azimuth from knot to knot of the netting about an opening, for every node of the lattice, rad, (n,)."""
    lattice, nodes = knots.lattice, np.arange(knots.codline + 1)
    row = np.searchsorted(knots.fore_start, nodes, side="right") - 1
    of_section = lattice.columns[np.clip(row - (row >= opening.aft), 0, lattice.bands - 1)]
    around = np.where(lattice.gathered[row], lattice.knots[row], of_section)
    fore_end = nodes < knots.start[row]
    around = np.where(fore_end, lattice.columns[np.maximum(row - 1, 0)], around)
    return np.asarray(2.0 * np.pi / around, dtype=np.float64)


def placed_window(window: LetIn, knots: Knots, shape: RowShape) -> Floats:
    """Start positions of a window's own nodes, spread evenly over the hole, (k, 3)."""
    lattice, opening, patch = knots.lattice, window.opening, window.patch
    own = patch.own
    deep = (opening.aft - opening.fore) / patch.rows
    place = opening.fore + deep * (own[:, 0] - 0.3 * own[:, 2])
    step = 2.0 * np.pi / lattice.columns[np.clip(place.astype(np.int64), opening.fore, opening.aft - 1)]
    from_middle = (own[:, 1] / 2 + 0.1 * own[:, 3]) * opening.across / patch.wide - 0.5 * opening.across
    azimuth = opening.side_rad + step * (opening.beside + from_middle)
    row = np.ceil(place).astype(np.int64)
    return shape.placed(row, azimuth, row - place)


def rows_of_window(window: LetIn) -> NDArray[np.int32]:
    """Rows whose rings a window's own nodes belong to: of its rows those that lie level with one, (k,)."""
    own = window.patch.own
    place = np.array([window.row(row) for row in own[:, 0]])
    level = np.abs(place - np.rint(place)) < 1e-6
    return np.where(level & (own[:, 2] == 0), np.rint(place), OFF_ROWS).astype(np.int32)
