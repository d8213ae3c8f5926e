"""Whether an equilibrium is stable: of a sector by all its harmonics, of a full net by its tangent's eigenvalues."""

from dataclasses import dataclass

from codend.equilibrium.bag_model import BagModel
from codend.solvers.harmonics import Growth, harmonics_of, stiffness_under_tension
from codend.solvers.newton import TangentAtEquilibrium
from codend.solvers.whole_tangent import WholeTangent


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
    """Stability of an equilibrium; of a sector every harmonic is asked, of a full net its whole tangent."""
    if tangent.problem.net.order == 1:
        return Stability(stability_of_whole(tangent))
    harmonics = harmonics_of(tangent.problem, tangent.solution, model.ring)
    growing = tuple(growth.harmonic for growth in harmonics.growing)
    stable = "no" if growing else "unknown" if harmonics.undecided else "yes"
    return Stability(stable, growing, harmonics.strongest)


def stability_of_whole(tangent: TangentAtEquilibrium) -> str:
    """Stability of a full net, or of moves that are the same in all sectors: ``yes``, ``no`` or ``unknown``."""
    if tangent.singular:
        return "unknown"
    grows = WholeTangent.at(tangent).grows(stiffness_under_tension(tangent.problem, tangent.solution))
    return {True: "no", False: "yes", None: "unknown"}[grows]


def ranges_text(numbers: tuple[int, ...]) -> str:
    """Rising whole numbers in short: ``2, 9 to 12``, which no spreadsheet takes for a date."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return ", ".join(f"{part[0]} to {part[-1]}" if len(part) > 1 else f"{part[0]}" for part in parts)
