"""Nets of knots: diamond netting with or without knot length, T90, and square mesh.

Every knot has four ports, where the twines to the four neighbouring knots leave it: fore or aft, left or right. The
kinds of knotted netting differ only in which ports are the same node: all four in ideal diamond netting, the two fore
ones and the two aft ones when the knot lies along the netting (T0), the two left ones and the two right ones when it
lies across (T90). Bars, facets and meshes are written once, in ports.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from codend.net import Net
from codend.net_parts import Corner, Lattice, Parts, RowShape, assembled

FORE_LEFT, FORE_RIGHT, AFT_LEFT, AFT_RIGHT = range(4)


def knotted_net(lattice: Lattice, shape: RowShape) -> Net:
    """Diamond netting with or without knot length, and T90."""
    bands, columns = lattice.bands, lattice.columns
    across = np.array([s.mesh == "t90" and s.knot_m > 0.0 for s in lattice.sections])
    along = np.array([s.mesh == "diamond" and s.knot_m > 0.0 for s in lattice.sections])
    # the knot of a row belongs to the band ahead of it; the entry's own row has knots only where they lie across
    across_row, along_row = np.concatenate([across[:1], across]), np.concatenate([[False], along])

    # number the nodes row by row: one or two a knot, and the codline after all others
    per_knot = 1 + (across_row | along_row).astype(int)
    per_knot[bands] = int(along_row[bands])
    start = np.concatenate([[0], np.cumsum(per_knot)]) * columns
    codline = int(start[-1])
    column = np.arange(columns)
    second_of_knot = (per_knot == 2) * columns
    ports = np.empty((4, bands + 1, columns), dtype=np.int64)
    base = start[:-1, None] + column
    ports[FORE_LEFT] = base
    ports[FORE_RIGHT] = base + (across_row * second_of_knot)[:, None]
    ports[AFT_LEFT] = base + (along_row * second_of_knot)[:, None]
    ports[AFT_RIGHT] = base + second_of_knot[:, None]
    ports[AFT_LEFT, bands] = ports[AFT_RIGHT, bands] = codline
    if not along_row[bands]:
        ports[FORE_LEFT, bands] = ports[FORE_RIGHT, bands] = codline

    def port(which: int, row: NDArray, counted: NDArray) -> Corner:
        inside, image = lattice.wrapped(counted)
        return Corner(ports[which, row, inside], image)

    parts = Parts(codline)
    band = np.arange(bands)[:, None]
    odd = band % 2
    here = np.broadcast_to(column, (bands, columns))
    # the two knots of the next row that lie half a mesh to the right and to the left
    right, left = here + odd, here + odd - 1
    parts.add_bars(port(AFT_RIGHT, band, here), port(FORE_LEFT, band + 1, right), band, False)
    parts.add_bars(port(AFT_LEFT, band, here), port(FORE_RIGHT, band + 1, left), band, False)
    parts.add_quadrangles(
        port(AFT_LEFT, band, here),
        port(AFT_RIGHT, band, here),
        port(FORE_LEFT, band + 1, right),
        port(FORE_RIGHT, band + 1, left),
        band,
    )
    parts.add_quadrangles(
        port(AFT_RIGHT, band, here),
        port(AFT_LEFT, band, here + 1),
        port(FORE_RIGHT, band + 1, right),
        port(FORE_LEFT, band + 1, right),
        band,
    )
    lengthwise = np.flatnonzero(along_row)[:, None]
    if lengthwise.size:
        knot = np.broadcast_to(column, (len(lengthwise), columns))
        parts.add_bars(port(FORE_LEFT, lengthwise, knot), port(AFT_LEFT, lengthwise, knot), lengthwise - 1, True)
        parts.add_quadrangles(
            port(FORE_RIGHT, lengthwise, knot),
            port(FORE_LEFT, lengthwise, knot + 1),
            port(AFT_LEFT, lengthwise, knot + 1),
            port(AFT_RIGHT, lengthwise, knot),
            lengthwise - 1,
        )
    # the entry's knots are held at both ends and the codline's are gathered: neither is a bar
    crosswise = np.flatnonzero(across_row[1:bands])[:, None] + 1
    if crosswise.size:
        knot = np.broadcast_to(column, (len(crosswise), columns))
        parts.add_bars(port(FORE_LEFT, crosswise, knot), port(FORE_RIGHT, crosswise, knot), crosswise - 1, True)

    _add_corners(parts, port, across_row, columns)
    row = np.arange(1, bands)[:, None]
    between = np.broadcast_to(column, (bands - 1, columns))
    middle = between + row % 2
    parts.add_meshes(
        [
            (port(AFT_RIGHT, row - 1, middle), port(FORE_LEFT, row, between + 1)),
            (port(AFT_LEFT, row, between + 1), port(FORE_RIGHT, row + 1, middle)),
            (port(FORE_LEFT, row + 1, middle), port(AFT_RIGHT, row, between)),
            (port(FORE_RIGHT, row, between), port(AFT_LEFT, row - 1, middle)),
        ],
        row,
    )
    node_row = np.full(codline + 1, -1, dtype=np.int32)
    positions = np.empty((codline + 1, 3))
    rows = np.broadcast_to(np.arange(bands + 1)[:, None], (bands + 1, columns))
    azimuth = (2 * column + rows % 2) * np.pi / (columns * lattice.order)
    # a knot keeps its length, however far the rows have closed up
    knot_m = lattice.globalisation * np.array([s.knot_m for s in lattice.sections])
    knot_share = np.minimum(knot_m / np.hypot(np.diff(shape.x), np.diff(shape.radius)), 0.9)
    ahead = np.where(along_row, np.concatenate([knot_share[:1], knot_share]), 0.0)[:, None]
    wide = np.where(across_row, 0.5 * np.concatenate([knot_m[:1], knot_m]), 0.0)
    half_angle = np.arcsin(np.clip(wide / np.maximum(shape.radius, wide + 1e-300), 0.0, 1.0))
    turn = np.minimum(half_angle, 0.4 * np.pi / (columns * lattice.order))[:, None]
    positions[ports[FORE_LEFT]] = shape.placed(rows, azimuth - turn, ahead)
    positions[ports[FORE_RIGHT]] = shape.placed(rows, azimuth + turn, ahead)
    positions[ports[AFT_LEFT]] = np.where(
        (ports[AFT_LEFT] == ports[FORE_LEFT])[..., None], positions[ports[AFT_LEFT]], shape.placed(rows, azimuth)
    )
    positions[codline] = (shape.x[bands], 0.0, 0.0)
    for side in (AFT_LEFT, AFT_RIGHT):
        node_row[ports[side]] = rows
    return assembled(parts, lattice, positions, node_row, ports[[AFT_LEFT, AFT_RIGHT], 0])


def _add_corners(
    parts: Parts, port: Callable[[int, NDArray, NDArray], Corner], across_row: NDArray, columns: int
) -> None:
    """Corners between two twines: fore and aft of a knot that lies lengthwise, left and right of one across."""
    bands = len(across_row) - 1
    rows = np.arange(bands + 1)

    def knots(chosen: NDArray) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        row = rows[chosen][:, None]
        here = np.broadcast_to(np.arange(columns), (len(row), columns))
        return row, here, here + row % 2, here + row % 2 - 1

    lengthwise = ~across_row
    row, here, right, left = knots(lengthwise & (rows < bands))
    aft = port(FORE_LEFT, row + 1, right), port(FORE_RIGHT, row + 1, left)
    parts.add_corners(port(AFT_LEFT, row, here), *aft, row, False)
    row, here, right, left = knots(lengthwise & (rows > 0) & (rows < bands))
    fore = port(AFT_LEFT, row - 1, right), port(AFT_RIGHT, row - 1, left)
    parts.add_corners(port(FORE_LEFT, row, here), *fore, row - 1, False)
    row, here, right, left = knots(~lengthwise & (rows > 0) & (rows < bands))
    if row.size:
        to_right = port(AFT_LEFT, row - 1, right), port(FORE_LEFT, row + 1, right)
        parts.add_corners(port(AFT_RIGHT, row, here), *to_right, row, True)
        to_left = port(AFT_RIGHT, row - 1, left), port(FORE_RIGHT, row + 1, left)
        parts.add_corners(port(AFT_LEFT, row, here), *to_left, row, True)


def square_net(lattice: Lattice, shape: RowShape) -> Net:
    """Square mesh: meridional bars and rings of bars."""
    bands, columns = lattice.bands, lattice.columns
    codline = bands * columns
    column = np.arange(columns)
    nodes = np.arange(bands + 1)[:, None] * columns + column
    nodes[bands] = codline

    def knot(row: NDArray, counted: NDArray) -> Corner:
        inside, image = lattice.wrapped(counted)
        return Corner(nodes[row, inside], image)

    parts = Parts(codline)
    band = np.arange(bands)[:, None]
    here = np.broadcast_to(column, (bands, columns))
    a, b, c, d = knot(band, here), knot(band, here + 1), knot(band + 1, here + 1), knot(band + 1, here)
    parts.add_bars(a, d, band, False)
    ring = np.arange(1, bands)[:, None]
    around = np.broadcast_to(column, (bands - 1, columns))
    parts.add_bars(knot(ring, around), knot(ring, around + 1), ring - 1, False)
    parts.add_quadrangles(a, b, c, d, band)
    parts.add_meshes([(a, b), (b, c), (c, d), (d, a)], band)
    node_row = np.empty(codline + 1, dtype=np.int32)
    rows = np.broadcast_to(np.arange(bands + 1)[:, None], (bands + 1, columns))
    node_row[nodes] = rows
    positions = np.empty((codline + 1, 3))
    positions[nodes] = shape.placed(rows, 2.0 * np.pi * column / (columns * lattice.order))
    return assembled(parts, lattice, positions, node_row, nodes[0])
