"""The tables [[netting]] and [[seam]] of a scene: flat sheets of netting, what they hang on, how they are joined."""

from collections.abc import Iterator
from copy import copy
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self

import numpy as np
from annotated_types import Ge, Le, MinLen
from pydantic import ValidationError, create_model, model_validator
from pydantic.fields import FieldInfo

from codend.net.net import Floats
from codend.netting.sheet import EDGES, EdgeName, Sheet, Taper, diamond_sheet, square_sheet
from codend.plan.messages import Contradiction
from codend.plan.tables import Netting, Number, Table, Text, Whole
from codend.scenes.tables import Vector, drag_by

TWINE_KEYS: Final = (
    "mesh",
    "bar_mm",
    "mesh_mm",
    "inside_mesh_mm",
    "twine_mm",
    "rtex",
    "runnage_m_kg",
    "twine_number",
    "material",
    "twines",
    "twine_density_kg_m3",
    "axial_stiffness_n",
)
"""Keys that a sheet has in common with a section of a codend, and that mean the same."""
HOLDS: Final = ("vessel", "ground", "frame", "symmetry", "repeats")
"""What an edge may be held by: every way, by three of them; in the plane of symmetry, y = 0; in the plane of its own
y, as of netting that repeats sideways. Ropes are called by their names."""
PLANES: Final = ("symmetry", "repeats")
"""Those beyond which there is more of the netting."""
CORNERS: Final[dict[EdgeName, tuple[int, int]]] = {"fore": (0, 1), "aft": (3, 2), "left": (0, 3), "right": (1, 2)}
"""First and last corner of every edge."""
Corner = Text | Vector
MOST_MESHES = 200_000
"""Of a sheet, after merging."""


