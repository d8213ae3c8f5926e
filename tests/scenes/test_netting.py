"""Sheets of netting in scenes: closed forms, symmetry, merging, seams, motion, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from codend.errors import InputError
from codend.mechanics.problem import Problem
from codend.mechanics.weight import GRAVITY_M_S2
from codend.scenes.build import build
from codend.scenes.follow import follow, motion_rows
from codend.scenes.measures import balance_error, cautions, result_row, solve_scene
from codend.scenes.netting_measures import netting_rows
from codend.scenes.scene import scene_from_dict
from codend.solvers.motion import Motion
from codend.solvers.refusal import passage
from codend.solvers.solve import find_equilibrium

WATER = 1025.0


def solved(data, source="scene"):
    built = build(scene_from_dict(data, source))
    result = solve_scene(built)
    assert result.converged, result.solution.report.attempts
    assert balance_error(result) < 1e-9
    return result


def row(result, number=0):
    return netting_rows(result.built, result.solution.positions, result.solution.bar_tension)[number]


def strip(rows, speed_m_s, law="le-bris-1999"):
    """A wall that repeats sideways with ballast along its foot, and u = R h / W of it."""
    height, ballast, twine, merged = 10.0, 200.0, 2e-4, 5000 // rows
    bar = height / rows / merged
    wide = merged * bar
    area = np.pi * 1e-4 / 4.0
    foot = {"name": "foot", "from": "c", "to": "d", "length_m": wide, "diameter_mm": 10.0, "normal": 0.0}
    foot |= {"tangential": 0.0, "mass_kg_m": WATER * area + ballast / GRAVITY_M_S2}
    wall = {"name": "wall", "mesh": "square", "bar_mm": 1e3 * bar, "twine_mm": 1e3 * twine, "meshes_across": merged}
    wall |= {"meshes_long": rows * merged, "globalisation": merged, "corners": ["a", "b", "d", "c"], "tangential": 0.0}
    wall |= {"fore": "vessel", "aft": "foot", "left": "repeats", "right": "repeats", "law": law, "normal": 1.36}
    points = [
        {"name": "a", "at": [0, 0, 0], "held": "vessel"},
        {"name": "b", "at": [0, wide, 0], "held": "vessel"},
        {"name": "c", "at": [0.1, 0, -9.0]},
        {"name": "d", "at": [0.1, wide, -9.0]},
    ]
    load = 0.5 * WATER * 1.36 * speed_m_s**2 * twine * 2.0 / bar
    data = {"title": "strip", "vessel": {"speed_m_s": speed_m_s}, "point": points, "rope": [foot], "netting": [wall]}
    return data, load * height / ballast


@pytest.mark.parametrize("speed_m_s", [0.3, 0.5])
def test_a_wall_that_repeats_sideways_hangs_as_its_closed_form(speed_m_s):
    # LB99: depth / h = asinh(u) / u, drift / h = (sqrt(1 + u^2) - 1) / u, upright and cross-flow twine alike
    data, u = strip(100, speed_m_s)
    result = solved(data)
    foot = result.solution.positions[result.built.node_of["c"]] / 10.0
    assert -foot[2] == pytest.approx(np.arcsinh(u) / u, rel=1e-4)
    assert foot[0] == pytest.approx((np.sqrt(1.0 + u * u) - 1.0) / u, rel=2e-4)


CABLE = (lambda u: np.arcsinh(u) / u, lambda u: (np.sqrt(1.0 + u * u) - 1.0) / u)
CHAIN = (lambda u: 2.0 * np.arctan(np.tanh(0.5 * u)) / u, lambda u: np.log(np.cosh(u)) / u)


@pytest.mark.parametrize(
    ("law", "twine", "depth", "drift"),
    [
        ("le-bris-1999", "upright", *CABLE),
        ("le-bris-1999", "cross-flow", *CABLE),
        ("bessonneau-1997", "upright", *CHAIN),
        ("bessonneau-1997", "cross-flow", *CABLE),
    ],
)
def test_a_wall_of_twine_one_way_hangs_as_the_closed_form_of_its_law(law, twine, depth, drift):
    # BM97: gd(u) / u and ln cosh(u) / u of upright twine, as of cross-flow twine asinh(u) / u
    data, both = strip(100, 0.5, law)
    built = build(scene_from_dict(data))
    net = built.problem.net
    across = np.abs(np.diff(net.positions[net.bars], axis=1)[:, 0, 1]) > 1e-9
    normal = np.where(across == (twine == "cross-flow"), net.bar_normal_drag, 0.0)
    bare = replace(net, bar_normal_drag=normal)
    found = find_equilibrium(Problem.of(bare, water=built.problem.loading.water), 1e-10)
    assert found.report.outcome.converged
    foot, u = found.positions[built.node_of["c"]] / 10.0, 0.5 * both
    assert -foot[2] == pytest.approx(depth(u), rel=1e-4)
    assert foot[0] == pytest.approx(drift(u), rel=2e-4)


def test_the_wall_in_motion_comes_to_the_same_rest():
    data, _ = strip(25, 0.5)
    built = build(scene_from_dict(data))
    rest = solve_scene(built)
    motion = Motion(built.problem, built.problem.net.positions, added_mass=built.added_mass, towed=built.towed)
    for _ in range(800):
        motion.step(0.25)
    assert motion.position == pytest.approx(rest.solution.positions, abs=1e-3)
    # bars across that their supports hold carry nothing that could be told
    assert motion.tension == pytest.approx(rest.solution.bar_tension, abs=0.3)


def wall(half, mesh, **more):
    """A small wall with a weight at its foot's corners, whole or cut in its plane of symmetry."""
    meshes = 10
    side = 0.05 * meshes * (1.0 if mesh == "diamond" else 0.5) / 2.0 * (1.0 if mesh == "diamond" else 2.0)
    weight = {"mass_kg": 3.0, "wet_weight_n": 20.0}
    points = [{"name": "b", "at": [0, side, 0], "held": "vessel"}, {"name": "d", "at": [0.1, side, -0.5], **weight}]
    sheet = {"name": "wall", "mesh": mesh, "bar_mm": 50.0, "twine_mm": 2.0, "meshes_long": 6, "fore": "vessel", **more}
    if half:
        sheet |= {"meshes_across": meshes // 2, "corners": [[0, 0, 0], "b", "d", [0.1, 0, -0.5]], "left": "symmetry"}
    else:
        sheet |= {"meshes_across": meshes, "corners": ["a", "b", "d", "c"]}
        points += [{"name": "a", "at": [0, -side, 0], "held": "vessel"}]
        points += [{"name": "c", "at": [0.1, -side, -0.5], **weight}]
    return {"title": "wall", "vessel": {"speed_m_s": 0.3}, "point": points, "netting": [sheet]}


@pytest.mark.parametrize("stiffness", [{}, {"axial_stiffness_n": 2000.0}], ids=["rigid", "stretching"])
@pytest.mark.parametrize("mesh", ["diamond", "square"])
def test_half_a_wall_with_its_plane_of_symmetry_is_the_whole_wall(mesh, stiffness):
    whole, half = solved(wall(False, mesh, **stiffness)), solved(wall(True, mesh, **stiffness))
    places = [r.solution.positions[r.built.node_of["d"]] for r in (whole, half)]
    assert places[1] == pytest.approx(places[0], abs=1e-9)
    for key in ("mass_kg", "twine_area_m2", "drag_n"):
        assert 2.0 * row(half)[key] == pytest.approx(row(whole)[key], rel=1e-9)
    assert 2.0 * result_row(half)["pull_ahead_n"] == pytest.approx(result_row(whole)["pull_ahead_n"], rel=1e-9)


def hung(**sheet):
    """A wall of diamond netting between a headline and a foot rope, both with sizes of their own."""
    rope = {"length_m": 10.2, "diameter_mm": 20.0, "mass_kg_m": 0.3}
    points = [{"name": name, "at": [0, y, 0], "held": "vessel"} for name, y in (("a", 0.0), ("b", 10.0))]
    points += [{"name": name, "at": [0.1, y, -4.0]} for name, y in (("c", 0.0), ("d", 10.0))]
    ropes = [{"name": "head", "from": "b", "to": "a", **rope}]
    ropes += [{"name": "foot", "from": "c", "to": "d", **rope, "length_m": 10.0, "mass_kg_m": 6.0}]
    net = {"name": "wall", "mesh": "diamond", "bar_mm": 50.0, "twine_mm": 2.0, "meshes_across": 200, "meshes_long": 60}
    net |= {"corners": ["a", "b", "d", "c"], "fore": "head", "aft": "foot", "twine_density_kg_m3": 950.0}
    net |= {"globalisation": 10, **sheet}
    return {"title": "hung", "vessel": {"speed_m_s": 0.5}, "point": points, "rope": ropes, "netting": [net]}


def test_merging_meshes_leaves_mass_weight_and_twine_as_they_are():
    rows = [row(solve_scene(build(scene_from_dict(hung(globalisation=g))))) for g in (10, 20)]
    for key in ("mass_kg", "wet_weight_n", "twine_area_m2", "twine_m"):
        assert rows[1][key] == pytest.approx(rows[0][key], rel=1e-12)
    assert rows[0]["twine_m"] == pytest.approx(4 * 200 * 60 * 0.05)


def test_netting_hangs_on_ropes_knot_by_knot_and_the_balance_is_shown():
    result = solved(hung())
    built = result.built
    head = built.rope_nodes[0]
    assert set(head) <= set(built.sheet_nodes[0].tolist())
    assert len(head) == 21
    told = result_row(result)
    assert told["balance_error"] < 1e-9
    # what the vessel pulls is the drag of netting and ropes, and what they weigh in water
    assert told["pull_ahead_n"] > row(result)["drag_n"]
    assert 0.0 < row(result)["opening_deg"] < 180.0
    assert any("does not slow the water" in note for note in cautions(result))


def test_a_wall_behind_another_meets_the_wake_that_loland_tells():
    # r = 1 - 0.46 Cd, Cd = 1.36 x twine area over the area between the corners
    front = wall(False, "square", normal=1.36)
    ahead = front["netting"][0]
    corners = [[5.0, -0.25, 0.0], [5.0, 0.25, 0.0], "d behind", "c behind"]
    behind = {**ahead, "name": "rear", "corners": corners}
    points = [{**p, "name": f"{p['name']} behind", "at": [p["at"][0] + 5.0, *p["at"][1:]]} for p in front["point"]]
    data = {**front, "netting": [ahead, behind], "point": front["point"] + [p for p in points if p["name"][0] in "cd"]}
    alone, shielded = (
        solved({**data, "netting": [ahead, {**behind, **more}]}) for more in ({}, {"shielded_by": "wall"})
    )
    twine = row(alone)["twine_area_m2"]
    area = 0.5 * np.hypot(0.5, 0.1)
    share = 1.0 - 0.46 * 1.36 * twine / area
    assert row(shielded, 1)["speed_share"] == pytest.approx(share, rel=1e-2)
    assert row(shielded)["speed_share"] == 1.0
    assert row(shielded, 1)["twine_area_m2"] == pytest.approx(twine)
    at = alone.solution.positions
    drag = [netting_rows(r.built, at, alone.solution.bar_tension)[1]["drag_n"] for r in (alone, shielded)]
    assert drag[1] / drag[0] == pytest.approx(row(shielded, 1)["speed_share"] ** 2, rel=1e-12)
    assert any("by Løland (1993) that of rear to" in note for note in cautions(shielded))


def test_two_halves_sewn_together_are_one_sheet():
    whole = wall(False, "diamond")
    sheet = whole["netting"][0]
    left = {**sheet, "name": "left", "meshes_across": 5, "corners": ["a", [0, 0, 0], [0.1, 0, -0.5], "c"]}
    right = {**sheet, "name": "right", "meshes_across": 5, "corners": [[0, 0, 0], "b", "d", [0.1, 0, -0.5]]}
    parts = {**whole, "netting": [left, right], "seam": [{"edges": ["left.right", "right.left"]}]}
    one, two = solved(whole), solved(parts)
    assert len(two.built.problem.net.positions) == len(one.built.problem.net.positions)
    places = [r.solution.positions[r.built.node_of["d"]] for r in (one, two)]
    assert places[1] == pytest.approx(places[0], abs=1e-9)
    assert row(two)["drag_n"] + row(two, 1)["drag_n"] == pytest.approx(row(one)["drag_n"], rel=1e-9)


def test_an_edge_between_the_same_point_twice_is_gathered_there():
    data = wall(False, "diamond")
    data["netting"][0]["corners"] = ["a", "b", "d", "d"]
    data["point"] = [point for point in data["point"] if point["name"] != "c"]
    built = build(scene_from_dict(data))
    aft = built.sheet_nodes[0][built.scene.netting[0].sheet.edges["aft"].knots]
    assert set(aft.tolist()) == {built.node_of["d"]}


def test_netting_in_motion_has_its_rows_and_its_momentum():
    data = hung(globalisation=20, axial_stiffness_n=5000.0) | {"time": {"end_s": 0.5, "output_s": 0.25}}
    built = build(scene_from_dict(data))
    frames = list(follow(built, solve_scene(built).solution.positions))
    names = [one["name"] for one in motion_rows(built, frames[-1])]
    assert names == ["vessel", "a", "b", "c", "d", "head", "foot", "wall"]
    free = ~built.problem.net.fixed.any(axis=1)
    scale = np.abs(frames[-1].support[~free]).max()
    assert np.abs(frames[-1].support[free]).max() < 1e-8 * scale


def test_netting_that_a_rope_pierces_is_seen():
    built = build(scene_from_dict(hung()))
    through = solve_scene(built).solution.positions.copy()
    assert passage(built.problem, through) is None
    middle = built.sheet_nodes[0][len(built.sheet_nodes[0]) // 2]
    for node, side in zip(built.rope_nodes[1][10:12], (-1.0, 1.0), strict=True):
        through[node] = through[middle] + [side, 0.03, 0.02 * side]
    assert passage(built.problem, through) is not None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"globalisation": 7}, "allowed: a common divisor of its counts: 1, 2, 4, 5, 10, 20"),
        ({"twine_mm": 60.0}, "netting.0.twine_mm = 60.0 is not allowed; allowed: thinner than a bar is long"),
        ({"mesh_mm": 100.0}, "netting.0.mesh_mm = 100.0 contradicts bar_mm"),
        ({"fore": "warp"}, 'fore = "warp" names warp, which is none; allowed: ropes, of head, foot'),
        ({"fore": "foot"}, "allowed: ropes end to end, from the point at its first corner to the one at its last"),
        ({"aft": "ground"}, "allowed: vessel.motion in place of vessel.speed_m_s"),
        ({"corners": ["a", "b", "d", "e"]}, "netting.0.corners.3 = "),
        ({"corners": ["a", "b", "d"]}, "netting.0.corners.3 is missing"),
        ({"left": "symmetry", "corners": ["a", "b", "d", [0, 1, 0]]}, "a place in the plane of symmetry, y = 0"),
        ({"meshes_across_aft": 100, "mesh": "square"}, "netting.0.meshes_across_aft"),
        ({"shielded_by": "rear"}, "netting.0.shielded_by"),
        ({"knot_mm": 3.0}, "netting.0.knot_mm = 3.0 is not a known key"),
        ({"name": "head"}, "allowed: a name that no other netting, rope or point has"),
        ({"meshes_across": 80, "globalisation": 20}, "netting.0.axial_stiffness_n is missing"),
        (
            {"fore": "vessel", "corners": [[0, -11, 0], [0, 11, 0], "d", "c"]},
            "or the held corners of its fore edge nearer than 20 m, not 22 m",
        ),
    ],
)
def test_mistakes_in_netting_are_one_line_with_the_key(change, message):
    with pytest.raises(InputError) as refused:
        scene_from_dict(hung(**change), "scene.toml")
    assert any(message in line for line in refused.value.lines), refused.value.lines
    assert all(line.startswith("scene.toml: ") for line in refused.value.lines)


