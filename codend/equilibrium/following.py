"""What grows of an equilibrium, followed gently to shapes that are not the same all round.

A harmonic k of a ring of n sectors fits into a sector w of them wide where k w / n is whole. The narrowest that growing
harmonics fit are followed, each started along its growing shape, and the widest of them once more shaken; what still
grows of a shape is followed on in a wider one. Where only the whole net has room and has too many knots, a merged net
takes its place. Where layers of netting meet, the start is followed once more with contact between them, if the plan
has it so; else following stops there.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import gcd

import numpy as np

from codend.bag.bag import Bag
from codend.bag.loads import problem_of
from codend.bag.measures import Measures, measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.stability import Stability, stability_of
from codend.equilibrium.start_shapes import all_round_start
from codend.mechanics.contact import add_force
from codend.mechanics.problem import Problem
from codend.mechanics.surface import ContactLaw, Surface
from codend.net.net import Floats, rotate
from codend.plan.plan import Case
from codend.solvers import gentle, newton
from codend.solvers.clock import Clock
from codend.solvers.gentle import End, Motion
from codend.solvers.harmonics import Growth
from codend.solvers.outcome import Progress, Solution
from codend.solvers.refusal import passage

MOST_KNOTS = 3000
"""Of a sector that is followed, or of the whole net: some seconds a shape."""
WIDTHS = 3
"""Narrowest sectors that are followed."""
MOST_WIDENINGS = 2
"""How often what still grows of a shape is followed on in a wider one."""
CONTACT_STEPS = 250
CONTACT_BEGINS_M, OF_A_BAR = 2e-3, 0.05
"""Distance at which contact begins, at most, and over the shortest bar: where the codline gathers netting it is no
farther apart than that before it touches."""
PUSH = 0.1
"""What layers press on each other with at half of that distance, over 1.2 and the mean tension of the bars."""
ALONG, SHAKEN = 0.05, 0.01
"""Largest move along a growing shape, and moves at random, to start with, over a bar."""
COVERING = 3.0
"""What wrinkles change, at most, over what was found: the shapes found are some of many."""


@dataclass(frozen=True)
class Shape:
    """A shape that was found, on its model."""

    model: BagModel
    problem: Problem
    solution: Solution
    stability: Stability
    measures: Measures
    meshes: int
    """Real meshes that the sector is wide."""
    harmonic: int
    """Harmonic that was followed to it."""


@dataclass(frozen=True)
class Followed:
    """What became of an equilibrium of which something grows."""

    shape: Shape | None
    """The shape that stands in its place, that of the narrowest sector; None where none does."""
    reason: str
    """Why it does, or why none does, and how wide the sector is, in words."""
    drag_spread_n: float
    """Largest drag less least over the shapes that were found; nan where none was."""
    opening_spread_deg: float
    folds: bool
    """Whether layers of netting met."""
    changed: Floats
    """What wrinkles change at most, by the shapes that were found: drag, volume, largest radius and opening ahead."""
    spent_ms: float
    contact_share: float = float("nan")
    """Share of the knots of the shape that stands which other netting presses on; nan without contact."""


LYING_ON_ITSELF = "netting lies on netting in this shape: contact is not modelled"
NOT_FOLLOWED = Followed(None, "", float("nan"), float("nan"), False, np.zeros(4), 0.0)


def follow(
    model: BagModel,
    case: Case,
    problem: Problem,
    solution: Solution,
    stability: Stability,
    progress: Progress | None = None,
) -> Followed:
    """Follow what grows of an equilibrium from a few starts."""
    if len(model.bag.ropes):
        return replace(NOT_FOLLOWED, reason="not followed: ropes along the netting have no place in wider sectors yet")
    if model.bag.layer_bands:
        return replace(NOT_FOLLOWED, reason="not followed: second layers have no place in wider sectors yet")
    if model.near is not None:
        return replace(NOT_FOLLOWED, reason='not followed: fidelity = "sector" asks for the exact ratio of the counts')
    with Clock() as clock:
        base, merged = (model, solution, stability, problem), ""
        if not list(_fitting(model, stability)):
            other = _merged(model, case)
            if other is None:
                reason = f"not followed: the sector that a growing harmonic fits has more than {MOST_KNOTS} knots"
                return replace(NOT_FOLLOWED, reason=reason)
            base, g = other, other[0].globalisation
            merged = f", {g} x {g} meshes merged into one, for the whole net has more than {MOST_KNOTS} knots"
        run = _Following(case, progress)
        run.pursue(*base, MOST_WIDENINGS)
        spent_ms = clock.ms
    at_rest = measure_all(base[0].bag, base[3], base[1])[2]
    return _told(run, at_rest, merged, spent_ms)


class _Following:
    """The shapes that are found on the way."""

    def __init__(self, case: Case, progress: Progress | None) -> None:
        self.case, self.progress = case, progress
        self.shapes: list[Shape] = []
        self.touching, self.lost = 0, 0
        self.in_contact = False
        """Whether contact was tried."""

    def pursue(
        self, model: BagModel, solution: Solution, stability: Stability, problem: Problem, widenings: int
    ) -> None:
        """Follow what grows of an equilibrium, and what then still grows of that."""
        for wide, sectors, growth, start in _starts(model, self.case, solution, stability):
            wide_problem = problem_of(wide.bag, wide.plan, self.case)
            tolerance = model.plan.model.tolerance
            motion = gentle.follow(wide_problem, tolerance, start, wide.prepared, self.progress)
            if motion.end is End.TOUCHING and wide.plan.model.contact is True:
                self.in_contact = True
                wide_problem, motion = self._under_contact(wide, wide_problem, start, motion)
            if motion.end is not End.SETTLED:
                self.touching += motion.end is End.TOUCHING
                self.lost += motion.end is End.STEPS_SPENT
                continue
            shape = self._shape(wide, wide_problem, motion, growth)
            if shape.stability.stable == "no" and widenings > 0 and sectors > 1:
                before = len(self.shapes)
                self.pursue(wide, motion.solution, shape.stability, wide_problem, widenings - 1)
                if len(self.shapes) > before:
                    continue
            self.shapes.append(shape)

    def _under_contact(
        self, model: BagModel, problem: Problem, start: Solution, before: Motion
    ) -> tuple[Problem, Motion]:
        """The problem with contact and where it leads from a start; as before where the start itself is pierced."""
        begins = min(CONTACT_BEGINS_M, OF_A_BAR * float(problem.structure.length.min()))
        law = ContactLaw(begins, PUSH * float(start.bar_tension.mean()) / begins)
        touching = replace(problem, surface=Surface.of(problem.net, law))
        if passage(touching, start.positions) is not None:
            return problem, before
        tolerance = model.plan.model.tolerance
        motion = gentle.follow(touching, tolerance, start, model.prepared, self.progress, CONTACT_STEPS)
        if motion.end is not End.SETTLED:
            return problem, before
        return touching.touching_at(motion.solution.positions), motion

    def _shape(self, model: BagModel, problem: Problem, motion: Motion, growth: Growth) -> Shape:
        tangent = newton.tangent_at(problem, motion.solution, model.prepared)
        return Shape(
            model,
            problem,
            motion.solution,
            stability_of(model, tangent),
            measure_all(model.bag, problem, motion.solution)[2],
            meshes_wide(model.bag, max(max(part.open_meshes) for part in model.plan.netting)),
            growth.harmonic,
        )


def in_contact_share(problem: Problem, solution: Solution) -> float:
    """Share of the knots that other netting presses on; nan without contact."""
    if problem.surface is None:
        return float("nan")
    force = np.zeros_like(solution.positions)
    add_force(solution.positions, problem.loading.contact, force)
    pressed = np.linalg.norm(force, axis=1) > 1e-6 * float(solution.bar_tension.mean())
    return float(pressed.mean())


def meshes_wide(bag: Bag, meshes_round: int) -> int:
    """Real meshes that a bag's sector is wide, of so many round."""
    return round(meshes_round / bag.net.order)


