"""Windows in merged nets: which merging leaves them where they are."""

import pytest

from codend.bag.build import merged_in_place
from codend.equilibrium import solve as equilibrium
from codend.equilibrium import stability
from codend.equilibrium.bag_model import model_of
from codend.plan.plan import Plan, plan_from_dict
from codend.solvers.mirror import mirror_of
from codend.solvers.whole_tangent import FIRST_EIGENVALUES, MOST_EIGENVALUES, WholeTangent

NETTING = {"mesh": "diamond", "mesh_mm": 100.0, "twine_mm": 3.0, "axial_stiffness_n": 1000.0, "panels": 2}


def windowed(extension: dict, codend: dict, window: dict, **tables: object) -> Plan:
    """A tapering extension and a codend, with a window in one of them."""
    return plan_from_dict(
        {
            "title": "merged window",
            "tow": {"speed_m_s": 1.0},
            "entry": {"hanging_ratio": 0.3},
            "netting": [NETTING | {"name": "extension"} | extension, NETTING | {"name": "codend"} | codend],
            "window": [{"mesh": "square", "mesh_mm": 100.0, "twine_mm": 3.0, "axial_stiffness_n": 1000.0} | window],
            "catch": {"filled_meshes": 4},
            **tables,
        }
    )


OF_FOUR = {"meshes_round": 32, "meshes_round_aft": 24, "meshes_long": 12}, {"meshes_round": 24, "meshes_long": 12}
IN_CODEND = {"netting": "codend", "meshes_from_codline": [4, 8]}
PLANS = {
    # merged by 2 the panel is 6 meshes wide and the window's place 4, the window's own count 2
    "in place": (*OF_FOUR, IN_CODEND | {"meshes_across": 8, "meshes_round": 4, "meshes_long": 4}, [1, 2]),
    # 3 merged meshes of a window in the place of 4
    "sewn aside": (*OF_FOUR, IN_CODEND | {"meshes_across": 8, "meshes_round": 6, "meshes_long": 4}, [1]),
    # 3 merged meshes are lost along each seam, so that those of the codend lie half a mesh beside it
    "beside the middle": (
        {"meshes_round": 36, "meshes_round_aft": 24, "meshes_long": 12},
        {"meshes_round": 24, "meshes_long": 12},
        IN_CODEND | {"meshes_across": 8, "meshes_round": 4, "meshes_long": 4},
        [1],
    ),
    "in what tapers": (
        *OF_FOUR,
        {"netting": "extension", "meshes_from_codline": [16, 20], "meshes_across": 4, "meshes_round": 4}
        | {"meshes_long": 4},
        [1, 2],
    ),
}


@pytest.mark.parametrize(("extension", "codend", "window", "merged"), PLANS.values(), ids=PLANS.keys())
def test_merging_leaves_windows_in_the_middle_where_a_plane_mirrors_the_net(extension, codend, window, merged):
    plan = windowed(extension, codend, window)
    assert set(plan.globalisations) >= {1, 2}
    assert [g for g in merged_in_place(plan) if g <= 2] == merged
    models = {g: model_of(plan, g, None) for g in (1, 2)}
    case = plan.cases()[0]
    mirrors = {g: mirror_of(model.problem(case), model.mirror_planes_rad) for g, model in models.items()}
    assert [g for g, mirror in mirrors.items() if mirror is not None] == merged


def test_no_steps_are_spent_where_they_lead_nowhere_beside_a_window():
    """Newton's method led from a sector, or from a single other catch, to no narrow net with a window."""
    plan = windowed(*PLANS["in place"][:3], catch={"filled_meshes": [4, 4.5, 5]})
    model, known = model_of(plan, 2, None), []
    assert model.narrow
    starts = []
    for case in plan.cases():
        _, solution = equilibrium.solve(model, case, known, None)
        assert solution.report.outcome.converged
        known.append((case, solution))
        starts.append(solution.report.attempts[0])
    assert starts[0].startswith("from the equilibrium of a sector, through the interior: interior point")
    assert starts[1].startswith("from where the last equilibria lead: interior point")
    assert starts[2].startswith("from where the last equilibria lead: newton")


@pytest.mark.parametrize(("closely", "most"), [(10**6, MOST_EIGENVALUES), (0, FIRST_EIGENVALUES)])
def test_a_large_net_with_a_window_is_asked_for_its_first_eigenvalues_alone(closely, most, monkeypatch):
    plan = windowed(*PLANS["in place"][:3])
    model, case = model_of(plan, 2, None), plan.cases()[0]
    problem, solution = equilibrium.solve(model, case, (), None)
    asked = []
    monkeypatch.setattr(stability, "ASKED_CLOSELY", closely)
    monkeypatch.setattr(WholeTangent, "growing", lambda self, scale, most, thorough: asked.append(most))
    assert stability.stability_of(model, stability.tangent_of(model, problem, solution), True).stable == "unknown"
    assert asked == [most]
