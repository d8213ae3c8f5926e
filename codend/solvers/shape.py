"""Whether twine can take a shape in which the forces balance."""

from codend.mechanics.arrays import Structure
from codend.mechanics.compiling import compile_kernel
from codend.mechanics.crossing import folded_on_catch, passed_through_itself
from codend.net import Floats
from codend.solvers.outcome import Outcome


def compile_checks(position: Floats, structure: Structure, share: Floats) -> None:
    """Have the kernels compiled, ahead of the clock of a solve."""
    compile_kernel(passed_through_itself, position, structure)
    compile_kernel(folded_on_catch, position, structure, share)


def outcome_of(position: Floats, structure: Structure, share: Floats) -> Outcome:
    """``CONVERGED``, or what is wrong with a shape in which the forces balance.

    Args:
        position: nodes, (n, 3), m.
        structure: the net.
        share: share of each band that lies in the catch, (bands,).
    """
    if passed_through_itself(position, structure):
        return Outcome.PASSED_THROUGH
    return Outcome.FOLDED if folded_on_catch(position, structure, share) else Outcome.CONVERGED
