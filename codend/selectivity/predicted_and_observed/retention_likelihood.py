"""Likelihood of field data through the predicted retention; equations in ``calibrate``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, log_expit, xlogy

from catch_models.fish import PARAMETERS, Species
from codend.selectivity.escape.haul import Haul, shares_until, trying_of
from codend.selectivity.escape.retention import escape_terms, nodes_of
from codend.selectivity.escape.retention_kernels import Nodes, Trying
from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.fit import LEAST_EXPECTED, dispersion_factor

Floats = NDArray[np.float64]

BOUNDS: Final = {
    "behaviour.contact": (0.0, 1.0),
    "spread.size": (0.002, 0.5),
    "spread.shape": (0.0, 0.5),
    "behaviour.attempts": (0.5, 200.0),
    "behaviour.rotation_deg": (0.0, 45.0),
    "behaviour.push_force_n": (0.01, 200.0),
    "section.compression": (0.0, 0.5),
    "section.height_compression": (0.0, 0.5),
    "section.width_compression": (0.0, 0.5),
}
"""Numbers that can be calibrated, and the range in which they are looked for."""
LOGARITHMIC: Final = ("spread.size", "behaviour.attempts", "behaviour.push_force_n")
TOGETHER: Final = {"section.compression": ("section.height_compression", "section.width_compression")}
"""Names that stand for several numbers of a species, which are then the same."""
AT_BOUND: Final = 2e-3
"""Share of its range within which a number counts as at its bound."""
SPLIT: Final = "split"
SPLIT_BOUNDS: Final = (-6.0, 6.0)
"""Of the logit of the split."""
STARTS, MOST_ITERATIONS = 16, 100
"""Points at which a start is looked for, and iterations of the scoring."""
TOLERANCE, STEP = 1e-3, 1e-3
"""Distance to the maximum in standard errors at which scoring ends; step of the differences, a share of the range."""
LEAST_RETENTION: Final = 1e-12
LEAST_INFORMATION: Final = 1e-6
"""On a number, at which it counts as without effect: its standard error is a thousand times its range."""
MOST_SECANTS, SECANT_TOLERANCE = 30, 0.01
"""Steps of the search for an end of an interval, and the share of the wanted fall's root within which it ends."""


@dataclass(frozen=True)
class Maximum:
    """The likeliest x, and how it was reached."""

    x: Floats
    log_likelihood: float
    errors: Floats
    """Standard errors by the expected information; infinite where it has none."""
    converged: bool


@dataclass(frozen=True)
class End:
    """One end of an interval."""

    x: float
    limited: bool
    """Whether the likelihood sets it, and not the range."""
    trouble: str
    """Why it is not to be believed; empty when it is."""


@dataclass(frozen=True)
class Trialled:
    """A computed codend and hauls with it."""

    haul: Haul
    data: FieldData
    volume_m3: Floats | None = None
    """Final catch of every haul of the trial, (H,); None: every haul is the whole of ``haul``."""


@dataclass(frozen=True)
class _Rows:
    """A trial as the likelihood reads it, R rows."""

    trial: Trialled
    trying: Trying
    shares: Floats
    """Of the time for which each computed catch stands, (R, c)."""
    length_cm: Floats
    length: NDArray[np.intp]
    """Number of each row's length, (R,)."""

    @classmethod
    def of(cls, trial: Trialled, species: Species) -> _Rows:
        haul, data = trial.haul, trial.data
        final = np.full(len(data.haul_names), haul.volume_m3[-1]) if trial.volume_m3 is None else trial.volume_m3
        shares = np.array([shares_until(haul, species, volume) for volume in final])[data.haul]
        length_cm, length = np.unique(data.length_cm, return_inverse=True)
        return cls(trial, trying_of(haul, species), shares, length_cm, length)

    def zeta(self, values: Floats, nodes: Nodes, split: float) -> Floats:
        """Log-odds of the rows, (R,)."""
        haul, data = self.trial.haul, self.trial.data
        terms = escape_terms(haul.crowd, values, nodes, self.trying)
        of_catches = np.array([one.retention(self.length_cm) for one in terms])
        r = np.einsum("rc,cr->r", self.shares, of_catches[:, self.length])
        r = np.clip(r, LEAST_RETENTION, 1.0 - LEAST_RETENTION)
        if data.design == "covered":
            return np.asarray(np.log(r) - np.log1p(-r) + data.log_offset)
        return np.asarray(np.log(r) + np.log(split / (1.0 - split)) + data.log_offset)


