"""Solving a scene by every contender: time, drag, opening and volume, beside an answer converged far beyond."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from time import perf_counter

import numpy as np
import pandas as pd

from codend.bag.meridian.plan_case import first_guess, problem_for, solve_case
from codend.bag.meridian.problem import MeridianShape
from codend.bag.meridian.solve import solve_meridian
from codend.equilibrium import fidelity
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.fidelity import Choice
from codend.io.columns import error_of
from codend.plan.plan import Plan
from codend.studies.case_result import CaseResult
from codend.studies.speed_accuracy.contenders import (
    FULL,
    KINETIC,
    MEMBRANE,
    MERIDIAN,
    SECTOR,
    SOLVER_NAMES,
    VISCOUS,
    Scene,
    contenders,
)
from codend.studies.study import StudyProgress, solve

ACCURACIES = (0.1, 0.01, 0.001, 1e-6)
"""Relative errors in drag that are asked for."""
QUANTITIES = {"drag_n": "drag", "opening_ahead_deg": "opening", "catch_volume_m3": "volume"}
REFERENCE_TOLERANCE = 1e-12
CONFIRMING_TOLERANCE = 1e-10
CLOSED_FORM = "closed form"
REFINEMENTS = (2, 4)
REPEATS = ((100.0, 5), (1000.0, 2), (np.inf, 1))
"""Runs of which the least time counts, for solves up to so many ms; two of the quick ones when in a hurry."""


@dataclass
class Answer:
    """An answer and the time it took."""

    row: dict[str, object]
    ms: list[float]
    again: Callable[[], float]
    """Solves once more, and tells the time it took, ms."""


@dataclass(frozen=True)
class Measured:
    """A scene with all its answers."""

    scene: Scene
    reference: pd.Series
    """The answer that errors are measured against, by the names of ``Measures``."""
    points: pd.DataFrame
    """A row an answer; see ``table_of``."""
    automatic: pd.DataFrame
    """The same for the automatic choice, a row an accuracy asked for."""
    confirmations: pd.DataFrame
    """Relative distance of other methods' tightest answers from the reference; a row a method, a column a quantity."""

    @property
    def resolved(self) -> dict[str, float]:
        """Relative error down to which two methods confirm the reference, by quantity; nan where none does."""
        return {name: float(self.confirmations[name].min()) for name in QUANTITIES.values()}


def measure(scene: Scene, quick: bool, progress: StudyProgress | None = None) -> Measured:
    """Solve a scene by everything there is, and by what is chosen automatically for ``ACCURACIES``.

    Args:
        scene: what is solved.
        quick: fewer settings, and none is timed more than twice.
        progress: told of every contender.

    Raises:
        RuntimeError: the answer that the others are measured against was not found.
    """
    reference = _reference(scene)
    answers = []
    if scene.is_membrane:
        answers = [_closed_form(scene), *(_refined_meridian(scene, by) for by in REFINEMENTS)]
    tried = tuple(contenders(scene, quick))
    for done, contender in enumerate(tried):
        if progress is not None:
            progress(done, len(tried), contender.label)
        answer = _answer(scene.plan(*contender.keys))
        answer.row |= asdict(contender)
        answers.append(answer)
    chosen: dict[tuple[str, float], Answer] = {}
    asked = []
    for accuracy in ACCURACIES:
        plan = scene.plan(f"model.accuracy={accuracy:g}")
        began = perf_counter()
        choice = fidelity.choose(plan)
        choosing_ms = 1e3 * (perf_counter() - began)
        model = MEMBRANE if choice.fidelity == "meridian" else choice.fidelity, choice.globalisation
        if model not in chosen:
            chosen[model] = _answer(plan)
        more = {"model": model[0], "globalisation": model[1], "accuracy": accuracy, "choosing_ms": choosing_ms}
        asked.append((chosen[model], more))
    _repeat([*answers, *chosen.values()], quick)
    points = table_of(scene.name, [_timed(answer) for answer in answers], reference)
    automatic = table_of(scene.name, [_timed(answer) | more for answer, more in asked], reference)
    return Measured(scene, reference, points, automatic, _confirmations(points, scene.weighed))


def _answer(plan: Plan) -> Answer:
    """A plan of one case, solved once."""
    study = solve(plan)
    result = study.cases[0]
    row = {
        "method": SOLVER_NAMES.get(result.report.method) or (VISCOUS if plan.model.damping == "viscous" else KINETIC),
        "knots": len(result.net.positions),
        "outcome": result.report.outcome.name.lower(),
        "residual": result.report.residual,
        **{name: getattr(result.measures, name) for name in QUANTITIES},
        **{f"{short}_claimed": _claimed(result, name) for name, short in QUANTITIES.items()},
    }
    return Answer(row, [result.report.solve_ms], _solver_of(plan, study.choice))


