"""What the user said of a scene: a TOML file of ropes, netting, points, vessel and water, checked once."""

from collections.abc import Iterator, Mapping, Sequence, Set
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import Field, PrivateAttr, model_validator

from codend.errors import InputError
from codend.io.names import as_name
from codend.io.toml import read_toml
from codend.net.net import Floats
from codend.netting.sheet import EDGES
from codend.plan.messages import Contradiction
from codend.plan.mistakes import checked
from codend.plan.overrides import apply_overrides
from codend.plan.tables import Table, Text
from codend.scenes.frame_checks import ballast_contradictions, frame_contradictions
from codend.scenes.frame_tables import FRAME, BallastTable, FloatTable, FrameTable
from codend.scenes.netting_checks import carried, links_of, netting_contradictions
from codend.scenes.netting_tables import CORNERS, PLANES, SeamTable, SheetTable
from codend.scenes.tables import (
    FASTEST_M_S,
    VESSEL,
    PointTable,
    RopeTable,
    SceneModel,
    SeabedTable,
    TimeTable,
    Vector,
    VesselTable,
    WaterTable,
)

FAST = ("vessel", "ground", FRAME)
"""What holds a point every way."""
NETTING_LENGTH_ERROR = 0.05
"""Netting that flaps is followed with so much in a step; the next one mends it."""
FULL_WIDTH = 1e-9
"""By how much, relative, the corners of a held edge may be farther apart than it is long: round-off."""
STEPS_A_PERIOD = 20
"""Fewest time steps in a period of heave: of fewer the motion would be another."""


