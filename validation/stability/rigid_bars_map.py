"""Rigid bars in time: time step against globalisation, and the largest stable step of the scheme.

About an equilibrium the scheme of ``rigid_motion`` is v' = v - dt M^-1 (K x + C v), x' = x + dt v' in the moves that
keep all lengths: M the masses with the added ones, K the stiffness of tensions and loads, C the drag that a bar's
own motion adds. Its eigenvalues z are those of z^2 - (2 - dt M^-1 C - dt^2 M^-1 K) z + 1 - dt M^-1 C; it is stable
while none is beyond the unit circle. ``RigidMotion.stable_time_step`` is a bound on that from sums over rows, of which
the shipped settings take half.

Stopping the net at peaks of its kinetic energy halves the stable step (*derived*). Let a mode without damping start
from rest at x, with a = (dt omega)^2: after two steps it is at (1 - 3 a + a^2) x, and its energy has fallen, so that
it is stopped there, if 1 < a < 3. Just beyond a = 1, which is dt = 1 / omega, the factor is below -1 and the stopped
mode grows; left alone it grows beyond dt = 2 / omega.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import null_space

from codend.mechanics import drag, rigid
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers import rigid_bars
from codend.solvers.outcome import Solution
from codend.solvers.rigid_bars import RigidBarsSettings
from codend.solvers.rigid_motion import RigidMotion
from validation.section import Verdict
from validation.stability.judge import Judgement, Reference, confirmed_reference, judge
from validation.stability.linear import dense_tangent, free_coordinates, lengths_of
from validation.stability.maps import Axis, Line, Panel, StabilityMap, panel, spaced
from validation.stability.relaxation_map import border
from validation.stability.scenes import bag_and_problem, disturbed, plan_of

TOLERANCE = 1e-5
NEARBY = 0.01
"""Disturbance of the equilibrium, in bar lengths."""
STEPS = 6_000
AGREEMENT = 1.4
"""Factor within which the border found must agree with the stable step of linear theory."""


class LinearMotion:
    """The motion about an equilibrium in the moves that keep all lengths."""

    def __init__(self, problem: Problem, solution: Solution) -> None:
        self.motion = RigidMotion(problem, solution.positions, np.zeros_like(solution.positions))
        self.motion.share[:] = solution.share
        self.motion.density[:] = solution.bar_tension / lengths_of(problem, solution.positions)
        free = free_coordinates(problem)
        keeping, mass = self._lengths_and_masses(problem, free)
        modes = null_space(keeping)
        still = np.zeros(len(problem.net.bars))
        stiffness = dense_tangent(problem, solution.positions, self.motion.density, still, solution.share)
        damping = _damping(problem, solution)[np.ix_(free, free)]
        inverse = np.linalg.inv(modes.T @ mass @ modes)
        self.stiffness = inverse @ (modes.T @ stiffness @ modes)
        self.damping = inverse @ (modes.T @ damping @ modes)

    def _lengths_and_masses(self, problem: Problem, free: np.ndarray) -> tuple[Floats, Floats]:
        """Gradients of half the squared lengths, (m, free), and the masses, (free, free)."""
        motion, structure = self.motion, problem.structure
        bars, nodes = len(structure.first), len(structure.free)
        gradient, square, inverse = np.zeros((2 * bars, 3)), np.zeros(bars), np.zeros((nodes, 3, 3))
        rigid.length_gradients(motion.position, structure, gradient, square)
        rigid.inverse_masses(motion.pattern, structure.free, gradient, square, motion.mass, motion.added, inverse)
        keeping = np.zeros((bars, 3 * nodes))
        for bar in range(bars):
            for end, node in enumerate((structure.first[bar], structure.second[bar])):
                keeping[bar, 3 * node : 3 * node + 3] += gradient[2 * bar + end]
        whole = np.zeros((3 * nodes, 3 * nodes))
        for node in range(nodes):
            whole[3 * node : 3 * node + 3, 3 * node : 3 * node + 3] = np.linalg.pinv(inverse[node])
        return keeping[:, free], whole[np.ix_(free, free)]

    def growth(self, dt: float) -> float:
        """Largest growth of any motion in a step of ``dt`` s."""
        size = len(self.stiffness)
        kick = -dt * np.hstack([self.stiffness, self.damping])
        kick[:, size:] += np.eye(size)
        step = np.vstack([np.hstack([np.eye(size), np.zeros((size, size))]) + dt * kick, kick])
        return float(np.abs(np.linalg.eigvals(step)).max())

    def largest_stable_step(self) -> float:
        """Time step, s, at which a motion begins to grow, to 1 %."""
        low, high = 1e-6, 1.0
        while high > 1.01 * low:
            middle = np.sqrt(low * high)
            # a motion that nothing slows neither grows nor dies down
            low, high = (middle, high) if self.growth(middle) < 1.0 + 1e-7 else (low, middle)
        return float(low)


def _damping(problem: Problem, solution: Solution) -> Floats:
    """Derivative of the drag by the nodes' velocities, turned to slow them, (3 n, 3 n): central differences."""
    size = solution.positions.size
    loading = problem.loading
    step = 1e-4 * loading.water.fastest
    found = np.zeros((size, size))
    for place in range(size):
        for sign in (1.0, -1.0):
            velocity, force = np.zeros_like(solution.positions), np.zeros_like(solution.positions)
            velocity.reshape(-1)[place] = sign * step
            drag.add_force(
                solution.positions, velocity, problem.structure, loading.water, loading.catch, solution.share, force
            )
            found[:, place] -= sign * force.ravel() / (2.0 * step)
    return found


