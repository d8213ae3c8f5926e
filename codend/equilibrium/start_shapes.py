"""Shapes and tensions to start from that nobody has solved on the net itself."""

import numpy as np

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.meridian.plan_case import tensions_on
from codend.bag.meridian.problem import MeridianShape
from codend.equilibrium.bag_model import BagModel
from codend.net.net import Floats, rotate
from codend.solvers.outcome import Outcome, Solution, SolverReport

START = SolverReport("start", Outcome.NOT_IMPROVING, 0, np.inf, np.inf, np.inf, 0.0)
"""Report of a shape that nobody has solved yet."""


def all_round_start(sector: Bag, positions: Floats, tension: Floats, sectors: int, wider: Bag | None = None) -> Solution:
    """A start for a bag of several sectors, from the shape (n, 3) and tensions (m,) of one without hinges.

    Nodes and bars of the wider net are numbered row by row, and those that differ by whole sectors one after the other.
    Ropes of ``wider``, which the sector has smeared, pull as these do where they start.
    """
    turned = rotate(positions[:-1, None], np.arange(sectors)[None], sector.net.order).reshape(-1, 3)
    own = np.delete(tension, sector.ropes)
    pulls = np.repeat(own, sectors)
    nodes = [turned, positions[-1:]]
    if wider is not None and len(wider.ropes):
        by_row = np.argsort(sector.bar_band[sector.ropes], kind="stable")
        rows, real = sector.bar_band[sector.ropes][by_row], (sector.rope_share * tension[sector.ropes])[by_row]
        pulls = np.append(pulls, np.interp(wider.bar_band[wider.ropes], rows, real) / wider.rope_share)
        nodes.append(wider.net.positions[len(wider.net.positions) - wider.anchors :])
    return Solution(np.concatenate(nodes), pulls, np.zeros(sector.bands), START)


def laid_out(model: BagModel, shape: MeridianShape) -> Solution:
    """Shape and tensions of the meridian method on the model's net, which has no hinges."""
    g = model.globalisation
    sector = build_bag(
        model.plan, globalisation=g, sectors=1, smeared=True, rows=(shape.x_m[::g], shape.radius_m[::g])
    )
    tension = g * tensions_on(sector, shape, g)
    return all_round_start(
        sector, sector.net.positions, tension, sector.net.order // model.bag.net.order, None if model.smeared else model.bag
    )
