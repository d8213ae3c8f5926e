"""Profile-likelihood intervals of a one-stage fit, where the likelihood is not the parabola that Wald's take it for.

The limits of a parameter are where twice the fall of the log-likelihood, all other parameters at their best, is the
square of the interval's quantile (times the dispersion factor): Venzon and Moolgavkar (1988), Appl. Stat. 37: 87-94.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from codend.selectivity.fits.marginal import log_likelihood, place_nodes
from codend.selectivity.fits.one_stage import OneStage
from codend.selectivity.fits.parameters import Estimates

Array = NDArray[np.float64]

FARTHEST: Final = 12.0
"""Standard errors from the estimate beyond which a limit is not looked for: there is none."""
PRECISION: Final = 2e-3  # of a limit, in standard errors


def with_profile_limits(found: Estimates, fit: OneStage, dispersion: float = 1.0) -> tuple[Estimates, tuple[str, ...]]:
    """Estimates with profile limits of L50, SR and an estimated split, and the kind of each interval.

    The parameters of `fit` are to be the mean L50, ln SR and logit split, that is, of one gear. A side without a limit
    is NaN.
    """
    lower, upper = found.lower_95.copy(), found.upper_95.copy()
    kinds = ["wald"] * len(found.names)
    at = fit.model.slices
    for name, part, back in (("l50_cm", "l50", float), ("sr_cm", "sr", np.exp), ("split", "split", expit)):
        if name not in found.names or np.isnan(found[name]) or at[part].start == at[part].stop:
            continue
        i = found.names.index(name)
        drop = fit.quantile**2 * dispersion
        lower[i], upper[i] = (float(back(limit)) for limit in profile_limits(fit, at[part].start, drop))
        kinds[i] = "profile"
    return replace(found, lower_95=lower, upper_95=upper), tuple(kinds)


def profile_limits(fit: OneStage, index: int, drop: float) -> tuple[float, float]:
    """Limits of one internal parameter, where twice the profile log-likelihood has fallen by `drop`; NaN for none."""
    error = float(np.sqrt(fit.maximum.covariance[index, index]))
    return _limit(fit, index, -error, drop), _limit(fit, index, error, drop)


def _limit(fit: OneStage, index: int, error: float, drop: float) -> float:
    """On the side of the sign of `error`, a standard error."""
    from scipy.optimize import brentq, minimize

    theta, covariance, model = fit.theta, fit.maximum.covariance, fit.model
    others = np.arange(theta.size) != index
    # the others at their best move along the regression on the parameter
    along = covariance[others, index] / covariance[index, index]
    root = np.linalg.cholesky(np.linalg.inv(np.linalg.inv(covariance)[np.ix_(others, others)]))
    modes = fit.maximum.modes
    best: dict[float, Array] = {}

    def excess(steps: float) -> float:
        nonlocal modes
        if steps == 0.0:
            return -drop
        shift = steps * error
        nearest = min(best, key=lambda tried: abs(tried - steps), default=None)
        start = np.zeros(theta.size - 1) if nearest is None else best[nearest]

        def objective(free: Array) -> tuple[float, Array]:
            nonlocal modes
            tried = theta.copy()
            tried[index] += shift
            tried[others] += along * shift + root @ free
            nodes, modes = place_nodes(model, tried, modes)
            value, gradient = log_likelihood(model, tried, nodes)
            return -value, -root.T @ gradient[others]

        if theta.size == 1:
            lowest = objective(np.zeros(0))[0]
        else:
            found = minimize(objective, start, jac=True, method="BFGS", options={"gtol": 1e-3})
            best[steps], lowest = found.x, float(found.fun)
        return 2.0 * (fit.maximum.log_likelihood + lowest) - drop

    with np.errstate(all="ignore"):
        far = float(np.sqrt(drop))
        while not excess(far) > 0.0:
            far *= 1.4
            if far > FARTHEST:
                return float("nan")
        return float(theta[index] + error * brentq(excess, 0.0, far, xtol=PRECISION, rtol=1e-12))
