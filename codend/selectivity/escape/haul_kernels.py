"""Kernels of retention over many hauls; equations stand in ``haul``."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_models.fish_parameters import PARAMETERS
from codend.compiled import njit
from codend.selectivity.escape.crowd_kernels import Crowd, Nodes, Trying, ideals_of, tables_of
from codend.selectivity.escape.retention_kernels import (
    Passages,
    add_terms,
    ln_length_at,
    passages_of,
    retained_at,
)

Floats = NDArray[np.float64]

BIN: Final = 0.004
"""Width, in ln L, of the bins in which terms of many hauls are gathered, each split between two to keep its mean."""
_LEAST_LN_M, _BINS = math.log(1e-3), int(math.log(1e4) / BIN)
_SIZE, _ROWS_AHEAD, _GROWTH = (
    PARAMETERS.index(name) for name in ("spread.size", "behaviour.rows_ahead", "haul.catch_growth")
)
OF_LENGTHS = np.array(
    [name.startswith("section.") or name in ("spread.shape", "behaviour.rotation_deg") for name in PARAMETERS]
)
"""Numbers on which the longest fish through a mesh of given opening depends."""
OF_PASSAGES = OF_LENGTHS | np.array([name.startswith("behaviour.push_") for name in PARAMETERS])
"""And those on which it depends what fish make of the opening."""
OF_TERMS = OF_PASSAGES | np.array(
    [name in ("behaviour.contact", "behaviour.attempts", "behaviour.rows_ahead") for name in PARAMETERS]
)
"""And those on which it depends which meshes are tried, and how often."""


def alike_together(values: Floats) -> NDArray[np.int64]:
    """Order of sets of values (m, 15) in which those that share tables, passages and terms follow each other, (m,)."""
    keys = [values[:, which].T for which in (OF_TERMS & ~OF_PASSAGES, OF_PASSAGES & ~OF_LENGTHS, OF_LENGTHS)]
    return np.lexsort(np.concatenate(keys))


@njit(cache=True, nogil=True)
def _same(values: Floats, m: int, which: NDArray[np.bool_]) -> bool:
    """Whether a set of values is as the one before it in some of its numbers."""
    return m > 0 and not np.any((values[m] != values[m - 1]) & which)


@njit(cache=True, nogil=True)
def time_shares(time: Floats) -> Floats:
    """Share of the haul for which each catch stands, (c,), adding to 1: trapezoidal rule, constant before the first."""
    share = np.zeros(len(time))
    share[0] = time[0]
    for i in range(1, len(time)):
        half = 0.5 * (time[i] - time[i - 1])
        share[i - 1] += half
        share[i] += half
    return share


@njit(cache=True, nogil=True)
def retain_hauls(
    crowd: Crowd,
    volume: Floats,
    values: Floats,
    nodes: Nodes,
    trying: Trying,
    ln_lengths: Floats,
    l50_sr: Floats,
    retained: Floats,
) -> None:
    """Write L50 and SR, (m, 2), and the retention at every length, (m, n), for many sets of values (m, 15)."""
    most = 0
    for catch in range(len(volume)):
        most = max(most, crowd.start[catch + 1] - crowd.start[catch])
    most, catches, shapes = most * len(nodes.rotation), len(volume), len(nodes.shape)
    ln_g, escape = np.empty((catches, shapes * most)), np.empty((catches, shapes * most))
    ln_length = np.empty((catches, shapes, most))
    mesh, rotation = np.empty((2, catches, shapes, most), dtype=np.int64)
    ways, terms = np.zeros(catches, dtype=np.int64), np.zeros(catches, dtype=np.int64)
    place, mass = np.empty(_BINS + 1), np.empty(_BINS + 1)
    tables = np.zeros((0, 0, 0, 0))
    for m in range(len(values)):
        share = time_shares((volume / volume[-1]) ** (1.0 / values[m, _GROWTH]))
        if not _same(values, m, OF_LENGTHS):
            tables = tables_of(crowd, values[m], nodes)
        if not _same(values, m, OF_PASSAGES):
            ideals, rows = ideals_of(crowd, values[m], nodes, tables), values[m, _ROWS_AHEAD]
            for other in range(m + 1, len(values)):
                if not _same(values, other, OF_PASSAGES):
                    break
                rows = max(rows, values[other, _ROWS_AHEAD])
            for catch in range(catches):
                passages = Passages(ln_length[catch], mesh[catch], rotation[catch])
                ways[catch] = passages_of(crowd, catch, values[m], nodes, rows, trying, ideals, tables, passages)
        if not _same(values, m, OF_TERMS):
            for catch in range(catches):
                passages = Passages(ln_length[catch], mesh[catch], rotation[catch])
                terms[catch] = add_terms(
                    crowd, catch, values[m], nodes, trying, passages, ways[catch], ln_g[catch], escape[catch]
                )
        gathered = np.zeros(_BINS + 1)
        for catch in range(catches):
            for k in range(terms[catch]):
                bins = min(max((ln_g[catch, k] - _LEAST_LN_M) / BIN, 0.0), _BINS - 1e-6)
                left = int(bins)
                weight = share[catch] * escape[catch, k]
                gathered[left] += weight * (left + 1 - bins)
                gathered[left + 1] += weight * (bins - left)
        count = 0
        for k in range(_BINS + 1):
            if gathered[k] > 0.0:
                place[count], mass[count] = _LEAST_LN_M + BIN * k, gathered[k]
                count += 1
        spread = values[m, _SIZE]
        l25 = ln_length_at(place[:count], mass[:count], spread, 0.25)
        l50 = ln_length_at(place[:count], mass[:count], spread, 0.50)
        l75 = ln_length_at(place[:count], mass[:count], spread, 0.75)
        l50_sr[m, 0], l50_sr[m, 1] = 100.0 * math.exp(l50), 100.0 * (math.exp(l75) - math.exp(l25))
        retained_at(place[:count], mass[:count], spread, ln_lengths, retained[m])
