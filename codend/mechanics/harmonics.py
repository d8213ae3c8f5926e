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
from codend.mechanics.lanes import (
    LANES,
    add_multiple,
    aligned,
    take_conjugate_products,
    write_inverse,
    write_multiple,
    write_product,
)
from codend.net.net import Floats, Ints

Complex = NDArray[np.complex128]
Places = NDArray[np.int64]
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


@njit(cache=True, error_model="numpy")
def add_up_images(blocks: Floats, place: Ints, whole: Floats) -> None:
    """Write the tangent for moves that are the same in all sectors: blocks of all images of a pair of nodes added up.

    Args:
        blocks: by image, (b, 3, 3).
        place: that of each in ``whole``, (b,).
        whole: is written, (c, 3, 3).
    """
    whole[:] = 0.0
    for block in range(len(place)):
        for i in range(3):
            for j in range(3):
                whole[place[block], i, j] += blocks[block, i, j]


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
    rows, count, number = len(depth), len(shift), 2 * LANES
    # rows j to j + width - 1, each at its number modulo width: its places, real and imaginary parts of all lanes
    window, scaled = aligned(width * width * number), aligned(width * number)
    start = np.arange(2 * width) % width * width * number
    wave, shifted, inverse, counted = (aligned(2 * turns * LANES), aligned(LANES), aligned(LANES), aligned(LANES))
    places, evens, odds = np.empty(width, dtype=np.int64), even.reshape(-1), odd.reshape(-1)
    for first in range(0, count, LANES):
        used = min(LANES, count - first)
        # lanes to spare hold ones
        wave[:], window[:], shifted[:], counted[:] = 1.0, 1.0, 0.0, 0.0
        for lane in range(used):
            shifted[lane] = shift[first + lane]
            for m in range(turns):
                wave[2 * m * LANES + lane] = turn[0, m, first + lane]
                wave[(2 * m + 1) * LANES + lane] = turn[1, m, first + lane]
        ready, turned = 0, 0
        for j in range(rows):
            while ready < min(j + width, rows):
                at = start[turned + ready - j]
                if ready < unknowns:
                    entry = ready * width
                    write_entries(evens, odds, entry, entry + depth[ready] + 1, unknowns * width, wave, window, at)
                else:
                    for d in range(depth[ready] + 1):
                        for lane in range(used):
                            window[at + d * number + lane] = tail[ready - unknowns, d, 0, first + lane]
                            window[at + d * number + LANES + lane] = tail[ready - unknowns, d, 1, first + lane]
                add_multiple(window, at, shifted, 0, 1.0)
                ready += 1
            write_inverse(inverse, window, start[turned], counted)
            below = 0
            for d in range(1, min(width, rows - j)):
                if depth[j + d] >= d:
                    places[below] = d * number
                    below += 1
                    take_column(window, start[turned + d] + d * number, inverse, scaled, places, below)
            turned = turned + 1 if turned + 1 < width else 0
        for lane in range(used):
            negative[first + lane] = int(counted[lane])


@njit(cache=True, error_model="numpy")
def write_entries(
    evens: Floats, odds: Floats, entry: int, past: int, size: int, wave: Floats, window: Floats, at: int
) -> None:
    """Write entries of the Hermitian parts of harmonics that follow one another in C and S, both flattened.

    Args:
        evens: C, image by image.
        odds: S, likewise.
        entry: the first entry's place in them.
        past: the place after the last.
        size: entries of an image.
        wave: cosine and sine of m phi in lanes, m by m.
        window: is written.
        at: where.
    """
    for first in range(entry, past):
        write_multiple(window, at, wave, 0, evens[first])
        write_multiple(window, at + LANES, wave, LANES, odds[first])
        turn = 2 * LANES
        for place in range(first + size, len(evens), size):
            if evens[place] != 0.0:
                add_multiple(window, at, wave, turn, evens[place])
            if odds[place] != 0.0:
                add_multiple(window, at + LANES, wave, turn + LANES, odds[place])
            turn += 2 * LANES
        at += 2 * LANES


@njit(cache=True, error_model="numpy")
def take_column(window: Floats, at: int, inverse: Floats, scaled: Floats, places: Places, below: int) -> None:
    """Take from a row its entry in a column times, over the pivot and conjugate, the rows from the pivot's to itself.

    Args:
        window: rows in lanes.
        at: where the row's entry in the column is.
        inverse: over the pivot, (lanes,).
        scaled: entries of the column over the pivot; this row's is written.
        places: where in ``scaled`` those are of the rows that reach the column, from the pivot's.
        below: how many there are up to this row.
    """
    place = places[below - 1]
    write_product(scaled, place, window, at, inverse, 0)
    write_product(scaled, place + LANES, window, at + LANES, inverse, 0)
    take_conjugate_products(window, at, scaled, places, below)


@njit(cache=True, error_model="numpy")
def add_turned_bands(bands: Floats, turns: Numbers, band: Numbers) -> None:
    """Add the bands of all images, (images, width, unknowns), each times its turn, to the first columns of a band."""
    images, width, size = bands.shape
    for image in range(images):
        turn = turns[image]
        for i in range(width):
            for j in range(size):
                band[i, j] += turn * bands[image, i, j]


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
def band_times(band: Numbers, vectors: Numbers) -> Numbers:
    """Products of a band, laid out as for ``write_rows``, with vectors (unknowns, k), which are complex if it is."""
    width, size = band.shape
    half, product = width // 2, np.zeros_like(vectors)
    for d in range(width):
        lower = d - half
        for j in range(max(0, -lower), min(size, size - lower)):
            for k in range(vectors.shape[1]):
                product[j + lower, k] += band[d, j] * vectors[j, k]
    return product


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


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def solve_band_of_numbers(band: Numbers, x: Numbers) -> None:
    """Solve in place with the factors of ``factorise_band_of_numbers``, (unknowns,)."""
    size, width = band.shape
    half = width // 2
    for i in range(size):
        value = x[i]
        for j in range(max(0, i - half), i):
            value -= band[i, half + j - i] * x[j]
        x[i] = value
    for i in range(size - 1, -1, -1):
        value = x[i]
        for j in range(i + 1, min(size, i + half + 1)):
            value -= band[i, half + j - i] * x[j]
        x[i] = value / band[i, half]


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
