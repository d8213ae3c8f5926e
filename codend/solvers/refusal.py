"""What an answer in balance is refused for: nets that have passed through themselves, and catches that cannot be."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.mechanics import possible
from codend.mechanics.piercing import TOUCHING, first_pierced, touching_m
from codend.mechanics.problem import Problem
from codend.mechanics.rings import first_crossed_ring
from codend.mechanics.sheet import Sheet, laced
from codend.net.net import Floats
from codend.solvers.outcome import Outcome

LARGEST_TURN = 0.5 * math.pi
"""Turn about its axis, from entry to codline, up to which a net is not wrung, rad."""
GATHERED = 0.25
"""Of the shortest bar: depth up to which the last mesh of a net with ropes touches itself. Ropes shorter than netting
fold it where the codline gathers it. Of the median bar, in the mesh ahead of a row that takes up
more than two nodes in one."""
ROUND_OFF = 1e-9
"""Of the shortest bar."""
_NOT_ASKED = np.zeros(0)
"""Of the catch."""
_IMPOSSIBLE = {
    possible.NO_VOLUME: (Outcome.NO_VOLUME, "volume {:.2g} m3"),
    possible.FRONT_BEHIND: (Outcome.FRONT_BEHIND, "front {:.2g} m ahead of the codline"),
    possible.INSIDE_OUT: (Outcome.INSIDE_OUT, "share that faces inward {:.2f}"),
}


class Refusal(NamedTuple):
    """How a solve ends instead."""

    outcome: Outcome
    where: str
    """What was seen, and where in the net."""


def refusal(problem: Problem, position: Floats, share: Floats) -> Refusal | None:
    """What speaks against an equilibrium with nodes at ``position`` (n, 3) and so much of each band in the catch."""
    # no bag, which a codline closes, but netting on which a pressure acts, holds no catch
    is_bag = problem.loading.catch.row_size[-1] == 1.0
    seen = _glance(problem, position, share if is_bag else _NOT_ASKED)
    through = _passage(problem, position, seen, gathered=True)
    if through is not None or seen.code == possible.POSSIBLE:
        return through
    outcome, told_by = _IMPOSSIBLE[seen.code]
    return Refusal(outcome, told_by.format(seen.number))


def passage(problem: Problem, position: Floats, gathered: bool = True) -> Refusal | None:
    """Where a net has passed through itself, or that it is wrung; None where it has not.

    ``gathered`` asks it of the last band as well, whose twines are gathered at the codline; else no band is named.
    """
    return _passage(problem, position, _glance(problem, position, _NOT_ASKED), gathered)


class _Seen(NamedTuple):
    """See ``possible.glance``."""

    turn: float
    through: int
    is_one_to_one: bool
    code: int
    number: float


def _glance(problem: Problem, position: Floats, share: Floats) -> _Seen:
    s, catch = problem.structure, problem.loading.catch
    return _Seen(*possible.glance(position, s, catch, problem.rings, share, *problem.tube))


def _passage(problem: Problem, position: Floats, seen: _Seen, gathered: bool) -> Refusal | None:
    if problem.surface is not None:
        return _through_surface(problem, position, problem.surface.sheet)
    catch = problem.loading.catch
    round_axis = _turned(problem, seen)
    if round_axis is None and _has_rings_that_may_cross(problem):
        round_axis = _crossed(problem, position, touching_m(problem.structure.length, problem.structure.diameter))
    if round_axis is not None:
        return round_axis
    if seen.is_one_to_one:
        return None
    touching = touching_m(problem.structure.length, problem.structure.diameter)
    bar, facet = first_pierced(position, *_sheet(problem, 0 if gathered else 1), touching)
    if bar < 0:
        return None
    if not gathered or not catch.row_size.any():
        return Refusal(Outcome.PASSED_THROUGH, "a bar pierces the netting")
    band, met = catch.bar_band[bar] + 1, catch.facet_band[facet] + 1
    gathered_bands = _ahead_of_takings_up(problem)
    if gathered_bands[band - 1] and gathered_bands[met - 1]:
        deeper = GATHERED * float(np.median(problem.structure.length))
        elsewhere = first_pierced(position, *_sheet(problem, gathered_bands), touching)[0]
        if elsewhere < 0 and first_pierced(position, *_sheet(problem), deeper)[0] < 0:
            return None
    if problem.structure.is_rope.any() and min(band, met) >= problem.bands - 1:
        deeper = GATHERED * float(problem.structure.length.min())
        ahead = first_pierced(position, *_sheet(problem, 2), touching)[0]
        if ahead < 0 and first_pierced(position, *_sheet(problem), deeper)[0] < 0:
            return None
    return Refusal(Outcome.PASSED_THROUGH, f"a bar of band {band} pierces band {met} of {problem.bands}")


def _ahead_of_takings_up(problem: Problem) -> NDArray[np.bool_]:
    """Bands in the mesh ahead of a row that takes up more than two of their nodes in one, (bands,)."""
    sizes = problem.loading.catch.row_size
    ahead = np.zeros(problem.bands, dtype=bool)
    for row in np.flatnonzero(2.0 * sizes[1:-1] < sizes[:-2]) + 1:
        ahead[max(row - 2, 0) : row] = True
    return ahead


def _through_surface(problem: Problem, position: Floats, sheet: Sheet) -> Refusal | None:
    """Where the surface that contact acts on is pierced, by any depth but round-off."""
    (first, second), turn = sheet.edge.T.copy(), sheet.edge_image[:, 1].copy()
    depth = ROUND_OFF * float(problem.structure.length.min())
    whole = np.ones(len(sheet.face))
    edge, _ = first_pierced(
        position, first, second, turn, sheet.face, sheet.face_image, whole, problem.structure.order, depth
    )
    if edge < 0:
        return None
    return Refusal(Outcome.PASSED_THROUGH, f"the side from node {first[edge]} to {second[edge]} pierces the netting")


def layers_touch(problem: Problem, position: Floats) -> bool:
    """Whether netting lies on netting: middle lines of twine are on the wrong side of each other."""
    seen = _glance(problem, position, _NOT_ASKED)
    if _turned(problem, seen) is not None:
        return True
    touching = TOUCHING * float(problem.structure.length.min())
    if _has_rings_that_may_cross(problem) and _crossed(problem, position, touching) is not None:
        return True
    return not seen.is_one_to_one and bool(first_pierced(position, *_sheet(problem), touching)[0] >= 0)


def _turned(problem: Problem, seen: _Seen) -> Refusal | None:
    """Whether the rings of knots of a bag are turned against each other."""
    if seen.through >= 0:
        return Refusal(Outcome.PASSED_THROUGH, f"band {seen.through + 1} of {problem.bands} at the axis")
    if abs(seen.turn) > LARGEST_TURN:
        return Refusal(Outcome.WRUNG, f"{math.degrees(seen.turn):.0f} degrees")
    return None


def _has_rings_that_may_cross(problem: Problem) -> bool:
    """Not those of one or two knots a sector: each is sound, or a bar of it pierces the netting."""
    return problem.rings.node.size > 0 and (
        problem.structure.order == 1.0 or bool(problem.loading.catch.row_size.max() > 2.0)
    )


def _crossed(problem: Problem, position: Floats, touching: float) -> Refusal | None:
    """Whether a ring of knots crosses itself, by more than a depth."""
    row, times = first_crossed_ring(position, *problem.rings, problem.structure.order, touching)
    if row < 0:
        return None
    runs = f"runs {times} times round and " if times != 1 else ""
    return Refusal(Outcome.PASSED_THROUGH, f"ring {row} of {problem.bands} {runs}crosses itself")


def told(outcome: Outcome, refused: Refusal | None) -> str:
    """An outcome in words, and where in the net what it was refused for."""
    return outcome.value if refused is None or refused.outcome is not outcome else f"{outcome.value} ({refused.where})"


def _sheet(problem: Problem, left_out: int | NDArray[np.bool_] = 0) -> tuple:
    """Bars and facets as ``first_pierced`` takes them, without some bands: which, (bands,), or how many at the end."""
    s, catch = problem.structure, problem.loading.catch
    if isinstance(left_out, int) and left_out == 0 and not s.is_rope.any():
        return s.first, s.second, s.image, s.facets, s.facet_image, s.facet_weight, s.order
    bars = ~laced(s.is_rope, s.first, s.second, s.facets)
    facets = np.ones(len(s.facets), dtype=bool)
    if not isinstance(left_out, int):
        bars, facets = bars & ~left_out[catch.bar_band], ~left_out[catch.facet_band]
    elif left_out > 0:
        last = problem.bands - left_out
        bars, facets = bars & (catch.bar_band < last), catch.facet_band < last
    of_facets = s.facets[facets], s.facet_image[facets], s.facet_weight[facets]
    return s.first[bars], s.second[bars], s.image[bars], *of_facets, s.order
