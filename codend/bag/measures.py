"""Equilibrium to measures: openings, opening forces, drag, volume, and the balance of forces.

Everything is stated for the real netting: tensions of a globalised net are divided by its globalisation.
"""

from dataclasses import dataclass, fields

import numpy as np

from codend.bag.bag import Bag, mesh_corners, real_tensions
from codend.bag.measure_kernels import (
    add_current_loads,
    catch_volume,
    mean_by,
    mean_over,
    net_pressures,
    rows_ahead,
    write_openings,
)
from codend.bag.supports import held_by_the_entry, sideways_imbalance
from codend.mechanics import catch_weight
from codend.mechanics.crossing import band_turns
from codend.mechanics.possible import inward_share
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.solvers.outcome import Solution
from codend.solvers.reactions import loads_and_supports

WANTED_OPENING_DEG = 30.0
"""Opening to which the opening force brings a mesh (Le Bris et al. 1999, figure 11)."""
ROWS_AHEAD = 5
"""Mesh rows ahead of the catch over which ``opening_ahead_deg`` is the mean."""


@dataclass(frozen=True)
class Measures:
    """Numbers of one case; the names are those of the columns of ``results.csv``."""

    filled_meshes: float
    catch_volume_m3: float
    front_radius_m: float
    front_from_codline_m: float
    max_radius_m: float
    length_m: float
    drag_n: float
    catch_drag_n: float
    twine_drag_n: float
    entry_reaction_n: float
    opening_ahead_deg: float
    opening_force_ahead_n: float
    opening_ahead_spread_deg: float
    """Standard deviation round the ring of the openings in the rows ahead, about the means of their rows."""
    opening_ahead_least_deg: float
    opening_ahead_most_deg: float
    max_bar_tension_n: float
    max_strap_tension_n: float
    """nan where there is no strap."""
    max_rope_tension_n: float
    """nan where there is no rope along the netting."""
    folded_share: float
    """Share of the netting on the catch that faces inward (``possible.inward_share``).

    Netting to spare can lie in folds, as twine gathered at a codline does: the pressure on the layers of a fold is
    right in sum, for one of three faces inward, but not layer by layer."""
    turn_deg: float
    """By how much the bag is turned about its axis from the entry to the codline, summed over the bands."""
    sideways_imbalance: float
    """What the entry's reactions leave of the loads across the axis and as a moment; see ``sideways_imbalance``."""

    @property
    def estimated(self) -> Floats:
        """What error estimates stand beside: drag, catch volume, largest radius and opening ahead, (4,)."""
        return np.array([self.drag_n, self.catch_volume_m3, self.max_radius_m, self.opening_ahead_deg])

    @classmethod
    def unknown(cls) -> "Measures":
        """All nan: of a case that was not solved."""
        return cls(*(float("nan") for _ in fields(cls)))


@dataclass(frozen=True)
class Rows:
    """Means over the knots or meshes of every row, from the entry, row 0, to the codline; arrays (rows + 1,)."""

    x_m: Floats
    radius_m: Floats
    opening_deg: Floats
    """nan at rows that have no whole mesh."""
    bar_tension_n: Floats
    opening_force_n: Floats
    pressure_pa: Floats


@dataclass(frozen=True)
class Meshes:
    """Every mesh of the model, arrays (k,) but ``centre_m`` (k, 3)."""

    centre_m: Floats
    opening_deg: Floats
    bar_tension_n: Floats
    opening_force_n: Floats
    pressure_pa: Floats


def opening_force(
    bar_tension_n: Floats,
    opening_deg: Floats,
    wanted_deg: float = WANTED_OPENING_DEG,
    bending_n: Floats | float = 0.0,
    rest_rad: Floats | float = 0.0,
) -> Floats:
    """Extra pull across the short diagonal that brings an isolated mesh to the wanted opening, N.

    F = P (tan phi' - tan phi) + B ((phi' - phi0) / cos phi' - (phi - phi0) / cos phi), P = 2 T cos phi - B (phi - phi0)
    sin phi the load along the netting that a mesh carries, phi half its opening, phi' half the wanted one, phi0 half
    that at rest and B = 24 EI / b^2: derived from the equilibrium of a rhombus of four clamped bars. Zero or less once
    the mesh is open that far.
    """
    half, wanted, bending = np.radians(opening_deg) / 2.0, np.radians(wanted_deg) / 2.0, np.asarray(bending_n)
    along = 2.0 * bar_tension_n * np.cos(half) - bending * (half - rest_rad) * np.sin(half)
    bent = (wanted - rest_rad) / np.cos(wanted) - (half - rest_rad) / np.cos(half)
    return np.asarray(along * (np.tan(wanted) - np.tan(half)) + bending * bent)


def mesh_opening_force(
    bag: Bag, bar_tension_n: Floats, opening_deg: Floats, wanted_deg: float = WANTED_OPENING_DEG
) -> Floats:
    """``opening_force`` of the meshes of a bag, whose real tensions and openings are given, (k,)."""
    return opening_force(bar_tension_n, opening_deg, wanted_deg, bag.mesh_bending_n, bag.mesh_rest_rad)


