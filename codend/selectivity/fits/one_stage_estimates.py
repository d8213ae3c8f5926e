"""What a one-stage fit says in numbers users read: parameters of a gear, coefficients, curves and bands.

Standard errors are by the delta method from the observed information, with the Jacobian by central differences of the
closed forms. Intervals are symmetric on the scale on which a quantity is free: SR, b and delta on the logarithm, the
split on the logit, others as they stand.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import expit, logit

from codend.selectivity.fits.one_stage import NORMAL, SD_NAMES, OneStage, Point
from codend.selectivity.fits.parameters import Estimates, within_lengths
from codend.selectivity.fits.predictors import Predictor

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

DIFFERENCE: Final = 1e-4  # in standard errors of each internal parameter
POSITIVE: Final = ("b", "sr_cm", "delta", "d", "w")
SHARES: Final = ("split", "c")
DRAWS: Final = 20_000
"""Of the normal deviates behind simultaneous bands."""


@dataclass(frozen=True)
class Band:
    """A curve over lengths with 95 % limits, arrays of one length.

    Attributes:
        length_cm: lengths.
        value: retention, or a difference of retentions.
        lower_95, upper_95: each length on its own.
        lower_all_95, upper_all_95: simultaneous: the whole true curve lies between them with 95 %.
    """

    length_cm: Array
    value: Array
    lower_95: Array
    upper_95: Array
    lower_all_95: Array
    upper_all_95: Array

    @property
    def significant(self) -> NDArray[np.bool_]:
        """Lengths whose simultaneous interval leaves out zero."""
        return (self.lower_all_95 > 0.0) | (self.upper_all_95 < 0.0)


def estimates(fit: OneStage, level: str = "", at: Mapping[str, str | float] | None = None) -> Estimates:
    """Parameters of one gear: the curve's, `split` (paired gear), `l50_cm, sr_cm`, standard deviations between units.

    Without a group and without `at` there follow for every covariate c of a formula the slopes of L50 and SR at the
    mean, `l50_cm:c, sr_cm:c`. NaN where the fit failed.
    """
    point, sds = fit.point(level, at), [SD_NAMES[term] for term in fit.model.random]
    shape_names = {"richards": ("delta",), "dual": ("c", "d", "w")}.get(fit.model.family.name, ())
    slopes = (
        []
        if level or at
        else [(of, name) for of, one in ((0, fit.l50), (1, fit.log_sr)) for name in covariates(fit, one)]
    )
    slopes.sort(key=lambda slope: slope[1])
    steps = [(of, *_slope_points(fit, name)) for of, name in slopes]
    paired = fit.model.design == "paired"
    names = ["a", "b", *shape_names, *(["split"] * paired), "l50_cm", "sr_cm"]
    names += [f"{('l50_cm', 'sr_cm')[of]}:{name}" for of, name in slopes]

    def values(theta: Array) -> Array:
        l50, sr, split = fit.curve_at(point, theta)
        shape = theta[fit.model.slices["shape"]]
        q25, q50, q75 = fit.model.family.quartiles(shape)[0]
        b = (q75 - q25) / sr
        found = [q50 - b * l50, b, *_public_shape(fit.model.family.name, shape), *([split] * paired), l50, sr]
        for of, up, down, width in steps:
            found.append((fit.curve_at(up, theta)[of] - fit.curve_at(down, theta)[of]) / width)
        return np.array([*found, *theta[fit.model.slices["sd"]]])

    return delta_estimates(fit, (*names, *sds), values)


def estimates_within(
    fit: OneStage, level: str = "", at: Mapping[str, str | float] | None = None
) -> tuple[Estimates, str]:
    """`estimates` without an L50 outside the lengths of the gear's fish, and the word for it or for a failed fit."""
    if not fit.converged:
        return estimates(fit, level, at), fit.maximum.outcome.value
    fished = fit.data.test_count + fit.data.other_count > 0.0
    if level:
        fished &= (fit.hauls[fit.group].to_numpy() == level)[fit.data.haul]
    return within_lengths(estimates(fit, level, at), fit.data.length_cm[fished])


def delta_estimates(fit: OneStage, names: tuple[str, ...], function: Function) -> Estimates:
    """Named functions of theta (k,) -> (m,) with errors and intervals; a split that is fixed has no error."""
    if not fit.converged:
        nothing = np.full(len(names), np.nan)
        return Estimates(names, nothing, nothing, nothing, nothing)
    value, slopes = function(fit.theta), jacobian(fit, function)
    errors = np.sqrt(np.maximum(np.einsum("mi,ij,mj->m", slopes, fit.maximum.covariance, slopes), 0.0))
    half = fit.quantiles(slopes) * errors
    lower, upper = value - half, value + half
    with np.errstate(all="ignore"):
        for i, name in enumerate(names):
            if name in POSITIVE:
                lower[i], upper[i] = value[i] * np.exp([-half[i] / value[i], half[i] / value[i]])
            elif name in SHARES:
                width = half[i] / (value[i] * (1.0 - value[i]))
                lower[i], upper[i] = expit(logit(value[i]) + np.array([-width, width]))
            elif name in SD_NAMES.values():
                lower[i] = max(lower[i], 0.0)
    return Estimates(names, value, errors, lower, upper)


