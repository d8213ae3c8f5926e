"""The meridian equations of a bag of netting, without dimensions, with their exact derivatives.

Derivation. 2 N bars of tension T at half angle phi to the meridian join two neighbouring half-mesh rows, which lie l_s
apart along the meridian. They pull along it with Q = 2 N T cos phi in all. Any plane through the axis cuts one bar per
half-mesh row, so the hoop force per length of meridian is T sin phi / l_s. With the slope a of the meridian
(dx/ds = cos a, dr/ds = sin a) its curvatures are -da/ds along and cos(a) / r across. Equilibrium of an element along its
outward normal (-sin a, cos a) and along the meridian, counted in half-mesh rows j (ds = l_s dj), is

    da/dj     = (pi / N) tan(phi) cos(a) - (2 pi r l_s p + F_n) / Q
    dln(Q)/dj = (pi / N) tan(phi) sin(a) - F_t / Q
    dr/dj     = l_s sin(a),   dx/dj = l_s cos(a)

with p the net pressure, and F_n and F_t the twine drag of a half-mesh row along the normal and along the meridian. Knots
enter through r and l_s alone: diamond r = (N b / pi) sin phi, l_s = b cos phi + l; T90 r = N (b sin phi + l) / pi,
l_s = b cos phi. Where T90 netting is narrower than its knots, r < N l / pi, the knots are slack: the bars then lie in
meridian planes, phi = 0, and carry no hoop force. In row coordinates nothing is singular at the codline, where r = 0 and
a = -pi/2 (a free codline takes no axial force).

Drag of a row. With i the flow, e the meridian and n the normal, the bars' directions are cos(phi) e plus and minus
sin(phi) across; cos B = cos(phi) cos(a) is the cosine between bar and flow. A bar's load is k_n (i - cos B t) + k_t cos B t,
times rho d b V^2 / 2, where k_n = Cd sin B and k_t = f Cd |cos B| (Le Bris et al. 1999, eq. 4-5) or k_n = Cd and
k_t = Cf (Bessonneau & Marichal 1997, eq. 2-3). Summed over 2 N bars, with t.n = 0 and t.e = cos phi,

    F_n = -N rho d b V^2 k_n sin(a)
    F_t =  N rho d b V^2 cos(a) (k_n sin^2 phi + k_t cos^2 phi)

Without dimensions: radius over R = N b / pi, rows as t = pi j / N, pressure over q = rho V^2 / 2, Q over pi R^2 q. Then
the pressure term is 2 r l_s C(theta) / Q and drag has the one factor 2 d / b. theta, between the upstream direction and
the outward normal, is pi/2 - a. Elastic twine has b (1 + T / EA) in place of b: with e = Q / (2 N EA),
r = sin phi + e tan phi and l_s = cos phi + e, knots apart.
"""

from dataclasses import dataclass

import numpy as np
from catch_models.pressure import PressureLaw
from numpy.typing import NDArray

Floats = NDArray[np.float64]
DRAG_LAWS = ("le-bris-1999", "bessonneau-1997")


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
    drag_law: str
    normal: float
    tangential: float
    drag_width: float
    """2 d / b."""
    compliance: float
    """Bar strain over Q cos(phi)^-1: pi R^2 q / (2 N EA), 0 for inextensible bars."""

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


def bars_at(shell: Shell, radius: Floats, log_force: Floats) -> Bars:
    """Half angle of the bars where the netting has this radius and carries this meridional force.

    For elastic bars sin(phi) + e tan(phi) = r is solved by Newton's method from above, where it converges monotonically
    (the left side is solved in u = tan(phi), concave and rising for radii that matter).
    """
    wide = radius - shell.knot_round
    taut = np.ones_like(radius)
    if shell.knot_round > 0.0:
        taut = (wide > 0.0).astype(float)
        wide = wide * taut
    if shell.compliance == 0.0:
        sine = np.clip(wide, -0.999999, 0.999999)
        cosine = np.sqrt(1.0 - sine**2)
        stretch = np.zeros_like(radius)
    else:
        stretch = shell.compliance * np.exp(np.minimum(log_force, 50.0))
        phi = _stretched_angle(wide, stretch)
        sine, cosine = np.sin(phi), np.cos(phi)
    phi_radius = taut / (cosine + stretch / cosine**2)
    return Bars(
        sine=sine,
        cosine=cosine,
        row_length=cosine + stretch + shell.knot_along,
        phi_radius=phi_radius,
        phi_log_force=-stretch * sine / cosine * phi_radius,
        strain_force=stretch,
    )


