"""Drag and lift of weights, floats and doors at the nodes of a net: force and tangent, kernels.

A point of drag area Cd A in water that passes it with the velocity V is dragged by rho / 2 Cd A |V| V and lifted by
rho / 2 Cl A |V|^2 e, e the part of the direction of its lift that lies across the flow, of length 1.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics.tangent import Pattern
from codend.mechanics.water import Water, flow_at
from codend.net.net import Floats, Ints, Net


class Points(NamedTuple):
    """What the flow does to points; arrays (p,) but ``lift_towards`` (p, 3)."""

    node: Ints
    drag_area: Floats
    """Cd A, m2."""
    lift_area: Floats
    """Cl A, m2."""
    lift_towards: Floats


def points_of(net: Net) -> Points:
    """The points of a net."""
    return Points(net.point_node, net.point_drag_area, net.point_lift_area, net.point_lift_towards)


@njit(cache=True)
def point_load(
    points: Points, point: int, density: float, vx: float, vy: float, vz: float
) -> tuple[float, float, float]:
    """Drag and lift of a point in water that passes it with the velocity V, N."""
    squared = vx * vx + vy * vy + vz * vz
    speed = np.sqrt(squared)
    if speed == 0.0:
        return 0.0, 0.0, 0.0
    drag = 0.5 * density * points.drag_area[point] * speed
    x, y, z = drag * vx, drag * vy, drag * vz
    if points.lift_area[point] != 0.0:
        ex, ey, ez = points.lift_towards[point, 0], points.lift_towards[point, 1], points.lift_towards[point, 2]
        along = (ex * vx + ey * vy + ez * vz) / squared
        ex, ey, ez = ex - along * vx, ey - along * vy, ez - along * vz
        size = np.sqrt(ex * ex + ey * ey + ez * ez)
        if size > 0.0:
            lift = 0.5 * density * points.lift_area[point] * squared / size
            x, y, z = x + lift * ex, y + lift * ey, z + lift * ez
    return x, y, z


@njit(cache=True)
def add_force(position: Floats, velocity: Floats, points: Points, water: Water, force: Floats) -> None:
    """Add drag and lift of the points to the nodal forces, N; ``velocity`` as in ``drag.add_force``."""
    moves = len(velocity) > 0
    for point in range(len(points.node)):
        node = points.node[point]
        vx, vy, vz, _, _, _ = flow_at(water, position[node, 2])
        if moves:
            vx, vy, vz = vx - velocity[node, 0], vy - velocity[node, 1], vz - velocity[node, 2]
        x, y, z = point_load(points, point, water.density, vx, vy, vz)
        force[node, 0] += x
        force[node, 1] += y
        force[node, 2] += z


@njit(cache=True)
def add_tangent(position: Floats, points: Points, water: Water, pattern: Pattern, blocks: Floats) -> None:
    """Add the points' part to the tangent: where the flow changes with the height, by V' dz, their load does."""
    if len(water.height) == 1:
        return
    v, s, e, load = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for point in range(len(points.node)):
        node = points.node[point]
        v[0], v[1], v[2], s[0], s[1], s[2] = flow_at(water, position[node, 2])
        squared, along = v @ v, v @ s
        if squared == 0.0:
            continue
        speed = np.sqrt(squared)
        load[:] = 0.5 * water.density * points.drag_area[point] * (speed * s + along / speed * v)
        lift = 0.5 * water.density * points.lift_area[point]
        if lift != 0.0:
            towards = points.lift_towards[point]
            share = (towards @ v) / squared
            e[:] = towards - share * v
            size = np.sqrt(e @ e)
            if size > 0.0:
                e /= size
                turned = -((towards @ s) - 2.0 * share * along) / squared * v - share * s
                load += lift * (2.0 * along * e + squared / size * (turned - (e @ turned) * e))
        slot = pattern.diagonal[node]
        for i in range(3):
            blocks[slot, i, 2] -= load[i]
