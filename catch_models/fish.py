"""Fish that meet a codend: the section that has to pass a mesh, how fish differ, and how they try.

A species is a table of numbers, each with the source it comes from; a source that begins with "assumed" marks a number
nobody measured, and the name of every such number goes with the results. Lengths of sections are per metre of fish.
The section is a superellipse |x / a|^n + |y / b|^n = 1, an ellipse for n = 2, with x along the fish's height.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Generic, Literal, TypeVar

import numpy as np
from annotated_types import Ge, Gt, Le, MinLen
from numpy.typing import ArrayLike, NDArray
from pydantic import AllowInfNan, BaseModel, ConfigDict, Strict

from catch_models.fish_parameters import PARAMETERS

Floats = NDArray[np.float64]
Number = Annotated[float, Strict(), AllowInfNan(False)]
Text = Annotated[str, MinLen(1)]
N = TypeVar("N")


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Sourced(_Table, Generic[N]):
    """A number, where it comes from, and between what bounds it may lie."""

    value: N
    source: Text
    """Where the number comes from; begins with "assumed" when nobody measured it."""
    low: N | None = None
    high: N | None = None
    """With ``low``, the range over which results are examined for what the number does to them."""

    @property
    def assumed(self) -> bool:
        """Whether the source says that nobody measured the number."""
        return self.source.lstrip().lower().startswith("assumed")


Share = Sourced[Annotated[Number, Ge(0), Le(0.9)]]
Ratio = Sourced[Annotated[Number, Ge(0.01), Le(1)]]
"""Of a fish's length. No fish is thinner than a hundredth of it, and none passes a mesh as a thread would; none that
trawls meet is higher or wider than it is long."""
Spread = Sourced[Annotated[Number, Ge(0), Le(0.5)]]


class Section(_Table):
    """The largest section that has to pass, of a fish of length 1."""

    height_per_length: Ratio
    """Height of the largest section that has to pass, over the length of the fish."""
    width_per_length: Ratio
    """Width of the same."""
    exponent: Sourced[Annotated[Number, Ge(1.2), Le(20)]] | None = None
    """Of the superellipse; left out, the section is an ellipse, 2."""
    height_compression: Share
    """Share of the height that gives way in the mesh."""
    width_compression: Share
    """Share of the width that gives way in the mesh."""


class Spreads(_Table):
    """How fish of one length differ, as standard deviations of natural logarithms (normal distributions)."""

    size: Spread
    """Of height and width together."""
    shape: Spread
    """Of height over width."""


class Behaviour(_Table):
    """How fish try to escape."""

    contact: Sourced[Annotated[Number, Ge(0), Le(1)]]
    """Probability that a fish tries a mesh at all."""
    attempts: Sourced[Annotated[Number, Gt(0), Le(1000)]]
    """Meshes that a fish which tries comes to, each a new draw."""
    rows_ahead: Sourced[Annotated[Number, Ge(1), Le(1000)]]
    """Rows of meshes ahead of the catch's front over which attempts are spread evenly."""
    rotation_deg: Sourced[Annotated[Number, Ge(0), Le(45)]]
    """Standard deviation of the angle, about the fish's axis, between the fish and its best orientation in the mesh."""
    push_force_n: Sourced[Annotated[Number, Ge(0), Le(1000)]] | None = None
    """Largest force F1 with which a fish of length L1 deforms a mesh; left out, 0: every mesh keeps its shape.

    One of length L pushes with F1 (L / L1)^n.
    """
    push_length_cm: Sourced[Annotated[Number, Ge(1), Le(500)]] | None = None
    """L1; left out, 30 cm."""
    push_exponent: Sourced[Annotated[Number, Ge(0), Le(4)]] | None = None
    """n; left out, 2: as the section of a muscle, which is assumed."""


class Along(_Table):
    """How attempts are spread over the distance from the catch's front, linear between the rows given."""

    rows_ahead: Annotated[tuple[Annotated[Number, Ge(0), Le(10_000)], ...], MinLen(1)]
    """Rows of meshes ahead of the front, rising from 0 to 1 on; nearer than the first its weight holds, and beyond the
    last no fish tries."""
    weight: Annotated[tuple[Annotated[Number, Ge(0)], ...], MinLen(1)]
    """Attempts there, relative; open meshes of a row share them."""
    source: Text
    """Where the distribution comes from."""


class Zone(_Table):
    """A part of the codend that fish pass on their way, with a contact and attempts of its own.

    All its meshes ahead of the front count, however far, and what fish try there takes nothing from the rest.
    """

    section: Text
    """Name or number of the section, or of the window, as in the tables of a run."""
    panel: Text | None = None
    """None: all panels of the section."""
    contact: Sourced[Annotated[Number, Ge(0), Le(1)]]
    """Probability that a fish on its way tries a mesh there at all."""
    attempts: Sourced[Annotated[Number, Gt(0), Le(1000)]]
    """Meshes that such a fish comes to there."""

    def holds(self, section: str, panel: str) -> bool:
        """Whether a part of the codend is of the zone."""
        return section == self.section and self.panel in (None, panel)


