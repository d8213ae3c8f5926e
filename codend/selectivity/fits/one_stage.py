"""One-stage fits: all hauls in one likelihood, hauls that differ, and L50, SR and split that depend on what is known.

The likelihood is that of `codend.selectivity.fits.marginal`: no haul is left out for having too few fish for a curve of
its own, and the mean is that of the hauls' L50, which for hauls that differ is not the L50 of the pooled fish.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import expit, gammaln, logit, stdtrit

from codend.selectivity.fits.families import FAMILIES
from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.fit import LEAST_DEGREES, LEAST_EXPECTED
from codend.selectivity.fits.marginal import (
    RANDOM_TERMS,
    MarginalModel,
    expected_share,
)
from codend.selectivity.fits.marginal_maximum import (
    MarginalMaximum,
    MarginalOutcome,
    maximise_marginal,
    starting_point,
)
from codend.selectivity.fits.model import selection_model, without_covariates
from codend.selectivity.fits.predictors import Predictor, averaged
from codend.selectivity.fits.scoring import grid_start

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

NORMAL: Final = 1.959963984540054  # 97.5 % quantile of the normal distribution
LARGEST_DEGREES: Final = 1e6
"""Of freedom, where a standard deviation is 0 and its error plays no part."""
SD_NAMES: Final = {"l50": "between_sd_l50_cm", "sr": "between_sd_log_sr", "split": "between_sd_logit_split"}


class Point(NamedTuple):
    """Predictors of one gear at given covariates: x' (q,) for L50, ln SR and logit split."""

    l50: Array
    log_sr: Array
    split: Array


