"""The catch's pressure apart from codends: on a sphere, and in a ring of bars."""

from functools import cache, partial

import numpy as np
import pandas as pd
from scipy.integrate import quad

from catch_models.pressure import UNIFORM_COEFFICIENT, sphere_law
from codend.mechanics import pressure
from codend.report.style import BLUE, INK, ORANGE, dress, new_figure
from codend.solvers import newton
from codend.solvers.outcome import Solution
from validation.independent_checks.check import (
    Check,
    Convergence,
    Theme,
    convergence_table,
    draw_convergence,
)
from validation.plain_nets import plain_net, plain_problem
from validation.section import Picture

MEASURED = (0.40, 0.50)
"""Drag coefficient of smooth spheres at Reynolds numbers of 1e3 to 2e5, from the curves in Schlichting, Boundary-Layer
Theory, and Hoerner, Fluid-Dynamic Drag, 1965 (0.47): most of it pressure drag."""
STAGNATION_PA = 500.0
RADIUS, WIDTH = 0.5, 0.04
RING_STIFFNESS = 200.0
"""EA of a ring's bars, N: stretched by some 3.5 %."""


# --- sphere ----------------------------------------------------------------------------------------------------------


@cache
def sphere_drag_coefficient() -> float:
    """Pressure drag of a sphere with the shipped curve, over q pi R^2: the integral of Cp sin(2 theta) over 0..pi.

    The constant 1 of the law, the still water inside, adds nothing over a closed surface.
    """
    law = sphere_law()
    pieces = zip(law.angles_rad[:-1], law.angles_rad[1:], strict=True)
    return sum(quad(lambda theta: float(1.0 - law(theta)) * np.sin(2.0 * theta), *ends)[0] for ends in pieces)


def _kernel_error(bands: int) -> float:
    """Of the kernel's load on a sphere of ``bands`` rows of facets from pole to pole, 2 ``bands`` round."""
    theta, azimuth = np.linspace(0.0, np.pi, bands + 1), np.arange(2 * bands) * np.pi / bands
    radius = RADIUS * np.sin(theta)[:, None]
    x = np.broadcast_to(-RADIUS * np.cos(theta)[:, None], (bands + 1, 2 * bands))
    positions = np.stack([x, radius * np.cos(azimuth), radius * np.sin(azimuth)], axis=-1).reshape(-1, 3)
    row, here = np.meshgrid(np.arange(bands), np.arange(2 * bands), indexing="ij")
    a, b = row * 2 * bands + here, row * 2 * bands + (here + 1) % (2 * bands)
    c, d = b + 2 * bands, a + 2 * bands
    facets = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])
    rows, no_bars = np.repeat(np.arange(bands + 1), 2 * bands), np.zeros((0, 2))
    net = plain_net(positions, np.ones_like(positions), no_bars, np.zeros(0), facets=facets)
    problem = plain_problem(net, rows, pressure_law=sphere_law(), stagnation_pressure=STAGNATION_PA, filled=bands)
    force = np.zeros_like(positions)
    pressure.add_force(positions, problem.structure, problem.loading.catch, np.ones(bands), force)
    coefficient = float(force[:, 0].sum()) / (STAGNATION_PA * np.pi * RADIUS**2)
    return abs(coefficient / sphere_drag_coefficient() - 1.0)


# --- ring ------------------------------------------------------------------------------------------------------------


