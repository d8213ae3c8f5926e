"""Net under loads to equilibrium: the methods, in the order in which they are tried."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from codend.build import build_net
from codend.errors import InputError
from codend.loads import problem_of
from codend.meridian.plan_case import first_guess, tensions_on
from codend.net import Net, rotate
from codend.plan import Case, Plan
from codend.problem import Problem
from codend.solvers import dynamic_relaxation, newton, rigid_bars
from codend.solvers.continuation import predict
from codend.solvers.dynamic_relaxation import RelaxationSettings
from codend.solvers.newton import NewtonSettings
from codend.solvers.outcome import Outcome, Progress, Solution, SolverReport
from codend.solvers.rigid_bars import RigidBarsSettings

DIRECT = NewtonSettings(rough_starts=())
"""Newton's method from the start it is given and no other."""

LONGER = NewtonSettings(iterations_allowed=60)
"""Ahead and behind a joint of different mesh counts every second line of twine is all but slack, which takes longer."""

SMALLEST_STIFFENING = 1e-3
"""Least step in stiffness, as a share of the twine's own, before that start is given up."""

FARTHEST_PREDICTION = 1.5
"""How far beyond the last catch the next one is predicted, over the distance between the last two."""

START = SolverReport("start", Outcome.NOT_IMPROVING, 0, np.inf, np.inf, np.inf, 0.0)
"""Report of a shape that nobody has solved yet."""

Attempt = tuple[str, Callable[[], Solution]]
"""Where it starts, and the solve."""


@dataclass(frozen=True)
class Scene:
    """A net with what is kept from one of its equilibria to the next."""

    plan: Plan
    net: Net
    columns: int | None
    globalisation: int
    prepared: newton.Prepared | None


def scene_of(plan: Plan, globalisation: int, columns: int | None) -> Scene:
    """Build the net of a plan, and number its unknowns if Newton's method may be used.

    Raises:
        InputError: the plan asks for rigid bars and gives elastic twine.
    """
    stretching = [s.axial_stiffness_n for s in plan.netting if s.axial_stiffness_n is not None]
    if plan.model.method == "rigid-bars" and stretching:
        allowed = 'left out with model.method = "rigid-bars": rigid bars do not stretch'
        raise InputError(file=plan.source, key="netting.axial_stiffness_n", value=stretching[0], allowed=allowed)
    net = build_net(plan, globalisation=globalisation, columns=columns)
    uses_newton = plan.model.method in ("auto", "newton")
    problem = problem_of(net, plan, plan.cases()[0])
    prepared = newton.prepare(problem.structure) if uses_newton else None
    return Scene(plan, net, columns, globalisation, prepared)


def solve(
    scene: Scene, case: Case, known: Sequence[tuple[Case, Solution]], progress: Progress | None
) -> tuple[Problem, Solution]:
    """Equilibrium of one case, helped by the equilibria known of others of the same scene.

    ``auto`` tries, in this order: Newton from where the last equilibria lead, Newton from the meridian method's shape
    or, for full nets of plans that it does not take, from the equilibrium of a sector (either is set all round for a
    full net), Newton from rough relaxations of a crude bag, and relaxation alone.
    The other methods try what they can of that; rigid bars that lead nowhere try again with bars that go slack. The
    report of what is returned tells every attempt; its time is that of all of them, the guess included.
    """
    problem = problem_of(scene.net, scene.plan, case)
    attempts: list[str] = []
    spent = 0.0
    for start, attempt in _attempts(scene, problem, case, known, progress):
        solution = attempt()
        attempts += [f"from {start}: {line}" for line in solution.report.attempts]
        spent += solution.report.solve_ms
        if solution.report.outcome.converged or solution.report.outcome is Outcome.OVERFULL:
            break
    return problem, replace(solution, report=replace(solution.report, attempts=tuple(attempts), solve_ms=spent))


