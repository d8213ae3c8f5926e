"""Exact tangent of the nodal forces: where its blocks lie, and how loads add to them.

The tangent is kept as 3 x 3 blocks -dF_i/dx_j for every pair of nodes (i, j) that share a bar, a facet or a corner.
These name images of nodes: with R the rotation of an image, a force acts on the node itself as R^T f, and a move of
the node shows at the image as R dx, so a block enters as R_i^T H R_j.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.structure import Structure
from codend.net.net import Floats, Ints


class Pattern(NamedTuple):
    """Which blocks there are and which of them every bar and facet adds to; the same for all states of a net."""

    row: Ints
    """Node whose force a block differentiates, (blocks,), rising; within it ``image`` rises, and then ``column``."""
    column: Ints
    """Node whose position it is differentiated by, (blocks,)."""
    bar_slot: Ints
    """Blocks of the ends of a bar: first-first, first-second, second-first, second-second, (m, 4)."""
    facet_slot: Ints
    """Blocks of the corners of a facet, (f, 3, 3)."""
    corner_slot: Ints
    """Blocks of the three nodes of a corner that resists opening, (c, 3, 3)."""
    contact_slot: Ints
    """Blocks of the four nodes of two parts near each other, (k, 4, 4)."""
    wrap_slot: Ints
    """Blocks of the nodes of the cells over which a layer lies, (w, k, k)."""
    diagonal: Ints
    """Blocks of the nodes with themselves, (n,)."""
    image: Ints
    """Sectors by which the column's node is turned against the row's, 0 where those blocks are added up, (blocks,)."""


NOTHING_NEAR = np.zeros((0, 4), dtype=np.int32), np.zeros((0, 4), dtype=np.int32)


def pattern_of(structure: Structure, by_image: bool = False, near: tuple[Ints, Ints] = NOTHING_NEAR) -> Pattern:
    """Blocks of a net's tangent: those of all images of a node added up, or kept apart ``by_image``.

    Added up they are the tangent for moves that are the same in all sectors, each in its own axes. ``near`` are nodes
    and images of the parts between which contact acts, (k, 4) each.
    """
    nodes = len(structure.free)
    reach = max(len(structure.rotations) - 1, 2 * int(np.abs(near[1]).max(initial=0))) if by_image else 0

    def paired(node: Ints, image: Ints) -> NDArray[np.int64]:
        """Keys of all pairs of the nodes (p, k) that a load joins, (p, k, k)."""
        node, turn = node.astype(np.int64), image.astype(np.int64) if by_image else np.zeros_like(image, np.int64)
        place = (turn[:, None, :] - turn[:, :, None] + reach) * nodes + node[:, None, :]
        return node[:, :, None] * (nodes * (2 * reach + 1)) + place

    bars = np.stack([structure.first, structure.second], axis=1)
    bar_images = np.stack([np.zeros_like(structure.image), structure.image], axis=1)
    own = np.arange(nodes, dtype=np.int32)[:, None]
    parts = (
        paired(bars, bar_images),
        paired(structure.facets, structure.facet_image),
        paired(structure.corners, structure.corner_image),
        paired(*near),
        paired(structure.wrap_node, structure.wrap_image),
        paired(own, np.zeros_like(own)),
    )
    pairs = [part.ravel() for part in parts]
    keys, place = np.unique(np.concatenate(pairs), return_inverse=True)
    place, wide = place.astype(np.int32), structure.wrap_node.shape[1]
    bars_end, facets_end, corners_end, near_end, wraps_end = np.cumsum([part.size for part in pairs[:5]])
    return Pattern(
        row=(keys // (nodes * (2 * reach + 1))).astype(np.int32),
        column=(keys % nodes).astype(np.int32),
        bar_slot=np.ascontiguousarray(place[:bars_end].reshape(-1, 4)),
        facet_slot=np.ascontiguousarray(place[bars_end:facets_end].reshape(-1, 3, 3)),
        corner_slot=np.ascontiguousarray(place[facets_end:corners_end].reshape(-1, 3, 3)),
        contact_slot=np.ascontiguousarray(place[corners_end:near_end].reshape(-1, 4, 4)),
        wrap_slot=np.ascontiguousarray(place[near_end:wraps_end].reshape(-1, wide, wide)),
        diagonal=np.ascontiguousarray(place[wraps_end:]),
        image=(keys // nodes % (2 * reach + 1) - reach).astype(np.int32),
    )


def with_contact(pattern: Pattern, near: Ints) -> Pattern:
    """The blocks of a net and of what is near each other in it, those of its images added up.

    The same as ``pattern_of`` finds, without sorting all again: parts come near and leave at most steps on the way.

    Args:
        pattern: without contact, not by image.
        near: nodes of the parts between which contact acts, (k, 4).
    """
    row, column, moved, slots = _blocks_beside(pattern.row, pattern.column, len(pattern.diagonal), near)
    return Pattern(
        row=row,
        column=column,
        bar_slot=moved[pattern.bar_slot],
        facet_slot=moved[pattern.facet_slot],
        corner_slot=moved[pattern.corner_slot],
        contact_slot=slots,
        wrap_slot=moved[pattern.wrap_slot],
        diagonal=moved[pattern.diagonal],
        image=np.zeros(len(row), dtype=np.int32),
    )


@njit(cache=True)
def _blocks_beside(row: Ints, column: Ints, nodes: int, near: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Rows and columns of the blocks of a pattern and of all pairs of the ``near`` nodes, (k, 4).

    Returns:
        rows, columns, where the pattern's own blocks went, and the blocks of the pairs, (k, 4, 4).
    """
    own_start, start = np.searchsorted(row, np.arange(nodes + 1)), np.zeros(nodes + 1, dtype=np.int64)
    for pair in range(len(near)):
        for i in range(4):
            start[near[pair, i] + 1] += 4
    start = np.cumsum(start)
    filled, beside = start[:-1].copy(), np.empty(start[nodes], dtype=np.int32)
    for pair in range(len(near)):
        for i in range(4):
            node = near[pair, i]
            beside[filled[node] : filled[node] + 4] = near[pair]
            filled[node] += 4
    new_row, new_column = np.empty(len(row) + len(beside), np.int32), np.empty(len(row) + len(beside), np.int32)
    moved, slots, count = np.empty(len(row), np.int32), np.empty((len(near), 4, 4), np.int32), 0
    new_start = np.zeros(nodes + 1, dtype=np.int64)
    for node in range(nodes):
        beside[start[node] : start[node + 1]].sort()
        own, other = own_start[node], start[node]
        while own < own_start[node + 1] or other < start[node + 1]:
            of_own = column[own] if own < own_start[node + 1] else nodes
            of_other = beside[other] if other < start[node + 1] else nodes
            new_row[count], new_column[count] = node, min(of_own, of_other)
            if of_own <= of_other:
                moved[own] = count
                own += 1
            while other < start[node + 1] and beside[other] == new_column[count]:
                other += 1
            count += 1
        new_start[node + 1] = count
    for pair in range(len(near)):
        for i in range(4):
            first, last = new_start[near[pair, i]], new_start[near[pair, i] + 1]
            for j in range(4):
                slots[pair, i, j] = first + np.searchsorted(new_column[first:last], near[pair, j])
    return new_row[:count].copy(), new_column[:count].copy(), moved, slots


