"""The lattice of a net: how many meshes every band has, and which knots become one where counts change.

Where two sections are joined the knots of the ring with more are taken up evenly, in the ratio of the counts. Where a
section tapers those of its panels' edges are gathered at the seams (``netting.taper``).
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats
from codend.plan.merging import rows_merged
from codend.plan.plan import Netting

Counts = NDArray[np.int64]


@dataclass(frozen=True)
class Lattice:
    """Counts that all index arithmetic rests on."""

    sections: tuple[Netting, ...]
    """From the entry."""
    number: Counts
    """Number of each band's section among them, (bands,)."""
    columns: Counts
    """Modelled (merged) meshes round of each band, (bands,)."""
    abreast: int
    """Equal sectors that are modelled side by side."""
    order: float
    globalisation: float
    seams: Counts | None = None
    """Seams of every band in the modelled sectors, at which its section loses meshes where it tapers, the first at
    azimuth 0, (bands,); None: no section tapers or has any."""

    @property
    def bands(self) -> int:
        """Bands between the rows."""
        return len(self.columns)

    @property
    def counted(self) -> Hashable:
        """All that what counts and kinds of netting decide depends on: equal where all of that is."""
        kinds = tuple((section.mesh, section.knot_m > 0.0) for section in self.sections)
        seams = () if self.seams is None else (self.seams.tobytes(), self.gathered.tobytes())
        return kinds, self.number.tobytes(), self.columns.tobytes(), seams, self.abreast, self.order == 1

    def beside(self, like: "Lattice") -> None:
        """Take over what another of the same counts and kinds (``counted``) has found that these alone decide."""
        self.__dict__.update((name, like.__dict__[name]) for name in _BY_COUNTS if name in like.__dict__)

    def section(self, band: int | np.integer) -> Netting:
        """Section of a band."""
        return self.sections[self.number[band]]

    def of_bands(self, value: Callable[[Netting], object]) -> NDArray:
        """A value of every band's section, (bands,)."""
        return np.array([value(section) for section in self.sections])[self.number]

    @cached_property
    def merged(self) -> Floats:
        """Real rows that every band stands for, (bands,)."""
        return rows_merged(self.sections, self.bands, self.globalisation)

    @cached_property
    def stretched_m(self) -> Floats:
        """Stretched length of every band, m, (bands,)."""
        return self.merged * self.of_bands(lambda section: section.bar_m + section.knot_along_m)

    @cached_property
    def staggered(self) -> NDArray[np.bool_]:
        """Whether the rows at either end of a band are turned against each other by half a mesh, (bands,)."""
        return self.of_bands(lambda section: section.kind.staggered)

    @cached_property
    def knots(self) -> Counts:
        """Knots in the ring of each row, (bands + 1,): where two sections meet, of the one with fewer; 1 codline."""
        return np.concatenate([self.columns[:1], np.minimum(self.columns[:-1], self.columns[1:]), [1]])

    @cached_property
    def shift(self) -> Counts:
        """1 for rows that are shifted by half a mesh, else 0, (bands + 1,)."""
        return np.concatenate([[0], np.cumsum(self.staggered)]) % 2

    @cached_property
    def phase(self) -> Floats:
        """Azimuth of column 0 of each band without its shift, rad, (bands,).

        Where knots are taken up unevenly, the sections are turned against each other so that on average none is pulled
        to either side. Seams stay where they are: on a column, or half a column beside one.
        """
        if self.seams is not None:
            return -np.pi * self._beside_seam / (self.columns * self.order)
        return np.cumsum(2.0 * np.pi / self.order * self._lag)

    @cached_property
    def _lag(self) -> Floats:
        """Share of a sector by which each band is turned against the one ahead, (bands,)."""
        lag = np.zeros(self.bands)
        for band in np.flatnonzero(np.diff(self.columns)) + 1:
            ahead, aft = self.columns[band - 1 : band + 1]
            wide, narrow = max(ahead, aft), min(ahead, aft)
            knot = np.arange(wide)
            mean = np.mean(knot / wide - knot * narrow // wide / narrow)
            lag[band] = mean if ahead > aft else -mean
        return lag

    @cached_property
    def gathered(self) -> NDArray[np.bool_]:
        """Whether knots of a row are gathered at the seams, those of a section that tapers there, (bands + 1,).

        Else those of a ring of more are taken up all round: there two sections of different counts are joined.
        """
        gathered = np.zeros(self.bands + 1, dtype=bool)
        if self.seams is None:
            return gathered
        gathered[1:-1] = True
        for row in np.flatnonzero(np.diff(self.number)) + 1:
            ahead, aft = self.section(row - 1), self.section(row)
            counts = round(ahead.open_meshes[1] / self.globalisation), round(aft.open_meshes[0] / self.globalisation)
            gathered[row] = counts[0] == counts[1]
        return gathered

    @cached_property
    def ring_seams(self) -> Counts:
        """Seams of every row at which its knots are gathered, 1 where none are, (bands + 1,)."""
        found = np.ones(self.bands + 1, dtype=np.int64)
        if self.seams is not None:
            ahead_is_wide = self.columns[:-1] >= self.columns[1:]
            found[1:-1] = np.where(self.gathered[1:-1], np.where(ahead_is_wide, self.seams[:-1], self.seams[1:]), 1)
        return found

    @cached_property
    def _upward(self) -> NDArray[np.bool_]:
        """Whether knots of a row are laced to the next knot on, not to the last, of a ring of fewer, (bands + 1,).

        In rows that are shifted by half a mesh the knots on either side of a seam are the last and the first, in others
        the first and the second.
        """
        return (self.seams is not None) & (self.shift == 1)

    @cached_property
    def after_seam(self) -> Counts:
        """Knots after that on a seam, or of half a mesh before it, that are gathered with it into one, (bands + 1,)."""
        found = np.zeros(self.bands + 1, dtype=np.int64)
        if self.seams is None:
            return found
        for row in range(1, self.bands):
            ahead, aft = self.columns[row - 1 : row + 1]
            wide = row - 1 if ahead >= aft else row
            lost = abs(int(ahead - aft)) // int(self.ring_seams[row])
            twice = lost - int(self.shift[row]) + int(self._beside_seam[wide])
            found[row] = twice // 2 if self._upward[row] else -(-twice // 2)
        return found

    @cached_property
    def _beside_seam(self) -> Counts:
        """0 where a seam runs through column 0 of a band, 1 where half a mesh on, (bands,)."""
        beside = np.zeros(self.bands, dtype=np.int64)
        for band in range(1, self.bands):
            ahead, aft = self.columns[band - 1 : band + 1]
            beside[band] = beside[band - 1]
            if ahead > aft:
                beside[band] = self.shift[band]  # the knot that others are laced to lies on the seam
            elif ahead < aft:
                even = self.gathered[band] and (aft - ahead) // self.ring_seams[band] % 2 == 0
                beside[band] = self.shift[band] if even else 1 - self.shift[band]
        return beside

    def laced(self, row: Counts, knot: Counts, columns: Counts) -> Counts:
        """Knot of a row's ring that a knot is laced to, of as many as ``columns``, both counted on all round.

        Where a section tapers some are gathered at every seam; where two are joined they are taken up evenly: of
        100 meshes joined to 60, at the ratio of 5 to 3, of each 5 two pairs are taken up two by two and one is not.
        """
        ring, seams = self.knots[row], self.ring_seams[row]
        if np.array_equal(ring, columns):
            return knot
        evenly = np.where(self._upward[row], -(-knot * ring // columns), knot * ring // columns)
        panel, place = np.divmod(knot, columns // seams)
        own = ring // seams
        gathered = panel * own + np.clip(place - self.after_seam[row], 0, own)
        return np.where(self.gathered[row] & (columns > ring), gathered, evenly)

    def beside_seam(self, row: Counts, knot: Counts, columns: Counts) -> Counts:
        """Side of a seam, -1 or 1, on which a knot lies that is gathered there with more than one other; else 0."""
        seams = self.ring_seams[row]
        lost = (columns - self.knots[row]) // seams
        place = 2 * (knot % (columns // seams) - self.after_seam[row]) + lost
        place = np.where(place > columns // seams, place - 2 * (columns // seams), place)
        many = self.gathered[row] & (lost > 1) & (np.abs(place) <= lost)
        return np.where(many, np.sign(place), 0)

    def last_laced(self, row: Counts, knot: Counts, columns: Counts) -> Counts:
        """The last of the knots, of as many as ``columns``, that are laced to a knot of a row's ring."""
        ring, seams = self.knots[row], self.ring_seams[row]
        evenly = np.where(self._upward[row], knot * columns // ring, -(-(knot + 1) * columns // ring) - 1)
        panel, place = np.divmod(knot, ring // seams)
        gathered = panel * (columns // seams) + place + self.after_seam[row]
        return np.where(self.gathered[row] & (columns > ring), gathered, evenly)

    def places(self, bands: NDArray[np.integer]) -> tuple[Counts, Counts]:
        """Band and column of every modelled mesh of some bands, band by band, each (places,)."""
        return self.counted_out(bands, self.columns[bands])

    def rings(self, rows: NDArray[np.integer]) -> tuple[Counts, Counts]:
        """Row and column of every knot of the rings of some rows, row by row, each (places,)."""
        return self.counted_out(rows, self.knots[rows])

    def counted_out(self, lines: NDArray[np.integer], counts: NDArray[np.integer]) -> tuple[Counts, Counts]:
        """Line and column of every place on lines of so many places, in the order of ``numbered``."""
        place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        wide = np.repeat(counts // self.abreast, counts)
        return np.repeat(lines, counts), place % self.abreast * wide + place // self.abreast

    def numbered(self, column: NDArray[np.integer], columns: NDArray[np.integer]) -> tuple[Counts, Counts]:
        """Number on its line, and image, of a column counted on all round where there are ``columns``.

        Places that differ by whole sectors follow one another, so that a sector of the net is numbered as all of it.
        """
        image = np.zeros_like(column) if self.order == 1 else column // columns
        inside, wide = column % columns, np.maximum(columns // self.abreast, 1)
        return inside % wide * self.abreast + inside // wide, image


_BY_COUNTS: Final = (
    "staggered", "knots", "shift", "gathered", "ring_seams", "after_seam", "_lag", "_upward", "_beside_seam",
)  # fmt: skip
"""What counts and kinds alone decide of a lattice."""
