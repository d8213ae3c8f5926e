"""One bag of netting at any number of meshes: its size and catch stay, its meshes become smaller."""

from functools import cache

import numpy as np

from codend.plan.plan import Plan, plan_from_dict
from codend.studies import study
from codend.studies.case_result import CaseResult

SPREAD_M = 4.0
"""N b: circumference with the bars spread fully, m."""
PRESSURE_PA = 1.4 * 0.5 * 1000.0
"""Uniform net pressure in the catch where the bag is bare."""


def bag(
    meshes_round: int,
    *,
    mesh: str = "diamond",
    knot_share: float = 0.0,
    stiffness: float | None = None,
    bare: bool = True,
    filled: float = 0.25,
    long: float = 0.6,
) -> Plan:
    """A plan whose shape does not depend on its number of meshes, but for what their number itself does.

    Args:
        meshes_round: N.
        mesh: "diamond" or "t90".
        knot_share: knot over bar length.
        stiffness: EA of all bars of a row together over N, N; None: inextensible.
        bare: uniform pressure and no twine drag, else the sphere's pressure and drag.
        filled: filled meshes over N.
        long: meshes long over N.
    """
    bar_mm = 1000.0 * SPREAD_M / meshes_round
    section = {
        "mesh": mesh,
        "meshes_round": meshes_round,
        "meshes_long": round(long * meshes_round),
        "bar_mm": bar_mm,
        "knot_mm": knot_share * bar_mm,
        "twine_mm": 0.05 * bar_mm,
    }
    if stiffness is not None:
        section["axial_stiffness_n"] = stiffness / meshes_round
    law = {"pressure": "uniform", "coefficient": 1.4} if bare else {"pressure": "sphere"}
    return plan_from_dict(
        {
            "title": "bag",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1000.0},
            "entry": {"radius_m": 0.35 * SPREAD_M / np.pi},
            "netting": [section],
            "catch": {"filled_meshes": filled * meshes_round, **law},
            "drag": {"normal": 0.0 if bare else 1.36},
            "model": {"fidelity": "sector", "tolerance": 1e-10},
        }
    )


@cache
def solved(meshes_round: int, **options: float | str | bool | None) -> CaseResult:
    """Equilibrium of a sector of the bag."""
    (result,) = study.solve(bag(meshes_round, **options)).cases  # type: ignore[arg-type]
    if not result.converged:
        raise RuntimeError(result.report.outcome.value)
    return result
