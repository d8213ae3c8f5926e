"""What counts and kinds of netting alone decide of a net: its knots numbered, where they lie, and what joins them.

Nets of plans that differ in their sizes only have one frame, which is made once for the last few of them.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

from codend.net.last_made import LastMade
from codend.netting.knots import Knots, Places, knots_of, places_of
from codend.netting.lattice import Lattice
from codend.netting.parts import Layout
from codend.netting.pattern import parts_of


@dataclass(frozen=True)
class Frame:
    """A net without its sizes."""

    knots: Knots
    """Those of the net that it was made for."""

    @cached_property
    def places(self) -> Places:
        """Where the nodes lie."""
        return places_of(self.knots)

    @cached_property
    def layout(self) -> Layout:
        """Bars, facets, meshes and corners of all sections."""
        return parts_of(self.knots).joined()

    def knots_in(self, lattice: Lattice) -> Knots:
        """The knots of another net with this frame."""
        lattice.beside(self.knots.lattice)
        return replace(self.knots, lattice=lattice)


MOST_KNOTS: Final = 10_000
"""Of all nets together whose frames are kept for others: they take about a kilobyte a knot."""
_frames: LastMade[Frame] = LastMade(MOST_KNOTS)


def frame_of(lattice: Lattice) -> Frame:
    """The frame of a net."""
    return _frames.of(lattice.counted, int(lattice.columns.sum()), lambda: Frame(knots_of(lattice)))
