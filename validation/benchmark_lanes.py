"""How far eight like sectors in the lanes of one instruction would lead: ``python -m validation.benchmark_lanes``.

Times the parts of a catch in a series on one core, and beside them a band LU with its solution for eight sectors at
once, each with its own numbers, as a part that was written for lanes. What the whole would gain if every part gained as
much is printed beside the goal of 5000 cases a second over two cores. About half of a study's processor time is
spent between kernels (their own was taken call by call), which only cases handed on by eight throughout would share.
"""

from collections.abc import Callable
from pathlib import Path
from time import process_time

import numba
import numpy as np

from codend.bag.measures import measure_all
from codend.equilibrium import accuracy
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.mechanics import newton_state, newton_step
from codend.plan.plan import load_plan
from codend.solvers import newton
from codend.solvers.harmonics import harmonics_of
from codend.solvers.refusal import refusal

FLUME = Path(__file__).parent / "cases" / "flume_150x140.toml"
CATCHES = [10.0 + 2.0 * i for i in range(16)]
LANES = 8
GOAL = 5000.0
SWITCH = newton.DIRECT.switches[0]


def microseconds(function: Callable[[], object], repeats: int = 200) -> float:
    """Least processor time of a call."""
    function()
    best = np.inf
    for _ in range(10):
        before = process_time()
        for _ in range(repeats // 10):
            function()
        best = min(best, (process_time() - before) / (repeats // 10))
    return 1e6 * float(best)


@numba.njit(fastmath={"contract", "reassoc", "nsz"}, error_model="numpy")
def solved_in_lanes(band, right):  # type: ignore[no-untyped-def]
    """Factorise eight bands (size, width, 8) in place, and solve for a right side each in place, (size, 8)."""
    size, width, _ = band.shape
    half = width // 2
    for k in range(size):
        for below in range(1, min(half, size - 1 - k) + 1):
            row, start = k + below, half - below
            for lane in range(LANES):
                band[row, start, lane] /= band[k, half, lane]
            for i in range(1, min(half, size - 1 - k) + 1):
                for lane in range(LANES):
                    band[row, start + i, lane] -= band[row, start, lane] * band[k, half + i, lane]
    for i in range(size):
        for j in range(max(0, i - half), i):
            for lane in range(LANES):
                right[i, lane] -= band[i, half + j - i, lane] * right[j, lane]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, min(size, i + half + 1)):
            for lane in range(LANES):
                right[i, lane] -= band[i, half + j - i, lane] * right[j, lane]
        for lane in range(LANES):
            right[i, lane] /= band[i, half, lane]


def main() -> None:
    """Print the table."""
    plan = load_plan(FLUME, [f"catch.filled_meshes={CATCHES}"])
    model = model_of(plan, 1, 1)
    known, iterations = [], []
    for case in plan.cases():
        problem, solution = equilibrium.solve(model, case, known, None)
        known.append((case, solution))
        iterations.append(solution.report.iterations)
    before, steps = known[:-1], float(np.mean(iterations[3:]))
    prepared = model.prepared
    tangent = newton.tangent_at(problem, solution, prepared)
    run = newton._Iterations(problem, prepared, newton.DIRECT, None)
    run._set_start(solution, SWITCH)
    loads, state, step = (problem.structure, problem.loading), run.state, prepared.step
    measures = measure_all(model.bag, problem, solution)[2]

    linearise = microseconds(lambda: newton_step.linearise(*loads, prepared.pattern, run.tension, 0.0, state, step))
    factorise = microseconds(lambda: prepared.system.factorise(step.blocks))
    back = microseconds(lambda: prepared.system.solve(step.right[:1]))
    state_us = microseconds(lambda: newton_state.measure(*loads, run.tension, SWITCH, 0.0, state))
    iteration = linearise + factorise + back + state_us
    whole = {
        "solver": microseconds(lambda: equilibrium.solve(model, case, before, None), 50),
        "of which refusals": microseconds(lambda: refusal(problem, solution.positions, solution.share)),
        "measures": microseconds(lambda: measure_all(model.bag, problem, solution)),
        "tangent and estimates": microseconds(
            lambda: accuracy.estimate(model, case, newton.tangent_at(problem, solution, prepared), measures), 50
        ),
        "harmonics": microseconds(lambda: harmonics_of(problem, solution, model.ring), 50),
    }
    print(f"{'microseconds, one core':32}{'':>10}")
    for name, time in whole.items():
        print(f"  {name:30}{time:10.0f}")
    total = sum(whole.values()) - whole["of which refusals"]
    print(f"  {'a catch':30}{total:10.0f}   {2e6 / total:.0f} a second over two cores")
    parts = {"tangent": linearise, "factors": factorise, "solution": back, "loads and residual": state_us}
    print(f"an iteration, of which {steps:.1f} a catch: " + ", ".join(f"{n} {t:.0f}" for n, t in parts.items()))

    rows = prepared.system.arrays.rows  # type: ignore[attr-defined] # banded
    prepared.system.factorise(tangent.prepared.step.blocks)
    band = np.ones((*rows.shape, LANES))
    band[:, rows.shape[1] // 2] = 10.0
    right = np.ones((len(rows), LANES))
    lanes = microseconds(lambda: solved_in_lanes(band.copy(), right.copy()))
    copies = microseconds(lambda: (band.copy(), right.copy()))
    eight, one_by_one = lanes - copies, LANES * (factorise + back)
    gain = one_by_one / eight
    print(f"factors and solution of eight sectors in lanes {eight:.0f}, one by one {one_by_one:.0f}: gain {gain:.1f}")
    kernels = steps * iteration
    print(f"all {steps:.1f} iterations {kernels:.0f}: in lanes with that gain {kernels / gain:.0f} a catch")
    print(
        f"all of a catch {total:.0f}: in lanes with that gain {total / gain:.0f}, or {2e6 * gain / total:.0f} a second"
    )
    print(f"goal {GOAL:.0f} a second, {2e6 / GOAL:.0f} microseconds a catch")


if __name__ == "__main__":
    main()
