"""The Pareto front of a cloud of answers: those that no other beats in both time and error."""

import numpy as np
import pandas as pd

from codend.net.net import Floats


def pareto_front(time: Floats, error: Floats) -> np.ndarray:
    """Places of the answers that are more exact than every faster one, the fastest first.

    Args:
        time: what an answer costs, (n,).
        error: how far off it is, (n,); nan for an answer that was not found, which is never on the front.
    """
    front, best = [], np.inf
    for place in np.lexsort((error, time)):
        if error[place] < best:
            front.append(place)
            best = error[place]
    return np.array(front, dtype=int)


def fastest(points: pd.DataFrame, accuracy: float) -> pd.Series | None:
    """The answer with an error in drag of ``accuracy`` or less that took the least time; None if there is none."""
    exact = points[points["drag_error"] <= accuracy].sort_values("solve_ms")
    return None if exact.empty else exact.iloc[0]
