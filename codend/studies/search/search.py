"""The least change of a plan that reaches a target: counts one combination after the other, real numbers by SLSQP.

The change is the root of the sum of the squares of the relative changes of the numbers that may change. Combinations
of counts, and of numbers that go by steps, are taken in the order of their own change; with each, real numbers are
changed as little as it takes by ``scipy.optimize`` with derivatives by the tangent, and no further than leaves the
whole change below that of the best design found. No combination is left out but those whose own change is already more.
Without real numbers the first design that reaches the target is therefore the one that a search through the whole grid
finds.
"""

import heapq
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from codend.equilibrium.fidelity import choose
from codend.errors import InputError
from codend.net.net import Floats
from codend.plan.numbers import alone
from codend.plan.plan import Plan
from codend.studies.case_result import CaseResult
from codend.studies.catches_solved import selectivity_in
from codend.studies.designs import Base, Run
from codend.studies.search.asked import Asked, Condition, Variable
from codend.studies.sensitivity.derivatives import Told, derivatives_at
from codend.studies.sensitivity.solved_case import OF_NETS, SolvedCase, quantities, solved_case
from codend.studies.study import solve

REACHED: Final = 1e-4
"""By how much, relative, a bound may be missed."""
AIMED: Final = 2e-5
"""By how much SLSQP is asked to keep them, so that rounding leaves them kept."""
ITERATIONS: Final = 15
PRECISION: Final = 1e-7
"""Of the square of the change, at which SLSQP ends."""
MOST_DESIGNS: Final = 20_000
"""That are looked at; a search that ends there says so."""
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Design:
    """A design that was looked at."""

    values: Mapping[str, float]
    """Of the numbers that may change, by their keys."""
    change: float
    """Root of the sum of the squares of the relative changes."""
    told: tuple[Told, ...]
    """What its cases tell; none where one was not solved."""
    reason: str = ""
    """Why not."""
    margin: float = -math.inf
    """Least margin by which it keeps all bounds, relative; below 0 where it does not."""

    @property
    def reaches(self) -> bool:
        """Whether all bounds are kept."""
        return self.margin >= -REACHED


@dataclass(frozen=True)
class Found:
    """How a search ended."""

    start: Design
    best: Design | None
    """The design of least change that reaches the target; None where none does."""
    nearest: Design
    """Of all that were looked at, the one that misses least."""
    conditions: tuple[Condition, ...]
    plan: Plan | None
    """Of the best design, with the catches of the target."""
    looked_at: tuple[Design, ...]
    combinations: int
    """Of counts and steps, of which ..."""
    tried: int
    """... so many were tried, and the others left out for their change."""
    cases: tuple[CaseResult, ...] = ()
    """Of that plan, as ``codend run`` solves them: with errors and stability, which designs on the way go without."""
    selected: Mapping[int, Mapping[str, float]] = field(default_factory=dict)
    """L50 and SR of these and what errors of the openings change in them, by the number of the case."""


def search(asked: Asked, progress: Progress | None = None) -> Found:
    """Look for the least change that reaches what is asked.

    Raises:
        InputError: the plan it starts from cannot be modelled, or is not solved.
    """
    return _Search(asked, progress).found()


