"""Netting that meets netting in motion: two curtains in a current, the light one in front blown against the other."""

import numpy as np
import pytest

from codend.errors import InputError
from codend.mechanics.contact_rows import add_pushes, write_gaps
from codend.scenes.build import build
from codend.scenes.by_motion import calm_shapes
from codend.scenes.equilibrium import contact_law, from_there
from codend.scenes.follow import follow
from codend.scenes.scene import scene_from_dict
from codend.solvers.refusal import passage


def curtains(end_s=4.0, apart_m=0.15, merged=4, **model):
    """Upper edges hang on the ground, 0.15 m from each other; weights at the lower corners of the second."""
    sheet = {"mesh": "square", "bar_mm": 100.0, "twine_mm": 2.0, "material": "PA", "meshes_across": 12}
    sheet |= {"meshes_long": 16, "globalisation": merged}
    weight = {"mass_kg": 0.5, "density_kg_m3": 7850.0}
    points, netting = [], []
    for name, x in (("front", 0.0), ("back", apart_m)):
        points += [
            {"name": f"{name} {side}", "at": [x, y, -1.0], "held": "ground"} for side, y in (("l", 0), ("r", 1.15))
        ]
        netting.append(
            {"name": name, "corners": [f"{name} l", f"{name} r", [x, 1.15, -2.55], [x, 0.0, -2.55]], **sheet}
        )
    points += [{"name": f"weight {k}", "at": [apart_m, y, -2.55], **weight} for k, y in enumerate((0.0, 1.15))]
    netting[1]["corners"][2:] = ["weight 1", "weight 0"]
    data = {"title": "curtains", "water": {"flow_m_s": [0.5, 0.0, 0.0]}, "point": points, "netting": netting}
    time = {"end_s": end_s, "output_s": 0.5, "step_s": 0.02, "start": "placed"}
    return build(scene_from_dict({**data, "time": time, **({"model": model} if model else {})}))


def frames(built, state=None):
    return list(follow(built, built.problem.net.positions, state))


def middles(built, frame):
    return [float(frame.positions[nodes, 0].mean()) for nodes in built.sheet_nodes]


def test_under_contact_the_light_curtain_stays_in_front():
    passing, under = curtains(), curtains(contact=True)
    through, stopped = frames(passing)[-1], frames(under)[-1]
    assert through.passages[0] > 0
    assert middles(passing, through)[0] > middles(passing, through)[1]
    assert stopped.passages[0] == 0
    assert middles(under, stopped)[0] < middles(under, stopped)[1]
    touching = under.problem.touching_by(contact_law(under.problem))
    assert touching.surface.least_distance(stopped.positions) > 0.0
    assert np.all(stopped.support[under.problem.net.fixed.any(axis=1) == 0] == pytest.approx(0.0, abs=1e-8))


def test_a_motion_under_contact_goes_on_from_any_frame():
    built = curtains(end_s=2.0, contact=True)
    whole = frames(built)
    assert len(whole[3].state["met"]) > 0
    assert np.array_equal(frames(built, whole[3].state)[-1].positions, whole[-1].positions)


def test_pushes_of_parts_that_meet_have_no_force_and_no_moment():
    built = curtains()
    rng = np.random.default_rng(2)
    places = built.problem.net.positions + 0.05 * rng.normal(size=built.problem.net.positions.shape)
    pairs = built.problem.touching_by(contact_law(built.problem)).surface.within(places, 0.1)
    gap, gradient = np.empty(len(pairs.kind)), np.empty((len(pairs.kind), 4, 3))
    write_gaps(places, pairs, gap, gradient)
    assert len(gap) > 50
    forces = np.zeros_like(places)
    add_pushes(pairs.node, gradient, rng.uniform(size=len(gap)), forces)
    assert np.abs(forces).max() > 0.5
    assert np.abs(forces.sum(axis=0)).max() < 1e-12
    assert np.abs(np.cross(places, forces).sum(axis=0)).max() < 1e-12


def test_gaps_change_as_their_gradients_say():
    built = curtains()
    rng = np.random.default_rng(3)
    places = built.problem.net.positions + 0.05 * rng.normal(size=built.problem.net.positions.shape)
    move = 1e-6 * rng.normal(size=places.shape)
    pairs = built.problem.touching_by(contact_law(built.problem)).surface.within(places, 0.1)
    (gap, gradient), (there, back) = ((np.empty(len(pairs.kind)), np.empty((len(pairs.kind), 4, 3))) for _ in range(2))
    write_gaps(places, pairs, gap, gradient)
    write_gaps(places + move, pairs, there, back)
    grown = -np.einsum("kia,kia->k", 0.5 * (gradient + back), move[pairs.node])
    assert there - gap == pytest.approx(grown, abs=1e-9)


def test_a_motion_under_contact_starts_where_nothing_passes_through_anything():
    with pytest.raises(InputError, match=r"model\.contact = .* is not possible from the start"):
        frames(curtains(apart_m=0.0, contact=True))


def test_a_net_is_led_near_its_rest_by_its_motion():
    problem = curtains().problem
    touching = problem.touching_by(contact_law(problem))
    start = next(calm_shapes(touching))
    assert passage(touching, start.positions) is None
    found_problem, found = from_there(problem, 1e-9, start)
    assert found.report.outcome.converged
    assert passage(found_problem, found.positions) is None
