"""Plan to bag: sectors, globalisation, and the shape in which a solver starts."""

import math

import numpy as np

from codend.bag.assemble import assembled
from codend.bag.bag import Bag, with_hinges
from codend.bag.layers import with_layers
from codend.bag.near_ratio import NearRatio
from codend.bag.ropes import with_ropes
from codend.bag.straps import with_straps
from codend.bag.windows import farthest_beside, sewn_to_bars, with_windows
from codend.errors import InputError
from codend.mechanics.drag_laws import drag
from codend.net.net import Floats
from codend.netting.frame import frame_of
from codend.netting.knots import placed_knots
from codend.netting.lattice import Counts, Lattice
from codend.netting.parts import RowShape
from codend.netting.pattern import parts_of
from codend.netting.taper import columns_along
from codend.netting.windows import LetIn
from codend.plan.merging import between_ropes
from codend.plan.plan import Netting, Plan

ROUND_OFF = 1e-6
"""Of a mesh: how far beside the middle of its panel a window lies in the middle."""


def build_bag(
    plan: Plan,
    *,
    globalisation: float = 1,
    sectors: int | None = None,
    smeared: bool = False,
    rows: tuple[Floats, Floats] | None = None,
    azimuth_rad: float = 0.0,
    near: NearRatio | None = None,
) -> Bag:
    """Bag of a plan, in the shape in which a solver starts.

    Args:
        plan: the net plan.
        globalisation: real meshes merged into one each way: bar length and drag diameter grow by this factor, solid
            diameter by its square root, axial stiffness by this factor (Le Bris et al. 1999, section 3.1; Bessonneau
            and Marichal 1997, section 4), so that mass, wet weight and drag area stay the same; a divisor of all mesh
            counts, or ``between_ropes`` of the plan.
        sectors: equal sectors that are modelled side by side, of as many as the meshes round of all sections can be
            divided into: each is one (merged) mesh wide where they have the same, and wide enough that every rope
            has its place in one; None gives the full net.
        smeared: ropes spread evenly over all columns of knots, which leaves the sectors as narrow as without ropes.
        rows: positions along the axis and radii of the rows, each (rows + 1,); a crude bag by default.
        azimuth_rad: turns the whole net about the axis.
        near: a sector of nearly the ratio of the sections' counts, in place of an exact one.

    Raises:
        InputError: the globalisation does not divide the mesh counts, a strap is too short for its row, or bending
            stiffness has no place in the model.
    """
    _check_bending(plan)
    lattice = _lattice_of(plan, globalisation, sectors, smeared, near)
    _check_edges(plan, lattice)
    if rows is None:
        around = lattice.columns * int(lattice.order) if near is None else _columns_of(plan, globalisation)[0]
        rows = _crude_rows(plan, lattice, around)
    x, radius = rows
    azimuth_rad += np.radians(plan.seam_deg)
    shape = RowShape(x, np.concatenate([[plan.entry_radius_m], radius[1:-1], [0.0]]), azimuth_rad)
    frame = frame_of(lattice)
    knots, node_row = frame.knots_in(lattice), frame.places.node_row
    positions = placed_knots(lattice, frame.places, shape)
    entry = np.arange(knots.fore_start[1])
    drag_law = drag(plan.drag.law, *plan.drag.coefficients)
    windows = list[LetIn]()
    if plan.window and sectors is None:
        parts = parts_of(knots)
        windows, knots, positions, node_row = with_windows(plan, parts, knots, shape, positions, node_row)
        entry = np.unique(knots.now(entry))
        layout = parts.joined(windows)
    else:
        layout = frame.layout
    bag = assembled(layout, lattice, positions, node_row, entry, drag_law, windows)
    bag = sewn_to_bars(bag, windows)
    if plan.model.bars_per_side == 2:
        bag = with_hinges(bag)
    bag = with_ropes(with_straps(bag, plan, knots, drag_law), plan, knots, drag_law, smeared)
    return with_layers(bag, plan, knots)


