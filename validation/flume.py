"""The flume case of Le Bris et al. (1999, section 5): drag against catch, by parts, and flume tables beside it.

Their figure 11 sets computed drag beside drag measured in the flume, and says that the measured drag includes that of
the hoop the codend hangs from. It prints no numbers, so nothing here is measured: the table compared with is computed
by the meridian method, and the hoop's drag is computed for a rod of assumed thickness.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from codend.plan.plan import load_plan
from codend.report.drag_plot import PARTS
from codend.report.style import INK, dress, new_figure
from codend.studies import study
from codend.studies.comparison import Comparison, Hoop, compare, read_flume_table
from validation.report import markdown_table
from validation.section import Picture, Section, Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HERE = Path(__file__).parent
CASE, TABLE = HERE / "cases" / "flume_150x140.toml", HERE / "tables" / "flume_150x140_meridian.csv"
ROD_M, ROD_RANGE_M = 0.010, (0.005, 0.020)
"""Thickness of the hoop's rod, ASSUMED: no source at hand prints it."""
HOOP_GREEN = "#009e73"
LARGEST = {
    "drag_n": 5e-4,
    "front_from_codline_m": 1e-3,
    "max_diameter_m": 5e-4,
    "length_m": 1e-4,
    "catch_volume_m3": 2e-3,
}
"""Largest relative differences allowed between net and table: 150 bars round against a smooth skin."""
NAMES = {
    "drag_n": "drag",
    "front_from_codline_m": "front from codline",
    "max_diameter_m": "largest diameter",
    "length_m": "length",
    "catch_volume_m3": "catch volume",
}


def section(quick: bool) -> Section:
    """The flume case on a sector of the real net, its drag by parts, and the table beside it; quick in any case."""
    plan = load_plan(CASE)
    solved = study.solve(plan)
    (speed,) = plan.tow.speed_m_s
    hoop, *of_range = (Hoop(plan.entry_radius_m, rod, plan.tow.water_density_kg_m3) for rod in (ROD_M, *ROD_RANGE_M))
    drag = solved.table[
        ["filled_meshes", "catch_volume_m3", "catch_mass_kg", *(column for column, *_ in PARTS)]
    ].assign(hoop_drag_assumed_rod_n=hoop.drag_n(np.full(len(solved.cases), speed)))
    drag["drag_with_assumed_hoop_n"] = drag["drag_n"] + drag["hoop_drag_assumed_rod_n"]
    comparison = compare(solved.table, read_flume_table(TABLE))
    low, high = (float(h.drag_n(np.array(speed))) for h in of_range)
    picture = Picture(
        "flume_drag",
        _figure(drag, (low, high), comparison),
        f"Drag of the flume case at {speed:g} m/s against the catch, as in figure 11 of Le Bris et al. (1999). Lines: "
        "computed on one sector of the real net. Circles: COMPUTED by the meridian method, not measured. The hoop is a "
        f"term of its own, COMPUTED for a rod ASSUMED {1000 * ROD_M:g} mm thick (band: {1000 * ROD_RANGE_M[0]:g} to "
        f"{1000 * ROD_RANGE_M[1]:g} mm).",
    )
    return Section(
        "Flume case: drag against catch",
        _text(drag, comparison, (low, high)),
        (picture,),
        {"flume_drag": drag, "flume_comparison": comparison.points, "flume_comparison_summary": comparison.summary},
        (*_balance_verdicts(solved), *(_verdict(comparison, name, most) for name, most in LARGEST.items())),
    )


