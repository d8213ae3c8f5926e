"""A word on second layers that carry load: what the model of them takes for granted."""

from collections.abc import Callable, Sequence

import numpy as np

from codend.bag.layer_measures import of_the_catch
from codend.studies.case_result import CaseResult
from codend.studies.study import Study

WORTH_TELLING = 0.01
"""Share of the hoop load on the catch."""


def held_layers(study: Study, named: Callable[[Sequence[CaseResult], Study], str]) -> list[str]:
    """A sentence on the cases, as ``named`` tells them, in which layers carry some of the hoop load."""
    solved = [result for result in study.cases if result.converged and result.bag.layers]
    shares = [of_the_catch(result.bag, result.problem, result.solution)[0] for result in solved]
    carried = [result for result, share in zip(solved, shares, strict=True) if share > WORTH_TELLING]
    if not carried:
        return []
    errors = [result.by_sliding / result.measures.estimated for result in carried]
    drag, degrees = max(one[0] for one in errors), max(result.by_sliding[3] for result in carried)
    free = [result for result in carried if np.isfinite(result.slid[0])]
    told = f" As nets of their own {_farthest(free)}." if free else ""
    return [
        f"Second layers carry up to {100.0 * max(shares):.2g} % of the hoop load on the catch: "
        f"{named(carried, study)}. They are taken to move with the netting below. Where one slides on it without "
        "friction and netting stands out through its meshes drag is mostly larger and meshes are less open: errors "
        f"count up to {100.0 * drag:.2g} % of the drag and {degrees:.2g} degrees of the opening ahead of the catch for "
        f"that, in {len(free)} of {len(carried)} cases by the same net with its layers in contact, else, where that "
        "cannot be asked or comes to no rest, by a wider law of random layers (contact = true under [model] asks it "
        f"of wider nets, in up to a minute).{told}"
    ]


def _farthest(free: Sequence[CaseResult]) -> str:
    """Drag and opening with layers in contact, of the case in which they are the farthest from those of the model."""
    far = max(free, key=lambda result: abs(result.slid[0] / result.measures.drag_n - 1.0))
    return (
        f"case {far.case.number} has {far.slid[0]:.4g} N and {far.slid[3]:.3g} degrees ahead of the catch, for "
        f"{far.measures.drag_n:.4g} N and {far.measures.opening_ahead_deg:.3g} degrees"
    )
