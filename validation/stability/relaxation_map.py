"""Dynamic relaxation: its time step against the penalty that stands in for inextensible twine, and the stable step.

The step of the relaxation is 1 in time under masses m = f S / 2, S the sum of the moduli of a node's row of the
stiffness matrix and f ``RelaxationSettings.mass_factor``. That is a step of s = f^-1/2 in units of the one that the
bound on the row allows. Central differences are stable while s omega < 2 with omega^2 the largest eigenvalue of
M^-1 K, M the masses for f = 1; K is that of the bars under the augmented law, for loads stand still between refreshes.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import eigh

from codend.mechanics import pressure, relaxation
from codend.mechanics.bars import augmented_law
from codend.mechanics.catch_front import fill
from codend.mechanics.problem import Problem
from codend.solvers import dynamic_relaxation
from codend.solvers.dynamic_relaxation import RelaxationSettings
from codend.solvers.outcome import Solution
from validation.section import Verdict
from validation.stability.judge import Finding, Judgement, confirmed_reference, judge
from validation.stability.linear import dense_tangent, free_coordinates, lengths_of
from validation.stability.maps import Axis, Line, Panel, StabilityMap, panel, spaced
from validation.stability.scenes import bag_and_problem, plan_of

TOLERANCE = 1e-6
AGREEMENT = 1.25
"""Factor within which the border found must agree with the stable step of linear theory."""
STEPS = 20_000


def largest_stable_step(problem: Problem, solution: Solution, penalty: float) -> float:
    """Time step, in units of the bound's, at which the relaxation of an equilibrium turns unstable by linear theory."""
    structure = problem.structure
    work = relaxation.workspace(structure, problem.bands, solution.positions)
    tension = float(solution.bar_tension.mean())
    augmented_law(structure, penalty * tension, work.relief, work.gain)
    length = lengths_of(problem, solution.positions)
    work.multiplier[:] = solution.bar_tension / length
    fill(solution.positions, structure, problem.loading.catch, work.share)
    pressure.add_bound(solution.positions, structure, problem.loading.catch, work.share, work.load_bound)
    relaxation.refresh(work, structure, problem.loading, 1.0)
    free = free_coordinates(problem)
    mass = 1.0 / work.state[:, relaxation.MOBILITY : relaxation.MOBILITY + 3].ravel()[free]
    hardening = np.where(work.density > 0.0, work.gain / length**3, 0.0)
    stiffness = dense_tangent(problem, solution.positions, work.density, hardening, None)
    fastest = eigh(stiffness, np.diag(mass), eigvals_only=True, subset_by_index=[len(free) - 1] * 2)[0]
    return float(2.0 / np.sqrt(fastest))


def border(grid: Panel) -> list[tuple[float, float]]:
    """Of each row the largest step that is right, 0 if none is, and the next one of the grid."""
    found = []
    for row in grid.cells:
        right = [n for n, cell in enumerate(row) if cell.judgement.finding in (Finding.RIGHT, Finding.RESCUED)]
        last = right[-1] if right else -1
        found.append((row[last].x if right else 0.0, row[last + 1].x if last + 1 < len(row) else np.inf))
    return found


def relaxation_map(quick: bool) -> StabilityMap:
    """Both dampings without restarts, and kinetic damping as shipped, with restarts."""
    bag, problem = bag_and_problem(plan_of())
    reference = confirmed_reference(bag, problem)
    step = Axis("time step / step of the bound", spaced(0.5, 2.0, 21)[:: 3 if quick else 1])
    penalty = Axis("penalty EA / mean bar tension", spaced(1.0, 1e4, 13)[:: 4 if quick else 1])
    stable = np.array([largest_stable_step(problem, reference.solution, p) for p in penalty.values])
    theory = Line("stable step by theory: 2 / largest frequency", stable, np.array(penalty.values))
    unguarded = RelaxationSettings(restarts=0, steps_allowed=STEPS)

    def solved(settings: RelaxationSettings, s: float, c: float) -> tuple[Solution, Judgement]:
        asked = replace(settings, mass_factor=s**-2, penalty=c)
        solution = dynamic_relaxation.solve(problem, TOLERANCE, settings=asked)
        return solution, judge(reference, solution, TOLERANCE)

    panels = tuple(
        panel(title, step, penalty, lambda s, c, settings=settings: solved(settings, s, c), (theory,))
        for title, settings in (
            ("kinetic damping, no restarts", unguarded),
            ("viscous damping, no restarts", replace(unguarded, viscous=True)),
            ("kinetic damping with restarts", RelaxationSettings()),
        )
    )
    return StabilityMap(
        name="stability_relaxation",
        title="Dynamic relaxation: time step against penalty",
        question=f"A sector of 24 x 20 meshes, 6 filled, from a crude bag to a residual of {TOLERANCE:g}. The shipped "
        f"settings are a step of {RelaxationSettings().mass_factor ** -0.5:.2f} and a penalty of "
        f"{RelaxationSettings().penalty:g}, with restarts.",
        panels=panels,
        checks=tuple(_agreement(grid, stable) for grid in panels[:2]),
    )


def _agreement(grid: Panel, stable: np.ndarray) -> Verdict:
    found = border(grid)
    ratios = [(last / s, after / s) for (last, after), s in zip(found, stable, strict=True) if last > 0.0]
    passed = bool(ratios) and all(last <= AGREEMENT and after >= 1.0 / AGREEMENT for last, after in ratios)
    low, high = min(last for last, _ in ratios), max(last for last, _ in ratios)
    return Verdict(
        f"Relaxation, {grid.title}: the border is the stable step of linear theory within a factor {AGREEMENT:g}.",
        passed,
        f"last right step over the theory's: {low:.2f} to {high:.2f}, in {len(ratios)} of {len(found)} rows",
    )
