"""Study files: TOML to ``Designs`` and species, every error on one line with the key and what is allowed."""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeGuard

import numpy as np

from catch_models.fish import Species
from codend.errors import InputError, all_at_once
from codend.io.names import as_name
from codend.io.toml import read_toml
from codend.plan.messages import is_counted, mistake_at
from codend.plan.numbers import numbers_of
from codend.plan.overrides import apply_values
from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.species import load_species
from codend.studies.designs import KEPT, SAMPLES, Axis, Base, Designs

MOST_DESIGNS: Final = 10_000_000
"""Days of solving; a list that makes more is a slip."""
KEYS: Final = ("title", "plan", "design", "species", "vary", "linked", "keep", "uncertain", "search")
DESIGN_KEYS: Final = ("name", "plan", "set")
RANGE_KEYS: Final = ("from", "to", "steps")
MOST_UNCERTAIN: Final = 0.5
"""Relative standard deviation; of more, proportions tell nothing."""
SAMPLE_KEYS: Final = ("sample", "size", "seed")


@dataclass(frozen=True)
class StudyPlan:
    """What a study file says."""

    source: str
    designs: Designs
    species: tuple[Species, ...]
    uncertain: Mapping[str, float] = field(default_factory=dict)
    """Relative standard deviations of numbers of the plans, by their keys."""
    search: Mapping[str, Any] | None = None
    """The table that ``codend search`` reads, as it stands."""
    species_of_files: Mapping[str, str] = field(default_factory=dict)
    """Names of species by those of their files, without ending."""


def load_study(path: str | Path) -> StudyPlan:
    """Read and check a study file.

    Raises:
        InputError: no such file, not TOML, a plan or species that cannot be used, anything ``study_from_dict`` refuses.
    """
    return study_from_dict(read_toml(path, "study file in TOML"), path)


def study_from_dict(data: Mapping[str, Any], source: str | Path = "study") -> StudyPlan:
    """Check a study's tables: ``plan`` or ``[[design]]``, and what varies; plans may be tables in place of files.

    Raises:
        InputError: unknown, missing, mistyped or contradictory keys: the first of them, with ``lines`` for all.
    """
    reader = _Reader(data, Path(source))
    bases = reader.bases()
    axes = [*reader.axes(bases), *reader.linked(bases)]
    sample, size, seed = reader.sample()
    keep = reader.keep(bases, {key for axis in axes for key in axis.keys})
    species = reader.species()
    uncertain = reader.uncertain(bases)
    search = reader.table("search", data["search"]) if "search" in data else None
    if sample is None:
        endless = [f"vary.{axis.keys[0]}.steps" for axis in axes if not axis.points]
        allowed = "a whole number from 2, or vary.sample"
        reader.errors += [InputError(source, key, None, allowed, "is missing") for key in endless]
    if reader.errors:
        raise all_at_once(reader.errors)
    designs = Designs(tuple(bases), tuple(axes), keep, sample, size, seed)
    if len(designs) > MOST_DESIGNS:
        raise InputError(source, "vary", None, f"at most {MOST_DESIGNS} designs", f"makes {len(designs)} designs")
    return StudyPlan(str(source), designs, tuple(species), uncertain, search, reader.species_of_files)


def looks_like_a_plan(data: Mapping[str, Any]) -> bool:
    """Whether tables are those of a plan and not of a study."""
    return any(key in data for key in Plan.model_fields if key not in KEYS) and "plan" not in data


