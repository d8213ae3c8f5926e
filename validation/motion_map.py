"""Motion in time: where it is right, wrong or refused by time step and bars, and its error against its work.

``python -m validation.motion_map [--quick] [--out DIR]``, or ``python -m validation --only motion``.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from codend.net.net import Floats
from codend.report.style import INK, new_figure, png
from validation.moordyn_comparison import EA, LENGTH, by_codend
from validation.section import Picture, Section, Verdict

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FROM_S, END_S = 5, 20
STEPS_S = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
BARS = (2, 5, 10, 20, 40, 80)
REFERENCE_BARS, REFERENCE_STEP_S = 240, 0.005
QUICK = 7, (0.02, 0.2, 1.0), (5, 20), 80, 0.01
"""The same of a quick run: end, steps, bars, bars and step of the reference."""
STIFFNESSES = {"rigid bars": None, f"EA {EA / 1e3:g} kN": EA}
LIMITS = (0.001, 0.01, 0.1)
FINE_BARS, FINE_STEP_S, LONG_STEP_S, ORDER = 5, 0.05, 0.2, 1.6
KINDS = ("within 0.1 %", "within 1 %", "within 10 %", "WRONG", "refused")
COLOURS = ("#0072b2", "#8cc5e3", "#f0c94c", "#d55e00", "#ece7d8")
TEXT = f"""The warp and the gear of the comparison with MoorDyn, from a level line at rest, the vessel at 1.8 m/s after
two seconds; with bars that do not stretch and with bars that do. The errors are the largest ones in the gear's depth
and in the pull at the vessel from {FROM_S} s to the end, a second apart, over what a reference of many bars in short
steps says. Wrong is what is off by more than 10 %, refused what says so itself. The more bars, the shorter a step must
be to gain by them: in long steps short bars lie in a zigzag, which is slow to die out."""
QUANTITIES = {"depth": "gear's depth", "pull": "pull at the vessel"}


def towed(bars: int, step_s: float, end_s: float, stiffness_n: float | None) -> Floats | None:
    """Time, distance, height and pull every second, (outputs, 4); None where the motion is refused."""
    nodes = np.linspace([0.0, 0.0, 0.0], [LENGTH, 0.0, 0.0], bars + 1)
    try:
        return by_codend(bars, nodes, end_s, step_s, stiffness_n)
    except ArithmeticError:
        return None


def kind_of(depth: float, pull: float) -> str:
    """What a run is called by its two errors, relative, nan where it was refused."""
    worst = max(depth, pull)
    return KINDS[-1] if np.isnan(worst) else KINDS[int(np.searchsorted(LIMITS, worst))]


def measured(quick: bool) -> pd.DataFrame:
    """A row for every stiffness, number of bars and step: errors, seconds of work a second of the sea, kind."""
    end, steps, bars, fine, fine_step = QUICK if quick else (END_S, STEPS_S, BARS, REFERENCE_BARS, REFERENCE_STEP_S)
    rows = []
    for law, stiffness in STIFFNESSES.items():
        reference = towed(fine, fine_step, end, stiffness)
        if reference is None:
            raise ArithmeticError(f"the reference with {law} is refused")
        for count in bars:
            for step in steps:
                began = process_time()
                found = towed(count, step, end, stiffness)
                work = (process_time() - began) / end
                errors = np.full(2, np.nan)
                if found is not None:
                    errors = np.abs(found[FROM_S - 1 :, 2:] / reference[FROM_S - 1 :, 2:] - 1.0).max(axis=0)
                depth, pull = map(float, errors)
                rows.append({"law": law, "bars": count, "step_s": step, "depth_error": depth, "pull_error": pull,
                             "work": work, "kind": kind_of(depth, pull)})  # fmt: skip
    return pd.DataFrame(rows)


def table(cells: pd.DataFrame, law: str, of: str) -> str:
    """Errors of one quantity, per cent, as a table of bars by steps."""
    own = cells[cells["law"] == law].pivot(index="bars", columns="step_s", values=f"{of}_error")
    lines = ["| bars | " + " | ".join(f"{step:g} s" for step in own.columns) + " |"]
    lines.append("|---" * (len(own.columns) + 1) + "|")
    for bars, row in own.iterrows():
        told = ["refused" if np.isnan(error) else f"{100.0 * error:.2g}" for error in row]
        lines.append(f"| {bars} | " + " | ".join(told) + " |")
    return "\n".join(lines)


def map_picture(cells: pd.DataFrame) -> Picture:
    """A coloured cell for every run."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    figure = new_figure(9.0, 4.4)
    for axes, law in zip(figure.subplots(1, 2, sharey=True), STIFFNESSES, strict=True):
        own = cells[cells["law"] == law]
        steps, bars = sorted(own["step_s"].unique()), sorted(own["bars"].unique())
        kinds = own.pivot(index="bars", columns="step_s", values="kind").to_numpy()
        numbers = np.array([[KINDS.index(kind) for kind in row] for row in kinds])
        look = {"edgecolors": "white", "linewidth": 0.8, "vmin": -0.5, "vmax": len(KINDS) - 0.5}
        axes.pcolormesh(numbers, cmap=ListedColormap(list(COLOURS)), **look)
        for y, x in np.argwhere(kinds == "WRONG"):
            axes.plot(x + 0.5, y + 0.5, "x", color="black", markersize=6, markeredgewidth=2)
        axes.set_xticks(np.arange(len(steps)) + 0.5, [f"{1e3 * step:g}" for step in steps])
        axes.set_yticks(np.arange(len(bars)) + 0.5, [str(count) for count in bars])
        axes.set_xlabel("time step, ms", color=INK)
        axes.set_title(law, loc="left", fontsize=10, color=INK)
        axes.tick_params(colors=INK, length=2)
        axes.spines[:].set_visible(False)
    figure.axes[0].set_ylabel("bars of the warp", color=INK)
    counts = cells["kind"].value_counts()
    handles = [
        Patch(facecolor=colour, edgecolor=INK, linewidth=0.5, label=f"{kind}: {counts.get(kind, 0)}")
        for kind, colour in zip(KINDS, COLOURS, strict=True)
    ]
    figure.legend(handles=handles, loc="outside lower left", ncols=len(KINDS), frameon=False, fontsize=9)
    caption = f"Depth and pull of a warp with a gear, both, from {FROM_S} s on, by time step and bars. {counted(cells)}"
    return Picture("motion_map", figure, caption)


