"""Numbers of a species estimated from field data: maximum likelihood through the predicted retention.

A trial's counts are binomial as in ``codend.selectivity.fits.model``, but with the predicted retention r of the
computed codend in place of a fitted curve. Each haul has the retention of a haul that ends with its own catch, where
the catch is known, and that of the whole study otherwise:

    covered   zeta = ln r - ln(1 - r) + ln(c1/c2)          paired   zeta = ln r + ln(p/(1 - p)) + ln(c1/c2)

The maximum is found by Fisher scoring with derivatives by central differences, kept within the bounds of every number.
Intervals are those of the profile likelihood, 2 (l_max - l(x)) <= 3.84 times the dispersion factor (see
``codend.selectivity.fits.fit.dispersion_factor``). A number is identified when the likelihood limits it on at least one
side; an end that the allowed range sets is told apart.

All other numbers of the species are taken as exact, and so is the computed codend: what is wrong with them goes into
the calibrated numbers. Lack of fit (deviance, p-value) tells when no values of them can explain the trial. Hauls that
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
from codend.selectivity.predicted_and_observed.retention_likelihood import BOUNDS, SPLIT, RetentionLikelihood

Floats = NDArray[np.float64]

NAMES: Final = {"spread": "spread.size"} | {name.split(".")[1]: name for name in BOUNDS}
"""Short names; "spread" is the spread of sizes."""
MOST_CATCHES: Final = 12
"""Catches of the study through which the likelihood goes, evenly spread, the smallest and largest among them."""
MARGIN: Final = 1e-3
"""By which a catch may exceed the largest computed: tables are rounded."""
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
    deviance: float
    degrees_of_freedom: int
    p_value: float
    dispersion: float
    converged: bool
    message: str
    species: Species
    """With the calibrated numbers and their source; as it was where ``converged`` is False."""

    @property
    def identified(self) -> NDArray[np.bool_]:
        """Whether the data limit each number at all, (k,)."""
        return np.asarray(self.limited.any(axis=1))


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
) -> Calibration:
    """Estimate numbers of a species from a trial with the codend of a study.

    Args:
        haul: the computed catches.
        species: all other numbers, and the starting values.
        data: the counted fish.
        names: of the numbers, as in ``calibrated_names``.
        estimate_split: paired gear: estimate the split p, else it is 0.5.
        volume_m3: final catch of every haul of the trial, (H,); None: every haul is the whole of ``haul``.
        source: what the calibrated species names as its numbers' source; left out, the data's file.

    Raises:
        InputError: an unknown name, or a field haul with a larger catch than any computed.
    """
    dotted = calibrated_names(names)
    if volume_m3 is not None and volume_m3.max() > haul.volume_m3[-1] * (1.0 + MARGIN):
        h = int(volume_m3.argmax())
        allowed = f"at most {haul.volume_m3[-1]:.4g} m3, the largest computed: add larger catches to the plan"
        raise InputError(data.source, f"catch of haul {data.haul_names[h]}", float(volume_m3[h]), allowed)
    likelihood = RetentionLikelihood(haul.thinned(MOST_CATCHES), species, data, dotted, estimate_split, volume_m3)
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
    result = Calibration(
        names=likelihood.names,
        values=numbers[0],
        lower_95=numbers[1],
        upper_95=numbers[2],
        limited=limited,
        deviance=deviance,
        degrees_of_freedom=degrees,
        p_value=float(chdtrc(degrees, deviance)) if degrees > 0 else np.nan,
        dispersion=dispersion,
        converged=converged,
        message=message,
        species=species,
    )
    return _with_species(result, source or Path(data.source).name) if converged else result


def _with_species(found: Calibration, source: str) -> Calibration:
    tables = found.species.model_dump(exclude_none=True)
    for i, name in enumerate(found.names):
        if name == SPLIT:
            continue
        said = f"calibrated on {source}" if found.identified[i] else f"assumed: {source} does not identify it"
        table, key = name.split(".")
        ends = {"low": float(found.lower_95[i]), "high": float(found.upper_95[i])}
        number = Sourced[float](value=float(found.values[i]), source=said, **ends)
        tables[table][key] = number.model_dump()
    return replace(found, species=Species.model_validate(tables))
