"""The meshes ahead of every catch of a study, as fish meet them: from the study's tables and its plan."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError
from codend.io.columns import ALL_PANELS, OF_LAYERS, PLACE
from codend.io.input_table import InputTable
from codend.io.run_tables import read_run_table, solved_cases
from codend.plan.merging import between_ropes, rows_merged
from codend.plan.plan import Netting, Plan, load_plan
from codend.plan.tables import TUBE
from codend.plan.windows import Window
from codend.selectivity.escape.penetration import SHAPES, Holes
from codend.selectivity.escape.yielding import held_by_neighbours, load_along

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

OF_ROWS: Final = ("case", "row", *PLACE, "radius_m", "bar_tension_n")
OF_MESHES: Final = ("case", "row", *PLACE, "opening_deg", "bar_tension_n")
"""Columns that are read, which have a value in every row."""


class Solved(Protocol):
    """A study in memory: its plan, and its tables as ``codend run`` writes them."""

    @property
    def plan(self) -> Plan:
        """What was solved."""

    @property
    def table(self) -> pd.DataFrame:
        """``results.csv``."""

    @property
    def profile(self) -> pd.DataFrame:
        """``profile.csv``."""

    @property
    def meshes(self) -> pd.DataFrame:
        """``meshes.csv``."""

    @property
    def layers(self) -> pd.DataFrame:
        """``layers.csv``."""


@dataclass(frozen=True)
class Run:
    """What is read of a study: its plan and its tables."""

    source: str
    plan: Plan
    results: pd.DataFrame
    profile: pd.DataFrame
    meshes: pd.DataFrame
    """Empty where the model is one mesh wide."""
    layers: pd.DataFrame | None = None
    """Bands under second layers; None without."""


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


def run_of(study: Solved) -> Run:
    """A study that is still in memory."""
    return Run(str(study.plan.source), study.plan, study.table, study.profile, study.meshes, study.layers)


def read_run(folder: str | Path) -> Run:
    """A study from the folder ``codend run`` wrote: plan.toml, results.csv, profile.csv and, if there, meshes.csv.

    Raises:
        InputError: a file is missing, or anything ``read_run_table`` refuses.
    """
    import pandas as pd

    folder = Path(folder)
    if not (folder / "plan.toml").is_file():
        raise InputError(folder, "", None, "a folder that codend run wrote", "holds no plan.toml")
    meshes = folder / "meshes.csv"
    return Run(
        str(folder),
        load_plan(folder / "plan.toml"),
        read_run_table(folder / "results.csv"),
        read_run_table(folder / "profile.csv", OF_ROWS),
        read_run_table(meshes, OF_MESHES) if meshes.exists() else pd.DataFrame(columns=list(OF_MESHES)),
        read_run_table(folder / "layers.csv", OF_LAYERS[:4]) if (folder / "layers.csv").exists() else None,
    )


def catches_of(run: Run, most_rows: float) -> list[Catch]:
    """Solved cases of a study, with the meshes up to ``most_rows`` + 1 rows ahead of the front.

    A net that is the same all round has one mesh a row, the mean of it, another all its meshes; every row of a
    globalised net stands for as many real ones.

    Raises:
        InputError: no case was solved, or the tables do not hold all of those that were.
    """
    results = InputTable(str(Path(run.source) / "results.csv"), run.results)
    results.require(("fidelity", "opening_ahead_deg"))
    solved = solved_cases(run.results, results.source, ("case", "speed_m_s", "filled_meshes", "catch_volume_m3"))
    InputTable(results.source, solved).check("case", ~solved["case"].duplicated().to_numpy(), "each case once")
    names_of = (*run.plan.section_names, *run.plan.window_names)
    section_of = dict(zip(names_of, (*run.plan.netting, *run.plan.window), strict=True))
    found = []
    for result in solved.to_dict("records"):
        profile, merged = _profile_of(run, result)
        meshes = _meshes_of(run, result, profile, merged)
        sections = [section_of[name] for name in meshes["section"]]
        place, row = profile["meshes_from_entry"].to_numpy(), meshes["row"].to_numpy(dtype=int)
        front_row = np.interp(place[-1] - result["filled_meshes"], place, merged * np.arange(len(place)))
        # a merged row stands for real rows about it, of square mesh for those behind it
        staggered = np.array([section.kind.staggered for section in sections])
        lines = round(merged)
        within = (np.arange(lines) - np.where(staggered[:, None], 0.5 * (lines - 1), 0.0)) * merged / lines
        ahead = (float(front_row) - merged * row[:, None] - within).ravel()
        near = (ahead > 0.0) & (ahead < most_rows + 1.0)
        which = np.repeat(np.arange(len(row)), lines)[near]
        share = 1.0 / np.bincount(row)[row]
        names, panels = meshes["section"].to_numpy(), np.full(len(row), "", dtype=object)
        if "panel" in meshes.columns:
            panels = meshes["panel"].fillna("").replace([TUBE, ALL_PANELS], "").to_numpy()
        found.append(
            Catch(
                case=int(result["case"]),
                speed_m_s=float(result["speed_m_s"]),
                volume_m3=float(result["catch_volume_m3"]),
                opening_ahead_deg=float(result["opening_ahead_deg"]),
                holes=_of_all_layers(
                    run,
                    result,
                    _holes([sections[i] for i in which], meshes.iloc[which], profile["radius_m"].to_numpy()),
                    meshes["row"].to_numpy(dtype=int)[which],
                    profile["radius_m"].to_numpy(),
                ),
                rows_ahead=ahead[near],
                share=share[which],
                parts=tuple(Part(str(names[i]), str(panels[i])) for i in which),
                opening_error_deg=float(result.get("opening_ahead_error_deg", np.nan)),
                smeared=result["fidelity"] == "smeared",
            )
        )
    return found


def _profile_of(run: Run, result: dict[Hashable, Any]) -> tuple[pd.DataFrame, float]:
    """Rows of a solved case, from the entry, and how many real ones each stands for."""
    source = str(Path(run.source) / "profile.csv")
    globalisations: list[float] = [1]
    if result["fidelity"] == "globalised":
        # in sectors between ropes by a number that divides nothing
        globalisations = [between_ropes(run.plan) or 1, *run.plan.globalisations]
    merged_in = {len(run.plan.sections_of_bands(g)): g for g in globalisations}
    profile = run.profile[run.profile["case"] == result["case"]].sort_values("row")
    last = len(profile) - 1
    if last not in merged_in or not np.array_equal(profile["row"], np.arange(last + 1)):
        allowed = f"rows 0 to {' or '.join(map(str, merged_in))}, each once, as in the plan"
        raise InputError(source, "case", result["case"], allowed, f"has {len(profile)} rows, not those of the plan")
    merged = merged_in[last]
    band, names = np.array(run.plan.sections_of_bands(merged)), np.array(run.plan.section_names, dtype=object)
    per_mesh = np.array([section.rows_per_mesh for section in run.plan.netting])[band]
    long = rows_merged(run.plan.netting, last, merged) / per_mesh
    section, place = profile["section"].to_numpy(), profile["meshes_from_entry"].to_numpy()
    joined = (section == names[np.append(band[:1], band)]) | (section == names[np.append(band, band[-1:])])
    table = InputTable(source, profile)
    table.check("section", joined, "a section of the plan that lies there: its name, or its number where it has none")
    placed = np.isclose(np.diff(place, prepend=0.0), np.append(0.0, long), rtol=1e-9, atol=1e-9)
    table.check("meshes_from_entry", placed, "the place of the plan's row")
    return profile, merged


def _meshes_of(run: Run, result: dict[Hashable, Any], profile: pd.DataFrame, merged: float) -> pd.DataFrame:
    """Meshes of a solved case: one a row of a net that is the same all round, of another all."""
    bands = [run.plan.netting[number].kind for number in run.plan.sections_of_bands(merged)]
    staggered = np.array([kind.staggered for kind in bands])
    # a square mesh lies behind the row that counts it, another about it; where square mesh ends a row counts none
    counting = np.append(~staggered | np.append(False, staggered[:-1]), False)
    meshes = run.meshes[run.meshes["case"] == result["case"]]
    if meshes.empty and result["fidelity"] in ("meridian", "smeared", "sector") and not _wide(result):
        rows = profile[counting]
        InputTable(str(Path(run.source) / "profile.csv"), rows).numbers("opening_deg")
        return rows
    source = str(Path(run.source) / "meshes.csv")
    section = profile["section"].to_numpy()
    row = np.sort(meshes["row"].to_numpy(dtype=float))
    if run.plan.tapers or run.plan.window or run.plan.ropes:
        # meshes round differ from row to row, and windows have their own
        wanted, found = np.flatnonzero(counting), np.unique(row)
    else:
        around = np.array([part.open_meshes[0] for part in run.plan.netting])
        number = {name: i for i, name in enumerate(run.plan.section_names)}
        count = around[[number[name] for name in section]] // merged * counting
        if result["fidelity"] in ("meridian", "sector"):
            count = np.rint(count / float(result["sector_order"])).astype(int)
        wanted, found = np.repeat(np.arange(len(count)), count), row
    if not np.array_equal(found, wanted):
        allowed = f"the {len(wanted)} of the plan in rows {wanted[0]} to {wanted[-1]}"
        raise InputError(source, "case", result["case"], allowed, f"has {len(meshes)} meshes, not those of the plan")
    own = meshes["section"].to_numpy() == section[meshes["row"].to_numpy(dtype=int)]
    own |= meshes["section"].isin(run.plan.window_names).to_numpy()
    InputTable(source, meshes).check("section", own, "that of its row in profile.csv, or a window")
    return meshes


def _wide(result: dict[Hashable, Any]) -> bool:
    """Whether more than one mesh round is modelled, all of which fish meet."""
    return float(result.get("sector_meshes", 1)) > 1 and result["fidelity"] == "sector"


def _holes(sections: list[Netting], meshes: pd.DataFrame, radius_m: Floats) -> Holes:
    row = meshes["row"].to_numpy(dtype=int)
    half = 0.5 * np.radians(meshes["opening_deg"].to_numpy(dtype=float))
    bar = np.array([s.clear_bar_m for s in sections])
    bar_full = np.array([s.bar_m for s in sections])
    width = np.array([s.drag_width_m for s in sections])
    around = np.array([max(s.open_meshes) for s in sections])
    # the chord between two meridional bars, which a bar across them bounds
    between = 2.0 * 0.5 * (radius_m[row] + radius_m[np.minimum(row + 1, len(radius_m) - 1)]) * np.sin(np.pi / around)
    # in a window and where counts differ round the ring, by the mesh's own opening
    alone = np.array([isinstance(s, Window) or s.tapers for s in sections], dtype=bool)
    between = np.where(alone, bar_full * np.tan(np.minimum(half, 0.5 * np.pi - 1e-9)), between)
    shape = np.array([SHAPES[s.kind.hole] for s in sections], dtype=np.int64)
    rectangle = shape == SHAPES["rectangle"]
    across = np.where(rectangle, np.clip(between - width, 0.0, bar), bar)
    bending, rest = np.array([s.bending_n for s in sections]), np.array([s.rest_half_angle_rad for s in sections])
    stretch = np.array([np.inf if s.axial_stiffness_n is None else s.axial_stiffness_n for s in sections])
    tension = meshes["bar_tension_n"].to_numpy(dtype=float)
    load = load_along(tension, half, bending, rest)
    knot = np.array([s.knot_m for s in sections])
    held = held_by_neighbours(
        tension,
        half,
        np.where(rectangle, np.inf, stretch),
        bending,
        rest,
        knot / np.array([s.bar_m for s in sections]),
        shape == SHAPES["rhombus, knots across"],
    )
    return Holes(shape, bar, knot, half, across, load, bending, rest, *held)


def _of_all_layers(run: Run, result: dict[Hashable, Any], holes: Holes, row: Counts, radius_m: Floats) -> Holes:
    """The holes that fish have to pass: under a second layer the tighter of both meshes.

    Tighter is the one that a fish of round section cannot pass first. Layers lie on the netting, so that a fish which
    has passed one mesh meets the other at once.
    """
    if run.layers is None or not run.plan.layer:
        return holes
    layers = run.layers[run.layers["case"] == result["case"]]
    for number, layer in enumerate(run.plan.layer, start=1):
        own = layers[layers["layer"].astype(str) == (layer.name or str(number))].set_index("row")
        over = np.flatnonzero(np.isin(row, own.index))
        if len(over) == 0:
            continue
        meshes = own.loc[row[over]].reset_index()[["row", "opening_deg", "bar_tension_n"]]
        mine = _holes([layer] * len(over), meshes, radius_m)
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
