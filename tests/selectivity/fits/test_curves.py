"""Retention curves against closed forms, each other and difference quotients."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from codend.selectivity.fits.curves import CURVES
from codend.selectivity.predicted_and_observed.simulate import parameters_of

EXAMPLES = {
    "logit": (-12.0, 0.4),
    "probit": (-9.0, 0.3),
    "gompertz": (-11.0, 0.35),
    "cloglog": (-10.0, 0.33),
    "richards": (-12.0, 0.4, 2.5),
}
LENGTH_CM = np.linspace(10.0, 60.0, 41)
curves = pytest.mark.parametrize("name", list(CURVES))


@curves
def test_l50_and_selection_range_are_where_the_curve_crosses_a_quarter_half_and_three_quarters(name: str) -> None:
    curve, parameters = CURVES[name], EXAMPLES[name]

    def crossing(p: float) -> float:
        return brentq(lambda length: curve.retention([length], parameters)[0] - p, 0.0, 100.0, xtol=1e-12)

    l50, sr = curve.l50_sr(parameters)
    assert l50 == pytest.approx(crossing(0.5), abs=1e-9)
    assert sr == pytest.approx(crossing(0.75) - crossing(0.25), abs=1e-9)
    assert curve.length_at(0.9, parameters) == pytest.approx(crossing(0.9), abs=1e-9)


def test_selection_ranges_have_their_textbook_factors() -> None:
    unit = {name: CURVES[name].l50_sr((0.0, 1.0)) for name in ("logit", "probit", "gompertz", "cloglog")}
    assert unit["logit"] == pytest.approx([0.0, 2.0 * np.log(3.0)])
    assert unit["probit"] == pytest.approx([0.0, 1.3489795])
    assert unit["gompertz"] == pytest.approx([0.3665129, 1.5725327])
    assert unit["cloglog"] == pytest.approx([-0.3665129, 1.5725327])


@curves
def test_gradients_of_retention_l50_and_range_equal_difference_quotients(name: str) -> None:
    curve, parameters = CURVES[name], np.array(EXAMPLES[name])
    gradient, l50_sr_gradient = curve.retention_gradient(LENGTH_CM, parameters), curve.l50_sr_gradient(parameters)
    for i in range(parameters.size):
        h = np.zeros(parameters.size)
        h[i] = 1e-5 * abs(parameters[i])
        up, down = parameters + h, parameters - h
        quotient = (curve.retention(LENGTH_CM, up) - curve.retention(LENGTH_CM, down)) / (2.0 * h[i])
        assert gradient[:, i] == pytest.approx(quotient, rel=1e-6, abs=1e-10)
        quotient = (curve.l50_sr(up) - curve.l50_sr(down)) / (2.0 * h[i])
        assert l50_sr_gradient[:, i] == pytest.approx(quotient, rel=1e-6, abs=1e-9)


@curves
@pytest.mark.parametrize("delta", [0.3, 1.0, 4.0])
def test_derivatives_of_log_retention_equal_difference_quotients(name: str, delta: float) -> None:
    eta = np.array([-30.0, -8.0, -1.0, -0.1, 0.0, 0.2, 1.5, 8.0, 25.0])
    curve, h = CURVES[name], 1e-5

    def parts(step_eta: float, step_delta: float) -> tuple:
        return curve.log_parts(eta + step_eta, np.full_like(eta, delta * np.exp(step_delta)))

    for side in (0, 1):
        at = parts(0.0, 0.0)[side]
        by_eta = [(u - d) / (2 * h) for u, d in zip(parts(h, 0)[side], parts(-h, 0)[side], strict=True)]
        by_log_delta = [(u - d) / (2 * h) for u, d in zip(parts(0, h)[side], parts(0, -h)[side], strict=True)]
        assert np.allclose(at.eta, by_eta[0], rtol=1e-6, atol=1e-9)
        assert np.allclose(at.eta_eta, by_eta[1], rtol=1e-6, atol=1e-9)
        assert np.allclose(at.log_delta, by_log_delta[0], rtol=1e-6, atol=1e-9)
        assert np.allclose(at.eta_log_delta, by_log_delta[1], rtol=1e-6, atol=1e-9)
        assert np.allclose(at.log_delta_log_delta, by_log_delta[3], rtol=1e-6, atol=1e-9)


@curves
@settings(deadline=None)
@given(eta=st.floats(-1e4, 1e4), log_delta=st.floats(-2.0, 2.0))
def test_tails_stay_finite_and_the_two_probabilities_add_up_to_one(name: str, eta: float, log_delta: float) -> None:
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        parts = CURVES[name].log_parts(np.array([eta]), np.exp(np.array([log_delta])))
    assert all(np.isfinite(value).all() for part in parts for value in part)
    assert np.exp(parts.retained.value) + np.exp(parts.escaped.value) == pytest.approx(1.0, abs=1e-12)
    assert parts.retained.eta >= 0.0 >= parts.escaped.eta


@curves
def test_the_rarest_escape_keeps_its_relative_precision(name: str) -> None:
    """Far up the curve 1 - r falls by exp(-step), or faster, long after r itself has rounded to one."""
    curve = CURVES[name]
    eta, delta = np.array([50.0, 51.0]), np.array([2.0, 2.0])
    fall = np.diff(curve.log_parts(eta, delta).escaped.value)[0]
    if name in ("logit", "gompertz", "richards"):
        assert fall == pytest.approx(-1.0, rel=1e-12)
    else:
        assert fall < -50.0


def test_gompertz_is_the_complementary_log_log_curve_upside_down() -> None:
    eta, delta = np.linspace(-6.0, 6.0, 25), np.ones(25)
    gompertz, cloglog = CURVES["gompertz"].log_parts(eta, delta), CURVES["cloglog"].log_parts(-eta, delta)
    assert gompertz.retained.value == pytest.approx(cloglog.escaped.value, rel=1e-14)


def test_richards_with_delta_one_is_the_logit_curve() -> None:
    logit, richards = CURVES["logit"], CURVES["richards"]
    assert richards.retention(LENGTH_CM, (-12.0, 0.4, 1.0)) == pytest.approx(logit.retention(LENGTH_CM, (-12.0, 0.4)))
    assert richards.l50_sr((-12.0, 0.4, 1.0)) == pytest.approx(logit.l50_sr((-12.0, 0.4)))


@curves
def test_parameters_of_a_given_l50_and_range_give_them_back(name: str) -> None:
    curve = CURVES[name]
    parameters = parameters_of(name, 31.0, 4.5, 0.4 if curve.has_shape else None)
    assert curve.l50_sr(parameters) == pytest.approx([31.0, 4.5])


def test_a_wrong_number_of_parameters_is_refused() -> None:
    with pytest.raises(ValueError, match="delta"):
        CURVES["richards"].retention(LENGTH_CM, (-12.0, 0.4))
