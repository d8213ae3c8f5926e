"""Wrinkles of commercial codends, and whether errors cover them: a section of the validation report."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from codend.report.style import new_figure
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from validation.report import markdown_table
from validation.section import Picture, Section, Verdict
from validation.shaken import largest_over_error, table_of
from validation.wrinkles.matrix import commercial, matrix

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LAW_SEED, LAW_NETS, QUICK_NETS = 1000, 30, 6
"""First of the nets on which the law was not found, seeds tried, and of them in the quick report."""
SAME = 2e-4
"""Relative change of drag within which a followed shape counts as the symmetric one's."""


def section(quick: bool) -> Section:
    """The commercial matrix, the law on nets it was not found on, and two wrinkled nets."""
    table = matrix(quick)
    law = table_of(QUICK_NETS if quick else LAW_NETS, LAW_SEED)
    pictures = () if quick else tuple(_pictures())
    return Section(
        "Wrinkles",
        _text(table, law),
        pictures=pictures,
        data={"wrinkles_commercial": table, "wrinkles_law": law},
        verdicts=_verdicts(table, law),
    )


def _text(table: pd.DataFrame, law: pd.DataFrame) -> str:
    headers = (
        "netting", "round", "EI N m²", "kg", "stable", "drag N", "opening °", "followed: meshes wide", "drag N",
        "opening °", "spread N", "spread °", "layers meet", "whole net, 2 x 2 merged, shaken: ends", "drag changes",
        "opening changes °",
    )  # fmt: skip
    rows = [
        (
            r.mesh, str(r.meshes_round), f"{r.bending_n_m2:g}", f"{r.catch_kg:g}", r.stable,
            f"{r.drag_n:.2f} ± {r.drag_error_n:.2g}", f"{r.opening_deg:.2f} ± {r.opening_error_deg:.2g}",
            str(r.followed_meshes), f"{r.followed_drag_n:.2f}", f"{r.followed_opening_deg:.2f}",
            _number(r.drag_spread_n), _number(r.opening_spread_deg), r.folds, r.whole_ends,
            "" if np.isnan(r.whole_drag_change) else f"{100.0 * r.whole_drag_change:.3f} %",
            _number(r.whole_opening_change_deg),
        )
        for r in table.itertuples()
    ]  # fmt: skip
    return "\n\n".join(
        [
            "Codends of 50 meshes long, full mesh 120 mm, knots of 15 mm, double 4 mm twine of EA 2 kN, at 1.5 m/s "
            "with an entry of 0.4 m radius (all ASSUMED), by the symmetric sector, by following what grows "
            "(`model.wrinkles = true`) and as a whole net shaken by 1 % of a bar and followed gently. Where layers "
            "meet, contact acts between them: the section Folds has more of these rows.",
            markdown_table(headers, rows),
            "The law of the errors (`codend/equilibrium/wrinkles.py`) on small unstable nets it was not found on, "
            "shaken whole from three seeds: largest changes from the symmetric shape, and over the errors stated.",
            markdown_table(
                tuple(law.columns),
                [tuple(f"{v:.3g}" if isinstance(v, float) else str(v) for v in r) for r in law.to_numpy()],
            ),
        ]
    )


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.2g}"


