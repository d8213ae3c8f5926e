"""The catches of a study in memory, with the meshes that fish meet ahead of them: as from its tables, without these."""

from collections.abc import Sequence

import numpy as np

from catch_models.fish import Species
from codend.io.columns import error_of
from codend.plan.plan import Plan
from codend.selectivity.escape.haul import hauls_of, terms_of_catches
from codend.selectivity.escape.haul_ends import moved_by_opening_error
from codend.selectivity.escape.meshes_met import Catch, SolvedMeshes, catch_of, rows_that_count
from codend.selectivity.escape.predict import rows_needed
from codend.studies import tables
from codend.studies.case_result import CaseResult
from codend.studies.study import Study

OF_FISH = ("l50_cm", "sr_cm")


def fish_columns(species: Sequence[Species], one: Species) -> tuple[str, ...]:
    """Columns of L50 and SR of one of some species: with its name where there are several."""
    return OF_FISH if len(species) == 1 else tuple(f"{name} {one.name}" for name in OF_FISH)


def selectivity_in(study: Study, species: Sequence[Species]) -> dict[int, dict[str, float]]:
    """L50 and SR of fish that meet each solved case, and what errors of the openings change, cm, by its number."""
    found: dict[int, dict[str, float]] = {}
    for haul in hauls_of(catches_in(study, max(map(rows_needed, species)))):
        for one in species:
            columns = fish_columns(species, one)
            names = (*columns, *map(error_of, columns))
            moved = moved_by_opening_error(haul, one)
            for catch, terms, by in zip(haul.catches, terms_of_catches(haul, one), moved, strict=False):
                found.setdefault(catch.case, {}).update(zip(names, (*terms.l50_sr(), *by), strict=True))
    return found


def catches_in(study: Study, most_rows: float) -> list[Catch]:
    """Solved cases, with the meshes up to ``most_rows`` + 1 rows ahead of the front: what ``catches_of`` reads."""
    return [catch_of(study.plan, _meshes_of(study.plan, one), most_rows) for one in study.cases if one.converged]


def _meshes_of(plan: Plan, result: CaseResult) -> SolvedMeshes:
    measures, merged = result.measures, result.bag.globalisation
    rows, meshes = tables.profile_columns(plan, result), tables.mesh_columns(plan, result)
    if meshes is None:
        counting = np.flatnonzero(rows_that_count(result.bag.band_kind))
        meshes = {name: rows[name][counting] for name in ("row", "section", "opening_deg", "bar_tension_n")}
    return SolvedMeshes(
        case=result.case.number,
        speed_m_s=result.case.speed_m_s,
        filled_meshes=measures.filled_meshes,
        volume_m3=measures.catch_volume_m3,
        opening_ahead_deg=measures.opening_ahead_deg,
        opening_error_deg=result.errors.opening_ahead_error_deg,
        smeared=result.smeared,
        merged=merged,
        place=rows["meshes_from_entry"],
        radius_m=rows["radius_m"],
        meshes=meshes,
        layers=list(enumerate(tables.layer_columns(plan, result))),
    )
