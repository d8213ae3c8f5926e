"""Catch comparison: against statsmodels, and gears whose ratio is known."""

import numpy as np
import pandas as pd
import pytest

from codend.errors import InputError
from codend.selectivity.fits.catch_comparison import _binomial, compare_catches

LENGTH_CM = np.arange(20.0, 41.0)


def catches(
    ratio: np.ndarray, n_hauls: int = 10, fish: float = 30.0, seed: int = 0, raising: float = 1.0
) -> pd.DataFrame:
    """Hauls in which the test gear catches `ratio` (n,) times what the control does; the test gear counted in part."""
    rng = np.random.default_rng(seed)
    frames = []
    for h in range(n_hauls):
        effort = np.exp(0.2 * rng.normal())
        counts = {
            "test": rng.poisson(fish * ratio * effort / raising),
            "control": rng.poisson(fish * np.ones(LENGTH_CM.size)),
        }
        frames.append(pd.DataFrame({"haul": h, "length_cm": LENGTH_CM, **counts, "test_raising": raising}))
    return pd.concat(frames, ignore_index=True)


def test_regressions_of_a_batch_are_those_of_statsmodels() -> None:
    import statsmodels.api as sm

    rng = np.random.default_rng(2)
    x = np.linspace(-1.0, 1.0, 15)
    columns, offset = x[:, None] ** np.arange(4), 0.3 * rng.normal(size=15)
    test, other = rng.poisson(20.0, (3, 15)).astype(float), rng.poisson(15.0, (3, 15)).astype(float)
    coefficients, likelihood = _binomial(columns, offset, test, other)
    for b in range(3):
        glm = sm.GLM(np.column_stack([test[b], other[b]]), columns, family=sm.families.Binomial(), offset=offset)
        assert coefficients[b] == pytest.approx(glm.fit(tol=1e-14).params, rel=1e-5, abs=1e-7)
        eta = columns @ coefficients[b] + offset
        assert likelihood[b] == pytest.approx((test[b] * eta - (test[b] + other[b]) * np.log1p(np.exp(eta))).sum())


def test_gears_that_catch_alike_are_not_told_apart() -> None:
    told = [
        ((found.lower_all_95 > 0.5) | (found.upper_all_95 < 0.5)).any()
        for found in (compare_catches(catches(np.ones(LENGTH_CM.size), seed=s), 200) for s in range(20))
    ]
    assert np.mean(told) < 0.25


@pytest.mark.parametrize("raising", [1.0, 4.0])
def test_a_known_ratio_lies_within_the_band_of_the_whole_curve(raising: float) -> None:
    ratio = np.exp(-0.1 * (LENGTH_CM - 30.0))
    found = compare_catches(catches(ratio, 20, 60.0 * raising**0.5, raising=raising), 300, seed=1)
    table = found.table()
    assert ((table["ratio_lower_all_95"] < ratio) & (ratio < table["ratio_upper_all_95"])).all()
    assert table["ratio"].to_numpy() == pytest.approx(ratio, rel=0.3)
    assert (table["share_lower_all_95"] <= table["share_lower_95"]).all()
    assert (table["share_upper_95"] <= table["share_upper_all_95"]).all()
    assert table["ratio"].to_numpy() == pytest.approx((table["share"] / (1.0 - table["share"])).to_numpy())
    assert 1 in found.orders
    assert sum(found.weights.values()) == pytest.approx(1.0)


def test_without_a_bootstrap_there_are_no_bands() -> None:
    found = compare_catches(catches(np.ones(LENGTH_CM.size)), 0)
    assert np.isnan(found.lower_95).all()
    assert np.isfinite(found.share).all()


@pytest.mark.parametrize("counts", [{"test": 0}, {"control": 0}, {"length_cm": 20.0, "haul": np.arange(210)}])
def test_catches_that_tell_nothing_are_refused(counts: dict) -> None:
    with pytest.raises(InputError, match="three or more lengths"):
        compare_catches(catches(np.ones(LENGTH_CM.size)).assign(**counts), 10)