@njit(cache=True)
def _add_turned_row(blocks: Floats, slot: int, i: int, x: float, y: float, z: float, c: float, s: float) -> None:
    """Add (x, y, z) R to row ``i`` of a block, R a turn with cosine c and sine s."""
    blocks[slot, i, 0] += x
    blocks[slot, i, 1] += c * y + s * z
    blocks[slot, i, 2] += c * z - s * y


@njit(cache=True)
def add_turned_block(
    blocks: Floats, slot: int, sign: float, h: Floats, row_image: int, column_image: int, rotations: Floats
) -> None:
    """Add sign R_i^T h R_j to a block, R_i and R_j the rotations of the two images."""
    if row_image == 0 and column_image == 0:
        for i in range(3):
            for j in range(3):
                blocks[slot, i, j] += sign * h[i, j]
        return
    middle = (rotations.shape[0] - 1) // 2
    c, s = sign * rotations[middle + row_image, 0], sign * rotations[middle + row_image, 1]
    e, t = rotations[middle + column_image, 0], rotations[middle + column_image, 1]
    for i in range(3):
        if i == 0:
            x, y, z = sign * h[0, 0], sign * h[0, 1], sign * h[0, 2]
        elif i == 1:
            x, y, z = c * h[1, 0] + s * h[2, 0], c * h[1, 1] + s * h[2, 1], c * h[1, 2] + s * h[2, 2]
        else:
            x, y, z = c * h[2, 0] - s * h[1, 0], c * h[2, 1] - s * h[1, 1], c * h[2, 2] - s * h[1, 2]
        _add_turned_row(blocks, slot, i, x, y, z, e, t)


@njit(cache=True, error_model="numpy")
def add_bar_blocks(
    blocks: Floats, slots: Ints, bar: int, h: Floats, sense: float, image: int, rotations: Floats
) -> None:
    """Add the blocks of a load on both ends of a bar that changes by h with its first end and by -h with its second.

    ``sense`` is that of the load on the second end against the one on the first: -1 for a pull, 1 for a drag.
    """
    fore_fore, fore_aft, aft_fore, aft_aft = slots[bar, 0], slots[bar, 1], slots[bar, 2], slots[bar, 3]
    if image == 0:
        for i in range(3):
            for j in range(3):
                value = h[i, j]
                blocks[fore_fore, i, j] += value
                blocks[fore_aft, i, j] -= value
                blocks[aft_fore, i, j] += sense * value
                blocks[aft_aft, i, j] -= sense * value
        return
    middle = (rotations.shape[0] - 1) // 2
    c, s = rotations[middle + image, 0], rotations[middle + image, 1]
    for i in range(3):
        x, y, z = h[i, 0], h[i, 1], h[i, 2]
        _add_turned_row(blocks, fore_fore, i, x, y, z, 1.0, 0.0)
        _add_turned_row(blocks, fore_aft, i, -x, -y, -z, c, s)
        if i == 1:
            x, y, z = c * x + s * h[2, 0], c * y + s * h[2, 1], c * z + s * h[2, 2]
        elif i == 2:
            x, y, z = c * x - s * h[1, 0], c * y - s * h[1, 1], c * z - s * h[1, 2]
        x, y, z = sense * x, sense * y, sense * z
        _add_turned_row(blocks, aft_fore, i, x, y, z, 1.0, 0.0)
        _add_turned_row(blocks, aft_aft, i, -x, -y, -z, c, s)
