"""Intervals of what a case tells, by how well the numbers of its plan are known, and which to measure better.

To first order: numbers are taken as independent, each with a standard deviation, and a quantity's variance is the sum
of (derivative x standard deviation)^2 over them. On a kink the mean square of both sides stands for the square.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import pandas as pd

from codend.studies.sensitivity.derivatives import CaseSensitivity, Derivatives

NORMAL_95: Final = 1.959964
"""Standard deviations to either end of an interval of 95 %."""
COLUMNS: Final = (
    "case",
    "quantity",
    "value",
    "standard_deviation",
    "lower_95",
    "upper_95",
    "measure_better",
    "share",
)


def interval_table(cases: Sequence[CaseSensitivity], uncertain: Mapping[str, float]) -> pd.DataFrame:
    """``intervals.csv``: a row a case and quantity.

    Args:
        cases: with derivatives by all the numbers that are uncertain.
        uncertain: relative standard deviations, by the keys of the numbers.

    Returns:
        Value, standard deviation and interval, the number that makes most of the variance (``measure_better``, empty
        where nothing does) and its share. Where a derivative is not known there is no interval.
    """
    rows = []
    for one in cases:
        numbers = [found for found in one.numbers if found.number.key in uncertain]
        for name, value in one.told.items():
            parts = {
                found.number.key: _square(found, name) * (uncertain[found.number.key] * found.number.value) ** 2
                for found in numbers
            }
            variance = sum(parts.values())
            deviation = math.sqrt(variance)
            most = max(parts, key=lambda key: parts[key]) if variance > 0.0 else ""
            half = NORMAL_95 * deviation
            share = parts[most] / variance if most else math.nan
            rows.append((one.case.number, name, value, deviation, value - half, value + half, most, share))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _square(found: Derivatives, name: str) -> float:
    """Mean square of the derivatives that there are, on either side; nan where there is none."""
    sides = [side for side in (found.below[name], found.above[name]) if not math.isnan(side)]
    return sum(side**2 for side in sides) / len(sides) if sides else math.nan
