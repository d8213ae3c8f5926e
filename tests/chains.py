"""Hanging chains of bars, built by hand: nets of one column whose motion has closed forms."""

import numpy as np

from codend.loads import wet_weight
from codend.mechanics.arrays import FILLED_MESHES, LE_BRIS_1999, Loading, structure_of
from codend.net import Net
from codend.problem import Problem

DIAMETER_M, DENSITY_KG_M3 = 0.01, 3000.0
MASS_PER_METRE = DENSITY_KG_M3 * np.pi * DIAMETER_M**2 / 4
GRAVITY_M_S2 = 9.80665


def chain(
    positions: np.ndarray, *, held: int = 1, water: float = 0.0, normal: float = 0.0, speed: float = 0.0
) -> Problem:
    """A chain through ``positions`` (n, 3), its first ``held`` nodes fixed, under its weight in water."""
    nodes = len(positions)
    bars = nodes - 1
    count = np.arange(nodes, dtype=np.int32)
    none = np.zeros((0, 3), dtype=np.int32)
    net = Net(
        positions=np.array(positions, dtype=float),
        order=1,
        fixed=np.repeat((count < held)[:, None], 3, axis=1),
        node_row=count,
        bars=np.stack([count[:-1], count[1:]], axis=1),
        bar_image=np.zeros(bars, dtype=np.int32),
        bar_length=np.linalg.norm(np.diff(positions, axis=0), axis=1),
        bar_flexibility=np.zeros(bars),
        bar_drag_diameter=np.full(bars, DIAMETER_M),
        bar_solid_diameter=np.full(bars, DIAMETER_M),
        bar_density=np.full(bars, DENSITY_KG_M3),
        bar_band=count[:-1],
        facets=none,
        facet_image=none,
        facet_weight=np.zeros(0),
        facet_band=np.zeros(0, dtype=np.int32),
        mesh_sides=np.zeros((0, 4, 2), dtype=np.int32),
        mesh_side_image=np.zeros((0, 4, 2), dtype=np.int32),
        mesh_bars=np.zeros((0, 4), dtype=np.int32),
        mesh_row=np.zeros(0, dtype=np.int32),
        band_meshes=np.ones(bars),
        corners=none,
        corner_image=none,
        corner_stiffness=np.zeros(0),
        corner_rest=np.zeros(0),
    )
    loading = Loading(
        dead=wet_weight(net, water),
        speed=speed,
        density=water,
        drag_law=LE_BRIS_1999,
        normal=normal,
        tangential=0.07,
        stagnation_pressure=0.0,
        angles=np.array([0.0, np.pi]),
        coefficients=np.zeros((4, 1)),
        catch_kind=FILLED_MESHES,
        catch_value=0.0,
    )
    return Problem(net, structure_of(net), loading)


def pendulum(angle: float, length: float = 1.0, **options: float) -> Problem:
    """One bar turned by ``angle`` from the vertical in the x-z plane."""
    return chain(np.array([[0.0, 0.0, 0.0], [length * np.sin(angle), 0.0, -length * np.cos(angle)]]), **options)  # type: ignore[arg-type]


def hanging(bars: int, length: float = 1.0, displacement: np.ndarray | None = None) -> np.ndarray:
    """Nodes of a chain of ``bars`` equal bars hung from the origin, moved along x by ``displacement``, (bars + 1,)."""
    x = np.zeros(bars + 1) if displacement is None else displacement
    drop = np.sqrt((length / bars) ** 2 - np.diff(x) ** 2)
    return np.stack([x, np.zeros(bars + 1), -np.concatenate([[0.0], np.cumsum(drop)])], axis=1)


def small_swings(bars: int, length: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, rad/s, and modes of the chain's masses: half a bar at its free end, a bar at every other node."""
    from scipy.linalg import eigh

    b = length / bars
    mass = MASS_PER_METRE * b * np.append(np.ones(bars - 1), 0.5)
    pull = GRAVITY_M_S2 * np.cumsum(mass[::-1])[::-1] / b
    stiffness = np.diag(pull + np.append(pull[1:], 0.0)) - np.diag(pull[1:], 1) - np.diag(pull[1:], -1)
    squares, modes = eigh(stiffness, np.diag(mass))
    return np.sqrt(squares), np.concatenate([np.zeros((1, bars)), modes / modes[-1]])
