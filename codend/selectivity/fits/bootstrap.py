"""Double bootstrap of a pooled fit: hauls, then fish within hauls (Millar 1993, Fish. Bull. 91: 564-572).

Fish counted are drawn again, never raised numbers: a raising factor belongs to the row and enters the refit as an
offset, that is, after resampling. A haul drawn m times has its n counted fish drawn m times with replacement, which is
a multinomial of m n fish over its (length, gear) cells; so the replicates are new counts on the same rows, and all are
refitted together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.fit import Fit
from codend.selectivity.fits.model import SelectionModel
from codend.selectivity.fits.parameters import Estimates, parameter_names, public_parameters
from codend.selectivity.fits.scoring import maximise

Array = NDArray[np.float64]

Told = Callable[[int, int, str], None]
"""Told how many parts of a long work are done, of how many, and what is being done."""

REFITS_AT_ONCE: Final = 50  # between two words on how far they are
COUNTS_AT_ONCE: Final = 2_000_000  # bounds the memory of the drawn counts
# with more failed refits the percentiles of the others no longer describe the estimator, and none are given
MOST_FAILED: Final = 0.1


@dataclass(frozen=True)
class Bootstrap:
    """Replicates of a pooled fit.

    Attributes:
        model: of the pooled fit.
        estimates: its parameters, with the standard deviation of the replicates and 95 % percentile intervals (Efron).
        replicates: (S, m) parameters of the S refits that converged, in the order of `estimates.names`.
        n_replicates: refits tried.
        n_failed: refits that did not converge; beyond `MOST_FAILED` of all, errors and intervals are NaN.
    """

    model: SelectionModel
    estimates: Estimates
    replicates: Array
    n_replicates: int
    n_failed: int

    @property
    def reliable(self) -> bool:
        """Whether enough refits converged for intervals."""
        return self.n_failed <= MOST_FAILED * self.n_replicates

    def retention(self, length_cm: ArrayLike) -> tuple[Array, Array]:
        """Retention of the fit (n,) and of the replicates (S, n), at the mean of the covariates."""
        curve = self.model.curve
        k = len(curve.parameter_names)
        return (
            curve.retention(length_cm, self.estimates.values[:k]),
            curve.retention(length_cm, self.replicates[:, :k]),
        )

    def interval(self, estimate: Array, replicates: Array) -> tuple[Array, Array]:
        """95 % percentile limits of any function of the replicates, (S, ...); NaN where not `reliable`."""
        if not self.reliable:
            return np.full_like(estimate, np.nan), np.full_like(estimate, np.nan)
        lower, upper = np.percentile(replicates, [2.5, 97.5], axis=0)
        return lower, upper


def double_bootstrap(
    data: FieldData, fit: Fit, n_replicates: int = 1000, seed: int = 0, progress: Told | None = None
) -> Bootstrap:
    """Resample and refit a converged pooled fit of `data`; with a single haul only its fish are resampled."""
    if not fit.converged:
        raise ValueError("only a converged fit can be bootstrapped")
    rng = np.random.default_rng(seed)
    model, row = _distinct_rows(fit.model)
    merge = np.zeros((row.size, model.log_offset.size))
    merge[np.arange(row.size), row] = 1.0
    block = max(1, COUNTS_AT_ONCE // row.size)
    parts = []
    for first in range(0, n_replicates, block):
        test, other = resample(data, min(block, n_replicates - first), rng)
        for begin in range(0, len(test), REFITS_AT_ONCE):
            if progress is not None:
                progress(first + begin, n_replicates, "bootstrap")
            some = slice(begin, begin + REFITS_AT_ONCE)
            maximum = maximise(model, test[some] @ merge, other[some] @ merge)
            parts.append(public_parameters(model, maximum.theta[maximum.converged])[0])
    replicates = np.concatenate(parts)

    bare = Bootstrap(fit.model, fit.estimates, replicates, n_replicates, n_replicates - len(replicates))
    lower, upper = bare.interval(fit.estimates.values, replicates)
    errors = replicates.std(axis=0, ddof=1) if bare.reliable else np.full_like(lower, np.nan)
    return replace(bare, estimates=Estimates(parameter_names(model), fit.estimates.values, errors, lower, upper))


def resample(data: FieldData, n_replicates: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Counts of the two gears drawn again, each (n_replicates, R)."""
    n_hauls, n_rows = len(data.haul_names), data.haul.size
    times_drawn = rng.multinomial(n_hauls, np.full(n_hauls, 1.0 / n_hauls), size=n_replicates)
    test, other = np.zeros((n_replicates, n_rows)), np.zeros((n_replicates, n_rows))
    for h in range(n_hauls):
        rows = np.flatnonzero(data.haul == h)
        cells = np.concatenate([data.test_count[rows], data.other_count[rows]])
        n_fish = int(cells.sum())
        if n_fish > 0:
            drawn = rng.multinomial(n_fish * times_drawn[:, h], cells / n_fish)
            test[:, rows], other[:, rows] = drawn[:, : rows.size], drawn[:, rows.size :]
    return test, other


def _distinct_rows(model: SelectionModel) -> tuple[SelectionModel, NDArray[np.int64]]:
    """The model with equal rows (length, offset, covariates) merged, and the merged row of each row.

    Their counts add up in the likelihood, so hauls without raising and covariates are refitted at the cost of one.
    """
    keys = np.column_stack([model.columns, model.log_offset])
    distinct, row = np.unique(keys, axis=0, return_inverse=True)
    merged = replace(model, columns=np.ascontiguousarray(distinct[:, :-1]), log_offset=distinct[:, -1].copy())
    return merged, row.ravel()
