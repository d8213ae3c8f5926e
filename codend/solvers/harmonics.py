"""Whether an equilibrium of a sector is stable against changes that vary from sector to sector.

The tangent of the whole net is block-circulant once the forces and moves of every sector are written in its own axes:
a change exp(i k theta) sees K_k (``mechanics.harmonics``), and the eigenvalues of K_k, k = 0 .. n - 1, are together
those of the whole net's tangent. Those of n - k are conjugate to those of k. A change grows where an eigenvalue has a
negative real part; where the Hermitian part of K_k is positive definite, none has.

A node on the axis, as the codline is, belongs to all sectors. Seen from sector s a move w of it is R^-s w, R the turn
by one sector. With R (0, 1, i) = exp(-2 pi i / n) (0, 1, i) its moves along the axis vary as k = 0, and those across as
k = 1 and n - 1. Where the moves of sectors are normalised, u_s = v exp(2 pi i k s / n) / sqrt(n), its column and row
weigh sqrt(n) times what one sector has of them. It is held across the flow in a sector, but by nothing in the net.

Every tangent is shifted by ``ring.NEUTRAL``: what moves for nothing, as slack twine does, does not count as growing.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from codend.mechanics.harmonics import Complex, negative_pivots_side_by_side, solve_band_of_numbers
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.harmonic_tangent import FIRST_STEPS, HarmonicTangent, Nearest
from codend.solvers.outcome import Solution
from codend.solvers.ring import Ring

Numbers = NDArray[np.integer]

CLOSE = 1.5
"""Factor within which the lowest eigenvalue of a Hermitian part is bounded."""
MOST_SIDE_BY_SIDE = 96
"""Harmonics factorised at a time: as many as fit into the nearest cache."""
AT_FIRST, LED = 8, 6
"""Steps of Arnoldi's method before it is first looked what it found beside 0, and led by the harmonic before."""
DENSE = 40
"""Unknowns up to which all eigenvalues of a harmonic are found at once."""
NEARER, NEARER_BY = 3, 0.2
"""How many numbers between the bound and 0 eigenvalues are sought about, and the factor between them."""
AS_BEFORE = 1.0, 1.1, 1.2
"""How many are wanted about 0, over what was enough for the harmonic before."""
MOST_ABOUT_NONE = 640
"""Steps of Arnoldi's method about 0 in all: four times as many as eigenvalues are asked for there at most."""
ONE = 1e-5
"""Distance of an eigenvector, of length 1, from those found before it, up to which it counts as one of them."""
DENSE_AT_LAST = 1500
"""Unknowns up to which they are where the lowest were not found otherwise."""


@dataclass(frozen=True)
class Growth:
    """Changes of one harmonic that grow."""

    harmonic: int
    eigenvalues: Complex
    """Those of K_k with negative real parts, N/m, the most negative first."""
    shape: Complex
    """How the first of them moves the nodes of a sector, (n, 3), its largest component 1: those of the s-th sector on
    by the real part of shape exp(2 pi i k s / n), each in its own axes."""


@dataclass(frozen=True)
class Harmonics:
    """What grows of an equilibrium of a sector."""

    order: float
    growing: tuple[Growth, ...]
    undecided: tuple[int, ...]
    """Harmonics whose eigenvalues were not found."""

    @property
    def strongest(self) -> Growth | None:
        """The harmonic that grows most."""
        return min(self.growing, key=lambda growth: growth.eigenvalues[0].real, default=None)

    @property
    def directions(self) -> int:
        """In how many directions the whole net runs away, the harmonics n - k included."""
        return sum(len(g.eigenvalues) * (1 if 2 * g.harmonic % self.order == 0 else 2) for g in self.growing)


def harmonics_of(problem: Problem, solution: Solution, ring: Ring) -> Harmonics:
    """Ask every harmonic, 0 .. n / 2, of an equilibrium of a sector.

    Those whose Hermitian part is positive definite, by its pivots, are stable. Of the others the eigenvalues in the
    left half-plane are found.
    """
    ring.linearise(problem, solution)
    return growing_harmonics(ring, stiffness_under_tension(problem, solution))


def stiffness_under_tension(problem: Problem, solution: Solution) -> float:
    """Stiffness of a bar against moves across it, N/m, in the mean."""
    return solution.mean_tension / float(problem.structure.length.mean())