def work_picture(cells: pd.DataFrame) -> Picture:
    """Error against work, a line for every number of bars, along which the step gets shorter."""
    figure = new_figure(9.0, 6.6)
    grid = figure.subplots(2, len(STIFFNESSES), sharex=True, sharey="row")
    for row, (of, name) in enumerate(QUANTITIES.items()):
        for axes, law in zip(grid[row], STIFFNESSES, strict=True):
            _draw_work(axes, cells[cells["law"] == law], of)
            axes.set_title(f"{name}, {law}", loc="left", fontsize=10, color=INK)
        grid[row, 0].set_ylabel("largest error, %", color=INK)
    for axes in grid[-1]:
        axes.set_xlabel("processor time over time of the sea, %", color=INK)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", title="bars", frameon=False, fontsize=9)
    caption = (
        "Error against work; along a line the step gets shorter, to the right. Where it is level, bars are too few."
    )
    return Picture("motion_work_precision", figure, caption)


def _draw_work(axes: "Axes", own: pd.DataFrame, of: str) -> None:
    from matplotlib import colormaps

    counts = sorted(own["bars"].unique())
    for number, bars in enumerate(counts):
        line = own[own["bars"] == bars].sort_values("step_s")
        colour = colormaps["viridis"](number / len(counts))
        axes.loglog(100 * line["work"], 100 * line[f"{of}_error"], "o-", ms=3, lw=1.2, color=colour, label=str(bars))
    axes.grid(alpha=0.3)
    axes.tick_params(colors=INK)


