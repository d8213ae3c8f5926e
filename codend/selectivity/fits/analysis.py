"""From a table of counted fish to fitted curves: what `codend fit` does, and the table `fit.csv`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from codend.errors import OPTIONS, InputError
from codend.selectivity.fits.between_hauls import BetweenHauls, fit_between_hauls
from codend.selectivity.fits.bootstrap import Bootstrap, double_bootstrap
from codend.selectivity.fits.curves import CURVES
from codend.selectivity.fits.fielddata import FieldData, read_field_data
from codend.selectivity.fits.fit import OVERDISPERSION, Fit, fit_hauls, fit_pooled
from codend.selectivity.fits.haul_table import AS_IT_STANDS, HaulReading
from codend.selectivity.fits.model import selection_model
from codend.selectivity.fits.parameters import Estimates

if TYPE_CHECKING:
    import pandas as pd

SPLITS = ("equal", "estimated")


@dataclass(frozen=True)
class FieldFit:
    """All fits of a trial.

    Attributes:
        data: the counted fish.
        pooled: one curve for all hauls.
        hauls: a curve for each haul; empty when there is only one.
        between_hauls: the mean curve with between-haul variation (Fryer 1991); None when there is only one haul. It
            or the bootstrap is the answer for "the gear" when hauls differ: intervals of the pooled fit, even widened
            by the dispersion factor, hold the true L50 of `validation.coverage_study` half of the time only.
        bootstrap: the pooled curve with double-bootstrap intervals; None when not asked for or the fit failed.
    """

    data: FieldData
    pooled: Fit
    hauls: tuple[Fit, ...]
    between_hauls: BetweenHauls | None
    bootstrap: Bootstrap | None

    @property
    def converged(self) -> bool:
        """Whether the pooled curve is a maximum of the likelihood."""
        return self.pooled.converged


def fit_field_data(
    data: str | Path | pd.DataFrame,
    design: str,
    curve: str = "logit",
    split: str = "equal",
    *,
    covariates: Sequence[str] = (),
    overdispersion: str = "pearson",
    n_bootstrap: int = 0,
    seed: int = 0,
    reading: HaulReading = AS_IT_STANDS,
) -> FieldFit:
    """Fit a retention curve to a covered-codend or paired-gear trial.

    Args:
        data: CSV file or DataFrame as described in `read_field_data`.
        design: "covered" or "paired".
        curve: "logit", "probit", "gompertz", "cloglog" or "richards".
        split: paired gear: "equal" (p = 0.5) or "estimated".
        covariates: numeric columns, constant within a haul, entering a and b linearly.
        overdispersion: "pearson" or "deviance" multiply the covariance by that statistic per degree of freedom where it
            shows lack of fit (see `codend.selectivity.fits.fit.dispersion_factor`); "none" never does.
        n_bootstrap: replicates of the double bootstrap; 0 for none.
        seed: of the bootstrap.
        reading: what the user says of the form of the table, its lengths and the rows that are wanted.

    Raises:
        InputError: bad data (see `read_field_data`) or a choice that does not exist.
    """
    field_data = read_field_data(data, design, covariates, reading)
    choices = (
        ("curve", curve, tuple(CURVES)),
        ("split", split, SPLITS),
        ("overdispersion", overdispersion, OVERDISPERSION),
    )
    for key, value, allowed in choices:
        if value not in allowed:
            raise InputError(OPTIONS, key, value, ", ".join(allowed))
    if split == "estimated" and design == "covered":
        raise InputError(OPTIONS, "split", split, "equal (only paired gear has a split)")
    if n_bootstrap < 0:
        raise InputError(OPTIONS, "n_bootstrap", n_bootstrap, "0 or more")

    model = selection_model(field_data, curve, split == "estimated")
    pooled = fit_pooled(field_data, model, overdispersion)
    several = len(field_data.haul_names) > 1
    hauls = fit_hauls(field_data, model, overdispersion) if several else ()
    return FieldFit(
        data=field_data,
        pooled=pooled,
        hauls=hauls,
        between_hauls=fit_between_hauls(field_data, model, hauls) if several else None,
        bootstrap=double_bootstrap(field_data, pooled, n_bootstrap, seed) if n_bootstrap and pooled.converged else None,
    )


def fit_table(fit: FieldFit) -> pd.DataFrame:
    """`fit.csv`: `group, curve, parameter, estimate, standard_error, lower_95, upper_95`.

    Groups: "pooled" (all hauls, delta-method intervals), "bootstrap" (the same curve, double-bootstrap errors and
    intervals), "between-hauls" (mean curve with between-haul variation), then "haul NAME" each. Parameters are named in
    `codend.selectivity.fits.parameters.parameter_names`. What could not be estimated is NaN, and so are the error and
    interval of a split that is fixed.
    """
    import pandas as pd

    groups: list[tuple[str, Estimates]] = [("pooled", fit.pooled.estimates)]
    if fit.bootstrap is not None:
        groups.append(("bootstrap", fit.bootstrap.estimates))
    if fit.between_hauls is not None:
        groups.append(("between-hauls", fit.between_hauls.estimates))
    groups += [(haul.group, haul.estimates) for haul in fit.hauls]
    model = fit.pooled.model
    frames = [
        pd.DataFrame(
            {
                "group": group,
                "curve": model.curve.name,
                "parameter": list(estimates.names),
                "estimate": estimates.values,
                "standard_error": estimates.standard_errors,
                "lower_95": estimates.lower_95,
                "upper_95": estimates.upper_95,
            }
        )
        for group, estimates in groups
    ]
    table = pd.concat(frames, ignore_index=True)
    if not model.estimate_split:
        table.loc[table["parameter"] == "split", ["standard_error", "lower_95", "upper_95"]] = np.nan
    return table


def diagnostics_table(fit: FieldFit) -> pd.DataFrame:
    """How each fit went, a row a group: convergence, likelihood, lack of fit and dispersion."""
    import pandas as pd

    rows = [
        {
            "group": one.group,
            "curve": one.model.curve.name,
            "converged": one.converged,
            "message": one.outcome.value,
            "gradient_norm": one.gradient_norm,
            "n_fish": one.n_fish,
            "log_likelihood": one.log_likelihood,
            "aic": one.aic,
            "deviance": one.deviance,
            "pearson_chi2": one.pearson_chi2,
            "degrees_of_freedom": one.degrees_of_freedom,
            "p_value": one.p_value,
            "dispersion": one.dispersion if one.converged else np.nan,
        }
        for one in (fit.pooled, *fit.hauls)
    ]
    return pd.DataFrame(rows)
