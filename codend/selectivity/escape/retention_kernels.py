"""Kernels of retention by length, of a catch and of many hauls; equations stand in ``retention`` and ``haul``."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_models.fish_parameters import PARAMETERS
from codend.compiled import njit
from codend.selectivity.escape.passage_kernels import (
    IDEALS,
    RECTANGLE,
    Fish,
    Hole,
    best_rotation,
    ideal_openings,
    longest_turned,
)
from codend.selectivity.escape.yielding_kernels import Effort, best_opening

Floats = NDArray[np.float64]

MOST_STEPS, PRECISION = 100, 1e-12
"""Of the search for the logarithm of a length."""
BIN: Final = 0.004
"""Width, in ln L, of the bins in which terms of many hauls are gathered, each split between two to keep its mean."""
_LEAST_LN_M, _BINS = math.log(1e-3), int(math.log(1e4) / BIN)
_SHORTEST_LN_M = math.log(1e-6)
(_SIZE, _SHAPE, _CONTACT, _ATTEMPTS, _ROWS_AHEAD, _ROTATION, _PUSH, _EXPONENT, _AT, _GROWTH) = (
    PARAMETERS.index(name)
    for name in (
        "spread.size",
        "spread.shape",
        "behaviour.contact",
        "behaviour.attempts",
        "behaviour.rows_ahead",
        "behaviour.rotation_deg",
        "behaviour.push_force_n",
        "behaviour.push_exponent",
        "behaviour.push_length_cm",
        "haul.catch_growth",
    )
)


class Crowd(NamedTuple):
    """Meshes of several catches in one row of arrays, as the kernels read them."""

    start: NDArray[np.int64]
    """First mesh of each catch, and the end of the last, (c + 1,)."""
    shape: NDArray[np.int64]
    bar: Floats
    knot: Floats
    half_angle: Floats
    across: Floats
    load: Floats
    bending: Floats
    rest: Floats
    held_across: Floats
    held_along: Floats
    """As in ``Holes``, (k,)."""
    rows_ahead: Floats
    """Distance of each mesh from the front, in rows of meshes, (k,)."""
    share: Floats
    """Share of each mesh in its row, (k,)."""
    netting: NDArray[np.int64]
    """Number of the netting a mesh is of, the same for all with its shape, bar and knot, (k,)."""


class Nodes(NamedTuple):
    """Quadrature over standard normal shapes and rotations, and steps of refinement."""

    shape: Floats
    shape_weight: Floats
    rotation: Floats
    rotation_weight: Floats
    steps: int


@njit(cache=True, nogil=True)
def ideals_of(crowd: Crowd, values: Floats, nodes: Nodes) -> Floats:
    """Ideal openings of every netting for every shape, (nettings, shapes, IDEALS); nan where no push needs them."""
    ideals = np.full((np.max(crowd.netting) + 1 if len(crowd.netting) else 0, len(nodes.shape), IDEALS), np.nan)
    if values[_PUSH] > 0.0:
        sought = np.ones(len(ideals), dtype=np.bool_)
        for mesh in range(len(crowd.netting)):
            netting = crowd.netting[mesh]
            if sought[netting] and crowd.shape[mesh] != RECTANGLE:
                for node in range(len(nodes.shape)):
                    fish = _fish(values, nodes.shape[node])
                    ideal_openings(_hole(crowd, mesh), fish, math.nan, nodes.steps, ideals[netting, node])
            sought[netting] = False
    return ideals


@njit(cache=True, nogil=True)
def _hole(crowd: Crowd, mesh: int) -> Hole:
    return Hole(
        crowd.shape[mesh],
        crowd.bar[mesh],
        crowd.knot[mesh],
        crowd.across[mesh],
        crowd.load[mesh],
        crowd.bending[mesh],
        crowd.rest[mesh],
        crowd.held_across[mesh],
        crowd.held_along[mesh],
    )


@njit(cache=True, nogil=True)
def _effort(values: Floats, nodes: Nodes) -> Effort:
    return Effort(values[_PUSH], values[_EXPONENT], 0.01 * values[_AT], nodes.steps)


@njit(cache=True, nogil=True)
def _fish(values: Floats, shape: float) -> Fish:
    """Section of a fish of length 1, mean size and a standard normal shape."""
    factor = math.exp(0.5 * values[_SHAPE] * shape)
    half_height, half_width = 0.5 * values[0] * (1.0 - values[3]), 0.5 * values[1] * (1.0 - values[4])
    return Fish(half_height * factor, half_width / factor, values[2])


@njit(cache=True, nogil=True)
def add_terms(
    crowd: Crowd, catch: int, values: Floats, nodes: Nodes, ideals: Floats, ln_length: Floats, escape: Floats
) -> int:
    """Write the terms of one catch into ``ln_length`` and ``escape``; how many there are.

    ``ideals`` are those of ``ideals_of``.
    """
    contact, attempts, rows = values[_CONTACT], values[_ATTEMPTS], values[_ROWS_AHEAD]
    rotations = len(nodes.rotation)
    first, end = crowd.start[catch], crowd.start[catch + 1]
    weight = np.zeros((end - first) * rotations)
    ln_g = np.empty(len(weight))
    total = 0.0
    for mesh in range(first, end):
        total += _tried(crowd, mesh, rows)
    if total == 0.0:
        return 0
    written = 0
    for node in range(len(nodes.shape)):
        fish = _fish(values, nodes.shape[node])
        count = 0
        for mesh in range(first, end):
            tried = _tried(crowd, mesh, rows)
            if tried == 0.0:
                continue
            hole, effort = _hole(crowd, mesh), _effort(values, nodes)
            phi = best_opening(hole, crowd.half_angle[mesh], fish, math.nan, effort, ideals[crowd.netting[mesh], node])
            best = best_rotation(hole, phi, fish, nodes.steps)
            for k in range(rotations):
                turned = best + math.radians(values[_ROTATION]) * nodes.rotation[k]
                length = longest_turned(hole, phi, fish, turned)
                ln_g[count] = math.log(length) if length > 0.0 else _SHORTEST_LN_M
                weight[count] = tried / total * nodes.rotation_weight[k]
                count += 1
        order = np.argsort(-ln_g[:count])
        probability, escaped = 0.0, 0.0
        for k in order:
            probability = min(probability + weight[k], 1.0)
            risen = 1.0 - (1.0 - probability) ** attempts
            ln_length[written] = ln_g[k]
            escape[written] = contact * nodes.shape_weight[node] * (risen - escaped)
            escaped = risen
            written += 1
    return written


@njit(cache=True, nogil=True)
def _tried(crowd: Crowd, mesh: int, rows: float) -> float:
    """Weight of a mesh among those tried: full over ``rows`` rows, falling to nothing over one row at either end.

    As rows are one apart the weights add to the same whole wherever the front stands between two of them.
    """
    ahead = crowd.rows_ahead[mesh]
    return crowd.share[mesh] * min(max(ahead, 0.0), 1.0) * min(max(rows + 1.0 - ahead, 0.0), 1.0)


@njit(cache=True, nogil=True)
def retained_at(ln_g: Floats, escape: Floats, spread: float, ln_length: Floats, retained: Floats) -> None:
    """Write the retention at every length; arguments as the fields of ``EscapeTerms``."""
    for i in range(len(ln_length)):
        retained[i] = 1.0 - _escaped(ln_g, escape, spread, ln_length[i])[0]


@njit(cache=True, nogil=True)
def _escaped(ln_g: Floats, escape: Floats, spread: float, ln_length: float) -> tuple[float, float]:
    """Escape at a length, and how fast it falls with ln L."""
    escaped, fall = 0.0, 0.0
    for k in range(len(ln_g)):
        if spread > 0.0:
            z = (ln_g[k] - ln_length) / spread
            if z > 9.0:
                escaped += escape[k]
            elif z > -9.0:
                escaped += escape[k] * 0.5 * math.erfc(-z * math.sqrt(0.5))
                fall += escape[k] * math.exp(-0.5 * z * z)
        elif ln_g[k] >= ln_length:
            escaped += escape[k]
    return escaped, fall / (math.sqrt(2.0 * math.pi) * spread) if spread > 0.0 else 0.0


@njit(cache=True, nogil=True)
def ln_length_at(ln_g: Floats, escape: Floats, spread: float, retention: float) -> float:
    """Logarithm of the length, in metres, retained with the given probability: Newton steps kept in a bracket."""
    if 1.0 - np.sum(escape) >= retention:
        return math.nan
    low, high = np.min(ln_g) - 9.0 * spread - 1e-6, np.max(ln_g) + 9.0 * spread + 1e-6
    tried = 0.5 * (low + high)
    for _ in range(MOST_STEPS):
        escaped, fall = _escaped(ln_g, escape, spread, tried)
        missing = retention - (1.0 - escaped)
        if missing > 0.0:
            low = tried
        else:
            high = tried
        step = missing / fall if fall > 0.0 else math.inf
        if abs(step) < PRECISION or high - low < PRECISION:
            break
        tried = tried + step if low < tried + step < high else 0.5 * (low + high)
    return tried


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
