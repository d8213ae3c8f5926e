"""Cases of a plan: every speed and catch solved in turn, each from the last one where that helps."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import Measures, measure_all
from codend.bag.meridian import plan_case
from codend.equilibrium import accuracy, fidelity, standing_in
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.accuracy import Errors
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.fidelity import Choice
from codend.equilibrium.folds import in_contact_share
from codend.equilibrium.followed import HANGS_ASIDE, LYING_ON_ITSELF, NOT_FOLLOWED, as_it_lies
from codend.equilibrium.following import by_contact, follow
from codend.equilibrium.other_shapes import apart_from_other_shapes
from codend.equilibrium.room import check_room, explained
from codend.equilibrium.sliding import changed_by_sliding
from codend.equilibrium.snapping import apart_by_snapping
from codend.equilibrium.stability import Stability, stability_of, tangent_of
from codend.equilibrium.start_shapes import carried_over
from codend.equilibrium.wrinkles import changed_by_wrinkles, may_hang_aside, within_accuracy
from codend.mechanics.problem import Problem
from codend.net.net import Net
from codend.plan.plan import Case, Plan
from codend.solvers import newton
from codend.solvers.outcome import Progress, Solution, SolverReport
from codend.solvers.refusal import layers_touch
from codend.studies.case_result import CaseResult

if TYPE_CHECKING:
    import pandas as pd

OPTIONAL_TABLES = ("meshes.csv", "ropes.csv", "layers.csv")
"""Of models one mesh wide, and of plans without ropes or second layers, there is none."""

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

    @cached_property
    def ropes(self) -> "pd.DataFrame":
        """``ropes.csv``: a row a rope along the netting of a case; empty of plans without."""
        from codend.studies import tables

        return tables.rope_table(self.plan, self.cases)

    @cached_property
    def layers(self) -> "pd.DataFrame":
        """``layers.csv``: a row a band under a second layer of a case; empty of plans without."""
        from codend.studies import tables

        return tables.layer_table(self.plan, self.cases)

    @property
    def tables(self) -> "dict[str, pd.DataFrame]":
        """Its tables by the names of their files; without those of meshes and of ropes where there are none."""
        found = {
            "results.csv": self.table,
            "profile.csv": self.profile,
            "meshes.csv": self.meshes,
            "ropes.csv": self.ropes,
            "layers.csv": self.layers,
        }
        return {name: table for name, table in found.items() if name not in OPTIONAL_TABLES or not table.empty}


def solve(
    plan: Plan,
    progress: StudyProgress | None = None,
    choice: Choice | None = None,
    keep: Callable[[CaseResult], None] | None = None,
    near: Sequence[CaseResult] = (),
) -> Study:
    """Solve every case of a plan.

    Args:
        plan: what to solve, and how (``plan.model``).
        progress: called before and during every case.
        choice: the model, where ``fidelity.choose`` has been asked already.
        keep: called with every case as it is done, in the order they are solved in.
        near: solved cases of plans like this one: of those whose nets have the same bars the nearest leads to the
            first.

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
    free = check_room(plan, choice)
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
            led_by = known or _nearest(near, model, case)
            found_on, problem, solution = standing_in.solve(model, choice, case, led_by, report)
            result = measured(found_on.bag, case, problem, solution)
            if result.converged:
                if found_on is model:
                    known.append((case, solution))
                if progress is not None:
                    progress(done, len(cases), f"case {case.number}: its stability and errors")
                unseen_n = choice.unseen_weight_n if found_on is model else choice.weight_n
                result = _with_sliding(found_on, _judged(found_on, result, unseen_n, report), report)
                if found_on is not model:
                    result = replace(result, stands_in=found_on.near)
        except MemoryError as error:
            raise explained(plan, choice, error, free) from None
        results[case.number] = result
        if keep is not None:
            keep(result)
    if progress is not None:
        progress(len(cases), len(cases), "done")
    return Study(plan, choice, tuple(results[case.number] for case in cases))


