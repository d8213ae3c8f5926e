"""How far the numbers of a result may be off: the solver's tolerance, merged meshes or none, and the pressure curve.

The number of meshes of the real net is real, not an error: a sector of the unglobalised net is exact in that respect,
and the membrane of the meridian method, which has meshes without number, is off by its distance to that sector.
"""

from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np

from codend.bag.build import merged_in_place
from codend.bag.loads import catch_weight_density
from codend.bag.measures import Measures, measure_all, measure_briefly, measure_with_changed
from codend.bag.near_ratio import NearRatio, narrower, near_enough, quick_looks
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.starts import BRIEFLY
from codend.mechanics.pressure import add_force as add_pressure
from codend.net.net import Floats
from codend.plan.plan import Case, Plan
from codend.solvers.newton import TangentAtEquilibrium, drifted, moved_by, polished

POLISHED = 1e-2
"""Tolerance of the answer that a result is compared with, over the result's own residual: one step with the tangent's
factors leaves 1e-3 to 5e-3 of that, and a hundredth of the estimate is none of its worth."""
FINEST = 1e-11
UNSETTLED = 10.0
"""On how far Newton's method moves in a few iterations where it does not settle: a T90 codend of stiff twine with a
small catch moved by 0.09 N of 1292 and 0.05 degrees in 8 of them, by 0.17 N and 0.08 degrees in 30."""
SMALL = 1e-3
"""Change of the suction that the tangent answers, over the one that is told."""
SAFETY = 1.5
LARGEST_MOVE = 0.1
"""Of a bar, that the tangent may answer such a change with: more is none of a net at rest."""
MORE_SUCTION = 0.1
"""Change of the suction outside the catch, relative, that the sensitivity to the pressure curve is told for."""
NOISE = 1e-8
"""Relative error that is claimed in any case: what a residual of ``FINEST`` may leave."""
NOISE_OF = np.array([0.0, 0.0, 0.0, 1.0])
"""Least sizes that it is of, in the units of the estimates: meshes all but shut are off by as much as others are."""
WEIGHT_LEFT_OUT = np.array([[0.7, 0.5], [0.7, 0.5], [0.75, 0.0], [7.0, 0.2]])
"""Relative change by wet weight of drag, volume, largest radius and opening ahead of the catch, at most, in w and w^2
with w the weight over the drag. Found on free full nets, of diamond and T90 netting alone and joined, with w from 0.005
to 0.5 (``python -m validation.weight_left_out``): where the sector is stable they were off by up to 0.16, 0.14, 0.25
and 2.8 w, where it is not by 0.66, 0.64, 0.5 and 6.8 w, and on other nets by up to 0.85 and 8.9 w: there the net lies
in waves, which ``wrinkles`` tells of. Merged meshes bear the weight, but in a bag of fewer rows and wider
meshes: they may be off by as much. On 60 nets of ``--seed 11``, none used, one was outside, by 1.3: its full net, not
stable, is known no better than that. On 77 of ``--nets 80 --seed 2`` all but one radius were within, off by 0.68 w
where 0.5 w was told: it is 0.75 w since."""

OF_THE_CATCH = np.array([0.0, 0.0, 1.5, 0.0])
"""What the catch's own weight changes beyond that, in its w: it presses from below, and bags it out. On 128 nets
(``--of-catch 1`` and ``0.5``) largest radii of stable sectors were off by up to 1.3 w, all else as above."""
AT_FIRST, AT_FIRST_UP_TO = np.array([10.0, 10.0, 25.0, 10.0]), 2e-4
"""What the first of it changes besides: a bag behind a small hoop sways under it and then holds. Of 116 nets of diamond
and T90 netting with w = 5e-4 three were outside the rest, by up to 1.6 w in drag and 3.2 w in the largest radius, one
with w = 1e-4 by 3.8 w and 11 w."""
TIPPED = np.array([0.15, 0.04, 0.3, 0.15])
"""Relative change of drag, volume, largest radius and opening by weight, however little, where a bag tips at its hoop
(``Kind.tips``). Symmetric shapes of square mesh, stable ones too, were left for others under 2e-5 of the drag, and then
changed by up to 0.113, 0.026, 0.23 and 0.109. With what else weight changes this covered all of 209 answers, the catch
bearing none, half or all of it."""
FEW_ROUND, TIPPED_OF_FEW = 12, np.array([0.3, 0.07, 0.3, 0.3])
"""Fewer meshes round make a bag that tips or swings go farther (``wrinkles.ASIDE_OF_FEW``). Of 37 bags of square mesh
of 6 to 10 (``python -m validation.weight_left_out --few``, seed 72, and 71 with ``--share 2e-5``) one changed by 0.26
in drag, 0.39 of what is told with all else, and the others by less."""

