"""Other shapes in which a scene's netting is in balance, and by how much what is told of it differs in them.

Slack netting, and netting that lies on netting, rests in more than one shape beside each other, and which of them is
found goes by the way on which it is sought. So it is sought on others as well: with a barrier that begins lower and
higher, shaken a little and more and loosened again, shaken as a whole, and let go at rest in still water and moved
gently into the current. These need not lead to all there are: errors are ``COVERING`` times the largest difference of
those found that would stay, and where netting lies on netting no less than what is assumed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.scenes.equilibrium import NEARBY, SHAKEN, apart, contact_law, in_still_water, shaken, stays
from codend.scenes.frame_measures import frame_rows
from codend.scenes.measures import SceneResult
from codend.scenes.netting_measures import contact_share, netting_rows, volume_m3
from codend.solvers import gentle, interior_point
from codend.solvers.half import half_of
from codend.solvers.interior_point import InteriorPointSettings
from codend.solvers.outcome import START, Solution
from codend.solvers.reactions import loads_and_supports
from codend.solvers.refusal import passage

LOWER, HIGHER = InteriorPointSettings(first_barrier=0.01), InteriorPointSettings(first_barrier=0.2)
"""Barriers that begin at a fifth and four times of the usual one: netting folds elsewhere."""
HARDER = 0.1
"""Of the shortest bar of netting: how far nodes are shaken where it is more."""
ALIKE = 1e-6
"""Of the shortest bar: how unlike the sides of a shape are that is taken as mirrored."""
COVERING = 3.0
"""Errors over the largest difference of the shapes found: on ways that are not gone here random cages changed by up to
2.5 times that (``python -m validation.cage --covered 24 --seed 31``)."""
LEAST_SHARE, LEAST_OF_A_BAR, LEAST_DEG = 5e-3, 0.1, 1.0
"""Errors at least, of netting that lies on netting, assumed: of volumes, and of forces over the drag of all; of places,
over the median bar; of openings."""
MOST_BARS = 3000
"""Of a net whose other shapes are sought: some ten seconds."""


def other_shapes(result: SceneResult) -> list[SceneResult]:
    """Shapes found in balance on other ways, that of the result among them where a way leads back to it.

    None of scenes that were not found in balance, without netting, with more than ``MOST_BARS`` bars or on a frame
    afloat.
    """
    problem, built = result.built.problem, result.built
    if not (result.converged and built.sheet_nodes) or problem.body is not None or len(problem.net.bars) > MOST_BARS:
        return []
    touching = problem
    if problem.surface is None and built.scene.model.contact is not False and len(problem.net.facets):
        touching = problem.touching_by(contact_law(problem, result.solution.mean_tension or None))
    tolerance, found = built.scene.model.tolerance, []
    for solution in _on_other_ways(touching, result.solution, tolerance):
        if not solution.report.outcome.converged or passage(touching, solution.positions) is not None:
            continue
        there = touching.touching_at(solution.positions)
        if stays(there, solution):
            found.append(SceneResult(replace(built, problem=there), solution, *loads_and_supports(there, solution)))
    return found


def not_sought(result: SceneResult, others: Sequence[SceneResult]) -> list[str]:
    """What a reader must know where errors that cover other shapes are not told."""
    if others or not (result.converged and result.built.sheet_nodes):
        return []
    if result.built.problem.body is not None:
        why = "of a frame afloat it is not asked"
    elif len(result.built.problem.net.bars) > MOST_BARS:
        why = f"of a net of more than {MOST_BARS} bars it is not asked"
    else:
        why = "no other way to look for one led anywhere"
    return [f"Whether this netting is in balance in other shapes as well is not known ({why}): errors are left empty."]


def shape_errors(result: SceneResult, others: Sequence[SceneResult]) -> dict[str, float]:
    """Errors that cover the other shapes, for the row of ``results.csv``; nan where none were found."""
    here = result.solution.positions
    moved = [float(np.linalg.norm(other.solution.positions - here, axis=1).max()) for other in others]
    volume = volume_m3(result.built, here)
    changed = [abs(volume_m3(other.built, other.solution.positions) - volume) for other in others]
    lies = _lies_on_netting(result)
    bar = float(np.median(result.built.problem.net.bar_length))
    return {
        "volume_error_m3": _covering(changed, lies * LEAST_SHARE * volume),
        "shape_error_m": _covering(moved, lies * LEAST_OF_A_BAR * bar),
    }


def netting_errors(result: SceneResult, others: Sequence[SceneResult]) -> list[dict[str, float]]:
    """The same of every sheet, for the rows of ``netting.csv``.

    Of forces that of the sheet of which they change most: which sheet meets the current is what shapes differ in.
    """
    own, *there = (_netting_rows(one) for one in (result, *others))
    lies, dragged = _lies_on_netting(result), sum(row["drag_n"] for row in own)

    def changes(name: str) -> list[list[float]]:
        """By sheet and shape."""
        return [[abs(rows[k][name] - row[name]) for rows in there] for k, row in enumerate(own)]

    forces = {
        error: _covering([change for of_sheet in changes(name) for change in of_sheet], lies * LEAST_SHARE * dragged)
        for error, name in (("drag_error_n", "drag_n"), ("lift_error_n", "lift_n"))
    }
    return [
        forces | {"opening_error_deg": _covering(of_sheet, lies * LEAST_DEG)} for of_sheet in changes("opening_deg")
    ]


def frame_errors(result: SceneResult, others: Sequence[SceneResult]) -> list[dict[str, float]]:
    """The same of what pulls at the frame, for the row of ``frame.csv``; none of a scene without a frame."""
    pulls = [[_pull(row) for row in _frame_rows(one)] for one in (result, *others)]
    least = _lies_on_netting(result) * LEAST_SHARE * sum(row["drag_n"] for row in _netting_rows(result))
    return [
        {"pull_error_n": _covering([float(np.linalg.norm(pull - own)) for pull in there], least)}
        for own, *there in zip(*pulls, strict=True)
    ]


def _covering(changes: Sequence[float], least: float) -> float:
    """The error that covers changes; nan of none."""
    return max(COVERING * max(changes), least) if changes else np.nan


def _lies_on_netting(result: SceneResult) -> bool:
    return contact_share(result.built, result.solution.positions) > 0.0


def _netting_rows(result: SceneResult) -> list[dict[str, Any]]:
    return netting_rows(result.built, result.solution.positions, result.solution.bar_tension)


def _frame_rows(result: SceneResult) -> list[dict[str, Any]]:
    return frame_rows(result.built, result.solution.positions, result.support)


def _pull(row: dict[str, Any]) -> Floats:
    return np.array([row[f"pull_{axis}_n"] for axis in "xyz"])


def _on_other_ways(whole: Problem, known: Solution, tolerance: float) -> Iterator[Solution]:
    """Where other ways lead, shapes of the whole net; those of a mirrored shape are gone by one half, but for one."""
    half = half_of(whole)
    bar = float(whole.net.bar_length[~whole.net.bar_is_rope].min())
    if half is not None and half.unlike_m(known.positions) > ALIKE * bar:
        half = None
    yield _from_shaken(SHAKEN, NEARBY, whole, known, tolerance)
    if half is None:
        yield from (way(whole, known, tolerance) for way in _WAYS)
        return
    part = half.problem
    if whole.surface is not None:
        part = part.touching_by(whole.surface.law)
    for way in _WAYS:
        found = half.whole(way(part, half.own(known), tolerance))
        meets = found.report.outcome.converged and passage(whole, found.positions) is not None
        yield way(whole, known, tolerance) if meets else found


def _from_as_built(settings: InteriorPointSettings, problem: Problem, known: Solution, tolerance: float) -> Solution:
    if problem.surface is not None and not apart(problem, problem.net.positions):
        return _nowhere(known)
    return interior_point.solve(problem, tolerance, None, settings)


def _from_shaken(
    far: float, settings: InteriorPointSettings, problem: Problem, known: Solution, tolerance: float
) -> Solution:
    return interior_point.solve(problem, tolerance, shaken(problem, known, far), settings)


def _from_rest(problem: Problem, known: Solution, tolerance: float) -> Solution:
    if not problem.loading.water.flow.any():
        return _nowhere(known)
    rest = in_still_water(problem, tolerance)
    if not rest.report.outcome.converged or (problem.surface is not None and not apart(problem, rest.positions)):
        return _nowhere(known)
    return gentle.solve(problem.touching_at(rest.positions), tolerance, rest)


_WAYS = (
    partial(_from_as_built, LOWER),
    partial(_from_as_built, HIGHER),
    partial(_from_shaken, SHAKEN, InteriorPointSettings()),
    partial(_from_shaken, HARDER, NEARBY),
    _from_rest,
)
"""Of a problem, the shape known of it and a tolerance."""


def _nowhere(known: Solution) -> Solution:
    """What a way ends in that cannot be gone."""
    return replace(known, report=START)
