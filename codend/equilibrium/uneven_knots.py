"""Knots of a ring that stiff twine holds unevenly, and would hold as well in another order.

Where meshes are gathered at the codline, the last knots lie in one plane, or some lean ahead and those between back. A
sector is stable one way or the other, by every harmonic; but round the whole net other orders are as stable, and meet.
Beside a joint, on the side of more meshes, knots between those that the joint holds stand in while these stand out, or
the other way about.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.bag.loads import problem_of
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.start_shapes import all_round_start
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.plan.plan import Case, Plan
from codend.solvers.outcome import Solution

UNEVEN = 0.05
"""Difference of the pulls of knots side by side, over their mean, from which they lean by turns: 0.6 in a codend that
widens from 14 meshes to 28, 0.005 in the row of knots ahead."""
FEWEST = 4
"""Knots among which another order is made."""
EVERY = 2, 3
"""One in so many pairs of knots is exchanged, or in so many knots bent, in the narrowest model that holds so many knots
and in the next. In that codend every other one of 14 changed drag and volume most, every third the largest radius."""
STIFF = 1.0
"""Stiffness of the mean corner over the mean tension times a bar's length from which knots in one plane are bent out of
it where sections of different counts are joined: those that stayed so were of 5.7 to 24. Knots of nets of one count
came back, of 45 stable ones of diamond and T90 netting all."""
BENT, AT_MOST = 0.4, 0.5
"""Move along the axis of knots that are bent over, out of the plane or through it, over the knot that ties them to the
codline, which is taken as so much of a twine at most. In a codend of 42 meshes and then 14 they moved by 0.39 of it, in
one of 9 and 27 the slackest of three by 0.15."""


def stiffness(problem: Problem, solution: Solution) -> float:
    """Stiffness of the mean corner over the mean tension times a bar's length; 0 of limp twine."""
    structure = problem.structure
    if len(structure.corner_stiffness) == 0:
        return 0.0
    return float(structure.corner_stiffness.mean() / (solution.mean_tension * structure.length.mean()))


def may_take_another_order(model: BagModel, problem: Problem, solution: Solution) -> bool:
    """Whether the last knots are held by stiff twine so that they lean by turns, or may."""
    joined = len({section.meshes_round for section in model.plan.netting}) > 1
    stiff = stiffness(problem, solution)
    return (joined and stiff > STIFF) or (stiff > 0.0 and lean_by_turns(model, solution))


def lean_by_turns(model: BagModel, solution: Solution) -> bool:
    """Whether the last knots do, those of one sector."""
    pulls = solution.bar_tension[last_knots(model.bag, solution.positions)[1]]
    apart = np.abs(pulls - np.roll(pulls, 1))
    return bool((apart > UNEVEN * pulls.mean()).any())


