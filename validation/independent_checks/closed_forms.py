"""Closed forms of a bare bag against the net, over the number of meshes round.

Netting without drag or knots, p uniform, bars inextensible, N large (*derived*, as in
``codend.bag.meridian.shell``): with T the tension of a bar, phi half the opening, a the slope of the meridian and r_c
the radius at the catch's front,

    T cos^2 phi is the same from entry to codline
    cos a = K r^2 cos phi in the catch and K r_c^2 cos phi ahead of it, K = pi p / (2 N T cos^2 phi)
    drag = p pi r_c^2
    hoop over meridional stress = tan^2 phi, and of equilibrium alone 2 + r a' / cos a in the catch, r a' / cos a ahead
    tan^2 phi -> 2 in a long catch, r -> sqrt(2/3) N b / pi

A net of N meshes has a polygon where these have a circle, so they should be off by order 1/N^2.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
import pandas as pd

from codend.report.style import BLUE, INK, ORANGE, dress, new_figure
from validation.independent_checks.bags import PRESSURE_PA, solved
from validation.independent_checks.check import Convergence, Floats, Theme, convergence_table, draw_convergence
from validation.section import Picture

MESHES_ROUND = (40, 80, 160, 320)
FILLED, LONG_CATCH = 0.25, {"filled": 2.5, "long": 2.8}
LEFT_OUT = 0.1
"""Share of the rows, towards the codline, that is left out: there a row has few bars to its radius."""


@dataclass(frozen=True)
class Rows:
    """Rows of a bag as a shell sees them; bands lie between two rows, ``inner`` rows between two bands."""

    cosine: Floats
    """cos phi of every band."""
    tension: Floats
    """Of a bar of every band, N."""
    cos_a: Floats
    radius: Floats
    """In the middle of every band, m."""
    tan2: Floats
    """tan^2 phi at the inner rows."""
    bend: Floats
    """r a' / cos a there."""
    front_radius: float
    aft: np.ndarray
    """Bands in the catch."""
    used: np.ndarray
    """Bands that are looked at."""


@cache
def rows_of(meshes_round: int) -> Rows:
    """Rows of the bag with the given number of meshes round."""
    result = solved(meshes_round, filled=FILLED)
    bag, x, r = result.bag, result.rows.x_m, result.rows.radius_m
    spread = meshes_round * bag.net.bar_length[0] / np.pi
    step, slope = np.hypot(np.diff(x), np.diff(r)), np.arctan2(np.diff(r), np.diff(x))
    middle = 0.5 * (r[1:] + r[:-1])
    bend = r[1:-1] * np.diff(slope) / (0.5 * (step[1:] + step[:-1])) / np.cos(0.5 * (slope[1:] + slope[:-1]))
    band = np.arange(bag.bands)
    front = bag.bands - round(2 * FILLED * meshes_round)
    return Rows(
        cosine=np.sqrt(1.0 - (middle / spread) ** 2),
        tension=np.bincount(bag.bar_band, weights=result.bar_tension_n) / np.bincount(bag.bar_band),
        cos_a=np.cos(slope),
        radius=middle,
        tan2=1.0 / (1.0 - (r[1:-1] / spread) ** 2) - 1.0,
        bend=bend,
        front_radius=float(r[front]),
        aft=band >= front,
        used=band < (1.0 - LEFT_OUT) * bag.bands,
    )


def _constant(rows: Rows) -> Floats:
    return rows.tension * rows.cosine**2


def _tension_error(meshes_round: int) -> float:
    rows = rows_of(meshes_round)
    constant = _constant(rows)[rows.used]
    return float(np.abs(constant / constant.mean() - 1.0).max())


def _slope_error(meshes_round: int) -> float:
    rows = rows_of(meshes_round)
    k = np.pi * PRESSURE_PA / (2.0 * meshes_round * _constant(rows)[rows.used].mean())
    radius = np.where(rows.aft, rows.radius, rows.front_radius)
    return float(np.abs(rows.cos_a / (k * radius**2 * rows.cosine) - 1.0)[rows.used].max())


def _drag_error(meshes_round: int) -> float:
    drag = solved(meshes_round, filled=FILLED).measures.entry_reaction_n
    return abs(drag / (PRESSURE_PA * np.pi * rows_of(meshes_round).front_radius ** 2) - 1.0)