def _verdicts(table: pd.DataFrame, law: pd.DataFrame) -> tuple[Verdict, ...]:
    limp = table[(table["mesh"] == "diamond") & (table["bending_n_m2"] == 0.0)]
    moved = (limp["followed_drag_n"] / limp["drag_n"] - 1.0).abs().max()
    shapes = table[table["followed_meshes"] > 1]
    off = ((shapes["followed_drag_n"] - shapes["drag_n"]).abs() / shapes["drag_error_n"]).max()
    opened = ((shapes["followed_opening_deg"] - shapes["opening_deg"]).abs() / shapes["opening_error_deg"]).max()
    whole = table[table["whole_ends"] == "settled"]
    whole_off = (whole["whole_drag_change"].abs() * whole["drag_n"] / whole["drag_error_n"]).max()
    over = largest_over_error(law)
    return (
        Verdict(
            "Limp diamond codends are stable and keep their symmetric answers",
            bool((limp["stable"] == "yes").all() and moved == 0.0),
            f"{len(limp)} codends, largest change {moved:.1e}",
        ),
        Verdict(
            "Followed commercial codends lie within the errors of their symmetric shapes",
            bool(max(np.nan_to_num(off), np.nan_to_num(opened)) <= 1.0),
            f"{len(shapes)} codends, largest change over its error {off:.3f} in drag, {opened:.3f} in opening",
        ),
        Verdict(
            "Whole commercial codends, shaken by 1 % of a bar, lie within them too",
            bool(np.nan_to_num(whole_off) <= 1.0),
            f"{len(whole)} codends that settle, largest change over its error {whole_off:.3f} in drag",
        ),
        Verdict(
            "Errors cover what wrinkles change on nets on which their law was not found",
            over <= 1.0,
            f"{len(law)} unstable nets, largest change over its error {over:.2f}",
        ),
    )


def _pictures() -> list[Picture]:
    """Two codends in waves, seen along the axis: rings of knots of the followed shapes."""
    drawn = (
        ("wrinkled_t0", commercial("diamond", 100, 2e-3, 300.0, wrinkles=True), "diamond netting of EI 2e-3 N m²"),
        ("wrinkled_t90", commercial("t90", 50, 5e-4, 300.0, wrinkles=True), "T90 netting of EI 5e-4 N m²"),
    )
    found = []
    for name, plan, what in drawn:
        result = solve(plan).cases[0]
        caption = (
            f"Rings of knots near the codline of a codend of {what}, {plan.netting[0].meshes_round} meshes round, "
            f"with 300 kg, seen along the axis: {result.followed.reason}. Drag {result.measures.drag_n:.2f} N."
        )
        found.append(Picture(name, rings_figure(result), caption))
    return found


def rings_figure(result: CaseResult, rings: int = 8) -> "Figure":
    """The last rings of knots of a solved case, seen along the axis, and how far knots lie off the mean of theirs."""
    from matplotlib import colormaps

    figure = new_figure(10.0, 5.0)
    seen, off = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
    order, bag = result.net.order, result.bag
    turn = np.exp(2j * np.pi * np.arange(order) / order)
    for number in range(rings):
        row = bag.bands - 1 - number
        knots = np.flatnonzero(bag.node_row == row)
        across = (turn[:, None] * (result.positions[knots, 1] + 1j * result.positions[knots, 2])).ravel()
        built = (turn[:, None] * (bag.net.positions[knots, 1] + 1j * bag.net.positions[knots, 2])).ravel()
        along = np.tile(result.positions[knots, 0], order)
        by_azimuth = np.argsort(np.angle(built))
        ring, x = across[by_azimuth], along[by_azimuth]
        colour = colormaps["viridis"](number / rings)
        closed = np.append(ring, ring[0])
        seen.plot(1e3 * closed.real, 1e3 * closed.imag, ".-", ms=2.5, lw=0.8, color=colour)
        off.plot(
            np.degrees(np.angle(ring * np.exp(-1j * np.angle(ring[0])))) % 360.0,
            1e3 * np.hypot(np.abs(ring) - np.abs(ring).mean(), x - x.mean())
            * np.sign(np.abs(ring) - np.abs(ring).mean()),
            ".", ms=3.5, color=colour, label=f"{(number + 1) / 2:g}",
        )  # fmt: skip
    seen.set_aspect("equal")
    seen.set(xlabel="y (mm)", ylabel="z (mm)")
    off.set(xlim=(0.0, 60.0), xlabel="azimuth (degrees)", ylabel="knots off the mean of their ring (mm)")
    off.legend(title="meshes from\nthe codline", frameon=False, loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure
