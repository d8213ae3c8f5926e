"""A bag put together: its netting as laid out, with the properties of each section's twine."""

from collections.abc import Callable, Sequence
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.net.net import NO_POINTS, Floats, Ints, Net
from codend.netting.lattice import Lattice
from codend.netting.parts import Layout
from codend.netting.windows import LetIn
from codend.plan.tables import Netting


def assembled(
    layout: Layout,
    lattice: Lattice,
    positions: Floats,
    node_row: Ints,
    entry: NDArray,
    drag: tuple[int, float, float],
    windows: Sequence[LetIn] = (),
) -> Bag:
    """Bag with the properties of its bars, held at the entry and nowhere else.

    Only the symmetry of a sector keeps its codline on the axis.

    ``drag`` is the law of the twine's drag and its coefficients, as ``drag_laws.drag`` gives them. Windows have parts
    of their own, in the bands of the netting that they are let into, and the properties of their own netting.
    """
    law, normal, tangential = drag
    g = lattice.globalisation
    band, is_knot = layout.bar_band, layout.bar_is_knot
    nettings = [*lattice.distinct, *(window.netting for window in windows)]
    # of every band, then of every window; and of every bar
    number = np.append(lattice.number, len(lattice.distinct) + np.arange(len(windows)))
    of_bar = number[np.where(layout.bar_piece >= 0, lattice.bands + layout.bar_piece, band)]

    def of_all(value: Callable[[Netting], float | bool]) -> NDArray:
        """A value of every band's section, and then of every window."""
        return np.array([value(netting) for netting in nettings])[number]

    def of_bars(value: Callable[[Netting], float | bool]) -> NDArray:
        return np.array([value(netting) for netting in nettings])[of_bar]

    def of_section(value: str) -> Floats:
        return np.asarray(of_bars(attrgetter(value)), dtype=np.float64)

    def softness(of: str) -> Floats:
        """Strain per newton of the (merged) bars or knots, 0 where they do not stretch."""

        def of_one(section: Netting) -> float:
            stiffness = getattr(section, of)
            return 0.0 if stiffness is None else 1.0 / (g * stiffness)

        return of_bars(of_one)

    around = lattice.order * lattice.columns[layout.facet_band]
    count = len(node_row)
    fixed = np.zeros((count, 3), dtype=bool)
    fixed[entry] = True
    fixed[layout.codline, 1:] = lattice.order > 1
    corners = layout.corners
    # where twines of two nettings meet, either bends as it does
    stiffness = of_all(lambda section: 12.0 * section.bending_stiffness_n_m2 / section.bar_m)
    clamped = stiffness[corners[:, 6:8]].mean(axis=1)
    # two twines gathered at the codline have no angle between them
    resists = (clamped > 0.0) & ((corners[:, 1] != corners[:, 2]) | (corners[:, 4] != corners[:, 5]))
    corners, clamped = corners[resists], clamped[resists]
    at_rest = of_all(lambda section: 2.0 * section.rest_half_angle_rad)[corners[:, 6:8]].mean(axis=1)
    net = Net(
        positions=positions,
        order=lattice.order,
        fixed=fixed,
        bars=layout.bars,
        bar_image=layout.bar_image,
        bar_length=lattice.merged[band] * np.where(is_knot, of_section("knot_m"), of_section("bar_m")),
        bar_flexibility=np.where(is_knot, softness("knot_axial_stiffness_n"), softness("axial_stiffness_n")),
        bar_drag_diameter=np.where(is_knot, 0.0, g * of_section("drag_width_m")),
        bar_solid_diameter=np.sqrt(g) * of_section("solid_diameter_m"),
        bar_density=of_bars(lambda s: np.nan if s.density_kg_m3 is None else s.density_kg_m3),
        bar_diameter=of_section("twine_m"),
        bar_drag_law=np.full(len(band), law, dtype=np.int32),
        bar_normal_drag=np.full(len(band), normal),
        bar_tangential_drag=np.full(len(band), tangential),
        bar_is_rope=np.zeros(len(band), dtype=bool),
        bar_is_strut=is_knot & of_bars(lambda section: section.knot_compression).astype(bool),
        facets=layout.facets,
        facet_image=layout.facet_image,
        facet_weight=layout.facet_weight * np.asarray(_polygon_area(g * around) / _polygon_area(around)),
        corners=corners[:, :3].astype(np.int32),
        corner_image=corners[:, 3:6].astype(np.int32),
        corner_stiffness=g**2 * clamped,
        corner_rest=np.where(corners[:, 8] == 1, np.pi - at_rest, at_rest),
        **NO_POINTS,
    )
    return Bag(
        net=net,
        node_row=node_row,
        bar_band=band,
        bar_is_twine=~is_knot,
        facet_band=layout.facet_band,
        band_meshes=lattice.merged / lattice.of_bands(lambda section: section.rows_per_mesh),
        band_kind=tuple(lattice.of_bands(lambda section: section.kind)),
        band_bending_n=lattice.of_bands(lambda section: section.bending_n),
        band_rest_rad=lattice.of_bands(lambda section: section.rest_half_angle_rad),
        mesh_sides=layout.mesh_sides,
        mesh_side_image=layout.mesh_side_image,
        mesh_bars=layout.mesh_bars,
        mesh_row=layout.mesh_row,
        globalisation=g,
        windows=tuple(window.netting for window in windows),
        bar_window=layout.bar_piece,
        mesh_window=layout.mesh_piece,
    )


def _polygon_area(corners: NDArray[np.floating]) -> Floats:
    """Area of a regular polygon over that of the circle through its corners.

    A globalised net is an inscribed polygon of too few corners; at the same radius, pressure on it falls short in this
    ratio along the axis and across it, and so does its volume. Its facets are weighted to make up for that. Where two
    sections meet, their weights differ, which leaves an error of the order of what the weights make up for.
    """
    return np.asarray(np.sinc(2.0 / corners))
