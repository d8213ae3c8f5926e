"""What each number of a species does to the L50 and SR of a haul, over the ranges the species file gives.

Two answers. One at a time: L50 and SR with a number at the low and at the high end of its range, all others as given.
Ranking by variance: with all numbers drawn uniformly and independently from their ranges, a number's first-order Sobol
index is the share of the variance it makes alone, its total index the share that would be left if all others were
known (Saltelli et al. 2010, Comput. Phys. Commun. 181: 259-270, as in ``scipy.stats.sobol_indices``).

Numbers without a range are held fixed. The ranges are as much an assumption as the numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_models.fish import PARAMETERS, Species
from codend.selectivity.escape.haul import MOST_CATCHES, Haul, many_hauls, trying_of
from codend.selectivity.escape.retention import nodes_of

Floats = NDArray[np.float64]

SAMPLES: Final = 128
"""Of the Sobol design; a power of 2. (number of ranges + 2) times as many hauls are computed."""
COARSE: Final = nodes_of(shapes=3, rotations=8, steps=8, openings=45)
BAND: Final = (2.5, 97.5)
"""Percentiles of the retention that the ranges allow."""


@dataclass(frozen=True)
class Sensitivity:
    """Effect of p numbers with a range; L50 and SR in cm along the last axis."""

    parameters: tuple[str, ...]
    ranges: Floats
    """(p, 2)."""
    base: Floats
    """L50 and SR with all numbers as given, (2,): by fewer catches and nodes than the prediction's own."""
    one_at_a_time: Floats
    """L50 and SR at the low and at the high end, by the same, (p, 2, 2)."""
    first_order: Floats
    """Sobol indices, (p, 2); nan where L50 or SR does not vary, or does not exist over all of the ranges."""
    total: Floats
    """(p, 2)."""
    band: Floats
    """Percentiles ``BAND`` of the retention by length when all numbers vary, (2, n)."""


def sensitivity(haul: Haul, species: Species, samples: int = SAMPLES, seed: int = 0) -> Sensitivity | None:
    """One-at-a-time effects and Sobol indices of every number with a range; None where there is none.

    Args:
        haul: computed at the numbers' own values; at most 6 of its catches are used.
        species: the numbers and their ranges.
        samples: of the Sobol design, a power of 2.
        seed: of its scrambling.
    """
    from scipy.stats import qmc, sobol_indices

    ranges = {name: limits for name, limits in species.ranges.items() if limits[0] < limits[1]}
    if not ranges:
        return None
    haul, count = haul.thinned(MOST_CATCHES), len(ranges)
    column = [PARAMETERS.index(name) for name in ranges]
    low, high = np.array(list(ranges.values())).T

    single = np.tile(species.values, (count, 2, 1))
    for i, at in enumerate(column):
        single[i, :, at] = low[i], high[i]
    drawn = qmc.Sobol(2 * count, rng=np.random.default_rng(seed)).random(samples)
    a, b = low + (high - low) * drawn[:, :count], low + (high - low) * drawn[:, count:]
    mixed = np.repeat(a[None], count, axis=0)
    for i in range(count):
        mixed[i, :, i] = b[:, i]
    design = np.tile(species.values, ((2 + count) * samples, 1))
    design[:, column] = np.concatenate([a, b, mixed.reshape(-1, count)])

    singles = np.vstack([species.values, single.reshape(-1, len(PARAMETERS))])
    trying = trying_of(haul, species)
    ends, _ = many_hauls(haul, singles, COARSE, np.empty(0), trying)
    of_a, retained = many_hauls(haul, design[:samples], COARSE, species.length_cm, trying)
    of_others, _ = many_hauls(haul, design[samples:], COARSE, np.empty(0), trying)
    found = np.concatenate([of_a, of_others])
    first_order, total = np.full((2, count, 2), np.nan)
    for quantity in range(2):
        f = found[:, quantity]
        if not np.isfinite(f).all() or np.ptp(f) == 0.0:
            continue
        if count == 1:  # makes all of the variance; scipy takes two numbers or more
            first_order[:, quantity] = total[:, quantity] = 1.0
        else:
            indices = sobol_indices(
                func={
                    "f_A": f[None, :samples],
                    "f_B": f[None, samples : 2 * samples],
                    "f_AB": f[2 * samples :].reshape(count, 1, samples),
                },
                n=samples,
            )
            first_order[:, quantity], total[:, quantity] = indices.first_order.ravel(), indices.total_order.ravel()
    return Sensitivity(
        parameters=tuple(ranges),
        ranges=np.stack([low, high], axis=1),
        base=ends[0],
        one_at_a_time=ends[1:].reshape(count, 2, 2),
        first_order=first_order,
        total=total,
        band=np.percentile(retained, BAND, axis=0),
    )
