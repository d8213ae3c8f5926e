"""Starts: where a solver may begin, when that is tried, and in which order, a table for each method of a plan.

``solve`` goes down the table of its method until a net is in balance. Every start stands there for what it was measured
to be worth, which its description tells (``python -m validation.which_starts``).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Final

from codend.bag.meridian.plan_case import first_guess
from codend.equilibrium.situation import AT_GEAR, Situation
from codend.equilibrium.start_shapes import laid_out
from codend.solvers import rigid_bars
from codend.solvers.continuation import in_steps, predict, with_catch
from codend.solvers.newton import NewtonSettings
from codend.solvers.outcome import Solution
from codend.solvers.rigid_bars import RigidBarsSettings

LONGER = NewtonSettings(iterations_allowed=60)
"""Ahead and behind a joint of different mesh counts every second line of twine is all but slack, which takes longer."""

SMALLEST_STIFFENING = 1e-3
"""Least step in stiffness, as a share of the twine's own, before that start is given up."""

LED_BARRIER = replace(AT_GEAR, first_barrier=1e-3, resumes=True)
"""For catches near one known, from where that was midway: nets of 30 000 knots took 8 steps with ropes and 9 with a
window; from its equilibrium, one correction a step, 14 to 16 with a window."""


@dataclass(frozen=True)
class Start:
    """Where a solver begins, when that is tried, and how it goes on from there."""

    name: str
    """As reports tell it after "from"."""
    applies: Callable[[Situation], bool]
    solve: Callable[[Situation], Solution | None]
    """None where there turns out to be no such start."""
    in_contact: bool = False
    """Whether what it solves has contact between layers of the net (``Situation.touching``)."""


def _from_where_the_last_lead(s: Situation) -> Solution:
    began = perf_counter()
    unlike = len(s.model.bag.windows) > 0 and not s.within_prediction
    if s.geared and (unlike or not s.model.narrow):
        return s.through_the_interior(s.problem, _nearest(s), LED_BARRIER)
    start = _led(s)
    led_ms = 1e3 * (perf_counter() - began)
    return _later(s.by_newton(s.problem, start, s.first_settings), led_ms)


def _from_a_sector(s: Situation) -> Solution | None:
    if s.sector_all_round is None:
        return None
    return _later(s.by_newton(s.problem, s.sector_all_round, s.first_settings), s.sector_all_round.report.solve_ms)


def _from_a_sector_through_the_interior(s: Situation) -> Solution | None:
    if s.sector_all_round is None:
        return None
    return s.through_the_interior(s.problem, s.sector_all_round)


def _along_the_rows(s: Situation) -> Solution | None:
    if s.along_the_rows is None:
        return None
    return _later(s.through_the_interior(s.problem, s.along_the_rows), s.along_the_rows.report.solve_ms)


def _relaxed_from_a_sector(s: Situation) -> Solution | None:
    if s.sector_all_round is None:
        return None
    return _later(s.relaxed(s.sector_all_round), s.sector_all_round.report.solve_ms)


def _from_the_meridian(s: Situation) -> Solution | None:
    """Stiff twine is brought up in steps from limp twine, for which the shape is meant, as long as they succeed."""
    began = perf_counter()
    shape = first_guess(s.plan, s.case)
    if shape is None:
        return None
    start = laid_out(s.model, shape)
    spent_ms = 1e3 * (perf_counter() - began)
    if len(s.model.bag.net.corners) == 0:
        return _later(s.by_newton(s.problem, start, s.first_settings), spent_ms)
    stiffness = s.problem.structure.corner_stiffness
    solution, reached, step = start, -1.0, 1.0
    while reached < 1.0:
        target = 0.0 if reached < 0.0 else min(reached + step, 1.0)
        structure = s.problem.structure._replace(corner_stiffness=target * stiffness)
        trial = s.by_newton(replace(s.problem, structure=structure), solution, s.first_settings)
        if trial.report.outcome.converged:
            solution, reached, step = trial, target, 3.0 * step
        elif reached < 0.0 or step < SMALLEST_STIFFENING:
            return _later(trial, spent_ms)
        else:
            step *= 0.25
        spent_ms += trial.report.solve_ms
    return _later(solution, spent_ms - solution.report.solve_ms)


def _in_steps_from_the_nearest(s: Situation) -> Solution:
    catch, solution = min(s.others_at_its_speed, key=lambda pair: abs(pair[0] - s.case.catch_value))
    # a catch given by its mass is a volume to the net
    size = catch * s.problem.loading.catch.size / s.case.catch_value
    return in_steps(s.problem, (size, solution), s.by_newton)


