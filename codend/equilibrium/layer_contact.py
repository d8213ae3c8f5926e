"""Second layers as nets of their own, in contact without friction with the netting below, in a sector.

Each is laced to the row of the netting below where it begins and gathered by the same codline. It slides, and the
netting below stands out through its meshes. No drag acts on its twine, as where it moves with the netting below. Both
ends of a knot that lies across are laced to one knot below.
"""

from dataclasses import replace
from math import gcd

import numpy as np

from codend.bag.bag import Bag, around
from codend.bag.build import build_bag
from codend.bag.layer_measures import measure_layers
from codend.bag.loads import catch_of
from codend.equilibrium.bag_model import BagModel
from codend.equilibrium.start_shapes import all_round_start
from codend.mechanics.problem import Problem
from codend.mechanics.surface import ContactLaw
from codend.mechanics.water import uniform_flow
from codend.net.net import Floats, Ints, Net, rotate, with_bars
from codend.plan.layers import Layer
from codend.plan.plan import Case, Plan, plan_from_dict
from codend.solvers import gentle
from codend.solvers.gentle import GentleSettings
from codend.solvers.outcome import Progress, Solution
from codend.solvers.refusal import passage

BEGINS_M = 1e-3
"""Distance at which contact begins."""
PUSH = 5.0
"""Force of parts at half of that on each other, over the mean tension: with a tenth fewer layers came to rest."""
NEAR, FAR = (0.01, 0.02, 0.04, 0.08, 0.15, 0.3), (0.03, 0.06, 0.12)
"""Shares by which a layer may start outside of what it lies on, of which the first with which nothing is pierced is
taken. From farther it takes more steps, seldom comes to no rest, and now and then to another shape."""
STEPS = 400
WORK = 200_000
"""Most steps times knots of the netting below: some 6 s a start. Layers that come to rest mostly do so in 50 to 150."""
MOST_KNOTS = {"auto": 1000, True: 3000, False: 0}
"""Of the netting below in a sector with whole meshes of all, by ``model.contact``: 500 take a second or two."""


def can_slide(model: BagModel) -> bool:
    """Whether the layers of a model can be nets of their own: in a sector of all that is not too wide.

    Nets with ropes, straps or seams cannot where their own sectors have no whole meshes of the layers, merged ones,
    those with windows and what stands for a wider sector never.
    """
    plan = model.plan
    plain = not (plan.window or plan.tapers or model.near) and plan.model.bars_per_side == 1
    if not plain or model.globalisation > 1 or model.sectors != 1:
        return False
    columns, all_alike = _repeats(model), not (plan.ropes or plan.straps or plan.seamed)
    knots = columns * int(np.count_nonzero(model.bag.node_row >= 0))
    return (columns == 1 or all_alike) and knots <= MOST_KNOTS[plan.model.contact]


def _repeats(model: BagModel) -> int:
    """Sectors of a model side by side that have whole meshes of its layers."""
    sectors = model.bag.net.sectors
    return sectors // gcd(sectors, *(layer.meshes_round for layer in model.plan.layer))


