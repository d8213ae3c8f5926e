"""What the tension of the bars leaves out of balance of the loads: a kernel."""

import numpy as np

from codend.compiled import njit
from codend.mechanics.structure import Structure
from codend.net.net import Floats


@njit(cache=True)
def out_of_balance(structure: Structure, force: Floats, load: Floats, tension: float) -> tuple[float, float]:
    """Largest nodal residual and axial imbalance of the free nodes, over the sizes of what acts on the net.

    These are the sizes of the loads of all nodes, (n, 3), summed all round, and the mean tension of the bars: not the
    resultant, for loads may cancel, and a net may be tight without any.
    """
    largest, axial, size = 0.0, 0.0, 0.0
    free, order = structure.free, structure.order
    for node in range(len(force)):
        squares = 0.0
        for i in range(3):
            squares += free[node, i] * force[node, i] ** 2
        largest = max(largest, squares)
        axial += order * free[node, 0] * force[node, 0]
        size += np.sqrt(load[node, 0] ** 2 + load[node, 1] ** 2 + load[node, 2] ** 2)
    scale = order * size + tension
    if not np.isfinite(largest) or not np.isfinite(scale):
        return np.inf, np.inf
    if scale == 0.0:
        return (0.0, 0.0) if largest == 0.0 else (np.inf, np.inf)
    return np.sqrt(largest) / scale, abs(axial) / scale
