"""The force that opens one mesh of a solved net: as if it were alone, and in the net, its neighbours and all.

Alone a mesh is a rhombus under the load along the netting that it carries (``measures.opening_force``; Le Bris et al.
1999, figure 11). In the net its two knots across the netting are pulled apart by hooks, long bars of no stretch from
the knots to fixed points abeam of them, shortened until the mesh is as wide as wanted: the force is what the hooks
carry. Neighbours must give way for that and many of their bars go slack, so the pull is solved by the interior-point
method. One mesh among all round is modelled by sectors side by side, as many as it takes until their number no longer
tells.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from codend.bag.bag import Bag, around, mesh_corners
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import WANTED_OPENING_DEG, measure_meshes, mesh_opening_force, mesh_openings
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.accuracy import SAFETY
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.start_shapes import all_round_start
from codend.errors import OPTIONS, InputError
from codend.mechanics.problem import Problem
from codend.net.net import Floats, Ints, rotate, with_bars
from codend.plan.kinds import kinds_in_words
from codend.plan.plan import Case, Plan
from codend.solvers import interior_point, newton
from codend.solvers.interior_point import InteriorPointSettings
from codend.solvers.mirror import Mirror, mirror_of
from codend.solvers.outcome import Progress, Solution

FEWEST_SECTORS = 10
WIDER = 1.4
"""Factor by which the model is made wider at least, from one to the next."""
WHOLE = 200
"""Sectors up to which the full net is modelled at once: narrow models of it take as long in all, and disagree."""
PULL = InteriorPointSettings(first_barrier=0.1, last_barrier=1e-9)
"""Of the first pull: half the steps that the defaults take."""
NEXT_PULL = replace(newton.DIRECT, iterations_allowed=8, switches=newton.DIRECT.switches[:1])
"""Newton's method from the last pulled net to one pulled a little more or less."""
USUAL_STEPS = 32
"""That a first pull takes at most, but for a few (measured on nets of 24 to 150 meshes round)."""
ENOUGH = 0.03
"""Two changes of the force in a row, from one width to the next, relative, at which the model is wide enough."""
HOOK = 10.0
"""Length of a hook over that of a mesh side."""
NEAR_DEG = 0.02
"""Opening within which the force is led to the wanted one by a straight line."""
MOST_PULLS = 8


@dataclass(frozen=True)
class Pull:
    """One mesh, and the force that opens it; the names of its numbers are those of the columns of the table."""

    case: Case
    filled_meshes: float
    meshes_from_entry: float
    opening_deg: float
    """Before it is pulled."""
    wanted_opening_deg: float
    opening_force_alone_n: float
    """0 or less where the mesh is open that far already."""
    opening_force_in_net_n: float
    """0 where the mesh is open that far already; nan where it was not found."""
    opening_force_in_net_error_n: float
    """Estimate: what is left of the way to the wanted opening, and with fewer sectors than there are the larger of the
    last two changes from one width to the next, with a margin; nan where there was one width only."""
    sectors: int
    """That were modelled side by side."""
    slack_bars: int
    """Of that model, in the pulled net."""
    residual: float
    """Of the pulled net, or of the solved one where nothing was to be pulled."""
    converged: bool
    attempts: tuple[str, ...]
    """What was tried, in order, a line each."""


