"""Scenes on which methods are compared."""

from pathlib import Path

from codend.studies.speed_accuracy.contenders import Scene
from codend.studies.study import solve

CASES = Path(__file__).parents[1] / "cases"


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


def next_of_a_series_ms(scene: Scene) -> float:
    """Least time of the scene's catch where the catches before it are known, ms: an equilibrium within a study."""
    plan = scene.plan("model.fidelity=sector")
    filled = plan.cases()[0].catch_value
    series = scene.plan("model.fidelity=sector", f"catch.filled_meshes={[filled - 3, filled - 2, filled - 1, filled]}")
    return min(solve(series).cases[-1].report.solve_ms for _ in range(3))
