"""The maximum of a marginal likelihood: a bounded quasi-Newton search, then Newton steps by observed information."""

from __future__ import annotations

from enum import Enum
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.selectivity.fits.marginal import MarginalModel, Nodes, log_likelihood, place_nodes

Array = NDArray[np.float64]

SEARCH_TOLERANCE: Final = 1e-5  # of the log-likelihood
DISTANCE_TOLERANCE: Final = 1e-4  # of a maximum, in standard errors
NEWTON_STEPS: Final = 12
SD_DIFFERENCE: Final = 0.1  # of a standard deviation, in its standard errors
DIFFERENCE: Final = 1e-5  # of the gradient, in units of `_scale`
MANY_FISH: Final = 1e6  # from which on the search is of the likelihood of so many: its steps fail at huge slopes
MOST_FISH: Final = 1e8
MOST_ERROR: Final = 3.0  # of L50 in reaches of the lengths and of ln SR: a plateau without an end is flat to rounding
LEAST_CURVATURE: Final = 1e-7  # of the information, its diagonal scaled to 1
STARTS_OF_SD: Final = {"l50": 0.4, "sr": 0.2, "split": 0.3}  # in units of SR for L50, as they are for the others
RETRIES: Final = (1.0, 0.3, 2.5)  # times the start of the standard deviations, until a maximum is found
LEAST_SD: Final = 0.05  # in the search, in units of `_scale`: at 0 every slope by it is 0, were it a maximum or not


class MarginalOutcome(Enum):
    """How the search ended; the value is the sentence for the user."""

    CONVERGED = "converged"
    NO_MAXIMUM = (
        "the likelihood has no maximum at a curve within the lengths measured: the counts do not tell its parameters "
        "(L50, SR, shape, an estimated split) apart; try a fixed split, a curve with fewer parameters, or fewer terms"
    )
    TOO_MANY = (
        f"more than {MOST_FISH:g} fish are counted, beside which what tells of differences between hauls is lost to "
        "round-off; of raised numbers give the count, and the factor in a column _raising, or ask for --random none"
    )
    NO_SELECTION = "the fish of all hauls together tell of no selection"


class MarginalMaximum(NamedTuple):
    """The fit; numbers are NaN where it has none.

    Attributes:
        theta: (k,) parameters of `MarginalModel`, standard deviations 0 or more and corrected (see `_corrected`).
        covariance: (k, k) inverse of the observed information, at the corrected standard deviations.
        covariance_by_sd: (s, k, k) its derivatives by the standard deviations.
        log_likelihood: at its maximum, without the binomial coefficients.
        modes: (H, s) predicted deviations of the hauls, in standard deviations.
        distance: sqrt(g' I^-1 g), from the maximum, in standard errors.
        outcome: whether it is one.
    """

    theta: Array
    covariance: Array
    covariance_by_sd: Array
    log_likelihood: float
    modes: Array
    distance: float
    outcome: MarginalOutcome


def maximise_marginal(model: MarginalModel, start: Array, *, again: bool = True) -> MarginalMaximum:
    """The most likely of the maxima found from `start` (k,) with each of the family's starts of the shape.

    With `again`, from other standard deviations where the first find none.
    """
    found, at = [], model.slices
    for shape in model.family.shape_starts:
        for factor in RETRIES if model.random and again else RETRIES[:1]:
            begin = start.copy()
            begin[at["shape"]], begin[at["sd"]] = shape, factor * start[at["sd"]]
            found.append(_maximum(model, begin))
            if found[-1].outcome is MarginalOutcome.CONVERGED:
                break
    best = max(found, key=lambda one: -np.inf if np.isnan(one.log_likelihood) else one.log_likelihood)
    too_many = bool(model.random) and model.test.sum() + model.other.sum() > MOST_FISH
    return refused(best, MarginalOutcome.TOO_MANY) if too_many else best


def refused(found: MarginalMaximum, why: MarginalOutcome = MarginalOutcome.NO_SELECTION) -> MarginalMaximum:
    """The maximum without its numbers, as where the fish of all hauls together tell of no selection."""
    nothing = {name: getattr(found, name) * np.nan for name in ("theta", "covariance", "covariance_by_sd", "modes")}
    return found._replace(**nothing, log_likelihood=np.nan, outcome=why)


