"""From a table of counted fish to fitted curves: what `codend fit` does, and the table `fit.csv`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from codend.errors import OPTIONS, InputError
from codend.selectivity.fits.between_hauls import BetweenHauls, fit_between_hauls
from codend.selectivity.fits.bootstrap import Bootstrap, Told, double_bootstrap
from codend.selectivity.fits.choices import (
    LEAST_UNITS,
    RandomTerms,
    allowed_choice,
    random_terms,
    split_choice,
    units_of,
)
from codend.selectivity.fits.curves import CURVES
from codend.selectivity.fits.fielddata import DESIGNS, FieldData, read_field_data
from codend.selectivity.fits.fit import OVERDISPERSION, Fit, fit_hauls, fit_pooled
from codend.selectivity.fits.haul_table import AS_IT_STANDS, HaulReading
from codend.selectivity.fits.model import selection_model
from codend.selectivity.fits.one_stage import OneStage, fit_one_stage
from codend.selectivity.fits.one_stage_estimates import estimates_within
from codend.selectivity.fits.parameters import Estimates, within_lengths
from codend.selectivity.fits.predictors import predictor
from codend.selectivity.fits.profile import with_profile_limits
from codend.selectivity.fits.scoring import NO_SELECTION

if TYPE_CHECKING:
    import pandas as pd

NO_TERMS = RandomTerms("haul", ())


class Answer(NamedTuple):
    """What one method says of the gear: its name, estimates, kinds of intervals, and what must be said."""

    group: str
    estimates: Estimates
    intervals: tuple[str, ...]
    note: str


@dataclass(frozen=True)
class FieldFit:
    """All fits of a trial.

    Attributes:
        data: the counted fish.
        one_stage: all hauls in one likelihood with variation between them; None with fewer than three hauls, without
            random terms, or where the pooled fish show no selection. It is the answer printed first, for simulation
            (`validation.field_fit_study`) shows it unbiased with intervals that hold the truth, for paired gear too.
        pooled: one curve for all hauls. Its intervals take no account of hauls that differ.
        hauls: a curve for each haul; empty when there is only one.
        between_hauls: the mean of the hauls' own curves (Fryer 1991), biased where hauls have few fish; None when there
            is only one haul.
        bootstrap: the pooled curve with double-bootstrap intervals; None when not asked for or the fit failed.
        answers: what each of them says of the gear, in the order in which they are printed.
        shown: the fit behind the first answer, or behind the pooled one where that failed, to draw and predict from;
            None where both did.
        overdispersion: as asked for.
    """

    data: FieldData
    one_stage: OneStage | None
    pooled: Fit
    hauls: tuple[Fit, ...]
    between_hauls: BetweenHauls | None
    bootstrap: Bootstrap | None
    answers: tuple[Answer, ...]
    shown: OneStage | None
    overdispersion: str

    @property
    def converged(self) -> bool:
        """Whether the answer printed first is a maximum of its likelihood."""
        return self.one_stage.converged if self.one_stage else self.pooled.converged


def fit_field_data(
    data: str | Path | pd.DataFrame | FieldData,
    design: str,
    curve: str = "logit",
    split: str | float = "equal",
    *,
    covariates: Sequence[str] = (),
    random: str = "haul",
    overdispersion: str = "pearson",
    n_bootstrap: int = 0,
    seed: int = 0,
    reading: HaulReading = AS_IT_STANDS,
    progress: Told | None = None,
) -> FieldFit:
    """Fit a retention curve to a covered-codend or paired-gear trial.

    Args:
        data: CSV file or DataFrame as described in `read_field_data`, or what that read.
        design: "covered" or "paired".
        curve: "logit", "probit", "gompertz", "cloglog" or "richards".
        split: paired gear: "equal" (p = 0.5), "estimated", or the share of the fish that enter the test gear.
        covariates: numeric columns, constant within a haul, entering a and b linearly; in one stage, L50 and ln SR.
        random: "haul", "none", or a column of units that differ at random, and after a colon what differs: "haul:l50"
            (the default for a covered codend and a fixed split), "haul:l50,split" (with an estimated one), "...,sr".
        overdispersion: "pearson" or "deviance" multiply the covariance of the pooled fit by that statistic per degree
            of freedom where it shows lack of fit (see `codend.selectivity.fits.fit.dispersion_factor`); "none" never.
        n_bootstrap: replicates of the double bootstrap; 0 for none.
        seed: of the bootstrap.
        reading: what the user says of the form of the table, its lengths and the rows that are wanted.
        progress: told how many refits of the bootstrap are done, of how many, and what is being done.

    Raises:
        InputError: bad data (see `read_field_data`) or a choice that does not exist.
    """
    allowed_choice("design", design, tuple(DESIGNS))
    allowed_choice("curve", curve, tuple(CURVES))
    allowed_choice("overdispersion", overdispersion, OVERDISPERSION)
    estimated, fixed = split_choice(split, design)
    if n_bootstrap < 0:
        raise InputError(OPTIONS, "n_bootstrap", n_bootstrap, "0 or more")
    terms = random_terms(random, estimated)
    field_data = data
    if not isinstance(field_data, FieldData):
        field_data = read_field_data(field_data, design, covariates, reading, factors=terms.columns)

    model = selection_model(field_data, curve, estimated, fixed)
    pooled = fit_pooled(field_data, model, overdispersion)
    several = len(field_data.haul_names) > 1
    hauls = fit_hauls(field_data, model, overdispersion) if several else ()
    selects = pooled.outcome not in NO_SELECTION
    between = fit_between_hauls(field_data, model, hauls) if several and selects else None
    bootstrap = None
    if n_bootstrap and pooled.converged:
        bootstrap = double_bootstrap(field_data, pooled, n_bootstrap, seed, progress)
    one_stage = None
    if terms.terms and len(field_data.haul_names) >= LEAST_UNITS and selects:
        one_stage = fit_trial(field_data, curve, estimated, fixed, terms)
    alike = _pooled_in_one_stage(field_data, pooled)
    return FieldFit(
        data=field_data,
        one_stage=one_stage,
        pooled=pooled,
        hauls=hauls,
        between_hauls=between,
        bootstrap=bootstrap,
        answers=_answers(field_data, one_stage, between, bootstrap, pooled, alike),
        shown=one_stage if one_stage is not None and one_stage.converged else alike,
        overdispersion=overdispersion,
    )


def _pooled_in_one_stage(data: FieldData, pooled: Fit) -> OneStage | None:
    """The pooled curve by L50 and SR, its covariance with the dispersion; None where there is none."""
    if not pooled.converged or pooled.note:
        return None
    model = pooled.model
    same = fit_trial(data, model.curve.name, model.estimate_split, model.fixed_split, NO_TERMS)
    widened = same.maximum._replace(covariance=same.maximum.covariance * pooled.dispersion)
    return replace(same, maximum=widened) if same.converged else None


def fit_trial(data: FieldData, curve: str, estimate_split: bool, fixed_split: float, terms: RandomTerms) -> OneStage:
    """One gear in one stage, its covariates in L50 and ln SR."""
    hauls = data.haul_columns()
    formula = " + ".join(f"`{name}`" for name in data.covariate_names) or "1"
    l50, sr = (predictor(name, formula, hauls, data.source) for name in ("l50", "sr"))
    split = predictor("split", "1", hauls, data.source) if estimate_split else None
    return fit_one_stage(
        data, hauls, curve, l50, sr, split, fixed_split=fixed_split, random=terms.terms, units=units_of(hauls, terms)
    )


def _answers(
    data: FieldData,
    one_stage: OneStage | None,
    between: BetweenHauls | None,
    bootstrap: Bootstrap | None,
    pooled: Fit,
    alike: OneStage | None,
) -> tuple[Answer, ...]:
    """What is printed, the answer that simulation shows unbiased first; two stages of too few hauls last."""
    found, fished = [], data.length_cm[data.test_count + data.other_count > 0.0]
    if one_stage is not None:
        estimates, note = estimates_within(one_stage)
        found.append(Answer("one-stage", estimates, _kinds(estimates, "student t"), note))
    if between is not None:
        estimates, note = within_lengths(between.estimates, fished)
        said = "; ".join(part for part in (between.message.removeprefix("converged").strip("; "), note) if part)
        found.append(Answer("between-hauls", estimates, _kinds(estimates, "student t"), said))
    if bootstrap is not None:
        said = f"{bootstrap.n_failed} of {bootstrap.n_replicates} refits did not converge" * bool(bootstrap.n_failed)
        found.append(Answer("bootstrap", bootstrap.estimates, _kinds(bootstrap.estimates, "percentile"), said))
    estimates, kinds = pooled.estimates, _kinds(pooled.estimates, "wald")
    if alike is not None and not data.covariate_names:
        estimates, kinds = with_profile_limits(estimates, alike, pooled.dispersion)
    found.append(Answer("pooled", estimates, kinds, pooled.note))
    if one_stage is None and between is not None and not between.converged and pooled.converged:
        found = [*(answer for answer in found if answer.group != "between-hauls"), found[0]]
    return tuple(found)


def _kinds(estimates: Estimates, kind: str) -> tuple[str, ...]:
    return (kind,) * len(estimates.names)


def fit_table(fit: FieldFit) -> pd.DataFrame:
    """`fit.csv`: `group, curve, parameter, estimate, standard_error, lower_95, upper_95, interval`.

    Groups are those of `FieldFit.answers`, the answer for the gear first: "one-stage" (all hauls in one likelihood, in
    which they differ), "between-hauls" (mean of the hauls' own curves), "bootstrap" (the pooled curve, with errors and
    intervals of the double bootstrap), "pooled" (all hauls one curve), then "haul NAME" each. Parameters are named in
    `codend.selectivity.fits.parameters.parameter_names`, besides in one stage the standard deviations between hauls,
    `between_sd_l50_cm, between_sd_log_sr, between_sd_logit_split`. `interval` is its kind: "student t", "wald",
    "profile" or "percentile". What could not be estimated is NaN, and so are the error and interval of a split that is
    fixed, and an L50 that lies outside the lengths of the fish.
    """
    import pandas as pd

    model = fit.pooled.model
    hauls = [Answer(haul.group, haul.estimates, _kinds(haul.estimates, "wald"), haul.note) for haul in fit.hauls]
    frames = [
        pd.DataFrame(
            {
                "group": one.group,
                "curve": model.curve.name,
                "parameter": list(one.estimates.names),
                "estimate": one.estimates.values,
                "standard_error": one.estimates.standard_errors,
                "lower_95": one.estimates.lower_95,
                "upper_95": one.estimates.upper_95,
                "interval": one.intervals,
            }
        )
        for one in (*fit.answers, *hauls)
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
            "message": one.note or one.outcome.value,
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
