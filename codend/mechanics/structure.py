"""A net as the kernels see it: a named tuple of plain arrays."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.net.net import Floats, Ints, Net

Flags = NDArray[np.bool_]


class Structure(NamedTuple):
    """Shapes as in ``codend.net.net.Net``."""

    first: Ints
    second: Ints
    image: Ints
    rotations: Floats
    """Cosine and sine for the images -K .. K, (2 K + 1, 2)."""
    length: Floats
    flexibility: Floats
    drag_diameter: Floats
    diameter: Floats
    drag_law: Ints
    normal_drag: Floats
    tangential_drag: Floats
    is_rope: Flags
    is_strut: Flags
    facets: Ints
    facet_image: Ints
    facet_weight: Floats
    corners: Ints
    corner_image: Ints
    corner_stiffness: Floats
    corner_rest: Floats
    wrap_node: Ints
    wrap_image: Ints
    wrap_weight: Floats
    wrap_law: Floats
    free: Floats
    """1 for coordinates that move, 0 for held ones, (n, 3)."""
    order: float


def _exact_where_whole(turns: Floats) -> Floats:
    """Cosines and sines of halves and quarters without round-off: a net's two halves are alike to the last digit."""
    whole = np.rint(turns)
    return np.ascontiguousarray(np.where(np.abs(turns - whole) < 1e-15, whole, turns))


def structure_of(net: Net) -> Structure:
    """The net as named arrays; every bar is written from the lower to the higher node number."""
    one, other = net.bars[:, 0], net.bars[:, 1]
    image = np.where(one > other, -net.bar_image, net.bar_image)
    images = (image, net.facet_image, net.corner_image, net.wrap_image)
    reach = max((int(np.abs(part).max()) for part in images if part.size), default=0)
    angle = 2.0 * np.pi * np.arange(-reach, reach + 1) / net.order
    return Structure(
        first=np.minimum(one, other).astype(np.int32, copy=False),
        second=np.maximum(one, other).astype(np.int32, copy=False),
        image=image.astype(np.int32, copy=False),
        rotations=_exact_where_whole(np.stack([np.cos(angle), np.sin(angle)], axis=1)),
        length=net.bar_length,
        flexibility=net.bar_flexibility,
        drag_diameter=net.bar_drag_diameter,
        diameter=net.bar_diameter,
        drag_law=net.bar_drag_law,
        normal_drag=net.bar_normal_drag,
        tangential_drag=net.bar_tangential_drag,
        is_rope=net.bar_is_rope,
        is_strut=net.bar_is_strut,
        facets=net.facets,
        facet_image=net.facet_image,
        facet_weight=net.facet_weight,
        corners=net.corners,
        corner_image=net.corner_image,
        corner_stiffness=net.corner_stiffness,
        corner_rest=net.corner_rest,
        wrap_node=net.wrap_node,
        wrap_image=net.wrap_image,
        wrap_weight=net.wrap_weight,
        wrap_law=net.wrap_law,
        free=(~net.fixed).astype(np.float64),
        order=float(net.order),
    )
