"""Everything `codend fit` leaves in its folder: tables, plots and `fit.html`, the answer and its picture first."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from codend.io.files import whole_file, write_bytes, write_table
from codend.report.fit_plots import comparison_plot, curve_plot, delta_plot, haul_plot, residual_plot
from codend.report.html import PageFigure, rendered
from codend.report.own_look import own_look
from codend.report.page_sections import Section
from codend.report.style import number_text, png
from codend.selectivity.fits.catch_comparison import CatchComparison
from codend.selectivity.fits.fit import Fit
from codend.selectivity.fits.one_stage import OneStage

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

SMALLEST: Final = 1e-7
"""Below which a number of a table is shown as 0."""
TABLES: Final = tuple(
    f"{name}.csv"
    for name in ("fit", "diagnostics", "coefficients", "curves", "predictions", "delta", "usability", "compare")
)
PLOTS: Final = ("curve", "hauls", "residuals", "delta", "compare")
FILES: Final = (*TABLES, "fit.html", *(f"fit_{name}.png" for name in PLOTS))
"""Every file that `write_fit` may write."""

CAPTIONS: Final = {
    "curve": "Fitted retention with 95 % bands: the darker one holds at each length on its own, the paler one the "
    "whole curve. Points are the fish of all hauls together, their area by the number counted.",
    "grey": " Grey: the curves predicted for single hauls.",
    "paired": " Left: what is fitted, the share of the fish in the test gear, which tends to the split (dotted) for "
    "fish that are all retained. Right: retention; points lie above 1 by chance, and those above 1.3 are not drawn.",
    "hauls": "L50 and SR of single hauls. Open circles with bars: the haul's own fish alone, 95 %; diamonds: predicted "
    "in one stage, drawn towards the mean where a haul has few fish. Line and band: the mean with its 95 % interval.",
    "residuals": "Pearson residuals of every length and haul about the haul's predicted curve, area by fish; the "
    "line is their mean by length. A curve of the right shape leaves a line near 0; most points of well-filled classes "
    "lie within the dotted lines.",
    "delta": "Difference of the curves. Gears differ at lengths where the paler band, which holds the whole curve, "
    "leaves out 0.",
    "compare": "Share of the fish in the test gear, and the ratio of the catches; the line across is where both gears "
    "catch alike, given equal effort. Points are the fish of all hauls together.",
}


@dataclass(frozen=True)
class FitReport:
    """What a page is made of.

    Attributes:
        title: of the page.
        summary: of the data and the model, in one or two sentences.
        lead: the answers, a line a gear.
        warnings: what failed or was left out.
        notes: what else is said of the fits.
        tables: by file name without its ending, all that is to be written; `SHOWN` says which the page shows.
        fit: what is drawn; None where nothing was fitted.
        hauls: the hauls' own fits; empty where there are none.
        covariates: numeric columns against which L50 and SR are drawn.
        reference_length_cm: of the usability indicators.
        comparison: catch comparison; None where that was not asked for.
    """

    title: str
    summary: str
    lead: Sequence[str]
    warnings: Sequence[str]
    notes: Sequence[str]
    tables: Mapping[str, pd.DataFrame]
    fit: OneStage | None = None
    hauls: tuple[Fit, ...] = ()
    covariates: list[str] = field(default_factory=list)
    reference_length_cm: float = np.nan
    comparison: CatchComparison | None = None


SHOWN: Final = {
    "fit": ("Estimates", ""),
    "usability": (
        "Usability",
        "Of the fish of all hauls together, with the curve of the gear.",
    ),
    "coefficients": ("Coefficients of the formulas", ""),
    "compare": ("Catch comparison by length", "Limits with `all` are of the whole curve."),
    "curves": (
        "Curves by AIC",
        "The least AIC is the best trade of fit and parameters; within 2 of it the data do not choose. The average is "
        "by the weights, its standard errors hold the choice of the curve.",
    ),
    "diagnostics": ("How each fit went", ""),
}
INDICATORS: Final = {
    "np_minus": "retained, of the fish below the reference length (np-)",
    "np_plus": "retained, of the fish at and above it (np+)",
    "discard_ratio": "below the reference length, of the fish retained",
}
PARAMETERS: Final = {
    "l50_cm": "L50, cm",
    "sr_cm": "SR, cm",
    "l50_cm difference": "L50, cm",
    "sr_cm difference": "SR, cm",
    "between_sd_l50_cm": "L50 between hauls, standard deviation, cm",
    "between_sd_log_sr": "ln SR between hauls, standard deviation",
    "between_sd_logit_split": "logit of the split between hauls, standard deviation",
}
OF: Final = {"l50_cm": "L50, cm", "log_sr": "ln SR", "logit_split": "logit of the split"}
HEADS: Final = {
    "standard_error": "standard error",
    "lower_95": "lower 95 %",
    "upper_95": "upper 95 %",
    "log_likelihood": "log-likelihood",
    "aic": "AIC",
    "delta_aic": "above least AIC",
    "l50_cm": "L50 cm",
    "l50_standard_error_cm": "its standard error",
    "sr_cm": "SR cm",
    "sr_standard_error_cm": "its standard error",
    "p_value": "p",
    "n_fish": "fish",
    "pearson_chi2": "Pearson chi²",
    "degrees_of_freedom": "degrees of freedom",
    "gradient_norm": "gradient",
}


def write_fit(report: FitReport, folder: Path) -> list[Path]:
    """Write the tables, `fit_*.png` and `fit.html`.

    Raises:
        OSError: a file cannot be written.
    """
    written = []
    for name, table in report.tables.items():
        written.append(folder / f"{name}.csv")
        write_table(table, written[-1])
    figures = {}
    for name, draw in _drawings(report).items():
        with own_look():
            picture = png(draw())
        path = folder / f"fit_{name}.png"
        write_bytes(picture, path)
        written.append(path)
        caption = CAPTIONS[name]
        if name == "curve" and report.fit is not None:
            caption += CAPTIONS["grey"] * bool(report.fit.model.random)
            caption += CAPTIONS["paired"] * (report.fit.model.design == "paired")
        figures[name] = PageFigure(picture, caption)
    written.append(folder / "fit.html")
    with whole_file(written[-1]) as temporary:
        temporary.write_text(fit_html(report, figures), encoding="utf-8")
    return written


def _drawings(report: FitReport) -> dict[str, Callable[[], Figure]]:
    drawn: dict[str, Callable[[], Figure]] = {}
    if (found := report.comparison) is not None:
        drawn["compare"] = lambda: comparison_plot(found)
    if (fit := report.fit) is not None and fit.converged:
        drawn["curve"] = lambda: curve_plot(fit)
        if fit.group:
            drawn["delta"] = lambda: delta_plot(fit)
        if len(fit.hauls) > 1:
            drawn["hauls"] = lambda: haul_plot(fit, report.hauls, report.covariates)
        drawn["residuals"] = lambda: residual_plot(fit)
    return drawn


def fit_html(report: FitReport, figures: Mapping[str, PageFigure]) -> str:
    """The page, everything from the table escaped: answers, their picture, estimates, differences, hauls, residuals."""
    sections = [Section("", figures=_some(figures, "compare", "curve")), _table(report, "fit")]
    sections += [
        Section("Differences of gears", figures=_some(figures, "delta")),
        _table(report, "compare"),
        _table(report, "usability"),
        _table(report, "coefficients"),
        Section("Hauls", figures=_some(figures, "hauls")),
        Section("Residuals", figures=_some(figures, "residuals")),
        _table(report, "curves"),
        _table(report, "diagnostics"),
    ]
    return rendered(
        "sections.html",
        title=report.title,
        summary=f"{report.summary} Written {datetime.now().astimezone():%d %B %Y, %H:%M %Z}.",
        lead=report.lead,
        warnings=report.warnings,
        notes=report.notes,
        sections=[section for section in sections if section is not None and (section.figures or section.rows)],
    )


def _some(figures: Mapping[str, PageFigure], *names: str) -> tuple[PageFigure, ...]:
    return tuple(figures[name] for name in names if name in figures)


def _table(report: FitReport, name: str) -> Section | None:
    """A table of the page; estimates without those of single hauls, which are drawn."""
    if name not in report.tables:
        return None
    table, (heading, text) = report.tables[name], SHOWN[name]
    if name == "fit":
        table = table[~table["group"].str.startswith("haul ")].drop(columns="curve")
        shown = table["parameter"].map(lambda name: PARAMETERS.get(name, name))
        answers_first = table["parameter"].isin(("a", "b")).to_numpy()
        table = table.assign(
            parameter=shown, order=answers_first, of=table["group"].ne(table["group"].shift()).cumsum()
        )
        table = table.sort_values(["of", "order"], kind="stable").drop(columns=["of", "order"])
        table = table.assign(group=table["group"].where(~table["group"].duplicated(), ""))
    if name == "diagnostics":
        table = table.drop(columns=["curve", "gradient_norm"])
    if name == "curves" and not table["note"].any():
        table = table.drop(columns="note")
    if name == "usability":
        table = table.drop(columns=[] if table["gear"].any() else "gear")
        table = table.assign(indicator=table["indicator"].map(INDICATORS))
        text = f"Reference length {report.reference_length_cm:g} cm. {text}"
    if name == "coefficients":
        p_value = table["p_value"].map(lambda p: "< 0.0001" if p < 1e-4 else number_text(p, 2))
        table = table.assign(of=table["of"].map(OF), p_value=p_value)
    words = tuple(table[column].dtype.kind not in "fiu" for column in table.columns)
    rows = tuple(tuple(map(_cell, row)) for row in table.itertuples(index=False))
    heads = tuple(HEADS.get(column, column.replace("_", " ")) for column in table.columns)
    return Section(heading, (text,) if text else (), heads, words, rows)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return number_text(value, 4) if abs(value) > SMALLEST or np.isnan(value) else "0"
    if isinstance(value, bool):
        return "yes" if value else "NO"
    return "" if str(value) == "<NA>" else str(value)
