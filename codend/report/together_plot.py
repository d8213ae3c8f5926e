"""Predicted and fitted retention in one plot, and L50 against the catch for both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from codend.net.net import Floats
from codend.report.style import BLUE, INK, ORANGE, PALE, dress, new_figure, number_text
from codend.selectivity.predicted_and_observed.together import Together, observed_retention
from codend.selectivity.predicted_and_observed.together_l50 import haul_l50_sr, together_l50_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GREEN = "#009e73"
"""Of the palette for the colour-blind by Okabe and Ito."""
MOST_OBSERVED = 1.25
"""Upper end of the axis where paired gear has observed retention above 1."""


def together_plot(many: Sequence[Together]) -> Figure:
    """Left: retention by length. Right: L50 against the catch, lines of computed curves, markers of fitted ones.

    A row of panels each species and speed.
    """
    figure = new_figure(12.0, 0.3 + 5.7 * len(many))
    grid = figure.subplots(len(many), 2, squeeze=False, width_ratios=(1.3, 1.0))
    for (left, right), one in zip(grid, many, strict=True):
        dress(left)
        dress(right)
        _retention(left, one)
        _l50(right, one)
        for axes in (left, right):
            if axes.get_legend_handles_labels()[0]:
                axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), frameon=False, fontsize="small")
    return figure


def fish_text(one: Together) -> str:
    """What kind of fish the trial's are."""
    return "simulated fish" if one.trial.simulated else "fish counted in the field"


def _label(text: str, values: Floats) -> str:
    """What the legend says of values: nothing where there are none to draw."""
    return text if np.isfinite(values).any() else "_nothing drawn"


def _retention(axes: Axes, one: Together) -> None:
    trial, length = one.trial, one.length_cm
    fine = np.linspace(length[0], length[-1], 400)
    label = _label("computed whole haul, 95 % over all ranges", one.predicted_band)
    axes.fill_between(length, *one.predicted_band, color=PALE, alpha=0.6, label=label, linewidth=0.0)
    assumed = f", {len(one.prediction.species.assumed)} numbers assumed" if one.prediction.species.assumed else ""
    known = bool(np.isfinite(one.predicted_trial).all())
    whole = f"computed whole haul, to {number_text(one.prediction.haul.volume_m3[-1])} m³{assumed}"
    axes.plot(fine, one.prediction.terms[-1].retention(fine), color=INK, lw=0.9 if known else 2.2, label=whole)
    if known:
        axes.plot(length, one.predicted_trial, color=INK, lw=2.2, label="computed hauls to the trial's catches, mean")
    if one.calibrated is not None:
        label = "the same, calibrated on the trial"
        axes.plot(length, one.calibrated_trial, color=GREEN, lw=1.8, ls="--", label=label)
    curve = trial.fit.pooled.model.curve.name
    label = _label("fitted, 95 % interval", one.fitted_band)
    axes.fill_between(length, *one.fitted_band, color=ORANGE, alpha=0.25, label=label, linewidth=0.0)
    label = _label(f"fitted {curve} ({trial.group.replace('-', ' ')})", one.fitted)
    axes.plot(length, one.fitted, color=ORANGE, lw=1.6, label=label)
    most, label = 1.02, f"observed, {fish_text(one)}: a dot a haul, area by fish"
    hauls = [observed_retention(trial, length, h) for h in range(len(trial.data.haul_names))]
    largest = max(fish.max() for fish, _ in hauls)
    for fish, observed in hauls:
        if not np.isfinite(observed).any():
            continue
        area = np.clip(30.0 * fish / largest, 3.0, None)
        axes.scatter(length, observed, s=area, color=BLUE, alpha=0.5, linewidth=0.0, label=label, zorder=3)
        most = max(most, min(MOST_OBSERVED, float(np.nanmax(observed, initial=0.0)) * 1.02))
        label = "_more"
    axes.set(xlabel="fish length (cm)", ylabel="retention", ylim=(0.0, most))
    fished = length[one.fish > 0.0]
    axes.set_xlim(fished[0] - 3.0, fished[-1] + 3.0)
    name = f"{one.prediction.species.name}, {number_text(one.prediction.haul.speed_m_s)} m/s"
    hauls_text = "1 haul" if len(hauls) == 1 else f"{len(hauls)} hauls"
    fitted_text = "" if np.isfinite(one.fitted).any() else ", no curve fitted"
    axes.set_title(f"{name}\n{hauls_text} of {fish_text(one)}{fitted_text}", loc="left", fontsize="medium")


def _l50(axes: Axes, one: Together) -> None:
    volume, curve = one.prediction.haul.volume_m3, one.trial.fit.pooled.model.curve.name
    # markers, for a single point makes no line
    of_haul, of_catch = haul_l50_sr(one.prediction)[:, 0], one.prediction.l50_sr[:-1, 0]
    axes.plot(volume, of_haul, color=INK, lw=1.6, marker=".", label=_label("computed haul, of its curve", of_haul))
    label = _label("computed, fish meeting this catch", of_catch)
    axes.plot(volume, of_catch, color=INK, lw=0.9, ls=":", marker=".", label=label)
    if one.calibrated is not None:
        of_haul = haul_l50_sr(one.calibrated)[:, 0]
        label = _label("calibrated haul, of its curve", of_haul)
        axes.plot(volume, of_haul, color=GREEN, lw=1.6, ls="--", marker=".", label=label)
    table = together_l50_table([one])
    table = table[table["catch_volume_m3"].notna() & table["l50_cm"].notna() | (table["what"] == "field mean")]
    hauls, mean = table[table["what"] == "field haul"], table[table["what"] == "field mean"].iloc[0]
    for kind, colour, marker in (("predicted", INK, "D"), ("calibrated", GREEN, "o")):
        fitted = table[table["what"] == f"{kind} field haul"]
        if len(fitted) and len(hauls):
            label = f"{'computed' if kind == 'predicted' else kind} haul, {curve} as fitted to fish"
            at = fitted["catch_volume_m3"]
            axes.plot(at, fitted["l50_cm"], color=colour, ls="", marker=marker, ms=6, mfc="none", label=label)
    if len(hauls):
        reach = [hauls["l50_cm"] - hauls["l50_lower_95_cm"], hauls["l50_upper_95_cm"] - hauls["l50_cm"]]
        at = hauls["catch_volume_m3"]
        label = f"field haul, {curve} fitted to its fish, 95 %"
        axes.errorbar(at, hauls["l50_cm"], reach, color=BLUE, marker="s", ms=4, lw=0.8, ls="", label=label)
    if np.isfinite(mean["l50_cm"]):
        axes.axhspan(mean["l50_lower_95_cm"], mean["l50_upper_95_cm"], color=ORANGE, alpha=0.2, linewidth=0.0)
        axes.axhline(mean["l50_cm"], color=ORANGE, lw=1.4, label=f"field, {one.trial.group.replace('-', ' ')}, 95 %")
    axes.set(xlabel="catch at the end of the haul (m³)", ylabel="L50 (cm)")
    axes.set_xlim(left=0.0)
    unknown = "the trial's table has no catches" if one.trial.volume_m3 is None else "no haul of the trial was fitted"
    note = "" if len(hauls) else f"; {unknown}"
    axes.set_title(f"L50 against the catch{note}", loc="left", fontsize="medium")
