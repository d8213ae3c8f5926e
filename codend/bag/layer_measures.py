"""What the second layers of a solved bag do: their openings, tensions, and the load that each carries."""

from dataclasses import dataclass

import numpy as np

from codend.bag.bag import Bag
from codend.mechanics import wrap
from codend.mechanics.problem import Problem
from codend.mechanics.structure import Structure
from codend.net.net import Floats, Ints, bar_vectors
from codend.solvers.outcome import Solution

LEAST_RADIUS_M = 1e-9
"""Of the codline, round which nothing pulls."""


@dataclass(frozen=True)
class LayerRows:
    """A layer band by band of the netting below, from where it begins; arrays (bands,)."""

    band: Floats
    """Number of the band."""
    x_m: Floats
    radius_m: Floats
    opening_deg: Floats
    bar_tension_n: Floats
    """Largest of the layer's real bars."""
    hoop_share: Floats
    """Share of the hoop load of the netting and all layers there that this one carries; 0 where there is none."""
    axial_share: Floats
    """Share of the load along the meridian, likewise."""
    hoop_load: Floats
    """Inward pull of all on a sector, N."""
    drawn: Floats
    """Largest length to which the netting below draws the layer's bars, over their own: from 1 on they pull."""


def measure_layers(bag: Bag, problem: Problem, solution: Solution) -> list[LayerRows]:
    """The layers of a bag, in the order of its plan."""
    position, structure = np.ascontiguousarray(solution.positions), problem.structure
    (x_of_row, radius_of_row), cells = _rings(bag, position), _cells(bag, structure, position)
    radius = np.maximum(radius_of_row, LEAST_RADIUS_M)
    own = [
        (one.by_band(one.round_n / radius[one.row], bag.bands), one.by_band(one.along_n, bag.bands)) for one in cells
    ]
    hoop, axial = np.array(_loads_below(bag, solution)) + np.array(own).sum(axis=0)
    found = []
    for one, (own_hoop, own_axial) in zip(cells, own, strict=True):
        bands = np.unique(one.band)
        across, along = one.by_band(one.across_m, bag.bands), one.by_band(one.length_m, bag.bands)
        opening = np.full(bag.bands, 90.0) if one.square else np.degrees(2.0 * np.arctan2(across, along))
        found.append(
            LayerRows(
                band=bands.astype(float),
                x_m=0.5 * (x_of_row[bands] + x_of_row[bands + 1]),
                radius_m=0.5 * (radius_of_row[bands] + radius_of_row[bands + 1]),
                opening_deg=opening[bands],
                bar_tension_n=np.array([one.largest_tension_n(band) for band in bands]),
                hoop_share=_share(own_hoop, hoop)[bands],
                axial_share=_share(own_axial, axial)[bands],
                hoop_load=hoop[bands],
                drawn=np.array([one.drawn[one.band == band].max() for band in bands]),
            )
        )
    return found


