"""Drag against the size of the catch, or what else a study varies."""

from typing import TYPE_CHECKING, Literal

from codend.report.plots import WIDTH_IN, Curve, curves_by_speed
from codend.report.style import BLUE, INK, ORANGE, dress, new_figure, new_panels, number_text, ordered_colours
from codend.studies.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PARTS: tuple[tuple[str, str, str, Literal["-", "--", ":"], str], ...] = (
    ("drag_n", "total", INK, "-", "o"),
    ("catch_drag_n", "by the catch", ORANGE, "--", "s"),
    ("twine_drag_n", "by the twine", BLUE, ":", "^"),
)
"""Column, name, colour, line and marker of each part of the drag."""


def drag_plot(study: Study) -> "Figure":
    """Drag, total and by parts, against catch volume, with a line a speed.

    Against speed where there is one catch, as bars where there is one case. The study has at least one solved case.
    """
    speeds = curves_by_speed(study)
    one_case = len(speeds) == 1 and len(next(iter(speeds.values()))) == 1
    if one_case:
        return _bars(next(iter(speeds.values()))[0])
    figure, (axes,) = new_panels(1, WIDTH_IN, 3.5)
    dress(axes)
    if max(len(curves) for curves in speeds.values()) > 1:
        _against_catch(axes, speeds)
    else:
        _against_speed(axes, [curve for curves in speeds.values() for curve in curves])
    return figure


def _against_catch(axes: "Axes", speeds: dict[float, list[Curve]]) -> None:
    from matplotlib.lines import Line2D

    colours = ordered_colours(len(speeds))
    for (_, curves), of_speed in zip(speeds.items(), colours, strict=True):
        volume = [curve.result.measures.catch_volume_m3 for curve in curves]
        for column, _, of_part, line, marker in PARTS:
            drag = [getattr(curve.result.measures, column) for curve in curves]
            colour = of_speed if len(speeds) > 1 else of_part
            axes.plot(volume, drag, color=colour, linestyle=line, marker=marker, markersize=4.5)
            if column == "drag_n":
                axes.errorbar(volume, drag, yerr=_drag_errors(curves), fmt="none", ecolor=colour, elinewidth=2.6)
    handles = [
        Line2D([], [], color=INK if len(speeds) > 1 else colour, linestyle=line, marker=marker, label=name)
        for _, name, colour, line, marker in PARTS
    ]
    if len(speeds) > 1:
        handles += [
            Line2D([], [], color=colour, linewidth=2.6, label=f"{number_text(speed)} m/s")
            for speed, colour in zip(speeds, colours, strict=True)
        ]
    axes.legend(
        handles=handles, title="drag", loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, alignment="left"
    )
    axes.set_xlabel("catch volume (m³)")
    _drag_axis(axes)


def _against_speed(axes: "Axes", curves: list[Curve]) -> None:
    curves = sorted(curves, key=lambda curve: curve.result.case.speed_m_s)
    for column, name, colour, line, marker in PARTS:
        speed = [curve.result.case.speed_m_s for curve in curves]
        drag = [getattr(curve.result.measures, column) for curve in curves]
        axes.plot(speed, drag, color=colour, linestyle=line, marker=marker, markersize=4.5, label=name)
        if column == "drag_n":
            axes.errorbar(speed, drag, yerr=_drag_errors(curves), fmt="none", ecolor=colour, elinewidth=2.6)
    axes.legend(title="drag", loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, alignment="left")
    axes.set_xlabel("speed (m/s)")
    _drag_axis(axes)


def _drag_errors(curves: list[Curve]) -> list[float]:
    """Errors of the drag, N; nan, which draws none, where there is no estimate."""
    return [curve.result.errors.drag_error_n for curve in curves]


def _drag_axis(axes: "Axes") -> None:
    axes.set_ylabel("drag (N)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)


def _bars(curve: Curve) -> "Figure":
    figure = new_figure(WIDTH_IN, 2.2)
    axes = figure.add_subplot()
    dress(axes)
    names = [name for _, name, _, _, _ in PARTS]
    drag = [getattr(curve.result.measures, column) for column, _, _, _, _ in PARTS]
    bars = axes.barh(names, drag, color=[colour for _, _, colour, _, _ in PARTS], height=0.55)
    axes.bar_label(bars, labels=[f"{number_text(value)} N" for value in drag], padding=4)
    axes.invert_yaxis()
    axes.margins(x=0.12)
    axes.set_xlabel(f"drag (N) with {curve.label} of catch at {number_text(curve.result.case.speed_m_s)} m/s")
    axes.grid(axis="y", visible=False)
    return figure
