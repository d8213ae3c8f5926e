"""One-stage fits: the marginal likelihood against integration by brute force, fits against other fits and the truth."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import dblquad, quad
from scipy.special import expit
from scipy.stats import norm

from codend.errors import InputError
from codend.selectivity.fits.analysis import NO_TERMS, fit_field_data, fit_table, fit_trial
from codend.selectivity.fits.choices import RandomTerms
from codend.selectivity.fits.curves import CURVES
from codend.selectivity.fits.families import FAMILIES
from codend.selectivity.fits.fielddata import read_field_data
from codend.selectivity.fits.fit import fit_pooled
from codend.selectivity.fits.marginal import MarginalModel, log_likelihood, place_nodes
from codend.selectivity.fits.model import selection_model
from codend.selectivity.fits.one_stage_estimates import estimates, estimates_within
from tests import ROOT
from tests.selectivity.fits.trials import LENGTH_CM, haul_table

HADDOCK = ROOT / "validation" / "tables" / "millar_haddock_paired.csv"
families = pytest.mark.parametrize("family", list(FAMILIES))


def marginal_model(
    family: str = "logit", design: str = "covered", random: tuple[str, ...] = ("l50",), n_hauls: int = 3
) -> MarginalModel:
    table = haul_table(n_hauls, design, fish=60.0, seed=3)
    one, haul = np.ones((len(table), 1)), np.repeat(np.arange(n_hauls), LENGTH_CM.size)
    test, other = ("codend", "cover") if design == "covered" else ("test", "control")
    return MarginalModel(
        family=FAMILIES[family],
        design=design,
        haul=haul,
        length_cm=table["length_cm"].to_numpy(),
        test=table[test].to_numpy(),
        other=table[other].to_numpy(),
        log_offset=np.full(len(table), 0.3),
        by_l50=np.column_stack([np.ones(len(table)), haul - 1.0]),
        by_log_sr=one,
        by_split=one if design == "paired" else np.empty((len(table), 0)),
        fixed_logit_split=0.0,
        random=random,
    )


def some_theta(model: MarginalModel) -> np.ndarray:
    theta, at = np.zeros(model.n_parameters), model.slices
    theta[at["l50"]], theta[at["sr"]] = (31.0, 0.5), 1.5
    theta[at["shape"]] = np.linspace(0.4, 0.9, len(model.family.shape_names))
    theta[at["split"]] = 0.2
    theta[at["sd"]] = np.linspace(0.7, 0.3, len(model.random))
    return theta


@families
@pytest.mark.parametrize(
    ("design", "random"),
    [("covered", ()), ("covered", ("l50",)), ("paired", ("l50", "split")), ("paired", ("l50", "sr", "split"))],
)
def test_the_gradient_equals_difference_quotients(family: str, design: str, random: tuple[str, ...]) -> None:
    model = marginal_model(family, design, random)
    theta, h = some_theta(model), 1e-5
    nodes, _ = place_nodes(model, theta)
    _, gradient = log_likelihood(model, theta, nodes)
    for i in range(theta.size):
        step = np.zeros(theta.size)
        step[i] = h
        up, down = (log_likelihood(model, theta + sign * step, nodes)[0] for sign in (1.0, -1.0))
        assert gradient[i] == pytest.approx((up - down) / (2.0 * h), rel=1e-6, abs=1e-5)


def integrand(model: MarginalModel, theta: np.ndarray, haul: int, deviations: dict[str, float]) -> float:
    """Likelihood of a haul at given deviations of a logit curve, written out anew."""
    rows, at = model.haul == haul, model.slices
    l50 = model.by_l50[rows] @ theta[at["l50"]] + deviations.get("l50", 0.0)
    r = expit(2.0 * np.log(3.0) * (model.length_cm[rows] - l50) / np.exp(theta[at["sr"]][0]))
    odds = (
        r / (1.0 - r) if model.design == "covered" else r * np.exp(theta[at["split"]][0] + deviations.get("split", 0.0))
    )
    share = 1.0 / (1.0 + np.exp(-0.3) / odds)
    return float(np.exp((model.test[rows] * np.log(share) + model.other[rows] * np.log1p(-share)).sum() + 60.0))


@pytest.mark.parametrize("design", ["covered", "paired"])
def test_the_likelihood_is_the_integral_over_hauls(design: str) -> None:
    random = ("l50",) if design == "covered" else ("l50", "split")
    model = marginal_model("logit", design, random)
    theta = some_theta(model)
    sd = theta[model.slices["sd"]]
    total = 0.0
    for haul in range(3):

        def density(split: float, l50: float, haul: int = haul) -> float:
            deviations = {"l50": l50, "split": split}
            normal = norm.pdf(l50, scale=sd[0]) * (norm.pdf(split, scale=sd[1]) if design == "paired" else 1.0)
            return integrand(model, theta, haul, deviations) * normal

        if design == "covered":
            found = quad(lambda u, f=density: f(0.0, u), -6.0, 6.0, epsrel=1e-10)[0]
        else:
            found = dblquad(density, -4.0, 4.0, -2.0, 2.0, epsrel=1e-8)[0]
        total += np.log(found) - 60.0
    assert log_likelihood(model, theta, place_nodes(model, theta)[0])[0] == pytest.approx(total, abs=2e-4)


@pytest.mark.parametrize("curve", list(CURVES))
@pytest.mark.parametrize(("design", "split"), [("covered", False), ("paired", True)])
def test_without_random_terms_it_is_the_pooled_fit(curve: str, design: str, split: bool) -> None:
    data = read_field_data(haul_table(4, design, seed=2), design)
    pooled, one = (
        fit_pooled(data, selection_model(data, curve, split), "none"),
        fit_trial(data, curve, split, 0.5, NO_TERMS),
    )
    assert one.converged
    assert one.log_likelihood == pytest.approx(pooled.log_likelihood, abs=1e-6)
    found = estimates(one)
    assert found.names == pooled.estimates.names
    assert found.values == pytest.approx(pooled.estimates.values, rel=1e-4)
    assert found.standard_errors == pytest.approx(pooled.estimates.standard_errors, rel=2e-3)


def test_hauls_that_do_not_differ_give_the_pooled_curve_and_no_variation() -> None:
    data = read_field_data(haul_table(8, l50=lambda hauls, rng: np.full(len(hauls), 32.0), seed=6), "covered")
    mixed, pooled = (fit_trial(data, "logit", False, 0.5, terms) for terms in (RandomTerms("haul", ("l50",)), NO_TERMS))
    assert estimates(mixed)["between_sd_l50_cm"] < 0.3
    assert estimates(mixed)["l50_cm"] == pytest.approx(estimates(pooled)["l50_cm"], abs=0.02)
    assert mixed.log_likelihood >= pooled.log_likelihood - 1e-6


def test_variation_between_hauls_is_recovered() -> None:
    """Forty hauls with much fish: mean and standard deviations of what hauls were drawn with, within their errors."""
    table = haul_table(40, "paired", split=0.55, fish=2000.0, seed=5)
    found = fit_field_data(table, "paired", split="estimated").answers[0].estimates
    for name, truth in (("l50_cm", 32.0), ("sr_cm", 5.0), ("split", 0.55), ("between_sd_l50_cm", 1.5)):
        i = found.names.index(name)
        assert abs(found[name] - truth) < 3.0 * found.standard_errors[i]
    assert found["between_sd_logit_split"] < 0.05


def test_units_can_be_larger_than_hauls() -> None:
    table = haul_table(12, seed=8)
    table["trip"] = (table["haul"].str[1:].astype(int) - 1) // 3
    by_trip = fit_field_data(table, "covered", random="trip").one_stage
    assert by_trip is not None
    assert by_trip.unit_names == ("0", "1", "2", "3")
    assert fit_field_data(table, "covered", random="none").one_stage is None
    for wrong, named in (
        ("vessel", "vessel"),
        ("haul:l95", "random"),
        ("none:l50", "random"),
        ("haul:split", "random"),
    ):
        with pytest.raises(InputError, match=named):
            fit_field_data(table, "covered", random=wrong)


def test_haddock_has_the_errors_and_profile_limits_that_are_known() -> None:
    """Equal split, errors by observed information .25 and .34, profile likelihood 28.92..29.90 and 1.20..2.56."""
    fit = fit_field_data(HADDOCK, "paired", overdispersion="none")
    table = fit_table(fit).set_index("parameter")
    assert table.loc["l50_cm", "standard_error"] == pytest.approx(0.25, abs=0.005)
    assert table.loc["sr_cm", "standard_error"] == pytest.approx(0.34, abs=0.005)
    assert table.loc["l50_cm", ["lower_95", "upper_95"]].to_list() == pytest.approx([28.92, 29.90], abs=0.015)
    assert table.loc["sr_cm", ["lower_95", "upper_95"]].to_list() == pytest.approx([1.20, 2.56], abs=0.02)
    assert set(table.loc[["l50_cm", "sr_cm"], "interval"]) == {"profile"}


def test_profile_limits_are_where_the_likelihood_has_fallen() -> None:
    """To the digit by a grid of its own: SR at its best for every L50, twice the fall 3.8415."""
    from scipy.optimize import brentq, minimize_scalar

    table = pd.read_csv(HADDOCK, comment="#")
    length, test, control = table["length_cm"].to_numpy(), table["test"].to_numpy(), table["control"].to_numpy()

    def best(l50: float) -> float:
        def fall(sr: float) -> float:
            r = expit(2.0 * np.log(3.0) / sr * (length - l50))
            return -(test * np.log(r / (1.0 + r)) - control * np.log1p(r)).sum()

        return float(minimize_scalar(fall, bounds=(0.3, 6.0), method="bounded", options={"xatol": 1e-9}).fun)

    found = fit_table(fit_field_data(HADDOCK, "paired", overdispersion="none")).set_index("parameter").loc["l50_cm"]
    least = best(found["estimate"])
    for limit, ends in (("lower_95", (28.0, 29.4)), ("upper_95", (29.45, 31.0))):
        assert found[limit] == pytest.approx(brentq(lambda l50: 2.0 * (best(l50) - least) - 3.841459, *ends), abs=2e-3)


def test_the_split_can_be_fixed_anywhere() -> None:
    free, half = (fit_field_data(HADDOCK, "paired", split=split).pooled for split in ("estimated", "equal"))
    fixed = fit_field_data(HADDOCK, "paired", split=free.estimates["split"]).pooled
    assert fixed.log_likelihood == pytest.approx(free.log_likelihood, abs=1e-8)
    assert fixed.estimates["l50_cm"] == pytest.approx(free.estimates["l50_cm"], abs=1e-4)
    assert fixed.estimates["split"] == pytest.approx(free.estimates["split"])
    assert fit_field_data(HADDOCK, "paired", split="0.5").pooled.estimates.values == pytest.approx(
        half.estimates.values
    )


@pytest.mark.parametrize("design", ["covered", "paired"])
def test_flat_data_are_refused_before_a_number_is_given(design: str) -> None:
    rng = np.random.default_rng(1)
    test, other = ("codend", "cover") if design == "covered" else ("test", "control")
    table = pd.DataFrame({"haul": np.repeat([1, 2, 3, 4], 12), "length_cm": np.tile(np.arange(20.0, 32.0), 4)})
    table = table.assign(**{test: rng.poisson(20.0, 48), other: rng.poisson(20.0, 48)})
    fit = fit_field_data(table, design, split="estimated" if design == "paired" else "equal")
    assert not fit.converged
    assert fit_table(fit).query("group in ('one-stage', 'pooled')")["estimate"].isna().all()
    assert len(fit.answers[-1].note) > 40


def test_an_l50_outside_the_lengths_is_empty_with_a_word() -> None:
    length = np.arange(20.0, 30.0)
    kept = np.round(1000.0 * expit(0.5 * (length - 33.0)))
    hauls = [
        pd.DataFrame({"haul": h, "length_cm": length, "codend": kept + h, "cover": 1000.0 - kept}) for h in range(4)
    ]
    fit = fit_field_data(pd.concat(hauls), "covered")
    assert fit.converged
    for answer in fit.answers:
        assert np.isnan(answer.estimates["l50_cm"])
        assert np.isnan(answer.estimates["sr_cm"])
        assert "above the lengths of the fish, 20 to 29 cm" in answer.note
    assert all(np.isnan(haul.estimates["l50_cm"]) and haul.note for haul in fit.hauls)
    assert estimates_within(fit.one_stage)[1] == fit.answers[0].note


def test_hauls_without_a_fit_of_their_own_are_counted_in_two_stages_and_stay_in_one() -> None:
    table = haul_table(8, seed=4)
    table.loc[table["haul"] == "H3", "cover"] = 0.0
    fit = fit_field_data(table, "covered")
    two = next(answer for answer in fit.answers if answer.group == "between-hauls")
    assert "1 of 8 hauls left out" in two.note
    assert "H3" in fit.one_stage.unit_names


def test_the_answer_printed_first_is_unbiased_where_two_stages_are_not() -> None:
    """Part of `validation.field_fit_study`: paired gear, 120 fish a haul and gear, forty trials."""
    from validation.field_fit_study import answers

    found = [answers(seed, "paired", 120, 0) for seed in range(40)]
    assert all(next(iter(trial)) == "one-stage" for trial in found)
    l50, sr = (np.array([trial["one-stage"].values[name] for trial in found]) for name in ("l50_cm", "sr_cm"))
    assert np.isfinite(l50).all()
    assert abs(l50[:, 0].mean() - 32.0) < 0.3
    assert abs(sr[:, 0].mean() - 5.0) < 0.5
    assert ((l50[:, 1] < 32.0) & (l50[:, 2] > 32.0)).mean() >= 0.85
    assert np.mean([trial["between-hauls"].values["l50_cm"][0] for trial in found]) > 32.5
    assert np.median([trial["one-stage"].values["between_sd_l50_cm"][0] for trial in found]) == pytest.approx(
        1.5, abs=0.2
    )


def test_a_trial_without_numbers_says_why() -> None:
    from validation.field_fit_study import answers

    for seed in range(8):
        for answer in answers(seed, "paired", 8, 0).values():
            assert np.isfinite(answer.values["l50_cm"][0]) or len(answer.said) > 20


def test_raised_totals_of_millions_are_fitted_between_hauls_as_counts_are():
    """The mean and what differs between hauls hardly move; only errors within hauls become too small."""
    table = haul_table(8, fish=2000.0, seed=4)
    one = fit_field_data(table, "covered").answers[0].estimates
    table[["codend", "cover"]] *= 5000
    many = fit_field_data(table, "covered").answers[0].estimates
    for name, within in (("l50_cm", 0.02), ("between_sd_l50_cm", 0.05)):
        i = one.names.index(name)
        np.testing.assert_allclose(many.values[i], one.values[i], atol=within)
        np.testing.assert_allclose(many.standard_errors[i], one.standard_errors[i], rtol=0.05)
