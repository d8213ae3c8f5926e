"""Sectors of joined or tapering sections whose counts of meshes share little: narrow ones, of nearly the same ratio.

172 meshes laced to 54 make a sector 86 and 27 meshes wide. One of 16 and 5 is laced in nearly the same ratio, and as
one of 10.8 sectors, which need not be a whole number, it stands for 172 and 53.8 meshes round: twine and rows are as
they are, loads of a sector count 10.8 times, and its images are turned by a 10.8th of the whole way round.

Two panels that taper from 148 meshes to 88 make a sector of half the net. One that tapers from 10 to 6, with a seam of
its own, is one of 14.7: it loses its meshes in coarser steps, along more seams, and shares the ropes among them.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from codend.plan.plan import Plan

NEARER = 1e-6
"""Share by which a wider sector must be nearer: multiples of a ratio differ by round-off."""
WORTH_KNOTS = 1000
"""Knots of a wide sector from which a narrow one takes its place: from there some end unsolved, after a minute."""
SLOW_KNOTS, SLOW_MESHES = 3000, 10
"""Knots of a model, and meshes round it, from which a case takes seconds or more: full nets of joined sections took 2 s
with 3 800 knots and 23 s with 15 000. Narrow sectors, however long, take milliseconds."""
NARROW_MESHES = 12
"""Width of a sector that takes a second at most, whether it is solved or not."""
ROUGHLY = 0.17
"""Mismatch up to which one tells what a plan is about like: it loses a mesh of three."""
DRAG_BY_MISMATCH = 2.1
"""Relative error in drag by the largest mismatch: the drag goes as the square of a radius, and that as the meshes round
(``python -m validation.joined_counts``); what estimates tell at the least (``equilibrium.accuracy.BY_MISMATCH``)."""


@dataclass(frozen=True)
class NearRatio:
    """A narrow sector in place of a wide one."""

    columns: tuple[int, ...]
    """Meshes of every section that it is wide, at its fore end; after them those at the aft end of all that taper."""
    order: float
    """Such sectors all round."""
    mismatch: tuple[float, ...]
    """Meshes round that it stands for, over the plan's, less 1, in the same order."""
    step: float = 0.0
    """Half of what it loses at once where it tapers, over its width there: how far it is off between the ends."""

    @property
    def largest(self) -> float:
        """Largest mismatch of a section, between its ends too."""
        return max(self.step, self.off)

    @property
    def off(self) -> float:
        """Largest mismatch of a section's ends, whose errors go with it."""
        return max(map(abs, self.mismatch))

    def ends(self, plan: Plan) -> Iterator[tuple[int, int]]:
        """Meshes that it is wide at the fore and the aft end of every section."""
        aft = iter(self.columns[len(plan.netting) :])
        for fore, part in zip(self.columns, plan.netting, strict=False):
            yield fore, next(aft) if part.tapers else fore


def near_ratios(plan: Plan) -> Iterator[NearRatio]:
    """Sectors ever wider, each nearer to the plan's counts than those before, up to the exact one.

    The number of sectors is the one that meets the counts best, sections weighed by the area of their netting: what a
    few rows at an end are off by matters little.
    """
    tapering = [part for part in plan.netting if part.tapers]
    counts = np.array([part.open_meshes[0] for part in plan.netting] + [part.open_meshes[1] for part in tapering])
    area = counts * [part.meshes_long * part.full_mesh_m**2 for part in (*plan.netting, *tapering)]
    # wider ones of the same ratio are nearer where they taper in finer steps
    exact = 1 if tapering else int(np.gcd.reduce(counts))
    least, nearest = int(np.argmin(counts)), np.inf
    for width in range(1, int(counts[least]) // exact + 1):
        columns = np.maximum(np.rint(counts * (width / counts[least])), 1).astype(int)
        share = columns / counts
        # least squares of the mismatches order x share - 1
        order = float((area * share).sum() / (area * share**2).sum())
        mismatch = order * share - 1.0
        step = 0.5 / int(columns.min()) if tapering else 0.0
        near = NearRatio(tuple(columns.tolist()), order, tuple(mismatch.tolist()), step)
        if near.largest < (1.0 - NEARER) * nearest:
            nearest = near.largest
            yield near


def near_enough(plan: Plan) -> NearRatio | None:
    """The narrowest sector that is near enough for the accuracy in drag that the plan asks for.

    None where the exact sector is narrow itself, no narrower one is near enough, or ropes have their places in it.
    """
    widest = max(part.open_meshes[0] for part in plan.netting) // math.gcd(
        *(part.open_meshes[0] for part in plan.netting)
    )
    seamed = plan.ropes or plan.window or plan.tapers
    if seamed or widest < SLOW_MESHES or len(plan.sections_of_bands()) * widest < WORTH_KNOTS:
        return None
    allowed = plan.model.accuracy / DRAG_BY_MISMATCH
    return next(
        (near for near in near_ratios(plan) if near.largest <= allowed and 2 * max(near.columns) <= widest), None
    )


def narrower(plan: Plan, near: NearRatio) -> NearRatio | None:
    """The next narrower sector, by whose answers those of one may be judged; None where there is none."""
    before = [other for other in near_ratios(plan) if max(other.columns) < max(near.columns)]
    return before[-1] if before else None


def stand_ins(plan: Plan) -> list[NearRatio]:
    """Narrow sectors that may stand for a wide one in which no equilibrium is found, the nearest to its counts first.

    None where the exact sector is narrow itself, or has what they have no place for.
    """
    counts = [part.open_meshes[0] for part in plan.netting]
    widest = max(counts) // math.gcd(*counts)
    plain = not (plan.seamed or plan.ropes or plan.window or plan.tapers or plan.layer)
    if not plain or widest < SLOW_MESHES or len(plan.sections_of_bands()) * widest < WORTH_KNOTS:
        return []
    return [near for near in near_ratios(plan) if max(near.columns) <= min(NARROW_MESHES, widest // 2)][::-1]


def quick_looks(plan: Plan) -> list[NearRatio]:
    """Narrow sectors that tell in a second what a plan that tapers is like, the nearest to its counts first.

    Along few seams a section tapers in sectors of half the net. None where those are narrow themselves.
    """
    widest = max(max(part.open_meshes) for part in plan.netting)
    if not plan.tapers or widest < SLOW_MESHES or len(plan.sections_of_bands()) * widest < WORTH_KNOTS:
        return []
    narrow = [near for near in near_ratios(plan) if 2 * max(near.columns) <= widest]
    found = [near for near in narrow if near.largest <= ROUGHLY and max(near.columns) <= NARROW_MESHES]
    return sorted(found, key=lambda near: near.off)


def smeared_sectors(plan: Plan) -> list[NearRatio | None]:
    """Sectors over which ropes can be smeared: one mesh wide, and where netting tapers those of ``quick_looks``."""
    return [*quick_looks(plan)] if plan.tapers else [None]
