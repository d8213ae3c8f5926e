"""What the user said: a TOML plan of a codend and its tow, checked once and immutable ever after.

All checks are made by ``plan_from_dict``, wherever the plan came from, and end in one ``InputError``.
"""

import math
import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

from annotated_types import MinLen
from pydantic import PrivateAttr, ValidationError, model_validator

from codend.errors import InputError
from codend.io.names import as_name
from codend.io.text import read_text
from codend.plan.messages import Contradiction, input_error
from codend.plan.overrides import CatchKind, apply_overrides
from codend.plan.reach import least_radius_m
from codend.plan.tables import Catch, Drag, Entry, Model, Netting, Strap, Table, Text, Tow


@dataclass(frozen=True)
class Case:
    """One speed and one catch of a plan."""

    number: int
    """Counted from 1."""
    speed_m_s: float
    catch_kind: CatchKind
    catch_value: float
    """In the unit of ``catch_kind``."""


class Plan(Table):
    """A whole plan: the sections of netting run from the entry to the codline."""

    title: Text
    tow: Tow
    entry: Entry
    netting: Annotated[tuple[Netting, ...], MinLen(1)]
    strap: tuple[Strap, ...] = ()
    catch: Catch
    drag: Drag = Drag.model_validate({})
    model: Model = Model()
    _source: Path = PrivateAttr(default=Path("plan"))

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        first = self.netting[0]
        limit_m = first.stretched_radius_m
        if self.entry.radius_m > limit_m or (self.entry.radius_m == limit_m and first.mesh != "square"):
            raise Contradiction(
                "entry.radius_m", f"below {limit_m:.4g} m, that of the first section's meshes pulled fully open"
            )
        self._check_catch_fits()
        self._check_straps()
        self._check_closes()
        if self.model.globalisation not in (divisors := self.globalisations):
            allowed = ", ".join(map(str, divisors))
            and_straps = ", and of the rows from every strap to the codline" if self.strap else ""
            reason = f"divisors of all meshes_round and meshes_long{and_straps}"
            raise Contradiction("model.globalisation", f"{allowed} ({reason})")
        return self

    def _check_catch_fits(self) -> None:
        """Refuse a catch beyond what the netting could hold whatever its shape: errors of unit, mostly."""
        hold_m3 = sum(math.pi * part.stretched_radius_m**2 * part.stretched_length_m for part in self.netting)
        most = {
            "filled_meshes": (float(sum(part.meshes_long for part in self.netting)), "the sum of meshes_long"),
            "volume_m3": (hold_m3, "a cylinder of the netting stretched both ways"),
            "mass_kg": (hold_m3 * self.catch_density_kg_m3, "a cylinder of the netting stretched both ways"),
            "front_from_codline_m": (
                sum(part.stretched_length_m for part in self.netting),
                "the netting stretched lengthwise",
            ),
        }
        limit, reason = most[self.catch.kind]
        for index, size in enumerate(self.catch.sizes):
            if size > limit:
                raise Contradiction(f"catch.{self.catch.kind}.{index}", f"above 0, at most {limit:.6g}, {reason}")

    def _check_straps(self) -> None:
        """Refuse straps that lie on no row of knots, or two on one."""
        meshes_long = sum(part.meshes_long for part in self.netting)
        for index, strap in enumerate(self.strap):
            key = f"strap.{index}.meshes_from_codline"
            if strap.meshes_from_codline >= meshes_long:
                raise Contradiction(key, f"below {meshes_long}, the sum of meshes_long")
            if self.rows_to_codline(strap.meshes_from_codline) is None:
                raise Contradiction(key, "a row of knots: whole meshes, or half ones in diamond and T90 netting")
            if strap.meshes_from_codline in [other.meshes_from_codline for other in self.strap[:index]]:
                raise Contradiction(key, "a row that has no other strap")

    def _check_closes(self) -> None:
        """Refuse netting too short to be gathered at the axis, even laid flat across the entry."""
        gap_m = least_radius_m(self.netting, self.entry.radius_m, 0)
        if gap_m > 0.0:
            allowed = f"more: laid flat the netting ends {gap_m:.3g} m short of the axis, where the codline gathers it"
            raise Contradiction(f"netting.{len(self.netting) - 1}.meshes_long", allowed)

    def rows_to_codline(self, meshes: float) -> int | None:
        """Rows from the codline to a place that many meshes ahead of it; None where no row of knots lies there."""
        rows = 0
        for part in reversed(self.netting):
            if meshes <= part.meshes_long:
                there = part.rows_per_mesh * meshes
                return rows + int(there) if there == int(there) else None
            rows += part.rows_per_mesh * part.meshes_long
            meshes -= part.meshes_long
        return None

    @property
    def strap_rows(self) -> tuple[int, ...]:
        """Rows from every strap to the codline."""
        rows = (self.rows_to_codline(strap.meshes_from_codline) for strap in self.strap)
        return tuple(count for count in rows if count is not None)

    @property
    def source(self) -> Path:
        """The file the plan came from."""
        return self._source

    @property
    def catch_density_kg_m3(self) -> float:
        """Density of the catch: its own, or the water's when the plan gives none."""
        return self.catch.density_kg_m3 or self.tow.water_density_kg_m3

    @property
    def sphere_cp_path(self) -> Path | None:
        """The user's own Cp curve for the sphere law; None for the one that is shipped."""
        return None if self.catch.sphere_cp_csv is None else self.source.parent / as_name(self.catch.sphere_cp_csv)

    @property
    def globalisations(self) -> tuple[int, ...]:
        """Meshes that can be merged, each way: divisors of every mesh count that leave at least 3 meshes round.

        Rows that carry a strap stay rows.
        """
        counts = [count for part in self.netting for count in (part.meshes_round, part.meshes_long)]
        common = math.gcd(*counts, *self.strap_rows)
        most = min(part.meshes_round for part in self.netting) // 3
        return tuple(g for g in range(1, min(common, most) + 1) if common % g == 0)

    def cases(self) -> tuple[Case, ...]:
        """Every speed with every catch, catches running fastest."""
        pairs = [(speed, size) for speed in self.tow.speed_m_s for size in self.catch.sizes]
        return tuple(Case(n, speed, self.catch.kind, size) for n, (speed, size) in enumerate(pairs, start=1))

    def to_dict(self) -> dict[str, Any]:
        """Plain tables, defaults filled in and absent keys left out; ``plan_from_dict`` reads them back."""
        return self.model_dump(mode="json", exclude_none=True)


