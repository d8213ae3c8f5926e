"""The automatic method over plans at the edge: soft and stiff twine, any catch and entry, speed to zero, slack twine.

Every cell is a plan of its own. Its reference is the answer of the other kind of method: dynamic relaxation from a
crude bag, which knows neither tangent nor meridian shape, to a residual of ``SECOND``; where that fails, from near the
answer.
"""

from dataclasses import replace

import numpy as np

from codend.bag.loads import pressure_law_of
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.net.net import Floats
from codend.plan.plan import Plan
from codend.solvers import dynamic_relaxation
from codend.solvers.outcome import Solution
from validation.section import Verdict
from validation.stability.judge import Finding, Judgement, judge, judge_alone, reference_of
from validation.stability.maps import Axis, Line, StabilityMap, panel, spaced
from validation.stability.scenes import BAR_M, MESHES_LONG, STRETCHED_RADIUS_M, disturbed, plan_of

TOLERANCE = 1e-8
SECOND = 1e-8
NEARBY = 1e-3
"""Disturbance, in bar lengths, of the answer that relaxation starts from where it gets nowhere from a crude bag."""
SAME_SHAPE = 1e-6
"""Largest move of a node over the bag's length that counts as none."""
AGREEMENT = 1.4
"""Factor within which the softest twine with an answer must agree with theory."""
PRESSURE_PA = 500.0
"""Stagnation pressure at 1 m/s in fresh water."""


def automatic_maps(quick: bool) -> tuple[StabilityMap, ...]:
    """The three maps of the automatic method."""
    return stretch_map(quick), fill_map(quick), slack_map(quick)


def softest_twine() -> float:
    """EA over q b (N b / pi) below which a long catch balloons without bound (*derived*).

    In a long catch tan^2 phi = 2, so that r = (2/3)^1/2 (N b / pi) (1 + e) and T = 3^1/2 pi C q r^2 / (2 N), e = T / EA
    the strain: e / (1 + e)^2 = C q b (N b / pi) / (3^1/2 EA), whose left side is never above 1/4, at e = 1. C is the
    net pressure coefficient abeam.
    """
    coefficient = float(pressure_law_of(plan_of())(0.5 * np.pi))
    return 4.0 * coefficient / 3.0**0.5


def stretch_map(quick: bool) -> StabilityMap:
    """Axial stiffness against catch."""
    load = PRESSURE_PA * BAR_M * STRETCHED_RADIUS_M
    values = (0.5, 1.0, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 7.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7)
    stiffness = Axis("EA / (q b N b / pi)", values[::4] if quick else values)

    def solved(x: float, y: float) -> tuple[Solution, Judgement]:
        return checked(plan_of(y, netting={"axial_stiffness_n": x * load}, tolerance=TOLERANCE))

    theory = softest_twine()
    line = Line("long catch: softer twine balloons", np.full(2, theory), np.array([0.5 * MESHES_LONG, MESHES_LONG]))
    grid = panel("elastic", stiffness, fills(quick), solved, (line,))
    last_lost = max((cell.x for cell in grid.cells[-1] if cell.judgement.finding is Finding.FAILED), default=0.0)
    first_held = min(cell.x for cell in grid.cells[-1] if cell.judgement.finding is not Finding.FAILED)
    return StabilityMap(
        name="stability_stretch",
        title="Automatic method: stiffness of the twine against catch",
        question="A sector of 24 x 20 meshes of elastic twine, EA over the load that the pressure puts on a bar: from "
        "rubber to steel.",
        panels=(grid,),
        checks=(
            Verdict(
                f"Elastic twine, the whole bag filled: the softest twine with an answer is that of a long catch in "
                f"theory within a factor {AGREEMENT:g}.",
                last_lost < first_held <= AGREEMENT * theory and first_held >= theory / AGREEMENT,
                f"theory {theory:.2f}; failures up to {last_lost:.3g}, answers from {first_held:.3g}",
            ),
        ),
    )


def fills(quick: bool) -> Axis:
    """Catches from less than a band of half a mesh to the whole bag."""
    all_of_it = float(MESHES_LONG)
    some = (0.1, 1.0, all_of_it) if quick else (0.01, 0.1, 0.4, 0.5, 0.6, 1.0, 2.0, 5.0, 10.0, 15.0)
    rest = () if quick else (19.0, 19.6, 19.9, all_of_it)
    values = (*some, *rest)
    return Axis(f"filled meshes of {MESHES_LONG}", values, tuple(f"{v:g}" for v in values))


