"""Short ropes by a plain model that shares nothing with the package: ``python -m validation.ropes_judged``.

The full net of ``validation.ropes_short`` (50 x 50 meshes, every knot of it) written here anew: bars and ropes that
carry no compression, uniform pressure on triangles between neighbouring knots of one row and the knot between them in
the next, twine drag by equations 4 and 5 of Le Bris et al. 1999. Its knots start where the package's equilibrium has
them, set round from the sector between ropes; what is out of balance there by the plain model is told, and the net is
relaxed on from there, with kinetic damping, where that is above 1e-6 of the drag.

The package's equilibria are the plain model's to 1e-9 of the drag or better. How far the meshes ahead open depends on
which are meant: with two ropes 20 % short the five rows of meshes nearest to the front, each half a mesh from the next,
which is what ``opening_ahead_deg`` tells, open by 13.6 degrees, ten of them, five meshes deep, by 15.9.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from codend.bag.build import build_bag
from codend.bag.measures import Measures, measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.start_shapes import all_round_start, set_round
from validation.ropes_short import plan_with

Floats = NDArray[np.float64]
ROUND, LONG, BAR_M, EA_N, ROPE_EA_N, ENTRY_M = 50, 50, 0.05, 1e3, 5e3, 0.3
TWINE_M, WATER_KG_M3, SPEED_M_S, COEFFICIENT, NORMAL, TANGENTIAL = 3e-3, 1025.0, 0.8, 1.4, 1.36, 0.07
ROWS = 2 * LONG
STEPS, WITHIN = 6000, 1e-6
"""Most steps of the relaxation, and the largest force left over at a knot, over the drag."""


@dataclass(frozen=True)
class Judged:
    """What the plain model finds."""

    opening_ahead_deg: tuple[float, float]
    """Mean over the five rows of meshes just ahead of the front, half a mesh apart, and over ten."""
    drag_n: float
    off_balance: float
    """Largest force at a knot that is out of balance where it starts, over the drag."""
    left_over: float
    """The same where it ends."""


def knot(row: int, column: int) -> int:
    """Number of a knot; the last row is gathered into one."""
    return row * ROUND + column % ROUND if row < ROWS else ROWS * ROUND


def lines() -> Iterator[tuple[int, int, int]]:
    """Ends of every bar of twine, and the row it starts from."""
    for row in range(ROWS):
        for column in range(ROUND):
            for aside in (0, -1) if row % 2 == 0 else (1, 0):
                yield knot(row, column), knot(row + 1, column + aside), row


def triangles(first: int) -> Iterator[tuple[int, int, int]]:
    """Corners, seen anticlockwise from outside with the codline to the right, of the skin from a row to the codline."""
    for row in range(first, ROWS):
        for column in range(ROUND):
            aside = 0 if row % 2 == 0 else 1
            yield knot(row, column), knot(row, column + 1), knot(row + 1, column + aside)
            if row + 1 < ROWS:
                yield knot(row, column), knot(row + 1, column + aside), knot(row + 1, column + aside - 1)


def ropes(number: int) -> Iterator[tuple[int, int, float]]:
    """Ends and stretched length of every piece of rope; one that meets no knot of the entry starts at the hoop."""
    for rope in range(number):
        half = round(2 * ROUND * rope / number)
        column, start = half // 2, half % 2
        if start:
            yield ROWS * ROUND + 1 + rope, knot(1, column), BAR_M
        for row in range(start, ROWS, 2):
            yield knot(row, column), knot(min(row + 2, ROWS), column), min(2, ROWS - row) * BAR_M


def judged(number: int, shortening: float, filled: float, drag: bool, start: Floats) -> Judged:
    """Equilibrium of the net with so many ropes, 0 for none, from places of its knots, (knots, 3)."""
    twine = np.array(list(lines()))
    laced = np.array(list(ropes(number))).reshape(-1, 3)
    count = ROWS * ROUND + 1 + number
    ends = np.concatenate([twine[:, :2], laced[:, :2].astype(int)])
    rest = np.append(np.full(len(twine), BAR_M), (1.0 - shortening) * laced[:, 2])
    stiff = np.append(np.full(len(twine), EA_N), np.full(len(laced), ROPE_EA_N))
    front = ROWS - round(2 * filled)
    skin = np.array(list(triangles(front)))
    bars = np.arange(len(ends))
    apart = csr_array((np.repeat([-1.0, 1.0], len(ends)), (np.tile(bars, 2), ends.T.ravel())), shape=(len(ends), count))
    shared = csr_array(
        (np.full(skin.size, 1 / 3), (skin.ravel(), np.repeat(np.arange(len(skin)), 3))), (count, len(skin))
    )
    stagnation = 0.5 * WATER_KG_M3 * SPEED_M_S**2
    dragged = csr_array(0.5 * abs(apart[: len(twine)]).T)
    bare = np.where(twine[:, 2] < front, stagnation * TWINE_M * NORMAL * drag, 0.0)

    place = np.zeros((count, 3))
    place[: len(start)] = start
    at_hoop = 2 * np.pi * np.round(2 * ROUND * np.arange(number) / max(number, 1)) / (2 * ROUND)
    place[ROWS * ROUND + 1 :] = ENTRY_M * np.stack([0 * at_hoop, np.cos(at_hoop), np.sin(at_hoop)], axis=1)
    free = np.ones((count, 1))
    free[:ROUND] = free[ROWS * ROUND + 1 :] = 0.0

    def forces(x: Floats) -> tuple[Floats, Floats]:
        """Forces on the knots, and the loads among them."""
        vector = apart @ x
        length = np.sqrt((vector**2).sum(axis=1))
        tension = np.maximum(stiff * (length / rest - 1.0), 0.0)
        a, b, c = x[skin[:, 0]], x[skin[:, 1]], x[skin[:, 2]]
        load = shared @ (0.5 * COEFFICIENT * stagnation * np.cross(b - a, c - a))
        t, size = vector[: len(twine)] / length[: len(twine), None], length[: len(twine)]
        along = t[:, :1] * t
        across = np.array([1.0, 0.0, 0.0]) - along
        normal = np.sqrt((across**2).sum(axis=1))
        load += dragged @ ((bare * size)[:, None] * (normal[:, None] * across + TANGENTIAL * abs(t[:, :1]) * along))
        return load - apart.T @ ((tension / length)[:, None] * vector), load

    mass = 0.6 * (abs(apart).T @ (stiff / rest) + 40.0)[:, None]
    speed, energy, off_balance = np.zeros_like(place), 0.0, np.inf
    for step in range(STEPS):
        force, load = forces(place)
        force *= free
        left_over = float(np.abs(force).max() / load[:, 0].sum())
        off_balance = left_over if step == 0 else off_balance
        if left_over <= WITHIN:
            break
        speed += force / mass
        now = float((mass * speed**2).sum())
        if now < energy:
            place -= 0.5 * speed
            speed, now = np.zeros_like(place), 0.0
        place += speed
        energy = now
    return Judged(
        (_opening_ahead_deg(place, front, 5), _opening_ahead_deg(place, front, 10)),
        float(load[:, 0].sum()),
        off_balance,
        left_over,
    )


def _opening_ahead_deg(place: Floats, front: int, rows: int) -> float:
    """Mean opening of the meshes whose middles lie in so many rows of knots just ahead of one."""
    net = place[: ROWS * ROUND].reshape(ROWS, ROUND, 3)
    found = []
    for row in range(front - rows, front):
        fore, aft = net[row - 1], net[row + 1]
        left, right = net[row], np.roll(net[row], -1, axis=0)
        if row % 2 == 1:
            fore, aft = np.roll(fore, -1, axis=0), np.roll(aft, -1, axis=0)
        wide, deep = (np.linalg.norm(one - other, axis=1) for one, other in ((right, left), (aft, fore)))
        found.append(2.0 * np.degrees(np.arctan(wide / deep)))
    return float(np.mean(found))


def found(number: int, shortening: float, filled: float, drag: bool) -> tuple[Measures, Floats] | None:
    """What the package finds, and places of the knots all round; None where it finds nothing."""
    model = model_of(plan_with(number, shortening, filled, drag), 1, 1)
    problem, solution = equilibrium.solve(model, model.plan.cases()[0], (), None)
    if not solution.report.outcome.converged:
        return None
    whole = build_bag(model.plan)
    if number:
        positions = set_round(model.bag, whole, solution).positions
    else:
        positions = all_round_start(model.bag, solution.positions, solution.bar_tension, ROUND).positions
    laid = whole.net.positions
    number_of = np.where(
        whole.node_row < ROWS,
        whole.node_row * ROUND
        + np.rint(np.arctan2(laid[:, 2], laid[:, 1]) / (2 * np.pi) * ROUND - 0.5 * (whole.node_row % 2)) % ROUND,
        ROWS * ROUND,
    ).astype(int)
    places = np.zeros((ROWS * ROUND + 1, 3))
    knots = len(laid) - whole.anchors
    places[number_of[:knots]] = positions[:knots]
    return measure_all(model.bag, problem, solution)[2], places


def main(catches: tuple[float, ...] = (12.0, 20.0)) -> None:
    """Print a line a net: the plain model, and the package beside it."""
    for drag, filled in product((False, True), catches):
        opened = []
        for number, shortening in ((0, 0.0), *product((2, 4), (0.1, 0.2))):
            told = f"{'with' if drag else 'no'} twine drag, {filled:g} meshes, {number} ropes {shortening:.0%} short: "
            of_package = found(number, shortening, filled, drag)
            if of_package is None:
                print(told + "not solved", flush=True)
                continue
            measures, places = of_package
            plain = judged(number, shortening, filled, drag, places)
            opened.append((*plain.opening_ahead_deg, measures.opening_ahead_deg))
            ahead = [now - tube for now, tube in zip(opened[-1], opened[0], strict=True)]
            print(
                f"{told}plain {ahead[0]:+6.2f} degrees (ten rows {ahead[1]:+6.2f}), drag {plain.drag_n:7.2f} N; "
                f"package {ahead[2]:+6.2f} degrees, "
                f"drag {measures.drag_n:7.2f} N (out of balance {plain.off_balance:.0e}, then {plain.left_over:.0e})",
                flush=True,
            )


if __name__ == "__main__":
    main(*((tuple(map(float, sys.argv[1:])),) if sys.argv[1:] else ()))
