"""Plots of predicted selectivity: retention, L50 and SR over the catch, the haul's history, meshes with fish in them.

Species have a panel each, and speeds; a species with assumed numbers says so in its title. Catches differ in colour,
from dark for the smallest to light for the largest, as in the other plots of a study.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from catch_models.fish import FishSection
from codend.report.style import BLUE, INK, ORANGE, PALE, dress, new_figure, number_text, ordered_colours, spread
from codend.selectivity.escape.meshes_met import Catch
from codend.selectivity.escape.penetration import SHAPES, hole_corners, longest_fish
from codend.selectivity.escape.predict import Prediction

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH_IN = 10.0
MOST_NAMED, MOST_DRAWN = 6, 3
POINTS = 400
LEAST_BARS = 4
"""Room for so many numbers even where fewer have a range, so that bars stay bars."""


def retention_plot(predictions: Sequence[Prediction]) -> Figure:
    """Retention by length for every catch and over the haul, with the bands of chance and of the ranges."""
    figure, panels = _panels(predictions, 3.6)
    for axes, found in panels:
        l50, sr = found.l50_sr[-1]
        if found.sensitivity is not None:
            axes.fill_between(
                found.length_cm, *found.sensitivity.band, color=PALE, alpha=0.6, label="whole haul, all ranges, 95 %"
            )
        if found.fish_band is not None:
            fish = number_text(found.species.haul.fish.value)
            label = f"logit of the haul, {fish} fish, 95 %"
            axes.fill_between(found.length_cm, *found.fish_band, color=ORANGE, alpha=0.25, label=label)
        colours = ordered_colours(len(found.haul.catches))
        named = spread(len(colours), MOST_NAMED)
        fine_cm = np.linspace(found.length_cm[0], found.length_cm[-1], POINTS)
        for i, (catch, colour) in enumerate(zip(found.haul.catches, colours, strict=True)):
            name = f"fish that meet {number_text(catch.volume_m3)} m³" if i in named else "_unnamed"
            axes.plot(fine_cm, found.terms[i].retention(fine_cm), color=colour, linewidth=1.1, label=name)
        axes.plot(fine_cm, found.terms[-1].retention(fine_cm), color=INK, linewidth=2.6, label="whole haul")
        if np.isfinite(l50):
            axes.plot([l50, l50], [0.0, 0.5], color=INK, linewidth=0.8, linestyle=":")
            axes.plot([found.length_cm[0], l50], [0.5, 0.5], color=INK, linewidth=0.8, linestyle=":")
        axes.set(xlabel="fish length (cm)", ylabel="retention", ylim=(0.0, 1.02))
        _limit_lengths(axes, found)
        computed = f"L50 {number_text(l50)} cm, SR {number_text(sr)} cm" if np.isfinite(l50) else "no L50"
        _title(axes, found, f"black curve: {computed} (a logit fit, as of a trial, has others)")
        _legend_aside(axes)
    return figure


def catch_plot(predictions: Sequence[Prediction]) -> Figure:
    """L50 and SR against the catch's volume, with intervals of the fitted logit curves."""
    figure, panels = _panels(predictions, 3.2, columns=2)
    for (left, right), found in zip(panels_by_row(panels), predictions, strict=True):
        for q, (axes, name) in enumerate(((left, "L50"), (right, "SR"))):
            volume = found.haul.volume_m3
            fitted = found.logit[:-1, q]
            reach = np.abs(np.stack([fitted - found.lower_95[:-1, q], found.upper_95[:-1, q] - fitted]))
            fish = number_text(found.species.haul.fish.value)
            label = f"logit, {fish} fish, 95 %"
            axes.errorbar(volume, fitted, reach, color=ORANGE, marker="s", ms=3, lw=0.8, ls="", label=label)
            axes.plot(volume, found.l50_sr[:-1, q], color=BLUE, marker="o", markersize=4, label="computed curve")
            axes.axhline(found.l50_sr[-1, q], color=INK, linewidth=1.2, linestyle="--", label="whole haul")
            axes.set(xlabel="catch volume (m³)", ylabel=f"{name} (cm)")
            axes.set_xlim(left=0.0)
            axes.set_ylim(bottom=0.0)
        _title(left, found)
        _legend_aside(right)
    return figure


