"""Ropes along the netting of a codend."""

from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le, Lt
from pydantic import model_validator

from codend.plan.messages import Contradiction
from codend.plan.tables import Number, Table, Whole


class Rope(Table):
    """Equal ropes along the netting at equal angles, laced to its knots; truly no compression."""

    kind: Literal["lastridge"] = "lastridge"
    """The only kind there is: along the netting."""
    number: Annotated[Whole, Ge(1), Le(100)]
    """How many, at equal angles."""
    shortening: Annotated[Number, Gt(-1), Lt(0.9)]
    """By how much the rope is shorter than the stretched netting it is laced to, relative; below 0 it is longer."""
    diameter_mm: Annotated[Number, Gt(0), Le(500)] | None = None
    """None: its drag is left out."""
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