class _Reader:
    """The tables of a study, read one by one; what is wrong is noted in ``errors``."""

    def __init__(self, data: Mapping[str, Any], source: Path) -> None:
        self.data, self.source = data, source
        self.errors: list[InputError] = []
        self.species_of_files: dict[str, str] = {}
        self._known("", data, KEYS)

    def _refuse(self, key: str, value: object, allowed: str, problem: str = "is not allowed") -> None:
        self.errors.append(InputError(self.source, key, value, allowed, problem))

    def _known(self, table: str, data: Mapping[str, Any], keys: Sequence[str]) -> None:
        """Note keys that a table does not have."""
        for key in data:
            if key not in keys:
                meant = next(iter(difflib.get_close_matches(key.lower(), keys, n=1)), None)
                home = next((name for name, own in _HOMES.items() if key in own), None)
                hint = f" (did you mean {meant}?)" if meant else f" (it is one of {home})" if home else ""
                self._refuse(f"{table}{key}", data[key], f"one of {', '.join(keys)}", f"is not a known key{hint}")

    def table(self, key: str, value: object) -> dict[str, Any]:
        if isinstance(value, Mapping):
            return dict(value)
        self._refuse(key, value, "a table")
        return {}

    def _tables(self, key: str) -> Iterator[tuple[str, dict[str, Any]]]:
        value = self.data.get(key, [])
        if not isinstance(value, list | tuple):
            self._refuse(key, value, f"tables [[{key}]]")
            return
        for number, item in enumerate(value):
            yield f"{key}.{number}", self.table(f"{key}.{number}", item)

    def bases(self) -> list[Base]:
        """The plans, checked whole; an error in one of their own files ends the reading."""
        designs = list(self._tables("design"))
        if "plan" not in self.data and not designs:
            self._refuse("plan", None, "the path of a plan, or tables [[design]]", "is missing")
        if not designs:
            return [self._base("", "plan", self.data["plan"], {})] if "plan" in self.data else []
        bases: list[Base] = []
        for number, (where, table) in enumerate(designs, start=1):
            self._known(f"{where}.", table, DESIGN_KEYS)
            name = table.get("name", str(number))
            if not isinstance(name, str) or not name.strip() or name in {base.name for base in bases}:
                self._refuse(f"{where}.name", name, "a text that no other design has")
                continue
            if "plan" not in table and "plan" not in self.data:
                self._refuse(f"{where}.plan", None, "the path of a plan, here or for all designs", "is missing")
                continue
            key = f"{where}.plan" if "plan" in table else "plan"
            changes = dict(_flat(self.table(f"{where}.set", table.get("set", {}))))
            bases.append(self._base(name, key, table.get("plan", self.data.get("plan")), changes, f"{where}.set."))
        return bases

    def _base(self, name: str, key: str, plan: Any, changes: Mapping[str, Any], where: str = "") -> Base:
        source, data = str(self.source), plan
        if isinstance(plan, str):
            source = str(self.source.parent / as_name(plan))
            data = read_toml(source, "TOML plan")
        elif not isinstance(plan, Mapping):
            raise InputError(self.source, key, plan, "the path of a plan, or its tables")
        plan_from_dict(data, source)
        if self._check_all(where, {k: [v] for k, v in changes.items()}, data):
            data = apply_values(data, [(tuple(k.split(".")), v) for k, v in changes.items()], source)
            plan_from_dict(data, source)
        return Base(name, data, source)

    def _check_all(self, where: str, changes: Mapping[str, Sequence[Any]], data: Mapping[str, Any]) -> bool:
        """Note values that a plan does not take at their keys; whether there are none."""
        before = len(self.errors)
        for key, values in changes.items():
            parts = key.split(".")
            try:
                apply_values(data, [(tuple(parts), values[0])], self.source)
            except InputError as error:
                self._refuse(f"{where}{key}", None, error.allowed, error.problem)
                continue
            location = [int(part) if part.isdecimal() else part for part in parts]
            found = (mistake_at(Plan, location, value, self.source, f"{where}{key}") for value in values)
            self.errors += [mistake for mistake in found if mistake is not None][:1]
        return len(self.errors) == before

    def axes(self, bases: Sequence[Base]) -> list[Axis]:
        """What ``[vary]`` says, an axis a key."""
        table = self.table("vary", self.data.get("vary", {}))
        axes = []
        for key, value in _flat({k: v for k, v in table.items() if k not in SAMPLE_KEYS}):
            where = f"vary.{key}"
            if isinstance(value, list | tuple) and value:
                points = list(value)
                self._twice(where, points)
            elif isinstance(value, Mapping):
                axis = self._range(where, key, value, bases)
                if axis is not None:
                    axes.append(axis)
                continue
            else:
                self._refuse(where, value, "a list of values, or { from = ..., to = ..., steps = ... }")
                continue
            if all([self._check_all("vary.", {key: points}, base.data) for base in bases[:1]]):
                axes.append(Axis((key,), tuple((point,) for point in points)))
        return axes

    def _twice(self, where: str, points: Sequence[Any]) -> None:
        if any(point in points[:i] for i, point in enumerate(points)):
            self._refuse(where, points, "each value once", "has a value twice")

    def _range(self, where: str, key: str, value: Mapping[str, Any], bases: Sequence[Base]) -> Axis | None:
        before = len(self.errors)
        self._known(f"{where}.", value, RANGE_KEYS)
        for name in ("from", "to"):
            if not _is_number(value.get(name)):
                problem = "is not allowed" if name in value else "is missing"
                self._refuse(f"{where}.{name}", value.get(name), "a number", problem)
        steps = value.get("steps")
        if steps is not None and not (_is_whole(steps) and 2 <= steps <= MOST_DESIGNS):
            self._refuse(f"{where}.steps", steps, "a whole number from 2: how many values, both ends among them")
        if len(self.errors) > before:
            return None
        low, high = value["from"], value["to"]
        if low >= high:
            self._refuse(f"{where}.to", high, f"above {low:g}, from")
        if not self._check_all("vary.", {key: [low, high]}, bases[0].data if bases else {}):
            return None
        counted = is_counted(Plan, [int(part) if part.isdecimal() else part for part in key.split(".")])
        if steps is None:
            return Axis((key,), (), low, high, counted)
        points = np.linspace(low, high, steps)
        # 3 to 6 in four steps gives 5, not 5.000000000000001
        values = [round(float(x)) if counted else float(f"{x:.12g}") for x in points]
        if len(set(values)) < len(values):
            self._refuse(f"{where}.steps", steps, f"at most {high - low + 1}: the key is a whole number")
        return Axis((key,), tuple((x,) for x in values))

    def linked(self, bases: Sequence[Base]) -> list[Axis]:
        """What ``[[linked]]`` says, an axis a table."""
        axes = []
        for where, table in self._tables("linked"):
            lists = dict(_flat(table))
            before = len(self.errors)
            for key, values in lists.items():
                if not isinstance(values, list | tuple) or not values:
                    self._refuse(f"{where}.{key}", values, "a list of values, as many as of the keys it changes with")
            if len(self.errors) > before or not lists:
                continue
            counts = {key: len(values) for key, values in lists.items()}
            first = next(iter(counts))
            for key, count in counts.items():
                if count != counts[first]:
                    self._refuse(f"{where}.{key}", list(lists[key]), f"{counts[first]} values, as {first} has")
            if len(self.errors) == before and self._check_all(f"{where}.", lists, bases[0].data if bases else {}):
                axes.append(Axis(tuple(lists), tuple(zip(*lists.values(), strict=True))))
        seen: set[str] = set(dict(_flat(self.table("vary", self.data.get("vary", {})))))
        for where, table in self._tables("linked"):
            for key, values in _flat(table):
                if key in seen:
                    self._refuse(f"{where}.{key}", values, "each key once", "varies twice")
                seen.add(key)
        return axes

    def sample(self) -> tuple[Any, int, int]:
        """Kind, size and seed of the sample; no kind for every combination."""
        table = self.table("vary", self.data.get("vary", {}))
        kind, size, seed = table.get("sample"), table.get("size"), table.get("seed", 0)
        if kind is not None and kind not in SAMPLES:
            meant = difflib.get_close_matches(str(kind).lower(), SAMPLES, n=1)
            hint = f' (did you mean "{meant[0]}"?)' if meant else ""
            self._refuse("vary.sample", kind, " or ".join(f'"{one}"' for one in SAMPLES), f"is not allowed{hint}")
        whole_size = size if _is_whole(size) else 0
        if kind is not None and not 1 <= whole_size <= MOST_DESIGNS:
            allowed = f"a whole number from 1 to {MOST_DESIGNS}: the points of the sample"
            self._refuse("vary.size", size, allowed, "is missing" if size is None else "is not allowed")
        if kind is None and size is not None:
            self._refuse("vary.size", size, "together with vary.sample")
        if not (_is_whole(seed) and seed >= 0):
            self._refuse("vary.seed", seed, "a whole number from 0")
        if kind is not None and not any(key for key in table if key not in SAMPLE_KEYS) and "linked" not in self.data:
            self._refuse("vary.sample", kind, "together with keys to vary")
        return kind, whole_size, seed

    def keep(self, bases: Sequence[Base], varied: set[str]) -> dict[str, str]:
        """What ``[keep]`` says: counts that follow, and from what."""
        kept = {}
        for key, value in _flat(self.table("keep", self.data.get("keep", {}))):
            where = f"keep.{key}"
            if value not in KEPT:
                meant = difflib.get_close_matches(str(value).lower(), KEPT, n=1)
                hint = f' (did you mean "{meant[0]}"?)' if meant else ""
                self._refuse(where, value, " or ".join(f'"{one}"' for one in KEPT), f"is not allowed{hint}")
            elif not key.startswith("netting.") or key.split(".")[2:] != [KEPT[value]]:
                self._refuse(where, value, f"the key netting.NUMBER.{KEPT[value]}, which keeps it")
            elif key in varied:
                self._refuse(where, value, "a key that does not vary itself", "varies as well")
            elif self._check_all("keep.", {key: [3]}, bases[0].data if bases else {}):
                kept[key] = value
        return kept

    def species(self) -> list[Species]:
        """The species, from files or as they are; a mistake in one of their own files ends the reading."""
        value = self.data.get("species", [])
        if not isinstance(value, list | tuple):
            value = [value]
        species: list[Species] = []
        for number, item in enumerate(value):
            if not isinstance(item, str | Species):
                self._refuse(f"species.{number}", item, "the path of a species file")
                continue
            one = load_species(self.source.parent / as_name(item)) if isinstance(item, str) else item
            if one.name in {other.name for other in species}:
                self._refuse(f"species.{number}", item, "each species once", "is named twice")
            species.append(one)
            if isinstance(item, str):
                self.species_of_files[Path(item).stem] = one.name
        return species

    def uncertain(self, bases: Sequence[Base]) -> dict[str, float]:
        """What ``[uncertain]`` says: relative standard deviations of numbers that the plans give."""
        found = {}
        for key, value in _flat(self.table("uncertain", self.data.get("uncertain", {}))):
            where = f"uncertain.{key}"
            if not _is_number(value) or not 0.0 < value <= MOST_UNCERTAIN:
                allowed = f"a number above 0, at most {MOST_UNCERTAIN:g}: a standard deviation over the number itself"
                self._refuse(where, value, allowed)
                continue
            for base in bases:
                plan = plan_from_dict(base.data, base.source)
                known = [number.key for number in numbers_of(plan, plan.cases()[0])]
                if key not in known:
                    meant = next(iter(difflib.get_close_matches(key, known, n=1)), None)
                    hint = f" (did you mean {meant}?)" if meant else ""
                    self._refuse(where, None, f"one of {', '.join(known)}", f"is no number that the plan gives{hint}")
                    break
            else:
                found[key] = float(value)
        return found


_HOMES: Final = {"[vary]": SAMPLE_KEYS, "[[design]]": DESIGN_KEYS}


def _flat(table: Mapping[str, Any], ahead: str = "") -> Iterator[tuple[str, Any]]:
    """Keys with all their parts, whether quoted whole or written as tables in tables; ranges stay whole."""
    for key, value in table.items():
        if isinstance(value, Mapping) and not any(name in value for name in RANGE_KEYS):
            yield from _flat(value, f"{ahead}{key}.")
        else:
            yield f"{ahead}{key}", value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))


def _is_whole(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool)
