"""Plans for the tests, made from keyword arguments."""

from codend.plan.plan import Plan, plan_from_dict


def make_plan(
    meshes_round: int = 24,
    meshes_long: int = 20,
    entry: float = 0.35,
    filled: float | list[float] = 6.0,
    *,
    bar_mm: float = 40.0,
    netting: dict | None = None,
    catch: dict | None = None,
    drag: dict | None = None,
    model: dict | None = None,
    speed: float = 1.0,
    mesh: str = "diamond",
) -> Plan:
    """A plan whose entry is a given share of the radius of meshes pulled fully open."""
    section = {
        "mesh": mesh,
        "meshes_round": meshes_round,
        "meshes_long": meshes_long,
        "bar_mm": bar_mm,
        "twine_mm": 2.0,
    }
    section |= netting or {}
    across = bar_mm + (section.get("knot_mm", 0.0) if mesh == "t90" else 0.0)
    limit = meshes_round * across / 1000 / 3.141592653589793 / (2.0 if mesh == "square" else 1.0)
    return plan_from_dict(
        {
            "title": "test",
            "tow": {"speed_m_s": speed, "water_density_kg_m3": 1000.0},
            "entry": {"radius_m": entry * limit},
            "netting": [section],
            "catch": catch if catch is not None else {"filled_meshes": filled},
            "drag": drag or {},
            "model": model or {},
        }
    )


UNIFORM = {"pressure": "uniform", "coefficient": 1.4}
NO_DRAG = {"normal": 0.0}


def uniform_plan(meshes_round: int, meshes_long: int, filled: float, **options: object) -> Plan:
    """Uniform pressure and no twine drag: the scene of the closed forms."""
    catch = {"filled_meshes": filled, **UNIFORM}
    return make_plan(meshes_round, meshes_long, catch=catch, drag=NO_DRAG, **options)  # type: ignore[arg-type]


def joined_plan(
    *sections: tuple[str, int, int, float, dict],
    entry: float = 0.08,
    catch: dict | None = None,
    drag: dict | None = None,
    model: dict | None = None,
    strap: list[dict] | None = None,
) -> Plan:
    """Sections one behind the other, each as kind, meshes round, meshes long, bar in mm, further keys."""
    names = ("mesh", "meshes_round", "meshes_long", "bar_mm")
    return plan_from_dict(
        {
            "title": "test",
            "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1000.0},
            "entry": {"radius_m": entry},
            "netting": [dict(zip(names, s[:4], strict=True)) | {"twine_mm": 2.0} | s[4] for s in sections],
            "strap": strap or [],
            "catch": catch or {"filled_meshes": 6.0},
            "drag": drag or {},
            "model": model or {},
        }
    )