def mesh_openings(bag: Bag, corners: Floats) -> tuple[Floats, Floats]:
    """Opening angles in degrees (k,) and outward normals (k, 3) of the meshes of a bag, by their ``mesh_corners``.

    The opening is 2 atan(transverse / longitudinal diagonal), both taken over the twine only, without the knots. In
    meshes that are folded over their widest part by a strap, the longitudinal one is taken along the netting: their
    twines are as far apart as if it lay flat. A square mesh has its width over its length instead: 90 degrees open.
    """
    opening, normal = np.empty(len(corners)), np.empty((len(corners), 3))
    write_openings(corners, bag.mesh_is_staggered, bag.mesh_is_folded, opening, normal)
    return opening, normal


def measure_meshes(bag: Bag, problem: Problem, solution: Solution) -> Meshes:
    """Opening, tension, opening force and net pressure of every mesh of the model."""
    corners = mesh_corners(bag, solution.positions)
    opening, normal = mesh_openings(bag, corners)
    tension = mean_over(solution.bar_tension, bag.mesh_bars) / bag.globalisation
    ahead, behind = bag.mesh_bands
    filled = 0.5 * (solution.share[ahead] + solution.share[behind])
    centre = corners.mean(axis=(1, 2))
    by_water = net_pressures(normal[:, 0], np.hypot(normal[:, 1], normal[:, 2]), problem.loading.catch)
    return Meshes(
        centre_m=centre,
        opening_deg=opening,
        bar_tension_n=tension,
        opening_force_n=np.where(bag.mesh_opens, mesh_opening_force(bag, tension, opening), np.nan),
        pressure_pa=filled * (by_water + _pressure_by_weight(problem, solution, centre[:, 2])),
    )


def ring_middles(bag: Bag, positions: Floats) -> Floats:
    """Sideways positions of the middles of the rings of knots, (rows + 1, 2), m.

    The rings of a sector have their middles on the axis; those of a full net, which may sag, where their knots have.
    """
    if bag.net.order > 1:
        return np.zeros((bag.bands + 1, 2))
    return np.stack([mean_by(bag.node_row, positions[:, i], bag.bands + 1) for i in (1, 2)], axis=1)


def ring_radii(bag: Bag, positions: Floats) -> Floats:
    """Distances of the nodes from the middle of their ring, m, (n,); of those that belong to none it is no distance."""
    across = positions[:, 1:] - ring_middles(bag, positions)[bag.node_row]
    return np.hypot(across[:, 0], across[:, 1])


def ring_means(bag: Bag, positions: Floats) -> tuple[Floats, Floats]:
    """Mean place along the axis and mean radius of every ring of knots, each (rows + 1,), m."""
    x, radius = positions[:, 0], ring_radii(bag, positions)
    return mean_by(bag.node_row, x, bag.bands + 1), mean_by(bag.node_row, radius, bag.bands + 1)


def measure_rows(bag: Bag, problem: Problem, solution: Solution, meshes: Meshes) -> Rows:
    """Means over every row of knots; of meshes those of windows are left out."""
    own = bag.mesh_of_section
    x, r = ring_means(bag, solution.positions)
    by_band = mean_by(bag.twine_band, real_tensions(bag, solution.bar_tension), bag.bands)
    tension = 0.5 * (np.concatenate([by_band[:1], by_band]) + np.concatenate([by_band, by_band[-1:]]))
    filled = 0.5 * (np.concatenate([[0.0], solution.share]) + np.concatenate([solution.share, solution.share[-1:]]))
    by_water = net_pressures(-np.gradient(r), np.abs(np.gradient(x)), problem.loading.catch)
    by_weight = _pressure_by_weight(problem, solution, ring_middles(bag, solution.positions)[:, 1])
    return Rows(
        x_m=x,
        radius_m=r,
        opening_deg=mean_by(bag.mesh_row[own], meshes.opening_deg[own], bag.bands + 1),
        bar_tension_n=tension,
        opening_force_n=mean_by(bag.mesh_row[own], meshes.opening_force_n[own], bag.bands + 1),
        pressure_pa=filled * (by_water + by_weight),
    )


def current_loads(problem: Problem, solution: Solution) -> tuple[Floats, Floats]:
    """Forces on the nodes, N: the current's drag on the twine, and the pressure of the catch, each (n, 3)."""
    position = np.ascontiguousarray(solution.positions)
    on_twine, by_catch = np.zeros_like(position), np.zeros_like(position)
    add_current_loads(position, problem.structure, problem.loading, solution.share, on_twine, by_catch)
    return on_twine, by_catch


