"""Chains of jointed bars against cables: under their weight, in a current, and both.

A cable along the unit tangent t carries its tension F = T t; under a load f per length, dF/ds = -f. The loads are the
wet weight w and the Landweber-Richtmyer drag, R = 1/2 rho V^2 d Cd across the flow (Le Bris et al. 1999, equations 4
and 5; Bessonneau and Marichal 1997, equations 2 and 3). Where no closed form is cited it is *derived* here from that.
"""

from collections.abc import Callable
from functools import cache, partial

import numpy as np
import pandas as pd
from scipy.integrate import OdeSolution, solve_ivp
from scipy.optimize import brentq, root

from codend.mechanics.drag_laws import BESSONNEAU_1997, LE_BRIS_1999
from codend.mechanics.weight import GRAVITY_M_S2
from codend.report.style import dress, new_figure
from codend.solvers import newton
from codend.solvers.outcome import Solution
from validation.chains import AREA_M2, DENSITY_KG_M3, DIAMETER_M, arc, chain
from validation.independent_checks.check import (
    Check,
    Convergence,
    Floats,
    Theme,
    convergence_table,
    draw_convergence,
)
from validation.section import Picture

LENGTH, WATER, SPEED = 1.5, 1000.0, 0.5
NORMAL, FRICTION = 1.36, {LE_BRIS_1999: 0.07, BESSONNEAU_1997: 0.1}
DRAG = 0.5 * WATER * SPEED**2 * DIAMETER_M * NORMAL
WEIGHT = (DENSITY_KG_M3 - WATER) * AREA_M2 * GRAVITY_M_S2
STIFFNESS = 10.0 * WEIGHT * LENGTH
FIRST, LAST = np.zeros(3), np.array([0.9, 0.0, -0.4])
HALF_SPAN = 0.5
TOLERANCE = 1e-12
AFT, DOWN = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])


def _solved(positions: Floats, **options: object) -> Solution:
    """Equilibrium of a chain by Newton's method."""
    solution = newton.solve(chain(positions, water=WATER, **{"speed": SPEED, **options}), TOLERANCE)  # type: ignore[arg-type]
    if not solution.report.outcome.converged:
        raise RuntimeError(solution.report.outcome.value)
    return solution


def _between(bars: int, towards: Floats, **options: object) -> Solution:
    chord = LAST - FIRST
    side = towards - (towards @ chord) / (chord @ chord) * chord
    return _solved(arc(FIRST, LAST, LENGTH, bars, side), held=(0, -1), length=LENGTH, **options)


def _gap(found: Floats, right: Floats) -> float:
    """Largest distance between nodes and the cable at the same arc length, over the length."""
    return float(np.linalg.norm(found - right, axis=1).max() / LENGTH)


# --- weight alone ----------------------------------------------------------------------------------------------------


def catenary(s: Floats, stiffness: float) -> Floats:
    """Points of a cable between ``FIRST`` and ``LAST`` under its weight, at unstretched arc lengths s, (n, 3).

    With H and V the tension's components at the first end (Irvine, Cable Structures, 1981, the elastic catenary):

        x = H s / EA + H/w (asinh(V/H) - asinh((V - w s)/H))
        z = -s (V - w s / 2) / EA - H/w (sqrt(1 + (V/H)^2) - sqrt(1 + ((V - w s)/H)^2))
    """

    def points(pull: Floats, s: Floats) -> tuple[Floats, Floats]:
        h, v = pull
        here = (v - WEIGHT * s) / h
        x = h * s / stiffness + h / WEIGHT * (np.arcsinh(v / h) - np.arcsinh(here))
        z = -s * (v - 0.5 * WEIGHT * s) / stiffness - h / WEIGHT * (np.hypot(1.0, v / h) - np.hypot(1.0, here))
        return x, z

    across, drop = LAST[0] - FIRST[0], FIRST[2] - LAST[2]
    # inextensible: sqrt(L^2 - h^2) = 2 a sinh(d / 2 a)
    chord = np.sqrt(LENGTH**2 - drop**2)
    a = brentq(lambda a: 2.0 * a * np.sinh(0.5 * across / a) - chord, 0.05 * across, 50.0 * across, xtol=1e-15)
    start = WEIGHT * a * np.array([1.0, np.sinh(0.5 * across / a + np.arctanh(drop / LENGTH))])
    end = np.array([LENGTH])
    pull = root(lambda pull: np.ravel(points(pull, end)) - [across, -drop], start, tol=1e-14).x
    x, z = points(pull, s)
    return np.stack([x, np.zeros_like(s), z], axis=1)


def _catenary_error(stiffness: float, bars: int) -> float:
    found = _between(bars, DOWN, speed=0.0, stiffness=stiffness).positions
    return _gap(found, catenary(np.linspace(0.0, LENGTH, bars + 1), stiffness))


# --- current alone ---------------------------------------------------------------------------------------------------


