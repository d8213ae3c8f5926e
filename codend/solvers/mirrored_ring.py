"""A sector that is its own mirror image: its harmonics in real numbers. See ``mechanics.mirrored_harmonics``."""

import math
from copy import copy
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.harmonics import ABREAST, Complex, add_turned_bands
from codend.mechanics.lanes import LANES
from codend.mechanics.mirrored_harmonics import (
    add_up_terms,
    mirrored_blocks,
    negative_pivots_of_real,
    symmetric_parts,
    terms_of_blocks,
)
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats, Ints, rotate
from codend.solvers.harmonic_tangent import HarmonicTangent
from codend.solvers.ring_images import Images, Joined, joined_of

Places = NDArray[np.int64]
ALIKE = 1e-9
"""Largest difference of a tangent from its mirror image's, over its largest entry, up to which their mean stands for
both. It is of the directions of bars: their own stiffness changes by its square, and what tension gives the nodes by a
thousandth of ``ring.NEUTRAL``. Of what bars pull with it tells nothing beside their own stiffness."""
ALIKE_PULL = 1e-7
"""Largest difference of a bar's force density from its image's, over the mean: a tenth of ``ring.NEUTRAL``. In 22 nets
solved it was 2e-9 and mostly 1e-12."""
SIMPLE = 55440
"""A common denominator of the azimuths of planes, in sectors: those of rows of so many meshes."""
HALF_EACH = np.sqrt(0.5)
NONE = np.zeros(0, dtype=np.int64)


class Ways(NamedTuple):
    """How nodes' moves, in the axes of their planes, follow from unknowns: a sum of two of them, each times a weight.

    All (n, 3, 2), by node and component; unknown -1 where there is none.
    """

    unknown: Places
    weight: Complex


class Terms(NamedTuple):
    """What makes up the entries of the tangent: entries of mean blocks, each times a weight and a harmonic's wave."""

    row: Ints
    column: Ints
    source: Ints
    wave: Ints
    weight: Floats
    """That of a ring of one sector."""
    on_axis: Places
    """How many of row and column are of nodes on the axis, whose moves weigh the more the more sectors there are; none
    of those off it."""