def check_place(plan: Plan, meshes_from_entry: float | None) -> None:
    """Refuse a place that is none of the codend, or in square mesh, which no pull across opens.

    Raises:
        InputError: it is not between entry and codline, or in square mesh; or there is nothing but square mesh.
    """
    open_to_a_pull = kinds_in_words(lambda kind: kind.opens, "or")
    rigid = next((section for section in plan.netting if not section.kind.opens), None)
    if rigid is not None and not any(section.kind.opens for section in plan.netting):
        allowed = f"{open_to_a_pull} netting somewhere: {rigid.kind.words} mesh is open"
        raise InputError(plan.source, "netting.mesh", rigid.mesh, allowed)
    if meshes_from_entry is None:
        return
    ends = np.cumsum([section.meshes_long for section in plan.netting])
    if not 0.0 < meshes_from_entry < ends[-1]:
        raise InputError(OPTIONS, "--at", meshes_from_entry, f"above 0 and below {ends[-1]:g}, the meshes long")
    there = plan.netting[int(np.searchsorted(ends, meshes_from_entry))].kind
    if not there.opens:
        allowed = f"a place in {open_to_a_pull} netting: {there.words} mesh is open"
        raise InputError(OPTIONS, "--at", meshes_from_entry, allowed)


def pull_mesh(
    plan: Plan,
    case: Case,
    meshes_from_entry: float | None = None,
    wanted_deg: float = WANTED_OPENING_DEG,
    progress: Progress | None = None,
) -> Pull:
    """Force that opens the mesh nearest to a place along the codend, alone and in the net.

    Wet weight is left out, as of a sector. Takes seconds where twine stretches; a net of inextensible twine gives way
    only far around: of a net of 42 000 knots that takes 15 s of processor time, and three times as long where no
    plane through the mesh mirrors the net.

    Args:
        plan: the net plan.
        case: speed and catch.
        meshes_from_entry: where the mesh is, in meshes from the entry; None for the one ahead of the catch
            that needs most when alone.
        wanted_deg: opening to bring it to.
        progress: told the residual of every step.

    Raises:
        InputError: the plan has hinges in its bars, there is no mesh at that place, or no such opening.
    """
    check_place(plan, meshes_from_entry)
    if not 0.0 < wanted_deg < 180.0:
        raise InputError(OPTIONS, "--opening", wanted_deg, "degrees above 0 and below 180")
    if plan.model.bars_per_side > 1:
        raise InputError(plan.source, "model.bars_per_side", plan.model.bars_per_side, "1 where a mesh is pulled open")
    sector = model_of(plan, 1, 1)
    bag = sector.bag
    problem, solution = equilibrium.solve(sector, case, (), progress)
    attempts, nothing = solution.report.attempts, float("nan")
    pull = Pull(case, nothing, nothing, nothing, wanted_deg, nothing, nothing, nothing, 1, 0, nothing, False, attempts)
    if not solution.report.outcome.converged:
        return pull
    meshes = measure_meshes(bag, problem, solution)
    alone = mesh_opening_force(bag, meshes.bar_tension_n, meshes.opening_deg, wanted_deg)
    place = bag.mesh_place[bag.mesh_row]
    ahead = place <= float((1.0 - solution.share) @ bag.band_meshes)
    if meshes_from_entry is not None:
        fits = np.where(bag.mesh_opens, -np.abs(place - meshes_from_entry), -np.inf)
    elif np.any(ahead & bag.mesh_opens):
        fits = np.where(ahead & bag.mesh_opens, alone, -np.inf)
    else:
        return replace(pull, attempts=(*attempts, "no mesh to pull lies ahead of the catch: say which is to be pulled"))
    mesh = int(np.argmax(fits))
    row = int(bag.mesh_row[mesh])
    pull = replace(
        pull,
        filled_meshes=float(solution.share @ bag.band_meshes),
        meshes_from_entry=float(place[mesh]),
        opening_deg=float(meshes.opening_deg[mesh]),
        opening_force_alone_n=float(alone[mesh]),
    )
    if pull.opening_deg >= wanted_deg:
        return replace(
            pull,
            opening_force_in_net_n=0.0,
            opening_force_in_net_error_n=0.0,
            residual=solution.report.residual,
            converged=True,
        )
    found: list[Pull] = []
    for sectors in _widths(bag.net.sectors):
        start = all_round_start(bag, solution.positions, solution.bar_tension, sectors)
        pulled = _pulled(plan, sectors, row, start, pull, progress)
        attempts += tuple(f"{sectors} of {bag.net.order} sectors: {line}" for line in pulled.attempts)
        if pulled.converged:
            found.append(pulled)
        if len(found) > 2 and _changes(found).max() <= ENOUGH * found[-1].opening_force_in_net_n:
            break
    if not found:
        return replace(pulled, attempts=attempts)
    widest = found[-1]
    error = widest.opening_force_in_net_error_n
    if widest.sectors < bag.net.order:
        error += SAFETY * float(_changes(found).max(initial=0.0)) if len(found) > 1 else nothing
    return replace(widest, opening_force_in_net_error_n=error, attempts=attempts)