@dataclass(frozen=True)
class _Cells:
    """Cells of a layer; arrays (cells,)."""

    square: bool
    band: Ints
    row: Ints
    """Row of the base."""
    across_m: Floats
    """Half diagonal of its meshes across."""
    length_m: Floats
    """And along."""
    round_n: Floats
    """Pull along the base times its length, N m."""
    along_n: Floats
    tension_n: Floats
    """Largest of its bars."""
    drawn: Floats
    """Length of the longest over its own."""

    def largest_tension_n(self, band: int) -> float:
        """Largest of a band's bars, each as long as the mean of the cells on either row's sides makes it."""
        here = self.band == band
        fore, aft = (self.tension_n[here & (self.row == row)] for row in (band, band + 1))
        side = np.arange(max(len(fore), len(aft)))
        return float(np.max(fore[side * len(fore) // len(side)] + aft[side * len(aft) // len(side)])) / 2.0

    def by_band(self, values: Floats, bands: int) -> Floats:
        """Values added up in each of all bands."""
        return np.asarray(np.bincount(self.band, values, bands), dtype=float)


def _cells(bag: Bag, structure: Structure, position: Floats) -> list[_Cells]:
    span, diagonal, pull, drawn = wrap.of_cells(position, structure)
    across, length = np.linalg.norm(diagonal, axis=2).T
    work, found, start = np.einsum("wki,wki->kw", span, pull), [], 0
    along = work[1] / np.linalg.norm(span[:, 1], axis=1)
    tension = structure.wrap_law[:, wrap.STIFFNESS] * np.maximum(drawn - 1.0, 0.0)
    for band, row in zip(bag.layer_bands, bag.layer_rows, strict=True):
        own = slice(start, start + len(band))
        start += len(band)
        square = bool(structure.wrap_law[own][0, wrap.SQUARE])
        measured = (across, length, work[0], along, tension, drawn)
        found.append(_Cells(square, band, row, *(values[own] for values in measured)))
    return found


def _share(own: Floats, whole: Floats) -> Floats:
    return np.divide(own, whole, out=np.zeros_like(own), where=whole > 0.0)


def _rings(bag: Bag, position: Floats) -> tuple[Floats, Floats]:
    """Mean place along the axis and radius of every row of knots, each (rows,)."""
    ring = np.flatnonzero(bag.node_row >= 0)
    row, place = bag.node_row[ring], position[ring]
    radius = np.linalg.norm((place - _middles(bag, position)[row])[:, 1:], axis=1)
    rows, size = bag.bands + 1, bag.ring_size
    return np.bincount(row, place[:, 0], rows) / size, np.bincount(row, radius, rows) / size


def _middles(bag: Bag, position: Floats) -> Floats:
    """Middle of every row's ring of a whole net, and the axis of a sector, (rows, 3)."""
    middle = np.zeros((bag.bands + 1, 3))
    if bag.net.order == 1:
        ring = np.flatnonzero(bag.node_row >= 0)
        np.add.at(middle, bag.node_row[ring], position[ring] / bag.ring_size[bag.node_row[ring], None])
    return middle


def _loads_below(bag: Bag, solution: Solution) -> tuple[Floats, Floats]:
    """Inward pull of the netting's twine by its hoop tension, and its pull along the meridian, of each band, N."""
    net = bag.net
    vector = bar_vectors(net, solution.positions)
    length = np.linalg.norm(vector, axis=1)
    first = solution.positions[net.bars[:, 0]]
    bands = bag.bar_band
    centre = _middles(bag, solution.positions)
    middle = first[:, 1:] + 0.5 * vector[:, 1:] - 0.5 * (centre[bands] + centre[bands + 1])[:, 1:]
    radius = np.hypot(middle[:, 0], middle[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        outward = (vector[:, 1:] * middle).sum(axis=1) / radius
        around = np.sqrt(np.maximum(length**2 - vector[:, 0] ** 2 - outward**2, 0.0))
        hoop = solution.bar_tension * around / length * around / radius
    along = solution.bar_tension * np.hypot(vector[:, 0], outward) / length
    twine = bag.bar_is_twine

    def by_band(pull: Floats) -> Floats:
        return np.asarray(np.bincount(bag.bar_band[twine], np.nan_to_num(pull[twine]), bag.bands), dtype=float)

    return by_band(hoop), by_band(along)


def hoop_share_of_catch(rows: LayerRows, share: Floats) -> float:
    """Share of the hoop load on the catch that a layer carries, over the bands that lie in it, so much of each."""
    weights = share[rows.band.astype(int)] * rows.hoop_load
    return float(np.average(rows.hoop_share, weights=weights)) if weights.sum() > 0.0 else float("nan")


def of_the_catch(bag: Bag, problem: Problem, solution: Solution) -> tuple[float, float, float]:
    """Share of the hoop load on the catch in all layers, their largest tension, N, and their mean opening there."""
    rows = measure_layers(bag, problem, solution)
    share = sum(hoop_share_of_catch(one, solution.share) for one in rows)
    inside = [solution.share[one.band.astype(int)] > 0.0 for one in rows]
    openings = np.concatenate([one.opening_deg[there] for one, there in zip(rows, inside, strict=True)])
    opening = float(openings.mean()) if len(openings) else float("nan")
    return float(share), max(float(one.bar_tension_n.max()) for one in rows), opening