def across_the_current(s: Floats, law: int) -> tuple[Floats, float]:
    """Points of a cable as dense as the water, held across the flow, without friction, and its tension.

    s runs from the middle. The tension is constant and bends the cable as T dphi/ds = R sin^2 phi (Le Bris) or
    R sin phi (Bessonneau), phi between cable and flow. So the cable is a catenary of parameter T/R,

        z = T/R asinh(R s/T),  x = -T/R (sqrt(1 + (R s/T)^2) - 1),

    as known for light cables (Landweber and Protter 1947), or a "catenary of equal strength",

        z = T/R gd(R s/T),  x = -T/R ln cosh(R s/T),  gd(u) = 2 atan(tanh(u/2)).
    """

    def heights(scale: float, s: Floats) -> Floats:
        u = s / scale
        return scale * (np.arcsinh(u) if law == LE_BRIS_1999 else 2.0 * np.arctan(np.tanh(0.5 * u)))

    half = np.array([0.5 * LENGTH])
    scale = float(brentq(lambda scale: heights(scale, half)[0] - HALF_SPAN, 1e-2, 1e2, xtol=1e-15))
    u, end = s / scale, 0.5 * LENGTH / scale
    depth = np.cosh(np.arcsinh(u)) if law == LE_BRIS_1999 else np.log(np.cosh(u))
    most = np.cosh(np.arcsinh(end)) if law == LE_BRIS_1999 else np.log(np.cosh(end))
    return np.stack([scale * (most - depth), np.zeros_like(s), heights(scale, s)], axis=1), DRAG * scale


@cache
def _light(bars: int, law: int) -> Solution:
    below, above = HALF_SPAN * DOWN, -HALF_SPAN * DOWN
    start = arc(below, above, LENGTH, bars, AFT)
    drag = {"normal": NORMAL, "tangential": 0.0, "drag_law": law}
    return _solved(start, held=(0, -1), length=LENGTH, density=WATER, **drag)


def _light_error(law: int, bars: int) -> float:
    right, tension = across_the_current(np.linspace(-0.5, 0.5, bars + 1) * LENGTH, law)
    found = _light(bars, law)
    return max(_gap(found.positions, right), float(np.abs(found.bar_tension / tension - 1.0).max()))


# --- weight and current ----------------------------------------------------------------------------------------------


def load(tangent: Floats, law: int) -> Floats:
    """Weight and drag per length of a cable in the x-z plane along the unit vector ``tangent``, N/m, (2,)."""
    along = tangent[0]
    across = np.array([1.0, 0.0]) - along * tangent
    if law == LE_BRIS_1999:
        drag = np.linalg.norm(across) * across + FRICTION[law] * abs(along) * along * tangent
    else:
        drag = across + FRICTION[law] / NORMAL * along * tangent
    return DRAG * drag - [0.0, WEIGHT]


@cache
def _heavy_cable(law: int) -> Callable[[Floats], Floats]:
    """State (x, z, F_x, F_z) of a heavy cable in a current between ``FIRST`` and ``LAST``, by shooting."""

    def rates(_: float, state: Floats) -> Floats:
        tangent = state[2:] / np.linalg.norm(state[2:])
        return np.concatenate([tangent, -load(tangent, law)])

    def shot(pull: Floats) -> OdeSolution:
        start = np.concatenate([FIRST[[0, 2]], pull])
        return solve_ivp(rates, (0.0, LENGTH), start, "DOP853", dense_output=True, rtol=1e-11, atol=1e-13).sol

    pull = root(lambda pull: shot(pull)(LENGTH)[:2] - LAST[[0, 2]], [0.3 * DRAG, -WEIGHT], tol=1e-12)
    if not pull.success:
        raise RuntimeError(pull.message)
    return shot(pull.x)


def heavy_cable(s: Floats, law: int) -> Floats:
    """Points of that cable at arc lengths s, (n, 3)."""
    x, z, *_ = _heavy_cable(law)(s)
    return np.stack([x, np.zeros_like(s), z], axis=1)


@cache
def _heavy(bars: int, law: int) -> Solution:
    return _between(bars, AFT + DOWN, normal=NORMAL, tangential=FRICTION[law], drag_law=law)


def _heavy_error(law: int, bars: int) -> float:
    return _gap(_heavy(bars, law).positions, heavy_cable(np.linspace(0.0, LENGTH, bars + 1), law))


def critical_angle(law: int) -> float:
    """Angle to the flow at which a towed heavy cable with a free end hangs straight.

    R sin^2 phi = w cos phi (Le Bris; "critical angle", Pode 1951), R sin phi = w cos phi (Bessonneau).
    """
    ratio = WEIGHT / DRAG
    if law == LE_BRIS_1999:
        return float(np.arccos(0.5 * (np.hypot(ratio, 2.0) - ratio)))
    return float(np.arctan(ratio))


