"""Shapes of a net plan, in metres as drawn: panels as cut and laid flat, with selvedges, windows, ropes and straps.

A section is drawn as technologists do, hung at E1: as wide as its stretched meshes times E1, as deep as they are times
E2 = sqrt(1 - E1^2), all at one scale; square mesh at its own width and depth. A cut that loses meshes at a rate then
slopes by that rate times E1 / E2.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate

from codend.plan.plan import Plan
from codend.plan.tables import Netting
from codend.plan.windows import SIDES_DEG

HANGING = 0.5
"""E1 that meshes are drawn at; no more than a way of drawing."""
Corner = tuple[float, float]


@dataclass(frozen=True)
class Piece:
    """A section as one panel has it, its middle at x = 0, y downward from the entry."""

    section: int
    top: float
    deep: float
    fore: float
    """Width at its fore end."""
    aft: float
    mesh: float
    """Width of a mesh."""
    selvedge: int
    """Meshes of each edge that are taken up."""

    @property
    def outline(self) -> list[Corner]:
        """Its corners, the fore end first."""
        bottom = self.top + self.deep
        return [
            (-self.fore / 2, self.top),
            (self.fore / 2, self.top),
            (self.aft / 2, bottom),
            (-self.aft / 2, bottom),
        ]

    def selvedges(self) -> list[list[Corner]]:
        """Corners of the strips along its two edges; none where nothing is taken up."""
        wide, bottom = self.selvedge * self.mesh, self.top + self.deep
        if wide == 0.0:
            return []
        return [
            [
                (side * self.fore / 2, self.top),
                (side * (self.fore / 2 - wide), self.top),
                (side * (self.aft / 2 - wide), bottom),
                (side * self.aft / 2, bottom),
            ]
            for side in (-1.0, 1.0)
        ]

    def width_at(self, y: float) -> float:
        """Width between the selvedges at a height."""
        share = (y - self.top) / self.deep
        return self.fore + (self.aft - self.fore) * share - 2 * self.selvedge * self.mesh


@dataclass(frozen=True)
class Panel:
    """A panel of all sections, from the entry to the codline, and what lies on it."""

    names: tuple[str, ...]
    """Of the panels that look like it; empty of a tube."""
    pieces: tuple[Piece, ...]
    windows: tuple[tuple[int, list[Corner]], ...]
    """Number of each window, and its corners."""
    straps: tuple[tuple[Corner, Corner], ...]
    ropes: tuple[list[Corner], ...]

    @property
    def width(self) -> float:
        """Of its widest piece."""
        return max(max(piece.fore, piece.aft) for piece in self.pieces)


def drawn_mesh(section: Netting) -> Corner:
    """Width and depth of a mesh as drawn, m."""
    if not section.kind.opens:
        return 0.5 * section.full_mesh_m, 0.5 * section.full_mesh_m
    return HANGING * section.full_mesh_m, math.sqrt(1.0 - HANGING**2) * section.full_mesh_m


def panels_of(plan: Plan) -> list[Panel]:
    """Panels that differ in what lies on them, the upper one first; of a tube the whole way round, cut open below."""
    pieces = tuple(_pieces(plan))
    sides = next((part.panel_names for part in plan.netting if part.panels > 1), ())
    alike: dict[tuple[int, ...], list[str]] = {}
    for side in sides or ("",):
        own = tuple(i for i, window in enumerate(plan.window) if not sides or window.side == side)
        alike.setdefault(own, []).append(side)
    return [
        Panel(
            tuple(name for name in names if name),
            pieces,
            tuple((number, _window(plan, pieces, number)) for number in own),
            tuple(_straps(plan, pieces)),
            tuple(_ropes(plan, pieces, sides.index(names[0]) if sides else 0)),
        )
        for own, names in alike.items()
    ]


def _pieces(plan: Plan) -> Iterator[Piece]:
    sizes = [drawn_mesh(part) for part in plan.netting]
    depths = [part.meshes_long * deep for part, (_, deep) in zip(plan.netting, sizes, strict=True)]
    for number, (part, (wide, _), top) in enumerate(
        zip(plan.netting, sizes, accumulate(depths[:-1], initial=0.0), strict=True)
    ):
        fore, aft = (wide * count / plan.panels for count in (part.meshes_round, part.aft_meshes_round))
        yield Piece(number, top, depths[number], fore, aft, wide, part.selvedge_meshes)


def _height(plan: Plan, pieces: tuple[Piece, ...], meshes_from_codline: float) -> tuple[Piece, float]:
    """Piece at a place, at a joint the one ahead, and its height."""
    place = sum(part.meshes_long for part in plan.netting) - meshes_from_codline
    for piece in pieces:
        long = plan.netting[piece.section].meshes_long
        if place <= long:
            return piece, piece.top + piece.deep * place / long
        place -= long
    return pieces[-1], pieces[-1].top + pieces[-1].deep


def _window(plan: Plan, pieces: tuple[Piece, ...], number: int) -> list[Corner]:
    """Corners of the netting that a window takes the place of, in the middle of its panel or about its side."""
    window, hole = plan.window[number], plan.holes[number]
    piece, part = pieces[hole.section], plan.netting[hole.section]
    step = piece.deep / part.meshes_long
    top, bottom = piece.top + step * hole.fore, piece.top + step * (hole.fore + hole.deep)
    half, middle = 0.5 * hole.across * piece.mesh, 0.0
    if plan.panels == 1:  # cut open below: starboard to the right, as seen from above looking forward
        turn = (90.0 - SIDES_DEG[window.side] + 180.0) % 360.0 - 180.0
        reach = 0.5 * piece.width_at(0.5 * (top + bottom)) - half
        middle = max(-reach, min(reach, turn / 360.0 * piece.width_at(0.5 * (top + bottom))))
    return [(middle - half, top), (middle + half, top), (middle + half, bottom), (middle - half, bottom)]


def _straps(plan: Plan, pieces: tuple[Piece, ...]) -> Iterator[tuple[Corner, Corner]]:
    for strap in plan.straps:
        piece, y = _height(plan, pieces, strap.meshes_from_codline)
        half = 0.5 * piece.width_at(y) + piece.selvedge * piece.mesh
        yield (-half, y), (half, y)


def _ropes(plan: Plan, pieces: tuple[Piece, ...], side: int) -> Iterator[list[Corner]]:
    """Ropes that run along a panel or its seams, from the entry on, bent where its sections meet."""
    long = sum(part.meshes_long for part in plan.netting)
    for rope in plan.rope:
        near, far = rope.meshes_from_codline or (0.0, float(long))
        (first, top), (last, bottom) = _height(plan, pieces, far), _height(plan, pieces, near)
        for number in range(rope.number):
            place = number / rope.number * plan.panels - side
            if place < 0.0 and plan.panels > 1 and side == plan.panels - 1 and number == 0:
                place = 1.0  # the first seam is the last panel's other edge
            if not 0.0 <= place <= 1.0:
                continue
            line = [(piece, max(piece.top, top)) for piece in pieces[first.section : last.section + 1]]
            ends = [(piece, min(piece.top + piece.deep, bottom)) for piece, _ in line]
            both = (point for pair in zip(line, ends, strict=True) for point in pair)
            yield [((place - 0.5) * piece.width_at(y), y) for piece, y in both]
