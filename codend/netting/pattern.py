"""Netting between the knots: bars, facets, meshes and corners of diamond, T90 and square netting, and of joints."""

import numpy as np

from codend.netting.knots import LEFT, RIGHT, Knots
from codend.netting.parts import Counts, Parts


def parts_of(knots: Knots) -> Parts:
    """Bars, facets, meshes and corners of all sections."""
    parts = Parts(knots.codline)
    _add_diamond_bands(parts, knots)
    _add_square_bands(parts, knots)
    _add_knots(parts, knots)
    _add_corners(parts, knots)
    _add_diamond_meshes(parts, knots)
    return parts


def _half_mesh_away(knots: Knots, row: Counts, counted: Counts) -> tuple[Counts, Counts]:
    """Columns of the two knots of a neighbouring row that lie half a mesh to the right and to the left of a knot."""
    shift = knots.lattice.shift[row]
    return counted + shift, counted + shift - 1


def _add_diamond_bands(parts: Parts, knots: Knots) -> None:
    band, here = knots.lattice.places(np.flatnonzero(~knots.lattice.square))
    right, left = _half_mesh_away(knots, band, here)
    aft_left, aft_right = knots.aft(LEFT, band, here), knots.aft(RIGHT, band, here)
    fore_left, fore_right = knots.fore(LEFT, band + 1, right), knots.fore(RIGHT, band + 1, left)
    parts.add_bars(aft_right, fore_left, band, False)
    parts.add_bars(aft_left, fore_right, band, False)
    parts.add_quadrangles(aft_left, aft_right, fore_left, fore_right, band)
    next_left, next_right = knots.aft(LEFT, band, here + 1), knots.fore(RIGHT, band + 1, right)
    parts.add_quadrangles(aft_right, next_left, next_right, fore_left, band)


def _add_square_bands(parts: Parts, knots: Knots) -> None:
    """Meridional bars and rings of bars; a joint has the ring of a square section if no knot of it is taken up."""
    lattice = knots.lattice
    band, here = lattice.places(np.flatnonzero(lattice.square))
    a, b = knots.aft(LEFT, band, here), knots.aft(LEFT, band, here + 1)
    c, d = knots.fore(LEFT, band + 1, here + 1), knots.fore(LEFT, band + 1, here)
    parts.add_bars(a, d, band, False)
    rows = np.arange(1, lattice.bands)
    ahead, behind = (lattice.square[rows - i] & (lattice.columns[rows - i] == lattice.knots[rows]) for i in (1, 0))
    ringed = ahead | behind
    row, knot = lattice.rings(rows[ringed])
    ring_band = np.repeat((rows - ahead)[ringed], lattice.knots[rows[ringed]])
    first, second = (knots.ring(LEFT, row, counted, lattice.knots[row]) for counted in (knot, knot + 1))
    parts.add_bars(first, second, ring_band, False)
    parts.add_quadrangles(a, b, c, d, band)
    parts.add_meshes([(a, b), (b, c), (c, d), (d, a)], band)


def _add_knots(parts: Parts, knots: Knots) -> None:
    """Knots as bars, and the netting between those that lie along it."""
    lattice = knots.lattice
    band, knot = lattice.places(np.flatnonzero(knots.along[1:]))
    row = band + 1
    fore, after = knots.fore(LEFT, row, knot), knots.fore(LEFT, row, knot + 1)
    aft, aft_after = (knots.ring(LEFT, row, counted, lattice.columns[band]) for counted in (knot, knot + 1))
    parts.add_bars(fore, aft, band, True)
    parts.add_quadrangles(fore, after, aft_after, aft, band)
    # the entry's knots are held at both ends and the codline's are gathered: neither is a bar
    row, knot = lattice.rings(np.flatnonzero(knots.across[1:]) + 1)
    left, right = (knots.ring(side, row, knot, lattice.knots[row]) for side in (LEFT, RIGHT))
    parts.add_bars(left, right, row - 1, True)


def _add_corners(parts: Parts, knots: Knots) -> None:
    """Corners between two twines: fore and aft of a knot that lies lengthwise, left and right of one across."""
    lattice = knots.lattice
    diamond = np.flatnonzero(~lattice.square)
    band, here = lattice.places(diamond[~knots.across[diamond]])
    right, left = _half_mesh_away(knots, band, here)
    twines = knots.fore(LEFT, band + 1, right), knots.fore(RIGHT, band + 1, left)
    parts.add_corners(knots.aft(LEFT, band, here), *twines, band, False)
    band, here = lattice.places(diamond[~knots.across[diamond + 1] & (diamond + 1 < lattice.bands)])
    right, left = _half_mesh_away(knots, band + 1, here)
    twines = knots.aft(LEFT, band, right), knots.aft(RIGHT, band, left)
    parts.add_corners(knots.fore(LEFT, band + 1, here), *twines, band, False)
    row, here = lattice.rings(np.flatnonzero(knots.across[1:]) + 1)
    right, left = _half_mesh_away(knots, row, here)
    twines = knots.aft(LEFT, row - 1, right), knots.fore(LEFT, row + 1, right)
    parts.add_corners(knots.aft(RIGHT, row, here), *twines, row, True)
    twines = knots.aft(RIGHT, row - 1, left), knots.fore(RIGHT, row + 1, left)
    parts.add_corners(knots.aft(LEFT, row, here), *twines, row, True)


def _add_diamond_meshes(parts: Parts, knots: Knots) -> None:
    """Meshes whose widest part lies in a row between two bands of diamonds; those closed by the lacing have none."""
    lattice = knots.lattice
    rows = np.arange(1, lattice.bands)
    row, knot = lattice.rings(rows[~lattice.square[rows - 1] & ~lattice.square[rows]])
    # of the knots of either band that share one, the last one leads to the next knot of the ring
    ahead, behind = (-(-(knot + 1) * lattice.columns[row - i] // lattice.knots[row]) - 1 for i in (1, 0))
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
