"""Knots resist being shortened where the plan says so, and twine never does."""

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.errors import InputError
from codend.plan.plan import Plan
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from tests.plans import make_plan


def t90_plan(meshes_round: int = 24, mesh: str = "t90", fidelity: str = "sector", **netting: object) -> Plan:
    """The same bag of coarser or finer netting; near the codline T90 netting is narrower than its knots."""
    share = 24 / meshes_round
    section = {"knot_mm": 10.0 * share, "twine_mm": share, "knot_compression": True, **netting}
    model = {"fidelity": fidelity, "tolerance": 1e-9, "wrinkles": False}
    return make_plan(
        meshes_round, 20 * meshes_round // 24, mesh=mesh, bar_mm=40.0 * share, netting=section, filled=6.0 / share,
        model=model,
    )  # fmt: skip


def solved(plan: Plan) -> CaseResult:
    result = solve(plan).cases[0]
    assert result.converged, result.report.attempts
    assert np.all(result.bar_tension_n[~result.net.bar_is_strut] >= 0.0)
    return result


def drag_and_opening(plan: Plan) -> np.ndarray:
    measures = solved(plan).measures
    return np.array([measures.drag_n, measures.opening_ahead_deg])


def test_knots_near_the_codline_push_and_keep_their_length():
    push, give = solved(t90_plan()), solved(t90_plan(knot_compression=False))
    apart = []
    for result in (push, give):
        net, knots = result.net, ~result.bag.bar_is_twine
        ends = result.positions[net.bars[knots]]
        apart.append(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / net.bar_length[knots])
    assert np.abs(apart[0] - 1.0).max() < 1e-6
    assert apart[1].min() < 0.8
    assert push.bar_tension_n.min() < -0.2
    assert push.measures.drag_n == pytest.approx(give.measures.drag_n, rel=5e-4)


def test_the_full_net_is_its_sector():
    sector, full = (solved(t90_plan(fidelity=fidelity)) for fidelity in ("sector", "full"))
    assert full.bar_tension_n.min() == pytest.approx(sector.bar_tension_n.min(), rel=1e-6)
    assert full.measures.drag_n == pytest.approx(sector.measures.drag_n, rel=1e-8)
    assert full.measures.opening_ahead_deg == pytest.approx(sector.measures.opening_ahead_deg, rel=1e-7)


def test_ever_stiffer_knots_are_knots_that_keep_their_length():
    soft = {"axial_stiffness_n": 300.0}
    rigid = drag_and_opening(t90_plan(**soft))
    off = [np.abs(drag_and_opening(t90_plan(knot_axial_stiffness_n=ea, **soft)) / rigid - 1.0).max()
           for ea in (1e5, 1e7, 1e9)]  # fmt: skip
    assert off[0] > 30.0 * off[1] > 0.0
    assert off[2] <= 1e-7


def test_knots_along_diamond_netting_are_pulled_whether_they_push_or_not():
    push, give = (drag_and_opening(t90_plan(mesh="diamond", knot_compression=p)) for p in (True, False))
    assert push == pytest.approx(give, rel=1e-8)


def test_the_membranes_error_covers_knots_that_push():
    """It knows knots that give way alone, and is held to the sector."""
    sector, membrane = (solved(t90_plan(fidelity=fidelity)) for fidelity in ("sector", "meridian"))
    off = np.abs(np.subtract(sector.measures.estimated, membrane.measures.estimated))
    errors = membrane.errors
    assert np.all(
        off <= [errors.drag_error_n, errors.catch_volume_error_m3, errors.max_radius_error_m,
                errors.opening_ahead_error_deg]
    )  # fmt: skip


def test_merged_knots_push_and_no_twine_does():
    bags = [build_bag(t90_plan(), globalisation=g) for g in (1, 2)]
    for bag in bags:
        assert np.array_equal(bag.net.bar_is_strut, ~bag.bar_is_twine)
    assert not build_bag(t90_plan(knot_compression=False)).net.bar_is_strut.any()


def test_knots_that_are_not_there_cannot_push():
    with pytest.raises(InputError, match=r"knot_compression = true.*knot_mm above 0"):
        make_plan(16, 14, netting={"knot_compression": True})
