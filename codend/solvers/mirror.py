"""Planes through the axis in which a net under its loads is its own mirror image, and stays so.

Moves of such a net that are mirrored have half the unknowns: all that is told of it is where every node's image is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from codend.mechanics.newton_state import empty_state, measure
from codend.mechanics.problem import Problem
from codend.net.net import Floats, Ints, Net, rotate
from codend.solvers.outcome import Midway, Solution

NEAR = 1e-9
"""Distance of a node from another's image, over the length of a bar, that is round-off."""
SAME_FORCE = 1e-9
"""Difference of mirrored forces, over the largest, that is round-off."""
ALIKE = 1e-4
"""Distance of a start's nodes from each other's images, over the length of a bar, up to which it is taken as mirrored:
solved starts are so to the tolerance they were solved to."""


@dataclass(frozen=True)
class Mirror:
    """Where the images of nodes and bars are: the move of node i is ``turn[i]`` times that of ``node[i]``."""

    node: Ints
    """The node that each node is the image of, itself on the plane, (n,)."""
    turn: Floats
    """Reflection, and the turn back from the sector in which the image lies, (n, 3, 3)."""
    bar: Ints
    """The same of bars, (m,)."""

    def made_mirrored(self, solution: Solution) -> Solution:
        """A solution whose positions and tensions are images to the last digit: stiff bars make forces of the rest."""
        tension = 0.5 * (solution.bar_tension + solution.bar_tension[self.bar])
        midway = solution.midway
        if midway is not None:
            density, slackness = (0.5 * (of + of[self.bar]) for of in (midway.density, midway.slackness))
            midway = Midway(self.mirrored(midway.positions), density, slackness, midway.barrier)
        return replace(solution, positions=self.mirrored(solution.positions), bar_tension=tension, midway=midway)

    def mirrored(self, positions: Floats) -> Floats:
        """Positions (n, 3) of which those behind the plane are the images of those before it."""
        of_image = np.einsum("nij,nj->ni", self.turn, positions[self.node])
        on_plane = (self.node == np.arange(len(self.node)))[:, None]
        before = (np.arange(len(self.node)) < self.node)[:, None]
        return np.where(before, positions, np.where(on_plane, 0.5 * (positions + of_image), of_image))

    def beside(self, node: Ints) -> "Mirror":
        """The same of a full net with more nodes, whose images these are."""
        turn = np.broadcast_to(self.turn[:1], (len(node), 3, 3))
        return replace(self, node=np.append(self.node, node).astype(np.int32), turn=np.concatenate([self.turn, turn]))

    def off(self, positions: Floats) -> float:
        """Farthest distance of a node from where its image says it is, m."""
        apart = positions - np.einsum("nij,nj->ni", self.turn, positions[self.node])
        return float(np.abs(apart).max())


def mirror_of(problem: Problem, azimuths_rad: Sequence[float]) -> Mirror | None:
    """The mirror of a net in the first of some planes that is one, None where none is.

    Held to the forces on the net in a mirrored shape drawn at random: of all bars, facets and loads there are. Only
    planes whose images need no more than signs are taken, where all bars stretch exchanged coordinates as well: else
    the lengths of a bar and its image differ by round-off, which bars that do not stretch make forces of.
    """
    for azimuth in azimuths_rad:
        mirror = _images(problem.net, _reflection(azimuth))
        if mirror is not None and _forces_are_mirrored(problem, mirror):
            return mirror
    return None


def _reflection(azimuth_rad: float) -> Floats:
    """Reflection in the plane of the axis and an azimuth, (3, 3)."""
    c, s = np.cos(2.0 * azimuth_rad), np.sin(2.0 * azimuth_rad)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, s, -c]])


