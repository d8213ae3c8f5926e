"""The likelihood of counted fish: a retention curve seen through a covered-codend or paired-gear design.

With n fish of one length counted in the two gears together, the number in the codend (test gear) is binomial (n, phi).
With c1, c2 the counted fractions (1 / raising factor) of the test gear and of the cover or control:

    covered   phi = c1 r / (c1 r + c2 (1 - r))                      zeta = ln r - ln(1 - r) + ln(c1/c2)
    paired    phi = p c1 r / (p c1 r + (1 - p) c2)     (SELECT)     zeta = ln r + ln(p/(1 - p)) + ln(c1/c2)

where zeta = logit(phi), r(L) = F(a + b L) and p is the split. Raising factors are thus offsets: the likelihood is that
of the fish counted (Millar 1994, ICES J. Mar. Sci. 51: 293; Millar and Fryer 1999, Rev. Fish Biol. Fish. 9: 89).

Internal parameters theta (k,) are those of centred and scaled columns, which keeps the information matrix well
conditioned: alpha and beta for [1, z] x [1, covariates], z the scaled length, then ln delta (Richards), then
logit p (estimated split). `codend.selectivity.fits.parameters` turns them into what users read.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_expit, logit

from codend.selectivity.fits.curves import CURVES, Curve, LogProbability
from codend.selectivity.fits.fielddata import FieldData

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SelectionModel:
    """A curve, a design and R rows to predict.

    Attributes:
        curve: the retention curve.
        design: "covered" or "paired".
        estimate_split: paired gear only: the split p is estimated, else it is `fixed_split`.
        fixed_split: share of the fish entering the test gear, where it is not estimated.
        covariate_names: C haul covariates, entering a and b linearly.
        length_centre_cm, length_scale_cm: z = (L - centre) / scale.
        covariate_centre, covariate_scale: (C,) the same for covariates; the centre is the mean over hauls.
        columns: (R, 2 + 2C) predictors of eta: [1, covariates, z, z * covariates].
        log_offset: (R,) ln(c1/c2).
    """

    curve: Curve
    design: str
    estimate_split: bool
    fixed_split: float
    covariate_names: tuple[str, ...]
    length_centre_cm: float
    length_scale_cm: float
    covariate_centre: Array
    covariate_scale: Array
    columns: Array
    log_offset: Array

    @property
    def n_parameters(self) -> int:
        """Number k of estimated parameters."""
        return self.columns.shape[1] + self.curve.has_shape + self.estimate_split

    def shape_and_split(self, theta: Array) -> tuple[Array, Array]:
        """(delta, logit p) of internal parameters (..., k), each (...); delta is 1 where the model has none."""
        n_linear = self.columns.shape[1]
        fixed = np.full(theta.shape[:-1], logit(self.fixed_split))
        delta = np.exp(theta[..., n_linear]) if self.curve.has_shape else np.ones_like(fixed)
        return delta, theta[..., -1] if self.estimate_split else fixed


class Evaluation(NamedTuple):
    """Log-likelihood of B data sets (B,), gradient (B, k), and observed and expected information (B, k, k)."""

    log_likelihood: Array
    gradient: Array
    observed: Array
    expected: Array


def selection_model(
    data: FieldData, curve: str, estimate_split: bool = False, fixed_split: float = 0.5
) -> SelectionModel:
    """The model of all rows of a trial; an estimated split, or one other than 0.5, needs paired gear."""
    if (estimate_split or fixed_split != 0.5) and data.design != "paired":
        raise ValueError("only paired gear has a split")
    length_centre, length_scale = _centre_and_scale(data.length_cm)
    covariate_centre, covariate_scale = _centre_and_scale(data.covariates)
    covariates = ((data.covariates - covariate_centre) / covariate_scale)[data.haul]
    by_haul = np.hstack([np.ones((data.haul.size, 1)), covariates])
    z = (data.length_cm - length_centre) / length_scale
    return SelectionModel(
        curve=CURVES[curve],
        design=data.design,
        estimate_split=estimate_split,
        fixed_split=fixed_split,
        covariate_names=data.covariate_names,
        length_centre_cm=float(length_centre),
        length_scale_cm=float(length_scale),
        covariate_centre=np.asarray(covariate_centre),
        covariate_scale=np.asarray(covariate_scale),
        columns=np.hstack([by_haul, by_haul * z[:, None]]),
        log_offset=data.log_offset,
    )


def _centre_and_scale(values: Array) -> tuple[Array, Array]:
    scale = values.std(axis=0)
    return values.mean(axis=0), np.where(scale > 0.0, scale, 1.0)


def without_covariates(model: SelectionModel) -> SelectionModel:
    """The model of single hauls: same centring of the length, no covariates (they are constant within a haul)."""
    n_by_haul = model.columns.shape[1] // 2
    none = np.empty(0)
    return replace(
        model,
        covariate_names=(),
        covariate_centre=none,
        covariate_scale=none,
        columns=np.ascontiguousarray(model.columns[:, [0, n_by_haul]]),
    )


def log_odds(model: SelectionModel, theta: Array) -> LogProbability:
    """Log-odds zeta = logit(phi) of internal parameters (B, k), with derivatives: arrays (B, R)."""
    delta, logit_split = model.shape_and_split(theta)
    eta = theta[:, : model.columns.shape[1]] @ model.columns.T
    retained, escaped = model.curve.log_parts(eta, delta[:, None])
    if model.design == "covered":
        log_ratio = LogProbability(*(np.subtract(r, e) for r, e in zip(retained, escaped, strict=True)))
    else:
        log_ratio = retained
    return log_ratio._replace(value=log_ratio.value + model.log_offset + logit_split[:, None])


def evaluate(model: SelectionModel, theta: Array, test_count: Array, other_count: Array) -> Evaluation:
    """Log-likelihood (without the binomial coefficients), gradient and information.

    Args:
        model: R rows.
        theta: (B, k) internal parameters, one set for each data set.
        test_count: (B, R) fish counted in the codend or test gear.
        other_count: (B, R) fish counted in the cover or control.
    """
    zeta = log_odds(model, theta)
    log_phi, log_rest = log_expit(zeta.value), log_expit(-zeta.value)
    log_likelihood = (test_count * log_phi + other_count * log_rest).sum(axis=1)

    n = test_count + other_count
    residual = test_count - n * np.exp(log_phi)
    # the square root of the weight first: in the far tail the slope overflows where the weight vanishes
    root_weight = np.sqrt(n) * np.exp(0.5 * (log_phi + log_rest))
    slopes = [(root_weight * zeta.eta)[:, None, :] * model.columns.T]
    gradient = [(residual * zeta.eta) @ model.columns]
    if model.curve.has_shape:
        slopes.append((root_weight * zeta.log_delta)[:, None, :])
        gradient.append((residual * zeta.log_delta).sum(axis=1, keepdims=True))
    if model.estimate_split:
        slopes.append(root_weight[:, None, :])
        gradient.append(residual.sum(axis=1, keepdims=True))
    jacobian = np.concatenate(slopes, axis=1)
    expected = jacobian @ jacobian.transpose(0, 2, 1)

    # observed = expected - sum of residual * second derivatives of zeta
    q = model.columns.shape[1]
    observed = expected.copy()
    observed[:, :q, :q] -= ((residual * zeta.eta_eta)[:, None, :] * model.columns.T) @ model.columns
    if model.curve.has_shape:
        cross = (residual * zeta.eta_log_delta) @ model.columns
        observed[:, :q, q] -= cross
        observed[:, q, :q] -= cross
        observed[:, q, q] -= (residual * zeta.log_delta_log_delta).sum(axis=1)
    return Evaluation(log_likelihood, np.concatenate(gradient, axis=1), observed, expected)
