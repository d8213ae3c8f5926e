"""Kernels of the meshes ahead of catches: what of them is tried, and tables of what they let through.

Equations stand in ``retention``.
"""

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
    Turns,
    ideal_openings,
    longest_turned_by,
    sides_of,
)

Floats = NDArray[np.float64]

SHUT: Final = 0.1
OPEN: Final = 0.25
"""Clear width of a mesh over that of the widest which is tried, up to which it takes no attempts, and from which all
it would by its place: see ``retention``."""
_SHAPE, _ROTATION, _PUSH = (
    PARAMETERS.index(name) for name in ("spread.shape", "behaviour.rotation_deg", "behaviour.push_force_n")
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
    part: NDArray[np.int64]
    """Number of the part of the codend that a mesh lies in, (k,)."""


class Nodes(NamedTuple):
    """Quadrature over standard normal shapes and rotations, and steps of refinement."""

    shape: Floats
    shape_weight: Floats
    rotation: Floats
    rotation_weight: Floats
    steps: int
    openings: int
    """Intervals of half opening angles at whose ends lengths are tabled and read off in between; 0: all are exact."""


class Trying(NamedTuple):
    """Where fish try, besides the numbers of ``PARAMETERS``."""

    zone: NDArray[np.int64]
    """Zone of every part of the codend: 0 where fish try as the species' numbers say, 1 and so on for others, (p,)."""
    contact: Floats
    attempts: Floats
    """In each zone, (z + 1,); those of zone 0 are not read."""
    rows: Floats
    weight: Floats
    """Distribution of attempts over the distance from the front in zone 0; empty: even over ``rows_ahead``."""


@njit(cache=True, nogil=True)
def ideals_of(crowd: Crowd, values: Floats, nodes: Nodes, tables: Floats) -> Floats:
    """Ideal openings of every netting for every shape, (nettings, shapes, IDEALS); nan where no push needs them.

    Those of ``tables``, where lengths are tabled.
    """
    nettings = np.max(crowd.netting) + 1 if len(crowd.netting) else 0
    ideals = np.full((nettings, len(nodes.shape), IDEALS), np.nan)
    if values[_PUSH] > 0.0 and nodes.openings > 0:
        for netting in range(nettings):
            for node in range(len(nodes.shape)):
                _peaks(tables[netting, node], ideals[netting, node])
    elif values[_PUSH] > 0.0:
        sought = np.ones(len(ideals), dtype=np.bool_)
        for mesh in range(len(crowd.netting)):
            netting = crowd.netting[mesh]
            if sought[netting] and crowd.shape[mesh] != RECTANGLE:
                for node in range(len(nodes.shape)):
                    fish = fish_of(values, nodes.shape[node])
                    ideal_openings(hole_in(crowd, mesh), fish, math.nan, nodes.steps, ideals[netting, node])
            sought[netting] = False
    return ideals


@njit(cache=True, nogil=True)
def _peaks(table: Floats, ideals: Floats) -> None:
    """Write the half opening angles at which a table's first column is highest into ``ideals``."""
    count, width = 0, 0.5 * math.pi / (len(table) - 1)
    for k in range(1, len(table) - 1):
        if table[k - 1, 0] <= table[k, 0] > table[k + 1, 0] and count < len(ideals):
            ideals[count] = k * width
            count += 1


@njit(cache=True, nogil=True)
def hole_in(crowd: Crowd, mesh: int) -> Hole:
    """Mesh of a crowd as a hole."""
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
def fish_of(values: Floats, shape: float) -> Fish:
    """Section of a fish of length 1, mean size and a standard normal shape."""
    factor = math.exp(0.5 * values[_SHAPE] * shape)
    half_height, half_width = 0.5 * values[0] * (1.0 - values[3]), 0.5 * values[1] * (1.0 - values[4])
    return Fish(half_height * factor, half_width / factor, values[2])


@njit(cache=True, nogil=True)
def tables_of(crowd: Crowd, values: Floats, nodes: Nodes) -> Floats:
    """Longest fish by netting, shape and half opening angle, at the best rotation and those of the nodes, m.

    (nettings, shapes, openings + 1, rotations + 1); nothing where all lengths are exact.
    """
    nettings = np.max(crowd.netting) + 1 if nodes.openings and len(crowd.netting) else 0
    tables = np.zeros((nettings, len(nodes.shape), nodes.openings + 1, len(nodes.rotation) + 1))
    sought = np.ones(nettings, dtype=np.bool_)
    angle = math.radians(values[_ROTATION]) * nodes.rotation
    turns = Turns(angle, np.cos(2.0 * angle), np.sin(2.0 * angle))
    for mesh in range(len(crowd.netting) if nettings else 0):
        netting = crowd.netting[mesh]
        if not sought[netting] or crowd.shape[mesh] == RECTANGLE:
            continue
        sought[netting] = False
        hole = hole_in(crowd, mesh)
        for node in range(len(nodes.shape)):
            fish = fish_of(values, nodes.shape[node])
            for i in range(1, nodes.openings):
                phi = 0.5 * math.pi * i / nodes.openings
                longest_turned_by(hole, phi, fish, nodes.steps, turns, tables[netting, node, i])
    return tables


@njit(cache=True, nogil=True)
def tried_shares(crowd: Crowd, first: int, end: int, rows: float, trying: Trying) -> Floats:
    """Share that each mesh of a catch has of the attempts in its zone, (end - first,); see ``retention``."""
    tried, gap = np.empty(end - first), np.empty(end - first)
    zones = len(trying.contact)
    widest, total = np.zeros(zones), np.zeros(zones)
    for mesh in range(first, end):
        zone = trying.zone[crowd.part[mesh]]
        tried[mesh - first] = place_weight(crowd, mesh, rows, trying)
        sides = sides_of(hole_in(crowd, mesh), crowd.half_angle[mesh])
        gap[mesh - first] = min(sides[1], sides[3], sides[5])
        if tried[mesh - first] > 0.0:
            widest[zone] = max(widest[zone], gap[mesh - first])
    for mesh in range(first, end):
        i, zone = mesh - first, trying.zone[crowd.part[mesh]]
        if widest[zone] > 0.0:
            tried[i] *= min(max((gap[i] / widest[zone] - SHUT) / (OPEN - SHUT), 0.0), 1.0)
        total[zone] += tried[i]
    for mesh in range(first, end):
        zone = trying.zone[crowd.part[mesh]]
        tried[mesh - first] /= total[zone] if total[zone] > 0.0 else 1.0
    return tried


@njit(cache=True, nogil=True)
def place_weight(crowd: Crowd, mesh: int, rows: float, trying: Trying) -> float:
    """Weight of a mesh among those tried, were all open; it rises from nothing over the first row ahead of the front.

    In zone 0 it follows the distribution given, or is full over ``rows`` rows and falls to nothing over one more: as
    rows are one apart the weights add to the same whole wherever the front stands between two of them.
    """
    ahead = crowd.rows_ahead[mesh]
    weight = crowd.share[mesh] * min(max(ahead, 0.0), 1.0)
    if trying.zone[crowd.part[mesh]] > 0:
        return weight
    if len(trying.rows) == 0:
        return weight * min(max(rows + 1.0 - ahead, 0.0), 1.0)
    if ahead > trying.rows[-1]:
        return 0.0
    return weight * float(np.interp(ahead, trying.rows, trying.weight))
