"""Equilibrium of a net and of the body that carries it, in turns: the net with the body held, then the body.

For nets that only some solvers settle, slack and with sheets that touch: any of them solves the net with the body held
where it is, and the body is moved as the tangent of both asks (``body_system``), which is Newton's method on its six
unknowns. The net follows by the same tangent, where nothing passes through anything on the way.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from codend.mechanics import body as rigid
from codend.mechanics import newton_step
from codend.mechanics.bars import bar_lengths
from codend.mechanics.newton_state import empty_state, measure
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.body_system import BodySystem, out_of_balance, residual_of
from codend.solvers.outcome import Outcome, Solution
from codend.solvers.prepared import Prepared, prepare
from codend.solvers.reactions import loads_and_supports
from codend.solvers.watched import Watched

METHOD = "body and net in turns"
TURNS = 40
LARGEST_TILT = 0.1
"""Largest rotation of the body in a turn, rad."""
FARTHEST = 0.5
"""Largest move of the body in a turn, over its size."""
WELL = 0.5
"""Share of a move beyond which the net follows the body."""
STALLED = 100.0
"""Growth of the residual over the least of the last three at which it is given up."""
SHIFTS = (0.0, 1e-6, 1e-4, 1e-2)
"""On the net's own tangent, as in ``newton_step.linearise``: slack netting has none of its own."""
Held = Callable[[Problem, Solution | None], tuple[Problem, Solution]]
"""Settles a net whose body is held, from a start: the problem with the contact that it found, and the solution."""


def solve(problem: Problem, tolerance: float, held: Held, start: Solution | None = None) -> tuple[Problem, Solution]:
    """Equilibrium of a net that hangs on a body afloat, and the problem with the contact that acts in it.

    Args:
        problem: the net under its loads, with a body.
        tolerance: largest residual, of the body with its weight over the sizes of all loads.
        held: settles the net with the body held.
        start: positions and tensions to start from; without one those in which the net was built.
    """
    body = problem.body
    assert body is not None
    pose = rigid.pose_of(body, problem.net.positions if start is None else start.positions)
    here = replace(problem, body=None)
    attempts: list[str] = []
    residuals: list[float] = []
    spent_ms = 0.0
    for turn in range(TURNS):
        here, found = held(here, start)
        attempts += found.report.attempts
        spent_ms += found.report.solve_ms
        if not found.report.outcome.converged:
            break
        load, support = loads_and_supports(here, found)
        scale = float(np.linalg.norm(load, axis=1).sum()) + found.mean_tension
        residual = residual_of(body, out_of_balance(body, pose, -support), scale)
        attempts.append(f"{METHOD}: turn {turn + 1}, residual {residual:.1e}")
        move, twist, grows = _moves(replace(here, body=body), found, pose)
        if residual <= tolerance:
            if grows:
                found = replace(found, report=replace(found.report, outcome=Outcome.TURNS_OVER))
            break
        if move is None:
            found = replace(found, report=replace(found.report, outcome=Outcome.SINGULAR))
            break
        tilt, way = float(np.linalg.norm(twist[3:])), float(np.linalg.norm(twist[:3]))
        size = min(1.0, LARGEST_TILT / max(tilt, 1e-300), FARTHEST * body.size_m / max(way, 1e-300))
        if here.surface is not None:
            share = here.surface.free_share(found.positions, size * move)
            if share < WELL:  # sheets that lie on each other are better left to the net's own solver
                move[np.setdiff1d(np.arange(len(move)), body.nodes)] = 0.0
                share = here.surface.free_share(found.positions, size * move)
            size *= share
        if residual >= STALLED * min(residuals[-3:], default=np.inf):
            found = replace(found, report=replace(found.report, outcome=Outcome.NOT_IMPROVING))
            break
        residuals.append(residual)
        pose = rigid.moved(pose, size * twist)
        positions = found.positions + size * move
        rigid.place(body, pose, positions)
        start = replace(found, positions=positions)
        here = replace(here, net=replace(here.net, positions=positions))
    else:
        found = replace(found, report=replace(found.report, outcome=Outcome.STEPS_SPENT))
    residual = max(found.report.residual, residual) if found.report.outcome.converged else found.report.residual
    report = replace(found.report, method=METHOD, residual=residual, attempts=tuple(attempts), solve_ms=spent_ms)
    return replace(here, body=body), Solution.ended(report, found.positions, found.bar_tension, found.share)


def _moves(problem: Problem, found: Solution, pose: rigid.Pose) -> tuple[Floats | None, Floats, bool]:
    """How net and body move to the first order, (n, 3) and (6,), and whether the body would leave where it is.

    None if the tangent cannot be factorised.
    """
    structure, body = problem.structure, problem.body
    assert body is not None
    watched = Watched(problem, prepare(structure, problem.bands))
    watched.look(found.positions)
    prepared: Prepared = watched.prepared
    state = empty_state(structure, problem.bands)
    state.position[:] = found.positions
    bar_lengths(state.position, structure, state.length)
    state.density[:] = found.bar_tension / np.maximum(state.length, 1e-300)
    tension = found.mean_tension
    measure(structure, watched.loading, tension, 1.0, 0.0, state)
    system = BodySystem(problem, prepared)
    for shift in SHIFTS:
        newton_step.linearise(structure, watched.loading, prepared.pattern, tension, shift, state, prepared.step)
        if system.factorise(prepared.step.blocks, pose, state.force) == 0:
            move = system.solve(prepared.step.right[:1], pose)[0]
            if np.isfinite(move).all():
                return move, system.twist, system.growing() is not None
    return None, np.zeros(6), False
