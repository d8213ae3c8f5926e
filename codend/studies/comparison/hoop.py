"""The drag of the hoop a codend hangs from in a flume: a computed term, for tables whose measured drag includes it."""

import math
from dataclasses import dataclass

from codend.net.net import Floats

CYLINDER_DRAG = 1.2
"""Drag coefficient of a round cylinder across the flow, as Le Bris et al. (1999, section 4.2) quote it."""


@dataclass(frozen=True)
class Hoop:
    """A ring of round rod, its plane across the flow.

    No source at hand prints the rod of the flume's hoop: its thickness is an assumption of whoever gives it, and goes
    by that word wherever the drag is shown.
    """

    radius_m: float
    """Of the ring, the codend's entry."""
    rod_m: float
    """Diameter of the rod, ASSUMED."""
    water_density_kg_m3: float
    drag_coefficient: float = CYLINDER_DRAG

    def drag_n(self, speed_m_s: Floats) -> Floats:
        """Drag at given speeds, N, 1/2 rho V^2 Cd d 2 pi R: as of a straight rod of the ring's length."""
        area = self.rod_m * 2.0 * math.pi * self.radius_m
        return 0.5 * self.water_density_kg_m3 * speed_m_s**2 * self.drag_coefficient * area

    @property
    def origin(self) -> str:
        """Where its drag is from, in words."""
        return f"computed, rod of {1000.0 * self.rod_m:g} mm ASSUMED"
