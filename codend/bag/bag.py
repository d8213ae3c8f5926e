"""A bag: the net of a codend, and what makes it one: rows of knots, bands of netting, meshes, straps and merging.

Rows count rings of knots from the entry, row 0, to the codline; band j is the netting between rows j and j + 1.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag_kernels import BagStructure
from codend.bag.measure_kernels import write_corners
from codend.net.net import Floats, Ints, Net, numbered_all_round, rotate, split_bars
from codend.plan.kinds import Kind
from codend.plan.tables import Netting


@dataclass(frozen=True)
class Bag:
    """A net with its place in the codend."""

    net: Net
    node_row: Ints
    """Row whose ring polygon the node belongs to, -1 for a node between two rings, (n,)."""
    bar_band: Ints
    """Band a bar lies in, (m,)."""
    bar_is_twine: NDArray[np.bool_]
    """Whether a bar is twine of the netting: no knot and no strap, (m,)."""
    facet_band: Ints
    """Band a facet lies in, (f,)."""
    band_meshes: Floats
    """Meshes that a band is long, (bands,)."""
    sections: tuple[Netting, ...]
    """Netting of the sections from the entry."""
    band_section: NDArray[np.int64]
    """Number among them of each band's, (bands,)."""

    mesh_sides: Ints
    """First and second node of the four twine sides of a mesh, walking round it: fore to right, right to aft, aft to
    left, left to fore, (k, 4, 2)."""
    mesh_side_image: Ints
    """Images of those nodes, (k, 4, 2)."""
    mesh_bars: Ints
    """Bars of those sides, -1 where a side is held and no bar, (k, 4)."""
    mesh_row: Ints
    """Row that counts a mesh, at its widest part or, of a mesh that lies in one band, ahead of it, (k,)."""

    globalisation: float = 1
    """Real meshes merged into one, each way."""
    abreast: int = 1
    """Sectors that would be equal but for the ropes, side by side in one that is modelled."""
    straps: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    """Bars that are ropes round the netting, (s,)."""
    strap_share: Floats = field(default_factory=lambda: np.zeros(0))
    """Tension of the real rope over that of its bar, (s,)."""
    ropes: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    """Bars that are ropes along the netting, from the entry, rope by rope and behind all other bars, (p,)."""
    rope_share: Floats = field(default_factory=lambda: np.zeros(0))
    """Tension of the real rope over that of its bar, (p,)."""
    rope_name: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    """1000 times the plan's table of the rope, plus its number among the equal ones, both from 0, (p,)."""
    windows: tuple[Netting, ...] = ()
    """Netting of the windows that are let in."""
    mesh_window: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    """Window that a mesh is of, -1 for none, (k,); empty: all -1."""
    bar_window: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    """Window that a bar of netting is of, -1 for none; empty: all -1."""
    anchors: int = 0
    """Nodes of the hoop that only ropes start from, behind all others."""

    layers: tuple[Netting, ...] = ()
    """Netting of the second layers over it."""
    layer_bands: tuple[Ints, ...] = ()
    """Band that each cell of each second layer lies over, in the order of the net's ``wrap_node``."""
    layer_rows: tuple[Ints, ...] = ()
    """Row of knots in which its base is, likewise."""

    @property
    def bands(self) -> int:
        """Number of bands of netting from the entry to the codline."""
        return len(self.band_meshes)

    @cached_property
    def row_place(self) -> Floats:
        """Place of every row of knots, in meshes from the entry, (bands + 1,)."""
        return np.concatenate([[0.0], np.cumsum(self.band_meshes)])

    @cached_property
    def ring_size(self) -> Floats:
        """Nodes in the ring polygon of each row, (bands + 1,)."""
        rings = self.node_row[self.node_row >= 0]
        return np.bincount(rings, minlength=self.bands + 1).astype(np.float64)

    @property
    def band_kind(self) -> tuple[Kind, ...]:
        """Kind of netting of each band, (bands,)."""
        return tuple(self.sections[number].kind for number in self.band_section)

    @property
    def tips(self) -> bool:
        """Whether any of its netting lets it tip at its hoop (``Kind.tips``)."""
        return any(section.kind.tips for section in self.sections)

    @property
    def turned(self) -> bool:
        """Whether any of its netting has its knots across."""
        return any(section.kind.knots == "across" for section in self.sections)

    @cached_property
    def band_is_staggered(self) -> NDArray[np.bool_]:
        """Whether the rows at either end of a band are half a mesh apart, a whole one otherwise, (bands,)."""
        return np.array([section.kind.staggered for section in self.sections])[self.band_section]

    @property
    def band_bending_n(self) -> Floats:
        """24 EI / b^2 of each band's real meshes, (bands,)."""
        return np.array([section.bending_n for section in self.sections])[self.band_section]

    @cached_property
    def _mesh_netting(self) -> NDArray[np.int64]:
        """Number of a mesh's netting among those of sections and then of windows, (k,)."""
        own = self.band_section[self._mesh_behind]
        if not self.windows:
            return own
        return np.where(self.mesh_window >= 0, len(self.sections) + self.mesh_window, own)

    def _of_meshes(self, value: Callable[[Netting], float | bool]) -> NDArray:
        """What a mesh has of its netting, (k,)."""
        return np.array([value(netting) for netting in (*self.sections, *self.windows)])[self._mesh_netting]

    @cached_property
    def mesh_is_staggered(self) -> NDArray[np.bool_]:
        """Whether a mesh has its sides aslant; otherwise along and across, (k,)."""
        return self._of_meshes(lambda netting: netting.kind.staggered)

    @cached_property
    def mesh_is_folded(self) -> NDArray[np.bool_]:
        """Whether a mesh is folded over its widest part by a strap, (k,)."""
        if len(self.straps) == 0:
            return np.zeros(len(self.mesh_row), dtype=bool)
        return np.isin(self.mesh_row, self.node_row[self.net.bars[self.straps, 0]]) & self.mesh_is_staggered

    @cached_property
    def _mesh_behind(self) -> Ints:
        """Band that a mesh reaches behind into, (k,)."""
        return np.minimum(self.mesh_row, self.bands - 1)

    @cached_property
    def mesh_bands(self) -> tuple[Ints, Ints]:
        """Bands that a mesh reaches ahead and behind into, the same of one that lies in one band, each (k,)."""
        behind = self._mesh_behind
        return np.where(self.mesh_is_staggered, np.maximum(behind - 1, 0), behind), behind

    @cached_property
    def held_by_the_entry(self) -> NDArray[np.bool_]:
        """Nodes that the hoop at the entry holds, (n,): the only ones that a gear holds."""
        held = self.net.fixed.all(axis=1) & (self.node_row == 0)
        held[len(held) - self.anchors :] = True
        return np.asarray(held)

    @cached_property
    def structure(self) -> BagStructure:
        """The bag as kernels see it."""
        ahead, behind = self.mesh_bands
        own = np.ones(len(self.net.bars), dtype=bool)
        own[self.straps] = own[self.ropes] = False
        return BagStructure(
            order=float(self.net.order),
            globalisation=float(self.globalisation),
            sides=self.mesh_sides,
            side_image=self.mesh_side_image,
            mesh_bars=self.mesh_bars,
            mesh_row=self.mesh_row,
            mesh_is_staggered=self.mesh_is_staggered,
            mesh_is_folded=self.mesh_is_folded,
            mesh_ahead=ahead,
            mesh_behind=behind,
            mesh_opens=self.mesh_opens,
            mesh_bending_n=self.mesh_bending_n,
            mesh_rest_rad=self.mesh_rest_rad,
            mesh_of_section=self.mesh_of_section,
            mesh_place=self.mesh_place,
            node_row=self.node_row,
            held_by_the_entry=self.held_by_the_entry,
            twine_band=np.where(self.bar_is_twine, self.bar_band, -1),
            band_meshes=self.band_meshes,
            netting=own,
            straps=self.straps,
            ropes=self.ropes,
            smeared=self.smeared,
        )

    @property
    def smeared(self) -> bool:
        """Whether ropes are spread over all columns of knots, a share of one along each."""
        return len(self.ropes) > 0 and bool(self.rope_share.min() != 1.0)

    @cached_property
    def mesh_opens(self) -> NDArray[np.bool_]:
        """Whether a mesh opens and closes, (k,)."""
        return self._of_meshes(lambda netting: netting.kind.opens)

    @cached_property
    def mesh_bending_n(self) -> Floats:
        """24 EI / b^2 of a mesh, (k,)."""
        return self._of_meshes(lambda netting: netting.bending_n)

    @cached_property
    def mesh_rest_rad(self) -> Floats:
        """Half the opening at which it is at rest, (k,)."""
        return self._of_meshes(lambda netting: netting.rest_half_angle_rad)

    @cached_property
    def mesh_of_section(self) -> NDArray[np.bool_]:
        """Whether a mesh is of its section's own netting, not of a window, (k,)."""
        return self.mesh_window < 0 if self.windows else np.ones(len(self.mesh_row), dtype=bool)

    @cached_property
    def mesh_place(self) -> Floats:
        """Middle of the meshes that a row counts, in meshes from the entry, (bands + 1,)."""
        behind = np.append(0.5 * self.band_meshes * ~self.band_is_staggered, 0.0)
        return self.row_place + behind


