"""Scenes of ropes and points at rest: closed forms, other methods, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from codend.errors import InputError
from codend.scenes.build import build
from codend.scenes.measures import NOTHING_PULLS, cautions, point_rows, result_row, rope_rows, solve_scene
from codend.scenes.scene import scene_from_dict

WATER, SPEED, DIAMETER_M, NORMAL, TANGENTIAL, G = 1025.0, 1.8, 0.012, 1.36, 0.07, 9.80665
DRAG = 0.5 * WATER * SPEED**2 * DIAMETER_M * NORMAL
WET = (0.5 - WATER * np.pi * DIAMETER_M**2 / 4.0) * G
NEUTRAL_KG_M = WATER * np.pi * DIAMETER_M**2 / 4.0
WARP = {
    "from": "vessel",
    "to": "gear",
    "length_m": 100.0,
    "diameter_mm": 12.0,
    "mass_kg_m": 0.5,
    "normal": NORMAL,
    "tangential": TANGENTIAL,
}
GEAR = {"name": "gear", "mass_kg": 200.0, "wet_weight_n": 1500.0, "area_m2": 0.5, "drag": 1.0}


def tow(rope=(), gear=(), **tables):
    data = {"title": "A warp", "vessel": {"speed_m_s": SPEED}, "rope": [{**WARP, **dict(rope)}], **tables}
    return scene_from_dict({"point": [{**GEAR, **dict(gear)}], **data})


def solved(scene):
    result = solve_scene(build(scene))
    assert result.converged, result.solution.report.attempts
    return result


def along(angle, law, weight, friction):
    """Rates of tension and angle by the arc from the gear up (PHYSICS: LB99, then BM97)."""
    if law == "le-bris-1999":
        return weight * np.sin(angle) + friction * DRAG * np.cos(angle) ** 2, weight * np.cos(angle) - (
            DRAG * np.sin(angle) ** 2
        )
    share = friction / NORMAL
    return weight * np.sin(angle) + share * DRAG * np.cos(angle), weight * np.cos(angle) - DRAG * np.sin(angle)


def cable(law, weight, friction, length):
    """Tension and depth of a cable of ``length`` above the gear by scipy at 1e-10, an independent answer."""
    pull, down = 0.5 * WATER * SPEED**2 * 0.5, 1500.0
    start = [np.hypot(pull, down), np.arctan2(down, pull), 0.0, 0.0]

    def rates(_, state):
        tension, angle, _, _ = state
        by_length, turning = along(angle, law, weight, friction)
        return [by_length, turning / tension, np.cos(angle), np.sin(angle)]

    end = solve_ivp(rates, (0.0, length), start, "DOP853", rtol=1e-11, atol=1e-10).y[:, -1]
    return np.array([end[0], end[2], end[3]])


@pytest.mark.parametrize("mass_kg_m", [NEUTRAL_KG_M, 0.5], ids=["neutral", "heavy"])
@pytest.mark.parametrize(("law", "friction"), [("le-bris-1999", TANGENTIAL), ("bessonneau-1997", 0.1)])
def test_a_warp_takes_tension_and_shape_of_the_cable_equations_to_the_second_order(law, friction, mass_kg_m):
    weight = 0.0 if mass_kg_m == NEUTRAL_KG_M else WET
    right = cable(law, weight, friction, 100.0)

    def error(bars):
        built = solved(tow({"law": law, "tangential": friction, "mass_kg_m": mass_kg_m, "bars": bars}))
        gear, rope = point_rows(built)[1], rope_rows(built)[0]
        found = np.array([rope["tension_from_n"], gear["x_m"], -gear["z_m"]])
        return np.abs(found / right - 1.0)

    coarse, fine = error(100), error(400)
    assert fine.max() < 2e-6
    assert np.all(coarse[1:] > 12.0 * fine[1:])
    assert np.abs(coarse / 16.0).max() < 1e-5


def test_a_warp_without_weight_has_the_closed_forms_of_both_laws():
    # LB99: T = T0 exp(f [(a - a0) + cot a - cot a0]); BM97: T sin^f a = const
    for law, friction in (("le-bris-1999", 0.07), ("bessonneau-1997", 0.1)):
        result = solved(tow({"law": law, "tangential": friction, "mass_kg_m": NEUTRAL_KG_M, "bars": 2000}))
        tension, places = result.solution.bar_tension, result.solution.positions
        d = -np.diff(places[result.built.rope_nodes[0]], axis=0)
        angle = np.arctan2(d[:, 2], -d[:, 0])
        if law == "le-bris-1999":
            constant = np.log(tension) - friction * (angle + 1.0 / np.tan(angle))
        else:
            constant = np.log(tension) + friction / NORMAL * np.log(np.sin(angle))
        assert np.ptp(constant) < 1e-6


@pytest.mark.parametrize("law", ["le-bris-1999", "bessonneau-1997"])
def test_a_warp_with_nothing_at_its_end_lies_at_the_critical_angle(law):
    scene = tow({"law": law}, {"mass_kg": 0.0, "wet_weight_n": 0.0, "drag": 0.0, "area_m2": 0.0})
    gear = point_rows(solved(scene))[1]
    angle, k = np.arctan2(-gear["z_m"], gear["x_m"]), WET / (2.0 * DRAG)
    right = np.arccos(np.hypot(1.0, k) - k) if law == "le-bris-1999" else np.arctan(2.0 * k)
    assert angle == pytest.approx(right, abs=1e-9)


def test_a_chain_on_the_seabed_hangs_free_as_far_as_the_catenary_says():
    # suspended length sqrt(z^2 + 2 a z), a = H / w
    depth, span = 20.0, 90.0
    rope = {"from": "buoy", "to": "anchor", "length_m": 96.0, "bars": 960, "normal": 0.0, "mass_kg_m": 5.0}
    points = [
        {"name": "buoy", "at": [0, 0, 0], "held": "ground"},
        {"name": "anchor", "at": [span, 0, -depth], "held": "ground"},
    ]
    scene = scene_from_dict({"title": "m", "rope": [{**WARP, **rope}], "point": points, "seabed": {"depth_m": depth}})
    result = solved(scene)
    pull = -point_rows(result)[0]["force_x_n"]
    weight = (5.0 - NEUTRAL_KG_M) * G
    a = pull / weight
    lifted = np.sqrt(depth**2 + 2.0 * a * depth)
    # what lies on the ground and what hangs reach from the anchor to the buoy
    assert a * np.arccosh(1.0 + depth / a) + 96.0 - lifted == pytest.approx(span, abs=2e-2)
    on_ground = result.solution.positions[:, 2] < -depth + 1e-4
    assert 0.1 * on_ground.sum() == pytest.approx(96.0 - lifted, abs=0.5)


def test_what_holds_a_scene_carries_all_its_loads():
    result = solved(tow({"normal": 0.0}))
    row = result_row(result)
    vessel = point_rows(result)[0]
    assert vessel["force_x_n"] == pytest.approx(-0.5 * WATER * SPEED**2 * 0.5, rel=1e-9)
    assert vessel["force_z_n"] == pytest.approx(1500.0 + 100.0 * WET, rel=1e-9)
    assert row["pull_n"] == pytest.approx(vessel["force_n"])
    assert rope_rows(result)[0]["tension_from_n"] == pytest.approx(row["pull_n"], rel=1e-5)


def test_ropes_never_push():
    # a strut beneath a weight hangs beside it, slack, and the other rope carries all
    strut = {"from": "post", "to": "gear", "length_m": 30.0, "normal": 0.0, "bars": 10, "mass_kg_m": NEUTRAL_KG_M}
    rope = {"from": "hook", "to": "gear", "length_m": 10.0, "normal": 0.0, "bars": 10, "mass_kg_m": NEUTRAL_KG_M}
    points = [
        {"name": "hook", "at": [0, 0, 0], "held": "ground"},
        {"name": "post", "at": [0, 0, -20.0], "held": "ground"},
        {"name": "gear", "mass_kg": 50.0, "wet_weight_n": 400.0, "at": [1.0, 0, -9.0]},
    ]
    scene = scene_from_dict({"title": "s", "rope": [{**WARP, **rope}, {**WARP, **strut}], "point": points})
    first, second = rope_rows(solved(scene))
    assert first["tension_to_n"] == pytest.approx(400.0, rel=1e-6)
    assert second["max_tension_n"] < 1e-3
    assert second["min_tension_n"] >= 0.0


def test_a_door_spreads_by_the_lift_of_its_table(tmp_path):
    table = tmp_path / "door.csv"
    table.write_text("# assumed\nattack_deg,lift,drag\n0,0,0.2\n40,1.2,0.8\n")
    door = {"table": "door.csv", "attack_deg": 30.0, "lift_towards": [0, 1, 0], "area_m2": 0.75}
    gear = {key: value for key, value in {**GEAR, **door, "wet_weight_n": 0.0}.items() if key != "drag"}
    rope = {**WARP, "normal": 0.0, "mass_kg_m": NEUTRAL_KG_M}
    data = {"title": "d", "vessel": {"speed_m_s": SPEED}, "rope": [rope], "point": [gear]}
    found = point_rows(solved(scene_from_dict(data, tmp_path / "scene.toml")))[1]
    assert found["y_m"] / found["x_m"] == pytest.approx(0.9 / 0.65, rel=1e-9)
    gear["attack_deg"] = 45.0
    with pytest.raises(InputError, match=r"point\.0\.attack_deg = 45.0 .* from 0 to 40"):
        scene_from_dict({**data, "point": [gear]}, tmp_path / "scene.toml")


def test_a_profile_of_the_current_stands_in_for_an_even_one():
    even = point_rows(solved(tow()))[1]
    layers = [{"depth_m": 0.0, "flow_m_s": [0.8, 0, 0]}, {"depth_m": 200.0, "flow_m_s": [0.8, 0, 0]}]
    layered = point_rows(solved(tow(vessel={"speed_m_s": 1.0}, water={"profile": layers})))[1]
    assert layered["z_m"] == pytest.approx(even["z_m"], rel=1e-9)
    layers[1]["flow_m_s"] = [0.4, 0, 0]
    assert point_rows(solved(tow(vessel={"speed_m_s": 1.0}, water={"profile": layers})))[1]["z_m"] < even["z_m"]


def test_cautions_name_the_law_and_what_floats_above_the_surface():
    notes = cautions(solved(tow(gear={"wet_weight_n": -3000.0})))
    assert any("le-bris-1999" in note for note in notes)
    assert any("above the surface" in note for note in notes)


def test_a_scene_in_which_nothing_pulls_leaves_nothing_over_and_says_so():
    still = {"vessel": {}, "water": {"density_kg_m3": WATER}}
    result = solved(tow({"mass_kg_m": NEUTRAL_KG_M}, {"wet_weight_n": 0.0}, **still))
    assert result_row(result)["balance_error"] == 0.0
    assert NOTHING_PULLS in cautions(result)
    assert NOTHING_PULLS not in cautions(solved(tow()))


@pytest.mark.parametrize(("stiffness_n", "told"), [(1e3, True), (1e6, False)])
def test_a_rope_that_stretches_as_no_rope_does_is_told(stiffness_n, told):
    notes = cautions(solved(tow({"axial_stiffness_n": stiffness_n})))
    assert any("look at its axial_stiffness_n" in note for note in notes) is told


HELD = {"name": "gear", "held": "ground", "at": [0, 0, -10]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rope": [{**WARP, "length_m": -1.0}]}, "rope.0.length_m = -1.0 is not allowed; allowed: a number above 0"),
        ({"rope": [{**WARP, "to": "door"}]}, 'rope.0.to = "door" is not allowed; allowed: the name of a point: gear'),
        ({"rope": [{k: v for k, v in WARP.items() if k != "from"}]}, "rope.0.from is missing"),
        ({"rope": [{**WARP, "lenght_m": 3.0}]}, "did you mean length_m?"),
        ({"point": [GEAR, GEAR]}, "point.1.name"),
        ({"point": [{**GEAR, "at": [1.0, 2.0]}]}, "point.0.at.2 is missing; allowed: a list of 3, each a number"),
        ({"point": [{**GEAR, "at": 1.0}]}, "point.0.at = 1.0 is not allowed; allowed: a list of 3, each a number"),
        ({"point": [{**GEAR, "density_kg_m3": 7850.0}]}, "contradicts wet_weight_n"),
        ({"point": [{**GEAR, "held_from_s": 5.0}], "time": {"end_s": 9.0, "output_s": 1.0}}, "axial_stiffness_n is"),
        (
            {"point": [{"name": "gear", "mass_kg": 9.0}]},
            "point.0.wet_weight_n is missing; allowed: given beside mass_kg",
        ),
        ({"point": [{"name": "gear", "area_m2": 0.5}]}, "point.0.drag is missing; allowed: given beside area_m2"),
        ({"point": [HELD]}, "point.0.held"),
        ({"vessel": {"speed_m_s": 1.0, "heave_m": 1.0}}, "vessel.period_s is missing"),
        ({"time": {"end_s": 10.0, "output_s": 6.0}}, "time.end_s = 10.0 is not allowed; allowed: a whole number"),
        ({"vessel": {"speed_m_s": 1.0, "period_s": 6.0}}, "vessel.heave_m is missing"),
        (
            {
                "vessel": {"heave_m": 1.0, "period_s": 0.02},
                "time": {"end_s": 1.0, "output_s": 0.5, "step_s": 0.02},
            },
            "time.step_s = 0.02 is not allowed; allowed: at most 0.001",
        ),
        (
            {"vessel": {"at": [0.0, 0.0, -120.0]}, "seabed": {"depth_m": 100.0}},
            "not below the seabed, 100 m deep",
        ),
        (
            {
                "rope": [{**WARP, "axial_stiffness_n": 1e6}],
                "point": [{**GEAR, "held_from_s": 9.0}],
                "time": {"end_s": 9.0, "output_s": 1.0},
            },
            "held_from_s = 9.0 is not allowed; allowed: below time.end_s, 9",
        ),
        ({"time": {"end_s": 1.0, "output_s": 2.0}}, "time.output_s = 2.0 is not allowed; allowed: at most 1, end_s"),
        ({"seabed": {"depth_m": 0.0}}, "seabed.depth_m"),
        (
            {"point": [{**GEAR, "at": [99.0, 0.0, 0.0], "held": "symmetry"}], "water": {"flow_m_s": [0.0, 0.5, 0.0]}},
            'water.flow_m_s = [0.0, 0.5, 0.0] is not allowed; allowed: [x, 0, z] beside what is held by "symmetry"',
        ),
        (
            {
                "point": [{**GEAR, "at": [99.0, 0.0, 0.0], "held": "symmetry"}],
                "water": {"profile": [{"depth_m": 0.0, "flow_m_s": [0.1, 0.2, 0.0]}]},
            },
            "water.profile.0.flow_m_s = [0.1, 0.2, 0.0] is not allowed",
        ),
    ],
)
def test_mistakes_are_one_line_with_the_key(change, message):
    data = {"title": "A warp", "vessel": {"speed_m_s": SPEED}, "rope": [WARP], "point": [GEAR], **change}
    with pytest.raises(InputError) as refused:
        scene_from_dict(data, "scene.toml")
    assert any(message in line for line in refused.value.lines), refused.value.lines
    assert all(line.startswith("scene.toml: ") for line in refused.value.lines)


def test_a_rope_too_short_for_its_held_ends_is_refused():
    data = {"title": "A", "vessel": {}, "rope": [{**WARP, "length_m": 5.0}], "point": [HELD]}
    with pytest.raises(InputError, match=r"rope\.0\.length_m = 5\.0 .* above 10"):
        scene_from_dict(data)
    stretched = {**data, "rope": [{**WARP, "length_m": 9.9, "axial_stiffness_n": 1e5}]}
    assert rope_rows(solved(scene_from_dict(stretched)))[0]["tension_to_n"] == pytest.approx(1e5 / 99.0, rel=3e-2)
