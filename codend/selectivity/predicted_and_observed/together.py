"""Predicted and fitted retention beside each other: the computed codend, and the curve fitted to hauls with it.

Three kinds of numbers stand side by side. Predicted: computed from the plan's openings and the species' numbers, of
which some are assumed. Fitted: a curve through the counted fish, with its interval. Observed: shares of the fish
counted, raised. L50 and SR of all of them are in ``codend.selectivity.predicted_and_observed.together_l50``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, ndtri, stdtrit

from codend.selectivity.escape.haul import shares_until, terms_of_haul
from codend.selectivity.escape.predict import Prediction
from codend.selectivity.escape.retention import EscapeTerms
from codend.selectivity.fits.analysis import FieldFit
from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.model import log_odds, without_covariates
from codend.selectivity.predicted_and_observed.calibrate import MARGIN, Calibration

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FieldTrial:
    """A trial with the codend of a study: its fish, the curve through them, and what is known of its catches."""

    fit: FieldFit
    simulated: bool
    """Whether the table says that its fish are simulated."""
    volume_m3: Floats | None
    """Final catch of every haul, (H,); None where the table has none."""

    @property
    def data(self) -> FieldData:
        """The counted fish."""
        return self.fit.data

    @property
    def group(self) -> str:
        """Which fit answers for the gear: the mean of the hauls where there is one, else the pooled fit."""
        between = self.fit.between_hauls
        return "between-hauls" if between is not None and between.converged else "pooled"


@dataclass(frozen=True)
class Together:
    """A prediction beside a trial; arrays (n,) over ``length_cm``, nan where something is not known."""

    prediction: Prediction
    trial: FieldTrial
    calibration: Calibration | None
    calibrated: Prediction | None
    """Prediction with the calibrated species."""
    length_cm: Floats
    """Those of the species file and of the trial."""
    predicted: Floats
    """Over the whole haul, which ends with the largest catch computed."""
    predicted_trial: Floats
    """Mean over hauls that end with the catches of the trial's; nan where those are not known or go beyond."""
    calibrated_trial: Floats
    """The same with calibrated numbers; without catches, over the whole haul. nan without calibration."""
    predicted_band: Floats
    """Percentiles 2.5 and 97.5 when the species' numbers vary over their ranges, (2, n)."""
    fitted: Floats
    fitted_band: Floats
    """95 % interval of the fitted curve, (2, n)."""
    fish: Floats
    """Counted."""
    observed: Floats
    """Raised share of the codend, all hauls together; paired gear: test over control, times (1 - p) / p."""


def set_together(
    prediction: Prediction,
    trial: FieldTrial,
    calibration: Calibration | None = None,
    calibrated: Prediction | None = None,
) -> Together:
    """A prediction beside a trial, at the lengths of both."""
    length_cm = np.union1d(prediction.length_cm, trial.data.length_cm)
    band = np.full((2, len(length_cm)), np.nan)
    if prediction.sensitivity is not None:
        known = prediction.length_cm
        band = np.array([np.interp(length_cm, known, end, np.nan, np.nan) for end in prediction.sensitivity.band])
    fitted, fitted_band = fitted_retention(trial, length_cm)
    fish, observed = observed_retention(trial, length_cm)
    after = np.full(len(length_cm), np.nan)
    if calibrated is not None:
        after = trial_retention(calibrated, trial, length_cm)
        after = calibrated.terms[-1].retention(length_cm) if trial.volume_m3 is None else after
    return Together(
        prediction=prediction,
        trial=trial,
        calibration=calibration,
        calibrated=calibrated,
        length_cm=length_cm,
        predicted=prediction.terms[-1].retention(length_cm),
        predicted_trial=trial_retention(prediction, trial, length_cm),
        calibrated_trial=after,
        predicted_band=band,
        fitted=fitted,
        fitted_band=fitted_band,
        fish=fish,
        observed=observed,
    )


def trial_retention(prediction: Prediction, trial: FieldTrial, length_cm: Floats) -> Floats:
    """Computed retention, mean over hauls that end with the trial's catches, (n,); see ``Together``."""
    haul, species = prediction.haul, prediction.species
    if trial.volume_m3 is None or beyond_computed(prediction, trial):
        return np.full(len(length_cm), np.nan)
    share = np.mean([shares_until(haul, species, float(volume)) for volume in trial.volume_m3], axis=0)
    return terms_of_haul(haul, prediction.terms[:-1], species, share).retention(length_cm)


def beyond_computed(prediction: Prediction, trial: FieldTrial) -> bool:
    """Whether a haul of the trial has a larger catch than any computed."""
    largest = prediction.haul.volume_m3[-1] * (1.0 + MARGIN)
    return trial.volume_m3 is not None and bool(trial.volume_m3.max() > largest)


