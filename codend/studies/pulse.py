"""A pulsing codend: what a heaving vessel does to its openings and its drag, period by period."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import ceil, pi, sin
from typing import Any

import numpy as np
import pandas as pd

from catch_models.fish import Species
from codend.bag.loads import problem_of
from codend.bag.measures import measure_all
from codend.net.net import Floats
from codend.plan.plan import Plan
from codend.plan.pulse import Following
from codend.selectivity.escape.haul import hauls_of, terms_of_catches
from codend.selectivity.escape.predict import rows_needed
from codend.solvers.pulsing import BagWater, PulsingBag
from codend.studies.case_result import CaseResult
from codend.studies.catches_solved import catches_in
from codend.studies.study import Study, StudyProgress

SHAPE = ("opening_ahead_deg", "front_radius_m", "max_radius_m", "filled_meshes")
"""Measures that stand in every row."""
OPENING_MET_DEG, DRAG_MET = 0.1, 0.01
"""By how much the least and the most open, and the least and the most drag over its mean, may change with steps half as
long: of a method of the second order three times what is left."""
LIES_ON_ITSELF = "its netting lies on itself, and what layers press on each other with is not followed in motion"
LEAST_RUNS, RUNS, MOST_BAR_STEPS = 3, 9, 5_000_000
"""Least and most runs in steps ever half as long, and bars times steps beyond which there are but the least."""


def surge(time_s: float, period_s: float) -> float:
    """Way to and fro over its amplitude, aft first: a sine that sets in over the first period without a jump."""
    ramp = sin(0.5 * pi * time_s / period_s) ** 2 if time_s < period_s else 1.0
    return ramp * sin(2.0 * pi * time_s / period_s)


@dataclass(frozen=True)
class Pulse:
    """A case of a plan under heave of one period."""

    table: pd.DataFrame
    """``case, period_s, time_s, entry_speed_m_s, speed_m_s, stagnation_pressure_pa, drag_n, opening_ahead_deg,
    front_radius_m, max_radius_m, filled_meshes``; speeds are through the water, drag is what the entry is held with."""
    least: CaseResult
    """The case as it is in the last period when the meshes ahead of the catch are least open."""
    most: CaseResult
    step_s: float
    """Time step."""
    off: dict[str, float] = field(default_factory=dict)
    """Of ``opening_ahead_deg`` and ``drag_n``: by how much a bound of the last period's range changed with the last
    halving of the step, or a quarter of the same for the halving before if that is more."""

    @property
    def last_period(self) -> pd.DataFrame:
        """Rows of the last period, both its ends among them."""
        return self.table[self.table["time_s"] >= self.table["time_s"].max() - self.table["period_s"].iloc[0] - 1e-9]

    @property
    def unlike_before_deg(self) -> float:
        """By how much openings range otherwise in the last period than in the one before, degrees."""
        period, time = self.table["period_s"].iloc[0], self.table["time_s"]
        end = time.max() - period + 1e-9
        before = self.table[(time >= end - period - 2e-9) & (time <= end)]["opening_ahead_deg"]
        last = self.last_period["opening_ahead_deg"]
        return max(abs(float(last.min() - before.min())), abs(float(last.max() - before.max())))

    def changes_from(self, other: "Pulse") -> dict[str, float]:
        """Largest change of a bound of the last period's range, of drag and of opening."""
        here, there = self.last_period, other.last_period
        return {
            name: max(abs(here[name].min() - there[name].min()), abs(here[name].max() - there[name].max()))
            for name in ("drag_n", "opening_ahead_deg")
        }

    @property
    def settled(self) -> bool:
        """Whether steps half as long would change the ranges by little."""
        mean = abs(float(self.last_period["drag_n"].mean()))
        return self.off["opening_ahead_deg"] <= OPENING_MET_DEG and self.off["drag_n"] <= DRAG_MET * mean


def pulse(plan: Plan, result: CaseResult, period_s: float, progress: StudyProgress | None = None) -> Pulse:
    """Rows in time of a case of a plan with ``[vessel]``, from its equilibrium on.

    The entry moves to and fro along the tow by the heave that is transmitted. The catch presses by rho V |V| / 2, V the
    speed at which the water passes the bag; the bag's water goes with it (``BagWater``). Steps are halved until the
    ranges change by little with it (``Pulse.settled``), or the work is too much; ``Pulse.off`` tells.

    Args:
        plan: its ``vessel`` is given.
        result: a case of it that was solved.
        period_s: of the heave.
        progress: told how many rows are done.

    Raises:
        ArithmeticError: the motion cannot be followed, or the netting presses on itself.
    """
    if result.followed.contact_share > 0.0:
        raise ArithmeticError(LIES_ON_ITSELF)
    following, steps = plan.time or Following(), first_steps(plan, period_s)
    found: Pulse | None = None
    failed: dict[int, ArithmeticError] = {}
    for number in range(RUNS):
        work = steps * following.periods * following.outputs_a_period * len(result.net.bars)
        if number >= LEAST_RUNS and work > MOST_BAR_STEPS:
            break
        try:
            now = in_steps(plan, result, period_s, steps, progress)
        except ArithmeticError as error:
            now, failed[steps] = None, error
        if found is not None and now is not None:
            change = now.changes_from(found)
            # of steps that are much too long the first change may be small by chance
            before = {name: 0.25 * found.off.get(name, 0.0) for name in change}
            now = replace(now, off={name: max(change[name], before[name]) for name in change})
            if found.off and now.settled:
                return now
        found, steps = now or found, 2 * steps
    if found is None or not found.off:
        output_ms = 1e3 * period_s / following.outputs_a_period
        reasons = (f"in steps of {output_ms / steps:.3g} ms {error}" for steps, error in failed.items())
        only = "" if found is None else f"; steps of {1e3 * found.step_s:.3g} ms led to its end, their error not known"
        raise ArithmeticError("; ".join(reasons) + only)
    return found


