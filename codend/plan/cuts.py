"""Cuts of netting as cutters count them: N points, T meshes (transversals) and B bars along an edge.

A cut of n N and m B loses m meshes of width in 2 n + m of depth, one of n T and m B loses 2 n + m in m: AN is straight,
AB loses a mesh a mesh, 1N2B a half. In turned netting, whose N-direction lies across, N and T change places.
"""

import math
import re
from dataclasses import dataclass
from typing import Final, Literal

_FORM: Final = re.compile(r"A([NTB])|(\d{1,4})([NT])(\d{1,4})B")


@dataclass(frozen=True)
class Cut:
    """So many points or meshes to so many bars, in their lowest numbers or as they were written."""

    along: int
    """Cuts straight along the codend (N, in turned netting T)."""
    across: int
    """Cuts straight across it (T, in turned netting N)."""
    bars: int

    @property
    def rate(self) -> float:
        """Meshes of width that an edge loses per mesh of depth; infinite straight across."""
        deep = 2 * self.along + self.bars
        return (2 * self.across + self.bars) / deep if deep else math.inf

    def text(self, straight: Literal["N", "T"] = "N") -> str:
        """As cutters write it, with the letter for a cut straight along the codend."""
        other = "T" if straight == "N" else "N"
        if self.bars == 0:
            return f"A{straight if self.along else other}"
        if not self.along and not self.across:
            return "AB"
        return f"{self.along or self.across}{straight if self.along else other}{self.bars}B"


def cut_of(text: str, straight: Literal["N", "T"] = "N") -> Cut | None:
    """The cut that a text such as "1N2B" or "AB" names; None where it names none."""
    found = _FORM.fullmatch(text.strip().replace(" ", "").upper())
    if found is None:
        return None
    if found[1] is not None:
        return Cut(int(found[1] == straight), int(found[1] not in (straight, "B")), int(found[1] == "B"))
    count, bars = int(found[2]), int(found[4])
    if count == 0 or bars == 0:
        return None
    return Cut(count, 0, bars) if found[3] == straight else Cut(0, count, bars)


def cut_that_loses(half_meshes: int, deep: int) -> Cut:
    """The cut of an edge that loses so many half meshes of width over ``deep`` whole meshes.

    Of w meshes over d: where d > w, B = 2 w and N = d - w; else B = 2 d and T = w - d; over their common divisor.
    """
    along, across = max(2 * deep - half_meshes, 0), max(half_meshes - 2 * deep, 0)
    bars = 2 * min(half_meshes, 2 * deep)
    common = math.gcd(along, across, bars) or 1
    return Cut(along // common, across // common, bars // common)
