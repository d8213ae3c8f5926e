"""Retention, L50 and SR of a computed codend: for every catch and over the haul, with what makes them uncertain.

Three sets of L50 and SR are told apart, for every catch: of fish that *meet* a codend with that catch in it
(``l50_cm``); of a whole haul that *ends* with that catch, and began with none (``haul_l50_cm``), both read off the
computed curve, at 0.5 and at 0.75 less 0.25; and those of a logit curve fitted to either as to a trial with the same
number of fish in every length class (``l50_logit_cm``, ``haul_l50_logit_cm``): what a trial reports is the last, of the
whole haul. An L50 beyond the lengths that are tabled is none, nan.

Three things make them uncertain. The openings are computed with an error: L50 and SR with all of them wider and
narrower by it widen the intervals, as the root of the sum of squares. A haul meets a finite number of fish: the
intervals are those of the fitted logit curve for ``haul.fish`` fish, by the delta method for single catches, by a
parametric bootstrap for the haul (arrivals a Poisson process, so that retained and escaped fish of a class are Poisson
numbers with means n r and n (1 - r)). And the numbers of the species are known between bounds only: see
``codend.selectivity.escape.sensitivity``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from catch_models.fish import PARAMETERS, Species
from codend.selectivity.escape.catches import Run, catches_of
from codend.selectivity.escape.haul import Haul, hauls_of, terms_of_catches, terms_of_haul
from codend.selectivity.escape.haul_ends import l50_sr_of_ends, moved_by_opening_error, shares_of_ends
from codend.selectivity.escape.retention import EscapeTerms
from codend.selectivity.escape.sensitivity import SAMPLES, Sensitivity, sensitivity
from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.model import SelectionModel, selection_model
from codend.selectivity.fits.parameters import parameter_names, public_parameters
from codend.selectivity.fits.scoring import Maximum, maximise

Floats = NDArray[np.float64]

BOOTSTRAP: Final = 1000
LOWER, UPPER = 2.5, 97.5
LEAST_REFITTED: Final = 0.9
"""Share of the bootstrap's refits that must have converged for its percentiles to be given."""
PredictionProgress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Prediction:
    """One species in one haul of c catches: rows are the catches in the order of their volume, and then the haul."""

    species: Species
    haul: Haul
    terms: tuple[EscapeTerms, ...]
    """The computed curves, c + 1 of them."""
    length_cm: Floats
    """(n,)."""
    retention: Floats
    """Of those at these lengths, (c + 1, n)."""
    l50_sr: Floats
    """Of the computed curves, cm, (c + 1, 2); nan where too few fish escape to have them."""
    logit: Floats
    """L50 and SR of the logit curves fitted to them, cm, (c + 1, 2); nan where no such curve fits."""
    lower_95: Floats
    upper_95: Floats
    """Intervals of those, (c + 1, 2); nan for the haul without bootstrap."""
    end_l50_sr: Floats
    """Of whole hauls that end with each catch, off the computed curves, cm, (c, 2)."""
    end_logit: Floats
    """Of logit curves fitted to those, (c, 2)."""
    opening_reach: Floats
    """By how much the error of the openings changes L50 and SR, cm, (c + 1, 2): part of the intervals; nan: unknown."""
    fish_band: Floats | None
    """Percentiles 2.5 and 97.5 of the logit curves refitted to bootstrapped hauls, (2, n)."""
    sensitivity: Sensitivity | None

    @property
    def contact(self) -> float:
        """Probability that a fish tries a mesh at all."""
        return float(self.species.values[PARAMETERS.index("behaviour.contact")])


def predict(
    run: Run,
    species: Sequence[Species],
    *,
    n_bootstrap: int = BOOTSTRAP,
    samples: int = SAMPLES,
    seed: int = 0,
    progress: PredictionProgress | None = None,
) -> list[Prediction]:
    """Selectivity of a study for every species, a haul for every speed.

    Args:
        run: the study's plan and tables (``codend.selectivity.escape.catches.run_of`` or ``read_run``).
        species: whom to ask for.
        n_bootstrap: replicates of the haul; 0 for none.
        samples: of the Sobol design, a power of 2; 0 leaves the sensitivity out.
        seed: of the bootstrap and the design.
        progress: told how many species and hauls are done, of how many, and which is being done.

    Raises:
        InputError: no case of the study was solved.
    """
    hauls = hauls_for(run, species)
    work = [(one, haul) for one in species for haul in hauls]
    found = []
    for done, (one, haul) in enumerate(work):
        if progress is not None:
            progress(done, len(work), f"{one.name} at {haul.speed_m_s:g} m/s")
        found.append(predict_haul(one, haul, n_bootstrap=n_bootstrap, samples=samples, seed=seed))
    if progress is not None:
        progress(len(work), len(work), "done")
    return found


