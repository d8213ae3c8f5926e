"""Numbers of a species estimated from field data: maximum likelihood through the predicted retention.

A trial's counts are binomial as in ``codend.selectivity.fits.model``, but with the predicted retention r of the
computed codend in place of a fitted curve. Each haul has the retention of a haul that ends with its own catch, where
the catch is known, and that of the whole study otherwise:

    covered   zeta = ln r - ln(1 - r) + ln(c1/c2)          paired   zeta = ln r + ln(p/(1 - p)) + ln(c1/c2)

The maximum is found by Fisher scoring with derivatives by central differences, kept within the bounds of every number.
Intervals are those of the profile likelihood, 2 (l_max - l(x)) <= 3.84 times the dispersion factor (see
``codend.selectivity.fits.fit.dispersion_factor``). A number is identified when the likelihood limits it on at least one
side and the estimate is not at an end of its range; an end that the allowed range sets is told apart.

All other numbers of the species are taken as exact, and so is the computed codend: what is wrong with them goes into
the calibrated numbers. Lack of fit (deviance, p-value) tells when no values of them can explain the trial: below 0.001
there is no calibration, and no species bears its numbers. Hauls that
differ from each other by more than the dispersion factor says make the intervals too short.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, chdtri

from catch_models.fish import Sourced, Species
from codend.errors import OPTIONS, InputError
from codend.selectivity.escape.haul import Haul
from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.predicted_and_observed.retention_likelihood import (
    AT_BOUND,
    BOUNDS,
    SPLIT,
    TOGETHER,
    RetentionLikelihood,
    Trialled,
)

Floats = NDArray[np.float64]

NAMES: Final = {"spread": "spread.size", "push": "behaviour.push_force_n"} | {
    name.split(".")[1]: name for name in BOUNDS
}
"""Short names; "spread" is the spread of sizes, "compression" that of height and width."""
MOST_CATCHES: Final = 12
"""Catches of the study through which the likelihood goes, evenly spread, the smallest and largest among them."""
MARGIN: Final = 1e-3
"""By which a catch may exceed the largest computed: tables are rounded."""
LEAST_P: Final = 1e-3
"""Chance of so large a deviance, below which no values of the numbers explain the trial."""
CRITICAL: Final = float(chdtri(1, 0.05))


@dataclass(frozen=True)
class Calibration:
    """Calibrated numbers, k of them; every estimate is nan where ``converged`` is False."""

    names: tuple[str, ...]
    """Dotted names, and "split" at the end where it was estimated."""
    values: Floats
    lower_95: Floats
    upper_95: Floats
    limited: NDArray[np.bool_]
    """Whether the likelihood, and not the allowed range, sets the lower and the upper end, (k, 2)."""
    at_bound: NDArray[np.bool_]
    """Whether the estimate lies at an end of the allowed range, (k,)."""
    deviance: float
    degrees_of_freedom: int
    p_value: float
    dispersion: float
    converged: bool
    message: str
    species: Species
    """With the calibrated numbers and their source; as it was where they do not explain the trial."""

    @property
    def identified(self) -> NDArray[np.bool_]:
        """Whether the data limit each number at all, and leave it within its range, (k,); none where none explains."""
        return np.asarray(self.limited.any(axis=1) & ~self.at_bound & self.explains)

    @property
    def explains(self) -> bool:
        """Whether the calibrated numbers explain the trial; where not, they are no calibration."""
        return self.converged and not self.p_value < LEAST_P


def calibrated_names(asked: Sequence[str]) -> tuple[str, ...]:
    """Dotted names of numbers asked for by their own, their short or their dotted name.

    Raises:
        InputError: a name that is none of a number that can be calibrated, or is given twice.
    """
    found = tuple(NAMES.get(name, name) for name in asked)
    for name, dotted in zip(asked, found, strict=True):
        if dotted not in BOUNDS or found.count(dotted) > 1:
            raise InputError(OPTIONS, "calibrate", name, f"{', '.join(NAMES)}, each once")
    if not found:
        raise InputError(OPTIONS, "calibrate", "", ", ".join(NAMES))
    return found


def calibrate(
    haul: Haul,
    species: Species,
    data: FieldData,
    names: Sequence[str],
    *,
    estimate_split: bool = False,
    volume_m3: Floats | None = None,
    source: str = "",
    also: Sequence[Trialled] = (),
) -> Calibration:
    """Estimate numbers of a species from a trial with the codend of a study, or from several, each with its own.

    Args:
        haul: the computed catches.
        species: all other numbers, and the starting values.
        data: the counted fish.
        names: of the numbers, as in ``calibrated_names``.
        estimate_split: paired gear: estimate the split p, else it is 0.5.
        volume_m3: final catch of every haul of the trial, (H,); None: every haul is the whole of ``haul``.
        source: what the calibrated species names as its numbers' source; left out, the data's files.
        also: other codends and the hauls with them, fitted jointly: one set of numbers for all.

    Raises:
        InputError: an unknown name, a field haul with a larger catch than any computed, or a split of several trials.
    """
    dotted = calibrated_names(names)
    trials = [Trialled(haul, data, volume_m3), *also]
    if estimate_split and also:
        raise InputError(OPTIONS, "split", "estimated", "equal where several codends are calibrated on jointly")
    for one in trials:
        _check_catches(one)
    thinned = [replace(one, haul=one.haul.thinned(MOST_CATCHES)) for one in trials]
    likelihood = RetentionLikelihood(thinned, species, dotted, estimate_split)
    k = len(likelihood.names)
    found = likelihood.maximise(likelihood.start(), np.ones(k, dtype=bool))
    deviance, degrees, dispersion = likelihood.lack_of_fit(found.x)
    numbers, limited, trouble = np.full((3, k), np.nan), np.zeros((k, 2), dtype=bool), ""
    if not found.converged:
        trouble = "no maximum of the likelihood was reached"
    else:
        ends = [[likelihood.end(found, i, side, CRITICAL * dispersion) for side in range(2)] for i in range(k)]
        trouble = next((end.trouble for pair in ends for end in pair if end.trouble), "")
    converged, message = not trouble, f"{trouble}; calibrate fewer numbers" if trouble else "converged"
    if converged:
        limited = np.array([[end.limited for end in pair] for pair in ends])
        lower, upper = np.array([[end.x for end in pair] for pair in ends]).T
        numbers = np.array([likelihood.natural(x) for x in (found.x, lower, upper)])
        unknown = [name for name, sides in zip(likelihood.names, limited, strict=True) if not sides.any()]
        if unknown:
            message += f"; not identified, any allowed value will do: {', '.join(unknown)}"
        # an end of the range that the estimate lies at is no answer of the data
        bound = [name for name, at in zip(likelihood.names, _at_bound(found.x), strict=True) if at]
        if bound:
            message += f"; at the end of what is allowed, and so not identified: {', '.join(bound)}"
    result = Calibration(
        names=likelihood.names,
        values=numbers[0],
        lower_95=numbers[1],
        upper_95=numbers[2],
        limited=limited,
        at_bound=_at_bound(found.x),
        deviance=deviance,
        degrees_of_freedom=degrees,
        p_value=float(chdtrc(degrees, deviance)) if degrees > 0 else np.nan,
        dispersion=dispersion,
        converged=converged,
        message=message,
        species=species,
    )
    if converged and not result.explains:
        message += f"; no calibration: no values of these numbers explain the trial (p = {result.p_value:.1g})"
        return replace(result, message=message)
    named = source or ", ".join(Path(one.data.source).name for one in trials)
    return _with_species(result, named) if converged else result


def _at_bound(x: Floats) -> NDArray[np.bool_]:
    return np.asarray((x < AT_BOUND) | (x > 1.0 - AT_BOUND))


def _check_catches(trial: Trialled) -> None:
    """Refuse a haul whose catch is larger than any computed."""
    largest, volume_m3, data = trial.haul.volume_m3[-1], trial.volume_m3, trial.data
    if volume_m3 is not None and volume_m3.max() > largest * (1.0 + MARGIN):
        h = int(volume_m3.argmax())
        allowed = f"at most {largest:.4g} m3, the largest computed: add larger catches to the plan"
        raise InputError(data.source, f"catch of haul {data.haul_names[h]}", float(volume_m3[h]), allowed)


def _with_species(found: Calibration, source: str) -> Calibration:
    tables = found.species.model_dump(exclude_none=True)
    for i, name in enumerate(found.names):
        if name == SPLIT:
            continue
        said = f"calibrated on {source}" if found.identified[i] else f"assumed: {source} does not identify it"
        ends = {"low": float(found.lower_95[i]), "high": float(found.upper_95[i])}
        number = Sourced[float](value=float(found.values[i]), source=said, **ends)
        for one in TOGETHER.get(name, (name,)):
            table, key = one.split(".")
            tables[table][key] = number.model_dump()
    return replace(found, species=Species.model_validate(tables))
