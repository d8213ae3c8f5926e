"""What a search is asked: the table ``[search]`` of a study file, checked against the plan that it starts from."""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from catch_models.fish import Species
from codend.errors import InputError, all_at_once
from codend.net.net import Floats
from codend.plan.numbers import PlanNumber, numbers_of
from codend.plan.overrides import CATCH_QUANTITIES, apply_values
from codend.plan.plan import Plan, plan_from_dict
from codend.studies.catches_solved import OF_FISH
from codend.studies.sensitivity.solved_case import OF_NETS
from codend.studies.study_file import StudyPlan

KEYS: Final = ("change", "target", "limits", "within")
BOUNDS: Final = ("least", "most")
WITHIN: Final = 0.25
"""How far a number may change where nothing limits it, relative."""


@dataclass(frozen=True)
class Variable:
    """A number that may change."""

    number: PlanNumber
    least: float
    most: float
    step: float | None
    """Between its values, counted from the least; None where any is allowed."""

    @property
    def size(self) -> float:
        """What changes are relative to: the plan's own value, or where that is 0 the way between its bounds."""
        return abs(float(self.number.value)) or self.most - self.least

    @property
    def values(self) -> Floats:
        """All its values, the one nearest to the plan's own first; of one without a step none."""
        if self.step is None:
            return np.zeros(0)
        count = int((self.most - self.least) / self.step + 1e-9)
        values = self.least + self.step * np.arange(count + 1)
        return np.asarray(values[np.argsort(np.abs(values - self.number.value), kind="stable")])

    def written(self, value: float) -> float | int:
        """A value as a plan has it: a count whole, another number to six digits."""
        if isinstance(self.number.value, int):
            return round(value)
        return float(f"{value:.12g}") if self.step is not None else float(f"{value:.6g}")


@dataclass(frozen=True)
class Condition:
    """A bound on what a case tells."""

    quantity: str
    """By the name of its column."""
    bound: float
    sign: float
    """1 where it is the least, -1 where the most."""

    def margin(self, value: float) -> float:
        """By how much a value keeps the bound, relative to it; below 0 where it does not."""
        return self.sign * (value - self.bound) / (abs(self.bound) or 1.0)

    @property
    def words(self) -> str:
        """The bound as it is told."""
        return f"{self.quantity} {'at least' if self.sign > 0.0 else 'at most'} {self.bound:g}"


@dataclass(frozen=True)
class Asked:
    """A search, ready to be made."""

    plan: Plan
    """Where it starts, with the catches and speeds at which the target is asked."""
    variables: tuple[Variable, ...]
    conditions: tuple[Condition, ...]
    """Limits, and targets that are bounds."""
    reach: Mapping[str, float]
    """Targets that are numbers, by quantity: to be reached from the side on which the plan is."""
    species: tuple[Species, ...]
    keep: Mapping[str, str]
    """Counts that follow, as ``[keep]`` has them."""
    data: Mapping[str, Any]
    """The tables of the plan."""


def asked_of(study: StudyPlan) -> Asked:
    """Check what a study file says of its search.

    Raises:
        InputError: it has none, or anything in it is unknown, missing or contradictory.
    """
    source, designs = study.source, study.designs
    if study.search is None:
        raise InputError(source, "search", None, "a table with change and target", "is missing")
    if len(designs.bases) > 1 or designs.axes:
        key = "design" if len(designs.bases) > 1 else "vary"
        raise InputError(
            source, key, None, "one plan; what may change is named in search.change", "is not for a search"
        )
    return _Reader(study, study.search).asked()


