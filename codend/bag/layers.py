"""Second layers of netting: outer bags over part of the codend, laced to a row of it and gathered at its codline.

A layer lies on the netting below and moves with it, drawn out evenly over each of its meshes: friction under the
pressure of the catch keeps it from sliding (an assumption, and what it may be worth is in the errors:
``equilibrium.sliding``). It then has no unknowns of its own, and limits how wide and how long the
netting below can be (``mechanics.wrap``). Its drag is left out: it lies in the lee of the twine below, or on the catch
(an assumption as well). Its weight is on the twine below.

Its cells are triangles between two rows of knots: a side of the one's ring, and the place on the other's beside its
middle.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.errors import InputError
from codend.net.net import Floats, Ints, Net
from codend.netting.knots import LEFT, RIGHT, Knots
from codend.netting.lattice import Counts, Lattice
from codend.plan.layers import Layer
from codend.plan.plan import Plan
from codend.plan.tables import Netting

GREATEST_STRAIN = 5e-3
"""Of a layer whose twine does not stretch, under twice the dynamic pressure on the mesh of its own bars."""


@dataclass(frozen=True)
class _Cells:
    """Cells of a layer; arrays (w,) but for the first three."""

    node: Ints
    """(w, k)."""
    image: Ints
    weight: Floats
    """(w, 2, k)."""
    band: Ints
    row: Ints
    """Row of the base."""
    around: Floats
    """Cells as there are in the ring of the base, all round."""


def with_layers(bag: Bag, plan: Plan, knots: Knots) -> Bag:
    """The bag with the layers of its plan.

    Raises:
        InputError: a layer lies over windows or over netting that tapers.
    """
    for index, layer in enumerate(plan.layer):
        bag = _with_layer(bag, plan, index, layer, knots)
    return bag


def _with_layer(bag: Bag, plan: Plan, index: int, layer: Layer, knots: Knots) -> Bag:
    rows_below = plan.rows_to_codline(layer.meshes_from_codline[1])
    assert rows_below is not None
    net, lattice = bag.net, knots.lattice
    bands = np.arange(lattice.bands - round(rows_below / lattice.globalisation), lattice.bands)
    _check_below(plan, index, [lattice.section(band) for band in bands])
    length = lattice.stretched_m[bands]
    rows = layer.rows_per_mesh * layer.meshes_long * length / length.sum()
    square = not layer.kind.staggered
    # bars of a sector over a band, of either way
    count = layer.meshes_round / net.order * rows
    cells = _cells_over(knots, bands)
    own = cells.band - bands[0]
    law = np.stack(
        np.broadcast_arrays(
            # a ring of knots is a polygon in the circle that the layer runs round
            np.pi / layer.meshes_round / (2.0 * np.sin(np.pi / cells.around)),
            layer.knot_across_m / 2.0 if square else layer.knot_across_m, rows[own], layer.knot_along_m, layer.bar_m,
            _stiffness_n(plan, layer), 0.5 * count[own] * net.order / cells.around, float(square),
        ),
        axis=1,
    )  # fmt: skip
    laid = replace(
        net,
        wrap_node=_beside(net.wrap_node, cells.node),
        wrap_image=_beside(net.wrap_image, cells.image),
        wrap_weight=_beside(net.wrap_weight, cells.weight),
        wrap_law=np.concatenate([net.wrap_law, law]),
    )
    laid = _with_twine(laid, bag, plan, layer, bands, 2.0 * count)
    return replace(
        bag,
        net=laid,
        layers=(*bag.layers, layer),
        layer_bands=(*bag.layer_bands, cells.band),
        layer_rows=(*bag.layer_rows, cells.row),
    )


def _check_below(plan: Plan, index: int, below: list[Netting]) -> None:
    """Refuse what a layer has no place over."""
    key = f"layer.{index}.meshes_from_codline"
    value = plan.layer[index].meshes_from_codline
    if plan.window:
        where = ", ".join(plan.window_names)
        raise InputError(plan.source, key, value, f"no layer beside {where}: what lies over windows has no model yet")
    if any(part.tapers for part in below):
        allowed = "over netting that does not taper: layers have no model there yet"
        raise InputError(plan.source, key, value, allowed)


def _beside(own: NDArray, more: NDArray) -> NDArray:
    """Two arrays, one after the other, the narrower one filled up: nodes with their first, which counts 0 then."""
    wide = max(own.shape[-1], more.shape[-1])

    def filled(part: NDArray) -> NDArray:
        short = wide - part.shape[-1]
        last = np.zeros_like(part[..., :1]) if part.ndim == 3 else part[..., :1]
        return np.concatenate([part, *[last] * short], axis=-1)

    return np.concatenate([filled(own), filled(more)])


def _cells_over(knots: Knots, bands: NDArray[np.integer]) -> _Cells:
    """Cells over some bands, sides of either row of each."""
    parts = [_cells(knots, int(band), base) for band in bands for base in (band, band + 1)]
    node, image, weight, band, row, around = (np.concatenate([part[i] for part in parts]) for i in range(len(parts[0])))
    return _Cells(*_each_node_once(node, image, weight), band, row, around)


def _cells(knots: Knots, band: int, base: int) -> tuple[NDArray, ...]:
    """Fields of the cells over a band whose base is in one of its rows, each node of a knot named for itself, k = 8."""
    lattice = knots.lattice
    other = 2 * band + 1 - base
    # at the codline all sides are points
    columns = int(lattice.knots[base] if base < lattice.bands else lattice.knots[other])
    side = np.arange(columns)
    place = _place_beside(lattice, base, other, side)
    first = np.floor(place + 1e-9).astype(np.int64)
    beyond = np.where(place - first < 1e-9, 0.0, place - first)
    part = np.zeros((columns, 2, 4))
    if lattice.bands not in (base, other):  # bars that the codline gathers run straight to it
        part[:, 0, 0], part[:, 0, 1] = -1.0, 1.0
    part[:, 1, :2] = -0.5
    part[:, 1, 2], part[:, 1, 3] = 1.0 - beyond, beyond
    corners = [
        _knot(knots, row, at) for row, at in ((base, side), (base, side + 1), (other, first), (other, first + 1))
    ]
    node, image = (np.concatenate([corner[i] for corner in corners], axis=1) for i in range(2))
    one = np.ones(columns, dtype=np.int64)
    return node, image, np.repeat(0.5 * part, 2, axis=2), band * one, base * one, columns * lattice.order * one


def _place_beside(lattice: Lattice, base: int, other: int, side: Counts) -> Floats:
    """Where the middle of a ring's side is on another ring, in its own knots."""
    if lattice.bands in (base, other):
        return side.astype(float)
    columns = lattice.knots[[base, other]] * lattice.order
    owner = [row if lattice.columns[row] == lattice.knots[row] else row - 1 for row in (base, other)]
    turn = lattice.phase[owner[0]] - lattice.phase[owner[1]]
    half = 0.5 * lattice.shift[[base, other]]
    azimuth = 2.0 * np.pi / columns[0] * (side + 0.5 + half[0]) + turn
    return np.asarray(azimuth * columns[1] / (2.0 * np.pi) - half[1])


