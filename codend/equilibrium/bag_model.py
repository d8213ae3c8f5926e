"""A bag as it is modelled, ready to be solved again and again."""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import in_case, problem_of
from codend.bag.near_ratio import NearRatio
from codend.errors import InputError
from codend.mechanics.problem import Problem
from codend.net.last_made import LastMade
from codend.plan.plan import Case, Plan
from codend.solvers.linear_systems import BandedSystem
from codend.solvers.mirror import Mirror, mirror_of
from codend.solvers.prepared import Prepared, prepare
from codend.solvers.ring import Ring


@dataclass(frozen=True)
class BagModel:
    """A bag with what is kept from one of its equilibria to the next."""

    plan: Plan
    bag: Bag
    sectors: int | None
    """Equal sectors that are modelled side by side, None for all."""
    globalisation: float
    smeared: bool = False
    """Whether ropes are spread over all columns of knots."""
    near: NearRatio | None = None
    """Nearly the ratio of the sections' counts, where a sector of it is modelled."""

    @cached_property
    def _first_case(self) -> Case:
        return self.plan.cases()[0]

    @cached_property
    def _first_problem(self) -> Problem:
        return problem_of(self.bag, self.plan, self._first_case)

    def problem(self, case: Case) -> Problem:
        """The bag under the loads of a case of its plan."""
        if case == self._first_case:
            return self._first_problem
        return in_case(self._first_problem, self.bag, self.plan, case)

    @cached_property
    def _joints(self) -> tuple[Hashable, ...]:
        """All that the numbering of its unknowns depends on: what is joined, what is held, and the bands of a catch."""
        s = self._first_problem.structure
        joined = (s.first, s.second, s.image, s.facets, s.facet_image, s.corners, s.corner_image, s.free)
        return (self.bag.bands, *(array.tobytes() for array in (*joined, s.wrap_node, s.wrap_image)))

    @cached_property
    def prepared(self) -> Prepared:
        """The unknowns numbered, and room for Newton's method to work in; made when first asked for.

        The numbering is that of the last model of the same joints.
        """
        structure, bands = self._first_problem.structure, self.bag.bands
        if len(structure.free) > MOST_NODES:
            return prepare(structure, bands)
        like = _prepared.of(self._joints, len(structure.free), lambda: prepare(structure, bands))
        return prepare(structure, bands, like)

    @property
    def between_ropes(self) -> bool:
        """Whether it is a sector of merged meshes with ropes as they are."""
        return self.globalisation > 1 and self.sectors is not None and len(self.plan.rope) > 0 and not self.smeared

    @property
    def narrow(self) -> bool:
        """Whether it is so narrow that a step costs next to nothing."""
        return isinstance(self.prepared.system, BandedSystem)

    @property
    def mirror_planes_rad(self) -> tuple[float, ...]:
        """Azimuths of the planes that may mirror it: upright, through the first seam, and through the sides."""
        return (np.pi / 2, float(np.radians(self.plan.seam_deg)), 0.0)

    @cached_property
    def half(self) -> tuple[Mirror, Prepared] | None:
        """The plane in which a wide net is its own mirror image, and room for one half; None without one."""
        if self.narrow:
            return None
        mirror = mirror_of(self._first_problem, self.mirror_planes_rad)
        if mirror is None:
            return None
        return mirror, prepare(self._first_problem.structure, self.bag.bands, mirror=mirror)

    @cached_property
    def ring(self) -> Ring:
        """The net as a sector of a ring, and room to ask its harmonics; numbered as the last of its joints."""
        structure, bands = self._first_problem.structure, self.bag.bands
        if len(structure.free) > MOST_NODES:
            return Ring(structure, bands)
        key = (structure.order == 2.0, *self._joints)
        return _rings.of(key, len(structure.free), lambda: Ring(structure, bands)).beside(structure, bands)


MOST_NODES = 3000
"""Of nets whose numbered unknowns are kept for others of the same joints: of one, and of all rings together."""
_prepared: LastMade[Prepared] = LastMade(2 * MOST_NODES)
_rings: LastMade[Ring] = LastMade(MOST_NODES)


@lru_cache(maxsize=1)
def _bag_of(plan: Plan, globalisation: float, sectors: int | None, smeared: bool) -> Bag:
    return build_bag(plan, globalisation=globalisation, sectors=sectors, smeared=smeared)


def bag_of(plan: Plan, globalisation: float, sectors: int | None, smeared: bool = False) -> Bag:
    """The bag of a plan; the last one is kept, for what chooses a model builds the one that is mostly chosen."""
    return _bag_of(plan, globalisation, sectors, smeared)


def model_of(
    plan: Plan, globalisation: float, sectors: int | None, smeared: bool = False, near: NearRatio | None = None
) -> BagModel:
    """Build the net of a plan.

    Raises:
        InputError: the plan asks for rigid bars and gives elastic twine or knots.
    """
    if plan.model.method == "rigid-bars":
        for key in ("axial_stiffness_n", "knot_axial_stiffness_n"):
            for value in filter(None, (getattr(s, key) for s in plan.netting)):
                allowed = 'left out with model.method = "rigid-bars": rigid bars do not stretch'
                raise InputError(file=plan.source, key=f"netting.{key}", value=value, allowed=allowed)
    if near is None:
        bag = bag_of(plan, globalisation, sectors, smeared)
    else:
        bag = build_bag(plan, globalisation=globalisation, sectors=sectors, smeared=smeared, near=near)
    return BagModel(plan, bag, sectors, globalisation, smeared, near)
