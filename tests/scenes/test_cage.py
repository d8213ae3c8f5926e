"""Cages: what they enclose, how they stand in a current with netting on netting, and that nothing passes through it."""

from dataclasses import replace
from itertools import islice

import ipctk
import numpy as np
import pytest

from codend.errors import InputError
from codend.mechanics import contact
from codend.mechanics.contact_ways import least_distance
from codend.mechanics.sheet import sheet_of
from codend.scenes.build import build
from codend.scenes.enclosure import enclosed_m3, facing_alike, openings
from codend.scenes.equilibrium import contact_law, in_still_water, stays
from codend.scenes.measures import LIES_ON_NETTING, cautions, result_row, solve_scene
from codend.scenes.netting_measures import netting_rows, volume_m3
from codend.scenes.other_shapes import LEAST_SHARE, frame_errors, netting_errors, not_sought, other_shapes, shape_errors
from codend.scenes.scene import scene_from_dict
from codend.solvers import gentle, interior_point
from codend.solvers.half import half_of
from validation.cage.gear import box, cylinder
from validation.cage.random_cages import random_cages


@pytest.fixture(scope="module")
def in_current():
    """A cage of few meshes in a current that lays its bottom on its walls."""
    result = solve_scene(build(scene_from_dict(box(0.6, merged=10))))
    assert result.converged, result.solution.report.attempts
    return result


@pytest.mark.parametrize(
    ("data", "volume"), [(box(), 1.0), (cylinder(merged=6), 0.75), (cylinder(sides=6, merged=6), 0.375 * np.sqrt(3.0))]
)
def test_the_volume_of_a_cage_as_placed_is_its_geometry(data, volume):
    built = build(scene_from_dict(data))
    assert volume_m3(built, built.problem.net.positions) == pytest.approx(volume, rel=1e-12)


def test_the_volume_does_not_depend_on_how_sheets_are_laid():
    data = box(merged=10)
    for sheet in data["netting"]:
        if sheet["name"] in ("right", "bottom"):  # mirrored: its left edge is its right one
            a, b, c, d = sheet["corners"]
            sheet["corners"] = [b, a, d, c]
    swap = {"right.left": "right.right", "right.right": "right.left", "bottom.left": "bottom.right"}
    swap["bottom.right"] = "bottom.left"
    for seam in data["seam"]:
        seam["edges"] = [swap.get(edge, edge) for edge in seam["edges"]]
    built = build(scene_from_dict(data))
    assert volume_m3(built, built.problem.net.positions) == pytest.approx(1.0, rel=1e-12)


def test_triangles_turned_either_way_are_turned_alike():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, -1.0]])
    sides = [np.array([[k, (k + 1) % 4, 4]]) for k in range(4)]
    sides[2] = sides[2][:, [1, 0, 2]]
    turned = facing_alike(sides, [np.ones(1)] * 4, square)
    faces = np.concatenate(turned)
    assert [len(loop) for loop in openings(faces, np.ones(4))] == [4]
    assert enclosed_m3(faces, np.ones(4), square) == pytest.approx(1.0 / 3.0, rel=1e-14)


def test_a_cage_in_a_current_is_in_balance_and_nothing_passes_through_it(in_current):
    row = result_row(in_current)
    assert row["residual"] < 1e-9
    assert row["balance_error"] < 1e-8
    assert row["contact_share"] > 0.05
    assert LIES_ON_NETTING in cautions(in_current)
    sheet = sheet_of(in_current.built.problem.net)
    triangles = sheet.face[sheet.face[:, 1] != sheet.face[:, 2]]
    mesh = ipctk.CollisionMesh(in_current.built.problem.net.positions, sheet.edge, triangles)
    assert not ipctk.has_intersections(mesh, np.asfortranarray(in_current.solution.positions))


def test_a_cage_in_a_current_is_found_with_contact_from_the_first_step(in_current):
    how, through, *last = in_current.solution.report.attempts
    assert how.startswith("one half of the net")
    assert through.startswith("interior point")
    assert all(attempt.startswith("newton") for attempt in last)
    assert in_current.solution.report.iterations < 60


def test_what_sheets_do_to_each_other_adds_up_to_nothing_and_keeps_them_apart(in_current):
    problem, places = in_current.built.problem, in_current.solution.positions
    near, push = problem.loading.contact, np.zeros_like(places)
    contact.add_force(places, near, push)
    assert np.abs(push).max() > 1e-4
    assert np.abs(push.sum(axis=0)).max() < 1e-9 * np.abs(push).max()
    assert least_distance(places, near) > 0.0


def test_the_drag_of_a_cage_is_what_holds_its_frame(in_current):
    held = in_current.support[in_current.built.problem.net.fixed.all(axis=1)].sum(axis=0)
    loads = in_current.load.sum(axis=0)
    assert held == pytest.approx(-loads, abs=1e-8 * np.linalg.norm(loads))
    assert abs(loads[1]) < 0.02 * loads[0]


