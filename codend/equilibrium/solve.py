"""Net under loads to equilibrium: the methods, in the order in which they are tried."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from time import perf_counter

import numpy as np

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.meridian.plan_case import equilibrium_guess, first_guess, tensions_on
from codend.bag.meridian.problem import MeridianShape
from codend.errors import InputError
from codend.mechanics.problem import Problem
from codend.mechanics.structure import structure_of
from codend.net.net import rotate
from codend.plan.plan import Case, Plan
from codend.solvers import dynamic_relaxation, interior_point, newton, rigid_bars
from codend.solvers.continuation import in_steps, predict, with_catch
from codend.solvers.dynamic_relaxation import RelaxationSettings
from codend.solvers.linear_systems import BandedSystem
from codend.solvers.newton import DIRECT, NewtonSettings
from codend.solvers.outcome import Outcome, Progress, Solution, SolverReport
from codend.solvers.rigid_bars import RigidBarsSettings
from codend.solvers.ring import Ring

BRIEF = replace(DIRECT, switches=DIRECT.switches[:1], iterations_allowed=10)
"""Newton's method from a start for no longer than a good one needs."""

LONGER = NewtonSettings(iterations_allowed=60)
"""Ahead and behind a joint of different mesh counts every second line of twine is all but slack, which takes longer."""

SMALLEST_STIFFENING = 1e-3
"""Least step in stiffness, as a share of the twine's own, before that start is given up."""

FARTHEST_PREDICTION = 1.5
"""How far beyond the last catch the next one is predicted, over the distance between the last two."""

START = SolverReport("start", Outcome.NOT_IMPROVING, 0, np.inf, np.inf, np.inf, 0.0)
"""Report of a shape that nobody has solved yet."""

Attempt = tuple[str, Callable[[], Solution | None]]
"""Where it starts, and the solve; None where there is no such start."""


@dataclass(frozen=True)
class Scene:
    """A bag with what is kept from one of its equilibria to the next."""

    plan: Plan
    bag: Bag
    sectors: int | None
    globalisation: int

    @cached_property
    def prepared(self) -> newton.Prepared:
        """The unknowns numbered, and room for Newton's method to work in; made when first asked for."""
        return newton.prepare(structure_of(self.bag.net), self.bag.bands)

    @cached_property
    def ring(self) -> Ring:
        """The net as a sector of a ring, and room to ask its harmonics; made when first asked for."""
        return Ring(structure_of(self.bag.net), self.bag.bands)


def scene_of(plan: Plan, globalisation: int, sectors: int | None) -> Scene:
    """Build the net of a plan.

    Raises:
        InputError: the plan asks for rigid bars and gives elastic twine.
    """
    stretching = [s.axial_stiffness_n for s in plan.netting if s.axial_stiffness_n is not None]
    if plan.model.method == "rigid-bars" and stretching:
        allowed = 'left out with model.method = "rigid-bars": rigid bars do not stretch'
        raise InputError(file=plan.source, key="netting.axial_stiffness_n", value=stretching[0], allowed=allowed)
    return Scene(plan, build_bag(plan, globalisation=globalisation, sectors=sectors), sectors, globalisation)


def solve(
    scene: Scene, case: Case, known: Sequence[tuple[Case, Solution]], progress: Progress | None
) -> tuple[Problem, Solution]:
    """Equilibrium of one case, helped by the equilibria known of others of the same scene.

    ``auto`` tries, in this order: Newton from where the last equilibria lead (on a wide net only where the catch is the
    same or not given by its meshes), for full nets Newton from the equilibrium of a sector set all round; the
    interior-point method from a crude bag; Newton from the meridian method's shape under uniform pressure without drag,
    from its equilibrium under the loads themselves, along a path of catches from the nearest equilibrium, from rough
    relaxations of the crude bag, for small catches along a path from half a bag, in which fewer bars are slack; and
    relaxation alone. Where the catch is not given by its meshes, the meridian method must search for the front and so
    comes last of these. The other methods try what they can of that; relaxation of a full net, too, begins with the
    equilibrium of a sector, for from a crude bag it goes through itself on the way; rigid bars that lead nowhere try
    again with bars that go slack. The report of what is returned tells every attempt; its time is that of all of them,
    the guesses included.
    """
    problem = problem_of(scene.bag, scene.plan, case)
    attempts: list[str] = []
    spent = 0.0
    solution: Solution | None = None
    for start, attempt in _attempts(scene, problem, case, known, progress):
        tried = attempt()
        if tried is None:
            continue
        # a net found in balance and refused tells more than a later start that led nowhere
        if solution is None or not solution.report.outcome.refused or tried.report.outcome.balanced:
            solution = tried
        attempts += [f"from {start}: {line}" for line in tried.report.attempts]
        spent += tried.report.solve_ms
        if solution.report.outcome.balanced:
            break
    assert solution is not None  # every method has a start that is always there
    return problem, replace(solution, report=replace(solution.report, attempts=tuple(attempts), solve_ms=spent))


