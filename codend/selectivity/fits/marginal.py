"""The likelihood of hauls that differ, in one stage: counted fish given each haul's own curve, integrated over hauls.

In haul h the curve has L50 = x1' beta1 + sd1 v1, ln SR = x2' beta2 + sd2 v2 and the gear the split logit p =
x3' beta3 + sd3 v3, with independent standard normal v (those of `random` only), so that

    likelihood of haul h = integral of binomial(counts | v) N(v; 0, I) dv

by adaptive Gauss-Hermite quadrature (Pinheiro and Bates 1995, J. Comput. Graph. Stat. 4: 12-35): nodes lie about the
mode of the integrand, scaled by its curvature; one node is Laplace's approximation. The gradient is the mean of the
gradient of the integrand's logarithm over the nodes, and exact for nodes that stay where they are.

With standard deviations as they stand, and not their logarithms, the likelihood is even in them: no variation between
hauls is an ordinary maximum at 0, not one at infinity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.polynomial.hermite_e import hermegauss
from numpy.typing import NDArray
from scipy.special import expit, log_expit

from codend.selectivity.fits.families import Family

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

RANDOM_TERMS: Final = ("l50", "sr", "split")
NODES_A_TERM: Final = {1: 11, 2: 7, 3: 5}
MODE_STEPS: Final = 25
MODE_TOLERANCE: Final = 1e-8
LIMIT_LOG_SR: Final = 12.0
"""Bound on ln SR of a haul in a wild trial step, so that nothing overflows."""


@dataclass(frozen=True)
class MarginalModel:
    """Counts and predictors of R rows, sorted by haul, of H hauls.

    Attributes:
        family: the curve.
        design: "covered" or "paired".
        haul: (R,) number of the haul, rising from 0 to H - 1.
        length_cm, test, other, log_offset: (R,) as in `FieldData`.
        by_l50, by_log_sr: (R, q) predictors of L50 and ln SR.
        by_split: (R, q) predictors of the logit of the split; no columns where it is fixed.
        fixed_logit_split: its value where it is fixed.
        random: which of `RANDOM_TERMS` differ between hauls, in that order.
    """

    family: Family
    design: str
    haul: Ints
    length_cm: Array
    test: Array
    other: Array
    log_offset: Array
    by_l50: Array
    by_log_sr: Array
    by_split: Array
    fixed_logit_split: float
    random: tuple[str, ...]

    @property
    def first_row(self) -> Ints:
        """(H,) first row of each haul."""
        return np.flatnonzero(np.diff(self.haul, prepend=-1))

    @property
    def slices(self) -> dict[str, slice]:
        """Where in theta (k,) each part lies: l50, sr, shape, split, sd."""
        sizes = {
            "l50": self.by_l50.shape[1],
            "sr": self.by_log_sr.shape[1],
            "shape": len(self.family.shape_names),
            "split": self.by_split.shape[1],
            "sd": len(self.random),
        }
        ends = np.cumsum(list(sizes.values()))
        return {name: slice(int(end) - size, int(end)) for (name, size), end in zip(sizes.items(), ends, strict=True)}

    @property
    def n_parameters(self) -> int:
        """Number k of parameters."""
        return self.slices["sd"].stop


class Nodes(NamedTuple):
    """Where the integrand is taken: v (H, K, s) and logarithms of weights (H, K) that hold the normal density of v."""

    v: Array
    log_weight: Array


class Slopes(NamedTuple):
    """Log-odds of a fish being in the test gear (R, K), and derivatives by L50, ln SR, and the shape (m, R, K)."""

    value: Array
    l50: Array
    log_sr: Array
    shape: Array


def log_likelihood(model: MarginalModel, theta: Array, nodes: Nodes) -> tuple[float, Array]:
    """Marginal log-likelihood, without binomial coefficients, and its gradient (k,), for nodes that stay in place."""
    at, v = model.slices, nodes.v[model.haul]
    zeta = log_odds(model, theta, v)
    log_phi, log_rest = log_expit(zeta.value), log_expit(-zeta.value)
    by_row = model.test[:, None] * log_phi + model.other[:, None] * log_rest
    total = np.add.reduceat(by_row, model.first_row, axis=0) + nodes.log_weight
    top = total.max(axis=1, keepdims=True)
    share = np.exp(total - top)
    sums = share.sum(axis=1, keepdims=True)
    value = float((top + np.log(sums)).sum())

    # d/dzeta of each row's log-likelihood, weighted by its node's share of the haul's integral
    score = (model.test[:, None] - (model.test + model.other)[:, None] * np.exp(log_phi)) * (share / sums)[model.haul]
    by_term = {"l50": score * zeta.l50, "sr": score * zeta.log_sr, "split": score}
    gradient = np.empty(model.n_parameters)
    gradient[at["l50"]] = model.by_l50.T @ by_term["l50"].sum(axis=1)
    gradient[at["sr"]] = model.by_log_sr.T @ by_term["sr"].sum(axis=1)
    gradient[at["split"]] = model.by_split.T @ score.sum(axis=1)
    gradient[at["shape"]] = (score * zeta.shape).sum(axis=(1, 2))
    gradient[at["sd"]] = [(by_term[term] * v[:, :, i]).sum() for i, term in enumerate(model.random)]
    return value, gradient


def log_odds(model: MarginalModel, theta: Array, v: Array) -> Slopes:
    """Log-odds of the rows at haul deviations v (R, K, s)."""
    at = model.slices
    deviation = dict.fromkeys(RANDOM_TERMS, np.zeros(v.shape[:2]))
    for i, term in enumerate(model.random):
        deviation[term] = theta[at["sd"]][i] * v[:, :, i]
    shape = theta[at["shape"]]
    (q25, q50, q75), slopes = model.family.quartiles(shape)
    l50 = (model.by_l50 @ theta[at["l50"]])[:, None] + deviation["l50"]
    log_sr = (model.by_log_sr @ theta[at["sr"]])[:, None] + deviation["sr"]
    steepness = np.exp(-np.clip(log_sr, -LIMIT_LOG_SR, LIMIT_LOG_SR))
    scaled = (model.length_cm[:, None] - l50) * steepness
    parts = model.family.log_parts(q50 + (q75 - q25) * scaled, shape)
    value, by_eta, by_shape = parts.retained, parts.retained_eta, parts.retained_shape
    if model.design == "covered":
        value, by_eta = value - parts.escaped, by_eta - parts.escaped_eta
        by_shape = by_shape - parts.escaped_shape
    split = model.by_split @ theta[at["split"]] if model.by_split.shape[1] else model.fixed_logit_split
    fixed = model.log_offset + split if model.design == "paired" else model.log_offset
    if len(shape):
        by_eta_of_shape = slopes[1][:, None, None] + (slopes[2] - slopes[0])[:, None, None] * scaled
        by_shape = by_shape + by_eta * by_eta_of_shape
    return Slopes(
        value=value + fixed[:, None] + deviation["split"],
        l50=-(q75 - q25) * steepness * by_eta,
        log_sr=-(q75 - q25) * scaled * by_eta,
        shape=by_shape,
    )


def haul_modes(model: MarginalModel, theta: Array, start: Array) -> tuple[Array, Array]:
    """Most likely deviations v (H, s) of every haul, and the information about them (H, s, s).

    Fisher scoring from `start` (H, s), halved where the integrand would fall. The information is the expected one, 1 or
    more in every direction, for the normal density adds 1.
    """
    s, first = len(model.random), model.first_row
    v = start.copy()
    value, gradient, information = _haul_values(model, theta, v)
    if v.any():  # a start left over from a wild trial step may lie where the integrand is flat
        fresh = _haul_values(model, theta, np.zeros_like(v))
        better = fresh[0] > value
        if better.any():
            v = np.where(better[:, None], 0.0, v)
            value, gradient, information = _haul_values(model, theta, v)
    for _ in range(MODE_STEPS):
        step = np.linalg.solve(information, gradient[..., None])[..., 0]
        if np.abs(step).max(initial=0.0) < MODE_TOLERANCE:
            break
        tried = v + step
        new = _haul_values(model, theta, tried)
        better = new[0] >= value - 1e-12 * (1.0 + np.abs(value))
        for _ in range(MODE_STEPS):
            if better.all():
                break
            step = np.where(better[:, None], step, 0.5 * step)
            tried = v + step
            new = _haul_values(model, theta, tried)
            better = new[0] >= value - 1e-12 * (1.0 + np.abs(value))
        v = np.where(better[:, None], tried, v)
        value, gradient, information = _haul_values(model, theta, v) if not better.all() else new
    return v.reshape(first.size, s), information


def _haul_values(model: MarginalModel, theta: Array, v: Array) -> tuple[Array, Array, Array]:
    """Logarithm of each haul's integrand (H,), its gradient (H, s) and expected information (H, s, s) by v."""
    zeta = log_odds(model, theta, v[model.haul][:, None, :])
    log_phi, log_rest = log_expit(zeta.value[:, 0]), log_expit(-zeta.value[:, 0])
    n = model.test + model.other
    slopes = {"l50": zeta.l50[:, 0], "sr": zeta.log_sr[:, 0], "split": np.ones(n.size)}
    sd = theta[model.slices["sd"]]
    by_v = np.stack([sd[i] * slopes[term] for i, term in enumerate(model.random)], axis=1)
    residual = model.test - n * np.exp(log_phi)
    # the square root of the weight first: in the far tail the slope overflows where the weight vanishes
    weighted = (np.sqrt(n) * np.exp(0.5 * (log_phi + log_rest)))[:, None] * by_v
    sums = np.add.reduceat
    value = sums(model.test * log_phi + model.other * log_rest, model.first_row) - 0.5 * (v**2).sum(axis=1)
    gradient = sums(residual[:, None] * by_v, model.first_row, axis=0) - v
    information = sums(weighted[:, :, None] * weighted[:, None, :], model.first_row, axis=0)
    return value, gradient, information + np.eye(v.shape[1])


