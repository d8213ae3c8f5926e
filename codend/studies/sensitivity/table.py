"""``sensitivities.csv``: a row a case, quantity and number of the plan."""

import math
from collections.abc import Sequence
from typing import Final

import pandas as pd

from catch_models.fish import Species
from codend.equilibrium.fidelity import choose
from codend.plan.plan import Plan
from codend.studies.sensitivity.derivatives import CaseSensitivity, Progress, sensitivity_of

COLUMNS: Final = (
    "case",
    "quantity",
    "key",
    "value",
    "derivative",
    "one_sided",
    "derivative_below",
    "derivative_above",
    "by_10_percent",
    "kink_below",
    "kink_above",
    "note",
)


def sensitivities(
    plan: Plan,
    species: Sequence[Species] = (),
    keys: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Derivatives of drag, catch volume, opening ahead, L50 and SR of every case of a plan.

    Args:
        plan: the plan.
        species: whose L50 and SR are asked.
        keys: numbers of the plan to ask; all that it names by default.
        progress: called before every number of a case.

    Returns:
        A row a case, quantity and key; cases that are not solved have none. ``derivative`` is per unit of ``value``,
        of counts per one more; where ``one_sided`` it holds towards larger values (``derivative_above``), or where
        these are not allowed towards smaller ones. ``by_10_percent`` is what 10 % more makes, in proportion, nan of
        counts below 10. Between ``kink_below`` and ``kink_above`` nothing goes slack or taut and the front passes no
        row, in proportion; empty where that never happens.

    Raises:
        InputError: a key is no number of the plan.
    """
    return sensitivity_table(case_sensitivities(plan, species, keys, progress))


def case_sensitivities(
    plan: Plan,
    species: Sequence[Species] = (),
    keys: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> list[CaseSensitivity]:
    """What ``sensitivities`` tells, case by case."""
    choice = choose(plan)
    found = (sensitivity_of(plan, case, species, keys, choice, progress) for case in plan.cases())
    return [one for one in found if one is not None]


def sensitivity_table(cases: Sequence[CaseSensitivity]) -> pd.DataFrame:
    """Derivatives as a table; see ``sensitivities``."""
    rows = []
    for one in cases:
        for name in one.told:
            for found in one.numbers:
                number, slope = found.number, found.slope[name]
                few = number.counted and number.value < 10
                rows.append(
                    (
                        one.case.number,
                        name,
                        number.key,
                        float(number.value),
                        slope,
                        found.one_sided,
                        found.below[name],
                        found.above[name],
                        math.nan if few else 0.1 * number.value * slope,
                        found.kink_below if math.isfinite(found.kink_below) else math.nan,
                        found.kink_above if math.isfinite(found.kink_above) else math.nan,
                        found.note,
                    )
                )
    return pd.DataFrame(rows, columns=list(COLUMNS))
