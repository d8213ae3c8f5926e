"""What a scene's frame, floats and ballast must agree on with its points and netting."""

from collections.abc import Iterator, Sequence

from codend.netting.sheet import EDGES
from codend.plan.messages import Contradiction
from codend.scenes.frame_tables import BallastTable, FloatTable, FrameTable
from codend.scenes.netting_tables import SheetTable


def frame_contradictions(
    frame: FrameTable | None, floats: Sequence[FloatTable], names: Sequence[str], used: bool, moves: bool
) -> Iterator[Contradiction]:
    """What is wrong with a frame and its floats.

    Args:
        frame: the frame, if there is one.
        floats: its floats.
        names: of points, ropes and netting.
        used: whether anything is fastened to the frame.
        moves: whether it is followed in time.
    """
    for index, one in enumerate(floats):
        if frame is None:
            yield Contradiction(f"float.{index}", "a table [frame], which it is a float of")
        if one.name in (*names, *(other.name for other in floats[:index])):
            yield Contradiction(f"float.{index}.name", "a name that no other float, point, rope or netting has")
    if frame is None:
        return
    if not used:
        allowed = 'a point or an edge of netting held by "frame", or a rope to it'
        yield Contradiction("frame", allowed, "holds nothing")
    if frame.hold == "floating":
        if not floats:
            yield Contradiction("float", "one table [[float]] at least, for a frame that floats", "is missing")
        if frame.mass_kg == 0.0 and not any(one.mass_kg for one in floats):
            yield Contradiction("frame.mass_kg", "a number above 0, of a frame that floats", "is missing")
        heavy = sum(one.mass_kg > 0.0 for one in floats) + (frame.mass_kg > 0.0)
        if moves and heavy < 2 and not any(one.mass_kg for one in floats) and not all(frame.inertia_kg_m2):
            yield Contradiction("frame.inertia_kg_m2", "three numbers above 0, of a frame in motion")


def ballast_contradictions(
    ballast: BallastTable | None, sheets: Sequence[SheetTable], points: Sequence[str]
) -> Iterator[Contradiction]:
    """What is wrong with where ballast hangs."""
    if ballast is None:
        return
    for index, name in enumerate(ballast.points or ()):
        if name not in points:
            yield Contradiction(f"ballast.points.{index}", f"the name of a point: {', '.join(points) or 'none'}")
    names = [sheet.name for sheet in sheets]
    for index, edge in enumerate(ballast.edges or ()):
        sheet, _, side = edge.rpartition(".")
        if sheet not in names or side not in EDGES:
            like = f'"{names[0] if names else "wall"}.aft"'
            yield Contradiction(f"ballast.edges.{index}", f"a netting and its edge, as in {like}: {', '.join(EDGES)}")