class _Reader:
    """Reads the table, and notes what is wrong in it."""

    def __init__(self, study: StudyPlan, table: Mapping[str, Any]) -> None:
        self.study, self.table, self.errors = study, table, list[InputError]()
        self.base = study.designs.bases[0]
        self._known("search.", table, KEYS)

    def asked(self) -> Asked:
        """What is asked, all checked."""
        target = self._table("search.target", self.table.get("target"))
        limits = {key: self._table(f"search.limits.{key}", value) for key, value in self._limits()}
        data = apply_values(self.base.data, list(self._cases(target)), self.base.source)
        plan = plan_from_dict(data, self.study.source)
        variables = self._variables(plan, limits)
        names = [one.number.key for one in variables]
        conditions: list[Condition] = []
        reach: dict[str, float] = {}
        species = self._species(target)
        for key, value in target.items():
            if key in OF_NETS + OF_FISH:
                if isinstance(value, Mapping):
                    conditions += self._conditions(f"search.target.{key}", key, value)
                elif _is_number(value):
                    reach[key] = float(value)
                else:
                    self._refuse(f"search.target.{key}", value, "a number, or { least = ..., most = ... }")
        if not reach and not conditions:
            allowed = f"one of {', '.join(OF_NETS + OF_FISH)}, with a number or a bound to reach"
            self._refuse("search.target", None, allowed, "names nothing to reach")
        for key, value in limits.items():
            if key in OF_NETS + OF_FISH:
                conditions += self._conditions(f"search.limits.{key}", key, value)
            elif key not in names and key not in self.table.get("change", ()):
                allowed = f"one of {', '.join((*OF_NETS, *OF_FISH, *names))}"
                self._refuse(f"search.limits.{key}", None, allowed, "is neither told of a case nor among search.change")
        wanted = {one.quantity for one in conditions} | set(reach)
        if not self.study.species and (fish := sorted(wanted & set(OF_FISH))):
            self._refuse("species", None, f"a species, whose {fish[0]} is asked", "is missing")
        if self.study.designs.keep and any(one.step is None for one in variables):
            free = next(one.number.key for one in variables if one.step is None)
            allowed = "a step for every number, in search.limits, where [keep] lets counts follow by leaps"
            self._refuse(f"search.limits.{free}", None, allowed, "has no step")
        if self.errors:
            raise all_at_once(self.errors)
        return Asked(plan, tuple(variables), tuple(conditions), reach, species, self.study.designs.keep, data)

    def _refuse(self, key: str, value: object, allowed: str, problem: str = "is not allowed") -> None:
        self.errors.append(InputError(self.study.source, key, value, allowed, problem))

    def _known(self, ahead: str, table: Mapping[str, Any], keys: Sequence[str]) -> None:
        for key in table:
            if key not in keys:
                meant = next(iter(difflib.get_close_matches(key, keys, n=1)), None)
                hint = f" (did you mean {meant}?)" if meant else ""
                self._refuse(f"{ahead}{key}", table[key], f"one of {', '.join(keys)}", f"is not a known key{hint}")

    def _table(self, key: str, value: object) -> dict[str, Any]:
        if isinstance(value, Mapping):
            return dict(value)
        self._refuse(key, value, "a table", "is missing" if value is None else "is not allowed")
        return {}

    def _limits(self) -> Iterator[tuple[str, Any]]:
        """Limits by their keys, whether quoted whole or written as tables in tables."""

        def flat(table: Mapping[str, Any], ahead: str) -> Iterator[tuple[str, Any]]:
            for key, value in table.items():
                inner = isinstance(value, Mapping) and not any(name in value for name in (*BOUNDS, "step"))
                if inner:
                    yield from flat(value, f"{ahead}{key}.")
                else:
                    yield f"{ahead}{key}", value

        return flat(self._table("search.limits", self.table.get("limits", {})), "")

    def _cases(self, target: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], Any]]:
        """Catches and speeds of the target, as changes to the plan."""
        self._known("search.target.", target, (*OF_NETS, *OF_FISH, "species", "speed_m_s", *CATCH_QUANTITIES))
        for key, value in target.items():
            if key in CATCH_QUANTITIES:
                yield ("catch", key), value
            if key == "speed_m_s":
                yield ("tow", key), value

    def _species(self, target: Mapping[str, Any]) -> tuple[Species, ...]:
        known = {one.name: one for one in self.study.species}
        name = target.get("species")
        if name is None:
            if len(known) > 1:
                self._refuse("search.target.species", None, f"one of {', '.join(known)}", "is missing")
            return tuple(known.values())[:1]
        one = known.get(str(name)) or known.get(self.study.species_of_files.get(str(name), ""))
        if one is None:
            self._refuse("search.target.species", name, f"one of {', '.join(known) or 'the species of the study'}")
            return ()
        return (one,)

    def _variables(self, plan: Plan, limits: Mapping[str, Mapping[str, Any]]) -> list[Variable]:
        keys = self.table.get("change")
        if not isinstance(keys, list | tuple) or not keys or not all(isinstance(key, str) for key in keys):
            problem = "is missing" if keys is None else "is not allowed"
            self._refuse("search.change", keys, "a list of keys of the plan that may change", problem)
            return []
        within = self.table.get("within", WITHIN)
        if not _is_number(within) or not 0.0 < within < 1.0:
            self._refuse("search.within", within, "a number between 0 and 1: how far a number may change, relative")
            return []
        known = {number.key: number for number in numbers_of(plan, plan.cases()[0])}
        several = set[str]()
        if len(plan.tow.speed_m_s) > 1:
            several.add("tow.speed_m_s")
        if len(plan.catch.sizes) > 1:
            several.add(f"catch.{plan.catch.kind}")
        found = []
        for place, key in enumerate(keys):
            if key not in known or key in several:
                problem = "has several values" if key in several else "is no number that the plan gives"
                allowed = f"one of {', '.join(one for one in known if one not in several)}"
                self._refuse(f"search.change.{place}", key, allowed, problem)
                continue
            variable = self._variable(known[key], limits.get(key, {}), float(within))
            if variable is not None:
                found.append(variable)
        return found

    def _variable(self, number: PlanNumber, limits: Mapping[str, Any], within: float) -> Variable | None:
        where = f"search.limits.{number.key}"
        before = len(self.errors)
        self._known(f"{where}.", limits, (*BOUNDS, "step"))
        for name, value in limits.items():
            if not _is_number(value) or (name == "step" and value <= 0.0):
                self._refuse(f"{where}.{name}", value, "a number" + (" above 0" if name == "step" else ""))
        if len(self.errors) > before:
            return None
        reach = within * abs(number.value)
        least, most = limits.get("least", number.value - reach), limits.get("most", number.value + reach)
        if not least <= number.value <= most:
            self._refuse(where, dict(limits), f"bounds with the plan's own {number.value:g} between them")
            return None
        if reach == 0.0 and not {"least", "most"} <= limits.keys():
            self._refuse(where, dict(limits), "least and most, for the plan's own value is 0")
            return None
        step = limits.get("step", 1.0 if number.counted else None)
        if step is not None and "least" not in limits:
            least = number.value - step * int((number.value - least) / step + 1e-9)
        if number.counted and (least != round(least) or step != round(step)):
            self._refuse(where, dict(limits), "whole numbers, for the key is one")
            return None
        return Variable(number, float(least), float(most), step)

    def _conditions(self, where: str, quantity: str, bounds: Mapping[str, Any]) -> Iterator[Condition]:
        self._known(f"{where}.", bounds, BOUNDS)
        for name, sign in (("least", 1.0), ("most", -1.0)):
            if name not in bounds:
                continue
            if _is_number(bounds[name]):
                yield Condition(quantity, float(bounds[name]), sign)
            else:
                self._refuse(f"{where}.{name}", bounds[name], "a number")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))
