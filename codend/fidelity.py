"""Which model a scene needs: no more than the scene asks for, the reason in words, and what the choice costs."""

import math
from dataclasses import dataclass

import numpy as np

from codend.accuracy import discretisation
from codend.build import build_net
from codend.loads import wet_weight
from codend.plan import Plan

NEGLIGIBLE_WEIGHT = 0.01
"""Wet weight over a bag's least drag, q times the entry's area, below which the scene counts as the same all round."""
FEWEST_MESHES_ROUND = 8
"""Merged meshes round below which a globalised net is no bag any more."""


@dataclass(frozen=True)
class Choice:
    """A model, and why it is enough."""

    fidelity: str
    """``meridian``, ``sector``, ``globalised`` or ``full``."""
    globalisation: int
    columns: int | None
    """Equal sectors that are modelled side by side, None for all."""
    why: str
    drag_error: float
    """Relative error in drag that the choice of model costs; nan where it was the user's and is not known ahead."""


def choose(plan: Plan) -> Choice:
    """The model that the plan names, or for ``auto`` the smallest one that is exact enough for its scene.

    A plan that is the same all round needs one rotational sector of the real net, which is exact. Wet weight breaks
    that symmetry; it counts once it exceeds 1 % of the stagnation pressure on the entry's area at the lowest speed.
    Then as many meshes are merged as ``model.accuracy`` allows, judged by sectors of the merged and of the real net.
    """
    asked, g = plan.model.fidelity, plan.model.globalisation
    sector = build_net(plan, columns=1)
    weight = sector.order * abs(float(wet_weight(sector, plan.tow.water_density_kg_m3).sum()))
    area = math.pi * plan.entry.radius_m**2
    scale = 0.5 * plan.tow.water_density_kg_m3 * min(plan.tow.speed_m_s) ** 2 * area
    heavy = weight > NEGLIGIBLE_WEIGHT * scale
    weighed = f"wet weight {weight:.3g} N against {scale:.3g} N of stagnation pressure on the entry's area"
    left_out = f"; it leaves out the wet weight, which here matters ({weighed})" if heavy else ""
    if asked == "sector":
        why = f"Asked for: one of {_sectors(plan, sector.order)} of the real net{left_out}."
        return Choice("sector", 1, 1, why, math.nan if heavy else 0.0)
    if asked == "meridian":
        why = f"Asked for: the netting as a membrane, the same all round{left_out}."
        return Choice("meridian", 1, 1, why, math.nan)
    if asked == "globalised":
        why = f"Asked for: the full net, {g} x {g} real meshes merged into one."
        return Choice("globalised", g, None, why, math.nan)
    if asked == "full":
        return Choice("full", 1, None, "Asked for: every mesh of the real net.", 0.0)
    if heavy:
        merged, error = _merged(plan)
        model = f"the full net, {merged} x {merged} meshes merged into one" if merged > 1 else "the full net"
        why = (
            f"Wet weight breaks the symmetry ({weighed}): {model}, "
            f"which costs {100.0 * error:.2g} % in drag where {100.0 * plan.model.accuracy:g} % is allowed."
        )
        return Choice("globalised" if merged > 1 else "full", merged, None, why, error)
    light = "no twine density is given, so wet weight is left out" if weight == 0.0 else f"{weighed} is negligible"
    why = f"The plan is the same all round and {light}: one of {_sectors(plan, sector.order)} of the real net is exact."
    return Choice("sector", 1, 1, why, 0.0)


def _sectors(plan: Plan, order: int) -> str:
    """How many sectors there are, and how many meshes of each section make one if it is not a single one of each."""
    wide = list(dict.fromkeys(part.meshes_round // order for part in plan.netting))
    if wide == [1]:
        return f"{order} equal sectors"
    *others, last = map(str, wide)
    meshes = f"{', '.join(others)} and {last}" if others else last
    return f"{order} equal sectors, {meshes} meshes wide,"


def _merged(plan: Plan) -> tuple[int, float]:
    """Most meshes that may be merged each way for the accuracy asked for, and the relative error in drag."""
    cases = sorted(plan.cases(), key=lambda case: case.catch_value)
    for g in sorted(plan.globalisations, reverse=True):
        if g == 1 or min(part.meshes_round for part in plan.netting) < FEWEST_MESHES_ROUND * g:
            continue
        errors = [discretisation(plan, case, g) for case in (cases[0], cases[-1])]
        if any(np.isnan(error.relative_drag) or error.relative_drag > plan.model.accuracy for error in errors):
            continue
        return g, max(error.relative_drag for error in errors)
    return 1, 0.0
