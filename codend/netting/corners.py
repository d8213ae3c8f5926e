"""Corners between twines, which stiff twine resists to turn in, where windows are let into netting.

Twine is clamped at its knots by two and two: those that lead aft from a node, those that lead ahead from one, or of a
knot that lies across the netting those of one side. Where a window is sewn in, two that meet at a knot may be of two
nettings. Knots at which more than two of a kind come together, and those sewn to a bar, are taken as hinges.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from codend.netting.lattice import Lattice
from codend.netting.parts import Parts
from codend.netting.windows import LetIn


def corners_beside(parts: Parts, windows: Sequence[LetIn], lattice: Lattice) -> list[NDArray]:
    """Corners of a full net whose windows are let in: those of the lattice that are left, and the windows' own."""
    bars = np.concatenate(parts.bars)
    own = [np.concatenate(window.bars) for window in windows]
    count = 1 + max(int(table[:, :2].max()) for table in (bars, *own))

    def key(one: NDArray, other: NDArray) -> NDArray:
        return np.minimum(one, other).astype(np.int64) * count + np.maximum(one, other)

    there = key(bars[:, 0], bars[:, 1])
    left = []
    for corners in parts.corners:
        whole = np.isin(key(corners[:, 0], corners[:, 1]), there) & np.isin(key(corners[:, 0], corners[:, 2]), there)
        left.append(corners[whole])
    staggered = [bars[(bars[:, 4] == 0) & lattice.staggered[bars[:, 3]]][:, [0, 1, 3]]]
    for number, (window, table) in enumerate(zip(windows, own, strict=True)):
        if window.netting.kind.staggered:
            twine = table[table[:, 4] == 0]
            piece = np.full(len(twine), lattice.bands + number)
            staggered.append(np.stack([twine[:, 0], twine[:, 1], piece], axis=1))
    twines = np.concatenate(staggered)
    across = _ends_of_knots_across(bars, own, windows, lattice, count)
    return [*left, _of_pieces(twines, lattice.bands, across, count)]


def _ends_of_knots_across(
    bars: NDArray, own: Sequence[NDArray], windows: Sequence[LetIn], lattice: Lattice, count: int
) -> NDArray[np.bool_]:
    """Whether a node is the end of a knot that lies across the netting, (nodes,)."""
    lie_across = lattice.of_bands(lambda section: section.knot_across_m > 0.0)
    across = np.zeros(count, dtype=bool)
    across[bars[(bars[:, 4] == 1) & lie_across[bars[:, 3]], :2]] = True
    for window, table in zip(windows, own, strict=True):
        if window.netting.knot_across_m > 0.0:
            across[table[table[:, 4] == 1, :2]] = True
    return across


def _of_pieces(twines: NDArray, bands: int, across: NDArray[np.bool_], count: int) -> NDArray:
    """Corners that a twine of a window is part of.

    Args:
        twines: fore and aft end, and band or number of the piece beyond all bands, (k, 3).
        bands: of the lattice.
        across: see ``_ends_of_knots_across``.
        count: nodes.
    """
    ends = [(twines[:, 0], twines[:, 1]), (twines[:, 1], twines[:, 0])]
    found = []
    # two that lead the same way from a node
    groups = [(middle, far, ~across[middle]) for middle, far in ends]
    # one either way from the end of a knot across
    middle, far = (np.concatenate(parts) for parts in zip(*ends, strict=True))
    groups.append((middle, far, across[middle]))
    for index, (nodes, fars, used) in enumerate(groups):
        numbers = np.arange(len(nodes)) % max(len(twines), 1)
        order = np.flatnonzero(used)[np.argsort(nodes[used], kind="stable")]
        at, to, which = nodes[order], fars[order], numbers[order]
        first = np.flatnonzero((np.diff(at, append=-1) == 0) & (np.bincount(at, minlength=count)[at] == 2))
        one, other = twines[which[first], 2], twines[which[first + 1], 2]
        none = np.zeros_like(one)
        table = [at[first], to[first], to[first + 1], none, none, none, one, other, none + (index == 2)]
        found.append(np.stack(table, axis=1)[np.maximum(one, other) >= bands])
    return np.concatenate(found)
