"""The papers' contact by prediction and correction against closed forms and the engine's own contact."""

import numpy as np
import pytest

from validation.prediction_correction import CASES, by_the_engine, settled


@pytest.mark.parametrize("make", CASES)
def test_prediction_and_correction_in_one_system_is_contact_without_friction(make):
    case = make(20)
    rest = settled(case)
    gaps, load = case.gaps(rest.position)[1:], case.load(rest.position)
    assert gaps.min() >= -1e-6 * case.bar_m
    assert rest.reaction.min() >= 0.0
    assert np.abs(rest.reaction[1:] * gaps).max() < 1e-9
    # all that acts on the free nodes, the plane among it, is in balance with the pull of the first bar
    along = rest.position[1] - rest.position[0]
    left = load[1:].sum(axis=0) + rest.reaction.sum() * case.normal - rest.tension[0] * along / np.linalg.norm(along)
    assert np.linalg.norm(left) < 1e-4 * np.abs(load).sum()
    assert rest.reaction.sum() == pytest.approx(case.on_plane_n, rel=3e-3)
    assert by_the_engine(case) == pytest.approx(rest.reaction.sum(), rel=1e-3)
