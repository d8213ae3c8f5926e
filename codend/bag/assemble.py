"""A bag put together: its netting as laid out, with the properties of each section's twine."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.net.net import NO_CORNERS, NO_POINTS, Floats, Ints, Net
from codend.netting.lattice import Counts, Lattice
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
    nettings = [*lattice.sections, *(window.netting for window in windows)]
    # of every band, then of every window; and of every bar
    number = np.append(lattice.number, len(lattice.sections) + np.arange(len(windows)))
    of_bar = number[np.where(layout.bar_piece >= 0, lattice.bands + layout.bar_piece, band)]
    of_bars = np.array([_twine(netting, g) for netting in nettings] + [_knot(netting, g) for netting in nettings])
    length, *properties = np.take(of_bars.T, of_bar + len(nettings) * is_knot, axis=1)
    flexibility, drag_diameter, solid_diameter, density, diameter, is_strut = properties
    fixed = np.zeros((len(node_row), 3), dtype=bool)
    fixed[entry] = True
    fixed[layout.codline, 1:] = lattice.order > 1
    net = Net(
        positions=positions,
        order=lattice.order,
        fixed=fixed,
        bars=layout.bars,
        bar_image=layout.bar_image,
        bar_length=lattice.merged[band] * length,
        bar_flexibility=flexibility,
        bar_drag_diameter=drag_diameter,
        bar_solid_diameter=solid_diameter,
        bar_density=density,
        bar_diameter=diameter,
        bar_drag_law=np.full(len(band), law, dtype=np.int32),
        bar_normal_drag=np.full(len(band), normal),
        bar_tangential_drag=np.full(len(band), tangential),
        bar_is_rope=np.zeros(len(band), dtype=bool),
        bar_is_strut=is_strut > 0.0,
        facets=layout.facets,
        facet_image=layout.facet_image,
        facet_weight=_facet_weight(layout, lattice),
        **_stiff_corners(layout, number, nettings, g),
        **NO_POINTS,
    )
    return Bag(
        net=net,
        node_row=node_row,
        bar_band=band,
        bar_is_twine=~is_knot,
        facet_band=layout.facet_band,
        band_meshes=lattice.merged / lattice.of_bands(lambda section: section.rows_per_mesh),
        sections=lattice.sections,
        band_section=lattice.number,
        mesh_sides=layout.mesh_sides,
        mesh_side_image=layout.mesh_side_image,
        mesh_bars=layout.mesh_bars,
        mesh_row=layout.mesh_row,
        globalisation=g,
        abreast=lattice.abreast,
        windows=tuple(window.netting for window in windows),
        bar_window=layout.bar_piece,
        mesh_window=layout.mesh_piece,
    )


def _twine(section: Netting, globalisation: float) -> tuple[float, ...]:
    """Length of a bar of one row, flexibility, both diameters, density, real diameter, and whether it is a strut."""
    return (
        section.bar_m,
        _softness(section.axial_stiffness_n, globalisation),
        globalisation * section.drag_width_m,
        *_of_material(section, globalisation),
        False,
    )


def _knot(section: Netting, globalisation: float) -> tuple[float, ...]:
    """The same of a knot, which carries no drag."""
    return (
        section.knot_m,
        _softness(section.knot_axial_stiffness_n, globalisation),
        0.0,
        *_of_material(section, globalisation),
        section.knot_compression,
    )


def _of_material(section: Netting, globalisation: float) -> tuple[float, float, float]:
    density = section.density_kg_m3
    solid_diameter_m = math.sqrt(globalisation) * section.solid_diameter_m
    return solid_diameter_m, math.nan if density is None else density, section.twine_m


def _softness(stiffness_n: float | None, globalisation: float) -> float:
    """Strain per newton of (merged) bars or knots, 0 where they do not stretch."""
    return 0.0 if stiffness_n is None else 1.0 / (globalisation * stiffness_n)


def _facet_weight(layout: Layout, lattice: Lattice) -> Floats:
    """Weights of the facets, those of merged meshes made up for what their polygons lack."""
    if lattice.globalisation == 1:
        return layout.facet_weight
    around = lattice.order * lattice.columns
    made_up = _polygon_area(lattice.globalisation * around) / _polygon_area(around)
    return np.asarray(layout.facet_weight * made_up[layout.facet_band])


def _stiff_corners(layout: Layout, number: Counts, nettings: Sequence[Netting], globalisation: float) -> dict[str, Any]:
    """Fields of the corners between twines that resist opening; ``number`` is that of the netting of a band or piece.

    Where twines of two nettings meet, either bends as it does.
    """
    if not any(netting.bending_stiffness_n_m2 for netting in nettings):
        return NO_CORNERS

    def mean(of_netting: list[float]) -> Floats:
        """Mean over both twines of what their netting has, (c,)."""
        return np.asarray(np.array(of_netting)[number][layout.corners[:, 6:8]].mean(axis=1))

    stiffness = mean([12.0 * netting.bending_stiffness_n_m2 / netting.bar_m for netting in nettings])
    at_rest = mean([2.0 * netting.rest_half_angle_rad for netting in nettings])
    corners = layout.corners
    # two twines gathered at the codline have no angle between them
    resists = (stiffness > 0.0) & ((corners[:, 1] != corners[:, 2]) | (corners[:, 4] != corners[:, 5]))
    corners, at_rest = corners[resists], at_rest[resists]
    return {
        "corners": corners[:, :3].astype(np.int32),
        "corner_image": corners[:, 3:6].astype(np.int32),
        "corner_stiffness": globalisation**2 * stiffness[resists],
        "corner_rest": np.where(corners[:, 8] == 1, np.pi - at_rest, at_rest),
    }


def _polygon_area(corners: NDArray[np.floating]) -> Floats:
    """Area of a regular polygon over that of the circle through its corners.

    A globalised net is an inscribed polygon of too few corners; at the same radius, pressure on it falls short in this
    ratio along the axis and across it, and so does its volume. Its facets are weighted to make up for that. Where two
    sections meet, their weights differ, which leaves an error of the order of what the weights make up for.
    """
    return np.asarray(np.sinc(2.0 / corners))
