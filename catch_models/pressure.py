"""Pressure of a catch on netting, as a law of the angle between the flow and the netting's outward normal.

Inside the catch the water stands still at stagnation pressure q = rho V^2 / 2; outside, the pressure is that on a
sphere, q Cp(theta) (Le Bris et al. 1999, section 5 and figure 9). The net pressure is q (1 - Cp(theta)). The second
law is uniform, q C. Both are held as one piecewise cubic in theta, so that every consumer needs one evaluation only.
"""

from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

UNIFORM_COEFFICIENT = 1.4
"""Net pressure over stagnation pressure in common practice: 1 inside, 0.4 of suction outside."""


@dataclass(frozen=True)
class PressureLaw:
    """Net pressure coefficient (inside minus outside, over q) as a piecewise cubic in theta.

    theta is the angle between the upstream direction and the outward normal, 0 on the upstream stagnation point.
    """

    name: str
    angles_rad: NDArray[np.float64]
    """Breaks of the pieces, shape (k + 1,), rising from 0 to pi."""
    coefficients: NDArray[np.float64]
    """Coefficients of (theta - break)^3 .. ^0 for each piece, shape (4, k)."""

    def __call__(self, theta_rad: ArrayLike) -> NDArray[np.float64]:
        """Net pressure coefficient at ``theta_rad`` (any shape)."""
        along, (cubic, square, slope, value) = self._piece_at(theta_rad)
        return np.asarray(((cubic * along + square) * along + slope) * along + value)

    def derivative(self, theta_rad: ArrayLike) -> NDArray[np.float64]:
        """Derivative of the net pressure coefficient with respect to theta, per radian."""
        along, (cubic, square, slope, _) = self._piece_at(theta_rad)
        return np.asarray((3.0 * cubic * along + 2.0 * square) * along + slope)

    def _piece_at(self, theta_rad: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Theta less the break before it, and the coefficients from there, (4, ...)."""
        theta = np.asarray(theta_rad, dtype=np.float64)
        piece = np.searchsorted(self.angles_rad[1:-1], theta, side="right")
        return theta - self.angles_rad[piece], self.coefficients[:, piece]


def uniform_law(coefficient: float = UNIFORM_COEFFICIENT) -> PressureLaw:
    """The same net pressure, ``coefficient`` times q, at every angle."""
    return PressureLaw("uniform", np.array([0.0, np.pi]), np.array([[0.0], [0.0], [0.0], [coefficient]]))


@lru_cache(maxsize=1)
def sphere_law() -> PressureLaw:
    """Stagnation pressure inside and a sphere's Cp outside: 1 - Cp(theta).

    The Cp curve is a *reconstruction* of the subcritical curve (Schlichting, Boundary-Layer Theory, figure 1.11), not a
    digitised measurement: see the header of ``catch_models/data/sphere_cp_subcritical.csv``. It is read from its pieces
    as they ship: what makes them takes a quarter of a second to import.
    """
    path = Path(str(files("catch_models") / "data" / "sphere_cp_subcritical_pieces.csv"))
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    pieces = np.loadtxt(lines, delimiter=",", skiprows=1)
    return PressureLaw("sphere", np.append(pieces[:, 0], np.pi), np.ascontiguousarray(pieces[:, 1:].T))


def sphere_law_through(theta_deg: NDArray[np.float64], cp: NDArray[np.float64]) -> PressureLaw:
    """The same with another curve of Cp, (k,) at angles (k,): monotone cubic (PCHIP) in theta.

    Raises:
        ValueError: the angles do not rise from 0 to 180.
    """
    from scipy.interpolate import PchipInterpolator

    if theta_deg.size < 2 or theta_deg[0] != 0.0 or theta_deg[-1] != 180.0 or np.any(np.diff(theta_deg) <= 0.0):
        raise ValueError("theta_deg must rise from 0 to 180")
    pieces = PchipInterpolator(np.radians(theta_deg), 1.0 - cp)
    return PressureLaw("sphere", np.asarray(pieces.x), np.asarray(pieces.c))
