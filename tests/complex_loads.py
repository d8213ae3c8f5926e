"""Forces on a net in plain numpy, apart from the project's kernels and analytic in the positions.

A complex step x + ih in one coordinate then gives a column of the derivative to round-off (Squire and Trapp 1998, SIAM
Review 40, 110-112): there is no difference to cancel. So norms are roots of sums of products, nothing is made absolute
or conjugate, and cases (pieces of the pressure law, taut and slack twine, the front's band) are told by real parts.
"""

from collections.abc import Callable

import numpy as np

from codend.mechanics.drag_laws import BESSONNEAU_1997, LE_BRIS_1999
from codend.mechanics.pressure import FILLED_MESHES, FRONT_FROM_CODLINE
from codend.mechanics.problem import Problem
from codend.net.net import Net, facet_corners, rotate

STEP = 1e-30


def derivative(function: Callable[[np.ndarray], np.ndarray], position: np.ndarray) -> np.ndarray:
    """Derivative of a function of positions by all of their coordinates, (values, 3 n)."""
    columns = []
    for coordinate in range(position.size):
        moved = position.astype(complex)
        moved.reshape(-1)[coordinate] += 1j * STEP
        columns.append(np.ravel(function(moved)).imag / STEP)
    return np.stack(columns, axis=1)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=-1)


def norm(a: np.ndarray) -> np.ndarray:
    return np.sqrt(dot(a, a))


