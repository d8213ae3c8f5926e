"""Netting that lies over other netting, as a second layer does, and shares its meridian: kernels of a load.

Where all is the same all round, a layer over a band from ring A to ring B, at the mean radius r and ds along the
meridian, has meshes of the half diagonals

    t = pi r / N - a across,    q = ds / n - l along

N its meshes round, n its rows over the band, a and l what its knots take across and along it. Its bars, of length b,
reach t^2 + q^2 = b^2 and pull by EA beyond; in square mesh those round reach 2 t = b and those along q = b, apart. A
layer that reaches farther than the netting below carries nothing.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats

ROUND, ACROSS, ROWS, ALONG, BAR, STIFFNESS, COUNT, SQUARE = range(8)
"""Columns of ``Net.wrap_law``."""


class Stretch(NamedTuple):
    """What a layer does over a band, by t and q."""

    tension: float
    """Of the bars, of square mesh of those round, N."""
    by_t: float
    by_q: float
    by_tt: float
    by_tq: float
    by_qq: float


@njit(cache=True, error_model="numpy")
def stretch_of(law: Floats, t: float, q: float) -> Stretch:
    """Energy of the bars of a layer over a band of a sector, differentiated by t and q."""
    bar, count = law[BAR], law[COUNT]
    rate = count * law[STIFFNESS] / bar
    if law[SQUARE] > 0.0:
        over_t, over_q = max(2.0 * t - bar, 0.0), max(q - bar, 0.0)
        stiff_t, stiff_q = (4.0 * rate if over_t > 0.0 else 0.0), (rate if over_q > 0.0 else 0.0)
        return Stretch(law[STIFFNESS] * over_t / bar, 2.0 * rate * over_t, rate * over_q, stiff_t, 0.0, stiff_q)
    length = np.sqrt(t * t + q * q)
    if length <= bar:
        return Stretch(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    pull, ct, cq = rate * (length - bar), t / length, q / length
    turn = pull / length
    return Stretch(
        law[STIFFNESS] * (length / bar - 1.0),
        pull * ct,
        pull * cq,
        rate * ct * ct + turn * cq * cq,
        (rate - turn) * ct * cq,
        rate * cq * cq + turn * ct * ct,
    )


@njit(cache=True, error_model="numpy")
def diagonals(position: Floats, structure: Structure, band: int) -> tuple[float, float, float, float, float]:
    """T and q of a layer over a band, the direction of the meridian there, and its length ds."""
    rings, law = structure.wrap_ring, structure.wrap_law
    x, r = np.zeros(2), np.zeros(2)
    for i in range(4):
        node = rings[band, i]
        x[i // 2] += 0.5 * position[node, 0]
        r[i // 2] += 0.5 * np.sqrt(position[node, 1] ** 2 + position[node, 2] ** 2)
    along = np.sqrt((x[1] - x[0]) ** 2 + (r[1] - r[0]) ** 2)
    t = max(0.5 * law[band, ROUND] * (r[0] + r[1]) - law[band, ACROSS], 0.0)
    q = max(along / law[band, ROWS] - law[band, ALONG], 0.0)
    return t, q, (x[1] - x[0]) / along, (r[1] - r[0]) / along, along


@njit(cache=True, error_model="numpy")
def _outwards(position: Floats, node: int) -> tuple[float, float, float]:
    """Direction away from the axis, and the distance from it."""
    y, z = position[node, 1], position[node, 2]
    r = np.sqrt(y * y + z * z)
    return (y / r, z / r, r) if r > 0.0 else (0.0, 0.0, 0.0)


@njit(cache=True, error_model="numpy")
def add_force(position: Floats, structure: Structure, force: Floats) -> None:
    """Add the pull of layers to the nodal forces, N."""
    for band in range(len(structure.wrap_ring)):
        law = structure.wrap_law[band]
        t, q, ex, er, _ = diagonals(position, structure, band)
        pull = stretch_of(law, t, q)
        if pull.by_t == 0.0 and pull.by_q == 0.0:
            continue
        inwards, along = 0.25 * law[ROUND] * pull.by_t, 0.5 * pull.by_q / law[ROWS]
        for i in range(4):
            node = structure.wrap_ring[band, i]
            y, z, _ = _outwards(position, node)
            sense = 1.0 if i < 2 else -1.0
            radial = sense * along * er - inwards
            force[node, 0] += sense * along * ex
            force[node, 1] += radial * y
            force[node, 2] += radial * z


@njit(cache=True, error_model="numpy")
def add_tangent(position: Floats, structure: Structure, pattern: Pattern, blocks: Floats) -> None:
    """Add the layers' part to the tangent."""
    for band in range(len(structure.wrap_ring)):
        law = structure.wrap_law[band]
        t, q, ex, er, along = diagonals(position, structure, band)
        pull = stretch_of(law, t, q)
        if pull.by_t == 0.0 and pull.by_q == 0.0:
            continue
        nx, nr = -er, ex
        dt = 0.25 * law[ROUND]
        across = pull.by_q / (law[ROWS] * along)
        for i in range(4):
            node = structure.wrap_ring[band, i]
            yi, zi, r = _outwards(position, node)
            si = (-0.5 if i < 2 else 0.5) / law[ROWS]
            for j in range(4):
                yj, zj, _ = _outwards(position, structure.wrap_ring[band, j])
                sj = (-0.5 if j < 2 else 0.5) / law[ROWS]
                bend = across * (0.25 if (i < 2) == (j < 2) else -0.25)
                xx = pull.by_qq * si * sj * ex * ex + bend * nx * nx
                xr = pull.by_qq * si * sj * ex * er + pull.by_tq * si * dt * ex + bend * nx * nr
                rx = pull.by_qq * si * sj * ex * er + pull.by_tq * sj * dt * ex + bend * nx * nr
                rr = pull.by_tt * dt * dt + pull.by_tq * dt * (si + sj) * er
                rr += pull.by_qq * si * sj * er * er + bend * nr * nr
                slot = pattern.wrap_slot[band, i, j]
                blocks[slot, 0, 0] += xx
                blocks[slot, 0, 1] += xr * yj
                blocks[slot, 0, 2] += xr * zj
                blocks[slot, 1, 0] += rx * yi
                blocks[slot, 2, 0] += rx * zi
                blocks[slot, 1, 1] += rr * yi * yj
                blocks[slot, 1, 2] += rr * yi * zj
                blocks[slot, 2, 1] += rr * zi * yj
                blocks[slot, 2, 2] += rr * zi * zj
            if r > 0.0:
                turning = (dt * pull.by_t + pull.by_q * si * er) / r
                slot = pattern.wrap_slot[band, i, i]
                blocks[slot, 1, 1] += turning * zi * zi
                blocks[slot, 1, 2] -= turning * yi * zi
                blocks[slot, 2, 1] -= turning * yi * zi
                blocks[slot, 2, 2] += turning * yi * yi


@njit(cache=True, error_model="numpy")
def add_bound(position: Floats, structure: Structure, bound: Floats) -> None:
    """Add the layers' part to the bound on each node's row of the stiffness, N/m."""
    for band in range(len(structure.wrap_ring)):
        law = structure.wrap_law[band]
        rate = law[COUNT] * law[STIFFNESS] / law[BAR]
        for i in range(4):
            bound[structure.wrap_ring[band, i]] += 4.0 * rate * (law[ROUND] ** 2 + 1.0 / law[ROWS] ** 2)
