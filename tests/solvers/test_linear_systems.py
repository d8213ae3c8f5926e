"""Linear systems of the tangent, apart from any net."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from codend.solvers.linear_systems import narrow_numbering
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


@pytest.mark.parametrize("reach", [1, 2, 3])
@pytest.mark.parametrize("shuffled", [False, True])
def test_a_band_is_as_narrow_as_by_reverse_cuthill_mckee_and_one_that_cannot_be_narrower_is_left(reach, shuffled):
    """Chains in which every node is joined to the next few on either side, some entries named twice."""
    size = 40
    row, column = np.nonzero(np.abs(np.subtract.outer(np.arange(size), np.arange(size))) <= reach)
    order = np.random.default_rng(reach).permutation(size) if shuffled else np.arange(size)
    row, column = np.append(order[row], order[:5]), np.append(order[column], order[:5])
    by_library = np.empty(size, dtype=int)
    graph = coo_array((np.ones(len(row)), (row, column)), shape=(size, size)).tocsr()
    by_library[reverse_cuthill_mckee(graph, symmetric_mode=True)] = np.arange(size)
    place = narrow_numbering(row, column, size)
    assert np.abs(place[row] - place[column]).max() <= np.abs(by_library[row] - by_library[column]).max()
    assert shuffled or (place == np.arange(size)).all()
