"""The floating cage of figure 19, found directly and in time. ``python -m validation.floating_cage [PICTURE.png]``.

First the cage of ``validation.cage``, of 4 x 4 merged meshes a wall, on a frame that floats on moorings, directly at
several speeds. Then ``validation/examples/floating_cage.toml``, what is assumed of it told there, followed from its
cubic shape; where it comes to rest is printed beside the equilibrium that is found directly.
"""

import sys
from io import BytesIO
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from codend.mechanics.body import attitude_deg, pose_of
from codend.net.net import Floats
from codend.report.style import BLUE, INK, ORANGE, PALE, new_figure, png
from codend.scenes.build import BuiltScene, build
from codend.scenes.follow import follow
from codend.scenes.frame import prism_of
from codend.scenes.frame_measures import frame_rows
from codend.scenes.measures import SceneResult, result_row, solve_scene
from codend.scenes.netting_measures import drag_of
from codend.scenes.scene import load_scene, scene_from_dict
from validation.cage.gear import box

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCENE = Path(__file__).parent / "examples" / "floating_cage.toml"
TIMES_S = (0.0, 0.5, 1.5, 12.0)
DEEPER = np.array([[1.0, 0.0], [0.45, 0.22], [0.0, 1.0]])
"""Where a step along x, y and z is seen, right and up."""


BEAMS = (("front", 0.0, 0.5, 0.15, 1.15), ("rear", 1.0, 0.5, 0.15, 1.15), ("left", 0.5, 0.0, 0.85, 0.15),
         ("right", 0.5, 1.0, 0.85, 0.15))  # fmt: skip
"""Of the frame: name, middle x and y, length and width, m."""
SPEEDS_M_S = (0.0, 0.3, 0.6, 1.0)


def afloat(cage: dict[str, Any]) -> dict[str, Any]:
    """A box of ``validation.cage.gear`` with its frame of 8 kg on four beams and four moorings, all of it assumed."""
    floats = [
        {"name": f"{name} beam", "at": [x, y, -0.035], "length_m": long, "width_m": wide, "height_m": 0.2}
        for name, x, y, long, wide in BEAMS
    ]
    points, ropes = list(cage["point"]), list(cage.get("rope", []))
    for number, (x, y) in enumerate(((0, 0), (0, 1), (1, 1), (1, 0)), start=1):
        anchor = {"name": f"anchor {number}", "at": [7.0 * x - 3.0, 4.0 * y - 1.5, -2.0], "held": "ground"}
        rope = {"name": f"mooring {number}", "from": f"top {number}", "to": anchor["name"], "length_m": 4.2}
        points.append(anchor)
        ropes.append({**rope, "diameter_mm": 6.0, "mass_kg_m": 0.05, "bars": 10})
    frame = {**cage["frame"], "hold": "floating", "at": [0.5, 0.5, 0.0], "mass_kg": 8.0}
    return {**cage, "frame": frame, "float": floats, "point": points, "rope": ropes}


def pulls(result: SceneResult) -> tuple[float, float]:
    """Drag of all netting and ropes, and what the anchors hold along x, N."""
    bars = np.ones(len(result.solution.bar_tension), dtype=bool)
    anchors = [node for name, node in result.built.node_of.items() if name.startswith("anchor")]
    drag = drag_of(result.built, result.solution.positions, bars)[0]
    return float(drag), float(-result.support[anchors, 0].sum())


def directly(merged: int = 10) -> None:
    """Print the equilibria of the paper's cage afloat, of ``merged`` meshes in one."""
    print("speed m/s   found   drift m   trim deg   yaw deg   drag N   anchors N   volume m3   s")
    for speed in SPEEDS_M_S:
        built, start = build(scene_from_dict(afloat(box(speed, merged=merged)))), process_time()
        result = solve_scene(built)
        spent = process_time() - start
        if not result.converged:
            print(f"{speed:9.1f}   {result.solution.report.outcome.value}")
            continue
        row = frame_rows(result.built, result.solution.positions, result.support)[0]
        drag, held = pulls(result)
        print(
            f"{speed:9.1f}{'yes':>8s}{row['x_m'] - 0.5:10.4f}{row['trim_deg']:11.3f}{row['yaw_deg']:10.1e}{drag:9.3f}"
            f"{held:12.3f}{result_row(result)['volume_m3']:12.4f}{spent:6.1f}"
        )


