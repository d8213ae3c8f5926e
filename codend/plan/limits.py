"""Limits that a user's file states, and how a plan stands to them; the program ships none.

A file holds ``[[limit]]`` tables, each with a quantity, its least or most, and where the limit comes from.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final, Literal, Self

from annotated_types import Ge, MinLen
from pydantic import model_validator

from codend.errors import InputError
from codend.io.toml import read_toml
from codend.plan.messages import Contradiction
from codend.plan.mistakes import checked
from codend.plan.plan import Plan
from codend.plan.tables import Netting, Number, Table, Text

Quantity = Literal[
    "inside_mesh_mm", "full_mesh_mm", "meshes_round", "open_meshes_round", "meshes_long", "twine_mm", "twines"
]
MEASURED: Final[dict[str, Callable[[Netting], tuple[float, float]]]] = {
    "inside_mesh_mm": lambda part: (1000 * part.inside_mesh_m,) * 2,
    "full_mesh_mm": lambda part: (1000 * part.full_mesh_m,) * 2,
    "meshes_round": lambda part: (part.meshes_round, part.aft_meshes_round),
    "open_meshes_round": lambda part: part.open_meshes,
    "meshes_long": lambda part: (part.meshes_long,) * 2,
    "twine_mm": lambda part: (1000 * part.twine_m,) * 2,
    "twines": lambda part: (part.twines,) * 2,
}
"""What is held to a limit, at the fore and at the aft end of a section."""
OF_PIECES: Final = ("inside_mesh_mm", "full_mesh_mm", "twine_mm", "twines")
"""What windows and layers are held to as well: fish meet their meshes too."""
_BY_ROUNDING: Final = 1e-9


class Limit(Table):
    """The least or the most of a quantity that is allowed, and by whom."""

    quantity: Quantity
    """What is limited."""
    source: Text
    """Where the limit comes from."""
    least: Annotated[Number, Ge(0)] | None = None
    """No less is allowed."""
    most: Annotated[Number, Ge(0)] | None = None
    """No more is allowed."""
    section: Text | None = None
    """The section, window or layer that it is for, by name or number; left out: all of them."""

    @model_validator(mode="after")
    def _can_be_kept(self) -> Self:
        if self.least is None and self.most is None:
            raise Contradiction("least", "least or most, or both", "is missing")
        if self.least is not None and self.most is not None and self.least > self.most:
            raise Contradiction("least", f"at most {self.most:g}, the most")
        if not (self.source.isprintable() and self.source.strip()):
            raise Contradiction("source", "a text of one line")
        return self


class Limits(Table):
    """A file of limits."""

    title: Text = "limits"
    limit: Annotated[tuple[Limit, ...], MinLen(1)]


@dataclass(frozen=True)
class Finding:
    """How a section, window or layer stands to a limit."""

    section: str
    limit: Limit
    found: float
    kept: bool

    @property
    def words(self) -> str:
        """In one line; what breaks a limit in as many digits as tell it from the limit."""
        limit = self.limit
        bounds = {
            word: f"{value:.10g}" for word, value in (("least", limit.least), ("most", limit.most)) if value is not None
        }
        verdict = "kept" if self.kept else "NOT KEPT"
        texts = [f"{self.found:.{digits}g}" for digits in (4, 6, 12)]
        found = next((text for text in texts if self.kept or text not in bounds.values()), texts[-1])
        allowed = ", ".join(f"{word} {bound}" for word, bound in bounds.items())
        return f"{verdict}: {limit.quantity} of {self.section} is {found}, {allowed} ({limit.source})"


def held_to(plan: Plan, path: str | Path) -> list[Finding]:
    """Every section, window and layer of a plan beside every limit of a file that is for it.

    Raises:
        InputError: no such file, or it says what limits cannot be.
    """
    limits = checked(Limits, read_toml(path, "TOML file of limits"), path)
    sections = list(zip(plan.section_names, plan.netting, strict=True))
    pieces = [*zip(plan.window_names, plan.window, strict=True), *zip(plan.layer_names, plan.layer, strict=True)]
    found: list[Finding] = []
    for number, limit in enumerate(limits.limit):
        netting = sections + pieces if limit.quantity in OF_PIECES else sections
        named = [name for name, _ in netting]
        if limit.section is not None and limit.section not in named:
            raise InputError(path, f"limit.{number}.section", limit.section, ", ".join(named))
        found += [_finding(name, part, limit) for name, part in netting if limit.section in (None, name)]
    return found


def _finding(name: str, part: Netting, limit: Limit) -> Finding:
    low, high = sorted(MEASURED[limit.quantity](part))
    short = limit.least is not None and low < limit.least * (1 - _BY_ROUNDING)
    over = limit.most is not None and high > limit.most * (1 + _BY_ROUNDING)
    return Finding(name, limit, low if short or limit.most is None else high, not (short or over))
