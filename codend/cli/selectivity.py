"""Commands on predicted selectivity: selectivity and species. Heavy libraries are imported where used."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codend.cli.common import NOT_CONVERGED, check_writable, haul_options, written_into
from codend.cli.console import shown_progress, text_table
from codend.errors import OPTIONS, InputError

if TYPE_CHECKING:
    from catch_models.fish import Species
    from codend.selectivity.predicted_and_observed.retention_likelihood import Trialled
    from codend.selectivity.predicted_and_observed.together import Together


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--species", "files", multiple=True, required=True, metavar="FILE.toml", help="May be repeated.")
@click.option("--bootstrap", "replicates", default=1000, show_default=True, help="Hauls drawn; 0 for none.")
@click.option("--samples", default=128, show_default=True, help="Of the ranking by variance: a power of 2; 0 for none.")
@click.option("--seed", default=0, show_default=True, help="Of both.")
@click.option("--field", metavar="DATA.csv", help="Hauls with this codend: sets the fitted curve beside the predicted.")
@click.option("--design", help="Of the field data: covered or paired.")
@click.option("--curve", default="logit", show_default=True, help="Fitted to the field data, as in codend fit.")
@click.option("--split", default="equal", show_default=True, help="Of paired gear: equal or estimated.")
@click.option(
    "--calibrate",
    "calibrated",
    metavar="NAME,...",
    help="Numbers of the species to estimate from the field data: contact, spread (of sizes), shape, attempts, "
    "rotation_deg, push, compression.",
)
@click.option(
    "--also",
    "others",
    nargs=2,
    multiple=True,
    metavar="DIR DATA.csv",
    help="Another run and hauls with its codend, to calibrate on jointly; may be repeated.",
)
@haul_options
def selectivity(
    folder: Path,
    files: tuple[str, ...],
    replicates: int,
    samples: int,
    seed: int,
    field: str | None,
    calibrated: str | None,
    others: tuple[tuple[str, str], ...],
    **choices: Any,
) -> int:
    """Predict which fish the codend of a run in DIR retains, from the computed openings and the fish's sections.

    Writes selectivity.csv, retention.csv, sensitivity.csv and plots into DIR, and a section into its report.html.
    `codend species` shows an example of a species file.

    With --field, together.csv and together_l50.csv hold predicted and fitted retention and L50 against the catch (of
    each haul, from a column catch_volume_m3 or catch_kg), and a plot shows both. L50 is compared between the same fits
    at the same catches: to the field's fish, and to those fish retained as computed. With --calibrate, calibration.csv
    holds the estimates, and calibrated_species.toml the species with them, unless no values of the numbers explain the
    hauls. Status 3 when a fit did not converge or explains nothing.
    """
    for key, value, good, allowed in (
        ("--bootstrap", replicates, replicates >= 0, "0 or more"),
        ("--samples", samples, samples >= 0 and samples & (samples - 1) == 0, "a power of 2, or 0"),
        ("--design", choices["design"], (field is None) == (choices["design"] is None), "together with --field"),
        ("--calibrate", calibrated, calibrated is None or field is not None, "together with --field"),
        ("--also", others, not others or calibrated is not None, "together with --calibrate"),
    ):
        if not good:
            raise InputError(OPTIONS, key, value, allowed)
    from codend.selectivity.escape.catches import read_run
    from codend.selectivity.escape.predict import predict
    from codend.selectivity.escape.species import load_species

    species = [load_species(file) for file in files]
    from codend.report.selectivity_page import FILES, write_selectivity
    from codend.report.selectivity_words import answers, notes
    from codend.selectivity.escape.tables import HAUL, selectivity_table

    check_writable(folder, FILES)
    read = read_run(folder)
    also: list[Trialled] = []
    trial, names = None, calibrated.split(",") if calibrated is not None else []
    if field is not None:
        from codend.selectivity.predicted_and_observed.calibrate import calibrated_names
        from codend.selectivity.predicted_and_observed.trial import check_selection, read_trial, set_beside

        if calibrated is not None:
            calibrated_names(names)  # a name that will not do ends the command before the work
        trial = read_trial(field, read.plan.catch_density_kg_m3, **choices)
        check_selection(trial)
        also = [_trialled(other, data, species, choices) for other, data in others]
    with shown_progress() as progress:
        found = predict(read, species, n_bootstrap=replicates, samples=samples, seed=seed, progress=progress)
    split = choices["split"] == "estimated"
    together = set_beside(found, trial, names, estimate_split=split, also=also) if trial else []
    with written_into(folder):
        written = write_selectivity(found, folder, together)
    for note in trial.data.notes if trial else ():
        click.echo(note)
    table = selectivity_table(found)
    columns = ["species", "l50_logit_cm", "l50_lower_95_cm", "l50_upper_95_cm"]
    columns += ["sr_logit_cm", "sr_lower_95_cm", "sr_upper_95_cm", "speed_m_s", "catch_volume_m3", "opening_ahead_deg"]
    headers = ["species", "L50 cm", "lower 95 %", "upper", "SR cm", "lower 95 %", "upper"]
    headers += ["speed m/s", "ends with m3", "mean opening deg"]
    whole = table["case"] == HAUL
    for answer in answers(found):
        click.echo(answer)
    click.echo("as a trial would report it: a logit curve fitted to the whole haul")
    click.echo(text_table(headers, table.loc[whole, columns].itertuples(index=False)))
    columns = ["species", "speed_m_s", "catch_volume_m3", "l50_cm", "sr_cm", "haul_l50_cm", "haul_sr_cm"]
    columns += ["haul_l50_logit_cm", "haul_sr_logit_cm"]
    headers = ["species", "speed m/s", "m3", "L50 met", "SR met", "L50 haul", "SR haul", "L50 trial", "SR trial"]
    last = table[~whole].groupby(["species", "speed_m_s"], sort=False).tail(1)
    click.echo(
        "the largest catch (all are in selectivity.csv), in cm; met: fish that meet it, haul: hauls that end with it, "
        "both off the computed curve, trial: a logit curve fitted to such hauls"
    )
    click.echo(text_table(headers, last[columns].itertuples(index=False)))
    for note in notes(found):
        click.echo(note)
    status = _print_together(together)
    click.echo(f"{len(written)} files written into {folder}")
    return status


def _trialled(folder: str, data: str, species: "Sequence[Species]", choices: dict[str, Any]) -> "Trialled":
    """Another run at one speed, and the hauls with its codend."""
    from codend.selectivity.escape.catches import read_run
    from codend.selectivity.escape.predict import hauls_for
    from codend.selectivity.predicted_and_observed.retention_likelihood import Trialled
    from codend.selectivity.predicted_and_observed.trial import check_selection, read_trial

    run = read_run(folder)
    hauls = hauls_for(run, species)
    if len(hauls) > 1:
        raise InputError(OPTIONS, "--also", folder, "a run at one speed", f"has {len(hauls)} speeds")
    trial = read_trial(data, run.plan.catch_density_kg_m3, **choices)
    check_selection(trial)
    return Trialled(hauls[0], trial.data, trial.volume_m3)


def _print_together(many: "Sequence[Together]") -> int:
    """Predicted beside fitted, and the calibration; the exit status."""
    if not many:
        return 0
    from codend.selectivity.predicted_and_observed.together import calibration_table
    from codend.selectivity.predicted_and_observed.together_l50 import together_l50_table

    table = together_l50_table(many)
    means = table[table["what"].str.endswith("field mean")]
    columns = ["species", "what", "l50_of", "catch_volume_m3", "l50_cm", "l50_lower_95_cm", "l50_upper_95_cm", "sr_cm"]
    headers = ["species", "mean of hauls", "L50 and SR of", "mean m3", "L50 cm", "lower 95 %", "upper", "SR cm"]
    click.echo(text_table(headers, means[columns].itertuples(index=False)))
    if not means["what"].str.startswith("predicted").any():
        click.echo("no prediction stands beside the field mean: a field haul's catch is larger than any computed")
    good = True
    for one in many:
        good &= one.trial.fit.converged
        if not one.trial.fit.converged:
            click.echo(f"the field data were not fitted: {one.trial.fit.pooled.outcome.value}", err=True)
        if one.calibration is not None:
            found = calibration_table(one.calibration)
            columns = ["parameter", "estimate", "lower_95", "upper_95", "identified"]
            headers = ["calibrated", "estimate", "lower 95 %", "upper 95 %", "identified"]
            click.echo(text_table(headers, found[columns].itertuples(index=False)))
            fit = f"deviance {one.calibration.deviance:.4g} on {one.calibration.degrees_of_freedom}"
            click.echo(f"calibration: {one.calibration.message}; {fit}, p = {one.calibration.p_value:.2g}")
            good &= one.calibration.explains
    return 0 if good else NOT_CONVERGED


@click.command()
@click.argument("name", default="example", metavar="[NAME]")
def species(name: str) -> None:
    """Print a species file: save it, and put in the numbers of your species.

    NAME is example, which is left out, of no fish and every number in it assumed; or red-mullet, of which the section
    was measured, by a source that is named, and all else is assumed.
    """
    from codend.selectivity.escape.species import SHIPPED_SPECIES, shipped_species_path

    if name not in SHIPPED_SPECIES:
        raise InputError(OPTIONS, "NAME", name, " or ".join(SHIPPED_SPECIES))
    click.echo(shipped_species_path(name).read_text(encoding="utf-8"), nl=False)