def _changes(found: list[Pull]) -> Floats:
    """Last two changes of the force from one width to the next, N."""
    return np.abs(np.diff([pull.opening_force_in_net_n for pull in found[-3:]]))


def _widths(order: int) -> Iterator[int]:
    """Numbers of sectors to model side by side, from narrow to the full net of ``order`` of them."""
    last = 0.0
    for sectors in range(1 if order > WHOLE else order, order + 1):
        if order % sectors == 0 and (sectors == order or sectors >= max(FEWEST_SECTORS, WIDER * last)):
            yield sectors
            last = sectors


def _pulled(plan: Plan, sectors: int, row: int, start: Solution, pull: Pull, progress: Progress | None) -> Pull:
    """The pull with so many sectors side by side: its force, not yet the error."""
    bag = build_bag(plan, sectors=sectors)
    bag = replace(bag, net=replace(bag.net, positions=start.positions))
    mesh = _middle_mesh(bag, row)
    bag, mirror = _mirrored(bag, mesh, problem_of(bag, plan, pull.case))
    net = bag.net
    right = np.unique([bag.mesh_sides[mesh, 0, 1], bag.mesh_sides[mesh, 1, 0]])
    left = np.unique([bag.mesh_sides[mesh, 2, 1], bag.mesh_sides[mesh, 3, 0]])
    abeam = net.positions[right].mean(axis=0) - net.positions[left].mean(axis=0)
    abeam /= np.linalg.norm(abeam)
    side = float(net.bar_length[bag.mesh_bars[mesh]].max())
    hooks = len(right) + len(left)
    if mirror is not None:
        knots = np.concatenate([right, left])
        of_anchors = len(net.positions) + np.argmax(mirror.node[knots][:, None] == knots, axis=1)
        mirror = mirror.beside(of_anchors)
    solution = replace(
        start,
        positions=_with_hooks(bag, right, left, abeam, HOOK * side, 0.0).net.positions,
        bar_tension=np.append(start.bar_tension, np.zeros(hooks)),
    )
    wanted, opening = np.radians(pull.wanted_opening_deg), np.radians(pull.opening_deg)
    pulled_by = [(0.0, pull.opening_deg, 0.0)]
    goal = side * (np.sin(wanted / 2.0) - np.sin(opening / 2.0))
    attempts: list[str] = []
    steps = 0

    def told(_: str, residual: float) -> None:
        nonlocal steps
        steps += 1
        share = min(0.9 * steps / USUAL_STEPS, 0.9) if len(pulled_by) == 1 else 0.95
        if progress is not None:
            where = f"{sectors} of {sectors * net.order:g} sectors, pull {len(attempts) + 1}"
            progress(f"{where}, about {share:.0%} done", residual)

    prepared: newton.Prepared | None = None
    while len(attempts) < MOST_PULLS:
        hooked = _with_hooks(bag, right, left, abeam, HOOK * side, goal)
        problem = problem_of(hooked, plan, pull.case)
        if prepared is None:
            prepared = newton.prepare(problem.structure, problem.bands, mirror=mirror)
        trial, tried = solution, []
        if len(pulled_by) > 1:
            trial = newton.solve(problem, plan.model.tolerance, solution, NEXT_PULL, told, prepared)
            tried = list(trial.report.attempts)
        if len(pulled_by) == 1 or not trial.report.outcome.converged:
            trial = interior_point.solve(problem, plan.model.tolerance, solution, PULL, told, prepared)
            tried += trial.report.attempts
        attempts.append(f"pulled by {2e3 * goal:.4g} mm: {'; '.join(tried)}")
        if not trial.report.outcome.converged:
            goal = 0.5 * (goal + pulled_by[-1][0])
            continue
        reached = float(mesh_openings(hooked, mesh_corners(hooked, trial.positions))[0][mesh])
        force = 0.5 * float(trial.bar_tension[-hooks:].sum())
        last_goal, last_opening, last_force = pulled_by[-1]
        if not (reached - last_opening) * (goal - last_goal) > 0.0:
            attempts[-1] += f" The mesh did not follow: {reached:.4g} degrees open, {last_opening:.4g} before."
            goal = 0.5 * (goal + last_goal)
            continue
        solution = trial
        pulled_by.append((goal, reached, force))
        short = (pull.wanted_opening_deg - reached) / (reached - last_opening)
        if abs(pull.wanted_opening_deg - reached) <= NEAR_DEG:
            slack = np.count_nonzero(trial.bar_tension[:-hooks] == 0.0)
            return replace(
                pull,
                opening_force_in_net_n=force + short * (force - last_force),
                opening_force_in_net_error_n=abs(short * (force - last_force)),
                sectors=sectors,
                slack_bars=int(slack),
                residual=trial.report.residual,
                converged=True,
                attempts=tuple(attempts),
            )
        goal += short * (goal - last_goal)
    return replace(
        pull, opening_force_in_net_n=float("nan"), sectors=sectors, converged=False, attempts=tuple(attempts)
    )


