"""The papers' contact by prediction and correction beside closed forms and the engine's own contact.

``python -m validation.prediction_correction``. Le Bris et al. 1999, figure 17: a step is first made without contact; of
the nodes that it carries through a surface the reactions are found that bring them back to it, and the step is made
again with these. As printed the reaction of each node is that of the node alone, and the step with it leaves
bars off their lengths. Here reactions N and tensions are solved for together, all of them 0 or above, so that lengths
and gaps are met by one and the same step (``reactions``). At rest both ways say the same, and what the engine says.

A line of rigid bars on a plane: semi-implicit Euler in time until nothing moves, mass and damping of no account then.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from codend.mechanics.contact import add_force
from codend.mechanics.drag_laws import drag
from codend.mechanics.problem import Problem
from codend.mechanics.surface import ContactLaw
from codend.mechanics.water import uniform_flow
from codend.net.net import Floats, Net
from codend.solvers.solve import find_equilibrium

STEP_S, MASS_KG, DAMPING_KG_S = 0.02, 20.0, 40.0
"""Of the whole line; not physics but the way to the rest."""
STILL_M_S = 1e-9
PASSES = 50
WATER, CHAIN_N_M, SHEET_BALLAST_N = 1000.0, 20.0, 10.0


@dataclass(frozen=True)
class Case:
    """A line of bars that hangs from its first node, and a plane that it may not pass."""

    name: str
    start: Floats
    """(n, 2), m: along x and up z."""
    bar_m: float
    normal: Floats
    """Of the plane, out of what is solid, (2,)."""
    offset_m: float
    """A node's gap is ``normal`` times its place, less this."""
    load: Callable[[Floats], Floats]
    """Forces on the nodes, N, (n, 2)."""
    on_plane_n: float
    """What the plane should carry by the closed form."""
    drag_n_m: float = 0.0
    """Of a bar across the flow along x, which ``load`` has by the law of LB99."""

    def gaps(self, position: Floats) -> Floats:
        """Of all nodes, m, (n,)."""
        return np.asarray(position @ self.normal - self.offset_m)


@dataclass(frozen=True)
class Rest:
    """Where a line has come to."""

    position: Floats
    tension: Floats
    """Of the bars, N, (n - 1,)."""
    reaction: Floats
    """Of the plane on the nodes, N, (n,)."""
    worst_length: float
    """Largest departure of a bar from its length, relative, over the whole way."""


def chain_on_a_floor(bars: int, drop_m: float = 3.0, pull_n: float = 30.0, weight_n_m: float = CHAIN_N_M) -> Case:
    """10 m of chain hung above a floor and pulled along it: sqrt(z^2 + 2 a z) hang free, a = H / w."""
    length = 10.0 / bars
    along = np.linspace(0.0, 10.0, bars + 1)
    slope = np.hypot(drop_m, 5.0)
    down = np.minimum(along / slope, 1.0)
    start = np.stack([5.0 * down + np.maximum(along - slope, 0.0), drop_m * (1.0 - down)], axis=1)
    force = np.zeros_like(start)
    force[:, 1] = -weight_n_m * length
    force[[0, -1], 1] *= 0.5
    force[-1, 0] = pull_n
    lying = weight_n_m * (10.0 - np.sqrt(drop_m**2 + 2.0 * pull_n / weight_n_m * drop_m))
    return Case("chain on a floor", start, length, np.array([0.0, 1.0]), 0.0, lambda _: force, float(lying))


