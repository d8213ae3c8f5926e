"""Bars that stretch in motion: the length that a step's tension gives them at its end.

With its strains e', e, e" after a step, before it and a step earlier, a bar of tension T over the step has

    T / EA = b e' + (1/2 - 2 b + c) e + (1/2 + b - c) e",   c = 1/2 + s,  b = (1 + s)^2 / 4

(Newmark's method in terms of places), stable for any step; s damps what swings faster than the steps.
"""

import numpy as np

from codend.mechanics.bars import carried
from codend.mechanics.structure import Structure
from codend.net.net import Floats

DAMPING = 0.1
"""s: it takes 2 s x (frequency x step) / 4 of a swing's amplitude a radian, and all from steps far longer on."""
LEAST_LENGTH = 0.5
"""What a bar is asked for at least, over its length."""


class Stretching:
    """Strains of a net's bars, and the lengths they are to have."""

    def __init__(self, structure: Structure, length: Floats) -> None:
        """Set it out for bars that have been as long as they are, (m,)."""
        strain = self._strains(structure, length)
        self.strain = np.stack([strain, strain])
        """Of the bars now and a step earlier, 0 in slack ones, (2, m)."""
        self.give = np.zeros(len(length))
        """A step's strain by its force density, m/N, (m,)."""
        self._rest, self._known = structure.length, np.zeros(len(length))

    def begin(self, structure: Structure, square: Floats) -> None:
        """Start a step of bars whose squared lengths are (m,)."""
        weights = _weights(DAMPING)
        self._rest = structure.length
        self._known = (weights[1] * self.strain[0] + weights[2] * self.strain[1]) / weights[0]
        self.give = structure.flexibility * np.sqrt(square) / weights[0]

    def aims(self, density: Floats | float) -> Floats:
        """Lengths of the bars at the end of the step under force densities, N/m, m, (m,)."""
        return np.maximum(self._rest * (1.0 + self.give * density - self._known), LEAST_LENGTH * self._rest)

    def note(self, structure: Structure, length: Floats) -> None:
        """Take the lengths at the end of a step, (m,)."""
        self.strain[1] = self.strain[0]
        self.strain[0] = self._strains(structure, length)

    @staticmethod
    def _strains(structure: Structure, length: Floats) -> Floats:
        stretched = np.where(structure.flexibility > 0.0, length / structure.length - 1.0, 0.0)
        return np.asarray(carried(structure.is_strut, stretched))


def _weights(damping: float) -> tuple[float, float, float]:
    c, b = 0.5 + damping, 0.25 * (1.0 + damping) ** 2
    return b, 0.5 - 2.0 * b + c, 0.5 + b - c