def starting_point(model: MarginalModel, l50_cm: float, sr_cm: float, logit_split: float) -> Array:
    """(k,) parameters of one curve for all hauls, and of hauls that differ a little."""
    theta, at = np.zeros(model.n_parameters), model.slices
    theta[at["l50"]][:1], theta[at["sr"]][:1] = l50_cm, np.log(sr_cm)
    theta[at["split"]][:1] = logit_split
    theta[at["sd"]] = [STARTS_OF_SD[term] * (sr_cm if term == "l50" else 1.0) for term in model.random]
    return theta


def _maximum(model: MarginalModel, start: Array) -> MarginalMaximum:
    from scipy.optimize import Bounds, minimize

    scale, bounds = _scale(model), _bounds(model)
    many = max(1.0, float(model.test.sum() + model.other.sum()) / MANY_FISH)
    modes = np.zeros((model.first_row.size, len(model.random)))

    def objective(scaled: Array) -> tuple[float, Array]:
        nonlocal modes
        theta = scaled * scale
        nodes, modes = place_nodes(model, theta, modes)
        value, gradient = log_likelihood(model, theta, nodes)
        return -value / many, -gradient * scale / many

    with np.errstate(all="ignore"):
        begin = np.clip(start, bounds[:, 0], bounds[:, 1]) / scale
        result = minimize(
            objective,
            begin,
            jac=True,
            method="SLSQP",
            bounds=Bounds(*(bounds / scale[:, None]).T),
            options={"ftol": SEARCH_TOLERANCE, "maxiter": 150},
        )
        theta = result.x * scale
        theta, covariance, distance, nodes, modes = _polished(model, theta, modes, scale)
        errors = np.sqrt(np.diagonal(covariance))[[model.slices["l50"].start, model.slices["sr"].start]]
        determined = bool((errors < MOST_ERROR * np.array([np.ptp(model.length_cm), 1.0])).all())
        inside = determined and bool(
            ((theta > bounds[:, 0]) & (theta < bounds[:, 1]))[: model.slices["sd"].start].all()
        )
        value = log_likelihood(model, theta, nodes)[0]
    if not (inside and distance < DISTANCE_TOLERANCE and np.isfinite(value)):
        k = theta.size
        none = np.full((k, k), np.nan)
        by_sd = np.full((len(model.random), k, k), np.nan)
        return MarginalMaximum(none[0], none, by_sd, np.nan, modes * np.nan, distance, MarginalOutcome.NO_MAXIMUM)
    sd = model.slices["sd"]
    sign = np.ones(theta.size)
    sign[sd] = np.where(theta[sd] < 0.0, -1.0, 1.0)
    theta, covariance, modes = theta * sign, covariance * sign[:, None] * sign, modes * sign[sd]
    with np.errstate(all="ignore"):
        theta, covariance, by_sd = _corrected(model, theta, covariance, modes, scale)
    return MarginalMaximum(theta, covariance, by_sd, value, modes, distance, MarginalOutcome.CONVERGED)


def _corrected(
    model: MarginalModel, theta: Array, covariance: Array, modes: Array, scale: Array
) -> tuple[Array, Array, Array]:
    """Standard deviations without the bias of maximum likelihood, the covariance there, and its derivatives by them.

    One Newton step of the profile likelihood adjusted for the p other parameters, l - ln|I_pp| / 2 (Cox and Reid 1987,
    J. R. Stat. Soc. B 49: 1-39): what REML is to least squares. With H units and errors that are small it is
    multiplication by 1 + 1 / 2H. A standard deviation of 0 stays.
    """
    sd, s = model.slices["sd"], len(model.random)
    p, by_sd, log_det = sd.start, np.zeros((s, theta.size, theta.size)), np.zeros(s)
    for i in range(s):
        step = np.zeros(theta.size)
        step[p + i] = SD_DIFFERENCE * np.sqrt(covariance[p + i, p + i])
        sides = []
        for moved in (theta + step, theta - step):
            nodes, _ = place_nodes(model, moved, modes)
            sides.append(np.linalg.inv(observed_information(model, moved, nodes, scale)[:p, :p]))
        by_sd[i, :p, :p] = (sides[0] - sides[1]) / (2.0 * step[p + i])
        log_det[i] = (np.linalg.slogdet(sides[0])[1] - np.linalg.slogdet(sides[1])[1]) / (2.0 * step[p + i])
    change = 0.5 * covariance[sd, sd] @ log_det
    change = np.clip(change, -theta[sd], theta[sd])
    moved, widened = theta.copy(), covariance + np.tensordot(change, by_sd, axes=1)
    moved[sd] += change
    if not (np.isfinite(widened).all() and np.linalg.eigvalsh(widened)[0] > 0.0):
        return theta, covariance, np.zeros_like(by_sd)
    return moved, widened, by_sd