BY_MISMATCH = np.array([1.4, 1.0, 1.4, 2.0])
"""Relative change of drag, volume, largest radius and opening by the largest mismatch of a near ratio: with ``SAFETY``
more than the 1.6, 1.1, 1.6 and 2.1 of 15 random pairs of counts (``python -m validation.joined_counts``). On 38 pairs
of ``--seed 7``, none used, errors were at most 0.34, 0.63, 0.31 and 0.40 of their estimates."""
BY_STEP = np.array([0.1, 0.1, 0.1, 0.3])
"""Relative change of the same by the step in which a narrow sector tapers: where its counts are met exactly those of
two panels from 42 meshes to 30 and from 28 to 20 were off by 0.0044 in drag and 0.011 in opening with a step of 0.1,
and by less in the rest (``python -m validation.tapering_sectors``). On 23 sectors of 4 plans of ``--seed 34``, none
used, errors were at most 0.59, 0.73, 0.31 and 0.23 of what is stated."""
IN_CONTACT = 2
"""Narrower sectors that one whose netting lies in folds is judged by: which of many shapes it takes is chance."""
NO_WRINKLES = np.zeros(4)
SMEARED = np.array([[0.012, 9.0], [0.03, 18.0], [0.02, 8.0], [2.0, 700.0]])
"""Change by smearing ropes of drag, volume, largest radius (relative) and opening ahead (degrees), at most: what
there is in any case, and by the square of the shortening over the number of ropes
(``python -m validation.smeared_ropes``); of diamond netting, of others by ``Kind.smeared_errors``."""


def weight_errors(plan: Plan, share: float) -> np.ndarray:
    """What weight that is left out may change, relative, by its share of the drag, (4,)."""
    tipped = np.zeros(4)
    if share > 0.0 and any(part.kind.tips for part in plan.netting):
        few = min(min(part.open_meshes) for part in plan.netting) < FEW_ROUND
        tipped = TIPPED_OF_FEW if few else TIPPED
    at_first = AT_FIRST * min(share, AT_FIRST_UP_TO)
    return np.asarray(WEIGHT_LEFT_OUT @ [share, share**2] + at_first + tipped)


def smeared_errors(plan: Plan) -> np.ndarray:
    """How far smeared ropes may be off: relative in drag, volume and largest radius, degrees in opening, (4,)."""
    most = max(max(rope.shortening, 0.0) ** 2 / rope.number for rope in plan.ropes)
    wider = np.max([part.kind.smeared_errors for part in plan.netting], axis=0)
    return np.asarray(wider * (SMEARED @ [1.0, most]))


def between_ropes_errors(plan: Plan) -> np.ndarray | None:
    """How far merged meshes between ropes may be off, as ``smeared_errors``; None where ropes are better smeared."""
    known = [part.kind.between_ropes_errors for part in plan.netting if part.kind.between_ropes_errors is not None]
    return np.max(known, axis=0) if known else None


@dataclass(frozen=True)
class Errors:
    """Estimates beside the quantities of ``Measures``; nan where none could be made."""

    drag_error_n: float
    catch_volume_error_m3: float
    max_radius_error_m: float
    opening_ahead_error_deg: float
    drag_change_with_suction: float
    """Relative change of the drag for 10 % more suction outside the catch: what the pressure curve is worth."""

    @classmethod
    def unknown(cls) -> "Errors":
        """No estimate of anything."""
        return _NO_ESTIMATES

    def with_more(self, changes: Floats) -> "Errors":
        """The same with what else may change drag, volume, largest radius and opening, (4,)."""
        drag, volume, radius, opening = map(float, changes)
        return replace(
            self,
            drag_error_n=self.drag_error_n + drag,
            catch_volume_error_m3=self.catch_volume_error_m3 + volume,
            max_radius_error_m=self.max_radius_error_m + radius,
            opening_ahead_error_deg=self.opening_ahead_error_deg + opening,
        )


_NO_ESTIMATES = Errors(*(float("nan") for _ in fields(Errors)))