def in_contact(
    model: BagModel,
    case: Case,
    problem: Problem,
    solution: Solution,
    starts: tuple[float, ...] = NEAR,
    progress: Progress | None = None,
) -> tuple[Bag, Problem, Solution] | None:
    """The bag of a model that ``can_slide`` and its layers as nets in a sector with whole meshes of all, at rest.

    It starts from the equilibrium of the model, whose layers move with the netting below, these ``NEAR`` or ``FAR``
    outside of it; None where all of these starts are pierced.
    """
    plan, columns, start = model.plan, _repeats(model), solution
    below = build_bag(plan.model_copy(update={"layer": ()}), sectors=columns, smeared=model.smeared)
    if columns > 1:
        start = all_round_start(model.bag, solution.positions, solution.bar_tension, columns)
    water = uniform_flow(plan.tow.water_density_kg_m3, np.array([case.speed_m_s, 0.0, 0.0]))
    law = ContactLaw.pressing(BEGINS_M, PUSH * solution.mean_tension)
    tensions = [max(float(rows.bar_tension_n.mean()), 1.0) for rows in measure_layers(model.bag, problem, solution)]
    for outside in starts:
        both, led = _beside_each_other(plan, below, start, tensions, outside)
        catch = catch_of(both, plan, case)._replace(weight_density=problem.loading.catch.weight_density)
        pressed = Problem.of(both.net, water=water, weight=problem.net.order == 1, catch=catch, contact=law)
        if passage(pressed, led.positions) is None:
            steps = GentleSettings(min(STEPS, WORK // int(np.count_nonzero(below.node_row >= 0))))
            led = replace(led, report=solution.report)
            return both, pressed, gentle.solve(pressed, plan.model.tolerance, led, steps, progress)
    return None


def _beside_each_other(
    plan: Plan, below: Bag, start: Solution, tensions: list[float], outside: float
) -> tuple[Bag, Solution]:
    """The netting below and its layers as one net, each that much outside of the one before, which begins no later."""
    net, positions, tension = below.net, start.positions, start.bar_tension
    within = sorted(range(len(plan.layer)), key=lambda number: _rows_below(plan, plan.layer[number]))
    for depth, number in enumerate(within):
        layer = plan.layer[number]
        own = _layer_bag(plan, layer, below, start.positions, (1 + depth) * outside)
        bars = len(net.bars)
        net, beside = _laced(net, below, below.bands - _rows_below(plan, layer), own)
        positions = np.concatenate([positions, beside])
        tension = np.append(tension, np.full(len(net.bars) - bars, tensions[number]))
    return around(below, net, 0), replace(start, positions=positions, bar_tension=tension)


def _laced(net: Net, below: Bag, row: int, own: Bag) -> tuple[Net, Floats]:
    """A net with a layer laced to a row of the netting below and to its codline, and where its new nodes start."""
    laced, turn = _round_in_order(below, row)
    entry, own_turn = _round_in_order(own, 0)
    bars, number = own.net.bars, np.full(len(own.net.positions), -1)
    number[entry] = laced[np.arange(len(entry)) * len(laced) // len(entry)]
    across = (own.node_row[bars] == 0).all(axis=1) & (own.net.bar_image == 0) & own.net.bar_is_strut
    number[bars[across, 1]] = number[bars[across, 0]]
    number[own.node_row == own.bands] = np.flatnonzero(below.node_row == below.bands)
    new = number < 0
    number[new] = len(net.positions) + np.arange(np.count_nonzero(new))
    beside = rotate(own.net.positions[new], (turn[0] - own_turn[0]) / (2.0 * np.pi), 1.0)
    wider = replace(
        net,
        positions=np.concatenate([net.positions, beside]),
        fixed=np.concatenate([net.fixed, own.net.fixed[new]]),
    )
    kept = np.flatnonzero(~across)
    values = {name: getattr(own.net, name)[kept] for name in ("bar_length", "bar_flexibility", "bar_is_strut")}
    return with_bars(
        wider, number[bars[kept]], own.net.bar_image[kept], bar_density=own.net.bar_density[kept], **values
    ), beside


def _round_in_order(bag: Bag, row: int) -> tuple[Ints, Floats]:
    """Nodes of a row by their azimuths, and these, rad; a sector's lie within half a turn of each other."""
    nodes = np.flatnonzero(bag.node_row == row)
    azimuth = np.arctan2(*bag.net.positions[nodes, :0:-1].T)
    first = np.angle(np.exp(1j * (azimuth - azimuth[0])))
    order = np.argsort(first, kind="stable")
    return nodes[order].astype(np.int32), azimuth[0] + first[order]


def _rows_below(plan: Plan, layer: Layer) -> int:
    """Rows of the netting below that a layer lies over."""
    rows = plan.rows_to_codline(layer.meshes_from_codline[1])
    assert rows is not None  # what a plan is asked
    return rows


def _layer_bag(plan: Plan, layer: Layer, below: Bag, positions: Floats, outside: float) -> Bag:
    """A layer as a sector as wide as the netting below, that much outside of where this is."""
    first = below.bands - _rows_below(plan, layer)
    rings = [np.flatnonzero(below.node_row == row) for row in range(first, below.bands + 1)]
    below_x = np.array([positions[ring, 0].mean() for ring in rings])
    below_radius = np.array([np.hypot(*positions[ring, 1:].T).max() for ring in rings])
    rows = np.linspace(0.0, 1.0, int(layer.rows_per_mesh * layer.meshes_long) + 1)
    share = np.linspace(0.0, 1.0, len(rings))
    x, radius = np.interp(rows, share, below_x), np.interp(rows, share, below_radius)
    # it starts behind the netting below as well, all but the codline
    x[:-1] = x[0] + (1.0 + outside) * (x[:-1] - x[0])
    for row in range(1, len(x) - 1):
        beside = (below_x >= min(x[row - 1], below_x[-3])) & (below_x <= max(x[row - 1], x[row + 1]))
        radius[row] = (1.0 + outside) * below_radius[beside].max(initial=radius[row])
    whole = plan.to_dict()
    outer = layer.model_dump(mode="json", exclude_none=True, exclude={"meshes_from_codline"})
    # its first row is one of the netting below: how wide it is counts for nothing
    entry = {"radius_m": min(float(radius[0]), 0.5 * layer.stretched_radius_m)}
    tables = {key: value for key, value in whole.items() if key in ("title", "tow")}
    alone = plan_from_dict(tables | {"entry": entry, "netting": [outer], "catch": {"filled_meshes": 0.5}})
    return build_bag(alone, sectors=layer.meshes_round // below.net.sectors, rows=(x, radius))
