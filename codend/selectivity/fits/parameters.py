"""From internal parameters to the ones users read, with the exact Jacobian for the delta method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, ndtri

from codend.selectivity.fits.model import SelectionModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimates:
    """Named estimates with standard errors and 95 % intervals; four arrays of one length, NaN where a fit failed."""

    names: tuple[str, ...]
    values: Array
    standard_errors: Array
    lower_95: Array
    upper_95: Array

    def __getitem__(self, name: str) -> float:
        """The estimate of that name."""
        return float(self.values[self.names.index(name)])


def within_lengths(found: Estimates, length_cm: Array) -> tuple[Estimates, str]:
    """Estimates without an L50 and SR that lie outside the lengths of the fish, and the word for it, empty if none is.

    A curve that reaches one half nowhere among the lengths (n,) says nothing of where it does.
    """
    if "l50_cm" not in found.names or np.isnan(found["l50_cm"]):
        return found, ""
    lowest, highest = float(length_cm.min()), float(length_cm.max())
    if lowest <= found["l50_cm"] <= highest:
        return found, ""
    outside = np.array([name.partition(":")[0] in ("l50_cm", "sr_cm") for name in found.names])
    numbers = (found.values, found.standard_errors, found.lower_95, found.upper_95)
    emptied = Estimates(found.names, *(np.where(outside, np.nan, column) for column in numbers))
    side = "below" if found["l50_cm"] < lowest else "above"
    return emptied, (
        f"no L50: the fitted curve is at one half {side} the lengths of the fish, {lowest:g} to {highest:g} cm, where "
        "nothing was measured"
    )


def parameter_names(model: SelectionModel) -> tuple[str, ...]:
    """Names in the order of `public_parameters`.

    `a, b`, then `delta` (Richards), `split` (paired gear), `l50_cm, sr_cm`, then for every covariate c its effects per
    unit of c: `a:c, b:c` (coefficients of the linear predictor) and `l50_cm:c, sr_cm:c` (slopes of L50 and SR).
    With covariates, a, b, L50 and SR are those at the mean of each covariate over the hauls, and so are the slopes.
    """
    names = [*model.curve.parameter_names]
    if model.design == "paired":
        names.append("split")
    names += ["l50_cm", "sr_cm"]
    for covariate in model.covariate_names:
        names += [f"{p}:{covariate}" for p in ("a", "b", "l50_cm", "sr_cm")]
    return tuple(names)


def public_parameters(model: SelectionModel, theta: Array) -> tuple[Array, Array]:
    """Values (..., m) and Jacobian (..., m, k) with respect to the internal parameters (..., k)."""
    k, n_linear = model.n_parameters, model.columns.shape[1]
    n_by_haul = n_linear // 2
    delta, logit_split = model.shape_and_split(theta)

    # a = alpha - beta centre / scale, b = beta / scale, and each covariate's own scale
    unscale = np.kron(
        [[1.0, -model.length_centre_cm / model.length_scale_cm], [0.0, 1.0 / model.length_scale_cm]],
        np.diag(1.0 / np.concatenate([[1.0], model.covariate_scale])),
    )
    linear = theta[..., :n_linear] @ unscale.T
    by_linear = np.zeros((*theta.shape[:-1], n_linear, k))
    by_linear[..., :n_linear] = unscale

    a, b = linear[..., 0], linear[..., n_by_haul]
    curve_values = [a, b]
    curve_jacobian = [by_linear[..., 0, :], by_linear[..., n_by_haul, :]]
    if model.curve.has_shape:
        curve_values.append(delta)
        curve_jacobian.append(_unit(k, n_linear, delta))
    curve_parameters = np.stack(curve_values, axis=-1)
    l50, sr = np.moveaxis(model.curve.l50_sr(curve_parameters), -1, 0)
    d_l50, d_sr = np.moveaxis(model.curve.l50_sr_gradient(curve_parameters) @ np.stack(curve_jacobian, axis=-2), -2, 0)

    values, jacobian = curve_values, curve_jacobian
    if model.design == "paired":
        split = expit(logit_split)
        values.append(split)
        jacobian.append(_unit(k, k - 1, split * (1.0 - split) * model.estimate_split))
    values += [l50, sr]
    jacobian += [d_l50, d_sr]
    d_b = by_linear[..., n_by_haul, :]
    for c in range(1, n_by_haul):
        a_c, b_c = linear[..., c], linear[..., n_by_haul + c]
        d_a_c, d_b_c = by_linear[..., c, :], by_linear[..., n_by_haul + c, :]
        # with a(c), b(c) linear: dL50/dc = -(a_c + L50 b_c) / b, dSR/dc = -SR b_c / b
        l50_c, sr_c = -(a_c + l50 * b_c) / b, -sr * b_c / b
        values += [a_c, b_c, l50_c, sr_c]
        jacobian += [
            d_a_c,
            d_b_c,
            -(d_a_c + _times(l50, d_b_c) + _times(b_c, d_l50) + _times(l50_c, d_b)) / b[..., None],
            -(_times(b_c, d_sr) + _times(sr, d_b_c) + _times(sr_c, d_b)) / b[..., None],
        ]
    return np.stack(values, axis=-1), np.stack(jacobian, axis=-2)


def delta_method(
    model: SelectionModel, theta: Array, covariance: Array, quantile: float = float(ndtri(0.975))
) -> Estimates:
    """Estimates with Wald intervals of one fit: theta (k,), covariance (k, k).

    Intervals are symmetric (estimate +- quantile * standard error), but for split and delta, which are symmetric on the
    logit and the log scale so that they stay within their range. A fixed split has standard error 0.
    """
    names = parameter_names(model)
    values, jacobian = public_parameters(model, theta)
    errors = np.sqrt(np.einsum("mi,ij,mj->m", jacobian, covariance, jacobian))
    lower, upper = values - quantile * errors, values + quantile * errors
    ends = np.array([-quantile, quantile])
    if model.curve.has_shape:
        i, at = model.columns.shape[1], names.index("delta")
        lower[at], upper[at] = np.exp(theta[i] + ends * np.sqrt(covariance[i, i]))
    if model.estimate_split:
        at = names.index("split")
        lower[at], upper[at] = expit(theta[-1] + ends * np.sqrt(covariance[-1, -1]))
    return Estimates(names, values, errors, lower, upper)


def _times(factor: Array, gradient: Array) -> Array:
    return factor[..., None] * gradient


def _unit(k: int, position: int, factor: Array) -> Array:
    """(..., k) gradient of a quantity that depends on one internal parameter."""
    gradient = np.zeros((*factor.shape, k))
    gradient[..., position] = factor
    return gradient
