"""Round straps: rings of rope bars through the knots of a row.

A strap through the N knots of a row is a polygon of N sides s, its corners on a circle of radius R. Merged knots lie on
that same circle, fewer and with longer sides between them. Their rope carries the tension that does the same work when
R changes, N T ds/dR, and stretches as the real one does at that R (derived).

A strap can be too short for the netting it holds, whatever the loads. Lengths of inextensible twine and rope are bounds
on distances, and a mean of two nets keeps what both keep: if any net fits, then so does the mean of all its turns and
mirror images, and that net is the same all round. Seen along the axis it is a row of circles, from the entry's, which
is held, to the strap's, and every band between takes the radius down by no more than its bars reach when they lie flat
(derived; ``plan_reach``). The codline asks for no width, and too long a strap is slack.
"""

from dataclasses import replace

import numpy as np

from codend.bag.bag import Bag, around
from codend.errors import InputError
from codend.net.net import with_bars
from codend.netting.knots import LEFT, RIGHT, Knots
from codend.plan.plan import Plan
from codend.plan.reach import least_radius_m
from codend.plan.tables import Strap


def with_straps(bag: Bag, plan: Plan, knots: Knots, drag: tuple[int, float, float]) -> Bag:
    """The bag with the straps of its plan, their bars after all others.

    Where the knots of a row lie across the netting (T90) a strap runs from knot to knot, and the knots close its ring.

    Raises:
        InputError: a strap is shorter than the netting of its row allows.
    """
    for index, strap in enumerate(plan.straps):
        row = knots.lattice.bands - round(plan.strap_rows[index] / knots.lattice.globalisation)
        across_m = knots.lattice.section(row - 1).knot_m if knots.across[row] else 0.0
        _check_length(plan, index, knots, row, across_m)
        bag = _with_strap(bag, strap, knots, row, across_m, drag)
    return bag


def _check_length(plan: Plan, index: int, knots: Knots, row: int, across_m: float) -> None:
    """Refuse a strap too short for the knots of its row, for their twines, or for the netting from the entry."""
    lattice, strap = knots.lattice, plan.straps[index]
    section = lattice.section(row - 1)
    real = lattice.globalisation * lattice.order * int(lattice.knots[row])
    # the circle round the sections of the twines that pass through the ring, two from a knot or in square mesh one
    bundle_m = np.pi * section.solid_diameter_m * np.sqrt(section.rows_per_mesh * real)
    bounds = [(real * across_m, "the knots of its row laid side by side"), (bundle_m, "round the twines of its row")]
    radius = least_radius_m(plan.netting, plan.entry_radius_m, plan.strap_rows[index])
    if strap.axial_stiffness_n is None and radius > across_m:
        side = _side_and_slope(radius, real, across_m)[0]
        bounds.append((real * (side + across_m), "as far as the netting from the entry reaches inwards"))
    least_m, reason = max(bounds)
    if strap.around_m <= least_m:
        allowed = f"above {least_m:.4g} m, {reason}"
        raise InputError(file=plan.source, key=f"strap.{index}.length_m", value=strap.around_m, allowed=allowed)


def _with_strap(bag: Bag, strap: Strap, knots: Knots, row: int, across_m: float, drag: tuple[int, float, float]) -> Bag:
    lattice, g = knots.lattice, knots.lattice.globalisation
    rows, count = lattice.rings(np.array([row]))
    first = knots.ring(RIGHT, rows, count, lattice.knots[rows])
    second = knots.ring(LEFT, rows, count + 1, lattice.knots[rows])
    bars = len(count)

    merged = lattice.order * bars
    real = g * merged
    side = strap.around_m / real - across_m
    # the triangle of one side and one knot, their corners on the circle
    across_both = np.sqrt(side**2 + across_m**2 + 2.0 * side * across_m * np.cos(np.pi / real))
    radius = across_both / (2.0 * np.sin(np.pi / real))
    slope = _side_and_slope(radius, real, across_m)[1]
    merged_side, merged_slope = _side_and_slope(radius, merged, g * across_m)
    gain = real * slope / (merged * merged_slope)
    softness = 0.0 if strap.axial_stiffness_n is None else 1.0 / strap.axial_stiffness_n
    flexibility = softness * merged_slope * side / (slope * merged_side * gain)
    longer = strap.around_m / (merged * merged_side)

    roped = with_bars(
        bag.net,
        np.stack([first.node, second.node], axis=1),
        second.image - first.image,
        bar_length=merged_side,
        bar_flexibility=flexibility,
        bar_drag_diameter=longer * strap.diameter_m,
        bar_solid_diameter=float(np.sqrt(longer)) * strap.diameter_m,
        bar_density=np.nan if strap.density_kg_m3 is None else strap.density_kg_m3,
        bar_diameter=strap.diameter_m,
        bar_is_rope=True,
        bar_drag_law=drag[0],
        bar_normal_drag=drag[1],
        bar_tangential_drag=drag[2],
    )
    own = np.arange(len(bag.bar_band), len(roped.bars), dtype=np.int32)
    return replace(
        around(bag, roped, row - 1),
        straps=np.append(bag.straps, own),
        strap_share=np.append(bag.strap_share, np.full(bars, 1.0 / gain)),
    )


def _side_and_slope(radius: float, knots: float, across_m: float) -> tuple[float, float]:
    """Side between two of the knots of a ring on a circle, each ``across_m`` wide, and its derivative by the radius."""
    half = np.arcsin(0.5 * across_m / radius)
    between = np.pi / knots - half
    slope = 2.0 * np.sin(between) + across_m / radius * np.cos(between) / np.cos(half)
    return float(2.0 * radius * np.sin(between)), float(slope)
