"""What it takes to hold the nodes of a net in equilibrium."""

import numpy as np

from codend.mechanics import loads
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.outcome import Solution


def loads_and_supports(problem: Problem, solution: Solution) -> tuple[Floats, Floats]:
    """Loads on the nodes, and what it takes to hold each node so, N, each (n, 3); see ``loads.loads_and_supports``."""
    position = np.ascontiguousarray(solution.positions)
    arguments = problem.structure, problem.loading, position, solution.bar_tension, solution.share
    load, support = loads.loads_and_supports(*arguments)
    return load, support
