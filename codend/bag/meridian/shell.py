"""The meridian equations of a bag of netting, without dimensions, with their exact derivatives.

Derivation. 2 N bars of tension T at half angle phi to the meridian join two neighbouring half-mesh rows, which lie l_s
apart along the meridian. They pull along it with Q = 2 N T cos phi in all. Any plane through the axis cuts one bar per
half-mesh row, so the hoop force per length of meridian is T sin phi / l_s. With the slope a of the meridian
(dx/ds = cos a, dr/ds = sin a) its curvatures are -da/ds along and cos(a) / r across. Equilibrium of an element along
its outward normal (-sin a, cos a) and along the meridian, counted in half-mesh rows j (ds = l_s dj), is

    da/dj     = (pi / N) tan(phi) cos(a) - (2 pi r l_s p + F_n) / Q
    dln(Q)/dj = (pi / N) tan(phi) sin(a) - F_t / Q
    dr/dj     = l_s sin(a),   dx/dj = l_s cos(a)

with p the net pressure, and F_n and F_t the twine drag of a half-mesh row along the normal and along the meridian.
Knots enter through r and l_s alone: diamond r = (N b / pi) sin phi, l_s = b cos phi + l; T90
r = N (b sin phi + l) / pi, l_s = b cos phi. Where T90 netting is narrower than its knots, r < N l / pi, the knots are
slack: the bars then lie in meridian planes, phi = 0, and carry no hoop force. Knots that resist compression tilt out of
the skin there, which leaves the bars in meridian planes (derived); what the last ones push at the codline is no part of
the membrane. In row coordinates nothing is singular at
the codline, where r = 0 and a = -pi/2 (a free codline takes no axial force).

Drag of a row. With i the flow, e the meridian and n the normal, the bars' directions are cos(phi) e plus and minus
sin(phi) across; cos B = cos(phi) cos(a) is the cosine between bar and flow. A bar's load is
k_n (i - cos B t) + k_t cos B t times rho d b V^2 / 2, where k_n = Cd sin B and k_t = f Cd |cos B| (Le Bris et al.
1999, eq. 4-5) or k_n = Cd and k_t = Cf (Bessonneau & Marichal 1997, eq. 2-3). Summed over 2 N bars, with t.n = 0 and
t.e = cos phi,

    F_n = -N rho d b V^2 k_n sin(a)
    F_t =  N rho d b V^2 cos(a) (k_n sin^2 phi + k_t cos^2 phi)

Without dimensions: radius over R = N b / pi, rows as t = pi j / N, pressure over q = rho V^2 / 2, Q over pi R^2 q. Then
the pressure term is 2 r l_s C(theta) / Q and drag has the one factor 2 d / b. theta, between the upstream direction and
the outward normal, is pi/2 - a. Elastic twine has b (1 + T / EA) in place of b: with e = Q / (2 N EA),
r = sin phi + e tan phi and l_s = cos phi + e, knots apart. A knot carries what its two twines pull with: along the
netting Q / N, across it Q tan(phi) / N. One of stiffness EA_k adds g = (l / b) Q / (N EA_k) to l_s where it lies along,
and g tan phi to r where it lies across.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from catch_models.pressure import PressureLaw
from codend.mechanics.drag_laws import drag_factors_of

Floats = NDArray[np.float64]
_ROUND_OFF = 1e-30
_STEEPEST = 0.999999  # sine of the half angle at which bars that cannot stretch are held while a solver tries radii
_LARGEST_LOG = 50.0  # likewise for ln Q


@dataclass(frozen=True)
class Shell:
    """A bag of netting as the meridian equations see it, without dimensions."""

    rows: float
    """2 M pi / N, the half-mesh rows from entry to codline."""
    front: float
    """Place of the catch's front, in the same measure."""
    entry_radius: float
    """Over N b / pi."""
    knot: float
    """Knot length over bar length."""
    knot_across: bool
    """T90: the knots lie across the meridian."""
    pressure: PressureLaw
    drag_law: int
    """Place in ``drag_laws.DRAG_LAWS``."""
    normal: float
    tangential: float
    speed_m_s: float
    reynolds_per_speed: float
    drag_width: float
    """2 d / b."""
    compliance: float
    """pi R^2 q / (2 N EA), 0 for inextensible bars."""
    knot_compliance: float = 0.0
    """(l / b) pi R^2 q / (N EA_k), 0 for knots that do not stretch."""

    @property
    def inextensible(self) -> bool:
        """Whether neither bars nor knots stretch."""
        return self.compliance == 0.0 and self.knot_compliance == 0.0

    @property
    def knot_along(self) -> float:
        """Share of a row's length along the meridian that is knot, over bar length."""
        return 0.0 if self.knot_across else self.knot

    @property
    def knot_round(self) -> float:
        """Radius a ring of knots alone would have."""
        return self.knot if self.knot_across else 0.0


