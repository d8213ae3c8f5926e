"""The designs of a study: what varies over plans, in a grid or a sample, run by run."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from codend.errors import InputError
from codend.plan.copy import toml_value
from codend.plan.overrides import apply_values
from codend.plan.plan import Plan, plan_from_dict, plan_of
from codend.plan.tables import Netting

Sample = Literal["sobol", "latin-hypercube"]
SAMPLES: Final = ("sobol", "latin-hypercube")
MOST_CHECKED: Final = 1000
ORDER_BITS: Final = 10
"""Cells each way of the curve along which the points of a sample are put in order: 2 to this power."""


@dataclass(frozen=True)
class Base:
    """A plan that is varied."""

    name: str
    data: Mapping[str, Any]
    """Its tables."""
    source: str
    """The file they are from."""


@dataclass(frozen=True)
class Axis:
    """Keys that change together, through given values or between two bounds."""

    keys: tuple[str, ...]
    points: tuple[tuple[Any, ...], ...] = ()
    """A value for each key at each step; none of a range that only a sample runs through."""
    low: float = 0.0
    high: float = 0.0
    counted: bool = False
    """Whether what lies between the bounds is kept whole."""

    def at(self, share: float) -> tuple[Any, ...]:
        """The values at a share of the way, 0 to below 1."""
        if self.points:
            return self.points[int(share * len(self.points))]
        if self.counted:
            return (int(self.low) + int(share * (self.high - self.low + 1)),)
        return (self.low + share * (self.high - self.low),)


@dataclass(frozen=True)
class Run:
    """One design of a study."""

    number: int
    """Counted from 1."""
    base: Base
    values: dict[str, Any] = field(default_factory=dict)
    """What it has for each key that varies."""
    keep: Mapping[str, str] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """Its design and values in words."""
        values = (f"{key} = {toml_value(value)}" for key, value in self.values.items())
        return ", ".join([self.base.name, *values] if self.base.name else values)

    @cached_property
    def all_values(self) -> dict[str, Any]:
        """Those and the counts that follow from what is kept; without these where the values make no netting.

        Raises:
            InputError: the plan it changes is none.
        """
        if not self.keep:
            return self.values
        before = plan_from_dict(self.base.data, self.base.source)
        # of the netting alone, which has to close and hold its catch only with the counts that follow
        changed = apply_values(self.base.data, _pairs(self.values), self.base.source)["netting"]
        counts = {}
        for key, quantity in self.keep.items():
            part = int(key.split(".")[1])
            try:
                new = Netting.model_validate(changed[part])
            except ValidationError:
                return self.values  # which the plan's own checks refuse with their reason
            size = _SIZES[quantity]
            counts[key] = max(round(getattr(new, KEPT[quantity]) * size(before.netting[part]) / size(new)), 1)
        return {**self.values, **counts}

    def plan(self) -> Plan:
        """The plan with its values.

        Raises:
            InputError: they do not make a plan.
        """
        data = apply_values(self.base.data, _pairs(self.all_values), self.base.source)
        return plan_of(data, self.base.source)


KEPT: Final = {"stretched_circumference": "meshes_round", "stretched_length": "meshes_long"}
"""What may be kept as it is in the plan, and the count of a section that follows from it."""
_SIZES: Final[Mapping[str, Callable[[Netting], float]]] = {
    "stretched_circumference": lambda section: 2.0 * math.pi * section.stretched_radius_m,
    "stretched_length": lambda section: section.stretched_length_m,
}


@dataclass(frozen=True)
class Designs:
    """All runs of a study: every plan with every combination of what varies, or with every point of a sample."""

    bases: tuple[Base, ...]
    axes: tuple[Axis, ...] = ()
    keep: Mapping[str, str] = field(default_factory=dict)
    """Counts that follow from what is kept (``KEPT``)."""
    sample: Sample | None = None
    """None: every combination, the last axis running fastest."""
    size: int = 0
    """Points of the sample."""
    seed: int = 0

    def __len__(self) -> int:
        return len(self.bases) * self._combinations

    @property
    def _combinations(self) -> int:
        return self.size if self.sample else math.prod(len(axis.points) for axis in self.axes)

    def run(self, number: int) -> Run:
        """The run of a number, from 1."""
        base, which = divmod(number - 1, self._combinations)
        if self.sample:
            found = [axis.at(share) for axis, share in zip(self.axes, self.shares[which], strict=True)]
        else:
            steps = np.unravel_index(which, [len(axis.points) for axis in self.axes]) if self.axes else ()
            found = [axis.points[int(step)] for axis, step in zip(self.axes, steps, strict=True)]
        values: dict[str, Any] = {}
        for axis, point in zip(self.axes, found, strict=True):
            values.update(zip(axis.keys, point, strict=True))
        return Run(number, self.bases[base], values, self.keep)

    @cached_property
    def text_keys(self) -> frozenset[str]:
        """Keys that vary through values of several kinds, or through lists, which are text in a table."""
        found = set()
        for axis in self.axes:
            for key, *values in zip(axis.keys, *axis.points, strict=True):
                kinds = {bool if isinstance(v, bool) else float if isinstance(v, int | float) else str for v in values}
                if len(kinds) > 1 or str in kinds:
                    found.add(key)
        return frozenset(found)

    def some(self, most: int) -> list[Run]:
        """At most so many of the runs, evenly spread, the first and the last among them."""
        count = len(self)
        numbers = range(1, count + 1) if count <= most else np.linspace(1, count, most).round().astype(int)
        return [self.run(int(number)) for number in numbers]

    def check_any(self) -> None:
        """See that some of the runs have values that make a plan.

        Raises:
            InputError: none of very many has; the first one's mistakes.
        """
        first: InputError | None = None
        for run in self.some(MOST_CHECKED):
            try:
                run.plan()
            except InputError as error:
                first = first or error
            else:
                return
        if first is not None:
            raise first

    @cached_property
    def shares(self) -> NDArray[np.float64]:
        """Points of the sample in the unit cube, (size, axes), neighbours one after the other."""
        points = _points(self.sample, len(self.axes), self.size, self.seed)
        return points[np.lexsort(_along_a_curve(points)[::-1])]


def _points(sample: Sample | None, axes: int, size: int, seed: int) -> NDArray[np.float64]:
    from scipy.stats import qmc

    if sample == "sobol":
        power = max(size - 1, 0).bit_length()
        points = qmc.Sobol(axes, rng=np.random.default_rng(seed)).random_base2(power)[:size]
    else:
        points = qmc.LatinHypercube(axes, rng=np.random.default_rng(seed)).random(size)
    return np.asarray(points)


def _along_a_curve(points: NDArray[np.float64]) -> list[NDArray[np.int64]]:
    """Keys to sort points by along Morton's curve, the first counting most: bits of their cells in turn."""
    cells = (points * 2**ORDER_BITS).astype(np.int64)
    return [(column >> bit) & 1 for bit in reversed(range(ORDER_BITS)) for column in cells.T]


def _pairs(values: Mapping[str, Any]) -> Sequence[tuple[tuple[str, ...], Any]]:
    return [(tuple(key.split(".")), value) for key, value in values.items()]