def sheet_on_a_wall(bars: int, height: float = 4.0, ballast_n: float = SHEET_BALLAST_N, drag_n_m: float = 8.0) -> Case:
    """A weighted sheet that the flow pushes on a smooth wall at D: (W / R) sqrt((1 + R D / W)^2 - 1) of it are free."""
    distance, length = 0.6, height / bars
    z = -np.linspace(0.0, height, bars + 1)
    start = np.stack([np.minimum(0.55, -0.2 * z), z], axis=1)

    def load(position: Floats) -> Floats:
        along = np.diff(position, axis=0)
        t = along / np.linalg.norm(along, axis=1)[:, None]
        across = np.array([1.0, 0.0]) - t[:, :1] * t
        half = 0.5 * drag_n_m * length * np.linalg.norm(across, axis=1)[:, None] * across
        force = np.zeros_like(position)
        force[:-1] += half
        force[1:] += half
        force[-1, 1] -= ballast_n
        return force

    free = ballast_n / drag_n_m * np.sqrt((1.0 + drag_n_m * distance / ballast_n) ** 2 - 1.0)
    return Case(
        "sheet on a wall", start, length, np.array([-1.0, 0.0]), -distance, load, drag_n_m * (height - free), drag_n_m
    )


CASES = (chain_on_a_floor, sheet_on_a_wall)


def reactions(matrix: Floats, right: Floats, taut: Floats) -> Floats:
    """Pulls and pushes p >= 0 with A p >= right, one of the two equal in every row, from a guess of which are not 0."""
    for _ in range(PASSES):
        found = np.zeros(len(right))
        on = np.flatnonzero(taut)
        found[on] = np.linalg.solve(matrix[np.ix_(on, on)], right[on])
        missing = right - matrix @ found
        worse = np.where(taut, found < -1e-12 * np.abs(found).max(initial=1.0), missing > 1e-12 * np.abs(right).max())
        if not worse.any():
            break
        taut ^= worse
    return np.maximum(found, 0.0)


def settled(case: Case, together: bool = True, steps: int = 10_000) -> Rest:
    """The rest of a line, its reactions found with its tensions or, as printed, each by itself.

    Raises:
        ArithmeticError: it does not come to rest.
    """
    x, v = case.start.copy(), np.zeros_like(case.start)
    nodes, bars = len(x), len(x) - 1
    mass = MASS_KG / nodes
    eased = mass + STEP_S * DAMPING_KG_S / nodes
    taut, touching = np.ones(bars, dtype=bool), np.zeros(nodes, dtype=bool)
    contact = np.zeros((nodes, 2 * nodes))
    contact[np.arange(1, nodes), 2 * np.arange(1, nodes)] = case.normal[0]
    contact[np.arange(1, nodes), 2 * np.arange(1, nodes) + 1] = case.normal[1]
    worst = 0.0
    for _ in range(steps):
        d = np.diff(x, axis=0)
        rows = np.zeros((bars, 2 * nodes))
        for i in range(2):
            rows[np.arange(bars), 2 * np.arange(bars) + i] = d[:, i]
            rows[np.arange(bars), 2 * np.arange(1, nodes) + i] = -d[:, i]
        rows[:, :2] = 0.0  # the first node is held
        freely = (mass * v + STEP_S * case.load(x)) / eased
        freely[0] = 0.0
        # pulls that bring bars to their lengths at the step's end, to the first order
        wanted = (0.5 * (d**2).sum(axis=1) - 0.5 * case.bar_m**2) / STEP_S - rows @ freely.ravel()
        scale = STEP_S / eased
        pull = reactions(scale * rows @ rows.T, wanted, taut)
        reached = freely + scale * (rows.T @ pull).reshape(-1, 2)
        push = np.zeros(nodes)
        through = case.gaps(x + STEP_S * reached) < 0.0
        through[0] = False
        if (through | touching).any():
            short = -case.gaps(x) / STEP_S - contact @ (freely if together else reached).ravel()
            short[0] = -1.0
            if together:
                both = np.concatenate([rows, contact])
                guess = np.concatenate([taut, (through | touching) & (np.arange(nodes) > 0)])
                found = reactions(scale * both @ both.T, np.concatenate([wanted, short]), guess)
                pull, push = found[:bars], found[bars:]
                reached = freely + scale * (both.T @ found).reshape(-1, 2)
            else:
                push = np.where(through, short / scale, 0.0)
                reached = reached + scale * (contact.T @ push).reshape(-1, 2)
        touching = push > 0.0
        v = reached
        x = x + STEP_S * v
        length = np.linalg.norm(np.diff(x, axis=0), axis=1)
        worst = max(worst, float(np.abs(length / case.bar_m - 1.0)[taut].max(initial=0.0)))
        if np.abs(v).max() < STILL_M_S:
            return Rest(x, pull * case.bar_m, push, worst)
    raise ArithmeticError(f"{case.name} does not come to rest: {np.abs(v).max():.1e} m/s")


