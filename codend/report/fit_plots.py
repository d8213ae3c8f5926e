"""Plots of fits to field data: curves with their fish, residuals, L50 and SR of hauls, differences, catch ratio.

Gears differ in colour; hauls lie behind in pale lines; the area of a point is by its fish.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from codend.net.net import Floats
from codend.report.style import BLUE, INK, ORANGE, PALE, dress, new_figure
from codend.selectivity.fits.catch_comparison import CatchComparison
from codend.selectivity.fits.fit import Fit
from codend.selectivity.fits.observed import fish_of_gears
from codend.selectivity.fits.one_stage import OneStage, conditional_residuals
from codend.selectivity.fits.one_stage_estimates import estimates, retention_band, share_band
from codend.selectivity.fits.predictions import delta_bands, lengths_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS: Final = (BLUE, ORANGE, "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
"""Of the palette for the colour-blind by Okabe and Ito."""
WIDTH_IN: Final = 10.0
LARGEST_AREA, LEAST_AREA = 130.0, 4.0
MOST_HAULS: Final = 80
MOST_RETENTION: Final = 1.3
MOST_RATIO: Final = 20.0
MOST_COVARIATES: Final = 4


def curve_plot(fit: OneStage) -> Figure:
    """Retention with the hauls behind; for paired gear also what is fitted, the share of fish in the test gear."""
    paired = fit.model.design == "paired"
    figure = new_figure(WIDTH_IN, 5.0)
    panels = figure.subplots(1, 1 + paired, squeeze=False)[0]
    length, gears = lengths_of(fit), fish_of_gears(fit)
    largest = max(float(gear.fish.max()) for gear in gears)
    for axes in panels:
        dress(axes)
    right = panels[-1]
    _hauls(right, fit, length)
    for gear, colour in zip(gears, COLOURS * len(gears), strict=False):
        point = fit.point(gear.level)
        band = retention_band(fit, point, length)
        name = gear.level or "fitted"
        right.fill_between(length, band.lower_all_95, band.upper_all_95, color=colour, alpha=0.1, linewidth=0.0)
        label = f"{name}, 95 % at each length and, paler, of the whole curve"
        right.fill_between(length, band.lower_95, band.upper_95, color=colour, alpha=0.25, linewidth=0.0, label=label)
        right.plot(length, band.value, color=colour, linewidth=2.0)
        _points(right, gear.length_cm, gear.retention, gear.fish, colour=colour, largest=largest)
        l50, _, split = fit.curve_at(point, fit.theta)
        right.plot([l50, l50], [0.0, 0.5], color=colour, linewidth=0.9, linestyle=":")
        if paired:
            band = share_band(fit, point, length)
            panels[0].fill_between(length, band.lower_95, band.upper_95, color=colour, alpha=0.25, linewidth=0.0)
            panels[0].plot(length, band.value, color=colour, linewidth=2.0)
            _points(panels[0], gear.length_cm, gear.share, gear.fish, colour=colour, largest=largest)
            panels[0].axhline(split, color=colour, linewidth=0.9, linestyle=":")
    seen = [gear.retention[np.isfinite(gear.retention)] for gear in gears]
    top = max(1.02, min(MOST_RETENTION, 1.03 * max(float(values.max(initial=0.0)) for values in seen)))
    right.set(xlabel="fish length (cm)", ylabel="retention", ylim=(-0.01, top))
    right.axhline(0.5, color=INK, linewidth=0.6, linestyle=":")
    if paired:
        right.set_ylabel("retention: (test / control) / (split / (1 - split))")
        panels[0].set(xlabel="fish length (cm)", ylabel="share of the fish in the test gear", ylim=(-0.01, 1.01))
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower left", frameon=False, fontsize="small")
    return figure


def residual_plot(fit: OneStage) -> Figure:
    """Pearson residuals about each haul's own predicted curve: by length, and by haul."""
    figure, several = new_figure(WIDTH_IN, 3.6), len(fit.hauls) > 1
    panels = figure.subplots(1, 1 + several, sharey=True, squeeze=False, width_ratios=(1.3, 1.0)[: 1 + several])[0]
    left, by_haul = panels[0], panels[1:]
    residual, fish = conditional_residuals(fit), fit.data.test_count + fit.data.other_count
    good = np.isfinite(residual)
    levels = fit.hauls[fit.group].to_numpy() if fit.group else np.full(len(fit.hauls), "")
    for level, colour in zip(fit.levels, COLOURS * len(fit.levels), strict=False):
        rows = good & (levels == level)[fit.data.haul]
        area = _area(fish[rows], float(fish.max()))
        for axes, x in zip(panels, (fit.data.length_cm[rows], fit.data.haul[rows] + 1.0), strict=False):
            axes.scatter(x, residual[rows], s=area, color=colour, alpha=0.35, linewidth=0.0, label=level)
    lengths = np.unique(fit.data.length_cm[good])
    weights = fish * good
    sums = [float((weights * np.nan_to_num(residual))[fit.data.length_cm == at].sum()) for at in lengths]
    totals = [float(weights[fit.data.length_cm == at].sum()) for at in lengths]
    left.plot(lengths, np.divide(sums, totals), color=INK, linewidth=1.4)
    for axes, name in zip(panels, ("fish length (cm)", "haul, in the order of the table"), strict=False):
        dress(axes)
        axes.axhline(0.0, color=INK, linewidth=0.8)
        for limit in (-2.0, 2.0):
            axes.axhline(limit, color=INK, linewidth=0.6, linestyle=":")
        axes.set_xlabel(name)
    left.set_ylabel("Pearson residual")
    for axes in by_haul:
        axes.xaxis.get_major_locator().set_params(integer=True)
    if fit.group:
        left.legend(frameon=False, fontsize="small")
    return figure


