"""A bag put together: the parts of its netting as written, with the properties of each section's twine."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from codend.bag.bag import Bag
from codend.net.net import NO_POINTS, Floats, Ints, Net
from codend.netting.parts import Counts, Lattice, Parts
from codend.netting.windows import LetIn


def assembled(
    parts: Parts,
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
    bars, netting = _own_and_of_windows(parts.bars, 3, [window.bars for window in windows], lattice.bands)
    is_knot = bars[:, 4].astype(bool)
    band = bars[:, 3]

    # of each band, and of each window
    nettings = [*lattice.sections, *(window.netting for window in windows)]
    sections = {id(s): s for s in nettings}

    def of_section(value: str) -> Floats:
        values = {key: getattr(s, value) for key, s in sections.items()}  # many bands have one section
        return np.array([values[id(s)] for s in nettings], dtype=np.float64)[netting]

    def softness(of: str) -> Floats:
        """Strain per newton of the (merged) bars or knots, 0 where they do not stretch."""
        given = (getattr(s, of) for s in nettings)
        return np.array([0.0 if stiffness is None else 1.0 / (g * stiffness) for stiffness in given])[netting]

    facets, weight = parts.facet_table()
    for window in windows:
        facets = np.concatenate([facets, *window.facets])
        weight = np.concatenate([weight, *window.weights])
    around = lattice.order * lattice.columns[facets[:, 6]]
    weight *= _polygon_area(g * around) / _polygon_area(around)
    meshes, mesh_netting = _own_and_of_windows(parts.meshes, 16, [window.meshes for window in windows], lattice.bands)
    by_row = np.argsort(meshes[:, 16], kind="stable")
    meshes, mesh_netting = meshes[by_row], mesh_netting[by_row]
    count = len(node_row)
    fixed = np.zeros((count, 3), dtype=bool)
    fixed[entry] = True
    fixed[parts.codline, 1:] = lattice.order > 1
    corners = np.concatenate(parts.corners)
    clamped = np.array([12.0 * s.bending_stiffness_n_m2 / s.bar_m for s in lattice.sections])[corners[:, 6]]
    # two twines gathered at the codline have no angle between them
    resists = (clamped > 0.0) & ((corners[:, 1] != corners[:, 2]) | (corners[:, 4] != corners[:, 5]))
    corners, clamped = corners[resists], clamped[resists]
    at_rest = np.array([2.0 * s.rest_half_angle_rad for s in lattice.sections])[corners[:, 6]]
    net = Net(
        positions=positions,
        order=lattice.order,
        fixed=fixed,
        bars=bars[:, :2].astype(np.int32),
        bar_image=bars[:, 2].astype(np.int32),
        bar_length=g * np.where(is_knot, of_section("knot_m"), of_section("bar_m")),
        bar_flexibility=np.where(is_knot, softness("knot_axial_stiffness_n"), softness("axial_stiffness_n")),
        bar_drag_diameter=np.where(is_knot, 0.0, g * of_section("drag_width_m")),
        bar_solid_diameter=np.sqrt(g) * of_section("solid_diameter_m"),
        bar_density=np.array([np.nan if s.density_kg_m3 is None else s.density_kg_m3 for s in nettings])[netting],
        bar_diameter=of_section("twine_m"),
        bar_drag_law=np.full(len(bars), law, dtype=np.int32),
        bar_normal_drag=np.full(len(bars), normal),
        bar_tangential_drag=np.full(len(bars), tangential),
        bar_is_rope=np.zeros(len(bars), dtype=bool),
        bar_is_strut=is_knot & np.array([s.knot_compression for s in nettings])[netting],
        facets=facets[:, :3].astype(np.int32),
        facet_image=facets[:, 3:6].astype(np.int32),
        facet_weight=weight,
        corners=corners[:, :3].astype(np.int32),
        corner_image=corners[:, 3:6].astype(np.int32),
        corner_stiffness=g**2 * clamped,
        corner_rest=np.where(corners[:, 7] == 1, np.pi - at_rest, at_rest),
        **NO_POINTS,
    )
    return Bag(
        net=net,
        node_row=node_row,
        bar_band=band.astype(np.int32),
        bar_is_twine=~is_knot,
        facet_band=facets[:, 6].astype(np.int32),
        band_meshes=np.array([g / s.rows_per_mesh for s in lattice.sections]),
        band_kind=tuple(s.kind for s in lattice.sections),
        band_bending_n=np.array([s.bending_n for s in lattice.sections]),
        band_rest_rad=np.array([s.rest_half_angle_rad for s in lattice.sections]),
        mesh_sides=meshes[:, :8].reshape(-1, 4, 2).astype(np.int32),
        mesh_side_image=meshes[:, 8:16].reshape(-1, 4, 2).astype(np.int32),
        mesh_bars=_bars_of_sides(bars[:, :3], meshes[:, :8].reshape(-1, 2), meshes[:, 8:16].reshape(-1, 2)),
        mesh_row=meshes[:, 16].astype(np.int32),
        globalisation=g,
        windows=tuple(window.netting for window in windows),
        bar_window=np.where(netting >= lattice.bands, netting - lattice.bands, -1).astype(np.int32),
        mesh_window=np.maximum(mesh_netting - lattice.bands, -1).astype(np.int32),
    )


def _own_and_of_windows(
    own: list[NDArray], place: int, of_windows: Sequence[list[NDArray]], bands: int
) -> tuple[NDArray, NDArray]:
    """Parts with those of windows after them, and the netting of each: its band, or behind those its window."""
    table = np.concatenate(own)
    netting = [np.minimum(table[:, place], bands - 1)]
    for number, parts in enumerate(of_windows):
        table = np.concatenate([table, *parts])
        netting.append(np.full(sum(map(len, parts)), bands + number))
    return table, np.concatenate(netting)


def _polygon_area(corners: Counts) -> Floats:
    """Area of a regular polygon over that of the circle through its corners.

    A globalised net is an inscribed polygon of too few corners; at the same radius, pressure on it falls short in this
    ratio along the axis and across it, and so does its volume. Its facets are weighted to make up for that. Where two
    sections meet, their weights differ, which leaves an error of the order of what the weights make up for.
    """
    return np.asarray(np.sinc(2.0 / corners))


def _bars_of_sides(bars: NDArray, sides: NDArray, images: NDArray) -> Ints:
    """Number of the bar on each side of each mesh, -1 where there is none, (meshes, 4)."""

    def key(first: NDArray, second: NDArray, image: NDArray) -> NDArray:
        swap = first > second
        low, high = np.where(swap, second, first), np.where(swap, first, second)
        # the bars to a node's own images on either side are one and the same
        turned = np.where(first == second, np.abs(image), np.where(swap, -image, image))
        return (low * (bars[:, :2].max() + 1) + high) * 8 + turned + 4

    bar_keys = key(bars[:, 0], bars[:, 1], bars[:, 2])
    order = np.argsort(bar_keys, kind="stable")
    relative = np.where(
        (sides[:, 0] == bars[:, :2].max()) | (sides[:, 1] == bars[:, :2].max()), 0, images[:, 1] - images[:, 0]
    )
    wanted = key(sides[:, 0], sides[:, 1], relative)
    place = np.minimum(np.searchsorted(bar_keys[order], wanted), len(bars) - 1)
    found = order[place]
    return np.where(bar_keys[found] == wanted, found, -1).reshape(-1, 4).astype(np.int32)
