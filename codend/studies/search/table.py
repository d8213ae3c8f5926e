"""``search.csv``: every design that a search looked at; and how it ended, in words."""

import math

import pandas as pd

from codend.io.columns import REASON, error_of
from codend.studies.case_result import CaseResult
from codend.studies.search.asked import Condition
from codend.studies.search.search import MOST_DESIGNS, REACHED, Design, Found


def search_table(found: Found) -> pd.DataFrame:
    """A row a design and case, in the order in which they were looked at: values, change, and what it tells."""
    rows = []
    for number, design in enumerate(found.looked_at, start=1):
        ahead = {"design": number, **design.values, "change": design.change, "reaches": design.reaches}
        if not design.told:
            rows.append({**ahead, REASON: design.reason})
        for case, told in enumerate(design.told, start=1):
            rows.append({**ahead, "case": case, **told, REASON: None})
    table = pd.DataFrame(rows)
    return table[[name for name in table.columns if name != REASON] + [REASON]]


def ended(found: Found) -> list[str]:
    """How a search ended, in sentences."""
    wanted = " and ".join(one.words for one in found.conditions)
    count = f"{len(found.looked_at)} designs were looked at"
    if found.best is found.start:
        return [f"The plan as it is has {wanted}.", *_as_run(found)]
    if found.best is not None:
        return [f"Reached: {wanted}, by {_changes(found, found.best)}. {count}.", *_as_run(found)]
    stopped = (
        f" The search ended there, with more designs to look at: at most {MOST_DESIGNS} are." if _stopped(found) else ""
    )
    sentences = [f"No design within the limits reaches {wanted}: {count}.{stopped}"]
    if math.isfinite(found.nearest.margin):
        cases = found.nearest.told
        worst = min(found.conditions, key=lambda one: min(one.margin(told[one.quantity]) for told in cases))
        values = [told[worst.quantity] for told in cases]
        value = min(values, key=worst.margin)
        sentences.append(f"The nearest has {worst.quantity} {value:.4g}, by {_changes(found, found.nearest)}.")
    return sentences


def _as_run(found: Found) -> list[str]:
    """How well what was reached is known: by the errors and the stability that a run of the plan found tells."""
    if not all(case.converged for case in found.cases):
        return ["As codend run solves this plan, not every case of it is solved."]
    told, missed = [], []
    bounds = {one.quantity: one for one in found.conditions}
    bounds.setdefault("opening_ahead_deg", Condition("opening_ahead_deg", 0.0, 1.0))
    for quantity, bound in bounds.items():
        values = [_with_error(found, case, quantity) for case in found.cases]
        value, error = min(values, key=lambda pair: bound.margin(pair[0]))
        if math.isnan(value):
            continue
        told.append(
            f"{quantity} {value:.4g} +- {error:.2g}" if error >= 0.0 else f"{quantity} {value:.4g}, error unknown"
        )
        if bound.margin(value) < -REACHED - (error / abs(bound.bound) if error >= 0.0 and bound.bound else 0.0):
            missed.append(bound.words)
    sentences = [f"As codend run tells it: {', '.join(told)}."] if told else []
    if missed:
        sentences.append(f"That misses {' and '.join(missed)}: followed as it wrinkles, the net has another shape.")
    unstable = [str(one.case.number) for one in found.cases if one.unstable]
    if unstable:
        sentences.append(
            f"The shape is not stable (case {', '.join(unstable)}): the errors cover what wrinkles change."
        )
    return sentences


def _with_error(found: Found, case: CaseResult, quantity: str) -> tuple[float, float]:
    """What a case tells of a quantity, and its error; nan where that is not known."""
    told = vars(case.measures) | vars(case.errors) | dict(found.selected.get(case.case.number, {}))
    return told.get(quantity, math.nan), told.get(error_of(quantity), math.nan)


def _stopped(found: Found) -> bool:
    return found.tried < found.combinations


def _changes(found: Found, design: Design) -> str:
    changed = [
        f"{key} {found.start.values[key]:g} to {value:g}"
        for key, value in design.values.items()
        if value != found.start.values[key]
    ]
    return ", ".join(changed) or "no change at all"
