"""How far other shapes of a net may lie from the one that was found."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from codend.bag.measures import Measures, measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.accuracy import by_any_method
from codend.equilibrium.bag_model import BagModel, model_of
from codend.equilibrium.stability import Stability, stability_of, tangent_of
from codend.equilibrium.starts import CRUDE, MERIDIAN, RELAXED_TO_THE_END
from codend.equilibrium.uneven_knots import stiffness
from codend.equilibrium.wrinkles import changed_by_wrinkles
from codend.net.net import Floats
from codend.plan.plan import Case, Plan
from codend.solvers import dynamic_relaxation, rigid_bars
from codend.solvers.newton import TangentAtEquilibrium

VERY_STIFF = 30.0
"""Stiffness of the mean corner over the mean tension of a bar times its length, beyond which twine holds netting open
or shut in more than one way: behind a hoop it was bent to, both twines of a mesh pull or one alone. A bag of 12 x 8
meshes of EI 2e-3 N m2 has 1.31 N in one shape and 2.05 N in another, at 650; commercial codends are below 3."""
STIFF_WITH_STRUTS = 6.0
"""The same where knots resist compression: in turned netting they tilt, one end in and one out, and stiff twine holds
row upon row in one pattern of that or another. A bag of 15 x 11 meshes, at 11, has 44.14 N and 43.96 N, both stable."""
STIFF_JOINED = 1.0
"""The same where sections of different counts are joined: a bag of 12 and then 36 meshes round of EI 2.5e-4 N m2, at 3,
has 18.69 N in a shape that is wrung by 1.8 degrees and 17.76 N in one that is not, where 0.78 N was stated."""
ROUGHLY = 1e-5
"""Tolerance of the others."""
ELSEWHERE = 3e-5
"""Relative distance from which a net lies in another shape than the symmetric one that starts near the membrane's shape
and through the interior lead to. A joint of 5 to 15 meshes, wrung by 4 degrees, was 9e-4 from the one that is not."""
RELAXED = dynamic_relaxation.METHOD, rigid_bars.METHOD
"""Methods that may lead from a crude bag to another symmetric shape than the others do."""
MOST_KNOTS = 500
"""Of a sector that is relaxed from a crude bag once more: a second."""


def apart_from_other_shapes(
    model: BagModel, case: Case, tangent: TangentAtEquilibrium, stability: Stability, measures: Measures
) -> Floats:
    """How far other shapes may lie from one that was found, drag, volume, largest radius and opening ahead, (4,).

    Of very stiff twine all that starts far apart lead to; of a relaxed sector what others do. Where a whole net lies
    in a stable shape and the symmetric one is not stable, it is one of many beside that; where that is stable too, one
    of two.
    """
    found = tangent.problem
    plan, loading = model.plan, found.loading
    if plan.rope or plan.window or loading.dead.any() or loading.catch.weight_density != 0.0:
        return np.zeros(4)
    whole = found.net.order == 1
    joined = len({section.meshes_round for section in plan.netting}) > 1
    most = STIFF_JOINED if joined else STIFF_WITH_STRUTS if found.structure.is_strut.any() else VERY_STIFF
    very_stiff, relaxed = stiffness(found, tangent.solution) > most, tangent.solution.report.method in RELAXED
    if not very_stiff and not relaxed and not (whole and stability.stable == "yes"):
        return np.zeros(4)
    plan = by_any_method(plan)
    sector = model_of(plan, model.globalisation, 1, model.smeared, model.near)
    if sector.bag.net.order == 1:
        return np.zeros(4)
    own, apart = measures.estimated, np.zeros(4)
    if very_stiff and len(sector.bag.net.positions) <= MOST_KNOTS:
        for other in _from_afar(replace(sector, plan=_roughly(plan)), case):
            apart = np.maximum(apart, np.abs(own - other.estimated))
    if not relaxed and not (whole and stability.stable == "yes"):
        return apart
    problem, solution = equilibrium.solve(sector, case, (), None)
    if not solution.report.outcome.converged:
        return apart
    symmetric = measure_all(sector.bag, problem, solution)[2]
    off = np.abs(own - symmetric.estimated)
    symmetric_stability = stability_of(sector, tangent_of(sector, problem, solution))
    if not whole or stability.stable != "yes" or symmetric_stability.stable != "no":
        return apart + off if (off > ELSEWHERE * symmetric.estimated).any() else apart
    changed = changed_by_wrinkles(sector.bag, case, solution, symmetric_stability, symmetric, touching=False)
    return np.asarray(apart + changed + off)


def _roughly(plan: Plan) -> Plan:
    """The plan at a tolerance that relaxation is quick to meet."""
    model = plan.model.model_copy(update={"tolerance": max(plan.model.tolerance, ROUGHLY)})
    return plan.model_copy(update={"model": model})


def _from_afar(sector: BagModel, case: Case) -> Iterator[Measures]:
    """What starts far from each other lead to."""
    for starts in ((MERIDIAN, CRUDE), (RELAXED_TO_THE_END,)):
        problem, solution = equilibrium.solve(sector, case, (), None, starts)
        if solution.report.outcome.converged:
            yield measure_all(sector.bag, problem, solution)[2]
