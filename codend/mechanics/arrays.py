"""What the kernels read: the net and its loading as named tuples of plain arrays."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats, Ints, Net

Flags = NDArray[np.bool_]

FILLED_MESHES, FRONT_FROM_CODLINE, VOLUME = range(3)
LE_BRIS_1999, BESSONNEAU_1997 = range(2)


class Structure(NamedTuple):
    """A net as the kernels see it; shapes as in ``codend.net.net.Net``."""

    first: Ints
    second: Ints
    image: Ints
    rotations: Floats
    """Cosine and sine for the images -K .. K, (2 K + 1, 2)."""
    length: Floats
    flexibility: Floats
    drag_diameter: Floats
    is_rope: Flags
    facets: Ints
    facet_image: Ints
    facet_weight: Floats
    corners: Ints
    corner_image: Ints
    corner_stiffness: Floats
    corner_rest: Floats
    free: Floats
    """1 for coordinates that move, 0 for held ones, (n, 3)."""
    order: float


class Catch(NamedTuple):
    """How the catch fills the net from its last band on, and how it presses."""

    bar_band: Ints
    """Band a bar lies in, (m,)."""
    facet_band: Ints
    """Band a facet lies in, (f,)."""
    band_meshes: Floats
    """Meshes that a band is long, (bands,)."""
    node_row: Ints
    """Row whose ring polygon the node belongs to, -1 for none, (n,)."""
    row_size: Floats
    """Nodes in the ring polygon of each row, (bands + 1,)."""
    kind: int
    """What its size is given by."""
    size: float
    """Filled meshes, distance of the front from the codline in m, or volume in m3."""
    stagnation_pressure: float
    angles: Floats
    """Breaks of the pressure law in theta, rad, (k + 1,)."""
    coefficients: Floats
    """Piecewise cubic net pressure coefficient, (4, k)."""


class Loading(NamedTuple):
    """What acts on a net: dead loads, the current, and the catch."""

    dead: Floats
    """Constant nodal forces in N, (n, 3)."""
    speed: float
    density: float
    drag_law: int
    normal: float
    tangential: float
    catch: Catch


def structure_of(net: Net) -> Structure:
    """The net as named arrays; every bar is written from the lower to the higher node number."""
    swap = net.bars[:, 0] > net.bars[:, 1]
    first = np.where(swap, net.bars[:, 1], net.bars[:, 0])
    second = np.where(swap, net.bars[:, 0], net.bars[:, 1])
    image = np.where(swap, -net.bar_image, net.bar_image)
    images = (image, net.facet_image, net.corner_image)
    reach = max(int(np.abs(part).max(initial=0)) for part in images)
    angle = 2.0 * np.pi * np.arange(-reach, reach + 1) / net.order
    return Structure(
        first=first.astype(np.int32),
        second=second.astype(np.int32),
        image=image.astype(np.int32),
        rotations=np.ascontiguousarray(np.stack([np.cos(angle), np.sin(angle)], axis=1)),
        length=net.bar_length,
        flexibility=net.bar_flexibility,
        drag_diameter=net.bar_drag_diameter,
        is_rope=net.bar_is_rope,
        facets=net.facets,
        facet_image=net.facet_image,
        facet_weight=net.facet_weight,
        corners=net.corners,
        corner_image=net.corner_image,
        corner_stiffness=net.corner_stiffness,
        corner_rest=net.corner_rest,
        free=(~net.fixed).astype(np.float64),
        order=float(net.order),
    )
