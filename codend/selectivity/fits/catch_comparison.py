"""Catch comparison and catch ratio of two gears that both select: no curve, no split, only which gear catches what.

The share of the fish of length L in the test gear, cc(L) = test / (test + control) of raised numbers, is modelled by

    logit cc(L) = v0 + v1 x + ... + v4 x^4,  x the length scaled to -1 .. 1,

averaged by Akaike weights over all models that leave out some of the v (at least one stays), of those within 10 of the
least AIC (Herrmann et al. 2017, Fish. Res. 185: 153-160). The catch ratio is cr = cc / (1 - cc): 1 where both gears
catch alike, given equal effort. Bands are of the double bootstrap of `codend.selectivity.fits.bootstrap`, the models
weighted anew in each replicate. Raising factors are offsets.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, expit, log_expit, logit, xlogy

from codend.errors import OPTIONS, InputError
from codend.selectivity.fits.bootstrap import COUNTS_AT_ONCE, REFITS_AT_ONCE, Told, resample
from codend.selectivity.fits.fielddata import FieldData, read_field_data
from codend.selectivity.fits.haul_table import AS_IT_STANDS, HaulReading

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

HIGHEST_ORDER: Final = 4
WITHIN_AIC: Final = 10.0
STEPS: Final = 25
GRADIENT_TOLERANCE: Final = 1e-6
LARGEST_LOGIT: Final = 15.0
"""Where one gear has all the fish the polynomial has no limit; its logit is held here."""


@dataclass(frozen=True)
class CatchComparison:
    """Shares over lengths with 95 % limits, arrays of one length.

    Attributes:
        data: the counted fish.
        length_cm: lengths.
        share: averaged cc.
        lower_95, upper_95: percentiles of the bootstrap, each length on its own; NaN without a bootstrap.
        lower_all_95, upper_all_95: simultaneous: 95 % of the replicates lie between them at every length.
        orders: the powers of x in the model of least AIC.
        weights: Akaike weight of each model, by its powers.
        deviance, degrees_of_freedom, p_value: lack of fit of the model of least AIC to lengths pooled over hauls.
        n_replicates: of the bootstrap.
    """

    data: FieldData
    length_cm: Array
    share: Array
    lower_95: Array
    upper_95: Array
    lower_all_95: Array
    upper_all_95: Array
    orders: tuple[int, ...]
    weights: dict[tuple[int, ...], float]
    deviance: float
    degrees_of_freedom: int
    p_value: float
    n_replicates: int

    def table(self) -> pd.DataFrame:
        """`compare.csv`: `length_cm`, `share` and its limits, `share_lower_95` and so on, `ratio` and its limits."""
        import pandas as pd

        columns = {"length_cm": self.length_cm}
        for name, back in (("share", lambda share: share), ("ratio", lambda share: share / (1.0 - share))):
            columns[name] = back(self.share)
            for limit in ("lower_95", "upper_95", "lower_all_95", "upper_all_95"):
                columns[f"{name}_{limit}"] = back(getattr(self, limit))
        return pd.DataFrame(columns)


def compare_catches(
    data: str | Path | pd.DataFrame | FieldData,
    n_bootstrap: int = 1000,
    seed: int = 0,
    reading: HaulReading = AS_IT_STANDS,
    progress: Told | None = None,
) -> CatchComparison:
    """Catch comparison of a paired trial, `test` against `control`, over the lengths at which fish were counted.

    Args:
        data: CSV file or DataFrame as described in `read_field_data`, or what that read.
        n_bootstrap: replicates; 0 for no bands.
        seed: of the bootstrap.
        reading: as in `fit_field_data`.
        progress: likewise.

    Raises:
        InputError: bad data, or fish of fewer than three lengths, or in one gear only.
    """
    field = data if isinstance(data, FieldData) else read_field_data(data, "paired", reading=reading)
    if n_bootstrap < 0:
        raise InputError(OPTIONS, "n_bootstrap", n_bootstrap, "0 or more")
    test, other = field.test_count, field.other_count
    lengths = np.unique(field.length_cm[test + other > 0.0])
    if lengths.size < 3 or test.sum() == 0.0 or other.sum() == 0.0:
        raise InputError(
            field.source, "length_cm", None, "fish of three or more lengths, some in each gear", "are too few"
        )
    keys, row = np.unique(np.column_stack([field.length_cm, field.log_offset]), axis=0, return_inverse=True)
    merge = np.zeros((field.haul.size, len(keys)))
    merge[np.arange(field.haul.size), row.ravel()] = 1.0
    centre, half = 0.5 * (lengths[0] + lengths[-1]), 0.5 * (lengths[-1] - lengths[0])
    powers = np.arange(min(HIGHEST_ORDER, lengths.size - 2) + 1)
    at_rows, at_lengths = (((values - centre) / half)[:, None] ** powers for values in (keys[:, 0], lengths))
    offset = keys[:, 1]

    shares, weights, likelihoods = _averaged(at_rows, offset, (test @ merge)[None], (other @ merge)[None], at_lengths)
    best = max(weights, key=lambda orders: float(weights[orders][0]))
    pooled_test, pooled_n = test @ merge, (test + other) @ merge
    saturated = xlogy(pooled_test, pooled_test / np.where(pooled_n > 0, pooled_n, 1.0))
    saturated += xlogy(pooled_n - pooled_test, 1.0 - pooled_test / np.where(pooled_n > 0, pooled_n, 1.0))
    deviance = 2.0 * (float(saturated.sum()) - float(likelihoods[best][0]))
    degrees = int((pooled_n > 0.0).sum()) - len(best)
    nothing = np.full(lengths.size, np.nan)
    lower, upper, lower_all, upper_all = nothing, nothing, nothing, nothing
    if n_bootstrap:
        rng, parts = np.random.default_rng(seed), []
        block = max(1, COUNTS_AT_ONCE // (8 * field.haul.size))
        for first in range(0, n_bootstrap, block):
            drawn_test, drawn_other = resample(field, min(block, n_bootstrap - first), rng)
            for begin in range(0, len(drawn_test), REFITS_AT_ONCE):
                if progress is not None:
                    progress(first + begin, n_bootstrap, "bootstrap")
                some = slice(begin, begin + REFITS_AT_ONCE)
                drawn = drawn_test[some] @ merge, drawn_other[some] @ merge
                parts.append(_averaged(at_rows, offset, *drawn, at_lengths)[0])
        lower, upper, lower_all, upper_all = _limits(shares[0], np.concatenate(parts))
    return CatchComparison(
        data=field,
        length_cm=lengths,
        share=shares[0],
        lower_95=lower,
        upper_95=upper,
        lower_all_95=lower_all,
        upper_all_95=upper_all,
        orders=best,
        weights={orders: float(weight[0]) for orders, weight in weights.items()},
        deviance=deviance,
        degrees_of_freedom=degrees,
        p_value=float(chdtrc(degrees, deviance)) if degrees > 0 else float("nan"),
        n_replicates=n_bootstrap,
    )


def _limits(share: Array, replicates: Array) -> tuple[Array, Array, Array, Array]:
    """Pointwise percentiles, and limits that hold 95 % of replicates (S, n) whole, symmetric on the logit scale."""
    lower, upper = np.percentile(replicates, [2.5, 97.5], axis=0)
    centre, scattered = logit(share), logit(replicates)
    error = scattered.std(axis=0)
    farthest = (np.abs(scattered - centre) / np.where(error > 0.0, error, 1.0)).max(axis=1)
    wide = np.percentile(farthest, 95.0) * error
    return lower, upper, np.minimum(expit(centre - wide), lower), np.maximum(expit(centre + wide), upper)


def _averaged(
    columns: Array, offset: Array, test: Array, other: Array, at: Array
) -> tuple[Array, dict[tuple[int, ...], Array], dict[tuple[int, ...], Array]]:
    """Averaged shares (B, n) at columns `at` (n, q); weights and log-likelihoods (B,) of each model by its powers."""
    models = [
        orders for size in range(1, columns.shape[1] + 1) for orders in combinations(range(columns.shape[1]), size)
    ]
    logits, likelihood = {}, {}
    for orders in models:
        coefficients, likelihood[orders] = _binomial(columns[:, orders], offset, test, other)
        logits[orders] = np.clip(coefficients @ at[:, orders].T, -LARGEST_LOGIT, LARGEST_LOGIT)
    aic = np.stack([2.0 * len(orders) - 2.0 * likelihood[orders] for orders in models])
    excess = aic - aic.min(axis=0)
    weight = np.where(excess <= WITHIN_AIC, np.exp(-0.5 * excess), 0.0)
    weight /= weight.sum(axis=0)
    share = sum(w[:, None] * expit(logits[orders]) for w, orders in zip(weight, models, strict=True))
    return np.asarray(share), dict(zip(models, weight, strict=True)), likelihood


def _binomial(columns: Array, offset: Array, test: Array, other: Array) -> tuple[Array, Array]:
    """Logistic regressions of B data sets (B, R) on the same columns (R, q): coefficients (B, q), log-likelihood (B,).

    Newton steps, halved where the likelihood would fall.
    """
    q, n = columns.shape[1], test + other
    coefficients = np.zeros((len(test), q))

    def likelihood(at: Array) -> tuple[Array, Array]:
        eta = at @ columns.T + offset
        return (test * log_expit(eta) + other * log_expit(-eta)).sum(axis=1), eta

    value, eta = likelihood(coefficients)
    for _ in range(STEPS):
        share = expit(eta)
        gradient = (test - n * share) @ columns
        information = np.einsum("br,ri,rj->bij", n * share * (1.0 - share), columns, columns, optimize=True)
        scale = np.trace(information, axis1=1, axis2=2) + 1e-12
        step = np.linalg.solve(information + 1e-9 * scale[:, None, None] * np.eye(q), gradient[..., None])[..., 0]
        if np.sqrt(np.abs((step * gradient).sum(axis=1)).max()) < GRADIENT_TOLERANCE:
            break
        tried, new_eta = likelihood(coefficients + step)
        for _ in range(10):
            worse = tried < value - 1e-9
            if not worse.any():
                break
            step[worse] *= 0.5
            tried, new_eta = likelihood(coefficients + step)
        coefficients, value, eta = coefficients + step, tried, new_eta
    return coefficients, value
