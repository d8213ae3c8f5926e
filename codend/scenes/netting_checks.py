"""What a scene's netting must agree on with its points, ropes and seams."""

from collections.abc import Iterator, Mapping, Sequence, Set
from itertools import chain

from codend.netting.sheet import EDGES, EdgeName
from codend.plan.messages import Contradiction
from codend.scenes.netting_tables import CORNERS, HOLDS, SeamTable, SheetTable

Ends = Mapping[str, tuple[str, str]]
"""Points at both ends of every rope."""


def netting_contradictions(
    sheets: Sequence[SheetTable],
    seams: Sequence[SeamTable],
    points: Sequence[str],
    ropes: Ends,
    holds: Mapping[str, str],
) -> Iterator[Contradiction]:
    """What is wrong with the netting of a scene.

    Args:
        sheets: the netting.
        seams: what is sewn together.
        points: names of all points, the vessel's among them.
        ropes: names of the ropes and their ends.
        holds: what may not hold an edge, and what is allowed instead.
    """
    names = [sheet.name for sheet in sheets]
    for index, sheet in enumerate(sheets):
        at = f"netting.{index}"
        if sheet.name in (*names[:index], *points, *ropes):
            yield Contradiction(f"{at}.name", "a name that no other netting, rope or point has")
        for corner, on in enumerate(sheet.corners):
            if isinstance(on, str) and on not in points:
                allowed = f"a place [x, y, z], or the name of a point: {', '.join(points) or 'none'}"
                yield Contradiction(f"{at}.corners.{corner}", allowed)
        for other in sheet.shields:
            if other not in names or other == sheet.name:
                others = [name for name in names if name != sheet.name]
                yield Contradiction(f"{at}.shielded_by", f"other netting: {', '.join(others) or 'of which is none'}")
            elif "choo-casarella-1971" in (sheet.law, sheets[names.index(other)].law):
                yield Contradiction(f"{at}.shielded_by", "left out with a law whose coefficients depend on the speed")
        for edge in EDGES:
            yield from _edge_contradictions(sheet, edge, f"{at}.{edge}", ropes, holds)
    for index, seam in enumerate(seams):
        for side, (name, sewn) in enumerate(seam.named):
            if name not in names or sewn not in EDGES:
                allowed = f'a netting and its edge, as in "{names[0] if names else "belly"}.left": {", ".join(EDGES)}'
                yield Contradiction(f"seam.{index}.edges.{side}", allowed)
        if len(set(seam.edges)) < len(seam.edges):
            yield Contradiction(f"seam.{index}.edges", "edges that differ")


def _edge_contradictions(
    sheet: SheetTable, edge: EdgeName, at: str, ropes: Ends, holds: Mapping[str, str]
) -> Iterator[Contradiction]:
    hold = sheet.hold_of(edge)
    if hold is not None and hold in holds:
        yield Contradiction(at, holds[hold])
    if hold == "symmetry":
        for corner in CORNERS[edge]:
            place = sheet.corners[corner]
            if not isinstance(place, str) and place[1] != 0.0:
                yield Contradiction(f"{at[: -len(edge)]}corners.{corner}", "a place in the plane of symmetry, y = 0")
    on = sheet.ropes_of(edge)
    if not on:
        return
    if unknown := [name for name in on if name not in ropes]:
        allowed = f"ropes, of {', '.join(ropes) or 'which there is none'}; or {', '.join(HOLDS)}"
        yield Contradiction(at, allowed, f"names {unknown[0]}, which is none")
        return
    first, last = sheet.corner_names(edge)
    reached, here = {first}, first
    for name in on:
        ends = ropes[name]
        here = ends[1] if ends[0] == here else ends[0] if ends[1] == here else None
        reached.add(here)
    if first is None or last is None or here != last or None in reached:
        yield Contradiction(at, "ropes end to end, from the point at its first corner to the one at its last")


def carried(first: Set[str], links: Sequence[Set[str]]) -> Set[str]:
    """All that hangs on some names, by links that each join several."""
    found = set(first)
    while more := set(chain.from_iterable(link for link in links if found & link)) - found:
        found |= more
    return found


def links_of(sheets: Sequence[SheetTable], seams: Sequence[SeamTable], ropes: Ends) -> list[Set[str]]:
    """What joins names of points, ropes and netting to each other, to "vessel", "ground", "frame" what they hold."""
    links: list[Set[str]] = [{name, *ends} for name, ends in ropes.items()]
    for sheet in sheets:
        on = [sheet.ropes_of(edge) for edge in EDGES]
        held = [hold for edge in EDGES if (hold := sheet.hold_of(edge)) in ("vessel", "ground", "frame")]
        links.append({sheet.name, *sheet.points, *chain.from_iterable(on), *held})
    links += [{name for name, _ in seam.named} for seam in seams]
    return links
