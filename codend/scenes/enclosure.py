"""What sheets of netting enclose: their facets turned the same way, and the volume within.

Sheets sewn together are turned so that the sides of their facets run against each other where they meet, and the whole
so that its volume as built is above 0: facets then face outward. What is left open is closed by a fan of triangles from
the middle of each opening, which of an opening in a plane is that plane.
"""

from collections import defaultdict, deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats

Ints = NDArray[np.integer]
Sides = dict[tuple[int, int], float]
"""How often facets run along a side from its lower to its higher node, less how often the other way."""
NOTHING = 1e-6
"""Of a whole side, what is round-off."""


def facing_alike(facets: Sequence[Ints], weights: Sequence[Floats], positions: Floats) -> list[Ints]:
    """Facets of every sheet, (f, 3) each, turned as one surface faces outward.

    Sheets that cannot all be turned so, as on a Moebius band, or where three meet along a seam, are left as they are
    against those turned first.

    Args:
        facets: of every sheet, nodes that are one with the same number.
        weights: of these, (f,) each.
        positions: of the nodes as built, (n, 3).
    """
    own = [_border(f, w) for f, w in zip(facets, weights, strict=True)]
    meets: dict[tuple[int, int], list[int]] = defaultdict(list)
    for number, border in enumerate(own):
        for side in border:
            meets[side].append(number)
    sense = np.zeros(len(facets))
    for first in range(len(facets)):
        if sense[first] != 0.0:
            continue
        sense[first], group, waiting = 1.0, [first], deque([first])
        while waiting:
            here = waiting.popleft()
            together: dict[int, float] = defaultdict(float)
            for side, runs in own[here].items():
                for other in meets[side]:
                    if other != here:
                        together[other] += runs * own[other][side]
            for other, product in together.items():
                if sense[other] == 0.0 and product != 0.0:
                    sense[other] = -np.sign(product) * sense[here]
                    group.append(other)
                    waiting.append(other)
        turned = [_turned(facets[k], sense[k] < 0.0) for k in group]
        if enclosed_m3(np.concatenate(turned), np.concatenate([weights[k] for k in group]), positions) < 0.0:
            sense[group] *= -1.0
    return [_turned(f, sense[k] < 0.0) for k, f in enumerate(facets)]


def openings(facets: Ints, weights: Floats) -> list[NDArray[np.int64]]:
    """Nodes round every opening of a surface, in the order in which facets run along it; none where it is ragged."""
    follows: dict[int, int] = {}
    for (low, high), runs in _border(facets, weights).items():
        start, end = (low, high) if runs > 0.0 else (high, low)
        if abs(abs(runs) - 1.0) > NOTHING or start in follows:
            return []
        follows[start] = end
    found = []
    while follows:
        first, here = next(iter(follows.items()))
        del follows[first]
        loop = [first]
        while here != first:
            if here not in follows:
                return []
            loop.append(here)
            here = follows.pop(here)
        found.append(np.array(loop, dtype=np.int64))
    return found


def enclosed_m3(facets: Ints, weights: Floats, positions: Floats) -> float:
    """Volume between a surface and the fans that close its openings, m3; below 0 where its facets face inward."""
    middle = positions[facets].mean(axis=(0, 1)) if len(facets) else np.zeros(3)
    a, b, c = (positions[facets] - middle).transpose(1, 0, 2)
    volume = float(weights @ np.einsum("ij,ij->i", np.cross(a, b), c)) / 6.0
    for loop in openings(facets, weights):
        rim = positions[loop] - middle
        volume -= (
            float(np.linalg.det(np.stack([rim, np.roll(rim, -1, axis=0), 0.0 * rim + rim.mean(axis=0)], 1)).sum()) / 6.0
        )
    return volume


def _turned(facets: Ints, over: bool) -> Ints:
    return facets[:, [0, 2, 1]] if over else facets


def _border(facets: Ints, weights: Floats) -> Sides:
    """Sides along which facets do not run both ways alike."""
    start, end = facets.ravel(), np.roll(facets, -1, axis=1).ravel()
    low, high = np.minimum(start, end).astype(np.int64), np.maximum(start, end).astype(np.int64)
    size = int(high.max(initial=0)) + 1
    keys, place = np.unique(low * size + high, return_inverse=True)
    runs = np.bincount(place.ravel(), np.where(start < end, 1.0, -1.0) * np.repeat(weights, 3), minlength=len(keys))
    kept = (np.abs(runs) > NOTHING) & (keys // size != keys % size)
    return {(int(key // size), int(key % size)): float(run) for key, run in zip(keys[kept], runs[kept], strict=True)}
