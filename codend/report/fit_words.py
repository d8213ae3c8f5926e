"""What is said of fits to field data: the answer in a line, data and model in a sentence, what a reader must know."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from codend.selectivity.fits.choices import LEAST_UNITS
from codend.selectivity.fits.fielddata import FieldData
from codend.selectivity.fits.one_stage import OneStage, left_over_dispersion
from codend.selectivity.fits.parameters import Estimates

if TYPE_CHECKING:
    import pandas as pd

    from codend.selectivity.fits.analysis import FieldFit
    from codend.selectivity.fits.catch_comparison import CatchComparison
    from codend.selectivity.fits.gears import GearFit

FAR_BEHIND: Final = 10.0
"""Above the least AIC, beyond which a curve has essentially no support (Burnham and Anderson 2002, section 2.6)."""


def lead(level: str, found: Estimates) -> str:
    """The answer for a gear in one line, with 95 % intervals."""
    if np.isnan(found["l50_cm"]):
        text = "no L50"
    else:
        parts = []
        for name, of in (("L50", "l50_cm"), ("SR", "sr_cm")):
            i = found.names.index(of)
            lower, upper = found.lower_95[i], found.upper_95[i]
            ends = " to ".join(f"{end:.2f}" if np.isfinite(end) else "no limit" for end in (lower, upper))
            parts.append(f"{name} {found.values[i]:.2f} cm ({ends})")
        text = ", ".join(parts)
    return f"{level}: {text}" if level else text


def data_text(data: FieldData) -> str:
    """Hauls, fish, lengths and design."""
    fish, fished = float((data.test_count + data.other_count).sum()), data.test_count + data.other_count > 0.0
    gears = {"covered": "a covered codend", "paired": "paired gear"}[data.design]
    count = len(data.haul_names)
    lengths = data.length_cm[fished]
    raised = "" if np.ptp(data.log_offset) == 0.0 == data.log_offset[0] else ", raising factors as offsets"
    return (
        f"{gears}, {count} haul{'s' * (count > 1)}, {fish:,.0f} fish counted, lengths {lengths.min():g} to "
        f"{lengths.max():g} cm{raised}"
    )


def model_text(one: OneStage) -> str:
    """The one-stage model in words."""
    words = {"l50": "L50", "sr": "ln SR", "split": "the split's logit"}
    differ = [words[term] for term in one.model.random]
    unit = "hauls" if one.units == one.data.haul_names else "units"
    between = f"{' and '.join(differ)} differing between {unit} at random" if differ else "hauls that do not differ"
    parts = [f"{one.model.family.name} curve, one likelihood with {between}"]
    if one.model.design == "paired":
        parts.append("split estimated" if one.split else f"split fixed at {one.fixed_split:g}")
    formulas = [
        f"{name} ~ {part.formula.replace('`', '')}"
        for name, part in (("L50", one.l50), ("ln SR", one.log_sr), ("logit split", one.split))
        if part is not None and part.spec is not None
    ]
    return "; ".join([*parts, *formulas])


def scatter_text(one: OneStage) -> list[str]:
    """What scatter is left about the hauls' own curves, in a sentence; none where too few classes tell."""
    factor, degrees = left_over_dispersion(one)
    if np.isnan(factor):
        return []
    return [
        f"Scatter left about the hauls' own curves: {factor:.2g} times that of chance (Pearson, {degrees} degrees of "
        "freedom). It does not widen the errors in one stage, which hold the variation between hauls."
    ]


def few_hauls(data: FieldData, limits: str) -> list[str]:
    """What limits leave out that are of one haul or two; nothing of more."""
    count = len(data.haul_names)
    if count >= LEAST_UNITS:
        return []
    told = "One haul tells" if count == 1 else f"{count} hauls tell"
    return [f"{told} nothing of how hauls differ: {limits} are those of these fish, and too narrow for others."]


def at_mean_text(one: OneStage) -> list[str]:
    """Where L50 and SR are asked for that depend on columns; nothing where they depend on none but the group."""
    parts = [part for part in (one.l50, one.log_sr, one.split) if part is not None and part.spec is not None]
    named = {str(name) for part in parts for name in part.spec.required_variables} - {one.group}
    used = [str(name) for name in one.hauls.columns if name in named]
    if not used:
        return []
    found = []
    for name in used:
        column = one.hauls[name]
        if column.dtype.kind == "f":
            found.append(f"{name} = {column.mean():.4g}")
        else:
            counts = column.value_counts(sort=False)
            found.append(f"{name}: {', '.join(f'{value} in {count}' for value, count in counts.items())}")
    return [
        f"L50 and SR are at the mean of the {len(one.hauls)} hauls ({'; '.join(found)}); --at asks for other places."
    ]


def trial_summary(fitted: FieldFit) -> str:
    """Data and model."""
    shown = f" The answer is the {fitted.answers[0].group.replace('-', ' ')} fit: {_first_model(fitted)}."
    return f"{data_text(fitted.data)[0].upper()}{data_text(fitted.data)[1:]}.{shown}"


def _first_model(fitted: FieldFit) -> str:
    if fitted.one_stage is not None:
        return model_text(fitted.one_stage)
    return f"{fitted.pooled.model.curve.name} curve for all fish together"


