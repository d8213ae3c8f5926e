"""Meshes merged into fewer, larger ones by numbers that need not divide the plan's counts.

A codend of 58 meshes round and 31 long with two ropes has a sector 29 meshes wide between them. Of 2.42 meshes merged
into one each way it is 12 wide and 13 long: as wide and as long as it was, for the last row stands for what the others
leave over. Ropes, and what hangs between them, stay as they are.
"""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from codend.plan.plan import Plan
from codend.plan.tables import Netting

LEAST_ROUND = 24
"""Merged meshes round that are left between ropes: with 12, 16 and 24 drag of twelve T90 plans was off by 1.8, 1.1 and
0.4 % (medians), openings by 0.2, 0.1 and 0.1 degrees."""


def rows_merged(sections: Iterable[Netting], bands: int, globalisation: float) -> NDArray[np.float64]:
    """Real rows that each of the bands of some sections stands for, (bands,)."""
    rows = np.full(bands, float(globalisation))
    rows[-1] = sum(part.rows_per_mesh * part.meshes_long for part in sections) - rows[:-1].sum()
    return rows


def between_ropes(plan: Plan) -> float | None:
    """Meshes that may be merged each way in a sector that has ropes as they are; 1 where it is that narrow already.

    None where rows are told by number (joints, straps, ends of ropes) or meshes have places of their own (windows,
    seams, tapers, layers), and no divisor of all these counts leaves ``LEAST_ROUND`` meshes round.
    """
    placed = plan.window or plan.layer or plan.tapers or any(part.has_seams for part in plan.netting)
    if placed or not plan.rope:
        return None
    counts = [count for part in plan.netting for count in part.open_meshes]
    order = math.gcd(*counts, *(rope.number for rope in plan.rope))
    wide = -(-LEAST_ROUND // order)
    if min(counts) <= wide * order:
        return 1
    if len(plan.netting) == 1 and not (plan.strap_rows or plan.rope_rows):
        return counts[0] / (wide * order)
    alike = (g for g in plan.globalisations if all(count % (g * order) == 0 for count in counts))
    return max((g for g in alike if 1 < g <= min(counts) / LEAST_ROUND), default=None)
