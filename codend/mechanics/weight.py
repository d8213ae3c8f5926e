"""Wet weight of the bars, and what else pulls at the nodes with the same force wherever they are."""

import numpy as np

from codend.net.net import Floats, Net

GRAVITY_M_S2 = 9.80665


def wet_weight(net: Net, water_density: float) -> Floats:
    """Nodal forces in N of the weight in water of bars, half to each end, and points, (n, 3)."""
    volume = 0.25 * np.pi * net.bar_solid_diameter**2 * net.bar_length
    lighter = net.bar_density - water_density
    lighter[np.isnan(lighter)] = 0.0
    half = -0.5 * GRAVITY_M_S2 * lighter * volume
    force = np.zeros_like(net.positions)
    force[:, 2] += np.bincount(net.bars.ravel(), np.repeat(half, 2), len(force))
    np.add.at(force[:, 2], net.point_node, -net.point_wet_weight)
    return force
