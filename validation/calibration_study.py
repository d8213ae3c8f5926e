"""Simulated trials of a computed codend: calibration must find the numbers they were drawn with.

A codend of assumed sizes is computed, and hauls of assumed fish with it are simulated with known contact and spread of
sizes. Both are calibrated from another starting point. Printed: mean error with its Monte Carlo error, the share of
95 % intervals that hold the truth (binomial error +-0.04 with 100 trials), and failed calibrations.

Run as `python -m validation.calibration_study`; with `--write FILE` it writes one such trial as a table instead.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

import codend
from catch_models.fish import Species
from codend.plan.plan import load_plan
from codend.selectivity.escape.catches import catches_of, run_of
from codend.selectivity.escape.haul import Haul, hauls_of
from codend.selectivity.escape.species import example_species_path, load_species
from codend.selectivity.fits.fielddata import read_field_data
from codend.selectivity.predicted_and_observed.calibrate import calibrate
from codend.selectivity.predicted_and_observed.simulate import computed_trial

PLAN = Path(__file__).parent / "cases" / "commercial_100mm_double.toml"
TRUTH = {"behaviour.contact": 0.8, "spread.size": 0.08}
NAMES = ("contact", "spread")
LENGTH_CM = np.arange(12.0, 41.0)
SHARE_OF_LARGEST = np.array([0.25, 0.4, 0.55, 0.7, 0.85, 1.0])
FISH_A_CLASS, SPLIT = 25.0, 0.55
NOTE = """# SIMULATED, not measured: fish that do not exist, drawn from the retention this program computes for the plan
# validation/cases/commercial_100mm_double.toml and the assumed fish of `codend species`, but with contact 0.8 and
# spread.size 0.08. Six hauls, Poisson numbers, 25 fish a length class expected. Written by
# `python -m validation.calibration_study --write FILE`.
"""


def changed(species: Species, numbers: dict[str, float]) -> Species:
    """A species with other values of some numbers."""
    tables = species.model_dump(exclude_none=True)
    for name, value in numbers.items():
        table, key = name.split(".")
        tables[table][key] = {"value": value, "source": "assumed: truth of a simulation"}
    return Species.model_validate(tables)


def computed_haul() -> Haul:
    """The plan's catches."""
    (haul,) = hauls_of(catches_of(run_of(codend.solve(load_plan(PLAN))), 15.0))
    return haul


@click.command(help=__doc__)
@click.option("--trials", default=100, show_default=True, help="Simulated trials of a design.")
@click.option("--seed", default=7, show_default=True)
@click.option("--write", "file", type=click.Path(path_type=Path), help="Write one covered-codend trial and stop.")
def main(trials: int, seed: int, file: Path | None) -> None:
    """Print the table, or write one trial."""
    haul, start = computed_haul(), load_species(example_species_path())
    true, rng = changed(start, TRUTH), np.random.default_rng(seed)
    volume, fish = SHARE_OF_LARGEST * haul.volume_m3[-1], np.full(len(LENGTH_CM), FISH_A_CLASS)

    def trial(design: str, split: float = 0.5):
        sizes = {
            "volume_m3": volume,
            "length_cm": LENGTH_CM,
            "expected_fish": fish * (2.0 if design == "paired" else 1.0),
        }
        return computed_trial(haul, true, design, rng=rng, split=split, **sizes)

    if file is not None:
        file.write_text(NOTE + trial("covered").round(4).to_csv(index=False), encoding="utf-8")
        return
    click.echo(f"{'design':28s} {'number':18s} {'truth':>6s} {'mean error':>18s} {'coverage':>9s} {'failed':>6s}")
    for design, split in (("covered", 0.5), ("paired", 0.5), ("paired", SPLIT)):
        estimated = split != 0.5
        found = [
            calibrate(
                haul,
                start,
                read_field_data(trial(design, split), design),
                NAMES,
                estimate_split=estimated,
                volume_m3=volume,
            )
            for _ in range(trials)
        ]
        good = [one for one in found if one.converged]
        truth = TRUTH | ({"split": split} if estimated else {})
        for i, (name, value) in enumerate(truth.items()):
            error = np.array([one.values[i] for one in good]) - value
            held = np.mean([one.lower_95[i] <= value <= one.upper_95[i] for one in good])
            spread = error.std(ddof=1) / np.sqrt(len(good))
            label = design + ", split estimated" * estimated
            text = f"{label:28s} {name:18s} {value:6.3f} {error.mean():+8.4f} +- {spread:.4f}"
            click.echo(f"{text} {held:9.3f} {trials - len(good):6d}")


if __name__ == "__main__":
    main()
