"""How an equilibrium moves with a number that it depends on: implicit differentiation by its tangent.

With r what is out of balance at nodes x and force densities q, and A the exact tangent, in it that of a front which
follows the net,  A dx/dp = dr/dp  at given x and q: one back-substitution a number. dr/dp is a difference of residuals
at p - h and p + h. Bars that are taut stay so and slack ones slack: it is the derivative up to the next number at which
one of them changes over.
"""

from dataclasses import dataclass

import numpy as np

from codend.mechanics.bars import add_bar_forces, add_bar_tangent, bar_lengths, bar_products
from codend.mechanics.catch_front import fill
from codend.mechanics.loads import add_force, add_tangent
from codend.mechanics.newton_state import State, empty_state, measure, take_over
from codend.mechanics.newton_step import empty_step, finish_step, linearise, right_side
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.dynamic_relaxation import reference_tension
from codend.solvers.newton import Prepared
from codend.solvers.outcome import Solution
from codend.solvers.ring import NEUTRAL

SWITCH = 0.1
"""Weight of the test for taut bars, which is the same at an equilibrium whatever the weight."""
REFINEMENTS = 60
REFINED, ENOUGH = 1e-12, 1e-8
"""Change of the solution by a refinement, relative, at which it ends, and the largest last one that is taken."""

STILL = 1e-3
"""Of a bar's length: a move that counts as none where tensions change by as much as they are."""


@dataclass(frozen=True)
class Move:
    """How an equilibrium moves with a number p, all over the change of p."""

    positions: Floats
    """(n, 3), m."""
    density: Floats
    """Of the force densities, N/m, (m,); 0 for slack bars."""


class Linearised:
    """The tangent at an equilibrium, factorised, to be asked how the equilibrium moves with this and that.

    Nothing else may be solved with ``prepared`` as long as it is asked. Its factors, those of Newton's method, are of a
    tangent in which nothing is quite inextensible nor quite free to turn about the axis: solutions are refined until
    they are those of the exact linear system of nodes and force densities.
    """

    def __init__(self, problem: Problem, solution: Solution, prepared: Prepared) -> None:
        self.problem = problem
        structure, loading, pattern = problem.structure, problem.loading, prepared.pattern
        self._pattern, self._system = pattern, prepared.system
        self._step = step = empty_step(structure, pattern)
        self._free = structure.free
        self.state = state = empty_state(structure, problem.bands)
        take_over(structure, np.ascontiguousarray(solution.positions), solution.bar_tension, state)
        tension = solution.mean_tension or reference_tension(problem)
        measure(structure, loading, tension, SWITCH, 0.0, state)
        self.taut = (state.density != 0.0) | structure.is_strut
        sides = linearise(structure, loading, pattern, tension, NEUTRAL, state, step)
        self._by_front, self._fronts = step.right[1:sides].copy(), step.gradient[: sides - 1].copy()
        self._sound = self._system.factorise(step.blocks) != -1
        self._solved_by_front = self._system.solve(self._by_front) if self._sound else self._by_front
        # the tangent at given densities and shares
        self._blocks = np.zeros_like(step.blocks)
        add_bar_tangent(state.position, structure, pattern, state.density, np.zeros_like(state.density), self._blocks)
        add_tangent(state.position, structure, loading, pattern, state.share, self._blocks)

    def move(self, less: Problem, more: Problem, spread: float) -> Move | None:
        """How the equilibrium moves with a number; None where that could not be found.

        Args:
            less: the problem at a number a little smaller, of as many nodes and bars; or at the number itself.
            more: at one a little larger, or at itself.
            spread: by how much the number in ``more`` is larger.
        """
        if not self._sound:
            return None
        first, second = self._in_this_shape(less), self._in_this_shape(more)
        by_hoop = (second.position - first.position) / spread
        force, gap = (second.force - first.force) / spread, (second.gap - first.gap) / spread
        positions, density = np.zeros_like(force), np.zeros_like(gap)
        before = np.inf
        for _ in range(REFINEMENTS):
            move, change = self._correction(*self._left(force, gap, positions, density))
            size = self._size(positions, density) or self._size(move, change)
            now = self._size(move, 0.0 * change) / size if size > 0.0 else 0.0
            if not np.isfinite(now):
                return None
            # no better than before: round-off, or a first correction that changed tensions alone
            if before <= ENOUGH and not now < before:
                break
            positions, density, before = positions + move, density + change, now
            if now <= REFINED:
                break
        return Move(positions + by_hoop, density) if before <= ENOUGH else None

    def _size(self, moves: Floats, density: Floats) -> float:
        """Size of a move: where nodes stay and tensions alone change, a bar's length for as much of these."""
        own = self.state
        tensions = float(np.abs(density).max(initial=0.0)) / (float(own.density.max(initial=0.0)) or 1.0)
        return max(float(np.abs(moves).max(initial=0.0)), STILL * tensions * float(own.length.max()))

    def _in_this_shape(self, problem: Problem) -> State:
        """What another problem leaves out of balance where nodes and force densities are as they are.

        Nodes on the hoop are where it has them; the axis, which also holds, stays where it is.
        """
        structure = problem.structure
        state = empty_state(structure, problem.bands)
        state.position[:] = np.where(self._free > 0.0, self.state.position, problem.net.positions)
        state.density[:] = self.state.density
        bar_lengths(state.position, structure, state.length)
        gap = 1.0 / structure.length - 1.0 / state.length - structure.flexibility * state.density
        state.gap[:] = np.where(self.taut, gap, 0.0)
        fill(state.position, structure, problem.loading.catch, state.share)
        state.load[:] = 0.0
        add_force(state.position, structure, problem.loading, state.share, state.load)
        state.force[:] = state.load
        add_bar_forces(state.position, structure, state.density, state.force)
        return state

    def _correction(self, force: Floats, gap: Floats) -> tuple[Floats, Floats]:
        """Moves (n, 3) and changes of density (m,) that take off what is out of balance, nearly."""
        own, step, structure = self.state, self._step, self.problem.structure
        there = own._replace(force=force, gap=gap)
        right_side(structure, own, there, step)
        solved = np.concatenate([self._system.solve(step.right[:1]), self._solved_by_front])
        finish_step(structure, own, there, solved, step)
        return step.move.copy(), step.change.copy()

    def _left(self, force: Floats, gap: Floats, moves: Floats, density: Floats) -> tuple[Floats, Floats]:
        """What forces (n, 3) and gaps (m,) leave out of balance, linearly, at moves and changes of density."""
        own, structure = self.state, self.problem.structure
        left = force.copy()
        add_bar_forces(own.position, structure, density, left)
        parts = np.einsum("bij,bj->bi", self._blocks, moves[self._pattern.column])
        left -= np.add.reduceat(parts, np.searchsorted(self._pattern.row, np.arange(len(moves))))
        for load, gradient in zip(self._by_front, self._fronts, strict=True):
            left += float((gradient * moves).sum()) * load
        shorter = gap + self._along(moves) / own.length**3 - structure.flexibility * density
        return left * self._free, np.where(self.taut, shorter, 0.0)

    def _along(self, moves: Floats) -> Floats:
        """Scalar product of every bar with the move of its second end against the first, m2, (m,)."""
        along = np.empty(len(self.taut))
        bar_products(self.state.position, moves, self.problem.structure, along)
        return along