def hauls_for(run: Run, species: Sequence[Species]) -> list[Haul]:
    """A haul for every speed of a study, with the rows of meshes that any of the species needs."""
    return hauls_of(catches_of(run, max(rows_needed(one) for one in species)))


def rows_needed(species: Species) -> float:
    """Rows of meshes ahead of the front that fish of the species may try."""
    if species.zone:
        return float("inf")
    if species.along is not None:
        return species.along.rows_ahead[-1]
    column = PARAMETERS.index("behaviour.rows_ahead")
    return float(max(species.values[column], species.ranges.get(PARAMETERS[column], (0, 0))[1]))


def predict_haul(
    species: Species, haul: Haul, *, n_bootstrap: int = BOOTSTRAP, samples: int = SAMPLES, seed: int = 0
) -> Prediction:
    """Selectivity of one species in one haul; arguments as those of ``predict``."""
    of_catches = terms_of_catches(haul, species)
    every = [*of_catches, terms_of_haul(haul, of_catches, species)]
    length_cm = species.length_cm
    retention = np.array([terms.retention(length_cm) for terms in of_catches])
    # a mean of ones may be more than one by round-off, and fish that escape are no negative number
    retention = np.vstack([retention, np.minimum(haul.time_shares(species) @ retention, 1.0)])
    per_class = species.haul.fish.value / len(length_cm)

    model, shares = _logit_model(length_cm), shares_of_ends(haul, species)
    of_ends = np.minimum(shares @ retention[:-1], 1.0)
    fitted = maximise(model, per_class * retention, per_class * (1.0 - retention))
    ends = maximise(model, per_class * of_ends, per_class * (1.0 - of_ends))
    logit, errors = _l50_sr(model, fitted)
    half = float(ndtri(0.975)) * errors
    lower, upper, band = logit - half, logit + half, None
    lower[-1] = upper[-1] = np.nan
    if n_bootstrap and fitted.converged[-1]:
        rng = np.random.default_rng(seed)
        shape = (n_bootstrap, len(length_cm))
        escaped = rng.poisson(per_class * (1.0 - retention[-1]), shape).astype(float)
        refitted = maximise(model, rng.poisson(per_class * retention[-1], shape).astype(float), escaped)
        good = refitted.converged
        if good.mean() >= LEAST_REFITTED:
            replicates, _ = _l50_sr(model, refitted)
            lower[-1], upper[-1] = np.percentile(replicates[good], (LOWER, UPPER), axis=0)
            parameters = public_parameters(model, refitted.theta[good])[0][:, :2]
            band = np.percentile(model.curve.retention(length_cm, parameters), (LOWER, UPPER), axis=0)
    moved = moved_by_opening_error(haul, species)
    widened = np.nan_to_num(moved)
    inside = _inside(length_cm)
    logit = inside(logit)
    return Prediction(
        species=species,
        haul=haul,
        terms=tuple(every),
        length_cm=length_cm,
        retention=retention,
        l50_sr=inside(np.array([terms.l50_sr() for terms in every])),
        logit=logit,
        lower_95=logit - np.hypot(logit - lower, widened),
        upper_95=logit + np.hypot(upper - logit, widened),
        end_l50_sr=inside(l50_sr_of_ends(of_catches, shares)),
        end_logit=inside(_l50_sr(model, ends)[0]),
        opening_reach=moved,
        fish_band=band,
        sensitivity=sensitivity(haul, species, samples, seed) if samples else None,
    )


def _inside(length_cm: Floats) -> Callable[[Floats], Floats]:
    """L50 and SR where L50 lies within the lengths, else nan."""

    def within(l50_sr: Floats) -> Floats:
        l50 = l50_sr[:, :1]
        return np.where((l50 >= length_cm[0]) & (l50 <= length_cm[-1]), l50_sr, np.nan)

    return within


def _logit_model(length_cm: Floats) -> SelectionModel:
    """Covered codend without raising, one row a length class."""
    none, one = np.zeros(len(length_cm)), np.ones(len(length_cm))
    rows = FieldData(
        source="computed retention",
        design="covered",
        haul_names=("haul",),
        haul=np.zeros(len(length_cm), dtype=np.int64),
        length_cm=length_cm,
        test_count=none,
        other_count=none,
        test_raising=one,
        other_raising=one,
        covariate_names=(),
        covariates=np.empty((1, 0)),
    )
    return selection_model(rows, "logit")


def _l50_sr(model: SelectionModel, fitted: Maximum) -> tuple[Floats, Floats]:
    """L50 and SR of many fits, (B, 2), and their standard errors."""
    names = parameter_names(model)
    which = [names.index("l50_cm"), names.index("sr_cm")]
    values, jacobian = public_parameters(model, fitted.theta)
    jacobian = jacobian[:, which]
    return values[:, which], np.sqrt(np.einsum("bmi,bij,bmj->bm", jacobian, fitted.covariance, jacobian))
