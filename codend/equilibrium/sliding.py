"""What it may change that second layers slide on the netting below, and that this stands out through their meshes.

The model holds a layer to the netting below (``bag.layers``). As a net of its own in contact without friction it
slides, and between its bars the netting below stands out in pillows, on whose slopes the sphere law reads another
pressure. A layer that can be is solved so beside (``layer_contact``), and the distance is told; else, with
``model.contact = false``, and where that comes to no rest, a law found on random layers
(``python -m validation.sliding_layers``).
"""

import numpy as np

from codend.bag.bag import Bag
from codend.bag.layer_measures import LayerRows, hoop_share_of_catch, measure_layers
from codend.bag.measures import Measures, measure_briefly
from codend.equilibrium.accuracy import SAFETY
from codend.equilibrium.bag_model import BagModel
from codend.equilibrium.layer_contact import can_slide, in_contact
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.plan.plan import Case
from codend.solvers.outcome import Progress, Solution

BY_SLIDING = np.array([0.3, 0.5, 0.22, 0.8])
"""Relative change of drag, volume, largest radius and opening ahead of the catch under a layer that carries all of a
load, round or along the bag. Of 229 random nets whose layers carry changes in contact were at most 0.89 of what is
stated where the law was found; on 128 others (``--seed 6``, and 7 by volume) at most 0.93."""
BY_SPARE_WIDTH = np.array([2.0, 0.6, 0.35, 0.0])
"""And what is more of it by the share by which the layer is narrower than the netting below, both pulled fully open."""
LEAST_OPENING_DEG = 10.0
"""Opening that its change is at least taken of: shut meshes under layers open by degrees, too."""
IN_CONTACT = np.array([0.02, 0.02, 0.02, 0.03])
"""Of the same by the distance at which contact begins, where a layer was solved in contact."""


def changed_by_sliding(
    model: BagModel,
    case: Case,
    bag: Bag,
    problem: Problem,
    solution: Solution,
    measures: Measures,
    progress: Progress | None = None,
) -> Floats:
    """Largest changes of drag, volume, largest radius and opening ahead if layers slide, N, m3, m and degrees, (4,).

    All 0 without layers and where none carries any load; that of the volume where the case gives it.
    """
    if not bag.layers:
        return np.zeros(4)
    layers = measure_layers(bag, problem, solution)
    carried = min(sum(largest_share(rows, solution.share) for rows in layers), 1.0)
    widest = max(part.stretched_radius_m for part in model.plan.netting)
    spare = max(1.0 - min(layer.stretched_radius_m for layer in bag.layers) / widest, 0.0)
    if carried == 0.0:
        return np.zeros(4)
    sizes = np.maximum(measures.estimated, [0.0, 0.0, 0.0, LEAST_OPENING_DEG])
    changed = carried * (BY_SLIDING + BY_SPARE_WIDTH * spare) * sizes
    if bag is model.bag and can_slide(model):
        found = in_contact(model, case, problem, solution, progress)
        if found is not None and found[2].report.outcome.converged:
            apart = np.abs(measure_briefly(*found) - measures.estimated)
            changed = SAFETY * apart + carried * IN_CONTACT * sizes
    if case.gives_volume:
        changed[1] = 0.0
    return changed


def largest_share(rows: LayerRows, share: Floats) -> float:
    """Largest share of a load that a layer carries: round the catch, and round or along the bag over any band."""
    on_the_catch = np.nan_to_num(hoop_share_of_catch(rows, share))
    return float(max(on_the_catch, rows.hoop_share.max(), rows.axial_share.max()))
