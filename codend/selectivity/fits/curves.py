"""Retention curves r(L) = F(a + b L): logit, probit, Gompertz, complementary log-log and Richards.

Definitions of Wileman et al. (1996, ICES Cooperative Research Report 215, section 6.2), with eta = a + b L:

    logit     r = 1 / (1 + exp(-eta))                L50 = -a/b                          SR = 2 ln 3 / b
    probit    r = Phi(eta)                           L50 = -a/b                          SR = 2 Phi^-1(0.75) / b
    gompertz  r = exp(-exp(-eta))                    L50 = (-ln ln 2 - a) / b            SR = ln(ln 4 / ln(4/3)) / b
    cloglog   r = 1 - exp(-exp(eta))                 L50 = (ln ln 2 - a) / b             SR = ln(ln 4 / ln(4/3)) / b
    richards  r = (1 / (1 + exp(-eta)))^(1/delta)    L50 = (logit(0.5^delta) - a) / b    SR = L75 - L25

`delta` = 1 makes Richards the logit curve. Everything is written in ln r and ln(1 - r), which keep their relative
precision in both tails.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erfcx, expit, log_expit, log_ndtr, ndtri

Array = NDArray[np.float64]

# beyond this |eta| the asymptotic forms are exact to rounding and exp() would overflow
ETA_LIMIT: Final = 600.0


class LogProbability(NamedTuple):
    """A log-probability at eta and ln delta, with first and second derivatives; arrays of one shape."""

    value: Array
    eta: Array
    eta_eta: Array
    log_delta: Array = np.zeros(())
    eta_log_delta: Array = np.zeros(())
    log_delta_log_delta: Array = np.zeros(())


class LogRetention(NamedTuple):
    """ln r and ln(1 - r)."""

    retained: LogProbability
    escaped: LogProbability


@dataclass(frozen=True)
class Curve:
    """A retention curve F(eta; delta), eta = a + b L.

    Parameters of a fitted curve are an array (..., 2), or (..., 3) for a curve with a shape: a, b and delta.

    Attributes:
        name: the curve's name on the command line and in tables.
        has_shape: whether the curve has the third parameter delta > 0.
        log_parts: (eta, delta) -> `LogRetention`.
        eta_at: (retention p, delta) -> eta with F(eta) = p, and its derivative with respect to delta.
    """

    name: str
    has_shape: bool
    log_parts: Callable[[Array, Array], LogRetention]
    eta_at: Callable[[float, Array], tuple[Array, Array]]

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the curve's own parameters, in the order of its parameter arrays."""
        return ("a", "b", "delta") if self.has_shape else ("a", "b")

    def _split(self, parameters: ArrayLike) -> tuple[Array, Array, Array]:
        values = np.asarray(parameters, dtype=float)
        if values.shape[-1] != len(self.parameter_names):
            raise ValueError(f"{self.name} has parameters {self.parameter_names}, got {values.shape[-1]} numbers")
        delta = values[..., 2] if self.has_shape else np.ones_like(values[..., 0])
        return values[..., 0], values[..., 1], delta

    def retention(self, length_cm: ArrayLike, parameters: ArrayLike) -> Array:
        """Retention r(L), shape (..., n) for `parameters` (..., k) and `length_cm` (n,)."""
        a, b, delta = self._split(parameters)
        eta = a[..., None] + b[..., None] * np.asarray(length_cm, dtype=float)
        return np.exp(self.log_parts(eta, delta[..., None]).retained.value)

    def retention_gradient(self, length_cm: ArrayLike, parameters: ArrayLike) -> Array:
        """Exact dr/dparameters, shape (..., n, k)."""
        a, b, delta = self._split(parameters)
        length = np.asarray(length_cm, dtype=float)
        log_r = self.log_parts(a[..., None] + b[..., None] * length, delta[..., None]).retained
        r = np.exp(log_r.value)
        # where r underflows its logarithmic slope may overflow; their product tends to zero
        slope = np.where(r > 0.0, r * log_r.eta, 0.0)
        columns = [slope, slope * length]
        if self.has_shape:
            columns.append(np.where(r > 0.0, r * log_r.log_delta, 0.0) / delta[..., None])
        return np.stack(columns, axis=-1)

    def length_at(self, retention: float, parameters: ArrayLike) -> Array:
        """Length (cm) of the given retention, shape (...): the closed forms of the module's heading."""
        a, b, delta = self._split(parameters)
        return np.asarray((self.eta_at(retention, delta)[0] - a) / b)

    def l50_sr(self, parameters: ArrayLike) -> Array:
        """L50 and selection range SR = L75 - L25 (cm), shape (..., 2)."""
        a, b, delta = self._split(parameters)
        eta25, eta50, eta75 = (self.eta_at(p, delta)[0] for p in (0.25, 0.5, 0.75))
        return np.stack([(eta50 - a) / b, (eta75 - eta25) / b], axis=-1)

    def l50_sr_gradient(self, parameters: ArrayLike) -> Array:
        """Exact gradient of (L50, SR) with respect to the parameters, shape (..., 2, k); for the delta method."""
        _, b, delta = self._split(parameters)
        l50, sr = np.moveaxis(self.l50_sr(parameters), -1, 0)
        zero = np.zeros_like(b)
        rows = [[-1.0 / b, -l50 / b], [zero, -sr / b]]
        if self.has_shape:
            d25, d50, d75 = (self.eta_at(p, delta)[1] for p in (0.25, 0.5, 0.75))
            rows[0].append(d50 / b)
            rows[1].append((d75 - d25) / b)
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _logit_parts(eta: Array, delta: Array) -> LogRetention:
    r, escape = expit(eta), expit(-eta)
    bend = -r * escape
    return LogRetention(LogProbability(log_expit(eta), escape, bend), LogProbability(log_expit(-eta), -r, bend))