def _lattice_of(
    plan: Plan, globalisation: float, sectors: int | None, smeared: bool, near: NearRatio | None
) -> Lattice:
    if globalisation not in plan.globalisations and globalisation != between_ropes(plan):
        raise InputError(
            file=plan.source,
            key="model.globalisation",
            value=globalisation,
            allowed="a common divisor of all mesh counts: " + ", ".join(map(str, plan.globalisations)),
        )
    sections = plan.netting
    number = np.repeat(np.arange(len(sections)), [part.merged_rows(globalisation) for part in sections])
    if near is not None:
        ends = zip(plan.netting, near.ends(plan), strict=True)
        columns = np.concatenate([_along(part, fore, aft, globalisation) for part, (fore, aft) in ends])
        seams = np.ones_like(columns) if plan.tapers else None
        return Lattice(sections, number, columns, 1, near.order / globalisation, globalisation, seams)
    columns, seams = _columns_of(plan, globalisation)
    # smeared all round, selvedges leave no seam but where meshes are lost along it
    seamed = plan.tapers or (not smeared and any(part.has_seams for part in plan.netting))
    most = math.gcd(int(np.gcd.reduce(columns)), int(np.gcd.reduce(seams)) if seamed else 0)
    # n equal ropes leave n equal sectors
    equal = most if smeared else math.gcd(most, *(rope.number for rope in plan.ropes))
    if sectors is not None and equal % sectors:
        raise ValueError(f"sectors must divide {equal}, the equal ones all round, not be {sectors}")
    abreast = most if sectors is None else most // equal * sectors
    order = most // abreast
    seams_of_order = seams // order if seamed else None
    return Lattice(sections, number, columns // order, abreast, order, globalisation, seams_of_order)


def merged_in_place(plan: Plan) -> list[int]:
    """Meshes that can be merged each way and leave every window in the middle of its panel, if all are there unmerged.

    Where merged counts lose an odd number of meshes along a seam that other counts do not, columns lie half a mesh
    beside it and the window beside the middle of its panel. Where its merged count is odd and that of its place even,
    or the other way round, a knot in the middle of its edges is sewn to one side. Either draws the bag aside, and no
    plane mirrors it.
    """
    if not plan.window:
        return list(plan.globalisations)
    mirrored = {g: _windows_mirrored(plan, g) for g in plan.globalisations}
    return [g for g in plan.globalisations if mirrored[g] or not mirrored[1]]


def _windows_mirrored(plan: Plan, globalisation: int) -> bool:
    """Whether every window lies in the middle of its panel, and has one in common with its place."""
    sewn_aside = any((part.meshes_round - part.meshes_across) // globalisation % 2 for part in plan.window)
    return not sewn_aside and farthest_beside(plan, _lattice_of(plan, globalisation, None, False, None)) <= ROUND_OFF


def _columns_of(plan: Plan, globalisation: float) -> tuple[Counts, Counts]:
    """(Merged) meshes all round of every band, and seams at which it loses some where it tapers, each (bands,).

    A tube tapers in as many places round as its counts and those of the other sections allow.
    """
    places = plan.places_round(globalisation)
    parts, seams = [], []
    for part in plan.netting:
        around = part.panels if part.has_seams else places
        fore, aft = (round(count / globalisation) // around for count in part.open_meshes)
        parts.append(around * _along(part, fore, aft, globalisation))
        seams.append(np.full(len(parts[-1]), around))
    return np.concatenate(parts), np.concatenate(seams)


def _along(part: Netting, fore: int, aft: int, globalisation: float) -> Counts:
    """Columns of the bands of a section, from its counts at either end, (rows,)."""
    return columns_along(fore, aft, part.merged_rows(globalisation), part.kind.staggered)


def _check_bending(plan: Plan) -> None:
    """Refuse bending stiffness where the model has no place for it, rather than leave it out."""
    for table, nettings in (("netting", plan.netting), ("window", plan.window)):
        for index, section in enumerate(nettings):
            if section.bending_stiffness_n_m2 == 0.0:
                continue
            if not section.kind.opens:
                allowed = f"0 for {section.kind.words} mesh, whose opening bending does not resist"
            elif plan.model.bars_per_side > 1:
                allowed = "0 with bars_per_side = 2: a hinge in mid-bar and stiff twine contradict each other"
            else:
                continue
            key = f"{table}.{index}.bending_stiffness_n_m2"
            raise InputError(plan.source, key, section.bending_stiffness_n_m2, allowed)


def _check_edges(plan: Plan, lattice: Lattice) -> None:
    """Refuse an entry so wide that netting cut so steeply does not reach from it to its seams.

    What is gathered in a seam after j rows of bars b hangs on knots of the hoop up to (w + j) / 2 meshes beside it, w
    the half meshes that an edge has lost by then; the nearest point of the seam is  r sin(pi (w + j) / N)  away, and
    the way there j (b + l) (derived). At a steady rate R of cut that is E1 below about 1 / (1 + R).
    """
    first = plan.netting[0]
    if lattice.seams is None or not first.tapers or first.stretches or not first.kind.staggered:
        return
    rows = np.arange(1, np.searchsorted(lattice.number, 1))
    lost = (lattice.columns[0] - lattice.columns[rows]) // lattice.seams[0]
    turn = np.minimum(np.pi * (lost + rows) / (lattice.columns[0] * lattice.order), np.pi / 2)
    way_m = rows * lattice.globalisation * (first.bar_m + first.knot_m)
    most_m = float(np.min(way_m[lost > 0] / np.sin(turn[lost > 0]), initial=np.inf))
    if plan.entry_radius_m < most_m:
        return
    key, value, most = "radius_m", plan.entry_radius_m, most_m
    if plan.entry.hanging_ratio is not None:
        key, value, most = "hanging_ratio", plan.entry.hanging_ratio, plan.entry.hanging_ratio * most_m / value
    cut = f"of section {plan.section_names[0]}, cut {first.edge_cut_text}, reaches its seams"
    raise InputError(plan.source, f"entry.{key}", value, f"below {most:.4g}, so that the netting {cut}")


def _crude_rows(plan: Plan, lattice: Lattice, around: Counts) -> tuple[Floats, Floats]:
    """Positions and radii of the rows of a plain bag that any solver can start from: tubes with conical ends.

    ``around`` are the (merged) meshes all round of every band.
    """
    g = lattice.globalisation
    side = lattice.of_bands(lambda section: g * (section.bar_m + section.knot_along_m))
    largest = g * around * lattice.of_bands(lambda section: section.stretched_radius_per_mesh_m)
    from_entry = np.concatenate([[0.0], np.cumsum(side)])
    bound = np.minimum(np.concatenate([largest[:1], largest]), np.concatenate([largest, largest[-1:]]))
    from_wide_entry = np.minimum(plan.entry_radius_m - 0.6 * from_entry, 0.9 * bound)
    wanted = np.maximum(0.55 * bound, from_wide_entry)
    wanted[0], wanted[-1] = plan.entry_radius_m, 0.0
    for strap, rows in zip(plan.straps, plan.strap_rows, strict=True):
        row = lattice.bands - round(rows / g)
        wanted[row] = min(wanted[row], 0.9 * strap.around_m / (2.0 * np.pi))
    # no row is wider than the slopes of the bag from any other row allow
    widening = np.minimum.accumulate(wanted - 0.4 * from_entry) + 0.4 * from_entry
    narrowing = np.minimum.accumulate((wanted + 0.6 * from_entry)[::-1])[::-1] - 0.6 * from_entry
    radius = np.minimum(widening, narrowing)
    opening = np.clip(0.5 * (radius[1:] + radius[:-1]) / largest, 0.0, 0.95)
    along = side * np.sqrt(1.0 - opening**2)
    step = np.sqrt(np.maximum(along**2 - np.diff(radius) ** 2, (0.2 * side) ** 2))
    return np.concatenate([[0.0], np.cumsum(step)]), radius
