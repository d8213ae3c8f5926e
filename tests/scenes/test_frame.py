"""Frames of a scene, held and afloat, and ballast: closed forms, balances, motion, and what is refused."""

import numpy as np
import pytest
from click.testing import CliRunner

from codend.cli.main import main
from codend.errors import InputError
from codend.mechanics.body import pose_of
from codend.mechanics.weight import GRAVITY_M_S2
from codend.scenes.build import build
from codend.scenes.frame_measures import float_rows, frame_cautions, frame_rows
from codend.scenes.measures import balance_error, result_row, solve_scene
from codend.scenes.scene import scene_from_dict
from codend.solvers import in_turns
from codend.solvers.refusal import passage
from codend.solvers.solve import find_equilibrium
from validation.cage.gear import box
from validation.cage.random_cages import crosses_itself
from validation.floating_cage import afloat, pulls
from validation.floating_frame import (
    WATER,
    balances,
    beams,
    drafts,
    hung,
    moored,
    periods,
    settles,
    solved,
    spins,
    tangents,
)
from validation.random_frames import WRONG, left_over, random_frame

ROUND = {"name": "a", "at": [0, 0, 0], "height_m": 1.0, "diameter_m": 1.0}
TOML = """
title = "A frame"
frame = { hold = "floating", mass_kg = 100.0, inertia_kg_m2 = [50.0, 60.0, 70.0] }
time = { end_s = 0.5, output_s = 0.25, step_s = 0.01 }
point = [{ name = "a", at = [-2.0, 0.0, 0.0], held = "frame" }, { name = "A", at = [-9.0, 0.0, -5.0], held = "ground" }]
rope = [{ from = "a", to = "A", length_m = 9.0, diameter_mm = 20.0, mass_kg_m = 1.0, bars = 8 }]

[[float]]
name = "front"
at = [-2.0, 0.0, -0.1]
height_m = 0.5
length_m = 0.3
width_m = 4.0

[[float]]
name = "rear"
at = [2.0, 0.0, -0.1]
height_m = 0.5
diameter_m = 1.2
"""


@pytest.mark.parametrize("group", [drafts, periods, spins, balances, tangents, settles])
def test_a_floating_frame_agrees_with_its_closed_forms_and_balances(group):
    for one in group():
        assert one.off <= one.allowed, one


def test_a_held_frame_carries_what_hangs_on_it():
    result = solved(hung(0.5, "held"))
    row = frame_rows(result.built, result.solution.positions, result.support)[0]
    assert balance_error(result) < 1e-8
    # held where it is placed, its beams 0.1 m deep: weight, two weights, netting and moorings against buoyancy
    floats = float_rows(result.built, result.solution.positions)
    assert row["buoyancy_n"] == pytest.approx(sum(one["buoyancy_n"] for one in floats))
    assert row["force_z_n"] == pytest.approx(row["weight_n"] - row["buoyancy_n"] - row["pull_z_n"])
    assert row["force_x_n"] == pytest.approx(-row["pull_x_n"])
    assert (row["z_m"], row["trim_deg"], row["hold"]) == (0.0, 0.0, "held")


def test_a_frame_on_one_mooring_turns_into_the_current():
    data = moored(0.5)
    data["rope"] = [rope for rope in data["rope"] if rope["name"] != "mooring b"]
    data["point"] = [point for point in data["point"] if point["name"] not in ("b", "B")]
    result = solved(data)
    row = frame_rows(result.built, result.solution.positions, result.support)[0]
    # the mooring, at (-2, 1.5) of it, lies in one vertical plane with the drag at its middle, but for its heel
    assert row["yaw_deg"] == pytest.approx(np.degrees(np.arctan2(1.5, 2.0)), abs=0.1)
    assert row["y_m"] == pytest.approx(4.0, abs=0.01)


def test_without_a_mooring_it_drifts_and_no_equilibrium_is_told():
    data = beams(water={"density_kg_m3": WATER, "flow_m_s": [0.5, 0.0, 0.0]})
    data["point"] += [{"name": "drag", "at": [0, 0, 0], "held": "frame", "area_m2": 2.0, "drag": 1.0}]
    assert not solve_scene(build(scene_from_dict(data))).converged


def test_a_frame_that_is_too_heavy_hangs_on_its_moorings_and_that_is_told():
    data = moored(0.5)
    data["frame"] = {**data["frame"], "mass_kg": 5000.0}
    result = solved(data)
    assert any("under water" in note for note in frame_cautions(result.built, result.solution.positions))


