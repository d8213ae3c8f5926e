"""Shapes and tensions to start from that nobody has solved on the net itself."""

from dataclasses import replace

import numpy as np

from codend.bag.bag import Bag
from codend.bag.bag_kernels import ring_means
from codend.bag.build import build_bag
from codend.bag.measure_kernels import mean_by
from codend.bag.meridian.plan_case import tensions_on
from codend.bag.meridian.problem import MeridianShape
from codend.equilibrium.bag_model import BagModel
from codend.net.net import Floats, Net, rotate
from codend.plan.merging import rows_merged
from codend.solvers.mirror import ALIKE
from codend.solvers.outcome import START, Solution


def all_round_start(
    sector: Bag, positions: Floats, tension: Floats, sectors: int, wider: Bag | None = None, abreast: int = 1
) -> Solution:
    """A start for a bag of several sectors, from the shape (n, 3) and tensions (m,) of one without hinges.

    Nodes and bars of the wider net are numbered row by row, and those that differ by whole sectors one after the other.
    Ropes of ``wider``, which the sector has smeared, pull as these do where they start. What is given may itself be so
    many narrower sectors ``abreast``, numbered likewise.
    """
    places = positions[:-1].reshape(-1, 1, abreast, 3)
    turned = rotate(places, np.arange(sectors)[None, :, None], sector.net.order).reshape(-1, 3)
    own = np.delete(tension, sector.ropes)
    pulls = np.repeat(own.reshape(-1, 1, abreast), sectors, axis=1).ravel()
    nodes = [turned, positions[-1:]]
    if wider is not None and len(wider.ropes):
        pulls = np.append(pulls, _rope_pulls(sector, tension, wider))
        nodes.append(wider.net.positions[len(wider.net.positions) - wider.anchors :])
    return Solution(np.concatenate(nodes), pulls, np.zeros(sector.bands), START)


def _rope_pulls(sector: Bag, tension: Floats, wider: Bag) -> Floats:
    """Tensions of the ropes of a wider bag, (ropes,), which pull as the smeared ones of a sector do in their rows."""
    by_row = np.argsort(sector.bar_band[sector.ropes], kind="stable")
    rows, real = sector.bar_band[sector.ropes][by_row], (sector.rope_share * tension[sector.ropes])[by_row]
    merged = sector.bands // wider.bands
    return np.asarray(np.interp(merged * wider.bar_band[wider.ropes], rows, real) / wider.rope_share)


def windowed_start(wider: BagModel, sector: Bag, found: Solution) -> Solution:
    """A start for a full net with windows, from the equilibrium of a sector of the netting they are let into.

    Its rows are those of the sector, and its bars pull as theirs do; those of a window, more or fewer, share the pull.
    """
    whole = wider.bag
    laid = build_bag(wider.plan, globalisation=wider.globalisation, rows=ring_means(sector.structure, found.positions))
    pulls = np.zeros(len(whole.net.bars))
    for twine in (True, False):
        there = whole.bar_is_twine == twine
        pulls[there] = _band_means(sector, found.bar_tension, twine)[whole.bar_band[there]]
    if len(whole.ropes):
        pulls[whole.ropes] = _rope_pulls(sector, found.bar_tension, whole)
    for number, (window, hole) in enumerate(zip(wider.plan.window, wider.plan.holes, strict=True)):
        lines = (
            window.meshes_round * window.rows_per_mesh / (hole.across * wider.plan.netting[hole.section].rows_per_mesh)
        )
        own = np.flatnonzero(whole.bar_window == number)
        pulls[own] /= lines
        if not window.kind.staggered:
            ends = laid.net.positions[whole.net.bars[own]]
            pulls[own[np.abs(ends[:, 1, 0] - ends[:, 0, 0]) < 0.1 * whole.net.bar_length[own]]] *= 0.1
    return Solution(laid.net.positions, pulls, np.zeros(whole.bands), START)


def windows_let_into(wider: BagModel, sector: Bag, found: Solution) -> Solution:
    """A start for a full net with windows, from the equilibrium of a sector of the same netting between its ropes.

    Knots outside the windows are where they are in the sector set all round, a window's where the netting is that it
    takes the place of. Ropes and netting outside pull as there, a window's twine as a mean of its band.
    """
    from scipy.spatial import cKDTree

    plan, g, rows = wider.plan, wider.globalisation, ring_means(sector.structure, found.positions)
    plain = build_bag(plan, globalisation=g, sectors=sector.net.sectors, rows=rows)
    laid = build_bag(plan, globalisation=g, rows=rows).net
    there = set_round(sector, plain, found)
    away, near = map(np.asarray, cKDTree(plain.net.positions).query(laid.positions, k=4))
    weight = 1.0 / (away + 1e-9 * float(laid.bar_length.min()))
    moved = (weight[:, :, None] * (there.positions - plain.net.positions)[near]).sum(axis=1)
    positions = laid.positions + moved / weight.sum(axis=1)[:, None]
    start = windowed_start(wider, sector, found)
    middles = (net.positions[net.bars].mean(axis=1) for net in (plain.net, laid))
    away, bar = map(np.asarray, cKDTree(next(middles)).query(next(middles)))
    pulls = np.where(away < 1e-6 * laid.bar_length, there.bar_tension[bar], start.bar_tension)
    return replace(start, positions=np.where(laid.fixed, laid.positions, positions), bar_tension=pulls)


