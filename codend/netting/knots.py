"""Knots of a net: which nodes they are, in which image, and where they start.

Every knot has four ports, where the twines to the four neighbouring knots leave it: fore or aft, left or right. The
kinds of netting differ only in which ports are the same node: all four in ideal diamond and in square netting, the two
fore ones and the two aft ones when the knot lies along the netting (T0), the two left ones and the two right ones when
it lies across (T90). Bars, facets and meshes are written once, in ports.

Where two sections meet, the knots of the row are those of the section with fewer meshes round. The other one's are
laced to them in the ratio of the two counts, so that some of its knots share one: its twines end there, or its last
knots if they lie along the netting.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats, Ints
from codend.netting.lattice import Counts, Lattice
from codend.netting.parts import Corner, RowShape

LEFT, RIGHT = range(2)


@dataclass(frozen=True)
class Knots:
    """Numbers of the nodes, row by row: one or two a knot, and the codline after all others; arrays (rows + 1,)."""

    lattice: Lattice
    along: NDArray[np.bool_]
    """Whether the knots of a row lie along the netting: they have nodes of their own for the twines ahead."""
    across: NDArray[np.bool_]
    """Whether they lie across: they have one node to the left and one to the right."""
    fore_start: Counts
    """First of a row's nodes where the twines ahead end, the ring itself but for knots that lie along."""
    start: Counts
    """First node of a row's ring."""
    renumbered: Counts | None = None
    """Numbers that the nodes have in a net with windows, -1 where there are none any more; None: as they were."""

    @property
    def codline(self) -> int:
        """Node of the codline, the last one."""
        return int(self.start[-1]) if self.renumbered is None else int(self.renumbered[self.start[-1]])

    def ring(self, side: int | Counts, row: Counts, counted: Counts, columns: Counts) -> Corner:
        """Nodes of a row's ring that knots counted on all round are laced to, where there are ``columns`` of them."""
        knots = self.lattice.knots[row]
        laced = self.lattice.laced(row, counted, columns)
        number, image = self.lattice.numbered(laced, knots)
        # twines of several knots gathered on a seam do not cross it
        beside = self.lattice.beside_seam(row, counted, columns)
        side = np.where(beside == 0, side, np.where(beside < 0, LEFT, RIGHT))
        return Corner(self.now(self.start[row] + number + side * (self.across[row] * knots)), image)

    def fore(self, side: int, row: Counts, counted: Counts) -> Corner:
        """Nodes in which the twines of the band ahead end; its columns are counted on all round."""
        columns = self.lattice.columns[row - 1]
        ring = self.ring(side, row, counted, columns)
        number, image = self.lattice.numbered(counted, columns)
        own = self.along[row]
        node = np.where(own, self.now(np.where(own, self.fore_start[row] + number, 0)), ring.node)
        return Corner(node, np.where(own, image, ring.image))

    def now(self, node: Counts) -> Counts:
        """Numbers that nodes have now."""
        return node if self.renumbered is None else self.renumbered[node]

    def aft(self, side: int, row: Counts, counted: Counts) -> Corner:
        """Nodes from which the twines of the band behind start; its columns are counted on all round."""
        return self.ring(side, row, counted, self.lattice.columns[row])


def knots_of(lattice: Lattice) -> Knots:
    """Number the knots of a net.

    The knot of a row belongs to the band ahead of it; the entry's own row has knots only where they lie across, and
    the codline gathers those. Where the counts of two sections differ, or square mesh follows, the row is laced at
    points: its knots cannot lie across. Where a section tapers they do: of the two that are sewn together at a seam one
    lies there.
    """
    along = np.append(False, lattice.of_bands(lambda section: section.knot_along_m > 0.0))
    lie_across = lattice.of_bands(lambda section: section.knot_across_m > 0.0)
    tapering = np.array([ahead is aft for ahead, aft in pairwise(lattice.sections)], dtype=bool)
    plain = ((lattice.columns[:-1] == lattice.columns[1:]) | tapering) & lattice.staggered[1:]
    across = np.concatenate([lie_across[:1], lie_across[:-1] & plain, [False]])
    fore_nodes = along * np.concatenate([[0], lattice.columns])
    nodes = fore_nodes + lattice.knots * (1 + across)
    fore_start = np.cumsum(nodes) - nodes
    return Knots(lattice, along, across, fore_start, fore_start + fore_nodes)


def placed_knots(knots: Knots, shape: RowShape) -> tuple[Floats, Ints]:
    """Start position of every node, (n, 3), and the row whose ring it belongs to, -1 between two rings, (n,)."""
    lattice = knots.lattice
    positions = np.empty((knots.codline + 1, 3))
    node_row = np.full(knots.codline + 1, -1, dtype=np.int32)
    knot_m = lattice.merged * lattice.of_bands(lambda section: section.knot_m)
    # a knot keeps its length, however far the rows have closed up
    knot_share = np.minimum(knot_m / np.hypot(np.diff(shape.x), np.diff(shape.radius)), 0.9)

    # the band whose columns a row's knots are
    rows = np.arange(lattice.bands)
    ahead = np.maximum(rows - 1, 0)
    owner = np.where(lattice.columns[ahead] == lattice.knots[:-1], ahead, rows)
    row, knot = lattice.rings(rows)
    azimuth = _azimuth(lattice, owner[row], knot, row)
    half_knot = np.where(knots.across[row], 0.5 * knot_m[owner[row]], 0.0)
    half_angle = np.arcsin(np.clip(half_knot / np.maximum(shape.radius[row], half_knot + 1e-300), 0.0, 1.0))
    turn = np.minimum(half_angle, 0.4 * np.pi / (lattice.knots[row] * lattice.order))
    for side, sign in ((LEFT, -1.0), (RIGHT, 1.0)):
        node = knots.ring(side, row, knot, lattice.knots[row]).node
        positions[node] = shape.placed(row, azimuth + sign * turn)
        node_row[node] = row
    positions[knots.codline] = (shape.x[-1], 0.0, 0.0)
    node_row[knots.codline] = lattice.bands

    band, column = lattice.places(np.flatnonzero(knots.along[1:]))
    row = band + 1
    azimuth = _azimuth(lattice, band, column, row)
    # knots that share a node of the ring lie beside each other, ahead of it
    shares = (row < lattice.bands) & (lattice.knots[row] < lattice.columns[band])
    band_shared, row_shared = band[shares], row[shares]
    laced = lattice.laced(row_shared, column[shares], lattice.columns[band_shared])
    middle = _azimuth(lattice, owner[row_shared], laced, row_shared)
    reach = 0.5 * knot_m[band_shared] / shape.radius[row_shared]
    azimuth[shares] = middle + np.clip(azimuth[shares] - middle, -reach, reach)
    positions[knots.fore(LEFT, row, column).node] = shape.placed(row, azimuth, knot_share[band])
    return positions, node_row


def _azimuth(lattice: Lattice, band: Counts, column: Counts, row: Counts) -> Floats:
    """Azimuth of a knot counted in the columns of a band, in a row at either end of it, rad."""
    return lattice.phase[band] + (2 * column + lattice.shift[row]) * np.pi / (lattice.columns[band] * lattice.order)
