"""Stiff twine: energy, rest, and the shell's group EI / (N b^4 p)."""

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.errors import InputError
from codend.mechanics import bending
from codend.mechanics.structure import structure_of
from codend.studies.study import solve
from tests.complex_loads import bending_energy, derivative
from tests.plans import make_plan, uniform_plan

RELAXED = {"fidelity": "sector", "method": "dynamic-relaxation"}
KINDS = [("diamond", 0.0), ("diamond", 6.0), ("t90", 6.0)]


@pytest.mark.parametrize(("mesh", "knot"), KINDS)
@pytest.mark.parametrize("sectors", [1, 2, None])
def test_bending_forces_are_minus_the_gradient_of_the_energy(mesh, knot, sectors):
    plan = make_plan(12, 6, mesh=mesh, netting={"knot_mm": knot, "bending_stiffness_n_m2": 1e-3})
    net = build_bag(plan, sectors=sectors).net
    rng = np.random.default_rng(1)
    positions = net.positions + 0.003 * rng.normal(size=net.positions.shape)
    positions[-1, 1:] = 0.0
    force = np.zeros_like(positions)
    bending.add_force(positions, structure_of(net), force)
    slope = derivative(lambda at: bending_energy(net, at), positions)[0]
    assert -force.ravel() == pytest.approx(slope, rel=1e-9, abs=1e-11 * np.abs(slope).max())


@pytest.mark.parametrize(("mesh", "knot"), KINDS)
def test_every_twine_has_its_bending_energy_once(mesh, knot):
    """A long net whose twines are all turned by the same angle from rest: k / 2 times that angle squared, each."""
    stiffness, turn = 1e-3, 0.1
    plan = make_plan(200, 40, mesh=mesh, netting={"knot_mm": knot, "bending_stiffness_n_m2": stiffness})
    net = build_bag(plan, sectors=1).net
    sign = np.where(net.corner_rest > np.pi / 2, -1.0, 1.0)
    stored = (net.corner_stiffness * (2 * turn * sign) ** 2).sum() / 8
    twines = np.count_nonzero(net.bar_drag_diameter > 0)
    expected = twines * 0.5 * (12 * stiffness / 0.040) * turn**2
    assert stored == pytest.approx(expected, rel=2 / 80)


def test_stiff_twine_holds_the_meshes_nearer_to_their_rest():
    openings = []
    for stiffness in (0.0, 1e-4, 3e-4, 1e-3):
        netting = {"bending_stiffness_n_m2": stiffness, "rest_opening_deg": 20.0}
        result = solve(make_plan(24, 20, netting=netting, model=RELAXED)).cases[0]
        assert result.converged
        assert result.measures.entry_reaction_n == pytest.approx(result.measures.drag_n, rel=2e-6)
        openings.append(result.measures.opening_ahead_deg)
    assert np.all(np.diff(openings) < 0.0)
    assert openings[-1] > 20.0


def test_shape_depends_on_bending_only_through_its_group():
    """EI / (N b^4 p): four times the pressure with four times EI leaves the shape as it is."""
    slow, fast = (
        solve(uniform_plan(24, 20, 6.0, speed=v, netting={"bending_stiffness_n_m2": 2e-3 * v**2}, model=RELAXED)).cases[
            0
        ]
        for v in (1.0, 2.0)
    )
    assert fast.positions == pytest.approx(slow.positions, abs=2e-5)


def test_globalised_stiff_netting_holds_the_same_energy():
    plan = make_plan(24, 20, netting={"bending_stiffness_n_m2": 1e-3})
    real, model = build_bag(plan).net, build_bag(plan, globalisation=4).net
    assert model.corner_stiffness.sum() == pytest.approx(real.corner_stiffness.sum(), rel=4 / 40)


def test_bending_is_refused_where_it_has_no_place():
    square = make_plan(24, 20, mesh="square", netting={"bending_stiffness_n_m2": 1e-3})
    with pytest.raises(InputError, match="square"):
        build_bag(square)
    stiff = make_plan(24, 20, netting={"bending_stiffness_n_m2": 1e-3})
    with pytest.raises(InputError, match="hinge"):
        build_bag(replace_model(stiff, bars_per_side=2))


def replace_model(plan, **changes):
    return plan.model_copy(update={"model": plan.model.model_copy(update=changes)})


def test_no_corner_is_kept_without_stiffness():
    assert len(build_bag(make_plan(24, 20)).net.corners) == 0


def test_newton_and_relaxation_agree_on_stiff_twine():
    netting = {"bending_stiffness_n_m2": 5e-4, "knot_mm": 6.0}
    symmetric = {"fidelity": "sector", "wrinkles": False}
    for mesh in ("diamond", "t90"):
        by_relaxation, by_newton = (
            solve(make_plan(24, 20, mesh=mesh, netting=netting, model=symmetric | {"method": method})).cases[0]
            for method in ("dynamic-relaxation", "newton")
        )
        assert by_newton.converged
        assert by_newton.positions == pytest.approx(by_relaxation.positions, abs=2e-5)
        assert by_newton.report.iterations < 20