HANGS_AT_M = -2.0 - np.sqrt(4.2**2 - 3.0**2 - 1.5**2)
"""Where four moorings of 4.2 m pulled straight hold the frame of ``afloat``, their anchors 2 m deep."""


@pytest.mark.parametrize("mass_kg", [150.0, 500.0, 5000.0])
def test_a_frame_that_floats_for_120_kg_do_not_carry_hangs_as_deep_as_its_moorings_let_it(mass_kg):
    cage = box(0.0)
    frame_alone = {"netting": [], "seam": [], "point": [one for one in cage["point"] if "top" in one["name"]]}
    data = afloat({key: value for key, value in (cage | frame_alone).items() if key != "ballast"})
    data["frame"] = {**data["frame"], "mass_kg": mass_kg}
    row = frame_rows((result := solved(data)).built, result.solution.positions, result.support)[0]
    # the moorings have weight, and sag the less the heavier the frame
    assert row["z_m"] == pytest.approx(HANGS_AT_M, abs=2e-5)
    assert (row["heel_deg"], row["trim_deg"], row["yaw_deg"]) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert row["pull_z_n"] == pytest.approx(row["weight_n"] - row["buoyancy_n"])


@pytest.mark.parametrize("mass_kg", [500.0, 1000.0])
def test_a_cage_on_such_a_frame_hangs_with_it_and_does_not_pass_through_itself(mass_kg):
    data = afloat(box(0.3, merged=10))
    data["frame"] = {**data["frame"], "mass_kg": mass_kg}
    result = solved(data)
    row = frame_rows(result.built, result.solution.positions, result.support)[0]
    assert row["z_m"] == pytest.approx(HANGS_AT_M, abs=1e-4)
    assert balance_error(result) < 1e-8
    assert not crosses_itself(result.built, result.solution.positions)
    assert pulls(result)[0] == pytest.approx(pulls(result)[1], rel=1e-8)


def test_a_float_cut_at_its_foot_is_told():
    weight = {"name": "weight", "at": [4.0, 0.0, 0.0], "held": "frame", "wet_weight_n": 1450.0}
    result = solved(beams(point=[weight]))
    told = frame_cautions(result.built, result.solution.positions)
    assert any("front is out of the water" in note or "crosses the foot" in note for note in told)


def ballasted(**ballast):
    data = hung(0.3, "held")
    data["point"] = [
        {key: value for key, value in point.items() if key not in ("mass_kg", "wet_weight_n") or "drag" in point}
        for point in data["point"]
    ]
    return data | {"ballast": ballast}


@pytest.mark.parametrize("where", [{"points": ["foot 1", "foot -1"]}, {"edges": ["wall.aft"]}])
def test_ballast_hangs_where_its_table_says(where):
    result = solved(ballasted(mass_kg=10.0, density_kg_m3=11340.0, **where))
    net = result.built.problem.net
    assert net.point_mass.sum() == pytest.approx(10.0)
    assert net.point_wet_weight.sum() == pytest.approx(10.0 * GRAVITY_M_S2 * (1.0 - WATER / 11340.0))
    foot = set(result.built.sheet_nodes[0][result.built.scene.netting[0].sheet.edges["aft"].knots].tolist())
    hung_at = {int(node) for node, mass in zip(net.point_node, net.point_mass, strict=True) if mass > 0.0}
    assert hung_at <= foot
    assert len(hung_at) == (2 if "points" in where else len(foot))


def test_ballast_at_points_is_a_weight_at_each():
    one = solved(ballasted(mass_kg=10.0, wet_weight_n=80.0, points=["foot 1", "foot -1"]))
    other = solved(hung(0.3, "held"))
    assert one.solution.positions == pytest.approx(other.solution.positions, abs=1e-9)


def test_a_motion_goes_on_from_a_state_as_it_would_have():
    from codend.scenes.follow import follow

    built = build(scene_from_dict(moored(1.0, time={"end_s": 1.0, "output_s": 0.5, "step_s": 0.0125})))
    start = built.problem.net.positions
    frames = list(follow(built, start))
    again = list(follow(built, start, frames[1].state))
    assert np.array_equal(again[-1].positions, frames[-1].positions)
    assert pose_of(built.frame, frames[-1].positions).origin[0] > 1e-3


