"""What Newton's method keeps of a net from one equilibrium to the next: its unknowns numbered, and room to work in."""

from dataclasses import dataclass

from codend.mechanics.newton_state import State, empty_state
from codend.mechanics.newton_step import Step, empty_step
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern, pattern_of
from codend.solvers.linear_systems import BandedSystem, LinearSystem, linear_system


@dataclass(frozen=True)
class Prepared:
    """What depends on the structure alone, and room to work in: kept from one equilibrium to the next."""

    pattern: Pattern
    system: LinearSystem
    states: tuple[State, State, State]
    step: Step


def prepare(structure: Structure, bands: int, like: Prepared | None = None) -> Prepared:
    """Number the unknowns of a structure, once for all its equilibria with a catch that fills so many bands.

    ``like`` is what was prepared of a net of the same joints: its numbering is taken, and nothing that is written to.
    """
    pattern = pattern_of(structure) if like is None else like.pattern
    numbered = None if like is None else like.system
    return Prepared(
        pattern=pattern,
        system=numbered.beside() if isinstance(numbered, BandedSystem) else linear_system(structure, pattern),
        states=(empty_state(structure, bands), empty_state(structure, bands), empty_state(structure, bands)),
        step=empty_step(structure, pattern),
    )
