"""Bars along the netting and rings of bars across it: square mesh, and joints with other netting."""

import numpy as np
from numpy.typing import NDArray

from codend.netting.knots import LEFT, Knots
from codend.netting.parts import Parts


def add_squares(parts: Parts, knots: Knots, own: NDArray[np.bool_]) -> None:
    """Write bars, facets and meshes of a pattern's ``own`` bands, (bands,).

    A joint has the ring of a square section if no knot of it is taken up.
    """
    lattice = knots.lattice
    band, here = lattice.places(np.flatnonzero(own))
    a, b = knots.aft(LEFT, band, here), knots.aft(LEFT, band, here + 1)
    c, d = knots.fore(LEFT, band + 1, here + 1), knots.fore(LEFT, band + 1, here)
    parts.add_bars(a, d, band, False)
    rows = np.arange(1, lattice.bands)
    ahead, behind = (own[rows - i] & (lattice.columns[rows - i] == lattice.knots[rows]) for i in (1, 0))
    ringed = ahead | behind
    row, knot = lattice.rings(rows[ringed])
    ring_band = np.repeat((rows - ahead)[ringed], lattice.knots[rows[ringed]])
    first, second = (knots.ring(LEFT, row, counted, lattice.knots[row]) for counted in (knot, knot + 1))
    parts.add_bars(first, second, ring_band, False)
    parts.add_quadrangles(a, b, c, d, band)
    parts.add_meshes([(a, b), (b, c), (c, d), (d, a)], band)
