"""What the tension of the bars leaves out of balance of the loads: a kernel."""

import numpy as np

from codend.compiled import njit
from codend.mechanics.structure import Structure
from codend.net.net import Floats

CANCELLED = 1e-6
"""Resultant, over the sizes of loads and tensions, under which loads are said to cancel."""


@njit(cache=True)
def out_of_balance(structure: Structure, force: Floats, load: Floats, tension: float) -> tuple[float, float]:
    """Largest nodal residual and axial imbalance of the free nodes, each over its scale.

    The residual is taken over the sizes of the loads of all nodes, (n, 3), summed all round, and the mean tension of
    the bars: not over the resultant, for loads may cancel, and a net may be tight without any. The axial imbalance, the
    sum of all that is left over, is taken over the resultant, which is the drag of a towed net, unless loads cancel.
    """
    largest, axial, size = 0.0, 0.0, 0.0
    x, y, z = 0.0, 0.0, 0.0
    free, order = structure.free, structure.order
    for node in range(len(force)):
        squares = 0.0
        for i in range(3):
            squares += free[node, i] * force[node, i] ** 2
        largest = max(largest, squares)
        axial += order * free[node, 0] * force[node, 0]
        lx, ly, lz = load[node, 0], load[node, 1], load[node, 2]
        size += order * np.sqrt(lx * lx + ly * ly + lz * lz)
        x, y, z = x + order * lx, y + ly, z + lz
    # across the axis the loads of a sector's images cancel
    resultant = abs(x) if order > 1.0 else np.sqrt(x * x + y * y + z * z)
    scale = size + tension
    if not np.isfinite(largest) or not np.isfinite(scale):
        return np.inf, np.inf
    if largest == 0.0:
        return 0.0, 0.0
    return np.sqrt(largest) / scale, abs(axial) / (resultant if resultant > CANCELLED * scale else scale)
