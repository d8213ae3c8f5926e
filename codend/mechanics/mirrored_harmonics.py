"""Harmonics of a sector that is its own mirror image, in real numbers: kernels.

A reflection in a plane through the axis takes harmonic k into -k, and complex conjugation takes that back: K_k of a net
that is its own image commutes with both together, and is real in unknowns that both leave as they are. Let a node's
moves w be seen in axes turned to the azimuth alpha of the plane halfway between it and its image, and times
exp(i k alpha). The image's are M conj(w) then, M = diag(1, 1, -1): of a node on the plane, whose image it is itself,
w = (x, r, i t) with x, r and t real; of two that are images of each other w = (p + i q) / sqrt(2) and its image, with p
and q real. Between nodes that lie d of azimuth apart entries weigh cos k d or sin k d.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.harmonics import ABREAST, Complex
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


@njit(cache=True, error_model="numpy")
def mirrored_blocks(
    blocks: Floats, member: Ints, source: Ints, turn: Floats, image: Ints, turned: Floats, mean: Floats
) -> tuple[float, float, float]:
    """Turn blocks into the axes of their nodes' planes, and take the mean of each and of its mirror image.

    Args:
        blocks: as they were assembled, (b, 3, 3).
        member: where those that are asked go among the turned ones, in which some are added up, (c,).
        source: which they are, (c,).
        turn: cosine and sine of the turns of its row's axes and of its column's, (c, 4).
        image: that of each of the turned ones, (t,).
        turned: room, (t, 3, 3).
        mean: is written, (t, 3, 3).

    Returns:
        the sum of the sizes of all entries, the largest, and how far an entry is from its image's at most.
    """
    turned[:] = 0.0
    for number in range(len(member)):
        block, into = source[number], member[number]
        c, s, e, t = turn[number, 0], turn[number, 1], turn[number, 2], turn[number, 3]
        for i in range(3):
            x, y, z = blocks[block, i, 0], blocks[block, i, 1], blocks[block, i, 2]
            if i > 0:
                by, other = (s, 2) if i == 1 else (-s, 1)
                x = c * x + by * blocks[block, other, 0]
                y = c * y + by * blocks[block, other, 1]
                z = c * z + by * blocks[block, other, 2]
            turned[into, i, 0] += x
            turned[into, i, 1] += e * y + t * z
            turned[into, i, 2] += e * z - t * y
    total, largest, off = 0.0, 0.0, 0.0
    for number in range(len(image)):
        if image[number] < number:
            continue
        other = image[number]
        for i in range(3):
            for j in range(3):
                sign = 1.0 if (i == 2) == (j == 2) else -1.0
                here, there = turned[number, i, j], sign * turned[other, i, j]
                mean[number, i, j] = 0.5 * (here + there)
                mean[other, i, j] = 0.5 * sign * (here + there)
                total += abs(here) + abs(there)
                largest = max(largest, abs(here))
                off = max(off, abs(here - there))
    return total, largest, off


@njit(cache=True, error_model="numpy")
def terms_of_blocks(
    asked: Ints, row: Ints, column: Ints, apart: Ints, factor: Floats, unknown: Ints, weight: Complex
) -> tuple[Ints, Ints, Ints, Ints, Floats]:
    """What the entries of the tangent are made up of: entries of blocks, each times a weight and a wave.

    Args:
        asked: blocks, (k,).
        row: node of each of them, (k,).
        column: likewise.
        apart: azimuth from row to column, in halves of a sector, (k,).
        factor: of a block's weights, (k,).
        unknown: those that a component of a node's moves is the sum of, -1 for none, (n, 3, 2).
        weight: times which weight, real or imaginary, (n, 3, 2).

    Returns:
        row and column of the entry, 9 times the block and the entry's place in it, the wave, 0 for none and then cosine
        and sine in turns, and the weight, (terms,).
    """
    places, weights, count = np.empty((4, 36 * len(asked)), dtype=np.int32), np.empty(36 * len(asked)), 0
    for number in range(len(asked)):
        halves = apart[number]
        for place in range(36):
            i, a, j, b = place // 12, place // 6 % 2, place // 2 % 3, place % 2
            into, of = unknown[row[number], i, a], unknown[column[number], j, b]
            product = np.conj(weight[row[number], i, a]) * weight[column[number], j, b]
            by_sine = product.imag != 0.0
            value = -product.imag * np.sign(halves) if by_sine else product.real
            if into < 0 or of < 0 or value == 0.0:
                continue
            places[0, count], places[1, count], places[2, count] = into, of, 9 * asked[number] + 3 * i + j
            places[3, count] = 0 if halves == 0 else 2 * abs(halves) - (0 if by_sine else 1)
            weights[count] = factor[number] * value
            count += 1
    return places[0, :count], places[1, :count], places[2, :count], places[3, :count], weights[:count]


@njit(cache=True, error_model="numpy")
def symmetric_parts(mean: Floats, turned: Ints, symmetric: Floats) -> None:
    """Write the symmetric parts of blocks, (t, 3, 3): ``turned`` is that from column to row, -1 of those not asked."""
    for block in range(len(turned)):
        other = turned[block]
        if other >= 0:
            for i in range(3):
                for j in range(3):
                    symmetric[block, i, j] = 0.5 * (mean[block, i, j] + mean[other, j, i])


@njit(cache=True, error_model="numpy")
def add_up_terms(blocks: Floats, source: Ints, place: Ints, weight: Floats, value: Floats) -> None:
    """Add entries of blocks, (t, 3, 3), each times its weight, at their places among some values, (values,)."""
    entries = blocks.reshape(-1)
    for number in range(len(source)):
        value[place[number]] += weight[number] * entries[source[number]]


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def negative_pivots_of_real(
    value: Floats,
    wave: Ints,
    more: Ints,
    into: Ints,
    depth: Ints,
    waves: Floats,
    shift: Floats,
    tail: Floats,
    kind: Ints,
    negative: Ints,
) -> None:
    """Count the negative pivots of the symmetric parts of some harmonics, as ``negative_pivots_side_by_side`` does.

    Three rows are worked on at a time: what is read of those before them serves all three.

    Args:
        value: of the entries of the lower triangle, row by row and each row from its diagonal on, a term each; behind
            them further terms, row by row, (k,).
        wave: where among a harmonic's waves, in lanes, each finds that which it goes with, (k,).
        more: where the further terms of a row begin, (rows with entries + 1,).
        into: how far from its row's diagonal each of these is added, in lanes, (further terms,).
        depth: how many columns before its diagonal a row starts, (rows,): each three rows at the same column.
        waves: of each harmonic, (harmonics, waves).
        shift: added to the diagonal, (harmonics,).
        tail: the rows behind those of which there are entries, (kinds, rows behind, width).
        kind: which kind of them a harmonic has, (harmonics,).
        negative: the counts are written, (harmonics,).
    """
    rows, count, width, behind = len(depth), len(shift), tail.shape[2], tail.shape[1]
    window, scaled = aligned(width * width * LANES), aligned(width * ABREAST * LANES)
    slot = np.arange(2 * width) % width * width * LANES
    lanes, own, counted = aligned(waves.shape[1] * LANES), aligned(LANES), aligned(LANES)
    for first in range(0, count, LANES):
        used = min(LANES, count - first)
        # lanes to spare hold ones
        lanes[:], window[:], own[:] = 1.0, 1.0, 0.0
        for lane in range(used):
            own[lane] = shift[first + lane]
            for number in range(waves.shape[1]):
                lanes[number * LANES + lane] = waves[first + lane, number]
        shifted, low, ready, turned, entry = load(own, 0), spread(0.0), 0, 0, 0
        for j in range(0, rows, ABREAST):
            while ready < rows and ready - depth[ready] <= j:
                at = slot[turned + ready - j]
                if ready < rows - behind:
                    for d in range(depth[ready] + 1):
                        store(window, at + d * LANES, times(load(lanes, wave[entry]), spread(value[entry])))
                        entry += 1
                    for term in range(more[ready], more[ready + 1]):
                        to = at + into[term - more[0]]
                        found = plus_product(load(window, to), load(lanes, wave[term]), spread(value[term]))
                        store(window, to, found)
                else:
                    for d in range(depth[ready] + 1):
                        for lane in range(used):
                            window[at + d * LANES + lane] = tail[kind[first + lane], ready - rows + behind, d]
                store(window, at, plus_product(load(window, at), shifted, spread(1.0)))
                ready += 1
            a, b, c = slot[turned], slot[turned + 1], slot[turned + 2]
            p, bp, cp = load(window, a), load(window, b + LANES), load(window, c + 2 * LANES)
            p_inverse = one_over(p)
            bp_over, cp_over = times(bp, p_inverse), times(cp, p_inverse)
            q, cq = less_product(load(window, b), bp, bp_over), less_product(load(window, c + LANES), cp, bp_over)
            q_inverse = one_over(q)
            cq_over = times(cq, q_inverse)
            r = less_product(less_product(load(window, c), cp, cp_over), cq, cq_over)
            r_inverse = one_over(r)
            low = one_more_if_low(one_more_if_low(one_more_if_low(low, p), q), r)
            for i in range(ABREAST, ready - j, ABREAST):
                u, v, w = slot[turned + i] + i * LANES, slot[turned + i + 1], slot[turned + i + 2]
                v, w = v + (i + 1) * LANES, w + (i + 2) * LANES
                pu, pv, pw = load(window, u), load(window, v), load(window, w)
                qu = less_product(load(window, u - LANES), pu, bp_over)
                qv = less_product(load(window, v - LANES), pv, bp_over)
                qw = less_product(load(window, w - LANES), pw, bp_over)
                ru = less_product(less_product(load(window, u - 2 * LANES), pu, cp_over), qu, cq_over)
                rv = less_product(less_product(load(window, v - 2 * LANES), pv, cp_over), qv, cq_over)
                rw = less_product(less_product(load(window, w - 2 * LANES), pw, cp_over), qw, cq_over)
                for k in range(ABREAST, i):
                    by = k * ABREAST * LANES
                    p_by, q_by, r_by = load(scaled, by), load(scaled, by + LANES), load(scaled, by + 2 * LANES)
                    at, under, last = u - k * LANES, v - k * LANES, w - k * LANES
                    store(window, at, less_three(load(window, at), pu, p_by, qu, q_by, ru, r_by))
                    store(window, under, less_three(load(window, under), pv, p_by, qv, q_by, rv, r_by))
                    store(window, last, less_three(load(window, last), pw, p_by, qw, q_by, rw, r_by))
                to, at, under, last = i * ABREAST * LANES, u - i * LANES, v - i * LANES, w - i * LANES
                pu_by, qu_by, ru_by = times(pu, p_inverse), times(qu, q_inverse), times(ru, r_inverse)
                pv_by, qv_by, rv_by = times(pv, p_inverse), times(qv, q_inverse), times(rv, r_inverse)
                pw_by, qw_by, rw_by = times(pw, p_inverse), times(qw, q_inverse), times(rw, r_inverse)
                store(window, at, less_three(load(window, at), pu, pu_by, qu, qu_by, ru, ru_by))
                store(window, under, less_three(load(window, under), pv, pu_by, qv, qu_by, rv, ru_by))
                store(window, last, less_three(load(window, last), pw, pu_by, qw, qu_by, rw, ru_by))
                under, last = under - LANES, last - LANES
                store(window, under, less_three(load(window, under), pv, pv_by, qv, qv_by, rv, rv_by))
                store(window, last, less_three(load(window, last), pw, pv_by, qw, qv_by, rw, rv_by))
                last -= LANES
                store(window, last, less_three(load(window, last), pw, pw_by, qw, qw_by, rw, rw_by))
                if i + ABREAST < ready - j:  # for the rows behind them
                    store(scaled, to, pu_by)
                    store(scaled, to + LANES, qu_by)
                    store(scaled, to + 2 * LANES, ru_by)
                    store(scaled, to + 3 * LANES, pv_by)
                    store(scaled, to + 4 * LANES, qv_by)
                    store(scaled, to + 5 * LANES, rv_by)
                    store(scaled, to + 6 * LANES, pw_by)
                    store(scaled, to + 7 * LANES, qw_by)
                    store(scaled, to + 8 * LANES, rw_by)
            turned += ABREAST
            if turned >= width:
                turned -= width
        store(counted, 0, low)
        for lane in range(used):
            negative[first + lane] = int(counted[lane])


@njit(cache=True, error_model="numpy", inline="always")
def less_three(number, p, p_by, q, q_by, r, r_by):  # type: ignore[no-untyped-def]
    """A vector less three products."""
    return less_product(less_product(less_product(number, p, p_by), q, q_by), r, r_by)
