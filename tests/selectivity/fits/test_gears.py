"""Gears, formulas, curves by AIC, predictions and their bands: against separate fits, known truth and definitions."""

import numpy as np
import pandas as pd
import pytest

from codend.errors import InputError
from codend.selectivity.fits.compare_gears import usability
from codend.selectivity.fits.curve_table import choose_curve, curve_table
from codend.selectivity.fits.families import DUAL, FAMILIES
from codend.selectivity.fits.gears import coefficient_table, fit_gears, gear_table
from codend.selectivity.fits.one_stage_estimates import (
    covariance_root,
    delta_band,
    estimates,
    retention_band,
    simultaneous_factor,
)
from codend.selectivity.fits.predictions import Drawn, delta_table, prediction_table, settings, usability_table
from tests.selectivity.fits.trials import LENGTH_CM, haul_table


def two_gears(n_hauls: int = 16, design: str = "covered", **more: float) -> pd.DataFrame:
    """B at 34 cm, A at 30.5 cm, both 0.4 cm up for every 100 kg of catch above 500, hauls with 0.7 cm."""
    return haul_table(
        n_hauls,
        design,
        l50=lambda hauls, rng: (
            30.5
            + 3.5 * (hauls["gear"] == "B")
            + 0.004 * (hauls["catch_kg"] - 500.0)
            + 0.7 * rng.normal(size=len(hauls))
        ),
        gears=True,
        **more,
    )


def test_gears_with_everything_apart_are_the_gears_one_by_one() -> None:
    table = two_gears(design="paired", split=0.6, fish=1000.0)
    both = fit_gears(table, "paired", split="estimated", group="gear", random="none")
    alone = [fit_gears(table[table["gear"] == g], "paired", split="estimated", random="none").one for g in "AB"]
    assert both.one.levels == ("A", "B")
    assert both.one.log_likelihood == pytest.approx(sum(one.log_likelihood for one in alone), abs=1e-5)
    for level, one in zip("AB", alone, strict=True):
        assert estimates(both.one, level).values == pytest.approx(estimates(one).values, rel=1e-3)
        assert estimates(both.one, level).standard_errors == pytest.approx(estimates(one).standard_errors, rel=1e-2)


def test_truth_is_found_with_gears_and_a_covariate() -> None:
    fit = fit_gears(two_gears(40, seed=3), "covered", group="gear", covariates=["catch_kg"])
    (difference,) = fit.differences()
    assert (difference.first, difference.second) == ("B", "A")
    l50, sr = difference.estimates.values
    errors = difference.estimates.standard_errors
    assert abs(l50 - 3.5) < 3.0 * errors[0]
    assert abs(sr) < 3.0 * errors[1]
    assert fit.p_value < 1e-6
    found = coefficient_table(fit.one).set_index(["of", "term"])
    slope = found.loc[("l50_cm", "catch_kg")]
    assert abs(slope["estimate"] - 0.004) < 3.0 * slope["standard_error"]
    assert found.loc[("l50_cm", "gear[T.B]"), "estimate"] == pytest.approx(l50, rel=1e-6)
    assert found.loc[("l50_cm", "gear[T.B]"), "standard_error"] == pytest.approx(errors[0], rel=1e-4)


def test_gears_that_are_alike_are_not_told_apart() -> None:
    p_values = [
        fit_gears(haul_table(12, fish=200.0, seed=s, gears=True), "covered", group="gear").p_value for s in range(20)
    ]
    assert np.mean(np.array(p_values) < 0.05) < 0.25


def test_covariates_of_l50_and_of_sr_are_apart() -> None:
    table = two_gears()
    of_l50 = estimates(fit_gears(table, "covered", l50="gear + catch_kg").one)
    assert "l50_cm:catch_kg" in of_l50.names
    assert "sr_cm:catch_kg" not in of_l50.names
    of_sr = fit_gears(table, "covered", l50="gear", sr="catch_kg").one
    low, high = (estimates(of_sr, "", {"catch_kg": kg}) for kg in (200.0, 900.0))
    assert low["l50_cm"] == pytest.approx(high["l50_cm"])
    slope = coefficient_table(of_sr).set_index(["of", "term"]).loc[("log_sr", "catch_kg"), "estimate"]
    assert np.log(high["sr_cm"] / low["sr_cm"]) == pytest.approx(700.0 * slope)


