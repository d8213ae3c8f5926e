"""A second layer as a net of its own, in contact without friction with the netting below, in a sector.

It is laced to the row of the netting below where it begins and gathered by the same codline. It slides, and the netting
below stands out through its meshes. No drag acts on its twine, as where it moves with the netting below.
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
from codend.net.net import Floats, Ints, rotate, with_bars
from codend.plan.plan import Case, Plan, plan_from_dict
from codend.solvers import gentle
from codend.solvers.gentle import GentleSettings
from codend.solvers.outcome import Progress, Solution
from codend.solvers.refusal import passage

BEGINS_M = 1e-3
"""Distance at which contact begins."""
PUSH = 5.0
"""Force of parts at half of that on each other, over the mean tension: with a tenth fewer layers came to rest."""
OUTSIDE = 0.15
"""Share by which the layer starts outside of the netting below."""
STEPS = 1500
WORK = 200_000
"""Most steps times knots of the netting below: some 15 s. Layers that come to rest mostly do so in far fewer."""


MOST_KNOTS = {"auto": 300, True: 1200, False: 0}
"""Of the netting below in a sector with whole meshes of both, by ``model.contact``: 300 take up to some 6 s."""


def can_slide(model: BagModel) -> bool:
    """Whether the layer of a model can be a net of its own: one alone, in a sector of both that is not too wide.

    Nets with ropes, straps, seams or several counts cannot, nor merged ones, nor layers whose knots lie across.
    """
    plan = model.plan
    plain = not (plan.ropes or plan.straps or plan.seamed or plan.window or plan.tapers) and len(plan.layer) == 1
    counts = {part.meshes_round for part in plan.netting}
    one = plain and len(counts) == 1 and model.globalisation == 1 and model.sectors == 1 and model.near is None
    one = one and plan.model.bars_per_side == 1 and plan.layer[0].knot_across_m == 0.0
    return one and _columns(plan)[0] * model.bag.bands <= MOST_KNOTS[plan.model.contact]


def _columns(plan: Plan) -> tuple[int, int]:
    """Meshes round of the netting below and of the layer in the narrowest sector with whole meshes of both."""
    counts = plan.netting[0].meshes_round, plan.layer[0].meshes_round
    shared = gcd(*counts)
    return counts[0] // shared, counts[1] // shared


def in_contact(
    model: BagModel, case: Case, problem: Problem, solution: Solution, progress: Progress | None = None
) -> tuple[Bag, Problem, Solution] | None:
    """The bag of a model that ``can_slide`` and its layer as two nets in a sector with whole meshes of both, at rest.

    The start is the equilibrium of the model, whose layer moves with the netting below; None where it is pierced.
    """
    plan = model.plan
    columns, of_layer = _columns(plan)
    below = build_bag(plan.model_copy(update={"layer": ()}), sectors=columns)
    start = all_round_start(model.bag, solution.positions, solution.bar_tension, columns)
    own, tension = _layer_net(plan, model.bag, problem, solution, of_layer)
    # its entry is a row of the netting below, its codline that one's
    nodes, mine = len(below.net.positions), len(own.net.positions)
    laced, turn = _round_in_order(below, below.bands - _rows_below(plan))
    entry, own_turn = _round_in_order(own, 0)
    number = np.full(mine, -1)
    number[entry] = laced[np.arange(len(entry)) * len(laced) // len(entry)]
    number[own.node_row == own.bands] = np.flatnonzero(below.node_row == below.bands)
    new = number < 0
    number[new] = nodes + np.arange(np.count_nonzero(new))
    beside = rotate(own.net.positions[new], (turn[0] - own_turn[0]) / (2.0 * np.pi), 1.0)
    net = replace(
        below.net,
        positions=np.concatenate([below.net.positions, beside]),
        fixed=np.concatenate([below.net.fixed, own.net.fixed[new]]),
    )
    net = with_bars(
        net,
        number[own.net.bars],
        own.net.bar_image,
        bar_length=own.net.bar_length,
        bar_flexibility=own.net.bar_flexibility,
        bar_density=np.nan,
    )
    both = around(below, net, 0)
    pressed = Problem.of(
        both.net,
        water=uniform_flow(plan.tow.water_density_kg_m3, np.array([case.speed_m_s, 0.0, 0.0])),
        catch=catch_of(both, plan, case),
        contact=ContactLaw.pressing(BEGINS_M, PUSH * solution.mean_tension),
    )
    led = replace(
        start,
        positions=np.concatenate([start.positions, beside]),
        bar_tension=np.concatenate([start.bar_tension, tension]),
        report=solution.report,
    )
    if passage(pressed, led.positions) is not None:
        return None
    steps = GentleSettings(min(STEPS, WORK // int((below.node_row >= 0).sum())))
    return both, pressed, gentle.solve(pressed, plan.model.tolerance, led, steps, progress)


def _round_in_order(bag: Bag, row: int) -> tuple[Ints, Floats]:
    """Nodes of a row by their azimuths, and these, rad; a sector's lie within half a turn of each other."""
    nodes = np.flatnonzero(bag.node_row == row)
    azimuth = np.arctan2(*bag.net.positions[nodes, :0:-1].T)
    first = np.angle(np.exp(1j * (azimuth - azimuth[0])))
    order = np.argsort(first, kind="stable")
    return nodes[order].astype(np.int32), azimuth[0] + first[order]


def _rows_below(plan: Plan) -> int:
    """Rows of the netting below that the layer lies over."""
    rows = plan.rows_to_codline(plan.layer[0].meshes_from_codline[1])
    assert rows is not None  # what a plan is asked
    return rows


def _layer_net(plan: Plan, bag: Bag, problem: Problem, solution: Solution, columns: int) -> tuple[Bag, Floats]:
    """The layer as a sector so wide, a little outside of the netting below, and the tension it starts with, N."""
    layer, positions = plan.layer[0], solution.positions
    first = bag.bands - _rows_below(plan)
    ring = [np.flatnonzero(bag.node_row == row)[0] for row in range(first, bag.bands + 1)]
    rows = np.linspace(0.0, 1.0, int(layer.rows_per_mesh * layer.meshes_long) + 1)
    share = np.linspace(0.0, 1.0, len(ring))
    below_x, below_radius = positions[ring, 0], np.hypot(*positions[ring, 1:].T)
    x, radius = np.interp(rows, share, below_x), np.interp(rows, share, below_radius)
    # it starts behind the netting below as well, all but the codline
    x[:-1] = x[0] + (1.0 + OUTSIDE) * (x[:-1] - x[0])
    for row in range(1, len(x) - 1):
        beside = (below_x >= min(x[row - 1], below_x[-3])) & (below_x <= max(x[row - 1], x[row + 1]))
        radius[row] = (1.0 + OUTSIDE) * below_radius[beside].max(initial=radius[row])
    whole = plan.to_dict()
    outer = {key: value for key, value in whole["layer"][0].items() if key != "meshes_from_codline"}
    # its first row is one of the netting below: how wide it is counts for nothing
    entry = {"radius_m": min(float(radius[0]), 0.5 * layer.stretched_radius_m)}
    tables = {key: value for key, value in whole.items() if key in ("title", "tow")}
    alone = plan_from_dict(tables | {"entry": entry, "netting": [outer], "catch": {"filled_meshes": 0.5}})
    own = build_bag(alone, sectors=columns, rows=(x, radius))
    (told,) = measure_layers(bag, problem, solution)
    return own, np.full(len(own.net.bars), max(float(told.bar_tension_n.mean()), 1.0))
