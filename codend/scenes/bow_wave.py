"""Bow wave of a ship that goes steadily ahead: its height, profile, velocities and sheet, in closed form.

Source: Guilbaud, David, Delhommeau and Noblesse, Etude experimentale et theorique de la vague d'etrave des navires
(GD below). Lengths are in units of U^2 / g and velocities in units of U, U the ship's speed, unless a name says
otherwise. Four slips of the print are mended: F_D is U / sqrt(g D); velocities are V / U; t is a length; in the
velocity the root stands over both of its terms, and with the angle mu left out cos(gamma + mu) is cos(gamma).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

GRAVITY_M_S2 = 9.81
HEIGHT_CONSTANT = 2.2
"""C of GD 3.1, from experiments."""
STEADY_LIMIT = 0.5
"""Height above which no water of a steady flow rises, by Bernoulli's equation (GD 3.1)."""
LIMIT_ANGLE_DEG: Final = math.degrees(math.asin(math.sqrt(HEIGHT_CONSTANT**2 + 1.0) - HEIGHT_CONSTANT))
"""Half entrance angle up to which the wave is steady at any speed (GD 3.1)."""


@dataclass(frozen=True)
class Hull:
    """The bow of a hull: how it opens behind its stem."""

    name: str
    entrance_angle_deg: float
    """Half the angle at which the waterline opens at the stem."""
    source: str


HULLS: Final = {
    hull.name: hull
    for hull in (
        Hull("model-10", 10.0, "GD 4: Larrarte's model, 1.5 m long, draught 0.2 m"),
        Hull("model-20", 20.0, "GD 4: Larrarte's model, 1.5 m long, draught 0.2 m"),
        Hull("model-30", 30.0, "GD 4: Larrarte's model, 1.5 m long, draught 0.2 m"),
        Hull(
            "wigley", math.degrees(math.atan(0.2)), "y = (B/2) (1 - (2x/L)^2) (1 - (z/D)^2) with the usual B = L / 10"
        ),
    )
}
"""Hulls whose entrance is known; a flat plate has the angle at which it is set."""


@dataclass(frozen=True)
class BowWave:
    """The wave at a bow.

    Raises:
        ValueError: an angle, speed or draught out of range.
    """

    speed_m_s: float
    draught_m: float
    entrance_angle_deg: float
    """Half entrance angle of the waterline, more than 0 and less than 90."""
    flare_deg: float = 0.0
    """Angle of the hull's side to the vertical, 0 or more and less than 90."""
    stem_share: float = 0.0
    """sigma: height at the stem over the largest, 0 or more and less than 1. GD tell no law for it; 0 is assumed."""

    def __post_init__(self) -> None:
        allowed = {
            "speed_m_s": (0.0 < self.speed_m_s <= 100.0, "more than 0 and at most 100"),
            "draught_m": (0.0 < self.draught_m <= 100.0, "more than 0 and at most 100"),
            "entrance_angle_deg": (0.0 < self.entrance_angle_deg < 90.0, "more than 0 and less than 90"),
            "flare_deg": (0.0 <= self.flare_deg < 90.0, "from 0 to less than 90"),
            "stem_share": (0.0 <= self.stem_share < 1.0, "from 0 to less than 1"),
        }
        for name, (right, what) in allowed.items():
            if not right:
                raise ValueError(f"{name} = {getattr(self, name):g} is not allowed; allowed: {what}")

    @property
    def length_unit_m(self) -> float:
        """U^2 / g, m."""
        return self.speed_m_s**2 / GRAVITY_M_S2

    @property
    def froude(self) -> float:
        """F_D = U / sqrt(g D)."""
        return self.speed_m_s / math.sqrt(GRAVITY_M_S2 * self.draught_m)

    @property
    def height(self) -> float:
        """z_b = C tan(a) / cos(a) / (1 + F_D), of the crest (GD 3.1)."""
        return HEIGHT_CONSTANT * _opening(self.entrance_angle_deg) / (1.0 + self.froude)

    @property
    def steady(self) -> bool:
        """Whether a steady wave is possible."""
        return self.height < STEADY_LIMIT

    @property
    def slowest_steady_m_s(self) -> float:
        """Speed from which on the wave is steady, 0 below ``LIMIT_ANGLE_DEG`` (GD 3.1)."""
        return steady_limit(self.entrance_angle_deg) * math.sqrt(GRAVITY_M_S2 * self.draught_m)

    @property
    def crest(self) -> float:
        """t_b: distance of the crest from the stem, along the hull; nan where the wave is not steady (GD 3.1)."""
        if not self.steady:
            return math.nan
        return math.sqrt(2.0 * self.height * (1.0 - 2.0 * self.height) * (1.0 - self.stem_share))

    def profile(self, t: Floats) -> Floats:
        """Heights of the contact line at distances from the stem: a parabola to the crest, then a cosine (GD 3.1)."""
        past = t - self.crest
        rise = self.height * (1.0 - (1.0 - self.stem_share) * (past / self.crest) ** 2)
        return np.where(past <= 0.0, rise, self.height * np.cos(past))

    def slope(self, t: Floats) -> Floats:
        """Derivative of ``profile``."""
        past = t - self.crest
        rise = -2.0 * self.height * (1.0 - self.stem_share) * past / self.crest**2
        return np.where(past <= 0.0, rise, -self.height * np.sin(past))

    def velocity(self, t: Floats) -> tuple[Floats, Floats]:
        """Velocities u along the hull's waterline and w up its side, of water at the contact line (GD 3.2).

        The angle mu of the free surface across the line drops out: w / u is the slope over the cosine of the flare.
        """
        flare, slope = math.cos(math.radians(self.flare_deg)), self.slope(t)
        # past the crest of the cosine the line dips below 0, never so far up that water would have no speed left
        root = np.sqrt((1.0 - 2.0 * self.profile(t)) / (flare**2 + slope**2))
        return root * flare, root * slope

    def sheet(self, t: Floats, onward: Floats) -> tuple[Floats, Floats, Floats]:
        """Where water is that left the hull at distances ``t`` (k,), ``onward`` (m,) farther on: free flight (GD 3.3).

        Returns:
            along the hull t', out from its waterline m' and up z', each (k, m).
        """
        flare = math.radians(self.flare_deg)
        u, w = (part[:, None] for part in self.velocity(t))
        height = self.profile(t)[:, None]
        time = onward[None, :] / u
        out = height * math.tan(flare) + time * w * math.sin(flare)
        up = height + time * (w * math.cos(flare) - 0.5 * time)
        return t[:, None] + onward[None, :], out, up


def steady_limit(entrance_angle_deg: float) -> float:
    """Froude number F_D from which on a wave is steady: 2 C tan(a) / cos(a) - 1, 0 where that is less (GD 3.1)."""
    return max(2.0 * HEIGHT_CONSTANT * _opening(entrance_angle_deg) - 1.0, 0.0)


def _opening(entrance_angle_deg: float) -> float:
    angle = math.radians(entrance_angle_deg)
    return math.tan(angle) / math.cos(angle)