def _knot(knots: Knots, row: int, number: Counts) -> tuple[Ints, Ints]:
    """Left and right nodes of knots of a row, and their images, each (knots, 2)."""
    lattice = knots.lattice
    if row == lattice.bands:
        node = np.full((len(number), 2), knots.codline, dtype=np.int32)
        return node, np.zeros_like(node)
    rows = np.full(len(number), row)
    found = [knots.ring(side, rows, number, lattice.knots[rows]) for side in (LEFT, RIGHT)]
    node, image = (np.stack([getattr(corner, name) for corner in found], axis=1) for name in ("node", "image"))
    return node.astype(np.int32), image.astype(np.int32)


def _each_node_once(node: Ints, image: Ints, weight: Floats) -> tuple[Ints, Ints, Floats]:
    """Cells with what counts of each of their nodes added up, and no more places than it takes."""
    number = np.empty_like(node)
    for place in range(node.shape[1]):
        same = (node == node[:, place, None]) & (image == image[:, place, None])
        number[:, place] = same.argmax(axis=1)
    summed = np.zeros_like(weight)
    for place in range(node.shape[1]):
        summed[np.arange(len(node)), :, number[:, place]] += weight[:, :, place]
    counts = np.abs(summed).max(axis=1) > 1e-12
    order = np.argsort(~counts, axis=1, kind="stable")[:, : counts.sum(axis=1).max()]
    used = np.take_along_axis(counts, order, axis=1)
    order = np.where(used, order, order[:, :1])
    kept = np.take_along_axis(summed, order[:, None], axis=2) * used[:, None]
    return np.take_along_axis(node, order, axis=1), np.take_along_axis(image, order, axis=1), kept


def _stiffness_n(plan: Plan, layer: Layer) -> float:
    """EA of the layer's twine, N; of twine that does not stretch one under which it hardly does."""
    if layer.axial_stiffness_n is not None:
        return layer.axial_stiffness_n
    pressure = plan.tow.water_density_kg_m3 * max(plan.tow.speed_m_s) ** 2
    # a ring of netting under pressure: N bars a row, each of b sin phi round
    return pressure * layer.stretched_radius_m * layer.bar_m / GREATEST_STRAIN


def _with_twine(net: Net, bag: Bag, plan: Plan, layer: Layer, bands: NDArray[np.integer], count: Floats) -> Net:
    """The net with the weight of the layer's twine on its own."""
    solid, density = net.bar_solid_diameter**2, net.bar_density.copy()
    water = plan.tow.water_density_kg_m3
    for band, bars in zip(bands, count * layer.bar_m, strict=True):
        own = np.flatnonzero(bag.bar_is_twine & (bag.bar_band == band))
        length = float(net.bar_length[own].sum())
        more = layer.solid_diameter_m**2 * bars / length
        heavier = np.nan_to_num(density[own] - water) * solid[own]
        heavier += 0.0 if layer.density_kg_m3 is None else (layer.density_kg_m3 - water) * more
        solid[own] += more
        weighs = ~np.isnan(density[own]) | (layer.density_kg_m3 is not None)
        density[own] = np.where(weighs, water + heavier / solid[own], np.nan)
    return replace(net, bar_solid_diameter=np.sqrt(solid), bar_density=density)
