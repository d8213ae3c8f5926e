"""Second layers of netting: outer bags over part of the codend, laced to a row of it and gathered at its codline.

A layer lies on the netting below and shares its meridian, drawn out evenly over it: friction under the pressure of the
catch keeps it from sliding (an assumption; what it is worth is not known). It then has no unknowns of its own, and
limits how wide and how long the netting below can be (``mechanics.wrap``). Its drag is left out: it lies in the lee of
the twine below, or on the catch (an assumption as well). Its weight is on the twine below.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.net.net import Floats, Net
from codend.netting.knots import LEFT, RIGHT, Knots
from codend.plan.layers import Layer
from codend.plan.plan import Plan
from codend.plan.tables import Netting

GREATEST_STRAIN = 5e-3
"""Of a layer whose twine does not stretch, under twice the dynamic pressure on the mesh of its own bars."""


def with_layers(bag: Bag, plan: Plan, knots: Knots) -> Bag:
    """The bag with the layers of its plan."""
    for layer in plan.layer:
        bag = _with_layer(bag, plan, layer, knots)
    return bag


def lengths_of_bands(sections: list[Netting]) -> Floats:
    """Stretched length of every band, (bands,), m."""
    return np.array([section.bar_m + section.knot_along_m for section in sections])


def _with_layer(bag: Bag, plan: Plan, layer: Layer, knots: Knots) -> Bag:
    rows_below = plan.rows_to_codline(layer.meshes_from_codline[1])
    assert rows_below is not None
    net, lattice = bag.net, knots.lattice
    bands = np.arange(lattice.bands - rows_below, lattice.bands)
    length = lengths_of_bands(lattice.sections)[bands]
    rows = layer.rows_per_mesh * layer.meshes_long * length / length.sum()
    row, first = np.append(bands, lattice.bands), np.zeros(rows_below + 1, dtype=int)
    sides = [knots.ring(side, row[:-1], first[:-1], lattice.knots[row[:-1]]).node for side in (LEFT, RIGHT)]
    ring = np.append(np.stack(sides, axis=1), np.full((1, 2), knots.codline), axis=0)
    square = float(not layer.kind.staggered)
    # bars of a sector over a band: two a mesh and row, of square mesh one each way
    count = (1.0 if square else 2.0) * layer.meshes_round / net.order * rows
    law = np.stack(
        np.broadcast_arrays(
            np.pi / layer.meshes_round, layer.knot_across_m / 2.0 if square else layer.knot_across_m, rows,
            layer.knot_along_m, layer.bar_m, _stiffness_n(plan, layer), count, square,
        ),
        axis=1,
    )  # fmt: skip
    laid = replace(
        net,
        wrap_ring=np.concatenate([net.wrap_ring, np.hstack([ring[:-1], ring[1:]]).astype(np.int32)]),
        wrap_law=np.concatenate([net.wrap_law, law]),
    )
    laid = _with_twine(laid, bag, plan, layer, bands, count)
    return replace(bag, net=laid, layer_bands=(*bag.layer_bands, bands.astype(np.int32)))


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
