"""Eigenvalues of unsymmetric tangents of whole nets whose symmetric part has many more negative ones than are found."""

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_array

from codend.solvers.whole_tangent import EXACTLY, FIRST_EIGENVALUES, ROUGHLY, WholeTangent


def skewed(lowest: float) -> WholeTangent:
    """Pairs of unknowns with eigenvalues from 0.5 to 4, one of ``lowest``, and a symmetric part negative in each."""
    first, second = np.linspace(0.5, 2.0, 350), np.linspace(2.5, 4.0, 350)
    first[7] = lowest
    matrix = csc_array(block_diag([[[a, 12.0], [0.0, b]] for a, b in zip(first, second, strict=True)]))
    return WholeTangent(matrix, np.zeros((1, 700)), np.zeros((1, 700)))


@pytest.mark.parametrize("lowest", [-0.3, -1e-6])
def test_what_grows_however_weakly_is_found_to_the_last_digits(lowest):
    found = skewed(lowest).growing(1.0, FIRST_EIGENVALUES, thorough=True)
    assert not found.complete
    assert found.eigenvalues.real == pytest.approx([lowest], rel=1e-3)


def test_of_many_that_cannot_be_found_all_it_is_soon_told_not_to_be_known_whether_any_grows(monkeypatch):
    nearest, asked = WholeTangent._nearest, []

    def noted(whole, centre, wanted, tolerance=EXACTLY):
        asked.append(tolerance)
        return nearest(whole, centre, wanted, tolerance)

    monkeypatch.setattr(WholeTangent, "_nearest", noted)
    found = skewed(0.4).growing(1.0, FIRST_EIGENVALUES, thorough=True)
    assert len(found.eigenvalues) == 0
    assert not found.complete
    assert asked == [ROUGHLY]
    # no eigenvalue is lower than the symmetric part's lowest
    lowest = np.linalg.eigvalsh(np.array([[0.4, 6.0], [6.0, 2.5]])).min()
    assert found.at_most >= -lowest