def estimate(
    model: BagModel,
    case: Case,
    tangent: TangentAtEquilibrium,
    measures: Measures,
    unseen_weight_n: float = 0.0,
    by_wrinkles: Floats = NO_WRINKLES,
) -> Errors:
    """Error estimates of one solved case, from the tangent at its equilibrium.

    The solver's part is the distance to an answer of a hundredth of its residual that Newton's method finds from it;
    where it finds none, ``UNSETTLED`` times the distance to where it went.
    With measures of the meridian method beside the solution of a sector, that distance is the membrane's error.
    ``unseen_weight_n`` is the wet weight of net and straps that the model leaves out; that of the catch is found here.
    Netting so heavy that it can fold over has none.
    ``by_wrinkles`` is what these may change, (4,), where something grows (``wrinkles``).
    The part of a globalised net is the distance between a sector of it and one of the real net, under the loads that
    are the same all round.
    """
    problem, report = tangent.problem, tangent.solution.report
    finest = max(POLISHED * max(report.residual, report.imbalance), FINEST)
    sizes = np.abs(measures.estimated)
    # while the tangent's own factors are there
    more, by_suction = _more_suction(tangent)
    finer = polished(tangent, finest)
    settled = finer is not None
    there = finer if finer is not None else drifted(tangent, finest)
    if there is None:
        return Errors.unknown()
    with_suction = float("nan")
    if settled and np.abs(by_suction).max() <= LARGEST_MOVE * problem.structure.length.min():
        coefficients = problem.loading.catch.coefficients + more
        exact, drag_n = measure_with_changed(model.bag, problem, there, coefficients, there.positions + by_suction)
        with_suction = (drag_n / exact[0] - 1.0) / SMALL
    else:
        exact = measure_briefly(model.bag, problem, there)
    solver = (1.0 if settled else UNSETTLED) * np.abs(sizes - exact)
    globalised = by_ratio(model, case, measures, 1 if problem.surface is None else IN_CONTACT)
    by_ropes = between_ropes_errors(model.plan) if model.between_ropes else None
    if model.globalisation > 1 and by_ropes is None:
        globalised += _distance(*(sector_measures(model.plan, case, g) for g in (1, model.globalisation)))
        globalised += by_merged_windows(model, case, measures)
    # N per m3 of the catch, in all and as the model bears it
    of_catch, borne = catch_weight_density(model.plan), problem.loading.catch.weight_density
    catch_n = abs(of_catch - borne if model.globalisation == 1 else of_catch) * measures.catch_volume_m3
    net_n = unseen_weight_n + (float(np.abs(problem.loading.dead).sum()) if model.globalisation > 1 else 0.0)
    share = (net_n + catch_n) / measures.drag_n
    errors = SAFETY * (solver + globalised) + NOISE * np.maximum(sizes, NOISE_OF)
    if share != 0.0:
        errors += (weight_errors(model.plan, share) + OF_THE_CATCH * catch_n / measures.drag_n) * sizes
    errors += by_wrinkles
    if by_ropes is not None:
        errors += by_ropes * [*sizes[:3], 1.0]
    if model.smeared and model.plan.ropes:
        errors += smeared_errors(model.plan) * [*sizes[:3], 1.0]
    if any(share > part.kind.folds_over_from for part in model.plan.netting):
        errors = np.full(4, np.nan)
    drag, volume, radius, opening = map(float, errors)
    return Errors(drag, volume, radius, opening, with_suction)


@lru_cache(maxsize=32)
def sector_measures(plan: Plan, case: Case, globalisation: int) -> Measures:
    """Measures of one sector of the merged net, under the loads that are the same all round; nan if it is not solved.

    The difference that merging makes there stands for the difference it makes in the full net. Sections whose counts
    share little have a sector of nearly their ratio, and those that taper a quick look. Counts of a small net without a
    common divisor make a sector of the whole net, which bears its weight and cannot be merged.
    Kept, for a choice of models and the estimates of every case ask for the same.
    """
    if not quick_looks(plan):
        near = near_enough(plan) if globalisation == 1 else None
        return _solved(model_of(by_any_method(plan), globalisation, 1, near=near), case)
    near, measures = quick_look(plan, case)
    if near is None or globalisation == 1:
        return measures
    return _solved(model_of(by_any_method(plan), globalisation, 1, True, near), case)


