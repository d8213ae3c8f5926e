"""A word on second layers that carry load: what the model of them takes for granted."""

from collections.abc import Callable, Sequence

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
    return [
        f"Second layers carry up to {100.0 * max(shares):.2g} % of the hoop load on the catch: "
        f"{named(carried, study)}. They are taken to move with the netting below. Where one slides on it without "
        "friction and netting bulges through its meshes drag is larger: by 1 to 6 % under layers a twentieth narrower "
        "than the netting below, by 20 to 24 % under ones a fifth narrower (python -m validation.layers_in_contact). "
        "No error estimate covers that."
    ]
