"""Equilibrium of a scene: by the ordinary solvers, and through the interior under contact where netting may meet.

In a current the net is let go as it was placed, with its sheets pressing on each other where they meet. If that leads
nowhere, and in still water, contact is left out if it is not needed: a shape that is in balance without it, and in
which nothing passes through anything, stands. Else the net is let go at rest in still water, and follows the current,
gently at last.

Of a scene that is its own mirror image one half is led so, to a shape that is mirrored to the last digit. It stands if
the whole net is in balance there and passes through nothing; where the whole would leave it, as far as pivots of its
tangent tell, it is followed to where it stays. Else the whole net is led.
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
from codend.solvers import floating, gentle, in_turns, interior_point, newton
from codend.solvers.dynamic_relaxation import as_built, reference_tension
from codend.solvers.gentle import End
from codend.solvers.half import Half, half_of
from codend.solvers.interior_point import FINISH, InteriorPointSettings
from codend.solvers.outcome import Outcome, Progress, Solution, Solver
from codend.solvers.prepared import Prepared, prepare
from codend.solvers.refusal import passage, told
from codend.solvers.solve import find_equilibrium, polished

OF_A_BAR = 0.05
"""Distance at which contact begins, over the shortest bar of netting."""
PUSH = 0.5
"""What sheets press on each other with at half of that distance, over the mean tension of the bars."""
UNDER_CONTACT: tuple[Solver, ...] = (interior_point.solve, gentle.solve)
NEARBY = InteriorPointSettings(first_barrier=1e-3)
"""Of a net that is followed from an equilibrium near by."""
LIGHTER = 0.7
"""Factor on the mass of a frame that is not found, by which it is made lighter."""
SHAKEN = 0.01
"""Of the shortest bar of netting: how far nodes are shaken, root mean square of a coordinate."""
OF_ONE_HALF = "one half of the net, which is its own mirror image:"
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
    half = half_of(problem) if sheet is None else None
    if half is None:
        return _held(problem, tolerance, progress, sheet)
    of_half, found = _held(half.problem, tolerance, progress)
    if found.report.outcome.converged:
        mirrored, found = _both_halves(problem, half, of_half, found, tolerance, progress)
        if found.report.outcome.converged:
            return mirrored, found
    attempts, spent_ms = found.report.attempts, found.report.solve_ms
    problem, found = _held(problem, tolerance, progress)
    attempts, spent_ms = (*attempts, *found.report.attempts), spent_ms + found.report.solve_ms
    return problem, replace(found, report=replace(found.report, attempts=attempts, solve_ms=spent_ms))


def _held(
    problem: Problem, tolerance: float, progress: Progress | None, sheet: Sheet | None = None
) -> tuple[Problem, Solution]:
    """The same of a net that hangs on what is held, as a whole; ``find`` tells of the arguments."""
    touching, attempts, spent_ms = problem.touching_by(contact_law(problem), sheet), [], 0.0
    flowing = bool(problem.loading.water.flow.any())
    if flowing and apart(touching, problem.net.positions):
        found = interior_point.solve(touching, tolerance, progress=progress)
        if found.report.outcome.converged:
            return _as_it_touches(problem, touching.touching_at(found.positions), found, tolerance, progress)
        attempts, spent_ms = list(found.report.attempts), found.report.solve_ms
    at_rest = None if flowing else in_still_water(problem, tolerance, progress)
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


def _both_halves(
    problem: Problem, half: Half, of_half: Problem, found: Solution, tolerance: float, progress: Progress | None
) -> tuple[Problem, Solution]:
    """The whole net in the shape of its half in balance; not converged where that is none for it, or does not last."""
    law = contact_law(half.problem) if of_half.surface is None else of_half.surface.law
    start = half.whole(found)
    touching = problem.touching_by(law)
    through = passage(touching, start.positions)
    if through is not None:
        return problem, _given_up(found, Outcome.PASSED_THROUGH, told(through.outcome, through))
    whole = problem if of_half.surface is None else touching.touching_at(start.positions)
    prepared = prepare(whole.structure, whole.bands)
    solution = newton.solve(whole, tolerance, start, FINISH, progress, prepared)
    if not solution.report.outcome.converged:
        return problem, _given_up(found, solution.report.outcome, solution.report.attempts[-1])
    whole, done = whole.touching_at(solution.positions), solution.report
    if not stays(whole, solution, prepared):
        motion = gentle.follow(whole, tolerance, shaken(whole, solution), prepared, progress, left=solution.positions)
        if motion.end is not End.SETTLED:
            return problem, _given_up(found, Outcome.NOT_IMPROVING, "it would leave it, for none that was found")
        solution = motion.solution
        led = f"{gentle.METHOD}: {motion.steps} steps from that shape, which the whole net would leave"
        done = replace(solution.report, attempts=(*done.attempts, led, *solution.report.attempts))
        whole = whole.touching_at(solution.positions)
    report = replace(
        done,
        iterations=found.report.iterations + done.iterations,
        solve_ms=found.report.solve_ms + done.solve_ms,
        attempts=(OF_ONE_HALF, *found.report.attempts, *done.attempts),
    )
    return whole, replace(solution, report=report)


def stays(problem: Problem, solution: Solution, prepared: Prepared | None = None) -> bool:
    """Whether a net in balance would stay so if it were moved a little, as far as the pivots of its tangent tell."""
    prepared = prepare(problem.structure, problem.bands) if prepared is None else prepared
    tangent = newton.tangent_at(problem, solution, prepared)
    return not tangent.singular and tangent.prepared.system.negative_pivots() == 0


def shaken(problem: Problem, known: Solution, far: float = SHAKEN) -> Solution:
    """A shape with every free node moved at random, ``far`` of a bar, as far as nothing passes through anything."""
    bar = float(problem.net.bar_length[~problem.net.bar_is_rope].min())
    moves = np.random.default_rng(0).standard_normal(known.positions.shape) * ~problem.net.fixed * far * bar
    if problem.surface is not None:
        moves *= problem.surface.free_share(known.positions, moves)
    return replace(known, positions=known.positions + moves)


def _given_up(found: Solution, outcome: Outcome, why: str) -> Solution:
    """A shape of one half that is none of the whole, with what was tried."""
    attempts = (OF_ONE_HALF, *found.report.attempts, f"the whole net in that shape: {why}")
    return replace(found, report=replace(found.report, outcome=outcome, attempts=attempts))


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
        for found in _made_heavier(touching, begun, tolerance, progress):
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


def _made_heavier(
    touching: Problem, begun: Solution, tolerance: float, progress: Progress | None
) -> Iterator[Solution]:
    """Every equilibrium looked for under a frame afloat, last that of its own mass: at once, or made heavier by steps.

    A frame that its floats do not carry draws the netting far before it hangs on its moorings; from a lighter one that
    does it is near.
    """
    body = touching.body
    assert body is not None
    masses, heaviest = [body.mass_kg], body.carries_kg
    while True:
        lighter = replace(touching, body=replace(body, mass_kg=masses[-1]))
        found = floating.solve(lighter, tolerance, begun, progress)
        yield found
        if found.report.outcome.converged or masses[-1] <= heaviest:
            break
        masses.append(LIGHTER * masses[-1])
    for mass in reversed(masses[:-1]):
        if not found.report.outcome.converged:
            return
        there = replace(touching.touching_at(found.positions), body=replace(body, mass_kg=mass))
        found = floating.solve(there, tolerance, found, progress)
        yield found


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
    rest = in_still_water(touching, tolerance, progress) if at_rest is None else at_rest
    if rest.report.outcome.converged and apart(touching, rest.positions):
        yield rest, contact_law(touching, rest.mean_tension), UNDER_CONTACT
    if apart(touching, touching.net.positions):
        for calm in calm_shapes(touching, progress):
            yield calm, contact_law(touching, calm.mean_tension), (gentle.solve,)
        yield as_built(touching), contact_law(touching), UNDER_CONTACT


def in_still_water(problem: Problem, tolerance: float, progress: Progress | None = None) -> Solution:
    """The same net without current, as far as it is found through the interior without contact."""
    water = problem.loading.water
    still = problem.loading._replace(water=water._replace(flow=np.zeros_like(water.flow)))
    return interior_point.solve(replace(problem, surface=None, loading=still), tolerance, progress=progress)


def apart(touching: Problem, positions: np.ndarray) -> bool:
    """Whether nothing passes through anything, nor nearly does."""
    assert touching.surface is not None
    least = APART * touching.surface.law.distance_m
    return passage(touching, positions) is None and touching.surface.least_distance(positions) > least