class RetentionLikelihood:
    """Log-likelihood of numbers scaled to x in [0, 1], (k,), over trials with one codend or several."""

    def __init__(
        self, trials: Sequence[Trialled], species: Species, names: tuple[str, ...], estimate_split: bool
    ) -> None:
        """Arguments as those of ``codend.selectivity.predicted_and_observed.calibrate.calibrate``, the names dotted."""
        self.trials = [_Rows.of(one, species) for one in trials]
        self.given, self.nodes = species.values, nodes_of()
        self.columns = [[PARAMETERS.index(one) for one in TOGETHER.get(name, (name,))] for name in names]
        self.names = (*names, SPLIT) if estimate_split else names
        ends = [BOUNDS[name] for name in names] + [SPLIT_BOUNDS] * estimate_split
        self.log = np.array([name in LOGARITHMIC for name in self.names])
        self.low, self.high = np.array(
            [tuple(np.log(e)) if log else e for e, log in zip(ends, self.log, strict=True)]
        ).T
        self.test = np.concatenate([one.data.test_count for one in trials])
        self.other = np.concatenate([one.data.other_count for one in trials])
        self.fish = self.test + self.other

    def natural(self, x: Floats) -> Floats:
        """Numbers as the species file and the fit have them."""
        at = self.low + x * (self.high - self.low)
        if self.names[-1] == SPLIT:
            at[-1] = expit(at[-1])
        return np.where(self.log, np.exp(np.where(self.log, at, 0.0)), at)

    def zeta(self, x: Floats) -> Floats:
        """Log-odds of every row, (R,)."""
        values, numbers = self.given.copy(), self.natural(x)
        for columns, number in zip(self.columns, numbers, strict=False):
            values[columns] = number
        split = float(numbers[-1]) if self.names[-1] == SPLIT else 0.5
        return np.concatenate([one.zeta(values, self.nodes, split) for one in self.trials])

    def value(self, zeta: Floats) -> float:
        """Log-likelihood without the binomial coefficients."""
        return float(self.test @ log_expit(zeta) + self.other @ log_expit(-zeta))

    def start(self) -> Floats:
        """The most likely of the species' own values and points spread over the range."""
        from scipy.stats import qmc

        own = np.array([self.given[columns].mean() for columns in self.columns])
        log = self.log[: len(own)]
        own = np.where(log, np.log(np.maximum(own, 1e-9)), own)
        own = (own - self.low[: len(own)]) / (self.high - self.low)[: len(own)]
        own = np.append(own, [0.5] * (self.names[-1] == SPLIT))
        spread = qmc.Sobol(len(self.names), rng=np.random.default_rng(0)).random(STARTS)
        points = np.vstack([np.clip(own, 0.01, 0.99), spread])
        return np.asarray(points[int(np.argmax([self.value(self.zeta(x)) for x in points]))])

    def maximise(self, x: Floats, free: NDArray[np.bool_]) -> Maximum:
        """Fisher scoring over the free numbers, within [0, 1]; a number at an end that pushes outwards rests there."""
        zeta = self.zeta(x)
        value, damping, errors = self.value(zeta), 1e-3, np.full(len(x), np.inf)
        for _ in range(MOST_ITERATIONS):
            slopes = self._slopes(x, free)
            phi = expit(zeta)
            gradient = slopes.T @ (self.test - self.fish * phi)
            information = slopes.T @ (slopes * (self.fish * phi * (1.0 - phi))[:, None])
            moving = free & ~((x <= 0.0) & (gradient <= 0.0)) & ~((x >= 1.0) & (gradient >= 0.0))
            which = np.flatnonzero(moving & (np.diag(information) > LEAST_INFORMATION))
            inner = information[np.ix_(which, which)]
            inner += 1e-12 * np.diag(np.diag(inner))
            full = np.linalg.inv(inner) if which.size else inner
            errors[which] = np.sqrt(np.maximum(np.diag(full), 0.0))
            step = np.zeros(len(x))
            step[which] = np.linalg.solve(inner + damping * np.diag(np.diag(inner)), gradient[which])
            trial = np.clip(x + step, 0.0, 1.0)
            promised = float((trial - x) @ gradient)
            if promised < TOLERANCE**2:
                return Maximum(x, value, errors, converged=True)
            tried = self.zeta(trial)
            gain = self.value(tried) - value
            # a parabola gives half of it; the expected information may be too small: steps with less are shortened
            damping = 0.2 * damping if gain > 0.35 * promised else 4.0 * damping + 0.1
            if gain >= 0.0:
                x, zeta, value = trial, tried, value + gain
        return Maximum(x, value, errors, converged=False)

    def _slopes(self, x: Floats, free: NDArray[np.bool_]) -> Floats:
        slopes = np.zeros((len(self.fish), len(x)))
        for i in np.flatnonzero(free):
            left, right = x.copy(), x.copy()
            left[i], right[i] = max(x[i] - STEP, 0.0), min(x[i] + STEP, 1.0)
            slopes[:, i] = (self.zeta(right) - self.zeta(left)) / (right[i] - left[i])
        return slopes

    def end(self, best: Maximum, i: int, side: int, critical: float) -> End:
        """Lower (0) or upper (1) end of the interval of number i, where twice the likelihood fell by ``critical``.

        The root of the fall is nearly straight in x, so that the secant method finds it in a few steps.
        """
        bound, free, target = float(side), np.arange(len(best.x)) != i, np.sqrt(critical)
        troubles = []

        def root_of_fall(at: float, start: Floats) -> tuple[float, Floats]:
            x = start.copy()
            x[i] = at
            found = self.maximise(x, free)
            fall = 2.0 * (best.log_likelihood - found.log_likelihood)
            if not found.converged:
                troubles.append("the likelihood has no maximum on the way to the ends of the intervals")
            if fall < -0.01:
                troubles.append("the likelihood has another, higher maximum")
            return float(np.sqrt(max(fall, 0.0))), found.x

        if best.x[i] == bound:
            return End(bound, False, "")
        far = bound
        root_far, _ = root_of_fall(bound, best.x)
        if root_far < target:
            return End(bound, False, "".join(troubles[:1]))
        near, root_near, start = best.x[i], 0.0, best.x
        width = min(target * best.errors[i], 0.5 * abs(bound - near))  # that of a parabola
        tried = near + (width if side else -width)
        for _ in range(MOST_SECANTS):
            root, start = root_of_fall(tried, start)
            if abs(root - target) < SECANT_TOLERANCE * target:
                return End(float(tried), True, "".join(troubles[:1]))
            if root < target:
                near, root_near = tried, root
            else:
                far, root_far = tried, root
            share = (target - root_near) / max(root_far - root_near, 1e-12)
            tried = near + float(np.clip(share, 0.05, 0.95)) * (far - near)
        return End(float(tried), True, "the ends of the intervals were not found")

    def lack_of_fit(self, x: Floats) -> tuple[float, int, float]:
        """Deviance, its degrees of freedom and the dispersion factor."""
        zeta, test, other, n = self.zeta(x), self.test, self.other, self.fish
        fished = n > 0.0
        test, other, n, zeta = test[fished], other[fished], n[fished], zeta[fished]
        deviance = 2.0 * (xlogy(test, test / n) + xlogy(other, other / n)).sum()
        deviance -= 2.0 * (test @ log_expit(zeta) + other @ log_expit(-zeta))
        phi = expit(zeta)
        full = (n * phi > LEAST_EXPECTED) & (n * (1.0 - phi) > LEAST_EXPECTED)
        squares = (test - n * phi)[full] ** 2 / (n * phi * (1.0 - phi))[full]
        return float(deviance), len(n) - len(x), dispersion_factor(squares, len(x))
