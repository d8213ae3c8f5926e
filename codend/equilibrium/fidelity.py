"""Which model a scene needs: no more than the scene asks for, the reason in words, and what the choice costs."""

import math
from dataclasses import dataclass

import numpy as np

from codend.bag.build import build_bag
from codend.equilibrium.accuracy import WEIGHT_LEFT_OUT, sector_measures
from codend.mechanics.weight import wet_weight
from codend.net.net import Net
from codend.plan.plan import Plan

SLOW_KNOTS, SLOW_MESHES = 3000, 10
"""Knots of a model, and meshes round it, from which a case takes seconds or more: full nets of joined sections took 2 s
with 3 800 knots and 23 s with 15 000. Narrow sectors, however long, take milliseconds."""
HEAVIEST_MERGED = 0.5
"""Weight over the drag of the smallest catch up to which merged diamond and T90 meshes are tried: there they were off
by no more than weightless sectors are; at a weight like the drag by ten times that."""
FEWEST_MESHES_ROUND = 8
"""Merged meshes round below which a globalised net is no bag any more."""


@dataclass(frozen=True)
class Choice:
    """A model, and why it is enough."""

    fidelity: str
    """``meridian``, ``sector``, ``globalised`` or ``full``."""
    globalisation: int
    sectors: int | None
    """Equal sectors that are modelled side by side, None for all."""
    why: str
    drag_error: float
    """Relative error in drag that the choice of model costs; nan where it was the user's and is not known ahead."""
    unseen_weight_n: float = 0.0
    """Wet weight that the model does not see."""


def choose(plan: Plan) -> Choice:
    """The model that the plan names, or for ``auto`` the smallest one that is exact enough for its scene.

    A plan that is the same all round needs one rotational sector of the real net, which is exact. Wet weight breaks
    that symmetry: openings then differ from top to bottom, by as much as the weight over the drag, which counts once it
    exceeds ``model.accuracy``. Then as many meshes are merged as that allows in drag, judged by sectors of the merged
    and of the real net, but none where the weight is so large that such sectors, which know none, tell nothing.
    """
    asked, g = plan.model.fidelity, plan.model.globalisation
    sector = build_bag(plan, sectors=1).net
    # twine that floats counts like twine that sinks: in different sections they bend the bag all the same
    weight = sector.order * float(np.abs(wet_weight(sector, plan.tow.water_density_kg_m3)).sum())
    drag = _least_drag(plan) if weight > 0.0 and asked in ("auto", "sector", "meridian") else math.inf
    heavy = weight > plan.model.accuracy * drag
    weighed = f"wet weight {weight:.3g} N, {100.0 * weight / drag:.2g} % of the drag of the smallest catch"
    # the sector of counts without a common divisor is the whole net, which bears its weight
    unseen = 0.0 if sector.order == 1 and asked != "meridian" else weight
    error = float(WEIGHT_LEFT_OUT[0] @ [unseen / drag, (unseen / drag) ** 2])
    left_out = f"; it leaves out the wet weight, which here matters ({weighed})" if heavy and unseen > 0.0 else ""
    if asked == "sector":
        why = f"Asked for: {_sector(plan, sector.order)}{left_out}.{_slow(plan, sector)}"
        return Choice("sector", 1, 1, why, error, unseen)
    if asked == "meridian":
        why = f"Asked for: the netting as a membrane, the same all round{left_out}."
        return Choice("meridian", 1, 1, why, math.nan, unseen)
    if asked == "globalised":
        why = f"Asked for: the full net, {g} x {g} real meshes merged into one."
        return Choice("globalised", g, None, why + _slow(plan, sector, g), math.nan)
    if asked == "full":
        return Choice("full", 1, None, f"Asked for: every mesh of the real net.{_slow(plan, sector, 1)}", 0.0)
    if heavy:
        bearable = weight <= min(HEAVIEST_MERGED, *(part.kind.folds_over_from for part in plan.netting)) * drag
        merged, error = _merged(plan) if bearable else (1, 0.0)
        model = f"the full net, {merged} x {merged} meshes merged into one" if merged > 1 else "the full net"
        cost = f"which costs {100.0 * error:.2g} % in drag where {100.0 * plan.model.accuracy:g} % is allowed"
        if not bearable:
            cost = "for merged meshes may bear so much of it otherwise"
        why = f"Wet weight breaks the symmetry ({weighed}): {model}, {cost}."
        return Choice("globalised" if merged > 1 else "full", merged, None, why + _slow(plan, sector, merged), error)
    dense = any(part.twine_density_kg_m3 is not None for part in plan.netting)
    light = f"{weighed}, is negligible" if dense else "no twine density is given, so wet weight is left out"
    why = f"The plan is the same all round and {light}: {_sector(plan, sector.order)} is exact.{_slow(plan, sector)}"
    return Choice("sector", 1, 1, why, error, unseen)


