"""Figures of a study: responses to what varies, maps over two numbers, drag against L50."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pandas as pd

from codend.io.columns import error_of
from codend.net.net import Floats
from codend.report.style import INK, ORANGE, dress, new_figure, number_text, ordered_colours, spread
from codend.report.tornado_plot import named

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DASHES: Final[tuple[Any, ...]] = ("-", (0, (5, 2)), (0, (1, 1.4)), (0, (6, 1.5, 1, 1.5)))
MARKERS: Final = ("o", "s", "^", "D")
MOST_COLOURS: Final = 8
"""Values of the second number that have a line each; of more, those evenly spread."""
DRAWN: Final = ("opening_ahead_deg", "drag_n", "l50_cm", "sr_cm")
CONDITIONS: Final = ("catch.", "tow.")
"""Beginnings of keys that are no choice of the gear: designs are compared where they are alike."""
NO_KEY: Final = ("run", "design")


@dataclass(frozen=True)
class Swept:
    """The table of a study at one of its cases, and which of its columns vary."""

    table: pd.DataFrame
    """Rows that were solved."""
    numbers: tuple[str, ...]
    """Columns of numbers that vary, the one with most values first."""
    kinds: tuple[str, ...]
    """Other columns that vary, the design's name among them."""
    conditions: tuple[str, ...]
    """Columns of catch and tow that vary."""
    case: str
    """The case in words."""

    @property
    def alike(self) -> list[pd.DataFrame]:
        """Rows of like catch and tow; all rows where no two are of the same, as in a sample."""
        groups = [own for _, own in self.table.groupby(list(self.conditions))] if self.conditions else []
        return groups if any(len(own) > 1 for own in groups) else [self.table]

    @property
    def quantities(self) -> list[str]:
        """What is drawn of every row."""
        return [
            name for name in self.table.columns if name.partition(" ")[0] in DRAWN and self.table[name].notna().any()
        ]

    @property
    def by_points(self) -> bool:
        """Whether the numbers are points of a sample, which no line joins."""
        runs = len(self.table)
        return len(self.numbers) > 1 and self.table[self.numbers[0]].nunique() > 0.6 * runs > 3


def swept(table: pd.DataFrame) -> Swept | None:
    """What varies in ``sweep.csv``, at its last case: the largest catch; None where nothing was solved.

    Of columns that change together the first stands for all.
    """
    solved = table[table["converged"].astype(bool)]
    if solved.empty:
        return None
    last = solved["case"].max()
    own = solved[solved["case"] == last]
    keys = [name for name in table.columns[: list(table.columns).index("case")] if name != "run"]
    numbers: list[str] = []
    kinds: list[str] = []
    seen = set[tuple[int, ...]]()
    for key in keys:
        pattern = tuple(int(code) for code in pd.factorize(own[key])[0])
        if len(set(pattern)) < 2 or pattern in seen:
            continue
        seen.add(pattern)
        (numbers if pd.api.types.is_numeric_dtype(own[key]) and key not in NO_KEY else kinds).append(key)
    numbers.sort(key=lambda key: -own[key].nunique())
    first = own.iloc[0]
    same = own["catch_mass_kg"].max() <= 1.001 * own["catch_mass_kg"].min()
    mass = f", {number_text(float(first['catch_mass_kg']))} kg" if same else ""
    words = f"case {int(last)}: {number_text(float(first['speed_m_s']))} m/s{mass}"
    conditions = tuple(key for key in keys if key.startswith(CONDITIONS) and own[key].nunique() > 1)
    return Swept(own, tuple(numbers), tuple(kinds), conditions, words)


