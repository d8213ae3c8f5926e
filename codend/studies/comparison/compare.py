"""Match the rows of a flume table with computed cases, and the differences of every quantity."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from codend.errors import InputError
from codend.io.run_tables import solved_cases
from codend.studies.comparison.flume_table import (
    CATCH_COLUMNS,
    HOOP_COLUMN,
    MEASURED_COLUMNS,
    SPEED_COLUMN,
    Floats,
    FlumeTable,
)
from codend.studies.comparison.hoop import Hoop

SAME = 1e-6
"""Relative difference up to which two speeds or catch sizes are one."""

_NEEDED = (SPEED_COLUMN, *CATCH_COLUMNS, "drag_n", "front_from_codline_m", "length_m")


@dataclass(frozen=True)
class Comparison:
    """A flume table beside computed cases."""

    table: FlumeTable
    computed: pd.DataFrame
    """The converged cases, columns as in the flume table."""
    matched_on: str | None
    """The catch column along which the computed cases were interpolated; None: matched on speed alone."""
    points: pd.DataFrame
    """``comparison.csv``: a row a quantity of a row of the table: ``table_line, speed_m_s``, the catch column matched
    on, ``quantity, tabled, computed, hoop_drag_n, hoop_origin, difference, relative_difference, interpolated, note,
    source``.

    ``computed`` is nan where ``note`` says why there is nothing to compare with. For ``drag_n`` it includes the hoop's
    drag, which ``hoop_drag_n`` repeats; ``hoop_origin`` says whether the table gives it or it was computed.
    """

    @property
    def compared(self) -> pd.DataFrame:
        """The points that have a computed value."""
        return self.points[self.points["computed"].notna()]

    @property
    def summary(self) -> pd.DataFrame:
        """``comparison_summary.csv``: a row a quantity, differences computed minus tabled.

        Columns ``quantity, points, bias, rms, largest`` (the difference of largest size, with its sign) and the same
        three of the differences relative to the tabled values: ``relative_bias, relative_rms, relative_largest``.
        """
        rows = []
        for quantity, points in self.compared.groupby("quantity", sort=False):
            row: dict[str, object] = {"quantity": quantity, "points": len(points)}
            for prefix, column in (("", "difference"), ("relative_", "relative_difference")):
                error = points[column].dropna().to_numpy()
                row[f"{prefix}bias"] = error.mean() if error.size else np.nan
                row[f"{prefix}rms"] = np.sqrt(np.mean(error**2)) if error.size else np.nan
                row[f"{prefix}largest"] = error[np.argmax(np.abs(error))] if error.size else np.nan
            rows.append(row | {"source": self.table.origin})
        return pd.DataFrame(rows)


def compare(
    results: pd.DataFrame, table: FlumeTable, source: str | Path = "results", hoop: Hoop | None = None
) -> Comparison:
    """Set the converged cases of a run beside a table.

    A row of the table is matched with the cases of its speed. Along the catch size, cases are interpolated by monotone
    cubics (PCHIP) and never extrapolated. Of several catch columns that one is matched on for which most rows lie
    within the computed range, of equals the one for which most rows need no interpolation; the others are compared.

    Args:
        results: ``Study.table``, or ``results.csv`` as ``codend.io.run_tables.read_run_table`` returns it.
        table: as ``read_flume_table`` returns it.
        source: where the results are from, for messages.
        hoop: whose drag is added to the computed drag, for a table that has the column ``hoop_drag_n``, and so drag
            that includes a hoop's, but no number in it.

    Raises:
        InputError: the results lack a column or a converged case, no row of the table can be matched with them, or a
            hoop is given for a table whose drag includes none or that gives the hoop's drag itself.
    """
    computed = _computed(results, source)
    speeds = _speeds(computed, table)
    if hoop is not None:
        table = _with_hoop(table, hoop, speeds)
    best = max(
        (_match(computed, table, speeds, name) for name in table.catch_columns or (None,)),
        key=lambda match: (match.found, match.exact),
    )
    points = pd.concat([_points(table, speeds, best, name) for name in _quantities(table, best.on)], ignore_index=True)
    if points["computed"].isna().all():
        reasons = "; ".join(dict.fromkeys(points["note"]))
        raise InputError(table.path, "", None, "rows that match the computed cases", f"has none to compare: {reasons}")
    return Comparison(table, computed, best.on, points.reset_index(drop=True))


def _computed(results: pd.DataFrame, source: str | Path) -> pd.DataFrame:
    """The converged cases, columns as in a flume table."""
    solved = solved_cases(results, source, (*_NEEDED, "max_radius_m"))
    return solved[list(_NEEDED)].astype(float).assign(max_diameter_m=2.0 * solved["max_radius_m"].astype(float))


@dataclass(frozen=True)
class _Match:
    """The computed cases at every row of a table, matched on one catch column."""

    on: str | None
    sizes: Floats
    computed: pd.DataFrame
    """A row a row of the table, nan where there is none."""
    interpolated: list[bool]
    notes: list[str]

    @property
    def found(self) -> int:
        return self.notes.count("")

    @property
    def exact(self) -> int:
        return self.found - sum(self.interpolated)


def _speeds(computed: pd.DataFrame, table: FlumeTable) -> Floats:
    """Speed of every row of the table; where it has none, the one speed that was computed."""
    if SPEED_COLUMN in table.columns:
        return table.columns[SPEED_COLUMN]
    one = computed[SPEED_COLUMN].iloc[0]
    if not np.allclose(computed[SPEED_COLUMN], one, rtol=SAME, atol=0.0):
        raise InputError(table.path, SPEED_COLUMN, None, "that column, as several speeds were computed", "is missing")
    return np.full(len(table.lines), float(one))


def _with_hoop(table: FlumeTable, hoop: Hoop, speeds: Floats) -> FlumeTable:
    """The table with the hoop's drag where it has an empty column for it."""
    if HOOP_COLUMN not in table.columns:
        allowed = "an empty column of that name where it does, or no hoop to be computed"
        raise InputError(table.path, HOOP_COLUMN, None, allowed, "is missing, so drag_n includes no hoop's")
    if not np.isnan(table.columns[HOOP_COLUMN]).all():
        allowed = "an empty column, or no hoop to be computed"
        raise InputError(table.path, HOOP_COLUMN, None, allowed, "has numbers of its own")
    return replace(table, columns=table.columns | {HOOP_COLUMN: hoop.drag_n(speeds)}, hoop_origin=hoop.origin)


