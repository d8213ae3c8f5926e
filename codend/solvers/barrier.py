"""A barrier that keeps twine taut: with b its height a bar of force density q is longer by b / q in its law.

It adds b / q^2 to what a bar strains per newton, and a step may go as far as the first density falls to nothing
(``mechanics.newton_state``): for sheets that hang slack and bodies that float.
"""

import numpy as np

from codend.mechanics.structure import Structure
from codend.net.net import Floats


def softened(structure: Structure, density: Floats, barrier: float) -> Structure:
    """The structure with twine as soft as the barrier makes it to a step from force densities (m,)."""
    if barrier == 0.0:
        return structure
    yielding = np.where(structure.is_strut, 0.0, barrier / density**2)
    return structure._replace(flexibility=structure.flexibility + yielding)


def share_to_slack(structure: Structure, density: Floats, change: Floats) -> float:
    """Share of a change of force densities, (m,), after which the first twine has none; infinite if none loses any."""
    falling = ~structure.is_strut & (change < 0.0)
    return float(np.min(-density[falling] / change[falling], initial=np.inf))
