"""Balance of forces and moments, and virtual work, on the largest full net that can be afforded.

The net is the flume case's, unglobalised (globalised by 10 where quick), its twine as heavy as steel so that nothing is
the same all round. Loads and tensions are put together here in plain numpy, load by load with its point of action,
apart from the project's kernels. At equilibrium, for any virtual displacement that the supports allow, loads and
tensions do no work; nor do loads alone, for one that leaves the length of every bar as it is. Supports hold the entry,
and the codline on the axis.
"""

from dataclasses import astuple, dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from catch_models.pressure import PressureLaw
from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.mechanics.problem import Problem
from codend.net.net import bar_vectors, facet_corners
from codend.plan.plan import load_plan
from codend.solvers import newton
from codend.solvers.outcome import Solution
from validation.independent_checks.check import Check, Floats, Theme

FLUME = Path(__file__).parents[1] / "cases" / "flume_150x140.toml"
CATCH = ["catch.filled_meshes=40", 'model.fidelity="full"', "model.tolerance=1e-10"]
STEEL = ["netting.0.twine_density_kg_m3=7850"]
QUICK_GLOBALISATION = 10
TURN_RAD = 0.123
SEED, FIELDS = 42, 20


def _solved(changes: list[str], globalisation: int, sectors: int | None = None) -> tuple[Bag, Problem, Solution]:
    plan = load_plan(FLUME, [*CATCH, *changes])
    model = model_of(plan, globalisation, sectors)
    problem, solution = equilibrium.solve(model, plan.cases()[0], (), None)
    return model.bag, problem, _checked(solution)


def _checked(solution: Solution) -> Solution:
    if not solution.report.outcome.converged:
        raise RuntimeError(solution.report.outcome.value)
    return solution


@dataclass(frozen=True)
class State:
    """A solved full net and what acts on it."""

    problem: Problem
    positions: Floats
    pulls: Floats
    """Tension along the bar, as a vector from the first end to the second, (m, 3)."""
    drag: Floats
    """Of every bar, acting on its middle, (m, 3)."""
    pressure: Floats
    """Of every facet, acting on its centroid, (f, 3)."""

    def resultant(self) -> Floats:
        """Sum of all loads, (3,)."""
        return self.drag.sum(axis=0) + self.pressure.sum(axis=0) + self.problem.loading.dead.sum(axis=0)

    def moment(self) -> Floats:
        """Sum of their moments about the middle of the entry, (3,)."""
        net, at = self.problem.net, self.positions
        return (
            np.cross(at[net.bars].mean(axis=1), self.drag).sum(axis=0)
            + np.cross(at[net.facets].mean(axis=1), self.pressure).sum(axis=0)
            + np.cross(at, self.problem.loading.dead).sum(axis=0)
        )

    def reactions(self) -> Floats:
        """Force of the supports on every node, what its bars and its part of the loads leave over, (n, 3)."""
        net = self.problem.net
        left = self.problem.loading.dead.copy()
        for end, sign in ((0, 1.0), (1, -1.0)):
            np.add.at(left, net.bars[:, end], sign * self.pulls + 0.5 * self.drag)
        for corner in range(3):
            np.add.at(left, net.facets[:, corner], self.pressure / 3.0)
        return np.where(net.fixed, -left, 0.0)

    def works(self, moved: Floats) -> tuple[float, float, float]:
        """Virtual work of loads and of tensions for displacements (n, 3), and the sum of the sizes of its parts, J."""
        net = self.problem.net
        parts = [
            np.sum(self.drag * moved[net.bars].mean(axis=1), axis=1),
            np.sum(self.pressure * moved[net.facets].mean(axis=1), axis=1),
            np.sum(self.problem.loading.dead * moved, axis=1),
        ]
        stretch = -np.sum(self.pulls * (moved[net.bars[:, 1]] - moved[net.bars[:, 0]]), axis=1)
        sizes = sum(float(np.abs(part).sum()) for part in (*parts, stretch))
        return sum(float(part.sum()) for part in parts), float(stretch.sum()), sizes


@cache
def state(quick: bool) -> State:
    """The heavy full net."""
    _, problem, solution = _solved(STEEL, QUICK_GLOBALISATION if quick else 1)
    net, loading, positions = problem.net, problem.loading, solution.positions
    catch = loading.catch
    vectors = bar_vectors(net, positions)
    tangent = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    # Le Bris et al. 1999, equations 4 and 5; none within the catch
    (flow,) = loading.water.flow
    along = (tangent @ flow)[:, None] * tangent
    across = flow - along
    size = 0.5 * loading.water.density * net.bar_drag_diameter * np.linalg.norm(vectors, axis=1)
    size *= net.bar_normal_drag * (1.0 - solution.share[catch.bar_band])
    drag = np.linalg.norm(across, axis=1, keepdims=True) * across
    drag += net.bar_tangential_drag[:, None] * np.linalg.norm(along, axis=1, keepdims=True) * along
    a, b, c = np.moveaxis(facet_corners(net, positions), 1, 0)
    area = 0.5 * np.cross(b - a, c - a)
    theta = np.arctan2(np.hypot(area[:, 1], area[:, 2]), -area[:, 0])
    law = PressureLaw("", catch.angles, catch.coefficients)
    pressure = catch.stagnation_pressure * law(theta) * net.facet_weight * solution.share[catch.facet_band]
    return State(
        problem,
        positions,
        solution.bar_tension[:, None] * tangent,
        size[:, None] * drag,
        pressure[:, None] * area,
    )


