"""What is compared on a scene: every method and model, each with the settings that trade its accuracy for time."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from codend.bag.meridian.plan_case import why_not_exactly
from codend.equilibrium import fidelity
from codend.equilibrium.fidelity import FEWEST_MESHES_ROUND
from codend.errors import OPTIONS, InputError
from codend.plan.plan import Plan, load_plan

NEWTON, KINETIC, VISCOUS, RIGID, MERIDIAN = (
    "Newton",
    "relaxation, kinetic",
    "relaxation, viscous",
    "rigid bars",
    "meridian",
)
METHOD_KEYS = {
    NEWTON: ("model.method=newton",),
    KINETIC: ("model.method=dynamic-relaxation", "model.damping=kinetic"),
    VISCOUS: ("model.method=dynamic-relaxation", "model.damping=viscous"),
    RIGID: ("model.method=rigid-bars",),
    MERIDIAN: (),
}
SOLVER_NAMES = {"newton": NEWTON, "rigid-bars": RIGID, "meridian": MERIDIAN}
"""Names that solvers go by in the results, and here; relaxation goes by two."""
MOST_KNOTS = 50_000
"""Knots of a full net beyond which it is not tried."""
MOST_FACTORS = 4
SECTOR, MERGED, FULL, MEMBRANE = "sector", "globalised", "full", "membrane"


@dataclass(frozen=True)
class Scene:
    """One catch in one codend."""

    name: str
    plan_file: Path
    overrides: tuple[str, ...]
    factors: tuple[int, ...]
    """Meshes merged each way, the coarsest first; 1 is the full net."""
    weighed: bool = False
    """Whether its twine has weight that counts, so that only a full net shows all there is to it."""

    def plan(self, *model: str) -> Plan:
        """The scene's plan with more overrides."""
        return load_plan(self.plan_file, [*self.overrides, *model])

    @cached_property
    def is_membrane(self) -> bool:
        """Whether the meridian method applies, and its front is known before it is solved."""
        plan = self.plan()
        return not self.weighed and not why_not_exactly(plan) and plan.catch.kind == "filled_meshes"

    @property
    def inextensible(self) -> bool:
        """Whether rigid bars may stand for its twine."""
        return not any(section.stretches for section in self.plan().netting)


@dataclass(frozen=True)
class Contender:
    """A way to solve a scene, with the setting that trades its accuracy for time."""

    method: str
    model: str
    tolerance: float
    globalisation: int = 1

    @property
    def label(self) -> str:
        """The contender in words."""
        merged = f" by {self.globalisation}" if self.model == MERGED else ""
        return f"{self.method}, {self.model}{merged}, tolerance {self.tolerance:g}"

    @property
    def keys(self) -> tuple[str, ...]:
        """The plan's keys that ask for it."""
        fidelity = "meridian" if self.model == MEMBRANE else self.model
        merging = (f"model.globalisation={self.globalisation}",) if self.model == MERGED else ()
        tolerance = f"model.tolerance={self.tolerance:g}"
        return (f"model.fidelity={fidelity}", tolerance, *merging, *METHOD_KEYS[self.method])


def scene_from(path: str | Path, changes: Sequence[str] = (), number: int = 1) -> Scene:
    """One case of a plan as a scene.

    Raises:
        InputError: the plan is refused, or has no case of that number.
    """
    free = (*changes, "model.fidelity=auto", "model.globalisation=1", "model.method=auto")
    plan = load_plan(path, free)
    cases = plan.cases()
    if number > len(cases):
        raise InputError(OPTIONS, "case", number, f"1 to {len(cases)}, the cases of the plan")
    case = cases[number - 1]
    only = (f"tow.speed_m_s={case.speed_m_s!r}", f"catch.{case.catch_kind}={case.catch_value!r}")
    least = min(min(section.open_meshes) for section in plan.netting)
    factors = [g for g in sorted(plan.globalisations, reverse=True) if g == 1 or least >= FEWEST_MESHES_ROUND * g]
    chosen = fidelity.choose(load_plan(path, [*free, *only])).fidelity
    knots = sum(section.open_meshes[0] * section.rows_per_mesh * section.meshes_long for section in plan.netting)
    if knots > MOST_KNOTS and len(factors) > 1:
        factors.remove(1)
    kept = tuple(factors[i] for i in np.unique(np.linspace(0, len(factors) - 1, MOST_FACTORS).round().astype(int)))
    return Scene(plan.title, Path(path), (*free, *only), kept, weighed=chosen not in ("sector", "meridian"))


def contenders(scene: Scene, quick: bool) -> Iterator[Contender]:
    """Everything that is tried on a scene; what takes long with few settings."""
    if scene.weighed:
        yield Contender(NEWTON, SECTOR, 1e-6)
        for g in scene.factors:
            yield Contender(NEWTON, MERGED if g > 1 else FULL, 1e-6, g)
            yield Contender(KINETIC, MERGED if g > 1 else FULL, 1e-6, g)
        return
    if scene.is_membrane:
        yield Contender(MERIDIAN, MEMBRANE, 1e-6)
    tolerances = (1e-2, 1e-6, 1e-10) if quick else (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
    for method in (NEWTON, KINETIC, VISCOUS):
        for tolerance in tolerances:
            yield Contender(method, SECTOR, tolerance)
    for method in (NEWTON, KINETIC, VISCOUS):
        for g in scene.factors:
            # the full net by relaxation takes a while: once is enough to confirm the others
            if g > 1 or method == NEWTON or (method == KINETIC and not quick):
                yield Contender(method, MERGED if g > 1 else FULL, 1e-6, g)
    if scene.inextensible:
        for tolerance in (1e-2,) if quick else (1e-2, 1e-5, 1e-8):
            yield Contender(RIGID, SECTOR, tolerance)
        if not quick and scene.factors[0] > 1:
            yield Contender(RIGID, MERGED, 1e-2, scene.factors[0])
