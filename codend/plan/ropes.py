"""Ropes along the netting of a codend, and the selvedges between its panels, which are cords of netting taken up."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le, Lt
from pydantic import model_validator

from codend.plan.messages import Contradiction
from codend.plan.tables import Netting, Number, Table, Whole


class Rope(Table):
    """Equal ropes along the netting at equal angles, laced to its knots; truly no compression."""

    kind: Literal["lastridge"] = "lastridge"
    """The only kind there is: along the netting."""
    number: Annotated[Whole, Ge(1), Le(100)]
    """How many, at equal angles."""
    shortening: Annotated[Number, Gt(-1), Lt(0.9)]
    """By how much the rope is shorter than the stretched netting it is laced to, relative; below 0 it is longer."""
    diameter_mm: Annotated[Number, Gt(0), Le(500)] | None = None
    """None: no drag of its own."""
    axial_stiffness_n: Annotated[Number, Gt(0), Le(1e9)] | None = None
    """EA of one rope, N; None: inextensible."""
    density_kg_m3: Annotated[Number, Ge(100), Le(20_000)] | None = None
    """Of its material; None: that of the water."""
    meshes_from_codline: tuple[Annotated[Number, Ge(0)], Annotated[Number, Gt(0)]] | None = None
    """Where it runs; None: from the codline to the entry."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.density_kg_m3 is not None and self.diameter_mm is None:
            raise Contradiction("density_kg_m3", "only with diameter_mm, without which the rope has no weight")
        ends = self.meshes_from_codline
        if ends is not None and ends[0] >= ends[1]:
            raise Contradiction("meshes_from_codline", "the end nearer to the codline first, as in [0, 50]")
        return self

    @property
    def diameter_m(self) -> float:
        """Diameter of the rope, 0 where the plan gives none, m."""
        return 0.0 if self.diameter_mm is None else self.diameter_mm / 1000

    @property
    def solid_diameter_m(self) -> float:
        """Diameter of the round section of its material, m."""
        return self.diameter_m


def places_round(number: int, columns: int) -> list[float]:
    """Places of equal ropes, as shares of the way round: the nearest of so many columns of knots, or half beside."""
    return [math.floor(2 * rope / number * columns + 0.5 + 1e-9) / (2 * columns) for rope in range(number)]


@dataclass(frozen=True)
class Selvedge:
    """The cords that the meshes taken up along the seams of a section make: as ropes as long as the stretched netting.

    Their twines are taken to lie in one round bundle (assumed).
    """

    number: int
    """Seams."""
    twines: int
    """Bars that lie side by side in a cord."""
    diameter_m: float
    solid_diameter_m: float
    axial_stiffness_n: float | None
    density_kg_m3: float | None
    meshes_from_codline: tuple[float, float]
    shortening: float = 0.0
    kind: str = "selvedge"


def selvedges_of(netting: Sequence[Netting]) -> Iterator[Selvedge]:
    """Selvedges of the sections that have any, from the entry."""
    to_codline = sum(part.meshes_long for part in netting)
    for part in netting:
        fore, to_codline = to_codline, to_codline - part.meshes_long
        if part.selvedge_meshes == 0:
            continue
        # two edges of so many meshes, each of two bars from row to row, in square mesh of one
        bars = 2 * part.rows_per_mesh * part.selvedge_meshes
        yield Selvedge(
            number=part.panels,
            twines=bars,
            diameter_m=math.sqrt(bars * part.twines) * part.twine_m,
            solid_diameter_m=math.sqrt(bars) * part.solid_diameter_m,
            axial_stiffness_n=None if part.axial_stiffness_n is None else bars * part.axial_stiffness_n,
            density_kg_m3=part.density_kg_m3,
            meshes_from_codline=(float(to_codline), float(fore)),
        )
