"""Where the entries of a sparse matrix go: kernels."""

import numpy as np

from codend.compiled import njit
from codend.net.net import Ints


@njit(cache=True)
def columns_in_order(row: Ints, column: Ints, size: int) -> tuple[Ints, Ints, Ints]:
    """Where the entries of a square matrix go in compressed columns, the rows in each in order.

    Sorted by counting, by rows first.

    Args:
        row: of every entry, each place named once, -1 for entries that are none of the matrix, (k,).
        column: of every entry, likewise, (k,).
        size: rows and columns of the matrix.

    Returns:
        the entries' numbers column by column, their rows, and where each column starts (size + 1,).
    """
    row_end, starts = np.zeros(size + 1, dtype=np.int32), np.zeros(size + 1, dtype=np.int32)
    for entry in range(len(row)):
        if row[entry] >= 0 and column[entry] >= 0:
            row_end[row[entry] + 1] += 1
            starts[column[entry] + 1] += 1
    row_end, starts = np.cumsum(row_end).astype(np.int32), np.cumsum(starts).astype(np.int32)
    by_row = np.empty(row_end[size], dtype=np.int32)
    for entry in range(len(row)):
        if row[entry] >= 0 and column[entry] >= 0:
            by_row[row_end[row[entry]]] = entry
            row_end[row[entry]] += 1
    end, order, rows = starts.copy(), np.empty_like(by_row), np.empty_like(by_row)
    for entry in by_row:
        place = end[column[entry]]
        order[place], rows[place] = entry, row[entry]
        end[column[entry]] += 1
    return order, rows, starts
