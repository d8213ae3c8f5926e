"""Lift and drag of a flat panel of netting on a frame, and drag coefficients of twine fitted to measured panels.

The panel is turned about an axis across the flow by the incidence phi: 0 along the flow, 90 degrees across it. One
diagonal of its meshes lies along that axis. The four sides of a mesh have the unit vectors

    t = cos(beta/2) e +- sin(beta/2) k,   e = (cos phi, sin phi),

k along the axis and beta the opening, the angle between two sides where they meet at the ends of the other diagonal;
cos B = cos(beta/2) cos(phi) is the cosine between side and flow. The loads of the four sides (Le Bris et al. 1999,
equations 4 and 5; Bessonneau and Marichal 1997, equations 2 and 3), projected and divided by 1/2 rho (4 l d) V^2
(Le Bris et al. 1999, equation 7), come to (*derived*)

    C_D = kn sin^2 B + kt cos^2 B
    C_L = (kn - kt) cos(beta/2) sin(phi) cos B

    kn = Cd sin B,  kt = f Cd |cos B|   (Le Bris)
    kn = Cd,        kt = Cf             (Bessonneau; others in ``mechanics.drag_laws``)

Lift is counted towards the side of the panel's upstream edge. The sides are taken as alone in the flow: that holds for
small solidity, and at small incidence, where sides lie in the wake of others, the drag is overrated (Le Bris et al.
1999, section 4.2).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codend.mechanics.drag_laws import drag, drag_factors_of

Floats = NDArray[np.float64]

_START = (1.2, 0.1)
"""Where the fit starts; its answer does not depend on it."""
_UNTELLING = 1e6
"""Condition of the Jacobian from which on the data say nothing about one of the coefficients."""


def panel_coefficients(
    incidence_deg: ArrayLike,
    opening_deg: ArrayLike,
    normal: float,
    tangential: float,
    drag_law: str = "le-bris-1999",
    reynolds: float = np.nan,
) -> tuple[Floats, Floats]:
    """Coefficients of lift and drag over 1/2 rho (4 l d) V^2 of a panel, each of the shape the angles have together.

    Args:
        incidence_deg: angle between panel and flow.
        opening_deg: opening angle of the meshes, seen along the diagonal that turns with the panel.
        normal: Cd.
        tangential: f, or Cf of Bessonneau's law.
        drag_law: which law of twine drag.
        reynolds: of the twine at the speed of the flow, V d / nu, where the law depends on it.

    Raises:
        ValueError: no such drag law, or it needs the Reynolds number.
    """
    phi, half = np.radians(incidence_deg), 0.5 * np.radians(opening_deg)
    cosine = np.asarray(np.cos(half) * np.cos(phi))
    sine = np.asarray(np.sqrt(1.0 - cosine**2))
    law, _, _ = drag(drag_law, normal, tangential)
    factors = drag_factors_of(law, normal, tangential, sine.ravel(), np.abs(cosine).ravel(), reynolds)
    across, along = (factor.reshape(sine.shape) for factor in factors[:2])
    if np.isnan(across).any() and not np.isnan(sine).any():
        raise ValueError(f"{drag_law} needs the Reynolds number of the twine")
    lift = (across - along) * np.cos(half) * np.sin(phi) * cosine
    return np.asarray(lift), np.asarray(across * sine**2 + along * cosine**2)


def solidity(twine_m: ArrayLike, bar_m: ArrayLike, opening_deg: ArrayLike) -> Floats:
    """Area of twine over area of netting, S = 2 d / (l sin beta) (Le Bris et al. 1999, equation 6)."""
    return np.asarray(2.0 * np.asarray(twine_m) / (np.asarray(bar_m) * np.sin(np.radians(opening_deg))))


@dataclass(frozen=True)
class PanelFit:
    """Drag coefficients fitted to panels, with what the scatter of the data leaves open."""

    normal: float
    """Cd."""
    tangential: float
    """f, or Cf of Bessonneau's law."""
    normal_error: float
    """Standard error of Cd; nan where there are too few numbers to tell."""
    tangential_error: float
    residual: float
    """Root mean square of the differences between fitted and given coefficients."""


def fit_panel(
    incidence_deg: ArrayLike,
    opening_deg: ArrayLike,
    lift: ArrayLike,
    drag: ArrayLike,
    drag_law: str = "le-bris-1999",
    reynolds: float = np.nan,
) -> PanelFit:
    """Drag coefficients of twine by least squares on measured lift and drag of panels, all given the same weight.

    Args:
        incidence_deg: of every measurement, (n,).
        opening_deg: of every measurement, or of all, (n,) or ().
        lift: measured coefficient over 1/2 rho (4 l d) V^2, (n,); nan where it was not measured.
        drag: the same of drag, (n,).
        drag_law: which law of twine drag.
        reynolds: of the twine at the speed of the flow, where the law depends on it.

    Returns:
        The coefficients and their standard errors, from the Jacobian and the scatter about the fit.

    Raises:
        ValueError: arrays that do not fit together, or angles or numbers too few to tell the two coefficients apart.
    """
    from scipy.optimize import least_squares

    incidence, opening, lift, drag = np.broadcast_arrays(incidence_deg, opening_deg, lift, drag)
    measured = np.concatenate([np.ravel(lift), np.ravel(drag)]).astype(float)
    known = np.isfinite(measured)
    count = int(np.count_nonzero(known))
    if count < 2:
        raise ValueError(f"two coefficients cannot be fitted to {count} measured number(s)")

    def difference(unknown: Floats) -> Floats:
        normal, tangential = unknown
        found = panel_coefficients(incidence, opening, normal, tangential, drag_law, reynolds)
        return (np.concatenate([np.ravel(part) for part in found]) - measured)[known]

    fit = least_squares(difference, _START, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    jacobian = np.array(fit.jac, dtype=np.float64)
    if np.linalg.cond(jacobian) > _UNTELLING:
        raise ValueError("these angles do not tell the two coefficients apart: more incidences are needed")
    scatter = 2.0 * fit.cost / (count - 2) if count > 2 else np.nan
    errors = np.sqrt(scatter * np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    return PanelFit(*map(float, (*fit.x, *errors, np.sqrt(2.0 * fit.cost / count))))
