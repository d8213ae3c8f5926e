"""Nets that are their own mirror image, of which one half is factorised."""

from dataclasses import replace

import numpy as np
import pytest

from codend.bag.loads import problem_of
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import BagModel, model_of
from codend.mechanics.newton_state import measure
from codend.mechanics.newton_step import linearise
from codend.mechanics.structure import structure_of
from codend.plan.plan import plan_from_dict
from codend.solvers.mirror import Mirror, mirror_of
from codend.solvers.prepared import prepare

ROPES = {"number": 2, "shortening": 0.1, "axial_stiffness_n": 5e3}
WINDOW = {
    "mesh": "square", "meshes_round": 4, "meshes_long": 8, "bar_mm": 20.0, "twine_mm": 1.0, "netting": "1",
    "meshes_from_codline": [4, 8], "meshes_across": 4,
}  # fmt: skip
SIDE = WINDOW | {"panel": "starboard"}
HEAVY = {"twine_density_kg_m3": 1380.0}


def model(netting: dict, sectors: int | None, **tables: object) -> BagModel:
    """A net of 24 x 14 meshes of twine that stretches."""
    netting = {"mesh": "diamond", "meshes_round": 24, "meshes_long": 14, "axial_stiffness_n": 1e3} | netting
    plan = {
        "title": "mirrored",
        "tow": {"speed_m_s": 1.0},
        "entry": {"hanging_ratio": 0.35},
        "netting": [{"bar_mm": 20.0, "twine_mm": 1.0} | netting],
        "catch": {"filled_meshes": 6, "pressure": "uniform"},
    }
    return model_of(plan_from_dict(plan | tables), 1, sectors)


MIRRORED = {
    "two ropes, a sector": ({"panels": 2}, 1, {"rope": [ROPES]}),
    "four ropes, a sector": ({"panels": 4}, 1, {"rope": [ROPES | {"number": 4}]}),
    "selvedges and knots": ({"panels": 2, "selvedge_meshes": 1, "knot_mm": 2.0}, 1, {}),
    "stiff twine": ({"panels": 2, "bending_stiffness_n_m2": 1e-4}, 1, {"rope": [ROPES]}),
    "a window on top, with weight": (HEAVY, None, {"window": [WINDOW]}),
    "a window in one side": ({}, None, {"window": [SIDE]}),
}


def mirror(made: BagModel) -> Mirror | None:
    """The mirror of a model in the planes it asks."""
    return mirror_of(problem_of(made.bag, made.plan, made.plan.cases()[0]), made.mirror_planes_rad)


@pytest.mark.parametrize("name", MIRRORED)
def test_a_half_takes_the_steps_of_the_whole(name):
    netting, sectors, tables = MIRRORED[name]
    made = model(netting, sectors, **tables)
    problem = problem_of(made.bag, made.plan, made.plan.cases()[0])
    found = mirror(made)
    structure, whole = problem.structure, made.prepared
    state = whole.states[0]
    state.position[:] = found.mirrored(problem.net.positions)
    state.density[:] = 10.0 / structure.length
    measure(structure, problem.loading, 1.0, 1.0, 1e-2, state)
    linearise(structure, problem.loading, whole.pattern, 1.0, 1e-2, state, whole.step)
    half = prepare(structure_of(made.bag.net), made.bag.bands, mirror=found).system
    assert whole.system.factorise(whole.step.blocks) >= 0
    assert half.factorise(whole.step.blocks) >= 0
    steps = [system.solve(whole.step.right[:1]) for system in (whole.system, half)]
    # inextensible knots cost digits of either
    np.testing.assert_allclose(steps[1], steps[0], atol=1e-6 * np.abs(steps[0]).max())


@pytest.mark.parametrize(
    ("netting", "tables"),
    [
        (HEAVY, {"window": [SIDE]}),  # weight tells up from down
        ({}, {"window": [WINDOW, SIDE]}),
        ({"mesh": "t90", "knot_mm": 2.0}, {"window": [WINDOW | {"meshes_from_codline": [4, 7]}, SIDE]}),
    ],
)
def test_a_net_without_a_mirror_has_none(netting, tables):
    assert mirror(model(netting, None, **tables)) is None


def test_a_half_finds_the_equilibrium_of_the_whole(monkeypatch):
    made = model({"panels": 2, "meshes_round": 48}, None, rope=[ROPES])
    assert made.half is not None
    case = made.plan.cases()[0]
    _, by_half = equilibrium.solve(made, case, (), None)
    monkeypatch.setattr(BagModel, "half", None)
    _, whole = equilibrium.solve(made, case, (), None)
    assert by_half.report.outcome.converged
    assert "of one half" in by_half.report.attempts[-1]
    np.testing.assert_allclose(by_half.positions, whole.positions, atol=1e-8)


def test_a_start_that_is_not_mirrored_is_followed_by_the_whole_net():
    made = model({"panels": 2, "meshes_round": 48}, None, rope=[ROPES])
    case = made.plan.cases()[0]
    _, found = equilibrium.solve(made, case, (), None)
    positions = found.positions.copy()
    positions[len(positions) // 2, 1] += 1e-3
    _, again = equilibrium.solve(made, case, [(case, replace(found, positions=positions))], None)
    assert "of one half" not in again.report.attempts[0]
    assert again.report.outcome.converged


def test_bars_that_do_not_stretch_make_no_forces_of_a_half_s_round_off():
    made = model({"panels": 2, "meshes_round": 60, "meshes_long": 20}, 1, rope=[{"number": 2, "shortening": 0.05}])
    assert (made.bag.net.bar_flexibility == 0.0).any()
    _, found = equilibrium.solve(made, made.plan.cases()[0], (), None)
    by_half = found.report.attempts[0]
    assert "of one half" in by_half
    assert "within the tolerance" in by_half


def test_quarters_of_nets_that_do_not_stretch_are_left_whole():
    assert mirror(model({"panels": 4, "knot_mm": 2.0}, 1, rope=[ROPES | {"number": 4}])) is None