def haul_plot(fit: OneStage, hauls: tuple[Fit, ...], names: list[str]) -> Figure:
    """L50 and SR of hauls against covariates, or in their order: own fits with 95 %, and what one stage predicts.

    Args:
        fit: the one-stage fit; its line and band are drawn where the covariate is in its formulas.
        hauls: the hauls' own fits, in the order of the table; may be empty.
        names: numeric columns; none for the order of the table.
    """
    columns: list[str] = names[:MOST_COVARIATES] or [""]
    figure = new_figure(WIDTH_IN, 5.6)
    grid = figure.subplots(2, len(columns), squeeze=False, sharey="row", sharex="col")
    levels = fit.hauls[fit.group].to_numpy() if fit.group else np.full(len(fit.hauls), "")
    predicted = fit.haul_l50_sr()
    for c, name in enumerate(columns):
        x = fit.hauls[name].to_numpy(dtype=float) if name else np.arange(1.0, len(fit.hauls) + 1)
        for q, (of, label) in enumerate((("l50_cm", "L50 (cm)"), ("sr_cm", "SR (cm)"))):
            axes = grid[q][c]
            dress(axes)
            for level, colour in zip(fit.levels, COLOURS * len(fit.levels), strict=False):
                mine = levels == level
                _own_fits(axes, x, hauls, of, mine, colour=colour)
                axes.plot(x[mine], predicted[mine, q], ls="", marker="D", ms=4, color=colour, label=level or None)
                _line(axes, fit, name, of, level, colour=colour)
            axes.set_ylabel(label if c == 0 else "")
            _limit(axes, predicted[:, q], hauls, of)
        grid[1][c].set_xlabel(name or "haul, in the order of the table")
        if not name:
            grid[1][c].xaxis.get_major_locator().set_params(integer=True)
    if fit.group:
        grid[0][0].legend(frameon=False, fontsize="small")
    return figure


def delta_plot(fit: OneStage) -> Figure:
    """Differences of the retention of every pair of gears, with bands for each length and for the whole curve."""
    bands = delta_bands(fit)
    figure = new_figure(WIDTH_IN, 3.2 * len(bands))
    for axes, ((first, second), band) in zip(
        figure.subplots(len(bands), 1, squeeze=False)[:, 0], bands.items(), strict=True
    ):
        dress(axes)
        wide = "95 % of the whole curve"
        axes.fill_between(
            band.length_cm, band.lower_all_95, band.upper_all_95, color=PALE, alpha=0.7, lw=0.0, label=wide
        )
        one = "95 % at each length"
        axes.fill_between(band.length_cm, band.lower_95, band.upper_95, color=BLUE, alpha=0.3, linewidth=0.0, label=one)
        axes.plot(band.length_cm, band.value, color=BLUE, linewidth=1.8)
        axes.axhline(0.0, color=INK, linewidth=0.8)
        axes.set(xlabel="fish length (cm)", ylabel=f"retention, {first} minus {second}")
        axes.legend(frameon=False, fontsize="small", loc="best")
    return figure


