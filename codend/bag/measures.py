"""Equilibrium to measures: openings, opening forces, drag, volume, and the balance of forces.

Everything is stated for the real netting: tensions of a globalised net are divided by its globalisation.
"""

from dataclasses import dataclass, fields

import numpy as np

from codend.bag.bag import Bag, real_tensions
from codend.bag.bag_kernels import ROWS_AHEAD, empty_sums, measure_bag, meshes_of, rows_of
from codend.bag.estimate_kernels import Estimated, estimated, estimated_and_changed
from codend.bag.measure_kernels import WANTED_OPENING_DEG, opening_force, rows_ahead, write_openings
from codend.mechanics.pressure import Catch
from codend.mechanics.problem import Problem
from codend.mechanics.structure import Structure
from codend.mechanics.water import Water
from codend.net.net import Floats
from codend.solvers.outcome import Solution


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
    """What the entry's reactions leave of the loads across the axis and as a moment; see
    ``measure_kernels.sideways_imbalance``."""
    codline_aside_m: float
    """Distance of the codline from the axis through the middle of the entry, along the tow; 0 of sectors.

    A window that is shorter or wider than the netting about it bends the bag aside, a long extension ahead of it by
    metres, and weight lets it sag."""

    @property
    def estimated(self) -> Floats:
        """What error estimates stand beside: drag, catch volume, largest radius and opening ahead, (4,)."""
        return np.array([self.drag_n, self.catch_volume_m3, self.max_radius_m, self.opening_ahead_deg])

    @classmethod
    def unknown(cls) -> "Measures":
        """All nan: of a case that was not solved."""
        return _NOT_MEASURED


_NOT_MEASURED = Measures(*(float("nan") for _ in fields(Measures)))


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


def mesh_opening_force(
    bag: Bag, bar_tension_n: Floats, opening_deg: Floats, wanted_deg: float = WANTED_OPENING_DEG
) -> Floats:
    """``opening_force`` of the meshes of a bag, whose real tensions and openings are given, (k,)."""
    return np.asarray(opening_force(bar_tension_n, opening_deg, wanted_deg, bag.mesh_bending_n, bag.mesh_rest_rad))


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
    catch = problem.loading.catch
    return Meshes(*meshes_of(bag.structure, _positions(solution), solution.bar_tension, solution.share, catch))


def measure_rows(bag: Bag, problem: Problem, solution: Solution, meshes: Meshes) -> Rows:
    """Means over every row of knots; of meshes those of windows are left out."""
    tension, catch = real_tensions(bag, solution.bar_tension), problem.loading.catch
    of_meshes = meshes.opening_deg, meshes.opening_force_n
    return Rows(*rows_of(bag.structure, _positions(solution), tension, solution.share, catch, *of_meshes))


def measure_briefly(bag: Bag, problem: Problem, solution: Solution) -> Estimated:
    """Of ``Measures`` the drag, the catch's volume, the largest radius and the opening ahead."""
    return estimated(bag.structure, *_in_water(problem), _positions(solution), solution.share)


def measure_with_changed(
    bag: Bag, problem: Problem, solution: Solution, coefficients: Floats, positions: Floats
) -> tuple[Estimated, float]:
    """The same, and the drag with other coefficients of the pressure law, (4, k), in the shape that it has then, N."""
    loads, changed = _in_water(problem), problem.loading.catch._replace(coefficients=coefficients)
    at = _positions(solution), solution.share
    return estimated_and_changed(bag.structure, *loads, *at, changed, positions)


def _in_water(problem: Problem) -> tuple[Structure, Water, Catch]:
    return problem.structure, problem.loading.water, problem.loading.catch


def measure_all(bag: Bag, problem: Problem, solution: Solution) -> tuple[Meshes, Rows, Measures]:
    """Meshes, rows and sums of a solved bag."""
    loads, sums = (problem.structure, problem.loading, problem.rings), empty_sums()
    tensions = solution.bar_tension, real_tensions(bag, solution.bar_tension)
    meshes, rows = measure_bag(bag.structure, *loads, _positions(solution), *tensions, solution.share, sums)
    return Meshes(*meshes), Rows(*rows), Measures(*sums[0].item())


def opening_rows_ahead(bag: Bag, share: Floats) -> Floats:
    """Middles of the five real mesh rows just ahead of the front, or as many as there are, in meshes from the entry."""
    return np.asarray(rows_ahead(share, bag.band_meshes, bag.globalisation, ROWS_AHEAD))


def _positions(solution: Solution) -> Floats:
    return np.ascontiguousarray(solution.positions)
