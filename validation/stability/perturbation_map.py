"""Every method from a crude bag shaken at random, over the tolerance.

On a full net, where nothing forbids a lopsided answer; every cell is shaken in its own way.
"""

from collections.abc import Callable
from dataclasses import replace

from codend.mechanics.problem import Problem
from codend.solvers import dynamic_relaxation, newton, rigid_bars
from codend.solvers.dynamic_relaxation import RelaxationSettings
from codend.solvers.outcome import Solution
from validation.stability.judge import Judgement, confirmed_reference, judge
from validation.stability.maps import Axis, StabilityMap, panel, spaced
from validation.stability.scenes import bag_and_problem, disturbed, plan_of


def perturbation_map(quick: bool) -> StabilityMap:
    """Random move of the start against tolerance for four methods, and against globalisation for Newton's."""
    distance = Axis("random move of the start / bar length", spaced(0.01, 3.0, 4 if quick else 12))
    tolerances = (1e-8, 1e-3) if quick else (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
    tolerance = Axis("tolerance", tolerances, tuple(f"{t:.0e}".replace("e-0", "e-") for t in tolerances))
    plan = plan_of()
    references = {4: confirmed_reference(*bag_and_problem(plan, 4, None))}

    def of_method(
        solve: Callable[[Problem, float], Solution], distance: float, tolerance: float
    ) -> tuple[Solution, Judgement]:
        reference = references[4]
        net = reference.problem.net
        shaken = disturbed(reference.problem, net.positions, distance, (round(1e3 * distance), round(1e12 * tolerance)))
        solution = solve(replace(reference.problem, net=replace(net, positions=shaken)), tolerance)
        return solution, judge(reference, solution, tolerance)

    viscous = RelaxationSettings(viscous=True)
    methods: dict[str, Callable[[Problem, float], Solution]] = {
        "Newton with rough starts": newton.solve,
        "relaxation, kinetic damping": dynamic_relaxation.solve,
        "relaxation, viscous damping": lambda p, t: dynamic_relaxation.solve(p, t, settings=viscous),
        "rigid bars": rigid_bars.solve,
    }
    panels = [
        panel(name, distance, tolerance, lambda x, y, solve=solve: of_method(solve, x, y))
        for name, solve in methods.items()
    ]
    return StabilityMap(
        name="stability_perturbation",
        title="Every method from a shaken start: size of the random move against tolerance",
        question="The full net of 24 x 20 meshes, 4 x 4 merged into one, 6 meshes filled; every node of the crude bag "
        "is moved at random (normally distributed in each coordinate).",
        panels=tuple(panels),
    )
