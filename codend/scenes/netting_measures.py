"""What is told of the netting of a scene: its drag, weight and tensions, and how its meshes are open."""

from typing import Any

import numpy as np

from codend.mechanics import contact, drag
from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import Floats
from codend.scenes.build import BuiltScene
from codend.scenes.enclosure import enclosed_m3, openings


def netting_rows(built: BuiltScene, positions: Floats, bar_tension: Floats) -> list[dict[str, Any]]:
    """A row for every sheet, for ``netting.csv``; tensions are those of real bars, of which a bar stands for several.

    Args:
        built: the scene.
        positions: of its nodes, (n, 3), m.
        bar_tension: of the bars of the model, (m,), N.
    """
    net, water = built.problem.net, built.problem.loading.water
    rows = []
    for number, (table, nodes) in enumerate(zip(built.scene.netting, built.sheet_nodes, strict=True)):
        own = built.bar_sheet == number
        volume = (0.25 * np.pi * net.bar_solid_diameter**2 * net.bar_length)[own].sum()
        density = water.density if table.twine.density_kg_m3 is None else table.twine.density_kg_m3
        force, real = drag_of(built, positions, own), bar_tension[own] / built.bar_lines[own]
        met = built.speed_shares[number]
        openings = openings_deg(built, number, positions)
        rows.append(
            {
                "name": table.name,
                "bars": int(own.sum()),
                "twine_m": float((net.bar_length * built.bar_lines)[own].sum()),
                "twine_area_m2": float((net.bar_drag_diameter * net.bar_length)[own].sum()) / met**2 if met else np.nan,
                "mass_kg": float(density * volume),
                "wet_weight_n": float((density - water.density) * volume * GRAVITY_M_S2),
                "drag_n": float(force[0]),
                "side_force_n": float(force[1]),
                "lift_n": float(force[2]),
                "mean_bar_tension_n": float(real.mean()),
                "max_bar_tension_n": float(real.max()),
                "slack_share": float(np.mean(real <= 0.0)),
                "opening_deg": float(np.mean(openings)) if len(openings) else np.nan,
                "deepest_m": float(0.0 - positions[nodes, 2].min()),
                "law": table.drag[0],
                "speed_share": met,
            }
        )
    return rows


def drag_of(built: BuiltScene, positions: Floats, which: np.ndarray) -> Floats:
    """Force of the flow on the bars marked in ``which``, (m,), N, (3,)."""
    structure, loading = built.problem.structure, built.problem.loading
    own = structure._replace(drag_diameter=np.where(which, structure.drag_diameter, 0.0))
    force, share = np.zeros_like(positions), np.zeros(built.problem.bands)
    drag.add_force(np.ascontiguousarray(positions), np.empty((0, 3)), own, loading.water, loading.catch, share, force)
    return np.asarray(force.sum(axis=0))


def openings_deg(built: BuiltScene, number: int, positions: Floats) -> Floats:
    """Opening of the whole meshes of a sheet, by their diagonals; none of netting whose meshes do not open."""
    table = built.scene.netting[number]
    if not table.twine.kind.opens:
        return np.zeros(0)
    fore, right, aft, left = positions[built.sheet_nodes[number][table.sheet.meshes]].transpose(1, 0, 2)
    across, along = (np.linalg.norm(b - a, axis=1) for a, b in ((left, right), (fore, aft)))
    return np.asarray(np.degrees(2.0 * np.arctan2(across, along)))


def volume_m3(built: BuiltScene, positions: Floats) -> float:
    """Volume within netting that is open nowhere but where it is held or hangs on ropes; nan of other netting.

    Openings are closed by fans from their middles, which of one in a plane is that plane.
    """
    net = built.problem.net
    rim = np.array(net.fixed.all(axis=1))
    rim[np.concatenate([np.zeros(0, dtype=int), *built.rope_nodes])] = True
    loops = openings(net.facets, net.facet_weight)
    if not loops or not all(rim[loop].all() for loop in loops):
        return np.nan
    return enclosed_m3(net.facets, net.facet_weight, positions)


def contact_share(built: BuiltScene, positions: Floats) -> float:
    """Share of the knots of netting on which other netting or ropes press."""
    if not built.sheet_nodes:
        return 0.0
    push = np.zeros_like(positions)
    contact.add_force(np.ascontiguousarray(positions), built.problem.loading.contact, push)
    return float(np.mean(np.any(push[np.unique(np.concatenate(built.sheet_nodes))] != 0.0, axis=1)))


def netting_caution(built: BuiltScene) -> list[str]:
    """What a reader must know of how netting is modelled."""
    if not built.scene.netting:
        return []
    laws = " and ".join(sorted({table.drag[0] for table in built.scene.netting}))
    alone = (
        f"Drag of the netting by {laws}, of every bar as if it were alone: netting does not slow the water behind it"
    )
    behind = [
        f"{table.name} to {100.0 * share:.3g} %"
        for table, share in zip(built.scene.netting, built.speed_shares, strict=True)
        if table.shields
    ]
    return [f"{alone}, but by Løland (1993) that of {', '.join(behind)}." if behind else f"{alone}."]
