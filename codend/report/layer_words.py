"""A word on second layers that carry load, or may: what the model of them takes for granted."""

from collections.abc import Callable, Sequence

import numpy as np

from codend.bag.layer_measures import of_the_catch
from codend.studies.case_result import CaseResult
from codend.studies.study import Study

WORTH_TELLING = 0.01
"""Share of the hoop load on the catch."""


def held_layers(study: Study, named: Callable[[Sequence[CaseResult], Study], str]) -> list[str]:
    """Sentences on the cases, as ``named`` tells them, in which layers carry some of the hoop load, or next to none."""
    solved = [result for result in study.cases if result.converged and result.bag.layers]
    shares = {id(one): of_the_catch(one.bag, one.problem, one.solution)[0] for one in solved}
    carried = [result for result in solved if shares[id(result)] > WORTH_TELLING]
    near = [result for result in solved if shares[id(result)] <= WORTH_TELLING and result.by_sliding.any()]
    found = []
    if carried:
        free = [result for result in carried if np.isfinite(result.slid[0])]
        told = f" As nets of their own {_farthest(free)}." if free else ""
        found.append(
            f"Second layers carry up to {100.0 * max(shares.values()):.2g} % of the hoop load on the catch: "
            f"{named(carried, study)}. They are taken to move with the netting below. Where one slides on it without "
            "friction and netting stands out through its meshes drag is mostly larger and meshes are less open: "
            f"{_counted(carried)} for that, in {len(free)} of {len(carried)} cases by the same net with its layers in "
            "contact, else, where that cannot be asked or comes to no rest, by a wider law of random layers (contact = "
            f"true under [model] asks it of wider nets, in up to a minute).{told}"
        )
    if near:
        found.append(
            "Second layers carry next to nothing of the hoop load on the catch, but hold netting elsewhere or lie so "
            "close over it that it may touch them where it stands out between its knots: "
            f"{named(near, study)}; {_counted(near)} for that."
        )
    return found


def _counted(results: Sequence[CaseResult]) -> str:
    """How much of the errors of some cases is for what their layers may do."""
    drag = max(result.by_sliding[0] / result.measures.drag_n for result in results)
    degrees = max(result.by_sliding[3] for result in results)
    of_drag = f"errors count up to {100.0 * drag:.2g} % of the drag"
    return f"{of_drag} and {degrees:.2g} degrees of the opening ahead of the catch"


def _farthest(free: Sequence[CaseResult]) -> str:
    """Drag and opening with layers in contact, of the case in which they are the farthest from those of the model."""
    far = max(free, key=lambda result: abs(result.slid[0] / result.measures.drag_n - 1.0))
    return (
        f"case {far.case.number} has {far.slid[0]:.4g} N and {far.slid[3]:.3g} degrees ahead of the catch, for "
        f"{far.measures.drag_n:.4g} N and {far.measures.opening_ahead_deg:.3g} degrees"
    )
