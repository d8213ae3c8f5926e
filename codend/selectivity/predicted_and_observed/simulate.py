"""Simulated selectivity trials with known truth: for testing fits and for planning how many fish a trial needs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from codend.selectivity.escape.haul import Haul, shares_until, terms_of_catches, terms_of_haul
from codend.selectivity.fits.curves import CURVES
from codend.selectivity.fits.fielddata import DESIGNS, FieldData

if TYPE_CHECKING:
    import pandas as pd

    from catch_models.fish import Species

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SimulatedTrial:
    """A trial whose every haul meets the same expected fish.

    Attributes:
        curve: name of the retention curve.
        parameters: its parameters a, b (and delta), those of the mean curve when hauls differ.
        design: "covered" or "paired".
        length_cm: (n,) length classes.
        expected_fish: (n,) expected number of fish a haul meets (both gears together for paired gear).
        n_hauls: number of hauls.
        split: paired gear: the share p of the fish met that enter the test gear.
        test_raising, other_raising: raising factors; fish are counted with probability 1 / factor.
        between_covariance: (k, k) covariance of the curve's parameters between hauls; zero when hauls are alike.
    """

    curve: str
    parameters: tuple[float, ...]
    design: str
    length_cm: Array
    expected_fish: Array
    n_hauls: int = 1
    split: float = 0.5
    test_raising: float = 1.0
    other_raising: float = 1.0
    between_covariance: Array | None = None

    def rows(self) -> FieldData:
        """The trial's table, without fish."""
        haul = np.repeat(np.arange(self.n_hauls), self.length_cm.size)
        none = np.zeros(haul.size)
        return FieldData(
            source="simulation",
            design=self.design,
            haul_names=tuple(str(h + 1) for h in range(self.n_hauls)),
            haul=haul,
            length_cm=np.tile(self.length_cm, self.n_hauls),
            test_count=none,
            other_count=none,
            test_raising=np.full(haul.size, self.test_raising),
            other_raising=np.full(haul.size, self.other_raising),
            covariate_names=(),
            covariates=np.empty((self.n_hauls, 0)),
        )

    def counts(self, n_trials: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """Counted fish of the two gears in `n_trials` repetitions, each (n_trials, R): independent Poisson numbers.

        Given their sum, the numbers of the two gears at one length are binomial, as the likelihood has it.
        """
        parameters = np.broadcast_to(self.parameters, (n_trials, self.n_hauls, len(self.parameters)))
        if self.between_covariance is not None:
            shift = rng.multivariate_normal(
                np.zeros(len(self.parameters)), self.between_covariance, parameters.shape[:2]
            )
            parameters = parameters + shift
        retained = CURVES[self.curve].retention(self.length_cm, parameters).reshape(n_trials, -1)
        met = np.tile(self.expected_fish, self.n_hauls)
        if self.design == "covered":
            test_mean, other_mean = met * retained, met * (1.0 - retained)
        else:
            test_mean, other_mean = met * self.split * retained, met * (1.0 - self.split) * np.ones_like(retained)
        test = rng.poisson(test_mean / self.test_raising)
        other = rng.poisson(other_mean / self.other_raising)
        return test.astype(float), other.astype(float)


def parameters_of(curve: str, l50_cm: float, sr_cm: float, delta: float | None = None) -> tuple[float, ...]:
    """Parameters a, b (and delta, for a curve with a shape) of the curve with given L50 and selection range."""
    shape = () if delta is None else (delta,)
    l50_at_unit_slope, sr_at_unit_slope = CURVES[curve].l50_sr((0.0, 1.0, *shape))
    b = float(sr_at_unit_slope) / sr_cm
    return (float(l50_at_unit_slope) - b * l50_cm, b, *shape)


def computed_trial(
    haul: Haul,
    species: Species,
    design: str,
    *,
    volume_m3: Array,
    length_cm: Array,
    expected_fish: Array,
    rng: np.random.Generator,
    split: float = 0.5,
) -> pd.DataFrame:
    """A simulated trial of a computed codend, as a table for ``read_field_data`` with ``catch_volume_m3``.

    Args:
        haul: the computed catches.
        species: true numbers of the fish.
        design: "covered" or "paired".
        volume_m3: final catch of every haul, (H,).
        length_cm: (n,) length classes.
        expected_fish: (n,) expected number of fish a haul meets (both gears together for paired gear).
        rng: for the Poisson numbers of fish.
        split: paired gear: the share of the fish met that enter the test gear.
    """
    import pandas as pd

    of_catches, columns, frames = terms_of_catches(haul, species), DESIGNS[design], []
    for h, volume in enumerate(volume_m3):
        share = shares_until(haul, species, float(volume))
        retained = np.clip(terms_of_haul(haul, of_catches, species, share).retention(length_cm), 0.0, 1.0)
        if design == "covered":
            means = (expected_fish * retained, expected_fish * (1.0 - retained))
        else:
            means = (expected_fish * split * retained, expected_fish * (1.0 - split))
        counts = {name: rng.poisson(mean) for name, mean in zip(columns, means, strict=True)}
        frames.append(pd.DataFrame({"haul": str(h + 1), "catch_volume_m3": volume, "length_cm": length_cm, **counts}))
    return pd.concat(frames, ignore_index=True)
