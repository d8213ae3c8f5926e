"""A quick proof that a bag of equal sectors passes through itself nowhere: it maps one to one to a cone.

Facets that make one tube, open at a rim and closed in a node on the axis, have the rim as the boundary of their sum,
however quadrangles are divided. The coordinates azimuth and x - r ``TILT`` map them to a cylinder. Where every facet's
outward normal leans outward and aft of the upstream side, n_r + ``TILT`` n_x > 0 all over it, each keeps its sense, and
how often they cover a point is how often the rim and the closed end run round it: once between the two. So facets
overlap in no place, and no bar, each a side of facets that cover both its sides once, meets a facet that it is no side
of. r n_r is linear over a facet and r all but so: its corners tell.

The proof fails where netting lies in folds or turns back farther; ``piercing`` searches there.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.pressure import area_vector, corners_of_facet
from codend.net.last_made import LastMade
from codend.net.net import Floats, Ints, Net

Flags = NDArray[np.bool_]
TILT = 1.0 / 3.0
"""Of the cone, radius over length: with ``LEAST`` bags may widen by up to 65 degrees from their entry on, and turn back
by 12 where they are drawn in to the codline, which catches press flat."""
LEAST = 0.1
"""Least sum of a unit normal's part outward and ``TILT`` of its part aft. With it and ``SLIVER`` netting that shares no
knot is apart by tens of times ``piercing.ON_EDGE``."""
SLIVER = 1e-3
"""Twice a facet's area over the square of its longest side, from which it has a width."""


class Tube(NamedTuple):
    """What facets that make one tube are closed in, and where they end."""

    apex: int
    """Node on the axis that closes it, which all sectors share; -1 of facets that make no tube, or something else."""
    rim: Ints
    """Ends of the sides where it ends, each in the sense in which facets run along it, (k, 2)."""
    image: Ints
    """Image of the second end seen from the first, (k,)."""


NO_TUBE = Tube(-1, np.empty((0, 2), dtype=np.int32), np.empty(0, dtype=np.int32))


class _Joints(NamedTuple):
    """What a tube was made of, kept while it is, and the tube."""

    bars: tuple[Ints, Ints]
    facets: tuple[Ints, Ints]
    reach: int
    """Most sectors between two ends of a side."""
    tube: Tube


_made: LastMade[_Joints] = LastMade(40_000)
"""Of so many nodes together, by the arrays themselves: nets of plans that differ in their sizes alone have the same."""


def tube_of(net: Net) -> Tube:
    """The tube that the facets of a sector make with their images, all bars its sides; else ``NO_TUBE``."""
    if len(net.facets) == 0 or net.order < 2 or int(net.order) != net.order:
        return NO_TUBE
    apex = _node_on_axis(net.positions, net.fixed, net.facets)
    if apex < 0:
        return NO_TUBE

    bars, facets, whole = (net.bars, net.bar_image), (net.facets, net.facet_image), net.facet_weight >= 1.0

    def made() -> _Joints:
        is_one, rim, image, reach = _rim(*bars, *facets, whole, len(net.positions), apex)
        return _Joints(bars, facets, reach, Tube(apex, rim, image) if is_one else NO_TUBE)

    found = _made.of((*map(id, (*bars, *facets)), whole.tobytes(), apex), len(net.positions), made)
    # images that are farther apart might be the same
    return found.tube if 2 * found.reach < net.order else NO_TUBE


@njit(cache=True)
def _node_on_axis(position: Floats, fixed: Flags, facets: Ints) -> int:
    """The one corner of facets that is held on the axis, -1 where there is none or more."""
    found = -1
    for facet in range(len(facets)):
        for i in range(3):
            node = facets[facet, i]
            if node != found and fixed[node, 1] and fixed[node, 2] and position[node, 1] == 0.0 == position[node, 2]:
                if found >= 0:
                    return -1
                found = node
    return found


@njit(cache=True)
def _side_of(a: int, b: int, image: int, apex: int) -> tuple[int, int, int, bool]:
    """A side's lower and higher node, the image of this seen from that, and whether that comes first.

    What leads to the apex, or from it, has no image.
    """
    turn = 0 if apex in (a, b) else image
    if a < b or (a == b and turn > 0):
        return a, b, turn, True
    return b, a, -turn, False


