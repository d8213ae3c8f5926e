"""Retention by length of fish that meet the meshes ahead of a catch.

A fish of the species tries meshes with probability C (contact), then n times (attempts), every time a mesh drawn from
those ahead of the front and a rotation drawn about its best one. Fish of one length differ in size, a factor e^(s z) on
the whole section, and in shape, e^(t y / 2) on the height and e^(-t y / 2) on the width, with z, y standard normal.

For a fish of mean size and shape y, mesh and rotation k lets lengths up to G_k through. A fish of length L and size z
is let through by k when L e^(s z) <= G_k; with p the probability of all such k it escapes with probability
E = 1 - (1 - p)^n. With the G_k in falling order p, and with it E, rises in steps dE_k at L e^(s z) = G_k, so that the
mean over sizes is a sum of normal distribution functions and no quadrature at all:

    r(L) = 1 - C sum over y and k of w_y dE_k Phi((ln G_k - ln L) / s).

Over shapes and rotations the mean is taken by quadrature. A haul is the mean of such sums.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from catch_models.fish import PARAMETERS
from codend.compiled import njit
from codend.selectivity.escape.passage import (
    IDEALS,
    RECTANGLE,
    Effort,
    Fish,
    Hole,
    best_opening,
    best_rotation,
    ideal_openings,
    longest_turned,
)
from codend.selectivity.escape.penetration import Holes

Floats = NDArray[np.float64]

SHAPES, ROTATIONS, STEPS = 5, 12, 14
"""Nodes of the quadratures over shapes and rotations, and steps of refinement of orientation and opening."""
MOST_STEPS, PRECISION = 100, 1e-12
"""Of the search for the logarithm of a length."""
_SHORTEST_LN_M = math.log(1e-6)
(_SIZE, _SHAPE, _CONTACT, _ATTEMPTS, _ROWS_AHEAD, _ROTATION, _PUSH) = (
    PARAMETERS.index(name)
    for name in (
        "spread.size",
        "spread.shape",
        "behaviour.contact",
        "behaviour.attempts",
        "behaviour.rows_ahead",
        "behaviour.rotation_deg",
        "behaviour.push_force_n",
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


@dataclass(frozen=True)
class EscapeTerms:
    """Escape as a sum of normal distribution functions of ln L: the terms of the formula above."""

    ln_length: Floats
    """ln G of every term, G in metres, (j,)."""
    escape: Floats
    """C w dE of every term, (j,); they add to the escape of the smallest fish."""
    spread: float
    """Standard deviation s."""

    def retention(self, length_cm: ArrayLike) -> Floats:
        """Retention at lengths in cm, any shape."""
        length = np.asarray(length_cm, dtype=float)
        retained = np.empty(length.size)
        retained_at(self.ln_length, self.escape, self.spread, np.log(0.01 * length.ravel()), retained)
        return retained.reshape(length.shape)

    def length_cm_at(self, retention: float) -> float:
        """Length retained with the given probability, cm; nan where even the smallest fish are retained more often."""
        return 100.0 * float(np.exp(ln_length_at(self.ln_length, self.escape, self.spread, retention)))

    def l50_sr(self) -> tuple[float, float]:
        """L50 and SR = L75 - L25, cm, as the curve itself has them."""
        l25, l50, l75 = (self.length_cm_at(retention) for retention in (0.25, 0.5, 0.75))
        return l50, l75 - l25


def crowd_of(catches: list[tuple[Holes, Floats, Floats]]) -> Crowd:
    """Meshes, distances from the front in rows, and shares in their rows, of every catch, strung together."""
    holes = [catch[0] for catch in catches]

    def strung(name: str) -> NDArray:
        return np.concatenate([getattr(one, name) for one in holes])

    _, netting = np.unique([strung(name) for name in ("shape", "bar_m", "knot_m")], axis=1, return_inverse=True)
    arrays = [
        np.concatenate([[0], np.cumsum([len(one.shape) for one in holes])]),
        *(strung(name) for name in ("shape", "bar_m", "knot_m", "half_angle_rad", "across_m", "load_n")),
        *(np.concatenate([catch[i] for catch in catches]) for i in (1, 2)),
        np.asarray(netting, dtype=np.int64),
    ]
    return Crowd(*arrays)


def nodes_of(shapes: int = SHAPES, rotations: int = ROTATIONS, steps: int = STEPS) -> Nodes:
    """Quadrature over standard normal variables: Gauss and Hermite's for shapes, equal strata for rotations.

    What a rotation does has a kink at the best one, and the power of the attempts dwells on the extremes: strata, each
    at the quantile of its middle, are within 0.2 % in L50 and 2 % in SR with 12, where Gauss and Hermite's rule is
    within 0.6 % and 5 %. An even number keeps off the kink.
    """
    shape, weight = np.polynomial.hermite_e.hermegauss(shapes)
    rotation = ndtri((np.arange(rotations) + 0.5) / rotations)
    return Nodes(shape, weight / weight.sum(), rotation, np.full(rotations, 1.0 / rotations), steps)


def escape_terms(crowd: Crowd, catch: int, values: Floats, nodes: Nodes | None = None) -> EscapeTerms:
    """Terms of the retention curve of one catch.

    Args:
        crowd: meshes of all catches.
        catch: number of the catch.
        values: of ``catch_models.fish.PARAMETERS``, (13,).
        nodes: quadrature; ``nodes_of()`` when left out.

    Returns:
        Terms; none where no mesh lies ahead of the catch, so that nothing escapes.
    """
    nodes = nodes or nodes_of()
    most = (crowd.start[catch + 1] - crowd.start[catch]) * len(nodes.shape) * len(nodes.rotation)
    ln_length, escape = np.empty(most), np.empty(most)
    count = add_terms(crowd, catch, values, nodes, ideals_of(crowd, values, nodes), ln_length, escape)
    return EscapeTerms(ln_length[:count], escape[:count], float(values[_SIZE]))


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
    return Hole(crowd.shape[mesh], crowd.bar[mesh], crowd.knot[mesh], crowd.across[mesh], crowd.load[mesh])


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
            hole, effort = _hole(crowd, mesh), Effort(values[_PUSH], nodes.steps)
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
