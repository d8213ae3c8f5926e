"""Sentences on predicted selectivity: the answer, and what a reader must know before using it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from catch_models.fish import LAW_OF_PUSH, PARAMETERS, Species
from codend.selectivity.escape.crowd_kernels import tried_shares
from codend.selectivity.escape.haul import trying_of
from codend.selectivity.escape.predict import Prediction
from codend.selectivity.predicted_and_observed.together import Together


def answers(predictions: Sequence[Prediction]) -> list[str]:
    """What a trial of each codend and species would report, a line each."""
    found = []
    for one in predictions:
        name = f"{one.species.name} at {one.haul.speed_m_s:g} m/s"
        numbers = l50_and_sr(one)
        if not numbers:
            found.append(f"{name}: no L50: {why_none(one)}.")
            continue
        said = [
            f"{what} {value} cm (95 % {within})" if within else f"{what} {value} cm" for what, value, within in numbers
        ]
        found.append(
            f"{name}: {', '.join(said)}, as a trial would report it: a logit curve fitted to whole hauls that end with "
            f"{one.haul.volume_m3[-1]:.3g} m³."
        )
    return found


def l50_and_sr(found: Prediction) -> list[tuple[str, str, str]]:
    """L50 and SR that a trial would report, each by name, in cm and with its interval; none without an L50."""
    values, lower, upper = found.logit[-1], found.lower_95[-1], found.upper_95[-1]
    if not np.isfinite(values[0]):
        return []
    return [
        (what, f"{value:.1f}", f"{low:.1f} to {high:.1f}" if np.isfinite(low) else "")
        for what, value, low, high in zip(("L50", "SR"), values, lower, upper, strict=True)
    ]


def why_none(found: Prediction) -> str:
    """Why the whole haul has no L50."""
    first, last = found.length_cm[0], found.length_cm[-1]
    if found.retention[-1].max() < 0.5:
        return f"fewer than half of the fish are retained even at {last:g} cm, the longest tabled"
    if found.retention[-1].min() > 0.5:
        return f"more than half of the fish are retained even at {first:g} cm, the shortest tabled"
    return f"the logit curve is none, or crosses one half beyond the lengths of {first:g} to {last:g} cm"


def notes(predictions: Sequence[Prediction]) -> list[str]:
    """What a reader must know before using the numbers."""
    found = []
    for species in {id(p.species): p.species for p in predictions}.values():
        if species.assumed:
            found.append(f"{species.name}: assumed, not measured: {', '.join(species.assumed)}.")
        push = float(species.values[PARAMETERS.index("behaviour.push_force_n")])
        found.append(f"{species.name}: {_push_words(species, push)}")
    for one in predictions:
        found += [*_part_words(one), *_idle_zones(one)]
        if not all(np.isfinite(catch.opening_error_deg) for catch in one.haul.catches):
            found.append(f"{one.species.name}: the openings have no error estimate, so the intervals hold none of it.")
        elif not np.isfinite(one.opening_reach).all():
            found.append(
                f"{one.species.name}: some catches have no L50, so it is not known what the error of the openings does."
            )
        if any(catch.smeared for catch in one.haul.catches):
            found.append(
                f"{one.species.name}: the ropes of this run are smeared over all meshes, so fish meet the mean opening "
                "of each row: near ropes and between them meshes open otherwise, and no interval holds what that does."
            )
        early = one.haul.time(one.species)[0]
        if len(one.haul.catches) == 1:
            found.append(f"{one.species.name}: a single catch was computed, and stands for the whole haul.")
        elif early > 0.1:
            found.append(
                f"{one.species.name} at {one.haul.speed_m_s:g} m/s: {early:.0%} of the haul comes before the smallest "
                "catch computed, and is given its openings."
            )
    return found


def _push_words(species: Species, push_n: float) -> str:
    """How hard fish push, and what they push against."""
    if push_n == 0.0:
        return "no push: every mesh is taken as rigid, open as far as the catch opens it."
    at, power = (float(species.values[PARAMETERS.index(name)]) for name in LAW_OF_PUSH[::-1])
    return (
        f"a fish of length L pushes with at most {push_n:.3g} N (L / {at:g} cm)^{power:g}, against the tension and "
        "bending of the mesh and, where the plan gives axial_stiffness_n, the netting around it."
    )


def _part_words(found: Prediction) -> list[str]:
    """Sections, panels and windows ahead of the largest catch, and which of them fish try; nothing of a single one."""
    if len(found.haul.parts) < 2:
        return []
    crowd, last = found.haul.crowd, len(found.haul.catches) - 1
    first, end = int(crowd.start[last]), int(crowd.start[last + 1])
    rows = float(found.species.values[PARAMETERS.index("behaviour.rows_ahead")])
    tried = tried_shares(crowd, first, end, rows, trying_of(found.haul, found.species))
    words = []
    for number, part in enumerate(found.haul.parts):
        own = crowd.part[first:end] == number
        name = f"{part.section} {part.panel}".strip()
        if not own.any():
            continue
        opening = float(np.degrees(2.0 * np.mean(crowd.half_angle[first:end][own])))
        share = float(tried[own].sum())
        why = (
            "" if share > 0.0 else "; fish try none of it: it is shut, or beyond the rows they try, and has no [[zone]]"
        )
        words.append(f"{name}: open {opening:.0f} degrees on average, {share:.0%} of the attempts in its zone{why}")
    return [f"{found.species.name}, with the largest catch: {'; '.join(words)}."]


def _idle_zones(found: Prediction) -> list[str]:
    """Zones of the species that are of no part of the codend, or of parts that an earlier one has: without effect."""
    used = set(trying_of(found.haul, found.species).zone.tolist())
    parts = ", ".join(f"{part.section} {part.panel}".strip() for part in found.haul.parts)
    return [
        f"{found.species.name}: its [[zone]] {f'{one.section} {one.panel or str()}'.strip()} has no effect: of the "
        f"codend's parts ({parts}) none is left for it."
        for number, one in enumerate(found.species.zone, start=1)
        if number not in used
    ]


def field_notes(together: Sequence[Together]) -> list[str]:
    """What the trial is, and what was calibrated on it."""
    found = []
    for one in together[:1]:
        data, kind = one.trial.data, "simulated" if one.trial.simulated else "counted in the field"
        fish = int(one.fish.sum())
        found.append(
            f"Trial: {Path(data.source).name}, {data.design}, hauls: {len(data.haul_names)}, {fish} fish {kind}."
        )
        if not one.trial.fit.converged:
            found.append(f"No curve was fitted to it: {one.trial.fit.pooled.outcome.value}.")
        if one.calibration is not None:
            numbers = zip(
                one.calibration.names,
                one.calibration.values,
                one.calibration.lower_95,
                one.calibration.upper_95,
                one.calibration.identified,
                strict=True,
            )
            said = [
                f"{name} {value:.3g} (95 % {lower:.3g} to {upper:.3g})" + " not identified" * (not known)
                for name, value, lower, upper, known in numbers
            ]
            values = f"{'; '.join(said)}; " if one.calibration.explains else ""
            fit = f"deviance {one.calibration.deviance:.4g} on {one.calibration.degrees_of_freedom} degrees of freedom"
            found.append(
                f"Calibrated on it: {values}{one.calibration.message}; {fit}, p = {one.calibration.p_value:.2g}."
            )
    return found
