"""Charts of error against time: a panel a scene, a colour a method, a marker a model."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from codend.report.style import BLUE, INK, ORANGE, PALE, dress, new_figure
from validation.work_precision.front import pareto_front
from validation.work_precision.measuring import CLOSED_FORM, Measured
from validation.work_precision.scenes import FULL, KINETIC, MEMBRANE, MERGED, MERIDIAN, NEWTON, RIGID, SECTOR, VISCOUS

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
    MERGED: "full net, meshes merged (number: g)",
    FULL: "full net, every mesh",
    MEMBRANE: "membrane (hollow: closed form)",
}
WORDS = {"drag": "drag", "opening": "opening ahead of the catch", "volume": "catch volume"}
LOWEST = 1e-11
"""Where answers are drawn that differ from the reference by less, or not at all."""


def chart(measured: tuple[Measured, ...], quantity: str) -> "Figure":
    """Error in a quantity against solve time, with the Pareto front of every scene."""
    figure = new_figure(12.5, 5.4)
    panels = figure.subplots(1, len(measured), sharey=True, sharex=True)
    for axes, of_scene in zip(panels, measured, strict=True):
        _panel(axes, of_scene, quantity)
    panels[0].set_ylabel(f"relative error in {WORDS[quantity]}")
    panels[len(panels) // 2].set_xlabel("solve time from nothing, first guess included, ms")
    _key(figure)
    return figure


def _panel(axes: "Axes", measured: Measured, quantity: str) -> None:
    points, resolved = measured.points, measured.resolved[quantity]
    axes.set_title(measured.scene.name, color=INK, fontsize=11)
    axes.loglog()
    axes.set_ylim(LOWEST / 2.0, 2.0)
    dress(axes)
    axes.axhspan(LOWEST / 10.0, resolved, color=PALE, alpha=0.5, linewidth=0.0)
    axes.text(
        0.985,
        resolved * 0.75,
        "below what two methods agree on",
        transform=axes.get_yaxis_transform(),
        ha="right",
        va="top",
        fontsize=7.5,
        color=INK,
    )
    _draw_front(axes, points, f"{quantity}_error", resolved)
    for (method, model), group in points.groupby(["method", "model"], sort=False):
        error = np.maximum(group[f"{quantity}_error"], LOWEST)
        hollow = method == CLOSED_FORM
        axes.plot(
            group["solve_ms"],
            error,
            linestyle="-" if model in (SECTOR, MEMBRANE) else "none",
            linewidth=0.7,
            marker=MARKERS[model],
            markersize=6.5,
            markerfacecolor="white" if hollow else COLOURS[method],
            markeredgecolor=COLOURS[method] if hollow else "white",
            markeredgewidth=1.4 if hollow else 0.7,
            color=COLOURS[method],
            zorder=4,
        )
        if model == MERGED:
            _number(axes, group, error, COLOURS[method])


def _draw_front(axes: "Axes", points: pd.DataFrame, column: str, resolved: float) -> None:
    """Steps below which no answer lies; errors that two methods cannot tell from none count as equal."""
    time, error = points["solve_ms"].to_numpy(), np.maximum(points[column].to_numpy(), resolved)
    front = pareto_front(time, error)
    ends = np.append(time[front], 1e6)
    axes.plot(
        np.insert(ends, 0, ends[0]),
        np.concatenate([[10.0], error[front], error[front[-1:]]]),
        drawstyle="steps-post",
        color=INK,
        linewidth=1.3,
        zorder=3,
        scalex=False,
    )


def _number(axes: "Axes", group: pd.DataFrame, error: pd.Series, colour: str) -> None:
    for g, ms, at in zip(group["globalisation"], group["solve_ms"], error, strict=True):
        axes.annotate(
            f"{g}", (ms, at), xytext=(4.5, 3.5), textcoords="offset points", fontsize=7.5, color=colour, zorder=5
        )


def _key(figure: "Figure") -> None:
    """Colours and markers, in two rows over the panels."""
    from matplotlib.lines import Line2D

    methods = [
        Line2D([], [], color=colour, linewidth=5.0, label=name)
        for name, colour in COLOURS.items()
        if name != CLOSED_FORM
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
