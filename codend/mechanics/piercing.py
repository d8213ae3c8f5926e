"""Bars that pierce the netting: where a net has passed through itself, in sectors with their images and in full nets.

Netting is seen as its facets. A quadrangle that is covered by both of its divisions into triangles, each at half
weight, is pierced when a bar pierces one triangle of either: a bar that ends in the space between the two divisions
touches it. Bars that share a node with a facet do not pierce it, and an end that lies nearer to the facet's plane than
a tolerance touches it: netting folded flat lies on itself and does not pass through.

Facets are sorted into the cells of a grid by the middles of their boxes, in (x, r) for a sector, whose images are told
apart by their azimuths, and in (x, y, z) for a full net.
"""

import math

import numpy as np

from codend.compiled import njit
from codend.net.net import Floats, Ints

TOUCHING = 1e-3
"""How far both ends of a bar must lie from a facet's plane to pierce it, over the shortest bar."""
ON_EDGE = 1e-9
"""Share by which facets are widened: nets with a plane of symmetry are pierced at the edges of facets, if at all."""
CELLS = 8
"""Most cells of the grid, over the number of facets."""


@njit(cache=True)
def at_image(position: Floats, node: int, image: int, order: float) -> tuple[float, float, float]:
    """A node turned about the x axis by ``image`` sectors."""
    x, y, z = position[node, 0], position[node, 1], position[node, 2]
    if image == 0:
        return x, y, z
    cosine, sine = math.cos(2.0 * math.pi * image / order), math.sin(2.0 * math.pi * image / order)
    return x, cosine * y - sine * z, sine * y + cosine * z


