"""A pelagic trawl of four equal panels, from a published plan, as a scene: the starboard half of the gear.

The trawl of Bessonneau and Marichal (1997, section 6) is a drawing without numbers, so another is taken: the Harstad
trawl of L. Schaerfe 1983, FAO FI:DP/GLO/82/001, appendix 6 ("1436 x 200 = 287 m circumference", x6567e07.gif of
https://www.fao.org/4/x6567e/x6567e00.htm), as transcribed in trawlkit 1.1.0 (PyPI, ``scharfe_harstad_1436x200.yaml``),
at ``SCALE`` of its size: its doors of 8.2 m2 are then those of 0.75 m2 of the paper, and its mouth is about as high as
the paper's 10 m. All mesh sizes, twine and bridles are scaled; meshes are not. Counts are rounded to multiples of what
is merged (``rounded`` tells by how much). Side panels have wings like the others, as the plan draws them.

From the paper: doors of 0.75 m2 and 170 kg, weights of 200 kg, warps of 100 m, 3.5 knots, law and coefficients of drag.
Assumed: lift and drag of the doors, floats, ropes, hanging of the wings, stretch of the twine, the water that goes with
a door.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

SCALE = 0.3
KNOT_M_S = 1852.0 / 3600.0
SPEED_M_S = 3.5 * KNOT_M_S
WARP_M, DOOR_M2, DOOR_KG, WEIGHT_KG = 100.0, 0.75, 170.0, 200.0
BRIDLE_M = 100.0 * SCALE
"""Bridles of 100 m of the plan."""
DOOR_LIFT, DOOR_DRAG, DOOR_WATER_KG = 1.3, 0.6, 500.0
"""Assumed: of a cambered door at its working angle; water that goes with it."""
FLOATS_N = 600.0
"""Buoyancy on half the headline, assumed."""
STRETCH_N = 500.0
"""EA of a bar of scaled twine, assumed: a polyamide twine of Rtex 1520 breaks near 1 kN, a quarter longer."""
HANGING = 0.5
"""Of the bosoms, from the plan."""


@dataclass(frozen=True)
class Section:
    """One section of half a panel: mesh and twine in mm at full size, and counts of meshes."""

    mesh: float
    twine: float
    fore: int
    aft: int
    long: int


PLAN = {
    "wing": Section(200, 1.87, 50, 130, 80),
    "1": Section(200, 1.48, 180, 155, 50),
    "2": Section(190, 1.41, 155, 130, 50),
    "3": Section(140, 1.41, 130, 101, 60),
    "4": Section(120, 1.41, 101, 72, 60),
    "5": Section(80, 1.41, 107, 58, 100),
    "6": Section(60, 1.41, 78, 48, 100),
    "7": Section(40, 1.15, 72, 72, 125),
}
"""Half a panel of the plan; a wing is one of its two wings, whose inner edge is cut all bars."""
MERGED = {
    16: {
        "wing": Section(200, 1.87, 48, 128, 80),
        "1": Section(200, 1.48, 176, 160, 48),
        "2": Section(190, 1.41, 160, 128, 48),
        "3": Section(140, 1.41, 128, 96, 64),
        "4": Section(120, 1.41, 96, 64, 64),
        "5": Section(80, 1.41, 112, 64, 96),
        "6": Section(60, 1.41, 80, 48, 96),
        "7": Section(40, 1.15, 64, 64, 128),
    },
    24: {
        "wing": Section(200, 1.87, 48, 120, 72),
        "1": Section(200, 1.48, 168, 144, 48),
        "2": Section(190, 1.41, 144, 120, 48),
        "3": Section(140, 1.41, 120, 96, 72),
        "4": Section(120, 1.41, 96, 72, 48),
        "5": Section(80, 1.41, 96, 48, 96),
        "6": Section(60, 1.41, 72, 48, 96),
        "7": Section(40, 1.15, 72, 72, 120),
    },
}
"""The same rounded, by how many real meshes are merged into one, each way."""
BOSOM = 48
"""Meshes of half a bosom; 49.5 in the plan."""
ROUND_M = 0.4
"""Side of the square in whose half the gear lies along the line astern."""
SPREAD = (
    (123.2, 121.9, 3.0, -34.3, -41.4),
    (126.6, 125.3, 3.0, -34.2, -41.4),
    (129.2, 128.2, 2.8, -34.5, -41.2),
    (131.3, 130.7, 2.0, -35.6, -40.7),
    (133.7, 133.4, 1.35, -36.7, -40.1),
    (135.1, 135.0, 1.0, -37.2, -39.6),
    (136.9, 136.9, 0.48, -37.85, -39.0),
    (138.4, 138.4, 0.27, -38.1, -38.65),
    (139.7, 139.7, 0.0, -38.35, -38.35),
)
"""About where the gear comes to rest: of wing ends, mouth and the ends of sections x above and below, half the width,
heights above and below, m. No netting passes through other netting there."""
SPREAD_DOOR = (93.9, 9.1, -32.7)
STRAIGHT = 0.9998
"""Share of their length over which the ropes along the wings are laid: sagging they would cross each other."""
Place = tuple[float, float]
_UP, _UP_OUT, _LOW_OUT, _LOW = (0.0, 0.0), (0.5 * ROUND_M, 0.0), (0.5 * ROUND_M, -ROUND_M), (0.0, -ROUND_M)
_UP_WING, _LOW_WING = (0.14 * ROUND_M, 0.0), (0.14 * ROUND_M, -ROUND_M)
_SIDE_UP, _SIDE_LOW = (0.5 * ROUND_M, -0.33 * ROUND_M), (0.5 * ROUND_M, -0.67 * ROUND_M)


def rounded(merged: int) -> float:
    """Largest change of the twine in a section by the rounding of its counts, relative."""

    def twine(section: Section) -> float:
        return (section.fore + section.aft) * section.long * section.mesh

    return max(abs(twine(MERGED[merged][name]) / twine(PLAN[name]) - 1.0) for name in PLAN)


def half_trawl(
    merged: int = 24,
    speed_m_s: float = SPEED_M_S,
    floats_n: float = FLOATS_N,
    spread: bool = False,
    **tables: dict[str, Any],
) -> dict[str, Any]:
    """The starboard half of the gear as tables of a scene, which ``tables`` add to.

    It is placed in a line astern at the surface; ``spread``, about as it is towed.
    """
    sections = MERGED[merged]
    netting: list[dict[str, Any]] = []
    seams: list[list[str]] = []

    def add(name: str, of: str, across: tuple[int, int], corners: Sequence[Any], taper: str, **edges: str) -> None:
        section = sections[of]
        sheet = {
            "name": name,
            "mesh": "diamond",
            "mesh_mm": round(section.mesh * SCALE, 6),
            "twine_mm": round(section.twine * SCALE, 6),
            "material": "PA",
            "axial_stiffness_n": STRETCH_N,
            "meshes_across": across[0],
            "meshes_across_aft": across[1],
            "meshes_long": section.long,
            "taper": taper,
            "globalisation": merged,
            "corners": [corner if isinstance(corner, str) else [round(c, 4) for c in corner] for corner in corners],
            "law": "bessonneau-1997",
        }
        netting.append({**sheet, **edges})

    def at(x: float, place: Place) -> list[float]:
        return [x, *place]

    def long_m(of: str) -> float:
        return 0.98 * sections[of].long * sections[of].mesh * SCALE / 1000.0

    ends = WARP_M + BRIDLE_M - 0.2
    x = ends + STRAIGHT * long_m("wing")

    def along_wing(end: Place, place: Place) -> list[float]:
        """Where a rope of the wing's length that is laid straight from the wing's end comes to."""
        aside = math.dist(end, place)
        return at(ends + math.sqrt((STRAIGHT * long_m("wing")) ** 2 - aside**2), place)

    wing, up, low = (sections["wing"].fore, sections["wing"].aft), "upper wing end", "lower wing end"
    up_out, low_out = at(x, _UP_OUT), at(x, _LOW_OUT)
    add("upper wing", "wing", wing, [up, up, up_out, "upper quarter"], "left", left="headline wing")
    add("side upper wing", "wing", wing, [up, up, "side upper quarter", up_out], "right", right="side upper wing rope")
    add("side lower wing", "wing", wing, [low, low, low_out, "side lower quarter"], "left", left="side lower wing rope")
    add("lower wing", "wing", wing, [low, low, "lower quarter", low_out], "right", right="footrope wing")
    seams += [["upper wing.right", "side upper wing.left"], ["side lower wing.right", "lower wing.left"]]

    behind, middle = x, (BOSOM, BOSOM)
    stations = [ends, x]
    x += long_m("1")
    beside = (sections["1"].fore - BOSOM, sections["1"].aft - BOSOM)
    lines = [at(x, place) for place in (_UP, _UP_WING, _UP_OUT, _SIDE_UP, _SIDE_LOW, _LOW_OUT, _LOW_WING, _LOW)]
    fore = ["upper centre", "upper quarter", up_out, "side upper quarter", "side lower quarter", low_out]
    fore += ["lower quarter", "lower centre"]
    names = ["upper 1 bosom", "upper 1", "side 1 upper", "side 1 bosom", "side 1 lower", "lower 1", "lower 1 bosom"]
    counts = [middle, beside, beside, (2 * BOSOM, 2 * BOSOM), beside, beside, middle]
    edges: list[dict[str, str]] = [{"left": "symmetry", "fore": "headline bosom"}, {}, {}, {"fore": "side bosom rope"}]
    edges += [{}, {}, {"right": "symmetry", "fore": "footrope bosom"}]
    for k, taper in enumerate(["both", "right", "left", "both", "right", "left", "both"]):
        add(names[k], "1", counts[k], [fore[k], fore[k + 1], lines[k + 1], lines[k]], taper, **edges[k])
        if k > 0:
            seams.append([f"{names[k - 1]}.right", f"{names[k]}.left"])
    seams += [[f"{a}.fore", f"{b} wing.aft"] for a, b in zip(names[1:6:4], ("upper", "lower"), strict=True)]
    seams += [[f"side 1 {side}.fore", f"side {side} wing.aft"] for side in ("upper", "lower")]
    ahead = {"upper": names[:2], "side": names[2:5], "lower": names[5:]}

    for of in "234567":
        fore_x, x = x, x + long_m(of)
        stations.append(fore_x)
        codend = of == "7"
        a, b, c, d = ("codline" if codend else at(x, place) for place in (_UP, _UP_OUT, _LOW_OUT, _LOW))
        half = (sections[of].fore, sections[of].aft)
        whole = (2 * half[0], 2 * half[1])
        start = [at(fore_x, place) for place in (_UP, _UP_OUT, _LOW_OUT, _LOW)]
        add(f"upper {of}", of, half, [start[0], start[1], b, a], "right", left="symmetry")
        add(f"side {of}", of, whole, [start[1], start[2], c, b], "both")
        add(f"lower {of}", of, half, [start[2], start[3], d, c], "left", right="symmetry")
        seams += [[f"upper {of}.right", f"side {of}.left"], [f"side {of}.right", f"lower {of}.left"]]
        seams += [[f"{part} {of}.fore", *(f"{name}.aft" for name in ahead[part])] for part in ahead]
        ahead = {part: [f"{part} {of}"] for part in ahead}

    def rope(name: str, first: str, last: str, length: float, mass: float, **more: float) -> dict[str, Any]:
        ends = {"name": name, "from": first, "to": last, "length_m": round(length, 4)}
        return {**ends, "diameter_mm": 12.0, "mass_kg_m": mass, "law": "bessonneau-1997", **more}

    wing_m = long_m("wing")
    bosom_m = BOSOM * sections["1"].mesh * SCALE / 1000.0 * HANGING
    ropes = [
        rope("warp", "vessel", "door", WARP_M, 0.5, normal=1.8, tangential=0.02, bars=40),
        rope("upper bridle", "door", up, BRIDLE_M, 0.45, bars=12),
        rope("lower bridle", "door", low, BRIDLE_M, 0.45, bars=12),
        rope("headline wing", up, "upper quarter", wing_m, 0.12),
        rope("headline bosom", "upper centre", "upper quarter", bosom_m, 0.12),
        rope("side upper wing rope", up, "side upper quarter", wing_m, 0.12),
        rope("side bosom rope", "side upper quarter", "side lower quarter", 2.0 * bosom_m, 0.12),
        rope("side lower wing rope", low, "side lower quarter", wing_m, 0.12),
        rope("footrope wing", low, "lower quarter", wing_m, 0.3),
        rope("footrope bosom", "lower centre", "lower quarter", bosom_m, 0.3),
    ]
    door = {"area_m2": DOOR_M2, "lift": DOOR_LIFT, "drag": DOOR_DRAG, "lift_towards": [0.0, 1.0, 0.0]}
    door |= {"mass_kg": DOOR_KG, "density_kg_m3": 7850.0, "added_mass_kg": DOOR_WATER_KG}
    points = [
        {"name": "door", "at": [0.999 * WARP_M, 0.0, 0.0], **door},
        {"name": up, "at": at(ends, _UP_OUT)},
        {
            "name": low,
            "at": at(ends, _LOW_OUT),
            "mass_kg": WEIGHT_KG,
            "density_kg_m3": 7850.0,
        },
        {"name": "upper quarter", "at": along_wing(_UP_OUT, _UP_WING), "mass_kg": 0.2, "wet_weight_n": -floats_n},
        {"name": "side upper quarter", "at": along_wing(_UP_OUT, _SIDE_UP)},
        {"name": "side lower quarter", "at": along_wing(_LOW_OUT, _SIDE_LOW)},
        {"name": "lower quarter", "at": along_wing(_LOW_OUT, _LOW_WING)},
        {"name": "upper centre", "at": at(behind, _UP), "held": "symmetry"},
        {"name": "lower centre", "at": at(behind, _LOW), "held": "symmetry"},
        {"name": "codline", "at": [x, 0.0, -0.5 * ROUND_M], "held": "symmetry"},
    ]
    if spread:
        stations.append(x)
        for point in points[1:]:
            point["at"] = _spread(point["at"], stations)
        points[0]["at"] = list(SPREAD_DOOR)
        for sheet in netting:
            places = sheet["corners"]
            sheet["corners"] = [place if isinstance(place, str) else _spread(place, stations) for place in places]
    return {
        "title": "Half of a pelagic trawl" if spread else "Half of a pelagic trawl, shot astern",
        "vessel": {"speed_m_s": speed_m_s},
        "rope": ropes,
        "netting": netting,
        "seam": [{"edges": edges} for edges in seams],
        "point": points,
        **tables,
    }


def _spread(place: Sequence[float], stations: Sequence[float]) -> list[float]:
    """Where a place in the line astern comes to as the gear is towed, about."""
    above, below, wide, top, bottom = (float(np.interp(place[0], stations, row)) for row in zip(*SPREAD, strict=True))
    down, out = -place[2] / ROUND_M, place[1] / (0.5 * ROUND_M)
    return [round(above + down * (below - above), 3), round(out * wide, 3), round(top + down * (bottom - top), 3)]
