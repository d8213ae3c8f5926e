"""A scene as a net under loads: ropes cut into bars, sheets of netting that hang on them, points at their nodes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError
from codend.mechanics.body import Body, shortest_period
from codend.mechanics.problem import Problem
from codend.mechanics.rigid import draw_in
from codend.mechanics.seabed import Seabed, no_seabed
from codend.mechanics.water import VISCOSITY_M2_S, Water
from codend.mechanics.weight import GRAVITY_M_S2, wet_weight
from codend.net.net import Floats, Net, with_point
from codend.netting.sheet import EDGES
from codend.scenes.bar_table import BarTable
from codend.scenes.enclosure import facing_alike
from codend.scenes.frame import ballasted, body_of, markers
from codend.scenes.frame_tables import FRAME
from codend.scenes.netting_tables import PLANES
from codend.scenes.scene import FAST, Scene
from codend.scenes.sheets import at_points, laced, laid, merged, sewn
from codend.scenes.shielding import speed_shares as speed_shares_of
from codend.scenes.tables import VESSEL, PointTable

FINE = 20
"""Parts of a bar in which the curve is measured on which a rope is laid."""
DRAWN_IN, TOO_LONG, MOST_SWEEPS = 1e-7, 5e-3, 20_000
"""By which, relative, bars may be too long at the start of a motion: what is aimed at, and what is refused."""
SINKS_M = 1e-3
"""How far what lies on the seabed sinks in under its own weight, assumed."""


STEPS_A_SWING = 8
"""Fewest time steps in the shortest swing of a frame by itself; below 3.1 it would swing ever farther."""


@dataclass(frozen=True)
class BuiltScene:
    """A scene's net, and where in it the user's points, ropes and sheets are."""

    scene: Scene
    problem: Problem
    node_of: dict[str, int]
    """Node of every point, the vessel's first where there is one."""
    rope_nodes: tuple[NDArray[np.int64], ...]
    """Nodes along every rope, from its first end to its second."""
    rope_bars: tuple[slice, ...]
    sheet_nodes: tuple[NDArray[np.int64], ...]
    """Nodes of every sheet's knots, some of which are one."""
    bar_sheet: NDArray[np.int64]
    """Number of the sheet that a bar is of, -1 of ropes, (m,)."""
    bar_lines: Floats
    """Real bars side by side that a bar stands for, (m,)."""
    added_mass: Floats
    """Cm of the bars, (m,)."""
    towed: NDArray[np.bool_]
    """Nodes that go with the vessel, (n,)."""
    frame: Body | None
    """The scene's frame, held or afloat."""
    speed_shares: tuple[float, ...]
    """Speed of the water that every sheet meets, over that of the current."""

    @property
    def held(self) -> dict[str, int]:
        """Points that something holds, and their nodes."""
        fixed = np.asarray(self.problem.net.fixed.all(axis=1))
        return {name: node for name, node in self.node_of.items() if fixed[node]}


