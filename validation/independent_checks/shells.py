"""Sector nets of every kind of knotted netting against their shell equations, over the number of meshes round.

The shell equations (``codend.bag.meridian``) are solved by collocation; no net of bars is involved. Where the knots lie
along the netting (hexagonal meshes) the shell spreads them evenly over a row, while the net has each at the aft end of
its row: a difference of the order of half a knot, which falls with the first order only, is to be expected there.
"""

from collections.abc import Mapping
from functools import cache, partial
from types import MappingProxyType

import numpy as np
import pandas as pd

from codend.bag.meridian import MeridianShape, plan_case
from codend.report.style import INK, dress, new_figure
from validation.independent_checks.bags import bag, solved
from validation.independent_checks.check import Check, Convergence, Theme, convergence_table, draw_convergence
from validation.section import Picture

MESHES_ROUND = (40, 80, 160, 320)
KINDS: Mapping[str, Mapping[str, float | str | bool]] = MappingProxyType(
    {
        "diamond": {"bare": False},
        "hexagonal": {"bare": False, "knot_share": 0.15, "stiffness": 1e4},
        "hexagonal, bare": {"knot_share": 0.15},
        "T90": {"bare": False, "mesh": "t90", "knot_share": 0.15, "stiffness": 1e4},
        "T90, bare": {"mesh": "t90", "knot_share": 0.15},
    }
)


@cache
def shell(kind: str, meshes_round: int) -> MeridianShape:
    """The same bag by the shell equations."""
    plan = bag(meshes_round, **KINDS[kind])  # type: ignore[arg-type]
    shape = plan_case.solve_case(plan, plan.cases()[0])
    if not shape.converged:
        raise RuntimeError(shape.outcome.value)
    return shape


def _shell_error(kind: str, meshes_round: int) -> float:
    """Largest relative difference of drag, volume, length and radius at the front."""
    right, found = shell(kind, meshes_round), solved(meshes_round, **KINDS[kind]).measures
    pairs = (
        (found.drag_n, right.drag_n),
        (found.catch_volume_m3, right.catch_volume_m3),
        (found.length_m, right.length_m),
        (found.front_radius_m, right.front_radius_m),
    )
    return max(abs(value / other - 1.0) for value, other in pairs)


def _pull_times_row_length(meshes_round: int) -> float:
    """Spread of T cos phi (b cos phi + l), which is the same from entry to codline with knots along the netting."""
    result = solved(meshes_round, **KINDS["hexagonal, bare"])
    bag, net, radius = result.bag, result.net, np.hypot(result.positions[:, 1], result.positions[:, 2])
    twine = bag.bar_is_twine
    bar, knot = float(net.bar_length[twine][0]), float(net.bar_length[~twine][0])
    band = bag.bar_band[twine]
    tension, middle = (
        np.bincount(band, weights=values) / np.bincount(band)
        for values in (result.bar_tension_n[twine], radius[net.bars[twine]].mean(axis=1))
    )
    cosine = np.sqrt(1.0 - (middle * np.pi / (meshes_round * bar)) ** 2)
    product = (tension * cosine * (bar * cosine + knot))[: int(0.9 * bag.bands)]
    return float(np.abs(product / product.mean() - 1.0).max())


FAMILIES = tuple(Convergence(kind, partial(_shell_error, kind), MESHES_ROUND, "meshes round") for kind in KINDS)
PULL = Convergence("pull times row length", _pull_times_row_length, MESHES_ROUND, "meshes round")
_SOURCE = "shell equations, by collocation"


def _checks_of(family: Convergence) -> tuple[Check, Check]:
    claim = f"Drag, volume, length and front of a {family.label} net are its shell's"
    if not family.label.startswith("hexagonal"):
        return family.checks(claim, _SOURCE, 1e-4)
    near, _ = family.checks(claim, _SOURCE, 5e-4)
    falls = Check(
        f"{claim}: the error falls with order 1 or better",
        "the order is found by fit",
        0.05,
        lambda _: float(np.maximum(0.0, 1.0 - family.order)),
        "short of order 1 by {error:.2f}, allowed {tolerance:g}",
    )
    return near, falls


CHECKS = (
    *(check for family in FAMILIES for check in _checks_of(family)),
    *PULL.checks("Meridional pull times row length is the same all along a hexagonal net", "derived", 1e-5),
)


def pictures() -> tuple[Picture, ...]:
    """Meridians of nets on those of their shells, and the fall of the differences."""
    figure = new_figure(9.0, 6.4)
    shapes, errors = figure.subplots(2, 1, height_ratios=(1.0, 1.7))
    coarsest = MESHES_ROUND[0]
    for number, (kind, options) in enumerate(KINDS.items()):
        right, rows = shell(kind, coarsest), solved(coarsest, **options).rows
        shapes.plot(right.x_m, right.radius_m, lw=1.0, color=f"C{number}")
        shapes.plot(rows.x_m, rows.radius_m, "o", ms=2.5, color=f"C{number}")
    for marker, line, label in (("o", "", f"nets, {coarsest} meshes round"), ("", "-", "shells")):
        shapes.plot([], [], marker=marker, ls=line, ms=3, color=INK, label=label)
    shapes.set(xlabel="x from the entry (m)", ylabel="radius (m)", aspect="equal")
    shapes.set_ylim(0.0, 1.6)
    dress(shapes)
    shapes.legend(frameon=False, fontsize="small", loc="upper left")
    draw_convergence(errors, (*FAMILIES, PULL), "meshes round")
    caption = (
        "Above: rows of nets (dots) on the meridians of their shells (lines), colours as below. Below: largest "
        "relative difference of drag, catch volume, length and radius at the front between net and shell, and the "
        "spread of pull times row length in the bare hexagonal net, against the number of meshes round."
    )
    return (Picture("shells", figure, caption),)


def data() -> dict[str, pd.DataFrame]:
    """What the right panel shows."""
    return {"shells": convergence_table((*FAMILIES, PULL), "meshes_round")}


THEME = Theme(
    "Nets against their shells",
    "Diamond, hexagonal (diamond with knots along the netting) and T90 nets, with elastic twine, sphere pressure and "
    "twine drag, or bare, against the shell equations of the same bag. The shell spreads knots along the netting "
    "evenly over a row, the net has each at the aft end of its row: a difference of the order of half a knot is to be "
    "expected, so hexagonal nets need only come to their shells with the first order, the others with the second.",
    CHECKS,
    pictures,
    data,
)
