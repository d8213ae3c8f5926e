"""Plans that differ in their sizes alone: they share how their nets are numbered, and nothing that is written to."""

import numpy as np
import pytest

from codend.equilibrium import bag_model
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.solve import solve as find
from codend.equilibrium.stability import tangent_of
from codend.net.last_made import LastMade
from codend.netting import frame
from codend.solvers import newton
from codend.solvers.harmonics import harmonics_of, negative_pivots
from tests.plans import make_plan

KINDS = [("diamond", {}), ("diamond", {"knot_mm": 8.0}), ("t90", {"knot_mm": 8.0}), ("square", {})]


def solved(model):
    return find(model, model.plan.cases()[0], (), None)


def nothing_kept(monkeypatch) -> None:
    for module, name in ((frame, "_frames"), (bag_model, "_prepared"), (bag_model, "_rings")):
        monkeypatch.setattr(module, name, LastMade(3000))
    bag_model._bag_of.cache_clear()


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
def test_a_net_after_another_of_its_joints_is_that_net_to_the_last_bit(mesh, netting, monkeypatch):
    wanted = make_plan(30, 20, mesh=mesh, bar_mm=55.0, netting=netting | {"twine_mm": 3.0})
    nothing_kept(monkeypatch)
    alone = model_of(wanted, 1, 1)
    first, harmonics = solved(alone)[1], harmonics_of(*solved(alone), alone.ring)
    nothing_kept(monkeypatch)
    other = model_of(make_plan(24, 20, mesh=mesh, netting=netting), 1, 1)
    harmonics_of(*solved(other), other.ring)
    after = model_of(wanted, 1, 1)
    assert after.prepared.pattern.row is bag_model._prepared.of(*_last(bag_model._prepared)).pattern.row
    second = solved(after)[1]
    np.testing.assert_array_equal(second.positions, first.positions)
    np.testing.assert_array_equal(second.bar_tension, first.bar_tension)
    assert harmonics_of(*solved(after), after.ring) == harmonics
    asked, shift = np.arange(16), np.linspace(0.0, 100.0, 16)
    np.testing.assert_array_equal(negative_pivots(after.ring, asked, shift), negative_pivots(alone.ring, asked, shift))


def _last(made):
    key = next(reversed(made._made))
    return key, 0, lambda: None


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
@pytest.mark.parametrize("catch", [{"filled_meshes": 6.0}, {"volume_m3": 0.01}])
def test_the_tangent_by_way_of_a_sectors_ring_is_that_of_newtons_method(mesh, netting, catch):
    model = model_of(make_plan(30, 20, mesh=mesh, netting=netting, catch=catch), 1, 1)
    problem, solution = solved(model)
    assert solution.report.outcome.converged
    newton.tangent_at(problem, solution, model.prepared)
    step = model.prepared.step
    blocks, right, gradient = step.blocks.copy(), step.right.copy(), step.gradient.copy()
    for values in step[:3]:
        values[:] = np.nan
    tangent = tangent_of(model, problem, solution)
    assert tangent.ring is model.ring
    sides = 1 + tangent.products
    assert sides == (1 if "filled_meshes" in catch else 2)
    for own, expected in ((step.blocks, blocks), (step.right[:sides], right[:sides])):
        np.testing.assert_allclose(own, expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(step.gradient[: sides - 1], gradient[: sides - 1], rtol=1e-9, atol=1e-12)


def test_a_tangent_keeps_its_factors_while_a_like_net_is_solved():
    first, second = (model_of(make_plan(24, 20, bar_mm=bar), 1, 1) for bar in (50.0, 60.0))
    problem, solution = solved(first)
    tangent = newton.tangent_at(problem, solution, first.prepared)
    factors = tangent.prepared.system.arrays.rows.copy()
    solved(second)
    np.testing.assert_array_equal(tangent.prepared.system.arrays.rows, factors)
