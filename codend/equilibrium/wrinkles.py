"""What wrinkles may change of an equilibrium that is the same all round, by the strength of what grows there.

The strength of a growth is the size of its eigenvalue over a bar's stiffness under tension. The law was found on nets
that were shaken and followed gently (``python -m validation.shaken``): changes rise about as the root of the
strength, up to ``STRONGEST``, beyond which they do not rise any more. Openings ahead of the catch change where the
growth moves the rows there, and with the drag. Where a bag swings on its hoop the strength tells nothing.
"""

import numpy as np

from codend.bag.bag import Bag
from codend.bag.measures import Measures, opening_rows_ahead
from codend.equilibrium.accuracy import FEW_ROUND, Errors
from codend.equilibrium.stability import Stability
from codend.net.net import Floats
from codend.plan.plan import Case, Plan
from codend.solvers.outcome import Solution

SWINGS = 0.1
"""Sideways move of the codline, over the largest of all, from which what grows swings the bag on its hoop."""
BY_SWINGING = np.array([0.04, 0.02, 0.02, 0.17])
"""Relative change of drag, volume, largest radius and opening ahead where it swings, however weakly that grows: it goes
as far as the hoop lets it. Bags of diamond and T90 netting changed by up to 0.029, 0.016, 0.017 and 0.119
(``python -m validation.swinging``)."""
SWAYS = 0.15
"""Stiffness of the codline against moves aside, over the drag over the length as a pendulum has it, up to which a bag
that tips (``Kind.tips``) may hang aside though its symmetric shape is stable. Pushed and let go, 15 of some 150 stable
bags of square mesh hung aside for good, of up to 0.104 (``python -m validation.pushed``, seeds 40 to 47); others came
back, of diamond and T90 netting all, however easily they swayed."""
ASIDE = np.array([0.15, 0.07, 0.3, 0.17])
"""Relative change of drag, volume, largest radius and opening of bags that tip where they swing or may hang aside: up
to 0.113, 0.035, 0.23 and 0.109."""
SWINGING_OF_FEW, ASIDE_OF_FEW = np.array([0.16, 0.02, 0.03, 0.17]), np.array([0.3, 0.07, 0.3, 0.3])
"""The same of bags of fewer than ``FEW_ROUND`` meshes round: those of diamond and T90 netting of 5 to 10 changed by up
to 0.109, 0.004, 0.011 and 0.100, those of square mesh by up to 0.221, 0.013, 0.111 and 0.206
(``python -m validation.swinging --few``, seed 50)."""
FILLED, SWINGING_FILLED = 0.8, np.array([1.0, 0.02, 0.03, 0.17])
"""Share of the meshes from which a bag counts as filled to its hoop, and the same of such bags of diamond and T90
netting: their drag is that of all of the catch, which way it points. Of 9 filled by 0.8 and more it changed by up to
0.25, of one of stiff twine by 0.76; of square mesh by up to 0.24, as of few meshes round. Of 76 of 6 to 10 meshes, none
used, limp ones changed by up to 0.23, those of square mesh by 0.14, all by at most 0.46 of what is told
(``python -m validation.swinging --few --filled --plans 80 --seed 63``)."""
STIFF, SWINGING_STIFF = 0.5, np.array([0.16, 0.08, 0.03, 0.35])
"""Pull that closes the mean mesh against its twine, over the mean tension, from which twine counts as stiff, and the
same of such bags, which bend as they swing: of 12 to 16 meshes round, filled by 0.45 to 0.78, by up to 0.105, 0.052,
0.003 and 0.20 (``python -m validation.shaken``, seeds 5200 to 5259 and 6000 to 6350), where others were outside."""
STRONGEST = 50.0
BY_STRENGTH = np.array([0.04, 0.35, 0.036, 0.004])
"""Relative change of drag, volume, largest radius and opening ahead, over the root of the strength. With 0.2 and 0.03
in volume and radius two of 18 nets of ``shaken --nets 60 --seed 2000`` were outside, by up to 1.51 and 1.02: before
gentle steps let weak growths go, shaken nets had come back."""
FEW_MESHES, FEW_OF_VOLUME = 1.2, 4.0
"""Filled meshes under which all that changes more, in proportion: few rows share it. One of these nets, of 0.87, was
outside in drag by 1.10. Volume changes more by the second besides: bags of stiff diamond netting with 0.15 and 1.15
meshes filled, which close to next to nothing, held 33 and 7 times as much in waves."""
BY_REACH = np.array([0.0, 0.0, 0.4])
"""Relative change of drag, volume and largest radius over the reach: the root of the strength times the largest move of
a knot in the rows ahead, over the largest of all."""
OPENING_BY_REACH_DEG = 44.0
LEAST_SIZES = np.array([0.0, 0.0, 0.0, 1.0])
"""Sizes that changes are at least taken of: meshes all but shut open by parts of a degree as well. Under a tight layer
T90 meshes of 0.005 degrees changed by three times a bound that was in proportion to that."""
CONTACT = 0.25, 0.05
"""Strength and reach that netting which lies on netting counts as at least: those of a T90 codend of 100 meshes round
that, followed with contact between its layers, changed by 0.6 % in drag and 1.8 degrees in opening."""
MORE_IN_CONTACT = 1.7
"""Factor on all changes where netting lies on netting: with it the changes of 20 codends of the commercial matrix that
were followed (``python -m validation --only wrinkles``) are at most 0.91 of them; with 1.4 one of stiff T90 netting,
which came to another of its shapes as steps under contact grew longer, was outside in drag by 1.10."""