def first_steps(plan: Plan, period_s: float) -> int:
    """Time steps an output that are tried first."""
    following = plan.time or Following()
    return ceil(period_s / following.outputs_a_period / following.step_s - 1e-9)


def _motion(plan: Plan, result: CaseResult, period_s: float) -> PulsingBag:
    assert plan.vessel is not None
    amplitude, density = plan.vessel.heave_m * plan.vessel.transmitted, plan.catch_density_kg_m3
    solution, problem = result.solution, problem_of(result.bag, plan, result.case)
    bag = BagWater.of(problem, solution.positions, solution.share, result.measures.catch_volume_m3, density)

    def path(time_s: float) -> Floats:
        return np.array([amplitude * surge(time_s, period_s), 0.0, 0.0])

    return PulsingBag(problem, solution, result.case.speed_m_s, bag, path)


def in_steps(
    plan: Plan, result: CaseResult, period_s: float, steps: int, progress: StudyProgress | None = None
) -> Pulse:
    """The rows in so many time steps from one to the next, as ``pulse`` has them; nothing is told of their errors.

    Raises:
        ArithmeticError: the motion cannot be followed.
    """
    following, motion = plan.time or Following(), _motion(plan, result, period_s)
    case, water, order = result.case, plan.tow.water_density_kg_m3, result.net.order
    output = period_s / following.outputs_a_period
    dt = output / steps
    entry = motion.towed
    rows: list[dict[str, float]] = []
    ends: dict[str, CaseResult] = {}
    count = following.periods * following.outputs_a_period
    for number in range(count + 1):
        for _ in range(steps if number > 0 else 0):
            motion.step(dt)
        now, speed = _as_it_is(result, motion), motion.now.speed_m_s
        if number >= count - following.outputs_a_period:
            for name, side in (("least", 1.0), ("most", -1.0)):
                if (
                    name not in ends
                    or side * now.measures.opening_ahead_deg < side * ends[name].measures.opening_ahead_deg
                ):
                    ends[name] = now
        rows.append(
            {
                "case": case.number,
                "period_s": period_s,
                "time_s": number * output,
                "entry_speed_m_s": case.speed_m_s - float(motion.now.velocity[entry, 0].mean()),
                "speed_m_s": speed,
                "stagnation_pressure_pa": 0.5 * water * speed * abs(speed),
                "drag_n": -float(motion.support[entry, 0].sum()) * order,
                **{name: getattr(now.measures, name) for name in SHAPE},
            }
        )
        if progress is not None:
            progress(number, count, f"case {case.number}, period {period_s:g} s, steps of {1e3 * dt:.3g} ms")
    return Pulse(pd.DataFrame(rows), ends["least"], ends["most"], dt)


def _as_it_is(result: CaseResult, motion: PulsingBag) -> CaseResult:
    problem, moment = replace(result.problem, loading=motion.loading), motion.now.solution
    at = replace(moment, report=result.solution.report)
    meshes, rows, measures = measure_all(result.bag, problem, at)
    return replace(result, problem=problem, solution=at, measures=measures, rows=rows, meshes=meshes)


def ranges(study: Study, pulsing: Sequence[Pulse], species: Sequence[Species]) -> pd.DataFrame:
    """A row a case and period: means and ranges of speed, drag and opening over the last period, and what L50 then is.

    L50 is that of fish that meet the meshes as they are at rest, least and most open: a range between which a haul's
    lies, for fish try at all times.
    """
    found = []
    for one in pulsing:
        last = one.last_period
        row: dict[str, Any] = {"case": one.least.case.number, "period_s": float(last["period_s"].iloc[0])}
        for name in ("speed_m_s", "drag_n", "opening_ahead_deg"):
            row |= {f"mean_{name}": float(last[name].iloc[:-1].mean())}
            row |= {f"least_{name}": float(last[name].min()), f"most_{name}": float(last[name].max())}
        row |= {f"{name}_by_half_steps": change for name, change in one.off.items()} | {"step_s": one.step_s}
        at_rest = next(result for result in study.cases if result.case.number == one.least.case.number)
        for fish in species:
            for words, result in (("rest", at_rest), ("least", one.least), ("most", one.most)):
                row[f"{fish.name}_l50_{words}_cm"] = _l50_cm(replace(study, cases=(result,)), fish)
        found.append(row)
    return pd.DataFrame(found)


def _l50_cm(study: Study, species: Species) -> float:
    (haul,) = hauls_of(catches_in(study, rows_needed(species)))
    return terms_of_catches(haul, species)[0].l50_sr()[0]
