"""A scene as a net under loads: ropes cut into bars, points at their nodes."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.drag_laws import drag
from codend.mechanics.problem import Problem
from codend.mechanics.seabed import Seabed, no_seabed
from codend.mechanics.water import VISCOSITY_M2_S, Water
from codend.mechanics.weight import GRAVITY_M_S2, wet_weight
from codend.net.net import Floats, Net, with_point
from codend.scenes.scene import FAST, Scene
from codend.scenes.tables import VESSEL, PointTable

SINKS_M = 1e-3
"""How far what lies on the seabed sinks in under its own weight, assumed."""


@dataclass(frozen=True)
class BuiltScene:
    """A scene's net, and where in it the user's points and ropes are."""

    scene: Scene
    problem: Problem
    node_of: dict[str, int]
    """Node of every point, the vessel's first where there is one."""
    rope_nodes: tuple[NDArray[np.int64], ...]
    """Nodes along every rope, from its first end to its second."""
    rope_bars: tuple[slice, ...]
    added_mass: Floats
    """Cm of the bars, (m,)."""
    towed: NDArray[np.bool_]
    """Nodes that go with the vessel, (n,)."""

    @property
    def held(self) -> dict[str, int]:
        """Points that something holds, and their nodes."""
        fixed = np.asarray(self.problem.net.fixed.all(axis=1))
        return {name: node for name, node in self.node_of.items() if fixed[node]}


def build(scene: Scene) -> BuiltScene:
    """The net of a scene under the loads of its steady tow."""
    places = _places(scene)
    node_of = {name: number for number, name in enumerate(places)}
    positions = list(places.values())
    ends: list[tuple[int, int]] = []
    rope_nodes, rope_bars = [], []
    for rope in scene.rope:
        count = rope.bars or scene.model.bars_per_rope
        first, last = (node_of[end] for end in rope.ends)
        inner = np.arange(count - 1) + len(positions)
        nodes = np.concatenate([[first], inner, [last]])
        positions += list(_laid(positions[first], positions[last], rope.length_m, count)[1:-1])
        rope_bars.append(slice(len(ends), len(ends) + count))
        rope_nodes.append(nodes)
        ends += list(zip(nodes[:-1].tolist(), nodes[1:].tolist(), strict=True))
    laid = np.array(positions)
    if scene.seabed is not None:
        laid[:, 2] = np.maximum(laid[:, 2], -scene.seabed.depth_m)
    counts = [len(nodes) - 1 for nodes in rope_nodes]

    def of_ropes(values: list[float]) -> Floats:
        return np.repeat(np.array(values, dtype=float), counts)

    held = np.zeros((len(laid), 3), dtype=bool)
    if scene.vessel is not None:
        held[node_of[VESSEL]] = True
    for point in scene.point:
        held[node_of[point.name]] = point.held in FAST
        held[node_of[point.name], 1] |= point.held == "symmetry"
    diameter = of_ropes([0.001 * rope.diameter_mm for rope in scene.rope])
    net = Net.from_bars(
        laid,
        ends,
        held,
        length_m=of_ropes([rope.length_m / count for rope, count in zip(scene.rope, counts, strict=True)]),
        stiffness_n=of_ropes([rope.axial_stiffness_n or np.inf for rope in scene.rope]),
        diameter_m=diameter,
        density_kg_m3=of_ropes([rope.mass_kg_m for rope in scene.rope]) / (0.25 * np.pi * diameter**2),
        is_rope=True,
    )
    drags = [drag(*rope.drag) for rope in scene.rope]
    net = replace(
        net,
        bar_drag_law=np.repeat(np.array([law for law, _, _ in drags], dtype=np.int32), counts),
        bar_normal_drag=of_ropes([normal for _, normal, _ in drags]),
        bar_tangential_drag=of_ropes([tangential for _, _, tangential in drags]),
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
    towed = np.zeros(len(laid), dtype=bool)
    towed[[node_of[p.name] for p in scene.point if p.held == "vessel"]] = True
    if scene.vessel is not None:
        towed[node_of[VESSEL]] = True
    return BuiltScene(
        scene,
        Problem.of(net, water=_water(scene), seabed=_seabed(scene, net)),
        node_of,
        tuple(rope_nodes),
        tuple(rope_bars),
        of_ropes([rope.added_mass for rope in scene.rope]),
        towed,
    )


def _places(scene: Scene) -> dict[str, Floats]:
    """Where every point starts: where it is told, or astern of what it hangs on, in a line at the same height."""
    found = {} if scene.vessel is None else {VESSEL: np.array(scene.vessel.at, dtype=float)}
    found |= {point.name: np.array(point.at, dtype=float) for point in scene.point if point.at is not None}
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
    u = np.linspace(0.0, 1.0, count + 1)[:, None]
    # a shallow parabola of depth h is longer than its chord by 8 h^2 / 3 c
    sag = np.sqrt(max(3.0 / 16.0 * (length**2 - apart**2), 0.0))
    side = np.array([0.6, 0.0, -0.8])
    if apart > 0.0:
        side -= (side @ chord) / apart**2 * chord
    size = float(np.linalg.norm(side))
    side = side / size if size > 0.1 else np.array([0.8, 0.0, 0.6])
    laid: Floats = first + u * chord + 4.0 * sag * u * (1.0 - u) * side
    return laid


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
