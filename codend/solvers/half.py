"""One half of a full net that is its own mirror image under its loads: an exact problem of half the size.

Nodes on the plane stay on it, which is all that the other half does to this one, but for what lies in the plane, of
which each half has a half, and for netting that meets its own image across the plane: of that the half knows nothing,
nor of moves that are not mirrored. Whoever uses it holds the whole net to what was found.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.contact import no_contact
from codend.mechanics.loads import Loading
from codend.mechanics.points import points_of
from codend.mechanics.problem import Problem, no_catch
from codend.mechanics.rings import rings_of
from codend.mechanics.structure import structure_of
from codend.mechanics.tube import tube_of
from codend.net.net import BAR_ARRAYS, Floats, Net
from codend.solvers.mirror import Mirror, mirror_of
from codend.solvers.outcome import Solution

Flags = NDArray[np.bool_]
Numbers = NDArray[np.int64]
ACROSS = np.array([1.0, -1.0, 1.0])
"""What a mirror in a plane of x and z makes of a vector."""


@dataclass(frozen=True)
class Half:
    """The half of a net on one side of a plane of x and z, and where it is in the whole."""

    problem: Problem
    plane: Floats
    """A place on the plane, (3,), m."""
    built: Floats
    """Where the nodes of the whole are built, (n, 3), m."""
    place: Numbers
    """Node of the half that every node of the whole is, or is the image of; -1 of those that nothing hangs on, (n,)."""
    is_image: Flags
    """Which are images, (n,)."""
    bar: Numbers
    """Bar of the half that every bar of the whole is, or is the image of, (m,)."""
    bar_share: Floats
    """Share of a bar that the half has: a half of those in the plane, (m,)."""

    def whole(self, solution: Solution) -> Solution:
        """Shape and tensions of the whole net from those of its half."""
        positions = self._set_out(solution.positions)
        tension = solution.bar_tension[self.bar] / self.bar_share
        return replace(solution, positions=positions, bar_tension=tension, midway=None)

    def own(self, solution: Solution) -> Solution:
        """Shape and tensions of the half from those of the whole net, whose other side is left out."""
        tension = np.empty(len(self.problem.net.bars))
        tension[self.bar] = solution.bar_tension * self.bar_share
        return replace(solution, positions=self._on_this_side(solution.positions), bar_tension=tension, midway=None)

    def unlike_m(self, positions: Floats) -> float:
        """Farthest distance of a node of the whole net, (n, 3), from where its image says it is, m."""
        apart = self._set_out(self._on_this_side(positions)) - positions
        return float(np.linalg.norm(apart[self.place >= 0], axis=1).max())

    def _on_this_side(self, positions: Floats) -> Floats:
        own, first = np.empty((len(self.problem.net.positions), 3)), (self.place >= 0) & ~self.is_image
        own[self.place[first]] = positions[first]
        return own

    def _set_out(self, own: Floats) -> Floats:
        """Nodes of the whole net, (n, 3), from those of its half, (h, 3)."""
        there = own[self.place]
        there = np.where(self.is_image[:, None], self.plane + ACROSS * (there - self.plane), there)
        return np.where((self.place < 0)[:, None], self.built, there)


def half_of(problem: Problem) -> Half | None:
    """One half of a net that has a plane of x and z in its middle as its mirror; None where it has none.

    None as well where no half is made: of sectors, of nets with bars across the plane, stiff corners, layers or a
    catch, and of those that hang on a body afloat. Contact is left to whoever uses it.
    """
    net = problem.net
    if net.order != 1.0 or len(net.corners) or len(net.wrap_node) or problem.loading.catch.row_size.any():
        return None
    if problem.body is not None:
        return None
    used = np.zeros(len(net.positions), dtype=bool)
    used[np.concatenate([net.bars.ravel(), net.point_node])] = True
    part, _ = _part_of(problem, used)
    across = part.net.positions[:, 1]
    plane = np.array([0.0, 0.5 * float(across.min() + across.max()), 0.0])
    placed = replace(part, net=replace(part.net, positions=part.net.positions - plane))
    mirror = mirror_of(placed, [0.5 * np.pi])
    if mirror is None or not np.array_equal(part.net.fixed, part.net.fixed[mirror.node]):
        return None
    on_plane = mirror.node == np.arange(len(mirror.node))
    beyond = ~on_plane & (placed.net.positions[:, 1] > 0.0)
    ends_beyond = beyond[part.net.bars].sum(axis=1)
    if not beyond.any() or np.any((ends_beyond == 1) & ~on_plane[part.net.bars].any(axis=1)):
        return None
    half, own = _part_of(part, ~beyond)
    share = np.where(on_plane[part.net.bars].all(axis=1), 0.5, 1.0)
    halved = _halved(half, on_plane[~beyond], share[own], float(plane[1]))
    return Half(halved, plane, net.positions, *_places(used, beyond, mirror), *_bars(own, share, mirror))


def _places(used: Flags, beyond: Flags, mirror: Mirror) -> tuple[Numbers, Flags]:
    """``place`` and ``is_image`` of the half."""
    of_part = _numbered(~beyond)
    of_part[beyond] = of_part[mirror.node[beyond]]
    place, is_image = np.full(len(used), -1), np.zeros(len(used), dtype=bool)
    place[used], is_image[used] = of_part, beyond
    return place, is_image


def _bars(own: Flags, share: Floats, mirror: Mirror) -> tuple[Numbers, Floats]:
    """``bar`` and ``bar_share`` of the half."""
    bar = _numbered(own)
    bar[~own] = bar[mirror.bar[~own]]
    return bar, share


def _numbered(which: Flags) -> Numbers:
    """Places of those marked among themselves, -1 of others."""
    return np.where(which, np.cumsum(which) - 1, -1)


def _part_of(problem: Problem, nodes: Flags) -> tuple[Problem, Flags]:
    """The problem of some nodes and of what lies between these alone, and which bars that are; without a catch."""
    net, loading, number = problem.net, problem.loading, _numbered(nodes)
    bars = np.asarray(nodes[net.bars].all(axis=1))
    facets = nodes[net.facets].all(axis=1)
    points = nodes[net.point_node]
    columns = {name: getattr(net, name)[bars] for name in BAR_ARRAYS}
    columns["bars"] = number[columns["bars"]].astype(np.int32)
    part = replace(
        net,
        positions=net.positions[nodes],
        fixed=net.fixed[nodes],
        facets=number[net.facets[facets]].astype(np.int32),
        facet_image=net.facet_image[facets],
        facet_weight=net.facet_weight[facets],
        point_node=number[net.point_node[points]].astype(np.int32),
        point_mass=net.point_mass[points],
        point_wet_weight=net.point_wet_weight[points],
        point_drag_area=net.point_drag_area[points],
        point_lift_area=net.point_lift_area[points],
        point_lift_towards=net.point_lift_towards[points],
        **columns,
    )
    stiffness = loading.seabed.stiffness
    seabed = loading.seabed._replace(stiffness=stiffness[nodes] if len(stiffness) else stiffness)
    loading = loading._replace(dead=loading.dead[nodes], seabed=seabed, contact=no_contact())
    return _with(replace(problem, net=part, surface=None), loading._replace(catch=no_catch(part))), bars


def _halved(problem: Problem, on_plane: Flags, bar_share: Floats, plane_y: float) -> Problem:
    """The problem with its nodes on the plane held there, and a half of all that lies in it."""
    net, loading = problem.net, problem.loading
    positions, fixed = net.positions.copy(), net.fixed.copy()
    positions[on_plane, 1], fixed[on_plane, 1] = plane_y, True
    share = np.where(on_plane, 0.5, 1.0)
    of_point = share[net.point_node]
    half = replace(
        net,
        positions=positions,
        fixed=fixed,
        bar_flexibility=net.bar_flexibility / bar_share,
        bar_drag_diameter=net.bar_drag_diameter * bar_share,
        bar_solid_diameter=net.bar_solid_diameter * np.sqrt(bar_share),
        facet_weight=_once_cut(net, on_plane),
        point_mass=net.point_mass * of_point,
        point_wet_weight=net.point_wet_weight * of_point,
        point_drag_area=net.point_drag_area * of_point,
        point_lift_area=net.point_lift_area * of_point,
    )
    dead, stiffness = loading.dead * share[:, None], loading.seabed.stiffness
    dead[on_plane, 1] = 0.0
    seabed = loading.seabed._replace(stiffness=stiffness * share if len(stiffness) else stiffness)
    return _with(replace(problem, net=half), loading._replace(dead=dead, seabed=seabed))


def _with(problem: Problem, loading: Loading) -> Problem:
    """The problem of its net, whatever that is now, under loads."""
    loading = loading._replace(points=points_of(problem.net))
    rings = rings_of(problem.net.positions, loading.catch.node_row, problem.net.order)
    structure, tube = structure_of(problem.net), tube_of(problem.net)
    return replace(problem, structure=structure, loading=loading, rings=rings, tube=tube)


def _once_cut(net: Net, on_plane: Flags) -> Floats:
    """Weights of facets: of a quadrangle that the plane cuts in two, one triangle is left, which counts whole, (f,)."""
    sides = np.sort(np.stack([net.facets, np.roll(net.facets, -1, axis=1)], axis=2), axis=2).astype(np.int64)
    in_plane = on_plane[sides].all(axis=2) & (net.facet_weight < 1.0)[:, None]
    key = sides[..., 0] * len(on_plane) + sides[..., 1]
    found, count = np.unique(key[in_plane], return_counts=True)
    cut = (in_plane & np.isin(key, found[count == 1])).any(axis=1)
    return np.where(cut, 1.0, net.facet_weight)
