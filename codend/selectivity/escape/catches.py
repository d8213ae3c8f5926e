"""The catches of a study, with the meshes that fish meet ahead of them, from its tables and its plan."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError
from codend.io.columns import OF_LAYERS, PLACE
from codend.io.input_table import InputTable
from codend.io.run_tables import read_run_table, solved_cases
from codend.plan.plan import Plan, load_plan
from codend.selectivity.escape.meshes_met import Catch, SolvedMeshes, catch_of, rows_that_count

if TYPE_CHECKING:
    import pandas as pd

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

    Raises:
        InputError: no case was solved, or the tables do not hold all of those that were.
    """
    return [catch_of(run.plan, solved, most_rows) for solved in _solved_in(run)]


def _solved_in(run: Run) -> Iterator[SolvedMeshes]:
    """The solved cases of a run's tables, which are checked."""
    results = InputTable(str(Path(run.source) / "results.csv"), run.results)
    results.require(("fidelity", "opening_ahead_deg"))
    solved = solved_cases(run.results, results.source, ("case", "speed_m_s", "filled_meshes", "catch_volume_m3"))
    InputTable(results.source, solved).check("case", ~solved["case"].duplicated().to_numpy(), "each case once")
    for result in solved.to_dict("records"):
        profile, merged = _profile_of(run, result)
        meshes = _meshes_of(run, result, profile, merged)
        yield SolvedMeshes(
            case=int(result["case"]),
            speed_m_s=float(result["speed_m_s"]),
            filled_meshes=float(result["filled_meshes"]),
            volume_m3=float(result["catch_volume_m3"]),
            opening_ahead_deg=float(result["opening_ahead_deg"]),
            opening_error_deg=float(result.get("opening_ahead_error_deg", np.nan)),
            smeared=result["fidelity"] == "smeared",
            merged=merged,
            place=profile["meshes_from_entry"].to_numpy(),
            radius_m=profile["radius_m"].to_numpy(),
            meshes={name: meshes[name].to_numpy() for name in ("row", "section", "opening_deg", "bar_tension_n")}
            | ({"panel": meshes["panel"].fillna("").to_numpy()} if "panel" in meshes.columns else {}),
            layers=list(_layers_of(run, result)),
        )


def _profile_of(run: Run, result: dict[Hashable, Any]) -> tuple[pd.DataFrame, int]:
    """Rows of a solved case, from the entry, and how many real ones each stands for."""
    source = str(Path(run.source) / "profile.csv")
    globalisations = run.plan.globalisations if result["fidelity"] == "globalised" else (1,)
    merged_in = {len(run.plan.sections_of_bands(g)): g for g in globalisations}
    profile = run.profile[run.profile["case"] == result["case"]].sort_values("row")
    last = len(profile) - 1
    if last not in merged_in or not np.array_equal(profile["row"], np.arange(last + 1)):
        allowed = f"rows 0 to {' or '.join(map(str, merged_in))}, each once, as in the plan"
        raise InputError(source, "case", result["case"], allowed, f"has {len(profile)} rows, not those of the plan")
    merged = merged_in[last]
    band, names = np.array(run.plan.sections_of_bands(merged)), np.array(run.plan.section_names, dtype=object)
    long = np.array([merged / section.rows_per_mesh for section in run.plan.netting])[band]
    section, place = profile["section"].to_numpy(), profile["meshes_from_entry"].to_numpy()
    joined = (section == names[np.append(band[:1], band)]) | (section == names[np.append(band, band[-1:])])
    table = InputTable(source, profile)
    table.check("section", joined, "a section of the plan that lies there: its name, or its number where it has none")
    placed = np.diff(place, prepend=0.0) == np.append(0.0, long)
    table.check("meshes_from_entry", placed, "the place of the plan's row")
    return profile, merged


def _meshes_of(run: Run, result: dict[Hashable, Any], profile: pd.DataFrame, merged: int) -> pd.DataFrame:
    """Meshes of a solved case: one a row of a net that is the same all round, of another all."""
    counting = rows_that_count([run.plan.netting[number].kind for number in run.plan.sections_of_bands(merged)])
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


def _layers_of(run: Run, result: dict[Hashable, Any]) -> Iterator[tuple[int, dict[str, NDArray[Any]]]]:
    """Second layers of a solved case."""
    if run.layers is None:
        return
    layers = run.layers[run.layers["case"] == result["case"]]
    for number, layer in enumerate(run.plan.layer):
        own = layers[layers["layer"].astype(str) == (layer.name or str(number + 1))]
        if len(own):
            yield number, {name: own[name].to_numpy() for name in ("row", "opening_deg", "bar_tension_n")}
