"""How much slower the water is behind netting: Løland's wake of a screen.

Behind a screen of drag coefficient Cd, over its area, the water goes at r = 1 - 0.46 Cd of its speed (G. Løland, 1993,
Current forces on, and water flow through and around, floating fish farms, Aquaculture International 1, 72-89, and his
thesis of 1991 before it), which he takes for the rear half of a cage. Cd is here that of the netting's twine across the
flow, by the scene's own law, over the area of the netting as it is placed. Netting behind
several screens meets the product of their shares, which is assumed.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from codend.net.net import Floats
from codend.scenes.netting_tables import SheetTable

WAKE: Final = 0.46
"""Løland's constant."""


def speed_shares(sheets: Sequence[SheetTable], shapes: Sequence[Floats]) -> list[float]:
    """Speed of the water that every sheet meets, over that of the current.

    Args:
        sheets: the netting.
        shapes: knots of each as it is placed, (k, 3).
    """
    behind = {
        table.name: max(1.0 - WAKE * drag_coefficient(table, shape), 0.0)
        for table, shape in zip(sheets, shapes, strict=True)
    }
    return [float(np.prod([behind[name] for name in table.shields])) for table in sheets]


def drag_coefficient(table: SheetTable, shape: Floats) -> float:
    """Of netting across the flow, its drag over rho V^2 / 2 and its area as placed, knots at ``shape``, (k, 3)."""
    facets = shape[table.sheet.facets]
    doubled = np.linalg.norm(np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0]), axis=1)
    area = 0.5 * float(table.sheet.facet_weight @ doubled)
    twine = float(table.lines.sum()) * table.twine.drag_width_m * table.globalisation * table.twine.bar_m
    return table.drag[1] * twine / area if area > 0.0 else 0.0
