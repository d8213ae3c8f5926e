"""Starts in sectors wide enough for what grows of an equilibrium: along the growing shape, and shaken.

A harmonic k of a ring of n sectors fits into a sector w of them wide where k w / n is whole.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import gcd

import numpy as np

from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.stability import Stability
from codend.equilibrium.start_shapes import all_round_start
from codend.net.net import Floats, rotate
from codend.plan.plan import Case
from codend.solvers.harmonics import Growth
from codend.solvers.outcome import Solution

MOST_KNOTS = 3000
"""Of a sector that is followed, or of the whole net: some seconds a shape."""
WIDTHS = 3
"""Narrowest sectors that are followed."""
ALONG, SHAKEN = 0.05, 0.01
"""Largest move along a growing shape, and moves at random, to start with, over a bar."""


def fitting(model: BagModel, stability: Stability) -> Iterator[tuple[int, Growth]]:
    """The narrowest sectors that growing harmonics fit, over the model's own width, each with the strongest of them."""
    order = model.bag.net.sectors
    strongest: dict[int, Growth] = {}
    for growth in sorted(stability.growths, key=lambda growth: growth.eigenvalues[0].real):
        strongest.setdefault(order // gcd(order, growth.harmonic), growth)
    knots = len(model.bag.net.positions) - 1
    for width in sorted(strongest)[:WIDTHS]:
        if width * knots <= MOST_KNOTS:
            yield width, strongest[width]


def starts(
    model: BagModel, case: Case, solution: Solution, stability: Stability
) -> Iterator[tuple[BagModel, int, Growth, Solution, Solution]]:
    """Models so many sectors wide, what grows there, the shape at rest, and where to start.

    That is along what grows, and of the widest shaken as well.
    """
    order, sectors = model.bag.net.sectors, model.sectors
    growing = list(fitting(model, stability))
    if not growing:
        return
    if len(solution.bar_tension) % (sectors or 1) or (len(solution.positions) - 1) % (sectors or 1):
        return  # sections of different counts, whose narrower sectors are not numbered alike
    for width, growth in growing:
        wide = model
        if width > 1:
            wide = model_of(model.plan, model.globalisation, (sectors or 1) * width)
        rest, start = along(model, wide, solution, growth)
        yield wide, order, growth, rest, start
    shake = np.random.default_rng(case.number).standard_normal(rest.positions.shape) * ~wide.bag.net.fixed
    yield wide, order, growth, rest, _moved(rest, SHAKEN * float(np.median(wide.bag.net.bar_length)) * shake)


def along(model: BagModel, wide: BagModel, solution: Solution, growth: Growth) -> tuple[Solution, Solution]:
    """The shape at rest in a wider model, and that moved a little along what grows of it."""
    order, abreast = model.bag.net.sectors, model.sectors or 1
    width = order // wide.bag.net.sectors
    rest = all_round_start(model.bag, solution.positions, solution.bar_tension, width, abreast=abreast)
    turn = np.exp(2j * np.pi * growth.harmonic * np.arange(width) / order)
    moves = (growth.shape[:-1].reshape(-1, 1, abreast, 3) * turn[None, :, None, None]).real
    moved = rotate(moves, np.arange(width)[None, :, None], order).reshape(-1, 3)
    moved = np.concatenate([moved, growth.shape[-1:].real]) * ~wide.bag.net.fixed
    bar = float(np.median(wide.bag.net.bar_length))
    return rest, _moved(rest, ALONG * bar / np.linalg.norm(moved, axis=1).max() * moved)


def _moved(start: Solution, by: Floats) -> Solution:
    return replace(start, positions=start.positions + by)