@cache
def ring(bars: int, stiffness: float) -> Solution:
    """Two equal rings of ``bars`` bars with a skin between them, 2 pi ``RADIUS`` long without load, under pressure.

    Modelled is the upper half, its ends free to move along the line they mirror each other at: of the whole ring the
    loads have no resultant that a residual could be told in.
    """
    half = bars // 2
    azimuth = 2.0 * np.pi * np.arange(half + 1) / bars
    start = 0.8 * RADIUS * (1.0 + 0.2 * np.cos(4.0 * azimuth))  # a start that is no circle
    one = np.stack([np.zeros(half + 1), start * np.cos(azimuth), start * np.sin(azimuth)], axis=1)
    here = np.arange(half)
    one_bars = np.stack([here, here + 1], axis=1)
    quadrangle = (here, here + 1, here + half + 2, here + half + 1)
    # both divisions into two triangles, half each: no corner is loaded more than another
    divisions = ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3))
    nodes = np.concatenate([one, one + np.array([WIDTH, 0.0, 0.0])])
    fixed = np.repeat([[True, False, False]], len(nodes), axis=0)
    fixed[[0, half, half + 1, 2 * half + 1], 2] = True
    fixed[[half // 2, half + 1 + half // 2], 1] = True
    net = plain_net(
        nodes,
        fixed,
        np.concatenate([one_bars, one_bars + half + 1]),
        np.full(2 * half, 2.0 * np.pi * RADIUS / bars),
        stiffness=stiffness,
        facets=np.concatenate([np.stack([quadrangle[corner] for corner in three], axis=1) for three in divisions]),
        facet_weight=0.5,
    )
    problem = plain_problem(net, np.repeat([0, 1], half + 1), stagnation_pressure=STAGNATION_PA, filled=1.0)
    solution = newton.solve(problem, 1e-11)
    if not solution.report.outcome.converged:
        raise RuntimeError(solution.report.outcome.value)
    return solution


def polygon(bars: int, stiffness: float) -> tuple[float, float]:
    """Radius of the knots and tension of each of the two rings, N.

    p w 2 r sin(pi/N) cos(pi/N) / 2 on a knot is borne by 2 T sin(pi/N), so T = p (w/2) r cos(pi/N); with the bars'
    length 2 r sin(pi/N) = l (1 + T / EA) that gives r (*derived*). As N grows, T = p (w/2) r and
    r = R (1 + T / EA).
    """
    angle, per_radius = np.pi / bars, UNIFORM_COEFFICIENT * STAGNATION_PA * 0.5 * WIDTH
    length = 2.0 * np.pi * RADIUS / bars
    radius = length / (2.0 * np.sin(angle) - length * per_radius * np.cos(angle) / stiffness)
    return radius, per_radius * radius * np.cos(angle)


def _ring_gap(bars: int, stiffness: float, radius: float, tension: float) -> float:
    found = ring(bars, stiffness)
    radii = np.hypot(found.positions[:, 1], found.positions[:, 2])
    return float(max(np.abs(radii / radius - 1.0).max(), np.abs(found.bar_tension / tension - 1.0).max()))


def _circle_error(stiffness: float, bars: int) -> float:
    """Of radius and tension against a smooth ring."""
    per_radius = UNIFORM_COEFFICIENT * STAGNATION_PA * 0.5 * WIDTH
    radius = RADIUS / (1.0 - RADIUS * per_radius / stiffness)
    return _ring_gap(bars, stiffness, radius, per_radius * radius)


RINGS = (("rigid", np.inf), ("elastic", RING_STIFFNESS))
FAMILIES = (
    Convergence("sphere of facets", _kernel_error, (32, 64, 128, 256), "rows of facets"),
    *(Convergence(f"ring of {name} bars", partial(_circle_error, ea), (16, 32, 64, 128)) for name, ea in RINGS),
)
_MIDDLE, _HALF_RANGE = 0.5 * (MEASURED[1] + MEASURED[0]), 0.5 * (MEASURED[1] - MEASURED[0])

CHECKS = (
    Check(
        f"The pressure drag of a sphere with the shipped Cp curve, a RECONSTRUCTION, is within the measured "
        f"{MEASURED[0]:g} to {MEASURED[1]:g}",
        "Schlichting, Boundary-Layer Theory; Hoerner, Fluid-Dynamic Drag, 1965",
        _HALF_RANGE,
        lambda _: abs(sphere_drag_coefficient() - _MIDDLE),
        f"{{error:.3f}} from the range's middle, {_MIDDLE:g}; allowed {{tolerance:g}}",
    ),
    *FAMILIES[0].checks(
        "Facets laid over a sphere take its pressure drag from the pressure kernel",
        "integral of Cp sin 2θ",
        5e-5,
        0.2,
    ),
    *(
        Check(
            f"Every bar of a regular ring of 48 {name} bars under pressure has the polygon's tension and radius",
            "derived: T = p (w/2) r cos(π/N)",
            1e-8,
            lambda _, ea=ea: _ring_gap(48, ea, *polygon(48, ea)),
        )
        for name, ea in RINGS
    ),
    *(
        check
        for family in FAMILIES[1:]
        for check in family.checks(f"A {family.label} tends to T = p r per unit width", "hoop formula", 5e-4)
    ),
)


def pictures() -> tuple[Picture, ...]:
    """The Cp curve with what it adds to the drag, and the fall of the errors."""
    figure = new_figure(11.0, 4.0)
    curve, errors = figure.subplots(1, 2)
    theta = np.linspace(0.0, np.pi, 361)
    cp = 1.0 - sphere_law()(theta)
    curve.plot(np.degrees(theta), cp, color=INK, label="Cp, shipped (reconstruction)")
    curve.plot(np.degrees(theta), 1.0 - 2.25 * np.sin(theta) ** 2, ":", color=BLUE, label="Cp, potential flow")
    curve.plot(np.degrees(theta), cp * np.sin(2.0 * theta), "--", color=ORANGE, label="Cp sin 2θ, adds up to the drag")
    curve.set(xlabel="θ from the upstream stagnation point (degrees)", ylabel="pressure over ρV²/2", ylim=(-1.3, 1.9))
    curve.set_xticks(np.arange(0, 181, 30))
    dress(curve)
    curve.legend(frameon=False, fontsize="small", loc="upper right")
    draw_convergence(errors, FAMILIES, "bars, or rows of facets")
    caption = (
        f"Left: the pressure curve outside the catch; it is a reconstruction, and its drag coefficient comes to "
        f"{sphere_drag_coefficient():.3f}. Right: errors of the drag of a sphere of facets, and of radius and tension "
        "of rings of bars, against the number of their parts."
    )
    return (Picture("pressure", figure, caption),)


def data() -> dict[str, pd.DataFrame]:
    """What the right panel shows."""
    return {"pressure": convergence_table(FAMILIES, "parts")}


THEME = Theme(
    "Pressure: sphere and ring",
    "The pressure curve that ships is a reconstruction, not a measurement. What can be held against measurements is "
    "its integral: smooth spheres at subcritical Reynolds numbers have a measured drag coefficient of "
    f"{MEASURED[0]:g} to {MEASURED[1]:g}, most of it pressure drag. A ring of bars under pressure, made from the same "
    "bars and facets as the netting, must carry p r per unit width and stretch by it.",
    CHECKS,
    pictures,
    data,
)
