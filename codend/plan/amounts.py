"""How much twine a section of netting takes: length, mass and projected area, as it is modelled."""

from dataclasses import dataclass

from codend.plan.tables import Netting


@dataclass(frozen=True)
class Amounts:
    """Of one section, all its twines counted."""

    twine_m: float
    """Twine of bars and knots; what more the tying of knots takes up is not counted."""
    mass_kg: float | None
    """That length times the mass of a metre; None where the plan gives neither titre nor density."""
    twine_area_m2: float
    """Projected area of the bars."""
    netting_area_m2: float
    """Fictitious area of the stretched netting: full mesh squared times meshes round and long."""

    def __add__(self, other: "Amounts") -> "Amounts":
        """Of both together; the mass is known where both are."""
        known = self.mass_kg is not None and other.mass_kg is not None
        return Amounts(
            self.twine_m + other.twine_m,
            (self.mass_kg or 0.0) + (other.mass_kg or 0.0) if known else None,
            self.twine_area_m2 + other.twine_area_m2,
            self.netting_area_m2 + other.netting_area_m2,
        )


def amounts_of(section: Netting, gone: int = 0) -> Amounts:
    """Twine of a section of N meshes round and M long: 4 N M bars and 2 N M knots, in square mesh 2 N M bars.

    ``gone`` of its meshes are left out: those in whose place windows are.
    """
    meshes = section.mean_meshes_round * section.meshes_long - gone
    bars = 4 * meshes if section.kind.staggered else 2 * meshes
    length_m = bars * section.bar_m + 2 * meshes * section.knot_m
    mass = None if section.mass_kg_m is None else length_m * section.mass_kg_m
    return Amounts(
        twine_m=section.twines * length_m,
        mass_kg=mass,
        twine_area_m2=bars * section.bar_m * section.drag_width_m,
        netting_area_m2=meshes * section.full_mesh_m**2,
    )
