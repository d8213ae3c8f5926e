"""What twine weighs and how thick it is: materials, titres and the numbers that follow from each other.

Rtex is the mass in grams of a kilometre of the finished twine, the runnage K = 1e6 / Rtex its metres in a kilogram.
"""

import math
import re
from typing import Final, Literal, get_args

MaterialName = Literal["PA", "PE", "PES", "PP", "PVA", "PVC", "PVD", "UHMWPE"]
"""Polyamide, polyethylene, polyester, polypropylene, polyvinyl alcohol, chloride, vinylidene chloride, and polyethylene
of ultra-high molecular weight."""
MATERIALS: Final[tuple[MaterialName, ...]] = get_args(MaterialName)
DENSITY_KG_M3: Final[dict[MaterialName, float]] = {
    "PA": 1140.0,
    "PE": 950.0,
    "PES": 1380.0,
    "PP": 910.0,
    "PVA": 1300.0,
    "PVC": 1370.0,
    "PVD": 1700.0,
    "UHMWPE": 970.0,
}
"""Of the fibres, as commonly published: Klust, Netting Materials for Fishing Gear, FAO 1982, section 1.2.5.3; Prado and
Dremiere, Fisherman's Workbook, FAO 1990, "Textile fibres"."""
THICKNESS_MM: Final[dict[MaterialName, tuple[float, float]]] = {
    "PA": (0.0284, 0.533),
    "PE": (0.0432, 0.499),
    "PES": (0.0296, 0.510),
    "PP": (0.0414, 0.506),
}
"""a and e of the diameter a Rtex^e of twisted twine, mm: fits to the tables of the Fisherman's Workbook (FAO 1990) that
trawlkit 1.1.0 made (data CC BY 4.0), off from them by up to 7, 8, 2 and 3 %."""
TAKEN_UP_BY_TWIST: Final = 1.10
"""Rtex of a twine over the titre of its yarns side by side, as the Fisherman's Workbook reckons twisted twine."""
MOST_RTEX: Final = 1e6
_NUMBER = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(?:[dD]|den)?\s*/\s*(\d+)\s*")


def rtex_of_number(number: str) -> float | None:
    """Rtex of a twine number such as ``210/24``, the denier of a yarn and how many there are; None if it is none.

    A denier is a gram in 9 km. A kilogram a metre is no twine.
    """
    found = _NUMBER.fullmatch(number)
    if found is None:
        return None
    rtex = float(found[1]) / 9.0 * float(found[2]) * TAKEN_UP_BY_TWIST
    return rtex if rtex <= MOST_RTEX else None


def thickness_mm(rtex: float, material: MaterialName | None) -> float | None:
    """Diameter of a twisted twine; None of materials whose twines are not tabled."""
    if material not in THICKNESS_MM:
        return None
    factor, exponent = THICKNESS_MM[material]
    return factor * rtex**exponent


def solid_diameter_m(mass_kg_m: float, density_kg_m3: float) -> float:
    """Diameter of the round section of nothing but fibre, without the water between them, m."""
    return math.sqrt(4.0 * mass_kg_m / (math.pi * density_kg_m3))
