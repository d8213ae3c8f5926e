"""All curves of a trial by AIC, and their average (Burnham and Anderson 2002, Model Selection, sections 2.9, 4.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from codend.selectivity.fits.families import FAMILIES
from codend.selectivity.fits.one_stage import OneStage, fit_one_stage
from codend.selectivity.fits.one_stage_estimates import estimates_within
from codend.selectivity.fits.parameters import Estimates

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
ANSWERS: Final = ("l50_cm", "sr_cm")


@dataclass(frozen=True)
class CurveChoice:
    """Fits of all families to one trial.

    Attributes:
        fits: one a family, the least AIC first, those without a maximum last.
        weights: (n,) Akaike weights, 0 for a fit without an L50 within the lengths.
        notes: (n,) what must be said of each; empty if nothing.
        average: L50 and SR averaged by the weights, with unconditional standard errors that hold the choice of curve.
    """

    fits: tuple[OneStage, ...]
    weights: Array
    notes: tuple[str, ...]
    average: Estimates


def choose_curve(one: OneStage, level: str = "") -> CurveChoice:
    """Fit every family with the predictors and random terms of a fit, and average L50 and SR of a gear."""
    fits = [one if name == one.model.family.name else _with_family(one, name) for name in FAMILIES]
    fits.sort(key=lambda fit: fit.aic if fit.converged else np.inf)
    found = [estimates_within(fit, level) for fit in fits]
    answers = np.array([[estimates[name] for name in ANSWERS] for estimates, _ in found])
    errors = np.array(
        [[estimates.standard_errors[estimates.names.index(name)] for name in ANSWERS] for estimates, _ in found]
    )
    good = np.isfinite(answers).all(axis=1) & np.isfinite(errors).all(axis=1)
    aic = np.array([fit.aic for fit in fits])
    weights = np.zeros(len(fits))
    if good.any():
        weights[good] = np.exp(-0.5 * (aic[good] - aic[good].min()))
        weights /= weights.sum()
        mean = weights[good] @ answers[good]
        error = weights[good] @ np.sqrt(errors[good] ** 2 + (answers[good] - mean) ** 2)
    else:
        mean = error = np.full(2, np.nan)
    half = one.quantile * error
    average = Estimates(ANSWERS, mean, error, mean - half, mean + half)
    return CurveChoice(tuple(fits), weights, tuple(note for _, note in found), average)


def curve_table(choice: CurveChoice, level: str = "") -> pd.DataFrame:
    """`curves.csv`, a row a curve by AIC and a last one for the average.

    Columns: `curve, parameters, log_likelihood, aic, delta_aic, weight, l50_cm, l50_standard_error_cm, sr_cm,
    sr_standard_error_cm, note`.
    """
    import pandas as pd

    rows = []
    least = choice.fits[0].aic
    for fit, weight, note in zip(choice.fits, choice.weights, choice.notes, strict=True):
        estimates = estimates_within(fit, level)[0]
        numbers = {"log_likelihood": fit.log_likelihood, "aic": fit.aic, "delta_aic": fit.aic - least}
        rows.append(
            {"curve": fit.model.family.name, "parameters": fit.model.n_parameters, **numbers, "weight": weight}
            | _l50_sr(estimates)
            | {"note": note}
        )
    rows.append({"curve": "average", "weight": choice.weights.sum()} | _l50_sr(choice.average) | {"note": ""})
    return pd.DataFrame(rows).astype({"parameters": "Int64"})


def _l50_sr(estimates: Estimates) -> dict[str, float]:
    found = {}
    for name in ("l50", "sr"):
        i = estimates.names.index(f"{name}_cm")
        found[f"{name}_cm"] = float(estimates.values[i])
        found[f"{name}_standard_error_cm"] = float(estimates.standard_errors[i])
    return found


def _with_family(one: OneStage, name: str) -> OneStage:
    return fit_one_stage(
        one.data,
        one.hauls,
        name,
        one.l50,
        one.log_sr,
        one.split,
        fixed_split=one.fixed_split,
        random=one.model.random,
        units=one.units,
        group=one.group,
        near=one,
    )
