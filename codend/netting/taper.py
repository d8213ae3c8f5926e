"""Sections that taper: how many columns of meshes every band has, and how many are lost in which rows along each seam.

An edge of a panel is cut along points N, each two rows deep, bars B, each one row deep and half a mesh in, and meshes
T, each a whole mesh in along a row. Sewn to its like, a bar on both edges makes the panel one mesh narrower: the knots
on either side of the seam become one, on the seam. A T on both edges makes it narrower by two more: the knots along
them are gathered in the seam as well, into that one (assumed: the lacing draws them together).

Where an edge loses no more than it is deep it has N and B: the rows of the B are an odd number apart, the first an odd
number from the end. Where it loses more it has a B in every row, and T between. Both are spread as evenly along the
section as that allows, as cutters do.
"""

import numpy as np

from codend.netting.lattice import Counts


def columns_along(fore: int, aft: int, rows: int, staggered: bool) -> Counts:
    """Columns of the bands of a section, from its counts at either end of one panel, (rows,).

    A section that widens is one that narrows, from behind.
    """
    if aft > fore:
        return columns_along(aft, fore, rows, staggered)[::-1]
    if aft == fore:
        return np.full(rows, fore, dtype=np.int64)
    lost = np.searchsorted(rows_of_loss(rows, fore - aft, staggered), np.arange(rows), side="right")
    return np.asarray(fore - lost, dtype=np.int64)


def rows_of_loss(rows: int, meshes: int, staggered: bool) -> Counts:
    """Rows of a section at whose seams meshes are lost, once for each, from 1 to ``rows`` from its end, (meshes,)."""
    if staggered and meshes > rows:
        bars = rows - (meshes - rows) % 2
        # each T as late as its rate allows: drawn in sooner, netting ahead would be too short; none in the last row,
        # which is that of the joint to the next section
        turns = (meshes - bars) // 2
        late = np.ceil(np.arange(1, turns + 1) * max(bars - 1, 1) / max(turns, 1)).astype(np.int64)
        return np.sort(np.concatenate([np.arange(1, bars + 1), late, late]))
    if not staggered:
        return np.ceil((np.arange(1, meshes + 1) - 0.5) * rows / max(meshes, 1)).astype(np.int64)
    even = (np.arange(1, meshes + 1) - 0.5) * rows / max(meshes, 1)
    odd = np.arange(1, meshes + 1) % 2
    return np.asarray(2 * np.rint((even - odd) / 2) + odd, dtype=np.int64)
