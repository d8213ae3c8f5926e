"""Whether an equilibrium is stable: of a sector by all its harmonics, of a full net by its tangent's eigenvalues."""

from dataclasses import dataclass, replace

import numpy as np

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.start_shapes import narrowed, set_round
from codend.mechanics.pressure import Catch
from codend.mechanics.problem import Problem
from codend.net.net import rotate
from codend.solvers import newton
from codend.solvers.harmonics import (
    Growth,
    growing_harmonics,
    most_growth,
    softest,
    stiffness_under_tension,
    sway_stiffness,
)
from codend.solvers.newton import TangentAtEquilibrium
from codend.solvers.outcome import Solution
from codend.solvers.ring import Ring
from codend.solvers.whole_tangent import FIRST_EIGENVALUES, MOST_EIGENVALUES, WholeTangent

ASKED_CLOSELY = 6000
"""Unknowns of a net with ropes or windows up to which as many eigenvalues are found as it takes, mostly: slack netting
beside them has many that are hardly none. Of larger ones the first tell, or it is not known."""


@dataclass(frozen=True)
class Stability:
    """Whether a net in balance stays as it is."""

    stable: str
    """``yes``, ``no`` or ``unknown``."""
    growing: tuple[int, ...] = ()
    """Harmonics of the sector that grow: a change varies so many times round the net."""
    growths: tuple[Growth, ...] = ()
    """What grows, harmonic by harmonic; of a full net move by move, each as of harmonic 0, the strongest first."""
    scale: float = float("nan")
    """A bar's stiffness under tension, N/m, beside which growth is weak or strong."""
    sway_n_m: float = float("nan")
    """The force that moves the codline aside over its move, at least, N/m: of kinds of netting that tip by one of them;
    nan of others."""
    complete: bool = True
    """Whether all that grows was found, and not merely what grows most."""
    at_most: float = float("nan")
    """How much what was not found may grow, N/m; nan where that is not known."""


def tangent_of(model: BagModel, problem: Problem, solution: Solution) -> TangentAtEquilibrium:
    """The tangent at an equilibrium of a model; of a sector whose harmonics can be asked it holds them all."""
    real_ropes = len(model.bag.ropes) > 0 and not model.smeared
    ring = None if model.bag.net.order == 1 or real_ropes else model.ring
    return newton.tangent_at(problem, solution, model.prepared, ring)


def stability_of(
    model: BagModel, tangent: TangentAtEquilibrium, thorough: bool = False, strongest_alone: bool = False
) -> Stability:
    """Stability of an equilibrium; of a sector every harmonic is asked, of a full net its whole tangent.

    That is enough to know whether anything grows; ``thorough`` finds all that does of a full net, as far as it can be.
    Of one of many shapes it is enough which harmonics of a sector grow, and about how strongly: ``strongest_alone``.
    """
    scale = stiffness_under_tension(tangent.problem, tangent.solution)
    if tangent.problem.net.order == 1:
        as_sector = _by_harmonics_of_whole(model, tangent, scale) if thorough else None
        if as_sector is not None:
            return as_sector
        found = _of_whole(tangent, scale, thorough, _most_asked(model, tangent))
        sways = thorough and found.stable != "unknown" and model.bag.tips
        return replace(found, sway_n_m=_sway_of_whole(model.bag, tangent)) if sways else found
    if len(model.bag.ropes) > 0 and not model.smeared:
        # a sector with real ropes is so wide that its harmonics cost more than the whole net does
        whole = tangent_of_whole(model, tangent)
        found = _of_whole(whole, scale, thorough, _most_asked(model, whole))
        return replace(found, growths=tuple(_in_one_sector(growth, model.bag) for growth in found.growths))
    near = tangent.problem.loading.contact
    if tangent.ring is not None:
        ring = tangent.ring
    else:
        touching = (near.node, near.image)
        ring = Ring(tangent.problem.structure, tangent.problem.bands, touching) if len(near.kind) else model.ring
        ring.linearise(tangent.problem, tangent.solution)
    if model.smeared and model.near is not None:
        at_most = most_growth(ring, scale)
        return Stability("unknown" if at_most > 0.0 else "yes", scale=scale, complete=at_most == 0.0, at_most=at_most)
    return _by_harmonics(model.bag, ring, scale, strongest_alone)


def _by_harmonics(bag: Bag, ring: Ring, scale: float, strongest_alone: bool = False) -> Stability:
    """By the tangent that the ring took over last."""
    harmonics = growing_harmonics(ring, scale, strongest_alone)
    growing = tuple(growth.harmonic for growth in harmonics.growing)
    stable = "no" if growing else "unknown" if harmonics.undecided else "yes"
    sway_n_m = sway_stiffness(ring) if stable != "unknown" and bag.tips else float("nan")
    complete = not harmonics.undecided and not strongest_alone
    return Stability(stable, growing, harmonics.growing, scale, sway_n_m, complete)


