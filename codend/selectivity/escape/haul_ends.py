"""Hauls that end with each computed catch, and what the error of the openings does to L50 and SR."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_models.fish import Species
from codend.selectivity.escape.haul import MOST_CATCHES, Haul, haul_of, terms_of_catches
from codend.selectivity.escape.haul_kernels import BIN, time_shares
from codend.selectivity.escape.meshes_met import Catch
from codend.selectivity.escape.retention import EscapeTerms, nodes_of

Floats = NDArray[np.float64]

BETWEEN_MERGED: Final = 2.0
"""With 1 SR was off by at most 1.05 times its error beside nets with every mesh, in 26 catches of diamond and T90 of
which 2 to 4 meshes were merged; with 2 by at most 0.7 times."""
UNKNOWN: Final = (np.nan, np.nan)
ROUGH: Final = nodes_of(shapes=3, rotations=8, steps=8)


def shares_of_ends(haul: Haul, species: Species) -> Floats:
    """Share of the time for which each catch stands in hauls that end with each of them, (c ends, c)."""
    time = haul.time(species)
    shares = np.zeros((len(time), len(time)))
    for end in range(len(time)):
        shares[end, : end + 1] = time_shares(time[: end + 1] / time[end])
    return shares


def l50_sr_of_ends(terms: Sequence[EscapeTerms], shares: Floats) -> Floats:
    """L50 and SR of hauls with the given shares of their catches' terms, off the computed curves, cm, (ends, 2)."""
    known = [one.ln_length for one in terms if one.ln_length.size]
    if not known:
        return np.full((len(shares), 2), np.nan)
    least, last = min(one.min() for one in known), max(one.max() for one in known)
    bins = int((last - least) / BIN) + 2
    gathered = np.zeros((len(terms), bins))
    for catch, one in enumerate(terms):
        at = (one.ln_length - least) / BIN
        left = at.astype(int)
        gathered[catch] += np.bincount(left, one.escape * (left + 1 - at), bins)
        gathered[catch] += np.bincount(left + 1, one.escape * (at - left), bins)
    place = least + BIN * np.arange(bins)
    found = []
    for escape in shares @ gathered:
        there = escape > 0.0
        found.append(EscapeTerms(place[there], escape[there], terms[0].spread).l50_sr() if there.any() else UNKNOWN)
    return np.array(found)


def moved_by_opening_error(haul: Haul, species: Species) -> Floats:
    """By how much L50 and SR change when all openings are off by their error, cm, (c + 1, 2): of catches and haul.

    The larger of the changes with all meshes wider and all narrower; nan where an error is not known or L50 is none.
    Where rows are merged, the openings of real rows between are not known: added is ``BETWEEN_MERGED`` of what L50 and
    SR change when all rows of a merged one are alike.
    """
    few = haul.thinned(MOST_CATCHES)
    error = np.array([catch.opening_error_deg for catch in few.catches])
    if not np.isfinite(error).all():
        return np.full((len(haul.catches) + 1, 2), np.nan)
    merged = any(catch.merged_alike is not None for catch in few.catches)
    if not error.any() and not merged:
        return np.zeros((len(haul.catches) + 1, 2))

    shares = np.vstack([np.eye(len(few.catches)), few.time_shares(species)])

    def all_of(catches: Iterable[Catch]) -> Floats:
        moved = haul_of(few.speed_m_s, list(catches))
        return l50_sr_of_ends(terms_of_catches(moved, species, ROUGH), shares)

    base = all_of(few.catches)
    wider, narrower = (
        all_of(_wider(catch, sign * by) for catch, by in zip(few.catches, error, strict=True)) for sign in (1.0, -1.0)
    )
    change = np.maximum(np.abs(wider - base), np.abs(narrower - base))
    if merged:
        alike = all_of(replace(catch, holes=catch.merged_alike or catch.holes) for catch in few.catches)
        change += BETWEEN_MERGED * np.abs(alike - base)
    each = [np.interp(haul.volume_m3, few.volume_m3, change[:-1, q]) for q in range(2)]
    return np.vstack([np.stack(each, axis=1), change[-1]])


def _wider(catch: Catch, by_deg: float) -> Catch:
    half = np.clip(catch.holes.half_angle_rad + 0.5 * np.radians(by_deg), 0.0, 0.5 * np.pi)
    return replace(catch, holes=replace(catch.holes, half_angle_rad=half))
