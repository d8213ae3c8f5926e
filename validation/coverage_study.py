"""Simulated trials: the fits must find the truth, and their 95 % intervals hold it 95 times in 100.

Simulated trials with known curves are fitted and the estimates of L50, SR and split compared with the truth: mean error
(with its Monte Carlo error) and the share of intervals that hold the truth. With 1000 trials a share of 0.95 is known
to +-0.014 (two binomial standard errors). Failed fits are counted and left out.

Run as `python -m validation.coverage_study`.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import click
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from codend.selectivity.fits.between_hauls import fit_between_hauls
from codend.selectivity.fits.bootstrap import double_bootstrap
from codend.selectivity.fits.curves import CURVES
from codend.selectivity.fits.fit import fit_hauls, fit_pooled
from codend.selectivity.fits.model import selection_model
from codend.selectivity.fits.parameters import Estimates, parameter_names, public_parameters
from codend.selectivity.fits.scoring import maximise
from codend.selectivity.predicted_and_observed.simulate import SimulatedTrial, parameters_of

Array = NDArray[np.float64]

L50_CM, SR_CM, DELTA, SPLIT = 30.0, 5.0, 2.0, 0.55
LENGTH_CM = np.arange(15.0, 46.0)
SHAPE = np.exp(-0.5 * ((LENGTH_CM - 30.0) / 6.0) ** 2)
HEADER = f"{'trial':34s} {'parameter':9s} {'truth':>8s} {'mean error':>18s} {'coverage':>9s} {'failed':>6s}"


def line(trial: str, name: str, truth: float, *, values: Array, lower_95: Array, upper_95: Array) -> str:
    """One row of the table from the estimates and interval limits of all trials, NaN where a fit failed."""
    good = np.isfinite(lower_95)
    error = values[good] - truth
    spread = error.std(ddof=1) / np.sqrt(good.sum())
    coverage = ((lower_95[good] <= truth) & (truth <= upper_95[good])).mean()
    failed = int((~good).sum())
    return f"{trial:34s} {name:9s} {truth:8.3f} {error.mean():+8.4f} +- {spread:.4f} {coverage:9.3f} {failed:6d}"


def one_haul(
    curve: str, design: str, split: float, n_trials: int, rng: np.random.Generator, *, raising: float = 1.0
) -> None:
    """Delta-method intervals of fits to a single haul of about 1500 (covered) or 6000 (paired) fish."""
    estimated = split != 0.5
    shape = DELTA if CURVES[curve].has_shape else None
    fish = (100.0 if design == "covered" else 400.0) * raising * SHAPE
    trial = SimulatedTrial(
        curve, parameters_of(curve, L50_CM, SR_CM, shape), design, LENGTH_CM, fish, split=split, other_raising=raising
    )
    model = selection_model(trial.rows(), curve, estimated)
    maximum = maximise(model, *trial.counts(n_trials, rng))
    values, jacobian = public_parameters(model, maximum.theta)
    errors = np.sqrt(np.einsum("smi,sij,smj->sm", jacobian, maximum.covariance, jacobian))
    truths = {"l50_cm": L50_CM, "sr_cm": SR_CM} | ({"split": split} if estimated else {})
    label = (
        f"{design}, {curve}" + (", split estimated" if estimated else "") + (f", raised {raising:g}" * (raising > 1))
    )
    for name, truth in truths.items():
        i = parameter_names(model).index(name)
        half = ndtri(0.975) * errors[:, i]
        at = values[:, i]
        click.echo(line(label, name, truth, values=at, lower_95=at - half, upper_95=at + half))


def many_hauls(n_trials: int, n_replicates: int, rng: np.random.Generator) -> None:
    """Twelve hauls that differ: pooled fit with dispersion factor, double bootstrap, and Fryer's mean curve."""
    parameters = parameters_of("logit", L50_CM, SR_CM)
    # L50 with standard deviation 1.5 cm between hauls, the slope b 10 %, independently
    a_b_from_l50_b = np.array([[-parameters[1], -L50_CM], [0.0, 1.0]])
    between = a_b_from_l50_b @ np.diag([1.5**2, (0.1 * parameters[1]) ** 2]) @ a_b_from_l50_b.T
    trial = SimulatedTrial(
        "logit", parameters, "covered", LENGTH_CM, 40.0 * SHAPE, n_hauls=12, between_covariance=between
    )
    rows = trial.rows()
    model = selection_model(rows, "logit")
    # what pooling estimates is the curve of the mean retention, a little flatter than the curve of mean parameters
    shifts = np.random.default_rng(0).multivariate_normal(np.zeros(2), between, 100_000)
    mean_retention = np.tile(CURVES["logit"].retention(LENGTH_CM, parameters + shifts).mean(axis=0), 12)
    fish = np.tile(trial.expected_fish, 12)
    pooled_theta = maximise(model, (fish * mean_retention)[None], (fish * (1.0 - mean_retention))[None]).theta
    pooled_truth = public_parameters(model, pooled_theta)[0][0]

    found: dict[str, list[Estimates]] = {"pooled": [], "double bootstrap": [], "between hauls": []}
    for i, (test, other) in enumerate(zip(*trial.counts(n_trials, rng), strict=True)):
        data = replace(rows, test_count=test, other_count=other)
        pooled = fit_pooled(data, model)
        found["pooled"].append(pooled.estimates)
        found["double bootstrap"].append(double_bootstrap(data, pooled, n_replicates, seed=i).estimates)
        found["between hauls"].append(fit_between_hauls(data, model, fit_hauls(data, model)).estimates)
    names = parameter_names(model)
    for (method, estimates), name in product(found.items(), ("l50_cm", "sr_cm")):
        i = names.index(name)
        truth = {"l50_cm": L50_CM, "sr_cm": SR_CM}[name] if method == "between hauls" else float(pooled_truth[i])
        fields = ("values", "lower_95", "upper_95")
        columns = {field: np.array([getattr(e, field)[i] for e in estimates]) for field in fields}
        click.echo(line(f"12 hauls, {method}", name, truth, **columns))


@click.command(help=__doc__)
@click.option("--trials", default=1000, show_default=True, help="Simulated trials of a kind.")
@click.option("--replicates", default=500, show_default=True, help="Bootstrap replicates of a trial.")
@click.option("--seed", default=20240, show_default=True)
def main(trials: int, replicates: int, seed: int) -> None:
    """Print the table."""
    rng = np.random.default_rng(seed)
    click.echo(HEADER)
    for design, split in (("covered", 0.5), ("paired", 0.5), ("paired", SPLIT)):
        for curve in CURVES:
            one_haul(curve, design, split, trials, rng)
    one_haul("logit", "covered", 0.5, trials, rng, raising=4.0)
    many_hauls(trials, replicates, rng)


if __name__ == "__main__":
    main()
