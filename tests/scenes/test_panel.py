"""Lift and drag of panels of netting, and the fit of twine coefficients; the checks by summation are in validation."""

import numpy as np
import pytest

from codend.scenes.panel import fit_panel, panel_coefficients, solidity

LAWS = [("le-bris-1999", 1.36, 0.07), ("bessonneau-1997", 1.2, 0.1)]


@pytest.mark.parametrize(("law", "normal", "tangential"), LAWS)
def test_a_panel_across_the_flow_has_the_drag_of_its_twine_and_no_lift(law, normal, tangential):
    lift, drag = panel_coefficients(90.0, [10.0, 60.0, 120.0], normal, tangential, law)
    assert drag == pytest.approx(normal)
    assert lift == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(("law", "normal", "tangential"), LAWS)
def test_a_panel_of_closed_meshes_along_the_flow_has_friction_alone(law, normal, tangential):
    lift, drag = panel_coefficients(0.0, 0.0, normal, tangential, law)
    friction = tangential * normal if law == "le-bris-1999" else tangential
    assert (lift, drag) == (pytest.approx(0.0), pytest.approx(friction))


@pytest.mark.parametrize(("law", "normal", "tangential"), LAWS)
def test_turned_the_other_way_a_panel_has_the_same_drag_and_opposite_lift(law, normal, tangential):
    incidence = np.linspace(5.0, 85.0, 9)
    lift, drag = panel_coefficients(incidence, 50.0, normal, tangential, law)
    other_lift, other_drag = panel_coefficients(180.0 - incidence, 50.0, normal, tangential, law)
    assert other_lift == pytest.approx(-lift)
    assert other_drag == pytest.approx(drag)
    assert np.all(lift > 0.0)


def test_friction_like_drag_across_pushes_a_panel_straight_downstream():
    """With kn = kt (Bessonneau, Cd = Cf) a side's load lies along the flow at any incidence."""
    lift, drag = panel_coefficients([20.0, 70.0], 40.0, 0.8, 0.8, "bessonneau-1997")
    assert lift == pytest.approx(0.0, abs=1e-15)
    assert drag == pytest.approx(0.8)


def test_solidity_is_twine_area_over_the_area_of_a_mesh():
    bar, twine, opening = 0.02, 0.0005, 40.0
    diagonals = 2.0 * bar * np.sin(np.radians(opening / 2)), 2.0 * bar * np.cos(np.radians(opening / 2))
    per_mesh = 2 * bar * twine  # four sides, each shared by two meshes
    assert solidity(twine, bar, opening) == pytest.approx(per_mesh / (0.5 * diagonals[0] * diagonals[1]))


def test_numbers_not_measured_are_left_out_of_the_fit():
    incidence = np.arange(0.0, 91.0, 15.0)
    lift, drag = panel_coefficients(incidence, 60.0, 1.36, 0.07)
    lift[2], drag[4] = np.nan, np.nan
    fit = fit_panel(incidence, 60.0, lift, drag)
    assert (fit.normal, fit.tangential) == (pytest.approx(1.36), pytest.approx(0.07))
    assert fit.residual == pytest.approx(0.0, abs=1e-12)


def test_two_numbers_give_coefficients_and_no_standard_errors():
    _, drag = panel_coefficients([0.0, 45.0], 60.0, 1.36, 0.07)
    fit = fit_panel([0.0, 45.0], 60.0, [np.nan, np.nan], drag)
    assert fit.normal == pytest.approx(1.36)
    assert np.isnan(fit.normal_error)
    assert np.isnan(fit.tangential_error)


@pytest.mark.parametrize(
    ("incidence", "lift", "drag", "said"),
    [
        ([90.0], [np.nan], [1.3], "1 measured number"),
        ([90.0, 90.0, 90.0], [0.0, 0.0, 0.0], [1.3, 1.4, 1.35], "more incidences are needed"),
        ([0.0, 90.0, 45.0], [0.0, 0.0], [0.1, 1.3], "shape mismatch"),
    ],
)
def test_data_that_cannot_tell_are_refused(incidence, lift, drag, said):
    with pytest.raises(ValueError, match=said):
        fit_panel(incidence, 60.0, lift, drag)


def test_an_unknown_law_is_refused():
    with pytest.raises(ValueError, match="unknown drag law 'stokes'"):
        panel_coefficients(0.0, 60.0, 1.0, 0.1, "stokes")