def by_the_engine(case: Case, thin: float = 1e-4) -> float:
    """What the plane carries by the engine's contact between layers, N; its gap is ``thin`` of a bar."""
    nodes, bars, gap = len(case.start), len(case.start) - 1, thin * case.bar_m
    along = np.array([case.normal[1], -case.normal[0]])
    middle = case.normal * case.offset_m + along * (case.start @ along).mean()
    away = 30.0 * along
    # seen from outside the solid its corners go round anticlockwise
    corners = [[*(middle - away), -30.0], [*(middle + away), -30.0], [*middle, 60.0]]
    lifted = case.start + np.maximum(2.0 * gap - case.gaps(case.start), 0.0)[:, None] * case.normal
    places = np.concatenate([np.insert(lifted, 1, 0.0, axis=1), np.array(corners)[:, [0, 2, 1]]])
    held = np.zeros((nodes + 3, 3), dtype=bool)
    held[0] = held[nodes:] = held[:, 1] = True
    ends = np.stack([np.arange(bars), np.arange(1, nodes)], axis=1)
    net = Net.from_bars(
        places, ends, held, length_m=case.bar_m, diameter_m=2.0 * case.drag_n_m / WATER,
        drag=drag("le-bris-1999", 1.0, 0.0), facets=[np.arange(nodes, nodes + 3)],
    )  # fmt: skip
    force = np.zeros_like(places)
    dead = case.load(case.start)
    force[:nodes, 0], force[:nodes, 2] = (0.0 if case.drag_n_m else dead[:, 0]), dead[:, 1]
    if case.drag_n_m:
        force[: nodes - 1, 2] = 0.0
        force[nodes - 1, 2] = -SHEET_BALLAST_N
    flow = np.array([1.0, 0.0, 0.0]) if case.drag_n_m else np.zeros(3)
    law = ContactLaw(gap, 3.0 * max(case.drag_n_m, CHAIN_N_M) * case.bar_m / gap)
    problem = Problem.of(net, nodal_force_n=force, water=uniform_flow(WATER, flow), weight=False, contact=law)
    found = find_equilibrium(problem, 1e-9)
    if not found.report.outcome.converged:
        raise ArithmeticError("; ".join(found.report.attempts))
    push = np.zeros_like(places)
    add_force(found.positions, problem.touching_at(found.positions).loading.contact, push)
    return float(push[:nodes, [0, 2]].sum(axis=0) @ case.normal)


def main() -> None:
    """Print both ways beside the closed form."""
    print(
        f"{'':18s}{'bars':>5s}{'on the plane N':>18s}{'closed form':>12s}{'gap / bar':>11s}"
        f"{'N x gap':>10s}{'length':>9s}"
    )
    for make in CASES:
        for bars in (20, 40):
            case = make(bars)
            print(
                f"{case.name:18s}{bars:5d}{by_the_engine(case):18.4f}{case.on_plane_n:12.4f}{'':30s}"
                "  the engine's contact"
            )
            for name, together in (("as one system", True), ("as printed", False)):
                try:
                    rest = settled(case, together)
                except ArithmeticError as error:
                    print(f"{case.name:18s}{bars:5d}   {name}: {error}")
                    continue
                gaps = case.gaps(rest.position)[1:]
                print(
                    f"{case.name:18s}{bars:5d}{rest.reaction.sum():18.4f}{case.on_plane_n:12.4f}"
                    f"{gaps.min() / case.bar_m:11.1e}{np.abs(rest.reaction[1:] * gaps).max():10.1e}"
                    f"{rest.worst_length:9.1e}  {name}"
                )


if __name__ == "__main__":
    main()
