"""Compiled code of the sparse L D L^T of a symmetric matrix whose pattern stays: found once, filled in again and again.

Row by row (the up-looking method: Davis 2006, Direct Methods for Sparse Linear Systems, section 4.7): row k of L solves
a triangular system with the rows before it, which are wanted only where the row is not zero.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.net.net import Floats, Ints


class Factors(NamedTuple):
    """Pattern and entries of L, without its diagonal of ones, and D; unknowns in the order of elimination."""

    row_start: Ints
    """Where the entries of each row of L begin, (size + 1,)."""
    row_column: Ints
    """Columns of the entries row by row, rising, (entries,)."""
    row_place: Ints
    """Where those entries stand column by column, (entries,)."""
    start: Ints
    """Where the entries of each column of L begin, (size + 1,)."""
    row: Ints
    """Rows of the entries column by column, rising, (entries,)."""
    lower: Floats
    """Entries of L column by column, (entries,)."""
    pivots: Floats
    """D, (size,)."""
    room: Floats
    """Zeros to work in, (size,)."""


@njit(cache=True)
def rows_of_factor(start: Ints, column: Ints) -> tuple[Ints, Ints]:
    """Pattern of L by rows, of a symmetric matrix of which each row has its entries left of the diagonal.

    Args:
        start: where the entries of each row of the matrix begin, (size + 1,).
        column: of each entry, below its row's number.

    Returns:
        where each row of L begins (size + 1,), and the columns of its entries, rising in each row.
    """
    size = len(start) - 1
    parent = np.full(size, -1, dtype=np.int32)
    ancestor = np.full(size, -1, dtype=np.int32)
    for k in range(size):
        for entry in range(start[k], start[k + 1]):
            i = column[entry]
            while i != -1 and i < k:
                after = ancestor[i]
                ancestor[i] = k
                if after == -1:
                    parent[i] = k
                i = after
    seen = np.full(size, -1, dtype=np.int32)
    row_start = np.zeros(size + 1, dtype=np.int32)
    for counted in range(2):
        if counted == 1:
            columns = np.empty(row_start[size], dtype=np.int32)
            seen[:] = -1
        filled = 0
        for k in range(size):
            seen[k] = k
            first = filled
            for entry in range(start[k], start[k + 1]):
                i = column[entry]
                while seen[i] != k:
                    seen[i] = k
                    if counted == 1:
                        columns[filled] = i
                    filled += 1
                    i = parent[i]
            if counted == 1:
                columns[first:filled].sort()
            else:
                row_start[k + 1] = filled
    return row_start, columns


@njit(cache=True, error_model="numpy")
def factorise_rows(entries: Floats, start: Ints, column: Ints, place: Ints, diagonal: Ints, factors: Factors) -> int:
    """Fill in L and D; number of negative pivots, -1 if one is zero or no number.

    Args:
        entries: of the whole matrix, in any order.
        start: where the entries left of the diagonal of each row begin, (size + 1,).
        column: of these.
        place: of these among ``entries``.
        diagonal: place of the diagonal of each row, (size,).
        factors: what is filled in.
    """
    row_start, row_column, row_place, begin, row, lower, pivots, x = factors
    negative = 0
    for k in range(len(diagonal)):
        for entry in range(start[k], start[k + 1]):
            x[column[entry]] = entries[place[entry]]
        pivot = entries[diagonal[k]]
        for entry in range(row_start[k], row_start[k + 1]):
            j, here = row_column[entry], row_place[entry]
            value = x[j]
            x[j] = 0.0
            if value == 0.0:
                lower[here] = 0.0
                continue
            for p in range(begin[j], here):
                x[row[p]] -= lower[p] * value
            share = value / pivots[j]
            lower[here] = share
            pivot -= share * value
        if pivot == 0.0 or not np.isfinite(pivot):
            x[:], pivots[:] = 0.0, 0.0
            return -1
        negative += pivot < 0.0
        pivots[k] = pivot
    return negative


@njit(cache=True, error_model="numpy")
def solve_rows(factors: Factors, x: Floats) -> None:
    """Replace a right side, (size,), by the solution."""
    start, row, lower, pivots = factors.start, factors.row, factors.lower, factors.pivots
    for j in range(len(x)):
        value = x[j]
        if value != 0.0:
            for p in range(start[j], start[j + 1]):
                x[row[p]] -= lower[p] * value
    for j in range(len(x) - 1, -1, -1):
        value = x[j] / pivots[j]
        for p in range(start[j], start[j + 1]):
            value -= lower[p] * x[row[p]]
        x[j] = value
