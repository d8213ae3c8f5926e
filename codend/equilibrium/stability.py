"""Whether an equilibrium is stable: of a sector by all its harmonics, of a full net by the pivots of its tangent."""

from dataclasses import dataclass

from codend.equilibrium.bag_model import BagModel
from codend.solvers.harmonics import Growth, harmonics_of
from codend.solvers.newton import TangentAtEquilibrium


@dataclass(frozen=True)
class Stability:
    """Whether a net in balance stays as it is."""

    stable: str
    """``yes``, ``no`` or ``unknown``."""
    growing: tuple[int, ...] = ()
    """Harmonics of the sector that grow: a change varies so many times round the net."""
    strongest: Growth | None = None
    """That of them which grows most."""


def stability_of(model: BagModel, tangent: TangentAtEquilibrium) -> Stability:
    """Stability of an equilibrium."""
    pivots = tangent.negative_pivots
    if tangent.problem.net.order == 1:
        return Stability("yes" if pivots == 0 else "no" if pivots > 0 else "unknown")
    harmonics = harmonics_of(tangent.problem, tangent.solution, model.ring)
    growing = tuple(growth.harmonic for growth in harmonics.growing)
    stable = "no" if growing else "unknown" if harmonics.undecided else "yes"
    return Stability(stable, growing, harmonics.strongest)


def ranges_text(numbers: tuple[int, ...]) -> str:
    """Rising whole numbers in short: ``2, 9 to 12``, which no spreadsheet takes for a date."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return ", ".join(f"{part[0]} to {part[-1]}" if len(part) > 1 else f"{part[0]}" for part in parts)
