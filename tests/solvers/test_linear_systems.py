"""Linear systems of the tangent, apart from any net."""

import numpy as np
import pytest

from codend.solvers.sparse_system import SparseSystem


def test_a_matrix_that_cannot_be_factorised_leaves_no_factors_to_go_on_with():
    """The last ones would be those of another matrix."""
    unknown, place = np.array([[0, 1]], dtype=np.int32), np.array([[0, 1], [0, 1]], dtype=np.int32)
    system = SparseSystem(unknown, place.T.copy(), place)
    assert not system.ready
    assert system.factorise(np.array([[2.0, 1.0], [1.0, 3.0]])) == 0
    assert system.solve(np.array([[[3.0, 4.0]]])).ravel() == pytest.approx([1.0, 1.0])
    assert system.factorise(np.array([[1.0, 1.0], [1.0, 1.0]])) == -1
    assert not system.ready
