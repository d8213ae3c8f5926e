"""The square pin-jointed net of the benchmark: four ways to one equilibrium, at the residual the table asks for."""

import numpy as np
import pytest

from validation.benchmark_pin_jointed import RESIDUAL, by_newton, by_relaxation, ours, residual, square_net

SIDE, THROUGH = 16, (8, 16)


@pytest.fixture(scope="module")
def exact():
    return ours("", by_newton, [SIDE], tolerance=1e-10, repeats=1).positions


@pytest.mark.parametrize("method", [by_newton, by_relaxation])
@pytest.mark.parametrize("sides", [(SIDE,), THROUGH])
def test_every_way_ends_at_the_same_equilibrium_within_the_residual(method, sides, exact):
    problem = square_net(SIDE, SIDE)
    found = ours("", method, sides, repeats=1).positions
    assert residual(problem, found) <= 3 * RESIDUAL  # the bars are held to their law by another tolerance
    np.testing.assert_allclose(found, exact, atol=1e-5 * np.abs(exact[:, 2]).max())


def test_the_net_keeps_the_symmetry_of_its_square(exact):
    sag = exact[:, 2].reshape(SIDE, SIDE)
    for same in (sag.T, sag[::-1], sag[:, ::-1]):
        np.testing.assert_allclose(same, sag, atol=1e-9)
    assert np.all(sag[1:-1, 1:-1] > 0.0)