def _middle_mesh(bag: Bag, row: int) -> int:
    """The mesh of a row that lies in the middle of a sector, no side of it in another."""
    inside = np.flatnonzero((bag.mesh_row == row) & ~bag.mesh_side_image.any(axis=(1, 2)))
    return int(inside[len(inside) // 2])


def _mirrored(bag: Bag, mesh: int, problem: Problem) -> tuple[Bag, Mirror | None]:
    """A full net turned about its axis until the plane y = 0 halves a mesh, and that plane as its mirror.

    None, and the net as it was, where it has no such plane, or is no full net, or its weight tells it from others.
    """
    net = bag.net
    if net.order != 1:
        return bag, None
    middle = net.positions[bag.mesh_sides[mesh].ravel()].mean(axis=0)
    quarter_less = 0.25 - np.arctan2(middle[2], middle[1]) / (2.0 * np.pi)
    turned = replace(net, positions=rotate(net.positions, quarter_less, 1.0))
    mirror = mirror_of(replace(problem, net=turned), (np.pi / 2,))
    if mirror is None:
        return bag, None
    return replace(bag, net=replace(turned, positions=mirror.mirrored(turned.positions))), mirror


def _with_hooks(bag: Bag, right: Ints, left: Ints, abeam: Floats, length: float, pulled: float) -> Bag:
    """The bag with a hook at each of the knots, shortened by ``pulled``: straight, without stretch, drag or weight."""
    net = bag.net
    knots = np.concatenate([right, left])
    away = np.repeat([length, -length], [len(right), len(left)])
    hooks = len(knots)
    anchors = net.positions[knots] + away[:, None] * abeam
    hooked = with_bars(
        net,
        np.stack([knots, len(net.positions) + np.arange(hooks)], axis=1),
        0,
        bar_length=length - pulled,
        bar_density=np.nan,
    )
    anchored = replace(
        hooked,
        positions=np.concatenate([net.positions, anchors]),
        fixed=np.concatenate([net.fixed, np.ones((hooks, 3), dtype=bool)]),
    )
    return around(bag, anchored, band=0)