def measure(bag: Bag, problem: Problem, solution: Solution, rows: Rows, meshes: Meshes) -> Measures:
    """Drag, volume, sizes and openings of a solved net."""
    net, structure, loading = problem.net, problem.structure, problem.loading
    position, share = np.ascontiguousarray(solution.positions), solution.share
    twine_load, catch_load = current_loads(problem, solution)
    load, support = loads_and_supports(problem, solution)

    front = solution.front_row
    front_x = float(np.interp(front, np.arange(bag.bands + 1), rows.x_m))
    ahead = opening_rows_ahead(bag, share)
    has_mesh = np.flatnonzero(np.isfinite(rows.opening_deg))
    tension, straps = real_tensions(bag, solution.bar_tension), bag.straps
    openings, forces = (
        np.interp(ahead, bag.mesh_place[has_mesh], values[has_mesh])
        for values in (rows.opening_deg, rows.opening_force_n)
    )
    return Measures(
        filled_meshes=float(share @ bag.band_meshes),
        catch_volume_m3=catch_volume(position, structure, loading.catch, share),
        front_radius_m=float(np.interp(front, np.arange(bag.bands + 1), rows.radius_m)),
        front_from_codline_m=float(rows.x_m[-1] - front_x),
        max_radius_m=_largest_radius(bag, position),
        length_m=float(rows.x_m[-1] - rows.x_m[0]),
        drag_n=float((twine_load + catch_load)[:, 0].sum() * net.order),
        catch_drag_n=float(catch_load[:, 0].sum() * net.order),
        twine_drag_n=float(twine_load[:, 0].sum() * net.order),
        entry_reaction_n=float(-support[held_by_the_entry(bag), 0].sum() * net.order),
        opening_ahead_deg=float(np.mean(openings)) if len(ahead) else float("nan"),
        opening_force_ahead_n=float(np.mean(forces)) if len(ahead) else float("nan"),
        **_spread_ahead(bag, meshes, ahead),
        max_bar_tension_n=float(tension[bag.netting].max()),
        max_strap_tension_n=float(tension[straps].max()) if len(straps) else float("nan"),
        max_rope_tension_n=float(tension[bag.ropes].max()) if len(bag.ropes) else float("nan"),
        folded_share=inward_share(position, structure, loading.catch, share),
        turn_deg=float(np.degrees(band_turns(position, structure, loading.catch, problem.rings)[0].sum())),
        sideways_imbalance=sideways_imbalance(bag, position, load, support),
    )


def _spread_ahead(bag: Bag, meshes: Meshes, ahead: Floats) -> dict[str, float]:
    """How openings differ round the ring in the rows just ahead of the front; nan where ropes are smeared."""
    place = bag.mesh_place[bag.mesh_row]
    found = bag.mesh_of_section & np.isfinite(meshes.opening_deg)
    if len(ahead):
        found &= (place > ahead.min() - 0.5 + 1e-9) & (place < ahead.max() + 0.5 - 1e-9)
    names = ("opening_ahead_spread_deg", "opening_ahead_least_deg", "opening_ahead_most_deg")
    if len(ahead) == 0 or not found.any() or bag.smeared:
        return dict.fromkeys(names, float("nan"))
    openings, row = meshes.opening_deg[found], bag.mesh_row[found]
    about = openings - mean_by(row, openings, bag.bands + 1)[row]
    return dict(zip(names, map(float, (np.sqrt(np.mean(about**2)), openings.min(), openings.max())), strict=True))


def measure_briefly(bag: Bag, problem: Problem, solution: Solution) -> tuple[float, float, float, float]:
    """Of ``measure`` the drag, the catch's volume, the largest radius and the opening ahead, as it has them."""
    position, share = np.ascontiguousarray(solution.positions), solution.share
    own, openings = bag.mesh_of_section, mesh_openings(bag, mesh_corners(bag, position))[0]
    by_row = mean_by(bag.mesh_row[own], openings[own], bag.bands + 1)
    has_mesh = np.flatnonzero(np.isfinite(by_row))
    ahead = opening_rows_ahead(bag, share)
    middles = np.interp(ahead, bag.mesh_place[has_mesh], by_row[has_mesh])
    return (
        drag_of(problem, solution),
        catch_volume(position, problem.structure, problem.loading.catch, share),
        _largest_radius(bag, position),
        float(np.mean(middles)) if len(ahead) else float("nan"),
    )


def _largest_radius(bag: Bag, positions: Floats) -> float:
    return float(ring_radii(bag, positions)[bag.node_row >= 0].max())


def drag_of(problem: Problem, solution: Solution) -> float:
    """Drag of the whole net, N."""
    on_twine, by_catch = current_loads(problem, solution)
    return float((on_twine + by_catch)[:, 0].sum() * problem.net.order)


def measure_all(bag: Bag, problem: Problem, solution: Solution) -> tuple[Meshes, Rows, Measures]:
    """Meshes, rows and sums of a solved bag."""
    meshes = measure_meshes(bag, problem, solution)
    rows = measure_rows(bag, problem, solution, meshes)
    return meshes, rows, measure(bag, problem, solution, rows, meshes)


def opening_rows_ahead(bag: Bag, share: Floats) -> Floats:
    """Middles of the five real mesh rows just ahead of the front, or as many as there are, in meshes from the entry."""
    return rows_ahead(share, bag.band_meshes, bag.globalisation, ROWS_AHEAD)


def _pressure_by_weight(problem: Problem, solution: Solution, height: Floats) -> Floats:
    """What the catch's own weight adds at some heights, Pa."""
    catch = problem.loading.catch
    front = catch_weight.front_height(np.ascontiguousarray(solution.positions), catch, solution.share)
    return catch.weight_density * (front - height)
