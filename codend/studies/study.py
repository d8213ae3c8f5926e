"""Cases of a plan: every speed and catch solved in turn, each from the last one where that helps."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import Measures, measure_all
from codend.bag.meridian import plan_case
from codend.equilibrium import accuracy, fidelity
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.accuracy import Errors
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.fidelity import Choice
from codend.equilibrium.room import check_room, too_little
from codend.equilibrium.stability import Stability, stability_of
from codend.mechanics.problem import Problem
from codend.plan.plan import Case, Plan
from codend.solvers import newton
from codend.solvers.memory import free_bytes
from codend.solvers.outcome import Solution, SolverReport
from codend.studies.case_result import CaseResult

if TYPE_CHECKING:
    import pandas as pd

StudyProgress = Callable[[int, int, str], None]
"""Told how many cases are done, of how many, and what is being done."""


@dataclass(frozen=True)
class Study:
    """All cases of a plan, with the model they were solved on and why."""

    plan: Plan
    choice: Choice
    cases: tuple[CaseResult, ...]

    @property
    def converged(self) -> bool:
        """Whether every case was solved."""
        return all(result.converged for result in self.cases)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """``results.csv``: a row a case."""
        from codend.studies import tables

        return tables.results_table(self.plan, self.choice.fidelity, self.cases)

    @cached_property
    def profile(self) -> "pd.DataFrame":
        """``profile.csv``: a row a knot row of a case."""
        from codend.studies import tables

        return tables.profile_table(self.plan, self.cases)

    @cached_property
    def meshes(self) -> "pd.DataFrame":
        """``meshes.csv``: a row a mesh of a case; empty where the model is one mesh wide."""
        from codend.studies import tables

        return tables.mesh_table(self.plan, self.cases)


def solve(
    plan: Plan,
    progress: StudyProgress | None = None,
    choice: Choice | None = None,
    keep: Callable[[CaseResult], None] | None = None,
) -> Study:
    """Solve every case of a plan.

    Args:
        plan: what to solve, and how (``plan.model``).
        progress: called before and during every case.
        choice: the model, where ``fidelity.choose`` has been asked already.
        keep: called with every case as it is done, in the order they are solved in.

    Returns:
        A study; a case that failed is in it, not converged, its numbers nan.

    Raises:
        InputError: the plan asks for what its netting does not allow.
        TooLittleMemory: the model does not fit into memory; which merged net would is told.
    """
    choice = fidelity.choose(plan) if choice is None else choice
    if choice.fidelity == "meridian":
        done_cases = []
        for result in _solve_meridian(plan, choice, progress):
            done_cases.append(result)
            if keep is not None:
                keep(result)
        return Study(plan, choice, tuple(done_cases))
    check_room(plan, choice)
    smeared = choice.fidelity == "smeared"
    model = model_of(plan, choice.globalisation, choice.sectors, smeared, choice.near)
    cases = plan.cases()
    known: list[tuple[Case, Solution]] = []
    results: dict[int, CaseResult] = {}
    # by growing catch, whatever the plan's order: each equilibrium leads to the next
    for done, case in enumerate(sorted(cases, key=lambda case: (case.speed_m_s, case.catch_value))):

        def report(doing: str, residual: float, case: Case = case, done: int = done) -> None:
            if progress is not None:
                progress(done, len(cases), f"case {case.number}: {doing}, residual {residual:.1e}")

        if progress is not None:
            progress(done, len(cases), f"case {case.number}")
        try:
            problem, solution = equilibrium.solve(model, case, known, report)
        except MemoryError:
            raise too_little(plan, choice, free_bytes()) from None
        result = _measured(model.bag, case, problem, solution)
        if result.converged:
            known.append((case, solution))
            if progress is not None:
                progress(done, len(cases), f"case {case.number}: its stability and errors")
            tangent = newton.tangent_at(problem, solution, model.prepared)
            stability = stability_of(model, tangent)
            errors = accuracy.estimate(model, case, tangent, result.measures, choice.unseen_weight_n)
            result = replace(result, errors=errors, stability=stability)
        results[case.number] = result
        if keep is not None:
            keep(result)
    if progress is not None:
        progress(len(cases), len(cases), "done")
    return Study(plan, choice, tuple(results[case.number] for case in cases))


def _measured(bag: Bag, case: Case, problem: Problem, solution: Solution) -> CaseResult:
    if not solution.report.outcome.converged:
        return CaseResult(case, bag, problem, solution, Measures.unknown(), Errors.unknown(), None, None, None)
    meshes, rows, measures = measure_all(bag, problem, solution)
    return CaseResult(case, bag, problem, solution, measures, Errors.unknown(), None, rows, meshes)


def _solve_meridian(plan: Plan, choice: Choice, progress: StudyProgress | None) -> Iterator[CaseResult]:
    """Cases by the meridian method: its own drag and sizes; openings on a sector net laid out along its shape.

    What the membrane leaves out of the real net is estimated by the equilibrium of a sector that starts from it.
    """
    cases = plan.cases()
    any_method = plan.model_copy(update={"model": plan.model.model_copy(update={"method": "auto"})})
    sector = model_of(any_method, 1, 1)
    for case in cases:
        if progress is not None:
            progress(case.number - 1, len(cases), f"case {case.number}: meridian method")
        started = perf_counter()
        shape = plan_case.solve_case(plan, case)
        report = SolverReport(
            method=plan_case.METHOD,
            outcome=shape.outcome,
            iterations=shape.iterations,
            residual=shape.residual,
            imbalance=shape.axial_imbalance,
            length_error=float("nan"),  # a membrane has no bars
            solve_ms=1e3 * (perf_counter() - started),
            attempts=(f"meridian method, {shape.method}: {shape.outcome.value}",),
        )
        bag = build_bag(plan, sectors=1, rows=(shape.x_m, shape.radius_m))
        problem = problem_of(bag, plan, case)
        share = plan_case.share_of(shape, bag.bands)
        solution = Solution(bag.net.positions, plan_case.tensions_on(bag, shape), share, report)
        result = _measured(bag, case, problem, solution)
        if not result.converged:
            yield result
            continue
        own = replace(
            result.measures,
            catch_volume_m3=shape.catch_volume_m3,
            front_radius_m=shape.front_radius_m,
            front_from_codline_m=shape.length_m - shape.front_x_m,
            max_radius_m=shape.largest_radius_m,
            length_m=shape.length_m,
            drag_n=shape.drag_n,
            catch_drag_n=shape.catch_drag_n,
            twine_drag_n=shape.twine_drag_n,
            entry_reaction_n=shape.entry_reaction_n,
            sideways_imbalance=0.0,  # a membrane is the same all round, and nothing turns it
        )
        _, of_bars = equilibrium.solve(sector, case, [(case, solution)], None)
        errors = Errors.unknown()
        if of_bars.report.outcome.converged:
            tangent = newton.tangent_at(problem, of_bars, sector.prepared)
            errors = accuracy.estimate(sector, case, tangent, own, choice.unseen_weight_n)
        # a membrane, which has no tangent
        yield replace(result, measures=own, errors=errors, stability=Stability("unknown"))
    if progress is not None:
        progress(len(cases), len(cases), "done")
