"""Errors know of other shapes that are the same all round, and rows say where layers lie on each other."""

import pytest

from codend.plan.plan import Plan, plan_from_dict
from codend.studies import study
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from validation.shaken import QUANTITIES


def bag(sections: list[dict], entry_m: float, speed_m_s: float, catch: dict, **model: object) -> Plan:
    return plan_from_dict(
        {
            "title": "other shapes",
            "tow": {"speed_m_s": speed_m_s, "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": entry_m},
            "netting": sections,
            "catch": catch,
            "model": model,
        }
    )


def turned(**model: object) -> CaseResult:
    """Stiff turned netting whose knots resist compression, and tilt by one pattern or another."""
    netting = {"mesh": "t90", "meshes_round": 15, "meshes_long": 11, "bar_mm": 35.65, "knot_mm": 12.176}
    netting |= {"twine_mm": 1.54, "axial_stiffness_n": 2252.7, "bending_stiffness_n_m2": 8.719e-4}
    plan = bag([netting | {"knot_compression": True}], 0.03412, 1.693, {"filled_meshes": 1.4886}, **model)
    return solve(plan).cases[0]


def joined(**model: object) -> CaseResult:
    """Of 5 and 15 meshes round, which relaxation wrings by 4 degrees."""
    netting = {"mesh": "diamond", "bar_mm": 26.445, "twine_mm": 2.333, "bending_stiffness_n_m2": 3.777e-4}
    counts = ((5, 7), (15, 4))
    sections = [{**netting, "meshes_round": around, "meshes_long": along} for around, along in counts]
    return solve(bag(sections, 0.025197, 1.4223, {"filled_meshes": 0.81863}, **model)).cases[0]


def over_both_errors(one: CaseResult, other: CaseResult) -> float:
    """Largest difference of two answers over what both state."""
    return max(
        abs(getattr(one.measures, name) - getattr(other.measures, name))
        / (getattr(one.errors, error) + getattr(other.errors, error))
        for name, error in QUANTITIES.items()
    )


@pytest.mark.parametrize(("make", "apart"), [(turned, 4e-3), (joined, 9e-4)])
@pytest.mark.parametrize("fidelity", ["sector", "full"])
def test_errors_of_a_relaxed_net_cover_the_symmetric_shape_that_others_lead_to(make, apart, fidelity):
    """Both are stable, by every harmonic and by the whole net's tangent."""
    relaxed, other = make(fidelity=fidelity, method="dynamic-relaxation"), make(fidelity=fidelity)
    assert relaxed.stability.stable == other.stability.stable == "yes"
    assert abs(relaxed.measures.drag_n / other.measures.drag_n - 1.0) > apart
    assert over_both_errors(relaxed, other) <= 1.0


def test_errors_of_stiff_turned_netting_with_knots_that_push_cover_how_else_these_may_tilt():
    result, relaxed = turned(), turned(method="dynamic-relaxation")
    for name, error in QUANTITIES.items():
        off = abs(getattr(result.measures, name) - getattr(relaxed.measures, name))
        assert off <= 1.01 * getattr(result.errors, error)


def test_joined_sectors_that_are_stable_are_asked_whether_layers_lie_on_each_other(monkeypatch):
    """Relaxed, a joint of 6, 10 and 6 meshes round lay on itself so, and stated 2e-6 degrees."""
    assert not joined().followed.folds
    monkeypatch.setattr(study, "layers_touch", lambda problem, positions: True)
    result = joined()
    assert (result.stability.stable, result.followed.folds) == ("yes", True)
    assert result.errors.opening_ahead_error_deg > 1.0


def test_sectors_with_ropes_are_asked_whether_layers_lie_on_each_other_as_their_whole_nets_are():
    """Gathered between two ropes that are 10 % short, netting of one count lies on itself: 5e-7 N was stated."""
    netting = {"mesh": "diamond", "meshes_round": 24, "meshes_long": 17, "bar_mm": 25.0, "knot_mm": 2.5}
    ropes = {"number": 2, "shortening": 0.1, "axial_stiffness_n": 2e4, "diameter_mm": 12}
    made = bag([netting | {"twine_mm": 2.494, "axial_stiffness_n": 1338.6}], 0.04176, 1.0949, {"filled_meshes": 6.494})
    tables = made.to_dict() | {"rope": [ropes]}
    sector, full = (
        solve(plan_from_dict(tables | {"model": {"fidelity": fidelity}})).cases[0] for fidelity in ("sector", "full")
    )
    assert (sector.followed.folds, full.followed.folds) == (True, True)
    assert sector.measures.drag_n == pytest.approx(full.measures.drag_n, rel=1e-6)
    assert sector.errors.drag_error_n == pytest.approx(full.errors.drag_error_n, rel=1e-2)
