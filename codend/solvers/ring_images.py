"""Which nodes of a sector are mirror images of each other, by the bars that join them alone, and which joints."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.harmonics import factorise_band_of_numbers, solve_band_of_numbers
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats, Ints
from codend.solvers.linear_systems import narrow_numbering

Places = NDArray[np.int64]
SAME = 1e-6
"""Difference, over that from row to row or over a sector, that is round-off."""
MOST_IN_A_ROW = 24
"""Nodes of a row up to which planes are tried."""


class Images(NamedTuple):
    """The reflection of a ring of sectors in a plane through its axis."""

    node: Ints
    """The node that each node is the image of, itself on the plane or on the axis, (n,)."""
    middle: Ints
    """Azimuth of the plane halfway between a node and its image, in halves of a sector, (n,)."""
    bar: Places
    """The joint that each bar is of, one of those it may share its ends with, (m,)."""
    joint: Places
    """The mirror image of each joint, (j,)."""


class Joined(NamedTuple):
    """Blocks between the same nodes at the same azimuth from each other."""

    source: Places
    """The blocks that are asked, (c,)."""
    member: Places
    """Which of the joined ones each is added to, (c,)."""
    turn: Floats
    """By how many sectors the axes of its row are turned, and of its column, (c, 2)."""
    third: Floats
    """By how many thirds of a circle both are turned besides, (c,): the mean over three is the same all round."""
    row: Places
    """Node of each of the joined ones, (t,)."""
    column: Places
    apart: Places
    """Azimuth from row to column, in halves of a sector, (t,)."""
    image: Places
    """Mirror image of each, (t,)."""
    turned: Places
    """That from its column to its row, (t,)."""


def images_of(structure: Structure, on_axis: Ints) -> Images | None:
    """The reflection that may take a sector's nodes into each other, None where none is found.

    Where every node is in the mean of its neighbours, but for those at the ends, its azimuth and its way along the axis
    follow from the bars alone, and have all the symmetries that these have (Tutte 1963, Proc. London Math. Soc. 13,
    743-767). Whether all else has this one is for the tangent and the bars' pull to tell.
    """
    nodes = len(structure.free)
    off_axis = np.ones(nodes, dtype=bool)
    off_axis[on_axis] = False
    placed = _in_the_mean(structure, off_axis)
    if placed is None:
        return None
    azimuth, along = placed
    own = np.flatnonzero(off_axis)
    by_row = own[np.argsort(along[own])]
    steps = np.diff(along[by_row], prepend=along[by_row[0]])
    row = np.zeros(nodes, dtype=np.int64)
    row[by_row] = np.cumsum(steps > SAME * np.ptp(along[own]) / nodes)
    counts = np.bincount(row[own])
    first = own[row[own] == counts.argmin()]
    if len(first) > MOST_IN_A_ROW:
        return None
    for other in first:
        found = _reflected(azimuth - 0.5 * (azimuth[first[0]] + azimuth[other]), row, own)
        joints = None if found is None else _joints(structure, off_axis, *found)
        if found is not None and joints is not None:
            return Images(*found, *joints)
    return None


def _in_the_mean(structure: Structure, off_axis: NDArray[np.bool_]) -> tuple[Floats, Floats] | None:
    """Azimuth of every node, in sectors, and its way along the axis by a measure of its own; 0 on the axis."""
    nodes = len(off_axis)
    one, other = structure.first, structure.second
    joins = off_axis[one] & off_axis[other]
    to_axis = np.bincount(one[~joins], minlength=nodes) + np.bincount(other[~joins], minlength=nodes)
    one, other, image = one[joins], other[joins], structure.image[joins].astype(np.float64)
    own = np.arange(nodes, dtype=np.int32)
    row, column = np.concatenate([own, one, other]), np.concatenate([own, other, one])
    place = narrow_numbering(row, column, nodes)
    half = int(np.abs(place[one] - place[other]).max(initial=0))
    joined = np.bincount(one, minlength=nodes) + np.bincount(other, minlength=nodes)
    diagonal = np.where(off_axis, joined, 1.0)
    diagonal[np.flatnonzero(off_axis)[-1]] += 1.0  # azimuths are told but for one of them
    entries = np.concatenate([diagonal, -np.ones(2 * len(one))])
    band = np.zeros((nodes, 2 * half + 1))
    np.add.at(band, (place[row], half + place[column] - place[row]), entries)
    turns = np.bincount(one, image, nodes) - np.bincount(other, image, nodes)
    ends = to_axis + np.pi * (structure.free == 0.0).all(axis=1)
    ends[off_axis] -= ends[off_axis].mean()
    ends[~off_axis] = 0.0
    factorise_band_of_numbers(band)
    found = []
    for side in (turns, ends):
        by_place = np.empty(nodes)
        by_place[place] = side
        solve_band_of_numbers(band, by_place)
        found.append(by_place[place])
    return (found[0], found[1]) if np.isfinite(found).all() else None


def _reflected(azimuth: Floats, row: Places, own: Places) -> tuple[Ints, Ints] | None:
    """Nodes' images under a change of their azimuths' sign, row by row, and middles; None where some have none."""
    here, there = ((sign * azimuth[own] + 0.5 * SAME) % 1.0 for sign in (1.0, -1.0))
    nodes, others = own[np.lexsort((here, row[own]))], own[np.lexsort((there, row[own]))]
    middle = azimuth[nodes] + azimuth[others]
    whole = np.rint(middle)
    node, halves = np.arange(len(row), dtype=np.int32), np.zeros(len(row), dtype=np.int32)
    node[nodes], halves[nodes] = others, whole
    if np.abs(middle - whole).max() > SAME or not np.array_equal(node[node], np.arange(len(node))):
        return None
    return node, halves


def _joints(
    structure: Structure, off_axis: NDArray[np.bool_], image: Ints, middle: Ints
) -> tuple[Places, Places] | None:
    """The joint that each bar is of, and the image of each joint; None where some are no images of any."""
    nodes = len(off_axis)
    one, other, sectors = (part.astype(np.int64) for part in (structure.first, structure.second, structure.image))
    # a node on the axis is in all sectors
    apart = np.where(off_axis[one] & off_axis[other], 2 * sectors + middle[other] - middle[one], 0)
    reach = int(np.abs(apart).max(initial=0))

    def key(i: Places, j: Places, between: Places) -> Places:
        turned = (i > j) | ((i == j) & (between < 0))
        i, j, between = np.where(turned, j, i), np.where(turned, i, j), np.where(turned, -between, between)
        return np.asarray((i * nodes + j) * (2 * reach + 1) + between + reach)

    keys, bar, joint = np.unique(key(one, other, apart), return_index=True, return_inverse=True)
    asked = key(image[one[bar]].astype(np.int64), image[other[bar]].astype(np.int64), -apart[bar])
    found = np.minimum(np.searchsorted(keys, asked), len(keys) - 1)
    return (joint, found) if np.array_equal(keys[found], asked) else None


def joined_of(pattern: Pattern, moves: NDArray[np.bool_], on_axis: NDArray[np.bool_], images: Images) -> Joined | None:
    """Blocks between nodes that move, joined, and their images; None where some have none."""
    source = np.flatnonzero(moves[pattern.row] & moves[pattern.column])
    row, column, image = (part[source].astype(np.int64) for part in (pattern.row, pattern.column, pattern.image))
    middle = images.middle.astype(np.int64)
    of_row, of_column = middle[row], middle[column]
    # a node on the axis is in all sectors: it is seen from where the other is
    of_row = np.where(on_axis[row], np.where(on_axis[column], 0, 2 * image + of_column), of_row)
    of_column = np.where(on_axis[column], of_row - 2 * image, of_column)
    # and in what it does to itself, or to others on it, it is the same all round
    times = np.where(on_axis[row] & on_axis[column], 3, 1)
    again = np.repeat(np.arange(len(row)), times)
    third = np.arange(len(again)) - np.repeat(np.cumsum(times) - times, times)
    source, row, column, image, of_row, of_column = (
        part[again] for part in (source, row, column, image, of_row, of_column)
    )
    apart = 2 * image + of_column - of_row
    reach, nodes = int(np.abs(apart).max()), len(moves)
    spread = 2 * reach + 1
    keys, member = np.unique((row * nodes + column) * spread + apart + reach, return_inverse=True)
    row, column, apart = keys // spread // nodes, keys // spread % nodes, keys % spread - reach
    node = images.node.astype(np.int64)
    asked = np.stack([node[row] * nodes + node[column], column * nodes + row]) * spread - apart + reach
    found = np.minimum(np.searchsorted(keys, asked), len(keys) - 1)
    if not np.array_equal(keys[found], asked):
        return None
    turn = np.asarray(0.5 * np.stack([of_row, of_column], axis=1), dtype=np.float64)
    return Joined(source, member, turn, third.astype(np.float64), row, column, apart, *found)