@dataclass(frozen=True)
class Bars:
    """Bars at given radii and meridional forces, arrays of one shape."""

    sine: Floats
    """sin(phi)."""
    cosine: Floats
    row_length: Floats
    """l_s over b."""
    phi_radius: Floats
    """Derivative of phi with respect to the radius; 0 where knots are slack."""
    phi_log_force: Floats
    """Derivative of phi with respect to ln Q."""
    strain_force: Floats
    """Q / (2 N EA): the bars' strain times cos(phi)."""
    row_stretch: Floats
    """What the forces add to ``row_length``, which is linear in Q: the bars' stretch and that of knots along."""


def bars_at(shell: Shell, radius: Floats, log_force: Floats) -> Bars:
    """Bars where the netting has this radius and carries this meridional force, both (n,)."""
    wide = radius - shell.knot_round
    taut = np.ones_like(radius)
    if shell.knot_round > 0.0:
        taut = (wide > 0.0).astype(float)
        wide = wide * taut
    force = np.exp(np.minimum(log_force, _LARGEST_LOG))
    stretch, of_knot = shell.compliance * force, shell.knot_compliance * force
    # of what widens the ring as its bars turn, and of what lengthens the row
    round_, along = (stretch + of_knot, stretch) if shell.knot_across else (stretch, stretch + of_knot)
    if shell.compliance == 0.0 and not (shell.knot_across and shell.knot_compliance > 0.0):
        sine = np.clip(wide, -_STEEPEST, _STEEPEST)
        cosine = np.sqrt(1.0 - sine**2)
    else:
        phi = _stretched_angle(wide, round_)
        sine, cosine = np.sin(phi), np.cos(phi)
    phi_radius = taut / (cosine + round_ / cosine**2)
    return Bars(
        sine=sine,
        cosine=cosine,
        row_length=cosine + along + shell.knot_along,
        phi_radius=phi_radius,
        phi_log_force=-round_ * sine / cosine * phi_radius,
        strain_force=stretch,
        row_stretch=along,
    )


def _stretched_angle(wide: Floats, stretch: Floats) -> Floats:
    """Half angle of sin(phi) + e tan(phi) = w, by Newton in u = tan(phi): w = u (1/sqrt(1 + u^2) + e)."""
    magnitude = np.abs(wide)
    tangent = magnitude / (1.0 + stretch)  # from below: the left side is concave, so Newton rises to the root
    for _ in range(60):
        secant = np.sqrt(1.0 + tangent**2)
        step = (magnitude - tangent * (1.0 / secant + stretch)) / (secant**-3 + stretch)
        tangent = tangent + step
        if np.all(np.abs(step) <= 1e-14 * (1.0 + tangent)):
            break
    return np.arctan(tangent) * np.sign(wide)