def set_round(sector: Bag, whole: Bag, solution: Solution) -> Solution:
    """The equilibrium of a sector with its ropes as one of the whole bag."""
    order, abreast, anchors = sector.net.sectors, sector.abreast, len(sector.net.positions) - sector.anchors

    def repeated(values: Floats) -> Floats:
        return np.repeat(values.reshape(-1, 1, abreast, *values.shape[1:]), order, axis=1)

    places = solution.positions[: anchors - 1]
    nodes = repeated(places)
    turned = rotate(nodes, np.broadcast_to(np.arange(order)[:, None], nodes.shape[:-1]), order).reshape(-1, 3)
    pulls = [repeated(np.delete(solution.bar_tension, sector.ropes)).ravel()]
    of_ropes, table = solution.bar_tension[sector.ropes], sector.rope_name // 1000
    pulls += [np.tile(of_ropes[table == which], order) for which in np.unique(table)]
    held = whole.net.positions[len(whole.net.positions) - whole.anchors :]
    codline = solution.positions[anchors - 1 : anchors]
    positions = np.concatenate([turned, codline, held])
    return replace(solution, positions=positions, bar_tension=np.concatenate(pulls))


def narrowed(sector: Bag, whole: Bag, solution: Solution) -> Solution | None:
    """The equilibrium of a whole bag as one of its sector, neither with ropes; None if it is not the same all round."""
    order, abreast = sector.net.sectors, sector.abreast
    alike = len(sector.net.positions) - 1, len(sector.net.bars)
    if alike[0] * order != len(whole.net.positions) - 1 or alike[1] * order != len(whole.net.bars):
        return None
    places = solution.positions[:-1].reshape(-1, order, abreast, 3)[:, 0].reshape(-1, 3)
    pulls = solution.bar_tension.reshape(-1, order, abreast)[:, 0].ravel()
    codline = solution.positions[-1:] * [1.0, 0.0, 0.0]
    found = replace(solution, positions=np.concatenate([places, codline]), bar_tension=pulls)
    round_again = set_round(sector, whole, found)
    off = np.abs(round_again.positions - solution.positions).max() / whole.net.bar_length.min()
    uneven = np.abs(round_again.bar_tension - solution.bar_tension).max() / solution.mean_tension
    return found if off <= ALIKE and uneven <= ALIKE else None


def _band_means(bag: Bag, tension: Floats, twine: bool) -> Floats:
    """Mean tension of the twines, or of the knots, of every band, 0 where it has none, (bands,)."""
    band = np.where(bag.bar_is_twine == twine, bag.bar_band, -1)
    band[bag.ropes] = -1
    return np.nan_to_num(mean_by(band, tension, bag.bands))


def along_the_rows(narrow: Bag, solution: Solution, model: BagModel) -> Solution:
    """A start for a wide sector or a full net of joined or tapering sections: the rows and tensions of a narrow one.

    That has nearly the ratio of their counts. Every ring is a circle at the mean place of the narrow one's knots, every
    twine and knot of a band pulls as the mean of its own do, every rope as the smeared ones.
    """
    merged = narrow.bands // model.bag.bands
    x, radius = (values[::merged] for values in ring_means(narrow.structure, solution.positions))
    bag = build_bag(
        model.plan, globalisation=model.globalisation, sectors=model.sectors, rows=(x, radius), near=model.near
    )
    of_twine, of_knots = (_band_means(narrow, solution.bar_tension, twine)[::merged] for twine in (True, False))
    # straps begin slack
    pulls = merged * np.where(bag.bar_is_twine, of_twine[bag.bar_band], of_knots[bag.bar_band])
    pulls[bag.straps] = 0.0
    if len(bag.ropes):
        pulls[bag.ropes] = _rope_pulls(narrow, solution.bar_tension, bag)
    return Solution(bag.net.positions, pulls, np.zeros(bag.bands), START)


def laid_out(model: BagModel, shape: MeridianShape) -> Solution:
    """Shape and tensions of the meridian method on the model's net, which has no hinges."""
    g, bands = model.globalisation, model.bag.bands
    rows = np.rint(np.append(0.0, np.cumsum(rows_merged(model.plan.netting, bands, g)))).astype(np.int32)
    places = shape.x_m[rows], shape.radius_m[rows]
    sector = build_bag(model.plan, globalisation=g, sectors=1, smeared=True, rows=places)
    tension = g * tensions_on(sector, shape, rows)
    sectors = sector.net.sectors // model.bag.net.sectors
    return all_round_start(sector, sector.net.positions, tension, sectors, model.bag)


def carried_over(solution: Solution, of: Net, to: Net) -> Solution:
    """The equilibrium of a net as a start for another with the same bars, held where that one is.

    It is longer by as much as the bars are, and wider as they and the sectors all round are. Under the same pressure
    the tension of a bar rises with the netting's section over the number of bars round it.
    """
    longer, more = float(to.bar_length.mean() / of.bar_length.mean()), to.order / of.order
    x, y, z = solution.positions.T
    radius, azimuth = longer * more * np.hypot(y, z), np.arctan2(z, y) / more
    moved = np.stack([longer * x, radius * np.cos(azimuth), radius * np.sin(azimuth)], axis=1)
    tension = longer**2 * more * solution.bar_tension
    return replace(solution, positions=np.where(to.fixed, to.positions, moved), bar_tension=tension, midway=None)