def rigid_bars_map(quick: bool) -> StabilityMap:
    """From the empty net, as the papers do, and from near the equilibrium, where linear theory holds."""
    counts = (2, 6) if quick else (1, 2, 3, 4, 6)
    plan = plan_of(6.0, netting={"meshes_long": 24})
    references: dict[float, Reference] = {}
    stable, bound = [], []
    for g in counts:
        bag, problem = bag_and_problem(plan, globalisation=g)
        references[g] = confirmed_reference(bag, problem)
        linear = LinearMotion(problem, references[g].solution)
        stable.append(1e3 * linear.largest_stable_step())
        bound.append(1e3 * linear.motion.stable_time_step())
    step = Axis("time step, ms", spaced(0.3, 20.0, 7 if quick else 19))
    merged = Axis("meshes merged into one, each way", tuple(float(g) for g in counts))
    lines = (
        Line("stable step by linear theory, left alone", np.array(stable), np.array(counts)),
        Line("half of it: stopped at peaks of the energy", 0.5 * np.array(stable), np.array(counts)),
        Line("the tool's own bound, of which it takes half", np.array(bound), np.array(counts)),
    )

    def from_empty(dt_ms: float, g: float) -> tuple[Solution, Judgement]:
        return solved(references[g].problem, RigidBarsSettings(time_step_s=dt_ms / 1e3, steps_allowed=STEPS), g)

    def from_nearby(dt_ms: float, g: float) -> tuple[Solution, Judgement]:
        problem = references[g].problem
        start = disturbed(problem, references[g].solution.positions, NEARBY, (int(g),))
        near = replace(problem, net=replace(problem.net, positions=start))
        return solved(near, RigidBarsSettings(time_step_s=dt_ms / 1e3, steps_allowed=STEPS, ramp_s=0.0), g)

    def solved(problem: Problem, settings: RigidBarsSettings, g: float) -> tuple[Solution, Judgement]:
        solution = rigid_bars.solve(problem, TOLERANCE, settings)
        return solution, judge(references[g], solution, TOLERANCE)

    panels = (
        panel("from the empty net, the catch coming up in 0.5 s", step, merged, from_empty, lines),
        panel(f"from the equilibrium, disturbed by {NEARBY:g} bars", step, merged, from_nearby, lines),
    )
    return StabilityMap(
        name="stability_rigid_bars",
        title="Rigid bars: time step against globalisation",
        question="A sector of 24 x 24 meshes, merged by 1 to 6 each way, 6 filled, to a residual of "
        f"{TOLERANCE:g} with a fixed time step and no restarts.",
        panels=panels,
        checks=(_agreement(panels[1], stable), _between(panels[0], bound, stable)),
    )


def _agreement(near: Panel, stable: list[float]) -> Verdict:
    ratios = [(2.0 * last / s, 2.0 * after / s) for (last, after), s in zip(border(near), stable, strict=True)]
    return Verdict(
        f"Rigid bars near the equilibrium: the border is half the stable step of linear theory within a "
        f"factor {AGREEMENT:g}.",
        all(last <= AGREEMENT and after >= 1.0 / AGREEMENT for last, after in ratios),
        f"last right step over that half: {min(r[0] for r in ratios):.2f} to {max(r[0] for r in ratios):.2f}",
    )


def _between(far: Panel, bound: list[float], stable: list[float]) -> Verdict:
    found = border(far)
    return Verdict(
        "Rigid bars from the empty net: every step up to the tool's half of its bound is right, none beyond linear "
        "theory's.",
        all(after > 0.5 * b and last <= s for (last, after), b, s in zip(found, bound, stable, strict=True)),
        "last right step over the tool's bound: "
        + ", ".join(f"{last / b:.2f}" for (last, _), b in zip(found, bound, strict=True)),
    )
