"""Bars aslant from row to row, two from a knot: diamond and T90 netting, and joints of such netting."""

import numpy as np
from numpy.typing import NDArray

from codend.netting.knots import LEFT, RIGHT, Knots
from codend.netting.lattice import Counts
from codend.netting.parts import Parts


def add_rhombs(parts: Parts, knots: Knots, own: NDArray[np.bool_]) -> None:
    """Write bars, facets, corners and meshes of a pattern's ``own`` bands, (bands,)."""
    bands = np.flatnonzero(own)
    _add_bands(parts, knots, bands)
    _add_corners(parts, knots, bands)
    _add_meshes(parts, knots, np.flatnonzero(own[:-1] & own[1:]) + 1)


def _half_mesh_away(knots: Knots, row: Counts, counted: Counts) -> tuple[Counts, Counts]:
    """Columns of the two knots of a neighbouring row that lie half a mesh to the right and to the left of a knot."""
    shift = knots.lattice.shift[row]
    return counted + shift, counted + shift - 1


def _add_bands(parts: Parts, knots: Knots, bands: Counts) -> None:
    band, here = knots.lattice.places(bands)
    right, left = _half_mesh_away(knots, band, here)
    aft_left, aft_right = knots.aft(LEFT, band, here), knots.aft(RIGHT, band, here)
    fore_left, fore_right = knots.fore(LEFT, band + 1, right), knots.fore(RIGHT, band + 1, left)
    parts.add_bars(aft_right, fore_left, band, False)
    parts.add_bars(aft_left, fore_right, band, False)
    parts.add_quadrangles(aft_left, aft_right, fore_left, fore_right, band)
    next_left, next_right = knots.aft(LEFT, band, here + 1), knots.fore(RIGHT, band + 1, right)
    parts.add_quadrangles(aft_right, next_left, next_right, fore_left, band)


def _add_corners(parts: Parts, knots: Knots, bands: Counts) -> None:
    """Corners between two twines: fore and aft of a knot that lies lengthwise, left and right of one across."""
    lattice = knots.lattice
    band, here = lattice.places(bands[~knots.across[bands]])
    right, left = _half_mesh_away(knots, band, here)
    twines = knots.fore(LEFT, band + 1, right), knots.fore(RIGHT, band + 1, left)
    parts.add_corners(knots.aft(LEFT, band, here), *twines, band, False)
    band, here = lattice.places(bands[~knots.across[bands + 1] & (bands + 1 < lattice.bands)])
    right, left = _half_mesh_away(knots, band + 1, here)
    twines = knots.aft(LEFT, band, right), knots.aft(RIGHT, band, left)
    parts.add_corners(knots.fore(LEFT, band + 1, here), *twines, band, False)
    row, knot = lattice.rings(np.flatnonzero(knots.across[1:]) + 1)
    ring, shift = lattice.knots[row], lattice.shift[row]
    last_ahead, last_behind = _last_that_share(knots, row, knot)
    twines = knots.aft(LEFT, row - 1, last_ahead + shift), knots.fore(LEFT, row + 1, last_behind + shift)
    parts.add_corners(knots.ring(RIGHT, row, knot, ring), *twines, row, True)
    first_ahead, first_behind = (last + 1 for last in _last_that_share(knots, row, knot - 1))
    twines = knots.aft(RIGHT, row - 1, first_ahead + shift - 1), knots.fore(RIGHT, row + 1, first_behind + shift - 1)
    parts.add_corners(knots.ring(LEFT, row, knot, ring), *twines, row, True)


def _last_that_share(knots: Knots, row: Counts, knot: Counts) -> tuple[Counts, Counts]:
    """Of the columns of the bands ahead and behind whose knots are laced to one of a row's ring, the last ones."""
    lattice = knots.lattice
    ahead, behind = (lattice.last_laced(row, knot, lattice.columns[row - i]) for i in (1, 0))
    return ahead, behind


def _add_meshes(parts: Parts, knots: Knots, rows: Counts) -> None:
    """Meshes whose widest part lies in a row between two such bands; those closed by the lacing have none."""
    lattice = knots.lattice
    row, knot = lattice.rings(rows)
    # the last of those that share a knot leads to the next knot of the ring
    ahead, behind = _last_that_share(knots, row, knot)
    fore_middle, aft_middle = ahead + lattice.shift[row], behind + lattice.shift[row]
    parts.add_meshes(
        [
            (knots.aft(RIGHT, row - 1, fore_middle), knots.fore(LEFT, row, ahead + 1)),
            (knots.aft(LEFT, row, behind + 1), knots.fore(RIGHT, row + 1, aft_middle)),
            (knots.fore(LEFT, row + 1, aft_middle), knots.aft(RIGHT, row, behind)),
            (knots.fore(RIGHT, row, ahead), knots.aft(LEFT, row - 1, fore_middle)),
        ],
        row,
    )
