"""What is told of a scene's frame: where it is, what pulls at it, what holds it, and how deep its floats lie."""

from typing import Any

import numpy as np

from codend.mechanics import body as rigid
from codend.mechanics.body import Body, Pose
from codend.net.net import Floats
from codend.scenes.build import BuiltScene
from codend.scenes.frame import prism_of
from codend.scenes.frame_tables import FRAME

COLUMNS = 4
"""Columns of a float."""


def frame_rows(built: BuiltScene, positions: Floats, support: Floats) -> list[dict[str, Any]]:
    """The row of ``frame.csv``; none of a scene without a frame.

    Args:
        built: the scene.
        positions: of its nodes, (n, 3), m.
        support: what holds them, (n, 3), N: of the frame's nodes, what the frame holds them with.
    """
    body, frame = built.frame, built.scene.frame
    if body is None or frame is None:
        return []
    pose = rigid.pose_of(body, positions)
    pull, own = pulls_on(body, pose, support), rigid.load(body, pose)
    heel, trim, yaw = rigid.attitude_deg(pose.turn)
    row = {"name": FRAME, "hold": frame.hold, **_xyz("{}_m", pose.origin)}
    row |= {"heel_deg": heel, "trim_deg": trim, "yaw_deg": yaw, "mass_kg": body.mass_kg, "weight_n": body.weight_n}
    row |= {"buoyancy_n": float(own[2] + body.weight_n), **_xyz("pull_{}_n", pull[:3])}
    row |= {**_xyz("moment_{}_n_m", pull[3:]), **_xyz("force_{}_n", -(pull + own)[:3])}
    return [row | _xyz("holding_moment_{}_n_m", -(pull + own)[3:])]


def float_rows(built: BuiltScene, positions: Floats) -> list[dict[str, Any]]:
    """A row for every float, for ``floats.csv``."""
    body, frame = built.frame, built.scene.frame
    if body is None or frame is None:
        return []
    pose = rigid.pose_of(body, positions)
    lift = rigid.buoyancies(body, rigid.immersed(body, pose))
    rows = []
    for number, table in enumerate(built.scene.floats):
        prism = prism_of(table, frame)
        foot = pose.origin + pose.turn @ prism.foot
        own = float(lift[COLUMNS * number : COLUMNS * (number + 1)].sum())
        volume = own / (body.water_density * rigid.GRAVITY_M_S2)
        share = volume / (prism.area_m2 * prism.height_m)
        row = {"name": table.name, **_xyz("{}_m", foot), "waterplane_m2": prism.area_m2, "draft_m": float(-foot[2])}
        rows.append(row | {"immersed_m3": volume, "immersed_share": share, "buoyancy_n": own})
    return rows


def pulls_on(body: Body, pose: Pose, support: Floats) -> Floats:
    """Force of netting, ropes and points on the frame, and its moment about the frame's origin, (6,), N and N m."""
    on_nodes = -support[body.nodes]
    return np.concatenate([on_nodes.sum(axis=0), np.cross(rigid.arms_now(body, pose), on_nodes).sum(axis=0)])


def frame_cautions(built: BuiltScene, positions: Floats) -> list[str]:
    """What a reader must know of how the floats lie in the water."""
    body, frame = built.frame, built.scene.frame
    if body is None or frame is None or not built.scene.afloat:
        return []
    if not np.isfinite(positions).all():
        return _why_it_may_not_float(built, body)
    found = ["The frame floats on a level surface, without waves."]
    turn = rigid.pose_of(body, positions).turn
    if turn[2, 2] < 0.0:
        found.append("The frame floats on its head: it would not stay upright, or was placed far from how it floats.")
    for table, row in zip(built.scene.floats, float_rows(built, positions), strict=True):
        sides = prism_of(table, frame).sides_m
        if sides:
            reach = 0.5 * float(np.abs(turn[2, :2]) @ sides)
        else:
            reach = 0.5 * float(np.hypot(*turn[2, :2])) * (table.diameter_m or 0.0)
        foot, top = -row["draft_m"], -row["draft_m"] + turn[2, 2] * table.height_m
        if foot >= reach:
            found.append(f"Float {table.name} is out of the water.")
        elif top <= -reach:
            found.append(f"Float {table.name} is under water, and carries no more however deep it goes.")
        elif foot > -reach or top < reach:
            found.append(f"The surface crosses the foot or top of float {table.name}: its lift is an approximation.")
    return found


def _why_it_may_not_float(built: BuiltScene, body: Body) -> list[str]:
    """What of a frame for which no equilibrium was found speaks against one near to where it is placed."""
    most = rigid.GRAVITY_M_S2 * body.carries_kg
    found = []
    if body.weight_n >= most:
        weighs = f"weighs {body.weight_n:.4g} N in air"
        found.append(f"The floats carry at most {most:.4g} N, and the frame with them {weighs}.")
    net, scene = built.problem.net, built.scene
    for table, name, nodes in zip(scene.rope, scene.rope_names, built.rope_nodes, strict=True):
        ends = nodes[[0, -1]]
        apart = float(np.linalg.norm(np.diff(net.positions[ends], axis=0)))
        if table.axial_stiffness_n is None and net.fixed[ends].all() and apart >= table.length_m:
            found.append(f"Rope {name} is {table.length_m:g} m long, and its ends are placed {apart:.4g} m apart.")
    return found


def _xyz(name: str, values: Floats) -> dict[str, float]:
    return {name.format(axis): float(value) for axis, value in zip("xyz", values, strict=True)}
