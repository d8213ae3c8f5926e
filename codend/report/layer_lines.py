"""Second layers as lines: the bars of their own meshes where they lie on the netting below, all round."""

import numpy as np

from codend.bag.bag import Bag
from codend.mechanics import wrap
from codend.net.net import Floats


def layer_lines(bag: Bag, positions: Floats) -> Floats:
    """Both ends of the bars of every second layer of a bag, m, (k, 2, 3).

    A layer is drawn out evenly over the netting below, so that its rows of knots lie where its share of their number
    is reached, at the mean radius there. Knots of no length are drawn.
    """
    ring, law, start = bag.net.wrap_ring, bag.net.wrap_law, 0
    x = positions[:, 0]
    radius = np.hypot(positions[:, 1], positions[:, 2])
    found = [np.zeros((0, 2, 3))]
    for bands in bag.layer_bands:
        own, laws = ring[start : start + len(bands)], law[start : start + len(bands)]
        start += len(bands)
        fore, aft = own[:, :2], own[-1:, 2:]
        place = np.append(0.0, np.cumsum(laws[:, wrap.ROWS]))
        row = np.arange(round(place[-1]) + 1)
        along, across = (
            np.interp(row, place, np.append(of[fore].mean(axis=1), of[aft].mean(axis=1))) for of in (x, radius)
        )
        found.append(_bars(along, across, round(np.pi / laws[0, wrap.ROUND]), bool(laws[0, wrap.SQUARE])))
    return np.concatenate(found)


def _bars(along: Floats, across: Floats, meshes: int, square: bool) -> Floats:
    """Bars between rows of knots at these places and radii, so many meshes round."""
    row, knot = np.meshgrid(np.arange(len(along)), np.arange(meshes), indexing="ij")
    half = np.zeros_like(row) if square else row % 2

    def at(row: np.ndarray, step: Floats | np.ndarray) -> Floats:
        angle = 2.0 * np.pi * step / meshes
        return np.stack([along[row], across[row] * np.cos(angle), across[row] * np.sin(angle)], axis=-1)

    here, there = (row[:-1], knot[:-1] + 0.5 * half[:-1]), row[1:]
    if square:
        pairs = [(at(*here), at(there, here[1])), (at(row, knot), at(row, knot + 1))]
    else:
        pairs = [(at(*here), at(there, here[1] + side)) for side in (-0.5, 0.5)]
    return np.concatenate([np.stack(pair, axis=-2).reshape(-1, 2, 3) for pair in pairs])
