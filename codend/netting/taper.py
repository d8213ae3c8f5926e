"""Sections that taper: how many columns of meshes every band has, and at which rows one is lost along each seam.

An edge of a panel is cut along points N, each two rows deep, and bars B, each one row deep and half a mesh in. Sewn to
its like, a bar on both edges makes the panel one mesh narrower: the knots on either side of the seam become one, on the
seam. So the rows at which that happens are an odd number apart, the first an odd number from the end. They are spread
as evenly along the section as that allows, as cutters do.
"""

import numpy as np

from codend.netting.parts import Counts


def columns_along(fore: int, aft: int, rows: int, staggered: bool) -> Counts:
    """Columns of the bands of a section, from its counts at either end of one panel, (rows,).

    A section that widens is one that narrows, from behind.
    """
    if aft > fore:
        return columns_along(aft, fore, rows, staggered)[::-1]
    lost = np.searchsorted(rows_of_loss(rows, fore - aft, staggered), np.arange(rows), side="right")
    return np.asarray(fore - lost, dtype=np.int64)


def rows_of_loss(rows: int, meshes: int, staggered: bool) -> Counts:
    """Rows of a section at whose seams a mesh is lost, counted from its end, from 1 to ``rows``, (meshes,)."""
    number = np.arange(1, meshes + 1)
    even = (number - 0.5) * rows / max(meshes, 1)
    if not staggered:
        return np.ceil(even).astype(np.int64)
    odd = number % 2
    return np.asarray(2 * np.rint((even - odd) / 2) + odd, dtype=np.int64)
