"""Which model a plan needs: no more than it asks for, the facts that decide, and what the choice costs."""

import math
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from codend.bag.build import build_bag, merged_in_place
from codend.bag.loads import catch_weight_density
from codend.bag.near_ratio import DRAG_BY_MISMATCH, SLOW_KNOTS, SLOW_MESHES, NearRatio, near_enough
from codend.equilibrium.accuracy import (
    between_ropes_errors,
    least_by_ratio,
    quick_look,
    rough_measures,
    smeared_errors,
    weight_errors,
)
from codend.equilibrium.bag_model import bag_of
from codend.errors import InputError
from codend.mechanics.weight import wet_weight
from codend.net.net import Net
from codend.plan.merging import between_ropes
from codend.plan.plan import Plan

HEAVIEST_GLOBALISED = 0.5
"""Weight over the drag of the smallest catch up to which diamond and T90 meshes are merged: there they were off by no
more than weightless sectors are; at a weight like the drag by ten times that."""
FEWEST_MESHES_ROUND = 8
"""Merged meshes round below which a globalised net is no bag any more."""


class Reason(Enum):
    """Why a model was chosen."""

    ASKED = auto()
    """The plan names it."""
    ROPES = auto()
    """The plan is the same all round but for its equal ropes, and sectors as wide as they are apart are exact."""
    BETWEEN_ROPES = auto()
    """Merged meshes in a sector with its ropes as they are are near enough for the accuracy in opening asked for."""
    SMEARED = auto()
    """Ropes smeared over all meshes are near enough for the accuracy in opening that was asked for."""
    WINDOW = auto()
    """A window is somewhere round the net; meshes are merged as the accuracy allows."""
    NO_WEIGHT = auto()
    """The plan is the same all round, and nothing is given a density other than the water's."""
    LITTLE_WEIGHT = auto()
    """The plan is the same all round but for a wet weight that does not matter."""
    WEIGHT = auto()
    """Wet weight breaks the symmetry; meshes are merged as the accuracy allows."""
    TIPS = auto()
    """Wet weight, however little, may tip the bag at its hoop; sectors tell nothing of that in merged meshes either."""
    TOO_HEAVY_TO_GLOBALISE = auto()
    """Wet weight breaks the symmetry, and is so large that sectors tell nothing of what merged meshes make of it."""


@dataclass(frozen=True)
class Choice:
    """A model, and the facts that it was chosen by; ``report.choice_words`` says them in sentences."""

    fidelity: str
    """``meridian``, ``sector``, ``globalised`` or ``full``."""
    globalisation: float
    """Real meshes merged into one, each way."""
    sectors: int | None
    """Equal sectors that are modelled side by side, None for all."""
    reason: Reason
    drag_error: float
    """Relative error in drag that the choice of model costs; nan where it was the user's and is not known ahead."""
    unseen_weight_n: float
    """Wet weight of net and straps that the model does not see."""
    order: int
    """Equal sectors that the plan can be divided into."""
    meshes_round: tuple[int, ...]
    """Of the sections from the entry, each count once."""
    weight_n: float
    """Wet weight of the whole net with its straps, that of what floats counted alike."""
    catch_weight_n: float
    """That of the smallest or the largest catch, whichever weighs more with the net over its drag."""
    least_drag_n: float
    """Drag of that catch at the lowest speed; infinite where it does not matter."""
    accuracy: float
    """What the choice may cost, relative (``model.accuracy``)."""
    knots: int
    """Of the model."""
    slow: bool
    """Whether a case takes seconds to minutes."""
    near: NearRatio | None = None
    """The sector of nearly the ratio of the counts that stands for one too wide."""
    real_ropes: bool = False
    """Whether ropes are modelled where they are, in a plan whose ropes may be smeared."""
    layered: bool = False
    """Whether second layers lie over the netting, of which every model knows no more than that they move with it."""

    @property
    def weight_over_drag(self) -> float:
        """Wet weight of net and catch over the drag; 0 where that does not matter."""
        return (self.weight_n + self.catch_weight_n) / self.least_drag_n

    @property
    def sees_weight(self) -> bool:
        """Whether wet weight acts on the model: on a full net, and on the sector of one that has no narrower."""
        return self.sectors is None or (self.order == 1 and self.fidelity != "meridian" and self.near is None)

    @property
    def weight_matters(self) -> bool:
        """Whether the weight breaks the symmetry by more than is allowed."""
        return self.weight_n + self.catch_weight_n > self.accuracy * self.least_drag_n