def mesh_corners(bag: Bag, positions: Floats) -> Floats:
    """End positions of the four sides of every mesh, (k, 4, 2, 3): mesh, side, end, coordinate."""
    corners = np.empty((len(bag.mesh_sides), 4, 2, 3))
    write_corners(positions, bag.mesh_sides, bag.mesh_side_image, float(bag.net.order), corners)
    return corners


@dataclass(frozen=True)
class WholeBag:
    """The sectors of a bag set side by side all round: for pictures, files and sums over the whole net."""

    positions: Floats
    """All nodes, (sectors * n, 3); nodes on the axis occur once a sector."""
    bars: Ints
    """(sectors * m, 2); bar i of sector s is number s * m + i."""
    meshes: Ints
    """Ends of the four sides of a mesh, (sectors * k, 8), walking round it; corners may repeat."""


def all_round(bag: Bag, positions: Floats) -> WholeBag:
    """Repeat one sector all round; values of bars and meshes are repeated with ``numpy.tile(values, net.sectors)``."""
    net = bag.net
    sectors = net.sectors
    if sectors != net.order:
        # as many as there is room for, each a little wider or narrower
        azimuth = net.order / sectors * np.arctan2(positions[:, 2], positions[:, 1])
        radius = np.hypot(positions[:, 1], positions[:, 2])
        positions = np.stack([positions[:, 0], radius * np.cos(azimuth), radius * np.sin(azimuth)], axis=1)
    whole = rotate(np.broadcast_to(positions, (sectors, *positions.shape)), np.arange(sectors)[:, None], sectors)
    bar_images = np.stack([np.zeros_like(net.bar_image), net.bar_image], axis=1)
    return WholeBag(
        positions=whole.reshape(-1, 3),
        bars=numbered_all_round(net, net.bars, bar_images),
        meshes=numbered_all_round(net, bag.mesh_sides, bag.mesh_side_image).reshape(-1, 8),
    )