def build(scene: Scene) -> BuiltScene:
    """The net of a scene under the loads of its steady tow."""
    places = places_of(scene)
    node_of = {name: number for number, name in enumerate(places)}
    ends = {name: rope.ends for name, rope in zip(scene.rope_names, scene.rope, strict=True)}
    lengths = {name: rope.length_m for name, rope in zip(scene.rope_names, scene.rope, strict=True)}
    lacings = [laced(sheet, ends, lengths) for sheet in scene.netting]
    positions: list[Floats] = list(places.values())
    if scene.frame is not None:
        positions += list(markers(scene.frame))
    bars = BarTable()
    rope_nodes, rope_bars = {}, []
    for name, rope in zip(scene.rope_names, scene.rope, strict=True):
        knots = max((part.bars for lacing in lacings for part in lacing if part.rope == name), default=0)
        count = rope.bars or knots or scene.model.bars_per_rope
        first, last = (node_of[end] for end in rope.ends)
        nodes = np.concatenate([[first], np.arange(count - 1) + len(positions), [last]])
        positions += list(_laid(positions[first], positions[last], rope.length_m, count)[1:-1])
        rope_bars.append(slice(bars.count, bars.count + count))
        rope_nodes[name] = nodes
        bars.add_rope(rope, np.stack([nodes[:-1], nodes[1:]], axis=1))
    firm, pairs = len(positions), []
    sheet_nodes = []
    firmly = np.array(positions)
    curves = [[(part, firmly[rope_nodes[part.rope]]) for part in lacing] for lacing in lacings]
    shapes = [laid(sheet, places, along) for sheet, along in zip(scene.netting, curves, strict=True)]
    speed_shares = speed_shares_of(scene.netting, shapes)
    for number, (sheet, lacing) in enumerate(zip(scene.netting, lacings, strict=True)):
        nodes = np.arange(len(sheet.sheet.share)) + len(positions)
        positions += list(shapes[number])
        sheet_nodes.append(nodes)
        bars.add_sheet(sheet, number, nodes, speed_shares[number])
        pairs += at_points(sheet, nodes, node_of)
        for part in lacing:
            pairs += part.pairs(nodes[part.edge.knots], rope_nodes[part.rope])
    for seam in scene.seam:
        pairs += sewn(seam, scene.netting, sheet_nodes, np.array(positions))
    place, laid_out = merged(len(positions), pairs, np.array(positions), firm)
    if scene.seabed is not None:
        laid_out[:, 2] = np.maximum(laid_out[:, 2], -scene.seabed.depth_m)
    sheet_nodes = [place[nodes] for nodes in sheet_nodes]
    held, towed, on_frame = _held(scene, node_of, sheet_nodes, len(laid_out))
    sides = [nodes[sheet.sheet.facets] for sheet, nodes in zip(scene.netting, sheet_nodes, strict=True)]
    weights = [sheet.sheet.facet_weight for sheet in scene.netting]
    facets = facing_alike(sides, weights, laid_out)
    net = bars.net(
        place, laid_out, held, np.concatenate([np.zeros((0, 3), int), *facets]), np.concatenate([[], *weights])
    )
    for point in scene.point:
        lift, coefficient = scene.coefficients(point)
        net = with_point(
            net,
            node_of[point.name],
            mass_kg=point.mass_kg + point.added_mass_kg,
            wet_weight_n=_wet_weight(point, scene.water.density_kg_m3),
            drag_area_m2=coefficient * point.area_m2,
            lift_area_m2=lift * point.area_m2,
            lift_towards=point.lift_towards,
        )
    density = scene.water.density_kg_m3
    if scene.ballast is not None:
        net = ballasted(net, scene.ballast, node_of, scene.netting, sheet_nodes, density)
    body = None
    if scene.frame is not None:
        body = body_of(scene.frame, scene.floats, on_frame, laid_out, density)
        _check_step(scene, body)
    built = BuiltScene(
        scene,
        Problem.of(net, water=_water(scene), seabed=_seabed(scene, net), body=body if scene.afloat else None),
        node_of,
        tuple(place[nodes] for nodes in rope_nodes.values()),
        tuple(rope_bars),
        tuple(sheet_nodes),
        bars.sheet,
        bars.lines,
        bars.added_mass,
        towed,
        body,
        tuple(speed_shares),
    )
    return _drawn_in(built) if scene.time is not None and scene.time.start == "placed" else built


def _held(
    scene: Scene, node_of: dict[str, int], sheet_nodes: Sequence[NDArray[np.int64]], count: int
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.int64]]:
    """Coordinates that are held, (n, 3), nodes that go with the vessel, (n,), and those of the frame, (k,)."""
    held, towed = np.zeros((count, 3), dtype=bool), np.zeros(count, dtype=bool)
    holds: list[tuple[str | None, NDArray[np.int64]]] = [
        (point.held, np.array([node_of[point.name]])) for point in scene.point
    ]
    for sheet, nodes in zip(scene.netting, sheet_nodes, strict=True):
        holds += [(sheet.hold_of(edge), nodes[sheet.sheet.edges[edge].knots]) for edge in EDGES]
    holds += [("vessel", np.array([node_of[VESSEL]]))] if scene.vessel is not None else []
    on_frame = np.zeros(0, dtype=np.int64)
    if scene.frame is not None:
        # its origin and its markers, which come after all places
        on_frame = np.array([node_of[FRAME], len(node_of), len(node_of) + 1])
        holds.append((FRAME, on_frame))
        on_frame = np.concatenate([on_frame, *(nodes for hold, nodes in holds[:-1] if hold == FRAME)])
        on_frame = on_frame[np.sort(np.unique(on_frame, return_index=True)[1])]
    for hold, nodes in holds:
        held[nodes] |= hold in FAST
        held[nodes, 1] |= hold in PLANES
        towed[nodes] |= hold == "vessel"
    return held, towed, on_frame


