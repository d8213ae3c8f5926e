"""Tables that users write or may have changed: read from CSV files, and their columns checked, with clear refusals."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError
from codend.io.text import read_text

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

LINE: Final = "line"
"""Name of the index of a frame whose rows are known by their line in a file, from 1."""


def _any_number(values: Floats) -> Mask:
    return np.ones(values.shape, dtype=bool)


@dataclass(frozen=True)
class InputTable:
    """A table of R rows, and where it is from."""

    source: str
    frame: pd.DataFrame
    """As read from a file: texts, nan where a cell is empty, with the lines of the file as index."""
    comments: tuple[str, ...] = ()
    """Lines that began with ``#``, without it."""

    def require(self, columns: Iterable[str]) -> None:
        """Refuse a table without these columns.

        Raises:
            InputError: one is missing.
        """
        for column in columns:
            if column not in self.frame.columns:
                found = ", ".join(map(str, self.frame.columns))
                raise InputError(self.source, column, None, f"a column of that name (found: {found})", "is missing")

    def numbers(
        self,
        column: str,
        allowed: str = "a number",
        is_allowed: Callable[[Floats], Mask] = _any_number,
        *,
        may_be_empty: bool = False,
    ) -> Floats:
        """(R,) the column as finite floats that satisfy ``is_allowed``; nan for empty cells, where those may be.

        Raises:
            InputError: there is no such column, or a cell is something else.
        """
        import pandas as pd

        self.require((column,))
        cells = self.frame[column]
        values = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
        finite = np.isfinite(values)
        good = finite & is_allowed(np.where(finite, values, 0.0))
        self.check(column, good | (may_be_empty & cells.isna().to_numpy()), allowed)
        return values

    def check(self, column: str, good: Mask, allowed: str) -> None:
        """Refuse the first cell of a column that is not good, (R,).

        Raises:
            InputError: there is one.
        """
        import pandas as pd

        if good.all():
            return
        row = int(np.argmin(good))
        cell = self.frame[column].iloc[row]
        shown = "(empty)" if pd.isna(cell) else str(cell)
        place = f"line {self.frame.index[row]}" if self.frame.index.name == LINE else f"data row {row + 1}"
        raise InputError(self.source, column, shown, allowed, f"in {place} is not allowed")


def read_table(path: str | Path) -> InputTable:
    """Read a CSV file: lines that begin with ``#`` are comments, the first other line is the header.

    Blank lines do not count, nor do blanks and quotes round cells. The ``csv`` module splits the lines, for pandas
    fills up rows that are too short and, where they are too long, takes the first column for an index.

    Raises:
        InputError: no such file, not UTF-8, no header, a column given twice, a row of another length than the header.
    """
    import pandas as pd

    text = read_text(path, "CSV table")
    comments, numbers, lines = [], [], []
    for number, line in enumerate(text.split("\n"), start=1):
        bare = line.strip(' "\t')  # spreadsheets put quotes round comments too
        if bare.startswith("#"):
            comments.append(bare.lstrip("# "))
        elif bare:
            numbers.append(number)
            lines.append(line)
    reader, begin, rows = csv.reader(lines, skipinitialspace=True), 0, []
    try:
        for row in reader:
            rows.append((numbers[begin], [cell.strip() or None for cell in row]))
            begin = reader.line_num  # more than one further on where a cell has line breaks in quotes
    except csv.Error as error:
        place = f"line {numbers[begin]}"
        raise InputError(path, place, None, "cells between commas", f"cannot be read: {error}") from None
    if not rows:
        raise InputError(path, "", None, "a CSV table with a header", "cannot be read: it is empty")
    (first, header), *others = rows
    for position, name in enumerate(header):
        if name in header[:position]:
            raise InputError(path, name or "(empty)", None, "each column once", f"in line {first} is given twice")
    for number, cells in others:
        if len(cells) != len(header):
            allowed = f"{len(header)} cells, as in the header"
            raise InputError(path, f"line {number}", None, allowed, f"has {len(cells)} cells")
    index = pd.Index([number for number, _ in others], name=LINE)
    frame = pd.DataFrame([cells for _, cells in others], index, [name or "" for name in header])
    return InputTable(str(path), frame, tuple(comments))
