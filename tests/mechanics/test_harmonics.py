"""Pivots of harmonics side by side, against the eigenvalues of the same matrices written out."""

import numpy as np
import pytest

from codend.mechanics.harmonics import negative_pivots_side_by_side


@pytest.mark.parametrize("harmonics", [1, 16, 37])
def test_negative_pivots_are_as_many_as_negative_eigenvalues(harmonics):
    rng = np.random.default_rng(harmonics)
    start = np.repeat([0, 0, 0, 3, 3, 9, 9, 15], 3)  # each three rows begin where some before them do
    rows, tails, reach = len(start), 2, 2
    depth = (np.arange(rows) - start).astype(np.int32)
    unknowns, width = rows - tails, int(depth.max()) + 1
    even, odd = rng.standard_normal((2, reach + 1, unknowns, width))
    tail = rng.standard_normal((tails, width, 2, harmonics))
    outside = np.arange(width) > depth[:, None]
    even[:, outside[:unknowns]], odd[:, outside[:unknowns]], tail[outside[unknowns:]] = 0.0, 0.0, 0.0
    odd[:, :, 0], tail[:, 0, 1] = 0.0, 0.0
    angle = np.arange(reach + 1)[:, None] * rng.uniform(0.0, np.pi, harmonics)
    shift = rng.uniform(-2.0, 6.0, harmonics)

    found = np.full(harmonics, -1)
    negative_pivots_side_by_side(even, odd, depth, np.stack([np.cos(angle), np.sin(angle)]), shift, tail, found)

    expected = []
    for k in range(harmonics):
        whole = np.zeros((rows, rows), dtype=complex)
        for i in range(rows):
            for d in range(depth[i] + 1):
                if i < unknowns:
                    # S has no part of the sector itself
                    whole[i, i - d] = np.cos(angle[:, k]) @ even[:, i, d] + 1j * np.sin(angle[:, k]) @ odd[:, i, d]
                else:
                    whole[i, i - d] = tail[i - unknowns, d, 0, k] + 1j * tail[i - unknowns, d, 1, k]
        values = np.linalg.eigvalsh(whole + shift[k] * np.eye(rows))  # of the lower triangle
        expected.append(np.count_nonzero(values < 0.0))
    assert found.tolist() == expected
    assert harmonics == 1 or len(set(expected)) > 1


def test_a_pivot_of_0_or_no_number_counts_as_negative():
    depth = np.arange(3, dtype=np.int32)
    even, none = np.zeros((1, 3, 3)), np.zeros((1, 3, 3))
    even[0, :, 0] = 1.0, 0.0, np.nan
    found = np.zeros(1, dtype=np.int64)
    negative_pivots_side_by_side(even, none, depth, np.ones((2, 1, 1)), np.zeros(1), np.zeros((0, 3, 2, 1)), found)
    assert found[0] == 2