def real_tensions(bag: Bag, bar_tension: Floats) -> Floats:
    """Tension of the real bars and ropes that the bars of a bag stand for, N, (m,)."""
    real = bar_tension / bag.globalisation
    real[bag.straps] = bag.strap_share * bar_tension[bag.straps]
    real[bag.ropes] = bag.rope_share * bar_tension[bag.ropes]
    return real


def with_hinges(bag: Bag) -> Bag:
    """The bag with a hinge in the middle of every bar of twine (Le Bris et al. 1999, figure 1)."""
    split = np.flatnonzero(bag.bar_is_twine)
    return replace(
        bag,
        net=split_bars(bag.net, bag.bar_is_twine),
        node_row=np.append(bag.node_row, np.full(len(split), -1, dtype=np.int32)),
        bar_band=np.append(bag.bar_band, bag.bar_band[split]),
        bar_is_twine=np.append(bag.bar_is_twine, bag.bar_is_twine[split]),
    )


def around(bag: Bag, net: Net, band: int | Ints) -> Bag:
    """The bag of a net that has more nodes and bars after its own: no knots of a row, no twine, in given bands."""
    nodes, bars = len(net.positions) - len(bag.node_row), len(net.bars) - len(bag.bar_band)
    return replace(
        bag,
        net=net,
        node_row=np.append(bag.node_row, np.full(nodes, -1, dtype=np.int32)),
        bar_band=np.append(bag.bar_band, np.broadcast_to(np.asarray(band, dtype=np.int32), (bars,))),
        bar_is_twine=np.append(bag.bar_is_twine, np.zeros(bars, dtype=bool)),
    )
