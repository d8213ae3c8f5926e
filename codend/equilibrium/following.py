"""What grows of an equilibrium, followed gently to shapes that are not the same all round.

The narrowest sectors that growing harmonics fit are followed (``growing_starts``), and what still grows of a shape in a
wider one. Where only the whole net has room and has too many knots, a merged net
takes its place. Where layers of netting meet, the start is followed once more with contact between them, unless the
plan forbids it: following stops there then.
"""

from dataclasses import replace
from itertools import islice

import numpy as np

from codend.bag.loads import problem_of
from codend.bag.measures import Measures, measure_all
from codend.equilibrium import growing_starts
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
from codend.equilibrium.followed import NOT_FOLLOWED, Followed, Shape, meshes_wide
from codend.equilibrium.growing_starts import fitting, starts
from codend.equilibrium.stability import Stability, stability_of, tangent_of
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.plan.plan import Case, Plan
from codend.solvers import gentle
from codend.solvers.clock import Clock
from codend.solvers.gentle import End, Motion
from codend.solvers.harmonics import Growth
from codend.solvers.outcome import Progress, Solution

MOST_WIDENINGS = 2
"""How often what still grows of a shape is followed on in a wider one."""
COVERING = 3.0
"""What wrinkles change, at most, over what was found: the shapes found are some of many."""
SWUNG = 0.1
"""Of how far a bag swings on its hoop, what is told as well: whichever way it swings it hangs alike."""
ENOUGH_SHAPES = 3
"""Shapes in contact whose spread is the error of the one that lasts among them."""
WORK: dict[object, int] = {"auto": 500_000, True: 2_000_000}
"""Gentle steps under contact times knots, over all starts, by ``model.contact``."""
SECONDS_A_STEP = 5e-5
"""What one of them takes by the knot, of processor time: to be told ahead."""
INNER_LAYERS = np.array([5e-4, 5e-4, 5e-4, 0.0]), np.array([0.0, 0.0, 0.0, 0.3])
"""What it changes whether the pressure of the catch acts on the inner layers of a fold, which it does here: share of
drag, volume and radius, and opening in degrees (a prototype's, on a T90 codend of 100 meshes round)."""


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
    if model.near is not None:
        return replace(NOT_FOLLOWED, reason='not followed: fidelity = "sector" asks for the exact ratio of the counts')
    with Clock() as clock:
        base, merged, most = (model, solution, stability, problem), "", growing_starts.MOST_KNOTS
        if not list(fitting(model, stability)):
            other = _merged(model, case)
            if other is None:
                reason = f"not followed: the sector that a growing harmonic fits has more than {most} knots"
                return replace(NOT_FOLLOWED, reason=reason)
            base, g = other, other[0].globalisation
            merged = f", {g} x {g} meshes merged into one, for the whole net has more than {most} knots"
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
        for of_start, sectors, growth, rest, start in islice(starts(model, self.case, solution, stability), most):
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
                found = follow_under_contact(wide, wide_problem, rest, start, self._telling_ahead(), allowed)
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

    def _telling_ahead(self) -> Progress | None:
        """Progress under contact, told with the most that all starts may yet take there."""
        told = self.progress
        if told is None:
            return None
        ahead = f"layers in contact, at most some {SECONDS_A_STEP * self.work:.0f} s yet"
        return lambda doing, residual: told(f"{ahead}, {doing}", residual)

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
        if self.progress is not None:
            self.progress(
                f"whether a shape of {len(problem.net.positions)} knots lasts", motion.solution.report.residual
            )
        return Shape(
            model,
            problem,
            motion.solution,
            stability_of(model, tangent, strongest_alone=True),
            measure_all(model.bag, problem, motion.solution)[2],
            meshes_wide(model.bag, max(max(part.open_meshes) for part in model.plan.netting)),
            growth.harmonic,
        )


def _merged(model: BagModel, case: Case) -> tuple[BagModel, Solution, Stability, Problem] | None:
    """A sector of the net with the fewest meshes merged of which something grows that can be followed; None if none."""
    for g in model.plan.globalisations:
        if g <= model.globalisation:
            continue
        found = _symmetric(replace(model, globalisation=g), case)
        if found is not None and list(fitting(found[0], found[2])):
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


def by_contact(measures: Measures) -> Floats:
    """What the model of contact may change: drag, volume, largest radius and opening ahead, (4,)."""
    of_size, by_itself = INNER_LAYERS
    return np.asarray(of_size * measures.estimated + by_itself)


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
            found = replace(found, changed=spread + by_contact(shape.measures))
    found = replace(found, shape=shape, reason=reason, covered=lasts, folds=share > 0.0)
    return replace(found, contact_share=share, fold_count=folds)
