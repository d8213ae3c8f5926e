"""Which parts of a net's surface are near each other: kernels.

Triangles and edges are sorted into the cells of a grid by boxes of where they go; those of a sector once, and what is
sought is turned back by every image in its stead. Pairs are found with a margin about the way of every node, so that
they are all that can meet until a node leaves it (Verlet 1967, Phys. Rev. 159, 98).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.cells import Numbers, sorted_into_cells, write_box
from codend.mechanics.contact import Contact, room, write_corners
from codend.mechanics.nearest import EDGE_EDGE, NODE_TRIANGLE, closing, nearest
from codend.mechanics.sheet import Sheet
from codend.net.net import Floats, Ints


class Candidates(NamedTuple):
    """Pairs that may come near each other while every node stays within a margin of where all are together on a way."""

    start: Floats
    """Where the way begins, (n, 3)."""
    way: Floats
    """To where it leads, (n, 3)."""
    pairs: Contact
    """By kind, then by number of the first part, image and second part, whatever the way was."""
    apart: Floats
    """Lower bound of the distance of each pair on the way, m, (k,)."""


@njit(cache=True, error_model="numpy")
def _lengths(vectors: Floats) -> Floats:
    """Lengths of vectors (n, 3)."""
    found = np.empty(len(vectors))
    for i in range(len(vectors)):
        found[i] = np.sqrt(vectors[i, 0] ** 2 + vectors[i, 1] ** 2 + vectors[i, 2] ** 2)
    return found


@njit(cache=True, error_model="numpy")
def _most(values: Floats, parts: Ints, part: int) -> float:
    """Largest of the values of a part's nodes."""
    largest = 0.0
    for corner in range(parts.shape[1]):
        largest = max(largest, values[parts[part, corner]])
    return largest


@njit(cache=True, error_model="numpy")
def near_pairs(position: Floats, way: Floats, reach: float, contact: Contact, sheet: Sheet) -> tuple[Contact, Floats]:
    """Pairs of a sheet that a way of its nodes may bring nearer to each other than ``reach``; see ``Candidates``.

    Parts that share a node, and pairs of which every node is held, are none. ``contact`` is the law; its pairs do not
    count.

    Returns:
        pairs and their ``apart``.
    """
    longest = _lengths(way)
    keys, apart = np.zeros((256, 4), dtype=np.int64), np.zeros(256)
    count = 0
    for of_kind in (NODE_TRIANGLE, EDGE_EDGE):
        keys, apart, count = _met(position, way, longest, reach, of_kind, sheet, keys, apart, count)
    # in an order that does not depend on the grid
    first, turn, second = keys[:count, 1], keys[:count, 2], keys[:count, 3]
    most = max(len(sheet.face), len(sheet.edge))
    order = np.argsort(((keys[:count, 0] * most + first) * sheet.sectors + turn) * most + second)
    node, image = np.zeros((count, 4), dtype=np.int32), np.zeros((count, 4), dtype=np.int32)
    kind, weight, even = np.zeros(count, dtype=np.int32), np.ones(count), np.zeros(count)
    for pair in range(count):
        row = order[pair]
        kind[pair] = keys[row, 0]
        _write_pair(kind[pair], first[row], turn[row], second[row], sheet, node[pair], image[pair])
        if kind[pair] == EDGE_EDGE:
            even[pair] = sheet.even[first[row]] * sheet.even[second[row]]
            # the pair of an edge and its own image half a round on is named twice over
            weight[pair] = 0.5 if first[row] == second[row] and 2 * turn[row] == sheet.period else 1.0
    pairs = Contact(node, image, kind, weight, even, contact.distance, contact.stiffness, contact.rotations, 1.0)
    return pairs, apart[order]