def drawn(axes: "Axes", built: BuiltScene, positions: Floats) -> None:
    """Netting, its seams, moorings and floats, seen from a side and above."""
    from matplotlib.collections import LineCollection

    seen, net = positions @ DEEPER, built.problem.net
    own = built.bar_sheet >= 0
    axes.axhline(0.0, color=PALE, lw=1.0, zorder=0)
    axes.add_collection(LineCollection(list(seen[net.bars[own]]), colors=BLUE, linewidths=0.4, alpha=0.7))
    axes.add_collection(LineCollection(list(seen[net.bars[~own]]), colors=INK, linewidths=0.9))
    for table, nodes in zip(built.scene.netting, built.sheet_nodes, strict=True):
        for edge in table.sheet.edges.values():
            axes.plot(*seen[nodes[edge.knots]].T, color=BLUE, lw=1.2)
    body = built.frame
    assert body is not None
    pose = pose_of(body, positions)
    assert built.scene.frame is not None
    for table in built.scene.floats:
        prism = prism_of(table, built.scene.frame)
        assert prism.sides_m is not None
        corners = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) * [*prism.sides_m, 0.0] / 2.0
        foot = pose.origin + (prism.foot + corners) @ pose.turn.T
        top = foot + prism.height_m * pose.turn[:, 2]
        for ring in (foot, top):
            axes.fill(*(ring @ DEEPER).T, facecolor=ORANGE, alpha=0.35, lw=0.0)
            axes.plot(*(np.concatenate([ring, ring[:1]]) @ DEEPER).T, color=ORANGE, lw=0.9)
        axes.add_collection(LineCollection(list(np.stack([foot, top], axis=1) @ DEEPER), colors=ORANGE, linewidths=0.9))


def main() -> None:
    """Print the motion and where it ends; write the picture if it is asked for."""
    directly()
    built = build(load_scene(SCENE))
    body = built.frame
    assert body is not None
    shapes = {}
    print("  time s   frame x m    z m   trim deg   moorings N")
    for frame in follow(built, built.problem.net.positions):
        pose = pose_of(body, frame.positions)
        pulls = [frame.bar_tension[bars].max() for bars in built.rope_bars]
        if frame.time_s in TIMES_S:
            shapes[frame.time_s] = frame.positions
        if frame.number % 4 == 0:
            trim = attitude_deg(pose.turn)[1]
            print(f"{frame.time_s:8.2f}{pose.origin[0]:12.4f}{pose.origin[2]:7.4f}{trim:11.3f}   ", *np.round(pulls, 2))
    anchors = [built.node_of[f"anchor {number}"] for number in range(1, 5)]
    drag = drag_of(built, frame.positions, np.ones(len(frame.bar_tension), dtype=bool))[0]
    print(f"drag {drag:.3f} N, held by the anchors with {-frame.support[anchors, 0].sum():.3f} N")
    result = solve_scene(build(load_scene(SCENE, ["time.start=equilibrium"])))
    rest = frame_rows(result.built, result.solution.positions, result.support)[0] if result.converged else {}
    print("directly:", ", ".join(f"{key} {rest[key]:.4f}" for key in ("x_m", "z_m", "trim_deg") if key in rest))
    if len(sys.argv) > 1:
        from PIL import Image

        figure = new_figure(7.5, 4.6)
        for axes, (time_s, positions) in zip(figure.subplots(2, 2).ravel(), shapes.items(), strict=True):
            drawn(axes, built, positions)
            axes.set_title(f"{time_s:g} s", color=INK, fontsize=10)
            axes.set(xlim=(-1.6, 1.9), ylim=(-1.4, 0.5), aspect="equal")
            axes.axis("off")
        image = Image.open(BytesIO(png(figure))).convert("RGB").quantize(24)
        image.save(sys.argv[1], optimize=True)


if __name__ == "__main__":
    main()
