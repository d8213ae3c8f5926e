"""Maximum-likelihood fits against published answers, an independent program, and invariants of the likelihood."""

import numpy as np
import pandas as pd
import pytest
from scipy.special import expit, ndtr

from codend.selectivity.fits import scoring
from codend.selectivity.fits.analysis import diagnostics_table, fit_field_data, fit_table
from codend.selectivity.fits.curves import CURVES
from codend.selectivity.fits.fielddata import read_field_data
from codend.selectivity.fits.fit import dispersion_factor
from codend.selectivity.fits.model import evaluate, selection_model
from codend.selectivity.fits.scoring import Outcome
from tests import ROOT

HADDOCK = ROOT / "validation" / "tables" / "millar_haddock_paired.csv"
curves = pytest.mark.parametrize("curve", list(CURVES))


def covered_trial(n_hauls: int = 1, seed: int = 5) -> pd.DataFrame:
    """Counts of a covered-codend trial with subsampled covers and a few lengths without fish."""
    rng = np.random.default_rng(seed)
    length_cm = np.arange(18.0, 44.0)
    met = rng.poisson(60.0 * np.exp(-0.5 * ((length_cm - 30.0) / 5.0) ** 2), (n_hauls, length_cm.size))
    met[:, [0, -1]] = 0
    retained = rng.binomial(met, expit(0.5 * (length_cm - 30.0)))
    cover = rng.binomial(met - retained, 0.25)
    return pd.DataFrame(
        {
            "haul": np.repeat(np.arange(n_hauls), length_cm.size),
            "length_cm": np.tile(length_cm, n_hauls),
            "codend": retained.ravel(),
            "cover": cover.ravel(),
            "cover_raising": 4.0,
        }
    )


def test_millars_haddock_with_equal_split() -> None:
    estimates = fit_field_data(HADDOCK, "paired").pooled.estimates
    assert estimates["a"] == pytest.approx(-36.3144, abs=1e-4)
    assert estimates["b"] == pytest.approx(1.2340, abs=1e-4)
    assert estimates["l50_cm"] == pytest.approx(29.43, abs=5e-3)
    assert estimates["sr_cm"] == pytest.approx(1.78, abs=5e-3)
    assert estimates["split"] == 0.5


def test_millars_haddock_with_estimated_split() -> None:
    fit = fit_field_data(HADDOCK, "paired", split="estimated").pooled
    assert fit.estimates["split"] == pytest.approx(0.573, abs=1e-3)
    assert fit.estimates["l50_cm"] == pytest.approx(30.18, abs=1e-2)
    assert fit.estimates["sr_cm"] == pytest.approx(2.40, abs=1e-2)
    assert fit.aic < fit_field_data(HADDOCK, "paired").pooled.aic
    assert fit.p_value > 0.05


@pytest.mark.parametrize(
    ("curve", "link"), [("logit", "Logit"), ("probit", "Probit"), ("cloglog", "CLogLog"), ("gompertz", "LogLog")]
)
def test_covered_fits_agree_with_the_binomial_glm_of_statsmodels(curve: str, link: str) -> None:
    import statsmodels.api as sm

    table = covered_trial(n_hauls=2)
    # the raising factor is an offset on the logit scale, which statsmodels' other links cannot carry
    raising = table["cover_raising"] if curve == "logit" else 1.0
    fit = fit_field_data(table.assign(cover_raising=raising), "covered", curve, overdispersion="none").pooled
    fished = table[table["codend"] + table["cover"] > 0]
    glm = sm.GLM(
        fished[["codend", "cover"]],
        sm.add_constant(fished["length_cm"]),
        family=sm.families.Binomial(link=getattr(sm.families.links, link)()),
        offset=np.log(np.broadcast_to(raising, len(table)))[fished.index],
    )
    oracle = glm.fit(tol=1e-14, maxiter=100)
    observed = np.sqrt(np.diagonal(np.linalg.inv(-glm.hessian(oracle.params, observed=True))))
    assert fit.estimates.values[:2] == pytest.approx(oracle.params.to_numpy(), rel=1e-7)
    assert fit.estimates.standard_errors[:2] == pytest.approx(observed, rel=1e-6)
    assert fit.deviance == pytest.approx(oracle.deviance, rel=1e-9)
    assert fit.pearson_chi2 == pytest.approx(oracle.pearson_chi2, rel=1e-7)
    assert fit.log_likelihood == pytest.approx(oracle.llf, rel=1e-9)
    assert fit.aic == pytest.approx(oracle.aic, rel=1e-9)
    assert fit.degrees_of_freedom == oracle.df_resid
    assert fit.pearson_residuals[fished.index] == pytest.approx(oracle.resid_pearson.to_numpy(), rel=1e-5, abs=1e-7)
    assert fit.deviance_residuals[fished.index] == pytest.approx(oracle.resid_deviance.to_numpy(), rel=1e-5, abs=1e-7)


