"""Whether a model fits into memory, and which merged net would."""

from codend.equilibrium.fidelity import Choice
from codend.errors import TooLittleMemory
from codend.plan.plan import Plan
from codend.solvers.memory import free_bytes, needed_bytes

SMALL_KNOTS = 1000
"""Nets up to so many, as narrow sectors are, fit wherever the program does."""
LARGE = 0.2
"""Share of the free memory from which on a net may be what it was too little for: needs are estimated."""
LEFT = 0.5
"""Share of the free memory that a merged net may take where the estimate for the one before fell short."""


def check_room(plan: Plan, choice: Choice) -> float | None:
    """Refuse a model that would not fit, before it is built; else tell how many bytes are free.

    Of a small one that is not asked, and None.

    Raises:
        TooLittleMemory: it would not.
    """
    if choice.knots <= SMALL_KNOTS:
        return None
    if needed_bytes(choice.knots) > (free := free_bytes()):
        raise too_little(plan, choice, free, free)
    return free


def explained(plan: Plan, choice: Choice, error: MemoryError, before: float | None) -> MemoryError:
    """Why memory ran out while a model was solved: a net that takes a good part of it, or else something beside.

    ``before`` is what was free then; where an estimate fell short of the need, the merged net is to take half of it.
    """
    free = free_bytes() if before is None else before
    return too_little(plan, choice, free, LEFT * free) if needed_bytes(choice.knots) > LARGE * free else error


def too_little(plan: Plan, choice: Choice, free: float, allowed: float) -> TooLittleMemory:
    """That a model does not fit into the memory that is free, in one line, with the merged net that would."""
    there = f"{_gb(free)} is free" if needed_bytes(choice.knots) > free else f"the {_gb(free)} there was did not do"
    said = f"{choice.knots} knots take about {_gb(needed_bytes(choice.knots))}, and {there}"
    full = choice.knots * choice.globalisation**2 * (1 if choice.sectors is None else choice.order)
    for g in plan.globalisations:
        if g > choice.globalisation and (merged := needed_bytes(1 + int(full // g**2))) <= allowed:
            return TooLittleMemory(
                f'{said}; {g} x {g} meshes merged into one (model.fidelity = "globalised", model.globalisation = {g}) '
                f"take {_gb(merged)}"
            )
    return TooLittleMemory(f"{said}; no meshes of this plan can be merged so far that it fits")


def _gb(size: float) -> str:
    return f"{size / 1e9:.2g} GB"
