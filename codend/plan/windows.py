"""Windows: pieces of other netting let into a panel of a section."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
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


BESIDE: Final = 0.26
"""Of a mesh: how far beside a rope a knot may lie that it is laced to. Every other row's are half a mesh off."""

CLEAR: Final = 1.5
"""Meshes between a window and a seam along which meshes are lost, on average of the cut's steps: one at every step."""


@dataclass(frozen=True)
class Hole:
    """The netting that a window takes the place of, in open meshes of its section."""

    section: int
    """Number of the section, from 0."""
    fore: int
    """Meshes from the section's fore end to the hole's."""
    deep: int
    first: float
    """Meshes from the first seam, round, to the hole; half a mesh where it has no middle in common with its panel.

    In a section that tapers as many as at its fore end."""
    across: int

    def in_panel(self, meshes_round: int, panels: int) -> tuple[int, float]:
        """The panel, of so many and so many meshes round at the fore end, and meshes from its middle to the hole's."""
        wide = meshes_round / panels
        middle = (self.first + 0.5 * self.across) % meshes_round
        panel = min(int(middle / wide), panels - 1)
        return panel, middle - (panel + 0.5) * wide

    def narrowest(self, part: Netting, globalisation: int = 1) -> float:
        """(Merged) meshes round of its section at the narrower of its ends."""
        return _narrowest(part, (self.fore, self.fore + self.deep), globalisation)

    def clear_of_seams(self, part: Netting, seams: int, globalisation: int = 1) -> bool:
        """Whether it lies between the seams, or lines of a tube, along which its section tapers."""
        beside = abs(self.in_panel(part.open_meshes[0] // globalisation, seams)[1])
        return beside + 0.5 * self.across + CLEAR <= 0.5 * self.narrowest(part, globalisation) / seams

    def merged(self, globalisation: int) -> Self:
        """The same in merged meshes, whole ones; towards the top where it has no middle in common with its panel."""
        first = math.floor(self.first / globalisation + 0.5)
        return replace(
            self,
            fore=self.fore // globalisation,
            deep=self.deep // globalisation,
            first=first,
            across=self.across // globalisation,
        )


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
    """Windows in no section or panel, outside it, wider than it, over one another or too near."""
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
        if part.tapers and part.panels == 1 and lines_of_loss([hole], netting, math.gcd(*part.open_meshes)) is None:
            allowed = f"another side of {window.netting} or panels = 2 there: here is the line along which it tapers"
            yield Contradiction(f"window.{index}.panel", allowed)
        if any(too_near(hole, other, part.open_meshes[0]) for other in holes):
            allowed = "netting that no other window is let into, with a mesh between windows side by side"
            yield Contradiction(f"window.{index}.meshes_from_codline", allowed)
        holes.append(hole)


def _not_within(index: int, window: Window, part: Netting, behind: int) -> Iterator[Contradiction]:
    ahead = behind + part.meshes_long
    for place, meshes in enumerate(window.meshes_from_codline):
        if not (behind <= meshes <= ahead and meshes == math.floor(meshes)):
            allowed = f"whole meshes from {behind} to {ahead}, where {window.netting} lies"
            yield Contradiction(f"window.{index}.meshes_from_codline.{place}", allowed)
    widest, of_these = min(part.open_meshes) // part.panels - (1 if part.panels == 1 else 0), ""
    if part.tapers:
        narrowest = _narrowest(part, [ahead - round(meshes) for meshes in window.meshes_from_codline]) / part.panels
        # half a mesh off its middle where it has none in common with the panel
        widest, of_these = math.floor(narrowest - 2 * CLEAR - 1), ", less those beside the seams that it tapers along"
    if window.meshes_across > widest:
        allowed = f"at most {widest}, the open meshes of the panel{of_these}"
        yield Contradiction(f"window.{index}.meshes_across", allowed)


def _narrowest(part: Netting, places: Sequence[float], globalisation: int = 1) -> float:
    """Least (merged) meshes round of a section over places in it, in (merged) meshes from its fore end."""
    fore, aft = (count / globalisation for count in part.open_meshes)
    long = part.meshes_long / globalisation
    return min(fore + (aft - fore) * place / long for place in places)


def lines_of_loss(holes: Sequence[Hole], netting: Sequence[Netting], most: int, globalisation: int = 1) -> int | None:
    """Lines at equal angles along which a tube tapers, at most so many, that run through no hole; None: one does."""
    own = [hole for hole in holes if netting[hole.section].tapers and netting[hole.section].panels == 1]
    for lines in range(most, 0, -1):
        if most % lines == 0 and all(hole.clear_of_seams(netting[hole.section], lines, globalisation) for hole in own):
            return lines
    return None


def too_near(one: Hole, other: Hole, meshes_round: int) -> bool:
    """Whether windows lie over one another, or side by side with less than a mesh between that holds their edges."""
    deep = max(one.fore, other.fore) < min(one.fore + one.deep, other.fore + other.deep)
    across = (other.first - one.first) % meshes_round < one.across + 1
    across = across or (one.first - other.first) % meshes_round < other.across + 1
    return one.section == other.section and deep and across


def strap_amiss(meshes_from_codline: float, windows: Sequence[Window], names: Sequence[str]) -> str | None:
    """What is allowed of a strap whose row of knots a window interrupts; None where none does.

    On the edge of a window with fewer meshes than it takes the place of, the row's knots are taken up: some are one.
    """
    for window, name in zip(windows, names, strict=True):
        near, far = (round(meshes) for meshes in window.meshes_from_codline)
        within, here = near < meshes_from_codline < far, f"at {meshes_from_codline:g}"
        if within:
            return f"at most {near} or at least {far}: {here} it would run through {name}"
        if near <= meshes_from_codline <= far and window.meshes_round < window.meshes_across:
            return f"below {near} or above {far}: {here} knots of its row are taken up at the edge of {name}"
    return None


def ropes_amiss(
    places: Sequence[float],
    ends: tuple[float, float],
    windows: Sequence[Window],
    holes: Sequence[Hole],
    netting: Sequence[Netting],
    globalisation: int = 1,
) -> tuple[int, int] | None:
    """The first rope that runs through a window, and that window; None where none does.

    Args:
        places: of every rope, as shares of the way round from the first seam.
        ends: where the ropes run, in meshes from the codline.
        windows: of the plan.
        holes: what they are let into, of merged meshes.
        netting: the sections.
        globalisation: meshes that are merged, each way.
    """
    for index, (window, hole) in enumerate(zip(windows, holes, strict=True)):
        near, far = window.meshes_from_codline
        if max(near, ends[0]) >= min(far, ends[1]):
            continue
        part = netting[hole.section]
        around = part.open_meshes[0] // globalisation
        # where the section is narrower the hole takes more of the way round
        half = (0.5 * hole.across - BESIDE) * around / hole.narrowest(part, globalisation)
        for number, place in enumerate(places):
            off = (place * around - hole.first - 0.5 * hole.across + 0.5 * around) % around - 0.5 * around
            if abs(off) < half:
                return number, index
    return None