def _attempts(
    scene: Scene, problem: Problem, case: Case, known: Sequence[tuple[Case, Solution]], progress: Progress | None
) -> Iterator[Attempt]:
    method, tolerance = scene.plan.model.method, scene.plan.model.tolerance

    def from_start(problem: Problem, start: Solution, settings: NewtonSettings = DIRECT) -> Solution:
        return newton.solve(problem, tolerance, start, settings, progress, scene.prepared)

    by_meshes = case.catch_kind == "filled_meshes"
    # where better starts are left, none is followed for long; weight may hide below the tolerance of single nodes
    brief = by_meshes and len(scene.bag.net.corners) == 0
    first_settings = replace(BRIEF if brief else DIRECT, least_iterations=int(problem.loading.dead.any()))

    def from_crude() -> Solution:
        joined = len({section.meshes_round for section in scene.plan.netting}) > 1
        return newton.solve(problem, tolerance, None, LONGER if joined else NewtonSettings(), progress, scene.prepared)

    def through_the_interior() -> Solution:
        return interior_point.solve(problem, tolerance, None, progress=progress, prepared=scene.prepared)

    def from_the_last() -> Solution:
        began = perf_counter()
        start = _led(case, known)
        led_ms = 1e3 * (perf_counter() - began)
        return _later(from_start(problem, start, first_settings), led_ms)

    def from_meridian(guess: Callable[[Plan, Case], MeridianShape | None], settings: NewtonSettings) -> Solution | None:
        began = perf_counter()
        start = _laid_out(scene, guess(scene.plan, case))
        guess_ms = 1e3 * (perf_counter() - began)
        if start is None:
            return None
        return _later(_from_limp(problem, start, partial(from_start, settings=settings)), guess_ms)

    half = 0.5 * float(scene.bag.band_meshes.sum())

    def from_half() -> Solution:
        larger = interior_point.solve(
            with_catch(problem, half), tolerance, None, progress=progress, prepared=scene.prepared
        )
        if not larger.report.outcome.converged:
            return larger
        return _later(in_steps(problem, (half, larger), from_start), larger.report.solve_ms)

    @cache
    def sector_all_round() -> tuple[Solution | None, float]:
        sector = scene_of(scene.plan, scene.globalisation, 1)
        part = solve(sector, case, (), None)[1]
        if not part.report.outcome.converged:
            return None, part.report.solve_ms
        start = all_round_start(sector.bag, part.positions, part.bar_tension, sector.bag.net.order)
        return start, part.report.solve_ms

    def from_sector(solved: Callable[[Solution], Solution]) -> Solution | None:
        start, sector_ms = sector_all_round()
        return None if start is None else _later(solved(start), sector_ms)

    has_sector = scene.sectors is None and scene.plan.model.bars_per_side == 1
    if method in ("auto", "newton"):
        path = _at_its_speed(case, known)
        same = any(other.catch_value == case.catch_value for other, _ in known)
        # on a wide net a start that leads nowhere costs minutes, and the equilibrium of a sector next to nothing
        near = _reaches(path, case.catch_value) and (isinstance(scene.prepared.system, BandedSystem) or not by_meshes)
        led = known and (scene.sectors == 1 or same or near)
        if led:
            yield "where the last equilibria lead", from_the_last
        if has_sector:
            settled = partial(from_start, problem, settings=first_settings)
            yield "the equilibrium of a sector", lambda: from_sector(settled)
        yield "a crude bag", through_the_interior
        if by_meshes:
            yield "the meridian method's shape", lambda: from_meridian(first_guess, first_settings)
            yield "the meridian method's equilibrium", lambda: from_meridian(equilibrium_guess, DIRECT)
        if known and not led:
            yield "where the last equilibria lead", from_the_last
        others = [pair for pair in path if pair[0] != case.catch_value]
        if others:
            catch, solution = min(others, key=lambda pair: abs(pair[0] - case.catch_value))
            # a catch given by its mass is a volume to the net
            known_catch = catch * problem.loading.catch.size / case.catch_value
            yield "the nearest equilibrium, in steps", lambda: in_steps(problem, (known_catch, solution), from_start)
        yield "a crude bag, relaxed", from_crude
        if by_meshes and case.catch_value < half:
            yield "half a bag, in steps", from_half
        if not by_meshes:
            yield "the meridian method's equilibrium", lambda: from_meridian(equilibrium_guess, DIRECT)
    if method in ("auto", "dynamic-relaxation"):
        settings = RelaxationSettings(viscous=scene.plan.model.damping == "viscous")
        relaxed = partial(dynamic_relaxation.solve, problem, tolerance, settings=settings, progress=progress)
        if has_sector:
            # a full net relaxed from a crude bag folds while it is far from its shape, and goes through itself
            yield "the equilibrium of a sector", lambda: from_sector(relaxed)
        yield "a crude bag", relaxed
    if method == "rigid-bars":
        yield "a crude bag", lambda: rigid_bars.solve(problem, tolerance, progress=progress)
        slack = RigidBarsSettings(slack=True)
        yield "a crude bag, its bars going slack", lambda: rigid_bars.solve(problem, tolerance, None, slack, progress)


