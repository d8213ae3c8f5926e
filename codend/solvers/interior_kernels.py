"""Steps of the interior-point method: kernels.

With s a bar's slackness and q its force density, the equations are s = q / EA - (1/l0 - 1/l) and s q = b, the barrier.
Linearised, s (q + dq) + q ds = b; both may go as far as the first of them falls to nothing (Nocedal and Wright,
Numerical Optimization, 2006, equations 19.12 and 19.9), each on its own way.
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.newton_state import State
from codend.mechanics.newton_step import Step
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.net.net import Floats


@njit(cache=True, error_model="numpy")
def begin(structure: Structure, barrier: float, least: float, state: State) -> None:
    """Write the slackness to begin with: what a bar is short of, at least ``least`` and what its density asks for."""
    flexibilities, rests = structure.flexibility, structure.length
    for bar in range(len(rests)):
        density, length = state.density[bar], max(state.length[bar], 1e-6 * rests[bar])
        short = flexibilities[bar] * density - 1.0 / rests[bar] + 1.0 / length
        state.slack[bar] = max(short, least, barrier / density)


@njit(cache=True, error_model="numpy")
def shift_by_pull(structure: Structure, pattern: Pattern, density: Floats, shift: float, blocks: Floats) -> None:
    """Add to the tangent, at every node, ``shift`` times the force densities that meet there.

    Netting all but slack is then held back as much as netting that is tight, and neither more than its own pull does.
    """
    firsts, seconds, diagonal = structure.first, structure.second, pattern.diagonal
    for bar in range(len(density)):
        stiffness = shift * abs(density[bar])
        for i in range(3):
            blocks[diagonal[firsts[bar]], i, i] += stiffness
            blocks[diagonal[seconds[bar]], i, i] += stiffness


@njit(cache=True, error_model="numpy")
def ways_to_nothing(
    structure: Structure, barrier: float, state: State, step: Step, loosening: Floats
) -> tuple[float, float]:
    """Write the change of the slackness, (m,).

    Returns:
        shares of the step at which the first slackness, and the first force density, falls to nothing.
    """
    to_tight, to_slack = np.inf, np.inf
    for bar in range(len(loosening)):
        loosening[bar] = 0.0
        if structure.is_strut[bar]:
            continue
        density, change, slack = state.density[bar], step.change[bar], state.slack[bar]
        loosening[bar] = (barrier - slack * (density + change)) / density
        if change < 0.0:
            to_slack = min(to_slack, -density / change)
        if loosening[bar] < 0.0:
            to_tight = min(to_tight, -slack / loosening[bar])
    return to_tight, to_slack


@njit(cache=True, error_model="numpy")
def go(state: State, step: Step, loosening: Floats, of_shape: float, of_pull: float, new: State) -> None:
    """Write positions, slackness and densities shares of a step away; struts pull as their shape goes."""
    for node in range(len(state.position)):
        for i in range(3):
            new.position[node, i] = state.position[node, i] + of_shape * step.move[node, i]
    for bar in range(len(loosening)):
        new.density[bar] = state.density[bar] + of_pull * step.change[bar]
        new.slack[bar] = state.slack[bar] + of_shape * loosening[bar]


@njit(cache=True, error_model="numpy")
def largest_force(structure: Structure, state: State) -> float:
    """Largest out-of-balance force of a free node, N."""
    largest = 0.0
    for node in range(len(state.force)):
        squares = 0.0
        for i in range(3):
            squares += structure.free[node, i] * state.force[node, i] ** 2
        largest = max(largest, squares)
    return float(np.sqrt(largest))
