"""Cages: what they enclose, how they stand in a current with netting on netting, and that nothing passes through it."""

import ipctk
import numpy as np
import pytest

from codend.errors import InputError
from codend.mechanics import contact
from codend.mechanics.contact_ways import least_distance
from codend.mechanics.sheet import sheet_of
from codend.scenes.build import build
from codend.scenes.enclosure import enclosed_m3, facing_alike, openings
from codend.scenes.measures import LIES_ON_NETTING, cautions, result_row, solve_scene
from codend.scenes.netting_measures import volume_m3
from codend.scenes.scene import scene_from_dict
from validation.cage.gear import box, cylinder


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
    through, last = in_current.solution.report.attempts
    assert through.startswith("interior point")
    assert last.startswith("newton")
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