def _later(solution: Solution, ms: float) -> Solution:
    """The same solution after ``ms`` more of solving."""
    return replace(solution, report=replace(solution.report, solve_ms=solution.report.solve_ms + ms))


def _led(case: Case, known: Sequence[tuple[Case, Solution]]) -> Solution:
    """Start for a case: the same catch at another speed, or where the last catches at its own speed lead.

    Limp inextensible twine takes the same shape at any speed, under tensions that grow with its square.
    """
    nearest, solution = min(known, key=lambda pair: (abs(pair[0].catch_value - case.catch_value), pair[0].speed_m_s))
    if nearest.catch_value != case.catch_value:
        path = _at_its_speed(case, known)
        if _reaches(path, case.catch_value):
            return predict(path, case.catch_value)
    return replace(solution, bar_tension=(case.speed_m_s / nearest.speed_m_s) ** 2 * solution.bar_tension)


def _at_its_speed(case: Case, known: Sequence[tuple[Case, Solution]]) -> list[tuple[float, Solution]]:
    """Catches known at the case's speed, each once, and their equilibria."""
    return list({other.catch_value: solution for other, solution in known if other.speed_m_s == case.speed_m_s}.items())


def _reaches(path: Sequence[tuple[float, Solution]], catch: float) -> bool:
    """Whether a polynomial through the last catches of a path can be trusted at another."""
    if len(path) < 2:
        return False
    (before, _), (last, _) = path[-2:]
    return abs(catch - last) <= FARTHEST_PREDICTION * abs(last - before)


def _from_limp(problem: Problem, start: Solution, solve: Callable[[Problem, Solution], Solution]) -> Solution:
    """Equilibrium from a start for limp twine; stiff twine is brought up in steps for as long as they succeed."""
    if len(problem.net.corners) == 0:
        return solve(problem, start)
    stiffness = problem.structure.corner_stiffness
    solution, reached, step, spent = start, -1.0, 1.0, 0.0
    while reached < 1.0:
        target = 0.0 if reached < 0.0 else min(reached + step, 1.0)
        structure = problem.structure._replace(corner_stiffness=target * stiffness)
        trial = solve(replace(problem, structure=structure), solution)
        if trial.report.outcome.converged:
            solution, reached, step = trial, target, 3.0 * step
        elif reached < 0.0 or step < SMALLEST_STIFFENING:
            return _later(trial, spent)
        else:
            step *= 0.25
        spent += trial.report.solve_ms
    return _later(solution, spent - solution.report.solve_ms)


def _laid_out(scene: Scene, shape: MeridianShape | None) -> Solution | None:
    """Shape and tensions of the meridian method on the scene's net; None where there is no shape or it does not fit."""
    if shape is None or scene.plan.model.bars_per_side > 1:
        return None
    g = scene.globalisation
    rows = (shape.x_m[::g], shape.radius_m[::g])
    sector = build_bag(scene.plan, globalisation=g, sectors=1, rows=rows)
    tension = g * tensions_on(sector, shape, g)
    return all_round_start(sector, sector.net.positions, tension, sector.net.order // scene.bag.net.order)


def all_round_start(sector: Bag, positions: np.ndarray, tension: np.ndarray, sectors: int) -> Solution:
    """A start for a net of so many sectors, from the shape and tensions of one without hinges.

    Nodes and bars of the wider net are numbered row by row, and those that differ by whole sectors one after the other.
    """
    turned = rotate(positions[:-1, None], np.arange(sectors)[None], sector.net.order).reshape(-1, 3)
    return Solution(
        np.concatenate([turned, positions[-1:]]), np.repeat(tension, sectors), np.zeros(sector.bands), START
    )
