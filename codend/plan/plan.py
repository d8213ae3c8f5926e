"""What the user said: a TOML plan of a codend and its tow, checked once and immutable ever after.

All checks are made by ``plan_from_dict``, wherever the plan came from, and end in one ``InputError``.
"""

import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain, combinations, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

from annotated_types import MinLen
from pydantic import PrivateAttr, model_validator

from codend.errors import InputError, all_at_once
from codend.io.names import as_name
from codend.io.toml import read_toml
from codend.plan.kinds import kinds_in_words
from codend.plan.layers import Layer
from codend.plan.messages import Contradiction
from codend.plan.mistakes import checked
from codend.plan.overrides import CatchKind, Overrides, apply_overrides
from codend.plan.pulse import Following, Heave
from codend.plan.reach import least_radius_m
from codend.plan.ropes import Rope, Selvedge, places_round, selvedges_of
from codend.plan.tables import Catch, Drag, Entry, Model, Netting, Strap, Table, Text, Tow
from codend.plan.windows import (
    Hole,
    Window,
    hole_of,
    lines_of_loss,
    out_of_place,
    ropes_amiss,
    strap_amiss,
    too_near,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_NO_FILE: Final = Path("plan")
MOST_CASES: Final = 10_000
"""Some minutes of solving; a list that makes more is a slip."""
_STAND_INS: Final = {
    "title": "plan",
    "tow": {"speed_m_s": 1.0},
    "drag": None,
    "model": None,
    "netting.twine_mm": 1e-6,
    **{f"netting.{key}": None for key in ("name", "twines", "twine_density_kg_m3", "material", "axial_stiffness_n")},
    **{f"netting.{key}": None for key in ("knot_axial_stiffness_n", "knot_compression")},
    **{f"netting.{key}": None for key in ("bending_stiffness_n_m2", "rest_opening_deg")},
    "strap.length_m": 1.0,
    **{f"strap.{key}": None for key in ("axial_stiffness_n", "diameter_mm", "density_kg_m3")},
    **{f"catch.{key}": None for key in ("coefficient", "sphere_cp_csv")},
}
"""Good values for those that have no say in whether the netting closes and holds its catch and straps."""


@dataclass(frozen=True)
class Case:
    """One speed and one catch of a plan."""

    number: int
    """Counted from 1."""
    speed_m_s: float
    catch_kind: CatchKind
    catch_value: float
    """In the unit of ``catch_kind``."""

    @property
    def gives_volume(self) -> bool:
        """Whether the volume of the catch is given, so that no error of the shape is one of it."""
        return self.catch_kind in ("volume_m3", "mass_kg")


class Plan(Table):
    """A whole plan: the sections of netting run from the entry to the codline."""

    title: Text
    tow: Tow
    entry: Entry
    netting: Annotated[tuple[Netting, ...], MinLen(1)]
    strap: tuple[Strap, ...] = ()
    rope: tuple[Rope, ...] = ()
    window: tuple[Window, ...] = ()
    layer: tuple[Layer, ...] = ()
    catch: Catch
    drag: Drag = Drag.model_validate({})
    model: Model = Model()
    vessel: Heave | None = None
    time: Following | None = None
    _source: Path = PrivateAttr(default_factory=lambda: _NO_FILE)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        Contradiction.raise_first(self._contradictions())
        return self

    def _contradictions(self) -> Iterator[Contradiction]:
        yield from self._names_given_twice()
        yield from self._other_panels()
        first = self.netting[0]
        limit_m, ratio = first.open_meshes[0] * first.stretched_radius_per_mesh_m, self.entry.hanging_ratio
        if ratio is not None and not first.kind.opens:
            yield Contradiction("entry.hanging_ratio", f"radius_m, with {first.kind.words} mesh at the entry")
        elif self.entry_radius_m > limit_m or (self.entry_radius_m == limit_m and first.kind.opens):
            pulled_open = "that of the first section's meshes pulled fully open"
            if ratio is None:
                yield Contradiction("entry.radius_m", f"below {limit_m:.4g} m, {pulled_open}")
            else:
                most = ratio * limit_m / self.entry_radius_m
                yield Contradiction("entry.hanging_ratio", f"below {most:.4g}, {pulled_open}")
        cases = len(self.tow.speed_m_s) * len(self.catch.sizes)
        if cases > MOST_CASES:
            key = "tow.speed_m_s" if len(self.tow.speed_m_s) > len(self.catch.sizes) else f"catch.{self.catch.kind}"
            yield Contradiction(key, f"at most {MOST_CASES} cases, speeds times catches", f"makes {cases} cases")
        if self.vessel is not None:
            if (fastest := self.vessel.fastest_m_s) >= min(self.tow.speed_m_s):
                allowed = f"so little that the codend never stops: it goes to and fro at {fastest:.3g} m/s"
                yield Contradiction("vessel.heave_m", allowed)
            if self.model.fidelity == "meridian":
                allowed = "any other beside [vessel]: a codend pulses as a net of bars"
                yield Contradiction("model.fidelity", allowed)
        elif self.time is not None:
            yield Contradiction("vessel", "a table [vessel] with heave_m and period_s beside [time]", "is missing")
        yield from self._catches_that_do_not_fit()
        yield from self._straps_out_of_place()
        yield from self._ropes_out_of_place()
        yield from self._layers_out_of_place()
        astray = list(out_of_place(self.window, self.netting, self.section_names, self.seam_deg))
        astray = astray or list(self._through_windows())
        yield from astray
        # laid even flat across the entry
        gap_m = least_radius_m(self.netting, self.entry_radius_m, 0)
        if gap_m > 0.0:
            allowed = f"more: laid flat the netting ends {gap_m:.3g} m short of the axis, where the codline gathers it"
            yield Contradiction(f"netting.{len(self.netting) - 1}.meshes_long", allowed)
        if not astray and self.model.globalisation not in (divisors := self.globalisations):
            allowed = ", ".join(map(str, divisors))
            rowed = [name for name in ("strap", "layer") if getattr(self, name)]
            and_straps = f", and of the rows from every {' and '.join(rowed)} to the codline" if rowed else ""
            reason = f"divisors of all meshes_round and meshes_long{and_straps}"
            yield Contradiction("model.globalisation", f"{allowed} ({reason})")

    @property
    def entry_radius_m(self) -> float:
        """Radius of the hoop that holds the front row: its own, or by 2 pi r = E1 x meshes round x full mesh, m."""
        first = self.netting[0]
        if self.entry.radius_m is not None:
            return self.entry.radius_m
        assert self.entry.hanging_ratio is not None
        return self.entry.hanging_ratio * first.open_meshes[0] * first.full_mesh_m / (2 * math.pi)

    @property
    def panels(self) -> int:
        """Panels round of the sections that have more than one; 1 of a tube."""
        return max(part.panels for part in self.netting)

    @property
    def seamed(self) -> bool:
        """Whether ropes or seams show all along it, so that not every mesh round is alike."""
        return len(self.rope) > 0 or any(part.has_seams for part in self.netting)

    @property
    def tapers(self) -> bool:
        """Whether a section does."""
        return any(part.tapers for part in self.netting)

    def places_round(self, globalisation: float = 1) -> int:
        """Places round, at equal angles, at which a tube that tapers loses meshes; as many as windows leave room."""
        counts = [round(count / globalisation) for part in self.netting for count in part.open_meshes]
        most = math.gcd(*counts, *(part.panels for part in self.netting if part.has_seams))
        holes = [hole.merged(round(globalisation)) for hole in self.holes]
        return lines_of_loss(holes, self.netting, most, round(globalisation)) or most

    @property
    def seam_deg(self) -> float:
        """Azimuth of the first seam, from starboard on over the top: the upper panel has its middle on top.

        The only seam of a single panel with a selvedge lies underneath; a tube has none, and 0. Where a tube tapers and
        has a window on its starboard side, it loses its meshes from underneath on as well.
        """
        to_starboard = self.tapers and any(window.side == "starboard" for window in self.window)
        if self.panels > 1 or to_starboard or any(part.selvedge_meshes for part in self.netting):
            return 90.0 - 180.0 / self.panels
        return 0.0

    @property
    def ropes(self) -> tuple[Rope | Selvedge, ...]:
        """Ropes along the netting, those of the plan before the selvedges, which are cords as well."""
        return (*self.rope, *selvedges_of(self.netting))

    @property
    def holes(self) -> tuple[Hole, ...]:
        """What the windows are let into."""
        return tuple(hole_of(window, self.netting, self.section_names, self.seam_deg) for window in self.window)

    @property
    def window_names(self) -> tuple[str, ...]:
        """What tables call the windows: their names, or "window" and their numbers, from 1."""
        return tuple(window.name or f"window {number}" for number, window in enumerate(self.window, start=1))

    @property
    def layer_names(self) -> tuple[str, ...]:
        """Of the layers: their names, or "layer" and their numbers, from 1."""
        return tuple(layer.name or f"layer {number}" for number, layer in enumerate(self.layer, start=1))

    def _other_panels(self) -> Iterator[Contradiction]:
        """Sections of other panels than the first that has any: their seams would not meet."""
        first = next((part.panels for part in self.netting if part.panels > 1), 1)
        for index, part in enumerate(self.netting):
            if part.panels > 1 and part.panels != first:
                yield Contradiction(f"netting.{index}.panels", f"{first}, as in the sections ahead, or 1")

    def _names_given_twice(self) -> Iterator[Contradiction]:
        """Names of sections that tables could not tell apart."""
        names = self.section_names + self.window_names
        for table, parts in (("netting", self.netting), ("window", self.window)):
            for index, part in enumerate(parts):
                if part.name is not None and names.count(part.name) > 1:
                    allowed = "a name that no other section has, nor its number where it has no name"
                    yield Contradiction(f"{table}.{index}.name", allowed)

    def _catches_that_do_not_fit(self) -> Iterator[Contradiction]:
        """Catches beyond what the netting could hold whatever its shape: errors of unit, mostly."""
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
                yield Contradiction(f"catch.{self.catch.kind}.{index}", f"above 0, at most {limit:.6g}, {reason}")

    def _straps_out_of_place(self) -> Iterator[Contradiction]:
        """Straps that lie on no row of knots, or two on one."""
        meshes_long = sum(part.meshes_long for part in self.netting)
        seen: list[float] = []
        for index, strap in self._straps_with_table():
            key = f"strap.{index}.meshes_from_codline"
            if strap.meshes_from_codline >= meshes_long:
                yield Contradiction(key, f"below {meshes_long}, the sum of meshes_long")
            elif self.rows_to_codline(strap.meshes_from_codline) is None:
                halves = kinds_in_words(lambda kind: kind.staggered)
                yield Contradiction(key, f"a row of knots: whole meshes, or half ones in {halves} netting")
            elif strap.meshes_from_codline in seen:
                yield Contradiction(key, "a row that has no other strap")
            seen.append(strap.meshes_from_codline)

    def _straps_with_table(self) -> Iterator[tuple[int, Strap]]:
        """Every strap, those that repeat one among them, with its length, and the number of its table."""
        meshes_long = sum(part.meshes_long for part in self.netting)
        for index, strap in enumerate(self.strap):
            place = strap.meshes_from_codline
            while place == strap.meshes_from_codline or place < meshes_long:
                length_m = strap.length_m
                if strap.circumference_share is not None:
                    section, open_meshes = self._open_meshes_at(place)
                    length_m = strap.circumference_share * open_meshes * section.full_mesh_m
                own = {"meshes_from_codline": place, "length_m": length_m}
                alone = {"circumference_share": None, "spacing_meshes": None}
                yield index, strap.model_copy(update=own | alone)
                if strap.spacing_meshes is None:
                    break
                place += strap.spacing_meshes

    def _open_meshes_at(self, meshes_from_codline: float) -> tuple[Netting, int]:
        """The section at a place, the one nearer to the codline where two meet, and its open meshes round there."""
        for part in reversed(self.netting):
            if meshes_from_codline <= part.meshes_long:
                fore, aft = part.open_meshes
                return part, round(aft + (fore - aft) * meshes_from_codline / part.meshes_long)
            meshes_from_codline -= part.meshes_long
        return self.netting[0], self.netting[0].open_meshes[0]

    @property
    def straps(self) -> tuple[Strap, ...]:
        """Every strap with its place and length, those that repeat one among them."""
        return tuple(strap for _, strap in self._straps_with_table())

    def _ropes_out_of_place(self) -> Iterator[Contradiction]:
        """Ropes that end at no row of knots, or more of them than there are meshes round."""
        meshes_long = sum(part.meshes_long for part in self.netting)
        fewest = min(min(part.open_meshes) for part in self.netting)
        for index, rope in enumerate(self.rope):
            if rope.number > fewest:
                yield Contradiction(f"rope.{index}.number", f"at most {fewest}, the fewest meshes round")
            for place, meshes in enumerate(rope.meshes_from_codline or ()):
                key = f"rope.{index}.meshes_from_codline.{place}"
                if meshes > meshes_long:
                    yield Contradiction(key, f"at most {meshes_long}, the sum of meshes_long")
                elif self.rows_to_codline(meshes) is None:
                    yield Contradiction(key, "a row of knots")

    def _through_windows(self) -> Iterator[Contradiction]:
        """Straps and ropes whose knots are not there, for a window is."""
        for index, strap in self._straps_with_table():
            allowed = strap_amiss(strap.meshes_from_codline, self.window, self.window_names)
            if allowed is not None:
                yield Contradiction(f"strap.{index}.meshes_from_codline", allowed)
        for index, rope in enumerate(self.rope):
            found = self._rope_through_window(rope)
            if found is None:
                continue
            number, window = found
            near, far = (f"{meshes:g}" for meshes in self.window[window].meshes_from_codline)
            through = f"rope {number + 1} of {rope.number} would run through {self.window_names[window]}"
            key = "number" if rope.meshes_from_codline is None else "meshes_from_codline"
            allowed = f"as many as run beside it, or meshes_from_codline as far as {near} or from {far}: {through}"
            yield Contradiction(f"rope.{index}.{key}", allowed)

    def _rope_through_window(self, rope: Rope, globalisation: int = 1) -> tuple[int, int] | None:
        """Which of equal ropes runs through which window, where meshes are merged; None: none."""
        holes = [hole.merged(globalisation) for hole in self.holes]
        ends = rope.meshes_from_codline or (0.0, math.inf)
        places = places_round(rope.number, self.netting[0].open_meshes[0] // globalisation)
        return ropes_amiss(places, ends, self.window, holes, self.netting, globalisation)

    def _layers_out_of_place(self) -> Iterator[Contradiction]:
        """Layers that begin at no row of knots, and models that have no place for any."""
        meshes_long = sum(part.meshes_long for part in self.netting)
        for index, layer in enumerate(self.layer):
            key, start = f"layer.{index}.meshes_from_codline.1", layer.meshes_from_codline[1]
            if start > meshes_long:
                yield Contradiction(key, f"at most {meshes_long}, the sum of meshes_long")
            elif self.rows_to_codline(start) is None:
                yield Contradiction(key, "a row of knots")
        if self.layer and self.model.fidelity == "meridian":
            yield Contradiction("model.fidelity", "any other under a [[layer]], which has no place on a membrane")
        if self.layer and self.model.method == "rigid-bars":
            yield Contradiction("model.method", '"auto", "newton" or "dynamic-relaxation", under a [[layer]]')

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
        rows = (self.rows_to_codline(strap.meshes_from_codline) for strap in self.straps)
        return tuple(count for count in rows if count is not None)

    @property
    def rope_rows(self) -> tuple[int, ...]:
        """Rows from every end of a rope to the codline, where the plan says where it ends."""
        rows = (self.rows_to_codline(meshes) for rope in self.rope for meshes in rope.meshes_from_codline or ())
        return tuple(count for count in rows if count is not None)

    @property
    def layer_rows(self) -> tuple[int, ...]:
        """Rows from where every layer begins to the codline."""
        rows = (self.rows_to_codline(layer.meshes_from_codline[1]) for layer in self.layer)
        return tuple(count for count in rows if count is not None)

    @property
    def section_names(self) -> tuple[str, ...]:
        """What tables call the sections: their names, or their numbers, counted from 1 at the entry."""
        return tuple(part.name or str(number) for number, part in enumerate(self.netting, start=1))

    def sections_of_bands(self, globalisation: float = 1) -> tuple[int, ...]:
        """Number of the section, from 0, of each band between two rows of knots, from the entry to the codline."""
        rows = (part.merged_rows(globalisation) for part in self.netting)
        return tuple(chain.from_iterable(repeat(number, count) for number, count in enumerate(rows)))

    @property
    def source(self) -> Path:
        """The file the plan came from."""
        return self._source

    @property
    def catch_density_kg_m3(self) -> float:
        """Density of the catch: its own, or the water's when the plan gives none."""
        return self.catch.density_kg_m3 or self.tow.water_density_kg_m3

    @property
    def water_is_assumed(self) -> bool:
        """Whether the plan leaves the water's density out."""
        return "water_density_kg_m3" not in self.tow.model_fields_set

    @property
    def sphere_cp_path(self) -> Path | None:
        """The user's own Cp curve for the sphere law; None for the one that is shipped."""
        return None if self.catch.sphere_cp_csv is None else self.source.parent / as_name(self.catch.sphere_cp_csv)

    @property
    def globalisations(self) -> tuple[int, ...]:
        """Meshes that can be merged, each way: divisors of every mesh count that leave at least 3 meshes round.

        Rows that carry a strap, or where a rope or a layer begins, stay rows.
        """
        counts = [count for part in self.netting for count in (*part.open_meshes, part.meshes_long)]
        counts += [count for window in self.window for count in (window.meshes_round, window.meshes_long)]
        counts += [count for hole in self.holes for count in (hole.fore, hole.deep, hole.across)]
        counts += [count // part.panels for part in self.netting if part.has_seams for count in part.open_meshes]
        common = math.gcd(*counts, *self.strap_rows, *self.rope_rows, *self.layer_rows)
        most = min(min(part.open_meshes) for part in self.netting) // 3
        divisors = tuple(g for g in range(1, min(common, most) + 1) if common % g == 0)
        return tuple(filter(self._windows_have_room, divisors)) if self.window else divisors

    def _windows_have_room(self, globalisation: int) -> bool:
        """Whether windows lie apart, and no rope runs through one, on the columns that there are of merged meshes."""
        holes = [hole.merged(globalisation) for hole in self.holes]
        around = [part.open_meshes[0] // globalisation for part in self.netting]
        apart = not any(too_near(one, other, around[one.section]) for one, other in combinations(holes, 2))
        for hole in holes:
            part = self.netting[hole.section]
            if part.tapers:
                seams = part.panels if part.has_seams else self.places_round(globalisation)
                apart = apart and hole.clear_of_seams(part, seams, globalisation)
        return apart and all(self._rope_through_window(rope, globalisation) is None for rope in self.rope)

    def cases(self) -> tuple[Case, ...]:
        """Every speed with every catch, catches running fastest."""
        pairs = [(speed, size) for speed in self.tow.speed_m_s for size in self.catch.sizes]
        return tuple(Case(n, speed, self.catch.kind, size) for n, (speed, size) in enumerate(pairs, start=1))

    def with_pressure(self, law: "Callable[[ArrayLike], ArrayLike]") -> "Plan":
        """The same plan with a pressure law of one's own.

        Args:
            law: net pressure on the netting, inside less outside, over rho V^2 / 2, by the angle in degrees between
                the upstream direction and the netting's outward normal, arrays (k,). It is read at every degree, and
                between by a monotone cubic.

        Raises:
            InputError: the law gives what is no number.
        """
        import numpy as np

        theta = np.arange(0.0, 181.0)
        net = np.broadcast_to(np.asarray(law(theta), dtype=float), theta.shape)
        curve = [[float(angle), float(cp)] for angle, cp in zip(theta, 1.0 - net, strict=True)]
        tables = self.said()
        kept = {key: value for key, value in tables["catch"].items() if key not in ("coefficient", "sphere_cp_csv")}
        return plan_from_dict(tables | {"catch": kept | {"pressure": "sphere", "sphere_cp": curve}}, self.source)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], overrides: Overrides = ()) -> "Plan":
        """A plan from its tables, as ``tomllib`` would read them; see ``plan_from_dict``.

        Raises:
            InputError: keys that are unknown, missing, mistyped, out of range or contradictory.
        """
        return plan_from_dict(data, overrides=overrides)

    def __repr__(self) -> str:
        sections = ", ".join(f"{part.meshes_round} x {part.meshes_long} {part.mesh}" for part in self.netting)
        return f"<Plan {self.title!r}: {sections}; {len(self.cases())} cases>"

    def said(self) -> dict[str, Any]:
        """The tables as they were given, without what was left out: changes laid over them are those of its file."""
        return self.model_dump(mode="json", exclude_unset=True, exclude_none=True)

    def to_dict(self) -> dict[str, Any]:
        """Plain tables, defaults filled in and absent keys left out; ``plan_from_dict`` reads them back."""
        return self.model_dump(mode="json", exclude_none=True)


def load_plan(path: str | Path, overrides: Overrides = ()) -> Plan:
    """Read a TOML plan, lay ``overrides`` over it, and check the result.

    Overrides are texts such as ``"netting.0.bar_mm=25"``, or a table such as ``{"netting.0.bar_mm": 25}``.

    Raises:
        InputError: no such file, not TOML, or anything ``plan_from_dict`` refuses.
    """
    return plan_from_dict(read_toml(path, "TOML plan"), path, overrides)


def plan_from_dict(data: Mapping[str, Any], source: str | Path = "plan", overrides: Overrides = ()) -> Plan:
    """Check tables as ``tomllib`` returns them, after ``overrides`` (see ``apply_overrides`` for their rules).

    Raises:
        InputError: unknown, missing, mistyped, out-of-range or contradictory keys, a Cp curve that is no file: the
            first of them, with ``lines`` for all.
    """
    return plan_of(apply_overrides(data, overrides, source), source)


def plan_of(tables: Mapping[str, Any], source: str | Path) -> Plan:
    """``plan_from_dict`` of plain tables, all changes made.

    Raises:
        InputError: see there.
    """
    found: list[InputError] = []
    try:
        plan = checked(Plan, tables, source, _STAND_INS)
    except InputError as error:
        found += [error, *error.others]
    key, catch = "catch.sphere_cp_csv", tables.get("catch")
    curve = catch.get("sphere_cp_csv") if isinstance(catch, Mapping) else None
    # os.path.isfile, unlike Path.is_file, is False and not an error for names no file can have
    is_file = isinstance(curve, str) and os.path.isfile(Path(source).parent / as_name(curve))
    if isinstance(curve, str) and not is_file and key not in {error.key for error in found}:
        found.append(InputError(source, key, curve, "a CSV file, its path relative to the plan's folder"))
    if found:
        raise all_at_once(found) from None
    plan._source = Path(source)
    return plan
