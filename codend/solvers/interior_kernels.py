"""Steps of the interior-point method: kernels.

With L the length that a bar of force density q has under its own pull, 1/L = 1/l0 - q/EA, the equations of a bar are
s = (L^2 - l^2) / 2, its slackness, and s q = b, its barrier. Halves of squares are taken because the force density is
then the multiplier of what keeps the bar short, and a step that turns the bar by v leaves just v^2 / 2 of it: without
bending and under loads that stay as they are the whole is convex. Linearised, s (q + dq) + q ds = b, and a step may go
as far as the first of s and q falls to nothing (Nocedal and Wright, Numerical Optimization, 2006, equations 19.12 and
19.9). What a whole step leaves, of s q the product ds dq, of the squares v^2 / 2, may be mended with the same factors
(equation 16.67 there, of quadratic programs: the corrector).
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.bars import bar_vector
from codend.mechanics.bending import add_bound
from codend.mechanics.newton_state import State
from codend.mechanics.newton_step import Step
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats

MOST_STRETCH = 0.9
"""Of the force density that would stretch a bar without end (EA / l0), beyond which the square of its length is led on
straight: on the way alone, for no answer has twine of ten times its length."""


@njit(cache=True, error_model="numpy")
def own_square(flexibility: float, rest: float, density: float) -> tuple[float, float]:
    """L^2 of a bar under its own pull, and half its derivative by the force density."""
    most = MOST_STRETCH / max(flexibility * rest, 1e-300)
    length = rest / (1.0 - flexibility * rest * min(density, most))
    slope = length**3 * flexibility
    return length * length + 2.0 * slope * max(density - most, 0.0), slope


@njit(cache=True, error_model="numpy")
def begin(structure: Structure, barrier: float, least: float, state: State) -> None:
    """Write the slackness to begin with: what a bar is short of, at least ``least`` l0^2 and what its density asks for.

    ``barrier`` is over the bar's rest length here and below, N.
    """
    for bar in range(len(state.slack)):
        rest, density = structure.length[bar], state.density[bar]
        square, _ = own_square(structure.flexibility[bar], rest, density)
        short = 0.5 * (square - state.length[bar] ** 2)
        state.slack[bar] = max(short, least * rest**2, barrier * rest / density)


@njit(cache=True, error_model="numpy")
def strain(structure: Structure, barrier: float, state: State, softness: Floats) -> float:
    """Write what every bar is too long for the barrier as ``gap``, and how it yields to a step, 1/N, (m,).

    Both as ``newton_step`` takes them, for which they are divided by l^3.

    Returns:
        the largest departure from a bar's law, over the square of its length.
    """
    worst = 0.0
    for bar in range(len(softness)):
        rest, density = structure.length[bar], state.density[bar]
        length = max(state.length[bar], 1e-6 * rest)
        square, yields = own_square(structure.flexibility[bar], rest, density)
        long = 0.5 * (length * length - square)
        if structure.is_strut[bar]:
            worst = max(worst, abs(long) / rest**2)
        else:
            worst = max(worst, abs(long + state.slack[bar]) / rest**2)
            yields += state.slack[bar] / density
            long += barrier * rest / density
        state.gap[bar], softness[bar] = long / length**3, yields / length**3
    return worst


@njit(cache=True, error_model="numpy")
def shift_by_resistance(structure: Structure, pattern: Pattern, state: State, shift: float, blocks: Floats) -> None:
    """Add to the tangent, at every node, ``shift`` times what pull and bending of the bars that meet there resist.

    Netting all but slack is then held back as much as netting that is tight, and neither more than its own pull does.
    """
    firsts, seconds, diagonal = structure.first, structure.second, pattern.diagonal
    resistance = np.zeros(len(state.position))
    for bar in range(len(firsts)):
        pull = abs(state.density[bar])
        resistance[firsts[bar]] += pull
        resistance[seconds[bar]] += pull
    add_bound(state.position, structure, resistance)
    for node in range(len(resistance)):
        for i in range(3):
            blocks[diagonal[node], i, i] += shift * resistance[node]


@njit(cache=True, error_model="numpy")
def largest_turn(structure: Structure, state: State, step: Step) -> float:
    """Largest change of a bar's vector in a step, over its length, or its rest length where it is shorter.

    Slack knots shrink to next to nothing, and which way they lie does not matter.
    """
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    largest = 0.0
    for bar in range(len(firsts)):
        dx, dy, dz = bar_vector(step.move, firsts[bar], seconds[bar], images[bar], rotations)
        largest = max(largest, np.sqrt(dx * dx + dy * dy + dz * dz) / max(state.length[bar], structure.length[bar]))
    return largest


@njit(cache=True, error_model="numpy")
def loosen(structure: Structure, barrier: float, state: State, there: State, change: Floats, loosening: Floats) -> None:
    """Add the change of the slackness, (m,), by a step from ``there``, by the linearisation in ``state``."""
    for bar in range(len(loosening)):
        if structure.is_strut[bar]:
            continue
        density, slack = state.density[bar], state.slack[bar]
        left = slack * density - there.slack[bar] * there.density[bar]
        loosening[bar] += (barrier * structure.length[bar] - slack * (density + change[bar]) + left) / density


@njit(cache=True, error_model="numpy")
def way_to_nothing(structure: Structure, state: State, change: Floats, loosening: Floats) -> float:
    """Share of a step at which the first slackness or density is 0."""
    share = np.inf
    for bar in range(len(loosening)):
        if structure.is_strut[bar]:
            continue
        if change[bar] < 0.0:
            share = min(share, -state.density[bar] / change[bar])
        if loosening[bar] < 0.0:
            share = min(share, -state.slack[bar] / loosening[bar])
    return share


@njit(cache=True, error_model="numpy")
def left_of_bars(structure: Structure, barrier: float, state: State, there: State) -> None:
    """Write what is left of the bars' equations in ``there`` as its ``gap``, to be mended by ``state``'s linearisation.

    That may be past where the first slackness or density is 0.
    """
    for bar in range(len(there.gap)):
        rest, density, slack = structure.length[bar], there.density[bar], there.slack[bar]
        square, _ = own_square(structure.flexibility[bar], rest, density)
        long = 0.5 * (there.length[bar] ** 2 - square)
        if not structure.is_strut[bar]:
            long += slack + (barrier * rest - slack * density) / state.density[bar]
        there.gap[bar] = long / max(state.length[bar], 1e-6 * rest) ** 3


@njit(cache=True, error_model="numpy")
def go(state: State, step: Step, loosening: Floats, share: float, new: State) -> None:
    """Write positions, slackness and densities a share of a step away."""
    for node in range(len(state.position)):
        for i in range(3):
            new.position[node, i] = state.position[node, i] + share * step.move[node, i]
    for bar in range(len(loosening)):
        new.density[bar] = state.density[bar] + share * step.change[bar]
        new.slack[bar] = state.slack[bar] + share * loosening[bar]


@njit(cache=True, error_model="numpy")
def reached_barrier(structure: Structure, state: State) -> float:
    """Mean of slackness times force density over the rest length, of twine, N."""
    total, count = 0.0, 0
    for bar in range(len(state.slack)):
        if not structure.is_strut[bar]:
            total += state.slack[bar] * state.density[bar] / structure.length[bar]
            count += 1
    return total / max(count, 1)


@njit(cache=True, error_model="numpy")
def largest_force(structure: Structure, force: Floats) -> float:
    """Largest force on a free node, N, of those on all, (n, 3)."""
    largest = 0.0
    for node in range(len(force)):
        squares = 0.0
        for i in range(3):
            squares += structure.free[node, i] * force[node, i] ** 2
        largest = max(largest, squares)
    return float(np.sqrt(largest))