def jacobian(fit: OneStage, function: Function) -> Array:
    """(m, k) derivatives of a function of theta."""
    columns = []
    for i, error in enumerate(np.sqrt(np.diagonal(fit.maximum.covariance))):
        step = np.zeros(fit.theta.size)
        step[i] = DIFFERENCE * error
        columns.append((function(fit.theta + step) - function(fit.theta - step)) / (2.0 * step[i]))
    return np.stack(columns, axis=-1)


def retention_band(fit: OneStage, point: Point, length_cm: ArrayLike) -> Band:
    """Retention of a haul that deviates in nothing; limits symmetric on the logit scale, so that they are shares."""
    length = np.asarray(length_cm, dtype=float)

    def log_odds(theta: Array) -> Array:
        r = np.clip(fit.retention_at(point, length, theta), 1e-300, 1.0 - 1e-16)
        return np.asarray(logit(r))

    return _band(fit, length, log_odds, expit)


def share_band(fit: OneStage, point: Point, length_cm: ArrayLike) -> Band:
    """Share of the fish in the test gear, of equally sampled paired gear: p r / (p r + 1 - p)."""
    length = np.asarray(length_cm, dtype=float)

    def log_odds(theta: Array) -> Array:
        split = fit.curve_at(point, theta)[2]
        return np.asarray(np.log(np.maximum(fit.retention_at(point, length, theta), 1e-300)) + logit(split))

    return _band(fit, length, log_odds, expit)


def delta_band(fit: OneStage, first: Point, second: Point, length_cm: ArrayLike) -> Band:
    """Retention of a first gear minus that of a second, of one fit: both share what they are correlated in."""
    length = np.asarray(length_cm, dtype=float)

    def difference(theta: Array) -> Array:
        return fit.retention_at(first, length, theta) - fit.retention_at(second, length, theta)

    return _band(fit, length, difference, np.asarray)


def _band(fit: OneStage, length: Array, function: Function, back: Callable[[Array], Array]) -> Band:
    if not fit.converged:
        nothing = np.full(length.size, np.nan)
        return Band(length, *[nothing] * 5)
    value, slopes = function(fit.theta), jacobian(fit, function)
    root = covariance_root(fit.maximum.covariance)
    directions = slopes @ root
    errors = np.sqrt((directions**2).sum(axis=1))
    pointwise = fit.quantiles(slopes)
    half, wide = pointwise * errors, simultaneous_factor(directions) * pointwise * errors
    return Band(length, back(value), *(back(value + part) for part in (-half, half, -wide, wide)))


def covariance_root(covariance: Array) -> Array:
    """(k, k) C with C C' = covariance, for one that may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def simultaneous_factor(directions: Array) -> float:
    """How much wider than for a single point a band is that holds the whole curve, by the largest |deviate|.

    Args:
        directions: (n, k) derivatives of the curve times a root of the covariance.

    Source: Hothorn, Bretz and Westfall (2008), Biom. J. 50: 346-363; the quantile by simulation, fixed seed.
    """
    errors = np.sqrt((directions**2).sum(axis=1))
    good = errors > 1e-12 * errors.max(initial=0.0)
    if not good.any():
        return 1.0
    deviates = np.random.default_rng(0).standard_normal((DRAWS, directions.shape[1]))
    largest = np.abs(deviates @ (directions[good] / errors[good, None]).T).max(axis=1)
    return max(float(np.quantile(largest, 0.95)) / NORMAL, 1.0)


def _public_shape(family: str, shape: Array) -> list[float]:
    if family == "dual":
        return [float(expit(shape[0])), *map(float, np.exp(shape[1:]))]
    return list(map(float, np.exp(shape)))


def covariates(fit: OneStage, one: Predictor) -> list[str]:
    """Numeric columns that a formula uses."""
    used = one.spec.required_variables if one.spec is not None else ()
    return [str(name) for name in fit.hauls.columns if name in used and fit.hauls[name].dtype.kind == "f"]


def _slope_points(fit: OneStage, name: str) -> tuple[Point, Point, float]:
    """Points a little above and below the mean of a covariate, and the distance between them."""
    mean, width = float(fit.hauls[name].mean()), 1e-3 * float(fit.hauls[name].std())
    return fit.point("", {name: mean + width}), fit.point("", {name: mean - width}), 2.0 * width
