"""Flume tables: a CSV of measured (or otherwise known) codends with ``#`` lines for its source and conditions."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError
from codend.io.input_table import read_table
from codend.io.table_form import TableForm

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


def read_flume_table(path: str | Path, form: TableForm | None = None) -> FlumeTable:
    """Read a flume table: any of ``COLUMNS``, in SI units, with cells left empty where nothing is known.

    Where ``hoop_drag_n`` is given, ``drag_n`` includes the drag of the hoop or frame the codend hangs from.

    Args:
        path: of the table.
        form: what the user says of its form; None where there is no option to ask for.

    Raises:
        InputError: as in ``read_table``; no rows, a column unknown, nothing to match on or to compare,
            a cell that is no number of 0 or more, a row given twice.
    """
    table = read_table(path, form, COLUMNS)
    header, lines = list(table.frame.columns), table.frame.index.tolist()
    for name in header:
        if name not in COLUMNS:
            raise InputError(path, name or "(empty)", None, ", ".join(COLUMNS), "is no known column")
    if table.frame.empty:
        raise InputError(path, "", None, "a row below the header", "has no rows")
    values = np.stack([table.numbers(n, _NUMBER, lambda v: v >= 0.0, may_be_empty=True) for n in header], axis=1)
    found: dict[bytes, int] = {}
    for line, row in zip(lines, values, strict=True):
        first = found.setdefault(row.tobytes(), line)
        if first != line:
            raise InputError(path, f"line {line}", None, "each row once", f"repeats line {first}")
    # a hoop's drag that is nowhere known still says that the measured drag includes it
    columns = {n: v for n, v in zip(header, values.T, strict=True) if n == HOOP_COLUMN or not np.isnan(v).all()}
    _check_use(path, columns)
    return FlumeTable(Path(path), table.comments, columns, np.array(lines))


def _check_use(path: str | Path, columns: dict[str, Floats]) -> None:
    if not any(name in columns for name in (*CATCH_COLUMNS, SPEED_COLUMN)):
        allowed = f"at least one of {', '.join((*CATCH_COLUMNS, SPEED_COLUMN))}, with a number in it"
        raise InputError(path, "", None, allowed, "has no column to match with the computed cases")
    if not any(name in columns for name in MEASURED_COLUMNS):
        allowed = f"at least one of {', '.join(MEASURED_COLUMNS)}, with a number in it"
        raise InputError(path, "", None, allowed, "has no column to compare")
    if HOOP_COLUMN in columns and "drag_n" not in columns:
        raise InputError(path, HOOP_COLUMN, None, "drag_n beside it, the drag with the hoop", "is given without drag_n")