def _match(computed: pd.DataFrame, table: FlumeTable, speeds: Floats, on: str | None) -> _Match:
    sizes = np.zeros(len(speeds)) if on is None else table.columns[on]
    rows, interpolated, notes = [], [], []
    known = ", ".join(f"{speed:g}" for speed in sorted(set(computed[SPEED_COLUMN])))
    nothing = pd.Series(np.nan, computed.columns)
    for speed, size in zip(speeds, sizes, strict=True):
        cases = computed[np.isclose(computed[SPEED_COLUMN], speed, rtol=SAME, atol=0.0)]
        row, between, note = nothing, False, ""
        if np.isnan(speed):
            note = "no speed_m_s"
        elif cases.empty:
            note = f"no case at {speed:g} m/s (computed: {known})"
        elif on is None and len(cases) > 1:
            note = f"several catches computed at {speed:g} m/s and no catch column in the table"
        elif on is None:
            row = cases.iloc[0]
        elif np.isnan(size):
            note = f"no {on}"
        else:
            row, between, note = _at_size(cases, on, float(size))
        rows.append(row)
        interpolated.append(between)
        notes.append(note)
    return _Match(on, sizes, pd.DataFrame(rows).reset_index(drop=True), interpolated, notes)


def curve(cases: pd.DataFrame, on: str, at: Floats) -> pd.DataFrame:
    """Two or more computed cases of one speed, interpolated at catch sizes within their range, nan outside it."""
    from scipy.interpolate import PchipInterpolator

    known = cases.sort_values(on).drop_duplicates(on)
    values = PchipInterpolator(known[on], known.to_numpy(dtype=float), axis=0, extrapolate=False)(at)
    return pd.DataFrame(values, columns=known.columns)


def _at_size(cases: pd.DataFrame, on: str, size: float) -> tuple[pd.Series, bool, str]:
    """The case at a catch size, whether it lies between computed ones, and why there is none."""
    same = cases[np.isclose(cases[on], size, rtol=SAME, atol=0.0)]
    if not same.empty:
        return same.iloc[0], False, ""
    least, most = cases[on].min(), cases[on].max()
    if not least < size < most:
        note = f"{on} = {size:g} is outside the computed {least:.6g} to {most:.6g}"
        return pd.Series(np.nan, cases.columns), False, note
    return curve(cases, on, np.array([size])).iloc[0], True, ""


def _quantities(table: FlumeTable, matched_on: str | None) -> list[str]:
    return [name for name in (*MEASURED_COLUMNS, *CATCH_COLUMNS) if name in table.columns and name != matched_on]


def _points(table: FlumeTable, speeds: Floats, match: _Match, quantity: str) -> pd.DataFrame:
    """Every tabled value of a quantity beside the computed one."""
    tabled = table.columns[quantity]
    computed = match.computed[quantity].to_numpy(dtype=float)
    notes = list(match.notes)
    hoop = np.full(len(tabled), np.nan)
    if quantity == "drag_n" and HOOP_COLUMN in table.columns:
        hoop = table.columns[HOOP_COLUMN]
        computed = computed + hoop
        notes = [note or ("no hoop_drag_n" if np.isnan(h) else "") for note, h in zip(notes, hoop, strict=True)]
    difference = computed - tabled
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(tabled > 0.0, difference / tabled, np.nan)
    points = pd.DataFrame({"table_line": table.lines, SPEED_COLUMN: speeds})
    if match.on is not None:
        points[match.on] = match.sizes
    points = points.assign(
        quantity=quantity,
        tabled=tabled,
        computed=computed,
        hoop_drag_n=hoop,
        hoop_origin=np.where(np.isnan(hoop), "", table.hoop_origin),
        difference=difference,
        relative_difference=relative,
        interpolated=match.interpolated,
        note=notes,
        source=table.origin,
    )
    return points[~np.isnan(tabled)]
