"""The tables of a scene: water, ropes, points, vessel, time, seabed and model, each checked by itself.

Lengths in m, x along the tow and aft, z up with the surface at 0, unless a key's name says otherwise.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal, Self

from annotated_types import Ge, Gt, Le
from pydantic import Field, create_model, model_validator

from codend.plan.messages import Contradiction
from codend.plan.tables import DRAG_COEFFICIENTS, SEA_WATER_KG_M3, Number, Table, Text, Whole

Vector = tuple[Number, Number, Number]
VESSEL = "vessel"
"""What a rope calls the vessel's towing point."""
_AT_MOST_M = 1e5
_FROM = "Name of the point it runs from, or `vessel`."


class Layer(Table):
    """The current at one depth; between two depths it changes evenly."""

    depth_m: Annotated[Number, Ge(0), Le(12_000)]
    """Below the surface."""
    flow_m_s: Vector
    """The current there, along x, y and z."""


class WaterTable(Table):
    """The water and its current over the ground."""

    density_kg_m3: Annotated[Number, Ge(900), Le(1300)] = SEA_WATER_KG_M3
    """Left out: sea water, and the run says so."""
    flow_m_s: Vector = (0.0, 0.0, 0.0)
    """Its current over the ground."""
    profile: tuple[Layer, ...] = ()
    """Its current by depth, instead of ``flow_m_s``."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.profile and "flow_m_s" in self.model_fields_set:
            raise Contradiction("flow_m_s", "either flow_m_s or profile", "contradicts profile")
        depths = [layer.depth_m for layer in self.profile]
        for index in range(1, len(depths)):
            if depths[index] <= depths[index - 1]:
                raise Contradiction(f"profile.{index}.depth_m", f"above {depths[index - 1]:g}, that of the one before")
        return self


def drag_by(law: str, normal: float | None, tangential: float | None) -> tuple[str, float, float]:
    """A law of drag and its two coefficients, the law's own where they are left out."""
    own = DRAG_COEFFICIENTS[law]
    return law, own[0] if normal is None else normal, own[1] if tangential is None else tangential


class _RopeTable(Table):
    """A rope, warp, bridle or mooring between two points; it never pushes."""

    to: Text
    """Name of the point at its other end, or `vessel`."""
    length_m: Annotated[Number, Gt(0), Le(_AT_MOST_M)]
    """Unstretched."""
    diameter_mm: Annotated[Number, Gt(0), Le(1000)]
    """For drag and buoyancy."""
    mass_kg_m: Annotated[Number, Gt(0), Le(10_000)]
    """In air."""
    name: Text | None = None
    """What tables call it; None: "rope" and its number."""
    axial_stiffness_n: Annotated[Number, Gt(0), Le(1e12)] | None = None
    """EA; None: it does not stretch."""
    law: Literal["le-bris-1999", "bessonneau-1997", "choo-casarella-1971"] = "le-bris-1999"
    """Of its drag: that of the paper it is named after."""
    normal: Annotated[Number, Ge(0), Le(10)] | None = None
    """None: that of the law."""
    tangential: Annotated[Number, Ge(0), Le(10)] | None = None
    """None: that of the law."""
    added_mass: Annotated[Number, Ge(0), Le(10)] = 1.0
    """Cm of a cylinder across its length, that of potential flow if left out."""
    bars: Annotated[Whole, Ge(1), Le(10_000)] | None = None
    """Straight bars it is cut into; None: those of the model."""

    @property
    def ends(self) -> tuple[str, str]:
        """Names of the points it runs between."""
        first: str = getattr(self, "from")
        return first, self.to

    @property
    def drag(self) -> tuple[str, float, float]:
        """Law of its drag and its two coefficients."""
        return drag_by(self.law, self.normal, self.tangential)


if TYPE_CHECKING:
    RopeTable = _RopeTable
