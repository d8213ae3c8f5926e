"""Chains of bars, built by hand: nets of one column whose shape and motion have closed forms."""

from collections.abc import Sequence

import numpy as np

from codend.mechanics.problem import Problem
from codend.net.net import Floats
from validation.plain_nets import plain_net, plain_problem

DIAMETER_M, DENSITY_KG_M3 = 0.01, 3000.0
AREA_M2 = np.pi * DIAMETER_M**2 / 4
MASS_PER_METRE = DENSITY_KG_M3 * AREA_M2


def chain(
    positions: Floats,
    *,
    held: Sequence[int] = (0,),
    length: float | None = None,
    stiffness: float = np.inf,
    density: float = DENSITY_KG_M3,
    tangential: float = 0.07,
    **flow: float,
) -> Problem:
    """A chain through ``positions`` (n, 3), z upwards, under its weight in water and the drag of a current along x.

    Args:
        positions: nodes in the shape in which a solver starts.
        held: nodes that do not move; a negative number counts from the end.
        length: of the whole chain in equal bars without load, m; left out, bars are as long as ``positions`` has them.
        stiffness: EA of a bar, N.
        density: of the bars, kg/m3.
        tangential: f or Cf of the drag law.
        flow: water, current and drag law, see ``plain_problem``.
    """
    count = np.arange(len(positions))
    bars = np.stack([count[:-1], count[1:]], axis=1)
    fixed = np.zeros((len(positions), 3), dtype=bool)
    fixed[list(held)] = True
    as_laid = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    bar_length = as_laid if length is None else np.full(len(bars), length / len(bars))
    net = plain_net(positions, fixed, bars, bar_length, stiffness=stiffness, diameter=DIAMETER_M, density=density)
    return plain_problem(net, count, tangential=tangential, **flow)  # type: ignore[arg-type]


def arc(first: Floats, last: Floats, length: float, bars: int, towards: Floats) -> Floats:
    """Nodes of a start for a chain between two points: a circular arc that bulges ``towards`` a side, (n, 3).

    Args:
        first: one end, (3,).
        last: the other end, nearer than ``length``.
        length: of the arc, m.
        bars: n - 1.
        towards: side to which it bulges, normal to the chord, (3,).
    """
    from scipy.optimize import brentq

    chord = last - first
    span = float(np.linalg.norm(chord))
    half = float(brentq(lambda angle: np.sinc(angle / np.pi) - span / length, 1e-9, np.pi - 1e-9))
    angle = np.linspace(-half, half, bars + 1)
    radius = length / (2.0 * half)
    along = radius * np.sin(angle) + 0.5 * span
    across = radius * (np.cos(angle) - np.cos(half))
    bulge = towards / np.linalg.norm(towards)
    return np.asarray(first + along[:, None] * chord / span + across[:, None] * bulge)
