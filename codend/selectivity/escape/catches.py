"""The meshes ahead of every catch of a study, as fish meet them: from the study's tables and its plan."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.bag.build import build_bag, rows_of
from codend.errors import InputError
from codend.io.input_table import InputTable
from codend.io.run_tables import read_run_table, solved_cases
from codend.plan.plan import Netting, Plan, load_plan
from codend.selectivity.escape.passage import KINDS, SQUARE
from codend.selectivity.escape.penetration import Holes

if TYPE_CHECKING:
    import pandas as pd

    from codend.studies.study import Study

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """What is read of a study: its plan and its tables."""

    source: str
    plan: Plan
    results: pd.DataFrame
    profile: pd.DataFrame
    meshes: pd.DataFrame
    """Empty for nets that are the same all round."""


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


def run_of(study: Study) -> Run:
    """A study that is still in memory."""
    return Run(str(study.plan.source), study.plan, study.table, study.profile, study.meshes)


def read_run(folder: str | Path) -> Run:
    """A study from the folder ``codend run`` wrote: plan.toml, results.csv, profile.csv and, if there, meshes.csv.

    Raises:
        InputError: a file is missing, or anything ``read_run_table`` refuses.
    """
    import pandas as pd

    folder, needed = Path(folder), ("case", "row", "opening_deg", "bar_tension_n")
    if not (folder / "plan.toml").is_file():
        raise InputError(folder, "", None, "a folder that codend run wrote", "holds no plan.toml")
    meshes = folder / "meshes.csv"
    return Run(
        str(folder),
        load_plan(folder / "plan.toml"),
        read_run_table(folder / "results.csv"),
        read_run_table(folder / "profile.csv", ("case", "row", "radius_m", "bar_tension_n")),
        read_run_table(meshes, needed) if meshes.exists() else pd.DataFrame(columns=list(needed)),
    )


def inside_mesh_m(section: Netting) -> float:
    """Stretched inside opening of a mesh: full mesh less one knot, or 2 (b - w) where the plan gives no knot, m."""
    return 2.0 * clear_bar_m(section) + section.knot_m


def clear_bar_m(section: Netting) -> float:
    """Length of a bar that no twine crosses, m; see ``codend.selectivity.escape.penetration``."""
    return section.bar_m if section.knot_m > 0.0 else section.bar_m - section.drag_width_m


def catches_of(run: Run, most_rows: float) -> list[Catch]:
    """Solved cases of a study, with the meshes up to ``most_rows`` + 1 rows ahead of the front.

    A net that is the same all round has one mesh a row, another all its meshes; every row of a globalised net stands
    for as many real ones.

    Raises:
        InputError: no case was solved, or the tables do not hold all of those that were.
    """
    results = InputTable(str(Path(run.source) / "results.csv"), run.results)
    results.require(("fidelity", "opening_ahead_deg"))
    solved = solved_cases(run.results, results.source, ("case", "speed_m_s", "filled_meshes", "catch_volume_m3"))
    InputTable(results.source, solved).check("case", ~solved["case"].duplicated().to_numpy(), "each case once")
    from_entry = np.concatenate([[0.0], np.cumsum([1.0 / section.rows_per_mesh for section in rows_of(run.plan)])])
    models: dict[int, Bag] = {}  # a sector of each globalisation
    found = []
    for result in solved.to_dict("records"):
        profile, merged = _profile_of(run, result)
        sections = rows_of(run.plan, merged)
        if merged not in models:
            models[merged] = build_bag(run.plan, globalisation=merged, sectors=1)
        bag = models[merged]
        meshes = _meshes_of(run, result, profile, bag)
        front_row = np.interp(from_entry[-1] - result["filled_meshes"], from_entry, np.arange(len(from_entry)))
        row = meshes["row"].to_numpy(dtype=int)
        # a merged row stands for real rows about it, of square mesh for those of the band behind it
        within = np.arange(merged) - np.where(np.append(bag.band_is_square, False)[row, None], 0.0, 0.5 * (merged - 1))
        ahead = (float(front_row) - merged * row[:, None] - within).ravel()
        near = (ahead > 0.0) & (ahead < most_rows + 1.0)
        which = np.repeat(np.arange(len(row)), merged)[near]
        share = 1.0 / np.bincount(row)[row]
        found.append(
            Catch(
                case=int(result["case"]),
                speed_m_s=float(result["speed_m_s"]),
                volume_m3=float(result["catch_volume_m3"]),
                opening_ahead_deg=float(result["opening_ahead_deg"]),
                holes=_holes(sections, meshes.iloc[which], profile["radius_m"].to_numpy()),
                rows_ahead=ahead[near],
                share=share[which],
            )
        )
    return found


def _profile_of(run: Run, result: dict[Hashable, Any]) -> tuple[pd.DataFrame, int]:
    """Rows of a solved case, from the entry, and how many real ones each stands for."""
    source = str(Path(run.source) / "profile.csv")
    globalisations = run.plan.globalisations if result["fidelity"] == "globalised" else (1,)
    merged = {len(rows_of(run.plan, g)): g for g in globalisations}
    profile = run.profile[run.profile["case"] == result["case"]].sort_values("row")
    last = len(profile) - 1
    if last not in merged or not np.array_equal(profile["row"], np.arange(last + 1)):
        allowed = f"rows 0 to {' or '.join(map(str, merged))}, each once, as in the plan"
        raise InputError(source, "case", result["case"], allowed, f"has {len(profile)} rows, not those of the plan")
    return profile, merged[last]


def _meshes_of(run: Run, result: dict[Hashable, Any], profile: pd.DataFrame, sector: Bag) -> pd.DataFrame:
    """Meshes of a solved case: one a row of a net that is the same all round, of another all."""
    # a row at which square mesh ends ahead of diamonds counts none
    meshes_round = sector.net.order * np.bincount(sector.mesh_row, minlength=len(profile))
    counted = np.flatnonzero(meshes_round)
    if run.meshes.empty and result["fidelity"] in ("meridian", "sector"):
        rows = profile.iloc[counted]
        InputTable(str(Path(run.source) / "profile.csv"), rows).numbers("opening_deg")
        return rows
    meshes = run.meshes[run.meshes["case"] == result["case"]]
    wanted = np.repeat(np.arange(len(meshes_round)), meshes_round)
    if not np.array_equal(np.sort(meshes["row"]), wanted):
        allowed = f"the {len(wanted)} of the plan in rows {counted[0]} to {counted[-1]}"
        source = Path(run.source) / "meshes.csv"
        raise InputError(source, "case", result["case"], allowed, f"has {len(meshes)} meshes, not those of the plan")
    return meshes


def _sections_of(meshes: pd.DataFrame, sections: list[Netting]) -> list[Netting]:
    """Section of each mesh, by the row it is counted by."""
    row = meshes["row"].to_numpy(dtype=int)
    # a square mesh lies behind the row it is counted by, another about it, at a joint one of the fewer meshes round
    pairs = [(sections[max(r - 1, 0)], sections[min(r, len(sections) - 1)]) for r in row]
    return [
        behind if behind.mesh == "square" or behind.meshes_round < ahead.meshes_round else ahead
        for ahead, behind in pairs
    ]


def _holes(sections: list[Netting], meshes: pd.DataFrame, radius_m: Floats) -> Holes:
    row, section = meshes["row"].to_numpy(dtype=int), _sections_of(meshes, sections)
    half = 0.5 * np.radians(meshes["opening_deg"].to_numpy(dtype=float))
    bar = np.array([clear_bar_m(s) for s in section])
    width = np.array([s.drag_width_m for s in section])
    around = np.array([s.meshes_round for s in section])
    # the chord between two meridional bars, which a bar across them bounds
    between = 2.0 * 0.5 * (radius_m[row] + radius_m[np.minimum(row + 1, len(radius_m) - 1)]) * np.sin(np.pi / around)
    kind = np.array([KINDS.index(s.mesh) for s in section], dtype=np.int64)
    across = np.where(kind == SQUARE, np.clip(between - width, 0.0, bar), bar)
    # half of a square mesh's bars run along the netting, and bear nearly all there is
    along = np.where(kind == SQUARE, 1.0, np.cos(half))
    load = 2.0 * meshes["bar_tension_n"].to_numpy(dtype=float) * along
    return Holes(kind, bar, np.array([s.knot_m for s in section]), half, across, load)