def test_a_shape_whose_sides_are_unlike_is_told_of_a_scene_whose_sides_are_not(in_current):
    assert result_row(in_current)["unlike_sides_m"] < 1e-9
    assert not any("mirror image" in word for word in cautions(in_current))
    moved = in_current.solution.positions.copy()
    side = np.flatnonzero(~in_current.built.problem.net.fixed[:, 1] & (moved[:, 1] > 0.6))
    moved[side[0], 1] += 0.01
    unlike = replace(in_current, solution=replace(in_current.solution, positions=moved))
    assert result_row(unlike)["unlike_sides_m"] == pytest.approx(0.01, rel=1e-6)
    assert any("its two sides differ by up to 0.01 m" in word for word in cautions(unlike))


def test_a_scene_whose_sides_are_unlike_is_not_asked_for_it():
    data = box(0.1, merged=10)
    data["water"]["flow_m_s"] = [0.1, 0.02, 0.0]
    assert np.isnan(result_row(solve_scene(build(scene_from_dict(data))))["unlike_sides_m"])


def test_sheets_that_do_not_touch_are_not_changed_by_contact():
    rows = []
    for on in (True, False):
        data = box(0.1, merged=10, seam_ropes=True) | {"model": {"contact": on}}
        rows.append(result_row(solve_scene(build(scene_from_dict(data)))))
    assert rows[0]["contact_share"] == 0.0
    assert rows[0]["volume_m3"] == pytest.approx(rows[1]["volume_m3"], rel=1e-12)


def test_a_knot_that_a_taper_leaves_on_nothing_is_refused():
    data = cylinder(merged=4)
    for sheet in data["netting"]:
        if sheet["name"].startswith("gore"):
            sheet["meshes_across_aft"] = 0
    with pytest.raises(
        InputError, match=r"meshes_across_aft = 0 is not allowed; allowed: a count that leaves every knot"
    ):
        scene_from_dict(data)


@pytest.fixture(scope="module")
def slack():
    """A cage of few meshes in a current so weak that its slack netting rests in several shapes."""
    result = solve_scene(build(scene_from_dict(box(0.3, merged=8))))
    assert result.converged
    return result, other_shapes(result)


def test_errors_cover_what_a_cage_rests_in_when_it_is_let_go_at_rest(slack):
    result, others = slack
    problem, tolerance = result.built.problem, result.built.scene.model.tolerance
    assert problem.surface is not None
    rest = in_still_water(problem, tolerance)
    led = gentle.solve(problem.touching_at(rest.positions), tolerance, rest)
    assert led.report.outcome.converged

    def told(places, tension):
        rows = netting_rows(result.built, places, tension)
        return np.array([[row[name] for name in ("drag_n", "lift_n", "opening_deg")] for row in rows])

    here = told(result.solution.positions, result.solution.bar_tension)
    changed = np.abs(told(led.positions, led.bar_tension) - here)
    assert changed[:, 0].max() > 0.01 * here[:, 0].sum()  # or there were nothing to cover
    stated = np.array([list(row.values()) for row in netting_errors(result, others)])
    assert np.all(changed <= stated)
    errors = shape_errors(result, others)
    assert (
        abs(volume_m3(result.built, led.positions) - volume_m3(result.built, result.solution.positions))
        < errors["volume_error_m3"]
    )
    assert np.linalg.norm(led.positions - result.solution.positions, axis=1).max() < errors["shape_error_m"]


def test_errors_are_what_is_assumed_at_least_where_every_way_leads_to_one_shape(in_current):
    others = other_shapes(in_current)
    assert len(others) >= 4
    row, errors = result_row(in_current), shape_errors(in_current, others)
    assert errors["volume_error_m3"] == pytest.approx(LEAST_SHARE * row["volume_m3"], rel=1e-12)
    (pull,) = frame_errors(in_current, others)
    assert pull["pull_error_n"] == pytest.approx(LEAST_SHARE * in_current.load[:, 0].sum(), rel=1e-9)
    assert not_sought(in_current, others) == []


def test_errors_that_were_not_sought_are_empty_and_told(in_current):
    assert np.isnan(list(shape_errors(in_current, []).values())).all()
    assert all(np.isnan(list(row.values())).all() for row in netting_errors(in_current, []))
    (told,) = not_sought(in_current, [])
    assert "errors are left empty" in told


def test_a_cage_that_would_leave_its_mirrored_shape_is_followed_to_where_it_stays():
    data = next(islice(random_cages(29, seed=29), 28, None))
    result = solve_scene(build(scene_from_dict(data)))
    assert result.converged
    assert any("which the whole net would leave" in attempt for attempt in result.solution.report.attempts)
    assert result.stable == "yes"
    assert 1e-4 < result_row(result)["unlike_sides_m"] < 0.01
    half = half_of(result.built.problem)
    assert half is not None
    law = contact_law(half.problem)
    of_half = interior_point.solve(half.problem.touching_by(law), result.built.scene.model.tolerance)
    assert of_half.report.outcome.converged
    mirrored = half.whole(of_half)
    assert not stays(result.built.problem.touching_by(law).touching_at(mirrored.positions), mirrored)
