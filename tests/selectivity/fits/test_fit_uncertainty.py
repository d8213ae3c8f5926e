"""Intervals against simulated truth; bootstrap, between-haul variation, and comparison of gears."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.special import ndtri

from codend.selectivity.fits.analysis import fit_field_data
from codend.selectivity.fits.between_hauls import _negative_reml, fit_between_hauls, reml
from codend.selectivity.fits.bootstrap import Bootstrap, double_bootstrap, resample
from codend.selectivity.fits.compare_gears import difference_curve, fished_population, usability
from codend.selectivity.fits.curves import CURVES
from codend.selectivity.fits.fielddata import FieldData, read_field_data
from codend.selectivity.fits.fit import fit_hauls, fit_pooled
from codend.selectivity.fits.model import selection_model
from codend.selectivity.fits.parameters import parameter_names, public_parameters
from codend.selectivity.fits.scoring import maximise
from codend.selectivity.predicted_and_observed.simulate import SimulatedTrial, parameters_of

LENGTH_CM = np.arange(15.0, 46.0)
FISH = 100.0 * np.exp(-0.5 * ((LENGTH_CM - 30.0) / 6.0) ** 2)


def one_trial(trial: SimulatedTrial, seed: int) -> FieldData:
    test, other = trial.counts(1, np.random.default_rng(seed))
    return replace(trial.rows(), test_count=test[0], other_count=other[0])


def logit_trial(l50_cm: float = 30.0, n_hauls: int = 1, **settings: object) -> SimulatedTrial:
    return SimulatedTrial("logit", parameters_of("logit", l50_cm, 5.0), "covered", LENGTH_CM, FISH, n_hauls, **settings)


@pytest.mark.parametrize(
    ("curve", "design", "split", "raising"),
    [
        *((curve, "covered", 0.5, 1.0) for curve in CURVES),
        ("logit", "covered", 0.5, 4.0),
        ("logit", "paired", 0.5, 1.0),
        ("cloglog", "paired", 0.6, 1.0),
        ("logit", "paired", 0.6, 2.0),
    ],
)
def test_estimates_are_unbiased_and_intervals_cover_the_truth(
    curve: str, design: str, split: float, raising: float
) -> None:
    """600 simulated hauls: mean within 4 Monte Carlo errors, coverage within 4 binomial errors of 95 %."""
    n_trials = 600
    delta = 2.0 if CURVES[curve].has_shape else None
    fish = FISH * (20.0 if design == "paired" else 4.0)
    trial = SimulatedTrial(
        curve, parameters_of(curve, 30.0, 5.0, delta), design, LENGTH_CM, fish, split=split, other_raising=raising
    )
    model = selection_model(trial.rows(), curve, estimate_split=split != 0.5)
    maximum = maximise(model, *trial.counts(n_trials, np.random.default_rng(11)))
    assert maximum.converged.all()
    values, jacobian = public_parameters(model, maximum.theta)
    errors = np.sqrt(np.einsum("smi,sij,smj->sm", jacobian, maximum.covariance, jacobian))
    truths = {"l50_cm": 30.0, "sr_cm": 5.0} | ({"split": split} if split != 0.5 else {})
    for name, truth in truths.items():
        i = parameter_names(model).index(name)
        mean_error = values[:, i].mean() - truth
        assert abs(mean_error) < 4.0 * values[:, i].std() / np.sqrt(n_trials)
        covered = (np.abs(values[:, i] - truth) < ndtri(0.975) * errors[:, i]).mean()
        assert abs(covered - 0.95) < 4.0 * np.sqrt(0.95 * 0.05 / n_trials)


def test_a_batch_of_fits_is_the_fits_one_by_one() -> None:
    trial = logit_trial()
    model = selection_model(trial.rows(), "logit")
    test, other = trial.counts(7, np.random.default_rng(0))
    together = maximise(model, test, other).theta
    alone = np.concatenate([maximise(model, test[i : i + 1], other[i : i + 1]).theta for i in range(7)])
    assert together == pytest.approx(alone, rel=1e-8)


def test_bootstrap_of_one_haul_has_the_errors_of_the_delta_method() -> None:
    data = one_trial(logit_trial(), seed=1)
    fit = fit_pooled(data, selection_model(data, "logit"))
    boot = double_bootstrap(data, fit, 2000, seed=4)
    assert boot.n_failed == 0
    assert boot.estimates.standard_errors == pytest.approx(fit.estimates.standard_errors, rel=0.12)
    assert boot.estimates.lower_95 == pytest.approx(fit.estimates.lower_95, rel=0.03)


def test_bootstrap_is_reproducible_and_depends_on_its_seed() -> None:
    data = one_trial(logit_trial(n_hauls=3), seed=1)
    fit = fit_pooled(data, selection_model(data, "logit"))
    one, same, other = (double_bootstrap(data, fit, 50, seed).replicates for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_a_bootstrap_tells_how_far_it_is_and_moves_no_number_for_it() -> None:
    data = one_trial(logit_trial(n_hauls=3), seed=1)
    fit = fit_pooled(data, selection_model(data, "logit"))
    told: list[tuple[int, int, str]] = []
    found = double_bootstrap(data, fit, 120, 1, lambda *said: told.append(said)).replicates
    assert [(done, total) for done, total, _ in told] == [(0, 120), (50, 120), (100, 120)]
    assert np.array_equal(found, double_bootstrap(data, fit, 120, 1).replicates)


def test_resampling_draws_counted_fish_haul_by_haul() -> None:
    """Whole fish only, whole hauls' totals, in cells that had fish, and the right mean: raised numbers play no part."""
    data = replace(one_trial(logit_trial(n_hauls=4), seed=2), other_raising=np.full(4 * LENGTH_CM.size, 7.0))
    test, other = resample(data, 3000, np.random.default_rng(0))
    assert np.array_equal(test, np.round(test))
    assert np.all(test[:, data.test_count == 0] == 0)
    totals = np.bincount(data.haul, data.test_count + data.other_count)
    for h in range(4):
        drawn = (test + other)[:, data.haul == h].sum(axis=1) / totals[h]
        assert set(np.unique(drawn)) <= {0.0, 1.0, 2.0, 3.0, 4.0}
    assert test.mean(axis=0) == pytest.approx(data.test_count, abs=0.15 * data.test_count.max())


