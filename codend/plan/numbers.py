"""The numbers of a plan that answers depend on, by their keys, and the plan with one of them changed."""

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Final

from pydantic import BaseModel

from codend.plan.plan import Case, Plan, plan_from_dict

TABLES: Final = ("tow", "entry", "netting", "window", "layer", "strap", "rope", "catch", "drag")
"""Tables of a plan that say what the gear is and how it is towed."""
ALWAYS: Final = ("tow.water_density_kg_m3", "drag.normal", "drag.tangential")
"""Numbers that are told of also where the plan leaves them to their defaults."""
PLACES: Final = ("meshes_from_codline", "spacing_meshes")
"""Numbers that are rows of knots: they change by whole meshes, as counts do."""
NO_KNOT: Final = ("knot_mm", 0.0)
"""A number that at this value stands for something else: knots that are points, of which nothing is known."""


@dataclass(frozen=True)
class PlanNumber:
    """A number of a plan."""

    key: str
    """Its parts with dots between them, positions counted from 0; of speeds and catches, which a case has one of each,
    without a position."""
    value: float
    counted: bool
    """Whether it changes by whole numbers only."""


def numbers_of(plan: Plan, case: Case) -> tuple[PlanNumber, ...]:
    """The numbers that a plan names, with the speed and the catch of one of its cases; those of its model left out."""
    found = [
        PlanNumber("tow.speed_m_s", case.speed_m_s, False),
        PlanNumber(f"catch.{case.catch_kind}", case.catch_value, False),
    ]
    for name in TABLES:
        table = getattr(plan, name, ())
        if isinstance(table, BaseModel):
            found += _numbers(name, table)
        else:
            for place, one in enumerate(table):
                found += _numbers(f"{name}.{place}", one)
    return tuple(found)


def _numbers(ahead: str, table: BaseModel) -> Iterator[PlanNumber]:
    for name in type(table).model_fields:
        key, value = f"{ahead}.{name}", getattr(table, name)
        if name not in table.model_fields_set and key not in ALWAYS:
            continue
        if isinstance(value, tuple) and name in PLACES:
            yield from (PlanNumber(f"{key}.{place}", float(one), True) for place, one in enumerate(value))
        elif isinstance(value, int) and not isinstance(value, bool):
            yield PlanNumber(key, value, True)
        elif isinstance(value, float) and (name, value) != NO_KNOT and not _of_no_law(key, table):
            yield PlanNumber(key, value, name in PLACES)


def _of_no_law(key: str, table: BaseModel) -> bool:
    """Whether a number belongs to a pressure law that the catch does not have."""
    return key == "catch.coefficient" and getattr(table, "pressure", None) == "sphere"


def alone(plan: Plan, case: Case) -> Plan:
    """The plan of one of a plan's cases."""
    tables = plan.to_dict()
    tables["tow"]["speed_m_s"] = [case.speed_m_s]
    tables["catch"][case.catch_kind] = [case.catch_value]
    return plan_from_dict(tables, plan.source)


def changed(plan: Plan, key: str, value: float) -> Plan:
    """The plan of one case with one of its numbers changed.

    Raises:
        InputError: the plan does not allow it.
    """
    tables = deepcopy(plan.to_dict())
    *parents, last = key.split(".")
    table: Any = tables
    for part in parents:
        table = table[int(part)] if isinstance(table, list) else table[part]
    if isinstance(table, list):
        table[int(last)] = value
    else:
        table[last] = [value] if isinstance(table.get(last), list) else value
    return plan_from_dict(tables, plan.source)
