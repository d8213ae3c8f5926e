"""What the second layers of a solved bag do: their openings, tensions, and the load that each carries."""

from dataclasses import dataclass

import numpy as np

from codend.bag.bag import Bag
from codend.mechanics import wrap
from codend.mechanics.problem import Problem
from codend.net.net import Floats, bar_vectors
from codend.solvers.outcome import Solution


@dataclass(frozen=True)
class LayerRows:
    """A layer band by band of the netting below, from where it begins; arrays (bands,)."""

    band: Floats
    """Number of the band."""
    x_m: Floats
    radius_m: Floats
    opening_deg: Floats
    bar_tension_n: Floats
    """Of the layer's real bars."""
    hoop_share: Floats
    """Share of the hoop load of both that the layer carries; 0 where neither is under any."""
    axial_share: Floats
    """Share of the load along the meridian, likewise."""
    hoop_load: Floats
    """Inward pull of both on a sector, N."""


def measure_layers(bag: Bag, problem: Problem, solution: Solution) -> list[LayerRows]:
    """The layers of a bag, in the order of its plan."""
    position, structure = np.ascontiguousarray(solution.positions), problem.structure
    hoop, axial = _loads_below(bag, solution)
    found, start = [], 0
    for bands in bag.layer_bands:
        values = []
        for number in range(start, start + len(bands)):
            law, ring = structure.wrap_law[number], structure.wrap_ring[number]
            t, q, _, _, _ = wrap.diagonals(position, structure, number)
            pull = wrap.stretch_of(law, t, q)
            x, r = position[ring, 0].mean(), np.hypot(position[ring, 1], position[ring, 2]).mean()
            opening = 90.0 if law[wrap.SQUARE] else np.degrees(2.0 * np.arctan2(t, q))
            of_layer = law[wrap.ROUND] * pull.by_t, pull.by_q / law[wrap.ROWS]
            values.append((x, r, opening, pull.tension, *of_layer))
        x, r, opening, tension, own_hoop, own_axial = np.array(values).T
        start += len(bands)
        hoop_share, axial_share = _share(own_hoop, hoop[bands]), _share(own_axial, axial[bands])
        load = own_hoop + hoop[bands]
        found.append(LayerRows(bands.astype(float), x, r, opening, tension, hoop_share, axial_share, load))
    return found


def _share(own: Floats, below: Floats) -> Floats:
    both = own + below
    return np.divide(own, both, out=np.zeros_like(own), where=both > 0.0)


def _loads_below(bag: Bag, solution: Solution) -> tuple[Floats, Floats]:
    """Inward pull of the netting's twine by its hoop tension, and its pull along the meridian, of each band, N."""
    net = bag.net
    vector = bar_vectors(net, solution.positions)
    length = np.linalg.norm(vector, axis=1)
    first = solution.positions[net.bars[:, 0]]
    middle = first[:, 1:] + 0.5 * vector[:, 1:]
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