def counted(cells: pd.DataFrame) -> str:
    """How many cells are of each kind, in words."""
    counts = cells["kind"].value_counts()
    return f"{len(cells)} cells: " + ", ".join(f"{counts.get(kind, 0)} {kind}" for kind in KINDS) + "."


def section(quick: bool) -> Section:
    """The map, the errors against work, and whether anything is wrong or refused."""
    cells = measured(quick)
    parts = [TEXT, "![motion_map]"]
    parts += [
        f"Errors in the {name}, %, {law}:\n\n{table(cells, law, of)}"
        for law in STIFFNESSES
        for of, name in QUANTITIES.items()
    ]
    parts += ["![motion_work_precision]", cheapest(cells)]
    return Section(
        title="Motion in time: work against precision, and a map by step and bars",
        text="\n\n".join(parts),
        pictures=(map_picture(cells), work_picture(cells)),
        data={"motion_map": cells},
        verdicts=tuple(_verdicts(cells)),
    )


def cheapest(cells: pd.DataFrame) -> str:
    """The least work that is exact enough, in words."""
    told = []
    for limit in LIMITS:
        enough = cells[cells[["depth_error", "pull_error"]].max(axis=1, skipna=False) <= limit]
        for law in STIFFNESSES:
            own = enough[enough["law"] == law]
            if len(own):
                best = own.loc[own["work"].idxmin()]
                told.append(
                    f"within {100.0 * limit:g} % {best['bars']} bars in steps of {best['step_s']:g} s, "
                    f"{100.0 * best['work']:.2g} % of the time of the sea ({law})"
                )
    return f"The least work: {'; '.join(told)}."


def _verdicts(cells: pd.DataFrame) -> Iterator[Verdict]:
    worst = cells[["depth_error", "pull_error"]].max(axis=1, skipna=False).fillna(np.inf)
    fine = worst[(cells["step_s"] <= FINE_STEP_S) & (cells["bars"] >= FINE_BARS)].max()
    claim = f"{FINE_BARS} bars or more in steps of {1e3 * FINE_STEP_S:g} ms or less are within 1 %."
    yield Verdict(claim, bool(fine <= LIMITS[1]), f"at worst {100.0 * fine:.2g} %")
    long = worst[cells["step_s"] <= LONG_STEP_S].max()
    claim = f"Nothing is wrong or refused in steps of {1e3 * LONG_STEP_S:g} ms or less, however many bars."
    yield Verdict(claim, bool(long <= LIMITS[2]), f"at worst {100.0 * long:.2g} %")
    finest = cells[cells["step_s"] == cells["step_s"].min()].pivot(index="law", columns="bars", values="depth_error")
    orders = np.log(finest[5] / finest[20]) / np.log(4.0)
    claim = f"Between 5 and 20 bars the error in depth falls with a power of at least {ORDER} of their size."
    yield Verdict(claim, bool(orders.min() >= ORDER), ", ".join(f"{law} {order:.2f}" for law, order in orders.items()))


def main() -> None:
    """Print the tables and draw both pictures."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--out", type=Path, default=Path("results/motion"))
    asked.add_argument("--quick", action="store_true")
    given = asked.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    found = section(given.quick)
    print(found.text)
    for picture in found.pictures:
        (given.out / f"{picture.name}.png").write_bytes(png(picture.figure))
        print(picture.caption)
    found.data["motion_map"].to_csv(given.out / "motion_map.csv", index=False, float_format="%.6g")
    for verdict in found.verdicts:
        print(f"{'passed' if verdict.passed else 'FAILED'}: {verdict.claim} {verdict.found}")


if __name__ == "__main__":
    main()