def _least_drag(plan: Plan) -> float:
    """Drag of the smallest catch at the lowest speed, N; stagnation pressure on the entry's area if it is not found."""
    case = min(plan.cases(), key=lambda case: (case.speed_m_s, case.catch_value))
    drag = sector_measures(plan, case, 1).drag_n
    area = math.pi * plan.entry.radius_m**2
    return drag if drag > 0.0 else 0.5 * plan.tow.water_density_kg_m3 * case.speed_m_s**2 * area


def _sector(plan: Plan, order: int) -> str:
    """The narrowest sector: of how many, and how many meshes of each section make it if it is not a single one."""
    counts = list(dict.fromkeys(part.meshes_round for part in plan.netting))
    if order == 1:
        return f"the full net (its mesh counts {_listed(counts)} have no common divisor)"
    wide = [count // order for count in counts]
    meshes = "" if wide == [1] else f", {_listed(wide)} meshes wide,"
    return f"one of {order} equal sectors{meshes} of the real net"


def _slow(plan: Plan, sector: Net, merged: int | None = None) -> str:
    """What a large model costs in time, in words; empty for others.

    The model is the sector, or the full net with so many meshes merged into one each way.
    """
    counts = {part.meshes_round for part in plan.netting}
    sectors, g = (1, 1) if merged is None else (sector.order, merged)
    # all knots but the codline, which every sector has
    knots = 1 + (len(sector.positions) - 1) * sectors // g**2
    if knots < SLOW_KNOTS or max(counts) * sectors // sector.order < SLOW_MESHES * g:
        return ""
    wide = merged is None and len(counts) > 1
    narrower = "; meshes round with a larger common divisor make a narrower sector" if wide else ""
    return f" Its {knots} knots take seconds to minutes a case{narrower}."


def _listed(counts: list[int]) -> str:
    *others, last = map(str, counts)
    return f"{', '.join(others)} and {last}" if others else last


def _merged(plan: Plan) -> tuple[int, float]:
    """Most meshes that may be merged each way for the accuracy asked for, and the relative error in drag."""
    by_size = sorted(plan.cases(), key=lambda case: case.catch_value)
    cases = by_size[:1] if by_size[0].catch_value == by_size[-1].catch_value else [by_size[0], by_size[-1]]
    real_n = [sector_measures(plan, case, 1).drag_n for case in cases]
    for g in sorted(plan.globalisations, reverse=True):
        if g == 1 or min(part.meshes_round for part in plan.netting) < FEWEST_MESHES_ROUND * g:
            continue
        merged_n = [sector_measures(plan, case, g).drag_n for case in cases]
        errors = [abs(merged / real - 1.0) for merged, real in zip(merged_n, real_n, strict=True)]
        if all(error <= plan.model.accuracy for error in errors):  # nan, where a sector was not solved, is no reason
            return g, max(errors)
    return 1, 0.0
