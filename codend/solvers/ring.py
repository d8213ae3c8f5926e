"""A sector as one of a ring: the tangents that its harmonics see, side by side or one alone. See ``harmonics``."""

import math
from copy import copy
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.harmonics import Complex, add_turned_bands, add_up_images, hermitian_parts
from codend.mechanics.newton_state import empty_state, measure, take_over
from codend.mechanics.newton_step import Step, empty_step, linearise
from codend.mechanics.problem import Problem
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import NOTHING_NEAR, Pattern, pattern_of
from codend.net.net import Floats, Ints
from codend.solvers.harmonic_tangent import HarmonicTangent
from codend.solvers.linear_systems import narrow_numbering
from codend.solvers.mirrored_ring import MirroredRing, depths_of, mirrored_ring
from codend.solvers.outcome import Solution
from codend.solvers.ring_images import Images, images_of

Places = NDArray[np.int64]
SWITCH = 0.1
"""Weight of the test for taut bars at an equilibrium, where they are one or the other (``newton_state.measure``)."""
NEUTRAL = 1e-6
"""Shift of a tangent that is asked for stability, over the stiffness that the mean tension gives the nodes: behind a
neck that has closed the bag turns about its axis for nothing, and round-off would give that eigenvalue either sign."""


class Entries(NamedTuple):
    """Entries of a matrix: those of the blocks that are named, each times a weight, added up where they meet."""

    row: Places
    column: Places
    source: Places
    weight: Complex
    """That of a ring of one sector."""
    image: Places
    """Sectors by which its column is turned against its row."""
    on_axis: Places
    """How many of the two are on the axis, whose moves weigh the more the more sectors there are."""

    def weights(self, harmonic: int, order: float) -> Complex:
        """Weights in a harmonic of a ring of so many sectors."""
        turn = np.exp(2j * np.pi * harmonic * self.image / order)
        return np.asarray(self.weight * turn * np.sqrt(order) ** self.on_axis)


