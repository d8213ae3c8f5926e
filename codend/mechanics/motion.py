"""Masses of the nodes of a net in motion, with what of its loads is taken at the end of a step: kernels.

A step of length h changes velocities by A (V' - V) / h = E - J^T q, with the forces E at its start and

    A = M + h D + h dt K

M the masses, D how fast drag grows with a node's own velocity, K the stiffness of the seabed where a node lies on it,
all 3 x 3 blocks of single nodes. Bars' drag follows the mean of both ends; each end is given the whole of its half,
which is no less, so that no step is too long for stability. D is weighted by 1 / (1 - exp(-z)) - 1 / z, z = h D / M:
1/2 where z is small, which makes the step one of the second order, and 1 where drag alone rules the motion.

Light bars under tension swing across themselves faster than long steps can follow. Where a step is too long for that
(h dt T / l above the mass at an end), the end is given the mass that is wanting, across the bar only: what swings so
fast is then slowed down, and neither a rest nor what the step can follow is changed.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.bars import bar_vector
from codend.mechanics.drag_laws import drag_factors
from codend.mechanics.images import turned
from codend.mechanics.points import Points
from codend.mechanics.rigid import RigidPattern, invert_free
from codend.mechanics.seabed import Seabed
from codend.mechanics.structure import Structure
from codend.mechanics.water import Water, flow_at
from codend.net.net import Floats

SAFE = 1.2
"""Mass at the end of a bar over what a step of its length needs."""


@njit(cache=True)
def weighted(rate: float, mass: float, step: float) -> float:
    """A growth of drag with velocity, kg/s, times its weight and the step, kg, for what it slows."""
    z = step * rate / mass if mass > 0.0 else np.inf
    if z < 1e-3:
        return step * rate * (0.5 + z / 12.0)
    if z > 50.0:
        return step * rate - mass
    return step * rate / (1.0 - np.exp(-z)) - mass


@njit(cache=True, error_model="numpy")
def add_masses(
    pattern: RigidPattern, gradient: Floats, square: Floats, mass: Floats, added: Floats, blocks: Floats
) -> None:
    """Add half a bar's mass to each of its ends, and half its added mass across it, to the nodes' blocks, (n, 3, 3)."""
    starts, ends = pattern.node_start, pattern.node_ends
    for node in range(len(blocks)):
        for place in range(starts[node], starts[node + 1]):
            end = ends[place]
            bar = end // 2
            across = 0.5 * added[bar] / square[bar] if square[bar] > 0.0 else 0.0
            for i in range(3):
                blocks[node, i, i] += 0.5 * (mass[bar] + added[bar])
                for j in range(3):
                    blocks[node, i, j] -= across * gradient[end, i] * gradient[end, j]


@njit(cache=True, error_model="numpy")
def add_bar_drag(
    position: Floats,
    velocity: Floats,
    structure: Structure,
    water: Water,
    mass: Floats,
    added: Floats,
    of_points: Floats,
    density: Floats,
    step: float,
    drift: float,
    blocks: Floats,
) -> None:
    """Add h D of the bars' drag, and the mass wanting under tension.

    ``mass`` and ``added`` are kg a bar, ``density`` the force densities of the last step, N/m, each (m,);
    ``of_points`` is the mass of a node's points for each bar there, kg, (n,).
    """
    n, t, u = np.empty(3), np.empty(3), np.empty(3)
    for bar in range(len(structure.first)):
        first, second, image = structure.first[bar], structure.second[bar], structure.image[bar]
        dx, dy, dz = bar_vector(position, first, second, image, structure.rotations)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        if length == 0.0:
            continue
        t[0], t[1], t[2] = dx / length, dy / length, dz / length
        n[0], n[1], n[2], _, _, _ = flow_at(water, position[first, 2] + 0.5 * dz)
        along = 0.0
        u[0] = velocity[second, 0]
        u[1], u[2] = turned(velocity[second, 1], velocity[second, 2], image, structure.rotations)
        for i in range(3):
            n[i] -= 0.5 * (velocity[first, i] + u[i])
            along += n[i] * t[i]
        across = 0.0
        for i in range(3):
            n[i] -= along * t[i]
            across += n[i] * n[i]
        across = np.sqrt(across)
        if across > 0.0:
            for i in range(3):
                n[i] /= across
        a, c, a_across, _, _, c_along = drag_factors(
            structure.drag_law[bar],
            structure.normal_drag[bar],
            structure.tangential_drag[bar],
            across,
            abs(along),
            structure.diameter[bar] / water.viscosity,
        )
        wetted = structure.length[bar] if structure.is_rope[bar] else length
        scale = 0.25 * water.density * structure.drag_diameter[bar] * wetted
        heavy, light = 0.5 * (mass[bar] + added[bar]), 0.5 * mass[bar]
        beside = weighted(scale * a, heavy, step)
        across_it = weighted(scale * (a + a_across * across), heavy, step) - beside
        along_it = weighted(scale * (c + c_along * abs(along)), light, step) - beside
        for end in range(2):
            node = first if end == 0 else second
            if end == 1:
                n[1], n[2] = turned(n[1], n[2], -image, structure.rotations)
                t[1], t[2] = turned(t[1], t[2], -image, structure.rotations)
            wanting = max(SAFE * step * drift * density[bar] - heavy - beside - of_points[node], 0.0)
            for i in range(3):
                for j in range(3):
                    blocks[node, i, j] += across_it * n[i] * n[j] + (along_it - wanting) * t[i] * t[j]
                blocks[node, i, i] += beside + wanting


@njit(cache=True, error_model="numpy")
def add_point_drag(
    position: Floats, velocity: Floats, points: Points, water: Water, mass: Floats, step: float, blocks: Floats
) -> None:
    """Add h D of the points, whose lift may turn with the flow; ``mass`` is kg a point, (p,)."""
    v = np.empty(3)
    for point in range(len(points.node)):
        node = points.node[point]
        v[0], v[1], v[2], _, _, _ = flow_at(water, position[node, 2])
        squared = 0.0
        for i in range(3):
            v[i] -= velocity[node, i]
            squared += v[i] * v[i]
        if squared == 0.0:
            continue
        speed = np.sqrt(squared)
        half = 0.5 * water.density * speed
        beside = weighted(half * (points.drag_area[point] + abs(points.lift_area[point])), mass[point], step)
        along = weighted(half * (2.0 * points.drag_area[point] + abs(points.lift_area[point])), mass[point], step)
        for i in range(3):
            blocks[node, i, i] += beside
            for j in range(3):
                blocks[node, i, j] += (along - beside) * v[i] * v[j] / squared


@njit(cache=True)
def add_seabed(
    position: Floats, velocity: Floats, seabed: Seabed, step: float, drift: float, force: Floats, blocks: Floats
) -> None:
    """Add h dt K where nodes lie on the seabed, and what their velocity takes from its push, N."""
    for node in range(len(seabed.stiffness)):
        if position[node, 2] < seabed.height:
            stiffness = seabed.stiffness[node]
            force[node, 2] -= drift * stiffness * velocity[node, 2]
            blocks[node, 2, 2] += step * drift * stiffness


@njit(cache=True, error_model="numpy")
def invert(blocks: Floats, free: Floats, inverse: Floats) -> None:
    """Write the inverses of symmetric 3 x 3 blocks with rows and columns of held coordinates 0, (n, 3, 3)."""
    here = np.empty((3, 3))
    for node in range(len(blocks)):
        for i in range(3):
            for j in range(3):
                here[i, j] = blocks[node, i, j]
        invert_free(here, free[node], inverse[node])
