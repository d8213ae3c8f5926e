"""Drag of the twine (Landweber-Richtmyer): kernels."""

import numpy as np
from numba import njit

from codend.mechanics.arrays import LE_BRIS_1999, Loading, Structure
from codend.mechanics.images import add_turned_back, turned
from codend.net import Floats


@njit(cache=True)
def add_drag(position: Floats, structure: Structure, loading: Loading, share: Floats, force: Floats) -> None:
    """Add the drag of every bar to the nodal forces, half to each end; bars within the catch carry none.

    The netting stands still in a current of ``speed`` along x. With c the cosine between bar and current, per bar of
    length l and width d (Le Bris et al. 1999, equations 4 and 5; Bessonneau and Marichal 1997, equations 2 and 3):

        LB99  normal 1/2 rho d l Cd |Vn| Vn,  tangential f 1/2 rho d l Cd |Vt| Vt
        BM97  normal 1/2 rho d l Cd |V| Vn,   tangential 1/2 rho d l Cf |V| Vt
    """
    pressure = 0.5 * loading.density * loading.speed * loading.speed
    if loading.normal == 0.0 and loading.tangential == 0.0:
        return
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    bands, widths = structure.bar_band, structure.drag_diameter
    for bar in range(len(firsts)):
        exposed = 1.0 - share[bands[bar]]
        if widths[bar] == 0.0 or exposed == 0.0:
            continue
        first, second, image = firsts[bar], seconds[bar], images[bar]
        y, z = turned(position[second, 1], position[second, 2], image, rotations)
        dx = position[second, 0] - position[first, 0]
        dy = y - position[first, 1]
        dz = z - position[first, 2]
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        if length == 0.0:
            continue
        cosine = dx / length
        sine_squared = (dy * dy + dz * dz) / (length * length)
        scale = 0.5 * exposed * pressure * widths[bar] * length
        if loading.drag_law == LE_BRIS_1999:
            normal = scale * loading.normal * np.sqrt(sine_squared)
            tangential = scale * loading.normal * loading.tangential * abs(cosine)
        else:
            normal = scale * loading.normal
            tangential = scale * loading.tangential
        # V = Vn + Vt with Vt = c t; along x the normal part is 1 - c^2, across it is -c t
        across = (tangential - normal) * cosine / length
        force_x = normal * sine_squared + tangential * cosine * cosine
        force_y, force_z = across * dy, across * dz
        force[first, 0] += force_x
        force[first, 1] += force_y
        force[first, 2] += force_z
        add_turned_back(force, second, force_x, force_y, force_z, image, rotations)
