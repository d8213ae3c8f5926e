"""A haul: the catch builds up from nothing to its final size through the computed equilibria, and fish arrive.

Fish arrive at a constant rate in time, and try to escape when they arrive, through the meshes as they are then. The
catch's volume grows as V = V_end (t / t_end)^g, so that a computed catch of volume V stands for the time
t / t_end = (V / V_end)^(1 / g). Between two computed catches retention is taken as linear in time; before the first
of them, it is that of the first: a share (V_1 / V_end)^(1 / g) of the haul rests on the smallest catch computed.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_models.fish import PARAMETERS, Species
from codend.compiled import njit
from codend.selectivity.escape.catches import Catch
from codend.selectivity.escape.retention import (
    Crowd,
    EscapeTerms,
    Nodes,
    add_terms,
    crowd_of,
    escape_terms,
    ideals_of,
    ln_length_at,
    nodes_of,
    retained_at,
)

Floats = NDArray[np.float64]
_GROWTH, _SIZE = PARAMETERS.index("haul.catch_growth"), PARAMETERS.index("spread.size")
BIN: Final = 0.004
"""Width, in ln L, of the bins in which terms of many hauls are gathered, each split between two to keep its mean."""
_LEAST_LN_M, _BINS = math.log(1e-3), int(math.log(1e4) / BIN)


@dataclass(frozen=True)
class Haul:
    """Catches at one speed, in the order of their volume, and their meshes."""

    speed_m_s: float
    catches: tuple[Catch, ...]
    crowd: Crowd

    @property
    def volume_m3(self) -> Floats:
        """Volumes of the catches, (c,)."""
        return np.array([catch.volume_m3 for catch in self.catches])

    def time(self, species: Species) -> Floats:
        """Share of the haul's time after which each catch is reached, (c,)."""
        return np.asarray((self.volume_m3 / self.volume_m3[-1]) ** (1.0 / species.values[_GROWTH]))

    def time_shares(self, species: Species) -> Floats:
        """Share of the haul's time for which each catch stands, (c,), adding to 1."""
        return time_shares(self.time(species))

    def thinned(self, most: int) -> Haul:
        """The same haul through at most so many of its catches, evenly spread, the first and the last among them."""
        if len(self.catches) <= most:
            return self
        kept = np.round(np.linspace(0, len(self.catches) - 1, most)).astype(int)
        return _haul(self.speed_m_s, [self.catches[i] for i in kept])


def hauls_of(catches: list[Catch]) -> list[Haul]:
    """One haul for every speed."""
    speeds = sorted({catch.speed_m_s for catch in catches})
    return [_haul(speed, [catch for catch in catches if catch.speed_m_s == speed]) for speed in speeds]


def _haul(speed_m_s: float, catches: list[Catch]) -> Haul:
    ordered = sorted(catches, key=lambda catch: catch.volume_m3)
    return Haul(speed_m_s, tuple(ordered), crowd_of([(c.holes, c.rows_ahead, c.share) for c in ordered]))


def terms_of_catches(haul: Haul, species: Species, nodes: Nodes | None = None) -> list[EscapeTerms]:
    """Retention of fish that meet each of the catches."""
    nodes = nodes or nodes_of()
    return [escape_terms(haul.crowd, i, species.values, nodes) for i in range(len(haul.catches))]


def terms_of_haul(
    haul: Haul, of_catches: Sequence[EscapeTerms], species: Species, share: Floats | None = None
) -> EscapeTerms:
    """Retention over the whole haul: the mean over time of that of its catches, or with shares (c,) of their own."""
    share = haul.time_shares(species) if share is None else share
    return EscapeTerms(
        np.concatenate([terms.ln_length for terms in of_catches]),
        np.concatenate([weight * terms.escape for weight, terms in zip(share, of_catches, strict=True)]),
        of_catches[0].spread,
    )


def shares_until(haul: Haul, species: Species, volume_m3: float) -> Floats:
    """Share of the time for which each catch stands in a haul that ends with another volume, (c,), adding to 1.

    Retention is linear in time between computed catches, and beyond the last that of the last.
    """
    power = 1.0 / species.values[_GROWTH]
    time, end = haul.volume_m3**power, volume_m3**power
    knots = np.concatenate([[0.0], time[time < end], [end]])
    hats = np.array([np.interp(knots, time, hat) for hat in np.eye(len(time))])
    return np.asarray(np.trapezoid(hats, knots, axis=1) / end)


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


def many_hauls(haul: Haul, values: Floats, nodes: Nodes, length_cm: Floats) -> tuple[Floats, Floats]:
    """L50 and SR over the haul in cm, (m, 2), and retention by length, (m, n), for many sets of values (m, 13).

    L50 and SR are nan where too few fish escape to have them. Shared out over the processor's cores.
    """
    parts = np.array_split(np.ascontiguousarray(values, dtype=float), os.cpu_count() or 1)
    found = [(np.empty((len(part), 2)), np.empty((len(part), len(length_cm)))) for part in parts]
    ln_length = np.log(0.01 * length_cm)

    def solve(part: Floats, result: tuple[Floats, Floats]) -> None:
        _many_hauls(haul.crowd, haul.volume_m3, part, nodes, ln_length, *result)

    with ThreadPoolExecutor(len(parts)) as pool:
        list(pool.map(solve, parts, found))
    l50_sr, retained = zip(*found, strict=True)
    return np.concatenate(l50_sr), np.concatenate(retained)


@njit(cache=True, nogil=True)
def _many_hauls(
    crowd: Crowd,
    volume: Floats,
    values: Floats,
    nodes: Nodes,
    ln_lengths: Floats,
    l50_sr: Floats,
    retained: Floats,
) -> None:
    most = 0
    for catch in range(len(volume)):
        most = max(most, crowd.start[catch + 1] - crowd.start[catch])
    most *= len(nodes.shape) * len(nodes.rotation)
    ln_g, escape = np.empty(most), np.empty(most)
    place, mass = np.empty(_BINS + 1), np.empty(_BINS + 1)
    for m in range(len(values)):
        share = time_shares((volume / volume[-1]) ** (1.0 / values[m, _GROWTH]))
        ideals = ideals_of(crowd, values[m], nodes)
        gathered = np.zeros(_BINS + 1)
        for catch in range(len(volume)):
            for k in range(add_terms(crowd, catch, values[m], nodes, ideals, ln_g, escape)):
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
