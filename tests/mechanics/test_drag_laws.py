"""The laws of drag: their derivatives, their joints, and the numbers of their papers."""

from typing import get_args

import numpy as np
import pytest

from codend.mechanics.drag_laws import CHOO_CASARELLA_1971, DRAG_LAWS, drag, drag_factors
from codend.plan.tables import DRAG_COEFFICIENTS, Drag


@pytest.mark.parametrize("law", DRAG_LAWS)
@pytest.mark.parametrize("across", [1e-4, 0.95e-3, 1e-3, 1.05e-3, 0.01, 0.029, 0.031, 0.2, 3.0])
def test_derivatives_of_the_factors_are_their_differences(law, across):
    def factors(a, b):
        return np.array(drag_factors(DRAG_LAWS.index(law), *DRAG_COEFFICIENTS[law], a, b, 1e3))

    along, step = 0.7, 1e-4 * across
    by_across = (factors(across + step, along) - factors(across - step, along))[:2] / (2.0 * step)
    by_along = (factors(across, along + step) - factors(across, along - step))[:2] / (2.0 * step)
    _, _, a_across, a_along, c_across, c_along = factors(across, along)
    assert [a_across, c_across] == pytest.approx(by_across, rel=1e-5, abs=1e-7)
    assert [a_along, c_along] == pytest.approx(by_along, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize(
    ("reynolds", "coefficient"),
    [(0.1, 55.642), (10.0, 1.45 + 8.55 * 10**-0.9), (1e3, 1.1 + 4.0 / np.sqrt(1e3)), (1e5, 1.1126)],
)
def test_choo_and_casarellas_coefficient_is_that_of_its_pieces(reynolds, coefficient):
    a, *_ = drag_factors(CHOO_CASARELLA_1971, 1.0, 1.0, 1.0, 0.0, reynolds)
    assert a == pytest.approx(coefficient, rel=1e-4)


@pytest.mark.parametrize("joint", [1.0, 30.0])
def test_the_pieces_meet_without_a_jump(joint):
    """Within a band about a joint the coefficient lies between the two pieces, which are 2 % apart at most."""
    numbers = joint * np.exp(np.linspace(-0.2, 0.2, 4001))
    found = np.array([drag_factors(CHOO_CASARELLA_1971, 1.0, 1.0, 1.0, 0.0, r)[0] for r in numbers])
    assert np.abs(np.diff(found) / found[:-1]).max() < 5e-4


def test_an_unknown_law_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match="le-bris-1999"):
        drag("morison", 1.0, 1.0)


def test_a_plan_may_choose_every_law():
    assert get_args(Drag.model_fields["law"].annotation) == DRAG_LAWS == tuple(DRAG_COEFFICIENTS)
