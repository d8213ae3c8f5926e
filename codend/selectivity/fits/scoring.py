"""Maximum likelihood of many data sets at once, by damped Newton steps.

A bootstrap or a simulation study refits the same rows thousands of times with other counts. One step for all of them is
a few array operations, where a general optimiser would need some milliseconds of calls a data set; a single fit is the
batch of one. Newton steps with the observed information where that is positive definite, Fisher scoring with the
expected information elsewhere (McCullagh and Nelder 1989, section 2.5), damped as by Levenberg and Marquardt so that
the likelihood never falls, from the best point of a coarse grid.
"""

from __future__ import annotations

from enum import Enum
from itertools import product
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_expit

from codend.selectivity.fits.model import Evaluation, SelectionModel, evaluate, log_odds

Array = NDArray[np.float64]

MAX_ITERATIONS: Final = 100
GRADIENT_TOLERANCE: Final = 1e-6  # distance to the maximum, in standard errors
# least eigenvalue of the information over that of fish all at r = 0.5: below it some parameter is not determined
LEAST_INFORMATION: Final = 1e-9
ELEMENTS_AT_ONCE: Final = 150_000  # rows times data sets of a block, to stay within the processor's cache


class Outcome(Enum):
    """How a fit ended; the value is the sentence for the user."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "no maximum of the likelihood was reached; try a curve with fewer parameters or an equal split"
    NO_INFORMATION = (
        "the counts do not determine the parameters: too few lengths with fish, no lengths at which some fish are "
        "retained and some are not, or a curve with more parameters than the data support"
    )
    FLAT = (
        "the share of fish in the codend or test gear does not rise with length beyond chance (at the 5 % level): "
        "these counts show no selection"
    )
    FALLING = "the fitted retention falls with length; check which column is the codend or test gear"


NO_SELECTION: Final = (Outcome.FLAT, Outcome.FALLING, Outcome.NO_INFORMATION)
"""Ends of a pooled fit after which no other is tried: the fish of all hauls together tell of no selection."""


class Maximum(NamedTuple):
    """Fits of B data sets.

    Attributes:
        theta: (B, k) internal parameters, NaN unless converged.
        covariance: (B, k, k) inverse of the observed information, NaN unless converged.
        log_likelihood: (B,) without the binomial coefficients.
        gradient_norm: (B,) sqrt(g' I^-1 g): distance to the maximum in standard errors.
        iterations: (B,).
        outcome: (B,) array of `Outcome`.
    """

    theta: Array
    covariance: Array
    log_likelihood: Array
    gradient_norm: Array
    iterations: NDArray[np.int64]
    outcome: NDArray[np.object_]

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(B,) whether each fit is a maximum with finite estimates."""
        return np.array([outcome is Outcome.CONVERGED for outcome in self.outcome], dtype=bool)


def maximise(model: SelectionModel, test_count: Array, other_count: Array) -> Maximum:
    """Fit every data set of a batch: `test_count` and `other_count` are (B, R), fractions of fish allowed."""
    block = max(1, ELEMENTS_AT_ONCE // model.log_offset.size)
    parts = [
        _maximise_block(model, test_count[i : i + block], other_count[i : i + block])
        for i in range(0, test_count.shape[0], block)
    ]
    return Maximum(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _maximise_block(model: SelectionModel, test_count: Array, other_count: Array) -> Maximum:
    n_sets = test_count.shape[0]
    theta = grid_start(model, test_count, other_count)
    state = evaluate(model, theta, test_count, other_count)
    damping = np.full(n_sets, 1e-3)
    distance = np.full(n_sets, np.inf)
    iterations = np.zeros(n_sets, dtype=np.int64)
    scale = _reference_information(model, test_count + other_count)

    active = np.flatnonzero((scale > 0.0).all(axis=1))
    for _ in range(MAX_ITERATIONS):
        if active.size == 0:
            break
        iterations[active] += 1
        at = Evaluation(*(array[active] for array in state))
        step = _damped_step(at, damping[active], scale[active])
        distance[active] = np.sqrt(np.maximum((step * at.gradient).sum(axis=1), 0.0))
        trial = theta[active] + step
        with np.errstate(all="ignore"):  # a wild trial step is refused below
            tried = evaluate(model, trial, test_count[active], other_count[active])
        slack = 1e-13 * (1.0 + np.abs(at.log_likelihood))
        better = tried.log_likelihood >= at.log_likelihood - slack
        better &= np.isfinite(tried.observed).all(axis=(1, 2)) & np.isfinite(tried.expected).all(axis=(1, 2))
        moved = active[better]
        theta[moved] = trial[better]
        for array, new in zip(state, tried, strict=True):
            array[moved] = new[better]
        damping[active] = np.where(better, 0.1 * damping[active], 10.0 * damping[active] + 1e-4)
        done = (distance[active] < GRADIENT_TOLERANCE) & (damping[active] < 1e-2)
        active = active[~done & (damping[active] < 1e12)]

    covariance, determined = _covariance(state.observed, state.expected, scale)
    slope = theta[:, model.columns.shape[1] // 2]
    outcome = np.full(n_sets, Outcome.CONVERGED, dtype=object)
    outcome[slope <= 0.0] = Outcome.FALLING
    outcome[~(distance < GRADIENT_TOLERANCE)] = Outcome.ITERATION_LIMIT
    outcome[~determined] = Outcome.NO_INFORMATION
    failed = outcome != Outcome.CONVERGED
    theta[failed] = np.nan
    covariance[failed] = np.nan
    return Maximum(theta, covariance, state.log_likelihood, distance, iterations, outcome)


def grid_start(model: SelectionModel, test_count: Array, other_count: Array) -> Array:
    """(B, k) the most likely point of a coarse grid in L50, SR, delta and split, covariates at no effect."""
    n_by_haul = model.columns.shape[1] // 2
    z = model.columns[:, n_by_haul]
    reach = float(np.ptp(z)) or 1.0
    l50s = np.linspace(z.min() - 0.2 * reach, z.max() + 0.2 * reach, 13)
    srs = reach * np.array([0.05, 0.15, 0.45])
    log_deltas = np.array([-1.0, 0.0, 1.0]) if model.curve.has_shape else np.zeros(1)
    logit_splits = np.array([-1.0, 0.0, 1.0]) if model.estimate_split else np.zeros(1)
    l50, sr, log_delta, logit_split = np.array(list(product(l50s, srs, log_deltas, logit_splits))).T

    eta25, eta50, eta75 = (model.curve.eta_at(p, np.exp(log_delta))[0] for p in (0.25, 0.5, 0.75))
    beta = (eta75 - eta25) / sr
    theta = np.zeros((l50.size, model.n_parameters))
    theta[:, 0], theta[:, n_by_haul] = eta50 - beta * l50, beta
    if model.curve.has_shape:
        theta[:, 2 * n_by_haul] = log_delta
    if model.estimate_split:
        theta[:, -1] = logit_split
    zeta = log_odds(model, theta)
    likelihood = test_count @ log_expit(zeta.value).T + other_count @ log_expit(-zeta.value).T
    return theta[np.argmax(likelihood, axis=1)]


def _reference_information(model: SelectionModel, n: Array) -> Array:
    """(B, k) diagonal of the information if half of the fish at every length were retained: sum of n x^2 / 4."""
    linear = 0.25 * n @ model.columns**2
    others = np.repeat(0.25 * n.sum(axis=1, keepdims=True), model.n_parameters - linear.shape[1], axis=1)
    return np.hstack([linear, others])


def _damped_step(at: Evaluation, damping: Array, scale: Array) -> Array:
    root = np.sqrt(scale)
    outer = root[:, :, None] * root[:, None, :]
    concave = _least_eigenvalues(at.observed / outer) > LEAST_INFORMATION
    matrix = np.where(concave[:, None, None], at.observed, at.expected)
    diagonal = np.einsum("bii->bi", matrix)  # a view: writes go to the matrix
    diagonal *= 1.0 + damping[:, None]
    diagonal += 1e-14 * scale  # a separated data set loses all its information on the way
    return np.asarray(np.linalg.solve(matrix, at.gradient[..., None])[..., 0], dtype=float)


def _least_eigenvalues(matrices: Array) -> Array:
    """The least eigenvalue of each symmetric matrix, (b,); minus infinity where it holds what is no number."""
    finite = np.isfinite(matrices).all(axis=(1, 2))
    found = np.full(len(matrices), -np.inf)
    found[finite] = np.linalg.eigvalsh(matrices[finite])[:, 0]
    return found


def _covariance(observed: Array, expected: Array, scale: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Inverse of the observed information, and whether the information determines every parameter.

    The observed one tells how sharp the likelihood of these counts is (Efron and Hinkley 1978, Biometrika 65: 457).
    """
    root = np.sqrt(np.where(scale > 0.0, scale, 1.0))
    outer = root[:, :, None] * root[:, None, :]
    determined = _least_eigenvalues(expected / outer) > LEAST_INFORMATION
    scaled = observed / outer
    determined &= _least_eigenvalues(scaled) > LEAST_INFORMATION
    scaled[~determined] = np.eye(scaled.shape[1])
    covariance: Array = np.linalg.inv(scaled) / outer
    return covariance, determined
