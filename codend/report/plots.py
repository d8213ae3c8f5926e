"""Plots along the codend: profiles, openings, opening forces and tensions of all catches of a study.

Catches differ in colour, from dark for the smallest to light for the largest; speeds have a panel each. Heavy lines
lie on the catch. Every function takes a study with at least one solved case.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from codend.bag.layer_measures import measure_layers
from codend.bag.measures import WANTED_OPENING_DEG, Rows, opening_rows_ahead
from codend.net.net import Floats
from codend.report.style import INK, PALE, dress, new_figure, new_panels, number_text, ordered_colours, spread
from codend.studies.case_result import CaseResult
from codend.studies.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Panels = tuple["Figure", list[tuple["Axes", list["Curve"]]]]
Colour = tuple[float, float, float, float]

WIDTH_IN = 10.0
MOST_LEGEND_ENTRIES = 10
THIN, HEAVY = 1.1, 2.6
LEAST_NAMED = 0.1
"""Share of the codend's meshes from which a section's name has room above a plot."""


@dataclass(frozen=True)
class Curve:
    """A solved case as it is drawn."""

    result: CaseResult
    rows: Rows
    colour: Colour
    label: str

    @property
    def meshes_from_entry(self) -> Floats:
        """Place of every row, (rows + 1,)."""
        return self.result.bag.row_place

    def of_meshes(self, values: Floats) -> Floats:
        """Values of the rows of meshes where the rows of knots are; those of square mesh lie between two."""
        has_mesh, bag = np.isfinite(self.rows.opening_deg), self.result.bag
        places = bag.mesh_place[has_mesh]
        return np.interp(bag.row_place, places, values[has_mesh], left=np.nan, right=np.nan)

    def at_front(self, values: Floats) -> float:
        """Value of a quantity of the rows at the catch's front."""
        return float(np.interp(self.result.solution.front_row, np.arange(len(values)), values))

    def ahead(self, values: Floats) -> Floats:
        """Values from the entry to the front."""
        return np.append(values[: int(np.ceil(self.result.solution.front_row))], self.at_front(values))

    def behind(self, values: Floats) -> Floats:
        """Values from the front to the codline."""
        return np.insert(values[int(np.floor(self.result.solution.front_row)) + 1 :], 0, self.at_front(values))


def solved(study: Study) -> list[CaseResult]:
    """The cases that have an answer."""
    return [result for result in study.cases if result.rows is not None]


def curves_by_speed(study: Study) -> dict[float, list[Curve]]:
    """Solved cases at each speed, from the smallest catch to the largest."""
    density = study.plan.catch_density_kg_m3
    found: dict[float, list[Curve]] = {}
    for speed in dict.fromkeys(result.case.speed_m_s for result in solved(study)):
        results = [result for result in solved(study) if result.case.speed_m_s == speed]
        results.sort(key=lambda result: result.measures.catch_volume_m3)
        found[speed] = [
            Curve(result, result.rows, colour, catch_text(result.measures.catch_volume_m3, density))
            for result, colour in zip(results, ordered_colours(len(results)), strict=True)
            if result.rows is not None
        ]
    return found


def catch_text(volume_m3: float, density_kg_m3: float) -> str:
    """Size of a catch, as volume and as mass."""
    return f"{number_text(volume_m3)} m³, {number_text(volume_m3 * density_kg_m3)} kg"


def profiles_plot(study: Study) -> "Figure":
    """Meridian profiles to scale, entry to the left; a dotted line where sections meet."""
    length = max(result.measures.length_m for result in solved(study))
    width = max(result.measures.max_radius_m for result in solved(study))
    with _panels(study, max(2.4, 0.62 * WIDTH_IN * 2.0 * width / length)) as (figure, panels):
        for axes, curves in panels:
            for curve in curves:
                x, r = curve.rows.x_m, curve.rows.radius_m
                for side in (1.0, -1.0):
                    _draw(axes, curve, x, side * r)
                joints = np.flatnonzero(np.isin(curve.meshes_from_entry, _joints(study)))
                axes.vlines(x[joints], -r[joints], r[joints], color=curve.colour, linewidth=0.8, linestyle=":")
            axes.axhline(0.0, color=INK, linewidth=0.5, linestyle=(0, (8, 3, 2, 3)))
            axes.set_aspect("equal")
            axes.set_xlabel("distance from the entry along the axis (m)")
            axes.set_ylabel("radius (m)")
    return figure


def opening_plot(study: Study) -> "Figure":
    """Mesh opening angle along the codend, with the error of the mean ahead of the catch."""
    figure = _along(study, "mesh opening angle (degrees)", lambda c: c.of_meshes(c.rows.opening_deg), from_zero=True)
    for axes, curves in zip(figure.axes, curves_by_speed(study).values(), strict=True):
        for curve in curves:
            ahead, result = opening_rows_ahead(curve.result.bag, curve.result.solution.share), curve.result
            error = result.errors.opening_ahead_error_deg
            if len(ahead) and np.isfinite(error):
                place, mean = float(ahead.mean()), result.measures.opening_ahead_deg
                axes.errorbar(place, mean, yerr=error, color=curve.colour, capsize=3.0, linewidth=THIN)
    return figure


def opening_force_plot(study: Study) -> "Figure":
    """Opening force of the meshes ahead of the catch, with the line below which none is needed."""
    wanted = f"{WANTED_OPENING_DEG:g}°"
    label = f"opening force to {wanted} (N)"
    figure = _along(study, label, lambda c: c.of_meshes(c.rows.opening_force_n), ahead_only=True)
    for axes in figure.axes:
        axes.axhline(0.0, color=INK, linewidth=1.0)
        bottom, top = axes.get_ylim()
        axes.axhspan(min(bottom, 0.0), 0.0, color=PALE, alpha=0.35, linewidth=0.0, zorder=0)
        axes.set_ylim(bottom, top)
    return figure


