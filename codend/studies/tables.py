"""Results as tables: ``results.csv``, ``profile.csv``, ``meshes.csv`` and ``opening_force.csv``."""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import accumulate
from math import isfinite
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from codend.bag.bag import Bag, mesh_corners
from codend.bag.layer_measures import measure_layers, of_the_catch
from codend.equilibrium.followed import meshes_wide
from codend.equilibrium.stability import ranges_text
from codend.io.columns import (
    ALL_PANELS,
    LAYER_COLUMNS,
    MESH_COLUMNS,
    OF_LAYERS,
    OF_MESHES,
    OF_ROPES,
    OPENING_FORCE_COLUMNS,
    PANEL,
    PROFILE_COLUMNS,
    RESULT_COLUMNS,
    ROPE_COLUMNS,
    SIZES,
    STRAP_COLUMNS,
)
from codend.net.net import rotate
from codend.plan.plan import Plan
from codend.plan.tables import TUBE
from codend.studies.case_result import CaseResult
from codend.studies.opening_force import Pull


def opening_force_table(pulls: Sequence[Pull]) -> pd.DataFrame:
    """``opening_force.csv``: a row a mesh that was pulled open, or was to be."""
    rows = [asdict(pull) | {"case": pull.case.number, "speed_m_s": pull.case.speed_m_s} for pull in pulls]
    return pd.DataFrame(rows, columns=OPENING_FORCE_COLUMNS)


def results_table(plan: Plan, fidelity: str, cases: Sequence[CaseResult]) -> pd.DataFrame:
    """A row a case; nan where a case was not solved, but for what the case asked for."""
    return pd.DataFrame([result_row(plan, fidelity, result) for result in cases], columns=result_columns(plan))


def result_columns(plan: Plan) -> list[str]:
    """Columns of ``results.csv`` of a plan."""
    ropes = (STRAP_COLUMNS if plan.strap else []) + (ROPE_COLUMNS if plan.ropes else [])
    return RESULT_COLUMNS + ropes + (LAYER_COLUMNS if plan.layer else [])


def result_row(plan: Plan, fidelity: str, result: CaseResult) -> dict[str, object]:
    """A row of ``results.csv``, by column."""
    measures = dict(vars(result.measures))
    density = plan.catch_density_kg_m3
    measures["catch_mass_kg"] = density * measures["catch_volume_m3"]
    if not result.converged:
        asked = {"volume_m3": "catch_volume_m3", "mass_kg": "catch_mass_kg"}
        measures[asked.get(result.case.catch_kind, result.case.catch_kind)] = result.case.catch_value
    return {
        "case": result.case.number,
        "speed_m_s": result.case.speed_m_s,
        **measures,
        **vars(result.errors),
        "fidelity": _fidelity_of(result.bag) if result.of_another_model(fidelity) else fidelity,
        "method": result.report.method,
        "iterations": result.report.iterations,
        "residual": result.report.residual,
        "converged": result.converged,
        "solve_ms": result.report.solve_ms,
        "stable": "unknown" if result.stability is None else result.stability.stable,
        "growing_harmonics": (result.stability and ranges_text(result.stability.growing)) or float("nan"),
        "sector_order": result.net.order,
        "sector_meshes": meshes_wide(result.bag, max(max(section.open_meshes) for section in plan.netting)),
        "drag_spread_n": result.followed.drag_spread_n,
        "opening_spread_deg": result.followed.opening_spread_deg,
        "folds": "yes" if result.followed.folds else "no",
        "contact_share": result.followed.contact_share,
        "fold_count": result.followed.fold_count,
        "shapes_found": result.followed.shapes_found,
        "wrinkles": result.followed.reason or float("nan"),
        **_sizes_ahead(plan, float(measures["filled_meshes"])),
        **_of_layers(result),
    }


def _of_layers(result: CaseResult) -> dict[str, float]:
    """Columns of second layers, none where there are none."""
    if not result.bag.layer_bands:
        return {}
    held = of_the_catch(result.bag, result.problem, result.solution) if result.converged else [float("nan")] * 3
    return dict(zip(LAYER_COLUMNS, [*held, result.slid[0], result.slid[3]], strict=True))


def layer_table(plan: Plan, cases: Sequence[CaseResult]) -> pd.DataFrame:
    """``layers.csv``: a row a band of netting under a second layer of a solved case."""
    parts = [
        pd.DataFrame({"case": result.case.number, **columns})
        for result in cases
        if result.rows is not None
        for columns in layer_columns(plan, result)
    ]
    return pd.concat(parts, ignore_index=True)[OF_LAYERS] if parts else pd.DataFrame(columns=OF_LAYERS)


