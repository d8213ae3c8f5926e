"""A scene's frame as a rigid body of its net, and its ballast as weights at the net's nodes."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.body import MARKER_M, UP, Body, Prism, cross
from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import Floats, Net, with_point
from codend.netting.sheet import EDGES
from codend.scenes.frame_tables import BallastTable, FloatTable, FrameTable
from codend.scenes.netting_tables import SheetTable

Counts = NDArray[np.int64]


def markers(frame: FrameTable) -> Floats:
    """Places of the two nodes that tell how the frame is turned, (2, 3)."""
    return np.array(frame.at) + MARKER_M * np.eye(3)[:2]


def prism_of(table: FloatTable, frame: FrameTable) -> Prism:
    """A float seen from the frame's origin."""
    foot = np.subtract(table.at, frame.at)
    if table.diameter_m is not None:
        return Prism(foot, table.height_m, diameter_m=table.diameter_m)
    return Prism(foot, table.height_m, sides_m=(table.length_m or 0.0, table.width_m or 0.0))


def body_of(
    frame: FrameTable, floats: Sequence[FloatTable], nodes: Counts, positions: Floats, water_density: float
) -> Body:
    """The frame with its floats as one body.

    Args:
        frame: what the user said.
        floats: its floats.
        nodes: of the net that go with it, its origin and its two markers first, (k,).
        positions: of all nodes, (n, 3).
        water_density: kg/m3.
    """
    prisms = [prism_of(table, frame) for table in floats]
    columns = [prism.columns() for prism in prisms] or [(np.zeros((0, 3)), np.zeros(0), np.zeros(0))]
    own = frame.at if frame.centre is None else frame.centre
    masses = np.array([frame.mass_kg, *(table.mass_kg for table in floats)])
    middles = np.array([np.subtract(own, frame.at), *(p.foot + 0.5 * p.height_m * UP for p in prisms)])
    inertias = [np.diag(frame.inertia_kg_m2)]
    inertias += [p.inertia(table.mass_kg) for p, table in zip(prisms, floats, strict=True)]
    mass = float(masses.sum())
    centre = masses @ middles / mass if mass > 0.0 else np.subtract(own, frame.at).astype(float)
    away = cross(middles - centre)
    inertia = np.sum(inertias, axis=0) - np.einsum("k,kij,kjl->il", masses, away, away)
    return Body(
        nodes=nodes.astype(np.int32),
        arms=positions[nodes] - np.array(frame.at),
        mass_kg=mass,
        centre=centre,
        inertia=inertia,
        added_mass=np.array(frame.added_mass_kg, dtype=float),
        added_inertia=np.array(frame.added_inertia_kg_m2, dtype=float),
        column_foot=np.concatenate([part[0] for part in columns]),
        column_height=np.concatenate([part[1] for part in columns]),
        column_area=np.concatenate([part[2] for part in columns]),
        water_density=water_density,
    )


def ballasted(
    net: Net,
    ballast: BallastTable,
    node_of: Mapping[str, int],
    sheets: Sequence[SheetTable],
    sheet_nodes: Sequence[Counts],
    water_density: float,
) -> Net:
    """The net with its ballast, which nodes share as its table says."""
    wet = ballast.wet_weight_n
    if ballast.density_kg_m3 is not None:
        wet = ballast.mass_kg * GRAVITY_M_S2 * (1.0 - water_density / ballast.density_kg_m3)
    assert wet is not None
    share = np.zeros(len(net.positions))
    for name in ballast.points or ():
        share[node_of[name]] += 1.0
    number = {sheet.name: index for index, sheet in enumerate(sheets)}
    for edge in ballast.edges or ():
        of, _, side = edge.rpartition(".")
        table, nodes = sheets[number[of]], sheet_nodes[number[of]]
        which = next(e for e in EDGES if e == side)
        on = table.sheet.edges[which]
        apart = np.diff(on.place)
        half = 0.5 * (np.concatenate([[0.0], apart]) + np.concatenate([apart, [0.0]]))
        np.add.at(share, nodes[on.knots], table.reach_m(which) * half)
    share /= share.sum()
    for node in np.flatnonzero(share):
        part = float(share[node])
        net = with_point(net, int(node), mass_kg=part * ballast.mass_kg, wet_weight_n=part * wet)
    return net