def test_the_command_writes_frame_and_floats(tmp_path):
    import pandas as pd

    scene = tmp_path / "frame.toml"
    scene.write_text(TOML)
    result = CliRunner().invoke(main, ["scene", str(scene), "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    frame, floats = (pd.read_csv(tmp_path / "out" / name) for name in ("frame.csv", "floats.csv"))
    assert frame["hold"].tolist() == ["floating"]
    assert floats["buoyancy_n"].sum() == pytest.approx(frame["buoyancy_n"][0])
    motion = pd.read_csv(tmp_path / "out" / "motion.csv")
    assert motion[motion["name"] == "frame"]["trim_deg"].notna().all()
    assert {"front", "rear"} <= set(motion["name"])


def test_a_frame_that_is_not_found_ends_in_words_that_say_what_speaks_against_it(tmp_path):
    scene = tmp_path / "frame.toml"
    more = """
        [[point]]
        name = "b"
        at = [2.0, 0.0, 0.0]
        held = "frame"
        [[point]]
        name = "B"
        at = [9.0, 0.0, -5.0]
        held = "ground"
        [[rope]]
        from = "b"
        to = "B"
        length_m = 5.0
        diameter_mm = 20.0
        mass_kg_m = 1.0
        bars = 8
    """
    point = '[[point]]\nname = "a"\nat = [-2.0, 0.0, 0.0]\nheld = "frame"\n'
    point += '[[point]]\nname = "A"\nat = [-9.0, 0.0, -5.0]\nheld = "ground"\n'
    rope = '[[rope]]\nfrom = "a"\nto = "A"\nlength_m = 5.0\ndiameter_mm = 20.0\nmass_kg_m = 1.0\nbars = 8\n'
    still = [line for line in TOML.splitlines() if not line.startswith(("time =", "point =", "rope ="))]
    scene.write_text("\n".join(still) + "\n" + point + rope + more)
    result = CliRunner().invoke(main, ["scene", str(scene), "--out", str(tmp_path / "out")])
    assert result.exit_code == 3, result.output
    assert "No equilibrium was found" in result.output
    assert "Rope rope 1 is 5 m long, and its ends are placed 8.602 m apart." in result.output


def test_a_frame_heavier_than_its_floats_carry_is_told_so_where_it_is_not_found():
    data = beams()
    data["frame"] = {**data["frame"], "mass_kg": 1e5}
    result = solve_scene(build(scene_from_dict(data)))
    assert not result.converged
    assert "The floats carry at most" in " ".join(frame_cautions(result.built, result.solution.positions))
    assert np.isnan(frame_rows(result.built, result.solution.positions, result.support)[0]["heel_deg"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"frame": None}, 'point.0.held = "frame" is not allowed; allowed: "ground", or a table [frame]'),
        ({"float": []}, "float = [] is missing; allowed: one table [[float]] at least"),
        ({"float": [{"name": "a", "at": [0, 0, 0], "height_m": 1.0}]}, "float.0.length_m is missing"),
        ({"float": [{**ROUND, "width_m": 1.0}]}, "float.0.width_m = 1.0 contradicts diameter_m"),
        ({"float": [{**ROUND, "name": "port"}]}, "float.0.name"),
        ({"frame": {"hold": "floating"}, "float": [{"name": "a", "at": [0, 0, 0], "height_m": 1.0, "diameter_m": 1.0}]},
         "frame.mass_kg is missing"),
        ({"ballast": {"mass_kg": 1.0, "points": ["port"]}}, "ballast.density_kg_m3 is missing"),
        ({"ballast": {"mass_kg": 1.0, "wet_weight_n": 9.0, "points": ["nowhere"]}}, "ballast.points.0"),
        ({"ballast": {"mass_kg": 1.0, "wet_weight_n": 9.0, "edges": ["wall.aft"]}}, "ballast.edges.0"),
        ({"ballast": {"mass_kg": 1.0, "wet_weight_n": 9.0}}, "ballast.points is missing"),
        ({"time": {"end_s": 1.0, "output_s": 0.5, "step_s": 0.2}}, "time.step_s = 0.2 is not allowed; allowed: at "),
    ],
)  # fmt: skip
def test_mistakes_in_a_frame_are_one_line_with_the_key(change, message):
    data = {key: value for key, value in {**beams(), **change}.items() if value is not None}
    with pytest.raises(InputError) as refused:
        build(scene_from_dict(data, "scene.toml"))
    assert any(message in line for line in refused.value.lines), refused.value.lines