def _stress_error(meshes_round: int) -> float:
    rows = rows_of(meshes_round)
    # at the front's own row the pressure steps, and with it the curvature
    same_side = rows.aft[1:] == rows.aft[:-1]
    found = rows.tan2 - rows.bend - 2.0 * rows.aft[:-1]
    return float(np.abs(found)[same_side & rows.used[1:]].max())


def _long_error(of_radius: bool, meshes_round: int) -> float:
    result = solved(meshes_round, **LONG_CATCH)
    middle = result.bag.bands - round(LONG_CATCH["filled"] * meshes_round)
    if of_radius:
        limit = np.sqrt(2.0 / 3.0) * meshes_round * result.net.bar_length[0] / np.pi
        return abs(float(result.rows.radius_m[middle]) / limit - 1.0)
    opening = np.interp(middle, *_known(result.rows.opening_deg))
    return abs(float(np.tan(np.radians(opening) / 2.0) ** 2) / 2.0 - 1.0)


def _known(values: Floats) -> tuple[Floats, Floats]:
    there = np.flatnonzero(np.isfinite(values))
    return there.astype(float), values[there]


_FORMS: tuple[tuple[str, str, Callable[[int], float], float], ...] = (
    ("T cos²φ", "T cos²φ is the same from entry to codline", _tension_error, 2e-5),
    ("cos a", "cos a = K r² cos φ in the catch and K r_c² cos φ ahead", _slope_error, 1e-4),
    ("drag", "The drag is p π r_c², r_c at the front", _drag_error, 1e-4),
    ("stress ratio", "Hoop over meridional stress, found from the shape alone, is tan²φ", _stress_error, 5e-4),
    ("tan²φ = 2", "tan²φ tends to 2 in a long catch", partial(_long_error, False), 5e-5),
    ("radius", "The radius tends to √(2/3) N b / π in a long catch", partial(_long_error, True), 1e-5),
)
FAMILIES = tuple(Convergence(label, error, MESHES_ROUND, "meshes round") for label, _, error, _ in _FORMS)
CHECKS = tuple(
    check
    for family, (_, claim, _, tolerance) in zip(FAMILIES, _FORMS, strict=True)
    for check in family.checks(claim, "derived, membrane of bars", tolerance, 0.1)
)


def pictures() -> tuple[Picture, ...]:
    """Both stress ratios along one bag, and the fall of all errors with the number of meshes."""
    figure = new_figure(11.0, 4.2)
    along, errors = figure.subplots(1, 2)
    rows = rows_of(MESHES_ROUND[0])
    place = np.arange(1, len(rows.tan2) + 1) / 2.0
    shown = rows.used[1:]
    along.plot(place[shown], rows.tan2[shown], color=INK, label="tan²φ of the net's meshes")
    forced = (rows.bend + 2.0 * rows.aft[:-1])[shown]
    along.plot(place[shown], forced, ".", color=ORANGE, ms=5, label="hoop over meridional stress, of the shape alone")
    along.axhline(2.0, color=BLUE, ls=":", label="limit in a long catch")
    along.axvline(place[np.argmax(rows.aft)] - 0.5, ymax=0.6, color=INK, lw=0.8, ls="--", label="front of the catch")
    along.set(xlabel=f"meshes from the entry ({MESHES_ROUND[0]} meshes round)", ylabel="hoop over meridional stress")
    along.set_ylim(0.0, 3.0)
    dress(along)
    along.legend(frameon=False, fontsize="small", loc="upper left")
    draw_convergence(errors, FAMILIES, "meshes round")
    caption = (
        "Left: the opening of the net's meshes beside what equilibrium asks of them, found from the curvature of the "
        "meridian. Right: largest relative departure from each closed form against the number of meshes round."
    )
    return (Picture("closed_forms", figure, caption),)


def data() -> dict[str, pd.DataFrame]:
    """What the right panel shows."""
    return {"closed_forms": convergence_table(FAMILIES, "meshes_round")}


THEME = Theme(
    "Closed forms of a bare bag",
    "Under uniform pressure, without drag and with inextensible bars, a bag of many meshes is a membrane with first "
    "integrals. The net of bars, a sector of it solved by Newton's method, must come to them as its meshes become "
    f"smaller. The last {100.0 * LEFT_OUT:g} % of the rows, at the codline, are left out.",
    CHECKS,
    pictures,
    data,
)
