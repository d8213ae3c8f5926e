"""What Newton's method keeps of a net from one equilibrium to the next: its unknowns numbered, and room to work in."""

from dataclasses import dataclass

from codend.mechanics.newton_state import State, empty_state
from codend.mechanics.newton_step import Step, empty_step
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern, pattern_of
from codend.solvers.linear_systems import BandedSystem, LinearSystem, linear_system
from codend.solvers.mirror import Mirror
from codend.solvers.mirrored_system import MirroredSystem


@dataclass(frozen=True)
class Prepared:
    """What depends on the structure alone, and room to work in: kept from one equilibrium to the next."""

    pattern: Pattern
    system: LinearSystem
    states: tuple[State, State, State]
    step: Step


def prepare(structure: Structure, bands: int, like: Prepared | None = None, mirror: Mirror | None = None) -> Prepared:
    """Number the unknowns of a structure, once for all its equilibria with a catch that fills so many bands.

    ``like`` is what was prepared of a net of the same joints: its numbering is taken, and nothing that is written to.
    With a ``mirror``, in which net and loads are their own images and stay so, half of the unknowns are factorised.
    """
    pattern = pattern_of(structure) if like is None else like.pattern
    system: LinearSystem
    if mirror is not None:
        system = MirroredSystem(structure, pattern, mirror)
    elif like is not None and isinstance(like.system, BandedSystem):
        system = like.system.beside()
    else:
        system = linear_system(structure, pattern)
    states = (empty_state(structure, bands), empty_state(structure, bands), empty_state(structure, bands))
    return Prepared(pattern, system, states, empty_step(structure, pattern))