@curves
@pytest.mark.parametrize(("design", "estimated"), [("covered", False), ("paired", False), ("paired", True)])
def test_gradient_and_observed_information_equal_difference_quotients(curve: str, design: str, estimated: bool) -> None:
    table = covered_trial()
    if design == "paired":
        table = table.rename(columns={"codend": "test", "cover": "control", "cover_raising": "control_raising"})
    data = read_field_data(table, design)
    model = selection_model(data, curve, estimated)
    counts = data.test_count[None], data.other_count[None]
    theta, h = np.array([[0.3, 2.0, 0.4, 0.2]])[:, : model.n_parameters], 1e-5
    at = evaluate(model, theta, *counts)
    for i in range(model.n_parameters):
        step = np.zeros_like(theta)
        step[0, i] = h
        up, down = evaluate(model, theta + step, *counts), evaluate(model, theta - step, *counts)
        slope = (up.log_likelihood - down.log_likelihood) / (2 * h)
        assert at.gradient[0, i] == pytest.approx(slope[0], rel=1e-6, abs=1e-5)
        curvature = (up.gradient - down.gradient)[0] / (2 * h)
        assert -at.observed[0, i] == pytest.approx(curvature, rel=1e-6, abs=1e-4)


@curves
def test_expected_counts_are_fitted_exactly(curve: str) -> None:
    """Counts that equal their expectation have the true parameters as their maximum of likelihood."""
    has_shape = CURVES[curve].has_shape
    truth = {"logit": (-12.0, 0.4), "probit": (-7.0, 0.23), "gompertz": (-9.0, 0.3), "cloglog": (-9.0, 0.3)}.get(
        curve, (-15.0, 0.5, 1.8)
    )
    length_cm = np.arange(10.0, 60.0)
    r = CURVES[curve].retention(length_cm, truth)
    met, split = 1e7, 0.6
    columns = {
        "covered": {"codend": met * r, "cover": met * (1.0 - r)},
        "paired": {"test": met * split * r, "control": met * (1.0 - split) * np.ones_like(r)},
    }
    for design, counts in columns.items():
        whole = {name: np.round(values) for name, values in counts.items()}
        table = pd.DataFrame({"haul": 1, "length_cm": length_cm, **whole})
        fit = fit_field_data(table, design, curve, "estimated" if design == "paired" else "equal").pooled
        assert fit.estimates.values[: 2 + has_shape] == pytest.approx(truth, rel=1e-5)
        assert fit.gradient_norm < 1e-6
        if design == "paired":
            assert fit.estimates["split"] == pytest.approx(split, rel=1e-6)


