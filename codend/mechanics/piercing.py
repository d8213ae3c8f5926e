"""Bars that pierce the netting: where a net has passed through itself, in sectors with their images and in full nets.

Netting is seen as its facets. A quadrangle that is covered by both of its divisions into triangles, each at half
weight, is pierced when a bar pierces one triangle of either: a bar that ends in the space between the two divisions
touches it. A bar pierces a facet if it meets it and both its ends are further from the facet's plane than a tolerance:
bars that share a node with a facet do not, nor does netting that is folded flat and lies on itself.

Facets are sorted into the cells of a grid by the middles of their boxes: in (z, y, x) for a full net, along x alone for
a sector, each as the image of it that is nearest to the azimuth 0. Bars are held against all planes of a stretch of the
list at a time, as their images about that azimuth: few have their ends on either side of one and not at it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.cells import cells_in
from codend.net.net import Floats, Ints

Counts = NDArray[np.int64]

TOUCHING = 1e-3
"""How far both ends of a bar must lie from a facet's plane to pierce it, over the shortest bar."""
ON_EDGE = 1e-9
"""Share by which facets are widened: nets with a plane of symmetry are pierced at the edges of facets, if at all."""
CELLS = 8
"""Most cells of the grid, over the number of facets."""

DEEPEST = 0.1
"""Of the shortest bar; see ``touching_m``."""


@njit(cache=True)
def touching_m(length: Floats, thickness: Floats) -> float:
    """Depth up to which netting touches itself and does not pass through, m, by its bars, (m,) both.

    Twine has a thickness: netting whose middle lines are on the wrong side of each other by less than that is pressed
    together, which is no part of the model, and not through. That counts up to ``DEEPEST`` of the shortest bar.
    """
    shortest = length.min()
    return max(TOUCHING * shortest, min(np.median(thickness), DEEPEST * shortest))


@njit(cache=True, error_model="numpy")
def write_point(position: Floats, node: int, image: int, cosines: Floats, sines: Floats, point: Floats) -> None:
    """Write a node turned about the x axis by ``image`` sectors, (3,)."""
    y, z = position[node, 1], position[node, 2]
    turn = image + len(cosines) if image < 0 else image
    if turn < 0 or turn >= len(cosines):
        turn = image % len(cosines)
    cosine, sine = cosines[turn], sines[turn]
    point[0], point[1], point[2] = position[node, 0], cosine * y - sine * z, sine * y + cosine * z


@njit(cache=True, error_model="numpy")
def wrapped(angle: float) -> float:
    """The angle between -pi and pi that differs from this one by whole turns."""
    return angle if abs(angle) <= math.pi else angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@njit(cache=True, error_model="numpy")
def around_axis(azimuths: Floats, radii: Floats, count: int, on_axis: float) -> tuple[float, float]:
    """Middle and half width of the azimuths of a bar or a facet, by its corners (count,); pi where it spans the axis.

    Corners on the axis have none: what lies between the others counts.
    """
    base, low, high, seen, winding, last = 0.0, 0.0, 0.0, 0, 0.0, 0.0
    for i in range(count):
        if radii[i] <= on_axis:
            continue
        azimuth = azimuths[i]
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


@njit(cache=True, error_model="numpy")
def write_plane(corners: Floats, touching: float, plane: Floats) -> None:
    """Write the unit normal of a facet (3, 3) and its distance from the origin, (4,).

    A facet thinner than the tolerance has no plane: its normal is 0, and nothing pierces it.
    """
    ux, uy, uz = corners[1, 0] - corners[0, 0], corners[1, 1] - corners[0, 1], corners[1, 2] - corners[0, 2]
    vx, vy, vz = corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1], corners[2, 2] - corners[0, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    plane[:] = 0.0
    if size > touching * math.sqrt(max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz)):
        plane[0], plane[1], plane[2] = nx / size, ny / size, nz / size
        plane[3] = plane[0] * corners[0, 0] + plane[1] * corners[0, 1] + plane[2] * corners[0, 2]


