"""Where Newton's method on shape and force densities stands, and how far that is from equilibrium: kernels.

With gap = 1/l0 - 1/l, a bar is taut where q + w (gap - q / EA) > 0, for any w > 0 (in newtons); then gap = q / EA must
hold, else q = 0: together that is the law of twine that carries no compression (a semismooth complementarity problem).
With a barrier b > 0 (in N/m2) all bars stay taut and the law is (q / EA - gap) q = b, which tends to it as b does to 0.
For struts, which carry compression, gap = q / EA holds whatever the sign of q, and no barrier.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.balance import out_of_balance
from codend.mechanics.bars import add_bar_forces, bar_lengths, bar_vector
from codend.mechanics.catch_front import fill
from codend.mechanics.loads import Loading, add_force
from codend.mechanics.structure import Structure
from codend.net.net import Floats

MARKS = np.dtype([(name, np.float64) for name in ("merit", "residual", "imbalance", "length_error", "fits", "lowest")])
"""Named numbers of a state that kernels write; ``fits`` is 1 if the catch fits into the net, ``lowest`` the largest
compression of twine, N, below 0, or 0."""
LENGTH_WEIGHT = 10.0
"""Force, in units of the reference tension, that a bar's strain of 1 counts as in the merit."""


class State(NamedTuple):
    """A shape with its tensions, and what is left of them out of balance."""

    position: Floats
    density: Floats
    """Force densities q, N/m, (m,); exactly 0 in slack bars, below 0 in struts that are pushed."""
    gap: Floats
    """1/l0 - 1/l - q / EA of the bars that count as taut, 0 for the others, 1/m, (m,); with a barrier b plus b / q."""
    length: Floats
    slack: Floats
    """In the interior: what a bar is taken to be short of its length (``interior_kernels``), m2, (m,); not written by
    ``measure``."""
    share: Floats
    force: Floats
    """Out-of-balance force of the nodes, N, (n, 3)."""
    load: Floats
    marks: NDArray[np.void]
    """What was found of it, see ``MARKS``, (1,)."""

    @property
    def residual(self) -> float:
        """Largest out-of-balance force of a free node, relative (``balance.out_of_balance``)."""
        return float(self.marks["residual"][0])

    @property
    def imbalance(self) -> float:
        """Axial sum of the out-of-balance forces, likewise."""
        return float(self.marks["imbalance"][0])

    @property
    def length_error(self) -> float:
        """Largest departure of a bar from the law of its twine, relative to its length."""
        return float(self.marks["length_error"][0])


def empty_state(structure: Structure, bands: int) -> State:
    """Arrays for a state of a net with a catch that fills so many bands."""
    nodes, bars = len(structure.free), len(structure.first)
    at_nodes, at_bars = (nodes, 3), (bars,)
    return State(
        np.zeros(at_nodes),
        np.zeros(at_bars),
        np.zeros(at_bars),
        np.zeros(at_bars),
        np.zeros(at_bars),
        np.zeros(bands),
        np.zeros(at_nodes),
        np.zeros(at_nodes),
        np.zeros(1, dtype=MARKS),
    )


@njit(cache=True, error_model="numpy")
def take_over(structure: Structure, position: Floats, tension: Floats, state: State) -> None:
    """Write a shape, (n, 3), and the force densities of its tensions, (m,): 0 of bars that are shrunk to nothing."""
    state.position[:] = position
    bar_lengths(position, structure, state.length)
    for bar in range(len(tension)):
        state.density[bar] = tension[bar] / state.length[bar] if state.length[bar] > 0.0 else 0.0


@njit(cache=True, error_model="numpy")
def measure(
    structure: Structure, loading: Loading, tension: float, switch: float, barrier: float, state: State
) -> None:
    """Cut the density of twine that is slack, and write all that follows from positions and densities.

    The merit is the root of the sum of the squares of the free out-of-balance forces and of the bars' strain errors
    times ``LENGTH_WEIGHT`` x ``tension`` (or the bar's own stiffness if less).

    Args:
        structure: the net.
        loading: what acts on it.
        tension: reference tension, N.
        switch: the w in the test for taut bars, in units of the reference tension. Any positive value gives the same
            answer; a small one lets bars go slack only as their tension passes through 0.
        barrier: 0, or what keeps twine from going slack, N/m2; all its densities must be above 0 then.
        state: positions and densities; the rest of it is written.
    """
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    rests, flexibilities, struts = structure.length, structure.flexibility, structure.is_strut
    position, density, gaps, lengths = state.position, state.density, state.gap, state.length
    force, load, free = state.force, state.load, structure.free
    merit, worst, total, lowest = 0.0, 0.0, 0.0, 0.0
    for bar in range(len(density)):
        dx, dy, dz = bar_vector(position, firsts[bar], seconds[bar], images[bar], rotations)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        rest = rests[bar]
        weight = 1.0 / max(flexibilities[bar], 1.0 / (LENGTH_WEIGHT * tension))
        gap = 1.0 / rest - 1.0 / max(length, 1e-6 * rest) - flexibilities[bar] * density[bar]
        if not struts[bar]:
            if barrier > 0.0:
                gap += barrier / density[bar]
            elif density[bar] + min(weight, switch * tension) * gap <= 0.0:
                density[bar] = gap = 0.0
        lengths[bar], gaps[bar] = length, gap
        total += abs(density[bar]) * length
        if not struts[bar]:
            lowest = min(lowest, density[bar] * length)
        error = abs(gap) * length
        worst = max(worst, error)
        merit += (weight * error) ** 2
    fits = fill(position, structure, loading.catch, state.share)
    load[:] = 0.0
    add_force(position, structure, loading, state.share, load)
    for node in range(len(force)):
        for i in range(3):
            force[node, i] = load[node, i]
    add_bar_forces(position, structure, density, force)
    for node in range(len(force)):
        for i in range(3):
            merit += free[node, i] * force[node, i] ** 2
    residual, imbalance = out_of_balance(structure, force, load, total / max(len(density), 1))
    marks = state.marks[0]
    marks.merit, marks.residual, marks.imbalance = np.sqrt(merit), residual, imbalance
    marks.length_error, marks.fits, marks.lowest = worst, 1.0 if fits else 0.0, lowest
