"""Plan to net: rows of knots for each kind of netting, sectors, globalisation and the codline.

Every knot has four ports, where the twines to the four neighbouring knots leave it: fore or aft, left or right. The
kinds of knotted netting differ only in which ports are the same node: all four in ideal diamond netting, the two fore
ones and the two aft ones when the knot lies along the netting (T0), the two left ones and the two right ones when it
lies across (T90). Bars, facets and meshes are written once, in ports.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError
from codend.net import Floats, Ints, Net, split_bars
from codend.plan import Netting, Plan

FORE_LEFT, FORE_RIGHT, AFT_LEFT, AFT_RIGHT = range(4)
HALF_MESH = 0.5


def build_net(
    plan: Plan,
    *,
    globalisation: int = 1,
    columns: int | None = None,
    rows: tuple[Floats, Floats] | None = None,
    azimuth_rad: float = 0.0,
) -> Net:
    """Net of a plan, in the shape in which a solver starts.

    Args:
        plan: the net plan; all sections must have the same number of meshes round.
        globalisation: real meshes merged into one each way: bar length and drag diameter grow by this factor, solid
            diameter by its square root, axial stiffness by this factor (Le Bris et al. 1999, section 3.1; Bessonneau
            and Marichal 1997, section 4), so that mass, wet weight and drag area stay the same.
        columns: (merged) meshes round that are modelled; 1 gives one rotational sector, None the full net.
        rows: positions along the axis and radii of the rows, each (rows + 1,); a crude bag by default.
        azimuth_rad: turns the whole net about the axis.

    Raises:
        InputError: the globalisation does not divide the mesh counts, or the sections differ in meshes round.
    """
    lattice = _Lattice.of(plan, globalisation, columns)
    _check_bending(plan)
    x, radius = rows if rows is not None else crude_rows(plan, globalisation)
    shape = _Shape(x, np.concatenate([[plan.entry.radius_m], radius[1:-1], [0.0]]), azimuth_rad)
    square = any(s.mesh == "square" for s in plan.netting)
    net = _square_net(lattice, shape, plan) if square else _knotted_net(lattice, shape)
    if plan.model.bars_per_side == 2:
        return split_bars(net, net.bar_drag_diameter > 0.0)
    return net


def _check_bending(plan: Plan) -> None:
    """Refuse bending stiffness where the model has no place for it, rather than leave it out."""
    stiff = [s for s in plan.netting if s.bending_stiffness_n_m2 > 0.0]
    if stiff and any(s.mesh == "square" for s in stiff):
        allowed = "0 for square mesh, whose opening bending does not resist"
    elif stiff and plan.model.bars_per_side > 1:
        allowed = "0 with bars_per_side = 2: a hinge in mid-bar and stiff twine contradict each other"
    else:
        return
    value = stiff[0].bending_stiffness_n_m2
    raise InputError(file=plan.source, key="netting.bending_stiffness_n_m2", value=value, allowed=allowed)


def rows_of(plan: Plan, globalisation: int = 1) -> list[Netting]:
    """Section of each band between two rows, from the entry to the codline."""
    return [
        section
        for section in plan.netting
        for _ in range((1 if section.mesh == "square" else 2) * section.meshes_long // globalisation)
    ]


def crude_rows(plan: Plan, globalisation: int = 1) -> tuple[Floats, Floats]:
    """Positions and radii of the rows of a plain bag that any solver can start from: a tube with a conical end."""
    sections = rows_of(plan, globalisation)
    side = np.array([globalisation * (s.bar_m + (s.knot_m if s.mesh == "diamond" else 0.0)) for s in sections])
    largest = np.array([s.stretched_radius_m for s in sections])
    to_codline = np.concatenate([np.cumsum(side[::-1])[::-1], [0.0]])
    wanted = np.minimum(0.55 * np.concatenate([largest, largest[-1:]]), 0.6 * to_codline)
    from_entry = to_codline[0] - to_codline
    radius = np.minimum(wanted, plan.entry.radius_m + 0.4 * from_entry)
    opening = np.clip(0.5 * (radius[1:] + radius[:-1]) / largest, 0.0, 0.95)
    along = side * np.sqrt(1.0 - opening**2)
    step = np.sqrt(np.maximum(along**2 - np.diff(radius) ** 2, (0.2 * side) ** 2))
    return np.concatenate([[0.0], np.cumsum(step)]), radius


@dataclass(frozen=True)
class _Lattice:
    """Counts that all index arithmetic rests on."""

    sections: list[Netting]
    columns: int
    order: int
    globalisation: int

    @classmethod
    def of(cls, plan: Plan, globalisation: int, columns: int | None) -> "_Lattice":
        counts = {s.meshes_round for s in plan.netting}
        if len(counts) > 1:
            raise InputError(
                file=plan.source,
                key="netting.meshes_round",
                value=sorted(counts),
                allowed="the same number in every section",
            )
        if globalisation not in plan.globalisations:
            raise InputError(
                file=plan.source,
                key="model.globalisation",
                value=globalisation,
                allowed="a common divisor of all mesh counts: " + ", ".join(map(str, plan.globalisations)),
            )
        meshes_round = counts.pop() // globalisation
        columns = meshes_round if columns is None else columns
        if meshes_round % columns:
            raise ValueError(f"columns must divide {meshes_round} meshes round, not {columns}")
        return cls(rows_of(plan, globalisation), columns, meshes_round // columns, globalisation)

    @property
    def bands(self) -> int:
        return len(self.sections)

    def wrapped(self, column: NDArray[np.integer]) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
        """Column inside the modelled part, and image, of a column counted on all round."""
        image = np.zeros_like(column) if self.order == 1 else column // self.columns
        return column % self.columns, image


@dataclass(frozen=True)
class _Shape:
    """Where the rows are when the solver starts."""

    x: Floats
    radius: Floats
    azimuth_rad: float

    def placed(self, row: NDArray, azimuth: Floats, ahead: Floats | float = 0.0) -> Floats:
        """Points at the azimuth (rad), a fraction ``ahead`` of the band back from the row towards the one before."""
        before = np.maximum(row - 1, 0)
        x = (1.0 - ahead) * self.x[row] + ahead * self.x[before]
        radius = (1.0 - ahead) * self.radius[row] + ahead * self.radius[before]
        angle = azimuth + self.azimuth_rad
        return np.stack([x, radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


@dataclass(frozen=True)
class _Corner:
    """One node with its image for every (row, column) of a pattern: two arrays of the same shape."""

    node: NDArray[np.integer]
    image: NDArray[np.integer]


class _Parts:
    """Bars, facets and meshes gathered while a net is written."""

    def __init__(self, codline: int) -> None:
        self.codline = codline
        self.bars: list[NDArray] = []
        self.facets: list[NDArray] = []
        self.meshes: list[NDArray] = []
        self.corners: list[NDArray] = []

    def add_bars(self, first: _Corner, second: _Corner, band: NDArray, is_knot: bool) -> None:
        image = np.where((first.node == self.codline) | (second.node == self.codline), 0, second.image - first.image)
        knot = np.full(first.node.shape, is_knot)
        self.bars.append(_columns(first.node, second.node, image, np.broadcast_to(band, knot.shape), knot))

    def add_quadrangles(self, a: _Corner, b: _Corner, c: _Corner, d: _Corner, band: NDArray) -> None:
        """Cover a, b, c, d by both divisions into triangles, each at half weight, so that no diagonal is special."""
        for p, q, r in ((a, b, c), (a, c, d), (a, b, d), (b, c, d)):
            place = np.broadcast_to(band, p.node.shape)
            self.facets.append(_columns(p.node, q.node, r.node, p.image, q.image, r.image, place))

    def add_meshes(self, sides: Sequence[tuple[_Corner, _Corner]], row: NDArray) -> None:
        nodes = [corner.node for side in sides for corner in side]
        images = [corner.image for side in sides for corner in side]
        self.meshes.append(_columns(*nodes, *images, np.broadcast_to(row, nodes[0].shape)))

    def add_corners(self, middle: _Corner, first: _Corner, second: _Corner, band: NDArray, across: bool) -> None:
        nodes = (middle.node, first.node, second.node)
        images = [np.where(c.node == self.codline, 0, c.image) for c in (middle, first, second)]
        place = np.broadcast_to(band, middle.node.shape)
        self.corners.append(_columns(*nodes, *images, place, np.full(middle.node.shape, across)))

    def facet_table(self) -> tuple[NDArray, Floats]:
        """Facets without the empty ones, equal ones merged, and their weights."""
        table = np.concatenate(self.facets)
        nodes, images = table[:, :3], np.where(table[:, :3] == self.codline, 0, table[:, 3:6])
        table = np.concatenate([nodes, images, table[:, 6:]], axis=1)
        same = [(nodes[:, i] == nodes[:, j]) & (images[:, i] == images[:, j]) for i, j in ((0, 1), (1, 2), (2, 0))]
        unique, count = np.unique(table[~np.any(same, axis=0)], axis=0, return_counts=True)
        by_band = np.argsort(unique[:, -1], kind="stable")
        return unique[by_band], np.asarray(0.5 * count[by_band], dtype=np.float64)


def _columns(*arrays: NDArray) -> NDArray:
    return np.stack([np.broadcast_to(a, arrays[0].shape).ravel() for a in arrays], axis=1)


def _knotted_net(lattice: _Lattice, shape: _Shape) -> Net:
    """Diamond netting with or without knot length, and T90."""
    bands, columns = lattice.bands, lattice.columns
    across = np.array([s.mesh == "t90" and s.knot_m > 0.0 for s in lattice.sections])
    along = np.array([s.mesh == "diamond" and s.knot_m > 0.0 for s in lattice.sections])
    # the knot of a row belongs to the band ahead of it; the entry's own row has knots only where they lie across
    across_row, along_row = np.concatenate([across[:1], across]), np.concatenate([[False], along])

    # number the nodes row by row: one or two a knot, and the codline after all others
    per_knot = 1 + (across_row | along_row).astype(int)
    per_knot[bands] = int(along_row[bands])
    start = np.concatenate([[0], np.cumsum(per_knot)]) * columns
    codline = int(start[-1])
    column = np.arange(columns)
    second_of_knot = (per_knot == 2) * columns
    ports = np.empty((4, bands + 1, columns), dtype=np.int64)
    base = start[:-1, None] + column
    ports[FORE_LEFT] = base
    ports[FORE_RIGHT] = base + (across_row * second_of_knot)[:, None]
    ports[AFT_LEFT] = base + (along_row * second_of_knot)[:, None]
    ports[AFT_RIGHT] = base + second_of_knot[:, None]
    ports[AFT_LEFT, bands] = ports[AFT_RIGHT, bands] = codline
    if not along_row[bands]:
        ports[FORE_LEFT, bands] = ports[FORE_RIGHT, bands] = codline

    def port(which: int, row: NDArray, counted: NDArray) -> _Corner:
        inside, image = lattice.wrapped(counted)
        return _Corner(ports[which, row, inside], image)

    parts = _Parts(codline)
    band = np.arange(bands)[:, None]
    odd = band % 2
    here = np.broadcast_to(column, (bands, columns))
    # the two knots of the next row that lie half a mesh to the right and to the left
    right, left = here + odd, here + odd - 1
    parts.add_bars(port(AFT_RIGHT, band, here), port(FORE_LEFT, band + 1, right), band, False)
    parts.add_bars(port(AFT_LEFT, band, here), port(FORE_RIGHT, band + 1, left), band, False)
    parts.add_quadrangles(
        port(AFT_LEFT, band, here),
        port(AFT_RIGHT, band, here),
        port(FORE_LEFT, band + 1, right),
        port(FORE_RIGHT, band + 1, left),
        band,
    )
    parts.add_quadrangles(
        port(AFT_RIGHT, band, here),
        port(AFT_LEFT, band, here + 1),
        port(FORE_RIGHT, band + 1, right),
        port(FORE_LEFT, band + 1, right),
        band,
    )
    lengthwise = np.flatnonzero(along_row)[:, None]
    if lengthwise.size:
        knot = np.broadcast_to(column, (len(lengthwise), columns))
        parts.add_bars(port(FORE_LEFT, lengthwise, knot), port(AFT_LEFT, lengthwise, knot), lengthwise - 1, True)
        parts.add_quadrangles(
            port(FORE_RIGHT, lengthwise, knot),
            port(FORE_LEFT, lengthwise, knot + 1),
            port(AFT_LEFT, lengthwise, knot + 1),
            port(AFT_RIGHT, lengthwise, knot),
            lengthwise - 1,
        )
    # the entry's knots are held at both ends and the codline's are gathered: neither is a bar
    crosswise = np.flatnonzero(across_row[1:bands])[:, None] + 1
    if crosswise.size:
        knot = np.broadcast_to(column, (len(crosswise), columns))
        parts.add_bars(port(FORE_LEFT, crosswise, knot), port(FORE_RIGHT, crosswise, knot), crosswise - 1, True)

    _add_corners(parts, port, across_row, columns)
    row = np.arange(1, bands)[:, None]
    between = np.broadcast_to(column, (bands - 1, columns))
    middle = between + row % 2
    parts.add_meshes(
        [
            (port(AFT_RIGHT, row - 1, middle), port(FORE_LEFT, row, between + 1)),
            (port(AFT_LEFT, row, between + 1), port(FORE_RIGHT, row + 1, middle)),
            (port(FORE_LEFT, row + 1, middle), port(AFT_RIGHT, row, between)),
            (port(FORE_RIGHT, row, between), port(AFT_LEFT, row - 1, middle)),
        ],
        row,
    )
    node_row = np.full(codline + 1, -1, dtype=np.int32)
    positions = np.empty((codline + 1, 3))
    rows = np.broadcast_to(np.arange(bands + 1)[:, None], (bands + 1, columns))
    azimuth = (2 * column + rows % 2) * np.pi / (columns * lattice.order)
    knot_share = np.array([s.knot_m / (s.bar_m + s.knot_m) for s in lattice.sections])
    ahead = np.where(along_row, np.concatenate([knot_share[:1], knot_share]), 0.0)[:, None]
    half_knot = lattice.globalisation * 0.5 * np.array([s.knot_m for s in lattice.sections])
    wide = np.where(across_row, np.concatenate([half_knot[:1], half_knot]), 0.0)
    half_angle = np.arcsin(np.clip(wide / np.maximum(shape.radius, wide + 1e-300), 0.0, 1.0))
    turn = np.minimum(half_angle, 0.4 * np.pi / (columns * lattice.order))[:, None]
    positions[ports[FORE_LEFT]] = shape.placed(rows, azimuth - turn, ahead)
    positions[ports[FORE_RIGHT]] = shape.placed(rows, azimuth + turn, ahead)
    positions[ports[AFT_LEFT]] = np.where(
        (ports[AFT_LEFT] == ports[FORE_LEFT])[..., None], positions[ports[AFT_LEFT]], shape.placed(rows, azimuth)
    )
    positions[codline] = (shape.x[bands], 0.0, 0.0)
    for side in (AFT_LEFT, AFT_RIGHT):
        node_row[ports[side]] = rows
    return _assembled(parts, lattice, positions, node_row, ports[[AFT_LEFT, AFT_RIGHT], 0])


def _add_corners(
    parts: _Parts, port: Callable[[int, NDArray, NDArray], _Corner], across_row: NDArray, columns: int
) -> None:
    """Corners between two twines: fore and aft of a knot that lies lengthwise, left and right of one across."""
    bands = len(across_row) - 1
    rows = np.arange(bands + 1)

    def knots(chosen: NDArray) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        row = rows[chosen][:, None]
        here = np.broadcast_to(np.arange(columns), (len(row), columns))
        return row, here, here + row % 2, here + row % 2 - 1

    lengthwise = ~across_row
    row, here, right, left = knots(lengthwise & (rows < bands))
    aft = port(FORE_LEFT, row + 1, right), port(FORE_RIGHT, row + 1, left)
    parts.add_corners(port(AFT_LEFT, row, here), *aft, row, False)
    row, here, right, left = knots(lengthwise & (rows > 0) & (rows < bands))
    fore = port(AFT_LEFT, row - 1, right), port(AFT_RIGHT, row - 1, left)
    parts.add_corners(port(FORE_LEFT, row, here), *fore, row - 1, False)
    row, here, right, left = knots(~lengthwise & (rows > 0) & (rows < bands))
    if row.size:
        to_right = port(AFT_LEFT, row - 1, right), port(FORE_LEFT, row + 1, right)
        parts.add_corners(port(AFT_RIGHT, row, here), *to_right, row, True)
        to_left = port(AFT_RIGHT, row - 1, left), port(FORE_RIGHT, row + 1, left)
        parts.add_corners(port(AFT_LEFT, row, here), *to_left, row, True)


def _square_net(lattice: _Lattice, shape: _Shape, plan: Plan) -> Net:
    """Square mesh: meridional bars and rings of bars."""
    if any(s.mesh != "square" for s in plan.netting):
        raise InputError(
            file=plan.source,
            key="netting.mesh",
            value=[s.mesh for s in plan.netting],
            allowed="square netting cannot be joined to another kind yet",
        )
    bands, columns = lattice.bands, lattice.columns
    codline = bands * columns
    column = np.arange(columns)
    nodes = np.arange(bands + 1)[:, None] * columns + column
    nodes[bands] = codline

    def knot(row: NDArray, counted: NDArray) -> _Corner:
        inside, image = lattice.wrapped(counted)
        return _Corner(nodes[row, inside], image)

    parts = _Parts(codline)
    band = np.arange(bands)[:, None]
    here = np.broadcast_to(column, (bands, columns))
    a, b, c, d = knot(band, here), knot(band, here + 1), knot(band + 1, here + 1), knot(band + 1, here)
    parts.add_bars(a, d, band, False)
    ring = np.arange(1, bands)[:, None]
    around = np.broadcast_to(column, (bands - 1, columns))
    parts.add_bars(knot(ring, around), knot(ring, around + 1), ring - 1, False)
    parts.add_quadrangles(a, b, c, d, band)
    parts.add_meshes([(a, b), (b, c), (c, d), (d, a)], band)
    node_row = np.empty(codline + 1, dtype=np.int32)
    rows = np.broadcast_to(np.arange(bands + 1)[:, None], (bands + 1, columns))
    node_row[nodes] = rows
    positions = np.empty((codline + 1, 3))
    positions[nodes] = shape.placed(rows, 2.0 * np.pi * column / (columns * lattice.order))
    return _assembled(parts, lattice, positions, node_row, nodes[0])


def _assembled(parts: _Parts, lattice: _Lattice, positions: Floats, node_row: Ints, entry: NDArray) -> Net:
    """Net with the properties of its bars, held at the entry and kept on the axis at the codline."""
    g = lattice.globalisation
    bars = np.concatenate(parts.bars)
    is_knot = bars[:, 4].astype(bool)
    band = bars[:, 3]

    def of_section(value: str) -> Floats:
        return np.array([getattr(s, value) for s in lattice.sections], dtype=np.float64)[band]

    stiffness = np.array(
        [np.inf if s.axial_stiffness_n is None else g * s.axial_stiffness_n for s in lattice.sections]
    )[band]
    facets, weight = parts.facet_table()
    around = lattice.columns * lattice.order
    weight *= _polygon_area(g * around) / _polygon_area(around)
    meshes = np.concatenate(parts.meshes)
    count = len(node_row)
    fixed = np.zeros((count, 3), dtype=bool)
    fixed[entry] = True
    fixed[parts.codline, 1:] = True
    corners = np.concatenate(parts.corners) if parts.corners else np.zeros((0, 8), dtype=np.int64)
    clamped = np.array([12.0 * s.bending_stiffness_n_m2 / s.bar_m for s in lattice.sections])[corners[:, 6]]
    # two twines gathered at the codline have no angle between them
    resists = (clamped > 0.0) & ((corners[:, 1] != corners[:, 2]) | (corners[:, 4] != corners[:, 5]))
    corners, clamped = corners[resists], clamped[resists]
    at_rest = np.array([2.0 * s.rest_half_angle_rad for s in lattice.sections])[corners[:, 6]]
    half = [1.0 if s.mesh == "square" else HALF_MESH for s in lattice.sections]
    return Net(
        positions=positions,
        order=lattice.order,
        fixed=fixed,
        node_row=node_row,
        bars=bars[:, :2].astype(np.int32),
        bar_image=bars[:, 2].astype(np.int32),
        bar_length=g * np.where(is_knot, of_section("knot_m"), of_section("bar_m")),
        bar_flexibility=np.where(is_knot, 0.0, 1.0 / stiffness),  # a knot is a lump that does not stretch
        bar_drag_diameter=np.where(is_knot, 0.0, g * of_section("drag_width_m")),
        bar_solid_diameter=np.sqrt(g) * of_section("solid_diameter_m"),
        bar_density=np.array(
            [np.nan if s.twine_density_kg_m3 is None else s.twine_density_kg_m3 for s in lattice.sections]
        )[band],
        bar_band=band.astype(np.int32),
        facets=facets[:, :3].astype(np.int32),
        facet_image=facets[:, 3:6].astype(np.int32),
        facet_weight=weight,
        facet_band=facets[:, 6].astype(np.int32),
        mesh_sides=meshes[:, :8].reshape(-1, 4, 2).astype(np.int32),
        mesh_side_image=meshes[:, 8:16].reshape(-1, 4, 2).astype(np.int32),
        mesh_bars=_bars_of_sides(bars[:, :3], meshes[:, :8].reshape(-1, 2), meshes[:, 8:16].reshape(-1, 2)),
        mesh_row=meshes[:, 16].astype(np.int32),
        band_meshes=g * np.array(half),
        corners=corners[:, :3].astype(np.int32),
        corner_image=corners[:, 3:6].astype(np.int32),
        corner_stiffness=g**2 * clamped,
        corner_rest=np.where(corners[:, 7] == 1, np.pi - at_rest, at_rest),
        globalisation=g,
    )


def _polygon_area(corners: int) -> float:
    """Area of a regular polygon over that of the circle through its corners.

    A globalised net is an inscribed polygon of too few corners; at the same radius, pressure on it falls short in this
    ratio along the axis and across it, and so does its volume. Its facets are weighted to make up for that.
    """
    return float(np.sinc(2.0 / corners))


def _bars_of_sides(bars: NDArray, sides: NDArray, images: NDArray) -> Ints:
    """Number of the bar on each side of each mesh, -1 where there is none, (meshes, 4)."""

    def key(first: NDArray, second: NDArray, image: NDArray) -> NDArray:
        swap = first > second
        low, high = np.where(swap, second, first), np.where(swap, first, second)
        return (low * (bars[:, :2].max() + 1) + high) * 8 + np.where(swap, -image, image) + 4

    bar_keys = key(bars[:, 0], bars[:, 1], bars[:, 2])
    order = np.argsort(bar_keys, kind="stable")
    relative = np.where(
        (sides[:, 0] == bars[:, :2].max()) | (sides[:, 1] == bars[:, :2].max()), 0, images[:, 1] - images[:, 0]
    )
    wanted = key(sides[:, 0], sides[:, 1], relative)
    place = np.minimum(np.searchsorted(bar_keys[order], wanted), len(bars) - 1)
    found = order[place]
    return np.where(bar_keys[found] == wanted, found, -1).reshape(-1, 4).astype(np.int32)