def test_failed_refits_are_counted_and_too_many_of_them_leave_no_interval() -> None:
    """Nearly knife-edged data: the two overlapping fish are missing from a good part of the replicates."""
    table = pd.DataFrame(
        {"haul": 1, "length_cm": np.arange(20.0, 26.0), "codend": [0, 0, 1, 9, 9, 9], "cover": [9, 9, 9, 1, 0, 0]}
    )
    boot = fit_field_data(table, "covered", n_bootstrap=300).bootstrap
    assert boot is not None
    assert 30 < boot.n_failed < 300
    assert len(boot.replicates) == 300 - boot.n_failed
    assert np.isnan(boot.estimates.lower_95).all()
    assert not np.isnan(boot.estimates.values).any()


def test_double_bootstrap_sees_the_variation_between_hauls() -> None:
    _, b = parameters_of("logit", 30.0, 5.0)
    shift_of_l50 = np.array([[(2.0 * b) ** 2, 0.0], [0.0, 0.0]])
    data = one_trial(logit_trial(n_hauls=15, between_covariance=shift_of_l50), seed=6)
    fit = fit_pooled(data, selection_model(data, "logit"))
    i = fit.estimates.names.index("l50_cm")
    boot = double_bootstrap(data, fit, 500)
    expected = 2.0 / np.sqrt(15)  # standard deviation of L50 between hauls over the root of their number
    assert boot.estimates.standard_errors[i] == pytest.approx(expected, rel=0.5)
    assert boot.estimates.standard_errors[i] > 2.0 * fit.estimates.standard_errors[i]


def test_reml_of_equal_errors_is_the_closed_form_of_a_balanced_design() -> None:
    """With one R for all hauls, D + R is the sample covariance and the mean curve the mean of the hauls."""
    rng = np.random.default_rng(8)
    v = rng.multivariate_normal([1.0, -2.0], [[3.0, 1.0], [1.0, 2.0]], 25)
    within = np.tile([[0.3, 0.1], [0.1, 0.2]], (25, 1, 1))
    found = reml(v, within, np.tile(np.eye(2), (25, 1, 1)))
    assert found is not None
    theta, covariance, between = found
    sample = np.cov(v.T)
    assert theta == pytest.approx(v.mean(axis=0), rel=1e-6)
    assert between + within[0] == pytest.approx(sample, rel=1e-4)
    assert covariance == pytest.approx(sample / 25, rel=1e-4)


def test_reml_gradient_equals_difference_quotients() -> None:
    rng = np.random.default_rng(9)
    v, design = rng.standard_normal((8, 2)), np.tile(np.eye(2), (8, 1, 1))
    within = np.array([np.diag(d) for d in rng.uniform(0.1, 1.0, (8, 2))])
    between, h = np.array([[0.5, 0.2], [0.2, 0.4]]), 1e-6
    by_d = _negative_reml(v, within, design, between)[1]
    for i, j in ((0, 0), (1, 1), (0, 1)):
        step = np.zeros((2, 2))
        step[i, j] = step[j, i] = h
        up, down = (_negative_reml(v, within, design, between + s)[0] for s in (step, -step))
        assert (up - down) / (2 * h) == pytest.approx((by_d * step).sum() / h, rel=1e-5)


