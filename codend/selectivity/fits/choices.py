"""Choices of a fit as users write them, checked: the split, what differs between hauls, and names out of a list."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from codend.errors import OPTIONS, InputError
from codend.selectivity.fits.marginal import RANDOM_TERMS

if TYPE_CHECKING:
    import pandas as pd

LEAST_UNITS = 3
"""Below which hauls, or larger units, are not taken as a sample of them."""
RANDOM_ALLOWED = "haul, none or a column, and after a colon what differs: l50, sr, split (of an estimated split)"


@dataclass(frozen=True)
class RandomTerms:
    """What differs at random between units.

    Attributes:
        unit: "haul" or a column that names larger units, such as trips.
        terms: of `RANDOM_TERMS`; empty for none.
    """

    unit: str
    terms: tuple[str, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """The column of the table that names the units, besides `haul`."""
        return (self.unit,) if self.terms and self.unit != "haul" else ()


def allowed_choice(key: str, value: str, allowed: Sequence[str]) -> None:
    """Refuse a value out of a list.

    Raises:
        InputError: it is not in it.
    """
    if value not in allowed:
        raise InputError(OPTIONS, key, value, ", ".join(allowed))


def split_choice(split: str | float, design: str) -> tuple[bool, float]:
    """Whether the split is estimated, and its value where it is not.

    Raises:
        InputError: no such split, or one for a covered codend.
    """
    allowed = "equal, estimated, or a share between 0 and 1"
    if split in ("equal", "estimated"):
        estimated, value = split == "estimated", 0.5
    else:
        try:
            estimated, value = False, float(split)
        except (TypeError, ValueError):
            raise InputError(OPTIONS, "split", split, allowed) from None
        if not (math.isfinite(value) and 0.0 < value < 1.0):
            raise InputError(OPTIONS, "split", split, allowed)
    if design == "covered" and (estimated or value != 0.5):
        raise InputError(OPTIONS, "split", split, "equal (only paired gear has a split)")
    return estimated, value


def random_terms(random: str, split_estimated: bool) -> RandomTerms:
    """Read `UNIT` or `UNIT:TERM,TERM`; L50, and an estimated split, differ where no terms are named.

    Raises:
        InputError: it cannot be read.
    """
    unit, colon, named = random.partition(":")
    default = ("l50", "split") if split_estimated else ("l50",)
    terms = tuple(term.strip() for term in named.split(",")) if colon else default
    if not unit or not set(terms) <= set(RANDOM_TERMS) or ("split" in terms and not split_estimated):
        raise InputError(OPTIONS, "random", random, RANDOM_ALLOWED)
    if unit == "none" and colon:
        raise InputError(OPTIONS, "random", random, RANDOM_ALLOWED)
    return RandomTerms(unit, () if unit == "none" else tuple(term for term in RANDOM_TERMS if term in terms))


def units_of(hauls: pd.DataFrame, terms: RandomTerms) -> list[str] | None:
    """The unit of each haul, a row of `hauls`; None where each haul is its own or none differ.

    Raises:
        InputError: too few units to tell how they differ.
    """
    if not terms.columns:
        return None
    units = list(hauls[terms.unit].astype(str))
    if len(set(units)) < LEAST_UNITS:
        allowed = f"a column with {LEAST_UNITS} or more units, or --group for gears"
        raise InputError(OPTIONS, "random", terms.unit, allowed, f"has {len(set(units))}")
    return units
