"""Retention curves by their L50 and SR, for models in which L50 and SR depend on gears, covariates and hauls.

A family is F(eta; shape), with quantiles q25, q50, q75 of eta at which F is 0.25, 0.5, 0.75; the curve is

    r(L) = F(q50 + (q75 - q25) (L - L50) / SR; shape),

so that L50 and SR mean the same in every family. Families are the curves of `codend.selectivity.fits.curves` (Richards
with shape ln delta) and the double logistic of two processes in one codend (Herrmann et al. 2016, Fish. Res. 180):

    dual      F = C / (1 + exp(-eta)) + (1 - C) / (1 + exp(-(eta - d) / w)),  shape logit C, ln d, ln w.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, log_expit, logit

from codend.selectivity.fits.curves import CURVES, Curve

Array = NDArray[np.float64]
QUARTILES: Final = (0.25, 0.5, 0.75)
QUANTILE_STEPS, QUANTILE_TOLERANCE = 200, 1e-13


class LogParts(NamedTuple):
    """ln r and ln(1 - r) at eta, with their derivatives by eta (same shape) and by the shape (m, ...)."""

    retained: Array
    escaped: Array
    retained_eta: Array
    escaped_eta: Array
    retained_shape: Array
    escaped_shape: Array


@dataclass(frozen=True)
class Family:
    """A family of retention curves.

    Attributes:
        name: as on the command line and in tables.
        shape_names: of the m internal shape parameters.
        shape_starts: values to start a search from, each (m,).
        log_parts: (eta, shape (m,)) -> `LogParts`.
        quartiles: shape (m,) -> (3,) eta of `QUARTILES` and (3, m) their derivatives by the shape.
    """

    name: str
    shape_names: tuple[str, ...]
    shape_starts: tuple[tuple[float, ...], ...]
    log_parts: Callable[[Array, Array], LogParts]
    quartiles: Callable[[Array], tuple[Array, Array]]

    def retention(self, length_cm: Array, l50_cm: Array, sr_cm: Array, shape: Array) -> Array:
        """Retention at lengths that broadcast against L50 and SR."""
        q25, q50, q75 = self.quartiles(shape)[0]
        return np.exp(self.log_parts(q50 + (q75 - q25) * (length_cm - l50_cm) / sr_cm, shape).retained)


def _family_of(curve: Curve) -> Family:
    def log_parts(eta: Array, shape: Array) -> LogParts:
        delta = np.exp(shape[0]) if curve.has_shape else np.float64(1.0)
        retained, escaped = curve.log_parts(eta, np.asarray(delta))
        none = np.empty((0, *eta.shape))
        by_shape = (retained.log_delta[None], escaped.log_delta[None]) if curve.has_shape else (none, none)
        return LogParts(retained.value, escaped.value, retained.eta, escaped.eta, *by_shape)

    def quartiles(shape: Array) -> tuple[Array, Array]:
        delta = np.exp(shape[0]) if curve.has_shape else np.float64(1.0)
        found = [curve.eta_at(p, np.asarray(delta)) for p in QUARTILES]
        slopes = np.array([[slope * delta] for _, slope in found]) if curve.has_shape else np.empty((3, 0))
        return np.array([float(value) for value, _ in found]), slopes

    names = ("ln delta",) if curve.has_shape else ()
    starts = ((-0.7,), (0.7,)) if curve.has_shape else ((),)
    return Family(curve.name, names, starts, log_parts, quartiles)


def _dual_parts(eta: Array, shape: Array) -> LogParts:
    first, (d, w) = shape[0], np.exp(shape[1:])
    second_eta = (eta - d) / w
    share, rest = log_expit(first), log_expit(-first)
    sides = []
    for sign in (1.0, -1.0):  # ln r is the sum of the two processes at eta, ln(1 - r) the same at -eta
        one, two = share + log_expit(sign * eta), rest + log_expit(sign * second_eta)
        value = np.logaddexp(one, two)
        weight, other = np.exp(one - value), np.exp(two - value)
        slope_1 = sign * weight * expit(-sign * eta)
        slope_2 = sign * other * expit(-sign * second_eta) / w
        by_shape = [weight * expit(-first) - other * expit(first), -d * slope_2, -w * second_eta * slope_2]
        sides.append((value, slope_1 + slope_2, np.stack(by_shape)))
    (retained, retained_eta, retained_shape), (escaped, escaped_eta, escaped_shape) = sides
    return LogParts(retained, escaped, retained_eta, escaped_eta, retained_shape, escaped_shape)


def _dual_quartiles(shape: Array) -> tuple[Array, Array]:
    return _dual_quartiles_of(tuple(map(float, shape)))


@lru_cache(maxsize=256)  # asked for at the same shape for every step towards the modes of hauls
def _dual_quartiles_of(numbers: tuple[float, ...]) -> tuple[Array, Array]:
    shape, p = np.array(numbers), np.array(QUARTILES)
    d, w = np.exp(shape[1:])
    ends = np.stack([logit(p), d + w * logit(p)])  # the quantiles of the two processes, between which F's lies
    lower, upper = ends.min(axis=0), ends.max(axis=0)
    eta = 0.5 * (lower + upper)
    for _ in range(QUANTILE_STEPS):
        parts = _dual_parts(eta, shape)
        excess = parts.retained - np.log(p)
        lower, upper = np.where(excess < 0.0, eta, lower), np.where(excess > 0.0, eta, upper)
        step = eta - excess / parts.retained_eta
        new = np.where((step > lower) & (step < upper), step, 0.5 * (lower + upper))
        if np.abs(new - eta).max() < QUANTILE_TOLERANCE:
            break
        eta = new
    return eta, -(parts.retained_shape / parts.retained_eta).T


DUAL: Final = Family(
    "dual",
    ("logit C", "ln d", "ln w"),
    ((0.0, 1.0, 0.0), (0.8, 1.5, 0.7), (-0.8, 1.0, -0.7)),
    _dual_parts,
    _dual_quartiles,
)
FAMILIES: Final = MappingProxyType({family.name: family for family in (*map(_family_of, CURVES.values()), DUAL)})
