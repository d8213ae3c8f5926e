"""What grows of an equilibrium, followed gently to shapes that are not the same all round.

A harmonic k of a ring of n sectors fits into a sector w of them wide where k w / n is whole. The narrowest that growing
harmonics fit are followed, each started along its growing shape, and the widest of them once more shaken; what still
grows of a shape is followed on in a wider one. Where only the whole net has room and has too many knots, a merged net
takes its place. Where layers of netting meet, the start is followed once more with contact between them, unless the
plan forbids it: following stops there then.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from math import gcd

import numpy as np

from codend.bag.bag import Bag
from codend.bag.loads import problem_of
from codend.bag.measures import Measures, measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.folds import (
    LEAST_STEPS,
    STEPS,
    fold_count,
    follow_under_contact,
    in_contact_share,
    is_pierced,
    limp_of,
)
from codend.equilibrium.stability import Stability, stability_of, tangent_of
from codend.equilibrium.start_shapes import all_round_start
from codend.mechanics.problem import Problem
from codend.net.net import Floats, rotate
from codend.plan.plan import Case, Plan
from codend.solvers import gentle
from codend.solvers.clock import Clock
from codend.solvers.gentle import End, Motion
from codend.solvers.harmonics import Growth
from codend.solvers.outcome import Progress, Solution

MOST_KNOTS = 3000
"""Of a sector that is followed, or of the whole net: some seconds a shape."""
WIDTHS = 3
"""Narrowest sectors that are followed."""
MOST_WIDENINGS = 2
"""How often what still grows of a shape is followed on in a wider one."""
ALONG, SHAKEN = 0.05, 0.01
"""Largest move along a growing shape, and moves at random, to start with, over a bar."""
COVERING = 3.0
"""What wrinkles change, at most, over what was found: the shapes found are some of many."""
SWUNG = 0.1
"""Of how far a bag swings on its hoop, what is told as well: whichever way it swings it hangs alike."""
ENOUGH_SHAPES = 3
"""Shapes in contact whose spread is the error of the one that lasts among them."""
WORK: dict[object, int] = {"auto": 500_000, True: 2_000_000}
"""Gentle steps under contact times knots, over all starts, by ``model.contact``: a thousand take some 0.05 s."""
INNER_LAYERS = np.array([5e-4, 5e-4, 5e-4, 0.0]), np.array([0.0, 0.0, 0.0, 0.3])
"""What it changes whether the pressure of the catch acts on the inner layers of a fold, which it does here: share of
drag, volume and radius, and opening in degrees (a prototype's, on a T90 codend of 100 meshes round)."""


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

    @property
    def growth(self) -> tuple[bool, float]:
        """Whether it is not known to last, and how strongly it grows, over a bar's stiffness under tension."""
        strengths = [-float(growth.eigenvalues[0].real) / self.stability.scale for growth in self.stability.growths]
        return self.stability.stable != "yes", max(strengths, default=0.0)


@dataclass(frozen=True)
class Followed:
    """What became of an equilibrium of which something grows."""

    shape: Shape | None
    """The shape that stands in its place, one that lasts, of the narrowest sector; None where none does."""
    reason: str
    """Why it does, or why none does, and how wide the sector is, in words."""
    drag_spread_n: float
    """Largest drag less least over the shapes that were found; nan where none was."""
    opening_spread_deg: float
    folds: bool
    """Whether layers of netting met."""
    changed: Floats
    """What wrinkles change at most, by the shapes that were found: drag, volume, largest radius and opening ahead. In
    contact it is their spread."""
    spent_ms: float
    contact_share: float = float("nan")
    """Share of the knots of the shape that stands which other netting presses on; nan without contact."""
    fold_count: int = 0
    """Most folds of any ring of the shape that stands, all round."""
    covered: bool = False
    """Whether that is all they may change: the shape lasts, and in contact it is one of several."""
    shapes_found: int = 0
    """Shapes in balance that the starts led to."""


LYING_ON_ITSELF = "netting lies on netting in this shape: contact is not modelled"
NOT_FOLLOWED = Followed(None, "", float("nan"), float("nan"), False, np.zeros(4), 0.0)


def as_it_lies(bag: Bag, problem: Problem, solution: Solution) -> Followed:
    """What is told of an equilibrium that was found with contact between its layers, without following anything."""
    share, folds = in_contact_share(problem, solution), fold_count(solution.positions, problem.rings, bag.net.order)
    return replace(NOT_FOLLOWED, folds=share > 0.0, contact_share=share, fold_count=folds)


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
        at_rest = measure_all(base[0].bag, base[3], base[1])[2]
        if model.plan.model.contact is not False and is_pierced(base[3], base[1]):
            limp = _symmetric(replace(base[0], plan=limp_of(model.plan)), case)
            base = base if limp is None else limp
            merged += ", from the shape of limp twine, for that of this twine lies through itself"
        run = _Following(model.plan, case, progress)
        run.pursue(*base, MOST_WIDENINGS)
        run.widen()
        spent_ms = clock.ms
    return _told(run, at_rest, merged, spent_ms)


class _Following:
    """The shapes that are found on the way."""

    def __init__(self, plan: Plan, case: Case, progress: Progress | None) -> None:
        self.plan, self.case, self.progress = plan, case, progress
        self.shapes: list[Shape] = []
        self.touching, self.lost, self.left_out = 0, 0, 0
        self.work = WORK.get(plan.model.contact, 0)
        """Steps times knots left under contact."""
        self.in_contact = False
        """Whether contact was tried."""

    def pursue(
        self,
        model: BagModel,
        solution: Solution,
        stability: Stability,
        problem: Problem,
        widenings: int,
        most: int | None = None,
    ) -> None:
        """Follow what grows of an equilibrium from so many starts at most, and what then still grows of that."""
        for of_start, sectors, growth, rest, start in islice(_starts(model, self.case, solution, stability), most):
            knots = len(start.positions)
            if self.in_contact and self.work < LEAST_STEPS * knots:
                self.left_out += 1
                continue
            wide = of_start
            if wide.plan is not self.plan:  # the start is of another twine
                wide = model_of(self.plan, wide.globalisation, wide.sectors)
            wide_problem = problem_of(wide.bag, wide.plan, self.case)
            tolerance = model.plan.model.tolerance
            touches = problem.surface is not None
            if not touches:
                motion = gentle.follow(
                    wide_problem, tolerance, start, wide.prepared, self.progress, left=rest.positions
                )
                touches = motion.end is End.TOUCHING and wide.plan.model.contact is not False
            if touches:
                self.in_contact = True
                allowed = max(min(STEPS, self.work // knots), LEAST_STEPS)
                found = follow_under_contact(wide, wide_problem, rest, start, self.progress, allowed)
                if found is None:
                    self.touching += 1
                    continue
                wide_problem, motion = found
                self.work -= motion.steps * knots
            if motion.end is not End.SETTLED:
                self.touching += motion.end is End.TOUCHING
                self.lost += motion.end is End.STEPS_SPENT
                continue
            shape = self._shape(wide, wide_problem, motion, growth)
            if shape.stability.stable == "no" and widenings > 0 and sectors > 1 and not touches:
                before = len(self.shapes)
                self.pursue(wide, motion.solution, shape.stability, wide_problem, widenings - 1)
                if len(self.shapes) > before:
                    continue
            self.shapes.append(shape)

    def widen(self) -> None:
        """Follow on in wider sectors, under contact, the shape of which the least grows, until one lasts."""
        for _ in range(MOST_WIDENINGS):
            best, before = self.best, len(self.shapes)
            if best is None or best.problem.surface is None or best.stability.stable == "yes":
                return
            self.pursue(best.model, best.solution, best.stability, best.problem, 0, 1)
            if len(self.shapes) == before:
                return

    @property
    def best(self) -> Shape | None:
        """The shape that lasts on the narrowest sector; where none does, that of which the least grows."""
        return min(self.shapes, key=lambda shape: (*shape.growth, shape.meshes), default=None)

    @property
    def unfinished(self) -> str:
        """Starts that led to no shape, in words."""
        lost = f", starts that did not: {self.lost}" if self.lost else ""
        more = "" if self.plan.model.contact is True else " (contact = true allows more)"
        return lost + (f", left out for their cost: {self.left_out}{more}" if self.left_out else "")

    def _shape(self, model: BagModel, problem: Problem, motion: Motion, growth: Growth) -> Shape:
        tangent = tangent_of(model, problem, motion.solution)
        return Shape(
            model,
            problem,
            motion.solution,
            stability_of(model, tangent),
            measure_all(model.bag, problem, motion.solution)[2],
            meshes_wide(model.bag, max(max(part.open_meshes) for part in model.plan.netting)),
            growth.harmonic,
        )


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
) -> Iterator[tuple[BagModel, int, Growth, Solution, Solution]]:
    """Models so many sectors wide, what grows there, the shape at rest, and where to start.

    That is along what grows, and of the widest shaken as well.
    """
    order, sectors = model.bag.net.sectors, model.sectors
    fitting = list(_fitting(model, stability))
    if not fitting:
        return
    if len(solution.bar_tension) % (sectors or 1) or (len(solution.positions) - 1) % (sectors or 1):
        return  # sections of different counts, whose narrower sectors are not numbered alike
    for width, growth in fitting:
        wide = model
        if width > 1:
            wide = model_of(model.plan, model.globalisation, (sectors or 1) * width)
        rest, start = along(model, wide, solution, growth)
        yield wide, order, growth, rest, start
    shake = np.random.default_rng(case.number).standard_normal(rest.positions.shape) * ~wide.bag.net.fixed
    yield wide, order, growth, rest, _moved(rest, SHAKEN * float(np.median(wide.bag.net.bar_length)) * shake)


def along(model: BagModel, wide: BagModel, solution: Solution, growth: Growth) -> tuple[Solution, Solution]:
    """The shape at rest in a wider model, and that moved a little along what grows of it."""
    order, abreast = model.bag.net.sectors, model.sectors or 1
    width = order // wide.bag.net.sectors
    rest = all_round_start(model.bag, solution.positions, solution.bar_tension, width, abreast=abreast)
    turn = np.exp(2j * np.pi * growth.harmonic * np.arange(width) / order)
    moves = (growth.shape[:-1].reshape(-1, 1, abreast, 3) * turn[None, :, None, None]).real
    moved = rotate(moves, np.arange(width)[None, :, None], order).reshape(-1, 3)
    moved = np.concatenate([moved, growth.shape[-1:].real]) * ~wide.bag.net.fixed
    bar = float(np.median(wide.bag.net.bar_length))
    return rest, _moved(rest, ALONG * bar / np.linalg.norm(moved, axis=1).max() * moved)


def _moved(start: Solution, by: Floats) -> Solution:
    return replace(start, positions=start.positions + by)


def _merged(model: BagModel, case: Case) -> tuple[BagModel, Solution, Stability, Problem] | None:
    """A sector of the net with the fewest meshes merged of which something grows that can be followed; None if none."""
    for g in model.plan.globalisations:
        if g <= model.globalisation:
            continue
        found = _symmetric(replace(model, globalisation=g), case)
        if found is not None and list(_fitting(found[0], found[2])):
            return found
    return None


def _symmetric(model: BagModel, case: Case) -> tuple[BagModel, Solution, Stability, Problem] | None:
    """The equilibrium of a sector of a model's plan with as many meshes merged, and its stability; None if none."""
    sector = model_of(model.plan, model.globalisation, 1)
    problem, solution = equilibrium.solve(sector, case, (), None)
    if not solution.report.outcome.converged:
        return None
    stability = stability_of(sector, tangent_of(sector, problem, solution))
    return sector, solution, stability, problem


def _told(run: _Following, at_rest: Measures, merged: str, spent_ms: float) -> Followed:
    """What the shapes found amount to."""
    values = np.array([shape.measures.estimated for shape in run.shapes]).reshape(-1, 4)
    all_values = np.concatenate([values, [at_rest.estimated]])
    spread = np.ptp(values, axis=0) if len(values) else np.full(4, np.nan)
    found = Followed(
        None, "", float(spread[0]), float(spread[3]), False, COVERING * np.ptp(all_values, axis=0), spent_ms
    )
    found = replace(found, shapes_found=len(run.shapes))
    if run.touching and not (run.in_contact and run.shapes):
        why = "no start without a crossing was found" if run.in_contact else "contact is not modelled"
        reason = f"followed{merged} until layers of netting met: {why}, the symmetric shape stands"
        return replace(found, reason=reason, folds=True)
    shape = run.best
    if shape is None:
        layers = f", with layers of netting that touch{run.unfinished}" if run.in_contact else ""
        reason = f"followed{merged}, but to no shape in balance{layers}: the symmetric shape stands"
        return replace(found, reason=reason, folds=run.in_contact)
    where = "in the whole net" if shape.model.bag.net.order == 1 else f"in a sector {shape.meshes} meshes wide"
    reason = f"followed {where}{merged}, the narrowest that harmonic {shape.harmonic} fits, which grows"
    if shape.model.bag.net.order == 1 and shape.harmonic == 0:
        reason = f"followed {where}{merged}, from which something grows"
    share = in_contact_share(shape.problem, shape.solution)
    if shape.problem.surface is not None:
        reason += f", with contact between layers; shapes that settled: {len(run.shapes)}"
        reason += run.unfinished
    folds = fold_count(shape.solution.positions, shape.problem.rings, shape.model.bag.net.order)
    lasts = shape.stability.stable == "yes"
    if lasts and shape.harmonic == 1 and len(values) > 1:
        found = replace(found, changed=COVERING * spread + SWUNG * np.ptp(all_values, axis=0))
    if shape.problem.surface is not None:
        lasts = lasts and len(run.shapes) >= ENOUGH_SHAPES
        if lasts:
            of_size, by_itself = INNER_LAYERS
            found = replace(found, changed=spread + of_size * shape.measures.estimated + by_itself)
    found = replace(found, shape=shape, reason=reason, covered=lasts, folds=share > 0.0)
    return replace(found, contact_share=share, fold_count=folds)