def load_plan(path: str | Path, overrides: Sequence[str] = ()) -> Plan:
    """Read a TOML plan, lay ``overrides`` such as ``"netting.0.bar_mm=25"`` over it, and check the result.

    Raises:
        InputError: no such file, not TOML, or anything ``plan_from_dict`` refuses.
    """
    return plan_from_dict(_read_toml(path), path, overrides)


def _read_toml(path: str | Path) -> dict[str, Any]:
    text = read_text(path, "TOML plan")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(path, "", None, "a TOML plan", "is not a plan: arrays or tables nested too deep") from None
    except ValueError as error:
        lines = len(text.splitlines())
        problem = str(error).replace("at end of document", f"at line {lines}, the end")
        raise InputError(path, "", None, "a TOML plan", f"is not TOML: {problem}") from None


def plan_from_dict(data: Mapping[str, Any], source: str | Path = "plan", overrides: Sequence[str] = ()) -> Plan:
    """Check tables as ``tomllib`` returns them, after ``overrides`` (see ``apply_overrides`` for their rules).

    Raises:
        InputError: an unknown, missing, mistyped, out-of-range or contradictory key; a Cp curve that is no file.
    """
    changed = apply_overrides(data, overrides, source)
    try:
        plan = Plan.model_validate(changed)
    except ValidationError as error:
        raise input_error(error, Plan, changed, source) from None
    plan._source = Path(source)
    # os.path.isfile, unlike Path.is_file, is False and not an error for names no file can have
    if plan.sphere_cp_path is not None and not os.path.isfile(plan.sphere_cp_path):
        value = plan.catch.sphere_cp_csv
        raise InputError(source, "catch.sphere_cp_csv", value, "a CSV file, its path relative to the plan's folder")
    return plan