class MirroredRing:
    """What depends on a sector's structure alone, and room for its tangent.

    Unknowns have the numbers that they have in complex ones: of two nodes that are images of each other the first has
    those of p, and the second those of q.
    """

    def __init__(self, order: float, unknown: Ints, on_axis: Ints, images: Images, joined: Joined, rows: int) -> None:
        self.order, self._on_axis, self._images, self._joined = order, on_axis, images, joined
        self.size, self._unknown, self._plane = int(unknown.max()) + 1, unknown, math.nan
        first = int(np.flatnonzero(unknown[:, 0] == 0)[0])
        self._first = first, int(images.node[first]), int(images.middle[first])
        self.waves = int(np.abs(joined.apart).max()) * 2 + 1
        self._ways = [_ways(unknown, on_axis, images, kind) for kind in (0, 1)]
        self._inner, self._at_axis = self._terms(self._ways[0], False), [self._terms(w, True) for w in self._ways]
        everything = (self._inner, *self._at_axis)
        row, column = (np.concatenate([terms[side] for terms in everything]) for side in (0, 1))
        self.half = int(np.abs(row - column).max())
        """Half-bandwidth."""
        depth = depths_of(np.maximum(row, column), np.minimum(row, column), rows)
        # each three rows begin where the first of them does
        self._depth = (np.repeat(depth[::ABREAST], ABREAST) + np.arange(len(depth)) % ABREAST).astype(np.int32)
        self._number_terms()
        place = self._inner.wave * (2 * self.half + 1) + self.half + self._inner.row - self._inner.column
        self._band_place = (place * self.size + self._inner.column).astype(np.int32)
        turns = np.rint(6.0 * joined.turn + joined.third[:, None]).astype(np.int64)
        each = np.arange(turns.min(), turns.max() + 1)
        self._turns, self._turn_of = (0.5 * (each // 3), each % 3), turns - each[0]
        self._take_order(order)

    def beside(self, order: float) -> Self:
        """The same sector in a ring of another order, with room of its own."""
        other = copy(self)
        other._take_order(order)
        return other

    def _take_order(self, order: float) -> None:
        joined = self._joined
        self.order, self._plane = order, math.nan
        self._waves = self._waves_of(np.arange(max(2, math.ceil(order))))
        self._value, self._tail = np.empty(len(self._lane_of_wave)), np.empty_like(self._tail_ahead)
        self._turned, self._mean = np.empty((2, len(joined.row), 3, 3))
        self._tail_weights = [weight * np.sqrt(order) ** on_axis for weight, on_axis in self._tail_weight]
        self._bands: Floats | None = None
        self._front: tuple[Floats, Floats] | None = None
        self._moves = [ways.weight.copy() for ways in self._ways]
        for weight in self._moves:
            weight[self._on_axis] *= np.sqrt(order)

    def _set_plane(self, plane: float) -> None:
        """Put the first plane at an azimuth, in sectors."""
        self._plane = plane
        sectors, thirds = self._turns
        angle = 2.0 * np.pi * ((sectors + plane) / self.order + thirds / 3.0)
        self._turn = np.stack([np.cos(angle), np.sin(angle)], axis=1)[self._turn_of].reshape(-1, 4)
        self._azimuth = np.asarray(plane + 0.5 * self._images.middle, dtype=np.float64)

    def _waves_of(self, harmonics: NDArray[np.integer]) -> Floats:
        """Cosines and sines of whole numbers of half sectors, (harmonics, waves): 1, then those of one half, ..."""
        angle = np.pi / self.order * np.arange(1, self.waves // 2 + 1) * harmonics[:, None]
        both = np.stack([np.cos(angle), np.sin(angle)], axis=2).reshape(len(harmonics), -1)
        return np.asarray(np.hstack([np.ones((len(harmonics), 1)), both]), dtype=np.float64)

    def _terms(self, ways: Ways, at_axis: bool) -> Terms:
        """Those between nodes off the axis, or those of which one or both are on it."""
        joined, on_axis = self._joined, np.zeros(len(self._unknown), dtype=np.int64)
        on_axis[self._on_axis] = 1
        ends = on_axis[joined.row] + on_axis[joined.column]
        number = np.arange(len(joined.row))
        asked = number[((ends > 0) == at_axis) & (joined.image >= number)]
        factor = np.where(joined.image[asked] == asked, 1.0, 2.0) / np.where(ends[asked] == 2, 3.0, 1.0)
        blocks = joined.row[asked], joined.column[asked], joined.apart[asked]
        row, column, source, wave, weight = terms_of_blocks(asked, *blocks, factor, ways.unknown, ways.weight)
        return Terms(row, column, source, wave, weight, ends[source // 9] if at_axis else NONE)

    def _number_terms(self) -> None:
        """Where terms go among those of the lower triangle, row by row, and in the rows behind it."""
        joined, inner, waves = self._joined, self._inner, self.waves
        first = np.append(0, np.cumsum(self._depth.astype(np.int64) + 1))[: self.size + 1]
        number, of_turned = np.arange(len(joined.row)), np.minimum(joined.turned, joined.image[joined.turned])
        self._symmetric = np.where((number <= joined.image) & (number <= of_turned), joined.turned, -1)
        self._twice = np.where(number < of_turned, 2.0, 1.0)
        kept, weight = self._lower(inner)
        below, before = np.maximum(inner.row[kept], inner.column[kept]), np.minimum(inner.row[kept], inner.column[kept])
        key = (first[below] + below - before) * waves + inner.wave[kept]
        is_there = np.zeros(first[-1] * waves, dtype=bool)
        is_there[key] = True
        there = np.flatnonzero(is_there)
        entry, wave = there // waves, there % waves
        # one term of every entry, and what more there is
        is_first = np.diff(entry, prepend=-1) > 0
        more = entry[~is_first]
        goes = np.where(is_first, entry, first[-1] - 1 + np.cumsum(~is_first))
        self._lane_of_wave = np.zeros(int(first[-1]) + len(more), dtype=np.int32)
        self._lane_of_wave[goes] = wave * LANES
        self._more = (first[-1] + np.searchsorted(more, first)).astype(np.int32)
        self._into = (LANES * (more - first[np.searchsorted(first, more, side="right") - 1])).astype(np.int32)
        place = goes[np.cumsum(is_there)[key] - 1].astype(np.int32)
        self._of_lower = inner.source[kept], place, weight
        self._tail_ahead = np.zeros((3, len(self._depth) - self.size, int(self._depth.max()) + 1))
        self._tail_ahead[:, :, 0] = 1.0
        self._of_tail, self._tail_weight = [], []
        for kind, terms in enumerate(self._at_axis):
            tail, (kept, weight) = self._tail_ahead[kind], self._lower(terms)
            below = np.maximum(terms.row[kept], terms.column[kept])
            tail[below - self.size, 0] = 0.0
            place = (below - self.size) * tail.shape[1] + np.abs(terms.row[kept] - terms.column[kept])
            self._of_tail.append((terms.source[kept], (kind * tail.size + place).astype(np.int32)))
            self._tail_weight.append((weight, terms.on_axis[kept]))

    def _lower(self, terms: Terms) -> tuple[NDArray[np.bool_], Floats]:
        """Which terms count in the lower triangle of the symmetric part, and how much they do."""
        # of a pair of entries, one above the diagonal and one below, each counts half
        block, half = terms.source // 9, np.where(terms.row == terms.column, 1.0, 0.5)
        kept = self._symmetric[block] >= 0
        return kept, (half * self._twice[block] * terms.weight)[kept]

    def gather(self, blocks: Floats, position: Floats, density: Floats, front: tuple[Floats, Floats] | None) -> bool:
        """Take over a tangent at a shape, (n, 3); whether it is its own mirror image, but for round-off.

        So must the bars' force densities be, (m,). With it the load and the gradient of a front that follows the net,
        at the nodes, (n, 3).
        """
        plane = self._plane_of(position)
        pull = np.bincount(self._images.bar, density)
        off = np.abs(pull - pull[self._images.joint]).max()
        if plane is None or not off <= ALIKE_PULL * np.abs(density).mean():
            return False
        if plane != self._plane:
            self._set_plane(plane)
        if not self._is_alike(blocks):
            return False
        self._front = None
        if front is not None:
            load, gradient = (self._along_unknowns(values) for values in front)
            if any(np.abs(side.imag).max() > ALIKE * np.abs(side.real).max() for side in (load, gradient)):
                return False
            self._front = load.real, gradient.real
        self._bands = None
        symmetric_parts(self._mean, self._symmetric, self._turned)
        self._value[:] = 0.0
        add_up_terms(self._turned, *self._of_lower, self._value)
        self._tail[:] = self._tail_ahead
        for terms, weight in zip(self._of_tail, self._tail_weights, strict=True):
            add_up_terms(self._turned, *terms, weight, self._tail.reshape(-1))
        return True

    def _plane_of(self, position: Floats) -> float | None:
        """Azimuth of the first plane, which bars alone do not tell, in sectors: the simple fraction next to it."""
        one, other, middle = self._first
        twice = math.atan2(position[one, 2], position[one, 1]) + math.atan2(position[other, 2], position[other, 1])
        plane = twice * self.order / (4.0 * math.pi) - 0.5 * middle
        return round(plane * SIMPLE) / SIMPLE if math.isfinite(plane) else None

    def _is_alike(self, blocks: Floats) -> bool:
        joined = self._joined
        total, largest, off = mirrored_blocks(
            blocks, joined.member, joined.source, self._turn, joined.image, self._turned, self._mean
        )
        return bool(np.isfinite(total) and off <= ALIKE * largest)

    def negative_pivots(self, harmonics: NDArray[np.integer], shift: Floats) -> NDArray[np.integer]:
        """Negative eigenvalues of the symmetric parts of harmonics, each shifted by its own."""
        negative = np.empty(len(harmonics), dtype=np.int64)
        waves, kind = self._waves[harmonics], np.minimum(harmonics, 2)
        negative_pivots_of_real(
            self._value,
            self._lane_of_wave,
            self._more,
            self._into,
            self._depth,
            waves,
            shift,
            self._tail,
            kind,
            negative,
        )
        return negative

    def tangent(self, harmonic: int) -> HarmonicTangent:
        """Tangent of a harmonic."""
        extra = len(self._on_axis) if harmonic <= 1 else 0
        band = np.zeros((2 * self.half + 1, self.size + extra))
        add_turned_bands(self._bands_by_wave(), self._waves[harmonic], band)
        if extra:
            terms, entries = self._at_axis[harmonic], self._mean.reshape(-1)
            values = terms.weight * np.sqrt(self.order) ** terms.on_axis * entries[terms.source]
            np.add.at(band, (self.half + terms.row - terms.column, terms.column), values)
        return HarmonicTangent(band, self._front if harmonic == 0 else None)

    def _bands_by_wave(self) -> Floats:
        """What goes with every wave, of unknowns off the axis, as bands laid out as ``HarmonicTangent.band``."""
        if self._bands is None:
            self._bands = np.zeros((self.waves, 2 * self.half + 1, self.size))
            inner = self._inner
            add_up_terms(self._mean, inner.source, self._band_place, inner.weight, self._bands.reshape(-1))
        return self._bands

    def _along_unknowns(self, values: Floats) -> Complex:
        """Values at the nodes, (n, 3), as those at the unknowns of harmonic 0: real but for what is not mirrored."""
        unknown, seen = self._ways[0].unknown, rotate(values, -self._azimuth, self.order)
        products, used = self._moves[0].conj() * seen[:, :, None], unknown >= 0
        found = np.zeros(self.size + len(self._on_axis), dtype=np.complex128)
        np.add.at(found, unknown[used], products[used])
        return found

    def moves_of(self, vector: NDArray[np.inexact], harmonic: int) -> Complex:
        """Moves of a sector's nodes by the unknowns of a harmonic, (n, 3)."""
        kind = min(harmonic, 1)
        known = np.append(vector, np.zeros(self.size + len(self._on_axis) + 1 - len(vector)))
        seen = np.sum(self._moves[kind] * known[self._ways[kind].unknown], axis=2)
        azimuth = self._azimuth
        wave = np.exp(2j * np.pi * harmonic / self.order * azimuth)
        return np.asarray(wave[:, None] * rotate(seen, azimuth, self.order))


def mirrored_ring(
    order: float, pattern: Pattern, free: Floats, unknown: Ints, on_axis: Ints, images: Images, rows: int
) -> MirroredRing | None:
    """The same of a sector whose nodes are images of each other; None where joints or supports are not.

    Args:
        order: sectors in the ring, more than two.
        pattern: blocks of the tangent by image.
        free: see ``Structure``.
        unknown: numbers of the unknowns of nodes off the axis, (n, 3).
        on_axis: nodes on it that move along it, or across it in harmonic 1.
        images: the reflection.
        rows: unknowns of the harmonics that have most.
    """
    moves = np.asarray(free.any(axis=1))
    off_axis = moves.copy()
    off_axis[on_axis] = False
    if not free[off_axis].all() or not np.array_equal(moves, moves[images.node]):
        return None
    joined = joined_of(pattern, moves, ~off_axis, images)
    return None if joined is None else MirroredRing(order, unknown, on_axis, images, joined, rows)


def _ways(unknown: Ints, on_axis: Ints, images: Images, kind: int) -> Ways:
    """How moves follow from unknowns: those of nodes on the axis as in harmonic 0 or 1."""
    nodes, size = len(unknown), int(unknown.max()) + 1
    number, other = np.arange(nodes), images.node
    own = np.stack([unknown, np.full_like(unknown, -1)], axis=2).astype(np.int64)
    weight = np.zeros((nodes, 3, 2), dtype=np.complex128)
    weight[:, :, 0] = 1.0, 1.0, 1.0j
    first, second = np.flatnonzero(number < other), np.flatnonzero(number > other)
    own[first, :, 1] = unknown[other[first]]
    weight[first] = np.array([HALF_EACH, 1j * HALF_EACH])
    own[second, :, 1] = own[second, :, 0]
    own[second, :, 0] = unknown[other[second]]
    weight[second] = np.array([[1.0], [1.0], [-1.0]]) * np.array([HALF_EACH, -1j * HALF_EACH])
    tail = size + np.arange(len(on_axis))
    own[on_axis] = -1
    if kind == 0:
        own[on_axis, 0, 0] = tail
    else:
        own[on_axis, 1:, 0] = tail[:, None]
        weight[on_axis, 1:, 0] = HALF_EACH, 1j * HALF_EACH
    return Ways(own, weight)


def depths_of(below: Places, before: Places, rows: int) -> Ints:
    """How many columns before its diagonal each row starts, by its entries below the diagonal, (rows and some,).

    All at columns divisible by ``ABREAST``, none before the row ahead of it, and rows to make up a number of them.
    """
    start = np.arange(rows + -rows % ABREAST)
    np.minimum.at(start, below.astype(np.int64), before.astype(np.int64))
    start = np.minimum.accumulate(start[::-1])[::-1] // ABREAST * ABREAST
    return np.asarray(np.arange(len(start)) - start, dtype=np.int32)