def comparison_plot(found: CatchComparison) -> Figure:
    """Catch comparison and catch ratio with bands."""
    figure = new_figure(WIDTH_IN, 4.4)
    left, right = figure.subplots(1, 2)
    length, raised = found.length_cm, found.data
    test = raised.test_count * raised.test_raising
    other = raised.other_count * raised.other_raising
    at = [raised.length_cm == one for one in length]
    fish = np.array([(raised.test_count + raised.other_count)[rows].sum() for rows in at])
    share = np.array([test[rows].sum() / (test + other)[rows].sum() for rows in at])
    table = found.table()
    for axes, name, seen in (
        (left, "share", share),
        (right, "ratio", share / np.where(share < 1.0, 1.0 - share, np.nan)),
    ):
        dress(axes)
        names = [f"{name}_{limit}" for limit in ("lower_all_95", "upper_all_95", "lower_95", "upper_95")]
        wide_low, wide_high, low, high = (np.minimum(table[column], MOST_RATIO) for column in names)
        if found.n_replicates:
            label = "95 % of the whole curve"
            axes.fill_between(length, wide_low, wide_high, color=PALE, alpha=0.7, linewidth=0.0, label=label)
            axes.fill_between(length, low, high, color=BLUE, alpha=0.3, linewidth=0.0, label="95 % at each length")
        axes.plot(length, np.minimum(table[name], MOST_RATIO), color=BLUE, linewidth=1.8)
        _points(axes, length, seen, fish, colour=ORANGE, largest=float(fish.max()))
        axes.axhline(0.5 if name == "share" else 1.0, color=INK, linewidth=0.8)
        axes.set_xlabel("fish length (cm)")
    left.set(ylabel="share of the fish in the test gear", ylim=(-0.01, 1.01))
    drawn = np.concatenate([table["ratio"].to_numpy(), table["ratio_upper_95"].fillna(0.0).to_numpy()])
    right.set(ylabel="catch ratio, test over control", ylim=(0.0, 1.05 * min(MOST_RATIO, max(1.2, float(drawn.max())))))
    if found.n_replicates:
        left.legend(frameon=False, fontsize="small")
    return figure


def _points(axes: Axes, x: Floats, y: Floats, fish: Floats, *, colour: str, largest: float) -> None:
    good = np.isfinite(y) & (fish > 0.0)
    area = _area(fish[good], largest)
    axes.scatter(x[good], y[good], s=area, facecolor=colour, edgecolor="white", linewidth=0.6, alpha=0.85, zorder=3)


def _area(fish: Floats, largest: float) -> Floats:
    return np.clip(LARGEST_AREA * fish / largest, LEAST_AREA, None)


def _hauls(axes: Axes, fit: OneStage, length: Floats) -> None:
    """Predicted curves of the units behind."""
    if not fit.model.random:
        return
    shape = fit.theta[fit.model.slices["shape"]]
    label = "hauls, predicted"
    curves = fit.haul_l50_sr()
    for l50, sr in curves[np.isfinite(curves[:, 0])][:MOST_HAULS]:
        axes.plot(length, fit.model.family.retention(length, l50, sr, shape), color=PALE, linewidth=0.8, label=label)
        label = "_more"


def _own_fits(axes: Axes, x: Floats, hauls: tuple[Fit, ...], of: str, mine: np.ndarray, *, colour: str) -> None:
    for h, fit in enumerate(hauls):
        if not mine[h] or not fit.converged or np.isnan(fit.estimates[of]):
            continue
        i = fit.estimates.names.index(of)
        value = fit.estimates.values[i]
        reach = [[value - fit.estimates.lower_95[i]], [fit.estimates.upper_95[i] - value]]
        axes.errorbar(x[h], value, reach, color=colour, alpha=0.35, marker="o", ms=4, lw=0.8, ls="", mfc="none")


def _line(axes: Axes, fit: OneStage, name: str, of: str, level: str, *, colour: str) -> None:
    """The mean with its interval, against the covariate where formulas use it."""
    used = {c for one in (fit.l50, fit.log_sr) if one.spec for c in one.spec.required_variables}
    if name and name in used:
        values = fit.hauls[name]
        at = np.linspace(float(values.min()), float(values.max()), 15)
        found = [estimates(fit, level, {name: float(value)}) for value in at]
    else:
        at, found = np.array(axes.get_xlim()), [estimates(fit, level)] * 2
        axes.set_xlim(*at)
    i = found[0].names.index(of)
    axes.plot(at, [one.values[i] for one in found], color=colour, linewidth=1.6)
    limits = [one.lower_95[i] for one in found], [one.upper_95[i] for one in found]
    axes.fill_between(at, *limits, color=colour, alpha=0.15, linewidth=0.0)


def _limit(axes: Axes, predicted: Floats, hauls: tuple[Fit, ...], of: str) -> None:
    """Leave out the far ends of intervals of hauls that say next to nothing."""
    values = np.array([fit.estimates[of] for fit in hauls if fit.converged])
    values = np.concatenate([values[np.isfinite(values)], predicted[np.isfinite(predicted)]])
    middle, reach = float(np.median(values)), max(float(np.ptp(predicted[np.isfinite(predicted)])), 0.5)
    low = max(float(values.min()) - reach, middle - 6.0 * reach, 0.0)
    axes.set_ylim(low, min(float(values.max()) + reach, middle + 6.0 * reach))