def drag_coefficients(shell: Shell, bars: Bars, slope: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Coefficients k_n and k_t of a bar's load across and along itself, and their derivatives by cos B."""
    along = bars.cosine * np.cos(slope)
    across = np.sqrt(np.maximum(1.0 - along**2, _ROUND_OFF))
    v = shell.speed_m_s
    a, c, a_across, a_along, c_across, c_along = drag_factors_of(
        shell.drag_law, shell.normal, shell.tangential, v * across, v * np.abs(along), shell.reynolds_per_speed
    )
    # sin B falls by cos B / sin B as cos B grows
    normal_b = a_along * np.sign(along) - a_across * along / across
    tangential_b = c_along * np.sign(along) - c_across * along / across
    return a / v, c / v, normal_b, tangential_b


def axial_drag(shell: Shell, bars: Bars, slope: Floats) -> Floats:
    """Axial twine drag of the 2 N bars of a row, per unit of t and over pi R^2 q."""
    normal, tangential, _, _ = drag_coefficients(shell, bars, slope)
    along2 = (bars.cosine * np.cos(slope)) ** 2
    length = shell.drag_width * (1.0 + bars.strain_force / bars.cosine)
    return length * (normal * (1.0 - along2) + tangential * along2)


def rates(shell: Shell, state: Floats, in_catch: Floats) -> tuple[Floats, Floats]:
    """Right-hand sides of the meridian equations in t and their Jacobian.

    Args:
        shell: the bag.
        state: radius, slope and ln Q, shape (3, n).
        in_catch: 1 where the netting is in contact with the catch (pressure, no twine drag), else 0, shape (n,).

    Returns:
        Derivatives of the state with respect to t, (3, n), and their derivatives [i, j] = df_i / dy_j, (3, 3, n).
    """
    radius, slope, log_force = state
    bars = bars_at(shell, radius, log_force)
    sin_a, cos_a = np.sin(slope), np.cos(slope)
    s, c = bars.sine, bars.cosine
    tangent = s / c
    inverse_force = np.exp(-np.maximum(log_force, -_LARGEST_LOG))

    theta = np.clip(0.5 * np.pi - slope, 0.0, np.pi)
    pressure = in_catch * shell.pressure(theta) * inverse_force
    pressure_a = -in_catch * shell.pressure.derivative(theta) * inverse_force
    normal, tangential, normal_b, tangential_b = drag_coefficients(shell, bars, slope)
    bare = shell.drag_width * (1.0 - in_catch) * inverse_force  # by 1 + e / cos(phi), the bars' stretch
    drag = bare * (1.0 + bars.strain_force / c)
    mixed = normal * s**2 + tangential * c**2
    value = np.stack(
        [
            bars.row_length * sin_a,
            tangent * cos_a - 2.0 * radius * bars.row_length * pressure + drag * normal * sin_a,
            tangent * sin_a - drag * mixed * cos_a,
        ]
    )

    # partial derivatives with phi still free; cos B = cos(phi) cos(a)
    drag_phi = bare * bars.strain_force * s / c**2
    normal_phi, normal_a = -normal_b * s * cos_a, -normal_b * c * sin_a
    mixed_b = normal_b * s**2 + tangential_b * c**2
    mixed_phi = -mixed_b * s * cos_a + 2.0 * s * c * (normal - tangential)
    mixed_a = -mixed_b * c * sin_a
    by_phi = np.stack(
        [
            -s * sin_a,
            cos_a / c**2 + 2.0 * radius * s * pressure + (drag_phi * normal + drag * normal_phi) * sin_a,
            sin_a / c**2 - (drag_phi * mixed + drag * mixed_phi) * cos_a,
        ]
    )
    by_slope = np.stack(
        [
            bars.row_length * cos_a,
            -tangent * sin_a - 2.0 * radius * bars.row_length * pressure_a + drag * (normal_a * sin_a + normal * cos_a),
            tangent * cos_a - drag * (mixed_a * cos_a - mixed * sin_a),
        ]
    )
    # ln Q: e / Q does not depend on it, so that the stretched length drops out of the loads' derivatives
    by_log_force = np.stack(
        [
            bars.row_stretch * sin_a,
            2.0 * radius * pressure * (bars.row_length - bars.row_stretch) - bare * normal * sin_a,
            bare * mixed * cos_a,
        ]
    )
    jacobian = by_phi[:, None] * np.stack([bars.phi_radius, np.zeros_like(s), bars.phi_log_force])
    jacobian += np.stack([np.zeros_like(value), by_slope, by_log_force], axis=1)
    jacobian[1, 0] -= 2.0 * bars.row_length * pressure
    return value, jacobian
