"""The cage of Le Bris et al. (1999, section 6) as a scene, and cages like it.

From the paper: a cube of five panels of diamond netting sewn together, hung knot by knot on a rigid square of 1 m x 1 m
at the surface; 12 kg of lead in all, shared out among the lower corners; twine lighter than water; currents of 0 to
1 m/s; no wake. Assumed, for the paper does not say: counts and sizes of the netting, how far it is open, its density
(that of polyethylene), fresh water, no ropes along the seams.
"""

from typing import Any

import numpy as np

MESHES, TWINE_MM, TWINE_KG_M3, WATER_KG_M3, LEAD_KG_M3 = 40, 1.5, 950.0, 1000.0, 11340.0
HANGING = np.sqrt(0.5)
"""Width of the netting over its meshes pulled straight: as high as wide, and so square where it is 1 m deep."""
BALLAST_KG = 12.0
SEAM_ROPE = {"diameter_mm": 4.0, "mass_kg_m": 0.012}


def box(
    speed_m_s: float = 0.0,
    *,
    merged: int = 5,
    meshes: int = MESHES,
    ballast_kg: float = BALLAST_KG,
    sides_m: tuple[float, float] = (1.0, 1.0),
    along_foot: bool = False,
    seam_ropes: bool = False,
    **twine: float,
) -> dict[str, Any]:
    """Tables of a box, its walls front, right, rear and left as the current along x meets it.

    Args:
        speed_m_s: of the current.
        merged: real meshes merged into one, each way.
        meshes: across each wall, and from its top to its foot.
        ballast_kg: lead in all.
        sides_m: along the current and across it.
        along_foot: whether it hangs along the foot and not at the corners.
        seam_ropes: whether ropes as long as the sides of the box run along its seams.
        twine: keys of the netting that differ.
    """
    length, width = sides_m
    plan = [(0.0, 0.0), (0.0, width), (length, width), (length, 0.0)]
    return prism(plan, ("front", "right", "rear", "left"), speed_m_s, merged, meshes, ballast_kg, along_foot,
                 seam_ropes, twine)  # fmt: skip


def cylinder(
    speed_m_s: float = 0.0, *, sides: int = 12, merged: int = 4, meshes: int = 12, ballast_kg: float = BALLAST_KG,
    along_foot: bool = True, **twine: float,
) -> dict[str, Any]:  # fmt: skip
    """Tables of a round cage of 1 m across and deep: a prism of panels, its bottom of gores that meet in the middle."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    plan = [(float(x), float(y)) for x, y in zip(0.5 - 0.5 * np.cos(angle), -0.5 * np.sin(angle), strict=True)]
    names = [f"panel {k + 1}" for k in range(sides)]
    return prism(plan, names, speed_m_s, merged, meshes, ballast_kg, along_foot, False, twine)


def prism(plan, names, speed_m_s, merged, meshes, ballast_kg, along_foot, seam_ropes, twine) -> dict[str, Any]:  # type: ignore[no-untyped-def]
    """Tables of a cage over a plan, corners (x, y) on the frame; of more than four corners the bottom is of gores."""
    count = len(plan)
    wide = [float(np.hypot(*np.subtract(plan[k], plan[(k + 1) % count]))) for k in range(count)]
    bar_m = max(wide) / (2.0 * meshes * HANGING)
    long = meshes if count == 4 else merged * round(1.0 / (2.0 * merged * bar_m * np.sqrt(1.0 - HANGING**2)))
    corners = [f"corner {k + 1}" for k in range(count)]
    points = [{"name": f"top {k + 1}", "at": [x, y, 0.0], "held": "frame"} for k, (x, y) in enumerate(plan)]
    points += [{"name": corners[k], "at": [x, y, -1.0]} for k, (x, y) in enumerate(plan)]
    like = {"mesh": "diamond", "bar_mm": 1e3 * bar_m, "twine_mm": TWINE_MM, "twine_density_kg_m3": TWINE_KG_M3}
    like |= {"meshes_across": meshes, "meshes_long": long, "globalisation": merged, **twine}
    netting, seams, ropes = [], [], []
    for k in range(count):
        after = (k + 1) % count
        on = [f"top {k + 1}", f"top {after + 1}", corners[after], corners[k]]
        wall = {"name": names[k], "corners": on, "fore": "frame", **like}
        if seam_ropes:
            wall |= {"left": f"side {k + 1}", "right": f"side {after + 1}", "aft": f"foot {k + 1}"}
            side, foot = (f"side {k + 1}", 1.0, on[0]), (f"foot {k + 1}", wide[k], corners[after])
            ropes += [
                {"name": n, "from": to, "to": corners[k], "length_m": m, **SEAM_ROPE} for n, m, to in (side, foot)
            ]
        else:
            seams.append([f"{names[k]}.right", f"{names[after]}.left"])
        netting.append(wall)
    if count == 4:
        bottom = {"name": "bottom", "corners": corners, **like}
        if seam_ropes:
            bottom |= {edge: f"foot {k + 1}" for k, edge in enumerate(("fore", "right", "aft", "left"))}
        else:
            seams += [[f"bottom.{edge}", f"{names[k]}.aft"] for k, edge in enumerate(("fore", "right", "aft", "left"))]
        netting.append(bottom)
    else:
        points.append({"name": "middle", "at": [0.5, 0.0, -1.0]})
        radius = merged * round(0.5 * np.cos(np.pi / count) / (2.0 * merged * bar_m * HANGING))
        for k in range(count):
            after = (k + 1) % count
            gore = {"name": f"gore {k + 1}", "corners": [corners[k], corners[after], "middle", "middle"], **like}
            # a panel that tapers to a point would hang its last knot on nothing: one merged mesh is gathered there
            netting.append({**gore, "meshes_across_aft": merged, "meshes_long": max(radius, merged)})
            seams += [[f"gore {k + 1}.right", f"gore {after + 1}.left"], [f"gore {k + 1}.fore", f"{names[k]}.aft"]]
    ballast = {"mass_kg": ballast_kg, "density_kg_m3": LEAD_KG_M3}
    ballast |= {"edges": [f"{name}.aft" for name in names]} if along_foot else {"points": corners}
    tables: dict[str, Any] = {
        "title": "A cage in a current",
        "water": {"density_kg_m3": WATER_KG_M3, "flow_m_s": [speed_m_s, 0.0, 0.0]},
        "frame": {"hold": "held"},
        "ballast": ballast,
        "netting": netting,
        "point": points,
    }
    if ropes:
        tables["rope"] = ropes
    if seams:
        tables["seam"] = [{"edges": edges} for edges in seams]
    return tables
