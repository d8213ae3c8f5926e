"""Rings of knots that cross themselves: polygons of the rows of a net, seen along their own axes.

A ring that runs once round its middle, every knot further round than the one before, is sound at a glance. Of the
others every two sides are held to each other. Rings of a sector one mesh wide are the same all round and sound.
"""

import math
from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.net.net import Floats, Ints


class Rings(NamedTuple):
    """Knots of every ring in their order round the axis, those of one sector."""

    start: Ints
    """Where each ring begins in the list, (rows + 1,)."""
    node: Ints
    image: Ints
    """Image in which the node takes its place in the ring."""


@njit(cache=True)
def rings_of(built: Floats, node_row: Ints, order: float) -> Rings:
    """Rings of a net by the azimuths of its knots as it was built, (n, 3), and their rows, -1 between rings, (n,)."""
    start = np.zeros(max(node_row.max(), -1) + 2, dtype=np.int64)
    for row in node_row:
        if row >= 0:
            start[row + 1] += 1
    start = np.cumsum(start)
    node, image, ahead = np.empty(start[-1], dtype=np.int64), np.empty(start[-1], dtype=np.int64), np.empty(start[-1])
    filled, first, sector = start[:-1].copy(), np.empty(len(start) - 1), 2.0 * math.pi / order
    for knot, row in enumerate(node_row):
        if row < 0:
            continue
        azimuth = math.atan2(built[knot, 2], built[knot, 1])
        if filled[row] == start[row]:
            first[row] = azimuth
        # counted from the ring's first knot, each in the image that puts it less than a sector on
        on = azimuth - first[row]
        turned = -math.floor(on / sector + 1e-9)
        on += turned * sector
        place = filled[row]
        while place > start[row] and ahead[place - 1] > on:
            node[place], image[place], ahead[place] = node[place - 1], image[place - 1], ahead[place - 1]
            place -= 1
        node[place], image[place], ahead[place] = knot, int(turned), on
        filled[row] += 1
    return Rings(start, node, image)


@njit(cache=True)
def turn_as_built(position: Floats, rings: Rings, row: int, order: float) -> tuple[float, float]:
    """Mean radius of a ring, m, and its turn about the axis from knots spread evenly in their order, rad.

    Rings whose meshes are shifted by a part of one are turned by it; a ring of two knots or less has no radius.
    """
    first, width = rings.start[row], rings.start[row + 1] - rings.start[row]
    count = width * order
    if count <= 2.0:
        return 0.0, 0.0
    middle_y, middle_z = 0.0, 0.0
    if order == 1.0:
        for i in range(width):
            middle_y += position[rings.node[first + i], 1] / width
            middle_z += position[rings.node[first + i], 2] / width
    radius, along, across = 0.0, 0.0, 0.0
    for i in range(width):
        node = rings.node[first + i]
        y, z = position[node, 1] - middle_y, position[node, 2] - middle_z
        angle = 2.0 * math.pi * (rings.image[first + i] / order - i / count)
        radius += math.hypot(y, z) / width
        along += y * math.cos(angle) - z * math.sin(angle)
        across += y * math.sin(angle) + z * math.cos(angle)
    return radius, math.atan2(across, along)