class Ring:
    """What depends on a sector's structure alone, and room to work in: kept from one equilibrium to the next.

    Unknowns are the free coordinates of the nodes off the axis, numbered for a narrow band; behind them come those that
    the nodes on it have in a harmonic.
    """

    def __init__(self, structure: Structure, bands: int, near: tuple[Ints, Ints] = NOTHING_NEAR) -> None:
        whole = structure.order.is_integer()
        self.order = int(structure.order) if whole else structure.order
        self.pattern = pattern_of(structure, by_image=True, near=near)
        self.state, self.step = empty_state(structure, bands), empty_step(structure, self.pattern)
        nodes = len(structure.free)
        self._whole_place = np.unique(
            self.pattern.row.astype(np.int64) * nodes + self.pattern.column, return_inverse=True
        )[1]
        self._gathered: Floats | None = None
        self.fronted = False
        """Whether the catch's front follows the net."""
        self.on_axis = np.flatnonzero((structure.free == [1.0, 0.0, 0.0]).all(axis=1)).astype(np.int32)
        images = images_of(structure, self.on_axis) if self.order > 2 else None
        self.unknown = _numbered(structure, self.pattern, self.on_axis, images)
        self.size = int(self.unknown.max()) + 1
        """Unknowns off the axis."""
        row = np.repeat(self.unknown[self.pattern.row][:, :, None], 3, axis=2).ravel()
        column = np.repeat(self.unknown[self.pattern.column][:, None, :], 3, axis=1).ravel()
        image = np.repeat(self.pattern.image, 9)
        self._off_axis = np.flatnonzero((row >= 0) & (column >= 0))
        self._row, self._column, self._image = (part[self._off_axis] for part in (row, column, image))
        self._at_axis = self._entries_at_axis(0), self._entries_at_axis(1)
        tails = max(len(self.axis_moves(k)) for k in (0, 1)) * len(self.on_axis)
        rows = np.concatenate([self._row, *(entries.row for entries in self._at_axis)])
        columns = np.concatenate([self._column, *(entries.column for entries in self._at_axis)])
        self.half = int(np.abs(rows - columns).max())
        """Half-bandwidth."""
        self.depth = depths_of(np.maximum(rows, columns), np.minimum(rows, columns), self.size + tails)
        """How many columns before its diagonal a row starts; see ``negative_pivots_side_by_side``."""
        width, reach = int(self.depth.max()) + 1, int(np.abs(image).max())
        self.even, self.odd = np.zeros((2, reach + 1, self.size, width))
        """C and S of ``mechanics.harmonics``."""
        row, column, image = self._row, self._column, self._image
        off = np.abs(row - column)
        self._tails = self._tail_of(0), self._tail_of(1)
        self._place = np.full(9 * len(self.pattern.row), -1)
        self._place[self._off_axis] = (np.abs(image) * self.size + np.maximum(row, column)) * width + off
        self._weight = np.zeros((len(self._place), 2))
        # an entry on the diagonal is both of a pair, which count half each
        self._weight[self._off_axis, 0] = np.where(off == 0, 1.0, 0.5)
        self._weight[self._off_axis, 1] = 0.5 * np.sign(image) * np.sign(row - column)
        self._as_mirrored: MirroredRing | None = None
        if images is not None:
            self._as_mirrored = mirrored_ring(
                self.order, self.pattern, structure.free, self.unknown, self.on_axis, images, self.size + tails
            )
        self.mirrored: MirroredRing | None = None
        """The same in real numbers, if the tangent that was gathered last is its own mirror image."""
        self.finite = True
        """Whether it is of numbers."""

    def beside(self, structure: Structure, bands: int) -> "Ring":
        """A ring of sectors with the same joints, of which neither are two or both, with room of its own."""
        other = copy(self)
        order = structure.order
        other.order = int(order) if order.is_integer() else order
        if other.order != self.order:
            for of_order in ("_axis_weights", "_turns"):
                other.__dict__.pop(of_order, None)
        other.state, other.step = empty_state(structure, bands), empty_step(structure, self.pattern)
        other.even, other.odd = np.zeros((2, *self.even.shape))
        other._as_mirrored = None if self._as_mirrored is None else self._as_mirrored.beside(other.order)
        return other

    @cached_property
    def _axis_weights(self) -> list[Complex]:
        """Weights of the entries at the axis in harmonics 0 and 1."""
        return [entries.weights(k, self.order) for k, entries in enumerate(self._at_axis)]

    @cached_property
    def _turns(self) -> Floats:
        """Cosine and sine of m phi in harmonics 0 .. n / 2 of a ring of n sectors, (2, reach + 1, harmonics)."""
        angle = np.arange(len(self.even))[:, None] * (2.0 * np.pi / self.order * np.arange(int(self.order // 2) + 1))
        return np.stack([np.cos(angle), np.sin(angle)])

    def linearise(self, problem: Problem, solution: Solution) -> int:
        """Take over the tangent at an equilibrium, shifted by ``NEUTRAL``; how many right sides go with it."""
        structure, state, step = problem.structure, self.state, self.step
        take_over(structure, np.ascontiguousarray(solution.positions), solution.bar_tension, state)
        tension = solution.mean_tension
        measure(structure, problem.loading, tension, SWITCH, 0.0, state)
        sides = linearise(structure, problem.loading, self.pattern, tension, NEUTRAL, state, step)
        self.gather(sides == 2)
        return int(sides)

    def write_whole(self, step: Step) -> None:
        """Write what was taken over into a step of moves that are the same in all sectors, images added up."""
        add_up_images(self.step.blocks, self._whole_place, step.blocks)
        sides = 1 + self.fronted
        step.right[:sides], step.gradient[: sides - 1] = self.step.right[:sides], self.step.gradient[: sides - 1]
        step.hardening[:] = self.step.hardening

    def gather(self, fronted: bool) -> None:
        """Take over the tangent that was written into ``step``, and whether the catch's front follows the net."""
        self.fronted = fronted
        self._gathered = None
        real = self._as_mirrored
        step, front = self.step, None
        if fronted:
            front = step.right[1], step.gradient[0]
        is_mirrored = real is not None and real.gather(step.blocks, self.state.position, self.state.density, front)
        self.mirrored = real if is_mirrored else None
        if self.mirrored is not None:
            self.finite = True
            return
        self.finite = bool(np.isfinite(self.step.blocks).all())
        hermitian_parts(self.step.blocks, self._place, self._weight, self.even, self.odd)

    def axis_moves(self, harmonic: int) -> Complex:
        """Moves of a node on the axis in a harmonic, as a sector sees them and of the size it does, (moves, 3)."""
        return self._axis_ways(harmonic) * np.sqrt(self.order)

    def _axis_ways(self, harmonic: int) -> Complex:
        """The same of the size that a ring of one sector would see."""
        moves: Complex = np.zeros((0, 3), dtype=complex)
        if harmonic == 0:
            moves = np.array([[1.0, 0.0, 0.0]], dtype=complex)
        elif harmonic == 1 and self.order == 2:
            moves = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], dtype=complex)
        elif harmonic == 1:
            moves = np.sqrt(0.5) * np.array([[0.0, 1.0, 1.0j]])
        return moves

    def _entries_at_axis(self, harmonic: int) -> Entries:
        """Entries of a harmonic in the rows and columns of the nodes on the axis."""
        moves, pattern = self._axis_ways(harmonic), self.pattern
        first = np.full(len(self.unknown), -1)
        first[self.on_axis] = self.size + len(moves) * np.arange(len(self.on_axis))

        def ways(node: int, moves: Complex) -> tuple[NDArray[np.integer], Complex]:
            """Unknowns of a node, and how each weighs its coordinates, (unknowns, 3)."""
            if first[node] < 0:
                return self.unknown[node], np.eye(3, dtype=np.complex128)
            return first[node] + np.arange(len(moves), dtype=np.int32), moves

        found: list[tuple[int, int, int, int, int, complex]] = []
        for block in np.flatnonzero((first[pattern.row] >= 0) | (first[pattern.column] >= 0)):
            ends = int(first[pattern.row[block]] >= 0) + int(first[pattern.column[block]] >= 0)
            rows, by_row = ways(pattern.row[block], moves.conj())
            columns, by_column = ways(pattern.column[block], moves)
            for a, b, i, j in np.ndindex(len(rows), len(columns), 3, 3):
                weight = by_row[a, i] * by_column[b, j]
                if weight != 0.0 and rows[a] >= 0 and columns[b] >= 0:
                    place = int(rows[a]), int(columns[b]), int(9 * block + 3 * i + j)
                    found.append((*place, int(pattern.image[block]), ends, complex(weight)))
        row, column, source, image, on_axis = np.array([e[:5] for e in found], dtype=np.int64).reshape(-1, 5).T
        return Entries(row, column, source, np.array([e[5] for e in found], dtype=complex), image, on_axis)

    def _values_at_axis(self, harmonic: int) -> tuple[Places, Places, Complex]:
        entries = self._at_axis[harmonic]
        values = self._axis_weights[harmonic] * self.step.blocks.reshape(-1)[entries.source]
        return entries.row, entries.column, values

    def turn_and_tail(self, harmonics: NDArray[np.integer]) -> tuple[Floats, Floats]:
        """What ``negative_pivots_side_by_side`` asks for of some harmonics."""
        rows, width = len(self.depth) - self.size, self.even.shape[2]
        tail = np.zeros((rows, width, 2, len(harmonics)))
        tail[:, 0, 0] = 1.0
        for lane in np.flatnonzero(harmonics <= 1):
            place, held, real, imaginary = self._tails[harmonics[lane]]
            value = self._values_at_axis(harmonics[lane])[2]
            parts = real * value.real, imaginary * value.imag
            for i, part in enumerate(parts):
                tail[:, :, i, lane] = np.bincount(place, part, rows * width).reshape(rows, width)
            tail[held, 0, 0, lane] = 1.0
        return np.take(self._turns, harmonics, axis=2), tail

    def _tail_of(self, harmonic: int) -> tuple[Places, NDArray[np.bool_], Floats, Floats]:
        """Of the entries at the axis in a harmonic where they go among the tail's, and what their two parts weigh.

        Between the two, rows that it does not have. Of each pair of entries the lower counts, of which the upper is the
        conjugate.
        """
        entries = self._at_axis[harmonic]
        below, width = np.maximum(entries.row, entries.column) - self.size, self.even.shape[2]
        weight = np.where(entries.row == entries.column, 1.0, 0.5)
        held = np.ones(len(self.depth) - self.size, dtype=bool)
        held[below] = False
        place = below * width + np.abs(entries.row - entries.column)
        return place, held, weight, np.where(entries.row >= entries.column, weight, -weight)

    def tangent(self, harmonic: int) -> HarmonicTangent:
        """Tangent of a harmonic at the equilibrium that was gathered last."""
        if self.mirrored is not None:
            return self.mirrored.tangent(harmonic)
        count = len(self.axis_moves(harmonic)) * len(self.on_axis)
        half, reach = self.half, len(self.even) - 1
        turns = np.exp(2j * np.pi * harmonic / self.order * np.arange(-reach, reach + 1))
        if real := 2 * harmonic in (0, self.order):
            turns = turns.real
        band = np.zeros((2 * half + 1, self.size + count), dtype=turns.dtype)
        add_turned_bands(self._bands, turns, band)
        if count:
            row, column, value = self._values_at_axis(harmonic)
            np.add.at(band, (half + row - column, column), value.real if real else value)
        front = None
        if harmonic == 0 and self.fronted:
            front = self._of_harmonic_0(self.step.right[1]), self._of_harmonic_0(self.step.gradient[0])
        return HarmonicTangent(band, front)

    @property
    def _bands(self) -> Floats:
        """B_m of the unknowns off the axis as bands, laid out as ``HarmonicTangent.band``, (images, ...)."""
        if self._gathered is None:
            half, reach = self.half, len(self.even) - 1
            shape = 2 * reach + 1, 2 * half + 1, self.size
            place = ((self._image + reach) * shape[1] + half + self._row - self._column) * shape[2] + self._column
            entries = self.step.blocks.reshape(-1)[self._off_axis]
            gathered = np.bincount(place, entries, math.prod(shape))
            self._gathered = np.asarray(gathered, dtype=np.float64).reshape(shape)
        return self._gathered

    def _of_harmonic_0(self, values: Floats) -> Floats:
        """Values at the nodes, (n, 3), as those at the unknowns of harmonic 0."""
        free = self.unknown >= 0
        off_axis = np.zeros(self.size)
        off_axis[self.unknown[free]] = values[free]
        return np.append(off_axis, values[self.on_axis] @ self.axis_moves(0)[0].real)

    def shape_of(self, vector: Complex, harmonic: int) -> Complex:
        """Moves of a sector's nodes by the unknowns of a harmonic, (n, 3), the largest component 1."""
        if self.mirrored is not None:
            shape = self.mirrored.moves_of(vector, harmonic)
        else:
            free = self.unknown >= 0
            shape = np.zeros(self.unknown.shape, dtype=complex)
            shape[free] = vector[self.unknown[free]]
            moves = self.axis_moves(harmonic)
            shape[self.on_axis] = vector[self.size :].reshape(len(self.on_axis), len(moves)) @ moves
        return shape / shape.reshape(-1)[np.abs(shape).argmax()]


def _numbered(structure: Structure, pattern: Pattern, on_axis: Ints, images: Images | None) -> Ints:
    """Number of the unknown of every free coordinate off the axis, -1 for the others, (n, 3); near the axis is last.

    Nodes that are mirror images of each other follow each other.
    """
    nodes = len(structure.free)
    _, pair = np.unique(_first_of(nodes, images), return_inverse=True)
    pairs = int(pair.max()) + 1
    place = narrow_numbering(pair[pattern.row].astype(np.int32), pair[pattern.column].astype(np.int32), pairs)[pair]
    if len(on_axis) and place[on_axis].mean() < 0.5 * pairs:
        place = pairs - 1 - place
    free = structure.free > 0.0
    free[on_axis] = False
    unknown = np.full(free.shape, -1, dtype=np.int32)
    order = np.argsort(place, kind="stable")
    rows, ways = np.nonzero(free[order])
    unknown[order[rows], ways] = np.arange(len(rows))
    return unknown


def _first_of(nodes: int, images: Images | None) -> Ints:
    """The first node of each pair of nodes that are images of each other, (n,)."""
    own = np.arange(nodes, dtype=np.int32)
    return own if images is None else np.minimum(own, images.node)
