"""Changes of a net that vary round the ring of its sectors, harmonic by harmonic: kernels.

Let B_m be the derivative of minus the forces on a sector by the moves of the m-th sector on, each in its own axes. A
change exp(i k theta) from sector to sector sees K_k = sum over m of B_m exp(i m phi), phi = 2 pi k / n, n the order. Of
its Hermitian part all harmonics share the real coefficients:

    H_k = C_0 + sum over m > 0 of (C_m cos m phi + i S_m sin m phi)

so they are factorised side by side. Of H_k, S and C row i holds column i - d of the lower triangle in place d.
"""

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.lanes import LANES, take_conjugate_product
from codend.net.net import Floats, Ints

Complex = NDArray[np.complex128]
Numbers = NDArray[np.inexact]
"""Complex, or real where every turn is: in harmonic 0, and in that of half the order."""


@njit(cache=True, error_model="numpy")
def hermitian_parts(blocks: Floats, place: Ints, weight: Floats, even: Floats, odd: Floats) -> None:
    """Gather the blocks by image into C and S.

    Args:
        blocks: (b, 3, 3).
        place: where an entry goes in C and in S, -1 for coordinates that are held, (9 b,).
        weight: how it counts in either, (9 b, 2).
        even: C is written, (reach + 1, unknowns, width).
        odd: S is written, likewise.
    """
    even[:] = 0.0
    odd[:] = 0.0
    entries, evens, odds = blocks.reshape(-1), even.reshape(-1), odd.reshape(-1)
    for entry in range(len(place)):
        where = place[entry]
        if where >= 0:
            evens[where] += weight[entry, 0] * entries[entry]
            odds[where] += weight[entry, 1] * entries[entry]


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def negative_pivots_side_by_side(
    even: Floats, odd: Floats, depth: Ints, turn: Floats, shift: Floats, tail: Floats, negative: Ints
) -> None:
    """Count the negative pivots of the Hermitian parts of some harmonics, factorised as L D L^H without pivoting.

    They are as many as negative eigenvalues. A pivot that is 0, or no number, counts as negative.

    Args:
        even: C, (reach + 1, unknowns, width).
        odd: S, likewise.
        depth: how many columns before its diagonal a row starts, that of the rows of ``tail`` included, (rows,).
        turn: cosine and sine of m phi, (2, reach + 1, harmonics).
        shift: added to the diagonal, (harmonics,).
        tail: real and imaginary part of further rows, which each harmonic has of its own, (..., width, 2, harmonics).
        negative: the counts are written, (harmonics,).
    """
    turns, unknowns, width = even.shape
    rows, count = len(depth), len(shift)
    # whole vectors of lanes; those to spare hold ones
    lanes = (count + LANES - 1) // LANES * LANES
    wave = np.ones((2, turns, lanes))
    wave[:, :, :count] = turn
    # rows j to j + width - 1, each at its number modulo width: its places, real and imaginary parts
    window, scaled = np.ones(width * width * 2 * lanes), np.empty(width * 2 * lanes)
    negative[:] = 0
    ready = 0
    for j in range(rows):
        while ready < min(j + width, rows):
            start = ready % width * width * 2 * lanes
            for d in range(depth[ready] + 1):
                entry = window[start + 2 * d * lanes :][: 2 * lanes]
                if ready >= unknowns:
                    entry[:count], entry[lanes : lanes + count] = (
                        tail[ready - unknowns, d, 0],
                        tail[ready - unknowns, d, 1],
                    )
                    continue
                entry[:lanes] = even[0, ready, d]
                entry[lanes:] = 0.0
                for m in range(1, turns):
                    c, s = even[m, ready, d], odd[m, ready, d]
                    if c != 0.0:
                        for lane in range(lanes):
                            entry[lane] += c * wave[0, m, lane]
                    if s != 0.0:
                        for lane in range(lanes):
                            entry[lanes + lane] += s * wave[1, m, lane]
            for lane in range(count):
                window[start + lane] += shift[lane]
            ready += 1
        pivot = window[j % width * width * 2 * lanes :][:lanes]
        for lane in range(count):
            negative[lane] += 0 if pivot[lane] > 0.0 else 1
        for lane in range(lanes):
            pivot[lane] = 1.0 / pivot[lane]
        for d in range(1, min(width, rows - j)):
            if depth[j + d] < d:
                continue
            row = (j + d) % width * width * 2 * lanes
            x = row + 2 * d * lanes
            by_pivot, entry = scaled[2 * d * lanes : 2 * (d + 1) * lanes], window[x : x + 2 * lanes]
            for lane in range(lanes):
                by_pivot[lane] = entry[lane] * pivot[lane]
            for lane in range(lanes):
                by_pivot[lanes + lane] = entry[lanes + lane] * pivot[lane]
            # row j + d less its entry in column j times, over the pivot and conjugate, those of rows j + 1 to j + d
            for e in range(1, d + 1):
                if depth[j + e] < e:
                    continue
                real_at, u = row + 2 * (d - e) * lanes, 2 * e * lanes
                for lane in range(0, lanes, LANES):
                    take_conjugate_product(
                        window,
                        scaled,
                        real_at + lane,
                        real_at + lanes + lane,
                        x + lane,
                        x + lanes + lane,
                        u + lane,
                        u + lanes + lane,
                    )