def response_figure(found: Swept) -> "Figure":
    """A panel a quantity over the first number that varies; colours are the second, dashes what else varies most."""
    across, table = found.numbers[0], found.table
    others = [*found.numbers[1:], *found.kinds]
    colour, dash = (*others, None, None)[:2]
    if colour in found.kinds and dash in found.numbers:
        colour, dash = dash, colour
    panels = found.quantities
    columns = min(len(panels), 2)
    figure = new_figure(4.7 * columns, 3.5 * -(-len(panels) // columns) + 0.6)
    axes = figure.subplots(-(-len(panels) // columns), columns, squeeze=False).ravel()
    for axis, quantity in zip(axes, panels, strict=False):
        dress(axis)
        if found.by_points:
            _points(figure, axis, table, across, quantity, colour)
        else:
            _lines(axis, table, across, quantity, colour, dash, others)
        axis.set_xlabel(across)
        axis.set_ylabel(_label(quantity))
    for axis in axes[len(panels) :]:
        axis.set_visible(False)
    if not found.by_points:
        _told_apart(figure, table, colour, dash)
    return figure


def _told_apart(figure: "Figure", table: pd.DataFrame, colour: str | None, dash: str | None) -> None:
    """Legends of what colours stand for, and of what dashes do."""
    from matplotlib.lines import Line2D

    handles = []
    if colour is not None:
        shown = _shown_levels(table, colour)
        for level, shade in zip(shown, ordered_colours(len(shown)), strict=True):
            handles.append(Line2D([], [], color=shade, lw=3.5, label=_named_level(colour, level)))
    for number, kind in enumerate(_levels(table, dash)[: len(DASHES)] if dash is not None else ()):
        marker, look = MARKERS[number], DASHES[number]
        handles.append(Line2D([], [], color=INK, linestyle=look, marker=marker, ms=4, label=_named_level(dash, kind)))
    if handles:
        wide = max(len(str(handle.get_label())) for handle in handles) > 28
        figure.legend(
            handles=handles, loc="outside lower center", frameon=False, ncols=2 if wide else 4, fontsize=8.5,
            handlelength=3.4,
        )  # fmt: skip


def _lines(
    axis: "Axes", table: pd.DataFrame, across: str, quantity: str, colour: Any, dash: Any, others: list[str]
) -> None:
    shown, kinds = _shown_levels(table, colour), _levels(table, dash)
    rest = [name for name in others if name not in (colour, dash)]
    for level, shade in zip(shown, ordered_colours(len(shown)), strict=True):
        for number, kind in enumerate(kinds[: len(DASHES)]):
            own = table if colour is None else table[table[colour] == level]
            own = own if dash is None else own[own[dash] == kind]
            # what else varies has a line each, of the same look
            for _, curve in own.groupby(rest, sort=False) if rest else [(None, own)]:
                rising = curve.sort_values(across)
                look: dict[str, Any] = {"linestyle": DASHES[number], "marker": MARKERS[number], "color": shade}
                axis.plot(rising[across], rising[quantity], lw=1.6, ms=3.5, **look)
                if error_of(quantity) in rising:
                    low, high = (rising[quantity] + sign * rising[error_of(quantity)] for sign in (-1.0, 1.0))
                    axis.fill_between(rising[across], low, high, color=shade, alpha=0.12, linewidth=0)


def _points(figure: "Figure", axis: "Axes", table: pd.DataFrame, across: str, quantity: str, colour: Any) -> None:
    drawn = axis.scatter(table[across], table[quantity], c=table[colour], cmap=_shades(0.0, 0.88), s=14)
    figure.colorbar(drawn, ax=axis, label=colour, shrink=0.9)


def _shades(low: float, high: float) -> Any:
    """A part of viridis: without the yellow that is lost on white, or the dark that hides lines."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps["viridis"](np.linspace(low, high, 256)))


def _levels(table: pd.DataFrame, key: str | None) -> list[Any]:
    return [None] if key is None else sorted(table[key].dropna().unique().tolist(), key=lambda v: (str(type(v)), v))


def _shown_levels(table: pd.DataFrame, key: str | None) -> list[Any]:
    levels = _levels(table, key)
    return [levels[i] for i in spread(len(levels), MOST_COLOURS)]


def _named_level(key: str | None, value: Any) -> str:
    return f"{key} = {number_text(value, 4) if isinstance(value, int | float) else value}"


def _label(quantity: str) -> str:
    words, unit = named(quantity)
    return f"{words} ({unit})"


def map_figure(found: Swept) -> "Figure | None":
    """A map a quantity over the first two numbers that vary; None where these are no grid, or fewer than two."""
    if len(found.numbers) < 2 or found.by_points:
        return None
    across, up = found.numbers[:2]
    own = found.table
    for key in (*found.numbers[2:], *found.kinds):
        own = own[own[key] == own[key].iloc[0]]
    grids = {name: own.pivot_table(index=up, columns=across, values=name) for name in found.quantities}
    if any(min(grid.shape) < 2 or grid.isna().to_numpy().mean() > 0.3 for grid in grids.values()):
        return None
    columns = min(len(grids), 2)
    figure = new_figure(4.9 * columns, 3.7 * -(-len(grids) // columns))
    axes = figure.subplots(-(-len(grids) // columns), columns, squeeze=False).ravel()
    for axis, (name, grid) in zip(axes, grids.items(), strict=False):
        values = np.ma.masked_invalid(grid.to_numpy(dtype=float))
        drawn = axis.pcolormesh(*_edges(grid), values, cmap=_shades(0.3, 1.0), shading="flat")
        if min(grid.shape) > 2 and np.ptp(values) > 0.0:
            lines = axis.contour(grid.columns, grid.index, values, colors=INK, linewidths=0.8)
            axis.clabel(lines, fontsize=7.5)
        figure.colorbar(drawn, ax=axis, label=_label(name))
        axis.set_xlabel(across)
        axis.set_ylabel(up)
    for axis in axes[len(grids) :]:
        axis.set_visible(False)
    return figure


def _edges(grid: pd.DataFrame) -> tuple[Floats, Floats]:
    """Edges of the cells about the grid's places, across and up."""
    found = []
    for places in (grid.columns.to_numpy(dtype=float), grid.index.to_numpy(dtype=float)):
        middles = 0.5 * (places[1:] + places[:-1])
        ends = 1.5 * places[[0, -1]] - 0.5 * places[[1, -2]]
        found.append(np.concatenate([ends[:1], middles, ends[1:]]))
    return found[0], found[1]


def fronts_of(found: Swept, more: str) -> list[pd.DataFrame]:
    """The front of every like catch and tow (``front_of``)."""
    return [front_of(own, more) for own in found.alike]


def front_of(table: pd.DataFrame, more: str) -> pd.DataFrame:
    """Rows than which no other has both less drag and more of a quantity, by rising drag."""
    rising = table.dropna(subset=["drag_n", more]).sort_values(["drag_n", more], ascending=[True, False])
    best = rising[more].cummax().shift(fill_value=-np.inf)
    return rising[rising[more] > best]


def pareto_figure(found: Swept, more: str) -> "Figure":
    """Drag against L50 (or the opening) of every design; lines through those not bettered at like catch."""
    table = found.table
    figure = new_figure(7.4, 4.6)
    axis = figure.subplots()
    dress(axis)
    colour = found.numbers[0] if found.numbers else None
    kinds = _levels(table, found.kinds[0] if found.kinds else None)
    drawn = None
    limits = (
        {} if colour is None else {"vmin": table[colour].min(), "vmax": table[colour].max(), "cmap": _shades(0.0, 0.88)}
    )
    for number, kind in enumerate(kinds):
        own = table if kind is None else table[table[found.kinds[0]] == kind]
        shade = INK if colour is None else own[colour]
        drawn = axis.scatter(
            own["drag_n"], own[more], c=shade, s=26, marker=MARKERS[number % len(MARKERS)], **limits
        )  # fmt: skip
    fronts = fronts_of(found, more)
    for front in fronts:
        axis.step(front["drag_n"], front[more], where="post", color=ORANGE, lw=1.2, zorder=0)
    ahead = pd.concat(fronts)
    chosen = ahead.iloc[spread(len(ahead), 8)]
    for drag, value, run in chosen[["drag_n", more, "run"]].itertuples(index=False):
        axis.annotate(f"run {run}", (drag, value), xytext=(5, -11), textcoords="offset points", fontsize=8, color=INK)
    if colour is not None and drawn is not None:
        figure.colorbar(drawn, ax=axis, label=colour)
    if len(kinds) > 1:
        _marked(figure, found.kinds[0], kinds)
    axis.set_xlabel(_label("drag_n"))
    axis.set_ylabel(_label(more))
    return figure


def _marked(figure: "Figure", key: str, kinds: list[Any]) -> None:
    """A legend of what markers stand for."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=INK, linestyle="", marker=MARKERS[number % len(MARKERS)], label=_named_level(key, kind))
        for number, kind in enumerate(kinds)
    ]
    figure.legend(handles=handles, loc="outside lower center", frameon=False, ncols=4, fontsize=8.5)
