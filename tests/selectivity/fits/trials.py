"""Simulated trials for tests of fits, as tables with the columns users have."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from codend.selectivity.fits.fielddata import DESIGNS
from codend.selectivity.predicted_and_observed.simulate import SimulatedTrial, parameters_of

LENGTH_CM = np.arange(20.0, 45.0)
SHARES = np.exp(-0.5 * ((LENGTH_CM - 32.0) / 5.0) ** 2)
SHARES /= SHARES.sum()


def haul_table(
    n_hauls: int,
    design: str = "covered",
    *,
    l50: Callable[[pd.DataFrame, np.random.Generator], np.ndarray] = lambda hauls, rng: (
        32.0 + 1.5 * rng.normal(size=len(hauls))
    ),
    sr_cm: float = 5.0,
    split: float = 0.5,
    fish: float = 300.0,
    seed: int = 0,
    gears: bool = False,
) -> pd.DataFrame:
    """Hauls of two gears, A and B in turn, with a catch: L50 by a function of the hauls' columns.

    Which gear a haul had is in the table only with `gears`.
    """
    rng = np.random.default_rng(seed)
    hauls = pd.DataFrame(
        {"haul": [f"H{h + 1}" for h in range(n_hauls)], "gear": ["A", "B"] * (n_hauls // 2) + ["A"] * (n_hauls % 2)}
    )
    hauls["catch_kg"] = np.round(rng.uniform(100.0, 1000.0, n_hauls))
    frames = []
    for (_, haul), centre in zip(hauls.iterrows(), l50(hauls, rng), strict=True):
        met = (2.0 if design == "paired" else 1.0) * fish * SHARES
        trial = SimulatedTrial("logit", parameters_of("logit", centre, sr_cm), design, LENGTH_CM, met, split=split)
        counts = dict(zip(DESIGNS[design], (count[0] for count in trial.counts(1, rng)), strict=True))
        frames.append(pd.DataFrame({**haul.to_dict(), "length_cm": LENGTH_CM, **counts}))
    table = pd.concat(frames, ignore_index=True)
    return table if gears else table.drop(columns="gear")