def history_plot(predictions: Sequence[Prediction]) -> Figure:
    """Opening ahead of the catch and L50 of the fish that arrive, over the haul's time."""
    figure, panels = _panels(predictions, 3.0)
    for axes, found in panels:
        time = found.haul.time(found.species)
        opening = np.array([catch.opening_ahead_deg for catch in found.haul.catches])
        axes.plot(time, opening, color=BLUE, marker="o", markersize=4)
        axes.plot([0.0, time[0]], [opening[0]] * 2, color=BLUE, linestyle=":")
        axes.set(xlabel="share of the haul's time", xlim=(0.0, 1.0))
        axes.set_ylabel("opening ahead (degrees)", color=BLUE)
        axes.set_ylim(bottom=0.0)
        lengths = axes.twinx()
        lengths.plot(time, found.l50_sr[:-1, 0], color=ORANGE, marker="s", markersize=4)
        lengths.plot([0.0, time[0]], [found.l50_sr[0, 0]] * 2, color=ORANGE, linestyle=":")
        lengths.axhline(found.l50_sr[-1, 0], color=ORANGE, linewidth=1.0, linestyle="--")
        lengths.set_ylabel("L50 (cm)", color=ORANGE)
        lengths.set_ylim(bottom=0.0)
        lengths.spines[["top"]].set_visible(False)
        _title(axes, found, "dotted: before the smallest catch computed; dashed: L50 of the haul")
    return figure


def mesh_plot(predictions: Sequence[Prediction]) -> Figure:
    """The mesh just ahead of the front, to scale, with the section of the longest mean fish that passes it."""
    columns = max(len(spread(len(found.haul.catches), MOST_DRAWN)) for found in predictions)
    figure, panels = _panels(predictions, 3.3, columns=columns)
    for row, found in zip(panels_by_row(panels), predictions, strict=True):
        catches = [found.haul.catches[i] for i in spread(len(found.haul.catches), MOST_DRAWN)]
        for axes in row[len(catches) :]:
            axes.set_visible(False)
        for axes, catch in zip(row, catches, strict=False):
            length_cm = draw_mesh(axes, catch, FishSection.of(found.species.values))
            text = f"{number_text(catch.volume_m3)} m³, opening {catch.opening_ahead_deg:.0f}°"
            axes.set_title(f"{text}\nlongest fish {number_text(length_cm)} cm", fontsize="medium")
        row[0].set_ylabel(f"{found.species.name}\nacross the netting (mm)")
        extent = max(np.abs([axes.dataLim.extents for axes in row if axes.get_visible()]).max(), 1.0)
        for axes in row:
            axes.set(xlim=(-1.05 * extent, 1.05 * extent), ylim=(-1.05 * extent, 1.05 * extent))
            axes.set_xlabel("along the netting (mm)")
    return figure


def sensitivity_plot(predictions: Sequence[Prediction]) -> Figure:
    """L50 with each number at both ends of its range, and the share of the variance that each one makes."""
    known = [found for found in predictions if found.sensitivity is not None]
    figure, panels = _panels(known, 4.2, columns=2)
    for (left, right), found in zip(panels_by_row(panels), known, strict=True):
        effects = found.sensitivity
        assert effects is not None
        order = np.argsort(np.nan_to_num(np.abs(np.diff(effects.one_at_a_time[:, :, 0], axis=1)[:, 0])))
        place = np.arange(len(order))
        for end, colour, label in ((0, BLUE, "at the low end"), (1, ORANGE, "at the high end")):
            change = effects.one_at_a_time[order, end, 0] - effects.base[0]
            left.barh(place, change, 0.7, color=colour, label=label)
        left.axvline(0.0, color=INK, linewidth=0.8)
        names = [_with_range(found, effects.parameters[i], effects.ranges[i]) for i in order]
        left.set_yticks(place, names, fontsize="small")
        left.set_xlabel("change of the haul's L50 (cm),\none number at a time")
        for q, (name, colour) in enumerate((("L50", INK), ("SR", PALE))):
            share = np.clip(effects.total[order, q], 0.0, None)
            right.barh(place + 0.2 - 0.4 * q, share, 0.38, color=colour, label=name)
        right.set_yticks(place, [])
        right.set_xlabel("share of the variance\n(total Sobol index)")
        middle, reach = place.mean(), 0.5 * max(len(place), LEAST_BARS)
        for axes in (left, right):
            axes.set_ylim(middle - reach, middle + reach)
            axes.legend(frameon=False, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2)
        _title(left, found)
    return figure


