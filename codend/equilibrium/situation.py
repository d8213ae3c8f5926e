"""What a start may look at, and the solvers as it asks for them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from codend.bag.near_ratio import SLOW_MESHES, near_ratios, quick_looks
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.folds import contact_law, under_weight
from codend.equilibrium.start_shapes import all_round_start, along_the_rows, windowed_start, windows_let_into
from codend.mechanics.problem import Problem
from codend.mechanics.sheet import FEWEST
from codend.plan.plan import Case, Plan
from codend.solvers import dynamic_relaxation, gentle, interior_point, newton
from codend.solvers.dynamic_relaxation import RelaxationSettings
from codend.solvers.gentle import GentleSettings
from codend.solvers.interior_point import InteriorPointSettings
from codend.solvers.mirror import ALIKE
from codend.solvers.newton import DIRECT, NewtonSettings
from codend.solvers.outcome import Progress, Solution
from codend.solvers.prepared import Prepared
from codend.solvers.refusal import passage

BRIEF = replace(DIRECT, switches=DIRECT.switches[:1], iterations_allowed=10)
"""Newton's method from a start for no longer than a good one needs."""

FROM_AFAR = InteriorPointSettings()
CORRECTIONS = 3
"""Of steps between and beside ropes and windows: a full net of 30 000 knots with a window took 18 steps without, 14
with one and 11 with three."""
AT_GEAR = InteriorPointSettings(corrections=CORRECTIONS)

FARTHEST_PREDICTION = 1.5
"""How far beyond the last catch the next one is predicted, over the distance between the last two."""

NEARLY = 0.12
"""Mismatch of the counts up to which a narrow sector's rows are near a wide one's."""

MOST_RELAXED = 1500
"""Knots of a net with ropes or windows up to which it is relaxed where nothing else leads to its equilibrium."""

MOST_HUNG, HANGING_STEPS = 3000, 1000
"""Knots of a net that is followed as it falls under its weight, and gentle steps that it may take: bags of 100 to 500
knots took 190 to 450, in 1 to 15 s."""

MOST_FOLDED = 1500
"""Knots of a sector of nearly the ratio that is followed until spare netting at its joint lies in folds: of 300 knots
some take 200 steps, in 2 s."""

Known = Sequence[tuple[Case, Solution]]
"""Equilibria of other cases of the same model."""


