"""Speed of the relaxation on the flume net: ``python -m validation.benchmarks``.

Prints, for the sector, globalised and full models of one plan, nanoseconds a bar and step for the inner loop and for
the whole relaxation (loads, masses and convergence included), and steps and milliseconds to a residual of 1e-6 from a
crude bag. Compilation comes first and is told apart. Each figure is the least of several runs: the machine's noise only
adds.
"""

from pathlib import Path
from time import perf_counter

import numba

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.mechanics import relaxation
from codend.mechanics.problem import Problem
from codend.plan.plan import load_plan
from codend.solvers import dynamic_relaxation

FLUME = Path(__file__).parent / "cases" / "flume_150x140.toml"
MODELS = (("sector", 1, 1), ("globalised by 10", 10, None), ("globalised by 5", 5, None), ("full", 1, None))
STEP_GOAL_NS = 5.0


def nanoseconds_a_bar_and_step(problem: Problem, runs: int = 30) -> float:
    """Time of the inner loop alone, ns a bar and step; least of several runs of about 5 ms each."""
    work = relaxation.workspace(problem.structure, problem.bands, problem.net.positions)
    relaxation.refresh(work, problem.structure, problem.loading, 1.5)
    bars = len(problem.net.bars)
    steps = max(2, 1_000_000 // bars)
    arrays = (work.state, work.chain, work.bar_end, work.bar_image, work.law, problem.structure.rotations)
    _steps(1, *arrays)
    return min(_timed(_steps, steps, *arrays) for _ in range(runs)) / (steps * bars) * 1e9


@numba.njit
def _steps(count, state, chain, bar_end, bar_image, law, rotations):  # type: ignore[no-untyped-def]
    for _ in range(count):
        relaxation.step(state, chain, bar_end, bar_image, law, rotations, 1.0, 1.0, 1.0)


def _timed(function, *arguments) -> float:  # type: ignore[no-untyped-def]
    started = perf_counter()
    function(*arguments)
    return perf_counter() - started


def main() -> None:
    """Print the table."""
    plan = load_plan(FLUME, ["catch.filled_meshes=40"])
    case = plan.cases()[0]
    started = perf_counter()
    tiny = problem_of(build_bag(plan, globalisation=10), plan, case)
    dynamic_relaxation.solve(tiny, 1e-2)
    print(f"compiling or loading the kernels: {perf_counter() - started:.1f} s")
    print(f"{'model':18}{'nodes':>8}{'bars':>8}{'inner loop':>16}{'with loads':>14}{'steps':>8}{'ms to 1e-6':>12}")
    print(f"{'':34}{'ns/bar/step':>16}{'ns/bar/step':>14}")
    for name, globalisation, sectors in MODELS:
        problem = problem_of(build_bag(plan, globalisation=globalisation, sectors=sectors), plan, case)
        bars = len(problem.net.bars)
        inner = nanoseconds_a_bar_and_step(problem)
        repeats = 1 if bars > 20_000 else 3
        reports = [dynamic_relaxation.solve(problem, 1e-6).report for _ in range(repeats)]
        best = min(reports, key=lambda report: report.solve_ms)
        whole = best.solve_ms * 1e6 / best.iterations / bars
        ending = "" if best.outcome.converged else f"  not converged: {best.outcome.value}"
        print(
            f"{name:18}{len(problem.net.positions):8}{bars:8}{inner:16.2f}{whole:14.2f}{best.iterations:8}"
            f"{best.solve_ms:12.1f}{ending}"
        )
    print(f"goal for the inner loop on the full net: {STEP_GOAL_NS:g} ns a bar and step on one core")


if __name__ == "__main__":
    main()
