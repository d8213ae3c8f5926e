"""Plan to net: sectors, globalisation, and the shape in which a solver starts."""

import numpy as np

from codend.errors import InputError
from codend.knots import knotted_net, square_net
from codend.net import Floats, Net, split_bars
from codend.net_parts import Lattice, RowShape
from codend.plan import Netting, Plan


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
    _check_kinds(plan)
    _check_bending(plan)
    lattice = _lattice_of(plan, globalisation, columns)
    x, radius = rows if rows is not None else crude_rows(plan, globalisation)
    shape = RowShape(x, np.concatenate([[plan.entry.radius_m], radius[1:-1], [0.0]]), azimuth_rad)
    square = any(s.mesh == "square" for s in plan.netting)
    net = square_net(lattice, shape) if square else knotted_net(lattice, shape)
    if plan.model.bars_per_side == 2:
        return split_bars(net, net.bar_drag_diameter > 0.0)
    return net


def _lattice_of(plan: Plan, globalisation: int, columns: int | None) -> Lattice:
    if globalisation not in plan.globalisations:
        raise InputError(
            file=plan.source,
            key="model.globalisation",
            value=globalisation,
            allowed="a common divisor of all mesh counts: " + ", ".join(map(str, plan.globalisations)),
        )
    meshes_round = plan.netting[0].meshes_round // globalisation
    columns = meshes_round if columns is None else columns
    if meshes_round % columns:
        raise ValueError(f"columns must divide {meshes_round} meshes round, not {columns}")
    return Lattice(rows_of(plan, globalisation), columns, meshes_round // columns, globalisation)


def _check_kinds(plan: Plan) -> None:
    """Refuse sections that cannot be joined yet."""
    counts = {s.meshes_round for s in plan.netting}
    if len(counts) > 1:
        allowed = "the same number in every section"
        raise InputError(file=plan.source, key="netting.meshes_round", value=sorted(counts), allowed=allowed)
    kinds = [s.mesh for s in plan.netting]
    if "square" in kinds and set(kinds) != {"square"}:
        allowed = "square netting cannot be joined to another kind yet"
        raise InputError(file=plan.source, key="netting.mesh", value=kinds, allowed=allowed)


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
