"""Equilibrium of a scene: by the ordinary solvers, and through the interior under contact where netting may meet.

In a current the net is let go as it was placed, with its sheets pressing on each other where they meet. If that leads
nowhere, and in still water, contact is left out if it is not needed: a shape that is in balance without it, and in
which nothing passes through anything, stands. Else the net is let go at rest in still water, and follows the current,
gently at last.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from codend.mechanics.body import place, pose_of
from codend.mechanics.contact import add_force
from codend.mechanics.problem import Problem
from codend.mechanics.sheet import Sheet
from codend.mechanics.surface import ContactLaw
from codend.scenes.by_motion import calm_shapes
from codend.solvers import floating, gentle, in_turns, interior_point
from codend.solvers.dynamic_relaxation import as_built, reference_tension
from codend.solvers.interior_point import InteriorPointSettings
from codend.solvers.outcome import Progress, Solution, Solver
from codend.solvers.refusal import passage
from codend.solvers.solve import find_equilibrium, polished

OF_A_BAR = 0.05
"""Distance at which contact begins, over the shortest bar of netting."""
PUSH = 0.5
"""What sheets press on each other with at half of that distance, over the mean tension of the bars."""
UNDER_CONTACT: tuple[Solver, ...] = (interior_point.solve, gentle.solve)
NEARBY = InteriorPointSettings(first_barrier=1e-3)
"""Of a net that is followed from an equilibrium near by."""
APART = 1e-3
"""Least distance of parts in a start for contact, over that at which it begins: nearer ones would leap apart."""


def find(
    problem: Problem,
    tolerance: float,
    contact: bool,
    progress: Progress | None = None,
    sheet: Sheet | None = None,
) -> tuple[Problem, Solution]:
    """Equilibrium of a scene, and the problem with the contact that acts in it.

    Args:
        problem: the net under its loads, without contact.
        tolerance: largest residual and axial imbalance.
        contact: whether netting that meets netting may press on it.
        progress: told the residual now and then.
        sheet: its surface, where that is not to be divided anew (``Problem.touching_by``).
    """
    if not contact or len(problem.net.facets) == 0:
        return problem, find_equilibrium(problem, tolerance, progress=progress)
    if problem.body is not None:
        return _afloat(problem, tolerance, progress)
    touching, attempts, spent_ms = problem.touching_by(contact_law(problem), sheet), [], 0.0
    flowing = bool(problem.loading.water.flow.any())
    if flowing and apart(touching, problem.net.positions):
        found = interior_point.solve(touching, tolerance, progress=progress)
        if found.report.outcome.converged:
            return _as_it_touches(problem, touching.touching_at(found.positions), found, tolerance, progress)
        attempts, spent_ms = list(found.report.attempts), found.report.solve_ms
    at_rest = None if flowing else _at_rest(problem, tolerance, progress)
    found = interior_point.solve(problem, tolerance, progress=progress) if at_rest is None else at_rest
    attempts += found.report.attempts
    spent_ms += found.report.solve_ms
    if found.report.outcome.converged:
        if passage(touching, found.positions) is None:
            return problem, polished(problem, tolerance, found, progress)
        attempts.append("in that shape netting passes through netting: contact is needed")
    started = False
    for start, law, solvers in _starts(touching, tolerance, at_rest, progress):
        started = True
        attempts += start.report.attempts if start is not at_rest else ()
        touching = problem.touching_by(law, sheet).touching_at(start.positions)
        for solve in solvers:
            found = solve(touching, tolerance, start, progress=progress)
            attempts += found.report.attempts
            spent_ms += found.report.solve_ms
            if found.report.outcome.converged:
                break
        if found.report.outcome.converged:
            touching = touching.touching_at(found.positions)
            break
    if not started:
        return problem, find_equilibrium(problem, tolerance, progress=progress)
    return touching, replace(found, report=replace(found.report, attempts=tuple(attempts), solve_ms=spent_ms))


def from_there(problem: Problem, tolerance: float, start: Solution) -> tuple[Problem, Solution] | None:
    """Equilibrium under contact by gentle steps from a shape; None if it passes through itself, or none was found."""
    touching = problem.touching_by(contact_law(problem, start.mean_tension))
    if not apart(touching, start.positions):
        return None
    touching = touching.touching_at(start.positions)
    found = gentle.solve(touching, tolerance, start)
    return (touching.touching_at(found.positions), found) if found.report.outcome.converged else None


def _as_it_touches(
    problem: Problem, touching: Problem, found: Solution, tolerance: float, progress: Progress | None
) -> tuple[Problem, Solution]:
    """An equilibrium under contact, and the problem: without contact where nothing presses on anything there."""
    push = np.zeros_like(found.positions)
    add_force(found.positions, touching.loading.contact, push)
    return (touching, found) if push.any() else (problem, polished(problem, tolerance, found, progress))


def _afloat(problem: Problem, tolerance: float, progress: Progress | None) -> tuple[Problem, Solution]:
    """The same of a net with a frame that floats: at once, without contact where nothing touches; else in turns.

    Contact begins with the netting as it was placed, under the frame where it floats if netting may pass through
    netting; so do the turns.
    """
    body = problem.body
    assert body is not None
    touching = problem.touching_by(contact_law(problem))
    assert touching.surface is not None
    sheet = touching.surface.sheet
    found, positions = floating.solution_and_shape(problem, tolerance, progress=progress)
    if found.report.outcome.converged and passage(touching, found.positions) is None:
        return problem, found
    if positions is None:
        return problem, found
    # netting goes along as it was placed, ropes lie as they then do
    built = problem.net.positions
    before, pose = pose_of(body, built), pose_of(body, positions)
    sheets = np.setdiff1d(problem.net.facets, np.flatnonzero(problem.net.fixed.any(axis=1)))
    positions[sheets] = pose.origin + (built[sheets] - before.origin) @ (pose.turn @ before.turn.T).T
    place(body, pose, positions)
    attempts, spent_ms = found.report.attempts, found.report.solve_ms
    touching = problem.touching_by(contact_law(problem), sheet).touching_at(positions)
    if apart(touching, positions):
        begun = replace(as_built(problem), positions=positions.copy())
        found = floating.solve(touching, tolerance, begun, progress)
        attempts, spent_ms = (*attempts, *found.report.attempts), spent_ms + found.report.solve_ms
        if found.report.outcome.converged:
            found = replace(found, report=replace(found.report, attempts=attempts, solve_ms=spent_ms))
            return touching.touching_at(found.positions), found

    def held(net: Problem, start: Solution | None) -> tuple[Problem, Solution]:
        if start is None or net.surface is None:
            return find(net, tolerance, True, progress, sheet)
        net = net.touching_at(start.positions)
        found = interior_point.solve(net, tolerance, start, NEARBY, progress)
        if not found.report.outcome.converged:
            found = gentle.solve(net, tolerance, start, progress=progress)
        if not found.report.outcome.converged:
            return net, found
        # lengths met to the tolerance leave tensions of taut moorings off by more than the frame may feel
        found = polished(net, tolerance, found, progress)
        return net.touching_at(found.positions), found

    moved = replace(problem, net=replace(problem.net, positions=positions))
    settled, turned = in_turns.solve(moved, tolerance, held)
    attempts, spent_ms = (*attempts, *turned.report.attempts), spent_ms + turned.report.solve_ms
    settled = replace(settled, net=problem.net)
    return settled, replace(turned, report=replace(turned.report, attempts=attempts, solve_ms=spent_ms))


def contact_law(problem: Problem, tension: float | None = None) -> ContactLaw:
    """How sheets press on each other where bars pull with ``tension`` on an average, N; by the loads if left out."""
    netting = ~problem.net.bar_is_rope
    distance = OF_A_BAR * float(problem.net.bar_length[netting].min())
    return ContactLaw.pressing(distance, PUSH * (tension or reference_tension(problem)))


def _starts(
    touching: Problem, tolerance: float, at_rest: Solution | None, progress: Progress | None
) -> Iterator[tuple[Solution, ContactLaw, tuple[Solver, ...]]]:
    """Shapes to be let go from in which nothing passes through anything, the contact there, and how.

    At rest in still water; then as built, led near its rest by its motion, or as it is.
    ``at_rest`` is how the net in still water was looked for, where it was.
    """
    rest = _at_rest(_in_still_water(touching), tolerance, progress) if at_rest is None else at_rest
    if rest.report.outcome.converged and apart(touching, rest.positions):
        yield rest, contact_law(touching, rest.mean_tension), UNDER_CONTACT
    if apart(touching, touching.net.positions):
        for calm in calm_shapes(touching, progress):
            yield calm, contact_law(touching, calm.mean_tension), (gentle.solve,)
        yield as_built(touching), contact_law(touching), UNDER_CONTACT


def _in_still_water(touching: Problem) -> Problem:
    """The same net without current and contact."""
    water = touching.loading.water
    still = touching.loading._replace(water=water._replace(flow=np.zeros_like(water.flow)))
    return replace(touching, surface=None, loading=still)


def _at_rest(still: Problem, tolerance: float, progress: Progress | None) -> Solution:
    """A net in still water as far as it is found without contact: through the interior, else by gentle steps."""
    return interior_point.solve(still, tolerance, progress=progress)


def apart(touching: Problem, positions: np.ndarray) -> bool:
    """Whether nothing passes through anything, nor nearly does."""
    assert touching.surface is not None
    least = APART * touching.surface.law.distance_m
    return passage(touching, positions) is None and touching.surface.least_distance(positions) > least
