"""Tables that ``codend run`` wrote, read back: whatever happened to the files, what comes out can be computed with."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from codend.errors import InputError
from codend.io.columns import (
    LAYER_COLUMNS,
    MESH_COLUMNS,
    PANEL,
    PLACE,
    PROFILE_COLUMNS,
    RESULT_COLUMNS,
    ROPE_COLUMNS,
    SECTION,
    STRAP_COLUMNS,
)
from codend.io.files import as_named
from codend.io.input_table import InputTable, read_table

if TYPE_CHECKING:
    import pandas as pd

MOST_MB: Final = 2000
"""Of a table of a run: a case of a net of 100 000 knots is 15 MB of ``meshes.csv``."""
WORDS: Final[dict[str, dict[str, object]]] = {
    "converged": {"True": True, "False": False, "TRUE": True, "FALSE": False},
    "fidelity": {name: name for name in ("meridian", "smeared", "sector", "globalised", "full")},
    "stable": {name: name for name in ("yes", "no", "unknown")},
    "folds": {name: name for name in ("yes", "no")},
}
"""Columns of words, and what the words stand for, as spreadsheets may have spelled them."""
TEXTS: Final = {"method", "growing_harmonics", "wrinkles", SECTION, PANEL}
_OF_PARTS = {*STRAP_COLUMNS, *ROPE_COLUMNS, *LAYER_COLUMNS}
NUMBERS: Final = {*RESULT_COLUMNS, *_OF_PARTS, *PROFILE_COLUMNS, *MESH_COLUMNS} - {*WORDS, *TEXTS}
"""Columns of numbers; what users have added may be any text."""


def read_run_table(path: str | Path, filled: Sequence[str] = ()) -> pd.DataFrame:
    """One of the tables of a run, each column of the type it was written with; nan where a cell is empty.

    Args:
        path: of the table.
        filled: columns that must be there, with a number or, in that of words, a word in every row.

    Raises:
        InputError: as in ``read_table``, a column is missing, or a cell is of another type or empty.
    """
    import pandas as pd

    table = read_table(path, most_mb=MOST_MB)
    for name in PLACE:
        if name in filled and name not in table.frame.columns:  # older versions wrote none
            raise InputError(path, name, None, "tables that this version wrote: run the plan again", "is missing")
    table.require(filled)
    columns = {}
    for name in table.frame.columns:
        cells = table.frame[name]
        if name in WORDS:
            table.check(name, cells.isin(WORDS[name]).to_numpy(), ", ".join(WORDS[name]))
            columns[name] = cells.map(WORDS[name])
        elif name == SECTION:
            table.check(name, cells.notna().to_numpy() | (name not in filled), "the name or number of a section")
            columns[name] = cells.map(as_named)
        elif name in NUMBERS:
            table.numbers(name, may_be_empty=name not in filled)
            columns[name] = pd.to_numeric(table.with_points(name))
        else:
            columns[name] = cells.where(cells.notna(), np.nan)
    return pd.DataFrame(columns, table.frame.index)


def solved_cases(results: pd.DataFrame, source: str | Path, filled: Sequence[str]) -> pd.DataFrame:
    """The rows of ``results.csv`` of cases that converged.

    Args:
        results: the whole table.
        source: where it is from, for messages.
        filled: columns that must be there, with a number for every case that converged.

    Raises:
        InputError: a column is missing, no case converged, or one of those that did has no number.
    """
    InputTable(str(source), results).require((*filled, "converged"))
    solved = results[results["converged"] == True]  # noqa: E712 the column may hold texts
    if solved.empty:
        raise InputError(source, "converged", None, "at least one solved case in results.csv", "is nowhere true")
    table = InputTable(str(source), solved)
    for column in filled:
        table.numbers(column)
    return solved
