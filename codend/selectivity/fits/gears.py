"""Gears beside each other, and L50, SR and split by formulas: one likelihood for all hauls of all gears.

    fit = fit_gears("trial.csv", "covered", group="gear", covariates=["catch_kg"])
    fit = fit_gears("trial.csv", "paired", split="estimated", l50="gear * catch_kg", sr="gear", split_by="gear")

Standard deviations between hauls, and the shape of a Richards or dual curve, are the same for all gears.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, ndtr

from codend.errors import OPTIONS, InputError
from codend.selectivity.fits.choices import (
    LEAST_UNITS,
    RandomTerms,
    allowed_choice,
    random_terms,
    split_choice,
    units_of,
)
from codend.selectivity.fits.curves import CURVES
from codend.selectivity.fits.families import FAMILIES
from codend.selectivity.fits.fielddata import DESIGNS, FieldData, read_field_data
from codend.selectivity.fits.fit import Fit, fit_hauls, fit_pooled
from codend.selectivity.fits.haul_table import AS_IT_STANDS, HaulReading
from codend.selectivity.fits.marginal_maximum import refused
from codend.selectivity.fits.model import selection_model, without_covariates
from codend.selectivity.fits.one_stage import OneStage, fit_one_stage
from codend.selectivity.fits.one_stage_estimates import delta_estimates, estimates_within
from codend.selectivity.fits.parameters import Estimates
from codend.selectivity.fits.predictors import columns_of, predictor
from codend.selectivity.fits.scoring import NO_SELECTION

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]


class Difference(NamedTuple):
    """L50 and SR of a first gear minus those of a second."""

    first: str
    second: str
    estimates: Estimates


@dataclass(frozen=True)
class GearFit:
    """A one-stage fit of several gears, or of one by formulas.

    Attributes:
        one: the fit.
        alike: the same without the group: one curve for all gears; None without a group.
        hauls: a curve for each haul from its own fish; empty for a curve that single hauls are not fitted with.
        notes: what must be said.
    """

    one: OneStage
    alike: OneStage | None
    hauls: tuple[Fit, ...]
    notes: tuple[str, ...]

    @property
    def converged(self) -> bool:
        """Whether the estimates are a maximum of the likelihood."""
        return self.one.converged

    @property
    def p_value(self) -> float:
        """Of the likelihood-ratio test that all gears have one curve and one split; NaN without a group."""
        if self.alike is None or not (self.one.converged and self.alike.converged):
            return float("nan")
        ratio = 2.0 * (self.one.log_likelihood - self.alike.log_likelihood)
        return float(chdtrc(self.one.model.n_parameters - self.alike.model.n_parameters, max(ratio, 0.0)))

    def differences(self, at: Mapping[str, str | float] | None = None) -> list[Difference]:
        """Of every pair of gears, the later minus the earlier in the table."""
        found = []
        for second, first in combinations(self.one.levels, 2):
            points = self.one.point(first, at), self.one.point(second, at)

            def change(theta: Array, points: tuple = points) -> Array:
                (l50, sr, _), (other_l50, other_sr, _) = (self.one.curve_at(point, theta) for point in points)
                return np.array([l50 - other_l50, sr - other_sr])

            names = ("l50_cm difference", "sr_cm difference")
            found.append(Difference(first, second, delta_estimates(self.one, names, change)))
        return found


def fit_gears(
    data: str | Path | pd.DataFrame | FieldData,
    design: str,
    curve: str = "logit",
    split: str | float = "equal",
    *,
    group: str = "",
    covariates: Sequence[str] = (),
    l50: str = "",
    sr: str = "",
    split_by: str = "",
    random: str = "haul",
    reading: HaulReading = AS_IT_STANDS,
) -> GearFit:
    """Fit gears, factors and covariates in one likelihood.

    Args:
        data: CSV file or DataFrame as described in `read_field_data`, or what that read with the group as a factor.
        design: "covered" or "paired".
        curve: name in `FAMILIES`: logit, probit, gompertz, cloglog, richards, dual.
        split: paired gear: "equal", "estimated", or the share of the fish that enter the test gear.
        group: column with the gear of each haul; L50, SR and an estimated split differ between gears.
        covariates: numeric columns, constant within a haul, on which L50 and ln SR depend linearly.
        l50: formula of columns for L50, such as "gear * catch_kg", instead of the group and covariates.
        sr: the same for ln SR.
        split_by: the same for the logit of the split.
        random: as in `fit_field_data`.
        reading: likewise.

    Raises:
        InputError: bad data, a formula that cannot be read, a choice that does not exist.
    """
    allowed_choice("curve", curve, tuple(FAMILIES))
    allowed_choice("design", design, tuple(DESIGNS))
    factors = (group,) if group else ()
    estimated, fixed = split_choice(split, design)
    terms = random_terms(random, estimated)
    named = (*factors, *terms.columns)
    formulas = {"l50": l50, "sr": sr, "split_by": split_by}.items()
    in_formulas = [column for name, formula in formulas for column in columns_of(name, formula) if column not in named]
    field = data
    if not isinstance(field, FieldData):
        field = read_field_data(field, design, covariates, reading, factors=named, in_formulas=in_formulas)
    if split_by and not estimated:
        raise InputError(OPTIONS, "split_by", split_by, "a formula together with the split estimated")
    hauls = field.haul_columns()
    if group and hauls[group].nunique() < 2:
        raise InputError(field.source, group, hauls[group].iloc[0], "at least two gears", "is the only one")
    units = units_of(hauls, terms)

    def fit(names: Sequence[str]) -> OneStage:
        both = " + ".join(f"`{name}`" for name in names) or "1"
        of_split = " + ".join(f"`{name}`" for name in names if name == group) or "1"
        return fit_one_stage(
            field,
            hauls,
            curve,
            predictor("l50", l50 or both, hauls, field.source),
            predictor("sr", sr or both, hauls, field.source),
            predictor("split_by", split_by or of_split, hauls, field.source) if estimated else None,
            fixed_split=fixed,
            random=terms.terms if len(hauls) >= LEAST_UNITS else (),
            units=units,
            group=group,
        )

    one = fit([*factors, *covariates])
    alike = replace(fit(covariates), group="") if group and not (l50 or sr or split_by) else None
    pooled = fit_pooled(field, without_covariates(selection_model(field, "logit", estimated, fixed)))
    if pooled.outcome in NO_SELECTION:
        one = replace(one, maximum=refused(one.maximum))
        notes = [pooled.outcome.value]
    else:
        notes = _notes(one, terms)
    alone = fit_hauls(field, selection_model(field, curve, estimated, fixed)) if curve in CURVES else ()
    return GearFit(one, alike, alone, tuple(notes))


def gear_table(fit: GearFit) -> pd.DataFrame:
    """`fit.csv` of gears: as `codend.selectivity.fits.analysis.fit_table`, groups "GEAR" and "GEAR minus GEAR"."""
    import pandas as pd

    groups: list[tuple[str, Estimates]] = [
        (level or "one-stage", estimates_within(fit.one, level)[0]) for level in fit.one.levels
    ]
    groups += [(f"{found.first} minus {found.second}", found.estimates) for found in fit.differences()]
    kind = "student t" if fit.one.model.random else "wald"
    table = pd.concat(
        [
            pd.DataFrame(
                {
                    "group": group,
                    "curve": fit.one.model.family.name,
                    "parameter": list(estimates.names),
                    "estimate": estimates.values,
                    "standard_error": estimates.standard_errors,
                    "lower_95": estimates.lower_95,
                    "upper_95": estimates.upper_95,
                    "interval": kind,
                }
            )
            for group, estimates in groups
        ],
        ignore_index=True,
    )
    if fit.one.split is None:
        table.loc[table["parameter"] == "split", ["standard_error", "lower_95", "upper_95"]] = np.nan
    return table


def coefficient_table(one: OneStage) -> pd.DataFrame:
    """`coefficients.csv`: `of, term, estimate, standard_error, z, p_value`, a row a term of the formulas.

    `of` is l50_cm, log_sr or logit_split; the coefficients are those of the formula's own columns.
    """
    import pandas as pd

    at, rows = one.model.slices, []
    parts = (("l50_cm", "l50", one.l50), ("log_sr", "sr", one.log_sr), ("logit_split", "split", one.split))
    for of, part, columns in parts:
        if columns is None:
            continue
        value = columns.to_basis @ one.theta[at[part]]
        spread = columns.to_basis @ one.maximum.covariance[at[part], at[part]] @ columns.to_basis.T
        errors = np.sqrt(np.diagonal(spread))
        for term, estimate, error in zip(columns.terms, value, errors, strict=True):
            z = estimate / error
            p_value = 2.0 * float(ndtr(-abs(z)))
            rows.append(
                {"of": of, "term": term, "estimate": estimate, "standard_error": error, "z": z, "p_value": p_value}
            )
    return pd.DataFrame(rows)


def _one_sided(one: OneStage) -> list[str]:
    """Gears that caught all of their fish in one of the two columns of counts, so that no curve can be told."""
    data, found = one.data, []
    names = DESIGNS[data.design]
    for level in filter(None, one.levels):
        of_level = (one.hauls[one.group].to_numpy() == level)[data.haul]
        for column, counts in zip(names, (data.test_count, data.other_count), strict=True):
            if not counts[of_level].any():
                found.append(f"{level} has no fish in {column}, which tells of no curve: leave it out with --only")
    return found


def _notes(one: OneStage, terms: RandomTerms) -> list[str]:
    notes = [] if one.converged else [*_one_sided(one), one.maximum.outcome.value]
    for level in one.levels:
        said = estimates_within(one, level)[1] if one.converged else ""
        notes += [f"{level}: {said}" if level else said] * bool(said)
    if terms.terms and not one.model.random:
        notes.append(f"fewer than {LEAST_UNITS} hauls: they are taken not to differ but by chance")
    return notes