def test_interactions_give_each_gear_its_slope() -> None:
    fit = fit_gears(two_gears(), "covered", l50="gear * catch_kg", group="gear").one
    found = coefficient_table(fit).set_index(["of", "term"])["estimate"]
    for level, slope in (
        ("A", found["l50_cm", "catch_kg"]),
        ("B", found["l50_cm", "catch_kg"] + found["l50_cm", "gear[T.B]:catch_kg"]),
    ):
        low, high = (estimates(fit, level, {"catch_kg": kg})["l50_cm"] for kg in (300.0, 800.0))
        assert (high - low) / 500.0 == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize(
    ("choice", "named"),
    [
        ({"l50": "gear + vessel"}, "l50"),
        ({"sr": "gear +"}, "sr"),
        ({"l50": "0 + gear"}, "with an intercept"),
        ({"l50": "gear + C(gear)"}, "have rank 2"),
        ({"l50": "gear + codend"}, "l50"),
        ({"group": "vessel"}, "vessel"),
        ({"group": "codend", "l50": "gear"}, "codend"),
        ({"l50": "gear", "split_by": "gear"}, "split_by"),
        ({"curve": "spline"}, "curve"),
        ({"l50": "gear", "random": "vessel"}, "vessel"),
    ],
)
def test_formulas_and_groups_that_cannot_be_are_refused(choice: dict, named: str) -> None:
    with pytest.raises(InputError, match=named):
        fit_gears(two_gears(4), "covered", **choice)


def test_one_gear_is_no_group() -> None:
    with pytest.raises(InputError, match="at least two gears"):
        fit_gears(two_gears(4).assign(gear="A"), "covered", group="gear")


def test_numbers_can_name_gears() -> None:
    table = two_gears(6)
    table["gear"] = np.where(table["gear"] == "A", 100, 120)
    assert fit_gears(table, "covered", group="gear").one.levels == ("100", "120")


def test_predictions_lie_where_the_estimates_say() -> None:
    one = fit_gears(two_gears(), "covered", group="gear", covariates=["catch_kg"]).one
    table = prediction_table(one, [{}, *settings(one, ["catch_kg=300"])])
    assert list(table["at"].unique()) == ["mean of hauls", "catch_kg=300"]
    for (gear, at), curve in table.groupby(["gear", "at"]):
        values = {"catch_kg": 300.0} if "=" in at else None
        assert curve["l50_cm"].iloc[0] == pytest.approx(estimates(one, gear, values)["l50_cm"])
        half = np.interp(curve["l50_cm"].iloc[0], curve["length_cm"], curve["retention"])
        assert half == pytest.approx(0.5, abs=2e-3)
        assert (curve["lower_all_95"] <= curve["lower_95"]).all()
        assert (curve["lower_95"] < curve["retention"]).all()
        assert (curve["retention"] < curve["upper_95"]).all()
        assert curve[["lower_all_95", "upper_all_95"]].stack().between(0.0, 1.0).all()
    for wrong in ("catch_kg", "catch_kg=much", "depth_m=3", "gear=A"):
        with pytest.raises(InputError, match="--at"):
            settings(one, [wrong])


def test_a_simultaneous_band_holds_whole_curves_as_often_as_it_says() -> None:
    """Curves drawn from the distribution of the estimates: 95 % stay inside it, of the other band fewer."""
    one = fit_gears(two_gears(fish=1000.0), "covered", group="gear").one
    first, second = one.point("B"), one.point("A")
    band = delta_band(one, first, second, LENGTH_CM)
    deviates = np.random.default_rng(1).standard_normal((1500, one.theta.size))
    thetas = one.theta + deviates @ covariance_root(one.maximum.covariance).T
    curves = np.array([one.retention_at(first, LENGTH_CM, t) - one.retention_at(second, LENGTH_CM, t) for t in thetas])

    def inside(lower: np.ndarray, upper: np.ndarray) -> float:
        return float(((curves >= lower) & (curves <= upper)).all(axis=1).mean())

    assert 0.94 < inside(band.lower_all_95, band.upper_all_95) < 0.99
    assert inside(band.lower_95, band.upper_95) < 0.93


def test_the_simultaneous_factor_of_known_cases() -> None:
    from scipy.stats import norm

    assert simultaneous_factor(np.ones((50, 1))) == pytest.approx(1.0, abs=0.02)  # one deviate moves all
    independent = norm.ppf(0.5 + 0.5 * 0.95 ** (1.0 / 10.0)) / norm.ppf(0.975)
    assert simultaneous_factor(np.eye(10)) == pytest.approx(independent, rel=0.01)


def test_differences_are_significant_where_the_whole_band_leaves_out_zero() -> None:
    table = delta_table(fit_gears(two_gears(fish=1000.0), "covered", group="gear").one)
    middle = table["length_cm"].between(29.0, 35.0)
    assert table.loc[middle, "significant"].all()
    assert (table.loc[middle, "difference"] < 0.0).all()


