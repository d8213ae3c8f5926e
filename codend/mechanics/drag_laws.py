"""Laws of the drag of a round bar (Landweber-Richtmyer): what a bar feels of the water that passes it. Kernels.

With Vn the part of the velocity across the bar and Vt the part along it, the drag over 1/2 rho d l is

    A Vn + C Vt

Both factors, in m/s, depend on |Vn| and |Vt|. A law is a branch of ``drag_factors`` with a number of its own:

    le-bris-1999           A = Cd |Vn|        C = f Cd |Vt|     Le Bris et al. (1999), equations 4 and 5
    bessonneau-1997        A = Cd |V|         C = Cf |V|        Bessonneau and Marichal (1997), equations 2 and 3
    choo-casarella-1971    A = Cd(Re) |Vn|    C = 2 pi nu / d (0.55 Re^1/2 + 0.084 Re^2/3),  Re = |Vn| d / nu

The third is that of Choo and Casarella (1971, Hydrodynamic resistance of towed cables, Journal of Hydronautics 5(4),
126-131) as Tsukrov et al. (2003, Ocean Engineering 30, 251-270) give it:

    Cd = 8 pi / (Re s) (1 - 0.87 / s^2),  s = ln(8 / Re) - 0.077215665    Re <= 1
    Cd = 1.45 + 8.55 Re^-0.9                                        1 < Re <= 30
    Cd = 1.1 + 4 Re^-0.5                                           30 < Re <= 1e5

Its pieces do not meet (2 % apart at 1, 1 % at 30): over a fifth of Re about these they are led into each other, so that
the drag has no jump. Beyond 1e5 the last one goes on, without the fall of the drag that real cylinders have there. Its
two coefficients are factors on the law.
"""

import numpy as np

from codend.compiled import njit
from codend.net.net import Floats

DRAG_LAWS = ("le-bris-1999", "bessonneau-1997", "choo-casarella-1971")
"""Their names; a law's number is its place here."""
LE_BRIS_1999, BESSONNEAU_1997, CHOO_CASARELLA_1971 = range(3)


def drag(law: str, normal: float, tangential: float) -> tuple[int, float, float]:
    """Number of a law and its coefficients, for ``Net.from_bars``.

    Raises:
        ValueError: there is no such law.
    """
    if law not in DRAG_LAWS:
        raise ValueError(f"unknown drag law {law!r}: there are {', '.join(DRAG_LAWS)}")
    return DRAG_LAWS.index(law), normal, tangential


SLOWEST = 1e-12
"""Reynolds number under which a law in it is taken at it: there is no drag left."""
MEETING = 0.2
"""Width over which two pieces of a law are led into each other, in ln Re."""


@njit(cache=True, error_model="numpy")
def drag_factors(
    law: int, normal: float, tangential: float, across: float, along: float, reynolds: float
) -> tuple[float, float, float, float, float, float]:
    """A and C of a law, m/s, and their derivatives: A by |Vn| and |Vt|, then C by both.

    Args:
        law: its place in ``DRAG_LAWS``.
        normal: its first coefficient.
        tangential: its second one.
        across: |Vn|, m/s.
        along: |Vt|, m/s.
        reynolds: Reynolds number per speed, d / nu, s/m.
    """
    if law == LE_BRIS_1999:
        friction = tangential * normal
        return normal * across, friction * along, normal, 0.0, 0.0, friction
    if law == BESSONNEAU_1997:
        speed = np.sqrt(across * across + along * along)
        if speed == 0.0:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        by_across, by_along = across / speed, along / speed
        return (
            normal * speed,
            tangential * speed,
            normal * by_across,
            normal * by_along,
            tangential * by_across,
            tangential * by_along,
        )
    number = max(reynolds * across, SLOWEST)
    coefficient, slope = _choo_casarella(number)
    root, third = np.sqrt(number), np.cbrt(number)
    friction = 2.0 * np.pi * tangential / reynolds
    return (
        normal * coefficient * across,
        friction * (0.55 * root + 0.084 * third * third),
        normal * (coefficient + slope * number),
        0.0,
        friction * (0.275 / root + 0.056 / third) * reynolds,
        0.0,
    )


@njit(cache=True, error_model="numpy")
def _choo_casarella(number: float) -> tuple[float, float]:
    """Drag coefficient at a Reynolds number, and its derivative by it."""
    logarithm = np.log(number)
    slow, middle, fast = 0.0, 0.0, 0.0
    slow_slope, middle_slope, fast_slope = 0.0, 0.0, 0.0
    # how far it is from each piece to the next, 0 to 1
    first, second = logarithm / MEETING + 0.5, (logarithm - np.log(30.0)) / MEETING + 0.5
    if first < 1.0:
        s = np.log(8.0) - 0.077215665 - logarithm
        slow = 8.0 * np.pi / (number * s) * (1.0 - 0.87 / (s * s))
        slow_slope = -slow / number + 8.0 * np.pi / (number * number * s * s) * (1.0 - 3.0 * 0.87 / (s * s))
    if first > 0.0 and second < 1.0:
        middle = 1.45 + 8.55 * number**-0.9
        middle_slope = -0.9 * 8.55 * number**-1.9
    if second > 0.0:
        fast = 1.1 + 4.0 / np.sqrt(number)
        fast_slope = -2.0 * number**-1.5
    if first <= 0.0:
        return slow, slow_slope
    if first < 1.0:
        # the cubic that leaves and arrives level
        share, share_slope = first * first * (3.0 - 2.0 * first), 6.0 * first * (1.0 - first) / (MEETING * number)
        return slow + share * (middle - slow), (
            slow_slope + share * (middle_slope - slow_slope) + share_slope * (middle - slow)
        )
    if second <= 0.0:
        return middle, middle_slope
    if second < 1.0:
        share, share_slope = second * second * (3.0 - 2.0 * second), 6.0 * second * (1.0 - second) / (MEETING * number)
        return middle + share * (fast - middle), (
            middle_slope + share * (fast_slope - middle_slope) + share_slope * (fast - middle)
        )
    return fast, fast_slope


@njit(cache=True)
def drag_factors_of(
    law: int, normal: float, tangential: float, across: Floats, along: Floats, reynolds: float
) -> Floats:
    """``drag_factors`` for many velocities, (6, n)."""
    factors = np.empty((6, len(across)))
    for i in range(len(across)):
        one = drag_factors(law, normal, tangential, across[i], along[i], reynolds)
        for j in range(6):
            factors[j, i] = one[j]
    return factors
