"""Whether an equilibrium is stable: of a sector by all its harmonics, of a full net by its tangent's eigenvalues."""

from dataclasses import dataclass, replace

import numpy as np

from codend.bag.build import build_bag
from codend.equilibrium.bag_model import BagModel
from codend.equilibrium.start_shapes import set_round
from codend.mechanics.problem import Problem
from codend.solvers import newton
from codend.solvers.harmonics import Growth, growing_harmonics, harmonics_of, stiffness_under_tension
from codend.solvers.newton import TangentAtEquilibrium
from codend.solvers.outcome import Solution
from codend.solvers.ring import Ring
from codend.solvers.whole_tangent import FIRST_EIGENVALUES, MOST_EIGENVALUES, WholeTangent


@dataclass(frozen=True)
class Stability:
    """Whether a net in balance stays as it is."""

    stable: str
    """``yes``, ``no`` or ``unknown``."""
    growing: tuple[int, ...] = ()
    """Harmonics of the sector that grow: a change varies so many times round the net."""
    growths: tuple[Growth, ...] = ()
    """What grows, harmonic by harmonic; of a full net, as one of harmonic 0, what was met first."""
    scale: float = float("nan")
    """A bar's stiffness under tension, N/m, beside which growth is weak or strong."""


def tangent_of(model: BagModel, problem: Problem, solution: Solution) -> TangentAtEquilibrium:
    """The tangent at an equilibrium of a model; of a sector whose harmonics can be asked it holds them all."""
    real_ropes = len(model.bag.ropes) > 0 and not model.smeared
    ring = None if model.bag.net.order == 1 or real_ropes else model.ring
    return newton.tangent_at(problem, solution, model.prepared, ring)


def stability_of(model: BagModel, tangent: TangentAtEquilibrium, strongest_alone: bool = False) -> Stability:
    """Stability of an equilibrium; of a sector every harmonic is asked, of a full net its whole tangent.

    Of one of many shapes it is enough which harmonics grow and how strongly, ``strongest_alone``.
    """
    scale = stiffness_under_tension(tangent.problem, tangent.solution)
    if tangent.problem.net.order == 1:
        growth = None if tangent.singular else _growth_of_whole(tangent, scale)
        grows = growth is not None and len(growth.eigenvalues) > 0
        stable = "unknown" if growth is None else "no" if grows else "yes"
        return Stability(stable, (), (growth,) if growth is not None and grows else (), scale)
    if len(model.bag.ropes) > 0 and not model.smeared:
        # a sector with real ropes is so wide that its harmonics cost more than the whole net does
        return Stability(stability_of_whole(_tangent_of_whole(model, tangent), FIRST_EIGENVALUES))
    near = tangent.problem.loading.contact
    if tangent.ring is not None:
        harmonics = growing_harmonics(tangent.ring, scale, strongest_alone)
    else:
        touching = (near.node, near.image)
        ring = Ring(tangent.problem.structure, tangent.problem.bands, touching) if len(near.kind) else model.ring
        harmonics = harmonics_of(tangent.problem, tangent.solution, ring, strongest_alone)
    growing = tuple(growth.harmonic for growth in harmonics.growing)
    stable = "no" if growing else "unknown" if harmonics.undecided else "yes"
    return Stability(stable, growing, harmonics.growing, scale)


def _tangent_of_whole(model: BagModel, tangent: TangentAtEquilibrium) -> TangentAtEquilibrium:
    """The tangent of the whole net at the equilibrium of a sector, under the sector's loads."""
    whole = replace(model, bag=build_bag(model.plan, globalisation=model.globalisation), sectors=None)
    solution = set_round(model.bag, whole.bag, tangent.solution)
    loading = tangent.problem.loading
    catch = loading.catch._replace(
        bar_band=whole.bag.bar_band,
        facet_band=whole.bag.facet_band,
        node_row=whole.bag.node_row,
        row_size=loading.catch.row_size * np.where(loading.catch.row_size > 1.0, model.bag.net.order, 1.0),
    )
    return newton.tangent_at(Problem.of(whole.bag.net, water=loading.water, catch=catch), solution, whole.prepared)


def stability_of_whole(tangent: TangentAtEquilibrium, most: int = MOST_EIGENVALUES) -> str:
    """Stability of a full net, or of moves that are the same in all sectors: ``yes``, ``no`` or ``unknown``."""
    if tangent.singular:
        return "unknown"
    growth = _growth_of_whole(tangent, stiffness_under_tension(tangent.problem, tangent.solution), most)
    return "unknown" if growth is None else "no" if len(growth.eigenvalues) else "yes"


def _growth_of_whole(tangent: TangentAtEquilibrium, scale: float, most: int = MOST_EIGENVALUES) -> Growth | None:
    """What grows of a whole net, nothing of it perhaps; None if that was not found out."""
    found = WholeTangent.at(tangent).growing(scale, most)
    if found is None:
        return None
    eigenvalues, vectors = found
    free = tangent.problem.structure.free > 0.0
    shape = np.zeros(free.shape, dtype=complex)
    if len(eigenvalues):
        shape[free] = vectors[:, 0]
        shape /= shape.reshape(-1)[np.abs(shape).argmax()]
    return Growth(0, eigenvalues, shape)


def ranges_text(numbers: tuple[int, ...]) -> str:
    """Rising whole numbers in short: ``2, 9 to 12``, which no spreadsheet takes for a date."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return ", ".join(f"{part[0]} to {part[-1]}" if len(part) > 1 else f"{part[0]}" for part in parts)