def _from_a_crude_bag_relaxed(s: Situation) -> Solution:
    joined = len({section.meshes_round for section in s.plan.netting}) > 1
    return s.by_newton(s.problem, None, LONGER if joined else NewtonSettings())


def _in_steps_from_half_a_bag(s: Situation) -> Solution:
    larger = s.through_the_interior(with_catch(s.problem, s.half_full_meshes))
    if not larger.report.outcome.converged:
        return larger
    return _later(in_steps(s.problem, (s.half_full_meshes, larger), s.by_newton), larger.report.solve_ms)


def _with_rigid_bars(s: Situation) -> Solution:
    return rigid_bars.solve(s.problem, s.tolerance, progress=s.progress)


def _with_rigid_bars_going_slack(s: Situation) -> Solution:
    return rigid_bars.solve(s.problem, s.tolerance, None, RigidBarsSettings(slack=True), s.progress)


LED = Start(
    "where the last equilibria lead",
    lambda s: s.led,
    _from_where_the_last_lead,
)
"""Led to 2457 of 2997 later catches of series, in 1 ms where a crude bag takes 10. Between ropes that are far apart
other twine goes slack with every catch: ten steps of Newton's method led to none of three, twenty of the other did."""
A_SECTOR = Start(
    "the equilibrium of a sector",
    lambda s: s.has_sector and not any(rope.shortening > 0.0 for rope in s.plan.rope) and len(s.model.bag.windows) == 0,
    _from_a_sector,
)
"""Not where ropes are shorter than the netting: there it led nowhere, at a quarter of the cost of the way through the
interior; nor in wide nets with windows, which it led to after the ten steps it has only where they change nothing. Led
to all of 418 full nets, in 14 ms with the sector's own equilibrium."""
THROUGH = Start(
    "the equilibrium of a sector, through the interior",
    lambda s: s.has_sector,
    _from_a_sector_through_the_interior,
)
"""Weight lets many bars go slack, and so do windows, and ropes beside the columns that they are laced to and alone draw
in. A crude bag with weight may lead to another shape than the one that hangs from the sector's."""
ROWS = Start(
    "the rows of a sector of nearly the ratio, through the interior",
    lambda s: s.wide,
    _along_the_rows,
)
"""Ahead of a joint much netting is slack, which no crude bag tells."""
CRUDE = Start(
    "a crude bag",
    lambda s: not (s.draws_in and s.model.bag.windows and s.sector_all_round is not None),
    lambda s: s.through_the_interior(s.problem),
)
"""Led to 3181 of 3547 nets that nothing known led to. Not to wide nets with windows that a sector had not led to, where
it takes a minute or more."""
STIFF = Start(
    "the meridian method's shape",
    lambda s: _has_meridian(s) and len(s.model.bag.net.corners) > 0,
    _from_the_meridian,
)
"""Stiff twine may have more than one symmetric shape: brought up from limp twine it takes that which is steadier, where
a crude bag led to one of twice as many growing directions."""
MERIDIAN = Start(
    "the meridian method's shape",
    lambda s: _has_meridian(s) and len(s.model.bag.net.corners) == 0,
    _from_the_meridian,
)
"""Led to 45 of 51 nets of one section that a crude bag had not led to, most of them of stiff twine with small catches.

The meridian method's equilibrium, which was tried next, led to none of those left."""
STEPS = Start(
    "the nearest equilibrium, in steps",
    lambda s: len(s.others_at_its_speed) > 0,
    _in_steps_from_the_nearest,
)
"""Led to 46 of 55 later catches that neither the last equilibria nor a crude bag had led to."""
HUNG = Start(
    "the nearest equilibrium or a crude bag, gently under contact",
    lambda s: s.may_hang,
    lambda s: s.hung(),
    in_contact=True,
)
"""Towed so slowly that its weight folds it over its hoop, a bag is in no balance without contact: all that come after
lead to nothing but nets that pass through themselves."""
IN_FOLDS = Start(
    "the rows of a sector of nearly the ratio, gently under contact",
    lambda s: s.may_fold,
    lambda s: s.hung(),
    in_contact=True,
)
"""Spare netting behind a joint lies in folds, and without contact has no equilibrium but such as pass through
themselves: 81 meshes to 74 of T90 were found so in sectors from 9 and 8 to 12 and 11 meshes wide, drag within 0.03 %
of each other and of the full net's, in 2 s each where that takes 30."""
IN_FOLDS_AT_GEAR = Start(
    "the equilibrium of a sector, gently under contact",
    lambda s: s.may_fold_at_gear,
    lambda s: s.hung(),
    in_contact=True,
)
"""Short ropes draw stiff and turned netting into folds, and windows that are wider than their place lie in some."""
CRUDE_RELAXED = Start(
    "a crude bag, relaxed",
    lambda s: not s.draws_in,
    _from_a_crude_bag_relaxed,
)
"""Led to 210 of 275 nets that all before had failed at."""
HALF_A_BAG = Start(
    "half a bag, in steps",
    lambda s: s.by_meshes and not s.draws_in and s.case.catch_value < s.half_full_meshes,
    _in_steps_from_half_a_bag,
)
"""Fewer bars are slack in half a bag than around a small catch. Led to 5 of 51 that all before had failed at."""
A_SECTOR_RELAXED = Start(
    A_SECTOR.name,
    lambda s: s.has_sector and (not s.draws_in or s.plan.model.method == "dynamic-relaxation"),
    _relaxed_from_a_sector,
)
"""A full net relaxed from a crude bag folds while it is far from its shape, and goes through itself."""
RELAXED_TO_THE_END = Start(
    "a crude bag",
    lambda s: not s.draws_in or s.plan.model.method == "dynamic-relaxation",
    lambda s: s.relaxed(None),
)
"""Led to 3 of 60 that all before had failed at, in 3 to 60 s."""
RIGID = Start("a crude bag", lambda s: True, _with_rigid_bars)
"""What the method is."""
RIGID_SLACK = Start(
    "a crude bag, its bars going slack",
    lambda s: True,
    _with_rigid_bars_going_slack,
)
"""Led to bags of square mesh, whose rings go slack, where bars that push had not."""

