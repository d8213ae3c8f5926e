"""What following leaves: shapes that are not the same all round, and which stands in the symmetric one's place."""

from dataclasses import dataclass, replace

import numpy as np

from codend.bag.bag import Bag
from codend.bag.measures import Measures
from codend.equilibrium.bag_model import BagModel
from codend.equilibrium.folds import fold_count, in_contact_share
from codend.equilibrium.stability import Stability
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.outcome import Solution


@dataclass(frozen=True)
class Shape:
    """A shape that was found, on its model."""

    model: BagModel
    problem: Problem
    solution: Solution
    stability: Stability
    measures: Measures
    meshes: int
    """Real meshes that the sector is wide."""
    harmonic: int
    """Harmonic that was followed to it."""

    @property
    def growth(self) -> tuple[bool, float]:
        """Whether it is not known to last, and how strongly it grows, over a bar's stiffness under tension."""
        strengths = [-float(growth.eigenvalues[0].real) / self.stability.scale for growth in self.stability.growths]
        return self.stability.stable != "yes", max(strengths, default=0.0)


@dataclass(frozen=True)
class Followed:
    """What became of an equilibrium of which something grows."""

    shape: Shape | None
    """The shape that stands in its place, one that lasts, of the narrowest sector; None where none does."""
    reason: str
    """Why it does, or why none does, and how wide the sector is, in words."""
    drag_spread_n: float
    """Largest drag less least over the shapes that were found; nan where none was."""
    opening_spread_deg: float
    folds: bool
    """Whether layers of netting met."""
    changed: Floats
    """What wrinkles change at most, by the shapes that were found: drag, volume, largest radius and opening ahead. In
    contact it is their spread."""
    spent_ms: float
    contact_share: float = float("nan")
    """Share of the knots of the shape that stands which other netting presses on; nan without contact."""
    fold_count: int = 0
    """Most folds of any ring of the shape that stands, all round."""
    covered: bool = False
    """Whether that is all they may change: the shape lasts, and in contact it is one of several."""
    shapes_found: int = 0
    """Shapes in balance that the starts led to."""


LYING_ON_ITSELF = "netting lies on netting in this shape: contact is not modelled"
HANGS_ASIDE = "not followed: a bag of this netting that sways so easily may hang aside of its hoop as well"
NOT_FOLLOWED = Followed(None, "", float("nan"), float("nan"), False, np.zeros(4), 0.0)


def as_it_lies(bag: Bag, problem: Problem, solution: Solution) -> Followed:
    """What is told of an equilibrium that was found with contact between its layers, without following anything."""
    share, folds = in_contact_share(problem, solution), fold_count(solution.positions, problem.rings, bag.net.order)
    return replace(NOT_FOLLOWED, folds=share > 0.0, contact_share=share, fold_count=folds)


def meshes_wide(bag: Bag, meshes_round: int) -> int:
    """Real meshes that a bag's sector is wide, of so many round."""
    return round(meshes_round / bag.net.order)
