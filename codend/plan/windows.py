"""Windows: pieces of other netting let into a panel of a section."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Final, Self

from annotated_types import Ge
from pydantic import model_validator

from codend.plan.messages import Contradiction
from codend.plan.tables import Netting, Number, PanelName, Text, Whole

OF_PANELS: tuple[str, ...] = ("panels", "selvedge_meshes", "meshes_round_aft", "cut")
"""Keys of a section that have no meaning in a window, which is one straight piece."""


class Window(Netting):
    """A piece of netting in place of a panel's own; its ``meshes_round`` are its own meshes across.

    Its edges are joined in the ratio of its counts to those of the netting that it takes the place of.
    """

    netting: Text
    """Section that it is let into, by name or number."""
    panel: PanelName | None = None
    """None: the upper one; of a tube, the side that its middle lies on."""
    meshes_from_codline: tuple[Annotated[Number, Ge(0)], Annotated[Number, Ge(0)]]
    """Where it lies, in meshes of the netting that it is let into, all sections counted from the codline."""
    meshes_across: Annotated[Whole, Ge(1)]
    """Meshes of that section, across, in whose place it is."""

    @model_validator(mode="after")
    def _one_straight_piece(self) -> Self:
        for key in OF_PANELS:
            if getattr(self, key) != type(self).model_fields[key].default:
                raise Contradiction(key, "left out: a window is one straight piece")
        if self.meshes_from_codline[0] >= self.meshes_from_codline[1]:
            raise Contradiction("meshes_from_codline", "the end nearer to the codline first, as in [10, 40]")
        return self

    @property
    def side(self) -> PanelName:
        """Panel, or side of a tube, in whose middle it lies."""
        return self.panel or "upper"


SIDES_DEG: Final[dict[PanelName, float]] = {"starboard": 0.0, "upper": 90.0, "port": 180.0, "lower": 270.0}
"""Azimuth of the middle of a panel, or of a side of a tube: from starboard on over the top, looking aft."""


@dataclass(frozen=True)
class Hole:
    """The netting that a window takes the place of, in open meshes of its section."""

    section: int
    """Number of the section, from 0."""
    fore: int
    """Meshes from the section's fore end to the hole's."""
    deep: int
    first: float
    """Meshes from the first seam, round, to the hole; half a mesh where it has no middle in common with its panel."""
    across: int


def hole_of(window: Window, netting: Sequence[Netting], names: Sequence[str], seam_deg: float) -> Hole:
    """Where a window lies that is in place (``out_of_place``)."""
    section = names.index(window.netting)
    part, behind = netting[section], sum(part.meshes_long for part in netting[section + 1 :])
    near, far = (round(meshes) - behind for meshes in window.meshes_from_codline)
    middle = (SIDES_DEG[window.side] - seam_deg) / 360.0 * part.open_meshes[0]
    return Hole(section, part.meshes_long - far, far - near, middle - window.meshes_across / 2, window.meshes_across)


def out_of_place(
    windows: Sequence[Window], netting: Sequence[Netting], names: Sequence[str], seam_deg: float
) -> Iterator[Contradiction]:
    """Windows in no section or panel, outside it, wider than it or over one another."""
    holes: list[Hole] = []
    for index, window in enumerate(windows):
        if window.netting not in names:
            yield Contradiction(f"window.{index}.netting", f"a section: {', '.join(names)}")
            continue
        section = names.index(window.netting)
        part, behind = netting[section], sum(part.meshes_long for part in netting[section + 1 :])
        if part.panels > 1 and window.side not in part.panel_names:
            yield Contradiction(f"window.{index}.panel", f"a panel of {window.netting}: {', '.join(part.panel_names)}")
            continue
        wrong = list(_not_within(index, window, part, behind))
        yield from wrong
        if wrong:
            continue
        hole = hole_of(window, netting, names, seam_deg)
        if any(_overlap(hole, other, part.open_meshes[0]) for other in holes):
            yield Contradiction(f"window.{index}.meshes_from_codline", "netting that no other window is let into")
        holes.append(hole)


def _not_within(index: int, window: Window, part: Netting, behind: int) -> Iterator[Contradiction]:
    ahead = behind + part.meshes_long
    for place, meshes in enumerate(window.meshes_from_codline):
        if not (behind <= meshes <= ahead and meshes == math.floor(meshes)):
            allowed = f"whole meshes from {behind} to {ahead}, where {window.netting} lies"
            yield Contradiction(f"window.{index}.meshes_from_codline.{place}", allowed)
    widest = min(part.open_meshes) // part.panels - (1 if part.panels == 1 else 0)
    if window.meshes_across > widest:
        allowed = f"at most {widest}, the open meshes of the panel"
        yield Contradiction(f"window.{index}.meshes_across", allowed)


def _overlap(one: Hole, other: Hole, meshes_round: int) -> bool:
    deep = max(one.fore, other.fore) < min(one.fore + one.deep, other.fore + other.deep)
    apart = (other.first - one.first) % meshes_round
    across = apart < one.across or (one.first - other.first) % meshes_round < other.across
    return one.section == other.section and deep and across
