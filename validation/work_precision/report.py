"""The section of the validation report on work against precision: text, charts, data and verdicts."""

import numpy as np
import pandas as pd

from codend.report.speed_plot import speed_figure
from codend.studies.speed_accuracy.choices import choices
from codend.studies.speed_accuracy.measuring import ACCURACIES, QUANTITIES, Measured, measure
from validation.section import Picture, Section, Verdict
from validation.work_precision import words
from validation.work_precision.orders import growth, orders
from validation.work_precision.scenes import next_of_a_series_ms, scenes, weighed_scene

CONFIRMED = 1e-7
"""Relative distance within which a sector's relaxation must confirm the reference."""
CONFIRMED_BY_FULL_NET = 1e-5
"""The same for a full net solved to a residual of 1e-6, whose drag is that much less exact."""
SLOWER = 3.0
"""The automatic choice may take this many times as long as the fastest answer that is exact enough."""
AT_ONCE_MS = 10.0
"""Or as much longer: nobody waits for that."""
ORDER = (1.6, 2.4)


def section(quick: bool) -> Section:
    """Error in drag, opening and volume against solve time for every method, and whether the automatic choice fits.

    Args:
        quick: the same bags with fewer and larger meshes, and fewer settings.
    """
    symmetric = tuple(measure(scene, quick) for scene in scenes(quick))
    weighed = measure(weighed_scene(quick), quick)
    everything = (*symmetric, weighed)
    chosen = pd.concat([choices(measured) for measured in everything], ignore_index=True)
    points = pd.concat([measured.points for measured in everything], ignore_index=True)
    by_order = {measured.scene.name: orders(measured.points) for measured in everything}
    series_ms = {measured.scene.name: next_of_a_series_ms(measured.scene) for measured in symmetric}
    exponents = {measured.scene.name: growth(measured.points) for measured in symmetric}
    verdicts = [_confirmed(everything), _covered(points), _exact_enough(chosen)]
    if not quick:  # small nets have few meshes to merge, and everything takes milliseconds
        verdicts += [_fast_enough(chosen), _second_order(by_order)]
    return Section(
        title="Work against precision",
        text=words.text(everything, chosen, by_order, series_ms, exponents, (SLOWER, AT_ONCE_MS), quick),
        pictures=tuple(
            Picture(f"work_precision_{short}", speed_figure(symmetric, short), words.caption(short))
            for short in QUANTITIES.values()
        ),
        data={
            "work_precision": points,
            "work_precision_choices": chosen,
            "work_precision_orders": pd.concat(by_order, names=["scene", "pair"]).reset_index(),
        },
        verdicts=tuple(verdicts),
    )


def _confirmed(everything: tuple[Measured, ...]) -> Verdict:
    found, passed = [], True
    for measured in everything:
        for _, row in measured.confirmations.iterrows():
            worst = float(row[list(QUANTITIES.values())].fillna(np.inf).max())
            passed &= worst <= (CONFIRMED if row["model"] == "sector" else CONFIRMED_BY_FULL_NET)
            found.append(f"{measured.scene.name}, {row['model']} by {row['method']}: {worst:.1e}")
        passed &= len(measured.confirmations) > 0
    claim = (
        f"Every reference is confirmed by a second method: within {CONFIRMED:.0e} by a sector's relaxation, within "
        f"{CONFIRMED_BY_FULL_NET:.0e} by a full net solved to a residual of 1e-6, in drag, opening and volume."
    )
    return Verdict(claim, passed, "; ".join(found))


def _covered(points: pd.DataFrame) -> Verdict:
    """Whether what a result claims covers its true error, for results that say they converged."""
    converged = points[points["outcome"] == "converged"]
    claims = [f"{short}_{part}" for short in QUANTITIES.values() for part in ("claimed", "error")]
    missing = int(converged[claims].isna().any(axis=1).sum())
    share = {
        short: float((converged[f"{short}_error"] / converged[f"{short}_claimed"]).max())
        for short in QUANTITIES.values()
    }
    return Verdict(
        "No result that says it converged is further off than the error estimate it carries, and none is without one.",
        missing == 0 and all(worst <= 1.0 for worst in share.values()),
        f"{len(converged)} results, {missing} without an estimate; largest true error over the estimate: "
        + ", ".join(f"{short} {worst:.2f}" for short, worst in share.items()),
    )


def _exact_enough(chosen: pd.DataFrame) -> Verdict:
    worst = (chosen["chosen_drag_error"] / chosen["accuracy"]).fillna(np.inf).max()
    asked = ", ".join(words.percent(accuracy) for accuracy in ACCURACIES)
    return Verdict(
        f"The automatic choice meets each accuracy asked for in drag: {asked}.",
        bool(worst <= 1.0),
        f"largest error over the accuracy asked for: {worst:.2g}",
    )


def _fast_enough(chosen: pd.DataFrame) -> Verdict:
    longer = chosen["chosen_ms"] - chosen["fastest_ms"]
    in_time = (chosen["ratio"] <= SLOWER) | (longer <= AT_ONCE_MS)  # nan, where nothing was found, is not
    told = chosen if in_time.all() else chosen[~in_time]
    worst = told.loc[told["ratio"].fillna(np.inf).idxmax()]
    return Verdict(
        f"The automatic choice takes at most {SLOWER:g} times as long as the fastest answer that is exact enough, or "
        f"at most {AT_ONCE_MS:g} ms longer.",
        bool(in_time.all()),
        f"slowest: {worst['ratio']:.1f} times, {worst['scene']} at {words.percent(worst['accuracy'])}, "
        f"{worst['chosen']} in {worst['chosen_ms']:.1f} ms against {worst['fastest']} in {worst['fastest_ms']:.1f} ms",
    )


def _second_order(by_order: dict[str, pd.DataFrame]) -> Verdict:
    """Judged where fewest meshes are merged, in the mean of the scenes: single quantities may pass through nought."""
    finest = pd.DataFrame({name: table.iloc[-1] for name, table in by_order.items()}).T
    mean = finest[list(QUANTITIES.values())].mean()
    return Verdict(
        "The error of merging g x g meshes falls with g^2 - 1: the order, counted in sqrt(g^2 - 1) between the two "
        f"smallest g, lies between {ORDER[0]} and {ORDER[1]} in the mean of the scenes.",
        bool(mean.between(*ORDER).all()),
        ", ".join(f"{short} {order:.2f}" for short, order in mean.items()),
    )