@njit(cache=True, error_model="numpy")
def _met(
    position: Floats,
    way: Floats,
    longest: Floats,
    reach: float,
    kind: int,
    sheet: Sheet,
    keys: Numbers,
    apart: Floats,
    count: int,
) -> tuple[Numbers, Floats, int]:
    """Add the pairs of a kind to (kind, first part, turn, second part) and ``apart``, of which so many are filled."""
    of_triangle = kind == NODE_TRIANGLE
    parts = sheet.face if of_triangle else sheet.edge
    images = sheet.face_image if of_triangle else sheet.edge_image
    size, seekers = (1, len(sheet.node)) if of_triangle else (2, len(sheet.edge))
    sectors, on_axis, half, found = sheet.sectors, sheet.on_axis, 0.5 * reach, room()
    own, own_image = np.zeros(size, dtype=np.int32), np.zeros(size, dtype=np.int32)
    node, image = np.zeros((1, 4), dtype=np.int32), np.zeros((1, 4), dtype=np.int32)
    first, last = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    box, boxes, held = np.zeros(6), np.zeros((len(parts), 6)), np.zeros(len(parts), dtype=np.bool_)
    for part in range(len(parts)):
        held[part] = sheet.fixed[parts[part]].all()
        write_box(position, way, parts[part], images[part], 0, sheet.rotations, half, boxes[part])
    start, contents, low, cell, shape = sorted_into_cells(boxes, sheet.cell)
    for seeker in range(seekers):
        if of_triangle:
            own[0] = sheet.node[seeker]
        else:
            own[:], own_image[:] = sheet.edge[seeker], sheet.edge_image[seeker]
        shared, own_held, moved = on_axis[own].all(), sheet.fixed[own].all(), longest[own].max()
        for turn in range(1 if shared else sectors):
            # the others turned by an image are met where the seeker is turned back
            back = _back(turn, sectors)
            write_box(position, way, own, own_image, back, sheet.rotations, half, box)
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
                            if not of_triangle and (
                                other < seeker or (other == seeker and (turn == 0 or 2 * turn > sectors))
                            ):
                                continue
                            if (
                                box[0] > boxes[other, 3] or box[3] < boxes[other, 0] or box[1] > boxes[other, 4]
                                or box[4] < boxes[other, 1] or box[2] > boxes[other, 5] or box[5] < boxes[other, 2]
                            ):  # fmt: skip
                                continue
                            # a pair that meets in several cells counts in the first of them
                            if (
                                i != max(int((boxes[other, 0] - low[0]) / cell), first[0])
                                or j != max(int((boxes[other, 1] - low[1]) / cell), first[1])
                                or k != max(int((boxes[other, 2] - low[2]) / cell), first[2])
                            ):
                                continue
                            if (own_held and held[other]) or _share_a_node(
                                own, own_image, parts, images, other, back, on_axis, sheet.period
                            ):
                                continue
                            _write_pair(kind, seeker, turn, other, sheet, node[0], image[0])
                            write_corners(position, node, image, sheet.rotations, 0, found.corner)
                            distance = np.sqrt(nearest(kind, found)[1])
                            if distance >= reach + moved + _most(longest, parts, other):
                                continue
                            write_corners(way, node, image, sheet.rotations, 0, found.corner)
                            distance -= closing(kind, found.corner)
                            if distance >= reach:
                                continue
                            if count == len(keys):
                                keys, apart = _twice(keys), _twice(apart)
                            keys[count, 0], keys[count, 1], keys[count, 2], keys[count, 3] = kind, seeker, turn, other
                            apart[count] = distance
                            count += 1
    return keys, apart, count


@njit(cache=True)
def _back(turn: int, sectors: int) -> int:
    """Images by which a part is turned back, half a round at most either way, instead of others by ``turn``."""
    return -turn if 2 * turn <= sectors else sectors - turn


@njit(cache=True)
def _write_pair(kind: int, first: int, turn: int, second: int, sheet: Sheet, node: Ints, image: Ints) -> None:
    """Write the nodes of a pair and the images they sit in, (4,) each."""
    size, turns = 1 if kind == NODE_TRIANGLE else 2, 0
    for i in range(4):
        if kind == NODE_TRIANGLE:
            node[i] = sheet.node[first] if i == 0 else sheet.face[second, i - 1]
            turns = 0 if i == 0 else sheet.face_image[second, i - 1]
        else:
            node[i] = sheet.edge[first, i] if i < 2 else sheet.edge[second, i - 2]
            turns = sheet.edge_image[first, i] if i < 2 else sheet.edge_image[second, i - 2]
        turns = turns if i < size else turns - _back(turn, sheet.sectors)
        image[i] = 0 if sheet.on_axis[node[i]] else _wrapped(turns, sheet.period)


@njit(cache=True)
def _share_a_node(
    own: Ints, own_image: Ints, parts: Ints, images: Ints, other: int, back: int, on_axis: NDArray, period: int
) -> bool:
    """Whether some nodes, turned back, and a part have one in common."""
    for a in range(len(own)):
        for b in range(parts.shape[1]):
            if own[a] == parts[other, b] and (
                on_axis[own[a]] or (own_image[a] - images[other, b] + back) % period == 0
            ):
                return True
    return False


@njit(cache=True)
def _wrapped(image: int, period: int) -> int:
    half = (period - 1) // 2
    return (image + half) % period - half


@njit(cache=True)
def _twice(values: NDArray) -> NDArray:
    return np.concatenate((values, np.zeros_like(values)))


@njit(cache=True, error_model="numpy")
def strayed(position: Floats, move: Floats, start: Floats, way: Floats) -> Floats:
    """How far each node is at most, on a move from a position, from where all are together on a way, m, (n,)."""
    square, along, of_move = 0.0, 0.0, 0.0
    for i in range(len(position)):
        for a in range(3):
            square += way[i, a] * way[i, a]
            along += (position[i, a] - start[i, a]) * way[i, a]
            of_move += move[i, a] * way[i, a]
    first = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
    last = min(max((along + of_move) / square, 0.0), 1.0) if square > 0.0 else 0.0
    found = np.empty(len(position))
    for i in range(len(position)):
        here, there = 0.0, 0.0
        for a in range(3):
            apart = position[i, a] - start[i, a]
            here += (apart - first * way[i, a]) ** 2
            there += (apart + move[i, a] - last * way[i, a]) ** 2
        found[i] = np.sqrt(max(here, there))
    return found


@njit(cache=True, error_model="numpy")
def may_meet(candidates: Candidates, stray: Floats, reach: float) -> Numbers:
    """Numbers of the pairs that may be nearer than ``reach`` to each other where nodes are so far off the way, (n,)."""
    node, kind = candidates.pairs.node, candidates.pairs.kind
    chosen, count = np.zeros(len(kind), dtype=np.int64), 0
    for pair in range(len(kind)):
        size = 1 if kind[pair] == NODE_TRIANGLE else 2
        mine, theirs = 0.0, 0.0
        for i in range(4):
            if i < size:
                mine = max(mine, stray[node[pair, i]])
            else:
                theirs = max(theirs, stray[node[pair, i]])
        if candidates.apart[pair] - mine - theirs < reach:
            chosen[count] = pair
            count += 1
    return chosen[:count]


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