def tension_plot(study: Study) -> "Figure":
    """Bar tension along the codend."""
    return _along(study, "bar tension (N)", lambda c: c.rows.bar_tension_n, from_zero=True)


def layers_plot(study: Study) -> "Figure":
    """Openings of second layers along the netting below, and the share of the hoop load that each carries."""
    figure = new_figure(WIDTH_IN, 5.6)
    panels = figure.subplots(2, sharex=True)
    for axes, label in zip(panels, ("opening of its meshes (degrees)", "share of the hoop load"), strict=True):
        dress(axes)
        axes.set_ylabel(label)
    panels[1].set_xlabel("meshes of the netting below, from the entry")
    for curve in [curve for curves in curves_by_speed(study).values() for curve in curves]:
        result, bag = curve.result, curve.result.bag
        for rows in measure_layers(bag, result.problem, result.solution):
            band = rows.band.astype(int)
            place = bag.row_place[band] + 0.5 * bag.band_meshes[band]
            for axes, values in zip(panels, (rows.opening_deg, rows.hoop_share), strict=True):
                axes.plot(place, values, color=curve.colour, linewidth=THIN, label=curve.label)
    for axes in panels:
        axes.set_ylim(bottom=0.0)
    handles, labels = panels[1].get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    named = [list(once)[i] for i in spread(len(once), MOST_LEGEND_ENTRIES)]
    panels[1].legend(
        [once[name] for name in named], named, title="catch", loc="center left", bbox_to_anchor=(1.01, 0.5)
    )
    return figure


def _along(
    study: Study, label: str, value: Callable[[Curve], Floats], ahead_only: bool = False, from_zero: bool = False
) -> "Figure":
    with _panels(study, 2.8, ahead_only) as (figure, panels):
        for axes, curves in panels:
            for curve in curves:
                _draw(axes, curve, curve.meshes_from_entry, value(curve), ahead_only)
                axes.set_xlim(0.0, curve.meshes_from_entry[-1])
            axes.set_xlabel("meshes from the entry")
            axes.set_ylabel(label)
            _mark_sections(axes, study)
        if from_zero:  # only now: the panels share their axis, and a limit ends its scaling
            figure.axes[0].set_ylim(bottom=0.0)
    return figure


def _joints(study: Study) -> NDArray[np.int_]:
    """Places where two sections meet, in meshes from the entry."""
    return np.cumsum([part.meshes_long for part in study.plan.netting])[:-1]


def _mark_sections(axes: "Axes", study: Study) -> None:
    """Lines where sections meet, and their names above; of a single section neither."""
    plan = study.plan
    ends = np.array([0, *_joints(study), sum(part.meshes_long for part in plan.netting)])
    if len(plan.netting) < 2:
        return
    for place in ends[1:-1]:
        axes.axvline(place, color=INK, linewidth=0.8, linestyle=":")
    for name, fore, aft in zip(plan.section_names, ends[:-1], ends[1:], strict=True):
        if aft - fore >= LEAST_NAMED * ends[-1]:
            middle = ((fore + aft) / 2, 1.0)
            axes.annotate(
                name,
                middle,
                xytext=(0, 3),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                ha="center",
                fontsize="small",
                color=INK,
            )


def _draw(axes: "Axes", curve: Curve, x: Floats, y: Floats, ahead_only: bool = False) -> None:
    """Thin line to the front, a dot there, heavy line on the catch."""
    axes.plot(curve.ahead(x), curve.ahead(y), color=curve.colour, linewidth=THIN)
    axes.plot(curve.at_front(x), curve.at_front(y), "o", color=curve.colour, markersize=4.0)
    if not ahead_only:
        axes.plot(curve.behind(x), curve.behind(y), color=curve.colour, linewidth=HEAVY, solid_capstyle="butt")


@contextmanager
def _panels(study: Study, height_in: float, ahead_only: bool = False) -> Iterator[Panels]:
    """A figure with a panel a speed, dressed and with legends once the block has drawn into them."""
    speeds = curves_by_speed(study)
    figure, panels = new_panels(len(speeds), WIDTH_IN, height_in)
    yield figure, list(zip(panels, speeds.values(), strict=True))
    for axes, (speed, curves) in zip(panels, speeds.items(), strict=True):
        dress(axes)
        axes.label_outer()
        if len(speeds) > 1:
            axes.set_title(f"{number_text(speed)} m/s", loc="left", fontsize="medium")
        _add_legend(axes, curves, ahead_only)


def _add_legend(axes: "Axes", curves: list[Curve], ahead_only: bool) -> None:
    from matplotlib.artist import Artist
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    named = [curves[i] for i in spread(len(curves), MOST_LEGEND_ENTRIES)]
    handles: list[Artist] = [Line2D([], [], color=curve.colour, linewidth=HEAVY, label=curve.label) for curve in named]
    handles.append(Line2D([], [], color=INK, linestyle="", marker="o", markersize=4.0, label="front of the catch"))
    if ahead_only:
        handles.append(Patch(color=PALE, alpha=0.35, label=f"wider than {WANTED_OPENING_DEG:g}° already"))
    else:
        handles.append(Line2D([], [], color=INK, linewidth=HEAVY, label="netting on the catch"))
    axes.legend(
        handles=handles,
        title="catch" if len(named) == len(curves) else f"catch ({len(named)} of {len(curves)} named)",
        loc="center left",
        bbox_to_anchor=(1.01, 0.5),
        frameon=False,
        fontsize="small",
        alignment="left",
    )
