"""How far inwards from the entry the netting of a plan reaches: to the strap on a row, and to the codline."""

import math
from collections.abc import Sequence

from codend.plan.tables import Netting


def least_radius_m(netting: Sequence[Netting], entry_radius_m: float, rows_to_codline: int) -> float:
    """Radius to which a row of knots can be drawn in from the entry, whatever pulls, m; 0 where twine or knots stretch.

    From a ring of radius r a flat bar b reaches in to r', the lesser root of  b^2 = r^2 + r'^2 - 2 r r' cos(g),  where
    its ends differ in azimuth by g: by half a mesh pi/N, in T90 netting by as much less as the knots take at either
    end, in square mesh not at all. Knots along the netting reach inwards by their length (derived).

    Where sections differ in their meshes round this is a bound from below, by chains of bars and knots straight from
    the entry, whose ends are off by up to half a mesh for every section.
    """
    if any(part.tapers for part in netting):
        return 0.0  # no bound is known
    counts = [part.open_meshes[0] for part in netting]
    joined = len(set(counts)) > 1
    radius = entry_radius_m
    if joined:
        radius = radius * math.cos(math.pi * len(counts) / min(counts)) - 0.5 * netting[0].knot_m
    rows = sum(part.rows_per_mesh * part.meshes_long for part in netting) - rows_to_codline
    for part in netting:
        across_m, bar_m, knot_m = 0.0 if joined else part.knot_across_m, part.bar_m, part.knot_m
        half_mesh = math.pi / part.open_meshes[0] if part.kind.staggered and not joined else 0.0
        own_rows = min(rows, part.rows_per_mesh * part.meshes_long)
        if own_rows and part.stretches:
            return 0.0
        for _ in range(own_rows):
            if radius <= bar_m + knot_m:
                return 0.0
            # the nearest that the aft ring may come tells the most that its knots take, and so the least turn
            turn = half_mesh
            if across_m > 0.0:
                turn -= math.asin(0.5 * across_m / radius) + math.asin(0.5 * across_m / (radius - bar_m))
            turn = max(turn, 0.0)
            flat_m = math.sqrt(max(bar_m**2 - (radius * math.sin(turn)) ** 2, 0.0))
            radius = radius * math.cos(turn) - flat_m - (knot_m - across_m)
        rows -= own_rows
    return float(radius)
