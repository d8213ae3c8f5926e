"""Kernels of retention over many hauls; equations stand in ``haul``."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_models.fish_parameters import PARAMETERS
from codend.compiled import njit
from codend.selectivity.escape.retention_kernels import (
    Crowd,
    Nodes,
    Trying,
    add_terms,
    ideals_of,
    ln_length_at,
    retained_at,
    tables_of,
)

Floats = NDArray[np.float64]

BIN: Final = 0.004
"""Width, in ln L, of the bins in which terms of many hauls are gathered, each split between two to keep its mean."""
_LEAST_LN_M, _BINS = math.log(1e-3), int(math.log(1e4) / BIN)
_SIZE, _GROWTH = PARAMETERS.index("spread.size"), PARAMETERS.index("haul.catch_growth")
OF_LENGTHS = np.array(
    [name.startswith("section.") or name in ("spread.shape", "behaviour.rotation_deg") for name in PARAMETERS]
)
"""Numbers on which the longest fish through a mesh of given opening depends."""


@njit(cache=True, nogil=True)
def _same_lengths(one: Floats, other: Floats) -> bool:
    return not np.any((one != other) & OF_LENGTHS)


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
    most *= len(nodes.shape) * len(nodes.rotation)
    ln_g, escape = np.empty(most), np.empty(most)
    place, mass = np.empty(_BINS + 1), np.empty(_BINS + 1)
    tables = np.zeros((0, 0, 0, 0))
    for m in range(len(values)):
        share = time_shares((volume / volume[-1]) ** (1.0 / values[m, _GROWTH]))
        if m == 0 or not _same_lengths(values[m], values[m - 1]):
            tables = tables_of(crowd, values[m], nodes)
        ideals = ideals_of(crowd, values[m], nodes, tables)
        gathered = np.zeros(_BINS + 1)
        for catch in range(len(volume)):
            for k in range(add_terms(crowd, catch, values[m], nodes, trying, ideals, tables, ln_g, escape)):
                bins = min(max((ln_g[k] - _LEAST_LN_M) / BIN, 0.0), _BINS - 1e-6)
                left = int(bins)
                weight = share[catch] * escape[k]
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
