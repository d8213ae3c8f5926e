"""The kinds of netting: one record a kind, which tells all that sets it apart.

A new kind is a record here, its name in ``MeshName`` and, if knots and twine are joined as in no other, a file in
``codend.netting.patterns`` that writes them and a line in ``codend.netting.pattern.PATTERNS``.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

MeshName = Literal["diamond", "t90", "square"]
"""What a plan calls them."""
HoleShape = Literal["rhombus, knots along", "rhombus, knots across", "rectangle"]
"""Holes whose passage by fish is known; see ``codend.selectivity.escape.penetration``."""


@dataclass(frozen=True)
class Kind:
    """A kind of netting; b is a bar, l a knot and N the meshes round."""

    words: str
    """What sentences call it."""
    pattern: str
    """What joins its knots, a key of ``codend.netting.pattern.PATTERNS``."""
    rows_per_mesh: Literal[1, 2]
    """Rows of knots that a mesh is long."""
    knots: Literal["along", "across", "none"]
    """How the length of its knots lies, or that they have none."""
    across_bars: float
    """Width round the netting that a mesh pulled fully open has, without knots, over 2 b: N times 2 b times this is the
    way round."""
    opens: bool
    """Whether its meshes open and close: bending resists that, and a pull across the netting helps."""
    membrane: bool
    """Whether the meridian method takes it."""
    hole: HoleShape
    """What fish have to pass."""
    straight_cut: Literal["N", "T"] | None
    """What cutters call the cut straight along the codend; None where edges are cut along bars only."""
    tips: bool = False
    """Whether its rings go slack ahead of the catch: a bag hangs from its hoop by the rows along alone there, and
    weight, however little, or a side's push may tip it into another shape."""
    folds_over_from: float = math.inf
    """Wet weight over the drag from which nets of it can fold over, and no estimate holds (found on full nets)."""
    smeared_errors: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    """By how much wider than those of diamond netting errors of smeared ropes are in drag, volume, radius and opening.

    Found on every other plan of ``python -m validation.smeared_ropes --kind t90`` and ``--kind square``, T90 with folds
    under contact: its 5 plans needed 0.7, 0.3, 0.2 and 1.1, the 5 others 0.8, 0.5, 0.4 and 1.3, one of 4 with
    ``--seed 16`` 1.0 in drag; square mesh 5.6, 2.9, 1.9 and 1.2 by 5, and 2.8, 3.3, 0.5 and 1.7 by 4 others.
    """

    between_ropes_errors: tuple[float, float, float, float] | None = None
    """Errors of fewer, larger meshes between ropes (``plan.merging``): relative in drag, volume and largest radius,
    degrees in opening. None where smeared ropes are as near: netting whose meshes open as ropes shorten it. T90 is
    open already there, and square mesh does not open: between ropes they lie aft of where those have their knots, hang
    in ahead of the catch, and stand out behind it, where they carry half of the load that smeared ropes do. Twice what
    T90 and square mesh needed on 12 and 24 plans, or more (``python -m validation.smeared_ropes --kind t90``); with
    ``--seed 91``, by which T90's drag and square mesh's opening were then widened, at most 0.39 of all that is stated.
    """

    @cached_property
    def staggered(self) -> bool:
        """Whether rows are half a mesh apart and turned by half a mesh.

        A mesh then lies about the row at its widest part, its sides aslant; else between two rows, along and across.
        """
        return self.rows_per_mesh == 2


KINDS: Final[dict[MeshName, Kind]] = {
    "diamond": Kind(
        words="diamond",
        pattern="rhombs",
        rows_per_mesh=2,
        knots="along",
        across_bars=1.0,
        opens=True,
        membrane=True,
        hole="rhombus, knots along",
        straight_cut="N",
    ),
    "t90": Kind(
        words="T90",
        pattern="rhombs",
        rows_per_mesh=2,
        knots="across",
        across_bars=1.0,
        opens=True,
        membrane=True,
        hole="rhombus, knots across",
        straight_cut="T",
        smeared_errors=(1.5, 1.0, 1.0, 1.8),
        between_ropes_errors=(0.021, 0.015, 0.006, 1.0),
    ),
    "square": Kind(
        words="square",
        pattern="squares",
        rows_per_mesh=1,
        knots="none",
        across_bars=0.5,
        opens=False,
        membrane=False,
        hole="rectangle",
        straight_cut=None,
        tips=True,
        folds_over_from=0.5,
        smeared_errors=(7.5, 4.5, 3.0, 2.5),
        between_ropes_errors=(0.07, 0.08, 0.025, 10.0),
    ),
}


def kinds_in_words(which: Callable[[Kind], bool], joint: Literal["and", "or"] = "and") -> str:
    """The kinds of which something holds, as a sentence names them: "diamond and T90"."""
    *first, last = [kind.words for kind in KINDS.values() if which(kind)]
    return f"{', '.join(first)} {joint} {last}" if first else last