def test_hauls_that_do_not_differ_give_the_pooled_curve_and_little_between_haul_variance() -> None:
    data = one_trial(logit_trial(n_hauls=10), seed=3)
    model = selection_model(data, "logit")
    pooled, between = fit_pooled(data, model), fit_between_hauls(data, model, fit_hauls(data, model))
    assert between.converged
    for name in ("l50_cm", "sr_cm"):
        i = pooled.estimates.names.index(name)
        assert abs(between.estimates[name] - pooled.estimates[name]) < pooled.estimates.standard_errors[i]
        assert between.between_sd[i] < 4.0 * pooled.estimates.standard_errors[i]


def test_between_haul_mean_uses_covariates_and_names_hauls_it_had_to_leave_out() -> None:
    rng = np.random.default_rng(4)
    frames = []
    for h in range(12):
        catch_t = 0.1 * (1 + h)
        data = one_trial(logit_trial(l50_cm=28.0 + 3.0 * catch_t + rng.normal(0.0, 0.3)), seed=100 + h)
        columns = {"length_cm": data.length_cm, "codend": data.test_count, "cover": data.other_count}
        frames.append(pd.DataFrame({"haul": f"H{h}", "catch_t": catch_t, **columns}))
    frames[5]["cover"] = 0.0  # all retained: no curve of its own
    result = fit_field_data(pd.concat(frames), "covered", covariates=["catch_t"])
    between = result.between_hauls
    assert between is not None
    assert between.excluded == ("H5",)
    assert "H5" in between.message
    i = between.estimates.names.index("l50_cm:catch_t")
    assert between.estimates.lower_95[i] < 3.0 < between.estimates.upper_95[i]
    assert between.estimates.lower_95[i] > 0.0


def test_too_few_hauls_give_no_mean_but_a_message() -> None:
    data = one_trial(logit_trial(n_hauls=2), seed=3)
    model = selection_model(data, "logit")
    between = fit_between_hauls(data, model, fit_hauls(data, model))
    assert not between.converged
    assert "too few" in between.message
    assert np.isnan(between.estimates.values).all()


def bootstrapped(l50_cm: float, seed: int) -> Bootstrap:
    data = one_trial(logit_trial(l50_cm), seed)
    return double_bootstrap(data, fit_pooled(data, selection_model(data, "logit")), 400, seed)


def test_a_gear_differs_from_another_where_their_curves_do() -> None:
    small, same, large = bootstrapped(28.0, 1), bootstrapped(28.0, 2), bootstrapped(33.0, 3)
    difference = difference_curve(small, large, LENGTH_CM)
    assert difference.significant[(LENGTH_CM > 27.0) & (LENGTH_CM < 34.0)].all()
    assert np.all(difference.difference[difference.significant] > 0.0)
    assert difference_curve(small, same, LENGTH_CM).significant.mean() < 0.5
    mirrored = difference_curve(large, small, LENGTH_CM)
    assert mirrored.difference == pytest.approx(-difference.difference)
    assert mirrored.lower_95 == pytest.approx(-difference.upper_95)


def test_usability_indicators_are_the_sums_they_are_defined_by() -> None:
    gear = bootstrapped(30.0, 5)
    population = np.array([10.0, 20.0, 30.0, 40.0])
    lengths = np.array([26.0, 29.0, 30.0, 34.0])
    r = gear.retention(lengths)[0]
    found = usability(gear, lengths, population, reference_length_cm=30.0)
    small, large = (r * population)[:2].sum(), (r * population)[2:].sum()
    assert found.np_minus.percent == pytest.approx(100.0 * small / 30.0)
    assert found.np_plus.percent == pytest.approx(100.0 * large / 70.0)
    assert found.discard_ratio.percent == pytest.approx(100.0 * small / (small + large))
    for indicator in (found.np_minus, found.np_plus, found.discard_ratio):
        assert indicator.lower_95 < indicator.percent < indicator.upper_95
    assert np.isnan(usability(gear, lengths, population, 20.0).np_minus.percent)


def test_the_fished_population_is_raised() -> None:
    table = pd.DataFrame(
        {"haul": [1, 1, 2], "length_cm": [20, 21, 20], "codend": [1, 2, 3], "cover": [4, 5, 6], "cover_raising": 10.0}
    )
    lengths, numbers = fished_population(read_field_data(table, "covered"))
    assert lengths == pytest.approx([20, 21])
    assert numbers == pytest.approx([1 + 40 + 3 + 60, 2 + 50])