else:  # "from" is a word of Python's own, and cannot be written as a field
    RopeTable = create_model("RopeTable", __base__=_RopeTable, **{"from": (Text, Field(description=_FROM))})


class PointTable(Table):
    """A weight, a float, a door, a knot, or what holds a rope's end."""

    name: Text
    """What ropes and tables call it."""
    at: Vector | None = None
    """Where it is held, or starts; None: astern of what it hangs on, in a line at the same height."""
    held: Literal["vessel", "ground", "frame", "symmetry"] | None = None
    """What holds it, if anything; "symmetry" holds it in y = 0, the plane in which half a gear meets the other."""
    held_from_s: Annotated[Number, Ge(0), Le(1e6)] | None = None
    """From when on it is held fast to the ground where it then is, as a gear that hangs up."""
    mass_kg: Annotated[Number, Ge(0), Le(1e7)] = 0.0
    """In air."""
    added_mass_kg: Annotated[Number, Ge(0), Le(1e7)] = 0.0
    """Of the water that goes with it, the same in all directions."""
    wet_weight_n: Annotated[Number, Ge(-1e8), Le(1e8)] | None = None
    """Downward, below 0 of floats; None: by mass and density, one of which must be given with a mass."""
    density_kg_m3: Annotated[Number, Gt(0), Le(30_000)] | None = None
    """Gives the weight in water, with the mass."""
    area_m2: Annotated[Number, Ge(0), Le(1e4)] = 0.0
    """What its coefficients are over."""
    drag: Annotated[Number, Ge(0), Le(100)] = 0.0
    """Coefficient over ``area_m2``."""
    lift: Annotated[Number, Ge(-100), Le(100)] = 0.0
    """Coefficient over `area_m2`, across the flow."""
    table: Text | None = None
    """CSV of ``attack_deg, lift, drag`` from which both are read at ``attack_deg``."""
    attack_deg: Annotated[Number, Ge(-180), Le(180)] | None = None
    """Angle at which the table is read."""
    lift_towards: Vector = (0.0, 0.0, 1.0)
    """Direction of the lift, of which the part across the flow counts."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        Contradiction.raise_first(self._contradictions())
        return self

    def _contradictions(self) -> Iterator[Contradiction]:
        if self.name == VESSEL:
            yield Contradiction("name", f'any name but "{VESSEL}", which is the vessel\'s towing point')
        if self.name in ("ground", "frame", "symmetry", "repeats"):
            yield Contradiction("name", "any name but those of what may hold netting")
        if self.held is not None and self.at is None:
            yield Contradiction("at", "where it is held: [x, y, z] in m", "is missing")
        if self.held == "symmetry" and self.at is not None and self.at[1] != 0.0:
            yield Contradiction("at", "a place in the plane of symmetry, y = 0")
        if self.held is not None and self.held_from_s is not None:
            yield Contradiction("held_from_s", "left out of a point that is held anyway", "contradicts held")
        if self.wet_weight_n is not None and self.density_kg_m3 is not None:
            yield Contradiction("density_kg_m3", "either wet_weight_n or density_kg_m3", "contradicts wet_weight_n")
        if self.density_kg_m3 is not None and self.mass_kg == 0.0:
            yield Contradiction("mass_kg", "a number above 0, with density_kg_m3", "is missing")
        if (self.table is None) != (self.attack_deg is None):
            key = "table" if self.table is None else "attack_deg"
            yield Contradiction(key, "table and attack_deg together, or neither", "is missing")
        if self.table is not None and (given := {"lift", "drag"} & self.model_fields_set):
            yield Contradiction(min(given), "left out, for the table gives it", "contradicts table")
        if (self.drag or self.lift or self.table) and self.area_m2 == 0.0:
            yield Contradiction("area_m2", "a number above 0, with drag or lift", "is missing")
        if self.mass_kg > 0.0 and self.wet_weight_n is None and self.density_kg_m3 is None:
            allowed = "given beside mass_kg, 0 of what neither sinks nor floats; or density_kg_m3"
            yield Contradiction("wet_weight_n", allowed, "is missing")
        if self.area_m2 > 0.0 and not {"drag", "lift", "table"} & self.model_fields_set:
            yield Contradiction(
                "drag", "given beside area_m2, 0 of what has none; or lift, or a table of both", "is missing"
            )
        if not any(self.lift_towards):
            yield Contradiction("lift_towards", "a direction: three numbers that are not all 0")


FASTEST_M_S = 20.0
"""Of a vessel."""


class VesselTable(Table):
    """What tows: its towing point, called "vessel", and how that moves."""

    at: Vector = (0.0, 0.0, 0.0)
    """Where its towing point is, or starts."""
    speed_m_s: Annotated[Number, Ge(0), Le(FASTEST_M_S)] = 0.0
    """Towards -x; places are then told as seen from the vessel, which the water passes by."""
    motion: Text | None = None
    """CSV of ``time_s, x_m, y_m, z_m``, by which its points move over the ground from where they start: along
    a cubic spline through eight rows or more at about even times, of which ten a period of heave give its accelerations
    to a few hundredths, else straight from row to row."""
    heave_m: Annotated[Number, Ge(0), Le(50)] = 0.0
    """Amplitude, upward first."""
    period_s: Annotated[Number, Gt(0), Le(1e5)] | None = None
    """Of the heave."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.heave_m > 0.0 and self.period_s is None:
            raise Contradiction("period_s", "a number above 0, with heave_m", "is missing")
        if self.period_s is not None and "heave_m" not in self.model_fields_set:
            raise Contradiction("heave_m", "a number above 0, with period_s", "is missing")
        if self.motion is not None and (given := {"speed_m_s", "heave_m"} & self.model_fields_set):
            raise Contradiction(max(given), "left out, for the table of motion gives it", "contradicts motion")
        return self