def layer_columns(plan: Plan, result: CaseResult) -> Iterator[dict[str, Any]]:
    """Columns of ``layers.csv`` of a solved case, of each layer in turn."""
    bag, under = result.bag, result.rows
    assert under is not None
    for number, rows in enumerate(measure_layers(bag, result.problem, result.solution), start=1):
        band = rows.band.astype(int)
        place = bag.row_place[band] + 0.5 * bag.band_meshes[band]
        known = np.flatnonzero(np.isfinite(under.opening_deg))
        yield {
            "layer": plan.layer[number - 1].name or str(number),
            "row": band,
            "meshes_from_entry": place,
            "opening_below_deg": np.interp(place, bag.mesh_place[known], under.opening_deg[known]),
            **{name: value for name, value in asdict(rows).items() if name != "band"},
        }


def _fidelity_of(bag: Bag) -> str:
    if bag.smeared:
        return "smeared"
    return "globalised" if bag.globalisation > 1 else "full" if bag.net.order == 1 else "sector"


def _sizes_ahead(plan: Plan, filled_meshes: float) -> dict[str, float]:
    """Size of the meshes just ahead of the front, or of the foremost ones; nan where the front is not known."""
    if not isfinite(filled_meshes):
        return dict.fromkeys(SIZES, float("nan"))
    ends = list(accumulate(part.meshes_long for part in plan.netting))
    section = plan.netting[bisect_left(ends, max(ends[-1] - filled_meshes, 0.5))]
    return dict(zip(SIZES, (1000.0 * section.inside_mesh_m, 1000.0 * section.full_mesh_m), strict=True))


def _sizes(plan: Plan, names: NDArray[np.object_]) -> dict[str, NDArray[np.float64]]:
    """Size of the meshes of sections and windows, by their names."""
    number = {name: i for i, name in enumerate(plan.section_names + plan.window_names)}
    found = 1000.0 * np.array([(part.inside_mesh_m, part.full_mesh_m) for part in (*plan.netting, *plan.window)])
    return dict(zip(SIZES, found[[number[name] for name in names]].T, strict=True))