def choose(plan: Plan) -> Choice:
    """The model that the plan names, or for ``auto`` the smallest one that is exact enough for it.

    A plan that is the same all round needs one rotational sector of the real net, which is exact. Wet weight, of the
    net or of a catch that is not as dense as the water, breaks that symmetry: openings then differ from top to bottom,
    by as much as the weight over the drag, which counts once it exceeds ``model.accuracy``. Then as many meshes are
    merged as that allows in drag, judged by sectors of the merged and of the real net, but none where the weight is so
    large that such sectors, which know none, tell nothing.
    """
    asked = plan.model.fidelity
    sector = bag_of(plan, 1, 1).net
    # twine that floats counts like twine that sinks: in different sections they bend the bag all the same
    weight = sector.order * float(np.abs(wet_weight(sector, plan.tow.water_density_kg_m3)).sum())
    heavy_catch = catch_weight_density(plan) != 0.0
    of_catch, drag = 0.0, math.inf
    if (weight > 0.0 or heavy_catch) and asked in ("auto", "sector", "meridian"):
        of_catch, drag = _heaviest(plan, weight)
    # the sector of counts without a common divisor is the whole net, which bears its weight
    sees_weight = sector.order == 1 and asked != "meridian"
    unseen = 0.0 if sees_weight else weight
    left_out = 0.0 if sees_weight else (weight + of_catch) / drag
    dense = heavy_catch or bool(np.isfinite(sector.bar_density).any())
    knots, slow = _size(plan, sector, None)
    by_sector = Choice(
        fidelity="sector",
        globalisation=1,
        sectors=1,
        reason=Reason.ROPES if plan.seamed else Reason.LITTLE_WEIGHT if dense else Reason.NO_WEIGHT,
        drag_error=float(weight_errors(plan, left_out)[0]),
        unseen_weight_n=unseen,
        order=sector.sectors,
        meshes_round=tuple(dict.fromkeys(count for part in plan.netting for count in part.open_meshes)),
        weight_n=weight,
        catch_weight_n=of_catch,
        least_drag_n=drag,
        accuracy=plan.model.accuracy,
        knots=knots,
        slow=slow,
        real_ropes=bool(plan.ropes) and not plan.window,
        layered=len(plan.layer) > 0,
    )

    def all_round(globalisation: int, reason: Reason, drag_error: float) -> Choice:
        knots, slow = _size(plan, sector, globalisation)
        return replace(
            by_sector,
            fidelity="globalised" if globalisation > 1 else "full",
            globalisation=globalisation,
            sectors=None,
            reason=reason,
            drag_error=drag_error,
            unseen_weight_n=0.0,
            knots=knots,
            slow=slow,
        )

    if plan.window and asked in ("sector", "smeared", "meridian"):
        allowed = '"auto", "full" or "globalised": a window lies somewhere round the net, where a sector has no place'
        raise InputError(plan.source, "model.fidelity", asked, allowed)
    match asked:
        case "sector":
            return replace(by_sector, reason=Reason.ASKED)
        case "smeared":
            quick = _smeared(by_sector, plan, Reason.ASKED)
            if quick is None:
                allowed = (
                    '"auto", "sector", "full" or "globalised": no narrow sector of netting that tapers so is solved'
                )
                raise InputError(plan.source, "model.fidelity", asked, allowed)
            return quick
        case "meridian":
            return replace(by_sector, fidelity="meridian", reason=Reason.ASKED, drag_error=math.nan, slow=False)
        case "globalised":
            chosen = all_round(plan.model.globalisation, Reason.ASKED, math.nan)
            return replace(chosen, fidelity="globalised")
        case "full":
            return all_round(1, Reason.ASKED, 0.0)
    if plan.window and not by_sector.weight_matters:
        globalisation, error = _largest_globalisation(plan)
        return all_round(globalisation, Reason.WINDOW, error)
    if plan.ropes and plan.model.opening_accuracy_deg is not None:
        merged, errors = between_ropes(plan), between_ropes_errors(plan)
        if merged is None or errors is None:
            quick = _smeared(by_sector, plan, Reason.SMEARED, plan.model.opening_accuracy_deg, left_out)
        else:
            quick = _between_ropes(by_sector, plan, merged, errors)
        if quick is not None:
            return quick
    near_enough_by_sector = by_sector.drag_error <= plan.model.accuracy
    if near_enough_by_sector and not by_sector.weight_matters:
        near = near_enough(plan)
        return by_sector if near is None else _in_its_place(by_sector, plan, near, (weight + of_catch) / drag)
    if not near_enough_by_sector and any(part.kind.tips for part in plan.netting):
        return all_round(1, Reason.TIPS, 0.0)
    if by_sector.weight_over_drag <= HEAVIEST_GLOBALISED:
        globalisation, error = _largest_globalisation(plan)
        return all_round(globalisation, Reason.WEIGHT, error)
    return all_round(1, Reason.TOO_HEAVY_TO_GLOBALISE, 0.0)


def _between_ropes(exact: Choice, plan: Plan, merged: float, errors: np.ndarray) -> Choice | None:
    """Meshes merged in the exact sector; None: it is narrow as it is, or they are not near enough in opening."""
    assert plan.model.opening_accuracy_deg is not None
    if merged == 1:
        return None
    net = build_bag(plan, globalisation=merged, sectors=1).net
    relative = weight_errors(plan, exact.weight_over_drag if net.order > 1 else 0.0)
    if relative[3] > 0.0:
        first = min(plan.cases(), key=lambda case: (case.speed_m_s, case.catch_value))
        errors = errors + relative * [1.0, 1.0, 1.0, rough_measures(plan, first).opening_ahead_deg]
    if not errors[3] <= plan.model.opening_accuracy_deg:
        return None
    return replace(
        exact,
        fidelity="globalised",
        globalisation=merged,
        reason=Reason.BETWEEN_ROPES,
        drag_error=float(errors[0]),
        unseen_weight_n=exact.weight_n if net.order > 1 else 0.0,
        order=net.sectors,
        knots=len(net.positions),
        slow=False,
    )