def _solver_of(plan: Plan, choice: Choice) -> Callable[[], float]:
    """Solves the plan's case from nothing, without the error estimates, and tells the time it took, ms."""
    if choice.fidelity == "meridian":
        return lambda: _time_of(lambda: solve_case(plan, plan.cases()[0]))
    model = model_of(plan, choice.globalisation, choice.sectors)
    return lambda: float(equilibrium.solve(model, plan.cases()[0], (), None)[1].report.solve_ms)


def _repeat(answers: list[Answer], quick: bool) -> None:
    """Solve in rounds, every answer once in each, so that a busy machine is unfair to none more than to another."""
    for taken in range(1, 2 if quick else REPEATS[0][1]):
        for answer in answers:
            if taken < next(runs for longest, runs in REPEATS if min(answer.ms) <= longest):
                answer.ms.append(answer.again())


def _time_of(work: Callable[[], object]) -> float:
    began = perf_counter()
    work()
    return 1e3 * (perf_counter() - began)


def _timed(answer: Answer) -> dict[str, object]:
    return answer.row | {"solve_ms": min(answer.ms), "runs": len(answer.ms)}


def table_of(scene: str, rows: list[dict[str, object]], reference: pd.Series) -> pd.DataFrame:
    """Answers with their relative errors ``drag_error``, ``opening_error`` and ``volume_error``."""
    table = pd.DataFrame(rows)
    table.insert(0, "scene", scene)
    for name, short in QUANTITIES.items():
        table[f"{short}_error"] = (table[name] / reference[name] - 1.0).abs()
    return table


def _reference(scene: Scene) -> pd.Series:
    model = ("model.fidelity=full", f"model.tolerance={CONFIRMING_TOLERANCE:g}")
    if not scene.weighed:
        model = ("model.fidelity=sector", f"model.tolerance={REFERENCE_TOLERANCE:g}")
    table = solve(scene.plan("model.method=newton", *model)).table
    if not table["converged"].all():
        raise RuntimeError(f"the reference of the scene {scene.name!r} was not found")
    return table.iloc[0]


def _claimed(result: CaseResult, quantity: str) -> float:
    """Error that the result itself estimates, relative."""
    return float(getattr(result.errors, error_of(quantity)) / getattr(result.measures, quantity))


def _confirmations(points: pd.DataFrame, weighed: bool) -> pd.DataFrame:
    """Distance of answers by another method or on another net than the reference's, a sector's relaxation first."""
    converged = points["outcome"] == "converged"
    relaxed = points["method"] == KINETIC
    tight = (points["model"] == SECTOR) & relaxed & (points["tolerance"] == CONFIRMING_TOLERANCE)
    whole = (points["model"] == FULL) & (relaxed if weighed else True)
    table = pd.concat([points[tight & converged], points[whole & converged]])
    found = {short: table[f"{short}_error"] for short in QUANTITIES.values()}
    return pd.DataFrame({"method": table["method"], "model": table["model"], **found}).reset_index(drop=True)


def _closed_form(scene: Scene) -> Answer:
    """Uniform pressure and no twine drag, by quadrature: another scene's answer, taken as a rough one of this."""
    plan = scene.plan()
    case = plan.cases()[0]
    shape = first_guess(plan, case)
    if shape is None:
        raise RuntimeError(f"no closed form for the scene {scene.name!r}")
    return _of_shape(plan, shape, CLOSED_FORM, "rough", lambda: first_guess(plan, case))


def _refined_meridian(scene: Scene, refinement: int) -> Answer:
    """The meridian method on a finer grid than its own."""
    plan = scene.plan()
    case = plan.cases()[0]
    problem = problem_for(plan, case, 2.0 * (plan.netting[0].meshes_long - case.catch_value))
    shape = solve_meridian(problem, refinement)
    return _of_shape(
        plan, shape, MERIDIAN, f"grid refined by {refinement}", lambda: solve_meridian(problem, refinement)
    )


def _of_shape(plan: Plan, shape: MeridianShape, method: str, outcome: str, work: Callable[[], object]) -> Answer:
    """A shape of the meridian equations as an answer, its openings its own."""
    rows = 2 * plan.netting[0].meshes_long
    ahead = rows - 2.0 * plan.cases()[0].catch_value - np.arange(1, 6)
    opening = np.interp(ahead, np.arange(rows + 1), np.degrees(2.0 * shape.half_angle_rad))
    row = {
        "method": method,
        "model": MEMBRANE,
        "globalisation": 1,
        "knots": rows + 1,
        "outcome": outcome,
        "residual": shape.residual,
        "drag_n": shape.drag_n,
        "opening_ahead_deg": float(opening.mean()),
        "catch_volume_m3": shape.catch_volume_m3,
    }
    return Answer(row, [_time_of(work)], lambda: _time_of(work))
