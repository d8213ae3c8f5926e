"""Tables that users write or may have changed: read from CSV files, and their columns checked, with clear refusals.

Every table comes through here: hauls, flume tables, Cp curves and the tables of a run.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError
from codend.io.table_form import Decimal, TableForm, decimal_of, separator_of, words_of
from codend.io.text import ENCODING, ENCODING_OPTION, MOST_MB, read_text

if TYPE_CHECKING:
    import pandas as pd

POINTS: Final = Decimal(".")
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
    form: str = ""
    """How the file is laid out, in words; empty for commas between columns and points in numbers."""
    decimal: Decimal = POINTS
    may_ask: bool = False
    """Whether the user has options to say how the file is laid out."""

    @property
    def where(self) -> str:
        """The source as messages name it: with its form, where that is not the plain one."""
        return f"{self.source} ({self.form})" if self.form else self.source

    def require(self, columns: Iterable[str]) -> None:
        """Refuse a table without these columns.

        Raises:
            InputError: one is missing.
        """
        for column in columns:
            if column not in self.frame.columns:
                found = ", ".join(map(str, self.frame.columns))
                raise InputError(self.where, column, None, f"a column of that name (found: {found})", "is missing")

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

        cells = self.with_points(column)
        values = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
        finite = np.isfinite(values)
        good = finite & is_allowed(np.where(finite, values, 0.0))
        self.check(column, good | (may_be_empty & cells.isna().to_numpy()), allowed)
        return values

    def with_points(self, column: str) -> pd.Series:
        """(R,) the cells of a column with points in its numbers, whatever stands there in the file.

        Raises:
            InputError: there is no such column, or what stands in its numbers cannot be told.
        """
        self.require((column,))
        cells = self.frame[column]
        if self.decimal.mark == ".":
            return cells
        if self.decimal.mark == ",":  # a point is then no part of a number
            return cells.str.replace(".", "?", regex=False).str.replace(",", ".", regex=False)
        if cells.str.contains("[.,]", na=False).any():
            allowed = "points or commas before fractions, and no mark after thousands"
            allowed += "; --decimal , or --decimal . says which" if self.may_ask else ""
            raise InputError(
                self.where, column, None, allowed, f"cannot be read for sure: the file {self.decimal.doubt}"
            )
        return cells

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
        raise InputError(self.where, column, shown, allowed, f"in {place} is not allowed")


def read_table(
    path: str | Path, form: TableForm | None = None, names: Iterable[str] = (), *, most_mb: float = MOST_MB
) -> InputTable:
    """Read a CSV file: lines that begin with ``#`` are comments, the first other line is the header.

    Blank lines, lines of empty cells and empty columns without a name do not count, nor do blanks and quotes round
    cells. The ``csv`` module splits the lines, for pandas fills up rows that are too short and, where they are too
    long, takes the first column for an index.

    Args:
        path: of the file.
        form: what the user says of its form; None where there is no option to ask for.
        names: of columns; one that is spelt like it but for capitals, blanks and brackets gets that name.
        most_mb: size from which the file is refused.

    Raises:
        InputError: no such file, too large, in an unknown encoding, no header, no sure separator, a column given
            twice, a row of another length than the header.
    """
    import pandas as pd

    may_ask, form = form is not None, form or TableForm()
    allowed = ENCODING_OPTION if may_ask else ENCODING
    text = read_text(path, "CSV table", encoding=form.encoding, allowed=allowed, most_mb=most_mb)
    comments: list[str] = []
    numbers: list[int] = []
    lines: list[str] = []
    separator = form.separator
    for number, line in enumerate(text.split("\n"), start=1):
        bare = line.strip(' "\t')  # spreadsheets put quotes round comments too
        if bare.startswith("#"):
            comments.append(bare.lstrip("# ").rstrip(',;|\t "'))  # and as many marks behind as there are columns
        elif not lines and (said := re.fullmatch(r"sep=([,;|]?)", bare)):
            separator = separator or said[1] or "\t"
        elif bare:
            numbers.append(number)
            lines.append(line)
    if not lines:
        raise InputError(path, "", None, "a CSV table with a header", "cannot be read: it is empty")
    separator = separator or separator_of(lines[0], path, may_ask=may_ask)
    what = words_of(separator, form.decimal)
    where = f"{path} ({what})" if what else str(path)
    reader, begin, rows = csv.reader(lines, delimiter=separator, skipinitialspace=True), 0, []
    try:
        for row in reader:
            rows.append((numbers[begin], [cell.strip() or None for cell in row]))
            begin = reader.line_num  # more than one further on where a cell has line breaks in quotes
    except csv.Error as error:
        place = f"line {numbers[begin]}"
        raise InputError(where, place, None, "cells between commas", f"cannot be read: {error}") from None
    (first, header), *others = _without_empty(rows)
    header = _spelt_as(names, header)
    for position, name in enumerate(header):
        if name in header[:position]:
            raise InputError(where, name or "(empty)", None, "each column once", f"in line {first} is given twice")
    for number, cells in others:
        if len(cells) != len(header):
            allowed = f"{len(header)} cells, as in the header"
            if separator == "," and len(cells) > len(header):
                allowed += " (where commas stand in numbers, columns need semicolons or tabs between them)"
            raise InputError(where, f"line {number}", None, allowed, f"has {len(cells)} cells")
    index = pd.Index([number for number, _ in others], name=LINE)
    frame = pd.DataFrame([cells for _, cells in others], index, [name or "" for name in header], dtype=object)
    filled = (frame.iloc[:, i].dropna().tolist() for i in range(frame.shape[1]))
    decimal = Decimal(form.decimal) if form.decimal else decimal_of(filled, separator)
    return InputTable(str(path), frame, tuple(comments), words_of(separator, decimal.mark), decimal, may_ask)


Row = tuple[int, list[str | None]]


def _without_empty(rows: list[Row]) -> list[Row]:
    """Rows, the header first, without those that are empty and without empty columns that have no name."""
    (first, header), *others = rows
    others = [(number, cells) for number, cells in others if any(cell is not None for cell in cells)]
    width = max(len(header), *(len(cells) for _, cells in others), 0)
    used = {i for i, name in enumerate(header) if name is not None}
    used |= {i for _, cells in others for i, cell in enumerate(cells) if cell is not None}
    dropped = set(range(width)) - used
    return [
        (number, [cell for i, cell in enumerate(cells) if i not in dropped])
        for number, cells in [(first, header), *others]
    ]


def _spelt_as(names: Iterable[str], header: list[str | None]) -> list[str | None]:
    """The names of a header, those spelt like one of ``names`` but for capitals, blanks and brackets as that one."""
    known = {_plain(name): name for name in names}
    exact = set(known.values())
    return [name if name is None or name in exact else known.get(_plain(name), name) for name in header]


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "_", name.casefold()).strip("_")
