"""Flume tables: a CSV of measured (or otherwise known) codends with ``#`` lines for its source and conditions."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError

Floats = NDArray[np.float64]

CATCH_COLUMNS = ("catch_mass_kg", "catch_volume_m3", "filled_meshes")
SPEED_COLUMN = "speed_m_s"
HOOP_COLUMN = "hoop_drag_n"
MEASURED_COLUMNS = ("drag_n", "front_from_codline_m", "max_diameter_m", "length_m")
COLUMNS = (*CATCH_COLUMNS, SPEED_COLUMN, *MEASURED_COLUMNS, HOOP_COLUMN)

_NUMBER = "a number of 0 or more, or an empty cell"


@dataclass(frozen=True)
class FlumeTable:
    """A flume table of R rows."""

    path: Path
    comments: tuple[str, ...]
    """Lines that began with ``#``, without it."""
    columns: dict[str, Floats]
    """(R,) each, nan where a cell is empty; only columns that hold a number."""
    lines: NDArray[np.int64]
    """(R,) line of each row in the file, from 1."""
    hoop_origin: str = "of the table"
    """Where ``hoop_drag_n`` is from."""

    @property
    def origin(self) -> str:
        """What the table says of its source: its first comment line."""
        return next((comment for comment in self.comments if comment), "source not stated")

    @property
    def catch_columns(self) -> tuple[str, ...]:
        """The columns that say how much catch there was."""
        return tuple(name for name in CATCH_COLUMNS if name in self.columns)


def read_flume_table(path: str | Path) -> FlumeTable:
    """Read a flume table: any of ``COLUMNS``, in SI units, with cells left empty where nothing is known.

    Where ``hoop_drag_n`` is given, ``drag_n`` includes the drag of the hoop or frame the codend hangs from.

    Raises:
        InputError: no such file, no header or rows, a column unknown or given twice, nothing to match on or to compare,
            a cell that is no number of 0 or more, a row of another length than the header or given twice.
    """
    path = Path(path)
    comments, rows = _read_rows(path)
    header = _checked_header(path, *next(rows, (0, [])))
    found: dict[tuple[float | None, ...], int] = {}
    for line, cells in rows:
        if len(cells) != len(header):
            allowed = f"{len(header)} cells, as in the header"
            raise InputError(path, f"line {line}", None, allowed, f"has {len(cells)} cells")
        row = tuple(_number(path, line, name, cell) for name, cell in zip(header, cells, strict=True))
        if row in found:
            raise InputError(path, f"line {line}", None, "each row once", f"repeats line {found[row]}")
        found[row] = line
    if not found:
        raise InputError(path, "", None, "a row below the header", "has no rows")
    values = np.array(list(found), dtype=float)
    # a hoop's drag that is nowhere known still says that the measured drag includes it
    columns = {n: v for n, v in zip(header, values.T, strict=True) if n == HOOP_COLUMN or not np.isnan(v).all()}
    _check_use(path, columns)
    return FlumeTable(path, comments, columns, np.array(list(found.values())))


def _read_rows(path: Path) -> tuple[tuple[str, ...], Iterator[tuple[int, list[str]]]]:
    """Comment lines, and the line numbers and cells of the others but empty ones."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(path, "", None, "the path of a CSV table", f"cannot be read: {error.strerror}") from None
    except ValueError as error:  # bytes that are not UTF-8, a null character in the path
        raise InputError(path, "", None, "a CSV table in UTF-8", f"cannot be read: {error}") from None
    # spreadsheets put quotes round lines and cells; no cell here needs them
    lines = [(number, line.strip(' "\t')) for number, line in enumerate(text.splitlines(), start=1)]
    comments = tuple(line.lstrip("# ") for _, line in lines if line.startswith("#"))
    kept = [(number, line) for number, line in lines if line and not line.startswith("#")]
    return comments, ((number, [cell.strip(' "\t') for cell in line.split(",")]) for number, line in kept)


def _checked_header(path: Path, line: int, names: list[str]) -> list[str]:
    for position, name in enumerate(names):
        if name not in COLUMNS:
            raise InputError(path, name or "(empty)", None, ", ".join(COLUMNS), f"in line {line} is no known column")
        if name in names[:position]:
            raise InputError(path, name, None, "each column once", f"in line {line} is given twice")
    if not names:
        raise InputError(path, "", None, f"a header of columns among {', '.join(COLUMNS)}", "is empty")
    return names


def _number(path: Path, line: int, column: str, cell: str) -> float | None:
    if not cell:
        return None
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0.0) or "_" in cell:
        raise InputError(path, column, cell, _NUMBER, f"in line {line} is not allowed")
    return value


def _check_use(path: Path, columns: dict[str, Floats]) -> None:
    if not any(name in columns for name in (*CATCH_COLUMNS, SPEED_COLUMN)):
        allowed = f"at least one of {', '.join((*CATCH_COLUMNS, SPEED_COLUMN))}, with a number in it"
        raise InputError(path, "", None, allowed, "has no column to match with the computed cases")
    if not any(name in columns for name in MEASURED_COLUMNS):
        allowed = f"at least one of {', '.join(MEASURED_COLUMNS)}, with a number in it"
        raise InputError(path, "", None, allowed, "has no column to compare")
    if HOOP_COLUMN in columns and "drag_n" not in columns:
        raise InputError(path, HOOP_COLUMN, None, "drag_n beside it, the drag with the hoop", "is given without drag_n")
