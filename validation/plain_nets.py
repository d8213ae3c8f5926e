"""Nets written by hand, without a plan: bars and facets between given nodes, in a current and under pressure."""

from dataclasses import replace

import numpy as np

from catch_models.pressure import PressureLaw, uniform_law
from codend.mechanics.drag_laws import LE_BRIS_1999
from codend.mechanics.pressure import FILLED_MESHES, Catch
from codend.mechanics.problem import Problem
from codend.mechanics.water import uniform_flow
from codend.net.net import Floats, Net


def plain_net(
    positions: Floats,
    fixed: np.ndarray,
    bars: np.ndarray,
    bar_length: Floats,
    *,
    stiffness: float = np.inf,
    diameter: float = 0.0,
    density: float = np.nan,
    facets: np.ndarray | None = None,
    facet_weight: float = 1.0,
) -> Net:
    """A full net of equal twine.

    Args:
        positions: nodes in the shape in which a solver starts, (n, 3).
        fixed: coordinates that are held, (n, 3).
        bars: first and second node, (m, 2).
        bar_length: without load, m, (m,).
        stiffness: EA of a bar, N.
        diameter: of the round twine, m; 0 for twine without drag or weight.
        density: of the twine, kg/m3; nan if it is that of the water.
        facets: corners, seen anticlockwise from outside, (f, 3); none by default.
        facet_weight: see ``Net.facet_weight``.
    """
    net = Net.from_bars(
        positions, bars, fixed, length_m=bar_length, stiffness_n=stiffness, diameter_m=diameter,
        density_kg_m3=density, facets=facets,
    )  # fmt: skip
    return replace(net, facet_weight=np.full(len(net.facets), facet_weight))


def plain_problem(
    net: Net,
    node_row: np.ndarray,
    *,
    water: float = 0.0,
    speed: float = 0.0,
    normal: float = 0.0,
    tangential: float = 0.0,
    drag_law: int = LE_BRIS_1999,
    pressure_law: PressureLaw | None = None,
    stagnation_pressure: float = 0.0,
    filled: float = 0.0,
) -> Problem:
    """A net under its weight in water, the drag of a current along x and the pressure of a catch.

    A bar or facet lies in the band aft of the lowest row it touches.

    Args:
        net: the net.
        node_row: row of every node, from 0, (n,).
        water: density of the water, kg/m3; 0 for none.
        speed: of the current, m/s.
        normal: drag coefficient Cd of the twine.
        tangential: f or Cf, as ``drag_law`` has it (see ``codend.mechanics.drag_laws``).
        drag_law: ``LE_BRIS_1999`` or ``BESSONNEAU_1997``.
        pressure_law: of the catch.
        stagnation_pressure: that the law is multiplied with, Pa.
        filled: bands that lie in the catch, counted from the last.
    """
    law = pressure_law or uniform_law()
    node_row = node_row.astype(np.int32)
    bands = int(max(node_row.max(), 1))

    def band_of(parts: np.ndarray) -> np.ndarray:
        return np.minimum(node_row[parts].min(axis=1, initial=bands), bands - 1).astype(np.int32)

    catch = Catch(
        bar_band=band_of(net.bars),
        facet_band=band_of(net.facets),
        band_meshes=np.ones(bands),
        node_row=node_row,
        row_size=np.bincount(node_row, minlength=bands + 1).astype(np.float64),
        kind=FILLED_MESHES,
        size=float(filled),
        stagnation_pressure=stagnation_pressure,
        angles=law.angles_rad,
        coefficients=law.coefficients,
    )
    count = len(net.bars)
    dragged = replace(
        net,
        bar_drag_law=np.full(count, drag_law, dtype=np.int32),
        bar_normal_drag=np.full(count, normal),
        bar_tangential_drag=np.full(count, tangential),
    )
    return Problem.of(dragged, water=uniform_flow(water, np.array([speed, 0.0, 0.0])), catch=catch)