def test_curves_are_ranked_by_aic_and_averaged_by_their_weights() -> None:
    one = fit_gears(haul_table(6, fish=3000.0, seed=2), "covered").one
    choice = choose_curve(one)
    table = curve_table(choice).set_index("curve")
    assert set(table.index) == {*FAMILIES, "average"}
    ranked = table.drop("average").dropna(subset="aic")
    assert ranked["aic"].is_monotonic_increasing
    assert ranked.index[0] in ("logit", "richards", "dual")
    assert table.drop("average")["weight"].sum() == pytest.approx(1.0)
    weights = np.exp(-0.5 * ranked["delta_aic"])
    assert ranked["weight"].to_numpy() == pytest.approx((weights / weights.sum()).to_numpy(), abs=1e-9)
    assert table.loc["average", "l50_cm"] == pytest.approx((ranked["weight"] * ranked["l50_cm"]).sum())
    assert table.loc["average", "l50_standard_error_cm"] >= (ranked["weight"] * ranked["l50_standard_error_cm"]).sum()


def test_a_dual_curve_is_found_where_two_processes_are_at_work() -> None:
    length = np.arange(15.0, 60.0)
    shape = np.array([0.4, np.log(4.0), np.log(0.5)])
    r = DUAL.retention(length, np.array(32.0), np.array(9.0), shape)
    table = pd.DataFrame(
        {"haul": 1, "length_cm": length, "codend": np.round(1e5 * r), "cover": np.round(1e5 * (1.0 - r))}
    )
    one = fit_gears(table, "covered", curve="dual").one
    found = estimates(one)
    assert found["l50_cm"] == pytest.approx(32.0, abs=0.02)
    assert found["sr_cm"] == pytest.approx(9.0, abs=0.05)
    assert one.retention_at(one.point(), length, one.theta) == pytest.approx(r, abs=1e-3)
    choice = choose_curve(fit_gears(table, "covered", curve="logit").one)
    assert choice.fits[0].model.family.name == "dual"
    assert choice.weights[0] > 0.99


@pytest.mark.parametrize("family", list(FAMILIES.values()), ids=list(FAMILIES))
def test_l50_and_sr_mean_the_same_in_every_family(family) -> None:
    shape = np.array([0.4, 0.9, -0.5])[: len(family.shape_names)]
    quartiles = family.retention(np.array([30.0]), np.array(30.0), np.array(4.0), shape)
    assert quartiles == pytest.approx([0.5])
    fine = np.linspace(20.0, 50.0, 30001)
    r = family.retention(fine, np.array(30.0), np.array(4.0), shape)
    assert np.interp(0.75, r, fine) - np.interp(0.25, r, fine) == pytest.approx(4.0, abs=2e-3)


def test_usability_of_drawn_curves_is_that_of_their_sums() -> None:
    one = fit_gears(two_gears(), "covered", group="gear").one
    table = usability_table(one, 30.0).set_index(["gear", "indicator"])
    assert ((table["lower_95"] < table["percent"]) & (table["percent"] < table["upper_95"])).all()
    assert table.loc[("A", "np_minus"), "percent"] > table.loc[("B", "np_minus"), "percent"]
    length, numbers = np.array([25.0, 35.0]), np.array([10.0, 30.0])
    drawn = Drawn(one, one.point("A"))
    r = one.retention_at(one.point("A"), length, one.theta)
    assert usability(drawn, length, numbers, 30.0).np_plus.percent == pytest.approx(100.0 * r[1])


def test_the_table_of_gears_has_gears_and_differences() -> None:
    table = gear_table(fit_gears(two_gears(), "covered", group="gear"))
    assert list(table["group"].unique()) == ["A", "B", "B minus A"]
    assert ((table["lower_95"] <= table["estimate"]) & (table["estimate"] <= table["upper_95"])).all()
    fixed = gear_table(fit_gears(two_gears(design="paired"), "paired", group="gear", split=0.45))
    split = fixed[fixed["parameter"] == "split"]
    assert split["estimate"].to_numpy() == pytest.approx([0.45, 0.45])
    assert split["standard_error"].isna().all()


def test_a_failed_fit_has_no_numbers_and_a_word() -> None:
    table = two_gears(4).assign(cover=0.0)
    fit = fit_gears(table, "covered", group="gear")
    assert not fit.converged
    assert gear_table(fit)["estimate"].isna().all()
    assert len(fit.notes[0]) > 40
    assert np.isnan(retention_band(fit.one, fit.one.point("A"), LENGTH_CM).value).all()
