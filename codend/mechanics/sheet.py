"""The surface of a net that contact acts on: its triangles and edges, those of a sector as of the whole net."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.contact import PARALLEL
from codend.net.net import Floats, Ints, Net, facet_corners

FEWEST = 4
"""Sectors, not a whole number of them, from which the fraction left over is little."""
BEYOND_ALL = 1 << 20


class Sheet(NamedTuple):
    """Parts of a net that nothing may pass through."""

    face: Ints
    """Corners of triangles, (f, 3); of a bar that is no side of one, its ends, the second twice."""
    face_image: Ints
    edge: Ints
    """Ends of sides and bars, each once, (e, 2)."""
    edge_image: Ints
    """Images of the ends, that of the first 0, (e, 2)."""
    node: Ints
    """Nodes of these, (k,): others are places and no parts."""
    even: Floats
    """Root of ``contact.PARALLEL`` times the square of an edge's length as built, m2, (e,)."""
    fixed: NDArray[np.bool_]
    """Nodes that are held, (n,)."""
    on_axis: NDArray[np.bool_]
    """Nodes that all sectors share, (n,)."""
    sectors: int
    """Images in which parts are sought, each the nearer way round."""
    period: int
    """Images by which a part is turned to where it was; beyond all where a fraction of a sector is left over."""
    cell: float
    """Of the grid in which parts are sought, m."""
    rotations: Floats


def sheet_of(net: Net) -> Sheet:
    """The surface of a net.

    Of quadrangles that are covered by both divisions into triangles the one whose diagonal is the longer along the flow
    counts, so that netting can fold along it. Where the net stands for sectors nearly its like, whose images do not
    close round, no part is sought in the fraction of one that is left over, opposite to each.

    Raises:
        ValueError: so few of such sectors go round that the fraction would be much of it.
    """
    sectors = int(net.order)
    closes = sectors == net.order
    if not closes and net.order < FEWEST:
        raise ValueError(f"contact needs a whole number of sectors all round, or {FEWEST} of them and a fraction")
    period = sectors if closes else BEYOND_ALL
    # a sector holds across the axis what it shares with all others
    on_axis = net.fixed[:, 1:].all(axis=1) & (net.positions[:, 1:] == 0.0).all(axis=1) & (sectors > 1)
    faces, images = _once_covered(net)
    bars = ~laced(net.bar_is_rope, net.bars[:, 0], net.bars[:, 1], net.facets)
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]], net.bars[bars]])
    turns = np.concatenate([images[:, [0, 1]], images[:, [1, 2]], images[:, [2, 0]], _bar_images(net)[bars]])
    edge, image, place = _unique_edges(sides, turns, on_axis, period)
    of_faces = np.unique(place[: 3 * len(faces)])
    bare = np.setdiff1d(np.arange(len(edge)), of_faces)
    faces = np.concatenate([faces, edge[bare][:, [0, 1, 1]]])
    images = np.concatenate([images, image[bare][:, [0, 1, 1]]])
    ends = _placed(net, edge, image)
    square = np.einsum("ij,ij->i", ends[:, 1] - ends[:, 0], ends[:, 1] - ends[:, 0])
    reach = sectors // 2 + int(np.abs(images).max(initial=0)) + int(np.abs(image).max(initial=0)) + 1
    angle = 2.0 * np.pi * np.arange(-reach, reach + 1) / net.order
    return Sheet(
        face=np.ascontiguousarray(faces, dtype=np.int32),
        face_image=np.ascontiguousarray(images, dtype=np.int32),
        edge=np.ascontiguousarray(edge, dtype=np.int32),
        edge_image=np.ascontiguousarray(image, dtype=np.int32),
        node=np.unique(edge).astype(np.int32),
        even=np.sqrt(PARALLEL) * square,
        fixed=np.asarray(net.fixed.all(axis=1)),
        on_axis=on_axis,
        sectors=sectors,
        period=period,
        cell=float(np.median(net.bar_length)) if len(net.bars) else 1.0,
        rotations=np.ascontiguousarray(np.stack([np.cos(angle), np.sin(angle)], axis=1)),
    )


def laced(is_rope: NDArray[np.bool_], first: Ints, second: Ints, facets: Ints) -> NDArray[np.bool_]:
    """Ropes with an end on netting, (m,): laced to it, they run through the meshes between their knots, or beside them.

    Where netting bulges between two knots the straight rope lies behind it, and has not passed through anything.
    """
    found = is_rope.copy()
    if found.any():
        found[found] = np.isin(np.stack([first[found], second[found]]), facets).any(axis=0)
    return found


def _bar_images(net: Net) -> Ints:
    return np.stack([np.zeros_like(net.bar_image), net.bar_image], axis=1)


