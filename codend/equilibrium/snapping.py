"""What it changes where netting snaps over into another stable shape of the same sector.

A knot of three bars has two places at their lengths, mirror images in the plane of its neighbours. Where no more than
one of them pulls, next to nothing tells the two apart: each is a stable shape, and what lies between is a snap that
every harmonic, which knows of small moves alone, calls stable. Such knots hang midway between short ropes, beside
windows and under layers that are too wide. Behind a joint of different counts the rows may be wrung as well, either way
about the axis: there is slack netting at it, too. Stiff twine holds knots at the codline and beside joints in one order
or another (``uneven_knots``), and a bag of it that is all but empty in folds wherever it is dented.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.bag.measure_kernels import knots_all_but_slack
from codend.bag.measures import Measures, measure_all
from codend.equilibrium.bag_model import BagModel
from codend.equilibrium.uneven_knots import (
    beside_joints,
    in_another_order,
    may_take_another_order,
    set_side_by_side,
    stiffness,
)
from codend.mechanics.problem import Problem
from codend.net.net import Floats, rotate
from codend.plan.plan import Case
from codend.solvers import gentle
from codend.solvers.gentle import End
from codend.solvers.outcome import Solution
from codend.solvers.prepared import prepare
from codend.solvers.refusal import passage

SLACK = 0.01
"""Pull over the mean bar's up to which a bar is all but slack."""
WAYS = 2.0, 1.3
"""Moves of such knots over their distance to the plane of their neighbours: to the mirrored place, or less where
netting would pass through netting."""
WRUNG = 0.5
"""Turn of the codline, of all that lies behind a joint in proportion, over the angle of a mesh there. From a
third to two thirds a joint of 5 to 15 meshes went on to the shape that is wrung by 4.3 degrees, less went back."""
STIFF = 4.0
"""Stiffness of the mean corner over the mean tension times a bar's length from which a net is shaken. Of 500 random
ones five of little catch, at 7 to 311, went into folds when shaken by 1 %, to 2e-2 of drag and 0.11 of the volume."""
SHAKEN, SHAKES = 0.03, (0, 1)
"""Move of every free knot over the length of a bar, and the seeds it is drawn with."""
FINE = 1e-9
"""Tolerance of what is reached, or the plan's own: what comes back is no other shape."""
STEPS = 150
"""Of a gentle motion; those that settled took 8 to 65."""
MOST_KNOTS = 3000
"""Of a net that is tried so; a second or two."""
COVERING = 2.0
"""What snaps change, at most, over what was found: not all that may snap do at once. One of 14 bags with slack knots
between ropes went elsewhere when shaken by 1 and 3 %, by 0.58 of what is told."""
NOT_TRIED = np.array([7e-3, 2e-3, 5e-4, 0.0]), np.array([0.0, 0.0, 0.0, 1.0])
"""What they are assumed to change in larger nets, and where no shape was reached: share of drag, volume and radius, and
opening in degrees, some twice what they changed in bags of 24 meshes round between two and four ropes."""
NOT_SHAKEN = np.array([4e-2, 0.25, 7e-2, 0.0]), np.array([0.0, 0.0, 0.0, 1.4])
"""The same of stiff twine: twice what folds changed at most in those five."""


def apart_by_snapping(model: BagModel, case: Case, problem: Problem, solution: Solution, measures: Measures) -> Floats:
    """How far the shapes lie into which it may snap over, drag, volume, largest radius and opening ahead, (4,).

    Knots that are all but slack are mirrored, all of them and every other one, joints are wrung, knots of stiff netting
    take each other's places, that of stiff twine is shaken, and the net is followed gently from there. 0 where
    there are none, and where the layers of the net press on each other, whose shape is one of many anyway; of the
    volume where the catch gives it.
    """
    apart = np.zeros(4)
    if problem.surface is not None:
        return apart
    here, reordered = _Start(model, problem, solution, []), may_take_another_order(model, problem, solution)
    starts = [replace(here, ways=ways) for ways in _ways(model, problem, solution)]
    stiff = stiffness(problem, solution) > STIFF
    if not (starts or reordered or stiff):
        return apart
    of_size, by_itself = NOT_SHAKEN if stiff else NOT_TRIED
    assumed = np.asarray(of_size * measures.estimated + by_itself)
    if case.gives_volume:
        assumed[1] = 0.0
    if len(solution.positions) > MOST_KNOTS:
        return assumed
    if reordered:
        orders = [
            _Start(wide, loaded, rest, [way])
            for wide, loaded, rest, way in in_another_order(model, case, problem, solution, MOST_KNOTS)
        ]
        apart = apart if orders else assumed
        starts += orders
    if stiff:
        starts += _shaken(model, case, problem, solution)
    for start in starts:
        reached = start.reached()
        apart = np.maximum(apart, assumed if reached is None else COVERING * np.abs(reached - measures.estimated))
    return np.asarray(apart)