def fill_map(quick: bool) -> StabilityMap:
    """Radius of the entry against catch."""
    shares = (0.02, 0.35, 0.999) if quick else (0.005, 0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999)
    entries = Axis("radius of the entry / (N b / pi)", shares, tuple(f"{v:g}" for v in shares))

    def solved(x: float, y: float, **netting: float | str) -> tuple[Solution, Judgement]:
        return checked(plan_of(y, x, netting=dict(netting), tolerance=TOLERANCE))

    return StabilityMap(
        name="stability_fill",
        title="Automatic method: entry against catch",
        question="A sector of 24 x 20 meshes of inextensible twine: the catch from a fiftieth of the last band to the "
        "whole bag, the entry from a point to the bound at which its meshes are pulled fully open.",
        panels=(
            panel("diamond", entries, fills(quick), solved),
            panel("T90 with knots", entries, fills(quick), lambda x, y: solved(x, y, mesh="t90", knot_mm=8.0)),
        ),
    )


def slack_map(quick: bool) -> StabilityMap:
    """Speed against slack twine, without drag of the twine."""
    speed = Axis("towing speed, m/s", spaced(1e-4, 3.0, 4 if quick else 13))
    lengths = (0.0, 0.2) if quick else (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4)
    knots = Axis("knot / bar", lengths, tuple(f"{v:g}" for v in lengths))
    small = (0.1, 2.0) if quick else (0.02, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
    catches = Axis("filled meshes", small, tuple(f"{v:g}" for v in small))

    slack, shapes = [0.0], dict[tuple[str, float], list[Floats]]()

    def solved(mesh: str, row: float, plan: Plan) -> tuple[Solution, Judgement]:
        solution, judgement = checked(plan)
        slack.append(float(np.mean(solution.bar_tension == 0.0)))
        shapes.setdefault((mesh, row), []).append(solution.positions)
        return solution, judgement

    def knotted(x: float, y: float) -> tuple[Solution, Judgement]:
        netting = {"mesh": "t90", "knot_mm": 1000.0 * y * BAR_M}
        return solved("t90", y, plan_of(1.0, 0.2, x, netting=netting, normal_drag=0.0, tolerance=TOLERANCE))

    def square(x: float, y: float) -> tuple[Solution, Judgement]:
        return solved("square", y, plan_of(y, 0.5, x, netting={"mesh": "square"}, normal_drag=0.0, tolerance=TOLERANCE))

    panels = (panel("T90, 1 mesh filled", speed, knots, knotted), panel("square mesh", speed, catches, square))
    apart = max(float(np.abs(shape - row[0]).max() / np.ptp(row[0][:, 0])) for row in shapes.values() for shape in row)

    return StabilityMap(
        name="stability_slack",
        title="Automatic method: towing speed against slack twine",
        question="Sectors of 24 x 20 meshes without drag on the twine: T90 netting with one mesh filled, whose knots "
        "go slack ahead of the catch, and square netting, whose rings do: up to "
        f"{100.0 * max(slack):.0f} % of all bars.",
        panels=panels,
        checks=(
            Verdict(
                f"Inextensible twine takes the same shape at every speed, within {SAME_SHAPE:g} of its length.",
                apart < SAME_SHAPE,
                f"largest difference {apart:.1e} of the length",
            ),
        ),
    )


def checked(plan: Plan) -> tuple[Solution, Judgement]:
    """Solve the plan's case by its method, and hold the answer to that of dynamic relaxation."""
    model = model_of(plan, 1, 1)
    problem, solution = equilibrium.solve(model, plan.cases()[0], (), None)
    if not solution.report.outcome.converged:
        return solution, judge_alone(solution, "numbers come with a failure")
    second = dynamic_relaxation.solve(problem, SECOND)
    if not second.report.outcome.converged:
        nearby = replace(solution, positions=disturbed(problem, solution.positions, NEARBY, (1,)))
        second = dynamic_relaxation.solve(problem, SECOND, nearby)
    if not second.report.outcome.converged:
        return solution, judge_alone(solution, "no second method confirms it")
    return solution, judge(reference_of(model.bag, problem, second), solution, plan.model.tolerance)
