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
    aligned,
    less_product,
    load,
    one_more_if_low,
    one_over,
    plus_product,
    spread,
    store,
    times,
)
from codend.net.net import Floats, Ints

Complex = NDArray[np.complex128]
ABREAST = 3
"""Columns that are eliminated at a time: as many as a node has coordinates."""
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
            if weight[entry, 1] != 0.0:
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

    They are as many as negative eigenvalues. A pivot that is 0, or no number, counts as negative. ``ABREAST`` columns
    are eliminated at a time, so that what lies behind them is read and written once for all of them.

    Args:
        even: C, (reach + 1, unknowns, width).
        odd: S, likewise.
        depth: how many columns before its diagonal a row starts, that of the rows of ``tail`` included, (rows,): no
            row before the one ahead of it, and all at columns that are divisible by ``ABREAST``, as the rows are.
        turn: cosine and sine of m phi, (2, reach + 1, harmonics).
        shift: added to the diagonal, (harmonics,).
        tail: real and imaginary part of further rows, which each harmonic has of its own, (..., width, 2, harmonics).
        negative: the counts are written, (harmonics,).
    """
    turns, unknowns, width = even.shape
    rows, count, number = len(depth), len(shift), 2 * LANES
    # rows j to j + width - 1, each at its number modulo width: its places, real and imaginary parts of all lanes
    window, scaled = aligned(width * width * number), aligned(width * ABREAST * number)
    start = np.arange(2 * width) % width * width * number
    wave, own, counted = aligned(2 * turns * LANES), aligned(LANES), aligned(LANES)
    evens, odds = even.reshape(-1), odd.reshape(-1)
    for first in range(0, count, LANES):
        used = min(LANES, count - first)
        # lanes to spare hold ones
        wave[:], window[:], own[:] = 1.0, 1.0, 0.0
        for lane in range(used):
            own[lane] = shift[first + lane]
            for m in range(turns):
                wave[2 * m * LANES + lane] = turn[0, m, first + lane]
                wave[(2 * m + 1) * LANES + lane] = turn[1, m, first + lane]
        shifted, low, ready, turned = load(own, 0), spread(0.0), 0, 0
        for j in range(0, rows, ABREAST):
            while ready < rows and ready - depth[ready] <= j:
                at = start[turned + ready - j]
                if ready < unknowns:
                    entry = ready * width
                    write_entries(evens, odds, entry, entry + depth[ready] + 1, unknowns * width, wave, window, at)
                else:
                    for d in range(depth[ready] + 1):
                        for lane in range(used):
                            window[at + d * number + lane] = tail[ready - unknowns, d, 0, first + lane]
                            window[at + d * number + LANES + lane] = tail[ready - unknowns, d, 1, first + lane]
                store(window, at, plus_product(load(window, at), shifted, spread(1.0)))
                ready += 1
            a, b, c = start[turned], start[turned + 1], start[turned + 2]
            p = load(window, a)
            p_inverse = one_over(p)
            bp_re, bp_im = load(window, b + number), load(window, b + number + LANES)
            bp_re_over, bp_im_over = times(bp_re, p_inverse), times(bp_im, p_inverse)
            q = less_product(less_product(load(window, b), bp_re, bp_re_over), bp_im, bp_im_over)
            q_inverse = one_over(q)
            cp_re, cp_im = load(window, c + 2 * number), load(window, c + 2 * number + LANES)
            cp_re_over, cp_im_over = times(cp_re, p_inverse), times(cp_im, p_inverse)
            cq_re, cq_im = load(window, c + number), load(window, c + number + LANES)
            cq_re = less_product(less_product(cq_re, cp_re, bp_re_over), cp_im, bp_im_over)
            cq_im = plus_product(less_product(cq_im, cp_im, bp_re_over), cp_re, bp_im_over)
            cq_re_over, cq_im_over = times(cq_re, q_inverse), times(cq_im, q_inverse)
            r = less_product(less_product(load(window, c), cp_re, cp_re_over), cp_im, cp_im_over)
            r = less_product(less_product(r, cq_re, cq_re_over), cq_im, cq_im_over)
            r_inverse = one_over(r)
            low = one_more_if_low(one_more_if_low(one_more_if_low(low, p), q), r)
            for i in range(ABREAST, ready - j):
                row = start[turned + i]
                at, to = row + i * number, i * ABREAST * number
                p_re, p_im = load(window, at), load(window, at + LANES)
                q_re, q_im = load(window, at - number), load(window, at - number + LANES)
                r_re, r_im = load(window, at - 2 * number), load(window, at - 2 * number + LANES)
                q_re = less_product(less_product(q_re, p_re, bp_re_over), p_im, bp_im_over)
                q_im = plus_product(less_product(q_im, p_im, bp_re_over), p_re, bp_im_over)
                r_re = less_product(less_product(r_re, p_re, cp_re_over), p_im, cp_im_over)
                r_im = plus_product(less_product(r_im, p_im, cp_re_over), p_re, cp_im_over)
                r_re = less_product(less_product(r_re, q_re, cq_re_over), q_im, cq_im_over)
                r_im = plus_product(less_product(r_im, q_im, cq_re_over), q_re, cq_im_over)
                store(scaled, to, times(p_re, p_inverse))
                store(scaled, to + LANES, times(p_im, p_inverse))
                store(scaled, to + 2 * LANES, times(q_re, q_inverse))
                store(scaled, to + 3 * LANES, times(q_im, q_inverse))
                store(scaled, to + 4 * LANES, times(r_re, r_inverse))
                store(scaled, to + 5 * LANES, times(r_im, r_inverse))
                for k in range(ABREAST, i + 1):
                    at, by = row + (i - k) * number, k * ABREAST * number
                    re, im = load(window, at), load(window, at + LANES)
                    u, v = load(scaled, by), load(scaled, by + LANES)
                    re, im = less_product(re, p_re, u), less_product(im, p_im, u)
                    re, im = less_product(re, p_im, v), plus_product(im, p_re, v)
                    u, v = load(scaled, by + 2 * LANES), load(scaled, by + 3 * LANES)
                    re, im = less_product(re, q_re, u), less_product(im, q_im, u)
                    re, im = less_product(re, q_im, v), plus_product(im, q_re, v)
                    u, v = load(scaled, by + 4 * LANES), load(scaled, by + 5 * LANES)
                    re, im = less_product(re, r_re, u), less_product(im, r_im, u)
                    re, im = less_product(re, r_im, v), plus_product(im, r_re, v)
                    store(window, at, re)
                    store(window, at + LANES, im)
            turned += ABREAST
            if turned >= width:
                turned -= width
        store(counted, 0, low)
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
        re, im, turn = spread(evens[first]), spread(0.0), 2 * LANES
        for place in range(first + size, len(evens), size):
            re = plus_product(re, load(wave, turn), spread(evens[place]))
            im = plus_product(im, load(wave, turn + LANES), spread(odds[place]))
            turn += 2 * LANES
        store(window, at, re)
        store(window, at + LANES, im)
        at += 2 * LANES


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
    for place in range(width):
        right = place - half  # of the diagonal
        count, first = size - abs(right), max(0, -right)
        own, other = band[half - right, first + right :], band[half + right, first:]
        for i in range(count):
            entry = own[i]
            if hermitian:
                entry = 0.5 * (entry + np.conj(other[i]))
            rows[first + i, place] = entry
    rows[:, half] -= centre


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def band_times(band: Numbers, vectors: Numbers) -> Numbers:
    """Products of a band, laid out as for ``write_rows``, with vectors (unknowns, k), which are complex if it is."""
    width, size = band.shape
    half, product = width // 2, np.zeros_like(vectors)
    for k in range(vectors.shape[1]):
        vector, found = vectors[:, k].copy(), np.zeros_like(vectors[:, k])
        for d in range(width):
            lower = d - half
            count = size - abs(lower)
            first, row = max(0, -lower), max(0, lower)
            entries, known = band[d, first : first + count], vector[first : first + count]
            sums = found[row : row + count]
            for j in range(count):
                sums[j] += entries[j] * known[j]
        product[:, k] = found
    return product


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def factorise_band_of_numbers(band: Numbers) -> None:
    """Factorise a band in place as L U without pivoting: entry (i, j) in ``band[i, half + j - i]``."""
    size, width = band.shape
    half = width // 2
    for k in range(size):
        inverse, reach = 1.0 / band[k, half], min(half, size - 1 - k)
        upper = band[k, half + 1 : half + 1 + reach]
        for below in range(1, reach + 1):
            row, start = k + below, half - below
            factor = band[row, start] * inverse
            band[row, start] = factor
            if factor != 0.0:
                lower = band[row, start + 1 : start + 1 + reach]
                for i in range(reach):
                    lower[i] -= factor * upper[i]


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def solve_band_of_numbers(band: Numbers, x: Numbers) -> None:
    """Solve in place with the factors of ``factorise_band_of_numbers``, (unknowns,)."""
    size, width = band.shape
    half = width // 2
    for i in range(size):
        value, reach = x[i], min(half, i)
        row, known = band[i, half - reach : half], x[i - reach : i]
        for j in range(reach):
            value -= row[j] * known[j]
        x[i] = value
    for i in range(size - 1, -1, -1):
        value, reach = x[i], min(half, size - 1 - i)
        row, known = band[i, half + 1 : half + 1 + reach], x[i + 1 : i + 1 + reach]
        for j in range(reach):
            value -= row[j] * known[j]
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
