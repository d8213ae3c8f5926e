"""The floating cage of figure 19 in time, and its picture. ``python -m validation.floating_cage [PICTURE.png]``.

The scene is ``validation/examples/floating_cage.toml``, what is assumed of it told there. Followed from its cubic
shape; where it comes to rest its moorings hold what the water pulls it with, which is printed.
"""

import sys
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from codend.mechanics.body import attitude_deg, pose_of
from codend.net.net import Floats
from codend.report.style import BLUE, INK, ORANGE, PALE, new_figure, png
from codend.scenes.build import BuiltScene, build
from codend.scenes.follow import follow
from codend.scenes.frame import prism_of
from codend.scenes.netting_measures import drag_of
from codend.scenes.scene import load_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCENE = Path(__file__).parent / "examples" / "floating_cage.toml"
TIMES_S = (0.0, 0.5, 1.5, 12.0)
DEEPER = np.array([[1.0, 0.0], [0.45, 0.22], [0.0, 1.0]])
"""Where a step along x, y and z is seen, right and up."""


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