def _probit_parts(eta: Array, delta: Array) -> LogRetention:
    mills, mirror = _mills(eta), _mills(-eta)
    return LogRetention(
        LogProbability(log_ndtr(eta), mills, -mills * (mills + eta)),
        LogProbability(log_ndtr(-eta), -mirror, -mirror * (mirror - eta)),
    )


def _mills(eta: Array) -> Array:
    """Normal density over Phi(eta), the derivative of ln Phi, without cancellation for eta -> -infinity."""
    return np.sqrt(2.0 / np.pi) / erfcx(-eta / np.sqrt(2.0))


def _gompertz_parts(eta: Array, delta: Array) -> LogRetention:
    u = np.exp(-np.clip(eta, -ETA_LIMIT, ETA_LIMIT))
    escape = -np.expm1(-u)
    g = u * np.exp(-u) / escape  # u / (e^u - 1) without overflow
    log_escape = np.where(eta < ETA_LIMIT, np.log(escape), -eta)
    return LogRetention(LogProbability(-u, u, -u), LogProbability(log_escape, -g, g * (1.0 - g - u)))


def _cloglog_parts(eta: Array, delta: Array) -> LogRetention:
    retained, escaped = _gompertz_parts(-eta, delta)
    return LogRetention(escaped._replace(eta=-escaped.eta), retained._replace(eta=-retained.eta))


def _richards_parts(eta: Array, delta: Array) -> LogRetention:
    log_r, slope = log_expit(eta) / delta, expit(-eta) / delta
    # r / (1 - r) times the derivatives of ln r; for eta -> infinity, 1 - r -> exp(-eta) / delta, both tend to 1
    reachable = eta < ETA_LIMIT
    log_escape = np.where(reachable, np.log(-np.expm1(np.where(reachable, log_r, -1.0))), -eta - np.log(delta))
    odds = np.exp(np.where(reachable, log_r - log_escape, 0.0))
    p, t = np.where(reachable, odds * slope, 1.0), np.where(reachable, -odds * log_r, 1.0)
    return LogRetention(
        LogProbability(log_r, slope, -slope * expit(eta), -log_r, -slope, log_r),
        LogProbability(
            value=log_escape,
            eta=-p,
            eta_eta=p * (expit(eta) - p - slope),
            log_delta=-t,
            eta_log_delta=p * (1.0 - t + log_r),
            log_delta_log_delta=t * (1.0 - t + log_r),
        ),
    )


def _without_shape(quantile: Callable[[float], float]) -> Callable[[float, Array], tuple[Array, Array]]:
    return lambda p, delta: (np.full_like(delta, quantile(p)), np.zeros_like(delta))


def _richards_eta_at(p: float, delta: Array) -> tuple[Array, Array]:
    escaped_power = -np.expm1(delta * np.log(p))  # 1 - p^delta
    return delta * np.log(p) - np.log(escaped_power), np.log(p) / escaped_power


CURVES: Final = MappingProxyType(
    {
        curve.name: curve
        for curve in (
            Curve("logit", False, _logit_parts, _without_shape(lambda p: float(np.log(p / (1.0 - p))))),
            Curve("probit", False, _probit_parts, _without_shape(lambda p: float(ndtri(p)))),
            Curve("gompertz", False, _gompertz_parts, _without_shape(lambda p: float(-np.log(-np.log(p))))),
            Curve("cloglog", False, _cloglog_parts, _without_shape(lambda p: float(np.log(-np.log1p(-p))))),
            Curve("richards", True, _richards_parts, _richards_eta_at),
        )
    }
)