@njit(cache=True, error_model="numpy")
def meets(corners: Floats, plane: Floats, x: float, y: float, z: float) -> bool:
    """Whether a point in the plane of a facet (3, 3) lies in it: on the inner side of all its edges."""
    for i in range(3):
        j = (i + 1) % 3
        ux, uy, uz = corners[j, 0] - corners[i, 0], corners[j, 1] - corners[i, 1], corners[j, 2] - corners[i, 2]
        px, py, pz = x - corners[i, 0], y - corners[i, 1], z - corners[i, 2]
        inside = plane[0] * (uy * pz - uz * py) + plane[1] * (uz * px - ux * pz) + plane[2] * (ux * py - uy * px)
        if inside < -ON_EDGE * (ux * ux + uy * uy + uz * uz):
            return False
    return True


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def crossed(planes: Floats, begin: int, end: int, bar: Floats, touching: float) -> int:
    """How many of some planes, (4, f), have the ends of a bar, (2, 3), on either side, both beyond a tolerance."""
    nx, ny, nz = planes[0, begin:end], planes[1, begin:end], planes[2, begin:end]
    distance, count = planes[3, begin:end], 0
    px, py, pz, qx, qy, qz = bar[0, 0], bar[0, 1], bar[0, 2], bar[1, 0], bar[1, 1], bar[1, 2]
    for i in range(end - begin):
        p = nx[i] * px + ny[i] * py + nz[i] * pz - distance[i]
        q = nx[i] * qx + ny[i] * qy + nz[i] * qz - distance[i]
        # an end that is one of the facet's corners lies in its plane
        count += (p * q < 0.0) & (min(abs(p), abs(q)) > touching)
    return count


@njit(cache=True, error_model="numpy")
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
    count, sectors, sector = len(facets), int(order), order > 1.0
    if count == 0:
        return -1, -1
    angle = 2.0 * math.pi / order
    cosines, sines = np.empty(sectors), np.empty(sectors)
    for turn in range(sectors):
        # each the nearer way round: with a fraction of a sector to spare the two ways differ
        nearer = turn if 2 * turn <= sectors else turn - sectors
        cosines[turn], sines[turn] = math.cos(angle * nearer), math.sin(angle * nearer)
    azimuth, radius = np.zeros(len(position)), np.zeros(len(position))
    if sector:
        for node in range(len(position)):
            y, z = position[node, 1], position[node, 2]
            azimuth[node], radius[node] = math.atan2(z, y), math.sqrt(y * y + z * z)
    corners, boxes, reaches = np.empty((count, 3, 3)), np.zeros((count, 6)), np.zeros(count)
    azimuths, radii = np.empty(3), np.empty(3)
    for facet in range(count):
        back = 0
        if sector:
            for i in range(3):
                node = facets[facet, i]
                azimuths[i], radii[i] = wrapped(azimuth[node] + facet_image[facet, i] * angle), radius[node]
            middle, half = around_axis(azimuths, radii, 3, 1e-3 * touching)
            back = math.floor(middle / angle + 0.5)
            reaches[facet] = abs(middle - back * angle) + half
        for i in range(3):
            write_point(position, facets[facet, i], facet_image[facet, i] - back, cosines, sines, corners[facet, i])
        write_box(corners[facet], sector, boxes[facet])
    start, contents, low, size, shape, reach = sorted_into_cells(boxes)
    planes, plane, widest = np.empty((4, count)), np.empty(4), np.zeros(len(start) - 1)
    for cell in range(len(widest)):
        for place in range(start[cell], start[cell + 1]):
            write_plane(corners[contents[place]], touching, plane)
            for k in range(4):
                planes[k, place] = plane[k]
            widest[cell] = max(widest[cell], reaches[contents[place]])
    bar_ends, turned, box = np.empty((2, 3)), np.empty((2, 3)), np.zeros(6)
    cells = np.empty((3, 2), dtype=np.int64)
    for bar in range(len(first)):
        write_point(position, first[bar], 0, cosines, sines, bar_ends[0])
        write_point(position, second[bar], image[bar], cosines, sines, bar_ends[1])
        write_box(bar_ends, sector, box)
        for i in range(3):
            cells[i, 0] = max(int((box[i] - reach[i] - low[i]) / size), 0)
            cells[i, 1] = min(int((box[3 + i] + reach[i] - low[i]) / size), shape[i] - 1)
        if cells[2, 0] > cells[2, 1]:
            continue  # beyond all facets, where the list has no stretch
        middle, half = 0.0, 0.0
        if sector:
            azimuths[0], azimuths[1] = azimuth[first[bar]], wrapped(azimuth[second[bar]] + image[bar] * angle)
            radii[0], radii[1] = radius[first[bar]], radius[second[bar]]
            middle, half = around_axis(azimuths, radii, 2, 1e-3 * touching)
        pierced = 0.0
        for i in range(cells[0, 0], cells[0, 1] + 1):
            for j in range(cells[1, 0], cells[1, 1] + 1):
                row = (i * shape[1] + j) * shape[2]
                # cells that follow one another along the last coordinate are one stretch of the list
                begin, end = start[row + cells[2, 0]], start[row + cells[2, 1] + 1]
                least, most = 0, 0
                if sector:
                    wide = half + ON_EDGE
                    for cell in range(row + cells[2, 0], row + cells[2, 1] + 1):
                        wide = max(wide, half + ON_EDGE + widest[cell])
                    least = math.ceil((middle - wide) / angle)
                    most = min(math.floor((middle + wide) / angle), least + sectors - 1)
                for turn in range(least, most + 1):
                    # the bar is turned back, rather than the facets forward
                    write_point(bar_ends, 0, -turn, cosines, sines, turned[0])
                    write_point(bar_ends, 1, -turn, cosines, sines, turned[1])
                    if crossed(planes, begin, end, turned, touching) == 0:
                        continue
                    for place in range(begin, end):
                        facet = contents[place]
                        if pierces(turned, planes[:, place], corners[facet], touching):
                            pierced += 1.0 if facet_weight[facet] >= 1.0 else 0.5
                            if pierced >= 1.0:
                                return bar, facet
    return -1, -1


