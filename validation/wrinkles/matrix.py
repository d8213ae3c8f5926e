"""Commercial codends, symmetric, followed and whole, beside each other."""

import numpy as np
import pandas as pd

from codend.plan.plan import Plan, plan_from_dict
from codend.solvers.gentle import End
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from validation.shaken import shaken

MESHES = ("diamond", "t90")
MESHES_ROUND = (100, 50)
BENDING_N_M2 = (0.0, 5e-4, 2e-3)
CATCH_KG = (50.0, 300.0, 1500.0)
MERGED = 2
"""Meshes merged each way in the whole net that is shaken: that of 100 meshes round has 10 000 knots."""


def commercial(mesh: str, meshes_round: int, bending_n_m2: float, catch_kg: float, **model: object) -> Plan:
    """A codend of full mesh 120 mm with knots of 15 mm, of double 4 mm twine, towed at 1.5 m/s (numbers ASSUMED)."""
    netting = {
        "mesh": mesh, "meshes_round": meshes_round, "meshes_long": 50, "bar_mm": 45.0, "knot_mm": 15.0,
        "twine_mm": 4.0, "twines": 2, "axial_stiffness_n": 2000.0, "bending_stiffness_n_m2": bending_n_m2,
    }  # fmt: skip
    return plan_from_dict(
        {
            "title": f"{mesh}, {meshes_round} round, EI {bending_n_m2:g} N m2, {catch_kg:g} kg",
            "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": 0.4},
            "netting": [netting],
            "catch": {"mass_kg": catch_kg},
            "model": {"fidelity": "sector", **model},
        }
    )


def rows_of(meshes_round: int, catches_kg: tuple[float, ...]) -> list[dict[str, object]]:
    """A row a codend of so many meshes round."""
    return [
        row_of(mesh, meshes_round, bending, catch)
        for mesh in MESHES
        for bending in BENDING_N_M2
        for catch in catches_kg
    ]


def row_of(mesh: str, meshes_round: int, bending: float, catch: float) -> dict[str, object]:
    """One codend: its symmetric shape, what following it led to, and its whole net shaken by 1 % of a bar."""
    symmetric = solve(commercial(mesh, meshes_round, bending, catch, wrinkles=False)).cases[0]
    row: dict[str, object] = {
        "mesh": mesh,
        "meshes_round": meshes_round,
        "bending_n_m2": bending,
        "catch_kg": catch,
        "stable": symmetric.stability.stable if symmetric.stability else "unknown",
        "drag_n": symmetric.measures.drag_n,
        "drag_error_n": symmetric.errors.drag_error_n,
        "opening_deg": symmetric.measures.opening_ahead_deg,
        "opening_error_deg": symmetric.errors.opening_ahead_error_deg,
    }
    followed = solve(commercial(mesh, meshes_round, bending, catch, wrinkles=True)).cases[0]
    shape = followed.followed.shape
    return row | {
        "followed_meshes": 1 if shape is None else shape.meshes,
        "followed_stable": followed.stability.stable if followed.stability else "unknown",
        "followed_drag_n": followed.measures.drag_n,
        "followed_opening_deg": followed.measures.opening_ahead_deg,
        "drag_spread_n": followed.followed.drag_spread_n,
        "opening_spread_deg": followed.followed.opening_spread_deg,
        "folds": "yes" if followed.followed.folds else "no",
        **_whole(commercial(mesh, meshes_round, bending, catch), symmetric),
    }


def _whole(plan: Plan, symmetric: CaseResult) -> dict[str, object]:
    """What becomes of the whole net, merged, when shaken: how it ends, and its changes from its own symmetric shape."""
    tables = plan.to_dict()
    tables["model"] |= {"fidelity": "globalised", "globalisation": MERGED, "wrinkles": False}
    merged = plan_from_dict(tables)
    if symmetric.stability is not None and symmetric.stability.stable == "yes":
        return {"whole_ends": "stable", "whole_drag_change": 0.0, "whole_opening_change_deg": 0.0}
    sector = _merged_sector(merged)
    if sector is None:
        return {"whole_ends": "not solved", "whole_drag_change": np.nan, "whole_opening_change_deg": np.nan}
    end, measures = shaken(sector, merged, 0)
    return {
        "whole_ends": end.name.lower(),
        "whole_drag_change": measures.drag_n / sector.measures.drag_n - 1.0 if end is End.SETTLED else np.nan,
        "whole_opening_change_deg": (
            measures.opening_ahead_deg - sector.measures.opening_ahead_deg if end is End.SETTLED else np.nan
        ),
    }


def _merged_sector(merged: Plan) -> CaseResult | None:
    """The equilibrium of a sector of the merged net."""
    from codend.equilibrium import solve as equilibrium
    from codend.equilibrium.bag_model import model_of
    from codend.studies.study import measured

    sector = model_of(merged, MERGED, 1)
    case = merged.cases()[0]
    problem, solution = equilibrium.solve(sector, case, (), None)
    return measured(sector.bag, case, problem, solution) if solution.report.outcome.converged else None


def matrix(quick: bool) -> pd.DataFrame:
    """The table, a row a codend."""
    if quick:
        return pd.DataFrame(rows_of(50, (300.0,)))
    return pd.DataFrame([row for around in MESHES_ROUND for row in rows_of(around, CATCH_KG)])
