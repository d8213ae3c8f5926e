"""Plain numpy and loops, apart from the project's kernels: what a result's arrays must satisfy."""

import numpy as np

from codend.net import Net
from codend.problem import Problem


def turned(point: np.ndarray, image: int, order: int) -> np.ndarray:
    angle = 2 * np.pi * image / order
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ point


def net_pressure_coefficient(problem: Problem, theta: float) -> float:
    loading = problem.loading
    piece = min(np.searchsorted(loading.angles, theta, side="right") - 1, len(loading.angles) - 2)
    return float(np.polyval(loading.coefficients[:, piece], theta - loading.angles[piece]))


def twine_drag(problem: Problem, vector: np.ndarray, width: float) -> np.ndarray:
    """Equations 4 and 5 of Le Bris et al. 1999, 2 and 3 of Bessonneau and Marichal 1997, in vectors."""
    loading = problem.loading
    length = np.linalg.norm(vector)
    flow = np.array([loading.speed, 0.0, 0.0])
    tangent = vector / length
    along = (flow @ tangent) * tangent
    across = flow - along
    scale = 0.5 * loading.density * width * length
    if loading.drag_law == 0:
        normal = scale * loading.normal * np.linalg.norm(across) * across
        return normal + loading.tangential * scale * loading.normal * np.linalg.norm(along) * along
    return scale * np.linalg.norm(flow) * (loading.normal * across + loading.tangential * along)


def nodal_loads(problem: Problem, positions: np.ndarray, share: np.ndarray) -> np.ndarray:
    net, loading = problem.net, problem.loading
    force = loading.dead.copy()
    for bar, (i, j) in enumerate(net.bars):
        image = net.bar_image[bar]
        vector = turned(positions[j], image, net.order) - positions[i]
        width = net.bar_drag_diameter[bar]
        if width > 0:
            load = (1 - share[net.bar_band[bar]]) * twine_drag(problem, vector, width)
            force[i] += load / 2
            force[j] += turned(load, -image, net.order) / 2
    for facet, corners in enumerate(net.facets):
        filled = share[net.facet_band[facet]]
        if filled == 0:
            continue
        a, b, c = (turned(positions[n], k, net.order) for n, k in zip(corners, net.facet_image[facet], strict=True))
        area = np.cross(b - a, c - a) / 2
        theta = np.arccos(np.clip(-area[0] / np.linalg.norm(area), -1, 1))
        pressure = loading.stagnation_pressure * net_pressure_coefficient(problem, theta)
        for n, k in zip(corners, net.facet_image[facet], strict=True):
            force[n] += turned(filled * net.facet_weight[facet] * pressure * area / 3, -k, net.order)
    return force


def bar_pulls(net: Net, positions: np.ndarray, tension: np.ndarray) -> np.ndarray:
    force = np.zeros_like(positions)
    for bar, (i, j) in enumerate(net.bars):
        image = net.bar_image[bar]
        vector = turned(positions[j], image, net.order) - positions[i]
        pull = tension[bar] * vector / np.linalg.norm(vector)
        force[i] += pull
        force[j] -= turned(pull, -image, net.order)
    return force


def residual(problem: Problem, positions: np.ndarray, tension: np.ndarray, share: np.ndarray) -> float:
    """Largest out-of-balance force of a free node over the resultant of the loads on the whole net."""
    net = problem.net
    loads = nodal_loads(problem, positions, share)
    resultant = net.order * loads.sum(axis=0)
    if net.order > 1:
        resultant[1:] = 0
    force = np.where(net.fixed, 0.0, loads + bar_pulls(net, positions, tension))
    return float(np.linalg.norm(force, axis=1).max() / np.linalg.norm(resultant))
