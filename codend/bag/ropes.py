"""Lastridge ropes: bars from knot to knot straight along the netting.

A rope lies on a meridian. In netting whose rows are turned against each other by half a mesh it meets a knot in every
second row, so that a piece of it is as long as a stretched mesh less the shortening. Ropes at equal angles lie on the
nearest column of knots; one that runs half a mesh beside the knots of the entry starts at a point of the hoop.

Smeared, a share of the ropes runs along every column of knots: all columns are alike, and one mesh is a sector. Ropes
hold short netting out all round there. Real ones hold it out where they are, and between them it hangs in, narrower and
with less drag: that is taken off the twine's diameter of drag (``HANGS_IN``). That will do for netting whose meshes
open as it is shortened; other is merged between real ropes (``plan.merging``).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from codend.bag.bag import Bag, around
from codend.errors import InputError
from codend.net.net import Floats, with_bars, with_held_node
from codend.netting.knots import LEFT, Knots
from codend.netting.lattice import Lattice
from codend.plan.plan import Plan
from codend.plan.ropes import Rope, Selvedge, places_round
from codend.plan.windows import BESIDE

SLACK_FROM, HANGS_IN = 0.045, 1.1
"""Shortening from which netting hangs slack between ropes, and the share of its drag that it then has less for every
unit more, of ropes as stretched as the drag of a bag ``BULGE`` of its width makes them: fitted to the drag of the twine
on 80 random plans with 2 to 6 ropes, 5 to 20 % short, which it leaves off by 2.7 % of itself, before by 8 %
(``python -m validation.smeared_ropes``)."""
BULGE = 0.6


@dataclass(frozen=True)
class _Pieces:
    """Bars of one rope, from the entry."""

    ends: list[tuple[int, int]]
    image: list[int]
    row: list[int]
    stretched_m: list[float]


def with_ropes(bag: Bag, plan: Plan, knots: Knots, drag: tuple[int, float, float], smeared: bool) -> Bag:
    """The bag with the ropes of its plan, their bars after all others."""
    if smeared and plan.rope:
        width = bag.net.bar_drag_diameter * _hanging_in(plan, knots.lattice)[bag.bar_band]
        bag = replace(bag, net=replace(bag.net, bar_drag_diameter=width))
    for index, rope in enumerate(plan.ropes):
        if smeared and knots.lattice.seams is not None:
            pieces, share = _over_tapers(plan, knots, rope)
            bag = _with_rope(bag, rope, drag, 1000 * index, pieces, share)
            continue
        for number, fraction, of_one in _places(rope, knots.lattice, smeared):
            bag, pieces = _laid(bag, plan, knots, rope, fraction)
            bag = _with_rope(bag, rope, drag, 1000 * index + number, pieces, np.full(len(pieces.row), of_one))
    return bag


def _over_tapers(plan: Plan, knots: Knots, rope: Rope | Selvedge) -> tuple[_Pieces, Floats]:
    """Pieces of a rope that is smeared over netting which tapers, and the share of a real one that each is, (pieces,).

    Columns end where it loses meshes, so that none is followed: a piece runs aft from every knot of every second row
    to the nearest of the next such row, and each of as many in a row is as much of the ropes.
    """
    lattice, order = knots.lattice, knots.lattice.order
    aft, fore = _rows_of(rope, plan, lattice)
    stretched = _places_stretched(lattice)
    pieces, share = _Pieces([], [], [], []), list[float]()
    rows = [*range(lattice.bands - fore, lattice.bands - aft, 2), lattice.bands - aft]
    for row, next_row in pairwise(rows):
        count, behind = int(lattice.knots[row]), int(lattice.knots[next_row])
        for column in range(count):
            if next_row == lattice.bands:
                node, image = knots.codline, 0
            else:
                # of the way round, as far as the knot of this row is
                fraction = (column - _column_at(lattice, row, 0.0)) / (count * order)
                there = round(_column_at(lattice, next_row, fraction))
                ring = knots.ring(LEFT, np.array([next_row]), np.array([there]), np.array([behind]))
                node, image = int(ring.node[0]), int(ring.image[0])
            first = knots.ring(LEFT, np.array([row]), np.array([column]), np.array([count]))
            pieces.ends.append((int(first.node[0]), node))
            pieces.image.append(image)
            pieces.row.append(row)
            pieces.stretched_m.append(float(stretched[next_row] - stretched[row]))
            share.append(rope.number / (count * order))
    return pieces, np.array(share)


def _column_at(lattice: Lattice, row: int, fraction: float) -> float:
    """Place in a row's ring, in its knots, of what is at a fraction of the way round."""
    count, ahead = int(lattice.knots[row]), max(row - 1, 0)
    owner = ahead if lattice.columns[ahead] == count else row
    place = (fraction - lattice.phase[owner] / (2.0 * np.pi)) * count * lattice.order - 0.5 * lattice.shift[row]
    return float(place)


def _places_stretched(lattice: Lattice) -> Floats:
    """Stretched length of the netting from the entry to every row, m, (rows + 1,)."""
    return np.append(0.0, np.cumsum(lattice.stretched_m))