@dataclass(frozen=True)
class OneStage:
    """A one-stage fit; every number is NaN when `converged` is False.

    Attributes:
        data: the counted fish.
        hauls: a row a haul, with the columns that formulas may use.
        l50, log_sr: predictors of L50 and ln SR.
        split: of the split's logit; None where it is fixed or the design has none.
        units: (H,) of every haul the unit that differs at random: itself, or what `random` names.
        unit_names: the U units, in the order of the model.
        model: the likelihood, rows sorted by unit.
        order: (R,) rows of `data` in the order of the model.
        maximum: the fit.
        group: column whose levels are gears; "" for one gear.
        degrees: of freedom of the variation between units: their number less the coefficients of L50; infinite without
            random terms.
    """

    data: FieldData
    hauls: pd.DataFrame
    l50: Predictor
    log_sr: Predictor
    split: Predictor | None
    units: tuple[str, ...]
    unit_names: tuple[str, ...]
    model: MarginalModel
    order: NDArray[np.int64]
    maximum: MarginalMaximum
    group: str
    degrees: float

    @property
    def converged(self) -> bool:
        """Whether the estimates are a maximum of the likelihood."""
        return self.maximum.outcome is MarginalOutcome.CONVERGED

    @property
    def fixed_split(self) -> float:
        """The split where it is not estimated."""
        return float(expit(self.model.fixed_logit_split))

    @property
    def theta(self) -> Array:
        """(k,) internal parameters."""
        return self.maximum.theta

    @property
    def log_likelihood(self) -> float:
        """Marginal, with the binomial coefficients."""
        test, n = self.model.test, self.model.test + self.model.other
        return self.maximum.log_likelihood + float((gammaln(n + 1) - gammaln(test + 1) - gammaln(n - test + 1)).sum())

    @property
    def quantile(self) -> float:
        """Student's t of 95 % intervals on `degrees`; normal without random terms."""
        return NORMAL if np.isinf(self.degrees) else float(stdtrit(self.degrees, 0.975))

    def quantiles(self, slopes: Array) -> Array:
        """(m,) Student's t of 95 % intervals of functions with derivatives (m, k) by theta.

        Satterthwaite's degrees of freedom, 2 V^2 / var V for the variance V of a function, var V from the errors of the
        standard deviations between units; no fewer than `degrees`.
        """
        if np.isinf(self.degrees):
            return np.full(len(slopes), NORMAL)
        sd, found = self.model.slices["sd"], self.maximum
        variance = np.einsum("mi,ij,mj->m", slopes, found.covariance, slopes)
        by_sd = np.einsum("mi,sij,mj->ms", slopes, found.covariance_by_sd, slopes)
        of_variance = np.einsum("ms,st,mt->m", by_sd, found.covariance[sd, sd], by_sd)
        with np.errstate(divide="ignore", invalid="ignore"):
            degrees = np.nan_to_num(2.0 * variance**2 / of_variance, nan=np.inf)
        return np.asarray(stdtrit(np.clip(degrees, self.degrees, LARGEST_DEGREES), 0.975))

    @property
    def aic(self) -> float:
        """2 k - 2 log-likelihood, standard deviations between hauls among the k."""
        return 2.0 * self.model.n_parameters - 2.0 * self.log_likelihood

    @property
    def levels(self) -> tuple[str, ...]:
        """Gears, in order of appearance; one empty name without a group."""
        return tuple(dict.fromkeys(self.hauls[self.group])) if self.group else ("",)

    def point(self, level: str = "", at: Mapping[str, str | float] | None = None) -> Point:
        """Predictors of a gear with some covariates set, averaged over all hauls for those that are not."""
        values = dict(at or {}) | ({self.group: level} if level else {})
        none = np.empty(0)
        return Point(
            averaged(self.l50, self.hauls, values),
            averaged(self.log_sr, self.hauls, values),
            averaged(self.split, self.hauls, values) if self.split else none,
        )

    def curve_at(self, point: Point, theta: Array) -> tuple[float, float, float]:
        """L50, SR (cm) and split of a haul that deviates in nothing."""
        at = self.model.slices
        logit_split = float(point.split @ theta[at["split"]]) if self.split else self.model.fixed_logit_split
        return (
            float(point.l50 @ theta[at["l50"]]),
            float(np.exp(point.log_sr @ theta[at["sr"]])),
            float(expit(logit_split)),
        )

    def retention_at(self, point: Point, length_cm: ArrayLike, theta: Array) -> Array:
        """(n,) retention of a haul that deviates in nothing."""
        l50, sr, _ = self.curve_at(point, theta)
        shape = theta[self.model.slices["shape"]]
        return self.model.family.retention(np.asarray(length_cm, dtype=float), np.array(l50), np.array(sr), shape)

    def deviations(self) -> dict[str, Array]:
        """Predicted deviation (s,) of every unit: the mode, which is drawn towards 0 the less its fish say."""
        sd = self.theta[self.model.slices["sd"]]
        return {name: sd * mode for name, mode in zip(self.unit_names, self.maximum.modes, strict=True)}

    def haul_curve(self, haul: int, deviation: Array) -> tuple[float, float]:
        """L50 and SR (cm) of a haul of the table whose unit has a deviation."""
        at, moved = self.model.slices, dict(zip(self.model.random, deviation, strict=True))
        l50 = float(self.l50.columns[haul] @ self.theta[at["l50"]]) + float(moved.get("l50", 0.0))
        log_sr = float(self.log_sr.columns[haul] @ self.theta[at["sr"]]) + float(moved.get("sr", 0.0))
        return l50, float(np.exp(log_sr))

    def haul_l50_sr(self) -> Array:
        """(H, 2) predicted L50 and SR of every haul; NaN for one without fish."""
        known, nothing = self.deviations(), (np.nan, np.nan)
        return np.array(
            [self.haul_curve(h, known[unit]) if unit in known else nothing for h, unit in enumerate(self.units)]
        )


