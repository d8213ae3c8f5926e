"""Linear systems of the tangent, apart from any net."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from codend.mechanics.problem import Problem
from codend.mechanics.rigid import rigid_pattern
from codend.net.net import Net
from codend.solvers.linear_systems import narrow_numbering
from codend.solvers.one_sided import PASSES, OneSided
from codend.solvers.sparse_kernels import columns_in_order
from codend.solvers.sparse_system import SparseSystem
from codend.solvers.symmetric_system import SymmetricSystem


def test_a_matrix_that_cannot_be_factorised_leaves_no_factors_to_go_on_with():
    """The last ones would be those of another matrix."""
    unknown, place = np.array([[0, 1]], dtype=np.int32), np.array([[0, 1], [0, 1]], dtype=np.int32)
    system = SparseSystem(unknown, place.T.copy(), place)
    assert not system.ready
    assert system.factorise(np.array([[2.0, 1.0], [1.0, 3.0]])) == 0
    assert system.solve(np.array([[[3.0, 4.0]]])).ravel() == pytest.approx([1.0, 1.0])
    assert system.factorise(np.array([[1.0, 1.0], [1.0, 1.0]])) == -1
    assert not system.ready


def _pattern(seed, size=60):
    """Entries of a random symmetric matrix, each place named once, in any order."""
    rng = np.random.default_rng(seed)
    pairs = rng.integers(size, size=(2 * size, 2))
    named = np.unique(np.concatenate([pairs, pairs[:, ::-1], np.stack([np.arange(size)] * 2, axis=1)]), axis=0)
    row, column = rng.permutation(named).astype(np.int32).T
    half = rng.normal(size=(size, size))
    values = np.where(row < column, half[row, column], half[column, row])
    return row, column, np.where(row == column, 10.0 + abs(values), values)


@pytest.mark.parametrize("seed", range(3))
def test_a_symmetric_system_is_solved_with_the_same_pattern_again_and_again(seed):
    row, column, values = _pattern(seed)
    system = SymmetricSystem(row, column, 60)
    for scale in (1.0, 0.5):
        whole = np.zeros((60, 60))
        whole[row, column] = scale * values
        right = np.random.default_rng(9).normal(size=(2, 60, 1))
        assert system.factorise(scale * values) == system.negative_pivots() == np.sum(np.linalg.eigvalsh(whole) < 0.0)
        assert np.allclose(system.solve(right)[..., 0].T, np.linalg.solve(whole, right[..., 0].T), rtol=1e-9)
    assert system.ready
    assert system.factorise(np.where(row == column, 0.0, 0.0 * values)) == -1
    assert not system.ready


@pytest.mark.parametrize("passes", [PASSES, 0])
def test_bars_that_never_push_pull_or_come_out_no_longer_than_they_are(passes, monkeypatch):
    """By either way of finding which are taut."""
    monkeypatch.setattr("codend.solvers.one_sided.PASSES", passes)
    rng = np.random.default_rng(4)
    places, ends = rng.normal(size=(20, 3)), np.array([(i, j) for i in range(20) for j in range(i) if (i - j) % 7 < 3])
    net = Net.from_bars(places, ends, np.zeros(20, dtype=bool))
    one_sided = OneSided(rigid_pattern(Problem.of(net).structure), np.zeros(len(ends), dtype=bool))
    jacobian = np.zeros((len(ends), 60))
    for bar, (a, b) in enumerate(ends):
        jacobian[bar, 3 * b : 3 * b + 3] = places[b] - places[a]
        jacobian[bar, 3 * a : 3 * a + 3] = places[a] - places[b]
    whole = jacobian @ jacobian.T + 0.1 * np.eye(len(ends))
    one_sided.entries[:] = whole[one_sided.pattern.row, one_sided.pattern.column]
    right = rng.normal(size=len(ends))
    density = one_sided.solve(right)
    left_over = whole @ density - right
    assert density.min() >= 0.0
    assert left_over.min() > -1e-8
    assert np.abs(density * left_over).max() < 1e-8
    assert 0 < np.count_nonzero(density) < len(ends)
    assert one_sided.unsettled == 0


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


@pytest.mark.parametrize("size", [1, 5, 40])
def test_entries_go_into_columns_with_their_rows_in_order_and_those_of_held_coordinates_nowhere(size):
    rng = np.random.default_rng(size)
    row, column = (part.astype(np.int32) for part in np.nonzero(rng.random((size, size)) < 0.4))
    mixed = rng.permutation(len(row))
    row, column = row[mixed], column[mixed]
    row[rng.random(len(row)) < 0.2] = -1
    order, rows, starts = columns_in_order(row, column, size)
    used = np.flatnonzero(row >= 0)
    expected = used[np.lexsort((row[used], column[used]))]
    np.testing.assert_array_equal(order, expected)
    np.testing.assert_array_equal(rows, row[expected])
    np.testing.assert_array_equal(starts, np.searchsorted(column[expected], np.arange(size + 1)))