def _check_step(scene: Scene, body: Body) -> None:
    """Refuse time steps longer than a part of the shortest swing of a frame that floats."""
    if scene.time is None or not scene.afloat:
        return
    longest = shortest_period(body) / STEPS_A_SWING
    if scene.time.step_s > longest:
        allowed = f"at most {longest:.3g}, an {STEPS_A_SWING}th of the shortest period of the frame afloat"
        raise InputError(scene.source, "time.step_s", scene.time.step_s, allowed)


def _drawn_in(built: BuiltScene) -> BuiltScene:
    """The scene with what is placed too long, ropes or netting between places too far apart, drawn in to its length."""
    positions = built.problem.net.positions.copy()
    net = built.problem.net
    # a rope that stretches may be placed under tension
    limits = np.where(net.bar_is_rope & (net.bar_flexibility > 0.0), np.inf, net.bar_length)
    structure = built.problem.structure._replace(length=limits)
    if draw_in(positions, structure, DRAWN_IN, MOST_SWEEPS) > TOO_LONG:
        apart = np.linalg.norm(positions[structure.second] - positions[structure.first], axis=1) / structure.length
        worst = int(apart.argmax())
        sheet = int(built.bar_sheet[worst])
        rope = next((number for number, bars in enumerate(built.rope_bars) if bars.start <= worst < bars.stop), 0)
        key = f"netting.{sheet}.corners" if sheet >= 0 else f"rope.{rope}.length_m"
        problem = f"is placed {apart[worst]:.4g} times as long as it is, however it is drawn in"
        raise InputError(
            built.scene.source, key, None, 'held places that it reaches, with time.start = "placed"', problem
        )
    return replace(built, problem=replace(built.problem, net=replace(built.problem.net, positions=positions)))


def places_of(scene: Scene) -> dict[str, Floats]:
    """Where every point starts: where it is told, or astern of what it hangs on, in a line at the same height."""
    found = {} if scene.vessel is None else {VESSEL: np.array(scene.vessel.at, dtype=float)}
    found |= {point.name: np.array(point.at, dtype=float) for point in scene.point if point.at is not None}
    found |= {} if scene.frame is None else {FRAME: np.array(scene.frame.at, dtype=float)}
    while True:
        left = [rope for rope in scene.rope if len(found.keys() & set(rope.ends)) == 1]
        if not left:
            return found
        rope = left[0]
        known, new = sorted(rope.ends, key=lambda end: end not in found)
        found[new] = found[known] + [rope.length_m, 0.0, 0.0]


def _laid(first: Floats, last: Floats, length: float, count: int) -> Floats:
    """Nodes of a rope from one place to another, sagging by about what it is longer, (count + 1, 3)."""
    chord = last - first
    apart = float(np.linalg.norm(chord))
    u = np.linspace(0.0, 1.0, FINE * count + 1)[:, None]
    # a shallow parabola of depth h is longer than its chord by 8 h^2 / 3 c
    sag = np.sqrt(max(3.0 / 16.0 * (length**2 - apart**2), 0.0))
    side = np.array([0.6, 0.0, -0.8])
    if apart > 0.0:
        side -= (side @ chord) / apart**2 * chord
    size = float(np.linalg.norm(side))
    side = side / size if size > 0.1 else np.array([0.8, 0.0, 0.6])
    curve = first + u * chord + 4.0 * sag * u * (1.0 - u) * side
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    even = np.linspace(0.0, reached[-1], count + 1)
    return np.stack([np.interp(even, reached, curve[:, i]) for i in range(3)], axis=1)


def _wet_weight(point: PointTable, water: float) -> float:
    if point.density_kg_m3 is not None:
        return point.mass_kg * GRAVITY_M_S2 * (1.0 - water / point.density_kg_m3)
    return point.wet_weight_n or 0.0


def _water(scene: Scene) -> Water:
    """The current, and against a vessel that tows at a steady speed what it adds to that."""
    tow = np.array([scene.speed_m_s, 0.0, 0.0])
    layers = scene.water.profile[::-1]
    heights = np.array([-layer.depth_m for layer in layers]) if layers else np.zeros(1)
    flows = np.array([layer.flow_m_s for layer in layers] or [scene.water.flow_m_s], dtype=float)
    return Water(scene.water.density_kg_m3, VISCOSITY_M2_S, heights, np.ascontiguousarray(flows + tow))


def _seabed(scene: Scene, net: Net) -> Seabed:
    if scene.seabed is None:
        return no_seabed()
    down = -wet_weight(net, scene.water.density_kg_m3)[:, 2]
    return Seabed(-scene.seabed.depth_m, np.maximum(down, np.abs(down).mean()) / SINKS_M)