def _hanging_in(plan: Plan, lattice: Lattice) -> Floats:
    """Share of its drag that the twine of every band keeps between the ropes that smeared ones stand for, (bands,)."""
    kept = np.ones(lattice.bands)
    pressure_pa = 0.5 * plan.tow.water_density_kg_m3 * max(plan.tow.speed_m_s) ** 2 * plan.catch.coefficient
    widest_m = max(part.stretched_radius_m for part in plan.netting)
    pull_n = pressure_pa * np.pi * (BULGE * widest_m) ** 2
    for rope in plan.rope:
        strain = 0.0 if rope.axial_stiffness_n is None else pull_n / rope.number / rope.axial_stiffness_n
        shorter = 1.0 - (1.0 - rope.shortening) * (1.0 + strain)
        aft, fore = _rows_of(rope, plan, lattice)
        beside = 1.0 - rope.number / (lattice.columns * lattice.order * lattice.globalisation)
        hanging = np.maximum(1.0 - HANGS_IN * max(shorter - SLACK_FROM, 0.0) * beside, 0.0)
        there = slice(lattice.bands - fore, lattice.bands - aft)
        kept[there] = np.minimum(kept, hanging)[there]
    return kept


def _rows_of(rope: Rope | Selvedge, plan: Plan, lattice: Lattice) -> tuple[int, int]:
    """Rows from the codline to either end of a rope, the nearer one first."""
    if rope.meshes_from_codline is None:
        return 0, lattice.bands
    aft, fore = (int(plan.rows_to_codline(meshes) or 0) for meshes in rope.meshes_from_codline)
    return round(aft / lattice.globalisation), round(fore / lattice.globalisation)


def _places(rope: Rope | Selvedge, lattice: Lattice, smeared: bool) -> Iterator[tuple[int, float, float]]:
    """Number, place round the net (0 to 1) and share of a real one of every rope in the modelled sectors."""
    columns, order = int(lattice.columns[0]), lattice.order
    if smeared:
        for column in range(columns):
            yield column, column / (columns * order), rope.number / (columns * order)
        return
    # of knots merged or not
    places = places_round(rope.number, columns * int(order))
    yield from ((number, places[number], 1.0) for number in range(int(rope.number // order)))


def _with_rope(
    bag: Bag, rope: Rope | Selvedge, drag: tuple[int, float, float], name: int, pieces: _Pieces, share: Floats
) -> Bag:
    length = (1.0 - rope.shortening) * np.array(pieces.stretched_m)
    density = np.nan if rope.density_kg_m3 is None else rope.density_kg_m3
    roped = with_bars(
        bag.net,
        np.array(pieces.ends),
        np.array(pieces.image),
        bar_length=length,
        bar_flexibility=0.0 if rope.axial_stiffness_n is None else 1.0 / (share * rope.axial_stiffness_n),
        bar_drag_diameter=share * rope.diameter_m,
        bar_solid_diameter=np.sqrt(share) * rope.solid_diameter_m,
        bar_density=density,
        bar_diameter=rope.diameter_m,
        bar_is_rope=True,
        bar_drag_law=drag[0],
        bar_normal_drag=drag[1],
        bar_tangential_drag=drag[2],
    )
    own = np.arange(len(bag.bar_band), len(roped.bars), dtype=np.int32)
    return replace(
        around(bag, roped, np.array(pieces.row)),
        ropes=np.append(bag.ropes, own),
        rope_share=np.append(bag.rope_share, 1.0 / share),
        rope_name=np.append(bag.rope_name, np.full(len(own), name, dtype=np.int32)),
    )


def _laid(bag: Bag, plan: Plan, knots: Knots, rope: Rope | Selvedge, fraction: float) -> tuple[Bag, _Pieces]:
    """A rope's pieces, and the bag with the point of the hoop that it starts from where no knot is there."""
    lattice, bands = knots.lattice, knots.lattice.bands
    aft, fore = _rows_of(rope, plan, lattice)
    stretched = _places_stretched(lattice)
    nodes: list[tuple[int, int, int]] = []
    for row in range(bands - fore, bands - aft + 1):
        if row == bands:
            nodes.append((row, knots.codline, 0))
            continue
        place = _column_at(lattice, row, fraction)
        column = round(place)
        if abs(place - column) <= BESIDE:
            ring = knots.ring(LEFT, np.array([row]), np.array([column]), lattice.knots[[row]])
            nodes.append((row, int(ring.node[0]), int(ring.image[0])))
        elif row == 0:
            bag = _on_the_hoop(bag, 2.0 * np.pi * fraction)
            nodes.append((0, len(bag.node_row) - 1, 0))
    if any(node < 0 for _, node, _ in nodes):
        where = ", ".join(plan.window_names)
        raise InputError(
            plan.source, "rope", None, f"places beside {where}: knots that a rope is laced to are not there"
        )
    pairs = list(pairwise(nodes))
    return bag, _Pieces(
        ends=[(first[1], second[1]) for first, second in pairs],
        image=[0 if knots.codline in (first[1], second[1]) else second[2] - first[2] for first, second in pairs],
        row=[first[0] for first, _ in pairs],
        stretched_m=[float(stretched[second[0]] - stretched[first[0]]) for first, second in pairs],
    )


def _on_the_hoop(bag: Bag, azimuth: float) -> Bag:
    """The bag with a held node on the hoop, so far round from its first knot."""
    start = bag.net.positions[0]
    cosine, sine = np.cos(azimuth), np.sin(azimuth)
    place: Floats = np.array([start[0], cosine * start[1] - sine * start[2], sine * start[1] + cosine * start[2]])
    return replace(around(bag, with_held_node(bag.net, place), 0), anchors=bag.anchors + 1)
