"""A trial read from a file and set beside every prediction, calibrated where that is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from codend.errors import OPTIONS, InputError
from codend.selectivity.escape.predict import Prediction, predict_haul
from codend.selectivity.fits.analysis import fit_field_data
from codend.selectivity.fits.choices import allowed_choice
from codend.selectivity.fits.fielddata import catch_volumes_m3, is_simulated
from codend.selectivity.fits.haul_table import AS_IT_STANDS, HaulReading
from codend.selectivity.fits.scoring import NO_SELECTION
from codend.selectivity.predicted_and_observed.calibrate import calibrate, calibrated_names
from codend.selectivity.predicted_and_observed.retention_likelihood import Trialled
from codend.selectivity.predicted_and_observed.together import FieldTrial, Together, set_together


def read_trial(
    path: str | Path,
    catch_density_kg_m3: float,
    design: str,
    curve: str = "logit",
    split: str = "equal",
    reading: HaulReading = AS_IT_STANDS,
) -> FieldTrial:
    """Read a trial with the codend of a study and fit a curve to it.

    Args:
        path: table as in ``read_field_data``, with an optional column ``catch_volume_m3`` or ``catch_kg``.
        catch_density_kg_m3: of the catch, by which ``catch_kg`` becomes a volume.
        design: "covered" or "paired".
        curve: as in ``fit_field_data``.
        split: likewise.
        reading: likewise.

    Raises:
        InputError: bad data, or a choice that does not exist.
    """
    allowed_choice("split", split, ("equal", "estimated"))
    fit = fit_field_data(path, design, curve, split, reading=reading)
    volume_m3 = catch_volumes_m3(path, fit.data, catch_density_kg_m3, reading)
    return FieldTrial(fit, is_simulated(path, reading), volume_m3)


def check_selection(trial: FieldTrial) -> None:
    """Refuse a trial whose fish tell of no selection: nothing computed can stand beside it.

    Raises:
        InputError: retention does not rise with length, or cannot be told to.
    """
    outcome = trial.fit.pooled.outcome
    if outcome in NO_SELECTION:
        gear = "codend" if trial.data.design == "covered" else "test"
        allowed = "fish of which the longer are retained the more"
        raise InputError(trial.data.source, gear, None, allowed, f"tells of no selection: {outcome.value}")


def set_beside(
    predictions: Sequence[Prediction],
    trial: FieldTrial,
    calibrated: Sequence[str] = (),
    *,
    estimate_split: bool = False,
    also: Sequence[Trialled] = (),
) -> list[Together]:
    """Every prediction beside one trial, and with numbers calibrated on it.

    Args:
        predictions: of the trial's species; calibration wants one alone.
        trial: with the codend of the predictions' study.
        calibrated: names of numbers to calibrate; none for no calibration.
        estimate_split: calibration with paired gear: estimate the split.
        also: other codends and hauls with them, calibrated on jointly.

    Raises:
        InputError: names that cannot be calibrated, or calibration of several species or speeds at once.
    """
    if not calibrated:
        return [set_together(found, trial) for found in predictions]
    names = calibrated_names(calibrated)
    if len(predictions) > 1:
        allowed = "one species and a run at one speed"
        raise InputError(OPTIONS, "calibrate", ",".join(calibrated), allowed, f"has {len(predictions)} to serve")
    found = predictions[0]
    first = f"{Path(trial.data.source).name}{' (simulated fish)' if trial.simulated else ''}"
    result = calibrate(
        found.haul,
        found.species,
        trial.data,
        names,
        estimate_split=estimate_split,
        volume_m3=trial.volume_m3,
        source=", ".join([first, *(Path(one.data.source).name for one in also)]),
        also=also,
    )
    again = predict_haul(result.species, found.haul, n_bootstrap=0, samples=0) if result.explains else None
    return [set_together(found, trial, result, again)]