@njit(cache=True, error_model="numpy")
def write_box(points: Floats, sector: bool, box: Floats) -> None:
    """Write the least and the largest coordinates of a bar or a facet, (6,): (z, y, x), or of a sector (0, 0, x)."""
    for i in range(1 if sector else 3):
        box[2 - i], box[5 - i] = points[0, i], points[0, i]
        for j in range(1, len(points)):
            box[2 - i], box[5 - i] = min(box[2 - i], points[j, i]), max(box[5 - i], points[j, i])


@njit(cache=True, error_model="numpy")
def pierces(bar: Floats, plane: Floats, corners: Floats, touching: float) -> bool:
    """Whether a bar, (2, 3), goes through a facet, (3, 3), and both its ends are further from its plane, (4,)."""
    p = plane[0] * bar[0, 0] + plane[1] * bar[0, 1] + plane[2] * bar[0, 2] - plane[3]
    q = plane[0] * bar[1, 0] + plane[1] * bar[1, 1] + plane[2] * bar[1, 2] - plane[3]
    if p * q >= 0.0 or min(abs(p), abs(q)) <= touching:
        return False
    along = p / (p - q)
    x, y, z = bar[0, 0], bar[0, 1], bar[0, 2]
    return meets(corners, plane, x + along * (bar[1, 0] - x), y + along * (bar[1, 1] - y), z + along * (bar[1, 2] - z))


@njit(cache=True, error_model="numpy")
def sorted_into_cells(boxes: Floats) -> tuple[Counts, Counts, Floats, float, Counts, Floats]:
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
    while cells_in(high - low, size) > CELLS * count + 8:
        size *= 1.25
    shape = np.empty(3, dtype=np.int64)
    for i in range(3):
        shape[i] = int((high[i] - low[i]) / size) + 1
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
