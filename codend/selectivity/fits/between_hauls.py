"""The mean curve of many hauls and how much hauls differ from it (Fryer 1991, ICES J. Mar. Sci. 48: 281-290).

Each haul's estimated parameters v_h scatter about a mean that may depend on haul covariates, by the haul's own
estimation error R_h and by a between-haul covariance D common to all hauls:

    v_h ~ N(X_h theta, R_h + D),  X_h = covariates of haul h for alpha and beta, 1 for ln delta and logit split.

D is estimated by residual maximum likelihood (REML), theta by generalised least squares. Parameters are the internal
ones of `codend.selectivity.fits.model`; D >= 0 through its Cholesky factor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.fit import Fit
from codend.selectivity.fits.model import SelectionModel, without_covariates
from codend.selectivity.fits.parameters import Estimates, delta_method, parameter_names, public_parameters

Array = NDArray[np.float64]

GRADIENT_TOLERANCE = 1e-4  # of the REML log-likelihood, per relative change of the standard deviations


@dataclass(frozen=True)
class BetweenHauls:
    """Mean curve over hauls.

    Attributes:
        estimates: parameters of the mean curve, with Student-t intervals on H - 1 - C degrees of freedom.
        theta, covariance: (k,) and (k, k) the same in internal parameters.
        names: of the curve parameters that `between_sd` refers to.
        between_sd: standard deviations between hauls of a, b, delta, split, L50 and SR (delta method at the mean).
        between_covariance: (k', k') D in internal parameters.
        haul_names: hauls that entered.
        excluded: hauls whose own fit did not converge. Leaving them out biases the mean if they fail for a reason that
            has to do with their selection.
        converged: whether REML reached its maximum; all numbers are NaN if not.
        message: what happened.
    """

    estimates: Estimates
    theta: Array
    covariance: Array
    names: tuple[str, ...]
    between_sd: Array
    between_covariance: Array
    haul_names: tuple[str, ...]
    excluded: tuple[str, ...]
    converged: bool
    message: str


def fit_between_hauls(data: FieldData, model: SelectionModel, hauls: Sequence[Fit]) -> BetweenHauls:
    """Combine the fits of single hauls, `hauls` in the order of `data.haul_names`; `model` is the pooled model."""
    used = np.array([fit.converged for fit in hauls], dtype=bool)
    n_by_haul = 1 + len(model.covariate_names)
    degrees = int(used.sum()) - n_by_haul
    excluded = tuple(name for name, good in zip(data.haul_names, used, strict=True) if not good)
    haul_names = tuple(name for name, good in zip(data.haul_names, used, strict=True) if good)
    single = without_covariates(model)
    k = single.n_parameters
    theta, covariance = np.full(model.n_parameters, np.nan), np.full((model.n_parameters,) * 2, np.nan)
    between = np.full((k, k), np.nan)
    converged, quantile = False, np.nan
    if degrees < 2:
        message = f"too few hauls with a fit of their own: {used.sum()}, and at least {n_by_haul + 2} are needed"
    elif np.linalg.matrix_rank(z := _by_haul(data, model)[used]) < n_by_haul:
        message = "the covariates cannot be told apart over the hauls with a fit of their own"
    else:
        v = np.array([fit.theta for fit in hauls if fit.converged])
        within = np.array([fit.covariance for fit in hauls if fit.converged])
        design = np.zeros((len(v), k, model.n_parameters))
        design[:, 0, :n_by_haul] = design[:, 1, n_by_haul : 2 * n_by_haul] = z
        for extra in range(2, k):
            design[:, extra, 2 * n_by_haul + extra - 2] = 1.0
        found = reml(v, within, design)
        converged = found is not None
        message = "converged" if converged else "the residual likelihood of the between-haul covariance has no maximum"
        if found is not None:
            theta, covariance, between = found
            quantile = float(stdtrit(degrees, 0.975))
            if excluded:
                count = f"{len(excluded)} of {len(hauls)} hauls"
                message += f"; {count} left out for want of a fit of their own: {', '.join(excluded)}"

    mean_of_hauls = np.concatenate([theta[[0, n_by_haul]], theta[2 * n_by_haul :]])
    jacobian = public_parameters(single, mean_of_hauls)[1]
    return BetweenHauls(
        estimates=delta_method(model, theta, covariance, quantile),
        theta=theta,
        covariance=covariance,
        names=parameter_names(single),
        between_sd=np.sqrt(np.einsum("mi,ij,mj->m", jacobian, between, jacobian)),
        between_covariance=between,
        haul_names=haul_names,
        excluded=excluded,
        converged=converged,
        message=message,
    )


def _by_haul(data: FieldData, model: SelectionModel) -> Array:
    """(H, 1 + C) a one and the scaled covariates of every haul."""
    scaled = (data.covariates - model.covariate_centre) / model.covariate_scale
    return np.hstack([np.ones((len(scaled), 1)), scaled])


def reml(v: Array, within: Array, design: Array) -> tuple[Array, Array, Array] | None:
    """Mean parameters (K,), their covariance (K, K) and D (k, k); None where no maximum is found.

    Args:
        v: (H, k) estimates of single hauls.
        within: (H, k, k) their covariances.
        design: (H, k, K) X_h.
    """
    from scipy.optimize import minimize

    k = v.shape[1]
    lower = np.tril_indices(k)
    # parameters in units of their scatter, so that one tolerance serves all of them
    unit = np.sqrt(np.einsum("hii->i", within) / len(v) + v.var(axis=0))
    scaled_v, scaled_within = v / unit, within / (unit[:, None] * unit)
    scaled_design = design / unit[:, None]

    def objective(entries: Array) -> tuple[float, Array]:
        factor = np.zeros((k, k))
        factor[lower] = entries
        value, by_d, _, _ = _negative_reml(scaled_v, scaled_within, scaled_design, factor @ factor.T)
        return value, (2.0 * by_d @ factor)[lower]

    start = np.diag(np.sqrt(np.maximum(scaled_v.var(axis=0) - np.einsum("hii->i", scaled_within) / len(v), 0.05)))
    result = minimize(objective, start[lower], jac=True, method="BFGS", options={"gtol": 0.1 * GRADIENT_TOLERANCE})
    if not np.abs(result.jac).max() < GRADIENT_TOLERANCE:
        return None
    factor = np.zeros((k, k))
    factor[lower] = result.x
    between = factor @ factor.T
    _, _, theta, covariance = _negative_reml(scaled_v, scaled_within, scaled_design, between)
    return theta, covariance, between * unit[:, None] * unit


def _negative_reml(v: Array, within: Array, design: Array, between: Array) -> tuple[float, Array, Array, Array]:
    """Minus the REML log-likelihood, its gradient with respect to D (k, k), the GLS mean and its covariance."""
    total = within + between
    inverse = np.linalg.inv(total)
    weighted = inverse @ design  # V^-1 X
    information = (design.transpose(0, 2, 1) @ weighted).sum(axis=0)
    covariance = np.linalg.inv(information)
    theta = covariance @ np.einsum("hik,hi->k", weighted, v)
    error = np.einsum("hij,hj->hi", inverse, v - design @ theta)  # V^-1 e
    value = 0.5 * (
        np.linalg.slogdet(total)[1].sum()
        + np.linalg.slogdet(information)[1]
        + np.einsum("hi,hij,hj->", error, total, error)
    )
    by_d = 0.5 * (inverse - weighted @ covariance @ weighted.transpose(0, 2, 1) - error[:, :, None] * error[:, None, :])
    return float(value), by_d.sum(axis=0), theta, covariance
