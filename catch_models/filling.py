"""How far a catch fills the bag: the share of every band of netting, counted from the entry, that lies in the catch.

The front moves continuously: the band it stands in is filled in part and carries its share of the band's loads and of
its volume, the lid placed in proportion between the two rows of knots, so that nothing jumps from row to row.
"""

import numpy as np
from numpy.typing import NDArray

from catch_models.kernel_cache import njit

Floats = NDArray[np.float64]


@njit(cache=True)
def fill_by_meshes(band_meshes: Floats, filled: float, share: Floats) -> bool:
    """Write the share of every band for ``filled`` meshes from the codline; False if the bag has fewer."""
    left = filled
    for band in range(len(share) - 1, -1, -1):
        share[band] = min(max(left / band_meshes[band], 0.0), 1.0)
        left -= band_meshes[band]
    return left <= 1e-9


@njit(cache=True)
def fill_to_plane(row_x: Floats, distance: float, share: Floats) -> bool:
    """Write the share of every band aft of a plane ``distance`` m ahead of the codline; False if out of the bag."""
    bands = len(share)
    plane = row_x[bands] - distance
    for band in range(bands):
        depth = row_x[band + 1] - row_x[band]
        share[band] = min(max((row_x[band + 1] - plane) / depth, 0.0), 1.0) if depth > 0.0 else 0.0
    # a row that lies ahead of its neighbour makes no second front: all is filled behind the foremost filled row
    for band in range(1, bands):
        if share[band - 1] > 0.0:
            share[band] = 1.0
    return plane >= row_x[0] - 1e-9 * distance


@njit(cache=True)
def fill_to_volume(row_x: Floats, band_area: Floats, band_moment: Floats, volume: float, share: Floats) -> bool:
    """Write the share of every band for a catch of ``volume`` m3; False if the bag holds less.

    Args:
        row_x: axial position of the rows, m, (bands + 1,).
        band_area: area of each band projected on the axis, positive where it faces aft, m2, (bands,).
        band_moment: integral of x over that projected area, m3, (bands,).
        volume: sum of the bands' own volumes times their shares that is wanted, m3.
        share: result, (bands,).

    The volumes of the bands add up from the codline; a band filled in part holds its share of its own.
    """
    share[:] = 0.0
    area, enclosed = 0.0, 0.0
    for band in range(len(share) - 1, -1, -1):
        whole = band_volume(row_x, band_area, band_moment, area, band)
        if enclosed + whole >= volume:
            share[band] = max(volume - enclosed, 0.0) / whole if whole > 0.0 else 1.0
            return True
        share[band] = 1.0
        area += band_area[band]
        enclosed += whole
    return False


@njit(cache=True)
def band_volume(row_x: Floats, band_area: Floats, band_moment: Floats, area_aft: float, band: int) -> float:
    """Volume of a band between the planes of its two rows, m3; ``area_aft`` is the area of all bands aft of it.

    The volume aft of a plane at x is (sum of moments) - x (sum of areas), the flux of (x, 0, 0), over the bands aft.
    """
    depth = row_x[band + 1] - row_x[band]
    return band_moment[band] - row_x[band] * band_area[band] + depth * area_aft


@njit(cache=True)
def enclosed_volume(row_x: Floats, band_area: Floats, band_moment: Floats, share: Floats) -> float:
    """Volume of the catch, m3: every band's own times its share. Arguments as in ``fill_to_volume``."""
    area, enclosed = 0.0, 0.0
    for band in range(len(share) - 1, -1, -1):
        enclosed += share[band] * band_volume(row_x, band_area, band_moment, area, band)
        area += band_area[band]
    return enclosed
