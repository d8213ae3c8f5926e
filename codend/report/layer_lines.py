"""Second layers as lines: the bars of their own meshes where they lie on the netting below, all round."""

from itertools import pairwise

import numpy as np

from codend.bag.bag import Bag, all_round
from codend.mechanics import wrap
from codend.net.net import Floats
from codend.plan.tables import Netting


def layer_lines(bag: Bag, positions: Floats) -> Floats:
    """Both ends of the bars of every second layer of a bag, m, (k, 2, 3).

    A layer is drawn out evenly over the netting below as it was built: its rows of knots lie where their share of the
    netting's length is reached, its knots where their share of the way round is. Knots of no length are drawn.
    """
    rings = _rings(bag, positions)
    found, start = [np.zeros((0, 2, 3))], 0
    for layer, band in zip(bag.layers, bag.layer_bands, strict=True):
        bands, first = np.unique(band, return_index=True)
        place = np.append(0.0, np.cumsum(bag.net.wrap_law[start + first, wrap.ROWS]))
        start += len(band)
        found.append(_bars(layer, rings[bands[0] :], place))
    return np.concatenate(found)


def _rings(bag: Bag, positions: Floats) -> list[tuple[Floats, Floats]]:
    """Of every row of knots the azimuths as built, rising from 0 to 1, (k,), and their places now, (k, 3)."""
    built, now = (all_round(bag, of).positions for of in (bag.net.positions, positions))
    row = np.tile(bag.node_row, bag.net.sectors)
    share = np.arctan2(built[:, 2], built[:, 1]) / (2.0 * np.pi) % 1.0
    order = np.lexsort((share, row))
    ends = np.searchsorted(row[order], np.arange(bag.bands + 2))
    return [(share[order[a:b]], now[order[a:b]]) for a, b in pairwise(ends)]


def _bars(layer: Netting, rings: list[tuple[Floats, Floats]], place: Floats) -> Floats:
    """Bars of a layer over rings that lie at these of its rows."""
    row, knot = np.meshgrid(np.arange(round(place[-1]) + 1), np.arange(layer.meshes_round), indexing="ij")
    square = not layer.kind.staggered
    half = np.zeros_like(row) if square else row % 2

    def at(row: np.ndarray, step: Floats | np.ndarray) -> Floats:
        share = step / layer.meshes_round
        ahead = np.clip(np.searchsorted(place, row, side="right") - 1, 0, len(place) - 2)
        part = ((row - place[ahead]) / (place[ahead + 1] - place[ahead]))[..., None]
        found = np.empty((*row.shape, 3))
        for ring in np.unique(ahead):
            there = ahead == ring
            fore, aft = (_on_ring(rings[i], share[there]) for i in (ring, ring + 1))
            found[there] = (1.0 - part[there]) * fore + part[there] * aft
        return found

    here, there = (row[:-1], knot[:-1] + 0.5 * half[:-1]), row[1:]
    if square:
        pairs = [(at(*here), at(there, here[1])), (at(row, knot), at(row, knot + 1))]
    else:
        pairs = [(at(*here), at(there, here[1] + side)) for side in (-0.5, 0.5)]
    return np.concatenate([np.stack(pair, axis=-2).reshape(-1, 2, 3) for pair in pairs])


def _on_ring(ring: tuple[Floats, Floats], share: Floats) -> Floats:
    """Places on a ring by their share of the way round, (k, 3)."""
    azimuth, places = ring
    return np.stack([np.interp(share % 1.0, azimuth, of, period=1.0) for of in places.T], axis=-1)