@njit(cache=True, error_model="numpy")
def write_rows(band: Numbers, centre: float, hermitian: bool, rows: Numbers) -> None:
    """Write a band, or its Hermitian part, less ``centre`` on its diagonal, as ``factorise_band_of_numbers`` takes it.

    Entry (i, j) stands in ``band[half + i - j, j]`` and goes into ``rows[i, half + j - i]``.
    """
    width, size = band.shape
    half = width // 2
    for i in range(size):
        for j in range(max(0, i - half), min(size, i + half + 1)):
            entry = band[half + i - j, j]
            if hermitian:
                entry = 0.5 * (entry + np.conj(band[half + j - i, i]))
            rows[i, half + j - i] = entry
        rows[i, half] -= centre


@njit(cache=True, error_model="numpy")
def factorise_band_of_numbers(band: Numbers) -> None:
    """Factorise a band in place as L U without pivoting: entry (i, j) in ``band[i, half + j - i]``."""
    size, width = band.shape
    half = width // 2
    for k in range(size):
        inverse = 1.0 / band[k, half]
        for below in range(1, min(half, size - 1 - k) + 1):
            row, start = band[k + below], half - below
            factor = row[start] * inverse
            row[start] = factor
            if factor != 0.0:
                for i in range(1, min(half, size - 1 - k) + 1):
                    row[start + i] -= factor * band[k, half + i]


@njit(cache=True, error_model="numpy")
def solve_band_of_numbers(band: Numbers, x: Numbers) -> None:
    """Solve in place with the factors of ``factorise_band_of_numbers``, (unknowns,)."""
    size, width = band.shape
    half = width // 2
    for i in range(size):
        for j in range(max(0, i - half), i):
            x[i] -= band[i, half + j - i] * x[j]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, min(size, i + half + 1)):
            x[i] -= band[i, half + j - i] * x[j]
        x[i] /= band[i, half]


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def arnoldi(
    band: Numbers, by_load: Numbers, gradient: Numbers, first: int, last: int, basis: Numbers, projection: Numbers
) -> None:
    """Carry Arnoldi's method for the inverse of a tangent on from step ``first`` to ``last``.

    Library routines would share such short vectors out among threads, which takes far longer than the work.

    Args:
        band: factors of the band.
        by_load: what the front's product adds to a solution y is ``by_load`` times the sum of ``gradient`` y.
        gradient: see there.
        first: steps that were made.
        last: steps to have made.
        basis: its rows are orthonormal, ``first`` + 1 of them are there, (steps + 1, unknowns).
        projection: column m holds the parts of the inverse of row m along the rows, (steps + 1, steps).
    """
    size, zero = basis.shape[1], 0.0 * basis[0, 0]
    for m in range(first, last):
        new = basis[m + 1]
        new[:] = basis[m]
        solve_band_of_numbers(band, new)
        along = zero
        for i in range(size):
            along += gradient[i] * new[i]
        for i in range(size):
            new[i] += along * by_load[i]
        for _ in range(2):  # once more against round-off
            for row in range(m + 1):
                old, part = basis[row], zero
                for i in range(size):
                    part += np.conj(old[i]) * new[i]
                projection[row, m] += part
                for i in range(size):
                    new[i] -= part * old[i]
        squares = 0.0
        for i in range(size):
            squares += new[i].real ** 2 + new[i].imag ** 2
        projection[m + 1, m] = np.sqrt(squares)
        for i in range(size):
            new[i] /= np.sqrt(squares)