class HaulNumbers(_Table):
    """What comes over a haul."""

    fish: Sourced[Annotated[Number, Ge(10), Le(1e7)]]
    """Fish of the species that arrive during the haul, at a constant rate, equally many of every length class."""
    catch_growth: Sourced[Annotated[Number, Ge(0.1), Le(10)]] | None = None
    """Exponent g of the catch's volume over time, V = V_end (t / t_end)^g; left out, 1: a steady growth."""


class LengthClasses(_Table):
    """Lengths for which retention is tabled."""

    from_cm: Annotated[Number, Gt(0), Le(500)]
    """Shortest."""
    to_cm: Annotated[Number, Gt(0), Le(500)]
    """Longest."""
    step_cm: Annotated[Number, Gt(0), Le(50)]
    """From one to the next."""


DEFAULTS = {
    "section.exponent": 2.0,
    "behaviour.push_force_n": 0.0,
    "behaviour.push_exponent": 2.0,
    "behaviour.push_length_cm": 30.0,
    "haul.catch_growth": 1.0,
}
"""Numbers a species may leave out: they then stand for no effect or for the form of a law, not for a measurement."""
LAW_OF_PUSH = ("behaviour.push_exponent", "behaviour.push_length_cm")
"""Numbers that are assumed where a species that pushes leaves them out."""


class Species(_Table):
    """A species of fish as meshes meet it."""

    name: Text
    shape: Literal["ellipse", "superellipse"] = "ellipse"
    section: Section
    spread: Spreads
    behaviour: Behaviour
    haul: HaulNumbers
    lengths: LengthClasses
    along: Along | None = None
    """None: evenly over ``behaviour.rows_ahead`` rows."""
    zone: tuple[Zone, ...] = ()

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled as plain tables: classes made of ``Sourced`` with bounds have no name they could be found by."""
        return Species.model_validate, (self.model_dump(exclude_unset=True),)

    def number(self, parameter: str) -> Sourced[float] | None:
        """A number by its dotted name, with its source; None where the species leaves it out."""
        table, key = parameter.split(".")
        found: Sourced[float] | None = getattr(getattr(self, table), key)
        return found

    @property
    def values(self) -> Floats:
        """Values of ``PARAMETERS``, (15,)."""
        found = ((name, self.number(name)) for name in PARAMETERS)
        return np.array([DEFAULTS[name] if number is None else number.value for name, number in found])

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Bounds of the parameters that have any."""
        found = {}
        for name in PARAMETERS:
            number = self.number(name)
            if number is not None and number.low is not None and number.high is not None:
                found[name] = (number.low, number.high)
        return found

    @property
    def assumed(self) -> tuple[str, ...]:
        """Names of the numbers whose source says that they are assumed."""
        numbers = {name: self.number(name) for name in (*PARAMETERS, "haul.fish")}
        left_out = LAW_OF_PUSH if self.pushes else ()
        found = [name for name, n in numbers.items() if (n.assumed if n is not None else name in left_out)]
        for zone in self.zone:
            tried = {"contact": zone.contact, "attempts": zone.attempts}
            found += [f"zone.{zone.section}.{name}" for name, number in tried.items() if number.assumed]
        along = self.along is not None and self.along.source.lstrip().lower().startswith("assumed")
        return (*found, *(["along"] if along else []))

    @property
    def pushes(self) -> bool:
        """Whether meshes yield to the fish, by its own number or at an end of the number's range."""
        push = self.behaviour.push_force_n
        return push is not None and max(push.value, push.high or 0.0) > 0.0

    @property
    def length_cm(self) -> Floats:
        """Lengths for which retention is tabled, cm."""
        classes = self.lengths
        count = int(np.floor((classes.to_cm - classes.from_cm) / classes.step_cm + 1e-9)) + 1
        return np.asarray(classes.from_cm + classes.step_cm * np.arange(count))


@dataclass(frozen=True)
class FishSection:
    """Compressed section of a fish of length 1: half height, half width and exponent."""

    half_height: float
    half_width: float
    exponent: float = 2.0

    @classmethod
    def of(cls, values: Floats) -> FishSection:
        """Section of the mean fish with the given values of ``PARAMETERS``."""
        height, width, exponent, soft_height, soft_width = (float(v) for v in values[:5])
        return cls(0.5 * height * (1.0 - soft_height), 0.5 * width * (1.0 - soft_width), exponent)

    def support(self, angle_rad: ArrayLike) -> Floats:
        """Distance from the centre to the tangent whose normal is at an angle to the height axis, any shape.

        h = (|a cos|^q + |b sin|^q)^(1/q) with 1/n + 1/q = 1, the dual norm of the superellipse's.
        """
        q = self.exponent / (self.exponent - 1.0)
        across = np.abs(self.half_height * np.cos(angle_rad)) ** q + np.abs(self.half_width * np.sin(angle_rad)) ** q
        return np.asarray(across ** (1.0 / q))

    def outline(self, points: int = 181) -> Floats:
        """Points on the section's edge, height along x, (points, 2)."""
        turn = np.linspace(0.0, 2.0 * np.pi, points)
        power = 2.0 / self.exponent
        x, y = (np.sign(f) * np.abs(f) ** power for f in (np.cos(turn), np.sin(turn)))
        return np.stack([self.half_height * x, self.half_width * y], axis=1)
