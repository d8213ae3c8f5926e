"""L50 and SR of a computed codend beside those of a trial, like for like.

A trial's L50 differs from one read off the computed retention curve in three ways, whatever the fish did. It is of
whole hauls, which begin empty, and not of the fish that meet the final catch. Its hauls end with their own catches. And
it is that of a fitted curve, which goes to zero for small fish, where the computed one goes to the share that never
tries a mesh. So the computed codend is also read as the trial reads the real one: the trial's fish, were they retained
as computed up to the catch of their haul, with the same curve fitted to them and the same mean over hauls. What then
differs is the fish.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from codend.selectivity.escape.predict import Prediction
from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.fit import Fit, fit_hauls, fit_pooled
from codend.selectivity.fits.parameters import Estimates, public_parameters
from codend.selectivity.predicted_and_observed.together import FieldTrial, Together, beyond_computed, haul_until

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]
Row = tuple[object, ...]

COMPUTED_CURVE: Final = "computed curve"
"""In the column ``l50_of``: read off the computed retention curve, where it is 0.5."""
UNKNOWN: Final = (np.nan,) * 4


def haul_l50_sr(prediction: Prediction) -> Floats:
    """L50 and SR of hauls that end with each of the computed catches, read off the computed curves, cm, (c, 2)."""
    return np.array([haul_until(prediction, float(volume)).l50_sr() for volume in prediction.haul.volume_m3])


def as_counted(prediction: Prediction, trial: FieldTrial) -> FieldData:
    """The trial's fish, as many at each length in each haul, shared between the gears as computed; no whole numbers.

    Of n fish counted in both gears together the codend has n phi, phi as in ``codend.selectivity.fits.model`` with the
    computed retention of a haul that ends with the catch of this one, or with the largest computed where the trial's
    catches are not known. The split of paired gear is the trial's.
    """
    data = trial.data
    retained = np.empty(len(data.haul))
    for h, volume in enumerate(_volume_m3(prediction, trial)):
        own = data.haul == h
        retained[own] = np.clip(haul_until(prediction, float(volume)).retention(data.length_cm[own]), 0.0, 1.0)
    in_codend, in_other = retained, 1.0 - retained
    if data.design == "paired":
        split = trial.fit.pooled.estimates["split"]
        in_codend, in_other = split * retained, np.full(len(retained), 1.0 - split)
    in_codend, in_other = in_codend / data.test_raising, in_other / data.other_raising
    fish, phi = data.test_count + data.other_count, in_codend / (in_codend + in_other)
    return replace(data, test_count=fish * phi, other_count=fish * (1.0 - phi))


def l50_sr_as_fitted(prediction: Prediction, trial: FieldTrial) -> tuple[Floats, Floats]:
    """L50 and SR of the trial's fits, had its fish been retained as computed: of every haul (H, 2), and of all (2,).

    That of all is the pooled fit, or the mean of the hauls with the weights they have in the trial's own mean (its
    between-haul covariance), as ``trial.group`` says. nan where no curve can be fitted.
    """
    counted, model = as_counted(prediction, trial), trial.fit.pooled.model
    if not trial.fit.hauls:
        pooled = _l50_sr(fit_pooled(counted, model, "none").estimates)
        return pooled[None], pooled
    hauls, between = fit_hauls(counted, model, "none"), trial.fit.between_hauls
    singles = np.array([_l50_sr(fit.estimates) for fit in hauls])
    if trial.group == "pooled" or between is None:
        return singles, _l50_sr(fit_pooled(counted, model, "none").estimates)
    theta = np.array([fit.theta for fit in _entered(hauls, trial)])
    weights = np.linalg.inv([fit.covariance + between.between_covariance for fit in _entered(trial.fit.hauls, trial)])
    mean = np.linalg.solve(weights.sum(axis=0), np.einsum("hij,hj->i", weights, theta))
    return singles, public_parameters(model, mean)[0][_l50_and_sr(hauls[0].estimates)]


def together_l50_table(many: Sequence[Together]) -> pd.DataFrame:
    """``together_l50.csv``: L50 and SR against the catch, a row each.

    ``what``: "predicted catch" (fish that meet this catch), "predicted haul" (one that ends with it), "predicted field
    haul" (ends with the catch of this field haul), "predicted field mean", then "calibrated ..." the same with
    calibrated numbers, and "field haul" and "field mean" with 95 % intervals. ``l50_of`` says what the L50 and SR of
    a row are those of: the computed curve itself, a curve fitted to it, or one fitted to counted fish; the last two
    are alike. Rows computed for field hauls are left out where one has a larger catch than any computed.
    """
    import pandas as pd

    rows: list[Row] = []
    for one in many:
        start = (one.prediction.species.name, one.prediction.haul.speed_m_s)
        for prefix, found in (("predicted", one.prediction), ("calibrated", one.calibrated)):
            if found is not None:
                rows += [(*start, *row) for row in _computed_rows(prefix, found, one.trial)]
        rows += [(*start, *row) for row in _field_rows(one.trial)]
    columns = ["species", "speed_m_s", "what", "name", "l50_of", "catch_volume_m3", "l50_cm", "sr_cm"]
    columns += [f"{quantity}_{end}_95_cm" for quantity in ("l50", "sr") for end in ("lower", "upper")]
    return pd.DataFrame(rows, columns=columns)


def _computed_rows(prefix: str, found: Prediction, trial: FieldTrial) -> Iterator[Row]:
    of_hauls = haul_l50_sr(found)
    for i, (catch, volume) in enumerate(zip(found.haul.catches, found.haul.volume_m3, strict=True)):
        if prefix == "predicted":
            yield "predicted catch", str(catch.case), COMPUTED_CURVE, volume, *found.l50_sr[i], *UNKNOWN
        yield f"{prefix} haul", str(catch.case), COMPUTED_CURVE, volume, *of_hauls[i], *UNKNOWN
    if beyond_computed(found, trial):
        return
    l50_of = f"{trial.fit.pooled.model.curve.name} fitted to the computed curve"
    singles, mean = l50_sr_as_fitted(found, trial)
    volumes = _volume_m3(found, trial)
    for name, volume, single in zip(trial.data.haul_names, volumes, singles, strict=True):
        yield f"{prefix} field haul", name, l50_of, volume, *single, *UNKNOWN
    yield f"{prefix} field mean", trial.group, l50_of, volumes.mean(), *mean, *UNKNOWN


def _field_rows(trial: FieldTrial) -> Iterator[Row]:
    fit, names = trial.fit, trial.data.haul_names
    volume = np.full(len(names), np.nan) if trial.volume_m3 is None else trial.volume_m3
    between = fit.between_hauls
    mean = between.estimates if between is not None and trial.group == "between-hauls" else fit.pooled.estimates
    singles = [one.estimates for one in fit.hauls] or [fit.pooled.estimates]
    groups = [("field haul", name, v, one) for name, v, one in zip(names, volume, singles, strict=True)]
    l50_of = f"{fit.pooled.model.curve.name} fitted to the fish"
    for what, name, at, estimates in [*groups, ("field mean", trial.group, volume.mean(), mean)]:
        which = _l50_and_sr(estimates)
        ends = [end[i] for i in which for end in (estimates.lower_95, estimates.upper_95)]
        yield what, name, l50_of, at, *estimates.values[which], *ends


def _volume_m3(prediction: Prediction, trial: FieldTrial) -> Floats:
    """Final catch of every haul, (H,): the trial's, or the largest computed where it has none."""
    if trial.volume_m3 is not None:
        return trial.volume_m3
    return np.full(len(trial.data.haul_names), prediction.haul.volume_m3[-1])


def _entered(hauls: Sequence[Fit], trial: FieldTrial) -> list[Fit]:
    """Those of the hauls that entered the trial's mean."""
    return [fit for fit, own in zip(hauls, trial.fit.hauls, strict=True) if own.converged]


def _l50_and_sr(estimates: Estimates) -> list[int]:
    return [estimates.names.index(quantity) for quantity in ("l50_cm", "sr_cm")]


def _l50_sr(estimates: Estimates) -> Floats:
    return estimates.values[_l50_and_sr(estimates)]
