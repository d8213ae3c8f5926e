"""The tangent of a net and of the rigid body that carries it: the body's six unknowns are eliminated last.

The body's nodes are held in the net's own tangent K; with J how they move with the body,

    (J^T K_bb J + B - J^T K_bf K_ff^-1 K_fb J) w = J^T r_b + r - J^T K_bf K_ff^-1 r_f

B and r being the body's own tangent and load, and the forces of its nodes turning with their arms.
"""

import numpy as np

from codend.mechanics import body as rigid
from codend.mechanics.body import Body, Pose
from codend.mechanics.problem import Problem
from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import Floats
from codend.solvers.prepared import Prepared

NONE = 1e-13
"""Stiffness of the body, over its largest, that is round-off."""
UNDONE, STEERED = 1e-6, 1e-3
"""Stiffness below 0 that is round-off, and what a body that would heel or turn is given, over that of its heave."""
UPRIGHTING = np.array([2, 3, 4])
"""What floating alone holds of the six: height, heel and trim."""


def out_of_balance(body: Body, pose: Pose, force: Floats) -> Floats:
    """What is left over on the body of its own loads and of the forces of its nodes, (n, 3): (6,), N and N m."""
    on_nodes = force[body.nodes]
    moment = np.cross(rigid.arms_now(body, pose), on_nodes).sum(axis=0)
    return np.asarray(rigid.load(body, pose) + np.concatenate([on_nodes.sum(axis=0), moment]))


def residual_of(body: Body, left: Floats, scale: float) -> float:
    """What is left over on the body, (6,), over its weight and the sizes of all else, ``scale``, N."""
    largest = max(np.linalg.norm(left[:3]), np.linalg.norm(left[3:]) / body.size_m)
    return float(largest) / (scale + body.weight_n)


def moored(problem: Problem) -> bool:
    """Whether bars join the body to anything that is held."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    assert problem.body is not None
    net, nodes = problem.net, problem.body.nodes
    count = len(net.positions)
    ends = np.concatenate([net.bars, np.stack([np.full(len(nodes), nodes[0]), nodes], axis=1)])
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, group = connected_components(graph, directed=False)
    other = np.setdiff1d(np.flatnonzero(net.fixed.any(axis=1)), nodes)
    return bool(np.any(group[other] == group[nodes[0]]))


class BodySystem:
    """The tangent of a net and of its body, factorised."""

    def __init__(self, problem: Problem, prepared: Prepared) -> None:
        assert problem.body is not None
        self.body, self.prepared = problem.body, prepared
        pattern, count = prepared.pattern, len(problem.net.positions)
        self._of_body = np.zeros(count, dtype=bool)
        self._of_body[self.body.nodes] = True
        self._into = np.flatnonzero(self._of_body[pattern.column])
        self._from = np.flatnonzero(self._of_body[pattern.row] & ~self._of_body[pattern.column])
        self._jacobian = np.zeros((count, 3, 6))
        self._asked = np.arange(6) if moored(problem) else UPRIGHTING
        spring = self.body.water_density * GRAVITY_M_S2 * self.body.column_area.sum()
        self._floor = max(spring, self.body.weight_n / self.body.size_m)
        self.steering = False
        """Whether the body is kept from the way to equilibria from which it would heel or turn."""
        self.twist = np.zeros(6)
        """Move of the body in the last solution, (6,)."""

    def factorise(self, blocks: Floats, pose: Pose, force: Floats) -> int:
        """Factorise the tangent of the net, ``blocks``, and of the body there, under nodal forces (n, 3).

        Returns:
            0, or -1 if the net's own is singular.
        """
        body, pattern, system = self.body, self.prepared.pattern, self.prepared.system
        if system.factorise(blocks) != 0:
            return -1
        arms = rigid.arms_now(body, pose)
        self._jacobian[body.nodes] = rigid.jacobian(arms)
        columns = np.zeros_like(self._jacobian)
        into, back = self._into, self._from
        np.add.at(columns, pattern.row[into], blocks[into] @ self._jacobian[pattern.column[into]])
        self._rows = np.zeros_like(self._jacobian)
        np.add.at(self._rows, pattern.column[back], blocks[back].transpose(0, 2, 1) @ self._jacobian[pattern.row[back]])
        own = rigid.load_tangent(body, pose) + rigid.force_tangent(arms, force[body.nodes])
        own += np.einsum("nij,nik->jk", self._jacobian, columns)
        free = columns.copy()
        free[self._of_body] = 0.0
        self._follows = system.solve(np.ascontiguousarray(free.transpose(2, 0, 1)))
        reduced = own - np.einsum("nij,kni->jk", self._rows, self._follows)
        self._scale = np.array([1.0] * 3 + [1.0 / body.size_m] * 3)
        scaled = (self._scale[:, None] * reduced * self._scale)[np.ix_(self._asked, self._asked)]
        self._reduced = scaled
        if self.steering and (least := float(np.linalg.eigvalsh(0.5 * (scaled + scaled.T))[0])) < 0.0:
            scaled = scaled + (STEERED * self._floor - 1.5 * least) * np.eye(len(scaled))
        self._inverse = np.zeros((6, 6))
        self._inverse[np.ix_(self._asked, self._asked)] = np.linalg.pinv(scaled, rcond=NONE)
        return 0

    def growing(self) -> Floats | None:
        """The move of the body that its last tangent does not undo but help, (6,); None where there is none.

        Its angles are in rad, and its largest place or angle times the body's size is 1.
        """
        values, vectors = np.linalg.eig(self._reduced)
        worst = int(np.argmin(values.real))
        if values[worst].real >= -UNDONE * self._floor:
            return None
        found = np.zeros(6)
        found[self._asked] = vectors[:, worst].real
        return np.asarray(self._scale * found / np.abs(found).max())

    def solve(self, right: Floats, pose: Pose) -> Floats:
        """Solution for a right side (1, n, 3), the moves of the body's nodes in it to the first order."""
        found = self.prepared.system.solve(right)
        found[:, self._of_body] = 0.0
        on_body = np.einsum("nij,ni->j", self._jacobian, right[0]) + rigid.load(self.body, pose)
        on_body -= np.einsum("nij,ni->j", self._rows, found[0])
        self.twist = self._scale * (self._inverse @ (self._scale * on_body))
        found[0] -= np.einsum("kni,k->ni", self._follows, self.twist)
        found[0] += self._jacobian @ self.twist
        return found
