"""Fish counted and fish raised: what is said of a table that has raising factors, or that looks as if it needed them.

A curve is fitted to the fish that were counted, n of them, each of which stands for as many as its factor says: the
factors are offsets, so that the curve is that of the raised numbers and its errors are those of n fish. Fitted to
raised totals as if these were counted, every fish speaks as often as its factor: the errors come out too small by about
its root, and L50 leans towards the hauls and gears of which least was counted.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHANCE: Final = 1e-4
"""Of counts that are all multiples of a number by accident, below which they are taken for raised ones."""
WHY: Final = (
    "Raised totals taken for counts give errors too small by about the root of the factor, and an L50 that leans "
    "towards what was sampled least"
)


def raising_notes(names: tuple[str, str], counts: tuple[Array, Array], factors: tuple[Array, Array]) -> list[str]:
    """What must be said of the counts (R,) of the two gears of a design and of their raising factors, (R,).

    Args:
        names: of the two columns of counts.
        counts: in those columns.
        factors: of these, 1 where there are none.
    """
    said = []
    raised = [(name, n, f) for name, n, f in zip(names, counts, factors, strict=True) if (f[n > 0.0] > 1.0).any()]
    for name, count, factor in raised:
        fished = count > 0.0
        least, most = factor[fished].min(), factor[fished].max()
        span = f"{least:g}" if least == most else f"{least:g} to {most:g}"
        said.append(
            f"{name}: {count.sum():,.0f} fish counted stand for {(count * factor).sum():,.0f}, raised by {span}. The "
            "curve is that of the raised numbers, its errors are those of the fish counted."
        )
    for name, count, factor in zip(names, counts, factors, strict=True):
        for multiple, text in _suspected(count, factor):
            said.append(f"{name}: all counts are multiples of {multiple}. {text} {WHY}.")
    return said


def _suspected(count: Array, factor: Array) -> Iterator[tuple[str, str]]:
    """What counts are all multiples of, by more than chance, and what that suggests."""
    whole = (count > 0.0) & (factor > 1.0) & (factor == np.round(factor))
    if whole.any() and (count[whole] % factor[whole] == 0.0).all() and np.log(factor[whole]).sum() > -np.log(CHANCE):
        yield "their raising factor", "Are they raised already? Then they are raised twice: give the fish counted."
    plain = count[(count > 0.0) & (factor == 1.0)]
    common = int(np.gcd.reduce(plain.astype(np.int64))) if np.unique(plain).size > 1 else 1
    if common > 1 and (plain.size - 1) * np.log(common) > -np.log(CHANCE):
        yield str(common), "Are they raised totals? Then give the fish counted, and the factor in a column _raising."
