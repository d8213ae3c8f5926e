"""Charts of error against time: a panel a scene, a colour a method, a marker a model."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from codend.report.style import BLUE, INK, ORANGE, PALE, dress, new_figure
from codend.studies.speed_accuracy.contenders import (
    FULL,
    KINETIC,
    MEMBRANE,
    MERGED,
    MERIDIAN,
    NEWTON,
    RIGID,
    SECTOR,
    VISCOUS,
)
from codend.studies.speed_accuracy.front import pareto_front
from codend.studies.speed_accuracy.measuring import CLOSED_FORM, Measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {
    NEWTON: BLUE,
    KINETIC: ORANGE,
    VISCOUS: "#e69f00",
    RIGID: "#9b4f96",
    MERIDIAN: "#009e73",
    CLOSED_FORM: "#009e73",
}
MARKERS = {SECTOR: "o", MERGED: "s", FULL: "^", MEMBRANE: "D"}
MODEL_NAMES = {
    SECTOR: "sector of the real net",
    MERGED: "full net, g x g meshes merged",
    FULL: "full net, every mesh",
    MEMBRANE: "membrane (hollow: closed form)",
}
WORDS = {"drag": "drag", "opening": "opening ahead of the catch", "volume": "catch volume"}
SPAN_MS = (0.1, 3e5)
TICKS_MS = {0.1: "0.1 ms", 1.0: "1 ms", 10.0: "10 ms", 100.0: "0.1 s", 1e3: "1 s", 1e4: "10 s", 1e5: "100 s"}
LOWEST = 1e-11
"""Where answers are drawn that differ from the reference by less, or not at all."""


def speed_figure(measured: tuple[Measured, ...], quantity: str) -> "Figure":
    """Error in a quantity against solve time, with the Pareto front of every scene."""
    figure = new_figure(max(4.2 * len(measured), 9.5), 5.4)
    panels = figure.subplots(1, len(measured), sharey=True, sharex=True, squeeze=False)[0]
    for axes, of_scene in zip(panels, measured, strict=True):
        _panel(axes, of_scene, quantity)
    panels[0].set_ylabel(f"relative error in {WORDS[quantity]}", color=INK)
    panels[len(panels) // 2].set_xlabel("solve time from nothing, first guess included", color=INK)
    _key(figure, {method for of_scene in measured for method in of_scene.points["method"]})
    return figure


def _panel(axes: "Axes", measured: Measured, quantity: str) -> None:
    points, resolved = measured.points, measured.resolved[quantity]
    axes.set_title(measured.scene.name, color=INK, fontsize=11)
    axes.loglog()
    axes.set_xlim(*SPAN_MS)
    axes.set_xticks(list(TICKS_MS), labels=list(TICKS_MS.values()))
    axes.set_ylim(LOWEST / 20.0, 2.0)
    dress(axes)
    if np.isfinite(resolved):
        axes.axhspan(LOWEST / 20.0, resolved, color=PALE, alpha=0.5, linewidth=0.0)
        agreed = "below what two methods agree on"
        axes.text(0.985, 0.02, agreed, transform=axes.transAxes, ha="right", fontsize=8, color=INK)
    _join_merged(axes, points, f"{quantity}_error")
    _draw_front(axes, points, f"{quantity}_error", resolved)
    for (method, model), group in points.groupby(["method", "model"], sort=False):
        error = np.maximum(group[f"{quantity}_error"], LOWEST)
        hollow = method == CLOSED_FORM
        axes.plot(
            group["solve_ms"],
            error,
            linestyle="-" if model in (SECTOR, MEMBRANE) else "none",
            linewidth=0.8,
            marker=MARKERS[str(model)],
            markersize=6.5,
            markerfacecolor="white" if hollow else COLOURS[str(method)],
            markeredgecolor=COLOURS[str(method)] if hollow else "white",
            markeredgewidth=1.4 if hollow else 0.7,
            color=COLOURS[str(method)],
            zorder=4,
        )


def _draw_front(axes: "Axes", points: pd.DataFrame, column: str, resolved: float) -> None:
    """Steps below which no answer lies; errors that two methods cannot tell from none count as equal."""
    time, error = points["solve_ms"].to_numpy(), np.fmax(points[column].to_numpy(), resolved)
    front = pareto_front(time, error)
    ends = np.append(time[front], SPAN_MS[1])
    axes.plot(
        np.insert(ends, 0, ends[0]),
        np.concatenate([[10.0], error[front], error[front[-1:]]]),
        drawstyle="steps-post",
        color=INK,
        linewidth=1.3,
        zorder=3,
    )


def _join_merged(axes: "Axes", points: pd.DataFrame, column: str) -> None:
    """A thin line through the answers with the same meshes merged, whose errors are those of merging, and their g."""
    for g, group in points[points["model"] == MERGED].groupby("globalisation"):
        row = group.sort_values("solve_ms")
        axes.plot(row["solve_ms"], row[column], color=INK, linewidth=0.6, alpha=0.5, zorder=2)
        last = row.iloc[-1]
        axes.annotate(
            f"g = {g}",
            (last["solve_ms"], last[column]),
            xytext=(-4.0, 6.0),
            textcoords="offset points",
            fontsize=8,
            color=INK,
            zorder=5,
        )


def _key(figure: "Figure", tried: set[str]) -> None:
    """Colours and markers, in rows above and below the panels."""
    from matplotlib.lines import Line2D

    methods = [
        Line2D([], [], color=colour, linewidth=5.0, label=name)
        for name, colour in COLOURS.items()
        if name in tried and name != CLOSED_FORM
    ]
    models = [
        Line2D([], [], color=INK, marker=marker, linestyle="none", label=MODEL_NAMES[name])
        for name, marker in MARKERS.items()
    ]
    front = [Line2D([], [], color=INK, linewidth=1.3, label="Pareto front")]
    first = figure.legend(handles=methods + front, loc="outside upper center", ncols=6, frameon=False, fontsize=9)
    second = figure.legend(handles=models, loc="outside lower center", ncols=4, frameon=False, fontsize=9)
    for text in (*first.get_texts(), *second.get_texts()):
        text.set_color(INK)
