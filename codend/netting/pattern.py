"""Netting between the knots: what the pattern of each band writes, and the knots, which all write alike."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from codend.netting.knots import LEFT, RIGHT, Knots
from codend.netting.parts import Parts
from codend.netting.patterns.rhombs import add_rhombs
from codend.netting.patterns.squares import add_squares

PATTERNS: Final[dict[str, Callable[[Parts, Knots, NDArray[np.bool_]], None]]] = {
    "rhombs": add_rhombs,
    "squares": add_squares,
}
"""Functions that write bars, facets, meshes and corners of the bands for which the last argument, (bands,), is true."""


def parts_of(knots: Knots) -> Parts:
    """Bars, facets, meshes and corners of all sections, to be changed before they are joined."""
    pattern = knots.lattice.of_bands(lambda section: section.kind.pattern)
    parts = Parts(knots.codline)
    for name, add_pattern in PATTERNS.items():
        add_pattern(parts, knots, pattern == name)
    _add_knots(parts, knots)
    return parts


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
