"""Half a gear with its plane of symmetry moves as the whole: a small trawl of ropes, doors and one merged sheet."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from codend.scenes.build import BuiltScene, build
from codend.scenes.measures import solve_scene
from codend.scenes.scene import scene_from_dict
from codend.solvers.motion import Motion

MIRROR = np.array([1.0, -1.0, 1.0])
STEP_S, END_S = 0.02, 3.0


def gear(half: bool) -> BuiltScene:
    """Warps, doors and bridles on both sides, or on one, of a sheet between a headline with floats and a foot rope."""
    points, ropes = [], []
    for side, sign in (("a", 1.0), ("b", -1.0))[: 1 if half else 2]:
        door = {"mass_kg": 40.0, "wet_weight_n": 250.0, "added_mass_kg": 30.0, "area_m2": 0.3}
        points += [
            {"name": f"block {side}", "at": [0, sign * 1.0, 0], "held": "vessel"},
            {"name": f"door {side}", "at": [30, sign * 4.0, -6.0], "lift": 1.3, "drag": 0.6,
             "lift_towards": [0, sign, 0], **door},
            {"name": f"up {side}", "at": [39.0, sign * 2.5, -5.0], "mass_kg": 1.0, "wet_weight_n": -60.0},
            {"name": f"low {side}", "at": [39.0, sign * 2.5, -7.5], "mass_kg": 20.0, "wet_weight_n": 150.0},
        ]  # fmt: skip
        ropes += [
            {"name": f"warp {side}", "from": f"block {side}", "to": f"door {side}", "length_m": 31.0, "bars": 8},
            {"name": f"upper bridle {side}", "from": f"door {side}", "to": f"up {side}", "length_m": 9.5, "bars": 4},
            {"name": f"lower bridle {side}", "from": f"door {side}", "to": f"low {side}", "length_m": 9.5, "bars": 4},
        ]
    sheet = {"name": "sheet", "mesh": "diamond", "bar_mm": 50.0, "twine_mm": 2.0, "meshes_across": 100}
    sheet |= {"meshes_long": 60, "globalisation": 10, "axial_stiffness_n": 5000.0, "fore": "headline", "aft": "foot"}
    sheet |= {"corners": ["up b", "up a", "low a", "low b"]}
    head = {"name": "headline", "from": "up b", "to": "up a", "length_m": 6.0}
    foot = {"name": "foot", "from": "low b", "to": "low a", "length_m": 6.0, "mass_kg_m": 2.0}
    if half:
        for name, z in (("up b", -5.0), ("low b", -7.5)):
            points.append({"name": name, "at": [40.0, 0, z], "held": "symmetry"})
        sheet |= {"meshes_across": 50, "left": "symmetry"}
        head["length_m"] = foot["length_m"] = 3.0
    every = {"diameter_mm": 12.0, "mass_kg_m": 0.4}
    data = {"title": "trawl", "vessel": {"speed_m_s": 1.2}, "point": points, "netting": [sheet]}
    data["model"] = {"contact": False}  # how hard netting presses on itself goes by the mean tension of all bars
    return build(scene_from_dict({**data, "rope": [{**every, **rope} for rope in [*ropes, head, foot]]}))


def moving(built: BuiltScene, start: np.ndarray) -> Motion:
    """On its way from rest as seen from a vessel that speeds up, heaving."""
    path = lambda t: np.array([-0.05 * t * t, 0.0, 0.3 * np.sin(2.0 * t)])  # noqa: E731
    return Motion(built.problem, start, added_mass=built.added_mass, towed=built.towed, path=path)


def test_half_a_small_trawl_moves_as_the_whole_trawl():
    half, whole = gear(True), gear(False)
    rests = [solve_scene(built) for built in (half, whole)]
    assert all(rest.converged for rest in rests)
    rest, other = (rest.solution.positions for rest in rests)
    # nodes of the half beside which those of the whole lie, of which some are mirrored
    mirrored = other[:, 1] < -1e-6
    apart, like = cKDTree(rest).query(np.where(mirrored[:, None], MIRROR, 1.0) * other)
    assert apart.max() < 1e-6
    side = np.where(mirrored[:, None], MIRROR, 1.0)
    part, full = moving(half, rest), moving(whole, side * rest[like])
    for _ in range(round(END_S / STEP_S)):
        part.step(STEP_S)
        full.step(STEP_S)
    assert np.abs(full.position - rest[like] * side).max() > 0.4
    assert full.position == pytest.approx(side * part.position[like], abs=1e-8)
    pulls = [motion.support[built.towed].sum(axis=0) for motion, built in ((part, half), (full, whole))]
    assert pulls[1][[0, 2]] == pytest.approx(2.0 * pulls[0][[0, 2]], rel=1e-8)