def _stretched_angle(wide: Floats, stretch: Floats) -> Floats:
    """phi of sin(phi) + e tan(phi) = w: Newton in u = tan(phi), where the left side is u (1/sqrt(1 + u^2) + e)."""
    magnitude = np.abs(wide)
    tangent = magnitude / (1.0 + stretch)  # from below: the left side is concave, so Newton rises to the root
    for _ in range(60):
        secant = np.sqrt(1.0 + tangent**2)
        step = (magnitude - tangent * (1.0 / secant + stretch)) / (secant**-3 + stretch)
        tangent = tangent + step
        if np.all(np.abs(step) <= 1e-14 * (1.0 + tangent)):
            break
    return np.arctan(tangent) * np.sign(wide)


def drag_coefficients(shell: Shell, bars: Bars, slope: Floats) -> tuple[Floats, Floats]:
    """Coefficients k_n and k_t of a bar's load across and along itself (see the module's head)."""
    along = bars.cosine * np.cos(slope)
    if shell.drag_law == "le-bris-1999":
        across = np.sqrt(np.maximum(1.0 - along**2, 1e-30))
        return shell.normal * across, shell.tangential * shell.normal * np.abs(along)
    return np.full_like(along, shell.normal), np.full_like(along, shell.tangential)


def axial_drag(shell: Shell, bars: Bars, slope: Floats) -> Floats:
    """Axial twine drag per unit of t, over pi R^2 q: d x-force of 2 N bars a row."""
    normal, tangential = drag_coefficients(shell, bars, slope)
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
    inverse_force = np.exp(-np.maximum(log_force, -50.0))

    theta = np.clip(0.5 * np.pi - slope, 0.0, np.pi)
    pressure = in_catch * shell.pressure(theta) * inverse_force
    pressure_a = -in_catch * shell.pressure.derivative(theta) * inverse_force
    normal_load = 2.0 * radius * bars.row_length * pressure

    normal, tangential = drag_coefficients(shell, bars, slope)
    length = shell.drag_width * (1.0 + bars.strain_force / c) * (1.0 - in_catch) * inverse_force
    mixed = normal * s**2 + tangential * c**2
    normal_load = normal_load - length * normal * sin_a
    tangential_load = length * mixed * cos_a
    value = np.stack([bars.row_length * sin_a, tangent * cos_a - normal_load, tangent * sin_a - tangential_load])

    # partial derivatives with respect to phi, a and ln Q, with phi still free
    if shell.drag_law == "le-bris-1999":
        along = c * cos_a
        across = np.sqrt(np.maximum(1.0 - along**2, 1e-30))
        across_phi, across_a = along * s * cos_a / across, along * c * sin_a / across
        sign = shell.tangential * shell.normal * np.sign(along)
        normal_phi, normal_a = shell.normal * across_phi, shell.normal * across_a
        tangential_phi, tangential_a = -sign * s * cos_a, -sign * c * sin_a
    else:
        normal_phi = normal_a = tangential_phi = tangential_a = np.zeros_like(s)
    stretch = bars.strain_force
    length_phi = shell.drag_width * (1.0 - in_catch) * inverse_force * stretch * s / c**2
    length_q = -shell.drag_width * (1.0 - in_catch) * inverse_force  # of d (1 + e / c) / Q: the stretch cancels
    mixed_phi = normal_phi * s**2 + tangential_phi * c**2 + 2.0 * s * c * (normal - tangential)
    mixed_a = normal_a * s**2 + tangential_a * c**2

    by_phi = np.stack(
        [
            -s * sin_a,
            cos_a / c**2 + 2.0 * radius * s * pressure + (length_phi * normal + length * normal_phi) * sin_a,
            sin_a / c**2 - (length_phi * mixed + length * mixed_phi) * cos_a,
        ]
    )
    by_slope = np.stack(
        [
            bars.row_length * cos_a,
            -tangent * sin_a
            - 2.0 * radius * bars.row_length * pressure_a
            + length * (normal_a * sin_a + normal * cos_a),
            tangent * cos_a - length * (mixed_a * cos_a - mixed * sin_a),
        ]
    )
    by_log_force = np.stack(
        [
            stretch * sin_a,
            2.0 * radius * pressure * (bars.row_length - stretch) + length_q * normal * sin_a,
            -length_q * mixed * cos_a,
        ]
    )
    jacobian = np.empty((3, 3, len(radius)))
    jacobian[:, 0] = by_phi * bars.phi_radius
    jacobian[1, 0] -= 2.0 * bars.row_length * pressure
    jacobian[:, 1] = by_slope
    jacobian[:, 2] = by_log_force + by_phi * bars.phi_log_force
    return value, jacobian