def _by_harmonics_of_whole(model: BagModel, tangent: TangentAtEquilibrium, scale: float) -> Stability | None:
    """That of a whole net in a shape that is the same all round, by one sector of it; None where it is not."""
    bag, plan, loading = model.bag, model.plan, tangent.problem.loading
    weighs = loading.dead.any() or loading.catch.weight_density != 0.0
    if weighs or len(loading.contact.kind) or plan.rope or plan.window:
        return None
    sector = model_of(plan, model.globalisation, 1)
    solution = narrowed(sector.bag, bag, tangent.solution)
    if sector.bag.net.order == 1 or solution is None:
        return None
    problem = Problem.of(sector.bag.net, water=loading.water, weight=False, catch=_catch_in(sector.bag, loading.catch))
    sector.ring.linearise(problem, solution)
    found = _by_harmonics(sector.bag, sector.ring, scale)
    growths = tuple(_set_round(growth, sector.bag, bag) for growth in found.growths)
    return replace(found, growths=growths)


def _set_round(growth: Growth, sector: Bag, whole: Bag) -> Growth:
    """What grows of a sector, as a move of the whole net."""
    order = sector.net.sectors
    turn = np.exp(2j * np.pi * growth.harmonic * np.arange(order) / order)
    moves = growth.shape[:-1].reshape(-1, 1, sector.abreast, 3) * turn[:, None, None]
    images = np.broadcast_to(np.arange(order)[:, None], moves.shape[:-1])
    turned = rotate(moves.real, images, order) + 1j * rotate(moves.imag, images, order)
    return replace(growth, harmonic=0, shape=np.concatenate([turned.reshape(-1, 3), growth.shape[-1:]]))


def _in_one_sector(growth: Growth, sector: Bag) -> Growth:
    """What grows of a whole bag, as the farthest that it moves each knot of one of its sectors in any."""
    moves = np.abs(growth.shape[: len(growth.shape) - 1 - sector.anchors * sector.net.sectors])
    farthest = moves.reshape(-1, sector.net.sectors, sector.abreast, 3).max(axis=1).reshape(-1, 3)
    codline = np.abs(growth.shape[len(moves)])
    return replace(growth, shape=np.concatenate([farthest, [codline], np.zeros((sector.anchors, 3))]))


def tangent_of_whole(model: BagModel, tangent: TangentAtEquilibrium) -> TangentAtEquilibrium:
    """The tangent of the whole net at the equilibrium of a sector, under the sector's loads."""
    whole = replace(model, bag=build_bag(model.plan, globalisation=model.globalisation), sectors=None)
    solution = set_round(model.bag, whole.bag, tangent.solution)
    loading = tangent.problem.loading
    surface = tangent.problem.surface
    law = None if surface is None else surface.law
    problem = Problem.of(whole.bag.net, water=loading.water, catch=_catch_in(whole.bag, loading.catch), contact=law)
    return newton.tangent_at(problem, solution, whole.prepared)


def _catch_in(bag: Bag, catch: Catch) -> Catch:
    """A catch in the rows and bands of another bag of the same plan."""
    return catch._replace(
        bar_band=bag.bar_band, facet_band=bag.facet_band, node_row=bag.node_row, row_size=bag.ring_size
    )


def _most_asked(model: BagModel, whole: TangentAtEquilibrium) -> int:
    """Eigenvalues of a whole net that are found at a time before it is not known whether one grows."""
    geared = (len(model.bag.ropes) > 0 and not model.smeared) or len(model.bag.windows) > 0
    large = np.count_nonzero(whole.problem.structure.free) > ASKED_CLOSELY
    return FIRST_EIGENVALUES if geared and large else MOST_EIGENVALUES


def stability_of_whole(tangent: TangentAtEquilibrium, most: int = MOST_EIGENVALUES) -> str:
    """Stability of a full net, or of moves that are the same in all sectors: ``yes``, ``no`` or ``unknown``."""
    return _of_whole(tangent, stiffness_under_tension(tangent.problem, tangent.solution), False, most).stable


def _of_whole(tangent: TangentAtEquilibrium, scale: float, thorough: bool, most: int = MOST_EIGENVALUES) -> Stability:
    """Stability of a full net by the eigenvalues of its tangent; all that grow if it is to be ``thorough``."""
    if tangent.singular:
        return Stability("unknown", scale=scale, complete=False)
    found = WholeTangent.at(tangent).growing(scale, most, thorough)
    if found is None:
        return Stability("unknown", scale=scale, complete=False)
    free = tangent.problem.structure.free > 0.0
    growths = []
    for eigenvalue, vector in zip(found.eigenvalues, found.vectors.T, strict=True):
        shape = np.zeros(free.shape, dtype=complex)
        shape[free] = vector
        growths.append(Growth(0, np.array([eigenvalue]), shape / shape.reshape(-1)[np.abs(shape).argmax()]))
    stable = "no" if growths else "yes" if found.complete else "unknown"
    return Stability(stable, (), tuple(growths), scale, complete=found.complete, at_most=found.at_most)


def _sway_of_whole(bag: Bag, tangent: TangentAtEquilibrium) -> float:
    """See ``Stability.sway_n_m``: of a full net by its tangent's own factors."""
    codline = len(bag.net.positions) - 1 - bag.anchors
    moves = []
    for way in (1, 2):
        force = np.zeros_like(bag.net.positions)
        force[codline, way] = 1.0
        moves.append(newton.moved_by(tangent, force)[codline, 1:])
    return softest(np.array(moves))


def ranges_text(numbers: tuple[int, ...]) -> str:
    """Rising whole numbers in short: ``2, 9 to 12``, which no spreadsheet takes for a date."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return ", ".join(f"{part[0]} to {part[-1]}" if len(part) > 1 else f"{part[0]}" for part in parts)