def _force_error(quick: bool) -> float:
    """Reactions and loads, over the drag."""
    net = state(quick)
    loads = net.resultant()
    return float(np.linalg.norm(net.reactions().sum(axis=0) + loads) / loads[0])


def _moment_error(quick: bool) -> float:
    """Moments of reactions and loads, over drag times length."""
    net = state(quick)
    reactions = np.cross(net.positions, net.reactions()).sum(axis=0)
    return float(np.linalg.norm(reactions + net.moment()) / (net.resultant()[0] * np.ptp(net.positions[:, 0])))


def _fields(net: State) -> list[Floats]:
    """Displacements that leave the supports alone: random polynomials of the position, and one random at every node."""
    random = np.random.default_rng(SEED)
    place = net.positions / np.abs(net.positions).max(axis=0)
    powers = np.stack(
        [place[:, 0] ** i * place[:, 1] ** j * place[:, 2] ** k for i, j, k in np.ndindex(4, 3, 3)], axis=1
    )
    smooth = [powers @ random.normal(size=(powers.shape[1], 3)) for _ in range(FIELDS)]
    return [np.where(net.problem.net.fixed, 0.0, field) for field in (*smooth, random.normal(size=place.shape))]


def _work_error(quick: bool) -> float:
    net = state(quick)
    found = (net.works(field) for field in _fields(net))
    return max(abs(loads + tensions) / sizes for loads, tensions, sizes in found)


def _mechanism_error(quick: bool) -> float:
    """Work of the loads alone for the part of those displacements that changes no bar's length."""
    net = state(quick)
    # at the codline two bars join the same two nodes: one says all
    bars, first = np.unique(net.problem.net.bars, axis=0, return_index=True)
    free = ~net.problem.net.fixed.ravel()
    tangent = net.pulls[first] / np.linalg.norm(net.pulls[first], axis=1, keepdims=True)
    row = np.repeat(np.arange(len(bars)), 6)
    column = (3 * bars[:, :, None] + np.arange(3)).reshape(-1)
    stretch = csc_array(
        (np.stack([-tangent, tangent], axis=1).reshape(-1), (row, column)), shape=(len(bars), len(free))
    )[:, np.flatnonzero(free)]
    factors = splu((stretch @ stretch.T).tocsc())
    worst = 0.0
    for field in _fields(net):
        moved = field.ravel()
        moved[free] -= stretch.T @ factors.solve(stretch @ moved[free])
        loads, _, sizes = net.works(moved.reshape(-1, 3))
        worst = max(worst, abs(loads) / sizes)
    return worst


def _turned_error(_: bool) -> float:
    """Of shape and drag, when a net that is the same all round is built turned about the axis and solved."""
    plan = load_plan(FLUME, CATCH)
    case = plan.cases()[0]
    bag, problem, solution = _solved([], QUICK_GLOBALISATION)
    other_bag = build_bag(plan, globalisation=QUICK_GLOBALISATION, azimuth_rad=TURN_RAD)
    other = problem_of(other_bag, plan, case)
    turned = _checked(newton.solve(other, 1e-10))
    c, s = np.cos(TURN_RAD), np.sin(TURN_RAD)
    moved = solution.positions @ np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
    shape = np.abs(turned.positions - moved).max() / np.ptp(moved[:, 0])
    drags = [measure_all(*case)[2].drag_n for case in ((bag, problem, solution), (other_bag, other, turned))]
    return max(float(shape), abs(drags[1] / drags[0] - 1.0))


def _sector_error(quick: bool) -> float:
    """Of every measure, between the full net of limp light twine and one sector of it."""
    g = QUICK_GLOBALISATION if quick else 1
    full, sector = (np.array(astuple(measure_all(*_solved([], g, sectors))[2])) for sectors in (None, 1))
    # the net has no straps, whose tension is nan, no folds, and is not turned but by round-off
    return float(np.nanmax(np.abs(full - sector) / np.where(np.abs(sector) < 1e-9, 1.0, np.abs(sector))))


CHECKS = (
    Check("Reactions of the supports and all loads add up to nothing", "balance of forces", 1e-8, _force_error),
    Check(
        "Their moments about the middle of the entry add up to nothing as well",
        "balance of moments",
        1e-8,
        _moment_error,
    ),
    Check(
        f"Loads and tensions do no work for {FIELDS + 1} random displacements that the supports allow",
        "principle of virtual work",
        1e-8,
        _work_error,
    ),
    Check(
        "Loads alone do no work for the part of them that leaves every bar's length as it is",
        "principle of virtual work",
        1e-8,
        _mechanism_error,
    ),
    Check(
        "The same net built turned about its axis takes the same shape, turned, and the same drag (globalised by 10)",
        "invariance",
        1e-7,
        _turned_error,
    ),
    Check("A full net and one sector of it have the same measures", "invariance", 1e-7, _sector_error),
)

THEME = Theme(
    "Balance and virtual work of a full net",
    "The flume case's net with 40 meshes filled, every one of its 42 000 knots modelled (with `--quick`: globalised by "
    f"{QUICK_GLOBALISATION}), its twine as heavy as steel so that nothing is the same all round. Loads and tensions "
    "are put together in plain numpy, apart from the kernels that solved the net; errors are relative to the drag, to "
    "drag times length, and to the sum of the sizes of all works.",
    CHECKS,
)