class Scene(Table):
    """A whole scene."""

    title: Text
    water: WaterTable = WaterTable()
    rope: tuple[RopeTable, ...] = ()
    netting: tuple[SheetTable, ...] = ()
    seam: tuple[SeamTable, ...] = ()
    point: tuple[PointTable, ...] = ()
    frame: FrameTable | None = None
    floats: tuple[FloatTable, ...] = Field(default=(), alias="float")
    ballast: BallastTable | None = None
    vessel: VesselTable | None = None
    time: TimeTable | None = None
    seabed: SeabedTable | None = None
    model: SceneModel = SceneModel()
    _source: Path = PrivateAttr(default=Path("scene"))

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        Contradiction.raise_first(self._contradictions())
        return self

    def _contradictions(self) -> Iterator[Contradiction]:
        if not self.rope and not self.netting:
            yield Contradiction("rope", "one table [[rope]] or [[netting]] at least", "is missing")
        names = [point.name for point in self.point]
        for index, name in enumerate(names):
            if name in names[:index]:
                yield Contradiction(f"point.{index}.name", "a name that no other point has")
        known = [*names, *([VESSEL] if self.vessel is not None else []), *([FRAME] if self.frame is not None else [])]
        for index, rope in enumerate(self.rope):
            for key, end in zip(("from", "to"), rope.ends, strict=True):
                if end not in known:
                    yield Contradiction(f"rope.{index}.{key}", f"the name of a point: {', '.join(known) or 'none'}")
            if rope.ends[0] == rope.ends[1]:
                yield Contradiction(f"rope.{index}.to", "another point than the one it starts from")
        rope_names = self.rope_names
        for index, name in enumerate(rope_names):
            if name in (*rope_names[:index], *known):
                yield Contradiction(f"rope.{index}.name", "a name that no other rope or point has")
        yield from netting_contradictions(self.netting, self.seam, known, self._rope_ends, self._cannot_hold())
        used = {end for rope in self.rope for end in rope.ends} | {
            end for sheet in self.netting for end in sheet.points
        }
        named = [*names, *rope_names, *(sheet.name for sheet in self.netting)]
        yield from frame_contradictions(self.frame, self.floats, named, self._on_frame(used), self.time is not None)
        yield from ballast_contradictions(self.ballast, self.netting, names)
        for index, point in enumerate(self.point):
            if point.name not in used and point.held != FRAME:
                yield Contradiction(f"point.{index}.name", "a point that a rope or netting runs to", "is on none")
            if point.held in (cannot := self._cannot_hold()):
                yield Contradiction(f"point.{index}.held", cannot[point.held])
            if point.held_from_s is not None and self.time is None:
                yield Contradiction(f"point.{index}.held_from_s", "a table [time] with it")
            if self.time is not None and point.held_from_s is not None and point.held_from_s >= self.time.end_s:
                yield Contradiction(f"point.{index}.held_from_s", f"below time.end_s, {self.time.end_s:g}")
            if self.seabed is not None and point.at is not None and point.at[2] < -self.seabed.depth_m:
                yield Contradiction(f"point.{index}.at", f"not below the seabed, {self.seabed.depth_m:g} m deep")
        if self.vessel is not None and self.seabed is not None and self.vessel.at[2] < -self.seabed.depth_m:
            yield Contradiction("vessel.at", f"not below the seabed, {self.seabed.depth_m:g} m deep")
        if self.time is not None and self.vessel is not None and self.vessel.period_s is not None:
            longest = self.vessel.period_s / STEPS_A_PERIOD
            if self.time.step_s > longest:
                yield Contradiction("time.step_s", f"at most {longest:g}, a {STEPS_A_PERIOD}th of vessel.period_s")
        if self.time is None and self.vessel is not None:
            for key in ("motion", "heave_m"):
                if key in self.vessel.model_fields_set:
                    yield Contradiction(f"vessel.{key}", "a table [time] with it")
        if any(point.held_from_s is not None for point in self.point):
            for index, rope in enumerate(self.rope):
                if rope.axial_stiffness_n is None:
                    allowed = "given where a point is held from a time on, for a stop without stretch has no peak"
                    yield Contradiction(f"rope.{index}.axial_stiffness_n", allowed, "is missing")
        placed = {point.name for point in self.point if point.at is not None} | {VESSEL, FRAME}
        reached = carried(placed, [set(rope.ends) for rope in self.rope])
        for index, point in enumerate(self.point):
            if point.name not in reached:
                yield Contradiction(f"point.{index}.at", "where it starts: [x, y, z] in m", "is missing")
        yield from self._not_held()
        yield from self._too_short()
        yield from self._across_its_plane()

    def _cannot_hold(self) -> dict[str, str]:
        """What can hold nothing here, and what is allowed instead."""
        found = {}
        if self.frame is None:
            found[FRAME] = '"ground", or a table [frame]'
        if self.vessel is None:
            found["vessel"] = '"ground", or a table [vessel]'
        elif self.vessel.speed_m_s > 0.0:
            found["ground"] = "vessel.motion in place of vessel.speed_m_s, for places are as seen from the vessel"
        return found

    def _on_frame(self, used: Set[str]) -> bool:
        """Whether anything is fastened to the frame, of which points ``used`` are on ropes or netting."""
        edges = [sheet.hold_of(edge) for sheet in self.netting for edge in EDGES]
        return FRAME in used or FRAME in edges or any(point.held == FRAME for point in self.point)

    def _not_held(self) -> Iterator[Contradiction]:
        """Ropes and netting that hang on nothing."""
        held = {point.name for point in self.point if point.held in FAST} | set(FAST)
        held -= {VESSEL} if self.vessel is None else set()
        found = carried(held, links_of(self.netting, self.seam, self._rope_ends))
        for index, rope in enumerate(self.rope):
            if not found & set(rope.ends):
                yield Contradiction(f"rope.{index}.from", "a rope that hangs, by others, on a held point or the vessel")
        for index, sheet in enumerate(self.netting):
            if sheet.name not in found:
                allowed = "netting that hangs, by ropes or other netting, on a held point or the vessel"
                yield Contradiction(f"netting.{index}.corners", allowed)

    def _too_short(self) -> Iterator[Contradiction]:
        """Ropes and netting that do not stretch, between held points that are farther apart."""
        places: dict[str | None, Vector] = {
            point.name: point.at for point in self.point if point.held in self._fast and point.at
        }
        if self.vessel is not None:
            places[VESSEL] = self.vessel.at
        for index, rope in enumerate(self.rope):
            if rope.axial_stiffness_n is None and set(rope.ends) <= places.keys():
                first, last = (np.array(places[end]) for end in rope.ends)
                apart = float(np.linalg.norm(last - first))
                if rope.length_m <= apart:
                    yield Contradiction(f"rope.{index}.length_m", f"above {apart:g}, the distance of its held ends")
        for index, sheet in enumerate(self.netting):
            for edge in EDGES if sheet.twine.axial_stiffness_n is None else ():
                held = sheet.hold_of(edge) in FAST
                on = [sheet.corners[corner] for corner in CORNERS[edge]]
                ends = [places.get(corner) if isinstance(corner, str) else corner if held else None for corner in on]
                if ends[0] is None or ends[1] is None:
                    continue
                apart, reach = float(np.linalg.norm(np.subtract(ends[0], ends[1]))), sheet.reach_m(edge)
                # of an edge that is held all along no bar has to pull
                if apart > reach * (1.0 + FULL_WIDTH) or (apart >= reach and not held):
                    allowed = f"given, or the held corners of its {edge} edge nearer than {reach:g} m, not {apart:g} m"
                    yield Contradiction(f"netting.{index}.axial_stiffness_n", allowed, "is missing")

    def _across_its_plane(self) -> Iterator[Contradiction]:
        """A current across a plane beyond which there is the same again."""
        edges = [hold for sheet in self.netting for edge in EDGES if (hold := sheet.hold_of(edge)) in PLANES]
        if not edges and not any(point.held == "symmetry" for point in self.point):
            return
        where = "symmetry" if not edges or "symmetry" in edges else "repeats"
        allowed = f'[x, 0, z] beside what is held by "{where}", for it goes on beyond as in a mirror'
        for index, layer in enumerate(self.water.profile):
            if layer.flow_m_s[1] != 0.0:
                yield Contradiction(f"water.profile.{index}.flow_m_s", allowed)
        if self.water.flow_m_s[1] != 0.0:
            yield Contradiction("water.flow_m_s", allowed)

    @property
    def afloat(self) -> bool:
        """Whether its frame floats."""
        return self.frame is not None and self.frame.hold == "floating"

    @property
    def _fast(self) -> tuple[str, ...]:
        """What holds points where they are."""
        return FAST[:2] if self.afloat else FAST

    @property
    def rope_names(self) -> tuple[str, ...]:
        """What tables call the ropes."""
        return tuple(rope.name or f"rope {number}" for number, rope in enumerate(self.rope, start=1))

    @property
    def _rope_ends(self) -> dict[str, tuple[str, str]]:
        return {name: rope.ends for name, rope in zip(self.rope_names, self.rope, strict=True)}

    @property
    def speed_m_s(self) -> float:
        """Of the vessel, 0 where it does not tow or moves by a table."""
        return self.vessel.speed_m_s if self.vessel is not None else 0.0

    @property
    def length_error(self) -> float:
        """What a step of the motion may leave a bar off its length, relative."""
        given = None if self.time is None else self.time.length_error
        return given or (NETTING_LENGTH_ERROR if self.netting else 1e-7)

    @property
    def source(self) -> Path:
        """The file it came from."""
        return self._source

    def coefficients(self, point: PointTable) -> tuple[float, float]:
        """Lift and drag of a point, from its table where it has one."""
        if point.table is None:
            return point.lift, point.drag
        table = _door_table(self.source.parent / as_name(point.table))
        assert point.attack_deg is not None
        if not table[0, 0] <= point.attack_deg <= table[-1, 0]:
            index = self.point.index(point)
            allowed = f"from {table[0, 0]:g} to {table[-1, 0]:g}, the angles in {point.table}"
            raise InputError(self.source, f"point.{index}.attack_deg", point.attack_deg, allowed)
        lift, drag = (float(np.interp(point.attack_deg, table[:, 0], table[:, column])) for column in (1, 2))
        return lift, drag

    def vessel_path(self) -> Floats | None:
        """Times and places of the vessel's table of motion, (k, 4); None without one."""
        if self.vessel is None or self.vessel.motion is None or self.time is None:
            return None
        from codend.io.input_table import read_table

        names = ("time_s", "x_m", "y_m", "z_m")
        table = read_table(self.source.parent / as_name(self.vessel.motion), names=names)
        path: Floats = np.stack([table.numbers(name) for name in names], axis=1)
        _rising(table.where, "time_s", path[:, 0])
        speed = np.linalg.norm(np.diff(path[:, 1:], axis=0), axis=1) / np.diff(path[:, 0])
        if np.any(too_fast := speed > FASTEST_M_S):
            row = int(np.argmax(too_fast))
            said = f"go at {speed[row]:.3g} m/s from {path[row, 0]:g} s on"
            raise InputError(table.where, "x_m, y_m, z_m", None, f"at most {FASTEST_M_S:g} m/s", said)
        if path[0, 0] > 0.0 or path[-1, 0] < self.time.end_s:
            allowed = f"times from 0 to time.end_s, {self.time.end_s:g}"
            raise InputError(table.where, "time_s", None, allowed, "does not run over the whole motion")
        return path


