"""Knots do not stretch unless the plan gives their stiffness, and then as the twine does."""

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.errors import InputError
from codend.plan.plan import load_plan
from codend.studies.study import solve
from tests import ROOT
from tests.plans import make_plan
from validation.axisymmetric_bars import PUBLIC, QUANTITIES, AxisymmetricBars, rings_of

PLAN = ROOT / "tests" / "knots_that_stretch.toml"
SOFT = {"knot_mm": 8.0, "axial_stiffness_n": 300.0, "knot_axial_stiffness_n": 150.0}


@pytest.mark.parametrize(("fidelity", "of_volume"), [("meridian", 1e-3), ("sector", 1.5e-3)])
def test_the_public_programs_example_is_met(fidelity, of_volume):
    """A sector's rings are polygons of 100 sides, which hold less than the circles by 0.07 % and more between them."""
    table = solve(load_plan(PLAN, [f'model.fidelity="{fidelity}"'])).table
    for quantity, answer in PUBLIC.items():
        within = of_volume if quantity == "catch_volume_m3" else 1e-3
        assert table[quantity].to_numpy() == pytest.approx(answer, rel=within)


@pytest.mark.parametrize("number", [0, 1])
def test_circles_and_the_first_row_of_knots_are_all_that_a_sector_and_the_public_program_differ_in(number):
    plan = load_plan(PLAN, [f"catch.filled_meshes={(50, 75)[number]}"])
    sector = solve(plan).cases[0]

    def of_bars(knots_first: bool, polygons: bool) -> np.ndarray:
        bars = AxisymmetricBars(plan, knots_first, polygons)
        return np.array(bars.solved(rings_of(sector.positions, plan, knots_first), sector.case.catch_value))

    assert of_bars(True, False) == pytest.approx([answer[number] for answer in PUBLIC.values()], rel=1e-5)
    drag, volume, length, radius = (
        np.array([getattr(sector.measures, name) for name in QUANTITIES]) / of_bars(False, True) - 1.0
    )
    assert max(abs(drag), abs(length), abs(radius)) <= 6e-5
    assert 0.0 < volume < 3e-4, "between two polygons turned by half a mesh netting bulges"


@pytest.mark.parametrize("fidelity", ["sector", "full", "meridian"])
@pytest.mark.parametrize("mesh", ["diamond", "t90"])
def test_ever_stiffer_knots_are_knots_that_do_not_stretch(mesh, fidelity):
    def measured(**stiffness: float) -> np.ndarray:
        netting = {"knot_mm": 8.0, "axial_stiffness_n": 300.0, **stiffness}
        plan = make_plan(16, 14, mesh=mesh, netting=netting, model={"fidelity": fidelity, "tolerance": 1e-10})
        result = solve(plan).cases[0]
        assert result.converged
        return np.array([result.measures.drag_n, result.measures.catch_volume_m3, result.measures.length_m])

    rigid = measured()
    off = [np.abs(measured(knot_axial_stiffness_n=ea) / rigid - 1.0).max() for ea in (1e5, 1e7, 1e9)]
    assert off[0] > 30.0 * off[1] > 0.0
    assert off[2] <= 1e-7


@pytest.mark.parametrize("mesh", ["diamond", "t90"])
def test_membrane_and_net_agree_on_knots_that_stretch(mesh):
    def drag_and_radius(fidelity: str, meshes_round: int) -> np.ndarray:
        # the same bag of ever finer netting
        share = 24 / meshes_round
        netting = {name: value * share for name, value in SOFT.items()} | {"twine_mm": share}
        plan = make_plan(
            meshes_round,
            20 * meshes_round // 24,
            mesh=mesh,
            bar_mm=40.0 * share,
            netting=netting,
            filled=6.0 / share,
            model={"fidelity": fidelity},
        )
        measures = solve(plan).cases[0].measures
        return np.array([measures.drag_n, measures.max_radius_m, measures.length_m])

    off = [np.abs(drag_and_radius("sector", n) / drag_and_radius("meridian", n) - 1.0).max() for n in (48, 96)]
    assert off[1] < 0.35 * off[0] < 0.01


def test_merged_knots_stretch_as_those_they_stand_for():
    plan = make_plan(24, 20, netting=SOFT)
    real, merged = (build_bag(plan, globalisation=g) for g in (1, 2))
    softness = [bag.net.bar_flexibility[~bag.bar_is_twine] for bag in (real, merged)]
    assert softness[0] == pytest.approx(1.0 / 150.0)
    assert softness[1] == pytest.approx(0.5 / 150.0)


def test_a_stiffness_of_knots_that_are_not_there_is_refused():
    with pytest.raises(InputError, match=r"knot_axial_stiffness_n = 100\.0"):
        make_plan(16, 14, netting={"knot_axial_stiffness_n": 100.0})


def test_rigid_bars_take_no_knots_that_stretch():
    netting = {"knot_mm": 8.0, "knot_axial_stiffness_n": 100.0}
    with pytest.raises(InputError, match="knot_axial_stiffness_n"):
        solve(make_plan(16, 14, netting=netting, model={"method": "rigid-bars"}))