def gathered(net: Net, *parts: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Forces on nodes, (n, 3), from parts (node, image, force on that image)."""
    force = np.zeros((len(net.positions), 3), dtype=complex)
    for node, image, load in parts:
        np.add.at(force, node, rotate(load, -image, net.order))
    return force


def vectors(net: Net, position: np.ndarray) -> np.ndarray:
    return rotate(position[net.bars[:, 1]], net.bar_image, net.order) - position[net.bars[:, 0]]


def on_both_ends(net: Net, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return gathered(net, (net.bars[:, 0], 0 * net.bar_image, first), (net.bars[:, 1], net.bar_image, second))


def elastic_pull(net: Net, position: np.ndarray) -> np.ndarray:
    """T = EA (l - l0) / l0 along every strut, and every bar that is longer than without load; nothing in the others."""
    vector = vectors(net, position)
    length = norm(vector)
    tension = (length / net.bar_length - 1.0) / net.bar_flexibility
    tension = np.where((tension.real > 0.0) | net.bar_is_strut, tension, 0.0)
    pull = (tension / length)[:, None] * vector
    return on_both_ends(net, pull, -pull)


def flow_at(problem: Problem, height: np.ndarray) -> np.ndarray:
    """Velocity of the water at heights (m,), (m, 3): linear between those for which it is given."""
    water = problem.loading.water
    if len(water.height) == 1:
        return np.broadcast_to(water.flow, (len(height), 3))
    piece = np.clip(np.searchsorted(water.height, height.real, side="right") - 1, 0, len(water.height) - 2)
    z = np.where(height.real < water.height[0], water.height[0], height)
    z = np.where(height.real > water.height[-1], water.height[-1], z)
    share = ((z - water.height[piece]) / (water.height[piece + 1] - water.height[piece]))[:, None]
    return (1.0 - share) * water.flow[piece] + share * water.flow[piece + 1]


def choo_casarella(number: np.ndarray) -> np.ndarray:
    """Drag coefficient at Reynolds numbers away from 1 and 30, where its pieces are led into each other."""
    s = -0.077215665 + np.log(8.0 / number)
    slow = 8.0 * np.pi / (number * s) * (1.0 - 0.87 * s**-2)
    middle, fast = 1.45 + 8.55 * number**-0.9, 1.1 + 4.0 * number**-0.5
    return np.where(number.real < 0.9, slow, np.where(number.real < 27.0, middle, fast))


def twine_drag(problem: Problem, position: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Le Bris et al. 1999, equations 4 and 5; Bessonneau and Marichal 1997, equations 2 and 3; Choo and Casarella 1971.

    A bar is as long as its ends are apart, a rope as long as itself. Of a net whose bars all have one law.
    """
    net, loading = problem.net, problem.loading
    vector = vectors(net, position)
    length = norm(vector)[:, None]
    flow = flow_at(problem, position[net.bars[:, 0], 2] + 0.5 * vector[:, 2])
    along = dot(flow, vector / length)[:, None] * vector / length
    across = flow - along
    normal, tangential = net.bar_normal_drag, net.bar_tangential_drag
    law = net.bar_drag_law[0]
    assert np.all(net.bar_drag_law == law)
    if law == LE_BRIS_1999:
        by_across, by_along = normal * norm(across), tangential * normal * norm(along)
    elif law == BESSONNEAU_1997:
        by_across, by_along = normal * norm(flow), tangential * norm(flow)
    else:
        per_speed = net.bar_diameter / loading.water.viscosity
        number = per_speed * norm(across)
        by_across = normal * choo_casarella(number) * norm(across)
        by_along = tangential * 2.0 * np.pi / per_speed * (0.55 * number**0.5 + 0.084 * number ** (2.0 / 3.0))
    load = by_across[:, None] * across + by_along[:, None] * along
    exposed = (1.0 - share[loading.catch.bar_band]) * net.bar_drag_diameter
    wetted = length.copy()
    wetted[net.bar_is_rope, 0] = net.bar_length[net.bar_is_rope]
    half = 0.25 * loading.water.density * exposed[:, None] * wetted * load
    return on_both_ends(net, half, half)


def catch_pressure(problem: Problem, position: np.ndarray, share: np.ndarray) -> np.ndarray:
    """q (1 - Cp(theta)) on every facet's area vector, a third to each corner (Le Bris et al. 1999, section 5)."""
    net, catch = problem.net, problem.loading.catch
    corners = facet_corners(net, position)
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    theta = 0.5 * np.pi + np.arctan(area[:, 0] / norm(area[:, 1:]))
    piece = np.clip(np.searchsorted(catch.angles, theta.real, side="right") - 1, 0, len(catch.angles) - 2)
    c, t = catch.coefficients[:, piece], theta - catch.angles[piece]
    coefficient = c[0] * t**3 + c[1] * t**2 + c[2] * t + c[3]
    filled = share[catch.facet_band] * net.facet_weight
    third = (filled * catch.stagnation_pressure * coefficient / 3.0)[:, None] * area
    return gathered(net, *((net.facets[:, i], net.facet_image[:, i], third) for i in range(3)))


def catch_weight(problem: Problem, position: np.ndarray, share: np.ndarray) -> np.ndarray:
    """d g (z_f - z) at the middle of every facet on its area vector, a third to each corner.

    What that lacks of d g V in sum, the two rings of the front's band bear, by its share.
    """
    net, catch = problem.net, problem.loading.catch
    corners = facet_corners(net, position)
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = int(np.flatnonzero(share.real)[0])
    fore, aft = (position[catch.node_row == row, 2].mean() for row in (front, front + 1))
    height = share[front] * fore + (1.0 - share[front]) * aft
    filled = share[catch.facet_band] * net.facet_weight
    third = (filled * catch.weight_density * (height - corners[:, :, 2].mean(axis=1)) / 3.0)[:, None] * area
    load = gathered(net, *((net.facets[:, i], net.facet_image[:, i], third) for i in range(3)))
    if net.order > 1:
        return load
    weight_density = catch.weight_density
    volume = _volume(*_shape(problem, position), front, share[front])
    left = -load.sum(axis=0) - np.array([0.0, 0.0, 1.0]) * weight_density * volume
    for row, part in ((front, share[front]), (front + 1, 1.0 - share[front])):
        ring = catch.node_row == row
        load[ring] += part * left / ring.sum()
    return load


def corner_twines(net: Net, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vectors from the middle of every corner along its two twines."""
    middle, first, second = np.moveaxis(rotate(position[net.corners], net.corner_image, net.order), 1, 0)
    return first - middle, second - middle


def bending_energy(net: Net, position: np.ndarray) -> np.ndarray:
    """k (psi - psi0)^2 / 8 of all corners: half the energy of the two twines that meet there."""
    u, v = corner_twines(net, position)
    psi = np.arccos(dot(u, v) / norm(u) / norm(v))
    return (net.corner_stiffness * (psi - net.corner_rest) ** 2).sum() / 8.0


def bending_resistance(net: Net, position: np.ndarray) -> np.ndarray:
    """Minus the gradient of that energy: the angle grows fastest as each twine turns away from the other."""
    u, v = corner_twines(net, position)
    lu, lv = norm(u)[:, None], norm(v)[:, None]
    cosine = (dot(u, v) / norm(u) / norm(v))[:, None]
    sine = np.sqrt(1.0 - cosine**2)
    moment = 0.25 * (net.corner_stiffness * (np.arccos(cosine[:, 0]) - net.corner_rest))[:, None]
    first = moment * (v / lv - cosine * u / lu) / (sine * lu)
    second = moment * (u / lu - cosine * v / lv) / (sine * lv)
    parts = zip((-first - second, first, second), net.corners.T, net.corner_image.T, strict=True)
    return gathered(net, *((node, image, load) for load, node, image in parts))


def shares(problem: Problem, position: np.ndarray) -> np.ndarray:
    """Share of every band within the catch: the bands aft of the front, and the part of its own that the front fills.

    A front given by a plane or by the volume is found by Newton's method on the place of the lid.
    """
    catch = problem.loading.catch
    if catch.kind == FILLED_MESHES:
        aft = np.cumsum(catch.band_meshes[::-1])[::-1] - catch.band_meshes
        return np.clip((catch.size - aft) / catch.band_meshes, 0.0, 1.0)
    shape = _shape(problem, position)
    real = [part.real for part in shape]
    measured = _to_plane if catch.kind == FRONT_FROM_CODLINE else _volume
    whole = np.array([measured(*real, band, 1.0) for band in range(problem.bands)])
    band = int(np.flatnonzero(whole >= catch.size)[-1])
    filled = 0.5 + 0.0j
    for _ in range(12):
        slope = measured(*real, band, filled.real + 1j * STEP).imag / STEP
        filled -= (measured(*shape, band, filled) - catch.size) / slope
    place = np.arange(problem.bands)
    return np.where(place > band, 1.0, np.where(place == band, filled, 0.0))


def _shape(problem: Problem, position: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean axial position of every row; axial projection of every band's facets all round, and its moment in x."""
    net, catch = problem.net, problem.loading.catch
    rows = np.array([position[catch.node_row == row, 0].mean() for row in range(problem.bands + 1)])
    a, b, c = np.moveaxis(facet_corners(net, position), 1, 0)
    projected = 0.5 * np.cross(b - a, c - a)[:, 0] * net.facet_weight * net.order
    area, moment = np.zeros(problem.bands, dtype=complex), np.zeros(problem.bands, dtype=complex)
    np.add.at(area, catch.facet_band, projected)
    np.add.at(moment, catch.facet_band, projected * (a + b + c)[:, 0] / 3.0)
    return rows, area, moment


def _to_plane(rows: np.ndarray, _area: np.ndarray, _moment: np.ndarray, band: int, filled: complex) -> complex:
    return rows[-1] - filled * rows[band] - (1.0 - filled) * rows[band + 1]


def _volume(rows: np.ndarray, area: np.ndarray, moment: np.ndarray, band: int, filled: complex) -> complex:
    """Volumes behind the planes of the band's two rows, in proportion: fluxes of (x - plane, 0, 0) out of the bands."""
    fore, aft = (moment - rows[row] * area for row in (band, band + 1))
    return filled * fore[band:].sum() + (1.0 - filled) * aft[band + 1 :].sum()