def _door_table(path: Path) -> Floats:
    from codend.io.input_table import read_table

    names = ("attack_deg", "lift", "drag")
    table = read_table(path, names=names)
    found: Floats = np.stack([table.numbers(name) for name in names], axis=1)
    _rising(table.where, "attack_deg", found[:, 0])
    return found


def _rising(where: str, column: str, values: Floats) -> None:
    if len(values) < 2:
        raise InputError(where, column, None, "two rows or more", f"has {len(values)}")
    falling = np.flatnonzero(np.diff(values) <= 0.0)
    if len(falling):
        raise InputError(where, column, float(values[falling[0] + 1]), "numbers that rise from row to row")


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Read a TOML scene, lay ``overrides`` such as ``"rope.0.length_m=25"`` over it, and check the result.

    Raises:
        InputError: no such file, not TOML, or anything ``scene_from_dict`` refuses.
    """
    return scene_from_dict(read_toml(path, "TOML scene"), path, overrides)


def scene_from_dict(data: Mapping[str, Any], source: str | Path = "scene", overrides: Sequence[str] = ()) -> Scene:
    """Check tables as ``tomllib`` returns them.

    Raises:
        InputError: unknown, missing, mistyped, out-of-range or contradictory keys, tables that are no files: the first
            of them, with ``lines`` for all.
    """
    scene = checked(Scene, apply_overrides(data, overrides, source), source)
    scene._source = Path(source)
    scene.vessel_path()
    for point in scene.point:
        scene.coefficients(point)
    return scene