def _judged(model: BagModel, result: CaseResult, unseen_weight_n: float, progress: Progress) -> CaseResult:
    """The result with its stability and errors, or that of the shape to which following what grows led."""
    plan, case, problem, solution = model.plan, result.case, result.problem, result.solution
    tangent = tangent_of(model, problem, solution)
    stability = stability_of(model, tangent, thorough=True)
    # sectors of diamond netting of one count that are stable lie on themselves nowhere, but for between ropes
    turned = any(part.knot_across_m > 0.0 for part in plan.netting)
    joined = len({count for part in plan.netting for count in part.open_meshes}) > 1
    roped = len(plan.ropes) > 0
    may_touch = stability.stable != "yes" or turned or joined or roped or result.net.order == 1
    touching = may_touch and layers_touch(problem, solution.positions)
    pressed = in_contact_share(problem, solution) > 0.0
    # what others of nearly the ratio, in folds likewise, differ by is in the estimates
    compared = pressed and model.near is not None and stability.stable == "yes"
    lying = touching or (pressed and not compared)
    changed = changed_by_wrinkles(result.bag, case, solution, stability, result.measures, lying)
    changed = changed + by_contact(result.measures) if compared else changed
    changed = changed + apart_from_other_shapes(model, case, tangent, stability, result.measures)
    if stability.stable == "yes":
        changed = changed + apart_by_snapping(model, case, problem, solution, result.measures)
    errors = accuracy.estimate(model, case, tangent, result.measures, unseen_weight_n, changed)
    aside = replace(NOT_FOLLOWED, reason=HANGS_ASIDE) if may_hang_aside(stability, result.measures) else NOT_FOLLOWED
    followed = replace(NOT_FOLLOWED, folds=True, reason=LYING_ON_ITSELF) if touching else aside
    followed = as_it_lies(result.bag, problem, solution) if pressed else followed
    result = replace(result, errors=errors, stability=stability, followed=followed)
    if stability.stable != "no" or plan.model.wrinkles is False or plan.model.bars_per_side > 1 or plan.ropes:
        return result
    if plan.model.wrinkles == "auto" and within_accuracy(plan, result.measures, errors):
        return result
    followed = follow(model, case, problem, solution, stability, progress)
    shape = followed.shape
    if shape is None:
        stands = result.followed
        folds = followed.folds or stands.folds
        followed = replace(followed, folds=folds, contact_share=stands.contact_share, fold_count=stands.fold_count)
        return replace(result, followed=followed)
    report = replace(
        shape.solution.report,
        attempts=(*solution.report.attempts, followed.reason, *shape.solution.report.attempts),
        solve_ms=solution.report.solve_ms + followed.spent_ms,
    )
    found = measured(shape.model.bag, case, shape.problem, replace(shape.solution, report=report))
    tangent = tangent_of(shape.model, shape.problem, shape.solution)
    folds = layers_touch(shape.problem, shape.solution.positions) or followed.contact_share > 0.0
    followed = replace(followed, folds=folds)
    covered = followed.covered and (not folds or followed.contact_share > 0.0)
    changed = followed.changed if covered else np.maximum(changed, followed.changed)
    errors = accuracy.estimate(shape.model, case, tangent, found.measures, unseen_weight_n, changed)
    return replace(found, errors=errors, stability=shape.stability, followed=followed)


def _with_sliding(model: BagModel, result: CaseResult, progress: Progress) -> CaseResult:
    """The result with what it may change that layers slide, which following what grows makes no smaller."""
    if not result.bag.layers:
        return result
    shape = result.bag, result.problem, result.solution, result.measures
    changed, slid = changed_by_sliding(model, result.case, *shape, progress)
    return replace(result, errors=result.errors.with_more(changed), by_sliding=changed, slid=slid)


def _nearest(near: Sequence[CaseResult], model: BagModel, case: Case) -> list[tuple[Case, Solution]]:
    """Of solved cases whose nets have the same bars between as many nodes as a model's, the nearest in catch and size.

    Its equilibrium is carried over to the model's net; the list is empty where there is none.
    """
    mine = model.bag.net
    solved = [one for one in near if one.case.catch_kind == case.catch_kind and one.report.method != plan_case.METHOD]

    def alike(other: Net) -> bool:
        pairs = (other.bars, mine.bars), (other.bar_image, mine.bar_image)
        nodes = len(other.positions) == len(mine.positions)
        return nodes and all(one is two or np.array_equal(one, two) for one, two in pairs)

    def apart(one: float, other: float) -> float:
        """Their difference over their sum."""
        return abs(one - other) / (one + other)

    size, order, length_m = case.catch_value, mine.order, float(mine.bar_length[0])
    distance = [
        apart(one.case.catch_value, size) + apart(one.net.order, order) + apart(float(one.net.bar_length[0]), length_m)
        for one in solved
    ]
    for number in sorted(range(len(solved)), key=distance.__getitem__):
        nearest = solved[number]
        if alike(nearest.net):
            return [(nearest.case, carried_over(nearest.solution, nearest.net, mine))]
    return []


def measured(bag: Bag, case: Case, problem: Problem, solution: Solution) -> CaseResult:
    """What was found of a case, with its measures but without errors; a case that failed has none."""
    if not solution.report.outcome.converged:
        nothing = Measures.unknown(), Errors.unknown()
        return CaseResult(case, bag, problem, solution, *nothing, None, None, None)
    meshes, rows, measures = measure_all(bag, problem, solution)
    return CaseResult(case, bag, problem, solution, measures, Errors.unknown(), None, rows, meshes)


def _solve_meridian(plan: Plan, choice: Choice, progress: StudyProgress | None) -> Iterator[CaseResult]:
    """Cases by the meridian method: its own drag and sizes; openings on a sector net laid out along its shape.

    What the membrane leaves out of the real net is estimated by the equilibrium of a sector that starts from it.
    """
    cases = plan.cases()
    sector = model_of(accuracy.by_any_method(plan), 1, 1)
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
        result = measured(bag, case, problem, solution)
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