def haul_until(prediction: Prediction, volume_m3: float) -> EscapeTerms:
    """Retention of a computed haul that ends with a catch."""
    haul, species = prediction.haul, prediction.species
    return terms_of_haul(haul, prediction.terms[:-1], species, shares_until(haul, species, volume_m3))


def fitted_retention(trial: FieldTrial, length_cm: Floats) -> tuple[Floats, Floats]:
    """Fitted retention (n,) and its 95 % interval (2, n): delta method on the logit, so that it stays in [0, 1]."""
    from dataclasses import replace

    pooled, between = trial.fit.pooled, trial.fit.between_hauls
    if trial.group == "between-hauls":
        assert between is not None
        theta, covariance = between.theta, between.covariance
        quantile = float(stdtrit(len(between.haul_names) - 1, 0.975))
    else:
        theta, covariance, quantile = pooled.theta, pooled.covariance, float(ndtri(0.975))
    # logit r is the log-odds of a covered codend without raising
    z = (length_cm - pooled.model.length_centre_cm) / pooled.model.length_scale_cm
    model = replace(
        without_covariates(pooled.model),
        design="covered",
        estimate_split=False,
        columns=np.stack([np.ones_like(z), z], axis=1),
        log_offset=np.zeros_like(z),
    )
    k = model.n_parameters
    logit = log_odds(model, theta[None, :k])
    slopes = logit.eta[0][:, None] * model.columns
    if model.curve.has_shape:
        slopes = np.hstack([slopes, np.broadcast_to(logit.log_delta, logit.eta.shape)[0][:, None]])
    reach = quantile * np.sqrt(np.einsum("ni,ij,nj->n", slopes, covariance[:k, :k], slopes))
    return expit(logit.value[0]), expit(logit.value[0] + np.array([[-1.0], [1.0]]) * reach)


def observed_retention(trial: FieldTrial, length_cm: Floats, haul: int | None = None) -> tuple[Floats, Floats]:
    """Fish counted and observed retention at lengths, (n,) each, of one haul or all; nan where no fish tell."""
    data = trial.data
    used = np.ones(len(data.haul), dtype=bool) if haul is None else data.haul == haul
    at = np.searchsorted(length_cm, data.length_cm[used])

    def summed(values: Floats) -> Floats:
        return np.bincount(at, values[used], minlength=len(length_cm)).astype(float)

    test, other = summed(data.test_count * data.test_raising), summed(data.other_count * data.other_raising)
    with np.errstate(invalid="ignore", divide="ignore"):
        if data.design == "covered":
            observed = test / (test + other)
        else:
            split = trial.fit.pooled.estimates["split"]
            observed = np.where(other > 0.0, test / other, np.nan) * (1.0 - split) / split
    return summed(data.test_count + data.other_count), observed


def together_table(many: Sequence[Together]) -> pd.DataFrame:
    """``together.csv``: a row a length, for every species and speed.

    ``predicted_retention`` is of the study's whole haul, ``predicted_trial_retention`` the mean over hauls that end
    with the trial's catches; likewise with calibrated numbers.
    """
    import pandas as pd

    frames = []
    for one in many:
        frame = pd.DataFrame(
            {
                "species": one.prediction.species.name,
                "speed_m_s": one.prediction.haul.speed_m_s,
                "length_cm": one.length_cm,
                "predicted_retention": one.predicted,
                "predicted_lower_95": one.predicted_band[0],
                "predicted_upper_95": one.predicted_band[1],
                "predicted_trial_retention": one.predicted_trial,
                "fitted_retention": one.fitted,
                "fitted_lower_95": one.fitted_band[0],
                "fitted_upper_95": one.fitted_band[1],
                "fitted_group": one.trial.group,
                "fish_counted": one.fish,
                "observed_retention": one.observed,
                "field_fish": "simulated" if one.trial.simulated else "field",
            }
        )
        if one.calibrated is not None:
            frame["calibrated_retention"] = one.calibrated.terms[-1].retention(one.length_cm)
            frame["calibrated_trial_retention"] = one.calibrated_trial
        frame["assumed"] = " ".join(one.prediction.species.assumed)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def calibration_table(found: Calibration) -> pd.DataFrame:
    """``calibration.csv``: a row a number."""
    import pandas as pd

    return pd.DataFrame(
        {
            "parameter": found.names,
            "estimate": found.values,
            "lower_95": found.lower_95,
            "upper_95": found.upper_95,
            "limited_below": found.limited[:, 0],
            "limited_above": found.limited[:, 1],
            "identified": found.identified,
            "deviance": found.deviance,
            "degrees_of_freedom": found.degrees_of_freedom,
            "p_value": found.p_value,
            "dispersion": found.dispersion,
            "converged": found.converged,
            "message": found.message,
        }
    )
