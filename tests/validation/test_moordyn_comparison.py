"""Beside MoorDyn-C, where it is installed (the optional group ``moordyn``)."""

import numpy as np
import pytest

from validation.moordyn_comparison import FROM_S, compare


def test_a_shot_warp_is_as_deep_and_pulls_as_hard_as_moordyns():
    pytest.importorskip("moordyn")
    other, own = compare(20, FROM_S + 5.0)
    late = other[:, 0] >= FROM_S
    assert late.sum() == 6
    assert own[late, 2:] == pytest.approx(other[late, 2:], rel=5e-3)
    assert np.array_equal(own[:, 0], other[:, 0])
