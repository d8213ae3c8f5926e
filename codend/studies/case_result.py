"""One case of a study: what was asked, the equilibrium, and what was measured in it."""

from dataclasses import dataclass, field

import numpy as np

from codend.bag.bag import Bag, real_tensions
from codend.bag.measures import Measures, Meshes, Rows
from codend.bag.near_ratio import NearRatio
from codend.equilibrium.accuracy import Errors
from codend.equilibrium.followed import NOT_FOLLOWED, Followed
from codend.equilibrium.stability import Stability
from codend.mechanics.problem import Problem
from codend.net.net import Floats, Net
from codend.plan.plan import Case
from codend.solvers.outcome import Solution, SolverReport

_NOTHING, _NOT_KNOWN = np.zeros(4), np.full(4, np.nan)


@dataclass(frozen=True)
class CaseResult:
    """One case of a study: what was asked, the equilibrium, and what was measured in it."""

    case: Case
    bag: Bag
    problem: Problem
    solution: Solution
    measures: Measures
    errors: Errors
    """How far the measures may be off."""
    stability: Stability | None
    """Whether the net stays as it is; None where the case was not solved."""
    rows: Rows | None
    """None where the case was not solved."""
    meshes: Meshes | None
    followed: Followed = NOT_FOLLOWED
    """What became of what grows of it."""
    by_sliding: Floats = field(default_factory=lambda: _NOTHING)
    """What of the errors is for layers that may slide: of drag, volume, largest radius and opening, (4,)."""
    slid: Floats = field(default_factory=lambda: _NOT_KNOWN)
    """These with its layers as nets of their own, in contact without friction; nan where that was not solved, (4,)."""
    stands_in: NearRatio | None = None
    """The sector of nearly the ratio of the counts that it is the equilibrium of, where that chosen has none."""

    @property
    def smeared(self) -> bool:
        """Whether its ropes are spread over all meshes: asked for so, or as none was found with them as they are."""
        return self.bag.smeared

    def of_another_model(self, fidelity: str) -> bool:
        """Whether what was chosen led to no equilibrium, or to another shape, so that it is one of another model."""
        merged = self.bag.globalisation > 1 and fidelity != "globalised"
        return self.followed.shape is not None or self.smeared or merged

    @property
    def net(self) -> Net:
        """The net as it was modelled."""
        return self.problem.net

    @property
    def positions(self) -> Floats:
        """Nodes at equilibrium, (n, 3), m; nan where the case was not solved."""
        return self.solution.positions

    @property
    def bar_tension_n(self) -> Floats:
        """Tension of the real bars and ropes, (m,)."""
        return real_tensions(self.bag, self.solution.bar_tension)

    @property
    def report(self) -> SolverReport:
        """What the solver did."""
        return self.solution.report

    @property
    def converged(self) -> bool:
        """Whether the numbers may be used."""
        return self.report.outcome.converged

    @property
    def unstable(self) -> bool:
        """Whether the net, though in balance, would not stay as it is."""
        return self.stability is not None and self.stability.stable == "no"
