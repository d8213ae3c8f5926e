"""Scenes on which methods are compared, and the methods and models that are compared on them."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from codend.plan import Plan, load_plan

CASES = Path(__file__).parents[1] / "cases"
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
SECTOR, MERGED, FULL, MEMBRANE = "sector", "globalised", "full", "membrane"


@dataclass(frozen=True)
class Scene:
    """One catch in one codend."""

    name: str
    plan_file: Path
    overrides: tuple[str, ...]
    factors: tuple[int, ...]
    """Meshes merged each way, the coarsest first; the last is 1, the full net."""
    weighed: bool = False
    """Whether its twine has weight that counts, so that only a full net shows all there is to it."""

    def plan(self, *model: str) -> Plan:
        """The scene's plan with more overrides."""
        return load_plan(self.plan_file, [*self.overrides, *model])

    @property
    def inextensible(self) -> bool:
        """Whether rigid bars may stand for its twine."""
        return all(section.axial_stiffness_n is None for section in self.plan().netting)


@dataclass(frozen=True)
class Contender:
    """A way to solve a scene, with the setting that trades its accuracy for time."""

    method: str
    model: str
    tolerance: float
    globalisation: int = 1

    @property
    def keys(self) -> tuple[str, ...]:
        """The plan's keys that ask for it."""
        fidelity = "meridian" if self.model == MEMBRANE else self.model
        merging = (f"model.globalisation={self.globalisation}",) if self.model == MERGED else ()
        tolerance = f"model.tolerance={self.tolerance:g}"
        return (f"model.fidelity={fidelity}", tolerance, *merging, *METHOD_KEYS[self.method])


def scenes(quick: bool) -> tuple[Scene, ...]:
    """Small catch, large catch, stiff elastic knotted; quick ones are the same bags of fewer and larger meshes."""
    flume, knotted = CASES / "flume_150x140.toml", CASES / "knotted_elastic.toml"
    stiff = "netting.0.axial_stiffness_n=100000"
    if not quick:
        return (
            Scene("small catch", flume, ("catch.filled_meshes=20",), (10, 5, 2, 1)),
            Scene("large catch", flume, ("catch.filled_meshes=100",), (10, 5, 2, 1)),
            Scene("stiff elastic knotted", knotted, ("catch.filled_meshes=40", stiff), (10, 5, 2, 1)),
        )
    counts = ("netting.0.meshes_round=32", "netting.0.meshes_long=28")
    coarse = (*counts, "netting.0.bar_mm=93.75", "netting.0.twine_mm=2.5")
    coarse_knots = (*counts, "netting.0.bar_mm=125", "netting.0.knot_mm=15", "netting.0.twine_mm=9", stiff)
    return (
        Scene("small catch", flume, (*coarse, "catch.filled_meshes=4"), (4, 2, 1)),
        Scene("large catch", flume, (*coarse, "catch.filled_meshes=20"), (4, 2, 1)),
        Scene("stiff elastic knotted", knotted, (*coarse_knots, "catch.filled_meshes=11"), (4, 2, 1)),
    )


def weighed_scene(quick: bool) -> Scene:
    """A catch towed slowly in nylon, whose weight in water is some per cent of the drag."""
    counts, bar, twine, filled = ((32, 24), 93.75, 2.4375, 7) if quick else ((96, 80), 31.25, 0.8125, 24)
    keys = (
        f"netting.0.meshes_round={counts[0]}",
        f"netting.0.meshes_long={counts[1]}",
        f"netting.0.bar_mm={bar}",
        f"netting.0.twine_mm={twine}",
        "netting.0.twine_density_kg_m3=1140",
        "tow.speed_m_s=0.2",
        f"catch.filled_meshes={filled}",
    )
    factors = (4, 2, 1) if quick else (8, 4, 2, 1)
    return Scene("slow tow of heavy twine", CASES / "flume_150x140.toml", keys, factors, weighed=True)


def contenders(scene: Scene, quick: bool) -> Iterator[Contender]:
    """Everything that is tried on a scene; what takes long with few settings."""
    if scene.weighed:
        yield Contender(NEWTON, SECTOR, 1e-6)
        for g in scene.factors:
            yield Contender(NEWTON, MERGED if g > 1 else FULL, 1e-6, g)
            yield Contender(KINETIC, MERGED if g > 1 else FULL, 1e-6, g)
        return
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
        if not quick:
            yield Contender(RIGID, MERGED, 1e-2, scene.factors[0])
