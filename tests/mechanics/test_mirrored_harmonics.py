"""Pivots of real harmonics side by side, against the eigenvalues of the same matrices written out."""

import numpy as np
import pytest

from codend.mechanics.lanes import LANES
from codend.mechanics.mirrored_harmonics import mirrored_blocks, negative_pivots_of_real


@pytest.mark.parametrize("harmonics", [1, 16, 37])
def test_negative_pivots_are_as_many_as_negative_eigenvalues(harmonics):
    rng = np.random.default_rng(harmonics)
    start = np.repeat([0, 0, 0, 3, 3, 9, 9, 15], 3)  # each three rows begin where some before them do
    rows, behind, waves = len(start), 3, 4
    depth = (np.arange(rows) - start).astype(np.int32)
    with_entries, width = rows - behind, int(depth.max()) + 1
    row = np.repeat(np.arange(with_entries), depth[:with_entries] + 1)
    before = np.concatenate([np.arange(d + 1) for d in depth[:with_entries]])
    more = np.flatnonzero(rng.random(len(row)) < 0.4)  # entries of two terms
    entry, wave = np.append(np.arange(len(row)), more), rng.integers(0, waves, len(row) + len(more))
    value, wave_values = rng.standard_normal(len(entry)), rng.uniform(-1.0, 1.0, (harmonics, waves))
    begin = len(row) + np.searchsorted(row[more], np.arange(with_entries + 1))
    tail, kind = rng.standard_normal((3, behind, width)), rng.integers(0, 3, harmonics)
    tail[:, np.arange(width) > depth[with_entries:, None]] = 0.0
    shift, found = rng.uniform(-2.0, 6.0, harmonics), np.full(harmonics, -1)

    negative_pivots_of_real(
        value,
        (wave * LANES).astype(np.int32),
        begin.astype(np.int32),
        (before[more] * LANES).astype(np.int32),
        depth,
        wave_values,
        shift,
        tail,
        kind,
        found,
    )

    expected = []
    for k in range(harmonics):
        whole = np.zeros((rows, rows))
        np.add.at(whole, (row[entry], row[entry] - before[entry]), value * wave_values[k, wave])
        for i in range(behind):
            last = with_entries + i
            whole[last, last - np.arange(depth[last] + 1)] = tail[kind[k], i, : depth[last] + 1]
        values = np.linalg.eigvalsh(whole + shift[k] * np.eye(rows))  # of the lower triangle
        expected.append(np.count_nonzero(values < 0.0))
    assert found.tolist() == expected
    assert harmonics == 1 or len(set(expected)) > 1


def test_the_mean_of_a_block_and_its_image_is_mirrored_and_tells_how_far_they_are_apart():
    rng = np.random.default_rng(0)
    mirror, blocks = np.diag([1.0, 1.0, -1.0]), rng.standard_normal((2, 3, 3))
    angle = np.array([[0.3, -0.2], [-0.3, 0.2]])
    turn = np.stack([np.cos(angle), np.sin(angle)], axis=2).reshape(-1, 4)
    own, pair = np.arange(2), np.array([1, 0])
    turned, mean = np.empty((2, 2, 3, 3))

    def turned_by(x: float) -> np.ndarray:
        return np.array([[1.0, 0.0, 0.0], [0.0, np.cos(x), -np.sin(x)], [0.0, np.sin(x), np.cos(x)]])

    expected = [turned_by(-a) @ block @ turned_by(b) for (a, b), block in zip(angle, blocks, strict=True)]
    total, largest, off = mirrored_blocks(blocks, own, own, turn, pair, turned, mean)
    np.testing.assert_allclose(turned, expected, atol=1e-15)
    np.testing.assert_allclose(mean[0], 0.5 * (expected[0] + mirror @ expected[1] @ mirror), atol=1e-15)
    np.testing.assert_allclose(mean[1], mirror @ mean[0] @ mirror, atol=0.0)
    assert off == pytest.approx(np.abs(expected[0] - mirror @ expected[1] @ mirror).max())
    assert largest == pytest.approx(np.abs(expected[0]).max())
    assert total == pytest.approx(np.abs(expected).sum())

    blocks[1] = turned_by(-0.3) @ mirror @ expected[0] @ mirror @ turned_by(-0.2)
    assert mirrored_blocks(blocks, own, own, turn, pair, turned, mean)[2] < 1e-14
    blocks[0, 1, 1] = np.nan
    assert not np.isfinite(mirrored_blocks(blocks, own, own, turn, pair, turned, mean)[0])
