"""What it may change that second layers slide on the netting below, and that this stands out through their meshes.

The model holds a layer to the netting below (``bag.layers``). As a net of its own in contact without friction it
slides, and between its bars the netting below stands out in pillows, on whose slopes the sphere law reads another
pressure. Layers that can be are solved so beside (``layer_contact``), and the distance is told; else, with
``model.contact = false``, and where that comes to no rest, a law found on random layers
(``python -m validation.sliding_layers``). The answer stays that of the model: without friction layers come to rest in
more shapes than one, or in none, so that a series would leap from one model to the other.
"""

from collections.abc import Iterator

import numpy as np

from codend.bag.bag import Bag
from codend.bag.layer_measures import LayerRows, hoop_share_of_catch, measure_layers
from codend.bag.measures import Measures, measure_briefly
from codend.equilibrium.accuracy import SAFETY
from codend.equilibrium.bag_model import BagModel
from codend.equilibrium.layer_contact import FAR, NEAR, can_slide, in_contact
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
NEARLY_DRAWN, TOUCHING = 0.94, np.array([0.01, 0.01, 0.02, 0.02])
"""Share of their length to which bars of a layer are drawn without a pull, from which netting that stands out may touch
them, and what that is taken to change: of layers drawn to 0.9996 and less it changed 0.002, 0.003, 0.008 and 0.008
(``python -m validation.sliding_layers --seed 77``), where nothing was stated."""
IN_CONTACT = np.array([0.1, 0.08, 0.06, 0.1])
"""Of the same where layers were solved in contact, for the distance at which it begins and other shapes in which they
come to rest: with a third of it two of 14 nets had others outside, by up to 1.9."""


def changed_by_sliding(
    model: BagModel,
    case: Case,
    bag: Bag,
    problem: Problem,
    solution: Solution,
    measures: Measures,
    progress: Progress | None = None,
) -> tuple[Floats, Floats]:
    """What it changes if layers slide.

    Returns:
        largest changes of drag, volume, largest radius and opening ahead, N, m3, m and degrees, (4,): all 0 without
        layers and where none is near to carrying any load, that of the volume where the case gives it;
        these four as they are with the layers as nets of their own in contact, nan where that was not solved, (4,).
    """
    changed, slid = np.zeros(4), np.full(4, np.nan)
    if not bag.layers:
        return changed, slid
    layers = measure_layers(bag, problem, solution)
    carried = min(sum(largest_share(rows, solution.share) for rows in layers), 1.0)
    widest = max(part.stretched_radius_m for part in model.plan.netting)
    spare = max(1.0 - min(layer.stretched_radius_m for layer in bag.layers) / widest, 0.0)
    sizes = np.maximum(measures.estimated, [0.0, 0.0, 0.0, LEAST_OPENING_DEG])
    if carried == 0.0:
        if max(rows.drawn.max() for rows in layers) >= NEARLY_DRAWN:
            changed = TOUCHING * sizes
            changed[1] *= not case.gives_volume
        return changed, slid
    changed = carried * (BY_SLIDING + BY_SPARE_WIDTH * spare) * sizes
    if bag is model.bag and can_slide(model):
        shapes = list(_shapes_in_contact(model, case, problem, solution, progress))
        if shapes:
            slid, apart = shapes[0], np.abs(np.array(shapes) - measures.estimated).max(axis=0)
            changed = SAFETY * apart + carried * IN_CONTACT * sizes
    if case.gives_volume:
        changed[1] = 0.0
    return changed, slid


def _shapes_in_contact(
    model: BagModel, case: Case, problem: Problem, solution: Solution, progress: Progress | None
) -> Iterator[Floats]:
    """What is estimated of the shapes in which layers come to rest from near by and from afar, (4,) each."""
    for starts in (NEAR, FAR):
        found = in_contact(model, case, problem, solution, starts, progress)
        if found is not None and found[2].report.outcome.converged:
            yield np.array(measure_briefly(*found))


def largest_share(rows: LayerRows, share: Floats) -> float:
    """Largest share of a load that a layer carries: round the catch, and round or along the bag over any band."""
    on_the_catch = np.nan_to_num(hoop_share_of_catch(rows, share))
    return float(max(on_the_catch, rows.hoop_share.max(), rows.axial_share.max()))