def changed_by_wrinkles(
    bag: Bag, case: Case, solution: Solution, stability: Stability, measures: Measures, touching: bool
) -> Floats:
    """Largest changes of drag, volume, largest radius and opening ahead by wrinkles, N, m3, m and degrees, (4,).

    All 0 where nothing grows, no netting lies on netting (``touching``) and the bag cannot hang aside; the most that
    may be where it is not known what grows, nan where nothing is known of that.
    """
    unknown = stability.stable == "unknown"
    if unknown and np.isnan(stability.at_most):
        return np.full(4, np.nan)
    aside = may_hang_aside(stability, measures)
    if not stability.growths and not touching and not unknown:
        return measures.estimated * _swung(bag, solution, measures) if aside else np.zeros(4)
    strength, reach = CONTACT if touching else (0.0, 0.0)
    swings, own = False, 0.0
    ahead, codline = _knots_ahead(bag, solution.share), -1 - bag.anchors
    for growth in stability.growths:
        own = min(-float(growth.eigenvalues[0].real) / stability.scale, STRONGEST)
        moved = np.abs(growth.shape).max(axis=1)
        strength = max(strength, own)
        swings |= bool(np.linalg.norm(growth.shape[codline, 1:]) >= SWINGS * moved.max())
        reach = max(reach, float(np.sqrt(own) * moved[ahead].max(initial=0.0) / moved.max()))
    if unknown:
        own = min(stability.at_most / stability.scale, STRONGEST)
        strength = max(strength, own)
    if not stability.complete:
        # what was not found grows less than all that was, but may swing the bag, and reach any row
        swings, reach = True, max(reach, float(np.sqrt(own)))
    sizes = np.maximum(measures.estimated, LEAST_SIZES)
    few, of_volume = (max(1.0, meshes / measures.filled_meshes) for meshes in (FEW_MESHES, FEW_OF_VOLUME))
    changed = sizes * BY_STRENGTH * np.sqrt(strength) * [few, few * of_volume, few, few]
    changed[:3] += sizes[:3] * BY_REACH * reach
    changed[3] += OPENING_BY_REACH_DEG * reach
    if swings or aside:
        changed += sizes * _swung(bag, solution, measures)
    if touching:
        changed *= MORE_IN_CONTACT
    if case.gives_volume:
        changed[1] = 0.0
    return changed


def _swung(bag: Bag, solution: Solution, measures: Measures) -> Floats:
    """What a swing on the hoop changes at most, relative, (4,)."""
    filled = measures.filled_meshes >= FILLED * bag.row_place[-1]
    if bag.tips:
        return ASIDE_OF_FEW if filled or _is_of_few(bag) else ASIDE
    law = SWINGING_FILLED if filled else SWINGING_OF_FEW if _is_of_few(bag) else BY_SWINGING
    stiff = bag.band_bending_n.mean() > STIFF * solution.mean_tension / bag.globalisation
    return np.maximum(law, SWINGING_STIFF) if stiff else law


def _is_of_few(bag: Bag) -> bool:
    """Whether any row of meshes, as they are modelled, is of fewer than ``FEW_ROUND`` round."""
    knots = float(bag.ring_size[:-1].min()) * bag.net.sectors
    # each knot of turned netting is two nodes of a ring
    return knots < FEW_ROUND * (2.0 if bag.turned else 1.0)


def may_hang_aside(stability: Stability, measures: Measures) -> bool:
    """Whether a bag may hang aside of its hoop as well as where it was found, stable there or not."""
    return bool(stability.sway_n_m * measures.length_m < SWAYS * measures.drag_n)


def within_accuracy(plan: Plan, measures: Measures, errors: Errors) -> bool:
    """Whether estimates are within the accuracy that a plan asks for in drag and, where it does, in opening."""
    asked_deg = plan.model.opening_accuracy_deg
    if asked_deg is not None and not errors.opening_ahead_error_deg <= asked_deg:
        return False
    return errors.drag_error_n <= plan.model.accuracy * measures.drag_n


def _knots_ahead(bag: Bag, share: Floats) -> Floats:
    """Numbers of the knots of the rows over which ``opening_ahead_deg`` is the mean."""
    middles = opening_rows_ahead(bag, share)
    if len(middles) == 0:
        return np.zeros(0, dtype=int)
    ring = np.flatnonzero(bag.node_row >= 0)
    place = bag.row_place[bag.node_row[ring]]
    return ring[(place >= middles.min() - 0.5) & (place <= middles.max() + 0.5 + 1e-9)]
