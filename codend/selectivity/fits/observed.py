"""The fish of each gear by length, all hauls together: what is drawn as points beside a fitted curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codend.selectivity.fits.one_stage import OneStage

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GearFish:
    """Fish of one gear at n lengths, raised; NaN where none were counted.

    Attributes:
        level: the gear.
        length_cm: (n,) lengths.
        fish: (n,) counted, not raised.
        share: (n,) of the raised fish those in the codend or test gear.
        retention: (n,) the same for a covered codend; for paired gear test over control, over the odds of the split, as
            raised numbers have it: above 1 by chance.
    """

    level: str
    length_cm: Array
    fish: Array
    share: Array
    retention: Array


def fish_of_gears(fit: OneStage) -> list[GearFish]:
    """The fish of every gear of a fit, its estimated split taken out of the retention."""
    data = fit.data
    levels = fit.hauls[fit.group].to_numpy() if fit.group else np.full(len(fit.hauls), "")
    found = []
    for level in fit.levels:
        rows = np.flatnonzero((levels == level)[data.haul])
        length, at = np.unique(data.length_cm[rows], return_inverse=True)
        test, other, fish = (
            np.bincount(at, weights=values[rows], minlength=length.size).astype(float)
            for values in (
                data.test_count * data.test_raising,
                data.other_count * data.other_raising,
                data.test_count + data.other_count,
            )
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            share = test / (test + other)
            split = fit.curve_at(fit.point(level), fit.theta)[2]
            retention = share if data.design == "covered" else test / other * (1.0 - split) / split
        found.append(GearFish(level, length, fish, share, np.where(np.isfinite(retention), retention, np.nan)))
    return found
