"""The tables [frame], [[float]] and [ballast] of a scene: what a cage hangs on, what keeps it open."""

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le, MinLen
from pydantic import model_validator

from codend.plan.messages import Contradiction
from codend.plan.tables import Number, Table, Text
from codend.scenes.tables import Vector

FRAME = "frame"
"""What points and edges name that are fastened to the frame, and what tables call it."""
_Sides = tuple[Annotated[Number, Ge(0)], Annotated[Number, Ge(0)], Annotated[Number, Ge(0)]]


class FrameTable(Table):
    """A rigid frame to which points and edges of netting are fastened that say `"frame"`; places are as it is placed.

    It is held, or floats with six unknowns on its `[[float]]` tables. Drag and more weights are those of points on it.
    """

    hold: Literal["held", "floating"] = "held"
    """Whether it stays where it is, and what holds it is told; or floats."""
    at: Vector = (0.0, 0.0, 0.0)
    """Its origin: what is told of its place, and about which moments are."""
    mass_kg: Annotated[Number, Ge(0), Le(1e7)] = 0.0
    """In air, without its floats and points."""
    centre: Vector | None = None
    """Its centre of mass; None: its origin."""
    inertia_kg_m2: _Sides = (0.0, 0.0, 0.0)
    """Of that mass about its centre and the axes x, y and z; counts in motion only."""
    added_mass_kg: _Sides = (0.0, 0.0, 0.0)
    """Of water that goes with it along x, y and z, at its centre; counts in motion only."""
    added_inertia_kg_m2: _Sides = (0.0, 0.0, 0.0)
    """Of water that turns with it about x, y and z, at its centre; counts in motion only."""


class FloatTable(Table):
    """A float of the frame, upright while the frame is level: a box or a cylinder with a waterplane."""

    name: Text
    """What tables call it."""
    at: Vector
    """Middle of its foot, as the frame is placed."""
    height_m: Annotated[Number, Gt(0), Le(1000)]
    """From foot to top."""
    length_m: Annotated[Number, Gt(0), Le(1e4)] | None = None
    """Of a box, along x."""
    width_m: Annotated[Number, Gt(0), Le(1e4)] | None = None
    """Of a box, along y."""
    diameter_m: Annotated[Number, Gt(0), Le(1e4)] | None = None
    """Of a cylinder, in place of length and width."""
    mass_kg: Annotated[Number, Ge(0), Le(1e7)] = 0.0
    """In air, evenly spread."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        box = [key for key in ("length_m", "width_m") if getattr(self, key) is not None]
        if self.diameter_m is not None and box:
            raise Contradiction(box[0], "left out of a cylinder, which has a diameter_m", "contradicts diameter_m")
        if self.diameter_m is None and len(box) < 2:
            key = "length_m" if "length_m" not in box else "width_m"
            raise Contradiction(key, "length_m and width_m of a box, or diameter_m of a cylinder", "is missing")
        return self


class BallastTable(Table):
    """Weights that keep a cage open: at some of its corners, or evenly along edges of its netting."""

    mass_kg: Annotated[Number, Gt(0), Le(1e7)]
    """Of all of it together, in air."""
    density_kg_m3: Annotated[Number, Gt(0), Le(30_000)] | None = None
    """Gives its weight in water; lead has 11340."""
    wet_weight_n: Annotated[Number, Gt(0), Le(1e8)] | None = None
    """Of all of it in water, in place of its density."""
    points: Annotated[tuple[Text, ...], MinLen(1)] | None = None
    """Points that share it equally."""
    edges: Annotated[tuple[Text, ...], MinLen(1)] | None = None
    """Edges of netting, as in "wall.aft", that share it by their stretched lengths, knot by knot."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        Contradiction.raise_first(self._contradictions())
        return self

    def _contradictions(self) -> Iterator[Contradiction]:
        for first, second in (("density_kg_m3", "wet_weight_n"), ("points", "edges")):
            given = [key for key in (first, second) if getattr(self, key) is not None]
            if len(given) == 2:
                yield Contradiction(second, f"either {first} or {second}", f"contradicts {first}")
            elif not given:
                yield Contradiction(first, f"{first} or {second}", "is missing")