@njit(cache=True)
def first_crossed_ring(
    position: Floats, start: Ints, node: Ints, image: Ints, order: float, touching: float
) -> tuple[int, int]:
    """The first row whose ring crosses itself, and how often it runs round its middle; -1, 0 where none does.

    Args:
        position: nodes, (n, 3).
        start: see ``Rings``, as the next two.
        node: list of knots.
        image: their images.
        order: number of equal sectors all round.
        touching: distance of a side's ends from another side up to which they touch, m.
    """
    sectors = int(order)
    for row in range(len(start) - 1):
        width = start[row + 1] - start[row]
        count = width * sectors
        if count < 4:
            continue
        ring = np.empty((count, 3))
        for i in range(count):
            place = start[row] + i % width
            angle = 2.0 * math.pi * (image[place] + i // width) / order
            x, y, z = position[node[place], 0], position[node[place], 1], position[node[place], 2]
            cosine, sine = math.cos(angle), math.sin(angle)
            ring[i, 0], ring[i, 1], ring[i, 2] = x, cosine * y - sine * z, sine * y + cosine * z
        flat = seen_along_its_axis(ring)
        turns, onward = round_its_middle(flat)
        if onward and turns == 1:
            continue
        # the sides of one sector against all
        for i in range(width):
            for j in range(count):
                if j in (i, (i + 1) % count, (i - 1) % count):
                    continue
                if sides_cross(flat[i], flat[(i + 1) % count], flat[j], flat[(j + 1) % count], touching):
                    return row, turns
    return -1, 0


@njit(cache=True)
def seen_along_its_axis(ring: Floats) -> Floats:
    """A ring of points (m, 3) from its middle, in two coordinates across its area vector, (m, 2)."""
    count = len(ring)
    middle, area = np.zeros(3), np.zeros(3)
    for i in range(count):
        middle += ring[i] / count
    for i in range(count):
        a, b = ring[i] - middle, ring[(i + 1) % count] - middle
        area[0] += a[1] * b[2] - a[2] * b[1]
        area[1] += a[2] * b[0] - a[0] * b[2]
        area[2] += a[0] * b[1] - a[1] * b[0]
    size = math.sqrt(area[0] ** 2 + area[1] ** 2 + area[2] ** 2)
    nx, ny, nz = (area[0] / size, area[1] / size, area[2] / size) if size > 0.0 else (1.0, 0.0, 0.0)
    # two vectors across the axis: y and z turned with it
    if abs(nx) > 0.1:
        ux, uy, uz = -ny, nx, 0.0
    else:
        ux, uy, uz = 0.0, -nz, ny
    size = math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / size, uy / size, uz / size
    vx, vy, vz = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
    flat = np.empty((count, 2))
    for i in range(count):
        x, y, z = ring[i, 0] - middle[0], ring[i, 1] - middle[1], ring[i, 2] - middle[2]
        flat[i, 0], flat[i, 1] = x * ux + y * uy + z * uz, x * vx + y * vy + z * vz
    return flat


@njit(cache=True)
def round_its_middle(flat: Floats) -> tuple[int, bool]:
    """How often a polygon (m, 2) runs round the origin, and whether it never turns back."""
    count, turns, onward = len(flat), 0, True
    for i in range(count):
        ay, az, by, bz = flat[i, 0], flat[i, 1], flat[(i + 1) % count, 0], flat[(i + 1) % count, 1]
        side = ay * bz - az * by
        onward = onward and side > 0.0
        if az < 0.0 <= bz and side > 0.0:
            turns += 1
        elif bz < 0.0 <= az and side < 0.0:
            turns -= 1
    return turns, onward


@njit(cache=True)
def sides_cross(a: Floats, b: Floats, c: Floats, d: Floats, touching: float) -> bool:
    """Whether the sides from a to b and from c to d cross, with no end nearer to the other side than ``touching``."""
    uy, uz, vy, vz = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    u, v = math.hypot(uy, uz), math.hypot(vy, vz)
    if u <= touching or v <= touching:
        return False
    c_off, d_off = (uy * (c[1] - a[1]) - uz * (c[0] - a[0])) / u, (uy * (d[1] - a[1]) - uz * (d[0] - a[0])) / u
    a_off, b_off = (vy * (a[1] - c[1]) - vz * (a[0] - c[0])) / v, (vy * (b[1] - c[1]) - vz * (b[0] - c[0])) / v
    if c_off * d_off >= 0.0 or a_off * b_off >= 0.0:
        return False
    return min(abs(a_off), abs(b_off), abs(c_off), abs(d_off)) > touching
