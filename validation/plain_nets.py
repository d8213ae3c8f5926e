"""Nets written by hand, without a plan: bars and facets between given nodes, in a current and under pressure."""

import numpy as np

from catch_models.pressure import PressureLaw, uniform_law
from codend.bag.loads import wet_weight
from codend.mechanics.arrays import FILLED_MESHES, LE_BRIS_1999, Catch, Loading, structure_of
from codend.mechanics.problem import Problem
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
    count = len(bars)
    facets = np.zeros((0, 3), dtype=np.int32) if facets is None else facets.astype(np.int32)
    none = np.zeros((0, 3), dtype=np.int32)
    return Net(
        positions=np.array(positions, dtype=float),
        order=1,
        fixed=np.array(fixed, dtype=bool),
        bars=bars.astype(np.int32),
        bar_image=np.zeros(count, dtype=np.int32),
        bar_length=np.array(bar_length, dtype=float),
        bar_flexibility=np.full(count, 1.0 / stiffness),
        bar_drag_diameter=np.full(count, diameter),
        bar_solid_diameter=np.full(count, diameter),
        bar_density=np.full(count, density),
        bar_is_rope=np.zeros(count, dtype=bool),
        facets=facets,
        facet_image=np.zeros_like(facets),
        facet_weight=np.full(len(facets), facet_weight),
        corners=none,
        corner_image=none,
        corner_stiffness=np.zeros(0),
        corner_rest=np.zeros(0),
    )


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
        tangential: f or Cf, as ``drag_law`` has it (see ``codend.mechanics.drag``).
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
    loading = Loading(
        dead=wet_weight(net, water),
        speed=speed,
        density=water,
        drag_law=drag_law,
        normal=normal,
        tangential=tangential,
        catch=catch,
    )
    return Problem(net, structure_of(net), loading)