def place_nodes(model: MarginalModel, theta: Array, start: Array | None = None) -> tuple[Nodes, Array]:
    """Nodes about each haul's mode, and the modes (H, s); without random terms one node without weight."""
    n_hauls, s = model.first_row.size, len(model.random)
    if s == 0:
        return Nodes(np.zeros((n_hauls, 1, 0)), np.zeros((n_hauls, 1))), np.zeros((n_hauls, 0))
    modes, information = haul_modes(model, theta, np.zeros((n_hauls, s)) if start is None else start)
    points, weights = hermegauss(NODES_A_TERM[s])
    grid = np.stack(np.meshgrid(*[points] * s, indexing="ij"), axis=-1).reshape(-1, s)
    log_weights = np.log(np.stack(np.meshgrid(*[weights] * s, indexing="ij"), axis=-1).reshape(-1, s)).sum(axis=1)
    spread = np.linalg.inv(np.linalg.cholesky(information)).transpose(0, 2, 1)  # spread spread' = information^-1
    v = modes[:, None, :] + np.einsum("hij,kj->hki", spread, grid)
    # weights are those of exp(-x^2/2), which is taken out, and the normal density of v comes in
    log_weight = log_weights + 0.5 * (grid**2).sum(axis=1) + np.linalg.slogdet(spread)[1][:, None]
    return Nodes(v, log_weight - 0.5 * (v**2).sum(axis=2) - 0.5 * s * np.log(2.0 * np.pi)), modes


def expected_share(model: MarginalModel, theta: Array, v: Array) -> Array:
    """(R,) expected share of the fish counted that are in the test gear, at haul deviations v (H, s)."""
    return expit(log_odds(model, theta, v[model.haul][:, None, :]).value[:, 0])