@njit(cache=True)
def wrapped(angle: float) -> float:
    """The angle between -pi and pi that differs from this one by whole turns."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@njit(cache=True)
def nearest_to_axis(ay: float, az: float, by: float, bz: float) -> float:
    """Least distance from the axis of a straight line between two points, seen along the axis."""
    y, z = by - ay, bz - az
    square = y * y + z * z
    along = min(max(-(ay * y + az * z) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(ay + along * y, az + along * z)


@njit(cache=True)
def around_axis(points: Floats, count: int, on_axis: float) -> tuple[float, float]:
    """Middle and half width of the azimuths of a bar or a facet, by its corners (count, 3); pi where it spans the axis.

    Corners on the axis have none: what lies between the others counts.
    """
    base, low, high, seen, winding, last = 0.0, 0.0, 0.0, 0, 0.0, 0.0
    for i in range(count):
        y, z = points[i, 1], points[i, 2]
        if math.hypot(y, z) <= on_axis:
            continue
        azimuth = math.atan2(z, y)
        if seen == 0:
            base = azimuth
        else:
            winding += wrapped(azimuth - last)
        away = wrapped(azimuth - base)
        low, high, last = min(low, away), max(high, away), azimuth
        seen += 1
    winding += wrapped(base - last)
    if abs(winding) > 1.0 or high - low > math.pi:
        return 0.0, math.pi
    return base + 0.5 * (low + high), 0.5 * (high - low)


@njit(cache=True)
def write_box(points: Floats, count: int, sector: bool, box: Floats) -> None:
    """Write the least and the largest coordinates of a bar or a facet, (6,): (x, y, z), or (x, r, 0) in a sector."""
    for i in range(3):
        box[i], box[3 + i] = points[0, i], points[0, i]
        for j in range(1, count):
            box[i], box[3 + i] = min(box[i], points[j, i]), max(box[3 + i], points[j, i])
    if not sector:
        return
    least, most = np.inf, 0.0
    inside = 0
    for j in range(count):
        k = (j + 1) % count
        ay, az, by, bz = points[j, 1], points[j, 2], points[k, 1], points[k, 2]
        least, most = min(least, nearest_to_axis(ay, az, by, bz)), max(most, math.hypot(ay, az))
        inside += 1 if ay * bz - az * by > 0.0 else -1
    if count == 3 and abs(inside) == 3:
        least = 0.0
    box[1], box[4], box[2], box[5] = least, most, 0.0, 0.0


@njit(cache=True)
def pierces(bar: Floats, facet: Floats, touching: float) -> bool:
    """Whether a bar (2, 3) passes through a facet (3, 3), both its ends further than ``touching`` from its plane."""
    ux, uy, uz = facet[1, 0] - facet[0, 0], facet[1, 1] - facet[0, 1], facet[1, 2] - facet[0, 2]
    vx, vy, vz = facet[2, 0] - facet[0, 0], facet[2, 1] - facet[0, 1], facet[2, 2] - facet[0, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    # a facet thinner than the tolerance has no plane
    if size <= touching * math.sqrt(max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz)):
        return False
    px, py, pz = bar[0, 0] - facet[0, 0], bar[0, 1] - facet[0, 1], bar[0, 2] - facet[0, 2]
    qx, qy, qz = bar[1, 0] - facet[0, 0], bar[1, 1] - facet[0, 1], bar[1, 2] - facet[0, 2]
    first, second = (px * nx + py * ny + pz * nz) / size, (qx * nx + qy * ny + qz * nz) / size
    if first * second >= 0.0 or min(abs(first), abs(second)) <= touching:
        return False
    along = first / (first - second)
    x, y, z = px + along * (qx - px), py + along * (qy - py), pz + along * (qz - pz)
    wx, wy, wz = nx / (size * size), ny / (size * size), nz / (size * size)
    b = (y * vz - z * vy) * wx + (z * vx - x * vz) * wy + (x * vy - y * vx) * wz
    c = (uy * z - uz * y) * wx + (uz * x - ux * z) * wy + (ux * y - uy * x) * wz
    return b >= -ON_EDGE and c >= -ON_EDGE and b + c <= 1.0 + ON_EDGE


@njit(cache=True)
def first_pierced(
    position: Floats,
    first: Ints,
    second: Ints,
    image: Ints,
    facets: Ints,
    facet_image: Ints,
    facet_weight: Floats,
    order: float,
    touching: float,
) -> tuple[int, int]:
    """The first bar that pierces the netting, and a facet it pierces; -1, -1 where none does.

    Args:
        position: nodes, (n, 3).
        first: first end of the bars, (m,).
        second: second end, (m,).
        image: image of the second end, (m,).
        facets: corners, (f, 3).
        facet_image: their images, (f, 3).
        facet_weight: below 1 where a quadrangle is covered twice, (f,).
        order: number of equal sectors all round.
        touching: distance of an end from a facet's plane up to which it touches, m.
    """
    sector, count = order > 1.0, len(facets)
    corners, points = np.empty((3, 3)), np.empty((2, 3))
    boxes, spans = np.empty((count, 6)), np.empty((count, 2))
    for facet in range(count):
        for i in range(3):
            corners[i] = at_image(position, facets[facet, i], facet_image[facet, i], order)
        write_box(corners, 3, sector, boxes[facet])
        if sector:
            spans[facet] = around_axis(corners, 3, 1e-3 * touching)
    start, contents, low, size, shape, reach = sorted_into_cells(boxes, order)
    box, span = np.empty(6), np.zeros(2)
    cell_low, cell_high = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    step = 2.0 * math.pi / order
    for bar in range(len(first)):
        points[0] = at_image(position, first[bar], 0, order)
        points[1] = at_image(position, second[bar], image[bar], order)
        write_box(points, 2, sector, box)
        if sector:
            span[:] = around_axis(points, 2, 1e-3 * touching)
        for i in range(3):
            cell_low[i] = max(int(math.floor((box[i] - reach[i] - low[i]) / size)), 0)
            cell_high[i] = min(int(math.floor((box[3 + i] + reach[i] - low[i]) / size)), shape[i] - 1)
        pierced = 0.0
        for i in range(cell_low[0], cell_high[0] + 1):
            for j in range(cell_low[1], cell_high[1] + 1):
                row = (i * shape[1] + j) * shape[2]
                # cells that follow one another along the last coordinate are one stretch of the list
                for place in range(start[row + cell_low[2]], start[row + cell_high[2] + 1]):
                    facet = contents[place]
                    apart = False
                    for k in range(3):
                        apart = apart or box[k] > boxes[facet, 3 + k] or box[3 + k] < boxes[facet, k]
                    if apart:
                        continue
                    least, most = 0, 0
                    if sector:
                        wide = span[1] + spans[facet, 1] + ON_EDGE
                        least = math.ceil((span[0] - spans[facet, 0] - wide) / step)
                        most = min(math.floor((span[0] - spans[facet, 0] + wide) / step), least + int(order) - 1)
                    for turn in range(least, most + 1):
                        shared = False
                        for k in range(3):
                            node, turned = facets[facet, k], facet_image[facet, k] + turn
                            corners[k] = at_image(position, node, turned, order)
                            for end in range(2):
                                if node == (second[bar] if end else first[bar]):
                                    between = turned - (image[bar] if end else 0)
                                    axial = math.hypot(position[node, 1], position[node, 2]) <= touching
                                    shared = shared or axial or between % int(order) == 0
                        if not shared and pierces(points, corners, touching):
                            pierced += 1.0 if facet_weight[facet] >= 1.0 else 0.5
                            if pierced >= 1.0:
                                return bar, facet
    return -1, -1


@njit(cache=True)
def sorted_into_cells(
    boxes: Floats, order: float
) -> tuple[Ints, Ints, Floats, float, Ints, Floats]:
    """Sort facets into the cells of a grid by the middles of their boxes.

    Returns:
        where the facets of each cell begin in the list, the list, the grid's lowest corner, the size of its cells, how
        many it has along each coordinate, and half the largest extent of a box along each.
    """
    count = len(boxes)
    low, high, reach = np.full(3, np.inf), np.full(3, -np.inf), np.zeros(3)
    extent = 0.0
    for facet in range(count):
        widest = 0.0
        for i in range(3):
            middle, wide = 0.5 * (boxes[facet, i] + boxes[facet, 3 + i]), boxes[facet, 3 + i] - boxes[facet, i]
            low[i], high[i] = min(low[i], middle), max(high[i], middle)
            reach[i], widest = max(reach[i], 0.5 * wide), max(widest, wide)
        extent += widest / count
    size = max(extent, 1e-300)
    shape = np.empty(3, dtype=np.int64)
    while True:
        for i in range(3):
            shape[i] = int((high[i] - low[i]) / size) + 1
        if shape[0] * shape[1] * shape[2] <= CELLS * count + 8:
            break
        size *= 1.25
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, dtype=np.int64)
    cell = np.empty(count, dtype=np.int64)
    for facet in range(count):
        index = 0
        for i in range(3):
            middle = 0.5 * (boxes[facet, i] + boxes[facet, 3 + i])
            index = index * shape[i] + min(int((middle - low[i]) / size), shape[i] - 1)
        cell[facet] = index
        start[index + 1] += 1
    for index in range(len(start) - 1):
        start[index + 1] += start[index]
    contents = np.empty(count, dtype=np.int64)
    free = start[:-1].copy()
    for facet in range(count):
        contents[free[cell[facet]]] = facet
        free[cell[facet]] += 1
    return start, contents, low, size, shape, reach