@dataclass(frozen=True)
class Situation:
    """The case to be solved, on which model, and what is known of others: all that a start may look at."""

    model: BagModel
    problem: Problem
    case: Case
    known: Known
    progress: Progress | None
    solve: Callable[[BagModel, Case], Solution]
    """Solves a case of another model, from nothing."""

    @property
    def plan(self) -> Plan:
        """What is modelled."""
        return self.model.plan

    @property
    def tolerance(self) -> float:
        """Largest residual and axial imbalance."""
        return self.plan.model.tolerance

    @property
    def by_meshes(self) -> bool:
        """Whether the catch is given by the meshes it fills, so that its front need not be searched for."""
        return self.case.catch_kind == "filled_meshes"

    @property
    def half_full_meshes(self) -> float:
        """Catch of half a bag, in meshes."""
        return 0.5 * float(self.model.bag.band_meshes.sum())

    @cached_property
    def at_its_speed(self) -> list[tuple[float, Solution]]:
        """Catches known at the case's speed, each once, and their equilibria."""
        return list({c.catch_value: found for c, found in self.known if c.speed_m_s == self.case.speed_m_s}.items())

    @property
    def others_at_its_speed(self) -> list[tuple[float, Solution]]:
        """The same but for the case's own catch."""
        return [pair for pair in self.at_its_speed if pair[0] != self.case.catch_value]

    @property
    def within_prediction(self) -> bool:
        """Whether a polynomial through the last catches known at its speed can be trusted at this one."""
        if len(self.at_its_speed) < 2:
            return False
        (before, _), (last, _) = self.at_its_speed[-2:]
        return abs(self.case.catch_value - last) <= FARTHEST_PREDICTION * abs(last - before)

    @property
    def led(self) -> bool:
        """Whether the last equilibria lead so near that nothing else is tried before.

        On a wide net a start that leads nowhere costs minutes, and the equilibrium of a sector next to nothing.
        """
        narrowest = self.model.sectors == 1 and not self.has_sector
        if narrowest or any(other.catch_value == self.case.catch_value for other, _ in self.known):
            return len(self.known) > 0
        # each way through the interior from nothing costs some thirty factorisations
        if self.geared:
            return len(self.others_at_its_speed) > 0
        return self.within_prediction and (self.model.narrow or not self.by_meshes)

    @property
    def has_sector(self) -> bool:
        """Whether more than a sector is modelled, or one with ropes, and that of a narrower one can be set round it."""
        wider = self.model.sectors is None or (len(self.plan.ropes) > 0 and not self.model.smeared)
        return wider and self.plan.model.bars_per_side == 1

    @property
    def geared(self) -> bool:
        """Whether ropes or windows are modelled as they are, and bars between and beside them go slack by many."""
        return self.has_sector and (len(self.plan.ropes) > 0 or len(self.model.bag.windows) > 0)

    @property
    def draws_in(self) -> bool:
        """Whether ropes or windows are modelled as they are, in so large a net that relaxing it would take minutes.

        Netting beside them hangs all but slack, and moves on and on: knotted nets with four ropes that the interior did
        not lead to were not found so either, in 30 s of 1800 knots and 100 s of 5000.
        """
        return self.geared and len(self.model.bag.net.positions) > MOST_RELAXED

    @cached_property
    def sector_all_round(self) -> Solution | None:
        """The equilibrium of a sector set all round, its report that of the sector; None where that is not solved."""
        if self.model.bag.windows and self.plan.ropes:
            between = model_of(self.plan, self.model.globalisation, 1)
            found = self.solve(between, self.case)
            if found.report.outcome.converged:
                return replace(windows_let_into(self.model, between.bag, found), report=found.report)
        # without gear the exact sector is the answer itself, and how else stiff netting starts decides its shape
        looks = quick_looks(self.plan) if self.geared else []
        for near in looks:
            narrow = model_of(self.plan, self.model.globalisation, 1, True, near)
            found = self.solve(narrow, self.case)
            if found.report.outcome.converged:
                lay = (
                    windowed_start(self.model, narrow.bag, found)
                    if self.model.bag.windows
                    else along_the_rows(narrow.bag, found, self.model)
                )
                return replace(lay, report=found.report)
        if looks:
            return None
        sector = model_of(self.plan, self.model.globalisation, 1, smeared=True)
        found = self.solve(sector, self.case)
        if not found.report.outcome.converged:
            return None
        if self.model.bag.windows:
            return replace(windowed_start(self.model, sector.bag, found), report=found.report)
        sectors = sector.bag.net.sectors // self.model.bag.net.sectors
        start = all_round_start(sector.bag, found.positions, found.bar_tension, sectors, self.model.bag)
        return replace(start, report=found.report)

    @property
    def wide(self) -> bool:
        """Whether joined sections make the model so wide that a sector of nearly their ratio costs nothing beside."""
        plan = self.plan
        plain = not (plan.seamed or plan.ropes or plan.window or plan.tapers or plan.layer)
        joined = plain and len({section.meshes_round for section in plan.netting}) > 1
        return joined and plan.model.bars_per_side == 1 and self._width >= SLOW_MESHES

    @property
    def _width(self) -> float:
        """Knots of the widest ring."""
        return float(self.problem.loading.catch.row_size.max())

    @cached_property
    def along_the_rows(self) -> Solution | None:
        """The rows of the narrowest sector of nearly the ratio that is solved, laid out; None where none is."""
        spent_ms = 0.0
        for near in near_ratios(self.plan):
            if 2 * max(near.columns) > self._width:
                return None
            if near.largest > NEARLY:
                continue
            narrow = model_of(self.plan, 1, 1, near=near)
            found = self.solve(narrow, self.case)
            spent_ms += found.report.solve_ms
            if found.report.outcome.converged:
                start = along_the_rows(narrow.bag, found, self.model)
                return replace(start, report=replace(found.report, solve_ms=spent_ms))
        return None

    @property
    def heavy(self) -> bool:
        """Whether weight acts on the model, of its twine or its catch."""
        loading = self.problem.loading
        return bool(loading.dead.any() or loading.catch.weight_density != 0.0)

    @property
    def may_hang(self) -> bool:
        """Whether layers of the net may lie on each other under its weight, and it can be followed until they do."""
        return self.heavy and not self.geared and self._small and self.plan.model.contact is not False

    @property
    def may_fold_at_gear(self) -> bool:
        """Whether netting between ropes and beside windows can be followed until it lies in folds."""
        followed = self.geared and self._small and self.plan.model.contact is not False
        start = self.sector_all_round if followed else None
        return start is not None and passage(self.touching, start.positions) is None

    @property
    def _small(self) -> bool:
        return len(self.model.bag.net.positions) <= MOST_HUNG

    @property
    def may_fold(self) -> bool:
        """Whether a sector of nearly the ratio of a joint can be followed until its spare netting lies in folds.

        The exact one is mostly so wide that this takes minutes.
        """
        near, knots = self.model.near, len(self.model.bag.net.positions)
        followed = near is not None and near.order >= FEWEST and knots <= MOST_FOLDED
        return followed and self.plan.model.contact is not False and self.along_the_rows is not None

    @cached_property
    def _drawn_out(self) -> Solution:
        """A shape in which no netting lies on any, every bar with a tension of the size that it will have."""
        laid = self.sector_all_round if self.geared else self.along_the_rows if self.may_fold else None
        return under_weight(self.problem) if laid is None else laid

    @cached_property
    def touching(self) -> Problem:
        """The problem with contact between layers of the net."""
        return self.problem.touching_by(contact_law(self.problem, self._drawn_out))

    @property
    def first_settings(self) -> NewtonSettings:
        """Newton's method where better starts are left: none is followed for long.

        Weight may hide below the tolerance of single nodes.
        """
        brief = self.by_meshes and len(self.model.bag.net.corners) == 0
        settings = BRIEF if brief else DIRECT
        return replace(settings, least_iterations=1) if self.heavy else settings

    def by_newton(self, problem: Problem, start: Solution | None, settings: NewtonSettings = DIRECT) -> Solution:
        """Newton's method to the plan's tolerance."""
        start, prepared = self._halved(start)
        return newton.solve(problem, self.tolerance, start, settings, self.progress, prepared)

    def through_the_interior(
        self,
        problem: Problem,
        start: Solution | None = None,
        settings: InteriorPointSettings | None = None,
    ) -> Solution:
        """The interior-point method to the plan's tolerance, from a start or the crude bag the net was built as."""
        start, prepared = self._halved(start)
        settings = settings or (AT_GEAR if self.geared else FROM_AFAR)
        return interior_point.solve(problem, self.tolerance, start, settings, self.progress, prepared)

    def _halved(self, start: Solution | None) -> tuple[Solution | None, Prepared]:
        """A start, and room to work in: with half of the net where that mirrors the other, and the start does.

        Without a start the whole net is asked, so that a shape that is not mirrored is found where no other is.
        """
        half = self.model.half if start is not None else None
        if start is None or half is None:
            return start, self.model.prepared
        mirror, prepared = half
        if mirror.off(start.positions) > ALIKE * float(self.model.bag.net.bar_length.min()):
            return start, self.model.prepared
        return mirror.made_mirrored(start), prepared

    def hung(self) -> Solution:
        """Gentle steps under contact from the nearest equilibrium known, or from a crude bag, as it falls."""
        start = self._drawn_out
        if self.known:
            nearest = min(self.known, key=lambda pair: abs(pair[0].catch_value - self.case.catch_value))[1]
            start = nearest if passage(self.touching, nearest.positions) is None else start
        return gentle.solve(self.touching, self.tolerance, start, GentleSettings(HANGING_STEPS), self.progress)

    def relaxed(self, start: Solution | None) -> Solution:
        """Relaxation to the plan's tolerance."""
        settings = RelaxationSettings(viscous=self.plan.model.damping == "viscous")
        return dynamic_relaxation.solve(self.problem, self.tolerance, start, settings, self.progress)