@njit(cache=True)
def _rim(
    bars: Ints, bar_image: Ints, facets: Ints, facet_image: Ints, whole: Flags, nodes: int, apex: int
) -> tuple[bool, Ints, Ints, int]:
    """Whether all bars are sides that facets cover once on either side or end at, and the sides where facets end.

    Those are the sides along which facets run once more often one way than the other; all else must run both ways
    alike. The last is the most sectors between two ends of a side.
    """
    count, reach = 3 * len(facets), 0
    newest, before = np.full(nodes, -1), np.empty(count, dtype=np.int64)
    high, turned = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    along = np.zeros((count, 2))
    found, is_one = 0, True
    for part in range(count + len(bars)):
        if part < count:
            facet, i = part // 3, part % 3
            j = (i + 1) % 3
            a, b, image = facets[facet, i], facets[facet, j], facet_image[facet, j] - facet_image[facet, i]
        else:
            a, b, image = bars[part - count, 0], bars[part - count, 1], bar_image[part - count]
        low, other, turn, forward = _side_of(a, b, image, apex)
        is_one &= low != other or turn != 0
        reach = max(reach, abs(turn))
        side = newest[low]
        while side >= 0 and (high[side] != other or turned[side] != turn):
            side = before[side]
        if part >= count:
            is_one &= side >= 0 and _is_covered_once(along[side])
            continue
        if side < 0:
            side, found = found, found + 1
            newest[low], before[side], high[side], turned[side] = side, newest[low], other, turn
        along[side, 0 if forward else 1] += 1.0 if whole[facet] else 0.5
    rim, images, ends = np.empty((found, 2), dtype=np.int32), np.empty(found, dtype=np.int32), 0
    for low in range(nodes):
        side = newest[low]
        while side >= 0:
            over = along[side, 0] - along[side, 1]
            is_one &= over in (-1.0, 0.0, 1.0)
            if over > 0.0:
                rim[ends, 0], rim[ends, 1], images[ends] = low, high[side], turned[side]
            elif over < 0.0:
                rim[ends, 0], rim[ends, 1], images[ends] = high[side], low, -turned[side]
            ends += over != 0.0
            side = before[side]
    return is_one, rim[:ends], images[:ends], reach


@njit(cache=True)
def _is_covered_once(along: Floats) -> bool:
    """Whether facets run once along a side one way, and once or never the other, (2,)."""
    return max(along[0], along[1]) == 1.0 and min(along[0], along[1]) in (0.0, 1.0)


@njit(cache=True, error_model="numpy")
def maps_to_a_cone(
    position: Floats, facets: Ints, images: Ints, rotations: Floats, order: float, apex: int, rim: Ints, image: Ints
) -> bool:
    """Whether a tube maps one to one to the cone, so that nothing passes through anything; see above.

    Args:
        position: nodes, (n, 3).
        facets: corners, (f, 3).
        images: their images, (f, 3).
        rotations: see ``Structure``.
        order: number of equal sectors all round.
        apex: see ``Tube``, as the next two.
        rim: sides where it ends.
        image: of their second ends.
    """
    if position[apex, 1] != 0.0 or position[apex, 2] != 0.0:
        return False
    angle = 0.0
    for side in range(len(rim)):
        ay, az = position[rim[side, 0], 1], position[rim[side, 0], 2]
        y, z = position[rim[side, 1], 1], position[rim[side, 1], 2]
        turn = 2.0 * math.pi * image[side] / order
        by, bz = math.cos(turn) * y - math.sin(turn) * z, math.sin(turn) * y + math.cos(turn) * z
        onward = math.atan2(ay * bz - az * by, ay * by + az * bz)
        if not onward * angle >= 0.0 or onward == 0.0:
            return False
        angle += onward
    # it closes after whole sectors, and must after one
    if not 0.0 < abs(angle) * order < 3.0 * math.pi:
        return False
    for facet in range(len(facets)):
        corners = corners_of_facet(position, facets, images, rotations, facet)
        if not _leans_outward(corners, (facets[facet, 0] == apex, facets[facet, 1] == apex, facets[facet, 2] == apex)):
            return False
    return True


@njit(cache=True, error_model="numpy")
def _leans_outward(corners: tuple[float, ...], closing: tuple[bool, bool, bool]) -> bool:
    """Whether a facet has a width and faces out of the cone all over, but at the node that closes the tube."""
    ax, ay, az, bx, by, bz, cx, cy, cz = corners
    nx, ny, nz = area_vector(corners)
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    longest = max(
        (bx - ax) ** 2 + (by - ay) ** 2 + (bz - az) ** 2,
        (cx - bx) ** 2 + (cy - by) ** 2 + (cz - bz) ** 2,
        (ax - cx) ** 2 + (ay - cy) ** 2 + (az - cz) ** 2,
    )
    if not 2.0 * size > SLIVER * longest:
        return False
    # of radii, which are convex: a linear bound from below, or from above by the corners' own where that counts less
    my, mz = ay + by + cy, az + bz + cz
    middle = math.sqrt(my * my + mz * mz)
    for i in range(3):
        if closing[i]:
            continue
        y, z = corners[3 * i + 1], corners[3 * i + 2]
        radius = math.sqrt(y * y + z * z)
        within = (y * my + z * mz) / middle if nx > 0.0 else radius
        if not ny * y + nz * z + TILT * nx * within > LEAST * size * radius:
            return False
    return True