def _fitting(model: BagModel, stability: Stability) -> Iterator[tuple[int, Growth]]:
    """The narrowest sectors that growing harmonics fit, over the model's own width, each with the strongest of them."""
    order = model.bag.net.sectors
    fitting: dict[int, Growth] = {}
    for growth in sorted(stability.growths, key=lambda growth: growth.eigenvalues[0].real):
        fitting.setdefault(order // gcd(order, growth.harmonic), growth)
    knots = len(model.bag.net.positions) - 1
    for width in sorted(fitting)[:WIDTHS]:
        if width * knots <= MOST_KNOTS:
            yield width, fitting[width]


def _starts(
    model: BagModel, case: Case, solution: Solution, stability: Stability
) -> Iterator[tuple[BagModel, int, Growth, Solution]]:
    """Models so many sectors wide, what grows there, and where to start: along it, and of the widest shaken as well."""
    order, sectors = model.bag.net.sectors, model.sectors
    fitting = list(_fitting(model, stability))
    if not fitting:
        return
    for width, growth in fitting:
        wide = model
        if width > 1:
            wide = model_of(model.plan, model.globalisation, (sectors or 1) * width)
        start = all_round_start(model.bag, solution.positions, solution.bar_tension, width)
        bar = float(np.median(wide.bag.net.bar_length))
        free = ~wide.bag.net.fixed
        turn = np.exp(2j * np.pi * growth.harmonic * np.arange(width) / order)
        moves = (growth.shape[:-1, None] * turn[None, :, None]).real
        along = rotate(moves, np.arange(width)[None], order).reshape(-1, 3)
        along = np.concatenate([along, growth.shape[-1:].real]) * free
        yield wide, order, growth, _moved(start, ALONG * bar / np.linalg.norm(along, axis=1).max() * along)
    shake = np.random.default_rng(case.number).standard_normal(start.positions.shape)
    yield wide, order, growth, _moved(start, SHAKEN * bar * shake * free)


def _moved(start: Solution, by: Floats) -> Solution:
    return replace(start, positions=start.positions + by)


def _merged(model: BagModel, case: Case) -> tuple[BagModel, Solution, Stability, Problem] | None:
    """A sector of the net with the fewest meshes merged of which something grows that can be followed; None if none."""
    for g in model.plan.globalisations:
        if g <= model.globalisation:
            continue
        sector = model_of(model.plan, g, 1)
        problem, solution = equilibrium.solve(sector, case, (), None)
        if not solution.report.outcome.converged:
            continue
        stability = stability_of(sector, newton.tangent_at(problem, solution, sector.prepared))
        if list(_fitting(sector, stability)):
            return sector, solution, stability, problem
    return None


def _told(run: _Following, at_rest: Measures, merged: str, spent_ms: float) -> Followed:
    """What the shapes found amount to."""
    values = np.array([shape.measures.estimated for shape in run.shapes]).reshape(-1, 4)
    all_values = np.concatenate([values, [at_rest.estimated]])
    spread = np.ptp(values, axis=0) if len(values) else np.full(4, np.nan)
    found = Followed(
        None, "", float(spread[0]), float(spread[3]), False, COVERING * np.ptp(all_values, axis=0), spent_ms
    )
    if run.touching:
        why = "no shape in contact was found" if run.in_contact else "contact is not modelled"
        reason = f"followed{merged} until layers of netting met: {why}, the symmetric shape stands"
        return replace(found, reason=reason, folds=True)
    if not run.shapes:
        return replace(found, reason=f"followed{merged}, but to no shape in balance: the symmetric shape stands")
    shape = min(run.shapes, key=lambda shape: (shape.stability.stable != "yes", shape.meshes))
    where = "in the whole net" if shape.model.bag.net.order == 1 else f"in a sector {shape.meshes} meshes wide"
    reason = f"followed {where}{merged}, the narrowest that harmonic {shape.harmonic} fits, which grows"
    if shape.model.bag.net.order == 1 and shape.harmonic == 0:
        reason = f"followed {where}{merged}, from which something grows"
    share = in_contact_share(shape.problem, shape.solution)
    if shape.problem.surface is not None:
        reason += ", with contact between layers"
    return replace(found, shape=shape, reason=reason, folds=share > 0.0, contact_share=share)