@lru_cache(maxsize=32)
def quick_look(plan: Plan, case: Case) -> tuple[NearRatio | None, Measures]:
    """The first narrow sector of netting that tapers which is solved, ropes smeared over it, and its measures.

    None, and nan, where none is.
    """
    for near in quick_looks(plan):
        found = _solved(model_of(by_any_method(plan), 1, 1, True, near), case)
        if np.isfinite(found.drag_n):
            return near, found
    return None, Measures.unknown()


@lru_cache(maxsize=32)
def rough_measures(plan: Plan, case: Case, globalisation: int = 1) -> Measures:
    """``sector_measures`` for a choice of models: ropes smeared over all meshes, for real ones may take minutes."""
    if not plan.ropes or plan.tapers:
        return sector_measures(plan, case, globalisation)
    return _solved(model_of(by_any_method(plan), globalisation, 1, smeared=True), case)


def by_any_method(plan: Plan) -> Plan:
    """The same plan, solved by whichever method finds its equilibria."""
    return plan.model_copy(update={"model": plan.model.model_copy(update={"method": "auto"})})


def _solved(model: BagModel, case: Case) -> Measures:
    problem, solution = equilibrium.solve(model, case, (), None, None if model.near is None else BRIEFLY)
    return measure_all(model.bag, problem, solution)[2] if solution.report.outcome.converged else Measures.unknown()


def by_ratio(model: BagModel, case: Case, measures: Measures, others: int = 1) -> np.ndarray:
    """What a sector of nearly the ratio of the counts is off by: the distance to narrower ones, which are further off.

    Answers are linear in the mismatch of the counts, as far as that is small; but where the way they change turns, two
    sectors happen to agree, and ``BY_MISMATCH`` is the least that is told; twice that, where no narrower one is solved.
    So many ``others`` are asked.
    """
    near = model.near
    if near is None:
        return np.zeros(4)
    least = least_by_ratio(near) * np.abs(measures.estimated)
    if near.step > 0.0:
        return least
    most, asked = least, 0
    other = narrower(model.plan, near)
    while other is not None and asked < others:
        compared = _solved(model_of(by_any_method(model.plan), 1, 1, model.smeared, other), case)
        if np.isfinite(compared.drag_n):
            here, there = np.array(near.mismatch), np.array(other.mismatch)
            part = np.linalg.norm(here) / np.linalg.norm(here - there)
            most, asked = np.maximum(most, part * _distance(measures, compared)), asked + 1
        other = narrower(model.plan, other)
    return most if asked else 2.0 * least


def least_by_ratio(near: NearRatio) -> np.ndarray:
    """What it is off by at the least, relative, (4,); where it tapers that is all that is known."""
    return BY_MISMATCH * near.off + BY_STEP * near.step


def by_merged_windows(model: BagModel, case: Case, measures: Measures) -> np.ndarray:
    """What merging makes of what windows change: how much that differs in the next coarser net.

    Where there is none coarser, or it is not solved, all that they change.
    """
    plan, g = by_any_method(model.plan), model.globalisation
    if not plan.window:
        return np.zeros(4)
    changed = measures.estimated - sector_measures(plan, case, g).estimated
    coarser = min((other for other in merged_in_place(plan) if other > g), default=None)
    if coarser is None:
        return np.abs(changed)
    other = _solved(model_of(plan, coarser, None), case).estimated - sector_measures(plan, case, coarser).estimated
    return np.where(np.isnan(other), np.abs(changed), np.abs(changed - other))


def _distance(first: Measures, second: Measures) -> np.ndarray:
    return np.abs(first.estimated - second.estimated)


def _more_suction(tangent: TangentAtEquilibrium) -> tuple[np.ndarray, np.ndarray]:
    """What a little more suction outside the catch adds to the pressure law's coefficients, and how nodes move by it.

    1 - Cp becomes 1 - 1.1 Cp, in proportion; inside the catch the water stays at stagnation pressure. The moves are
    told by the tangent, with one back-substitution, (n, 3); they are infinite where it is singular.
    """
    problem, position = tangent.problem, np.ascontiguousarray(tangent.solution.positions)
    catch = problem.loading.catch
    more = SMALL * MORE_SUCTION * catch.coefficients
    more[3] -= SMALL * MORE_SUCTION
    if tangent.singular:
        return more, np.full_like(position, np.inf)
    force = np.zeros_like(position)
    # pressures are linear in the coefficients
    add_pressure(position, problem.structure, catch._replace(coefficients=more), tangent.solution.share, force)
    return more, moved_by(tangent, force)
