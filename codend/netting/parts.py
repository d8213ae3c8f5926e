"""Parts of a net while it is written: bars, facets, meshes and corners."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats, Ints
from codend.netting.lattice import Counts


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


class Piece(Protocol):
    """Netting let into a net while it is written, its parts as those of ``Parts``."""

    bars: list[NDArray]
    facets: list[NDArray]
    weights: list[Floats]
    meshes: list[NDArray]


class Parts:
    """Bars, facets and meshes gathered while a net is written."""

    def __init__(self, codline: int) -> None:
        self.codline = codline
        self.bars: list[NDArray] = []
        self.facets: list[NDArray] = []
        self.meshes: list[NDArray] = []
        self.corners: list[NDArray] = []

    def add_bars(self, first: Corner, second: Corner, band: NDArray, is_knot: bool) -> None:
        """Add a bar for every place of the pattern; knots carry no drag."""
        image = np.where((first.node == self.codline) | (second.node == self.codline), 0, second.image - first.image)
        self.bars.append(np.stack([first.node, second.node, image, band, np.full_like(band, is_knot)], axis=1))

    def add_quadrangles(self, a: Corner, b: Corner, c: Corner, d: Corner, band: NDArray) -> None:
        """Cover a, b, c, d by both divisions into triangles, each at half weight, so that no diagonal is special."""
        for p, q, r in ((a, b, c), (a, c, d), (a, b, d), (b, c, d)):
            self.facets.append(np.stack([p.node, q.node, r.node, p.image, q.image, r.image, band], axis=1))

    def add_meshes(self, sides: Sequence[tuple[Corner, Corner]], row: NDArray) -> None:
        """Add a mesh for every place, by its four sides in the order of ``Bag.mesh_sides``."""
        nodes = [corner.node for side in sides for corner in side]
        images = [corner.image for side in sides for corner in side]
        self.meshes.append(np.stack([*nodes, *images, row], axis=1))

    def add_corners(self, middle: Corner, first: Corner, second: Corner, band: NDArray, across: bool) -> None:
        """Add a corner between two twines at a knot for every place."""
        nodes = (middle.node, first.node, second.node)
        images = [np.where(c.node == self.codline, 0, c.image) for c in (middle, first, second)]
        self.corners.append(np.stack([*nodes, *images, band, band, np.full_like(band, across)], axis=1))

    def joined(self, pieces: Sequence["Piece"] = ()) -> "Layout":
        """All of them, with those of pieces of other netting after them."""
        bars, bar_piece = _numbered([self.bars, *(piece.bars for piece in pieces)])
        meshes, mesh_piece = _numbered([self.meshes, *(piece.meshes for piece in pieces)])
        by_row = np.argsort(meshes[:, 16], kind="stable")
        meshes, mesh_piece = meshes[by_row], mesh_piece[by_row]
        facets, weight = self._facet_table()
        for piece in pieces:
            facets, weight = np.concatenate([facets, *piece.facets]), np.concatenate([weight, *piece.weights])
        return Layout(
            codline=self.codline,
            bars=bars[:, :2].astype(np.int32),
            bar_image=bars[:, 2].astype(np.int32),
            bar_band=bars[:, 3].astype(np.int32),
            bar_is_knot=bars[:, 4].astype(bool),
            bar_piece=bar_piece,
            mesh_piece=mesh_piece,
            facets=facets[:, :3].astype(np.int32),
            facet_image=facets[:, 3:6].astype(np.int32),
            facet_band=facets[:, 6].astype(np.int32),
            facet_weight=weight,
            mesh_sides=meshes[:, :8].reshape(-1, 4, 2).astype(np.int32),
            mesh_side_image=meshes[:, 8:16].reshape(-1, 4, 2).astype(np.int32),
            mesh_bars=_bars_of_sides(bars[:, :3], meshes[:, :8].reshape(-1, 2), meshes[:, 8:16].reshape(-1, 2)),
            mesh_row=meshes[:, 16].astype(np.int32),
            corners=np.concatenate(self.corners),
        )

    def _facet_table(self) -> tuple[NDArray, Floats]:
        """Facets without the empty ones, equal ones merged, and their weights."""
        table = np.concatenate(self.facets)
        nodes, images = table[:, :3], np.where(table[:, :3] == self.codline, 0, table[:, 3:6])
        table = np.concatenate([nodes, images, table[:, 6:]], axis=1)
        same = [(nodes[:, i] == nodes[:, j]) & (images[:, i] == images[:, j]) for i, j in ((0, 1), (1, 2), (2, 0))]
        table = table[~np.any(same, axis=0)]
        # by band, then by node and image
        table = table[np.lexsort((*table.T[-2::-1], table[:, -1]))]
        first = np.flatnonzero(np.append(True, (table[1:] != table[:-1]).any(axis=1)))
        return table[first], 0.5 * np.diff(first, append=len(table))


@dataclass(frozen=True)
class Layout:
    """Which nodes are joined by bars, facets, meshes and corners: what a net's counts and patterns decide alone.

    Fields are as those of ``Net`` and ``Bag`` but for the last.
    """

    codline: int
    bars: Ints
    bar_image: Ints
    bar_band: Ints
    bar_is_knot: NDArray[np.bool_]
    bar_piece: Ints
    """Number of the piece of other netting that a bar is of; -1: of the section's own."""
    mesh_piece: Ints
    """The same of meshes."""
    facets: Ints
    facet_image: Ints
    facet_band: Ints
    facet_weight: Floats
    """1, or 1/2 where a quadrangle is covered twice."""
    mesh_sides: Ints
    mesh_side_image: Ints
    mesh_bars: Ints
    mesh_row: Ints
    corners: Counts
    """Middle, first and second node of all corners between two twines, their images, the band of either twine (beyond
    all bands the number of a piece), and whether it lies across, (c, 9)."""


def _numbered(tables: Sequence[list[NDArray]]) -> tuple[NDArray, Ints]:
    """Parts of a net and then of its pieces, and the number of the piece that each is of, -1 of the net's own."""
    counts = [sum(map(len, table)) for table in tables]
    piece = np.repeat(np.arange(-1, len(tables) - 1, dtype=np.int32), counts)
    return np.concatenate([part for table in tables for part in table]), piece


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
