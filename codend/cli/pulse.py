"""What ``codend scene`` does with a codend's plan: it pulses under a vessel that heaves."""

from itertools import product
from pathlib import Path

import click

from codend.cli.common import NOT_CONVERGED, Stopped, check_writable, explain_failures, written_into
from codend.cli.console import shown_progress, text_table
from codend.errors import InputError

FILES = ("pulse.csv", "pulse_range.csv", "pulse.png", "results.csv")
TABLE = {
    "case": "case",
    "period_s": "period s",
    "least_opening_ahead_deg": "opening least deg",
    "mean_opening_ahead_deg": "mean",
    "most_opening_ahead_deg": "most",
    "least_drag_n": "drag least N",
    "mean_drag_n": "mean",
    "most_drag_n": "most",
}
SNAPS = "where slack twine that does not stretch snaps taut, its pull is as large as the step is short"
UNLIKE_DEG = 1.0
SWINGS = "it has not come to a period, for want of time.periods or because it swings by itself, as stiff codends may"
ASSUMED = (
    "Assumed: the heave reaches the entry whole unless vessel.transmitted says less; the catch moves with the netting "
    "on it, with the added mass of a sphere of its volume; its pressure follows the speed without delay."
)


def pulse_codend(file: str, folder: Path, changes: tuple[str, ...], species_files: tuple[str, ...]) -> int:
    """Solve a plan's cases, let each pulse with every period of heave, and write what is seen."""
    from codend.plan.plan import load_plan

    plan = load_plan(file, changes)
    if plan.vessel is None:
        raise InputError(file, "vessel", None, "a table with heave_m and period_s, for a codend to pulse", "is missing")
    check_writable(folder, FILES)
    from codend.selectivity.escape.species import load_species

    species = [load_species(name) for name in species_files]
    import pandas as pd

    from codend.io.files import write_bytes, write_table
    from codend.report.own_look import own_look
    from codend.report.pulse_plot import pulse_plot
    from codend.report.style import png
    from codend.studies import study as studies
    from codend.studies.pulse import pulse, ranges

    with written_into(folder, FILES), own_look():
        with shown_progress() as progress:
            study = studies.solve(plan, progress)
            solved = [result for result in study.cases if result.converged]
            pulsing, failed = [], []
            for result, period in product(solved, plan.vessel.period_s):
                try:
                    pulsing.append(pulse(plan, result, period, progress))
                except ArithmeticError as error:
                    failed.append(f"case {result.case.number}, period {period:g} s: {error}")
            if failed and not pulsing:
                raise Stopped(f"{file}: {failed[0]}", NOT_CONVERGED)
        write_table(study.table, folder / "results.csv")
        if not pulsing:
            explain_failures(study)
            return NOT_CONVERGED
        table, found = pd.concat([one.table for one in pulsing]), ranges(study, pulsing, species)
        write_table(table, folder / "pulse.csv")
        write_table(found, folder / "pulse_range.csv")
        write_bytes(png(pulse_plot(table)), folder / "pulse.png")
    heads = {**TABLE, **{str(name): str(name) for name in found if str(name).endswith("_cm")}}
    click.echo(text_table(list(heads.values()), found[list(heads)].itertuples(index=False, name=None)))
    for one in pulsing:
        if not one.settled:
            of = f"case {one.least.case.number}, period {one.table['period_s'].iloc[0]:g} s"
            by = f"{one.off['opening_ahead_deg']:.2g} degrees and that of drag by {one.off['drag_n']:.3g} N"
            click.echo(f"Of {of}, steps half as long still changed the range of openings by {by}: {SNAPS}.")
        if one.unlike_before_deg > UNLIKE_DEG:
            of = f"case {one.least.case.number}, period {one.table['period_s'].iloc[0]:g} s"
            unlike = f"{one.unlike_before_deg:.2g} degrees"
            click.echo(f"Of {of}, openings ranged by {unlike} otherwise in the period before: {SWINGS}.")
    for number in dict.fromkeys(one.least.case.number for one in pulsing if one.least.unstable):
        click.echo(f"Case {number} would not keep the shape from which it pulses: stable = no in results.csv.")
    for said in failed:
        click.echo(f"Not followed: {said}.")
    click.echo(ASSUMED)
    explain_failures(study)
    return 0 if study.converged and not failed else NOT_CONVERGED