class _Search:
    """A search as it goes."""

    def __init__(self, asked: Asked, progress: Progress | None) -> None:
        self.asked, self.progress = asked, progress
        self.variables = asked.variables
        self.conditions: tuple[Condition, ...] = ()
        self.looked_at: dict[tuple[float, ...], Design] = {}
        self.last: tuple[tuple[float, ...], list[SolvedCase]] = ((), [])
        self.led: Floats | None = None
        self.known: dict[tuple[float, ...], tuple[Floats | None, Floats]] = {}
        told = {one.quantity for one in asked.conditions} | set(asked.reach)
        self.fish = asked.species if told.difference(OF_NETS) else ()
        """Species whose L50 or SR is bounded."""

    def found(self) -> Found:
        """The result."""
        source = self.asked.plan.source
        own = np.array([one.number.value for one in self.variables], dtype=float)
        start = self._looked_at(own)
        if not start.told:
            raise InputError(source, "", None, "a plan that is solved to start from", f"is no start: {start.reason}")
        self.conditions = (*self.asked.conditions, *self._reaching(start))
        start = self.look(own)
        stepped = [i for i, one in enumerate(self.variables) if one.step is not None]
        free = [i for i, one in enumerate(self.variables) if one.step is None]
        combinations = math.prod(len(self.variables[i].values) for i in stepped)
        best, tried = (start if start.reaches else None), 0
        for change, values in _by_change([self.variables[i] for i in stepped]):
            if (best is not None and change >= best.change) or len(self.looked_at) >= MOST_DESIGNS:
                break
            tried += 1
            if self.progress is not None:
                self.progress(tried, combinations, f"{len(self.looked_at)} designs looked at")
            there = own.copy()
            there[stepped] = values
            room = math.inf if best is None else math.sqrt(best.change**2 - change**2)
            for one in self._of_combination(there, free, self._bounds(free, room)):
                if one.reaches and (best is None or one.change < best.change):
                    best = one
        told = [one for one in self.looked_at.values() if one.told]
        plan = None if best is None else self._plan(np.array([best.values[one.number.key] for one in self.variables]))
        study = None if plan is None else solve(plan)
        return Found(
            start=start,
            best=best,
            nearest=max(told, key=lambda one: one.margin),
            conditions=self.conditions,
            plan=plan,
            looked_at=tuple(self.looked_at.values()),
            combinations=combinations,
            tried=tried,
            cases=() if study is None else study.cases,
            selected=selectivity_in(study, self.asked.species) if study and self.asked.species else {},
        )

    def _reaching(self, start: Design) -> Iterator[Condition]:
        """Numbers to reach, from the side on which the plan is: that of the case which misses most."""
        for quantity, wanted in self.asked.reach.items():
            missed = [told[quantity] - wanted for told in start.told if not math.isnan(told[quantity])]
            if not missed:
                allowed = f"a plan that has {quantity} where it starts"
                raise InputError(self.asked.plan.source, f"search.target.{quantity}", wanted, allowed)
            yield Condition(quantity, wanted, -math.copysign(1.0, max(missed, key=abs)))

    def look(self, values: Floats) -> Design:
        """A design, solved once, and judged."""
        place = self._place(values)
        if place not in self.looked_at:
            design = self._looked_at(values)
            margins = [one.margin(told[one.quantity]) for told in design.told for one in self.conditions]
            margin = -math.inf if not margins or any(map(math.isnan, margins)) else min(margins)
            self.looked_at[place] = replace(design, margin=margin)
        return self.looked_at[place]

    def _place(self, values: Floats) -> tuple[float, ...]:
        return tuple(float(one.written(value)) for one, value in zip(self.variables, values, strict=True))

    def _looked_at(self, values: Floats) -> Design:
        place = self._place(values)
        shares = [(value - one.number.value) / one.size for one, value in zip(self.variables, place, strict=True)]
        named = {one.number.key: one.written(value) for one, value in zip(self.variables, place, strict=True)}
        design = Design(named, float(np.linalg.norm(shares)), ())
        try:
            solved = self._solved(values)
        except InputError as error:
            return replace(design, reason=error.lines[0])
        if solved is None:
            return replace(design, reason="not every case was solved")
        return replace(design, told=tuple(quantities(one, self.asked.species) for one in solved))

    def _solved(self, values: Floats) -> list[SolvedCase] | None:
        """The cases of a design; of the last one they are kept."""
        place = self._place(values)
        if self.last[0] != place:
            plan = self._plan(values)
            choice = choose(plan)
            found = [solved_case(alone(plan, case), choice) for case in plan.cases()]
            solved = [one for one in found if one is not None]
            if len(solved) < len(found):
                return None
            self.last = place, solved
        return self.last[1]

    def _plan(self, values: Floats) -> Plan:
        named = {one.number.key: one.written(value) for one, value in zip(self.variables, values, strict=True)}
        return Run(1, Base("", self.asked.data, str(self.asked.plan.source)), named, self.asked.keep).plan()

    def _bounds(self, free: list[int], room: float) -> Floats:
        """Least and most of real numbers, (f, 2), none of which changes by more than some room, relative."""
        variables = [self.variables[i] for i in free]
        return np.array(
            [
                (
                    max(one.least, one.number.value - room * one.size),
                    min(one.most, one.number.value + room * one.size),
                )
                for one in variables
            ]
        ).reshape(-1, 2)

    def _of_combination(self, values: Floats, free: list[int], bounds: Floats) -> Iterator[Design]:
        """Designs with given counts and steps: with real numbers changed as little as it takes."""
        own = self.look(values)
        yield own
        if own.reaches or not free:
            return
        for start in self._starts(values, free, bounds):
            found = self._least_change(start, free, bounds)
            yield found
            if found.reaches:
                self.led = np.array([found.values[self.variables[i].number.key] for i in free])
                return

    def _starts(self, values: Floats, free: list[int], bounds: Floats) -> Iterator[Floats]:
        """Real numbers of the last design that reached the target, the plan's own, the corner to which slopes lead."""
        if self.led is not None:
            near = values.copy()
            near[free] = np.clip(self.led, *bounds.T)
            yield near
        yield values
        margins, slopes = self._margins(values, free)
        if margins is None:
            return
        corner = values.copy()
        worst = slopes[int(np.argmin(margins))]
        corner[free] = np.where(worst > 0.0, bounds[:, 1], bounds[:, 0])
        yield corner

    def _least_change(self, start: Floats, free: list[int], bounds: Floats) -> Design:
        """SLSQP over the real numbers, each in units of its own size, from a start."""
        from scipy.optimize import minimize

        sizes = np.array([self.variables[i].size for i in free])
        own = np.array([self.variables[i].number.value for i in free]) / sizes

        def at(x: Floats) -> tuple[Floats, Floats]:
            values = start.copy()
            values[free] = x * sizes
            margins, slopes = self._margins(values, free)
            if margins is None:
                count = len(self.conditions) * len(self.asked.plan.cases())
                return np.full(count, -1.0), np.zeros((count, len(free)))
            return margins, slopes * sizes

        constraints = {"type": "ineq", "fun": lambda x: at(x)[0] - AIMED, "jac": lambda x: at(x)[1]}
        result: Any = minimize(  # type: ignore[call-overload]
            lambda x: float(((x - own) ** 2).sum()),
            start[free] / sizes,
            jac=lambda x: 2.0 * (x - own),
            method="SLSQP",
            bounds=list(bounds / sizes[:, None]),
            constraints=constraints,
            options={"maxiter": ITERATIONS, "ftol": PRECISION},
        )
        values = start.copy()
        values[free] = np.clip(result.x * sizes, *bounds.T)
        return self.look(values)

    def _margins(self, values: Floats, free: list[int]) -> tuple[Floats | None, Floats]:
        """Margins of all bounds in all cases (k,), and their slopes by the real numbers (k, f); None: not solved.

        Of a design as it is written once, and beside it by these slopes: at the end of its steps SLSQP asks dozens of
        times for values that are written alike.
        """
        place = self._place(values)
        if place not in self.known:
            self.known[place] = self._margins_of(np.array(place), free)
        margins, slopes = self.known[place]
        return None if margins is None else margins + slopes @ (values - np.array(place))[free], slopes

    def _margins_of(self, values: Floats, free: list[int]) -> tuple[Floats | None, Floats]:
        design = self.look(values)
        solved = self._solved(values) if design.told else None
        if solved is None or not math.isfinite(design.margin):
            return None, np.zeros((0, len(free)))
        margins, slopes = [], []
        for case in solved:
            numbers = [replace(self.variables[i].number, value=float(values[i])) for i in free]
            told, found = derivatives_at(case, numbers, self.fish)
            for one in self.conditions:
                margins.append(one.margin(told[one.quantity]))
                scale = one.sign / (abs(one.bound) or 1.0)
                slopes.append([scale * each.slope[one.quantity] for each in found])
        return np.array(margins), np.nan_to_num(np.array(slopes))


def _by_change(variables: list[Variable]) -> Iterator[tuple[float, Floats]]:
    """Every combination of the values of numbers that go by steps, by their change; one of nothing where none do."""
    lists = [one.values for one in variables]
    shares = [np.abs(values - one.number.value) / one.size for values, one in zip(lists, variables, strict=True)]

    def change(steps: tuple[int, ...]) -> float:
        return math.sqrt(sum(share[step] ** 2 for share, step in zip(shares, steps, strict=True)))

    first = (0,) * len(lists)
    waiting, seen = [(0.0, first)], {first}
    while waiting:
        size, steps = heapq.heappop(waiting)
        yield size, np.array([values[step] for values, step in zip(lists, steps, strict=True)])
        for i in range(len(lists)):
            following = (*steps[:i], steps[i] + 1, *steps[i + 1 :])
            if following[i] < len(lists[i]) and following not in seen:
                seen.add(following)
                heapq.heappush(waiting, (change(following), following))
