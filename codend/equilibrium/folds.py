"""Netting in folds: the contact between its layers, a start that nothing pierces, and how much lies in folds."""

from dataclasses import replace

import numpy as np

from codend.equilibrium.bag_model import BagModel
from codend.mechanics.contact import add_force
from codend.mechanics.problem import Problem
from codend.mechanics.rings import Rings
from codend.mechanics.surface import ContactLaw, Surface
from codend.net.net import Floats, rotate
from codend.plan.plan import Plan
from codend.solvers import gentle
from codend.solvers.dynamic_relaxation import as_built
from codend.solvers.gentle import End, Motion
from codend.solvers.outcome import Progress, Solution
from codend.solvers.refusal import passage

STEPS = 400
"""Gentle steps allowed: of T90 codends of 100 meshes round most take 50 to 150, wide sectors up to 300."""
LEAST_STEPS = 60
"""Fewer are not worth a start."""
BEGINS_M, OF_A_BAR = 2e-3, 0.05
"""Distance at which contact begins, at most, and over the median bar: halving it moves drag by 0.04 %, openings by
0.02 degrees, and takes longer. It is not the twine's thickness: where a codline gathers netting the start already has
layers nearer to each other."""
PUSH = 0.12
"""What layers press on each other with at half of that distance, over the mean tension of the bars."""
HALVINGS = 4
"""Most halvings of a first move that would push netting through netting."""


def contact_law(problem: Problem, solution: Solution) -> ContactLaw:
    """How layers of a net press on each other, by its bars and their tension."""
    begins = min(BEGINS_M, OF_A_BAR * float(np.median(problem.structure.length)))
    return ContactLaw.pressing(begins, PUSH * float(solution.bar_tension.mean()))


def follow_under_contact(
    model: BagModel,
    problem: Problem,
    rest: Solution,
    start: Solution,
    progress: Progress | None,
    steps_allowed: int = STEPS,
) -> tuple[Problem, Motion] | None:
    """The problem with contact, and where a start, moved from a shape at rest, leads; None where that is pierced."""
    touching = replace(problem, surface=Surface.of(problem.net, contact_law(problem, start)))
    for _ in range(HALVINGS + 1):
        if passage(touching, start.positions) is None:
            break
        start = replace(start, positions=0.5 * (start.positions + rest.positions))
    else:
        return None
    tolerance = model.plan.model.tolerance
    motion = gentle.follow(touching, tolerance, start, model.prepared, progress, steps_allowed, rest.positions)
    if motion.end is not End.SETTLED:
        return touching, motion
    return touching.touching_at(motion.solution.positions), motion


def under_weight(problem: Problem) -> Solution:
    """The shape in which a net was built, every bar with a tension that bears the net's weight, or its loads if more.

    In a crude bag, drawn out along the axis, nothing lies on anything.
    """
    start = as_built(problem)
    borne = float(np.abs(problem.loading.dead).sum() / (2.0 * problem.loading.catch.row_size.max()))
    return replace(start, bar_tension=np.maximum(start.bar_tension, borne))


def is_pierced(problem: Problem, solution: Solution) -> bool:
    """Whether the surface that contact acts on lies through itself, be it by less than an answer is refused for."""
    touching = replace(problem, surface=Surface.of(problem.net, contact_law(problem, solution)))
    return passage(touching, solution.positions) is not None


def limp_of(plan: Plan) -> Plan:
    """The plan with netting that does not resist opening."""
    limp = [part.model_copy(update={"bending_stiffness_n_m2": 0.0}) for part in plan.netting]
    return plan.model_copy(update={"netting": type(plan.netting)(limp)})


def contact_pushes(problem: Problem, solution: Solution) -> Floats:
    """What other netting pushes each knot with, N, (n,); their sum depends on the model of contact."""
    force = np.zeros_like(solution.positions)
    add_force(solution.positions, problem.loading.contact, force)
    return np.asarray(np.linalg.norm(force, axis=1))


def in_contact_share(problem: Problem, solution: Solution) -> float:
    """Share of the knots that other netting presses on; nan without contact."""
    if problem.surface is None:
        return float("nan")
    return float((contact_pushes(problem, solution) > 1e-6 * float(solution.bar_tension.mean())).mean())


def fold_count(positions: Floats, rings: Rings, order: float) -> int:
    """Most folds of any ring of knots, all round: places where it runs back about its middle and then on again."""
    most = 0
    for first, last in zip(rings.start[:-1], rings.start[1:], strict=True):
        node, image = rings.node[first:last], rings.image[first:last]
        if len(node) * order < 3:
            continue
        place = rotate(positions[node], image.astype(np.int32), order)[:, 1:]
        place = place - place.mean(axis=0) if order == 1.0 else place
        azimuth = np.arctan2(place[:, 1], place[:, 0])
        step = np.diff(azimuth, append=azimuth[0] + 2.0 * np.pi / order)
        back = (step + np.pi) % (2.0 * np.pi) - np.pi < -BACKWARD / len(node)
        most = max(most, round(order * np.count_nonzero(back & ~np.roll(back, 1))))
    return most


BACKWARD = 1e-3
"""Azimuth by which a ring runs back, rad times its knots in a sector, from which that is a fold."""
