"""Parts of a net while it is written: its lattice, bars, facets, meshes and corners, put together in the end."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats, Ints, Net
from codend.plan.plan import Netting

Counts = NDArray[np.int64]

HALF_MESH = 0.5


@dataclass(frozen=True)
class Lattice:
    """Counts that all index arithmetic rests on."""

    sections: list[Netting]
    """Section of each band."""
    columns: Counts
    """Modelled (merged) meshes round of each band, (bands,)."""
    abreast: int
    """Equal sectors that are modelled side by side."""
    order: int
    globalisation: int

    @property
    def bands(self) -> int:
        """Bands between the rows."""
        return len(self.sections)

    @cached_property
    def square(self) -> NDArray[np.bool_]:
        """Whether a band is of square mesh, (bands,)."""
        return np.array([s.mesh == "square" for s in self.sections])

    @cached_property
    def knots(self) -> Counts:
        """Knots in the ring of each row, (bands + 1,): where two sections meet, of the one with fewer; 1 codline."""
        return np.concatenate([self.columns[:1], np.minimum(self.columns[:-1], self.columns[1:]), [1]])

    @cached_property
    def shift(self) -> Counts:
        """1 for rows that are shifted by half a mesh, else 0, (bands + 1,)."""
        return np.concatenate([[0], np.cumsum(~self.square)]) % 2

    @cached_property
    def phase(self) -> Floats:
        """Azimuth of column 0 of each band without its shift, rad, (bands,).

        Where knots are taken up unevenly, the sections are turned against each other so that on average none is pulled
        to either side.
        """
        turn = np.zeros(self.bands)
        for band in np.flatnonzero(np.diff(self.columns)) + 1:
            ahead, aft = self.columns[band - 1 : band + 1]
            wide, narrow = max(ahead, aft), min(ahead, aft)
            knot = np.arange(wide)
            lag = 2.0 * np.pi / self.order * np.mean(knot / wide - taken_up(knot, wide, narrow) / narrow)
            turn[band] = lag if ahead > aft else -lag
        return np.cumsum(turn)

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


def taken_up(knot: Counts, wide: Counts, narrow: Counts) -> Counts:
    """Knot of a ring of ``narrow`` that a knot of ``wide`` is laced to, both counted on all round.

    100 meshes are joined to 60 at the ratio of 5 to 3: of each 5, two pairs are taken up two by two and one is not.
    """
    return knot * narrow // wide


@dataclass(frozen=True)
class RowShape:
    """Where the rows are when the solver starts."""

    x: Floats
    radius: Floats
    azimuth_rad: float

    def placed(self, row: NDArray, azimuth: Floats, ahead: Floats | float = 0.0) -> Floats:
        """Points at the azimuth (rad), a fraction ``ahead`` of the band back from the row towards the one before."""
        before = np.maximum(row - 1, 0)
        x = (1.0 - ahead) * self.x[row] + ahead * self.x[before]
        radius = (1.0 - ahead) * self.radius[row] + ahead * self.radius[before]
        angle = azimuth + self.azimuth_rad
        return np.stack([x, radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


@dataclass(frozen=True)
class Corner:
    """One node with its image for every place of a pattern: two arrays (places,)."""

    node: NDArray[np.integer]
    image: NDArray[np.integer]


class Parts:
    """Bars, facets and meshes gathered while a net is written."""

    def __init__(self, codline: int) -> None:
        self.codline = codline
        self.bars: list[NDArray] = []
        self.facets: list[NDArray] = []
        self.meshes: list[NDArray] = []
        self.corners: list[NDArray] = []

    def add_bars(self, first: Corner, second: Corner, band: NDArray, is_knot: bool) -> None:
        """Add a bar for every place of the pattern; knots carry no drag and do not stretch."""
        image = np.where((first.node == self.codline) | (second.node == self.codline), 0, second.image - first.image)
        self.bars.append(np.stack([first.node, second.node, image, band, np.full_like(band, is_knot)], axis=1))

    def add_quadrangles(self, a: Corner, b: Corner, c: Corner, d: Corner, band: NDArray) -> None:
        """Cover a, b, c, d by both divisions into triangles, each at half weight, so that no diagonal is special."""
        for p, q, r in ((a, b, c), (a, c, d), (a, b, d), (b, c, d)):
            self.facets.append(np.stack([p.node, q.node, r.node, p.image, q.image, r.image, band], axis=1))

    def add_meshes(self, sides: Sequence[tuple[Corner, Corner]], row: NDArray) -> None:
        """Add a mesh for every place, by its four sides in the order of ``Net.mesh_sides``."""
        nodes = [corner.node for side in sides for corner in side]
        images = [corner.image for side in sides for corner in side]
        self.meshes.append(np.stack([*nodes, *images, row], axis=1))

    def add_corners(self, middle: Corner, first: Corner, second: Corner, band: NDArray, across: bool) -> None:
        """Add a corner between two twines at a knot for every place."""
        nodes = (middle.node, first.node, second.node)
        images = [np.where(c.node == self.codline, 0, c.image) for c in (middle, first, second)]
        self.corners.append(np.stack([*nodes, *images, band, np.full_like(band, across)], axis=1))

    def facet_table(self) -> tuple[NDArray, Floats]:
        """Facets without the empty ones, equal ones merged, and their weights."""
        table = np.concatenate(self.facets)
        nodes, images = table[:, :3], np.where(table[:, :3] == self.codline, 0, table[:, 3:6])
        table = np.concatenate([nodes, images, table[:, 6:]], axis=1)
        same = [(nodes[:, i] == nodes[:, j]) & (images[:, i] == images[:, j]) for i, j in ((0, 1), (1, 2), (2, 0))]
        unique, count = np.unique(table[~np.any(same, axis=0)], axis=0, return_counts=True)
        by_band = np.argsort(unique[:, -1], kind="stable")
        return unique[by_band], np.asarray(0.5 * count[by_band], dtype=np.float64)


def assembled(parts: Parts, lattice: Lattice, positions: Floats, node_row: Ints, entry: NDArray) -> Net:
    """Net with the properties of its bars, held at the entry and kept on the axis at the codline."""
    g = lattice.globalisation
    bars = np.concatenate(parts.bars)
    is_knot = bars[:, 4].astype(bool)
    band = bars[:, 3]

    def of_section(value: str) -> Floats:
        return np.array([getattr(s, value) for s in lattice.sections], dtype=np.float64)[band]

    stiffness = np.array(
        [np.inf if s.axial_stiffness_n is None else g * s.axial_stiffness_n for s in lattice.sections]
    )[band]
    facets, weight = parts.facet_table()
    around = lattice.order * lattice.columns[facets[:, 6]]
    weight *= _polygon_area(g * around) / _polygon_area(around)
    meshes = np.concatenate(parts.meshes)
    count = len(node_row)
    fixed = np.zeros((count, 3), dtype=bool)
    fixed[entry] = True
    fixed[parts.codline, 1:] = True
    corners = np.concatenate(parts.corners)
    clamped = np.array([12.0 * s.bending_stiffness_n_m2 / s.bar_m for s in lattice.sections])[corners[:, 6]]
    # two twines gathered at the codline have no angle between them
    resists = (clamped > 0.0) & ((corners[:, 1] != corners[:, 2]) | (corners[:, 4] != corners[:, 5]))
    corners, clamped = corners[resists], clamped[resists]
    at_rest = np.array([2.0 * s.rest_half_angle_rad for s in lattice.sections])[corners[:, 6]]
    half = [1.0 if s.mesh == "square" else HALF_MESH for s in lattice.sections]
    return Net(
        positions=positions,
        order=lattice.order,
        fixed=fixed,
        node_row=node_row,
        bars=bars[:, :2].astype(np.int32),
        bar_image=bars[:, 2].astype(np.int32),
        bar_length=g * np.where(is_knot, of_section("knot_m"), of_section("bar_m")),
        bar_flexibility=np.where(is_knot, 0.0, 1.0 / stiffness),  # a knot is a lump that does not stretch
        bar_drag_diameter=np.where(is_knot, 0.0, g * of_section("drag_width_m")),
        bar_solid_diameter=np.sqrt(g) * of_section("solid_diameter_m"),
        bar_density=np.array(
            [np.nan if s.twine_density_kg_m3 is None else s.twine_density_kg_m3 for s in lattice.sections]
        )[band],
        bar_band=band.astype(np.int32),
        facets=facets[:, :3].astype(np.int32),
        facet_image=facets[:, 3:6].astype(np.int32),
        facet_weight=weight,
        facet_band=facets[:, 6].astype(np.int32),
        mesh_sides=meshes[:, :8].reshape(-1, 4, 2).astype(np.int32),
        mesh_side_image=meshes[:, 8:16].reshape(-1, 4, 2).astype(np.int32),
        mesh_bars=_bars_of_sides(bars[:, :3], meshes[:, :8].reshape(-1, 2), meshes[:, 8:16].reshape(-1, 2)),
        mesh_row=meshes[:, 16].astype(np.int32),
        band_meshes=g * np.array(half),
        corners=corners[:, :3].astype(np.int32),
        corner_image=corners[:, 3:6].astype(np.int32),
        corner_stiffness=g**2 * clamped,
        corner_rest=np.where(corners[:, 7] == 1, np.pi - at_rest, at_rest),
        globalisation=g,
    )


def _polygon_area(corners: Counts) -> Floats:
    """Area of a regular polygon over that of the circle through its corners.

    A globalised net is an inscribed polygon of too few corners; at the same radius, pressure on it falls short in this
    ratio along the axis and across it, and so does its volume. Its facets are weighted to make up for that. Where two
    sections meet, their weights differ, which leaves an error of the order of what the weights make up for.
    """
    return np.asarray(np.sinc(2.0 / corners))


def _bars_of_sides(bars: NDArray, sides: NDArray, images: NDArray) -> Ints:
    """Number of the bar on each side of each mesh, -1 where there is none, (meshes, 4)."""

    def key(first: NDArray, second: NDArray, image: NDArray) -> NDArray:
        swap = first > second
        low, high = np.where(swap, second, first), np.where(swap, first, second)
        # the bars to a node's own images on either side are one and the same
        turned = np.where(first == second, np.abs(image), np.where(swap, -image, image))
        return (low * (bars[:, :2].max() + 1) + high) * 8 + turned + 4

    bar_keys = key(bars[:, 0], bars[:, 1], bars[:, 2])
    order = np.argsort(bar_keys, kind="stable")
    relative = np.where(
        (sides[:, 0] == bars[:, :2].max()) | (sides[:, 1] == bars[:, :2].max()), 0, images[:, 1] - images[:, 0]
    )
    wanted = key(sides[:, 0], sides[:, 1], relative)
    place = np.minimum(np.searchsorted(bar_keys[order], wanted), len(bars) - 1)
    found = order[place]
    return np.where(bar_keys[found] == wanted, found, -1).reshape(-1, 4).astype(np.int32)