def _text(drag: pd.DataFrame, comparison: Comparison, of_range: tuple[float, float]) -> str:
    hoop = float(drag["hoop_drag_assumed_rod_n"].iloc[0])
    share = hoop / drag["drag_n"]
    rows = [[f"{value:.4g}" for value in row] for row in drag.itertuples(index=False)]
    headers = (
        "filled meshes",
        "volume m³",
        "mass kg",
        "drag N",
        "by the catch N",
        "by the twine N",
        "hoop (assumed rod) N",
    )
    return "\n\n".join(
        [
            "The half-scale codend of 150 x 140 meshes that Le Bris et al. (1999, section 5) computed and that DIFTA "
            "towed in a flume; what their paper does not print is assumed, as marked in "
            "`validation/cases/flume_150x140.toml`.",
            "Their figure 11 shows measured drag a little above computed drag, and they say that the measured drag "
            "includes that of the hoop the codend hangs from. **The figure prints no numbers, and no source at hand "
            "does: no measured flume table ships with this project.** What a table must say of its source to be called "
            "measured is in `validation/tables/README.md`.",
            "So the hoop is a *computed* term here, a round rod across the flow, 1/2 ρ V² Cd d 2πR with Cd = "
            f"{Hoop.drag_coefficient:g} and an **assumed** rod of {1000 * ROD_M:g} mm: {hoop:.1f} N, "
            f"{100 * share.min():.1f} to {100 * share.max():.1f} % of the codend's drag ({of_range[0]:.1f} N with "
            f"{1000 * ROD_RANGE_M[0]:g} mm, {of_range[1]:.1f} N with {1000 * ROD_RANGE_M[1]:g} mm).",
            "![flume_drag]",
            markdown_table((*headers, "with hoop N"), rows),
            f"Beside the table `{comparison.table.path.name}` ({comparison.table.origin}):",
            markdown_table(
                ("quantity", "points", "bias", "RMS", "largest difference"),
                [
                    (NAMES[r.quantity], str(r.points), *(f"{100 * v:.3f} %" for v in r[5:8]))
                    for r in comparison.summary.itertuples(index=False)
                ],
            ),
        ]
    )


def _balance_verdicts(solved: study.Study) -> tuple[Verdict, ...]:
    table = solved.table
    parts = float((table["catch_drag_n"] + table["twine_drag_n"] - table["drag_n"]).abs().max() / table["drag_n"].max())
    entry = float((table["entry_reaction_n"] / table["drag_n"] - 1.0).abs().max())
    tolerance = solved.plan.model.tolerance
    return (
        Verdict(
            "Every catch of the flume case is solved", solved.converged, f"{int(table['converged'].sum())} catches"
        ),
        Verdict("Drag by the catch and by the twine add up to the drag", parts <= 1e-12, f"largest error {parts:.1e}"),
        Verdict(
            "The pull on the hoop is the drag",
            entry <= tolerance,
            f"largest error {entry:.1e}, tolerance {tolerance:.0e}",
        ),
    )


def _verdict(comparison: Comparison, quantity: str, most: float) -> Verdict:
    (row,) = comparison.summary[comparison.summary["quantity"] == quantity].itertuples()
    return Verdict(
        f"The net's {NAMES[quantity]} is that of the meridian method, at every catch",
        abs(row.relative_largest) <= most,
        f"largest difference {row.relative_largest:.1e}, allowed {most:.0e}, {row.points} catches",
    )


def _figure(drag: pd.DataFrame, hoop: tuple[float, float], comparison: Comparison) -> "Figure":
    figure = new_figure(9.0, 4.4)
    axes = figure.add_subplot()
    volume = drag["catch_volume_m3"]
    for column, name, colour, line, marker in PARTS:
        axes.plot(volume, drag[column], color=colour, ls=line, marker=marker, ms=4, label=name)
    axes.plot(volume, drag["drag_with_assumed_hoop_n"], color=HOOP_GREEN, lw=1.2, label="total + hoop (assumed rod)")
    axes.fill_between(volume, *hoop, color=HOOP_GREEN, alpha=0.25, lw=0.0)
    axes.plot(volume, drag["hoop_drag_assumed_rod_n"], color=HOOP_GREEN, ls="-.", lw=1.2, label="hoop (assumed rod)")
    table = comparison.table.columns
    axes.plot(
        table["catch_volume_m3"], table["drag_n"], "o", ms=9, mfc="none", color=INK, label="total, COMPUTED by meridian"
    )
    axes.set(xlabel="catch volume (m³)", ylabel="drag (N)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    dress(axes)
    axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure
