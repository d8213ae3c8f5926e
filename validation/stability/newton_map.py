"""Newton's method: how far its start may be, in shape and in load."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from codend.mechanics.problem import Problem
from codend.solvers import newton
from codend.solvers.continuation import with_catch
from codend.solvers.newton import NewtonSettings
from codend.solvers.outcome import Solution
from validation.stability.judge import Judgement, confirmed_reference, judge
from validation.stability.maps import Axis, StabilityMap, panel, spaced
from validation.stability.scenes import bag_and_problem, disturbed, plan_of

TOLERANCE = 1e-9
FILLED = 10.0
DIRECT = NewtonSettings(rough_starts=())


def newton_map(quick: bool) -> StabilityMap:
    """Newton's method alone and with its rough starts, over disturbance and step of catch or load."""
    distance = Axis("random move of the start / bar length", spaced(1e-3, 3.0, 6 if quick else 17))
    steps = (-9.5, -9.0, -8.0, -6.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 8.0, 10.0)[:: 4 if quick else 1]
    catches = Axis("catch of the start, meshes", tuple(FILLED + step for step in steps))
    loads = Axis("stagnation pressure of the start / wanted", spaced(0.01, 10.0, 3 if quick else 13))
    limp_bag, limp = bag_and_problem(plan_of(FILLED))
    stretching_netting = {"knot_mm": 5.0, "axial_stiffness_n": 300.0}
    stretching_bag, stretching = bag_and_problem(plan_of(FILLED, netting=stretching_netting))

    def over_catches(settings: NewtonSettings, x: float, y: float) -> tuple[Solution, Judgement]:
        return solved(limp, with_catch(limp, y), settings, x, y)

    def over_loads(x: float, y: float) -> tuple[Solution, Judgement]:
        loading = stretching.loading
        catch = loading.catch._replace(stagnation_pressure=loading.catch.stagnation_pressure * y)
        water = loading.water._replace(flow=loading.water.flow * np.sqrt(y))
        weaker = loading._replace(water=water, catch=catch)
        return solved(stretching, replace(stretching, loading=weaker), DIRECT, x, y)

    pairs = ((limp_bag, limp), (stretching_bag, stretching))
    references = {id(problem): confirmed_reference(bag, problem) for bag, problem in pairs}
    starts: dict[tuple[int, float], Solution] = {}

    def solved(
        wanted: Problem, other: Problem, settings: NewtonSettings, x: float, y: float
    ) -> tuple[Solution, Judgement]:
        key = id(wanted), y
        if key not in starts:
            starts[key] = newton.solve(other, 1e-10)
        start = starts[key]
        seed = round(1e3 * x), round(1e3 * y)
        start = replace(start, positions=disturbed(wanted, start.positions, x, seed))
        solution = newton.solve(wanted, TOLERANCE, start, settings)
        return solution, judge(references[id(wanted)], solution, TOLERANCE)

    narrow = confirmed_reference(*bag_and_problem(plan_of(4.0, 0.05)))

    def turned(x: float, y: float) -> tuple[Solution, Judgement]:
        aft = (narrow.bag.node_row >= y)[:, None]
        around = Rotation.from_rotvec([np.radians(x), 0.0, 0.0]).apply(narrow.solution.positions)
        start = replace(narrow.solution, positions=np.where(aft, around, narrow.solution.positions))
        solution = newton.solve(narrow.problem, TOLERANCE, start)
        return solution, judge(narrow, solution, TOLERANCE)

    angles = Axis("aft part turned about the axis, degrees", (0.0, 15.0, 30.0, 60.0, 90.0, 120.0, 150.0, 165.0, 180.0))
    rows = Axis(
        "row at which it begins",
        (1.0, 20.0, 38.0) if quick else (1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 38.0),
    )
    panels = (
        panel("inextensible, alone", distance, catches, lambda x, y: over_catches(DIRECT, x, y)),
        panel("inextensible, with rough starts", distance, catches, lambda x, y: over_catches(NewtonSettings(), x, y)),
        panel("knotted elastic, alone", distance, loads, over_loads),
        panel("narrow entry, twisted start, with rough starts", angles, rows, turned),
    )
    return StabilityMap(
        name="stability_newton",
        title="Newton's method: distance of the start against step of catch or load",
        question=f"A sector of 24 x 20 meshes with {FILLED:g} meshes filled, started from the equilibrium of another "
        "catch or of another pressure of the water, its nodes moved at random (normally distributed in each "
        f"coordinate); to a residual of {TOLERANCE:g}. Twisted starts are of a bag with an entry of a twentieth of the "
        "stretched radius, 4 meshes filled, its aft part turned about the axis.",
        panels=panels,
    )
