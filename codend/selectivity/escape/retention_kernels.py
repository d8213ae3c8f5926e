"""Kernels of retention by length, of fish that meet a catch; equations stand in ``retention``."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_models.fish_parameters import PARAMETERS
from codend.compiled import njit
from codend.selectivity.escape.crowd_kernels import (
    Crowd,
    Nodes,
    Trying,
    fish_of,
    hole_in,
    place_weight,
    tried_shares,
)
from codend.selectivity.escape.passage_kernels import RECTANGLE, best_rotation, longest_turned
from codend.selectivity.escape.yielding_kernels import Effort, Passing, best_opening

Floats = NDArray[np.float64]

MOST_STEPS, PRECISION = 100, 1e-12
"""Of the search for the logarithm of a length."""
_SHORTEST_LN_M = math.log(1e-6)
(_CONTACT, _ATTEMPTS, _ROWS_AHEAD, _ROTATION, _PUSH, _EXPONENT, _AT) = (
    PARAMETERS.index(name)
    for name in (
        "behaviour.contact",
        "behaviour.attempts",
        "behaviour.rows_ahead",
        "behaviour.rotation_deg",
        "behaviour.push_force_n",
        "behaviour.push_exponent",
        "behaviour.push_length_cm",
    )
)


class Passages(NamedTuple):
    """What the meshes of one catch let through, by shape, the longest first, (shapes, n) each."""

    ln_length: Floats
    """Logarithm of the longest fish, in metres."""
    mesh: NDArray[np.int64]
    """Mesh of the catch, from its first."""
    rotation: NDArray[np.int64]
    """Node of the rotation."""


@njit(cache=True, nogil=True)
def _effort(values: Floats, nodes: Nodes) -> Effort:
    return Effort(values[_PUSH], values[_EXPONENT], 0.01 * values[_AT], nodes.steps)


@njit(cache=True, nogil=True)
def passages_of(
    crowd: Crowd,
    catch: int,
    values: Floats,
    nodes: Nodes,
    rows: float,
    trying: Trying,
    ideals: Floats,
    tables: Floats,
    passages: Passages,
) -> int:
    """Write what the meshes of a catch let through where fish try ``rows`` rows or fewer; how many each shape has.

    ``ideals`` are those of ``ideals_of`` and ``tables`` those of ``tables_of``.
    """
    rotations, effort = len(nodes.rotation), _effort(values, nodes)
    first, end = crowd.start[catch], crowd.start[catch + 1]
    ln_g, no_table = np.empty((end - first) * rotations), np.zeros((0, 0))
    mesh_of, rotation_of = np.empty((2, len(ln_g)), dtype=np.int64)
    count = 0
    for node in range(len(nodes.shape)):
        fish = fish_of(values, nodes.shape[node])
        count = 0
        for mesh in range(first, end):
            if place_weight(crowd, mesh, rows, trying) == 0.0:
                continue
            hole, netting = hole_in(crowd, mesh), crowd.netting[mesh]
            tabled = nodes.openings > 0 and hole.shape != RECTANGLE
            passing = Passing(fish, math.nan, tables[netting, node] if tabled else no_table)
            phi = best_opening(hole, crowd.half_angle[mesh], passing, effort, ideals[netting, node])
            left, share, best = 0, 0.0, 0.0
            if tabled:
                at = phi / (0.5 * math.pi) * nodes.openings
                left = min(int(at), nodes.openings - 1)
                share = at - left
            else:
                best = best_rotation(hole, phi, fish, nodes.steps)
            for k in range(rotations):
                if tabled:
                    ends = tables[netting, node, left, k + 1], tables[netting, node, left + 1, k + 1]
                    length = (1.0 - share) * ends[0] + share * ends[1]
                else:
                    turned = best + math.radians(values[_ROTATION]) * nodes.rotation[k]
                    length = longest_turned(hole, phi, fish, turned)
                ln_g[count] = -math.log(length) if length > 0.0 else -_SHORTEST_LN_M
                mesh_of[count], rotation_of[count] = mesh - first, k
                count += 1
        order = np.argsort(ln_g[:count])
        for k in range(count):
            passages.ln_length[node, k] = -ln_g[order[k]]
            passages.mesh[node, k], passages.rotation[node, k] = mesh_of[order[k]], rotation_of[order[k]]
    return count


@njit(cache=True, nogil=True)
def add_terms(
    crowd: Crowd,
    catch: int,
    values: Floats,
    nodes: Nodes,
    trying: Trying,
    passages: Passages,
    count: int,
    ln_length: Floats,
    escape: Floats,
) -> int:
    """Write the terms of one catch into ``ln_length`` and ``escape``; how many there are.

    ``passages`` are of at least the rows that fish try, ``count`` of each shape, as ``passages_of`` has them.
    """
    first, end = crowd.start[catch], crowd.start[catch + 1]
    tried = tried_shares(crowd, first, end, values[_ROWS_AHEAD], trying)
    contact, attempts = trying.contact.copy(), trying.attempts.copy()
    contact[0], attempts[0] = values[_CONTACT], values[_ATTEMPTS]
    probability, kept = np.empty(len(contact)), np.empty(len(contact))
    written = 0
    for node in range(len(nodes.shape)):
        probability[:], kept[:], escaped = 0.0, 1.0, 0.0
        for k in range(count):
            mesh = passages.mesh[node, k]
            if tried[mesh] == 0.0:
                continue
            z = trying.zone[crowd.part[first + mesh]]
            probability[z] = min(probability[z] + tried[mesh] * nodes.rotation_weight[passages.rotation[node, k]], 1.0)
            kept[z] = 1.0 - contact[z] * (1.0 - (1.0 - probability[z]) ** attempts[z])
            risen = 1.0 - float(np.prod(kept))
            ln_length[written] = passages.ln_length[node, k]
            escape[written] = nodes.shape_weight[node] * (risen - escaped)
            escaped = risen
            written += 1
    return written


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