def _towed_error(law: int, friction: float) -> float:
    """Of shape and of the tension at the tow point, L (w sin phi + tangential drag)."""
    bars = 16
    s = np.linspace(0.0, LENGTH, bars + 1)[:, None]
    start = s * (0.8 * AFT + 0.6 * DOWN)
    found = _solved(start, normal=NORMAL, tangential=friction, drag_law=law)
    phi = critical_angle(law)
    tangential = friction * (DRAG * np.cos(phi) ** 2 if law == LE_BRIS_1999 else DRAG / NORMAL * np.cos(phi))
    # of the first bar, the half at its upper end hangs on the tow point and not on the bar
    pull = (LENGTH - 0.5 * LENGTH / bars) * (WEIGHT * np.sin(phi) + tangential)
    shape = _gap(found.positions, s * (np.cos(phi) * AFT + np.sin(phi) * DOWN))
    return max(shape, abs(float(found.bar_tension[0]) / pull - 1.0))


LAWS = {LE_BRIS_1999: "Le Bris 1999", BESSONNEAU_1997: "Bessonneau 1997"}
BARS = (20, 40, 80, 160)
FAMILIES = (
    Convergence("catenary", partial(_catenary_error, np.inf), BARS),
    Convergence("elastic catenary", partial(_catenary_error, STIFFNESS), BARS),
    *(Convergence(f"light, {name}", partial(_light_error, law), BARS) for law, name in LAWS.items()),
    *(Convergence(f"heavy, {name}", partial(_heavy_error, law), BARS) for law, name in LAWS.items()),
)
_CLAIMS = (
    ("A chain of rigid bars between two points hangs as a catenary", "catenary, closed form", 2e-5),
    ("A chain of elastic bars hangs as an elastic catenary", "Irvine, Cable Structures, 1981", 2e-5),
    *(
        (f"A chain as dense as the water takes the light cable's shape and tension in a current ({name})", source, 2e-4)
        for name, source in zip(
            LAWS.values(),
            ("Landweber and Protter 1947; derived", "derived: catenary of equal strength"),
            strict=True,
        )
    ),
    *(
        (f"A heavy chain in a current follows the cable equations ({name})", "cable equations, shooting", 5e-5)
        for name in LAWS.values()
    ),
)
CHECKS = (
    *(check for family, claim in zip(FAMILIES, _CLAIMS, strict=True) for check in family.checks(*claim)),
    *(
        Check(
            f"A towed heavy chain hangs straight at the critical angle, {words} ({name})",
            "Pode 1951, R sin²φ = w cos φ" if law == LE_BRIS_1999 else "derived: R sin φ = w cos φ",
            1e-9,
            lambda _, law=law, friction=friction: _towed_error(law, friction),
        )
        for law, name in LAWS.items()
        for words, friction in (("without friction", 0.0), ("with friction", FRICTION[law]))
    ),
)


def pictures() -> tuple[Picture, ...]:
    """Shapes of chains on the cables' curves, and the fall of their errors."""
    figure = new_figure(11.0, 4.4)
    shapes, errors = figure.subplots(1, 2, width_ratios=(1.0, 1.0))
    s, bars = np.linspace(0.0, LENGTH, 201), 20
    middle = s - 0.5 * LENGTH
    curves = [(0, catenary(s, np.inf), _between(bars, DOWN, speed=0.0).positions)]
    curves += [(2 + law, across_the_current(middle, law)[0], _light(bars, law).positions) for law in LAWS]
    curves += [(4 + law, heavy_cable(s, law), _heavy(bars, law).positions) for law in LAWS]
    for family, cable, nodes in curves:
        shapes.plot(cable[:, 0], cable[:, 2], lw=1.2, color=f"C{family}", label=FAMILIES[family].label)
        shapes.plot(nodes[:, 0], nodes[:, 2], "o", ms=3.5, color=f"C{family}")
    shapes.annotate("", (0.95, 0.15), (0.65, 0.15), arrowprops={"arrowstyle": "->"})
    shapes.text(0.8, 0.17, "current", ha="center", fontsize="small")
    shapes.set(xlabel="x, aft (m)", ylabel="z, up (m)", aspect="equal")
    dress(shapes)
    draw_convergence(errors, FAMILIES, "bars in the chain")
    caption = (
        f"Left: chains of {bars} bars (dots) on the cables' own curves (lines), colours as on the right. Right: "
        "largest distance from the cable over its length (of light cables the error of the tension too, if larger) "
        "against the number of bars; the drag law is named."
    )
    return (Picture("cables", figure, caption),)


def data() -> dict[str, pd.DataFrame]:
    """What the right panel shows."""
    return {"cables": convergence_table(FAMILIES, "bars")}


THEME = Theme(
    "Chains and cables",
    f"A chain of {LENGTH:g} m of jointed bars, {1000.0 * DIAMETER_M:g} mm thick and of {DENSITY_KG_M3:g} kg/m³, is "
    "solved by the same Newton's method as the netting and held against the cable it stands for: hung between two "
    f"points, held across a current of {SPEED:g} m/s where it weighs nothing, towed by one end, and under weight and "
    "current together. This checks wet weight, both drag laws and the elastic law apart from netting and catch.",
    CHECKS,
    pictures,
    data,
)