def _images(net: Net, reflection: Floats) -> Mirror | None:
    """Images of nodes and bars in a plane; None unless every one has its own and supports and bars are like."""
    sectors = net.sectors
    image = np.repeat(np.arange(sectors), len(net.positions))
    all_round = rotate(np.tile(net.positions, (sectors, 1)), image, net.order)
    near = NEAR * float(net.bar_length.min())
    found = _nearest(all_round, net.positions @ reflection.T, near)
    if found is None:
        return None
    node = np.empty(len(net.positions), dtype=np.int32)
    turn = np.empty((len(node), 3, 3))
    there = found % len(node)
    if len(np.unique(there)) < len(node):
        return None
    node[there] = np.arange(len(node))
    back = rotate(np.broadcast_to(reflection.T, (len(node), 3, 3)), -(found // len(node))[:, None], net.order)
    turn[there] = np.swapaxes(back, 1, 2)
    exact = np.rint(turn)
    only_signs = not exact[:, 1, 2].any()
    if not only_signs and net.bar_flexibility.min() == 0.0:
        return None
    if np.abs(turn - exact).max() > NEAR or not np.array_equal(node[node], np.arange(len(node))):
        return None
    bar, held = _bar_images(net, reflection, near), np.asarray(net.fixed.all(axis=1))
    if bar is None or not np.array_equal(held, held[node]):
        return None
    return Mirror(node, exact, bar)


def _bar_images(net: Net, reflection: Floats, near: float) -> Ints | None:
    """Bars whose images the bars are: of their likes by where their middles lie, (m,)."""
    from scipy.spatial import cKDTree

    ends = net.positions[net.bars[:, 0]], rotate(net.positions[net.bars[:, 1]], net.bar_image, net.order)
    likes = (net.bar_length, net.bar_flexibility, net.bar_drag_diameter, net.bar_is_rope, net.bar_is_strut)
    joined = (net.bars.min(axis=1), net.bars.max(axis=1), np.abs(net.bar_image))
    _, same = np.unique(np.stack([*likes, *joined]), axis=1, return_inverse=True)
    order = np.argsort(same, kind="stable")
    number = np.empty(len(same))  # of bars side by side, as those that are gathered at the codline
    number[order] = np.arange(len(same)) - np.searchsorted(same[order], same[order])
    _, like = np.unique(np.stack([*likes, number]), axis=1, return_inverse=True)
    middle = 0.5 * (ends[0] + ends[1])
    bar = np.full(len(middle), -1, dtype=np.int32)
    for kind in range(like.max() + 1):
        own = np.flatnonzero(like == kind)
        image = np.repeat(np.arange(net.sectors), len(own))
        tree = cKDTree(rotate(np.tile(middle[own], (net.sectors, 1)), image, net.order))
        apart, found = tree.query(middle[own] @ reflection.T)
        if np.max(apart) > near:
            return None
        bar[own] = own[found % len(own)]
    return bar if len(np.unique(bar)) == len(bar) else None


def _nearest(points: Floats, asked: Floats, near: float) -> Ints | None:
    from scipy.spatial import cKDTree

    apart, found = cKDTree(points).query(asked)
    return np.asarray(found, dtype=np.int32) if np.max(apart) <= near else None


def _forces_are_mirrored(problem: Problem, mirror: Mirror) -> bool:
    structure, net = problem.structure, problem.net
    rng = np.random.default_rng(0)
    state = empty_state(structure, problem.bands)
    free = structure.free > 0.0
    drawn = 0.05 * float(net.bar_length.min()) * rng.standard_normal(net.positions.shape) * free
    drawn += np.einsum("nij,nj->ni", mirror.turn, drawn[mirror.node])
    state.position[:] = mirror.mirrored(net.positions) + drawn * free
    state.density[:] = 1.0 / structure.length
    measure(structure, problem.loading, 1.0, 1.0, 0.0, state)
    off = 0.0
    for forces in (state.force, state.load):
        there = np.einsum("nij,nj->ni", mirror.turn, forces[mirror.node])
        off = max(off, float(np.abs((forces - there)[free]).max() / max(np.abs(forces[free]).max(), 1e-300)))
    return off <= SAME_FORCE
