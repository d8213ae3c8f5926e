"""What the supports of a bag carry, and whether the entry's alone balance its loads.

Only the hoop at the entry holds a bag. A support anywhere else that carries something is one that no gear supplies: it
shows in the balance of the whole bag, which counts the reactions of the entry and no others.
"""

import numpy as np
from numpy.typing import NDArray

from codend.bag import measure_kernels
from codend.bag.bag import Bag
from codend.net.net import Floats


def held_by_the_entry(bag: Bag) -> NDArray[np.bool_]:
    """Nodes that the hoop at the entry holds, (n,)."""
    held = bag.net.fixed.all(axis=1) & (bag.node_row == 0)
    held[len(held) - bag.anchors :] = True
    return np.asarray(held)


def sideways_imbalance(bag: Bag, positions: Floats, load: Floats, support: Floats) -> float:
    """What the loads of a bag and the reactions of its entry leave over across the axis and as a moment, relative.

    The larger of the force across the axis over the resultant load, and of the moment about the middle of the entry
    over that times the bag's reach from there. Over the images of a sector all cancel but the moment about the axis.
    """
    entry = held_by_the_entry(bag)
    return float(measure_kernels.sideways_imbalance(positions, load, support, entry, float(bag.net.order)))
