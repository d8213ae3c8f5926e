"""Hanging chains whose motion has closed forms: a pendulum, and small swings of a chain."""

import numpy as np

from codend.mechanics.problem import Problem
from codend.mechanics.weight import GRAVITY_M_S2
from validation.chains import MASS_PER_METRE, chain


def pendulum(angle: float, length: float = 1.0, **options: float) -> Problem:
    """One bar turned by ``angle`` from the vertical in the x-z plane."""
    return chain(np.array([[0.0, 0.0, 0.0], [length * np.sin(angle), 0.0, -length * np.cos(angle)]]), **options)  # type: ignore[arg-type]


def hanging(bars: int, length: float = 1.0, displacement: np.ndarray | None = None) -> np.ndarray:
    """Nodes of a chain of ``bars`` equal bars hung from the origin, moved along x by ``displacement``, (bars + 1,)."""
    x = np.zeros(bars + 1) if displacement is None else displacement
    drop = np.sqrt((length / bars) ** 2 - np.diff(x) ** 2)
    return np.stack([x, np.zeros(bars + 1), -np.concatenate([[0.0], np.cumsum(drop)])], axis=1)


def small_swings(bars: int, length: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, rad/s, and modes of the chain's masses: half a bar at its free end, a bar at every other node."""
    from scipy.linalg import eigh

    b = length / bars
    mass = MASS_PER_METRE * b * np.append(np.ones(bars - 1), 0.5)
    pull = GRAVITY_M_S2 * np.cumsum(mass[::-1])[::-1] / b
    stiffness = np.diag(pull + np.append(pull[1:], 0.0)) - np.diag(pull[1:], 1) - np.diag(pull[1:], -1)
    squares, modes = eigh(stiffness, np.diag(mass))
    return np.sqrt(squares), np.concatenate([np.zeros((1, bars)), modes / modes[-1]])
