"""A bag as it is modelled, ready to be solved again and again."""

from dataclasses import dataclass
from functools import cached_property

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.near_ratio import NearRatio
from codend.errors import InputError
from codend.mechanics.structure import structure_of
from codend.plan.plan import Plan
from codend.solvers import newton
from codend.solvers.ring import Ring


@dataclass(frozen=True)
class BagModel:
    """A bag with what is kept from one of its equilibria to the next."""

    plan: Plan
    bag: Bag
    sectors: int | None
    """Equal sectors that are modelled side by side, None for all."""
    globalisation: int
    smeared: bool = False
    """Whether ropes are spread over all columns of knots."""
    near: NearRatio | None = None
    """Nearly the ratio of the sections' counts, where a sector of it is modelled."""

    @cached_property
    def prepared(self) -> newton.Prepared:
        """The unknowns numbered, and room for Newton's method to work in; made when first asked for."""
        return newton.prepare(structure_of(self.bag.net), self.bag.bands)

    @cached_property
    def ring(self) -> Ring:
        """The net as a sector of a ring, and room to ask its harmonics; made when first asked for."""
        return Ring(structure_of(self.bag.net), self.bag.bands)


def model_of(
    plan: Plan, globalisation: int, sectors: int | None, smeared: bool = False, near: NearRatio | None = None
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
    bag = build_bag(plan, globalisation=globalisation, sectors=sectors, smeared=smeared, near=near)
    return BagModel(plan, bag, sectors, globalisation, smeared, near)
