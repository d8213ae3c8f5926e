"""What the tension of the bars leaves out of balance of the loads: a kernel."""

import numpy as np

from codend.compiled import njit
from codend.mechanics.structure import Structure
from codend.net.net import Floats


@njit(cache=True)
def out_of_balance(structure: Structure, force: Floats, load: Floats) -> tuple[float, float]:
    """Largest nodal residual and axial imbalance of the free nodes, both over the resultant of the loads."""
    largest, axial = 0.0, 0.0
    x, y, z = 0.0, 0.0, 0.0
    free, order = structure.free, structure.order
    for node in range(len(force)):
        squares = 0.0
        for i in range(3):
            squares += free[node, i] * force[node, i] ** 2
        largest = max(largest, squares)
        axial += order * free[node, 0] * force[node, 0]
        x, y, z = x + order * load[node, 0], y + load[node, 1], z + load[node, 2]
    # across the axis the loads of a sector's images cancel
    resultant = abs(x) if order > 1.0 else np.sqrt(x * x + y * y + z * z)
    if not np.isfinite(largest) or not np.isfinite(resultant):
        return np.inf, np.inf
    if resultant == 0.0:
        return (0.0, 0.0) if largest == 0.0 else (np.inf, np.inf)
    return np.sqrt(largest) / resultant, abs(axial) / resultant
