"""What a one-stage fit predicts, as tables: retention at given covariates, differences of gears, usability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codend.errors import OPTIONS, InputError
from codend.selectivity.fits.compare_gears import INDICATORS, fished_population, usability
from codend.selectivity.fits.one_stage import OneStage, Point
from codend.selectivity.fits.one_stage_estimates import Band, covariance_root, delta_band, estimates, retention_band

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
Values = Mapping[str, str | float]

DRAWS: Final = 2000
LENGTHS: Final = 121


@dataclass(frozen=True)
class Drawn:
    """Curves of one gear drawn from the normal distribution of the estimates, as `usability` takes them.

    Attributes:
        fit: a converged fit.
        point: the gear, at its covariates.
        seed: of the draws.
    """

    fit: OneStage
    point: Point
    seed: int = 0

    def retention(self, length_cm: ArrayLike) -> tuple[Array, Array]:
        """Retention of the fit (n,) and of the draws (S, n)."""
        deviates = np.random.default_rng(self.seed).standard_normal((DRAWS, self.fit.theta.size))
        thetas = self.fit.theta + deviates @ covariance_root(self.fit.maximum.covariance).T
        drawn = np.array([self.fit.retention_at(self.point, length_cm, theta) for theta in thetas])
        return self.fit.retention_at(self.point, length_cm, self.fit.theta), drawn

    def interval(self, estimate: Array, replicates: Array) -> tuple[Array, Array]:
        """95 % percentile limits of any function of the draws (S, ...)."""
        lower, upper = np.percentile(replicates, [2.5, 97.5], axis=0)
        return lower, upper


def settings(fit: OneStage, texts: Sequence[str]) -> list[dict[str, str | float]]:
    """Read covariates to predict at, each `NAME=VALUE,NAME=VALUE`.

    Raises:
        InputError: a name that no formula uses, a value that is no number, or none of a factor's.
    """
    used = {
        name for one in (fit.l50, fit.log_sr, fit.split) if one and one.spec for name in one.spec.required_variables
    }
    known = [str(name) for name in fit.hauls.columns if name in used and name != fit.group]
    return [_setting(fit, text, known) for text in texts]


def _setting(fit: OneStage, text: str, known: Sequence[str]) -> dict[str, str | float]:
    found: dict[str, str | float] = {}
    for pair in text.split(","):
        name, equals, value = (part.strip() for part in pair.partition("="))
        if not equals or name not in known:
            raise InputError(
                OPTIONS, "--at", text, f"NAME=VALUE with what formulas use ({', '.join(known) or 'nothing'})"
            )
        cells = fit.hauls[name]
        if cells.dtype.kind != "f":
            if value not in set(cells):
                raise InputError(OPTIONS, f"--at {name}", value, ", ".join(dict.fromkeys(cells)))
            found[name] = value
            continue
        try:
            found[name] = float(value)
        except ValueError:
            found[name] = np.nan
        if not np.isfinite(found[name]):
            raise InputError(OPTIONS, f"--at {name}", value, "a number")
    return found


def lengths_of(fit: OneStage) -> Array:
    """Lengths over which curves are drawn: those of the fish, finely."""
    fished = fit.data.length_cm[fit.data.test_count + fit.data.other_count > 0.0]
    return np.linspace(fished.min(), fished.max(), LENGTHS)


def retention_bands(fit: OneStage, at: Sequence[Values] = ({},)) -> dict[tuple[str, str], Band]:
    """Curves with bands by gear and by what they are at, in words; an empty `at` is the mean over hauls."""
    length = lengths_of(fit)
    return {
        (level, at_text(fit, values)): retention_band(fit, fit.point(level, values), length)
        for values in at
        for level in fit.levels
    }


def prediction_table(fit: OneStage, at: Sequence[Values] = ({},)) -> pd.DataFrame:
    """`predictions.csv`: retention of every gear at every setting, of a haul that deviates in nothing.

    Columns: `gear, at, l50_cm, sr_cm, length_cm, retention, lower_95, upper_95, lower_all_95, upper_all_95`; `_all_`
    are simultaneous over lengths.
    """
    import pandas as pd

    frames = []
    for values in at:
        for level in fit.levels:
            found, band = estimates(fit, level, values), retention_band(fit, fit.point(level, values), lengths_of(fit))
            head = {"gear": level, "at": at_text(fit, values), "l50_cm": found["l50_cm"], "sr_cm": found["sr_cm"]}
            frames.append(pd.DataFrame(head | _columns(band, "retention")))
    return pd.concat(frames, ignore_index=True)


def delta_bands(fit: OneStage, at: Values | None = None) -> dict[tuple[str, str], Band]:
    """Retention of a later gear of the table minus that of an earlier one, for every pair."""
    length = lengths_of(fit)
    return {
        (first, second): delta_band(fit, fit.point(first, at), fit.point(second, at), length)
        for second, first in combinations(fit.levels, 2)
    }


def delta_table(fit: OneStage) -> pd.DataFrame:
    """`delta.csv`: `first, second, length_cm, difference, lower_95, upper_95, lower_all_95, upper_all_95, significant`.

    `significant` where the simultaneous band leaves out zero.
    """
    import pandas as pd

    frames = [
        pd.DataFrame(
            {"first": first, "second": second} | _columns(band, "difference") | {"significant": band.significant}
        )
        for (first, second), band in delta_bands(fit).items()
    ]
    return pd.concat(frames, ignore_index=True)


def usability_table(fit: OneStage, reference_length_cm: float) -> pd.DataFrame:
    """`usability.csv`: `gear, indicator, percent, lower_95, upper_95` for the fish of all hauls together.

    Indicators as in `codend.selectivity.fits.compare_gears.Usability`.
    """
    import pandas as pd

    length, numbers = fished_population(fit.data)
    rows = []
    for level in fit.levels:
        found = usability(Drawn(fit, fit.point(level)), length, numbers, reference_length_cm)
        for name in INDICATORS:
            one = getattr(found, name)
            limits = {"percent": one.percent, "lower_95": one.lower_95, "upper_95": one.upper_95}
            rows.append({"gear": level, "indicator": name, **limits})
    return pd.DataFrame(rows)


def at_text(fit: OneStage, values: Values) -> str:
    """A setting in words."""
    if values:
        return ", ".join(
            f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}" for name, value in values.items()
        )
    used = {name for one in (fit.l50, fit.log_sr) if one.spec for name in one.spec.required_variables} - {fit.group}
    return "mean of hauls" if used else ""


def _columns(band: Band, name: str) -> dict[str, Array]:
    return {
        "length_cm": band.length_cm,
        name: band.value,
        "lower_95": band.lower_95,
        "upper_95": band.upper_95,
        "lower_all_95": band.lower_all_95,
        "upper_all_95": band.upper_all_95,
    }