def test_raising_undoes_subsampling() -> None:
    """A cover counted to one tenth, raised by ten, gives the estimates of the whole cover, with larger errors."""
    length_cm = np.arange(20.0, 41.0)
    r = expit(0.5 * (length_cm - 30.0))
    whole = pd.DataFrame(
        {"haul": 1, "length_cm": length_cm, "codend": np.round(1e6 * r), "cover": 10 * np.round(1e5 * (1 - r))}
    )
    tenth = whole.assign(cover=whole["cover"] // 10, cover_raising=10.0)
    full, sub = (fit_field_data(t, "covered", overdispersion="none").pooled.estimates for t in (whole, tenth))
    assert sub.values == pytest.approx(full.values, rel=1e-4)
    assert np.all(sub.standard_errors > 1.05 * full.standard_errors)


def test_only_the_ratio_of_the_two_raising_factors_matters() -> None:
    table = covered_trial()
    both = table.assign(codend_raising=3.0, cover_raising=12.0)
    one, other = (fit_field_data(t, "covered").pooled.estimates for t in (table, both))
    assert one.values == pytest.approx(other.values, rel=1e-9)
    assert one.standard_errors == pytest.approx(other.standard_errors, rel=1e-9)


@curves
def test_lengths_in_another_unit_scale_l50_and_range(curve: str) -> None:
    table = covered_trial(n_hauls=3)
    one = fit_field_data(table, "covered", curve).pooled.estimates
    ten = fit_field_data(table.assign(length_cm=10.0 * table["length_cm"]), "covered", curve).pooled.estimates
    for name in ("l50_cm", "sr_cm"):
        i = one.names.index(name)
        assert ten.values[i] == pytest.approx(10.0 * one.values[i], rel=1e-6)
        assert ten.standard_errors[i] == pytest.approx(10.0 * one.standard_errors[i], rel=1e-5)


def test_splitting_a_haul_in_two_changes_no_estimate() -> None:
    table = covered_trial()
    halves = [
        table.assign(
            haul=h,
            codend=table["codend"] // 2 + h * (table["codend"] % 2),
            cover=table["cover"] // 2 + h * (table["cover"] % 2),
        )
        for h in (0, 1)
    ]
    one = fit_field_data(table, "covered", overdispersion="none").pooled.estimates
    two = fit_field_data(pd.concat(halves), "covered", overdispersion="none").pooled.estimates
    assert one.values == pytest.approx(two.values, rel=1e-9)
    assert one.standard_errors == pytest.approx(two.standard_errors, rel=1e-9)


def test_lengths_without_fish_have_no_residual_and_change_nothing() -> None:
    table = covered_trial()
    fished = table[table["codend"] + table["cover"] > 0]
    fit, without = (fit_field_data(t, "covered").pooled for t in (table, fished))
    assert np.isnan(fit.pearson_residuals[[0, -1]]).all()
    assert fit.degrees_of_freedom == without.degrees_of_freedom
    assert fit.estimates.values == pytest.approx(without.estimates.values, rel=1e-9)


def test_covariates_are_the_linear_terms_of_the_glm() -> None:
    import statsmodels.api as sm

    table = covered_trial(n_hauls=6).assign(cover_raising=1.0)
    table["catch_kg"] = 50.0 * (1 + table["haul"] ** 2)
    fit = fit_field_data(table, "covered", covariates=["catch_kg"], overdispersion="none").pooled
    fished = table[table["codend"] + table["cover"] > 0]
    catch = fished["catch_kg"] - table["catch_kg"].groupby(table["haul"]).first().mean()
    design = np.column_stack([np.ones(len(fished)), fished["length_cm"], catch, catch * fished["length_cm"]])
    oracle = sm.GLM(fished[["codend", "cover"]].to_numpy(), design, family=sm.families.Binomial()).fit(tol=1e-14)
    names = ("a", "b", "a:catch_kg", "b:catch_kg")
    at = [fit.estimates.names.index(name) for name in names]
    assert fit.estimates.values[at] == pytest.approx(oracle.params, rel=1e-6)
    assert fit.estimates.standard_errors[at] == pytest.approx(oracle.bse, rel=1e-6)

    # slopes of L50 and SR at the mean catch, from the curves on either side of it
    a, b, a_c, b_c = oracle.params
    above, below = (CURVES["logit"].l50_sr((a + s * a_c, b + s * b_c)) for s in (1e-3, -1e-3))
    slopes = (above - below) / 2e-3
    assert [fit.estimates["l50_cm:catch_kg"], fit.estimates["sr_cm:catch_kg"]] == pytest.approx(slopes, rel=1e-6)


@curves
@pytest.mark.parametrize(
    ("codend", "cover"),
    [
        ([0, 0, 0, 5, 9, 4], [7, 9, 3, 0, 0, 0]),  # knife edge
        ([0, 0, 3, 5, 9, 4], [7, 9, 3, 0, 0, 0]),  # knife edge with one mixed length
        ([3, 8, 3, 5, 9, 4], [0, 0, 0, 0, 0, 0]),  # all retained
        ([0, 0, 6, 0, 0, 0], [0, 0, 4, 0, 0, 0]),  # one length
        ([9, 8, 7, 3, 1, 0], [0, 2, 3, 7, 9, 9]),  # columns swapped
    ],
)
def test_data_without_a_finite_estimate_are_reported_not_fitted(curve: str, codend: list, cover: list) -> None:
    table = pd.DataFrame({"haul": 1, "length_cm": np.arange(20.0, 26.0), "codend": codend, "cover": cover})
    result = fit_field_data(table, "covered", curve, n_bootstrap=5)
    assert not result.converged
    assert result.bootstrap is None
    assert np.isnan(result.pooled.estimates.values).all()
    assert np.isnan(fit_table(result)["estimate"]).all()
    swapped = codend[0] == 9 and curve != "richards"
    assert not swapped or result.pooled.outcome is Outcome.FALLING
    assert len(diagnostics_table(result)["message"][0]) > 40


def test_paired_gear_that_retains_everything_has_no_curve() -> None:
    table = pd.DataFrame({"haul": 1, "length_cm": np.arange(20.0, 30.0), "test": 50, "control": 50})
    for split in ("equal", "estimated"):
        assert not fit_field_data(table, "paired", split=split).converged


def test_errors_are_inflated_only_where_the_fit_is_poor() -> None:
    assert dispersion_factor(np.full(40, 1.2), 2) == 1.0
    assert dispersion_factor(np.full(40, 4.0), 2) == pytest.approx(4.0 * 40 / 38)
    assert dispersion_factor(np.full(2, 4.0), 2) == 1.0  # no degree of freedom to tell
    plain = fit_field_data(HADDOCK, "paired", overdispersion="none").pooled
    inflated = fit_field_data(HADDOCK, "paired", overdispersion="pearson").pooled
    assert inflated.dispersion > 1.5
    ratio = inflated.estimates.standard_errors[:2] / plain.estimates.standard_errors[:2]
    assert ratio == pytest.approx(np.sqrt(inflated.dispersion))


def test_probit_is_phi_of_the_linear_predictor_at_the_fit() -> None:
    fit = fit_field_data(covered_trial(), "covered", "probit").pooled
    a, b = fit.estimates["a"], fit.estimates["b"]
    assert ndtr(a + b * fit.estimates["l50_cm"]) == pytest.approx(0.5)
    assert ndtr(b * fit.estimates["sr_cm"] / 2) == pytest.approx(0.75)


def test_fit_table_has_the_promised_columns_groups_and_parameters() -> None:
    table = fit_table(fit_field_data(covered_trial(n_hauls=4), "covered", n_bootstrap=50))
    columns = ["group", "curve", "parameter", "estimate", "standard_error", "lower_95", "upper_95", "interval"]
    assert list(table.columns) == columns
    groups = ["one-stage", "between-hauls", "bootstrap", "pooled", "haul 0", "haul 1", "haul 2", "haul 3"]
    assert list(table["group"].unique()) == groups
    assert list(table["parameter"][:4]) == ["a", "b", "l50_cm", "sr_cm"]
    assert ((table["lower_95"] < table["estimate"]) & (table["estimate"] < table["upper_95"])).all()
    paired = fit_table(fit_field_data(HADDOCK, "paired", "logit", "estimated"))
    assert list(paired["parameter"]) == ["a", "b", "split", "l50_cm", "sr_cm"]
    assert list(paired["group"].unique()) == ["pooled"]


def test_information_that_is_no_number_determines_nothing() -> None:
    """LAPACK finds no eigenvalues of it, which once ended a calibration on flat data in a traceback."""
    information = np.stack([np.eye(2), np.full((2, 2), np.nan)])
    _, determined = scoring._covariance(information, information, np.ones((2, 2)))
    assert determined.tolist() == [True, False]
