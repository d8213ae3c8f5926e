"""A haul: the catch builds up from nothing to its final size through the computed equilibria, and fish arrive.

Fish arrive at a constant rate in time, and try to escape when they arrive, through the meshes as they are then. The
catch's volume grows as V = V_end (t / t_end)^g, so that a computed catch of volume V stands for the time
t / t_end = (V / V_end)^(1 / g). Between two computed catches retention is taken as linear in time; before the first
of them, it is that of the first: a share (V_1 / V_end)^(1 / g) of the haul rests on the smallest catch computed.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from catch_models.fish import PARAMETERS, Species
from codend.selectivity.escape.catches import Catch
from codend.selectivity.escape.retention import EscapeTerms, crowd_of, escape_terms, nodes_of
from codend.selectivity.escape.retention_kernels import Crowd, Nodes, retain_hauls, time_shares

Floats = NDArray[np.float64]
_GROWTH = PARAMETERS.index("haul.catch_growth")


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


def many_hauls(haul: Haul, values: Floats, nodes: Nodes, length_cm: Floats) -> tuple[Floats, Floats]:
    """L50 and SR over the haul in cm, (m, 2), and retention by length, (m, n), for many sets of values (m, 13).

    L50 and SR are nan where too few fish escape to have them. Shared out over the processor's cores.
    """
    parts = np.array_split(np.ascontiguousarray(values, dtype=float), os.cpu_count() or 1)
    found = [(np.empty((len(part), 2)), np.empty((len(part), len(length_cm)))) for part in parts]
    ln_length = np.log(0.01 * length_cm)

    def solve(part: Floats, result: tuple[Floats, Floats]) -> None:
        retain_hauls(haul.crowd, haul.volume_m3, part, nodes, ln_length, *result)

    with ThreadPoolExecutor(len(parts)) as pool:
        list(pool.map(solve, parts, found))
    l50_sr, retained = zip(*found, strict=True)
    return np.concatenate(l50_sr), np.concatenate(retained)