def _attempts(
    scene: Scene, problem: Problem, case: Case, known: Sequence[tuple[Case, Solution]], progress: Progress | None
) -> Iterator[Attempt]:
    method, tolerance = scene.plan.model.method, scene.plan.model.tolerance

    def from_start(problem: Problem, start: Solution) -> Solution:
        return newton.solve(problem, tolerance, start, DIRECT, progress, scene.prepared)

    def from_crude() -> Solution:
        dynamic_relaxation.compile_kernels(problem)  # for the rough starts, ahead of Newton's clock
        joined = len({section.meshes_round for section in scene.plan.netting}) > 1
        return newton.solve(problem, tolerance, None, LONGER if joined else NewtonSettings(), progress, scene.prepared)

    if method in ("auto", "newton"):
        # on a full net a start that leads nowhere costs minutes: there the last equilibria must be near
        led = known and (scene.columns == 1 or _near(case, known))
        if led:
            yield "where the last equilibria lead", lambda: from_start(problem, _led(case, known))
        began = perf_counter()
        guess = _sector_guess(scene, case)
        guess_ms = 1e3 * (perf_counter() - began)
        if guess is not None:
            yield "the meridian method's shape", lambda: _later(_from_limp(problem, guess, from_start), guess_ms)
        elif scene.columns is None and scene.plan.model.bars_per_side == 1:
            sector = _sector_equilibrium(scene, case)
            sector_ms = 1e3 * (perf_counter() - began)
            if sector is not None:
                yield "the equilibrium of a sector", lambda: _later(from_start(problem, sector), sector_ms)
        if known and not led:
            yield "where the last equilibria lead", lambda: from_start(problem, _led(case, known))
        yield "a crude bag", from_crude
    if method in ("auto", "dynamic-relaxation"):
        settings = RelaxationSettings(viscous=scene.plan.model.damping == "viscous")
        yield "a crude bag", lambda: dynamic_relaxation.solve(problem, tolerance, settings=settings, progress=progress)
    if method == "rigid-bars":
        yield "a crude bag", lambda: rigid_bars.solve(problem, tolerance, progress=progress)
        slack = RigidBarsSettings(slack=True)
        yield "a crude bag, its bars going slack", lambda: rigid_bars.solve(problem, tolerance, slack, progress)


def _later(solution: Solution, ms: float) -> Solution:
    """The same solution after ``ms`` more of solving."""
    return replace(solution, report=replace(solution.report, solve_ms=solution.report.solve_ms + ms))


def _led(case: Case, known: Sequence[tuple[Case, Solution]]) -> Solution:
    """Start for a case: the same catch at another speed, or where the last catches at its own speed lead.

    Limp inextensible twine takes the same shape at any speed, under tensions that grow with its square.
    """
    nearest, solution = min(known, key=lambda pair: (abs(pair[0].catch_value - case.catch_value), pair[0].speed_m_s))
    if nearest.catch_value != case.catch_value and _near(case, known):
        return predict(_at_its_speed(case, known), case.catch_value)
    return replace(solution, bar_tension=(case.speed_m_s / nearest.speed_m_s) ** 2 * solution.bar_tension)


def _at_its_speed(case: Case, known: Sequence[tuple[Case, Solution]]) -> list[tuple[float, Solution]]:
    return [(other.catch_value, solution) for other, solution in known if other.speed_m_s == case.speed_m_s]


def _near(case: Case, known: Sequence[tuple[Case, Solution]]) -> bool:
    """Whether the same catch is known, or the last ones are near enough to trust a polynomial through them."""
    if any(other.catch_value == case.catch_value for other, _ in known):
        return True
    row = [catch for catch, _ in _at_its_speed(case, known)]
    return len(row) > 1 and abs(case.catch_value - row[-1]) <= FARTHEST_PREDICTION * abs(row[-1] - row[-2])


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


def _sector_guess(scene: Scene, case: Case) -> Solution | None:
    """Shape and tensions of the meridian method, laid out on the scene's net; None where it does not apply."""
    if scene.plan.model.bars_per_side > 1:
        return None
    shape = first_guess(scene.plan, case)
    if shape is None:
        return None
    g = scene.globalisation
    rows = (shape.x_m[::g], shape.radius_m[::g])
    sector = build_net(scene.plan, globalisation=g, columns=1, rows=rows)
    tension = g * tensions_on(sector, shape, g)
    return all_round_start(sector, sector.positions, tension, 1 if scene.columns == 1 else sector.order)


def _sector_equilibrium(scene: Scene, case: Case) -> Solution | None:
    """Equilibrium of one sector, set all round for a full net; None where it is not found."""
    sector = scene_of(scene.plan, scene.globalisation, 1)
    solution = solve(sector, case, (), None)[1]
    if not solution.report.outcome.converged:
        return None
    return all_round_start(sector.net, solution.positions, solution.bar_tension, sector.net.order)


def all_round_start(sector: Net, positions: np.ndarray, tension: np.ndarray, columns: int) -> Solution:
    """A start for the net of ``columns`` sectors, from the shape and tensions of one without hinges.

    Nodes and bars of the wider net are numbered row by row, and those that differ by whole sectors one after the other.
    """
    turned = rotate(positions[:-1, None], np.arange(columns)[None], sector.order).reshape(-1, 3)
    return Solution(
        np.concatenate([turned, positions[-1:]]), np.repeat(tension, columns), np.zeros(sector.bands), START
    )
