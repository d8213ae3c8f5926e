"""Drag of the twine (Landweber-Richtmyer): kernels."""

import numpy as np

from codend.compiled import njit
from codend.mechanics.arrays import LE_BRIS_1999, Loading, Structure
from codend.mechanics.bars import bar_vector
from codend.mechanics.images import add_turned_back, turned
from codend.net.net import Floats


@njit(cache=True)
def drag_vector(
    law: int, normal: float, tangential: float, vx: float, vy: float, vz: float, tx: float, ty: float, tz: float
) -> tuple[float, float, float]:
    """Drag of a bar along the unit vector t in water that passes it at the velocity v, over 1/2 rho d l, m2/s2.

    With V = Vn + Vt, Vt = (V . t) t (Le Bris et al. 1999, equations 4 and 5; Bessonneau and Marichal 1997, equations 2
    and 3):

        LB99  normal Cd |Vn| Vn,  tangential f Cd |Vt| Vt
        BM97  normal Cd |V| Vn,   tangential Cf |V| Vt
    """
    along = vx * tx + vy * ty + vz * tz
    nx, ny, nz = vx - along * tx, vy - along * ty, vz - along * tz
    if law == LE_BRIS_1999:
        across = normal * np.sqrt(nx * nx + ny * ny + nz * nz)
        along *= normal * tangential * abs(along)
    else:
        speed = np.sqrt(vx * vx + vy * vy + vz * vz)
        across = normal * speed
        along *= tangential * speed
    return across * nx + along * tx, across * ny + along * ty, across * nz + along * tz


@njit(cache=True)
def add_drag(position: Floats, structure: Structure, loading: Loading, share: Floats, force: Floats) -> None:
    """Add the drag of every bar to the nodal forces, half to each end; bars within the catch carry none.

    The netting stands still in a current of ``speed`` along x. A strap meets it with its own length, in the direction
    of its ends, however slack it hangs between them.
    """
    law, normal, tangential = loading.drag_law, loading.normal, loading.tangential
    density, speed = loading.density, loading.speed
    if normal == 0.0 and tangential == 0.0:
        return
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    bands, widths = loading.catch.bar_band, structure.drag_diameter
    for bar in range(len(firsts)):
        exposed = 1.0 - share[bands[bar]]
        if widths[bar] == 0.0 or exposed == 0.0:
            continue
        first, second, image = firsts[bar], seconds[bar], images[bar]
        dx, dy, dz = bar_vector(position, first, second, image, rotations)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        if length == 0.0:
            continue
        wetted = structure.length[bar] if structure.is_rope[bar] else length
        half = 0.25 * exposed * density * widths[bar] * wetted
        x, y, z = drag_vector(law, normal, tangential, speed, 0.0, 0.0, dx / length, dy / length, dz / length)
        force[first, 0] += half * x
        force[first, 1] += half * y
        force[first, 2] += half * z
        add_turned_back(force, second, half * x, half * y, half * z, image, rotations)


@njit(cache=True)
def add_moving_drag(
    position: Floats, velocity: Floats, structure: Structure, loading: Loading, share: Floats, force: Floats
) -> None:
    """Add the drag of bars that move, half to each end: the velocity is that of the water past the bar's middle.

    Within the catch the water goes with the net, so there a bar meets only the flow of its own motion; at rest this is
    ``add_drag``.
    """
    law, normal, tangential = loading.drag_law, loading.normal, loading.tangential
    density, speed = loading.density, loading.speed
    if normal == 0.0 and tangential == 0.0:
        return
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    bands, widths = loading.catch.bar_band, structure.drag_diameter
    for bar in range(len(firsts)):
        first, second, image = firsts[bar], seconds[bar], images[bar]
        dx, dy, dz = bar_vector(position, first, second, image, rotations)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        if widths[bar] == 0.0 or length == 0.0:
            continue
        tx, ty, tz = dx / length, dy / length, dz / length
        y, z = turned(velocity[second, 1], velocity[second, 2], image, rotations)
        vx = -0.5 * (velocity[first, 0] + velocity[second, 0])
        vy, vz = -0.5 * (velocity[first, 1] + y), -0.5 * (velocity[first, 2] + z)
        filled = share[bands[bar]]
        wetted = structure.length[bar] if structure.is_rope[bar] else length
        half = 0.25 * density * widths[bar] * wetted
        x, y, z = 0.0, 0.0, 0.0
        if filled < 1.0:
            x, y, z = drag_vector(law, normal, tangential, speed + vx, vy, vz, tx, ty, tz)
            x, y, z = half * (1.0 - filled) * x, half * (1.0 - filled) * y, half * (1.0 - filled) * z
        if filled > 0.0:
            ix, iy, iz = drag_vector(law, normal, tangential, vx, vy, vz, tx, ty, tz)
            x, y, z = x + half * filled * ix, y + half * filled * iy, z + half * filled * iz
        force[first, 0] += x
        force[first, 1] += y
        force[first, 2] += z
        add_turned_back(force, second, x, y, z, image, rotations)
