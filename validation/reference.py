"""What the arrays of a result must satisfy, in plain numpy and loops, apart from the project's kernels.

Loads are those of Le Bris et al. 1999 (equations 4 and 5, section 5) and Bessonneau and Marichal 1997 (equations 2 and
3); nets whose twine resists bending are not covered.
"""

from typing import NamedTuple

import numpy as np

from codend.mechanics.drag_laws import BESSONNEAU_1997, LE_BRIS_1999
from codend.mechanics.problem import Problem
from codend.net.net import Net


def turned(point: np.ndarray, image: int, order: int) -> np.ndarray:
    """A point turned about the x axis by ``image`` of ``order`` equal sectors, (3,)."""
    angle = 2 * np.pi * image / order
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ point


def net_pressure_coefficient(problem: Problem, theta: float) -> float:
    """Net pressure over stagnation pressure at the angle theta, rad."""
    catch = problem.loading.catch
    piece = min(np.searchsorted(catch.angles, theta, side="right") - 1, len(catch.angles) - 2)
    return float(np.polyval(catch.coefficients[:, piece], theta - catch.angles[piece]))


def twine_drag(problem: Problem, bar: int, vector: np.ndarray) -> np.ndarray:
    """Drag of a bar in N, (3,): equations 4 and 5 of LB99, 2 and 3 of BM97, in vectors."""
    net, water = problem.net, problem.loading.water
    normal, tangential = net.bar_normal_drag[bar], net.bar_tangential_drag[bar]
    length = np.linalg.norm(vector)
    (flow,) = water.flow
    tangent = vector / length
    along = (flow @ tangent) * tangent
    across = flow - along
    scale = 0.5 * water.density * net.bar_drag_diameter[bar] * length
    if net.bar_drag_law[bar] == LE_BRIS_1999:
        return scale * normal * (np.linalg.norm(across) * across + tangential * np.linalg.norm(along) * along)
    assert net.bar_drag_law[bar] == BESSONNEAU_1997
    return scale * np.linalg.norm(flow) * (normal * across + tangential * along)


def bar_vector(net: Net, positions: np.ndarray, bar: int) -> np.ndarray:
    """From the first to the second end of a bar, m, (3,)."""
    i, j = net.bars[bar]
    return turned(positions[j], net.bar_image[bar], net.order) - positions[i]


def nodal_loads(problem: Problem, positions: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Loads on the nodes in N, (n, 3): all forces but the bars' tensions."""
    net, catch = problem.net, problem.loading.catch
    force = problem.loading.dead.copy()
    for bar, (i, j) in enumerate(net.bars):
        if net.bar_drag_diameter[bar] > 0:
            vector = bar_vector(net, positions, bar)
            drag = twine_drag(problem, bar, vector)
            if net.bar_is_rope[bar]:  # however slack, it meets the water with its own length
                drag *= net.bar_length[bar] / np.linalg.norm(vector)
            load = (1 - share[catch.bar_band[bar]]) * drag
            force[i] += load / 2
            force[j] += turned(load, -net.bar_image[bar], net.order) / 2
    for facet, corners in enumerate(net.facets):
        filled = share[catch.facet_band[facet]]
        if filled == 0:
            continue
        a, b, c = (turned(positions[n], k, net.order) for n, k in zip(corners, net.facet_image[facet], strict=True))
        area = np.cross(b - a, c - a) / 2
        theta = np.arctan2(np.hypot(area[1], area[2]), -area[0])
        pressure = catch.stagnation_pressure * net_pressure_coefficient(problem, theta)
        for n, k in zip(corners, net.facet_image[facet], strict=True):
            force[n] += turned(filled * net.facet_weight[facet] * pressure * area / 3, -k, net.order)
    return force


def bar_pulls(net: Net, positions: np.ndarray, tension: np.ndarray) -> np.ndarray:
    """Pull of the bars on the nodes in N, (n, 3)."""
    force = np.zeros_like(positions)
    for bar, (i, j) in enumerate(net.bars):
        vector = bar_vector(net, positions, bar)
        pull = tension[bar] * vector / np.linalg.norm(vector)
        force[i] += pull
        force[j] -= turned(pull, -net.bar_image[bar], net.order)
    return force


class Departure(NamedTuple):
    """How far a state is from an equilibrium of a net."""

    residual: float
    """Largest out-of-balance force of a free node over the resultant of the loads on the whole net."""
    imbalance: float
    """Axial sum of the out-of-balance forces of all free nodes over the same."""
    length_error: float
    """Largest departure of a bar from its twine's law (slack bars may be short), relative to its length."""
    compression: float
    """Largest compression in a bar over the largest tension."""
    drag: float
    """Axial sum of the loads on the whole net, N."""


def departure(problem: Problem, positions: np.ndarray, tension: np.ndarray, share: np.ndarray) -> Departure:
    """Hold positions (n, 3), bar tensions (m,) and the catch's share of the bands to what an equilibrium must be."""
    net = problem.net
    loads = nodal_loads(problem, positions, share)
    resultant = net.order * loads.sum(axis=0)
    if net.order > 1:
        resultant[1:] = 0
    mean_tension = np.abs(tension).mean()
    scale = net.order * np.linalg.norm(loads, axis=1).sum() + mean_tension
    force = np.where(net.fixed, 0.0, loads + bar_pulls(net, positions, tension))
    length = np.array([np.linalg.norm(bar_vector(net, positions, bar)) for bar in range(len(net.bars))])
    stretch = length / net.bar_length - 1.0 - tension * net.bar_flexibility
    return Departure(
        residual=float(np.linalg.norm(force, axis=1).max() / scale),
        imbalance=float(abs(net.order * force[:, 0].sum()) / np.linalg.norm(resultant)),
        length_error=float(np.where(tension > 0, np.abs(stretch), stretch).max()),
        compression=float(max(0.0, -tension.min()) / max(tension.max(), 1e-300)),
        drag=float(net.order * loads[:, 0].sum()),
    )


def facing_rings(problem: Problem, positions: np.ndarray) -> float:
    """Least mean, over a band, of the cosine between the directions of the knots that a bar joins, from their axis.

    That is the flow's for a sector, and for a full net, whose codline is free, the middles of its rings. Near 1 in a
    sound net that is the same all round; below 0 the netting has passed through itself at the axis.
    """
    net, catch = problem.net, problem.loading.catch
    if net.order == 1:
        positions = positions.copy()
        for row in np.unique(catch.node_row[catch.node_row >= 0]):
            ring = catch.node_row == row
            positions[ring, 1:] -= positions[ring, 1:].mean(axis=0)
    cosines: dict[int, list[float]] = {}
    for bar, (i, j) in enumerate(net.bars):
        if catch.node_row[i] == catch.node_row[j] or min(catch.node_row[i], catch.node_row[j]) < 0:
            continue
        first, second = positions[i, 1:], turned(positions[j], net.bar_image[bar], net.order)[1:]
        size = np.linalg.norm(first) * np.linalg.norm(second)
        if size > 1e-8 * net.bar_length[bar] ** 2:
            cosines.setdefault(int(catch.bar_band[bar]), []).append(float(first @ second / size))
    return min((float(np.mean(found)) for found in cosines.values()), default=1.0)


def residual(problem: Problem, positions: np.ndarray, tension: np.ndarray, share: np.ndarray) -> float:
    """Largest out-of-balance force of a free node over the resultant of the loads on the whole net."""
    return departure(problem, positions, tension, share).residual
