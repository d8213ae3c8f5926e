"""Boxes about parts of a net on their way, sorted into the cells of a grid: kernels."""

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.images import turned
from codend.net.net import Floats, Ints

Numbers = NDArray[np.int64]

MOST_CELLS = 4
"""Cells of the grid, over the parts that are sorted into it."""


@njit(cache=True)
def write_box(
    position: Floats, way: Floats, node: Ints, image: Ints, turn: int, rotations: Floats, reach: float, box: Floats
) -> None:
    """Write least and largest coordinates of some nodes on their way, turned by ``turn`` images more, (6,)."""
    for i in range(3):
        box[i], box[3 + i] = np.inf, -np.inf
    for corner in range(len(node)):
        place, turns = node[corner], image[corner] + turn
        x, y, z = position[place, 0], position[place, 1], position[place, 2]
        dx, dy, dz = way[place, 0], way[place, 1], way[place, 2]
        y, z = turned(y, z, turns, rotations)
        dy, dz = turned(dy, dz, turns, rotations)
        box[0], box[3] = min(box[0], x, x + dx), max(box[3], x, x + dx)
        box[1], box[4] = min(box[1], y, y + dy), max(box[4], y, y + dy)
        box[2], box[5] = min(box[2], z, z + dz), max(box[5], z, z + dz)
    for i in range(3):
        box[i] -= reach
        box[3 + i] += reach


@njit(cache=True)
def cells_in(extent: Floats, cell: float) -> float:
    """About how many cells of a size, and no less, a grid has that covers some extent along each coordinate, (3,)."""
    return float((extent[0] / cell + 1.0) * (extent[1] / cell + 1.0) * (extent[2] / cell + 1.0))


@njit(cache=True)
def sorted_into_cells(boxes: Floats, cell: float) -> tuple[Numbers, Numbers, Floats, float, Numbers]:
    """Where the list of each cell starts, the boxes in each, the grid's corner, its cells' size, and its shape."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for box in boxes:
        for i in range(3):
            low[i], high[i] = min(low[i], box[i]), max(high[i], box[3 + i])
    shape = np.ones(3, dtype=np.int64)
    # of parts flung far apart the grid has more cells than a whole number holds
    while len(boxes) > 0 and cells_in(high - low, cell) > MOST_CELLS * len(boxes) + 1000:
        cell *= 1.3
    for i in range(3):
        shape[i] = max(int((high[i] - low[i]) / cell) + 1, 1) if len(boxes) else 1
    cells = shape[0] * shape[1] * shape[2]
    start = np.zeros(cells + 1, dtype=np.int64)
    contents = np.zeros(0, dtype=np.int64)
    for filling in range(2):
        for number in range(len(boxes)):
            box = boxes[number]
            for i in range(int((box[0] - low[0]) / cell), int((box[3] - low[0]) / cell) + 1):
                for j in range(int((box[1] - low[1]) / cell), int((box[4] - low[1]) / cell) + 1):
                    for k in range(int((box[2] - low[2]) / cell), int((box[5] - low[2]) / cell) + 1):
                        place = (i * shape[1] + j) * shape[2] + k
                        if filling == 0:
                            start[place + 1] += 1
                        else:
                            contents[start[place]] = number
                            start[place] += 1
        if filling == 0:
            for place in range(cells):
                start[place + 1] += start[place]
            contents = np.zeros(start[cells], dtype=np.int64)
    for place in range(cells, 0, -1):
        start[place] = start[place - 1]
    start[0] = 0
    return start, contents, low, cell, shape