@dataclass(frozen=True)
class _Start:
    """A model at rest, and shapes of it to set out from, (n, 3), the first that passes through nothing on its way."""

    model: BagModel
    problem: Problem
    rest: Solution
    ways: list[Floats]

    def reached(self) -> Floats | None:
        """Drag, volume, largest radius and opening of the shape that they lead to, (4,); None: to none."""
        problem = self.problem
        # the tangent's own factors are in the model's room
        room = prepare(problem.structure, problem.bands, self.model.prepared)
        tolerance = min(self.model.plan.model.tolerance, FINE)
        for way in self.ways:
            if passage(problem, way, gathered=False) is None:
                begun = replace(self.rest, positions=way)
                motion = gentle.follow(problem, tolerance, begun, room, steps_allowed=STEPS)
                if motion.end is End.SETTLED:
                    return measure_all(self.model.bag, problem, motion.solution)[2].estimated
        return None


def _shaken(model: BagModel, case: Case, problem: Problem, solution: Solution) -> list[_Start]:
    """The widest sector of at most ``MOST_KNOTS`` that the loads allow, free knots moved at random by each seed."""
    sectors = 1 if len(model.bag.ropes) else model.bag.net.sectors
    most = max(MOST_KNOTS // len(solution.positions), 1)
    widths = [width for width in range(min(most, sectors), 0, -1) if sectors % width == 0]
    wider = (set_side_by_side(model, case, problem, solution, width) for width in widths)
    wide, loaded, rest = next(found for found in wider if found is not None)
    size = SHAKEN * float(np.median(loaded.structure.length)) * ~loaded.net.fixed
    moves = [size * np.random.default_rng(seed).standard_normal(rest.positions.shape) for seed in SHAKES]
    return [_Start(wide, loaded, rest, [rest.positions + move, rest.positions + 0.3 * move]) for move in moves]


def _ways(model: BagModel, problem: Problem, solution: Solution) -> Iterator[list[Floats]]:
    """Shapes of the model's own net to set out from, (n, 3), those of a list in the place of each other."""
    knots = all_but_slack(model.bag, problem, solution)
    if len(knots):
        for some in (knots, knots[::2], knots[1::2]):
            off = to_the_plane(problem, solution.positions, some)
            if len(some):
                yield [solution.positions + way * off for way in WAYS]
    for moved in beside_joints(model.plan, model.bag, problem, solution.positions):
        yield [moved]
    counts = [section.meshes_round for section in model.plan.netting]
    for joint in range(1, len(counts)):
        if counts[joint] != counts[joint - 1]:
            ahead = sum(section.meshes_long for section in model.plan.netting[:joint])
            turn = 2.0 * np.pi * WRUNG * model.globalisation / max(counts[joint - 1 : joint + 1])
            # netting that mirrors itself is wrung either way alike
            for way in (1.0, -1.0) if model.bag.turned else (1.0,):
                yield [wrung(model.bag, problem, solution.positions, ahead, way * turn)]


def all_but_slack(bag: Bag, problem: Problem, solution: Solution) -> NDArray[np.int_]:
    """Numbers of the free knots of three bars and more of which at most one pulls; not the codline, (k,)."""
    s, codline = problem.structure, len(solution.positions) - 1 - bag.anchors
    least = SLACK * solution.mean_tension
    return knots_all_but_slack(s.first, s.second, solution.bar_tension, least, s.free, codline)


def to_the_plane(problem: Problem, positions: Floats, knots: NDArray[np.int_]) -> Floats:
    """Moves of these knots on to the planes of their neighbours, (n, 3); twice as far is the mirrored place."""
    structure, order = problem.structure, problem.net.order
    moves = np.zeros_like(positions)
    for knot in knots:
        ahead, behind = np.flatnonzero(structure.first == knot), np.flatnonzero(structure.second == knot)
        others = np.concatenate([structure.second[ahead], structure.first[behind]])
        places = rotate(positions[others], np.concatenate([structure.image[ahead], -structure.image[behind]]), order)
        middle = places.mean(axis=0)
        normal = np.linalg.svd(places - middle)[2][2]
        moves[knot] = -((positions[knot] - middle) @ normal) * normal
    return moves


def wrung(bag: Bag, problem: Problem, positions: Floats, ahead: float, turn: float) -> Floats:
    """The shape turned about the axis behind so many meshes from the entry, by ``turn`` rad at the codline, (n, 3)."""
    joint = np.searchsorted(bag.row_place, ahead - 1e-9)
    x = positions[:, 0]
    at_joint, codline = float(x[bag.node_row == joint].mean()), float(x[-1 - bag.anchors])
    share = np.clip((x - at_joint) / (codline - at_joint), 0.0, 1.0)
    turned = rotate(positions, share * turn / (2.0 * np.pi), 1.0)
    return np.where(problem.net.fixed, positions, turned)
