"""Closed-form meridian of a bag under uniform pressure and without twine drag: two integrals and two unknowns.

With constant p and no drag the meridian equations (see ``shell``) have two first integrals. Q l_s is constant for
diamond netting and Q cos(phi) for T90 (that is T cos^2 phi constant without knots), and the axial force Q cos(a) is
that of the pressure on the section within: p pi r^2 in the catch, p pi r_c^2 ahead of it, r_c the front's radius. Hence

    cos a = k r^2 l_s in the catch,   cos a = E l_s ahead of it,   E = k r_c^2   (l_s of T90: cos phi)

and the rows follow by integration, dt = (cos phi / l_s) dphi / |sin a|. Both integrands are singular where the
meridian turns (sin a = 0), and the rows grow like the logarithm of the distance to the limit shapes, the tube of
tan^2 phi = 2 in the catch and the cylinder of closed meshes ahead of it. Both are removed by substitutions that hold
these distances themselves: phi* - phi = (phi* - phi_m) cosh v in the catch, with phi_m the largest angle and phi* the
limit it cannot pass; sin(a/2) = g sinh w (g cosh w where there is no neck) ahead, with 2 g^2 = |E l_s(0) - 1|. What
remains is smooth, and Gauss-Legendre on a few graded panels gives it to round-off. All lengths are without dimensions,
as in ``shell``.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codend.bag.meridian.shell import Floats, Shell

_SMALLEST = 1e-280  # keeps the parameter of a meridian on the limit itself finite


@dataclass(frozen=True)
class Netting:
    """What the first integrals need to know of the netting."""

    along: float
    """Knot length over bar length where knots lie along the meridian."""
    across: float
    """The same where they lie across."""
    widest: float
    """phi*: half angle at which r^2 l_s is largest."""
    square: Floats
    """(r^2 l_s)^2 in powers of e, shape (7,); e = cos phi - cos phi* (diamond) or sin phi* - sin phi (T90)."""

    def radius(self, phi: Floats | float) -> Floats:
        """Radius at half angle phi."""
        return np.asarray(np.sin(phi) + self.across)

    def row_length(self, phi: Floats | float) -> Floats:
        """Length of a row along the meridian."""
        return np.asarray(np.cos(phi) + self.along)


def netting_of(shell: Shell) -> Netting:
    """Largest half angle of a long catch, and the expansion of the first integral about it."""
    along, across = shell.knot_along, shell.knot_round
    if shell.knot_across:
        sine = (-across + np.sqrt(across**2 + 24.0)) / 6.0
        e = np.polynomial.Polynomial([sine, -1.0])
        return Netting(
            along, across, float(np.arcsin(sine)), np.asarray(((e + across) ** 4 * (1.0 - e**2)).coef, float)
        )
    cosine = (-along + np.sqrt(along**2 + 3.0)) / 3.0
    e = np.polynomial.Polynomial([cosine, 1.0])
    return Netting(
        along, across, float(np.arccos(cosine)), np.asarray(((1.0 - e**2) ** 2 * (e + along) ** 2).coef, float)
    )


@dataclass(frozen=True)
class Ahead:
    """Meridian ahead of the catch as a function of w; fields broadcast against w."""

    netting: Netting
    axial: Floats
    """E."""
    scale: Floats
    """g."""
    neck: NDArray[np.bool_]
    """True where the meridian has, or would have, a smallest radius: E l_s(0) > 1."""

    @classmethod
    def from_excess(cls, netting: Netting, excess: Floats) -> "Ahead":
        """The meridian with this E l_s(0) - 1."""
        axial = (1.0 + excess) / netting.row_length(0.0)
        return cls(netting, axial, np.sqrt(np.maximum(0.5 * np.abs(excess), _SMALLEST)), excess >= 0.0)

    def place(self, slope: Floats) -> Floats:
        """Parameter w of a slope."""
        half = np.sin(0.5 * slope) / self.scale
        return np.where(self.neck, np.arcsinh(half), np.sign(half) * np.arccosh(np.maximum(np.abs(half), 1.0)))

    def _half_sine(self, w: Floats) -> Floats:
        return self.scale * np.where(self.neck, np.sinh(w), np.sign(w) * np.cosh(w))

    def _closure(self, w: Floats) -> Floats:
        """1 - cos(phi), free of cancellation near closed meshes."""
        return 2.0 / self.axial * (self.scale * np.where(self.neck, np.cosh(w), np.sinh(w))) ** 2

    def rates(self, w: Floats) -> Floats:
        """Rows per parameter, from dt = da / (tan phi cos a)."""
        half2, cosine = self._half_sine(w) ** 2, 1.0 - self._closure(w)
        return cosine * np.sqrt(2.0 * self.axial / ((1.0 + cosine) * (1.0 - half2))) / (1.0 - 2.0 * half2)

    def state(self, w: Floats) -> tuple[Floats, Floats, Floats]:
        """Radius, half angle phi and slope a."""
        phi = 2.0 * np.arcsin(np.sqrt(0.5 * self._closure(w)))
        return self.netting.radius(phi), phi, 2.0 * np.arcsin(self._half_sine(w))


@dataclass(frozen=True)
class Catch:
    """Meridian in the catch as a function of v, negative ahead of the largest radius; fields broadcast against v."""

    netting: Netting
    gap: Floats
    """phi* - phi_m."""

    @property
    def axial(self) -> Floats:
        """k: cos(a) = 1 at the largest radius."""
        phi = self.netting.widest - self.gap
        return 1.0 / (self.netting.radius(phi) ** 2 * self.netting.row_length(phi))

    def place(self, phi: Floats | float) -> Floats:
        """|v| of a half angle; nan if it is above the largest."""
        return np.asarray(np.arccosh((self.netting.widest - phi) / self.gap))

    def _turn(self, v: Floats) -> tuple[Floats, Floats]:
        """phi, and 1 - (cos a)^2 over sinh(v/2)^2, without cancellation at any gap."""
        widest, squares = self.netting.widest, self.netting.square
        offset = self.gap * np.sinh(0.5 * v) ** 2  # half of phi_m - phi
        largest = widest - self.gap
        phi = largest - 2.0 * offset
        # e - m, e + m of the expansion: e at phi, m at phi_m
        if self.netting.across > 0.0:
            m = 2.0 * np.cos(widest - 0.5 * self.gap) * np.sin(0.5 * self.gap)
            chord = 2.0 * np.cos(largest - offset)
        else:
            chord = 2.0 * np.sin(largest - offset)
            m = 2.0 * np.sin(widest - 0.5 * self.gap) * np.sin(0.5 * self.gap)
        e = m + chord * np.sin(offset)
        # square(m) - square(e) = (e - m) sum of -p_n (e^n - m^n) / (e - m), n >= 2 (p_1 = 0 at the widest)
        quotient, power, total = e + m, m, -squares[2] * (e + m)
        for coefficient in squares[3:]:
            power = power * m
            quotient = e * quotient + power
            total = total - coefficient * quotient
        height = np.polynomial.polynomial.polyval(m, squares)
        return phi, self.gap * chord * np.sinc(offset / np.pi) * total / height

    def rates(self, v: Floats) -> Floats:
        """Rows per parameter, from dt = (cos phi / l_s) dphi / |sin a|."""
        phi, turn = self._turn(v)
        share = np.cos(phi) / self.netting.row_length(phi)
        return share * 2.0 * self.gap * np.cosh(0.5 * v) / np.sqrt(turn)

    def state(self, v: Floats) -> tuple[Floats, Floats, Floats]:
        """Radius, half angle phi and slope a."""
        phi, turn = self._turn(v)
        radius = self.netting.radius(phi)
        sine = -np.sinh(0.5 * v) * np.sqrt(turn)
        return radius, phi, np.arctan2(sine, self.axial * radius**2 * self.netting.row_length(phi))


@dataclass(frozen=True)
class SlackTail:
    """T90 netting narrower than its knots, r < N l / pi in the catch, as a function of -r: phi = 0, Q constant."""

    axial: Floats
    """k."""

    def rates(self, u: Floats) -> Floats:
        """Rows per parameter, from dt = dr / sin a with l_s = 1."""
        return np.asarray(1.0 / np.sqrt(1.0 - (self.axial * u**2) ** 2))

    def state(self, u: Floats) -> tuple[Floats, Floats, Floats]:
        """Radius, half angle phi and slope a."""
        return -u, np.zeros_like(u), -np.arccos(self.axial * u**2)
