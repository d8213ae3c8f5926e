"""Drag of the bars in the water that passes them: force and tangent, kernels. The laws are in ``drag_laws``.

Half of a bar's drag goes to each of its ends. With d the bar's vector, l its length, t = d / l, V the velocity of the
water past its middle, Vt = V . t and Vn = V - Vt t, the load on each end is S l F, with

    F = A Vn + C Vt t,   S = rho w / 4 times the share of the bar that is outside the catch, w its width

A and C are functions of |Vn| and |Vt|. A change of d turns the bar by dt = (dd - t t.dd) / l, which changes these by
d|Vn| = -Vt n.dt, dVt = Vn.dt (n = Vn / |Vn|), dVn = -(Vn.dt) t - Vt dt. A rope meets the water with its own length in
place of l, in the direction of its ends, however slack it hangs between them.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.bars import bar_vector
from codend.mechanics.drag_laws import drag_factors
from codend.mechanics.images import add_turned_back, turned
from codend.mechanics.pressure import Catch
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern, add_bar_blocks, add_turned_block
from codend.mechanics.water import Water, flow_at
from codend.net.net import Floats

Law = tuple[int, float, float, float]
"""A law's number, its two coefficients, and a bar's Reynolds number per speed, s/m."""


@njit(cache=True, error_model="numpy")
def bar_drag(
    law: int,
    normal: float,
    tangential: float,
    reynolds: float,
    vx: float,
    vy: float,
    vz: float,
    tx: float,
    ty: float,
    tz: float,
) -> tuple[float, float, float]:
    """F of a bar along the unit vector t in water that passes it with the velocity V, m2/s2."""
    along = vx * tx + vy * ty + vz * tz
    nx, ny, nz = vx - along * tx, vy - along * ty, vz - along * tz
    a, c, _, _, _, _ = drag_factors(law, normal, tangential, np.sqrt(nx * nx + ny * ny + nz * nz), abs(along), reynolds)
    along *= c
    return a * nx + along * tx, a * ny + along * ty, a * nz + along * tz


@njit(cache=True, error_model="numpy")
def add_force(
    position: Floats,
    velocity: Floats,
    structure: Structure,
    water: Water,
    catch: Catch,
    share: Floats,
    force: Floats,
) -> None:
    """Add the drag of every bar to the nodal forces, N.

    Bars within the catch carry none of the current's drag. ``velocity`` is that of the nodes, (n, 3), or empty, (0, 3),
    for a net at rest. Where a net moves the water within the catch goes with it, so there a bar meets only the flow of
    its own motion.
    """
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    bands, widths, diameters = catch.bar_band, structure.drag_diameter, structure.diameter
    laws, normals, tangentials = structure.drag_law, structure.normal_drag, structure.tangential_drag
    density, ropes, rests = water.density, structure.is_rope, structure.length
    per_viscosity = 1.0 / water.viscosity
    moves = len(velocity) > 0
    uniform = len(water.height) == 1
    vx, vy, vz, _, _, _ = flow_at(water, 0.0)
    for bar in range(len(firsts)):
        exposed = 1.0 - share[bands[bar]]
        if widths[bar] == 0.0 or (exposed == 0.0 and not moves):
            continue
        first, second, image = firsts[bar], seconds[bar], images[bar]
        dx, dy, dz = bar_vector(position, first, second, image, rotations)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        if length == 0.0:
            continue
        tx, ty, tz = dx / length, dy / length, dz / length
        law, normal, tangential, reynolds = laws[bar], normals[bar], tangentials[bar], diameters[bar] * per_viscosity
        if not uniform:
            vx, vy, vz, _, _, _ = flow_at(water, position[first, 2] + 0.5 * dz)
        half = 0.25 * density * widths[bar] * (rests[bar] if ropes[bar] else length)
        if moves:
            y, z = turned(velocity[second, 1], velocity[second, 2], image, rotations)
            ux = 0.5 * (velocity[first, 0] + velocity[second, 0])
            uy, uz = 0.5 * (velocity[first, 1] + y), 0.5 * (velocity[first, 2] + z)
            x, y, z = bar_drag(law, normal, tangential, reynolds, vx - ux, vy - uy, vz - uz, tx, ty, tz)
            ix, iy, iz = bar_drag(law, normal, tangential, reynolds, -ux, -uy, -uz, tx, ty, tz)
            within = 1.0 - exposed
            x, y, z = exposed * x + within * ix, exposed * y + within * iy, exposed * z + within * iz
        else:
            x, y, z = bar_drag(law, normal, tangential, reynolds, vx, vy, vz, tx, ty, tz)
            half *= exposed
        x, y, z = half * x, half * y, half * z
        force[first, 0] += x
        force[first, 1] += y
        force[first, 2] += z
        add_turned_back(force, second, x, y, z, image, rotations)


@njit(cache=True, error_model="numpy")
def add_tangent(
    position: Floats,
    velocity: Floats,
    rate: float,
    structure: Structure,
    water: Water,
    catch: Catch,
    pattern: Pattern,
    share: Floats,
    blocks: Floats,
) -> None:
    """Add the derivative of the drag to the tangent.

    ``velocity`` is as in ``add_force``; of a net that moves every node's grows with its position by ``rate``, 1/s.
    """
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    bands, widths, rests = catch.bar_band, structure.drag_diameter, structure.length
    ropes, density, diameters = structure.is_rope, water.density, structure.diameter
    laws, normals, tangentials = structure.drag_law, structure.normal_drag, structure.tangential_drag
    per_viscosity = 1.0 / water.viscosity
    moves, uniform, slots = len(velocity) > 0, len(water.height) == 1, pattern.bar_slot
    vx, vy, vz, _, _, _ = flow_at(water, 0.0)
    h, g, v, u, t = np.zeros((3, 3)), np.zeros((3, 3)), np.empty(3), np.empty(3), np.empty(3)
    for bar in range(len(firsts)):
        exposed = 1.0 - share[bands[bar]]
        if widths[bar] == 0.0 or (exposed == 0.0 and not moves):
            continue
        first, second, image = firsts[bar], seconds[bar], images[bar]
        dx, dy, dz = bar_vector(position, first, second, image, rotations)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        if length == 0.0:
            continue
        t[0], t[1], t[2] = dx / length, dy / length, dz / length
        if not uniform:
            vx, vy, vz, _, _, _ = flow_at(water, position[first, 2] + 0.5 * dz)
        scale = 0.25 * density * widths[bar]
        own = rests[bar] / length if ropes[bar] else 1.0
        v[0], v[1], v[2] = vx, vy, vz
        h[:] = 0.0
        law = laws[bar], normals[bar], tangentials[bar], diameters[bar] * per_viscosity
        if moves:
            u[0] = velocity[second, 0]
            u[1], u[2] = turned(velocity[second, 1], velocity[second, 2], image, rotations)
            g[:] = 0.0
            for i in range(3):
                u[i] = 0.5 * (velocity[first, i] + u[i])
                v[i] -= u[i]
            inside = scale * (1.0 - exposed)
            for i in range(3):
                u[i] = -u[i]
            _add_slopes(law, u, t, inside, own, ropes[bar], h)
            _add_slopes_by_flow(law, u, t, inside * own * length, g)
            _add_slopes_by_flow(law, v, t, scale * exposed * own * length, g)
            # each end's velocity is half that of the middle, and slows the water that passes
            for i in range(2):
                for j in range(2):
                    at = image * i, image * j
                    add_turned_block(blocks, slots[bar, 2 * i + j], 0.5 * rate, g, at[0], at[1], rotations)
        _add_slopes(law, v, t, scale * exposed, own, ropes[bar], h)
        add_bar_blocks(blocks, slots, bar, h, 1.0, image, rotations)
        if not uniform:
            _add_shear(position, structure, water, pattern, bar, scale * exposed * own * length, h, blocks)


@njit(cache=True, error_model="numpy")
def _add_slopes(law: Law, v: Floats, t: Floats, scale: float, own: float, rope: bool, h: Floats) -> None:
    """Add minus the change of a bar's drag by its vector, in water that passes it with the velocity v, (3, 3).

    ``scale`` is S over the length, ``own`` a rope's length over that between its ends.
    """
    along = v[0] * t[0] + v[1] * t[1] + v[2] * t[2]
    ux, uy, uz = v[0] - along * t[0], v[1] - along * t[1], v[2] - along * t[2]
    across = np.sqrt(ux * ux + uy * uy + uz * uz)
    number, normal, tangential, reynolds = law
    a, c, a_across, a_along, c_across, c_along = drag_factors(number, normal, tangential, across, abs(along), reynolds)
    # d(S l F) = S l' dF + S F dl, the latter not of a rope; dF = ((A' - C') and so on along Vn and t) Vn.dd / l
    if along < 0.0:
        a_along, c_along = -a_along, -c_along
    per_across = 1.0 / across if across > 0.0 else 0.0
    by_turn_u = a_along - along * a_across * per_across
    by_turn_t = -a + c + along * (c_along - along * c_across * per_across)
    turn = along * (c - a)
    for i in range(3):
        u = ux if i == 0 else (uy if i == 1 else uz)
        along_u, along_t = own * scale * (by_turn_u * u + by_turn_t * t[i]), -own * scale * turn * t[i]
        if not rope:
            along_t += scale * (a * u + c * along * t[i])
        h[i, 0] += along_u * ux + along_t * t[0]
        h[i, 1] += along_u * uy + along_t * t[1]
        h[i, 2] += along_u * uz + along_t * t[2]
        h[i, i] += own * scale * turn


@njit(cache=True, error_model="numpy")
def _add_slopes_by_flow(law: Law, v: Floats, t: Floats, scale: float, g: Floats) -> None:
    """Add the change of the drag on each end of a bar by the velocity v of the water that passes it, kg/s, (3, 3)."""
    along = v[0] * t[0] + v[1] * t[1] + v[2] * t[2]
    u = v - along * t
    across = np.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    number, normal, tangential, reynolds = law
    a, c, a_across, a_along, c_across, c_along = drag_factors(number, normal, tangential, across, abs(along), reynolds)
    if along < 0.0:
        a_along, c_along = -a_along, -c_along
    if across > 0.0:
        a_across, c_across = a_across / across, c_across / across
    for i in range(3):
        for j in range(3):
            g[i, j] += scale * u[i] * (a_across * u[j] + a_along * t[j])
            g[i, j] += scale * t[i] * ((c - a) * t[j] + along * (c_across * u[j] + c_along * t[j]))
        g[i, i] += scale * a


@njit(cache=True, error_model="numpy")
def _add_shear(
    position: Floats,
    structure: Structure,
    water: Water,
    pattern: Pattern,
    bar: int,
    scale: float,
    h: Floats,
    blocks: Floats,
) -> None:
    """Add what a bar's drag changes by as its middle meets another flow at another height; only in full nets.

    With dV = V' dz the change of F is  A dVn + C dVt t + (A' d|Vn| + A. d|Vt|) Vn + (C' d|Vn| + C. d|Vt|) Vt t.
    """
    first, second = structure.first[bar], structure.second[bar]
    dx, dy, dz = bar_vector(position, first, second, 0, structure.rotations)
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    vx, vy, vz, sx, sy, sz = flow_at(water, position[first, 2] + 0.5 * dz)
    tx, ty, tz = dx / length, dy / length, dz / length
    along, along_z = vx * tx + vy * ty + vz * tz, sx * tx + sy * ty + sz * tz
    nx, ny, nz = vx - along * tx, vy - along * ty, vz - along * tz
    mx, my, mz = sx - along_z * tx, sy - along_z * ty, sz - along_z * tz
    across = np.sqrt(nx * nx + ny * ny + nz * nz)
    across_z = (nx * mx + ny * my + nz * mz) / across if across > 0.0 else 0.0
    speed_z = along_z if along >= 0.0 else -along_z
    a, c, a_across, a_along, c_across, c_along = drag_factors(
        structure.drag_law[bar],
        structure.normal_drag[bar],
        structure.tangential_drag[bar],
        across,
        abs(along),
        structure.diameter[bar] / water.viscosity,
    )
    a_z = a_across * across_z + a_along * speed_z
    friction_z = (c_across * across_z + c_along * speed_z) * along + c * along_z
    slots = pattern.bar_slot
    for row in range(2):
        for column in range(2):
            slot = slots[bar, 2 * row + column]
            blocks[slot, 0, 2] -= 0.5 * scale * (a * mx + a_z * nx + friction_z * tx)
            blocks[slot, 1, 2] -= 0.5 * scale * (a * my + a_z * ny + friction_z * ty)
            blocks[slot, 2, 2] -= 0.5 * scale * (a * mz + a_z * nz + friction_z * tz)