def test_a_frame_and_its_net_in_turns_come_to_the_same_as_at_once():
    built = build(scene_from_dict(hung(0.5)))
    at_once = solve_scene(built).solution

    def held(problem, start):
        return problem, find_equilibrium(problem, 1e-10, start)

    _, turned = in_turns.solve(built.problem, 1e-9, held)
    assert turned.report.outcome.converged
    assert turned.positions == pytest.approx(at_once.positions, abs=1e-6)
    assert turned.bar_tension == pytest.approx(at_once.bar_tension, abs=1e-5)


def test_a_frame_too_high_to_stand_turns_over_and_is_found_on_its_head():
    # it floats upright by symmetry, but would not stay so
    data = beams()
    data["frame"] = {**data["frame"], "centre": [0.0, 0.0, 60.0]}
    row = frame_rows((result := solved(data)).built, result.solution.positions, result.support)[0]
    assert abs(row["heel_deg"]) == pytest.approx(180.0, abs=1e-6) or abs(row["trim_deg"]) > 90.0
    assert row["buoyancy_n"] == pytest.approx(row["weight_n"], rel=1e-8)


@pytest.mark.parametrize("above_m", [-3.0, 0.5, 3.0])
def test_a_frame_placed_far_from_the_surface_floats_as_one_placed_in_it(above_m):
    data = moored(0.5)
    for rope in data["rope"]:
        rope["length_m"] = max(rope["length_m"], 24.0 if rope["name"] != "line" else 0.0)
    right = frame_rows((result := solved(data)).built, result.solution.positions, result.support)[0]
    lift = np.array([0.0, 0.0, above_m])
    for table in (*data["float"], *(point for point in data["point"] if point.get("held") == "frame")):
        table["at"] = (lift + table["at"]).tolist()
    data["frame"] = {**data["frame"], "at": lift.tolist(), "centre": (lift + data["frame"]["centre"]).tolist()}
    row = frame_rows((result := solved(data)).built, result.solution.positions, result.support)[0]
    for key in ("x_m", "z_m", "heel_deg", "trim_deg", "yaw_deg", "buoyancy_n"):
        assert row[key] == pytest.approx(right[key], abs=1e-6)


def test_a_frame_moored_by_its_rear_turns_about_though_it_lay_in_balance():
    data = moored(0.5)
    data["rope"] = [rope for rope in data["rope"] if rope["name"] != "mooring b"]
    data["point"] = [point for point in data["point"] if point["name"] not in ("b", "B")]
    places = {"a": [2.0, 0.0, 0.0], "A": [-20.0, 0.0, -10.0]}
    data["point"] = [{**point, "at": places.get(point["name"], point["at"])} for point in data["point"]]
    row = frame_rows((result := solved(data)).built, result.solution.positions, result.support)[0]
    assert abs(row["yaw_deg"]) == pytest.approx(180.0, abs=1e-4)


@pytest.mark.parametrize("seed", range(8))
def test_random_frames_are_found_in_balance(seed):
    assert left_over(solved(random_frame(seed))) < WRONG


def test_a_floating_cage_in_a_current_is_held_by_its_anchors():
    result = solved(afloat(box(1.0, merged=10)))
    drag, held = pulls(result)
    assert held == pytest.approx(drag, rel=1e-8)
    assert balance_error(result) < 1e-8
    row = frame_rows(result.built, result.solution.positions, result.support)[0]
    # the current is along a plane of symmetry: no yaw, no heel, no way to the side
    assert (row["yaw_deg"], row["heel_deg"], row["y_m"] - 0.5) == pytest.approx((0.0, 0.0, 0.0), abs=1e-8)
    assert passage(result.built.problem, result.solution.positions) is None
    assert result_row(result)["contact_share"] > 0.0


@pytest.mark.parametrize("longer", [1.0, 1.05])
def test_netting_of_a_floating_cage_passes_through_itself_by_no_division_of_the_net_as_built(longer):
    data = afloat(box(1.5, merged=10))
    data["rope"][0]["length_m"] *= longer
    built = build(scene_from_dict(data))
    result = solve_scene(built)
    assert result.converged
    assert not crosses_itself(built, result.solution.positions)
    # netting that lies in folds is not quite its own mirror image
    row = frame_rows(result.built, result.solution.positions, result.support)[0]
    assert (abs(row["yaw_deg"]) > 1.0) == (longer > 1.0)
