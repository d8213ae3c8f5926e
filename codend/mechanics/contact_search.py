"""Which parts of a net's surface are near each other, and how far it may move before any meet: kernels.

Triangles and edges are sorted into the cells of a grid by boxes of where they go; those of a sector once, and what is
sought is turned back by every image in its stead. How far a pair may go is found by additive steps, each no longer
than the distance left allows at the speed of its fastest nodes (Li et al. 2021, ACM Trans. Graph. 40(4), 170, 5.2).
"""

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.contact import Contact, room, write_corners
from codend.mechanics.images import turned
from codend.mechanics.nearest import EDGE_EDGE, NODE_TRIANGLE, nearest
from codend.mechanics.sheet import Sheet
from codend.net.net import Floats, Ints

Numbers = NDArray[np.int64]

LEFT_OVER = 0.1
"""Share of their distance that a move leaves between two parts."""
MOST_STEPS = 60
CLOSE_ENOUGH = 0.02
"""Of the distance that may be used up: what is left of it when a pair counts as having met."""
MOST_CELLS = 4
"""Cells of the grid, over the parts that are sorted into it."""


@njit(cache=True)
def _write_box(
    position: Floats, move: Floats, node: Ints, image: Ints, turn: int, rotations: Floats, reach: float, box: Floats
) -> None:
    """Write least and largest coordinates of some nodes on their way, turned by ``turn`` images more, (6,)."""
    for i in range(3):
        box[i], box[3 + i] = np.inf, -np.inf
    for corner in range(len(node)):
        for moved in range(2):
            x, y, z = position[node[corner], 0], position[node[corner], 1], position[node[corner], 2]
            if moved == 1:
                x, y, z = x + move[node[corner], 0], y + move[node[corner], 1], z + move[node[corner], 2]
            y, z = turned(y, z, image[corner] + turn, rotations)
            box[0], box[3] = min(box[0], x - reach), max(box[3], x + reach)
            box[1], box[4] = min(box[1], y - reach), max(box[4], y + reach)
            box[2], box[5] = min(box[2], z - reach), max(box[5], z + reach)


