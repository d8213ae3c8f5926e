"""What it changes where netting snaps over into another stable shape of the same sector.

A knot of three bars has two places at their lengths, mirror images in the plane of its neighbours. Where no more than
one of them pulls, next to nothing tells the two apart: each is a stable shape, and what lies between is a snap that
every harmonic, which knows of small moves alone, calls stable. Such knots hang midway between short ropes, beside
windows and under layers that are too wide. Behind a joint of different counts the rows may be wrung as well, either way
about the axis: there is slack netting at it, too.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.bag.measures import Measures, measure_all
from codend.equilibrium.bag_model import BagModel
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
FINE = 1e-9
"""Tolerance of what is reached, or the plan's own: what comes back is no other shape."""
STEPS = 150
"""Of a gentle motion; those that settled took 8 to 65."""
MOST_KNOTS = 3000
"""Of a net that is tried so; a second or two."""
COVERING = 2.0
"""What snaps change, at most, over what was found: not all that may snap do at once."""
NOT_TRIED = np.array([2e-3, 5e-4, 5e-4, 0.0]), np.array([0.0, 0.0, 0.0, 1.0])
"""What they are assumed to change in larger nets, and where no shape was reached: share of drag, volume and radius, and
opening in degrees, some twice what they changed in a bag of 24 meshes round under a layer between two ropes."""


def apart_by_snapping(model: BagModel, case: Case, problem: Problem, solution: Solution, measures: Measures) -> Floats:
    """How far the shapes lie into which it may snap over, drag, volume, largest radius and opening ahead, (4,).

    Knots that are all but slack are mirrored all at once, joints are wrung, and the net is followed gently from there.
    0 where there are none, and where the layers of the net press on each other, whose shape is one of many anyway; of
    the volume where the catch gives it.
    """
    apart = np.zeros(4)
    starts = () if problem.surface is not None else tuple(_starts(model, problem, solution))
    if not starts:
        return apart
    of_size, by_itself = NOT_TRIED
    assumed = np.asarray(of_size * measures.estimated + by_itself)
    if case.gives_volume:
        assumed[1] = 0.0
    if len(solution.positions) > MOST_KNOTS:
        return assumed
    # the tangent's own factors are in the model's room
    room = prepare(problem.structure, problem.bands, model.prepared)
    for ways in starts:
        free = (way for way in ways if passage(problem, way, gathered=False) is None)
        start = next(free, None)
        if start is None:
            apart = np.maximum(apart, assumed)
            continue
        begun = replace(solution, positions=start)
        motion = gentle.follow(problem, min(model.plan.model.tolerance, FINE), begun, room, steps_allowed=STEPS)
        if motion.end is End.SETTLED:
            found = measure_all(model.bag, problem, motion.solution)[2]
            apart = np.maximum(apart, COVERING * np.abs(found.estimated - measures.estimated))
        else:
            apart = np.maximum(apart, assumed)
    return np.asarray(apart)


def _starts(model: BagModel, problem: Problem, solution: Solution) -> Iterator[list[Floats]]:
    """Shapes to set out from, the first of each that passes through nothing, lists of (n, 3)."""
    knots = all_but_slack(model.bag, problem, solution)
    if len(knots):
        off = to_the_plane(problem, solution.positions, knots)
        yield [solution.positions + way * off for way in WAYS]
    counts = [section.meshes_round for section in model.plan.netting]
    turned = any(kind.knots == "across" for kind in model.bag.band_kind)
    for joint in range(1, len(counts)):
        if counts[joint] != counts[joint - 1]:
            ahead = sum(section.meshes_long for section in model.plan.netting[:joint])
            turn = 2.0 * np.pi * WRUNG * model.globalisation / max(counts[joint - 1 : joint + 1])
            # netting that mirrors itself is wrung either way alike
            for way in (1.0, -1.0) if turned else (1.0,):
                yield [wrung(model.bag, problem, solution.positions, ahead, way * turn)]


def all_but_slack(bag: Bag, problem: Problem, solution: Solution) -> NDArray[np.int_]:
    """Numbers of the free knots of three bars and more of which at most one pulls; not the codline, (k,)."""
    structure, count = problem.structure, len(solution.positions)
    ends = np.concatenate([structure.first, structure.second])
    pulls = np.tile(solution.bar_tension > SLACK * solution.mean_tension, 2)
    slack = (np.bincount(ends, pulls, count) <= 1.0) & (np.bincount(ends, minlength=count) >= 3)
    slack &= (structure.free > 0.0).all(axis=1)
    slack[-1 - bag.anchors] = False
    return np.flatnonzero(slack)


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
