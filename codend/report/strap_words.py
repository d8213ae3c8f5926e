"""A word on straps that do nothing: slack though they lie on the catch."""

from collections.abc import Callable, Sequence

import numpy as np

from codend.net.net import bar_vectors
from codend.report.style import number_text
from codend.studies.case_result import CaseResult
from codend.studies.study import Study

SLACK = 1e-6
"""Pull of a strap, over the mean pull of the bars, up to which it is slack."""


def slack_straps(study: Study, named: Callable[[Sequence[CaseResult], Study], str]) -> list[str]:
    """A sentence a strap slack on the catch: in which cases, as ``named`` tells, and how wide the netting is."""
    found = []
    for strap, rows in zip(study.plan.straps, study.plan.strap_rows, strict=True):
        slack: list[CaseResult] = []
        around: list[float] = []
        for result in filter(lambda result: result.converged, study.cases):
            bag = result.bag
            row = bag.bands - round(rows / bag.globalisation)
            own = bag.straps[bag.node_row[bag.net.bars[bag.straps, 0]] == row]
            pull = result.solution.bar_tension
            if row <= result.solution.front_row or pull[own].max() > SLACK * pull.mean():
                continue
            slack.append(result)
            straight = np.linalg.norm(bar_vectors(bag.net, result.positions)[own], axis=1)
            around.append(strap.around_m * float(straight.sum() / bag.net.bar_length[own].sum()))
        if slack:
            least, most = number_text(min(around)), number_text(max(around))
            found.append(
                f"The strap {strap.meshes_from_codline:g} meshes from the codline, {strap.around_m:.4g} m round, lies "
                f"on the catch and is slack, so that it bounds nothing: {named(slack, study)}. The netting there is "
                f"{least if least == most else f'{least} to {most}'} m round."
            )
    return found
