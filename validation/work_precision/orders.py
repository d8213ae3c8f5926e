"""How the error falls as fewer meshes are merged, and how the cost grows."""

import numpy as np
import pandas as pd

from codend.studies.speed_accuracy.contenders import FULL, KINETIC, MERGED, NEWTON
from codend.studies.speed_accuracy.measuring import QUANTITIES


def orders(points: pd.DataFrame) -> pd.DataFrame:
    """Order of the error in merging, a row a pair of neighbouring g, a column a quantity.

    A net of N / g meshes is off the membrane by c (g / N)^2, the real net by c / N^2: their difference, the error of
    merging, goes with g^2 - 1, and its order is counted in sqrt(g^2 - 1). 2 is what to expect once g is small enough.
    """
    merged = points[(points["model"] == MERGED) & (points["method"] == NEWTON)].sort_values("globalisation")
    g = merged["globalisation"].to_numpy(float)
    found: dict[str, object] = {"from": g[1:].astype(int), "to": g[:-1].astype(int)}
    for short in QUANTITIES.values():
        error = merged[f"{short}_error"].to_numpy()
        found[short] = 2.0 * np.diff(np.log(error)) / np.diff(np.log(g**2 - 1.0))
    return pd.DataFrame(found)[::-1].reset_index(drop=True)


def growth(points: pd.DataFrame) -> dict[str, float]:
    """Exponent of the solve time over the knots of full nets, merged or not, by method."""
    exponents = {}
    for method in (NEWTON, KINETIC):
        nets = points[points["model"].isin([MERGED, FULL]) & (points["method"] == method)]
        exponents[method] = float(np.polyfit(np.log(nets["knots"]), np.log(nets["solve_ms"]), 1)[0])
    return exponents
