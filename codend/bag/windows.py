"""Windows of a plan in the lattice of its full net: where they are cut, and the nodes numbered anew.

A sector has no windows: it is one of the netting that they are let into, from which their nets start.
"""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.net.net import BAR_ARRAYS, Floats, Ints
from codend.netting.corners import corners_beside
from codend.netting.knots import Knots
from codend.netting.lattice import Lattice
from codend.netting.parts import Parts, RowShape
from codend.netting.windows import LetIn, Opening, cut_out, let_in, placed_window, rows_of_window
from codend.plan.plan import Plan
from codend.plan.windows import SIDES_DEG


def with_windows(
    plan: Plan, parts: Parts, knots: Knots, shape: RowShape, positions: Floats, node_row: Ints
) -> tuple[list[LetIn], Knots, Floats, Ints]:
    """The windows, the knots as they are numbered with them, and positions and rows of all nodes.

    ``parts`` lose what the windows take the place of, and are numbered anew.

    Raises:
        InputError: what is not modelled of windows.
    """
    windows: list[LetIn] = []
    azimuth = np.arctan2(positions[:, 2], positions[:, 1]) - shape.azimuth_rad
    count, g = len(positions), round(knots.lattice.globalisation)
    rows = [node_row]
    for index, window in enumerate(plan.window):
        opening = opening_of(plan, knots.lattice, index)
        found = let_in(knots, opening, window, window.meshes_round // g, window.meshes_long // g, count)
        windows.append(found)
        count += len(found.patch.own)
        positions = np.concatenate([positions, placed_window(found, knots, shape)])
        rows.append(rows_of_window(found))
    for found in windows:
        cut_out(parts, knots, found.opening, azimuth, node_row)
    return _numbered_anew(parts, windows, knots, positions, np.concatenate(rows))


def opening_of(plan: Plan, lattice: Lattice, index: int) -> Opening:
    """The hole that a window of a plan is let into, in the lattice of its full net."""
    g = round(lattice.globalisation)
    section = plan.holes[index].section
    hole, part = plan.holes[index].merged(g), plan.netting[section]
    start = plan.sections_of_bands(g).index(section)
    fore, aft = (start + part.rows_per_mesh * meshes for meshes in (hole.fore, hole.fore + hole.deep))
    if not part.tapers:
        first = np.full(lattice.bands + 1, int(hole.first))
        step = 2.0 * np.pi / lattice.columns[fore]
        middle = lattice.phase[fore] + step * (first[fore] + 0.5 * (hole.across + lattice.shift[fore]))
        return Opening(fore, aft, first, first, hole.across, middle, 0.0)
    assert lattice.seams is not None
    seams = int(lattice.seams[fore])
    panel, beside = hole.in_panel(part.open_meshes[0] // g, seams)
    return _opening_in_panel(lattice, fore, aft, panel, seams, beside, hole.across)


def farthest_beside(plan: Plan, lattice: Lattice) -> float:
    """How far beside the middle of its panel, or side of a tube, any window lies in a full net, real meshes."""
    farthest = 0.0
    for index, window in enumerate(plan.window):
        opening = opening_of(plan, lattice, index)
        step = 2.0 * np.pi / lattice.columns[opening.fore]
        off = opening.side_rad + step * opening.beside - np.radians(SIDES_DEG[window.side] - plan.seam_deg)
        off = (off + np.pi) % (2.0 * np.pi) - np.pi
        farthest = max(farthest, lattice.globalisation * float(abs(off) / step))
    return farthest


def _opening_in_panel(
    lattice: Lattice, fore: int, aft: int, panel: int, seams: int, beside: float, across: int
) -> Opening:
    """A hole in a panel that tapers, of the endless lattice a rectangle, so far beside the panel's middle, columns.

    Columns are counted from the first seam, so that its left edge moves by as many as are lost there. Where no column
    of knots is so far beside, it lies half a mesh further on.
    """
    columns = lattice.columns
    wide = columns // seams
    # of the knot of column 0 from the panel's first seam, columns
    start = 0.5 * lattice.shift[:-1] + lattice.phase * columns / (2.0 * np.pi)
    own = int(np.ceil(0.5 * (wide[fore] - across) + beside - start[fore] - 1e-9))
    beside = own + start[fore] + 0.5 * across - 0.5 * wide[fore]
    ahead, behind = np.zeros(lattice.bands + 1, dtype=np.int64), np.zeros(lattice.bands + 1, dtype=np.int64)
    for row in range(fore, aft + 1):
        if row > fore:
            ahead[row] = own + panel * wide[row - 1]
            lost = columns[row - 1] - columns[row] if row < aft else 0
            own -= int(np.sign(lost) * lattice.after_seam[row])
        behind[row] = own + panel * wide[min(row, aft - 1)]
    return Opening(fore, aft, ahead, behind, across, 2.0 * np.pi * (panel + 0.5) / seams, float(beside))


def _numbered_anew(
    parts: Parts, windows: list[LetIn], knots: Knots, positions: Floats, node_row: Ints
) -> tuple[list[LetIn], Knots, Floats, Ints]:
    stands_for = np.arange(len(positions))
    for window in windows:
        for one, other in window.alias.items():
            stands_for[one] = other
    while not np.array_equal(stands_for[stands_for], stands_for):
        stands_for = stands_for[stands_for]
    tables = [*parts.bars, *(bars for window in windows for bars in window.bars)]
    used = np.zeros(len(positions), dtype=bool)
    used[stands_for[np.concatenate([bars[:, :2].ravel() for bars in tables])]] = True
    used[stands_for[: knots.fore_start[1]]] = True
    codline = knots.codline
    used[codline] = False
    kept = np.append(np.flatnonzero(used), codline)
    number = np.full(len(positions), -1, dtype=np.int64)
    number[kept] = np.arange(len(kept))
    number = number[stands_for]

    def anew(table: NDArray, nodes: int) -> NDArray:
        return np.concatenate([number[table[:, :nodes]], table[:, nodes:]], axis=1)

    def whole(table: NDArray, nodes: int) -> NDArray:
        """Rows of a table whose nodes all differ."""
        apart = [table[:, i] != table[:, j] for i in range(nodes) for j in range(i)]
        return table[np.all(apart, axis=0)]

    def open_meshes(table: NDArray) -> NDArray:
        return np.asarray((table[:, 0:8:2] != table[:, 1:8:2]).all(axis=1))

    for window in windows:
        window.splits = [
            (int(number[one]), int(number[other]), share, int(number[node]))
            for one, other, share, node in window.splits
        ]
    parts.bars = [whole(anew(bars, 2), 2) for bars in parts.bars]
    # where netting tapers knots lie a little off their columns, and what hangs on one that is gone has gone with it
    parts.facets = [facets[(number[facets[:, :3]] >= 0).all(axis=1)] for facets in parts.facets]
    parts.facets = [whole(anew(facets, 3), 3) for facets in parts.facets]
    parts.meshes = [meshes[open_meshes(meshes)] for meshes in (anew(table, 8) for table in parts.meshes)]
    parts.corners = [anew(corners, 3) for corners in parts.corners]
    parts.codline = int(number[codline])
    for window in windows:
        window.bars = [whole(anew(bars, 2), 2) for bars in window.bars]
        facets = anew(np.concatenate(window.facets), 3)
        weights = np.concatenate(window.weights)
        sound = (facets[:, 0] != facets[:, 1]) & (facets[:, 1] != facets[:, 2]) & (facets[:, 2] != facets[:, 0])
        window.facets, window.weights = [facets[sound]], [weights[sound]]
        meshes = anew(np.concatenate(window.meshes), 8)
        window.meshes = [meshes[open_meshes(meshes)]]
    parts.corners = corners_beside(parts, windows, knots.lattice)
    return windows, replace(knots, renumbered=number), positions[kept], node_row[kept]


def sewn_to_bars(bag: Bag, windows: list[LetIn]) -> Bag:
    """The bag with those bars of the netting parted that knots of windows are sewn to."""
    sewn: dict[tuple[int, int], list[tuple[float, int]]] = {}
    for window in windows:
        for one, other, share, node in window.splits:
            sewn.setdefault((one, other), []).append((share, node))
    if not sewn:
        return bag
    where = {tuple(ends): bar for bar, ends in enumerate(bag.net.bars.tolist())}
    bars, lengths = bag.net.bars.copy(), bag.net.bar_length.copy()
    added: list[tuple[int, int, int, float]] = []
    for (one, other), places in sewn.items():
        bar, turned = (where[one, other], False) if (one, other) in where else (where[other, one], True)
        shares, nodes = zip(*[(0.0, one), *sorted(places), (1.0, other)], strict=True)
        pieces = [(a, b, (t - s) * lengths[bar]) for (s, a), (t, b) in pairwise(zip(shares, nodes, strict=True))]
        if turned:
            pieces = [(b, a, length) for a, b, length in pieces]
        (bars[bar, 0], bars[bar, 1], lengths[bar]), *others = pieces
        added += [(bar, *piece) for piece in others]
    of = np.array([bar for bar, *_ in added])
    arrays: dict[str, Any] = {
        name: np.append(getattr(bag.net, name), getattr(bag.net, name)[of]) for name in BAR_ARRAYS if name != "bars"
    }
    arrays["bar_length"] = np.append(lengths, [length for *_, length in added])
    ends = np.array([(a, b) for _, a, b, _ in added], dtype=np.int32)
    net = replace(bag.net, bars=np.concatenate([bars, ends]), **arrays)
    own = ("bar_band", "bar_is_twine", "bar_window")
    of_bag: dict[str, Any] = {name: np.append(getattr(bag, name), getattr(bag, name)[of]) for name in own}
    return replace(bag, net=net, **of_bag)
