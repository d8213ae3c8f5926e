"""Which model a scene needs: no more than the scene asks for, and the reason in words."""

import math
from dataclasses import dataclass

from codend.build import build_net
from codend.loads import wet_weight
from codend.plan import Plan

NEGLIGIBLE_WEIGHT = 0.01
"""Wet weight over a bag's least drag, q times the entry's area, below which the scene counts as the same all round."""


@dataclass(frozen=True)
class Choice:
    """A model, and why it is enough."""

    fidelity: str
    """``meridian``, ``sector``, ``globalised`` or ``full``."""
    globalisation: int
    columns: int | None
    """Meshes round that are modelled, None for all."""
    why: str


def choose(plan: Plan) -> Choice:
    """The model that the plan names, or for ``auto`` the smallest one that is exact enough for its scene.

    A plan that is the same all round needs one rotational sector of the real net, which is exact. Wet weight breaks
    that symmetry; it counts once it exceeds 1 % of the stagnation pressure on the entry's area at the lowest speed.
    """
    asked, g = plan.model.fidelity, plan.model.globalisation
    weight = abs(float(wet_weight(build_net(plan), plan.tow.water_density_kg_m3).sum()))
    area = math.pi * plan.entry.radius_m**2
    scale = 0.5 * plan.tow.water_density_kg_m3 * min(plan.tow.speed_m_s) ** 2 * area
    heavy = weight > NEGLIGIBLE_WEIGHT * scale
    weighed = f"wet weight {weight:.3g} N against {scale:.3g} N of stagnation pressure on the entry's area"
    if asked == "sector":
        warning = f"; it leaves out the wet weight, which here matters ({weighed})" if heavy else ""
        return Choice("sector", 1, 1, f"Asked for: one of {_sectors(plan)} equal sectors of the real net{warning}.")
    if asked == "meridian":
        warning = f"; it leaves out the wet weight, which here matters ({weighed})" if heavy else ""
        return Choice("meridian", 1, 1, f"Asked for: the netting as a membrane, the same all round{warning}.")
    if asked == "globalised":
        return Choice("globalised", g, None, f"Asked for: the full net, {g} x {g} real meshes merged into one.")
    if asked == "full":
        return Choice("full", 1, None, "Asked for: every mesh of the real net.")
    if heavy:
        merged = min(plan.globalisations, key=lambda d: abs(d - 5))
        why = f"Wet weight breaks the symmetry ({weighed}): the full net, {merged} x {merged} meshes merged into one."
        return Choice("globalised", merged, None, why)
    light = "no twine density is given, so wet weight is left out" if weight == 0.0 else f"{weighed} is negligible"
    why = f"The plan is the same all round and {light}: one of {_sectors(plan)} equal sectors of the real net is exact."
    return Choice("sector", 1, 1, why)


def _sectors(plan: Plan) -> int:
    return plan.netting[0].meshes_round
