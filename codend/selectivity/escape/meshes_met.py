"""The meshes ahead of a catch, as fish meet them: their holes, places and parts of the codend."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.io.columns import ALL_PANELS
from codend.plan.kinds import Kind
from codend.plan.merging import rows_merged
from codend.plan.plan import Netting, Plan
from codend.plan.tables import TUBE
from codend.plan.windows import Window
from codend.selectivity.escape.penetration import SHAPES, Holes
from codend.selectivity.escape.yielding import held_by_neighbours, load_along

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

UNNAMED: Final = ("", TUBE, ALL_PANELS)
"""What is no name of a panel."""


class Part(NamedTuple):
    """A part of a codend, by name."""

    section: str
    panel: str
    """Empty where meshes are told apart by section only."""


@dataclass(frozen=True)
class Catch:
    """A solved case: its size and the meshes that fish meet ahead of it."""

    case: int
    speed_m_s: float
    volume_m3: float
    opening_ahead_deg: float
    holes: Holes
    rows_ahead: Floats
    """Distance of each mesh from the front, in rows of meshes; 1 and more lie wholly ahead, (k,)."""
    share: Floats
    """Share of each mesh in its row, (k,)."""
    parts: tuple[Part, ...] = ()
    """Where each mesh lies, (k,); empty: all in one part."""
    opening_error_deg: float = 0.0
    """By how much the openings may be off: the estimate of that ahead of the catch; nan where there is none."""
    smeared: bool = False
    """Whether ropes were smeared over all meshes, whose openings are then means round the ring."""
    merged_alike: Holes | None = None
    """Holes as they were if all real rows of a merged one were alike; None where none are merged."""


@dataclass(frozen=True)
class SolvedMeshes:
    """A solved case: its size, and the meshes of its net in the columns of the tables."""

    case: int
    speed_m_s: float
    filled_meshes: float
    volume_m3: float
    opening_ahead_deg: float
    opening_error_deg: float
    smeared: bool
    merged: float
    """Real rows that each row stands for."""
    place: Floats
    """Place of every row, in meshes from the entry, (r,)."""
    radius_m: Floats
    """Radius of every row, (r,)."""
    meshes: Mapping[str, NDArray[Any]]
    """Columns row, section, opening_deg, bar_tension_n and, of several panels, panel, (k,) each."""
    layers: Sequence[tuple[int, Mapping[str, NDArray[Any]]]] = ()
    """Number of every second layer in the plan, and its columns row, opening_deg and bar_tension_n."""


def catch_of(plan: Plan, solved: SolvedMeshes, most_rows: float) -> Catch:
    """A solved case with the meshes up to ``most_rows`` + 1 rows ahead of the front.

    A net that is the same all round has one mesh a row, the mean of it, another all its meshes; every row of a
    globalised net stands for as many real ones, whose openings and tensions go linearly from that of one merged row to
    that of the next; radii are those of the merged row.
    """
    merged, meshes = solved.merged, solved.meshes
    number = {name: i for i, name in enumerate((*plan.section_names, *plan.window_names))}
    sections = [*plan.netting, *plan.window]
    section = np.array([number[name] for name in meshes["section"]], dtype=np.int64)
    row = meshes["row"].astype(int)
    real_rows = np.append(0.0, np.cumsum(rows_merged(plan.netting, len(solved.place) - 1, merged)))
    front_row = np.interp(solved.place[-1] - solved.filled_meshes, solved.place, real_rows)
    # a merged row stands for real rows about it, of square mesh for those behind it
    staggered = np.array([part.kind.staggered for part in sections])[section]
    lines = round(merged)
    within = (np.arange(lines) - np.where(staggered[:, None], 0.5 * (lines - 1), 0.0)) * merged / lines
    ahead = (float(front_row) - merged * row[:, None] - within).ravel()
    near = (ahead > 0.0) & (ahead < most_rows + 1.0)
    which = np.repeat(np.arange(len(row)), lines)[near]
    share = 1.0 / np.bincount(row)[row]
    panels = ["" if panel in UNNAMED else str(panel) for panel in meshes.get("panel", len(row) * [""])]
    met = {name: meshes[name][which] for name in ("row", "opening_deg", "bar_tension_n")}

    def holes_of(met: Mapping[str, NDArray[Any]]) -> Holes:
        return _of_all_layers(plan, solved, _holes(sections, section[which], met, solved.radius_m), row[which])

    merged_alike = None
    if lines > 1:
        merged_alike = holes_of(met)
        for name, most in (("opening_deg", 180.0), ("bar_tension_n", np.inf)):
            along = _between_merged_rows(meshes[name].astype(float), row, section, ahead.reshape(-1, lines))
            met[name] = np.clip(along.ravel()[near], 0.0, most)
    return Catch(
        case=solved.case,
        speed_m_s=solved.speed_m_s,
        volume_m3=solved.volume_m3,
        opening_ahead_deg=solved.opening_ahead_deg,
        holes=holes_of(met),
        rows_ahead=ahead[near],
        share=share[which],
        parts=tuple(Part(str(meshes["section"][i]), panels[i]) for i in which),
        opening_error_deg=solved.opening_error_deg,
        smeared=solved.smeared,
        merged_alike=merged_alike,
    )


def _between_merged_rows(values: Floats, row: Counts, section: Counts, ahead: Floats) -> Floats:
    """What merged meshes (k,) have, at the real rows that they stand for (k, lines), which lie so far ahead.

    The mean of a row goes linearly from the middle of one merged row to that of the next of its section; by how much a
    mesh differs from that mean it does in all of its rows.
    """
    found = np.repeat(values[:, None], ahead.shape[1], axis=1)
    for number in np.unique(section):
        here = np.flatnonzero(section == number)
        _, first, own = np.unique(row[here], return_index=True, return_inverse=True)
        mean = np.bincount(own, values[here]) / np.bincount(own)
        middle = ahead[here[first]].mean(axis=1)
        # the farther back the row, the nearer to the front
        found[here] += np.interp(ahead[here], middle[::-1], mean[::-1]) - mean[own][:, None]
    return found


def rows_that_count(kinds: Sequence[Kind]) -> NDArray[np.bool_]:
    """Whether a row counts meshes, by the kinds of the bands, (bands + 1,).

    A square mesh lies behind the row that counts it, another about it; where square mesh ends a row counts none.
    """
    staggered = np.array([kind.staggered for kind in kinds])
    return np.append(~staggered | np.append(False, staggered[:-1]), False)


def _holes(sections: Sequence[Netting], number: Counts, meshes: Mapping[str, NDArray[Any]], radius_m: Floats) -> Holes:
    """Holes of meshes, (k,), that are of the netting of these numbers."""

    def of_each(value: Callable[[Netting], Any]) -> NDArray[Any]:
        return np.array([value(part) for part in sections])[number]

    row = meshes["row"].astype(int)
    half = 0.5 * np.radians(meshes["opening_deg"].astype(float))
    bar, bar_full, width = (
        of_each(lambda s: s.clear_bar_m),
        of_each(lambda s: s.bar_m),
        of_each(lambda s: s.drag_width_m),
    )
    # the chord between two meridional bars, which a bar across them bounds
    behind = np.minimum(row + 1, len(radius_m) - 1)
    between = (radius_m[row] + radius_m[behind]) * np.sin(np.pi / of_each(lambda s: max(s.open_meshes)))
    # in a window and where counts differ round the ring, by the mesh's own opening
    alone = of_each(lambda s: isinstance(s, Window) or s.tapers)
    between = np.where(alone, bar_full * np.tan(np.minimum(half, 0.5 * np.pi - 1e-9)), between)
    shape = of_each(lambda s: SHAPES[s.kind.hole])
    rectangle = shape == SHAPES["rectangle"]
    across = np.where(rectangle, np.clip(between - width, 0.0, bar), bar)
    bending, rest = of_each(lambda s: s.bending_n), of_each(lambda s: s.rest_half_angle_rad)
    stretch = of_each(lambda s: np.inf if s.axial_stiffness_n is None else s.axial_stiffness_n)
    tension = meshes["bar_tension_n"].astype(float)
    load = load_along(tension, half, bending, rest)
    knot = of_each(lambda s: s.knot_m)
    held = held_by_neighbours(
        tension,
        half,
        np.where(rectangle, np.inf, stretch),
        bending,
        rest,
        knot / bar_full,
        shape == SHAPES["rhombus, knots across"],
    )
    return Holes(shape, bar, knot, half, across, load, bending, rest, *held)


def _of_all_layers(plan: Plan, solved: SolvedMeshes, holes: Holes, row: Counts) -> Holes:
    """The holes that fish have to pass: under a second layer the tighter of both meshes.

    Tighter is the one that a fish of round section cannot pass first. Layers lie on the netting, so that a fish which
    has passed one mesh meets the other at once.
    """
    for number, own in solved.layers:
        order = np.argsort(own["row"])
        at = np.minimum(np.searchsorted(own["row"][order], row), len(order) - 1)
        over = np.flatnonzero(own["row"][order[at]] == row)
        if len(over) == 0:
            continue
        meshes = {name: own[name][order[at[over]]] for name in ("row", "opening_deg", "bar_tension_n")}
        mine = _holes([plan.layer[number]], np.zeros(len(over), dtype=np.int64), meshes, solved.radius_m)
        tighter = _widest_round(mine) < _widest_round(holes)[over]
        chosen = {}
        for field in fields(Holes):
            values = getattr(holes, field.name).copy()
            values[over[tighter]] = getattr(mine, field.name)[tighter]
            chosen[field.name] = values
        holes = Holes(**chosen)
    return holes


def _widest_round(holes: Holes) -> Floats:
    """Radius of the largest round section that passes a rhombus of these bars, or half a rectangle's shorter side."""
    by_rhombus = holes.bar_m * np.sin(holes.half_angle_rad) * np.cos(holes.half_angle_rad)
    return np.where(holes.shape == SHAPES["rectangle"], 0.5 * np.minimum(holes.across_m, holes.bar_m), by_rhombus)