class TimeTable(Table):
    """How long the motion goes on."""

    end_s: Annotated[Number, Gt(0), Le(1e6)]
    """How long it goes on."""
    output_s: Annotated[Number, Gt(0), Le(1e6)]
    """Time from one output to the next."""
    step_s: Annotated[Number, Gt(0), Le(10)] = 0.01
    """Longest time step."""
    length_error: Annotated[Number, Ge(1e-9), Le(0.1)] | None = None
    """How far a step may leave a bar off its length, relative, for the next to mend; None: 1e-7, with netting 0.05."""
    start: Literal["equilibrium", "placed"] = "equilibrium"
    """Whether it begins in the equilibrium of the tow, or at rest where the points and ropes are placed."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.output_s > self.end_s:
            raise Contradiction("output_s", f"at most {self.end_s:g}, end_s")
        outputs = self.end_s / self.output_s
        if abs(outputs - round(outputs)) > 1e-6:
            raise Contradiction("end_s", f"a whole number of times output_s, {self.output_s:g}")
        if self.end_s / self.output_s > 1e5:
            raise Contradiction("output_s", f"at least {self.end_s / 1e5:g}, which makes 100000 outputs")
        return self


class SeabedTable(Table):
    """A level seabed without friction."""

    depth_m: Annotated[Number, Gt(0), Le(12_000)]
    """Below the surface."""


class SceneModel(Table):
    """How a scene is modelled."""

    bars_per_rope: Annotated[Whole, Ge(1), Le(10_000)] = 40
    """Straight bars that a rope is cut into which does not say so itself."""
    tolerance: Annotated[Number, Ge(1e-12), Le(0.1)] = 1e-9
    """Largest nodal residual over the sum of all loads."""
    contact: bool | None = None
    """Whether netting that meets netting presses on it, without friction; false: such a shape is refused; true: in a
    motion as well, which then takes longer, and starts where nothing passes through anything; None: in an equilibrium
    only."""
