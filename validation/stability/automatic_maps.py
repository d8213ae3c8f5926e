"""The automatic method over plans at the edge: soft and stiff twine, any catch and entry, speed to zero, slack twine.

Every cell is a plan of its own. Its reference is the answer of the other kind of method: dynamic relaxation from a
crude bag, which knows neither tangent nor meridian shape, to a residual of ``SECOND``.
"""

from codend import equilibrium
from codend.plan import Plan
from codend.solvers import dynamic_relaxation
from codend.solvers.outcome import Solution
from validation.stability.judge import Judgement, judge, judge_alone, reference_of
from validation.stability.maps import Axis, StabilityMap, panel, spaced
from validation.stability.scenes import BAR_M, MESHES_LONG, STRETCHED_RADIUS_M, plan_of

TOLERANCE = 1e-8
SECOND = 1e-8
PRESSURE_PA = 500.0
"""Stagnation pressure at 1 m/s in fresh water."""


def automatic_maps(quick: bool) -> tuple[StabilityMap, ...]:
    """The three maps of the automatic method."""
    return stretch_map(quick), fill_map(quick), slack_map(quick)


def stretch_map(quick: bool) -> StabilityMap:
    """Axial stiffness against catch."""
    load = PRESSURE_PA * BAR_M * STRETCHED_RADIUS_M
    stiffness = Axis("EA / (q b N b / pi)", spaced(0.3, 3e7, 5 if quick else 17))

    def solved(x: float, y: float) -> tuple[Solution, Judgement]:
        return checked(plan_of(y, netting={"knot_mm": 4.0, "axial_stiffness_n": x * load}, tolerance=TOLERANCE))

    return StabilityMap(
        name="stability_stretch",
        title="Automatic method: stiffness of the twine against catch",
        question="A sector of 24 x 20 knotted meshes; EA over the load that the pressure puts on a bar, from rubber to "
        "steel.",
        panels=(panel("elastic, knotted", stiffness, fills(quick), solved),),
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

    def knotted(x: float, y: float) -> tuple[Solution, Judgement]:
        netting = {"mesh": "t90", "knot_mm": 1000.0 * y * BAR_M}
        return checked(plan_of(1.0, 0.2, x, netting=netting, normal_drag=0.0, tolerance=TOLERANCE))

    def square(x: float, y: float) -> tuple[Solution, Judgement]:
        return checked(plan_of(y, 0.5, x, netting={"mesh": "square"}, normal_drag=0.0, tolerance=TOLERANCE))

    return StabilityMap(
        name="stability_slack",
        title="Automatic method: towing speed against slack twine",
        question="Sectors of 24 x 20 meshes without drag on the twine: T90 netting with one mesh filled, whose knots "
        "go slack ahead of the catch, and square netting, whose rings do.",
        panels=(panel("T90, 1 mesh filled", speed, knots, knotted), panel("square mesh", speed, catches, square)),
    )


def checked(plan: Plan) -> tuple[Solution, Judgement]:
    """Solve the plan's case by its method, and hold the answer to that of dynamic relaxation."""
    scene = equilibrium.scene_of(plan, 1, 1)
    problem, solution = equilibrium.solve(scene, plan.cases()[0], (), None)
    if not solution.report.outcome.converged:
        return solution, judge_alone(solution, "numbers come with a failure")
    second = dynamic_relaxation.solve(problem, SECOND)
    if not second.report.outcome.converged:
        return solution, judge_alone(solution, "no second method confirms it")
    return solution, judge(reference_of(problem, second), solution, plan.model.tolerance)
