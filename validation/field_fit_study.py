"""Simulated trials of hauls that differ: bias, coverage and failures of every answer that `codend fit` prints.

Fifteen hauls, lengths 20 to 44 cm normal about 32 (standard deviation 5), L50 32 cm, SR 5 cm, L50 between hauls with
standard deviation 1.5 cm, paired gear with split 0.5 estimated, so many fish meeting each gear in a haul. Of the answer
printed first the bias is to stay below 0.3 cm in L50 and 0.5 cm in SR from 120 fish up (below, that of the median), and
its 95 % intervals are to hold the truth 90 to 97 times in 100. A trial without numbers says why.

Run as `python -m validation.field_fit_study`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import click
import numpy as np

from codend.selectivity.fits.analysis import fit_field_data
from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.predicted_and_observed.simulate import SimulatedTrial, parameters_of

LENGTH_CM = np.arange(20.0, 45.0)
SHARES = np.exp(-0.5 * ((LENGTH_CM - 32.0) / 5.0) ** 2)
SHARES /= SHARES.sum()
L50_CM, SR_CM, BETWEEN_SD_CM, HAULS = 32.0, 5.0, 1.5, 15
TRUTHS = {"l50_cm": L50_CM, "sr_cm": SR_CM, "split": 0.5, "between_sd_l50_cm": BETWEEN_SD_CM}
FISH = (30, 60, 120, 300, 1000)
HEADER = "design    fish answer         parameter           truth    mean  median coverage without"


@dataclass(frozen=True)
class Answer:
    """Estimates of one method in one trial, by parameter: value and limits; what it said, if it had none."""

    values: dict[str, tuple[float, float, float]]
    said: str


def simulated(design: str, fish: float, seed: int) -> FieldData:
    """A trial with the stated truth."""
    parameters = parameters_of("logit", L50_CM, SR_CM)
    between = np.diag([(BETWEEN_SD_CM * parameters[1]) ** 2, 0.0])  # a shift of a by b x moves L50 by -x
    met = (2.0 if design == "paired" else 1.0) * fish * SHARES
    trial = SimulatedTrial("logit", parameters, design, LENGTH_CM, met, HAULS, between_covariance=between)
    test, other = trial.counts(1, np.random.default_rng([seed, int(fish), design == "paired"]))
    return replace(trial.rows(), test_count=test[0], other_count=other[0])


def answers(seed: int, design: str, fish: float, replicates: int) -> dict[str, Answer]:
    """All answers to one trial, in the order in which they are printed."""
    split = "estimated" if design == "paired" else "equal"
    fitted = fit_field_data(simulated(design, fish, seed), design, split=split, n_bootstrap=replicates, seed=seed)
    found = {}
    for name, one, _, said in fitted.answers:
        values = {
            parameter: (one.values[i], one.lower_95[i], one.upper_95[i])
            for i, parameter in enumerate(one.names)
            if parameter in TRUTHS
        }
        found[name] = Answer(values, said)
    return found


def table_lines(design: str, fish: float, trials: Iterable[dict[str, Answer]]) -> list[str]:
    """Rows of the table for one design and number of fish, and the words of trials that had no number."""
    trials, lines = list(trials), []
    complete = max(trials, key=len)  # a method that was not tried, for what another said, has no numbers either
    for name, whole in complete.items():
        for parameter in whole.values:
            nothing = dict.fromkeys(whole.values, (np.nan,) * 3)
            got = np.array([(trial[name].values if name in trial else nothing)[parameter] for trial in trials])
            truth, good = TRUTHS[parameter], np.isfinite(got[:, 0])
            value, lower, upper = got[good].T
            limits = np.isfinite(lower) & np.isfinite(upper)
            held = ((lower <= truth) & (truth <= upper))[limits].mean() if limits.any() else np.nan
            mean, median = (value.mean(), np.median(value)) if good.any() else (np.nan, np.nan)
            lines.append(
                f"{design:8s} {fish:5g} {name:14s} {parameter:18s} {truth:6.2f} {mean:7.2f} {median:7.2f} {held:8.3f} "
                f"{(~good).sum():7d}"
            )
        answers = [trial.get(name, next(reversed(trial.values()))) for trial in trials]
        silent = Counter(one.said for one in answers if not np.isfinite(one.values["l50_cm"][0]))
        lines += [f"    {count} of {len(trials)} {name}: {said or 'SILENT'}" for said, count in silent.items()]
    return lines


@click.command(help=__doc__)
@click.option("--trials", default=200, show_default=True, help="Simulated trials of a kind.")
@click.option("--fish", multiple=True, type=float, default=FISH, show_default=True, help="Meeting each gear in a haul.")
@click.option("--design", "designs", multiple=True, default=("paired", "covered"), show_default=True)
@click.option("--replicates", default=200, show_default=True, help="Bootstrap replicates of a trial.")
@click.option("--workers", default=2, show_default=True)
def main(trials: int, fish: tuple[float, ...], designs: tuple[str, ...], replicates: int, workers: int) -> None:
    """Print the table."""
    click.echo(HEADER)
    with ProcessPoolExecutor(workers) as pool:
        for design in designs:
            for number in fish:
                one = partial(answers, design=design, fish=number, replicates=replicates)
                for line in table_lines(design, number, pool.map(one, range(trials), chunksize=4)):
                    click.echo(line)


if __name__ == "__main__":
    main()