def trial_warnings(fitted: FieldFit) -> list[str]:
    """Failures, hauls left out, and hauls without an L50 of their own."""
    silent = [fit for fit in fitted.hauls if fit.note]
    if not fitted.pooled.converged and fitted.one_stage is None:
        nor = f" (nor were {len(silent)} of {len(fitted.hauls)} hauls)" if silent else ""
        return [f"pooled was not fitted: {fitted.pooled.note}{nor}"]
    found = []
    for answer in fitted.answers:
        if answer.note:
            failed = "was not fitted" if np.isnan(answer.estimates.values).all() else "warning"
            found.append(f"{answer.group} {failed}: {answer.note}")
    found += _wide_range(fitted)
    if silent:
        names = ", ".join(fit.group.removeprefix("haul ") for fit in silent[:8]) + ", ..." * (len(silent) > 8)
        kept = " In one stage they count all the same." if fitted.one_stage is not None else ""
        share = f"{len(silent)} of {len(fitted.hauls)}"
        found.append(f"{share} hauls have no L50 of their own ({names}); diagnostics.csv says why.{kept}")
    return found


def _wide_range(fitted: FieldFit) -> list[str]:
    """A word where the answer's selection range is wider than the lengths that were measured."""
    sr = float(fitted.answers[0].estimates["sr_cm"])
    fished = fitted.data.length_cm[fitted.data.test_count + fitted.data.other_count > 0.0]
    span = float(np.ptp(fished))
    if not sr > span:
        return []
    return [f"SR of {sr:.3g} cm is wider than all lengths measured, {span:.3g} cm: L25 or L75 is no measurement"]


def trial_notes(fitted: FieldFit) -> list[str]:
    """Dispersion, and scatter left over."""
    notes, pooled, kind = [], fitted.pooled, fitted.overdispersion.capitalize()
    if pooled.converged:
        notes += few_hauls(fitted.data, "limits")
    if pooled.converged:
        if fitted.overdispersion == "none":
            notes.append("Pooled fit: no dispersion factor, as asked for.")
        elif pooled.dispersion > 1.0:
            notes.append(
                f"Pooled fit: its variances are multiplied by a dispersion factor of {pooled.dispersion:.3g} ({kind}); "
                "--overdispersion none turns that off."
            )
        else:
            notes.append(f"Pooled fit: no lack of fit by {kind}, dispersion factor 1.")
    if fitted.one_stage is not None and fitted.one_stage.converged:
        notes += [*at_mean_text(fitted.one_stage), *scatter_text(fitted.one_stage)]
    elif fitted.shown is not None:
        notes += at_mean_text(fitted.shown)
    return notes


def curve_warnings(curves: pd.DataFrame, curve: str) -> list[str]:
    """A word where another curve fits far better than the one that was asked for; `curves` as `curves.csv` has them."""
    behind = float(curves.loc[curves["curve"] == curve, "delta_aic"].iloc[0])
    best = str(curves["curve"].iloc[0])
    if not behind > FAR_BEHIND:
        return []
    l50, sr = (float(curves[name].iloc[0]) for name in ("l50_cm", "sr_cm"))
    numbers = f"L50 {l50:.2f} cm, SR {sr:.2f} cm" if np.isfinite(l50) else "no L50 within the lengths"
    return [
        f"the {curve} curve has hardly any support beside the {best} curve, whose AIC is {behind:.0f} lower "
        f"({numbers}): look at the residuals, and consider --curve {best}"
    ]


def gear_summary(fitted: GearFit) -> str:
    """Data, model and the test of the group."""
    text = data_text(fitted.one.data)
    test = ""
    if np.isfinite(fitted.p_value) and fitted.alike is not None:
        gain = fitted.alike.aic - fitted.one.aic
        test = (
            f" One curve and split for all gears: likelihood ratio p = {fitted.p_value:.2g}, AIC "
            f"{abs(gain):.3g} {'higher' if gain > 0.0 else 'lower'} than with gears apart."
        )
    return f"{text[0].upper()}{text[1:]}. {model_text(fitted.one)[0].upper()}{model_text(fitted.one)[1:]}.{test}"


def gear_warnings(fitted: GearFit) -> list[str]:
    """Failures."""
    return list(fitted.notes) if fitted.converged else [f"not fitted: {note}" for note in fitted.notes]


def comparison_summary(found: CatchComparison) -> str:
    """Data and models."""
    text = data_text(found.data)
    model = " + ".join({0: "1", 1: "x"}.get(order, f"x^{order}") for order in found.orders)
    return (
        f"{text[0].upper()}{text[1:]}. Polynomials up to the fourth order averaged by AIC, the best {model}; bands of "
        f"{found.n_replicates} double-bootstrap replicates."
    )


def comparison_lead(found: CatchComparison) -> list[str]:
    """Where the gears differ."""
    if not found.n_replicates:
        return ["No bands, and so no telling where the gears differ"]
    less, more = found.upper_all_95 < 0.5, found.lower_all_95 > 0.5
    lines = [
        f"The test gear catches {word} than the control at {_lengths(found.length_cm, at)}"
        for word, at in (("less", less), ("more", more))
        if at.any()
    ]
    return lines or ["No length at which the gears' catches differ beyond chance, all lengths taken together"]


def comparison_notes(found: CatchComparison) -> list[str]:
    """Lack of fit, and what the ratio takes for granted."""
    notes = [
        "The ratio takes both gears to have fished with equal effort; where they did not, it is off by that factor."
    ]
    notes += few_hauls(found.data, "bands")
    if np.isfinite(found.p_value):
        lack = "a shape these polynomials lack, or hauls that differ" if found.p_value < 0.05 else "no lack of fit"
        notes.append(
            f"Lengths pooled over hauls: deviance {found.deviance:.4g} on {found.degrees_of_freedom}, p = "
            f"{found.p_value:.2g}: {lack}."
        )
    return notes


def _lengths(length_cm: np.ndarray, at: np.ndarray) -> str:
    """Runs of lengths in words."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(int)))
    runs = [(length_cm[a], length_cm[b - 1]) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return ", ".join(f"{a:g} cm" if a == b else f"{a:g} to {b:g} cm" for a, b in runs)
