"""Pivots of harmonics side by side, against the eigenvalues of the same matrices written out."""

import numpy as np
import pytest

from codend.mechanics.harmonics import (
    band_times,
    factorise_band_of_numbers,
    negative_pivots_side_by_side,
    solve_band_of_numbers,
    write_rows,
)


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


@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize(("size", "half"), [(12, 0), (12, 3), (30, 5), (4, 3)])
def test_bands_multiply_and_solve_as_the_matrices_they_are(kind, size, half):
    rng = np.random.default_rng(size + half)
    i, j = np.indices((size, size))
    whole = rng.standard_normal((size, size)).astype(kind)
    whole += 1j * rng.standard_normal((size, size)) if kind is complex else 0.0
    whole[np.abs(i - j) > half] = 0.0
    whole += 4.0 * (half + 1) * np.eye(size)
    band = np.zeros((2 * half + 1, size), dtype=kind)
    inside = np.abs(i - j) <= half
    band[(half + i - j)[inside], j[inside]] = whole[inside]
    sides = rng.standard_normal((size, 2)).astype(kind)

    assert band_times(band, sides) == pytest.approx(whole @ sides, rel=1e-13, abs=1e-13)
    for hermitian, asked in ((False, whole), (True, 0.5 * (whole + whole.conj().T))):
        rows = np.zeros((size, 2 * half + 1), dtype=kind)
        write_rows(band, 0.7, hermitian, rows)
        factorise_band_of_numbers(rows)
        solved = sides[:, 0].copy()
        solve_band_of_numbers(rows, solved)
        assert solved == pytest.approx(np.linalg.solve(asked - 0.7 * np.eye(size), sides[:, 0]), rel=1e-12, abs=1e-13)
