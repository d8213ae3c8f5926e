"""``search.csv``: every design that a search looked at; and how it ended, in words."""

import math

import pandas as pd

from codend.io.columns import REASON
from codend.studies.search.search import MOST_DESIGNS, Design, Found


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
        return [f"The plan as it is has {wanted}."]
    if found.best is not None:
        return [f"Reached: {wanted}, by {_changes(found, found.best)}. {count}."]
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


def _stopped(found: Found) -> bool:
    return found.tried < found.combinations


def _changes(found: Found, design: Design) -> str:
    changed = [
        f"{key} {found.start.values[key]:g} to {value:g}"
        for key, value in design.values.items()
        if value != found.start.values[key]
    ]
    return ", ".join(changed) or "no change at all"