def _placed(net: Net, node: Ints, image: Ints) -> Floats:
    angle = 2.0 * np.pi * image / net.order
    x, y, z = np.moveaxis(net.positions[node], -1, 0)
    return np.stack([x, np.cos(angle) * y - np.sin(angle) * z, np.sin(angle) * y + np.cos(angle) * z], axis=-1)


def _undirected(sides: Ints, turns: Ints) -> tuple[Ints, NDArray[np.bool_]]:
    """Lower and higher node of sides (k, 2) with images, and the turn between them, (k, 3); whether that is against it.

    The two sides from a node to its own images are one.
    """
    turn = turns[:, 1] - turns[:, 0]
    against = (sides[:, 0] > sides[:, 1]) | ((sides[:, 0] == sides[:, 1]) & (turn < 0))
    low, high = np.where(against[:, None], sides[:, ::-1], sides).T
    return np.stack([low, high, np.where(against, -turn, turn)], axis=1), against


def _unique_edges(sides: Ints, turns: Ints, on_axis: NDArray[np.bool_], period: int) -> tuple[Ints, Ints, Ints]:
    """Edges each once, (e, 2), their images, (e, 2), and which of them each side is, (sides,)."""
    turns = np.where(np.any(on_axis[sides], axis=1, keepdims=True), 0, turns)
    turns = np.stack([np.zeros(len(turns), dtype=int), wrapped(turns[:, 1] - turns[:, 0], period)], axis=1)
    table, place = np.unique(_undirected(sides, turns)[0], axis=0, return_inverse=True)
    keep = (table[:, 0] != table[:, 1]) | (table[:, 2] != 0)
    number = np.where(keep, np.cumsum(keep) - 1, -1)
    image = np.stack([np.zeros(len(table), dtype=table.dtype), table[:, 2]], axis=1)
    return table[keep, :2], image[keep], number[place.ravel()]


def wrapped(image: Ints, period: int) -> Ints:
    """Images as turns of half a round at most."""
    half = (period - 1) // 2
    return np.asarray((image + half) % period - half)


def _once_covered(net: Net) -> tuple[Ints, Ints]:
    """Triangles and images, with one division of every quadrangle that is covered by both, (f, 3) each."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    # netting of quadrangles alone has no facets that count whole
    most = net.facet_weight.max(initial=0.0)
    half = np.flatnonzero(net.facet_weight < 0.75 * (most if most > 0.75 else 1.0))
    if len(half) == 0:
        return net.facets, net.facet_image
    node, image = net.facets[half], net.facet_image[half]
    sides = np.stack([node, np.roll(node, -1, axis=1)], axis=2).reshape(-1, 2)
    turns = np.stack([image, np.roll(image, -1, axis=1)], axis=2).reshape(-1, 2)
    keys, against = _undirected(sides, turns)
    _, which = np.unique(keys, axis=0, return_inverse=True)
    which = which.ravel()
    # a diagonal is a side of two triangles, which run along it in opposite senses; other sides are of four, or of two
    # in the same sense
    runs, senses = np.bincount(which), np.bincount(which, weights=np.where(against, -1.0, 1.0))
    is_diagonal = np.asarray((runs == 2) & (senses == 0.0))
    diagonal = is_diagonal[which]
    # the triangles of a quadrangle run along its sides in the same sense
    triangle = np.repeat(np.arange(len(half)), 3)
    _, directed = np.unique(2 * which + against, return_inverse=True)
    joined = csr_array((np.ones(len(which)), (triangle, len(half) + directed.ravel())), shape=(2 * len(which),) * 2)
    quadrangle = connected_components(joined, directed=False)[1][: len(half)]
    corner = facet_corners(net, net.positions)[half]
    span = np.roll(corner, -1, axis=1) - corner
    # of two as long the one that winds forward about the axis, the same in all sectors; of two across the flow, as in a
    # wall that faces it, the steeper one, which is its own mirror image
    winds = span[..., 0] * (corner[..., 1] * span[..., 2] - corner[..., 2] * span[..., 1]) > 0.0
    along, up = np.round(np.abs(span[..., [0, 2]]) / np.abs(span).max(), 6).transpose(2, 0, 1)
    along = (along + 1e-7 * np.where(along > 0.0, winds, 0.5 * up)).ravel()
    own = np.where(diagonal, along, -1.0).reshape(-1, 3).argmax(axis=1) + 3 * np.arange(len(half))
    by_length = np.lexsort((which[own], along[own], quadrangle))
    longest = np.zeros(int(quadrangle.max()) + 1, dtype=int)
    longest[quadrangle[by_length]] = which[own][by_length]
    keep = half[which[own] == longest[quadrangle]]
    rest = np.setdiff1d(np.arange(len(net.facets)), half)
    chosen = np.sort(np.concatenate([rest, keep]))
    return net.facets[chosen], net.facet_image[chosen]
