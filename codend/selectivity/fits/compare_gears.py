"""Two gears beside each other: difference of retention curves, and usability indicators of one gear's catch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codend.selectivity.fits.bootstrap import Bootstrap
from codend.selectivity.fits.fielddata import FieldData

Array = NDArray[np.float64]
INDICATORS: Final = ("np_minus", "np_plus", "discard_ratio")


class Replicated(Protocol):
    """A curve with replicates of it: a `Bootstrap`, or draws from a fit's distribution."""

    def retention(self, length_cm: ArrayLike) -> tuple[Array, Array]:
        """Retention of the fit (n,) and of the replicates (S, n)."""

    def interval(self, estimate: Array, replicates: Array) -> tuple[Array, Array]:
        """95 % limits of any function of the replicates (S, ...)."""


@dataclass(frozen=True)
class CurveDifference:
    """Retention of a first gear minus that of a second, arrays of one length with 95 % limits.

    `lower_95, upper_95` hold at each length on its own, `lower_all_95, upper_all_95` at all lengths together: 95 % of
    the replicates lie between them from end to end.
    """

    length_cm: Array
    difference: Array
    lower_95: Array
    upper_95: Array
    lower_all_95: Array
    upper_all_95: Array

    @property
    def significant(self) -> NDArray[np.bool_]:
        """Lengths whose own interval leaves out zero; among many, one in twenty does so by chance."""
        return (self.lower_95 > 0.0) | (self.upper_95 < 0.0)

    @property
    def significant_together(self) -> NDArray[np.bool_]:
        """Lengths where the simultaneous band leaves out zero."""
        return (self.lower_all_95 > 0.0) | (self.upper_all_95 < 0.0)


def difference_curve(first: Bootstrap, second: Bootstrap, length_cm: ArrayLike) -> CurveDifference:
    """Difference r_first(L) - r_second(L) of two separate trials with bootstrap interval.

    The replicates of the trials are independent, so any pairing of them is a replicate of the difference
    (Herrmann et al. 2018, Fish. Res. 207). Bootstrap both with different seeds.
    """
    length = np.asarray(length_cm, dtype=float)
    estimate_1, replicates_1 = first.retention(length)
    estimate_2, replicates_2 = second.retention(length)
    pairs = min(len(replicates_1), len(replicates_2))
    difference = estimate_1 - estimate_2
    unreliable = first if not first.reliable else second
    differences = replicates_1[:pairs] - replicates_2[:pairs]
    lower, upper = unreliable.interval(difference, differences)
    error = differences.std(axis=0)
    farthest = (np.abs(differences - difference) / np.where(error > 0.0, error, 1.0)).max(axis=1)
    wide = np.where(np.isfinite(lower), np.percentile(farthest, 95.0) * error, np.nan)
    ends = np.fmin(difference - wide, lower), np.fmax(difference + wide, upper)
    return CurveDifference(length, difference, lower, upper, *ends)


@dataclass(frozen=True)
class Indicator:
    """A percentage with its 95 % interval."""

    percent: float
    lower_95: float
    upper_95: float


@dataclass(frozen=True)
class Usability:
    """What a gear does to a population of fish, against a reference length (Wienbeck et al. 2014, Fish. Res.).

    Attributes:
        np_minus: fish below the reference length that are retained, of those that entered (%): low is good.
        np_plus: fish of the reference length and above that are retained, of those that entered (%): high is good.
        discard_ratio: fish below the reference length, of all retained (%): low is good.
    """

    np_minus: Indicator
    np_plus: Indicator
    discard_ratio: Indicator


def usability(gear: Replicated, length_cm: ArrayLike, numbers: ArrayLike, reference_length_cm: float) -> Usability:
    """Usability indicators of a gear for a population `numbers` (n,) at `length_cm` (n,).

    The intervals carry the uncertainty of the retention curve; the population is taken as given. An indicator whose
    population is empty is NaN.
    """
    length, population = np.asarray(length_cm, dtype=float), np.asarray(numbers, dtype=float)
    small = length < reference_length_cm
    estimate, replicates = gear.retention(length)

    def indicators(retention: Array) -> Array:
        retained = retention * population
        kept_small, kept_large = retained[..., small].sum(axis=-1), retained[..., ~small].sum(axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = [
                kept_small / population[small].sum(),
                kept_large / population[~small].sum(),
                kept_small / (kept_small + kept_large),
            ]
        return 100.0 * np.stack(shares, axis=-1)

    percent = indicators(estimate)
    limits = gear.interval(percent, indicators(replicates))
    return Usability(*(Indicator(*map(float, row)) for row in np.column_stack([percent, *limits])))


def fished_population(data: FieldData) -> tuple[Array, Array]:
    """(lengths, raised numbers) that met the gear, all hauls together.

    Covered codend: codend and cover. Paired gear: the control's catch, which stands for the population as far as the
    control retains everything and fishes as hard as the test gear.
    """
    raised = data.other_count * data.other_raising
    if data.design == "covered":
        raised = raised + data.test_count * data.test_raising
    length_cm, row = np.unique(data.length_cm, return_inverse=True)
    return length_cm, np.bincount(row, weights=raised).astype(float)
