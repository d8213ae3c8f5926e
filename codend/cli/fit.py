"""The command on fish counted in the field. Heavy libraries are imported where the command uses them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codend.cli.common import NOT_CONVERGED, check_writable, haul_options, out_option, written_into
from codend.cli.console import ShownProgress, shown_progress, text_table
from codend.errors import OPTIONS, InputError

if TYPE_CHECKING:
    import pandas as pd

    from codend.report.fit_page import FitReport
    from codend.selectivity.fits.analysis import FieldFit
    from codend.selectivity.fits.gears import GearFit
    from codend.selectivity.fits.haul_table import HaulReading

HEADERS = ["group", "parameter", "estimate", "standard error", "lower 95 %", "upper 95 %", "interval"]


@click.command()
@click.argument("data", metavar="DATA.csv")
@click.option("--design", required=True, help="covered (codend and cover) or paired (test and control gear).")
@click.option("--curve", default="logit", show_default=True, help="logit, probit, gompertz, cloglog, richards or dual.")
@click.option("--split", default="equal", show_default=True, help="Of paired gear: equal, estimated or a share.")
@click.option("--covariate", "covariates", multiple=True, metavar="NAME", help="A column; may be repeated.")
@click.option("--group", default="", metavar="COLUMN", help="Gears to set beside each other, by this column.")
@click.option("--l50", default="", metavar="FORMULA", help="What L50 depends on, such as 'gear * catch_kg'.")
@click.option("--sr", default="", metavar="FORMULA", help="What ln SR depends on.")
@click.option("--split-by", default="", metavar="FORMULA", help="What the logit of an estimated split depends on.")
@click.option(
    "--random",
    default="haul",
    show_default=True,
    metavar="UNIT[:TERMS]",
    help="What differs at random: haul, none or a column, and after a colon l50, sr, split.",
)
@click.option("--at", multiple=True, metavar="NAME=VALUE,...", help="Predict there as well; may be repeated.")
@click.option("--reference-length", type=float, metavar="CM", help="For usability indicators: the minimum size.")
@click.option("--compare", is_flag=True, help="Catch comparison of two gears that both select; no curve.")
@click.option(
    "--overdispersion",
    default="pearson",
    show_default=True,
    help="Widens errors of the pooled fit where it fits badly: pearson, deviance or none.",
)
@click.option("--bootstrap", "replicates", type=int, help="Double bootstrap; left out: none, with --compare 1000.")
@click.option("--seed", default=0, show_default=True, help="Of the bootstrap.")
@haul_options
@out_option
def fit(
    data: str,
    folder: Path,
    *,
    design: str,
    curve: str,
    compare: bool,
    replicates: int | None,
    seed: int,
    at: tuple[str, ...],
    reference_length: float | None,
    **choices: Any,
) -> int:
    """Fit retention curves to a covered-codend or paired-gear trial, or compare the catches of two gears.

    Writes fit.html, a page with the answer and its picture first, and tables and plots into DIR. Of several hauls the
    answer printed first is from one likelihood in which hauls differ. With --group, --l50, --sr, --split-by or the dual
    curve everything is in that likelihood. Status 3 when the first answer did not converge.
    """
    from codend.report.fit_page import FILES, write_fit

    check_writable(folder, FILES)
    if reference_length is not None and not reference_length > 0.0:
        raise InputError(OPTIONS, "--reference-length", reference_length, "a length above 0")
    with shown_progress() as progress:
        progress(0, 3, "fitting")
        if compare:
            report = _compared(
                data, design, 1000 if replicates is None else replicates, seed, choices["reading"], progress
            )
            good = True
        else:
            asked = {"curve": curve, "n_bootstrap": replicates or 0, "seed": seed, **choices}
            report, good = _fitted(data, design, asked, at, reference_length, progress)
        progress(2, 3, "pictures and page")
        with written_into(folder, FILES):
            written = write_fit(report, folder)
    _print(report)
    click.echo(f"{len(written)} files written into {folder}; fit.html is the page")
    return 0 if good else NOT_CONVERGED


def _fitted(
    data: str,
    design: str,
    asked: dict[str, Any],
    at: Sequence[str],
    reference_length: float | None,
    progress: ShownProgress,
) -> "tuple[FitReport, bool]":
    """Curves of a trial, or of gears and formulas in one likelihood, and whether the first answer converged."""
    formulas = {name: asked.pop(name) for name in ("group", "l50", "sr", "split_by")}
    if any(formulas.values()) or asked["curve"] == "dual":
        from codend.selectivity.fits.gears import fit_gears

        if replicates := asked.pop("n_bootstrap"):
            raise InputError(OPTIONS, "--bootstrap", replicates, "without --group, --l50, --sr, --split-by and dual")
        for name in ("seed", "overdispersion"):
            asked.pop(name)
        gears = fit_gears(data, design, **asked, **formulas)
        progress(1, 3, "every curve, predictions")
        return _gears_report(gears, at, reference_length), gears.converged
    from codend.selectivity.fits.analysis import fit_field_data

    fitted = fit_field_data(data, design, **asked, progress=progress)
    progress(1, 3, "every curve, predictions")
    return _trial_report(fitted, at, reference_length), fitted.converged


def _print(report: "FitReport") -> None:
    """Answers, their table, and what must be said."""
    for line in report.lead:
        click.echo(line)
    if "fit" in report.tables:
        table = report.tables["fit"]
        shown = table[~table["group"].str.startswith("haul ")].drop(columns="curve")
        fixed = (shown["parameter"] == "split") & shown["standard_error"].isna() & shown["estimate"].notna()
        shown = shown.assign(parameter=shown["parameter"].mask(fixed, "split, fixed"))
        click.echo(text_table(HEADERS, shown.itertuples(index=False)))
    if "usability" in report.tables:
        table = report.tables["usability"]
        headers = ["indicator", "%", "lower 95 %", "upper 95 %"]
        if not table["gear"].any():
            table = table.drop(columns="gear")
        click.echo(text_table(["gear", *headers][-len(table.columns) :], table.itertuples(index=False)))
    if "curves" in report.tables:
        table = report.tables["curves"]
        columns = ["curve", "parameters", "aic", "weight", "l50_cm", "sr_cm"]
        shown = table[columns].assign(parameters=table["parameters"].astype(float))
        click.echo(
            text_table(["curve", "parameters", "AIC", "weight", "L50 cm", "SR cm"], shown.itertuples(index=False))
        )
    for note in report.notes:
        click.echo(note)
    for warning in report.warnings:
        click.echo(warning, err=True)


def _trial_report(fitted: "FieldFit", at: Sequence[str], reference_length: float | None) -> "FitReport":
    from codend.report.fit_page import FitReport
    from codend.report.fit_words import lead, trial_notes, trial_summary, trial_warnings
    from codend.selectivity.fits.analysis import diagnostics_table, fit_table

    tables = {"fit": fit_table(fitted), "diagnostics": diagnostics_table(fitted)}
    shown = fitted.shown
    if shown is not None:
        tables |= _predicted(shown, at, reference_length)
    columns = [name for name, values in fitted.data.columns.items() if values.dtype.kind == "f" and _varies(values)]
    return FitReport(
        title=f"Selectivity of {Path(fitted.data.source).name}",
        summary=trial_summary(fitted),
        lead=[lead("", fitted.answers[0].estimates)],
        warnings=[*trial_warnings(fitted), *_far_behind(tables, fitted.pooled.model.curve.name)],
        notes=[*fitted.data.notes, *trial_notes(fitted)],
        tables=tables,
        fit=shown,
        hauls=fitted.hauls,
        reference_length_cm=reference_length or float("nan"),
        covariates=[
            *fitted.data.covariate_names,
            *(name for name in columns if name not in fitted.data.covariate_names),
        ],
    )


def _gears_report(fitted: "GearFit", at: Sequence[str], reference_length: float | None) -> "FitReport":
    from codend.report.fit_page import FitReport
    from codend.report.fit_words import at_mean_text, gear_summary, gear_warnings, lead, scatter_text
    from codend.selectivity.fits.gears import coefficient_table, gear_table
    from codend.selectivity.fits.one_stage_estimates import covariates, estimates_within
    from codend.selectivity.fits.predictions import delta_table

    one = fitted.one
    tables = {"fit": gear_table(fitted)}
    if one.converged:
        tables |= {"coefficients": coefficient_table(one), **_predicted(one, at, reference_length)}
        if one.group:
            tables["delta"] = delta_table(one)
    return FitReport(
        title=f"Selectivity of {Path(one.data.source).name}" + (f", by {one.group}" if one.group else ""),
        summary=gear_summary(fitted),
        lead=[lead(level, estimates_within(one, level)[0]) for level in one.levels],
        warnings=[*gear_warnings(fitted), *_far_behind(tables, one.model.family.name)],
        notes=[*one.data.notes, *([*at_mean_text(one), *scatter_text(one)] if one.converged else [])],
        tables=tables,
        fit=one if one.converged else None,
        hauls=fitted.hauls,
        reference_length_cm=reference_length or float("nan"),
        covariates=list(dict.fromkeys([*covariates(one, one.l50), *covariates(one, one.log_sr)])),
    )


def _compared(
    data: str, design: str, replicates: int, seed: int, reading: "HaulReading", progress: ShownProgress
) -> "FitReport":
    from codend.report.fit_page import FitReport
    from codend.report.fit_words import comparison_lead, comparison_notes, comparison_summary
    from codend.selectivity.fits.catch_comparison import compare_catches

    if design != "paired":
        raise InputError(OPTIONS, "--design", design, "paired, with --compare")
    found = compare_catches(data, replicates, seed, reading, progress)
    return FitReport(
        title=f"Catch comparison of {Path(found.data.source).name}",
        summary=comparison_summary(found),
        lead=comparison_lead(found),
        warnings=[],
        notes=[*found.data.notes, *comparison_notes(found)],
        tables={"compare": found.table()},
        comparison=found,
    )


def _predicted(fit: Any, at: Sequence[str], reference_length: float | None) -> "dict[str, pd.DataFrame]":
    """Tables of what a converged fit predicts: of every curve, at covariates, and the usability of its catch."""
    from codend.selectivity.fits.curve_table import choose_curve, curve_table
    from codend.selectivity.fits.predictions import prediction_table, settings, usability_table

    tables = {
        "predictions": prediction_table(fit, [{}, *settings(fit, at)]),
        "curves": curve_table(choose_curve(fit)),
    }
    if reference_length is not None:
        tables["usability"] = usability_table(fit, reference_length)
    return tables


def _far_behind(tables: "dict[str, pd.DataFrame]", curve: str) -> list[str]:
    from codend.report.fit_words import curve_warnings

    return curve_warnings(tables["curves"], curve) if "curves" in tables else []


def _varies(values: Any) -> bool:
    return bool((values != values[0]).any())
