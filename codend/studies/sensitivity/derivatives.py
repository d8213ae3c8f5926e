"""Derivatives of what a case tells with respect to the numbers of its plan.

Of real numbers by implicit differentiation (``solvers.derivative``): the equilibrium moves to first order, and what is
told of it is measured on either side along that move. Where a plan stands on a kink (``kinks``), either side is solved
for itself. Of counts by differences of one.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from catch_models.fish import Species
from codend.bag.loads import problem_of
from codend.equilibrium.fidelity import Choice, choose
from codend.errors import InputError
from codend.mechanics.bars import bar_lengths
from codend.mechanics.catch_front import fill
from codend.plan.numbers import PLACES, PlanNumber, alone, changed, numbers_of
from codend.plan.plan import Case, Plan
from codend.solvers.derivative import Linearised, Move
from codend.solvers.outcome import Solution
from codend.studies.sensitivity.kinks import Kink, kinks_along
from codend.studies.sensitivity.solved_case import SolvedCase, modelled, quantities, solved_case

STEP: Final = 2e-5
"""Change of a number that differences along a move are taken over, relative; nearer kinks are stood on."""
STEP_BESIDE_KINK: Final = 1e-4
"""The same, between equilibria that are solved each for itself."""
FROM_ZERO: Final = {"bending_stiffness_n_m2": 1e-4, "rest_opening_deg": 20.0, "shortening": 0.1}
"""What stands for the size of a number that is 0; of others 1."""
WIDEST: Final = 25
"""Meshes that a sector may be wide for a count to be asked, where it is not that wide already."""
FARTHEST: Final = 0.2
"""Of a count: how far off the next one may be whose sector is as narrow."""

Told = dict[str, float]
"""Quantities by the names of their columns."""
Progress = Callable[[int, int, str], None]
"""Told how many numbers are done, of how many, and which is next."""


@dataclass(frozen=True)
class Derivatives:
    """What one number of a plan does to what a case tells: everything by that number, nan where it is not known."""

    number: PlanNumber
    below: Told
    """Towards smaller values."""
    above: Told
    """Towards larger ones."""
    one_sided: bool = False
    """Whether the two are found each for itself: on a kink, at an end of what is allowed, of counts."""
    note: str = ""
    """The kink, the step of a count, or why nothing is known."""
    kink_below: float = -math.inf
    """Value at which the first kink is met, in proportion; infinite where none is."""
    kink_above: float = math.inf

    @property
    def slope(self) -> Told:
        """Towards larger values, or where nothing is there towards smaller ones."""
        return {name: self.below[name] if math.isnan(above) else above for name, above in self.above.items()}


@dataclass(frozen=True)
class CaseSensitivity:
    """Derivatives of one case."""

    case: Case
    told: Told
    numbers: tuple[Derivatives, ...]


def sensitivity_of(
    plan: Plan,
    case: Case,
    species: Sequence[Species] = (),
    keys: Sequence[str] | None = None,
    choice: Choice | None = None,
    progress: Progress | None = None,
) -> CaseSensitivity | None:
    """Derivatives of one case of a plan; None where the case cannot be solved.

    Args:
        plan: the plan.
        case: one of its cases.
        species: whose L50 and SR are asked.
        keys: numbers to ask, by their keys; all that the plan names by default.
        choice: the model, where it has been chosen.
        progress: called before every number.

    Raises:
        InputError: a key is no number of the plan.
    """
    every = numbers_of(plan, case)
    for key in keys or ():
        if key not in {number.key for number in every}:
            allowed = f"one of {', '.join(number.key for number in every)}"
            raise InputError(plan.source, key, None, allowed, "is no number that the plan gives")
    choice = choose(plan) if choice is None else choice
    base = solved_case(alone(plan, case), choice)
    if base is None:
        return None
    asked = [number for number in every if keys is None or number.key in keys]

    def next_one(done: int, total: int, key: str) -> None:
        if progress is not None:
            progress(done, total, f"case {case.number}: {key}")

    told, found = derivatives_at(base, asked, species, next_one)
    return CaseSensitivity(case, told, found)


def derivatives_at(
    base: SolvedCase, numbers: Sequence[PlanNumber], species: Sequence[Species], progress: Progress | None = None
) -> tuple[Told, tuple[Derivatives, ...]]:
    """What a solved case tells, and its derivatives by numbers of its plan."""
    told, found = quantities(base, species), []
    linear = Linearised(base.problem, base.solution, base.model.prepared)
    for done, number in enumerate(numbers):
        if progress is not None:
            progress(done, len(numbers), number.key)
        if number.counted:
            found.append(_of_count(base, number, species))
        else:
            found.append(_of_real(base, told, linear, number, species))
    return told, tuple(found)


def _of_real(
    base: SolvedCase, told: Told, linear: Linearised, number: PlanNumber, species: Sequence[Species]
) -> Derivatives:
    size = abs(number.value) or FROM_ZERO.get(number.key.rpartition(".")[2], 1.0)
    step = STEP * size
    less, more = (_unsolved(base, number, sign * step) for sign in (-1.0, 1.0))
    spread = step * ((less is not None) + (more is not None))
    unknown = dict.fromkeys(told, math.nan)
    if spread == 0.0:
        return Derivatives(number, unknown, unknown, note="the plan allows no other value")
    move = linear.move((less or base).problem, (more or base).problem, spread)
    if move is None:
        return Derivatives(number, unknown, unknown, note="the tangent of this equilibrium is singular")
    first = base if less is None else _along(less, base, linear, move, -step)
    second = base if more is None else _along(more, base, linear, move, step)
    low, high = (told if end is base else quantities(end, species) for end in (first, second))
    slope = {name: (high[name] - low[name]) / spread for name in told}
    kink = kinks_along(base, (first, second), move, spread, size)
    places = number.value + kink.below, number.value + kink.above
    if less is None:
        return Derivatives(number, unknown, slope, True, "the plan allows no smaller value", *places)
    if more is None:
        return Derivatives(number, slope, unknown, True, "the plan allows no larger value", *places)
    if kink.distance <= step:
        beside = STEP_BESIDE_KINK * size
        below, above = (_beside(base, number, sign * beside, species) or unknown for sign in (-1.0, 1.0))
        return Derivatives(number, below, above, True, f"here {kink.reason}", *places)
    return Derivatives(number, slope, slope, False, _ahead(kink, size), *places)


def _ahead(kink: Kink, size: float) -> str:
    """The nearest kink within a tenth of the number, in words."""
    if kink.distance > 0.1 * size:
        return ""
    side = "more" if kink.above <= -kink.below else "less"
    return f"at {100.0 * kink.distance / size:.2g} % {side} {kink.reason}"


def _unsolved(base: SolvedCase, number: PlanNumber, change: float) -> SolvedCase | None:
    """The case with a number changed, in the shape that it has without; None where the plan does not allow it."""
    try:
        plan = changed(base.plan, number.key, number.value + change)
        model = modelled(plan, base.choice)
    except InputError:
        return None
    (case,) = plan.cases()
    return replace(base, plan=plan, model=model, problem=problem_of(model.bag, plan, case))


def _along(end: SolvedCase, base: SolvedCase, linear: Linearised, move: Move, change: float) -> SolvedCase:
    """The changed case moved to first order."""
    positions = np.ascontiguousarray(base.solution.positions + change * move.positions)
    length, share = np.empty(len(move.density)), np.empty(end.model.bag.bands)
    bar_lengths(positions, end.problem.structure, length)
    fill(positions, end.problem.structure, end.problem.loading.catch, share)
    tension = (linear.state.density + change * move.density) * length
    return replace(end, solution=Solution(positions, tension, share, base.solution.report))


def _beside(base: SolvedCase, number: PlanNumber, step: float, species: Sequence[Species]) -> Told | None:
    """Derivatives on one side, by a parabola through three cases there that are solved each for itself."""
    found = []
    for steps in (1.0, 2.0, 3.0):
        try:
            plan = changed(base.plan, number.key, number.value + steps * step)
        except InputError:
            return None
        case = solved_case(plan, base.choice, base.solution)
        if case is None:
            return None
        found.append(quantities(case, species))
    return {name: (-2.5 * found[0][name] + 4.0 * found[1][name] - 1.5 * found[2][name]) / step for name in found[0]}


def _of_count(base: SolvedCase, number: PlanNumber, species: Sequence[Species]) -> Derivatives:
    notes, own = [], base
    if base.choice.sectors is None:
        own_choice = replace(base.choice, fidelity="sector", globalisation=1, sectors=1, near=None)
        found = solved_case(base.plan, own_choice) if _width(base.plan) <= WIDEST else None
        if found is None:
            unknown = dict.fromkeys(quantities(base, species), math.nan)
            return Derivatives(number, unknown, unknown, True, "the net has no narrow sector to ask for this count")
        own = found
        notes.append("of a sector, which bears no weight")
    told = quantities(own, species)
    unknown = dict.fromkeys(told, math.nan)
    sides: list[Told] = []
    for sign in (-1, 1):
        step, plan = _next_count(own, number, sign)
        try:
            case = None if plan is None else solved_case(plan, replace(own.choice, near=None))
        except InputError:  # of what can be drawn and is not modelled
            case = plan = None
        if case is None:
            reason = "not allowed, or not of a narrow sector" if plan is None else "not solved"
            notes.append(f"{'fewer' if sign < 0 else 'more'} are {reason}")
            sides.append(unknown)
            continue
        if abs(step) != 1:
            notes.append(f"over {abs(step)} {'fewer' if sign < 0 else 'more'}, the next of a narrow sector")
        then = quantities(case, species)
        sides.append({name: (then[name] - told[name]) / step for name in told})
    return Derivatives(number, sides[0], sides[1], True, "; ".join(notes))


def _next_count(base: SolvedCase, number: PlanNumber, sign: int) -> tuple[int, Plan | None]:
    """The step to the next count that leaves the sector narrow, and its plan; no plan where there is none."""
    if base.choice.near is not None:
        return sign, None
    kind = float if number.key.split(".")[-1] in PLACES or number.key.split(".")[-2] in PLACES else int
    # a sector between other ropes is that of nearly as many meshes, or the whole net at once
    widest = max(0 if base.plan.ropes else WIDEST, math.ceil(1.5 * _width(base.plan)))
    for step in range(1, max(1, int(FARTHEST * number.value)) + 1):
        try:
            plan = changed(base.plan, number.key, kind(number.value + sign * step))
        except InputError:
            continue
        if _width(plan) <= widest:
            return sign * step, plan
    return sign, None


def _width(plan: Plan) -> int:
    """Meshes that a sector of a plan is wide."""
    counts = [count for part in plan.netting for count in part.open_meshes]
    return max(counts) // math.gcd(*counts, *(rope.number for rope in plan.ropes))
