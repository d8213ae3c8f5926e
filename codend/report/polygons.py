"""Meshes of the whole net as plain polygons, for pictures and files."""

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import WholeBag


def joined_on_axis(whole: WholeBag) -> WholeBag:
    """The same net with nodes that meet on the axis, such as the codline of every sector, made one."""
    on_axis = np.flatnonzero(~np.any(whole.positions[:, 1:], axis=1))
    _, first, of_node = np.unique(whole.positions[on_axis, 0], return_index=True, return_inverse=True)
    kept = np.ones(len(whole.positions), dtype=bool)
    kept[on_axis] = False
    kept[on_axis[first]] = True
    number = np.cumsum(kept, dtype=np.int32) - 1
    number[on_axis] = number[on_axis[first]][of_node]
    return WholeBag(whole.positions[kept], number[whole.bars], number[whole.meshes])


def mesh_polygons(whole: WholeBag) -> list[tuple[NDArray[np.intp], NDArray[np.int32]]]:
    """Meshes by their number of corners: (numbers of the meshes (k,), corners (k, c)) for each number c there is.

    Corners are walked from the fore one round, repeated ones left out.
    """
    differs = whole.meshes != np.roll(whole.meshes, -1, axis=1)
    corners = differs.sum(axis=1)
    found = []
    for count in np.unique(corners):
        which = np.flatnonzero(corners == count)
        found.append((which, whole.meshes[which][differs[which]].reshape(len(which), count)))
    return found
