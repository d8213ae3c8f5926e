"""A scene in figures: its shape from the side and from above, depths and tensions in time, and its motion as a film."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from codend.mechanics.body import pose_of
from codend.net.net import Floats
from codend.report.style import BLUE, INK, ORANGE, PALE, dress, new_figure, ordered_colours
from codend.report.vtk import read_nodes
from codend.scenes.build import BuiltScene
from codend.scenes.frame import prism_of
from codend.scenes.frame_tables import FRAME

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

MOST_FRAMES = 60
MOST_NAMES = 16
"""Points that are named in a figure: of more, names would lie on each other."""
FRAME_MS = 80


def scene_figure(built: BuiltScene, positions: Floats) -> "Figure":
    """Ropes, netting and points from the side, and from above where they leave the plane of the tow."""
    flat = np.ptp(positions[:, 1]) < 1e-6 * max(np.ptp(positions), 1.0)
    figure = new_figure(9.0, 4.2 if flat else 7.4)
    axes = figure.subplots(1 if flat else 2, 1, squeeze=False, sharex=True)[:, 0]
    for panel, coordinate, words in zip(axes, (2, 1), ("height (m)", "to the side (m)"), strict=False):
        panel.add_collection(_netting(built, positions, coordinate))
        for rope, nodes in enumerate(built.rope_nodes):
            panel.plot(*positions[nodes][:, [0, coordinate]].T, color=INK, lw=1.4)
            if coordinate == 2 and len(built.rope_nodes) <= 8:
                middle = positions[nodes[len(nodes) // 2]]
                name = built.scene.rope_names[rope]
                panel.annotate(name, middle[[0, 2]], (6, 6), textcoords="offset points", color=BLUE, fontsize=8)
        for corners in _floats(built, positions, coordinate):
            panel.fill(*corners.T, facecolor=PALE, edgecolor=INK, lw=0.8, zorder=1)
        for name, node in built.node_of.items():
            held = name in built.held
            x, up = positions[node, 0], positions[node, coordinate]
            panel.plot(x, up, "s" if held else "o", color=INK if held else ORANGE, ms=5)
            if len(built.node_of) <= MOST_NAMES:
                panel.annotate(name, (x, up), (6, -11), textcoords="offset points", color=INK, fontsize=8)
        panel.set_ylabel(words)
        dress(panel)
    axes[-1].set_xlabel("aft of the vessel (m)" if built.scene.vessel is not None else "along x (m)")
    _levels(axes[0], built)
    return figure


def _floats(built: BuiltScene, positions: Floats, coordinate: int) -> list[Floats]:
    """Outlines of a frame's floats from the side or from above, each (k, 2)."""
    from scipy.spatial import ConvexHull

    body, frame = built.frame, built.scene.frame
    if body is None or frame is None:
        return []
    pose, found = pose_of(body, positions), []
    for table in built.scene.floats:
        prism = prism_of(table, frame)
        round_it = np.linspace(0.0, 2.0 * np.pi, 40)
        section = np.stack([np.cos(round_it), np.sin(round_it)], axis=1) * 0.5 * (table.diameter_m or 0.0)
        if prism.sides_m:
            section = 0.5 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * prism.sides_m
        own = [prism.foot + np.array([*corner, height]) for corner in section for height in (0.0, prism.height_m)]
        seen = (pose.origin + np.array(own) @ pose.turn.T)[:, [0, coordinate]]
        found.append(seen[ConvexHull(seen).vertices])
    return found


def motion_figure(built: BuiltScene, table: "pd.DataFrame") -> "Figure":
    """Depth of the free points and tension of the ropes against time."""
    figure = new_figure(9.0, 6.4)
    depth, tension = figure.subplots(2, 1, sharex=True)
    free = [name for name in built.node_of if name not in built.held or (name == FRAME and built.scene.afloat)]
    _lines(depth, table, free, "z_m")
    _lines(tension, table, built.scene.rope_names, "tension_n")
    depth.set_ylabel("height (m)")
    tension.set_ylabel("largest tension (N)")
    tension.set_ylim(bottom=0.0)
    tension.set_xlabel("time (s)")
    return figure


def film(built: BuiltScene, files: Sequence[Path], times_s: Sequence[float]) -> bytes:
    """Files of the motion, evenly chosen, as an animated GIF of the side view."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    chosen = np.unique(np.linspace(0, len(files) - 1, min(len(files), MOST_FRAMES)).round().astype(int))
    shapes = [read_nodes(files[number]) for number in chosen]
    low, high = np.min([s.min(axis=0) for s in shapes], axis=0), np.max([s.max(axis=0) for s in shapes], axis=0)
    figure = new_figure(7.0, 4.0)
    figure.set_dpi(90)
    axes = figure.subplots()
    room = 0.04 * np.maximum(high - low, 1e-3 * np.ptp([low, high]))
    axes.set(xlim=(low[0] - room[0], high[0] + room[0]), ylim=(low[2] - room[2], high[2] + room[2]))
    axes.set_xlabel("x (m)")
    axes.set_ylabel("height (m)")
    dress(axes)
    _levels(axes, built)
    netting = _netting(built, shapes[0], 2)
    axes.add_collection(netting)
    lines = [axes.plot([], [], color=INK, lw=1.4)[0] for _ in built.rope_nodes]
    (points,) = axes.plot([], [], "o", color=ORANGE, ms=4)
    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    images = []
    for number, shape in zip(chosen, shapes, strict=True):
        netting.set_segments(_segments(built, shape, 2))
        for line, nodes in zip(lines, built.rope_nodes, strict=True):
            line.set_data(shape[nodes, 0], shape[nodes, 2])
        points.set_data(*shape[list(built.node_of.values())][:, [0, 2]].T)
        axes.set_title(f"{times_s[number]:.4g} s", color=INK, fontsize=9)
        canvas.draw()
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3].copy()).quantize(32))
    written = BytesIO()
    images[0].save(written, "GIF", save_all=True, append_images=images[1:], duration=FRAME_MS, loop=0)
    return written.getvalue()


def _segments(built: BuiltScene, positions: Floats, coordinate: int) -> list[Floats]:
    """Bars of the netting as seen from the side or from above, (k, 2, 2)."""
    return list(positions[built.problem.net.bars[built.bar_sheet >= 0]][:, :, [0, coordinate]])


def _netting(built: BuiltScene, positions: Floats, coordinate: int) -> "LineCollection":
    from matplotlib.collections import LineCollection

    return LineCollection(_segments(built, positions, coordinate), colors=BLUE, linewidths=0.4, alpha=0.6)


def _levels(axes: "Axes", built: BuiltScene) -> None:
    axes.axhline(0.0, color=PALE, lw=1.0, zorder=0)
    if built.scene.seabed is not None:
        axes.axhline(-built.scene.seabed.depth_m, color=ORANGE, lw=1.0, zorder=0)


def _lines(axes: "Axes", table: "pd.DataFrame", names: Sequence[str], column: str) -> None:
    for name, colour in zip(names, ordered_colours(len(names)), strict=True):
        rows = table[table["name"] == name]
        axes.plot(rows["time_s"], rows[column], color=colour, lw=1.3, label=name)
    if names:
        axes.legend(frameon=False, fontsize=8)
    dress(axes)