class _SheetTable(Table):
    """A sheet of netting between a fore and an aft edge; bars are twine, knots are points.

    Its corners are counted fore left, fore right, aft right, aft left. An edge both of whose corners are the same point
    is gathered there.
    """

    name: Text
    """What tables and seams call it."""
    meshes_across: Annotated[Whole, Ge(0), Le(100_000)]
    """Of the fore edge."""
    meshes_long: Annotated[Whole, Ge(1), Le(100_000)]
    """From the fore to the aft edge."""
    corners: tuple[Corner, Corner, Corner, Corner]
    """Points it hangs on, by name, or places where free corners start."""
    meshes_across_aft: Annotated[Whole, Ge(0), Le(100_000)] | None = None
    """Of the aft edge; None: as many as the fore edge."""
    taper: Taper = "both"
    """Side edges that take up the difference."""
    globalisation: Annotated[Whole, Ge(1), Le(1000)] = 1
    """Real meshes merged into one, each way."""
    fore: Text | tuple[Text, ...] | None = None
    """What the fore edge hangs on: a rope, ropes end to end, or what holds it; None: nothing, or a seam."""
    aft: Text | tuple[Text, ...] | None = None
    """The same of the aft edge."""
    left: Text | tuple[Text, ...] | None = None
    """The same of the left edge."""
    right: Text | tuple[Text, ...] | None = None
    """The same of the right edge."""
    law: Literal["le-bris-1999", "bessonneau-1997", "choo-casarella-1971"] = "le-bris-1999"
    """Of its twine's drag."""
    normal: Annotated[Number, Ge(0), Le(10)] | None = None
    """None: that of the law."""
    tangential: Annotated[Number, Ge(0), Le(10)] | None = None
    """None: that of the law."""
    added_mass: Annotated[Number, Ge(0), Le(10)] = 1.0
    """Cm of the twine across its length, that of potential flow if left out."""
    shielded_by: Text | tuple[Text, ...] | None = None
    """Netting that it lies behind: the water it meets goes at 1 - 0.46 Cd of the current (Løland 1993); None: none."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        try:
            assert self.twine
        except ValidationError as error:
            cause = error.errors()[0].get("ctx", {}).get("error")
            if isinstance(cause, Contradiction):
                raise cause from None
            raise
        Contradiction.raise_first(self._contradictions())
        return self

    def _contradictions(self) -> Iterator[Contradiction]:
        if self.twine.kind.pattern == "squares" and self.aft_meshes != self.meshes_across:
            yield Contradiction("meshes_across_aft", f"{self.meshes_across}, for square mesh is not tapered here")
        if self.twine.kind.pattern == "squares" and self.meshes_across == 0:
            yield Contradiction("meshes_across", "at least 1 of square mesh")
        if self.meshes_across + self.aft_meshes == 0:
            yield Contradiction("meshes_across", "above 0 at one edge at least")
        counts = (self.meshes_across, self.aft_meshes, self.meshes_long)
        if any(count % self.globalisation for count in counts):
            common = [g for g in range(1, 1001) if not any(count % g for count in counts)]
            yield Contradiction("globalisation", f"a common divisor of its counts: {', '.join(map(str, common))}")
        elif (many := max(counts[:2]) * self.meshes_long // self.globalisation**2) > MOST_MESHES:
            yield Contradiction("globalisation", f"so high that at most {MOST_MESHES} meshes are left, not {many}")
        else:
            sheet = self.sheet
            if len(np.unique(sheet.bars)) < len(sheet.share):
                allowed = "a count that leaves every knot on a bar: tapered so, one hangs on nothing"
                yield Contradiction("meshes_across_aft", allowed)
        for edge in EDGES:
            if isinstance(on := getattr(self, edge), tuple) and (not on or set(on) & set(HOLDS)):
                yield Contradiction(edge, f"a rope, ropes end to end, or one of {', '.join(HOLDS)}")

    @cached_property
    def twine(self) -> Netting:
        """Its mesh and twine, as a section of a codend has them, whose counts mean nothing here."""
        given = {key: getattr(self, key) for key in TWINE_KEYS if key in self.model_fields_set}
        return Netting(meshes_round=3, meshes_long=1, **given)

    @property
    def aft_meshes(self) -> int:
        """Meshes across the aft edge."""
        return self.meshes_across if self.meshes_across_aft is None else self.meshes_across_aft

    @property
    def shields(self) -> tuple[str, ...]:
        """Names of the netting that it lies behind."""
        given = self.shielded_by
        return (given,) if isinstance(given, str) else given or ()

    @cached_property
    def lines(self) -> Floats:
        """Real bars side by side that each of its bars stands for, (m,).

        A bar stands for g x g real ones (Le Bris et al. 1999, section 3.1): it is g times as long, and g lie side by
        side. Of the last line of square netting there are (g + 1) / 2, of one in a plane that it goes on
        beyond g / 2.
        """
        sheet, g = self.sheet, self.globalisation
        lines = np.where(sheet.outermost, 0.5 * (g + 1), float(g))
        for edge in EDGES:
            if self.hold_of(edge) in PLANES:
                on_edge = np.isin(sheet.bars, sheet.edges[edge].knots).all(axis=1)
                lines[sheet.outermost & on_edge] = 0.5 * g
        return lines

    @property
    def drag(self) -> tuple[str, float, float]:
        """Law of its twine's drag and its two coefficients."""
        return drag_by(self.law, self.normal, self.tangential)

    @property
    def stretched_m(self) -> float:
        """Length pulled straight from the fore to the aft edge."""
        return self.twine.rows_per_mesh * self.meshes_long * self.twine.bar_m

    def reach_m(self, edge: EdgeName) -> float:
        """Length of an edge pulled straight."""
        if edge in ("left", "right"):
            return self.stretched_m
        meshes = self.meshes_across if edge == "fore" else self.aft_meshes
        return 2.0 * self.twine.kind.across_bars * meshes * self.twine.bar_m

    @cached_property
    def sheet(self) -> Sheet:
        """Its merged lattice."""
        across, aft, long = (n // self.globalisation for n in (self.meshes_across, self.aft_meshes, self.meshes_long))
        return SHEETS[self.twine.kind.pattern](across, aft, long, self.taper)

    def ropes_of(self, edge: EdgeName) -> tuple[str, ...]:
        """Ropes that an edge hangs on, end to end; none of one that is free or held."""
        on = getattr(self, edge)
        if on is None or on in HOLDS:
            return ()
        return on if isinstance(on, tuple) else (on,)

    def hold_of(self, edge: EdgeName) -> str | None:
        """What holds an edge, one of ``HOLDS``; None if nothing does."""
        on = getattr(self, edge)
        return on if isinstance(on, str) and on in HOLDS else None

    def corner_names(self, edge: EdgeName) -> tuple[str | None, str | None]:
        """Points at the first and the last corner of an edge, None where there is none."""
        first, last = (self.corners[corner] for corner in CORNERS[edge])
        return (first if isinstance(first, str) else None, last if isinstance(last, str) else None)

    @property
    def points(self) -> tuple[str, ...]:
        """Points at its corners."""
        return tuple(corner for corner in self.corners if isinstance(corner, str))


SHEETS: Final = {
    "rhombs": diamond_sheet,
    "squares": lambda across, aft, long, taper: square_sheet(across, long),
}
"""Lattice of a pattern of netting, as ``netting.pattern.PATTERNS`` names them."""


def _as_in_a_codend(key: str) -> FieldInfo:
    field = copy(Netting.model_fields[key])
    field.description = "As of a section of a codend."
    return field


if TYPE_CHECKING:
    SheetTable = _SheetTable
else:  # keys of the twine are those of a codend's section, bounds and all
    SheetTable = create_model(
        "SheetTable",
        __base__=_SheetTable,
        **{key: (Netting.model_fields[key].annotation, _as_in_a_codend(key)) for key in TWINE_KEYS},
    )


class SeamTable(Table):
    """An edge of a sheet sewn to one of another, or to several end to end, knot to knot or in the ratio of counts."""

    edges: Annotated[tuple[Text, ...], MinLen(2)]
    """As in "belly.left"; the first is sewn to all others, these in the order in which they follow one another."""

    @property
    def named(self) -> tuple[tuple[str, str], ...]:
        """Sheet and edge of each."""
        return tuple((sheet, edge) for sheet, _, edge in (edge.rpartition(".") for edge in self.edges))
