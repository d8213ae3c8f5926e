"""What it takes to hold the nodes of a net in equilibrium."""

import numpy as np

from codend.mechanics.bars import add_bar_forces, bar_lengths
from codend.mechanics.loads import add_force
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.outcome import Solution


def loads_and_supports(problem: Problem, solution: Solution) -> tuple[Floats, Floats]:
    """Loads on the nodes, the twine's bending among them, and what it takes to hold each node so, N, each (n, 3).

    The latter is what a support carries, and at a free node what the solver leaves out of balance.
    """
    position, structure = np.ascontiguousarray(solution.positions), problem.structure
    load, length = np.zeros_like(position), np.empty(len(problem.net.bars))
    add_force(position, structure, problem.loading, solution.share, load)
    bar_lengths(position, structure, length)
    density = np.divide(solution.bar_tension, length, out=np.zeros_like(length), where=length > 0.0)
    total = load.copy()
    add_bar_forces(position, structure, density, total)
    return load, -total