def test_a_seam_names_netting_and_edges():
    data = hung() | {"seam": [{"edges": ["wall.left", "wall.top"]}]}
    with pytest.raises(InputError, match=r"seam\.0\.edges\.1 = \"wall\.top\""):
        scene_from_dict(data)


def test_netting_that_is_placed_farther_than_it_reaches_is_drawn_in_or_refused():
    data = hung() | {"time": {"end_s": 1.0, "output_s": 0.5, "start": "placed"}}
    data["point"][2]["at"], data["point"][3]["at"] = [0, 0, -9.0], [0, 9.9, -9.0]
    net = build(scene_from_dict(data)).problem.net
    apart = np.linalg.norm(net.positions[net.bars[:, 1]] - net.positions[net.bars[:, 0]], axis=1)
    assert np.all(apart <= (1.0 + 5e-3) * net.bar_length)
    data["netting"][0]["left"] = data["netting"][0]["right"] = "vessel"
    with pytest.raises(InputError, match=r"is placed .* times as long as it is, however it is drawn in"):
        build(scene_from_dict(data))


def test_netting_that_hangs_on_nothing_is_refused():
    data = hung()
    loose = {**data["netting"][0], "name": "loose", "corners": [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]]}
    loose = {key: value for key, value in loose.items() if key not in ("fore", "aft")}
    with pytest.raises(InputError, match=r"netting\.1\.corners"):
        scene_from_dict({**data, "netting": [data["netting"][0], loose]})


def test_half_a_wall_moves_as_the_whole_wall():
    ends = []
    for half in (False, True):
        built = build(scene_from_dict(wall(half, "diamond")))
        rest = solve_scene(built).solution.positions
        velocity = np.where(built.problem.net.fixed, 0.0, [0.1, 0.0, 0.0])
        moving = Motion(built.problem, rest, velocity, added_mass=built.added_mass, towed=built.towed)
        for _ in range(20):
            moving.step(0.02)
        ends.append(moving.position[built.node_of["d"]])
    assert ends[1] == pytest.approx(ends[0], abs=1e-8)