_BY_NEWTON = (
    LED,
    A_SECTOR,
    THROUGH,
    ROWS,
    STIFF,
    CRUDE,
    MERIDIAN,
    STEPS,
    HUNG,
    IN_FOLDS_AT_GEAR,
    CRUDE_RELAXED,
    HALF_A_BAG,
)
_BY_RELAXATION = (A_SECTOR_RELAXED, RELAXED_TO_THE_END)

STARTS: Final[dict[str, tuple[Start, ...]]] = {
    "auto": (*_BY_NEWTON, *_BY_RELAXATION),
    "newton": _BY_NEWTON,
    "dynamic-relaxation": _BY_RELAXATION,
    "rigid-bars": (RIGID, RIGID_SLACK),
}
"""For each ``model.method`` the starts in the order tried."""
BRIEFLY: Final = (LED, ROWS, STIFF, CRUDE, MERIDIAN, STEPS, IN_FOLDS)
"""Those that take a wide joined net no minutes, where another model can stand in its place."""


BETWEEN_ROPES: Final = (LED, A_SECTOR, THROUGH, CRUDE, IN_FOLDS_AT_GEAR)
"""Those that have led to large nets between real ropes, where smeared ones can stand in their place. The last takes
some 20 s of up to ``MOST_HUNG`` knots: who asks for no accuracy in opening has not asked for a quick look. Of 72 random
nets of larger meshes between ropes, too, these led to all that any led to, in 0.2 s; the others took 5 to 14 s more."""


def _has_meridian(s: Situation) -> bool:
    return s.by_meshes and s.plan.model.bars_per_side == 1 and not s.plan.layer and not s.model.bag.windows


def _later(solution: Solution, ms: float) -> Solution:
    """The same solution after ``ms`` more of solving."""
    return replace(solution, report=replace(solution.report, solve_ms=solution.report.solve_ms + ms))


def _led(s: Situation) -> Solution:
    """The same catch at another speed, or where the last catches at the case's own speed lead.

    Limp inextensible twine takes the same shape at any speed, under tensions that grow with its square.
    """
    wanted = s.case.catch_value
    if s.within_prediction and all(case.catch_value != wanted for case, _ in s.known):
        return predict(s.at_its_speed, wanted)
    return _nearest(s)


def _nearest(s: Situation) -> Solution:
    """The equilibrium of the nearest catch, at the case's speed; of the case itself, without the way to it."""
    wanted, speed = s.case.catch_value, s.case.speed_m_s
    nearest, solution = min(s.known, key=lambda pair: (abs(pair[0].catch_value - wanted), pair[0].speed_m_s))
    ratio = speed / nearest.speed_m_s
    of_itself = (nearest.catch_value, ratio) == (wanted, 1.0)
    midway = solution.midway.at_speed(ratio) if solution.midway is not None and not of_itself else None
    return replace(solution, bar_tension=ratio**2 * solution.bar_tension, midway=midway)
