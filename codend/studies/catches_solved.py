"""The catches of a study in memory, with the meshes that fish meet ahead of them: as from its tables, without these."""

import numpy as np

from codend.plan.plan import Plan
from codend.selectivity.escape.meshes_met import Catch, SolvedMeshes, catch_of, rows_that_count
from codend.studies import tables
from codend.studies.case_result import CaseResult
from codend.studies.study import Study


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