def _smeared(
    exact: Choice, plan: Plan, reason: Reason, asked_deg: float = math.inf, left_out: float = 0.0
) -> Choice | None:
    """Ropes smeared over a sector in place of the exact one, narrow where netting tapers; None: none is so near.

    So near it is in opening, with what weight changes that is left out, by its share of the drag.
    """
    errors = smeared_errors(plan)
    if errors[3] > asked_deg:
        return None
    quick = replace(exact, fidelity="smeared", reason=reason, slow=False, real_ropes=False)
    if reason is Reason.SMEARED or plan.tapers:
        first = min(plan.cases(), key=lambda case: (case.speed_m_s, case.catch_value))
        near, measures = quick_look(plan, first) if plan.tapers else (None, rough_measures(plan, first))
        if not measures.drag_n > 0.0:
            return None
        relative = weight_errors(plan, left_out)
        if near is not None:
            relative = relative + least_by_ratio(near)
            knots = len(build_bag(plan, near=near, smeared=True).net.positions)
            quick = replace(quick, near=near, unseen_weight_n=exact.weight_n, knots=knots)
        errors = errors + relative * [1.0, 1.0, 1.0, measures.opening_ahead_deg]
    return None if errors[3] > asked_deg else replace(quick, drag_error=float(errors[0]))


def _in_its_place(exact: Choice, plan: Plan, near: NearRatio, left_out: float) -> Choice:
    """A sector of nearly the ratio of the counts in place of the exact one; it sees no weight."""
    return replace(
        exact,
        near=near,
        drag_error=float(DRAG_BY_MISMATCH * near.largest + weight_errors(plan, left_out)[0]),
        unseen_weight_n=exact.weight_n,
        knots=len(build_bag(plan, near=near).net.positions),
        slow=False,
    )


def _heaviest(plan: Plan, weight_n: float) -> tuple[float, float]:
    """Weight in water and drag of the smallest or the largest catch at the lowest speed, N.

    Of the two it is that which with the net weighs more over its drag. Where the drag is not found, the stagnation
    pressure on the entry's area stands in for it.
    """
    slowest = min(plan.tow.speed_m_s)
    cases = sorted((case for case in plan.cases() if case.speed_m_s == slowest), key=lambda case: case.catch_value)
    stand_in_n = 0.5 * plan.tow.water_density_kg_m3 * slowest**2 * math.pi * plan.entry_radius_m**2
    density = abs(catch_weight_density(plan))
    found: list[tuple[float, float]] = []
    # a net alone weighs most over the drag of its smallest catch
    for case in (cases[0], cases[-1])[: 1 + int(density > 0.0 and len(cases) > 1)]:
        measures = rough_measures(plan, case)
        drag = measures.drag_n if measures.drag_n > 0.0 else stand_in_n
        found.append((float(np.nan_to_num(density * measures.catch_volume_m3)), drag))
    return max(found, key=lambda pair: (weight_n + pair[0]) / pair[1])


def _size(plan: Plan, sector: Net, globalisation: int | None) -> tuple[int, bool]:
    """Knots of a model, and whether it is slow: of the full net with so many meshes merged, or of the sector."""
    sectors, g = (1, 1) if globalisation is None else (sector.sectors, globalisation)
    # all knots but the codline, which every sector has
    knots = 1 + (len(sector.positions) - 1) * sectors // g**2
    widest = max(max(part.open_meshes) for part in plan.netting)
    return knots, knots >= SLOW_KNOTS and widest * sectors // sector.sectors >= SLOW_MESHES * g


def _largest_globalisation(plan: Plan) -> tuple[int, float]:
    """Most meshes that may be merged each way for the accuracy asked for, and the relative error in drag."""
    by_size = sorted(plan.cases(), key=lambda case: case.catch_value)
    cases = by_size[:1] if by_size[0].catch_value == by_size[-1].catch_value else [by_size[0], by_size[-1]]
    real_n = [rough_measures(plan, case).drag_n for case in cases]
    for g in sorted(merged_in_place(plan), reverse=True):
        if g == 1 or min(min(part.open_meshes) for part in plan.netting) < FEWEST_MESHES_ROUND * g:
            continue
        globalised_n = [rough_measures(plan, case, g).drag_n for case in cases]
        errors = [abs(globalised / real - 1.0) for globalised, real in zip(globalised_n, real_n, strict=True)]
        if all(error <= plan.model.accuracy for error in errors):  # nan, where a sector was not solved, is no reason
            return g, max(errors)
    return 1, 0.0