def fit_one_stage(
    data: FieldData,
    hauls: pd.DataFrame,
    curve: str,
    l50: Predictor,
    log_sr: Predictor,
    split: Predictor | None,
    *,
    fixed_split: float = 0.5,
    random: Sequence[str] = (),
    units: Sequence[str] | None = None,
    group: str = "",
    near: OneStage | None = None,
) -> OneStage:
    """Fit L50, SR and split of all hauls in one likelihood.

    Args:
        data: the counted fish.
        hauls: a row a haul with the columns that the predictors use.
        curve: name in `FAMILIES`.
        l50: predictor of L50.
        log_sr: of ln SR.
        split: of the logit of the split; None for a fixed split or a covered codend.
        fixed_split: its value where it is fixed.
        random: which of `RANDOM_TERMS` differ between units.
        units: (H,) the unit of each haul; each haul its own if not given.
        group: column of `hauls` with the gear.
        near: a fit of the same predictors and random terms with another curve, to start from.
    """
    of_hauls = tuple(data.haul_names if units is None else units)
    labels = tuple(dict.fromkeys(of_hauls))
    unit_of_haul = np.array([labels.index(unit) for unit in of_hauls])
    fished = np.flatnonzero(data.test_count + data.other_count > 0.0)
    order = fished[np.argsort(unit_of_haul[data.haul[fished]], kind="stable")]
    haul, present = data.haul[order], np.unique(unit_of_haul[data.haul[order]])
    model = MarginalModel(
        family=FAMILIES[curve],
        design=data.design,
        haul=np.searchsorted(present, unit_of_haul[haul]),
        length_cm=data.length_cm[order],
        test=data.test_count[order],
        other=data.other_count[order],
        log_offset=data.log_offset[order],
        by_l50=l50.columns[haul],
        by_log_sr=log_sr.columns[haul],
        by_split=split.columns[haul] if split else np.empty((order.size, 0)),
        fixed_logit_split=float(logit(fixed_split)),
        random=tuple(term for term in RANDOM_TERMS if term in random),
    )
    start = starting_point(model, *_grid_start(data, split is not None, fixed_split))
    if near is not None and near.converged:
        for part in ("l50", "sr", "split"):
            start[model.slices[part]] = near.theta[near.model.slices[part]]
    maximum = maximise_marginal(model, start, again=near is None)
    degrees = float(max(present.size - l50.columns.shape[1], 1)) if random else np.inf
    unit_names = tuple(labels[i] for i in present)
    return OneStage(data, hauls, l50, log_sr, split, of_hauls, unit_names, model, order, maximum, group, degrees)


def _grid_start(data: FieldData, estimate_split: bool, fixed_split: float) -> tuple[float, float, float]:
    """L50, SR and logit split of the most likely pooled logit curve of a coarse grid."""
    model = without_covariates(selection_model(data, "logit", estimate_split, fixed_split))
    theta = grid_start(model, data.test_count[None], data.other_count[None])[0]
    beta = theta[1] / model.length_scale_cm
    l50 = model.length_centre_cm - theta[0] / beta
    return float(l50), float(2.0 * np.log(3.0) / beta), float(model.shape_and_split(theta)[1])


def conditional_residuals(fit: OneStage) -> Array:
    """(R,) Pearson residuals of the rows of `fit.data` about each unit's own predicted curve; NaN without fish."""
    share = expected_share(fit.model, fit.theta, fit.maximum.modes)
    n = fit.model.test + fit.model.other
    found = np.full(fit.data.haul.size, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        found[fit.order] = (fit.model.test - n * share) / np.sqrt(n * share * (1.0 - share))
    return found


def left_over_dispersion(fit: OneStage) -> tuple[float, int]:
    """Pearson X^2 / d about each unit's own predicted curve and its degrees of freedom d; NaN where too few to tell.

    Over classes expected to hold more than `LEAST_EXPECTED` fish in both gears; every random term takes a degree of
    freedom for each unit but one.
    """
    model = fit.model
    share, n = expected_share(model, fit.theta, fit.maximum.modes), model.test + model.other
    filled = (n * share > LEAST_EXPECTED) & (n * (1.0 - share) > LEAST_EXPECTED)
    degrees = int(filled.sum()) - model.n_parameters - len(model.random) * (len(fit.unit_names) - 1)
    if degrees < LEAST_DEGREES:
        return float("nan"), degrees
    return float((conditional_residuals(fit)[fit.order][filled] ** 2).sum()) / degrees, degrees