def growing_harmonics(ring: Ring, scale: float, strongest_alone: bool = False) -> Harmonics:
    """What grows by the tangent that was gathered last.

    Args:
        ring: with the tangent.
        scale: a stiffness, N/m, of the net's order of size.
        strongest_alone: of a harmonic that grows no more is found than some eigenvalue near its lowest, which is quick.
    """
    asked = np.arange(int(ring.order // 2) + 1)
    if not ring.finite:
        return Harmonics(ring.order, (), tuple(asked.tolist()))
    negative = negative_pivots(ring, asked, np.zeros(len(asked)))
    with_front = negative.copy()
    if ring.fronted:
        with_front[0] = ring.tangent(0).negative_eigenvalues(int(negative[0]))
    doubtful = asked[with_front > 0]
    if len(doubtful) == 0:
        return Harmonics(ring.order, (), ())
    with _libraries().limit(limits=1, user_api="blas"):
        found: dict[int, tuple[Complex, Complex] | None] = {}
        led: Complex | None = None
        for k in doubtful.tolist():
            if strongest_alone:
                found[k] = None
                continue
            found[k] = pair = _nearest_to_none(ring.tangent(k), int(negative[k]), int(with_front[k]), led)
            led = None if pair is None else pair[1].sum(axis=1)
        left = np.array([k for k, pair in found.items() if pair is None], dtype=doubtful.dtype)
        enough = 0
        for k, lowest in zip(left.tolist(), _lower_bounds(ring, left, scale), strict=True):
            tangent = ring.tangent(k)
            first = tangent.nearest(lowest).eigenvalues(1) if strongest_alone and not enough else None
            if first is not None and first[0].real.min() < 0.0:
                found[k] = first
                continue
            if first is not None:  # often nothing grows
                found[k] = _nearest_to_none(tangent, int(negative[k]), int(with_front[k]), None)
                if found[k] is not None:
                    continue
            found[k], enough = _lowest_eigenvalues(tangent, lowest, int(negative[k]), int(with_front[k]), enough)
    growing, undecided = [], []
    for k, pair in found.items():
        if pair is None:
            undecided.append(k)
            continue
        eigenvalues, vectors = pair
        grows = np.flatnonzero(eigenvalues.real < 0.0)
        if len(grows):
            grows = grows[np.argsort(eigenvalues[grows].real)]
            growing.append(Growth(k, eigenvalues[grows], ring.shape_of(vectors[:, grows[0]], k)))
    return Harmonics(ring.order, tuple(growing), tuple(undecided))


def most_growth(ring: Ring, scale: float) -> float:
    """The most that anything may grow by the tangent that was gathered last, N/m; 0 where nothing does.

    A bound by pivots alone, in a moment: of nets in which hundreds of ways grow finding them takes a minute.
    """
    asked = np.arange(int(ring.order // 2) + 1)
    negative = negative_pivots(ring, asked, np.zeros(len(asked)))
    with_front = ring.tangent(0).negative_eigenvalues(int(negative[0])) if ring.fronted else 0
    doubtful = asked[negative > 0] if negative.any() or with_front == 0 else asked[:1]
    return float(-_lower_bounds(ring, doubtful, scale).min(initial=0.0))


def sway_stiffness(ring: Ring) -> float:
    """The force across the flow that moves the codline aside, the whole net following, over its move, N/m, at least.

    By the tangent that was gathered last: harmonics 1 and n - 1 make up the force and its move.
    """
    tangent = ring.tangent(1)
    factors = tangent.factors(0.0)
    ways = tangent.size - ring.size
    moves = np.zeros((ways, tangent.size), dtype=factors.dtype)
    moves[:, ring.size :] = np.eye(ways)
    for side in moves:
        solve_band_of_numbers(factors, side)
    return softest(moves[:, ring.size :])


def softest(moves: NDArray[np.inexact]) -> float:
    """Least stiffness, by the moves by unit forces: what moves of its own accord has a negative one."""
    stiffness = np.linalg.eigvals(np.linalg.inv(moves)).real
    return float(stiffness.min())


@cache
def _libraries() -> ThreadpoolController:
    """Matrices as small as a harmonic's projections take far longer where libraries share them out among threads."""
    return ThreadpoolController()


def negative_pivots(ring: Ring, harmonics: Numbers, shift: Floats) -> Numbers:
    """Negative eigenvalues of the Hermitian parts of harmonics, each shifted by its own; the front stands still."""
    if ring.mirrored is not None:
        return ring.mirrored.negative_pivots(harmonics, shift)
    negative = np.empty(len(harmonics), dtype=np.int64)
    for start in range(0, len(harmonics), MOST_SIDE_BY_SIDE):
        part = slice(start, start + MOST_SIDE_BY_SIDE)
        turn, tail = ring.turn_and_tail(harmonics[part])
        negative_pivots_side_by_side(ring.even, ring.odd, ring.depth, turn, shift[part], tail, negative[part])
    return negative


def _lower_bounds(ring: Ring, harmonics: Numbers, scale: float) -> Floats:
    """Bounds on the lowest eigenvalues of the Hermitian parts of harmonics, N/m; the front stands still.

    They are of ``CLOSE`` times their size at most, or of 1e-2 ``scale``.
    """
    bound = np.full(len(harmonics), 1e-2 * scale)
    left = np.arange(len(harmonics))
    while len(left):
        left = left[negative_pivots(ring, harmonics[left], bound[left]) > 0]
        bound[left] *= CLOSE
    return -bound


def _nearest_to_none(
    tangent: HarmonicTangent, negative: int, expected: int, led: Complex | None
) -> tuple[Complex, Complex] | None:
    """Those eigenvalues nearest to 0, where the rest is proved to be stable: in a few steps, and nearly always enough.

    The arguments are those of ``_lowest_eigenvalues``, and the sum of the vectors of the harmonic before.
    """
    if not tangent.size > DENSE or expected >= tangent.size // 4:
        return None
    found = tangent.nearest(0.0, led=led).eigenvalues(expected, AT_FIRST if led is None else LED)
    if found is None:
        return None
    vectors = found[1]
    basis = vectors / np.linalg.norm(vectors) if vectors.shape[1] == 1 else np.linalg.qr(vectors)[0]
    return None if tangent.negative_eigenvalues(negative, basis) > 0 else found


def _lowest_eigenvalues(
    tangent: HarmonicTangent, lowest: float, negative: int, expected: int, enough: int
) -> tuple[tuple[Complex, Complex] | None, int]:
    """All eigenvalues of a harmonic with negative real parts, and others; with their vectors. None if they hide.

    Those nearest to a lower bound are found, then those nearest to numbers between that and 0, and ever more about 0,
    until on what they leave the Hermitian part is positive definite: that proves the rest to be stable. Some of slack
    netting lie so near to 0 that the Hermitian part is negative among them though none of them is.

    Returns:
        eigenvalues and vectors, and how many were wanted about 0 if that decided.

    Args:
        tangent: the harmonic's.
        lowest: a bound on the eigenvalues of its Hermitian part, the front left out, N/m.
        negative: how many of these are negative.
        expected: how many are with the front: often as many as eigenvalues are needed.
        enough: how many were wanted about 0 of the harmonic before, if that decided there: it is tried first.
    """
    found: tuple[Complex, Complex] | None = None
    seekers: dict[float, Nearest] = {}
    for centre, wanted in _places_to_look(tangent.size, lowest, expected, enough):
        if centre not in seekers:
            seekers[centre] = tangent.nearest(centre, max(FIRST_STEPS, 4 * wanted) if centre else MOST_ABOUT_NONE)
        part = seekers[centre].eigenvalues(wanted)
        if part is None:
            continue
        found, basis = _joined(found, part)
        if tangent.negative_eigenvalues(negative, basis) == 0:
            return found, 0 if centre else wanted
    return np.linalg.eig(tangent.dense()) if tangent.size <= DENSE_AT_LAST else None, 0


def _places_to_look(size: int, lowest: float, expected: int, enough: int) -> Iterator[tuple[float, int]]:
    """Numbers about which eigenvalues are sought, and how many there: none where dense matrices are as quick."""
    if size <= DENSE or expected >= size // 4:
        return
    most = min(size // 8, MOST_ABOUT_NONE // 4)
    for share in AS_BEFORE if enough else ():
        yield 0.0, min(int(share * enough), most)
    yield lowest, expected
    for fall in range(1, NEARER + 1):
        yield lowest * NEARER_BY**fall, expected + 2
    wanted = max(expected + 2, min(enough, most))
    while wanted <= most:
        yield 0.0, wanted
        wanted += wanted // 3


def _joined(
    found: tuple[Complex, Complex] | None, part: tuple[Complex, Complex]
) -> tuple[tuple[Complex, Complex], Complex]:
    """Eigenvalues and vectors of both, each once, and an orthonormal basis of the vectors."""
    values, vectors = part if found is None else (np.append(found[0], part[0]), np.hstack([found[1], part[1]]))
    vectors = vectors / np.linalg.norm(vectors, axis=0)
    # one that was found before, or any of several that are one but for round-off, adds nothing but that
    new = np.abs(np.diag(np.linalg.qr(vectors, mode="r"))) > ONE
    values, vectors = values[new], vectors[:, new]
    return (values, vectors), np.linalg.qr(vectors)[0]