def draw_mesh(axes: Axes, catch: Catch, section: FishSection) -> float:
    """Draw the mesh nearest to one row ahead of the front, in mm, with the longest fish; its length in cm."""
    i = int(np.argmin(np.abs(catch.rows_ahead - 1.0)))
    longest_m = float(longest_fish(catch.holes, section)[i])
    corners = 1000.0 * hole_corners(catch.holes, i)
    closed = np.concatenate([corners, corners[:1]])
    axes.plot(closed[:, 0], closed[:, 1], color=INK, linewidth=1.6, solid_joinstyle="round")
    turns = np.radians(np.linspace(0.0, 90.0, 181))
    at_turns = [float(longest_fish(catch.holes, section, rotation_deg=d)[i]) for d in np.degrees(turns)]
    turn = turns[int(np.argmax(at_turns))]
    outline = 1000.0 * longest_m * section.outline() @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    axes.fill(outline[:, 0], outline[:, 1], color=BLUE, alpha=0.35, linewidth=0.0)
    axes.plot(outline[:, 0], outline[:, 1], color=BLUE, linewidth=1.0)
    axes.set_aspect("equal")
    if catch.holes.shape[i] == SHAPES["rectangle"]:
        axes.text(0.0, 0.0, "square", ha="center", va="center", color=INK, fontsize="small")
    return 100.0 * longest_m


def panels_by_row(panels: list[tuple[Axes, Prediction]]) -> list[list[Axes]]:
    """Axes of each prediction, in the order of the predictions."""
    rows: dict[int, list[Axes]] = {}
    for axes, found in panels:
        rows.setdefault(id(found), []).append(axes)
    return list(rows.values())


def _panels(
    predictions: Sequence[Prediction], height_in: float, columns: int = 1
) -> tuple[Figure, list[tuple[Axes, Prediction]]]:
    figure = new_figure(WIDTH_IN, 0.3 + height_in * len(predictions))
    # so wide a gap that numbers at the ends of neighbouring axes stay apart
    grid = figure.subplots(len(predictions), columns, squeeze=False, gridspec_kw={"wspace": 0.12})
    panels = [(axes, found) for row, found in zip(grid, predictions, strict=True) for axes in row]
    for axes, _ in panels:
        dress(axes)
    return figure, panels


def _title(axes: Axes, found: Prediction, more: str = "") -> None:
    """Species, speed, and whether its numbers are assumed."""
    parts = [f"{found.species.name}, {number_text(found.haul.speed_m_s)} m/s"]
    if found.species.assumed and "assumed" not in found.species.name.lower():
        parts.append(f"{len(found.species.assumed)} numbers assumed")
    parts += [more] * bool(more)
    axes.set_title("; ".join(parts), loc="left", fontsize="medium")


def _limit_lengths(axes: Axes, found: Prediction) -> None:
    """Leave out lengths at which every curve is certain to retain."""
    curves = found.retention if found.sensitivity is None else np.vstack([found.retention, found.sensitivity.band])
    uncertain = np.flatnonzero((curves < 0.995).any(axis=0))
    last = min(uncertain[-1] + 3, len(found.length_cm) - 1) if uncertain.size else len(found.length_cm) - 1
    axes.set_xlim(found.length_cm[0], found.length_cm[last])


def _with_range(found: Prediction, parameter: str, limits: np.ndarray) -> str:
    number = found.species.number(parameter)
    assumed = " (assumed)" if number is not None and number.assumed else ""
    return f"{parameter}, {limits[0]:g} to {limits[1]:g}{assumed}"


def _legend_aside(axes: Axes) -> None:
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small", alignment="left")
