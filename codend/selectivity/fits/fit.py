"""One maximum-likelihood fit of a retention curve, with what tells whether to believe it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, expit, gammaln, log_expit, xlogy

from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.model import SelectionModel, log_odds, without_covariates
from codend.selectivity.fits.parameters import Estimates, delta_method, within_lengths
from codend.selectivity.fits.scoring import Maximum, Outcome, maximise

Array = NDArray[np.float64]

OVERDISPERSION: Final = ("none", "pearson", "deviance")
# a chi-square statistic is believed only over classes with more expected fish than this in both gears
LEAST_EXPECTED: Final = 3.0
LACK_OF_FIT_LEVEL: Final = 0.05
LEAST_DEGREES: Final = 5  # of freedom: on fewer the factor itself is known within a factor of two or so
FLAT_LEVEL: Final = 0.05


@dataclass(frozen=True)
class Fit:
    """A fitted curve; every number is NaN when `converged` is False.

    Attributes:
        group: what was fitted: "pooled" or "haul NAME".
        model: curve, design and rows.
        outcome: how the fit ended; `outcome.value` is a sentence.
        theta: (k,) internal parameters of the model.
        covariance: (k, k) their covariance, inverse observed information times `dispersion`.
        estimates: the parameters users read, with delta-method intervals; L50 and SR are NaN where L50 lies outside the
            lengths of the fish.
        note: what is to be said of a fit without numbers, or without an L50; else empty.
        gradient_norm: distance to the maximum of the likelihood, in standard errors.
        iterations: Newton steps taken.
        n_fish: fish counted.
        log_likelihood: binomial, with the coefficients.
        aic: 2 k - 2 log_likelihood.
        deviance, pearson_chi2: lack of fit over all classes with fish.
        degrees_of_freedom: classes with fish, minus k.
        p_value: of the deviance; of little meaning where most classes hold only a few fish.
        dispersion: factor >= 1 on the covariance (see `dispersion_factor`).
        pearson_residuals, deviance_residuals: (R,), NaN in classes without fish.
    """

    group: str
    model: SelectionModel
    outcome: Outcome
    theta: Array
    covariance: Array
    estimates: Estimates
    note: str
    gradient_norm: float
    iterations: int
    n_fish: float
    log_likelihood: float
    aic: float
    deviance: float
    pearson_chi2: float
    degrees_of_freedom: int
    p_value: float
    dispersion: float
    pearson_residuals: Array
    deviance_residuals: Array

    @property
    def converged(self) -> bool:
        """Whether the estimates are a maximum of the likelihood."""
        return self.outcome is Outcome.CONVERGED


def fit_pooled(data: FieldData, model: SelectionModel, overdispersion: str = "pearson") -> Fit:
    """One curve for all hauls; their rows stay apart, so that raising factors and covariates keep their haul.

    The standard errors take no account of variation between hauls beyond the dispersion factor.
    """
    maximum = maximise(model, data.test_count[None], data.other_count[None])
    counts = {"test": data.test_count, "other": data.other_count}
    fit = _described("pooled", data, model, maximum, 0, **counts, overdispersion=overdispersion)
    if fit.converged and rise_p_value(data, fit.log_likelihood, model.n_parameters, fit.dispersion) > FLAT_LEVEL:
        flat = Maximum(
            maximum.theta * np.nan,
            maximum.covariance * np.nan,
            maximum.log_likelihood,
            maximum.gradient_norm,
            maximum.iterations,
            np.array([Outcome.FLAT], dtype=object),
        )
        return _described("pooled", data, model, flat, 0, **counts, overdispersion="none")
    return fit


def rise_p_value(data: FieldData, log_likelihood: float, n_parameters: int, dispersion: float = 1.0) -> float:
    """P-value of the hypothesis that the share of fish in the codend or test gear is the same at every length.

    Likelihood ratio of a curve of `n_parameters` and `log_likelihood` (with coefficients) to one share for all lengths,
    over the dispersion.
    """
    from scipy.optimize import brentq

    test, n, offset = data.test_count, data.test_count + data.other_count, data.log_offset

    def excess(zeta: float) -> float:
        return float(test.sum() - (n * expit(zeta + offset)).sum())

    limit = 40.0 + float(np.abs(offset).max())
    level = brentq(excess, -limit, limit) if excess(-limit) * excess(limit) < 0.0 else np.sign(excess(0.0)) * limit
    coefficients = gammaln(n + 1.0) - gammaln(test + 1.0) - gammaln(n - test + 1.0)
    constant = test * log_expit(level + offset) + (n - test) * log_expit(-level - offset) + coefficients
    ratio = 2.0 * (log_likelihood - float(constant.sum())) / dispersion
    return float(chdtrc(max(n_parameters - 1, 1), max(ratio, 0.0)))


def fit_hauls(data: FieldData, model: SelectionModel, overdispersion: str = "pearson") -> tuple[Fit, ...]:
    """One curve for each haul, without covariates."""
    model = without_covariates(model)
    of_haul = data.haul == np.arange(len(data.haul_names))[:, None]
    test, other = data.test_count * of_haul, data.other_count * of_haul
    maximum = maximise(model, test, other)
    return tuple(
        _described(f"haul {name}", data, model, maximum, h, test=test[h], other=other[h], overdispersion=overdispersion)
        for h, name in enumerate(data.haul_names)
    )


def _described(
    group: str,
    data: FieldData,
    model: SelectionModel,
    maximum: Maximum,
    i: int,
    *,
    test: Array,
    other: Array,
    overdispersion: str,
) -> Fit:
    """Fit number i of a batch with its diagnostics."""
    n, theta = test + other, maximum.theta[i]
    zeta = log_odds(model, theta[None]).value[0]
    phi = expit(zeta)
    with np.errstate(divide="ignore", invalid="ignore"):  # classes without fish, or without doubt: NaN by definition
        pearson = (test - n * phi) / np.sqrt(n * phi * expit(-zeta))
        log_ratio = xlogy(test, test / n) + xlogy(other, other / n) - test * log_expit(zeta) - other * log_expit(-zeta)
    deviance_residuals = np.sign(test - n * phi) * np.sqrt(2.0 * np.maximum(log_ratio, 0.0))
    fished = n > 0.0
    k, degrees = model.n_parameters, int(fished.sum()) - model.n_parameters
    deviance = float((deviance_residuals[fished] ** 2).sum())
    coefficients = (gammaln(n + 1.0) - gammaln(test + 1.0) - gammaln(other + 1.0)).sum()
    converged = maximum.outcome[i] is Outcome.CONVERGED
    log_likelihood = float(maximum.log_likelihood[i] + coefficients) if converged else np.nan

    squares = {"none": None, "pearson": pearson**2, "deviance": deviance_residuals**2}[overdispersion]
    well_filled = (n * phi > LEAST_EXPECTED) & (n * expit(-zeta) > LEAST_EXPECTED)
    dispersion = 1.0 if squares is None else dispersion_factor(squares[well_filled], k)
    covariance = dispersion * maximum.covariance[i]
    estimates = delta_method(model, theta, covariance)
    note = "" if converged else maximum.outcome[i].value
    if converged:
        estimates, note = within_lengths(estimates, data.length_cm[fished])
    return Fit(
        group=group,
        model=model,
        outcome=maximum.outcome[i],
        theta=theta,
        covariance=covariance,
        estimates=estimates,
        note=note,
        gradient_norm=float(maximum.gradient_norm[i]),
        iterations=int(maximum.iterations[i]),
        n_fish=float(n.sum()),
        log_likelihood=log_likelihood,
        aic=2.0 * k - 2.0 * log_likelihood,
        deviance=deviance,
        pearson_chi2=float((pearson[fished] ** 2).sum()),
        degrees_of_freedom=degrees,
        p_value=float(chdtrc(degrees, deviance)) if degrees > 0 else np.nan,
        dispersion=dispersion,
        pearson_residuals=pearson,
        deviance_residuals=deviance_residuals,
    )


def dispersion_factor(squared_residuals: Array, n_parameters: int) -> float:
    """Variance inflation X^2 / d where X^2, on d degrees of freedom, shows lack of fit at the 5 % level; else 1.

    With the classes of single hauls it is the replicate estimate of dispersion (REP) of Millar, Broadhurst and Macbeth
    (2004, Fish. Res. 67). Classes expected to hold 3 fish or fewer in either gear must be left out by the caller: their
    residuals are far from chi-square and deflate (deviance) or scatter (Pearson) the estimate. On fewer than 5 degrees
    of freedom there is no telling, and the factor is 1. Inflation is right for variation between fish and hauls; a
    curve of the wrong shape also raises X^2, and the residuals tell which it is.
    """
    degrees = squared_residuals.size - n_parameters
    if degrees < LEAST_DEGREES:
        return 1.0
    statistic = float(squared_residuals.sum())
    return statistic / degrees if chdtrc(degrees, statistic) < LACK_OF_FIT_LEVEL else 1.0