def rope_table(plan: Plan, cases: Sequence[CaseResult]) -> pd.DataFrame:
    """``ropes.csv``: a row a rope of a solved case; those of other sectors are as these."""
    rows: list[dict[str, object]] = []
    for result in cases:
        bag, tension = result.bag, result.bar_tension_n
        ahead = result.solution.share[bag.bar_band[bag.ropes]] == 0.0
        for name in np.unique(bag.rope_name) if result.converged else ():
            own = bag.rope_name == name
            bars = bag.ropes[own]
            y, z = result.net.positions[result.net.bars[bars[0], 0], 1:]
            pulls = tension[bars][ahead[own]]
            rows.append(
                {
                    "case": result.case.number,
                    "rope": int(name) // 1000 + 1,
                    "number": int(name) % 1000 + 1,
                    "kind": plan.ropes[int(name) // 1000].kind,
                    "place_deg": float(np.degrees(np.arctan2(z, y)) % 360.0),
                    "length_m": float(result.net.bar_length[bars].sum()),
                    "max_tension_n": float(tension[bars].max()),
                    "tension_ahead_n": float(pulls[-1]) if len(pulls) else float("nan"),
                    "slack_share": float(np.mean(tension[bars] <= 0.0)),
                }
            )
    return pd.DataFrame(rows, columns=OF_ROPES)


def profile_table(plan: Plan, cases: Sequence[CaseResult]) -> pd.DataFrame:
    """A row a knot row of a solved case, row 0 at the entry."""
    parts = []
    for result in cases:
        if result.rows is not None:
            columns = profile_columns(plan, result)
            sizes = _sizes(plan, columns["section"])
            parts.append(pd.DataFrame({"case": result.case.number, **columns, **sizes}))
    return pd.concat(parts, ignore_index=True)[PROFILE_COLUMNS] if parts else pd.DataFrame(columns=PROFILE_COLUMNS)


def profile_columns(plan: Plan, result: CaseResult) -> dict[str, Any]:
    """Columns of ``profile.csv`` of a solved case, without the sizes of its meshes."""
    assert result.rows is not None
    return {
        "row": np.arange(len(result.rows.x_m)),
        "section": sections_of_rows(plan, result.bag.globalisation),
        "meshes_from_entry": result.bag.row_place,
        **vars(result.rows),
    }


def mesh_table(plan: Plan, cases: Sequence[CaseResult]) -> pd.DataFrame:
    """A row a mesh of a solved case, with its middle's position; none of a model that is one mesh wide.

    Of one panel that stands for all the meshes of all are listed, each in its place.
    """
    parts = []
    for result in cases:
        columns = mesh_columns(plan, result)
        if columns is None:
            continue
        bag, copies = result.bag, _panels_alike(plan, result.bag)
        assert result.meshes is not None
        sector = np.repeat(np.arange(copies), len(bag.mesh_row))
        centre = rotate(np.tile(result.meshes.centre_m, (copies, 1)), sector, bag.net.order)
        centre = centre[np.argsort(np.tile(bag.mesh_row, copies), kind="stable")]
        table = pd.DataFrame(
            {
                "case": result.case.number,
                **columns,
                "meshes_from_entry": bag.mesh_place[columns["row"]],
                **dict(zip(("x_m", "y_m", "z_m"), centre.T, strict=True)),
                **_sizes(plan, columns["section"]),
            }
        )
        table["mesh"] = table.groupby("row").cumcount()
        parts.append(table)
    return pd.concat(parts, ignore_index=True)[MESH_COLUMNS] if parts else pd.DataFrame(columns=MESH_COLUMNS)


def mesh_columns(plan: Plan, result: CaseResult) -> dict[str, Any] | None:
    """Columns of ``meshes.csv`` of a solved case by row, without places and sizes; None of one mesh wide."""
    bag = result.bag
    if result.meshes is None or np.bincount(bag.mesh_row).max() == 1:
        return None
    copies = _panels_alike(plan, bag)
    section = sections_of_rows(plan, bag.globalisation)[bag.mesh_row]
    if bag.windows:
        names = np.array(plan.window_names, dtype=object)
        section = np.where(bag.mesh_of_section, section, names[np.maximum(bag.mesh_window, 0)])
    values = {"row": bag.mesh_row, "section": section}
    values |= {name: value for name, value in vars(result.meshes).items() if name in OF_MESHES}
    columns = {name: np.tile(value, copies) for name, value in values.items()}
    columns[PANEL] = panels_of_meshes(plan, bag, copies)
    order = np.argsort(columns["row"], kind="stable")
    return {name: column[order] for name, column in columns.items()}


def _panels_alike(plan: Plan, bag: Bag) -> int:
    """How many times the modelled sector, of one or more whole panels, is set side by side to show all of them."""
    order = bag.net.sectors
    return order if plan.panels % order == 0 else 1


def panels_of_meshes(plan: Plan, bag: Bag, copies: int) -> NDArray[np.object_]:
    """Panel that each mesh is of, of so many sectors set side by side, (copies * k,).

    Where less than a panel is modelled all are alike, and it is of any.
    """
    number = np.array(plan.sections_of_bands(bag.globalisation))[np.minimum(bag.mesh_row, bag.bands - 1)]
    panels = np.array([part.panels for part in plan.netting])[number]
    middle = mesh_corners(bag, bag.net.positions).mean(axis=(1, 2))
    azimuth = np.degrees(np.arctan2(middle[:, 2], middle[:, 1])) - plan.seam_deg
    sector = np.repeat(np.arange(copies), len(middle)) * 360.0 / bag.net.order
    panels, azimuth = np.tile(panels, copies), np.tile(azimuth, copies) + sector
    place = np.floor(azimuth % 360.0 / 360.0 * panels + 1e-9).astype(int) % panels
    names = [part.panel_names for part in plan.netting]
    found = [names[part][at] for part, at in zip(np.tile(number, copies), place, strict=True)]
    one = plan.panels % bag.net.sectors != 0
    return np.array([ALL_PANELS if one and name != TUBE else name for name in found], dtype=object)


def sections_of_rows(plan: Plan, globalisation: float) -> NDArray[np.object_]:
    """What the section is called whose meshes a row counts, (rows + 1,).

    At a joint that is the one with fewer meshes round, the one ahead where they have the same; but a square mesh lies
    wholly behind the row that counts it.
    """
    band = np.array(plan.sections_of_bands(globalisation))
    ahead, behind = np.append(band[:1], band), np.append(band, band[-1:])
    staggered = np.array([section.kind.staggered for section in plan.netting])
    ends = np.array([section.open_meshes for section in plan.netting])
    counting = np.where(~staggered[behind] | (ends[behind, 0] < ends[ahead, 1]), behind, ahead)
    return np.array(plan.section_names, dtype=object)[counting]