@njit(cache=True)
def _sorted_into_cells(boxes: Floats, cell: float) -> tuple[Numbers, Numbers, Floats, float, Numbers]:
    """Where the list of each cell starts, the boxes in each, the grid's corner, its cells' size, and its shape."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for box in boxes:
        for i in range(3):
            low[i], high[i] = min(low[i], box[i]), max(high[i], box[3 + i])
    shape = np.ones(3, dtype=np.int64)
    while True:
        for i in range(3):
            shape[i] = max(int((high[i] - low[i]) / cell) + 1, 1) if len(boxes) else 1
        if shape[0] * shape[1] * shape[2] <= MOST_CELLS * len(boxes) + 1000:
            break
        cell *= 1.3
    cells = shape[0] * shape[1] * shape[2]
    start = np.zeros(cells + 1, dtype=np.int64)
    contents = np.zeros(0, dtype=np.int64)
    for filling in range(2):
        for number in range(len(boxes)):
            box = boxes[number]
            for i in range(int((box[0] - low[0]) / cell), int((box[3] - low[0]) / cell) + 1):
                for j in range(int((box[1] - low[1]) / cell), int((box[4] - low[1]) / cell) + 1):
                    for k in range(int((box[2] - low[2]) / cell), int((box[5] - low[2]) / cell) + 1):
                        place = (i * shape[1] + j) * shape[2] + k
                        if filling == 0:
                            start[place + 1] += 1
                        else:
                            contents[start[place]] = number
                            start[place] += 1
        if filling == 0:
            for place in range(cells):
                start[place + 1] += start[place]
            contents = np.zeros(start[cells], dtype=np.int64)
    for place in range(cells, 0, -1):
        start[place] = start[place - 1]
    start[0] = 0
    return start, contents, low, cell, shape


@njit(cache=True)
def _same(node: int, image: int, other: int, other_image: int, sheet: Sheet) -> bool:
    """Whether two nodes with their images are one."""
    return node == other and (sheet.on_axis[node] or (image - other_image) % sheet.sectors == 0)


@njit(cache=True)
def near_pairs(position: Floats, move: Floats, reach: float, sheet: Sheet) -> tuple[Ints, Ints, Ints, Floats, Floats]:
    """Pairs whose boxes, of where a move takes them and half of ``reach`` wider, meet: fields of ``Contact``.

    Parts that share a node, and pairs of which every node is held, are none.
    """
    count, room_for = 0, 256
    node, image = np.zeros((room_for, 4), dtype=np.int32), np.zeros((room_for, 4), dtype=np.int32)
    kind, weight, even = np.zeros(room_for, dtype=np.int32), np.ones(room_for), np.zeros(room_for)
    sectors, half = sheet.sectors, 0.5 * reach
    own, own_image, box = np.zeros(2, dtype=np.int32), np.zeros(2, dtype=np.int32), np.zeros(6)
    for kind_now in range(2):
        parts = sheet.face if kind_now == NODE_TRIANGLE else sheet.edge
        images = sheet.face_image if kind_now == NODE_TRIANGLE else sheet.edge_image
        size = 1 if kind_now == NODE_TRIANGLE else 2
        boxes = np.zeros((len(parts), 6))
        for part in range(len(parts)):
            _write_box(position, move, parts[part], images[part], 0, sheet.rotations, half, boxes[part])
        start, contents, low, cell, shape = _sorted_into_cells(boxes, sheet.cell)
        first, last = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
        seekers = len(sheet.node) if kind_now == NODE_TRIANGLE else len(sheet.edge)
        for seeker in range(seekers):
            if kind_now == NODE_TRIANGLE:
                own[0], own_image[0] = sheet.node[seeker], 0
            else:
                own[:], own_image[:] = sheet.edge[seeker], sheet.edge_image[seeker]
            shared = sheet.on_axis[own[:size]].all()
            for turn in range(1 if shared else sectors):
                # the others turned by an image are met where the seeker is turned back
                back = -turn if 2 * turn <= sectors else sectors - turn
                _write_box(position, move, own[:size], own_image[:size], back, sheet.rotations, half, box)
                outside = False
                for i in range(3):
                    a, b = (box[i] - low[i]) / cell, (box[3 + i] - low[i]) / cell
                    outside = outside or b < 0.0 or a >= shape[i]
                    first[i], last[i] = max(int(a), 0), min(int(b), shape[i] - 1)
                if outside:
                    continue
                for i in range(first[0], last[0] + 1):
                    for j in range(first[1], last[1] + 1):
                        for k in range(first[2], last[2] + 1):
                            place = (i * shape[1] + j) * shape[2] + k
                            for entry in range(start[place], start[place + 1]):
                                other = contents[entry]
                                there = boxes[other]
                                if (
                                    box[0] > there[3] or box[3] < there[0] or box[1] > there[4]
                                    or box[4] < there[1] or box[2] > there[5] or box[5] < there[2]
                                ):  # fmt: skip
                                    continue
                                # a pair that meets in several cells counts in the first of them
                                if (
                                    i != max(int((there[0] - low[0]) / cell), first[0])
                                    or j != max(int((there[1] - low[1]) / cell), first[1])
                                    or k != max(int((there[2] - low[2]) / cell), first[2])
                                ):
                                    continue
                                counts = 1.0
                                if kind_now == EDGE_EDGE:
                                    if other < seeker or (other == seeker and (turn == 0 or 2 * turn > sectors)):
                                        continue
                                    counts = 0.5 if other == seeker and 2 * turn == sectors else 1.0
                                met, held = False, True
                                for a in range(size):
                                    held = held and sheet.fixed[own[a]]
                                    for b in range(parts.shape[1]):
                                        met = met or _same(
                                            own[a], own_image[a], parts[other, b], images[other, b] - back, sheet
                                        )
                                for b in range(parts.shape[1]):
                                    held = held and sheet.fixed[parts[other, b]]
                                if met or held:
                                    continue
                                if count == room_for:
                                    room_for *= 2
                                    node, image = _longer(node, room_for), _longer(image, room_for)
                                    kind = _longer(kind.reshape(-1, 1), room_for)[:, 0].copy()
                                    more, less = np.ones(room_for), np.zeros(room_for)
                                    more[:count], less[:count] = weight, even
                                    weight, even = more, less
                                for a in range(4):
                                    mine = a < size
                                    node[count, a] = own[a] if mine else parts[other, a - size]
                                    turns = own_image[a] if mine else images[other, a - size] - back
                                    on_axis = sheet.on_axis[node[count, a]]
                                    image[count, a] = 0 if on_axis else _wrapped(turns, sectors)
                                kind[count], weight[count] = kind_now, counts
                                if kind_now == EDGE_EDGE:
                                    even[count] = sheet.even[seeker] * sheet.even[other]
                                count += 1
    return node[:count], image[:count], kind[:count], weight[:count], even[:count]


@njit(cache=True)
def _wrapped(image: int, sectors: int) -> int:
    half = (sectors - 1) // 2
    return (image + half) % sectors - half


@njit(cache=True)
def _longer(values: Ints, rows: int) -> Ints:
    new = np.zeros((rows, values.shape[1]), dtype=values.dtype)
    new[: len(values)] = values
    return new


@njit(cache=True)
def within_reach(position: Floats, contact: Contact, reach: float) -> Numbers:
    """Numbers of the pairs nearer to each other than ``reach``."""
    found, chosen = room(), np.zeros(len(contact.kind), dtype=np.int64)
    count = 0
    for pair in range(len(contact.kind)):
        write_corners(position, contact.node, contact.image, contact.rotations, pair, found.corner)
        _, square = nearest(contact.kind[pair], found)
        if square < reach * reach:
            chosen[count] = pair
            count += 1
    return chosen[:count]


@njit(cache=True)
def least_distance(position: Floats, contact: Contact) -> float:
    """Least distance of the pairs, m; inf where there is none."""
    found, least = room(), np.inf
    for pair in range(len(contact.kind)):
        write_corners(position, contact.node, contact.image, contact.rotations, pair, found.corner)
        least = min(least, nearest(contact.kind[pair], found)[1])
    return np.sqrt(least)


@njit(cache=True, error_model="numpy")
def free_share(position: Floats, move: Floats, contact: Contact) -> float:
    """Share of a move, at most 1, after which every pair that might meet keeps ``LEFT_OVER`` of its distance."""
    found, share = room(), 1.0
    start, way = np.zeros((4, 3)), np.zeros((4, 3))
    for pair in range(len(contact.kind)):
        kind = contact.kind[pair]
        write_corners(position, contact.node, contact.image, contact.rotations, pair, start)
        write_corners(move, contact.node, contact.image, contact.rotations, pair, way)
        if _pass_by(kind, start, way):
            continue
        speed = _closing_speed(kind, way)
        if speed == 0.0:
            continue
        found.corner[:] = start
        distance = np.sqrt(nearest(kind, found)[1])
        kept = LEFT_OVER * distance
        if distance - kept > speed * share:
            continue
        usable, at = distance - kept, 0.0
        for _ in range(MOST_STEPS):
            at += 0.9 * (distance - kept) / speed
            if at >= share:
                break
            for i in range(4):
                for j in range(3):
                    found.corner[i, j] = start[i, j] + at * way[i, j]
            distance = np.sqrt(nearest(kind, found)[1])
            if distance - kept < CLOSE_ENOUGH * usable:
                break
        share = min(share, at)
    return share


@njit(cache=True)
def _pass_by(kind: int, start: Floats, way: Floats) -> bool:
    """Whether the boxes of where the parts of a pair go do not meet."""
    own = 1 if kind == NODE_TRIANGLE else 2
    for j in range(3):
        low, high, there_low, there_high = np.inf, -np.inf, np.inf, -np.inf
        for i in range(4):
            a, b = start[i, j], start[i, j] + way[i, j]
            if i < own:
                low, high = min(low, a, b), max(high, a, b)
            else:
                there_low, there_high = min(there_low, a, b), max(there_high, a, b)
        if low > there_high or high < there_low:
            return True
    return False


@njit(cache=True)
def _closing_speed(kind: int, way: Floats) -> float:
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
