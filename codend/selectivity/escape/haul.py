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
from codend.selectivity.escape.crowd_kernels import Crowd, Nodes, Trying
from codend.selectivity.escape.haul_kernels import alike_together, retain_hauls, time_shares
from codend.selectivity.escape.meshes_met import Catch, Part
from codend.selectivity.escape.retention import EscapeTerms, crowd_of, escape_terms, everywhere_alike, nodes_of

Floats = NDArray[np.float64]
MOST_CATCHES = 6
"""Of a haul that is computed many times over."""
_GROWTH = PARAMETERS.index("haul.catch_growth")


@dataclass(frozen=True)
class Haul:
    """Catches at one speed, in the order of their volume, and their meshes."""

    speed_m_s: float
    catches: tuple[Catch, ...]
    crowd: Crowd
    parts: tuple[Part, ...] = (Part("", ""),)
    """Parts of the codend that the crowd's meshes lie in, by number."""

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
        return haul_of(self.speed_m_s, [self.catches[i] for i in kept])


def hauls_of(catches: list[Catch]) -> list[Haul]:
    """One haul for every speed."""
    speeds = sorted({catch.speed_m_s for catch in catches})
    return [haul_of(speed, [catch for catch in catches if catch.speed_m_s == speed]) for speed in speeds]


def haul_of(speed_m_s: float, catches: list[Catch]) -> Haul:
    """A haul through the given catches."""
    ordered = sorted(catches, key=lambda catch: catch.volume_m3)
    names = [name for c in ordered for name in c.parts or len(c.share) * (Part("", ""),)]
    parts = tuple(dict.fromkeys(names)) or (Part("", ""),)
    part = np.array([parts.index(name) for name in names], dtype=np.int64)
    return Haul(speed_m_s, tuple(ordered), crowd_of([(c.holes, c.rows_ahead, c.share) for c in ordered], part), parts)


def trying_of(haul: Haul, species: Species) -> Trying:
    """Where fish of the species try: the zones it gives for parts of the codend, and its distribution of attempts.

    A part is of the first zone that names its section, and its panel if the zone names one.
    """
    zone = np.zeros(len(haul.parts), dtype=np.int64)
    for number, part in enumerate(haul.parts):
        fits = [z for z, one in enumerate(species.zone, start=1) if one.holds(part.section, part.panel)]
        zone[number] = fits[0] if fits else 0
    contact, attempts = np.zeros((2, len(species.zone) + 1))
    contact[1:] = [one.contact.value for one in species.zone]
    attempts[1:] = [one.attempts.value for one in species.zone]
    along = species.along
    rows, weight = (np.array(along.rows_ahead), np.array(along.weight)) if along else (np.empty(0), np.empty(0))
    return Trying(zone, contact, attempts, rows, weight)


def terms_of_catches(haul: Haul, species: Species, nodes: Nodes | None = None) -> list[EscapeTerms]:
    """Retention of fish that meet each of the catches."""
    nodes, trying = nodes or nodes_of(), trying_of(haul, species)
    return escape_terms(haul.crowd, species.values, nodes, trying)


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


def many_hauls(
    haul: Haul, values: Floats, nodes: Nodes, length_cm: Floats, trying: Trying | None = None
) -> tuple[Floats, Floats]:
    """L50 and SR over the haul in cm, (m, 2), and retention by length, (m, n), for many sets of values (m, 15).

    L50 and SR are nan where too few fish escape to have them. Shared out over the processor's cores.
    """
    values = np.ascontiguousarray(values, dtype=float)
    order = alike_together(values)
    parts = np.array_split(values[order], os.cpu_count() or 1)
    found = [(np.empty((len(part), 2)), np.empty((len(part), len(length_cm)))) for part in parts]
    ln_length = np.log(0.01 * length_cm)
    tried = trying or everywhere_alike(int(haul.crowd.part.max(initial=0)) + 1)

    def solve(part: Floats, result: tuple[Floats, Floats]) -> None:
        retain_hauls(haul.crowd, haul.volume_m3, part, nodes, tried, ln_length, *result)

    with ThreadPoolExecutor(len(parts)) as pool:
        list(pool.map(solve, parts, found))
    l50_sr, retained = (np.concatenate(each)[np.argsort(order)] for each in zip(*found, strict=True))
    return l50_sr, retained