def last_knots(bag: Bag, positions: Floats) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Knots that netting is tied to the codline by, as they follow each other round it, and those bars, (k,) both."""
    codline = len(positions) - 1 - bag.anchors
    tied = np.setdiff1d(np.flatnonzero((bag.net.bars == codline).any(axis=1)), bag.ropes)
    knots = bag.net.bars[tied].sum(axis=1) - codline
    along = _round_it(positions, knots)
    return knots[along], tied[along]


def in_another_order(
    model: BagModel, case: Case, problem: Problem, solution: Solution, most_knots: int
) -> Iterator[tuple[BagModel, Problem, Solution, Floats]]:
    """Models of at most so many knots, each with the shape at rest and that with last knots in another order.

    Those that lean by turns are exchanged, and those that pull least bent over; (n, 3).
    """
    leaning = lean_by_turns(model, solution)
    own, count = len(last_knots(model.bag, solution.positions)[0]), len(solution.positions) - 1
    sectors = model.bag.net.sectors
    widths = [width for width in range(1, sectors + 1) if sectors % width == 0 and width * own >= FEWEST]
    for width, every in zip((widths + widths[-1:])[: len(EVERY)], EVERY, strict=False):
        if width > 1 and (width * count > most_knots or len(model.bag.ropes)):
            return
        wider = set_side_by_side(model, case, problem, solution, width)
        if wider is None:
            return
        wide, loaded, rest = wider
        yield wide, loaded, rest, _bent_over(wide.bag, rest, every)
        if leaning:
            yield wide, loaded, rest, _exchanged(wide.bag, rest, every)


def set_side_by_side(
    model: BagModel, case: Case, problem: Problem, solution: Solution, width: int
) -> tuple[BagModel, Problem, Solution] | None:
    """The model so many times as wide and its shape there; None where weight acts, which a sector does not bear."""
    if width == 1:
        return model, problem, solution
    abreast = model.sectors or 1
    wide = model_of(model.plan, model.globalisation, abreast * width, near=model.near)
    loaded = problem_of(wide.bag, wide.plan, case)
    if loaded.loading.dead.any() or loaded.loading.catch.weight_density:
        return None
    start = all_round_start(model.bag, solution.positions, solution.bar_tension, width, abreast=abreast)
    return wide, loaded, replace(solution, positions=start.positions, bar_tension=start.bar_tension)


def _exchanged(bag: Bag, rest: Solution, every: int) -> Floats:
    knots, _ = last_knots(bag, rest.positions)
    pairs = knots[: len(knots) // 2 * 2].reshape(-1, 2)
    one, other = pairs[: max(len(pairs) - 1, 1) : every].T
    return in_places_of(rest.positions, np.append(one, other), np.append(other, one))


def _bent_over(bag: Bag, rest: Solution, every: int) -> Floats:
    knots, bars = last_knots(bag, rest.positions)
    pulls = rest.bar_tension[bars]
    slackest = pulls <= pulls.min() + UNEVEN * pulls.mean()
    chosen, tied = knots[slackest], bars[slackest]
    some = slice(0, max(len(chosen) - 1, 1), every)
    chosen, tied = chosen[some], tied[some]
    length = np.minimum(bag.net.bar_length[tied], AT_MOST * np.median(bag.net.bar_length[bag.bar_is_twine]))
    moved = rest.positions.copy()
    back = moved[chosen, 0] > moved[len(moved) - 1 - bag.anchors, 0]
    moved[chosen, 0] += BENT * length * np.where(back, -1.0, 1.0)
    return moved


def beside_joints(plan: Plan, bag: Bag, problem: Problem, positions: Floats) -> Iterator[Floats]:
    """Shapes in which the knots beside a joint of stiff netting have the places of those next to them, (n, 3)."""
    if len(problem.structure.corners) == 0:
        return
    place = 0
    for ahead, behind in zip(plan.netting[:-1], plan.netting[1:], strict=True):
        place += ahead.meshes_long
        if ahead.meshes_round == behind.meshes_round:
            continue
        joint = int(np.searchsorted(bag.row_place, place - 1e-9))
        beside = joint + 1 if behind.meshes_round > ahead.meshes_round else joint - 1
        ring = np.flatnonzero(bag.node_row == beside)
        ring = ring[_round_it(positions, ring)]
        if len(ring) > 1:
            both = [ring, *_other_ends(bag, ring)]
            knots, of = np.concatenate(both), np.concatenate([np.roll(ends, 1) for ends in both])
            yield np.where(problem.net.fixed, positions, in_places_of(positions, knots, of))


def _other_ends(bag: Bag, ring: NDArray[np.int_]) -> list[NDArray[np.int_]]:
    """The other ends of the knots of these nodes, in their order, where each has one."""
    is_knot = ~bag.bar_is_twine
    is_knot[np.concatenate([bag.straps, bag.ropes])] = False
    knots = bag.net.bars[is_knot]
    other = {int(end): int(node) for pair in knots for end, node in (pair, pair[::-1])}
    ends = [other[int(node)] for node in ring if int(node) in other]
    return [np.array(ends)] if len(ends) == len(ring) else []


def in_places_of(positions: Floats, knots: NDArray[np.int_], of: NDArray[np.int_]) -> Floats:
    """The shape with these knots as far along the axis and from it as others are, each at its own azimuth, (n, 3)."""
    moved = positions.copy()
    moved[knots, 0] = positions[of, 0]
    wider = np.hypot(*positions[of, 1:].T) / np.hypot(*positions[knots, 1:].T)
    moved[knots, 1:] = wider[:, None] * positions[knots, 1:]
    return moved


def _round_it(positions: Floats, knots: NDArray[np.int_]) -> NDArray[np.int_]:
    """Order in which knots follow each other round the axis."""
    return np.argsort(np.arctan2(positions[knots, 2], positions[knots, 1]))
