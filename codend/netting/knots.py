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
    tapering = lattice.number[:-1] == lattice.number[1:]
    plain = ((lattice.columns[:-1] == lattice.columns[1:]) | tapering) & lattice.staggered[1:]
    across = np.concatenate([lie_across[:1], lie_across[:-1] & plain, [False]])
    fore_nodes = along * np.concatenate([[0], lattice.columns])
    nodes = fore_nodes + lattice.knots * (1 + across)
    fore_start = np.cumsum(nodes) - nodes
    return Knots(lattice, along, across, fore_start, fore_start + fore_nodes)


@dataclass(frozen=True)
class Places:
    """Where among the rows the nodes lie, whatever the sizes; arrays (k,) of the knots in all rings but the codline."""

    node_row: Ints
    """Row whose ring a node belongs to, -1 between two rings, (n,)."""
    row: Counts
    """Row of a knot."""
    owner: Counts
    """Band whose columns a row's knots are."""
    turns: Floats
    """Place in its ring, in half columns, times pi."""
    left: NDArray[np.integer]
    """Its node, or of one that lies across that to the left."""
    right: NDArray[np.integer]
    """That to the right, or the same."""
    across: NDArray[np.bool_] | None
    """Whether it lies across; None: none does."""
    band: Counts
    """Band at whose aft end a knot lies that has a node of its own ahead of the ring, (a,)."""
    ahead_turns: Floats
    """Place of such a knot, likewise, (a,)."""
    ahead: NDArray[np.integer]
    """Its node, (a,)."""
    shares: NDArray[np.bool_]
    """Whether it shares its node of the ring with others, (a,)."""
    laced_owner: Counts
    """Band whose columns that node is counted in, of those that share one."""
    laced_turns: Floats
    """Its place."""


def places_of(knots: Knots) -> Places:
    """Where the nodes of a net lie."""
    lattice = knots.lattice
    node_row = np.full(knots.codline + 1, -1, dtype=np.int32)
    node_row[knots.codline] = lattice.bands
    rows = np.arange(lattice.bands)
    ahead = np.maximum(rows - 1, 0)
    owner = np.where(lattice.columns[ahead] == lattice.knots[:-1], ahead, rows)
    row, knot = lattice.rings(rows)
    left, right = (knots.ring(side, row, knot, lattice.knots[row]).node for side in (LEFT, RIGHT))
    node_row[left] = node_row[right] = row
    band, column = lattice.places(np.flatnonzero(knots.along[1:]))
    aft = band + 1
    shares = (aft < lattice.bands) & (lattice.knots[aft] < lattice.columns[band])
    laced = lattice.laced(aft[shares], column[shares], lattice.columns[band[shares]])

    def turns(counted: Counts, row: Counts) -> Floats:
        return np.asarray((2 * counted + lattice.shift[row]) * np.pi)

    return Places(
        node_row=node_row,
        row=row,
        owner=owner[row],
        turns=turns(knot, row),
        left=left,
        right=right,
        across=knots.across[row] if knots.across.any() else None,
        band=band,
        ahead_turns=turns(column, aft),
        ahead=knots.fore(LEFT, aft, column).node,
        shares=shares,
        laced_owner=owner[aft[shares]],
        laced_turns=turns(laced, aft[shares]),
    )


def placed_knots(lattice: Lattice, places: Places, shape: RowShape) -> Floats:
    """Start position of every node, (n, 3)."""
    positions = np.empty((len(places.node_row), 3))
    positions[-1] = shape.x[-1], 0.0, 0.0
    knot_m = lattice.merged * lattice.of_bands(lambda section: section.knot_m)

    row, owner = places.row, places.owner
    azimuth = _azimuth(lattice, owner, places.turns)
    if places.across is None:
        positions[places.left] = shape.placed(row, azimuth)
    else:
        half_knot = np.where(places.across, 0.5 * knot_m[owner], 0.0)
        half_angle = np.arcsin(np.clip(half_knot / np.maximum(shape.radius[row], half_knot + 1e-300), 0.0, 1.0))
        turn = np.minimum(half_angle, 0.4 * np.pi / (lattice.knots[row] * lattice.order))
        positions[places.left] = shape.placed(row, azimuth - turn)
        positions[places.right] = shape.placed(row, azimuth + turn)
    if len(places.band) == 0:
        return positions

    # a knot keeps its length, however far the rows have closed up
    knot_share = np.minimum(knot_m / np.hypot(np.diff(shape.x), np.diff(shape.radius)), 0.9)
    band, shares = places.band, places.shares
    azimuth = _azimuth(lattice, band, places.ahead_turns)
    if len(places.laced_turns):
        # knots that share a node of the ring lie beside each other, ahead of it
        middle = _azimuth(lattice, places.laced_owner, places.laced_turns)
        reach = 0.5 * knot_m[band[shares]] / shape.radius[band[shares] + 1]
        azimuth[shares] = middle + np.clip(azimuth[shares] - middle, -reach, reach)
    positions[places.ahead] = shape.placed(band + 1, azimuth, knot_share[band])
    return positions


def _azimuth(lattice: Lattice, band: Counts, turns: Floats) -> Floats:
    """Azimuth of knots counted in the columns of a band, so many half columns, times pi, from its first, rad."""
    return lattice.phase[band] + turns / (lattice.columns[band] * lattice.order)
