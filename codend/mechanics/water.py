"""The water: its density and viscosity, and its flow, which may change with the height. Kernels."""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.net.net import Floats

VISCOSITY_M2_S = 1.19e-6
"""Kinematic viscosity of sea water of salinity 35 at 15 degrees Celsius (ITTC recommended procedure 7.5-02-01-03)."""


class Water(NamedTuple):
    """Water at rest or in a current."""

    density: float
    """kg/m3."""
    viscosity: float
    """Kinematic, m2/s."""
    height: Floats
    """Heights z for which the flow is given, rising, m, (k,)."""
    flow: Floats
    """Velocity of the water there, m/s, (k, 3); linear between two heights, constant beyond them."""

    @property
    def fastest(self) -> float:
        """Speed of its fastest layer, m/s."""
        return float(np.linalg.norm(self.flow, axis=1).max())


def uniform_flow(density: float, flow: Floats, viscosity: float = VISCOSITY_M2_S) -> Water:
    """Water that flows alike everywhere, ``flow`` (3,) in m/s."""
    return Water(float(density), float(viscosity), np.zeros(1), np.array(flow, dtype=float).reshape(1, 3))


@njit(cache=True)
def flow_at(water: Water, z: float) -> tuple[float, float, float, float, float, float]:
    """Velocity of the water at a height, m/s, and its derivative by the height, 1/s."""
    height, flow = water.height, water.flow
    last = len(height) - 1
    if last == 0 or z <= height[0]:
        return flow[0, 0], flow[0, 1], flow[0, 2], 0.0, 0.0, 0.0
    if z >= height[last]:
        return flow[last, 0], flow[last, 1], flow[last, 2], 0.0, 0.0, 0.0
    above = np.searchsorted(height, z, side="right")
    below = above - 1
    step = height[above] - height[below]
    share = (z - height[below]) / step
    sx, sy, sz = (
        (flow[above, 0] - flow[below, 0]) / step,
        (flow[above, 1] - flow[below, 1]) / step,
        (flow[above, 2] - flow[below, 2]) / step,
    )
    return (
        flow[below, 0] + share * step * sx,
        flow[below, 1] + share * step * sy,
        flow[below, 2] + share * step * sz,
        sx,
        sy,
        sz,
    )
