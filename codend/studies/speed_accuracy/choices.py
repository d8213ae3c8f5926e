"""What is chosen automatically for an accuracy, beside the fastest of all that was tried."""

import numpy as np
import pandas as pd

from codend.studies.speed_accuracy.contenders import FULL, MERGED
from codend.studies.speed_accuracy.front import fastest
from codend.studies.speed_accuracy.measuring import QUANTITIES, Measured


def choices(measured: Measured) -> pd.DataFrame:
    """A row an accuracy: the fastest answer that reaches it in drag, and the automatic one with its time and error.

    Where a weighed scene is given a full net, the fastest is sought among full nets: no other shows the weight.
    """
    rows = []
    for _, chosen in measured.automatic.iterrows():
        of_full = measured.points["model"].isin([MERGED, FULL])
        best = fastest(
            measured.points[of_full] if chosen["model"] in (MERGED, FULL) else measured.points, chosen["accuracy"]
        )
        rows.append(
            {
                "scene": measured.scene.name,
                "accuracy": chosen["accuracy"],
                "fastest": "none" if best is None else told(best),
                "fastest_ms": np.nan if best is None else best["solve_ms"],
                "fastest_error": np.nan if best is None else best["drag_error"],
                "chosen": told(chosen),
                "chosen_ms": chosen["solve_ms"],
                "choosing_ms": chosen["choosing_ms"],
                **{f"chosen_{short}_error": chosen[f"{short}_error"] for short in QUANTITIES.values()},
                "ratio": np.nan if best is None else chosen["solve_ms"] / best["solve_ms"],
            }
        )
    return pd.DataFrame(rows)


def told(answer: pd.Series) -> str:
    """An answer in words: its model and method."""
    if answer["outcome"] == "rough":
        return "closed form for uniform pressure"
    net = f"full net, g = {answer['globalisation']}" if answer["model"] in (MERGED, FULL) else answer["model"]
    return f"{net}, {answer['method']}"