def _polished(
    model: MarginalModel, theta: Array, modes: Array, scale: Array
) -> tuple[Array, Array, float, Nodes, Array]:
    """Newton steps, nodes placed anew for each; the covariance, and the distance that the last step found."""
    distance, covariance = np.inf, np.full((theta.size, theta.size), np.nan)
    nodes, modes = place_nodes(model, theta, modes)
    for _ in range(NEWTON_STEPS):
        _, gradient = log_likelihood(model, theta, nodes)
        information = observed_information(model, theta, nodes, scale)
        root = np.sqrt(np.abs(np.diagonal(information)))
        with np.errstate(all="ignore"):
            scaled = information / (root[:, None] * root)
        if not np.isfinite(scaled).all() or np.linalg.eigvalsh(scaled)[0] < LEAST_CURVATURE:
            return theta, covariance, np.inf, nodes, modes
        covariance = np.linalg.inv(scaled) / (root[:, None] * root)
        step = covariance @ gradient
        distance = float(np.sqrt(max(step @ gradient, 0.0)))
        if distance < DISTANCE_TOLERANCE:
            break
        theta = theta + step / max(1.0, distance)
        nodes, modes = place_nodes(model, theta, modes)
    return theta, covariance, distance, nodes, modes


def observed_information(model: MarginalModel, theta: Array, nodes: Nodes, scale: Array) -> Array:
    """(k, k) minus the second derivatives, by central differences of the exact gradient at nodes that stay in place."""
    rows = []
    for i, unit in enumerate(scale):
        step = np.zeros(theta.size)
        step[i] = DIFFERENCE * unit
        up, down = log_likelihood(model, theta + step, nodes)[1], log_likelihood(model, theta - step, nodes)[1]
        rows.append((down - up) / (2.0 * step[i]))
    information = np.array(rows)
    return 0.5 * (information + information.T)


def _scale(model: MarginalModel) -> Array:
    """(k,) steps that are small for each parameter: a twentieth of the lengths for L50, a few tenths for the others."""
    at, scale = model.slices, np.full(model.n_parameters, 0.2)
    reach = float(np.ptp(model.length_cm)) or 1.0
    scale[at["l50"]] = 0.05 * reach
    for i, term in enumerate(model.random):
        scale[at["sd"]][i : i + 1] = 0.05 * reach if term == "l50" else 0.2
    return scale


def _bounds(model: MarginalModel) -> Array:
    """(k, 2) beyond which a curve is none: L50 further outside the lengths than they reach, SR far below a class."""
    at, bounds = model.slices, np.tile([-20.0, 20.0], (model.n_parameters, 1))
    lowest, highest = float(model.length_cm.min()), float(model.length_cm.max())
    reach = (highest - lowest) or 1.0
    bounds[at["l50"]] = -5.0 * reach, 5.0 * reach
    bounds[at["l50"]][0] = lowest - reach, highest + reach
    bounds[at["sr"]][0] = np.log(reach) - 7.0, np.log(reach) + 2.0
    bounds[at["shape"]] = -6.0, 6.0
    bounds[at["split"]] = -10.0, 10.0
    bounds[at["sd"], 0] = LEAST_SD * _scale(model)[at["sd"]]
    for i, term in enumerate(model.random):
        bounds[at["sd"].start + i, 1] = 2.0 * reach if term == "l50" else 10.0
    return bounds
